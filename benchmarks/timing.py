"""Wall times of calls and of whole processes, memory of processes."""

import os
import statistics
import subprocess
import sys
import time
from contextlib import contextmanager


@contextmanager
def one_core():
    """This process and those it starts keep to one core, so that no tool gets more of the machine than another."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(allowed)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)


def timed(call, repeats, patience=1.0):
    """Seconds of each repeat, fewer where they take longer than `patience` together, and the last result.

    The first call warms up and does not count, unless it alone uses up the patience.
    """
    begun = time.perf_counter()
    result = call()
    first = time.perf_counter() - begun
    seconds = []
    while first + sum(seconds) < patience and len(seconds) < repeats:
        begun = time.perf_counter()
        result = call()
        seconds.append(time.perf_counter() - begun)
    return seconds or [first], result


def run(command, allowed=(0,), **options):
    """Wall seconds of a process; RuntimeError with the last line it said where its exit status is none of those allowed."""
    begun = time.perf_counter()
    done = subprocess.run(
        [str(part) for part in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, errors="replace", check=False, **options,
    )  # fmt: skip
    seconds = time.perf_counter() - begun
    if done.returncode not in allowed:
        raise RuntimeError((done.stdout.strip().splitlines() or [f"exit status {done.returncode}"])[-1])
    return seconds


# Started from a small process of its own: a child's peak begins with that of the process it is started from.
_PEAK = """
import os, sys
_, _, usage = os.wait4(os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ), 0)
sys.stderr.write(str(usage.ru_maxrss))
"""


def peak_memory(command):
    """Peak resident memory of a process [bytes], at least the 10 MB or so of the Python that starts it."""
    done = subprocess.run(
        [sys.executable, "-S", "-E", "-c", _PEAK, *(str(part) for part in command)],
        stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True,
    )  # fmt: skip
    return int(done.stderr.split()[-1]) * 1024


def spread(seconds, digits=3):
    """Minimum, median and maximum as text, with the unit that suits them."""
    low, middle, high = min(seconds), statistics.median(seconds), max(seconds)
    unit, scale = ("s", 1) if middle >= 1 else ("ms", 1e3) if middle >= 1e-3 else ("us", 1e6)
    if len(seconds) == 1:
        return f"{middle * scale:.{digits}g} {unit}"
    return f"{middle * scale:.{digits}g} {unit} ({low * scale:.{digits}g} to {high * scale:.{digits}g})"
