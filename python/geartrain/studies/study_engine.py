"""The batches of a study on an executor: no scheduler of our own, but retries, which no executor knows to be harmless."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor, wait
from typing import Any

from ..errors import InputError, SolverError, plain, shown
from .study_worker import BUSY, OVER, STOPS, compute_batch, follow_client

__all__ = ["compute_all", "cores", "executor_of"]

_MOST = 512  # batches handed to an executor at a time: so the client stays small
_POLL = 0.5  # s
_PATIENCE = 2.0  # s between looks at batches that others have claimed
_LOOKS = 5  # such looks before a warning says that it waits
_ATTEMPTS = 5  # of a batch, or of a pool of processes without any progress
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def compute_all(
    folder: str, digest: str, blocks: Sequence[int], executor: Any, workers: int, tell: Callable[[], int], patient: bool = True
) -> None:
    """Have batches computed.

    Parameters
    ----------
    folder, digest : str
        As for `compute_batch`.
    blocks : sequence of int
        Numbers of the batches.
    executor : None or Executor
        As `executor_of` gives it; None: a pool of processes of our own.
    workers : int
        Size of our own pool; 1: in this process.
    tell : callable
        Called now and then to tell progress; gives the number of points that there are.
    patient : bool
        Whether to wait for the batches that other processes have claimed.
    """
    left, looks = list(blocks), 0
    while left:
        if executor is not None:
            try:
                left = _on(executor, folder, digest, left, tell)
            except BrokenExecutor as error:
                raise SolverError(f"the executor is broken: {error}") from None
        elif workers == 1:
            left = _in_this_process(folder, digest, left, tell)
        else:
            left = _in_own_pools(folder, digest, left, workers, tell)
        if not patient:
            return
        if left:
            tell()
            looks += 1
            if looks == _LOOKS:
                words = f"{len(left)} batches are claimed by other processes, as the files in {folder}/claims tell: waiting "
                words += "for them"
                warnings.warn(plain(words), stacklevel=2)
            time.sleep(_PATIENCE)


def _in_this_process(folder: str, digest: str, blocks: Sequence[int], tell: Callable[[], int]) -> list[int]:
    busy = []
    for block in blocks:
        if compute_batch(folder, digest, block) == BUSY:
            busy.append(block)
        tell()
    return busy


def _in_own_pools(folder: str, digest: str, blocks: list[int], workers: int, tell: Callable[[], int]) -> list[int]:
    """A pool that a killed process breaks is followed by another, as long as there is progress."""
    known, idle = tell(), 0
    while True:
        context = multiprocessing.get_context("spawn")  # a fork would inherit threads of OpenMP in the midst of their work
        ours, line = context.Pipe(duplex=False)
        with (
            _one_thread_each(), ours, line,
            _Pool(min(workers, len(blocks)), context, follow_client, (ours,)) as pool,
        ):
            try:
                return _on(pool, folder, digest, blocks, tell)
            except BaseException as error:
                line.close()  # the processes write what they have and end, also where a dead one has left a queue locked
                pool.shutdown(cancel_futures=True)
                if not isinstance(error, BrokenExecutor):
                    raise
                broken = error
        now = tell()
        idle = 0 if now > known else idle + 1
        known = now
        if idle == _ATTEMPTS:
            raise SolverError(
                f"worker processes die without a result ({broken}). A script that runs a study needs the line "
                'if __name__ == "__main__": before the call; else see the messages of the workers'
            )


class _Pool(ProcessPoolExecutor):
    """Starts its processes with signals held back until `follow_client` lets them in: Ctrl-C in a terminal goes to the processes
    that still import too, and each would print where it was."""

    def submit(self, *arguments: Any, **keywords: Any) -> Future[Any]:
        before = signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
        try:
            return super().submit(*arguments, **keywords)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextlib.contextmanager
def _one_thread_each() -> Iterator[None]:
    """Processes started here use a thread each unless the user says otherwise, draw no progress bars, and do not look for modules
    in the working directory first (from Python 3.11 on), which may be a folder from elsewhere."""
    wanted = {**dict.fromkeys(_ONE_THREAD, "1"), "TQDM_DISABLE": "1", "PYTHONSAFEPATH": "1"}
    added = {name: value for name, value in wanted.items() if name not in os.environ}
    os.environ.update(added)
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)


def executor_of(executor: Any) -> Any:
    """Something with ``submit`` that gives futures of ``concurrent.futures``, of an executor or a client of Dask; None of None."""
    if executor is None:
        return None
    if hasattr(executor, "get_executor"):  # a client of Dask; points are pure, but a lost one must not be taken from its memory
        return executor.get_executor(pure=False, retries=0)
    if isinstance(executor, Executor) or hasattr(executor, "submit"):
        return executor
    wanted = "None, an Executor of concurrent.futures or a Client of dask.distributed"
    raise InputError(f"executor = {shown(executor)}: must be {wanted}")


def _on(executor: Any, folder: str, digest: str, blocks: Sequence[int], tell: Callable[[], int]) -> list[int]:
    """Those that others have claimed."""
    waiting, busy = list(reversed(blocks)), []
    attempts = dict.fromkeys(blocks, 0)
    running: dict[Future[str], int] = {}
    try:
        while waiting or running:
            while waiting and len(running) < _MOST:
                block = waiting.pop()
                running[executor.submit(compute_batch, folder, digest, block)] = block
            with _signals_later():
                done, _ = wait(running, _POLL, FIRST_COMPLETED)
                for future in done:
                    block = running.pop(future)
                    again = _outcome(future, block, attempts)
                    if again == BUSY:
                        busy.append(block)
                    elif again:
                        waiting.append(block)
            tell()
    finally:
        with _signals_later():
            for future in running:
                future.cancel()
    return busy


@contextlib.contextmanager
def _signals_later() -> Iterator[None]:
    """Signals are handled at the end: an exception of a handler amid the locks of futures would leave some locked, and the thread
    that completes the futures would wait for them without end."""
    handlers = {number: signal.getsignal(number) for number in STOPS}
    if threading.current_thread() is not threading.main_thread() or None in handlers.values():  # where C handles them
        yield
        return
    came: list[int] = []
    try:
        for number in handlers:
            signal.signal(number, lambda number, _: came.append(number))
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for late in dict.fromkeys(came):
            signal.raise_signal(late)


def _outcome(future: Future[str], block: int, attempts: dict[int, int]) -> str:
    """Nothing where the batch is over; ``BUSY``; or another word where it is to be computed again."""
    error = None if future.cancelled() else future.exception()
    if future.cancelled() or isinstance(error, CancelledError):
        raise SolverError("the executor has given up the work: its scheduler or its workers are gone")
    if isinstance(error, (BrokenExecutor, OSError)):
        raise error
    if error is None:
        status = future.result()
        return "" if status == OVER else status
    attempts[block] += 1  # as Dask tells of a worker that was killed
    if attempts[block] == _ATTEMPTS:
        raise SolverError(f"batch {block} failed {_ATTEMPTS} times, at last with {type(error).__name__}: {error}") from error
    return "failed"
