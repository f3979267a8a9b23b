"""Ctrl-C: obeyed within a second whatever the size of the work, a second one at once; in the executable as well."""

import signal
import subprocess
import sys
import threading
import time

import h5py
import pytest
from conftest import write_case

import geartrain as gt
from geartrain._core import watch as _watch
from geartrain._core.watch import watched

pytestmark = pytest.mark.full

#: What may lie between Ctrl-C and the end of the work [s].
PATIENCE = 1.0

#: Lines of a program that sends itself Ctrl-C, after seconds of its own processor time, so that it comes in the same place
#: beside other work.
INTERRUPT = """
sent = []
begun = time.process_time()
def interrupt():
    while time.process_time() - begun < {wait}:
        time.sleep(0.01)
    sent.append(time.monotonic())
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt, daemon=True).start()
"""

CHILD = """
import os, signal, sys, threading, time
import geartrain as gt
import tqdm.auto  # which a call imports: an interrupt within that is Python's own
signal.signal(signal.SIGINT, signal.default_int_handler)
train = gt.Train(
    input_torque=150.0, prime_mover_inertia=2.3e-7, load_inertia=2.3e-7,
    characteristic_length=30e-6, characteristic_frequency=9870.0,
    shafts=[gt.Shaft(stiffness=1e6, damping_ratio=0.01) for _ in range({meshes} + 1)],
    meshes=[gt.Mesh(driving_radius=0.05, driven_radius=0.05, driving_inertia=0.0023, driven_inertia=0.0023, damping_ratio=0.05,
                    stiffness=2.5e8 * (1 + 0.01 * i), half_backlash=30e-6, stiffness_cos=[0.3]) for i in range({meshes})])
""" + INTERRUPT + """\
try:
    train.{call}
except gt.Interrupted as stop:
    print(time.monotonic() - sent[0], type(stop.result).__name__, stop)
"""
MAP = "stability_map(start=0.2, stop=2.6, parameter_start=0.01, parameter_stop=0.1, {})"
HUGE = "points=10000, parameter_points=10000"


@pytest.mark.parametrize(("meshes", "call", "waits"), [
    (300, "response(start=0.2, stop=2.6)", (0.2, 2.0)),
    pytest.param(300, "response(start=0.2, stop=2.6, harmonics=1000)", (0.2, 2.0, 6.0), marks=pytest.mark.nightly),
    (300, "attractors(frequency=0.9)", (0.2, 2.0)),
    pytest.param(300, "sweep(start=0.5, stop=1.0)", (1.0,), marks=pytest.mark.nightly),
    (300, "integrate(0.9)", (1.0,)),
    (200, "response(start=0.9, stop=0.9001, harmonics=1, max_points=3, stability=False).audit(points=3)", (1.0, 3.0)),
    pytest.param(300, "response(start=0.9, stop=0.9001, harmonics=1, max_points=3, stability=False).audit(points=3)", (1.0, 3.0),
                 marks=pytest.mark.nightly),
    (300, "run_up(start=0.5, stop=1.0, duration=0.5)", (1.0,)),
    (2, "run_up(start=0.5, stop=1.0, duration=100.0, samples=1)", (0.2, 2.0)),
    (2, MAP.format(HUGE), (0.2, 2.0)),
    pytest.param(2, MAP.format(HUGE + ", linear=True"), (0.2, 2.0), marks=pytest.mark.nightly),
    pytest.param(60, MAP.format("linear=True"), (0.2, 2.0), marks=pytest.mark.nightly),
    (60, MAP.format("points=20"), (2.0,)),
    pytest.param(30, "response(start=1.5, stop=4.0, period_doublings=2)", (2.0, 4.0), marks=pytest.mark.nightly),
    pytest.param(700, "modes()", (0.3, 2.0), marks=pytest.mark.nightly),
    (30, "integrate(0.9, max_periods=1).trajectory(1000000, samples=1)", (2.0,)),
    pytest.param(700, "natural_frequencies()", (2.0,), marks=pytest.mark.nightly),
])
def test_within_a_second(meshes, call, waits, times):
    """By day after the longest wait alone."""
    for wait in waits[-times(len(waits)):]:
        code = CHILD.format(meshes=meshes, call=call, wait=wait)
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
        assert float(done.stdout.split()[0]) < PATIENCE, (wait, done.stdout)
        assert "stopped by Ctrl-C" in done.stdout


PAGE = """
import os, signal, threading, time
import geartrain as gt
import matplotlib.backends.backend_agg, matplotlib.figure, plotly.offline  # as tqdm above
signal.signal(signal.SIGINT, signal.default_int_handler)
train = gt.read_case({case!r}).train
branch = train.response(start=0.2, stop=2.6, step=0.0005, max_points=100000)
""" + INTERRUPT + """\
try:
    gt.page(branch)
except KeyboardInterrupt:
    print(len(branch), time.monotonic() - sent[0])
"""


@pytest.mark.parametrize("wait", [1.0, *(pytest.param(wait, marks=pytest.mark.nightly) for wait in (2.5, 4.0))])
def test_a_page_of_a_large_branch(tmp_path, wait):
    """Compressing 100 MB takes seconds."""
    code = PAGE.format(case=str(write_case(tmp_path, "&modes /\n")), wait=wait)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    points, seconds = done.stdout.split()
    assert int(points) > 20_000 and float(seconds) < PATIENCE, done


def test_a_huge_map_takes_memory_as_it_grows():
    """1e4 x 1e4 motions are 4 GB; after some rows it is some MB."""
    code = CHILD.format(meshes=2, call=MAP.format(HUGE + ", linear=True"), wait=1.5)
    # Not ru_maxrss, which begins with the memory of the process that runs the tests.
    code += "print(next(line for line in open('/proc/self/status') if line.startswith('VmHWM:')).split()[1])\n"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True)
    assert int(done.stdout.split()[-1]) < 500_000, done.stdout  # kB


def test_a_map_beyond_all_memory_is_told_at_once():
    """With 3 GB where the map and the file of it want 7."""
    code = "import resource\n" + CHILD.format(meshes=2, call=MAP.format(HUGE + ", linear=True"), wait=20.0)
    code = code.replace("try:\n", "resource.setrlimit(resource.RLIMIT_AS, (3 * 10**9, 3 * 10**9))\ntry:\n")
    code = code.replace("except gt.Interrupted as stop:\n    print(time.monotonic() - sent[0], type(stop.result).__name__, stop)",
                        "except MemoryError as error:\n    print(error)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=15, check=False)
    assert "no memory for 10000 times 10000 motions (7.2 GB" in done.stdout, done


def test_a_second_one_at_once():
    """Of work that does not look: the first Ctrl-C waits for it, the second does not."""
    forever = threading.Event()

    def interrupt():
        for pause in (0.3, 0.7):
            time.sleep(pause)
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    begin = time.monotonic()
    try:
        threading.Thread(target=interrupt).start()
        with pytest.raises(gt.Interrupted) as stop:
            watched(lambda progress: forever.wait(30), "work")
    finally:
        signal.signal(signal.SIGINT, before)
        forever.set()
    assert 0.9 < time.monotonic() - begin < 5 and stop.value.result is None


LONG = "&response from = 0.2, to = 2.6, step = 1e-4, max_points = 100000 /\n"


def test_the_executable_ends_at_once_and_goes_on(executable, tmp_path):
    """By the signal, as a shell's loop wants it, with a word on what there is."""
    case, output = write_case(tmp_path, LONG), tmp_path / "out.h5"
    partial = tmp_path / "out.h5.partial"
    work = subprocess.Popen([executable, case, "--output", output], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    while not partial.exists():
        time.sleep(0.01)
    begin = time.monotonic()
    work.send_signal(signal.SIGINT)
    _, told = work.communicate(timeout=30)
    assert time.monotonic() - begin < PATIENCE
    assert work.returncode == -signal.SIGINT and "interrupted" in told and "--resume" in told
    with h5py.File(partial) as file:
        assert len(file["response/frequency"]) > 0
    assert not output.exists()
    again = subprocess.Popen([executable, case, "--output", output, "--resume"], stdout=subprocess.DEVNULL)
    time.sleep(0.2)
    assert again.poll() is None, "the checkpoint is taken"
    again.kill()
    again.wait()


def test_a_map_stopped_before_its_first_row_can_be_written(tmp_path):
    case = write_case(tmp_path, (
        "&stability_map from = 0.2, to = 2.6, points = 9000, parameter_from = 0.01, parameter_to = 0.1, parameter_points = 9000 /\n"
    ))
    read = gt.read_case(case)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        threading.Timer(0.2, signal.raise_signal, [signal.SIGINT]).start()
        with pytest.raises(gt.Interrupted) as stop:
            read.run()
    finally:
        signal.signal(signal.SIGINT, before)
    result = stop.value.result
    assert len(result.stability_map.parameter) == 0 and "cancelled after 0 of 9000 rows" in result.ended
    result.write(tmp_path / "out.h5")
    assert h5py.is_hdf5(tmp_path / "out.h5")


def test_an_interrupt_amid_the_locks_of_the_bar_is_one(monkeypatch):
    """tqdm releases a lock on its way out that it may not have taken yet, which makes another error of Ctrl-C."""

    class Bar:
        n = 0

        def set_postfix_str(self, _):
            try:
                raise KeyboardInterrupt
            finally:
                raise RuntimeError("cannot release un-acquired lock")

        def close(self):
            raise RuntimeError("cannot release un-acquired lock")

    monkeypatch.setattr(_watch, "progress_bar", lambda *_: Bar())
    monkeypatch.setattr(_watch, "_PATIENCE", 0.0)

    def work(progress):
        while not progress[0]:
            time.sleep(0.01)
        return "what there is"

    with pytest.raises(gt.Interrupted) as stop:
        watched(work, "work")
    assert stop.value.result == "what there is"
