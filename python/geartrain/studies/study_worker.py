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
from typing import Any

from ..errors import DrawingWarning
from .study_plan import Plan
from .study_store import DONE, FAILED, SET_ASIDE, Record, Store

__all__ = ["BUSY", "OVER", "STOPPED", "STOPS", "compute_alone", "compute_batch", "follow_client", "record_of"]

#: What became of a batch: all its points are in the folder; a living process computes it; told to stop before its end.
OVER, BUSY, STOPPED = "over", "busy", "stopped"
#: Signals that ask for an end.
STOPS = (signal.SIGINT, signal.SIGTERM)

_stopping = threading.Event()
_interrupted = threading.Event()  # within `_stoppable`
_computing = threading.Event()  # within `_interruptible`
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
    with _stoppable():
        try:
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
        if _interrupted.is_set():  # in the midst of a lock, say, which makes another error of it
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
            _, said = child.communicate()
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


@contextlib.contextmanager
def _stoppable() -> Iterator[None]:
    """In the main thread of a child process one interrupt or termination ends the batch, amid the computing of a point and nowhere
    else: no claim is left behind, and what is written is written to its end."""
    if multiprocessing.parent_process() is None or threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: Any) -> None:
        _interrupted.set()
        if _computing.is_set():
            _computing.clear()
            raise KeyboardInterrupt

    _interrupted.clear()
    before = {number: signal.getsignal(number) for number in STOPS}
    try:
        for number in before:
            signal.signal(number, stop)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def _interruptible() -> Iterator[None]:
    """Where a batch that is told to stop does so."""
    try:
        _computing.set()
        if _interrupted.is_set():
            raise KeyboardInterrupt
        yield
    finally:
        _computing.clear()


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
