"""Long work in a thread of its own, with a progress bar and Ctrl-C."""

from __future__ import annotations

import _thread
import atexit
import contextlib
import math
import multiprocessing
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..errors import Interrupted
from .extras import missing
from .warn import warn

__all__ = ["progress_bar", "quiet", "stops", "time_limit", "watched"]

Result = TypeVar("Result")

_PATIENCE = 1.0  # s of silence before the bar appears
_SILENCE = 10.0  # s of silence where there is no terminal
_BETWEEN = 60.0  # s between two lines there
_TICK = 0.05  # s between looks at the progress

#: Signals whose handler asks work in the main thread to stop without an exception, which Python drops in a finalizer.
stops: list[int] = []

#: Monotonic time at which long work of this thread has to end [s].
_end: ContextVar[float] = ContextVar("end", default=math.inf)


@contextlib.contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Stop long work within this context after so many seconds; `watched` then raises TimeoutError."""
    token = _end.set(time.monotonic() + seconds)
    try:
        yield
    finally:
        _end.reset(token)


def watched(
    work: Callable[[NDArray[np.float64]], Result],
    name: str,
    total: int | None = None,
    unit: str = "points",
    value: str = "Lambda",
    in_parts: bool = True,
) -> Result:
    """Do long work that Ctrl-C can stop.

    Parameters
    ----------
    work : callable
        Called in another thread with the progress: ``progress[0]``, once it is not zero, tells it to stop, in the midst of a
        step; it keeps the number of points done in ``progress[1]`` and Lambda of the latest in ``progress[2]``. ``progress[3]``
        is the length of the latest forecast, whose characters follow as their codes. It must release the global lock.
    name : str
        What the bar is called.
    total : int, optional
        Number of points, where known.
    unit, value : str
        What is counted in place of points, and what the third number is.
    in_parts : bool
        Whether there is anything to be had of work that was stopped; else the first Ctrl-C does not wait for it.

    Raises
    ------
    Interrupted
        On Ctrl-C, once the work has stopped; its ``result`` is what the work returned. On a second Ctrl-C at once, without it.
    TimeoutError
        Once the work has stopped because its `time_limit` is over.
    """
    progress = quiet()
    # Not an Event: a Ctrl-C amid the Python code of its locks makes an error of the other thread.
    busy, ended, over = threading.Lock(), threading.Lock(), False
    busy.acquire()
    ended.acquire()
    result: Result | None = None
    failure: BaseException | None = None

    def run() -> None:
        nonlocal result, failure, over
        try:
            result = work(progress)
        except BaseException as error:  # noqa: BLE001 (the waiting thread raises it again)
            failure = error
        finally:
            over = True
            busy.release()
            ended.release()

    interrupted = late = False
    wanted = True
    bar = None
    told = ""
    begin = time.monotonic()
    try:
        # Not a Thread, whose start waits for it: a Ctrl-C meanwhile would be an interrupt of no work.
        _thread.start_new_thread(run, ())
        while not over:
            try:
                busy.acquire(timeout=_TICK)
                if time.monotonic() > _end.get():
                    late, progress[0] = True, 1.0
                if stops and not interrupted:
                    raise KeyboardInterrupt
                if wanted and bar is None and time.monotonic() - begin > _PATIENCE:
                    bar = progress_bar(name, total, begin, unit)
                    wanted = bar is not None
                if bar is not None:
                    bar.n = int(progress[1])
                    bar.set_postfix_str(f"{value} = {progress[2]:.4g}")
                    told = _tell(bar, progress, told)
            except (KeyboardInterrupt, OSError, ValueError, RuntimeError) as stop:
                if not isinstance(stop, KeyboardInterrupt):
                    wanted, bar = False, None  # standard error is lost, and the bar with it
                    # Ctrl-C amid the locks of the bar makes an error of the lock.
                    if not isinstance(stop.__context__, KeyboardInterrupt):
                        continue
                progress[0] = 1.0
                second, interrupted = interrupted, True
                if second or not in_parts:
                    # The other thread ends by itself, and before the process does: its code must not be unloaded under it.
                    atexit.register(ended.acquire)
                    break
    finally:
        progress[0] = 1.0  # whatever takes this thread out of here, the other one does not go on for nobody
        if bar is not None:
            with contextlib.suppress(OSError, ValueError, RuntimeError):
                bar.close()
    if interrupted:
        message = f"{name} stopped by Ctrl-C"
        if result is not None:
            if progress[1]:
                message += f" at {value} = {progress[2]:.6g}, after {int(progress[1])} {unit}"
            message += "; .result holds what there is"
        raise Interrupted(message, result) from failure
    if late:
        raise TimeoutError(f"{name} stopped by its time limit") from failure
    if failure is not None:
        raise failure
    return cast(Result, result)


def quiet() -> NDArray[np.float64]:
    """The progress of work, as `watched` passes it on; by itself for work that nobody watches."""
    return np.zeros(404)


def _tell(bar: Any, progress: NDArray[np.float64], told: str) -> str:
    """Write the latest forecast above the bar, once; the forecast."""
    forecast = "".join(map(chr, progress[4 : 4 + int(progress[3])].astype(int)))
    if forecast and forecast != told and not bar.disable:
        bar.write(forecast, file=sys.stderr)
    return forecast


class _Lines:
    """In place of a bar where standard error is no terminal, as in the log of a batch: what is expected, then a line a minute."""

    disable = False

    def __init__(self, name: str, begin: float, unit: str) -> None:
        self.n = 0
        self._name, self._begin, self._unit = name, begin, unit
        self._forecast, self._next = "", begin + _SILENCE

    def write(self, forecast: str, file: object) -> None:
        self._forecast = forecast

    def update(self, more: int) -> None:
        self.n += more
        self.set_postfix_str("")

    def set_postfix_str(self, words: str) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        so_far = [f"{self._name}: {self.n} {self._unit}", words, f"after {now - self._begin:.0f} s"]
        print(self._forecast or ", ".join(filter(None, so_far)), file=sys.stderr, flush=True)
        self._forecast, self._next = "", now + _BETWEEN

    def close(self) -> None:
        pass


def progress_bar(name: str, total: int | None, begin: float, unit: str) -> Any:
    """A bar on a terminal or in a notebook, elsewhere lines; None where nobody reads it: without a standard error, in a process of
    a pool, on a terminal without tqdm."""
    if sys.stderr is None or sys.stderr.closed:
        return None
    try:
        from tqdm.auto import tqdm
    except ImportError:
        if sys.stderr.isatty():
            warn(f"no progress bar without {missing('tqdm')}")
            return None
    else:
        bar = tqdm(desc=name, total=total, unit=f" {unit}", disable=None, leave=False)
        bar.start_t = time.time() - (time.monotonic() - begin)
        if not bar.disable:
            return bar
    return None if multiprocessing.parent_process() else _Lines(name, begin, unit)
