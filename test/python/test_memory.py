"""Too little memory: status 4 of the executable, MemoryError in Python, and what is computed by then is kept."""

import pickle
import re
import resource
import subprocess
import sys

import h5py
import pytest
from conftest import ROOT, paper_train, run

import geartrain as gt

TRAIN = (ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0]
BASINS = "&basins frequency = 0.6, displacement_points = 10000, velocity_points = 10000 /\n"


def limited(executable, folder, analyses, megabytes, **keywords):
    """A run of the executable that may have so much memory."""
    case = folder / "case.nml"
    case.write_text(TRAIN + analyses)
    limit = megabytes * 10**6
    return run(executable, case, "--output", folder / "out.h5", timeout=120,
               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)), **keywords)


def test_a_grid_beyond_the_memory(executable, tmp_path):
    """It is known before anything is computed; the other analyses of the case run."""
    done = limited(executable, tmp_path, BASINS + "&modes /\n", 600)
    assert done.returncode == 4, done
    assert "basins: no memory for 10000 times 10000 starts (2 GB with the file of them): take fewer" in done.stderr, done
    with h5py.File(tmp_path / "out.h5") as file:
        assert "modes" in file and "basins" not in file


@pytest.mark.parametrize("analysis", [
    "&integration from = 0.5, to = 0.9, points = 100000, harmonics = 200 /\n",
    "&bifurcation_diagram from = 0.5, to = 0.9, points = 10000, sections = 1000 /\n",
    "&stability_map from = 0.2, to = 0.3, parameter_from = 0.1, parameter_to = 0.2, points = 10000, parameter_points = 10000 /\n",
    "&run_up from = 0.4, to = 0.8, duration = 100.0, samples = 500 /\n",
])
def test_arrays_that_settings_ask_for(executable, tmp_path, analysis):
    done = limited(executable, tmp_path, analysis, 600)
    assert done.returncode == 4 and re.search(r"no memory for .* GB with the file of them\): take fewer", done.stderr), done


@pytest.mark.full
def test_results_that_outgrow_the_memory_are_kept(executable, tmp_path):
    """A response of any number of points ends while there is still memory to write it."""
    analysis = "&response from = 0.2, to = 2.6, harmonics = 12, step = 1e-6, max_points = 10000000 /\n"
    done = limited(executable, tmp_path, analysis, 400)
    assert done.returncode == 4 and "there is no memory for more results; those so far are kept" in done.stderr, done
    with h5py.File(tmp_path / "out.h5") as file:
        points = len(file["response/frequency"])
        assert points > 10_000 and file["response"].attrs["complete"] == 0
    assert not (tmp_path / "out.h5.partial").exists()


CHILD = """
import os, pickle, resource, sys
import geartrain as gt
train = pickle.load(sys.stdin.buffer)
pages = int(open("/proc/self/statm").read().split()[0])
limit = pages * os.sysconf("SC_PAGE_SIZE") + int(sys.argv[1]) * 10**6
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
for name, call in {
    "modes": lambda: train.natural_frequencies(),
    "response": lambda: train.response(start=0.3, stop=0.5, harmonics=6),
    "integration": lambda: train.integrate(frequency=0.6),
    "sweep": lambda: train.sweep(start=0.5, stop=0.6, points=3),
    "attractors": lambda: train.attractors(frequency=0.6, starts=8),
    "basins": lambda: train.basins(frequency=0.6, starts=4, points=(8, 8)),
    "huge basins": lambda: train.basins(frequency=0.6, points=(10000, 10000)),
    "diagram": lambda: train.bifurcation_diagram(start=0.5, stop=0.6, points=2, sections=20),
    "map": lambda: train.stability_map(
        start=0.4, stop=0.5, points=4, parameter="stiffness_variation", parameter_start=0.1, parameter_stop=0.2,
        parameter_points=2),
    "run-up": lambda: train.run_up(start=0.4, stop=0.6, duration=0.01),
    "huge run-up": lambda: train.run_up(start=0.4, stop=0.8, duration=100.0, samples=500),
    "trajectory": lambda: train.response(start=0.3, stop=0.5, harmonics=6).at(0.4)[0].trajectory(100),
}.items():
    try:
        call()
        print(name, "done", flush=True)
    except MemoryError as error:
        print(name, "MemoryError", flush=True)
"""


@pytest.mark.parametrize("megabytes", [20, 100, 200, 300, 400, 600, 1000])
def test_python_goes_on(megabytes):
    """Each call succeeds or raises MemoryError; the interpreter lives on."""
    train = gt.read_case(ROOT / "namelists" / "fig03.nml").train
    done = subprocess.run([sys.executable, "-c", CHILD, str(megabytes)], input=pickle.dumps(train), capture_output=True,
                          timeout=300, check=False)
    told = dict(line.rsplit(" ", 1) for line in done.stdout.decode().splitlines())
    assert done.returncode == 0 and len(told) == 12, (done.stdout.decode(), done.stderr.decode()[-1500:])
    assert told["huge basins"] == told["huge run-up"] == "MemoryError"
    if megabytes == 20:
        assert set(told.values()) == {"MemoryError"}
    if megabytes == 1000:
        assert list(told.values()).count("MemoryError") == 2


def test_a_checkpoint_that_cannot_be_written_is_told(executable, tmp_path):
    """Once, and the run goes on to its end; a limit on the size of files keeps checkpoints and results from the disk."""
    case = tmp_path / "case.nml"
    case.write_text(TRAIN + "&response from = 0.2, to = 2.6, step = 0.0005, max_points = 100000 /\n&modes /\n")
    done = run(executable, case, "--output", tmp_path / "out.h5", timeout=120,
               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000)))
    assert done.returncode == 4 and "Written" not in done.stdout, done
    told = [line for line in done.stderr.splitlines() if line.startswith("geartrain: warning: ")]
    assert len(told) == 1 and "out.h5.partial: error: cannot be written: " in told[0], done
    assert told[0].endswith("; the run goes on without this checkpoint")
    assert "out.h5: error: cannot be written: " in done.stderr.splitlines()[-1]
    assert re.search(r"^Response: .* \d{4,} motions", done.stdout, re.MULTILINE), done


def test_more_samples_than_the_machine_has_memory_for(monkeypatch):
    motion = paper_train().integrate(1.9)
    motion.trajectory(1000)
    monkeypatch.setattr("os.sysconf", lambda name: 1000)  # a megabyte
    with pytest.raises(MemoryError, match="1000 periods"):
        motion.trajectory(1000)


def test_least_of_orders():
    motion = paper_train().integrate(1.9)
    for least in (float("nan"), -1, 2, [0.1, 0.2]):
        with pytest.raises(gt.InputError, match="least"):
            motion.orders(least)
