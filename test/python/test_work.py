"""Long work: Ctrl-C, threads, the global lock, and what is left behind."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import paper_train

import geartrain as gt
from geartrain._core import box as _box
from geartrain._core import watch as _watch

INTERRUPTED = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job of a shell is born deaf to it
sys.path.insert(0, {folder!r})
from conftest import paper_train
import geartrain as gt
train = paper_train()
print("ready", flush=True)
try:
    train.{call}
except gt.Interrupted as stop:
    result = stop.result
    print(len(result), str(stop))
    print(result.ended)
print(len(train.natural_frequencies()), "alive")
"""


@pytest.mark.parametrize("call", [
    "response(start=0.2, stop=2.6, step=1e-5, max_points=10**6)",
    "sweep(start=0.2, stop=2.6, points=20000)",
])
def test_interrupt_leaves_interpreter_and_results_alive(call, request):
    code = INTERRUPTED.format(folder=str(request.path.parent), call=call)
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    output, errors = child.communicate(timeout=120)
    assert child.returncode == 0, errors
    first, ended, last = output.splitlines()
    assert int(first.split()[0]) > 10 and "stopped by Ctrl-C at Lambda = " in first
    assert ended and last == "5 alive"
    assert errors == ""  # no progress bar where there is no terminal


@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminal")
def test_bar_appears_on_a_terminal(request):
    import fcntl
    import pty
    import struct
    import termios

    try:
        ours, theirs = pty.openpty()
    except OSError:
        pytest.skip("this system gives no pseudo-terminal")
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
    code = INTERRUPTED.format(folder=str(request.path.parent), call="sweep(start=0.2, stop=2.6, points=20000)")
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.DEVNULL, stderr=theirs)
    os.close(theirs)
    shown = b""
    while b"Lambda = " not in shown:
        shown += os.read(ours, 1000)
    child.send_signal(signal.SIGINT)
    assert child.wait(timeout=120) == 0
    os.close(ours)
    assert b"integration:" in shown and b"/20000" in shown


def test_interrupted_is_a_keyboard_interrupt():
    assert issubclass(gt.Interrupted, KeyboardInterrupt)


def test_threads_give_equal_bits(train, branch):
    with ThreadPoolExecutor(4) as pool:
        jobs = [pool.submit(train.response, start=0.2, stop=2.6) for _ in range(6)]
        for job in jobs:
            np.testing.assert_array_equal(job.result().coefficients, branch.coefficients)
            np.testing.assert_array_equal(job.result().multipliers, branch.multipliers)


def test_threads_give_equal_words(train):
    # Of different lengths: text that one thread makes is not cut as another's.
    def words(number):
        number %= 6
        try:
            return train.response(start=0.9, stop=(1.0, 1.02345, 1.023456)[number % 3], stability=False, harmonics=1,
                                  max_points=2 + number, period_doublings=-1 if number == 5 else 0).ended
        except gt.InputError as error:
            return str(error)

    alone = [words(number) for number in range(6)]
    assert len(set(map(len, alone))) > 2
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(words, range(300)))
    assert together == alone * 50


def test_global_lock_is_free_meanwhile(train):
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.wait(0.002):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    text = train.namelist(response={"start": 0.2, "stop": 2.6, "harmonics": 12})
    with _box.Box(text) as box:
        progress = _watch.quiet()
        thread.start()
        begin = time.perf_counter()
        box.run("response", progress)
        end = time.perf_counter()
    stop.set()
    thread.join()
    assert progress[1] > 100
    assert sum(begin < instant < end for instant in ticks) > (end - begin) / 0.04


def test_quick_work_does_not_wait(train, monkeypatch):
    # The waiting thread wakes up when the work is done, however long it would wait to look at the progress.
    monkeypatch.setattr(_watch, "_TICK", 60.0)
    begin = time.monotonic()
    train.response(start=0.9, stop=0.91, stability=False)
    assert time.monotonic() - begin < 30


@pytest.mark.parametrize("forecast", ["", "work: about 3 min expected"])
def test_lines_where_there_is_no_terminal(forecast, monkeypatch, capsys):
    """In the log of a batch: nothing of short work, then what is expected, and how far it is."""

    def work(progress):
        progress[4 : 4 + len(forecast)] = list(map(ord, forecast))
        progress[1:4] = 7, 0.5, len(forecast)
        time.sleep(0.5)

    monkeypatch.setattr(_watch, "_PATIENCE", 0.0)
    _watch.watched(work, "work")
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(_watch, "_SILENCE", 0.1)
    monkeypatch.setattr(_watch, "_BETWEEN", 0.2)
    _watch.watched(work, "work")
    first, second, *_ = capsys.readouterr().err.splitlines()
    assert first == (forecast or "work: 7 points, Lambda = 0.5, after 0 s")
    assert second == "work: 7 points, Lambda = 0.5, after 0 s"


def test_every_box_is_closed(train, monkeypatch):
    gc.collect()  # boxes of tests before
    open_boxes = set()

    class Counted:
        def __getattr__(self, name):
            return getattr(_fortran, name)

        def open_box(self):
            handle = _fortran.open_box()
            open_boxes.add(handle)
            return handle

        def open_copy(self, other):
            handle = _fortran.open_copy(other)
            open_boxes.add(handle)
            return handle

        def close_box(self, handle):
            open_boxes.remove(handle)
            _fortran.close_box(handle)

    _fortran = _box.fortran
    monkeypatch.setattr(_box, "fortran", Counted())
    opened = []
    train.response(start=0.9, stop=1.0).at(0.95)[0].refine()
    opened.append(paper_train().integrate(0.9))
    with pytest.raises(gt.InputError):
        paper_train(characteristic_length=-1.0)
    with pytest.raises(gt.InputError):
        train.integrate(-1.0)
    # A train keeps a box, and motions and branches their train.
    assert opened and open_boxes
    opened.clear()
    assert not open_boxes
