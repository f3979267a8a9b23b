"""The folder of a study: plans, batches of records, claims of who computes what, suspects. Batches alone are the truth.

A batch file is written beside and renamed, has a name of its own and is never written again, so that any number of processes on
any machines may write at once. A claim is a file that its owner touches; the claim of an owner that died is anyone's.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import signal
import socket
import stat
import threading
import uuid
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._core.sealed import DamagedError, distrust, seal, unseal
from ..errors import plain
from .quantity import Quantity
from .study_plan import Plan, is_key

__all__ = ["DONE", "FAILED", "SET_ASIDE", "Batch", "Claim", "Record", "Store"]

#: Statuses of a point: computed; the call raised an error; it killed the process that computed it.
DONE, FAILED, SET_ASIDE = "done", "failed", "set aside"

_HEARTBEAT = 15.0  # s between touches of a claim
_STALE = 180.0  # s without a touch after which its owner counts as dead: longer than network file systems keep a file's time back
_LEFT = 3600.0  # s after which a file that was not renamed is a killed writer's
_DAMAGED = (DamagedError, OSError)


class Record(NamedTuple):
    """What became of a point."""

    key: bytes
    status: str
    message: str
    seconds: float
    kept: Mapping[str, Quantity]


class Batch(NamedTuple):
    """Records as a file has them: arrays with a row for each, padded to the longest."""

    keys: NDArray[np.bytes_]
    status: NDArray[np.str_]
    message: NDArray[np.str_]
    seconds: NDArray[np.float64]
    kept: Mapping[str, Quantity]


class Store:
    """The folder of a study.

    Parameters
    ----------
    folder : path-like
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder).absolute()
        self.plans, self.batches, self.claims, self.suspects, self.branches = (
            self.folder / name for name in ("plans", "batches", "claims", "suspects", "branches")
        )
        self._lock = threading.Lock()
        self._seen: dict[str, int] = {}
        self._known: dict[bytes, str] = {}

    def make(self) -> None:
        """Make what is not there, and remove what killed writers have left."""
        for path in (self.plans, self.batches, self.claims, self.suspects, self.branches):
            path.mkdir(parents=True, exist_ok=True)
        now = self._now()
        for path in self.folder.glob("*/*.tmp"):
            with contextlib.suppress(OSError):
                # Claims are moved aside for moments only, without a lock.
                is_old = now - path.stat().st_mtime > _LEFT
                if is_old or (path.parent != self.claims and _has_no_writer(path)):
                    path.unlink()

    def _now(self) -> float:
        """The time of the file system, which may be another machine's."""
        path = self.claims / f"{uuid.uuid4().hex}.tmp"
        path.touch()
        now = path.stat().st_mtime
        path.unlink()
        return now

    def _put(self, path: Path, text: bytes, anew: bool = True) -> None:
        """Write a file beside and rename it; leave one that is there alone where it is not to be written ``anew``.

        The file beside has a lock until it has its name: by that another process knows that its writer lives.
        """
        while True:
            beside = path.with_name(f"{uuid.uuid4().hex}.tmp")
            try:
                with beside.open("xb") as file:
                    with contextlib.suppress(OSError):  # a file system without locks
                        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    file.write(text)
                    file.flush()
                    os.fsync(file.fileno())
                    if not anew:
                        with contextlib.suppress(OSError):  # a file system without links
                            os.link(beside, path)
                        if path.exists():
                            return
                    os.replace(beside, path)
                    return
            except FileNotFoundError:
                # Removed between its making and its lock, or the folder is gone.
                if not path.parent.exists():
                    raise
            finally:
                with contextlib.suppress(OSError):
                    beside.unlink()

    # ------------------------------------------------------------------------------------------------ plans

    def put_plan(self, plan: Plan) -> Plan:
        """Make a plan the folder's latest; gives it in the batches in which it has been begun."""
        path = self.plans / f"{plan.digest}.npz"
        try:
            known = self.plan(plan.digest)
        except OSError:  # not there, or damaged
            self._put(path, plan.dump(), anew=path.exists())
            known = self.plan(plan.digest)
        os.utime(path)
        return known

    def plan(self, digest: str = "") -> Plan:
        """A plan of the folder, the latest unless told."""
        known = [self.plans / f"{digest}.npz"] if digest else self.plans.glob("*.npz")
        paths = [*known] if digest else sorted(known, key=lambda path: path.stat().st_mtime)
        if not paths:
            raise FileNotFoundError(plain(f"{self.folder}: holds no study"))
        try:
            return Plan.load(_content(paths[-1]))
        except FileNotFoundError:
            raise
        except _DAMAGED as error:
            words = f"{paths[-1]}: is damaged ({error}): run the study again from Python, which writes it anew"
            raise OSError(plain(words)) from None

    # ---------------------------------------------------------------------------------------------- batches

    def write(self, name: str, records: Sequence[Record]) -> None:
        """Write records as a batch file whose name begins with ``name``."""
        kept = {key: quantity for record in records for key, quantity in record.kept.items()}
        about = {key: quantity[1:] for key, quantity in kept.items()}
        arrays = {f"kept {key}": _stacked([record.kept.get(key) for record in records]) for key in kept}
        file = self.batches / f"{name}-{uuid.uuid4().hex[:12]}.npz"
        self._save(
            file, about, np.array([record.key for record in records], "S32"), np.array([record.status for record in records]),
            np.array([record.message for record in records]), np.array([record.seconds for record in records]), arrays,
        )

    def _save(
        self, path: Path, about: Mapping[str, Any], keys: NDArray[Any], status: NDArray[Any], message: NDArray[Any],
        seconds: NDArray[Any], arrays: Mapping[str, Any],
    ) -> None:
        columns = {"keys": keys, "status": status, "message": message, "seconds": seconds}
        self._put(path, seal({"about": np.array(json.dumps(about)), **columns, **arrays}))

    def paths(self, prefix: str = "") -> list[Path]:
        """The batch files, by name."""
        try:
            names = sorted(os.listdir(self.batches))
        except FileNotFoundError:
            raise FileNotFoundError(plain(f"{self.folder}: is no folder of a study, or has vanished")) from None
        return [self.batches / name for name in names if name.endswith(".npz") and name.startswith(prefix)]

    def read(self, path: Path) -> Batch | None:
        """A batch; None, with a warning, of a damaged file."""
        try:
            return _batch(_content(path))
        except _DAMAGED as error:
            if path.exists():
                words = plain(f"{path}: is damaged ({error}): its points count as not computed")
                warnings.warn(words, stacklevel=2)
            return None

    def messages(self, keys: Collection[bytes]) -> dict[bytes, str]:
        """Why points failed, by their keys."""
        found: dict[bytes, str] = {}
        for path in self.paths():
            with contextlib.suppress(*_DAMAGED):
                batch = _batch(_content(path))
                if (batch.status != DONE).any():
                    rows = zip(batch.keys.tolist(), batch.status.tolist(), batch.message.tolist())
                    found |= {key: message for key, status, message in rows if key in keys and status != DONE}
        return {key: plain(message, lines=True) for key, message in found.items()}

    def mend(self) -> None:
        """Read every batch; a damaged one is renamed, and with that its points are to be computed again."""
        for path in self.paths():
            if self.read(path) is None and path.exists():
                path.rename(path.with_suffix(".damaged"))

    def statuses(self, prefix: str = "") -> Mapping[bytes, str]:
        """Keys with their statuses, after a look at the batch files whose names begin with ``prefix``; each is read once."""
        with self._lock:
            return self._look(prefix)

    def _look(self, prefix: str = "") -> Mapping[bytes, str]:
        paths = self.paths()
        anew = not self._seen.keys() <= {path.name for path in paths}  # the folder, or a batch, was removed
        for path in paths:
            if not path.name.startswith(prefix):
                continue
            with contextlib.suppress(*_DAMAGED):
                written = path.stat().st_mtime_ns
                if self._seen.get(path.name) == written:
                    continue
                anew = anew or path.name in self._seen  # points were taken out of it
                batch = _batch(_content(path))
                self._seen[path.name] = written
                for key, status in zip(batch.keys.tolist(), batch.status.tolist()):
                    if self._known.get(key) != DONE:
                        self._known[key] = status
        if anew:
            self._seen, self._known = {}, {}
            return self._look()
        return self._known

    def forget(self, keys: Collection[bytes]) -> None:
        """Take failed points out of the batches, so that they are computed again."""
        wanted = {*keys}
        for path in self.paths():
            batch = self.read(path)
            if batch is None:
                continue
            stay = np.array([key not in wanted or status == DONE for key, status in zip(batch.keys.tolist(), batch.status)])
            if not stay.all():
                about = {name: quantity[1:] for name, quantity in batch.kept.items()}
                arrays = {f"kept {name}": quantity.values[stay] for name, quantity in batch.kept.items()}
                self._save(path, about, batch.keys[stay], batch.status[stay], batch.message[stay], batch.seconds[stay], arrays)
        for key in wanted:
            self.clear(key)

    # ----------------------------------------------------------------------------------- claims and suspects

    def is_suspect(self, key: bytes) -> bool:
        """Whether a process died while it computed the point."""
        return (self.suspects / key.decode()).exists()

    def clear(self, key: bytes) -> None:
        """A point is no suspect any more."""
        (self.suspects / key.decode()).unlink(missing_ok=True)

    @contextlib.contextmanager
    def claim(self, name: str) -> Iterator[Claim | None]:
        """Claim a batch for as long as the context lasts; None where a living process has claimed it."""
        path, claimed = self.claims / name, None
        try:
            with _uninterrupted():  # a claim half made would be nobody's
                claimed = Claim.make(path) or (Claim.make(path) if self._bury(path) else None)
            if claimed is None:
                yield None
                return
            with claimed:
                yield claimed
        finally:
            if claimed is not None:
                with contextlib.suppress(OSError):
                    path.unlink()

    def _bury(self, path: Path) -> bool:
        """Remove the claim of a dead process; the point that it was at is a suspect."""
        try:
            text, touched = _content(path), path.stat().st_mtime
        except FileNotFoundError:
            return True
        if not _is_dead(text) and abs(self._now() - touched) < _STALE:
            return False
        aside = path.with_name(f"{uuid.uuid4().hex}.tmp")
        try:
            os.rename(path, aside)
        except FileNotFoundError:
            return True
        if aside.read_bytes()[:_OWNER] != text[:_OWNER]:  # another process was faster, and this is its claim
            with contextlib.suppress(OSError):
                os.link(aside, path)
            aside.unlink()
            return False
        key = aside.read_bytes()[_OWNER:].strip()
        if is_key(key):
            (self.suspects / key.decode()).touch()
        aside.unlink()
        return True


@contextlib.contextmanager
def _uninterrupted() -> Iterator[None]:
    """In the main thread signals that ask for an end wait until the context is left."""
    came: list[int] = []
    before = {}
    if threading.current_thread() is threading.main_thread():
        before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        for number, handler in before.items():
            if callable(handler):
                signal.signal(number, lambda number, _: came.append(number))
        yield
    finally:
        for number, handler in before.items():
            if callable(handler):
                signal.signal(number, handler)
        for signum in came:
            signal.raise_signal(signum)


def _content(path: Path) -> bytes:
    """The bytes of a file. A pipe would keep the reader waiting, and a link to a device has no end."""
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise OSError(errno.EINVAL, "is no ordinary file", str(path))
        return file.read()


def _has_no_writer(path: Path) -> bool:
    """Whether a temporary file has no lock: its writer was killed."""
    with path.open("r+b") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
    return True


_OWNER = 160  # characters of a claim that say whose it is; after them stands the key of the point that is computed


def _is_dead(text: bytes) -> bool:
    """Whether the owner of a claim was a process of this machine that is no more."""
    try:
        owner = json.loads(text[:_OWNER])
        host, process = owner["host"], owner["process"]
    except (ValueError, TypeError, KeyError):  # not yet written, or no claim: it is removed when nobody has touched it for long
        return False
    if host != _host() or not isinstance(process, int):
        return False
    with contextlib.suppress(OSError, IndexError):  # killed, but its parent has not yet asked for its status
        if Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] == "Z":
            return True
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        return False
    return False


def _host() -> str:
    return socket.gethostname()[:60]


class Claim:
    """A batch that this process computes: a file that a thread touches."""

    def __init__(self, path: Path, descriptor: int) -> None:
        self._path, self._descriptor = path, descriptor
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._beat, name="geartrain claim", daemon=True)

    @classmethod
    def make(cls, path: Path) -> Claim | None:
        """A claim; None where there is a claim of another."""
        try:
            descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        except FileExistsError:
            return None
        owner = {"host": _host(), "process": os.getpid(), "id": uuid.uuid4().hex}
        os.write(descriptor, json.dumps(owner).ljust(_OWNER).encode())
        return cls(path, descriptor)

    def at(self, key: bytes) -> None:
        """Tell which point is computed: the suspect, should the process die."""
        os.pwrite(self._descriptor, key.ljust(32), _OWNER)

    def _beat(self) -> None:
        while not self._ended.wait(_HEARTBEAT):
            with contextlib.suppress(OSError):  # taken by another, or gone with the folder: the batch is written all the same
                os.utime(self._path)

    def __enter__(self) -> Claim:  # noqa: PYI034 (typing.Self needs Python 3.11)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        os.close(self._descriptor)


def _batch(text: bytes) -> Batch:
    """Read a batch from the bytes of its file; `DamagedError` where they hold none."""
    arrays = unseal(text)
    with distrust():
        about = json.loads(arrays["about"].item())
        kept = {name: Quantity(arrays[f"kept {name}"], tuple(row[0]), *row[1:]) for name, row in about.items()}
        batch = Batch(arrays["keys"], arrays["status"], arrays["message"], arrays["seconds"], kept)
        columns = [batch.status, batch.message, batch.seconds, *(quantity.values for quantity in kept.values())]
        if any(len(column) != len(batch.keys) for column in columns):
            raise DamagedError("the lists differ in length")
    return batch


def _stacked(rows: Sequence[Quantity | None]) -> NDArray[Any]:
    """Arrays with a row for each, filled up with NaN, -1, False or nothing where one is shorter than another or not there."""
    known = [np.asarray(row.values) for row in rows if row is not None]
    texts = [values.astype(str) if values.dtype.kind == "O" else values for values in known]
    full = [values for values in texts if values.size] or texts
    shape = tuple(map(max, zip(*(values.shape for values in texts))))
    kind = np.result_type(*full)
    table = np.full((len(rows), *shape), fill_of(kind), kind)
    for place, row in enumerate(rows):
        if row is not None:
            values = np.asarray(row.values)
            if values.size:
                table[place, ...][tuple(slice(length) for length in values.shape)] = values
    return table


def fill_of(kind: np.dtype[Any]) -> Any:
    """What stands where there is no value."""
    return {"f": np.nan, "c": complex(np.nan, np.nan), "i": -1, "U": ""}.get(kind.kind, False)
