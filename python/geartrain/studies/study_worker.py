"""A batch of a study, computed by whichever process is asked to: `compute_batch` is what every executor runs."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from collections.abc import Iterator
from functools import lru_cache
from multiprocessing.connection import Connection
from types import SimpleNamespace
from typing import Any

from .._core.watch import stops
from ..errors import DrawingWarning
from .study_plan import Plan
from .study_store import DONE, FAILED, SET_ASIDE, Record, Store

__all__ = ["BUSY", "OVER", "STOPPED", "STOPS", "compute_alone", "compute_batch", "follow_client", "record_of"]

#: What became of a batch: all its points are in the folder; a living process computes it; told to stop before its end.
OVER, BUSY, STOPPED = "over", "busy", "stopped"
#: Signals that ask for an end; the last at a time limit of a cluster.
STOPS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGXCPU") if hasattr(signal, name))

_stopping = threading.Event()
_batch = SimpleNamespace(computing=False)  # within `_interruptible`; handlers of signals must not meet a lock
_TICK = 0.1  # s between looks at a process that computes a point
_ANSWER = 0.2  # s for the answer of a process that is to end
_LONGEST = 10.0  # s after which the points so far are written: so much a kill may lose


def compute_batch(folder: str, digest: str, block: int) -> str:
    """Compute the points of a batch that are not yet in the folder, and write them there.

    Parameters
    ----------
    folder : str
    digest : str
        Of the plan.
    block : int
        Number of the batch.
    """
    if _stopping.is_set():
        return STOPPED
    store, plan = _opened(folder, digest)
    name = f"{digest}-{block:06d}"
    there = store.statuses(name)
    keys = {key: point for point in plan.block(block) if (key := plan.key(point)) not in there}
    if not keys:
        return OVER
    try:
        with _stoppable():
            return _compute(store, plan, name, keys)
    except KeyboardInterrupt:
        if multiprocessing.parent_process() is None:
            raise
        return STOPPED


def _compute(store: Store, plan: Plan, name: str, keys: dict[bytes, int]) -> str:
    """Compute points, unless a living process has claimed them."""
    with store.claim(name) as claim:
        if claim is None:
            return BUSY
        records: list[Record] = []
        written = time.monotonic()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", DrawingWarning)
                there = store.statuses(name)  # another process may have been faster
                for key in [key for key in keys if key not in there]:
                    alone = store.is_suspect(key)
                    claim.at(b"" if alone else key)
                    with _interruptible():
                        records += _alone(store, plan, keys[key]) if alone else [record_of(plan, keys[key])]
                    if time.monotonic() - written > _LONGEST and records:
                        store.write(name, records)
                        records, written = [], time.monotonic()
        finally:
            claim.at(b"")
            if records:
                store.write(name, records)
    return OVER


def record_of(plan: Plan, point: int) -> Record:
    """What becomes of a point; an error of the call is a failure of the point."""
    begun = time.perf_counter()
    status, message, kept = DONE, "", {}
    try:
        kept = plan.compute(point)
    except Exception as error:  # noqa: BLE001 (a failed point is a result)
        if stops:  # in the midst of a lock, say, which makes another error of it
            raise KeyboardInterrupt from None
        status, message = FAILED, f"{type(error).__name__}: {error}"
    return Record(plan.key(point), status, message, time.perf_counter() - begun, kept)


@lru_cache(maxsize=2)
def _opened(folder: str, digest: str) -> tuple[Store, Plan]:
    store = Store(folder)
    store.statuses()
    return store, store.plan(digest)


def compute_alone(folder: str, digest: str, point: str) -> None:
    """Compute one point, in a process that it may kill."""
    store, plan = _opened(folder, digest)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DrawingWarning)
        store.write(f"{digest}-alone", [record_of(plan, int(point))])


def _alone(store: Store, plan: Plan, point: int) -> list[Record]:
    """Compute a suspect in a process of its own, which writes what it finds; the record of its death where it dies."""
    key, begun = plan.key(point), time.perf_counter()
    # Python looks in the working directory first: it may hold anything.
    code = (
        "import sys; sys.path[:] = filter(None, sys.path); "
        "from geartrain.studies.study_worker import compute_alone; compute_alone(*sys.argv[1:])"
    )
    command = [sys.executable, "-c", code, str(store.folder), plan.digest, str(point)]
    paths = [os.environ.get("PYTHONPATH", ""), *filter(None, sys.path)]  # the user's first, as Python has them
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    with subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as child:
        try:
            said = _said_by(child)
        except BaseException:
            child.kill()
            raise
    if child.returncode == 0:
        store.clear(key)
        return []
    if child.returncode < 0:
        why = f"killed its process twice, the second time by signal {-child.returncode} ({signal.strsignal(-child.returncode)})"
    else:
        why = f"ended its process with status {child.returncode}: {said.strip().splitlines()[-1] if said.strip() else ''}"
    return [Record(key, SET_ASIDE, why, time.perf_counter() - begun, {})]


def _said_by(child: subprocess.Popen[str]) -> str:
    """What a process says before its end; an interrupt where this one is to stop, as Ctrl-C may have ended that one too."""
    said = None
    while said is None:
        with contextlib.suppress(subprocess.TimeoutExpired):
            _, said = child.communicate(timeout=_TICK)
        if stops:
            raise KeyboardInterrupt
    return said


@contextlib.contextmanager
def _stoppable() -> Iterator[None]:
    """In the main thread one interrupt or termination ends the batch, amid the computing of a point and nowhere else: no claim is
    left behind, and what is written is written to its end. A second one raises, as for keeps of the user's own that take long.
    Handlers of the user's own stay."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handlers = {number: signal.getsignal(number) for number in STOPS}
    ours = multiprocessing.parent_process() is not None
    before = {number: handler for number, handler in handlers.items() if ours or handler is signal.default_int_handler}

    def stop(number: int, _: Any) -> None:
        stops.append(number)
        if len(stops) > 1 and _batch.computing:
            _batch.computing = False
            raise KeyboardInterrupt

    stops.clear()
    try:
        for number in before:
            signal.signal(number, stop)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        late = len(stops) > 0
        if signal.SIGTERM in stops and before[signal.SIGTERM] is signal.SIG_DFL:
            # Whoever ends the process waits for that: it goes when its answer is on the way.
            end = threading.Timer(_ANSWER, os.kill, (os.getpid(), signal.SIGTERM))
            end.daemon = True
            end.start()
        stops.clear()
    if late:
        raise KeyboardInterrupt


@contextlib.contextmanager
def _interruptible() -> Iterator[None]:
    """Where a batch that is told to stop does so."""
    try:
        _batch.computing = True
        if stops:
            raise KeyboardInterrupt
        yield
        if stops:
            raise KeyboardInterrupt
    finally:
        _batch.computing = False


def follow_client(line: Connection) -> None:
    """For processes of our own pool: quiet on Ctrl-C between batches, and ended when the client closes the line or is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, STOPS)

    def wait() -> None:
        with contextlib.suppress(OSError):
            line.poll(None)
        _stopping.set()
        while True:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(1)

    threading.Thread(target=wait, name="geartrain client", daemon=True).start()
