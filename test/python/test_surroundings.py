"""Python as it may be: texts that a case file takes, no standard error, no tqdm, motions made by hand, values without end."""

import dataclasses
import itertools
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, paper_train

import geartrain as gt

#: No break, emoji with joiner, right to left, no character yet, soft hyphen.
TEXTS = ("a\u00a0b", "\U0001f469\u200d\U0001f52c", "\u05d0\u200f", "\U000323b0", "\u00ad", "it's")


@pytest.mark.parametrize("text", TEXTS)
def test_read_case_takes_what_the_executable_takes(executable, tmp_path, text):
    name = text.replace("'", "''")
    source = (ROOT / "namelists" / "single_pair.nml").read_text().split("&response")[0]
    title = next(line for line in source.splitlines() if line.strip().startswith("title"))
    path = tmp_path / f"{text}.nml"
    path.write_text(source.replace(title, f"   title = '{name}'") + f"&output file = '{name}.h5' /\n", encoding="utf-8")
    done = subprocess.run([executable, "--check", path], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    case = gt.read_case(path)
    assert case.train.title == text and case.output == f"{text}.h5"
    assert dataclasses.replace(case.train, title=text) == case.train
    case.run().write(tmp_path / "python.h5")
    assert gt.read_case(path).train == case.train


@pytest.mark.parametrize("text", [
    "a\nb", "\t", "\x7f", "\x00", "\x1c", "\ud800", "a\u2028b", "a\u0085b", "a\u202eb", "\u2066", "\ufeffa",
])
def test_control_characters_are_told(text):
    with pytest.raises(gt.InputError, match=r"title = .*without control characters"):
        paper_train(title=text)


LONG = """
import sys
sys.path.insert(0, {folder!r})
from conftest import paper_train
{before}
print(len(paper_train().sweep(start=0.2, stop=2.6, points=150)))
"""


@pytest.mark.parametrize("before", [
    "sys.stderr = None",
    "sys.stderr.close()",
    "sys.stderr = open('/dev/full', 'w', buffering=1); sys.stderr.isatty = lambda: True",
    "sys.modules['tqdm'] = sys.modules['tqdm.auto'] = None",
    "import os; os.close(2)",
])
def test_without_standard_error_or_tqdm_there_is_no_bar(request, before):
    before = "import geartrain._core.watch as watch; watch._PATIENCE = 0.1\n" + before
    code = LONG.format(folder=str(request.path.parent), before=before)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 120) and done.stdout == "150\n", done  # 120: Python itself cannot flush such a stream at its end


WITHOUT = """
import sys
sys.modules["matplotlib"] = None
sys.path.insert(0, {folder!r})
from conftest import paper_train
train = paper_train()
branch, motion, sweep = train.response(start=0.4, stop=0.5), train.integrate(0.9), train.sweep(start=0.4, stop=0.5, points=2)
told = set()
for draw in (
    branch.plot, motion.plot, motion.phase_plane, motion.poincare_section, sweep.plot, train.plot, train.modes().plot,
    train.campbell(start=0.2, stop=1.0).plot,
):
    try:
        draw()
    except ImportError as error:
        told.add(str(error))
print(*told)
"""


def test_a_missing_package_is_told_with_the_extra_that_brings_it(request):
    code = WITHOUT.format(folder=str(request.path.parent))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "this call needs matplotlib, which is not installed: pip install 'geartrain[plot]'\n"


@pytest.mark.parametrize("changes", [
    {"period": 10**6}, {"period": 10**30}, {"period": -1}, {"period": 2.5}, {"period": True}, {"period": None},
    {"coefficients": np.ones((2, 4))}, {"coefficients": np.ones((1, 33))}, {"coefficients": np.full((2, 33), np.nan)},
    {"period": 10**400}, {"period": 2**31}, {"coefficients": np.zeros((2, 0))},
    {"coefficients": np.zeros((0, 33))}, {"coefficients": None},
    {"coefficients": np.full((2, 33), 1e300)}, {"coefficients": np.ones((2, 33), complex)},
    {"rms": np.ones(3)}, {"rms": None}, {"mean": [None, None]}, {"mesh_force_maximum": np.ones(1)},
    {"state": np.full(10, np.inf)}, {"state": np.full(10, 1e200)}, {"state": "rest"},
    {"frequency": float("nan")}, {"frequency": 10**400}, {"frequency": None}, {"multipliers": np.ones((2, 2), complex)},
    {"error_estimate": None}, {"lyapunov_exponent": "0"}, {"stable": "yes"}, {"kind": "unheard"}, {"kind": None},
])
def test_forged_motions_are_refused(train, changes):
    """Wherever a motion goes, whatever of it is used there; the message tells the value and what it must be."""
    forged = dataclasses.replace(train.integrate(0.9), **changes)
    begin = time.monotonic()
    for call in (forged.refine, lambda: forged.displacement, lambda: forged.mesh_force, lambda: forged.time,
                 lambda: forged.true_ac_rms, lambda: forged.waveform(64), forged.spectrum, forged.plot,
                 lambda: train.response(start=0.8, stop=1.0, seed=forged), lambda: train.integrate(0.9, start=forged)):
        with pytest.raises(gt.InputError, match=r"must (be|have)"):
            call()
    assert time.monotonic() - begin < 5


@pytest.mark.parametrize("changes", [
    {"state": np.ones(3)}, {"multipliers": np.ones(11, complex)}, {"frequency": -1.0}, {"frequency": 0.0}, {"frequency": 1e-300},
    {"frequency": 1e300}, {"train": "the paper's"},
])
def test_forged_motions_that_no_motion_of_the_train_is_like(train, changes):
    forged = dataclasses.replace(train.integrate(0.9), **changes)
    with pytest.raises(gt.InputError, match=r"^refine: .*must "):
        forged.refine()
    for call in (lambda: forged.displacement, lambda: forged.waveform(64)):
        with pytest.raises(gt.InputError, match=r"^motion: .*must "):
            call()


def test_motions_of_another_train_are_refused(train):
    """Not one byte of it is read or written: the heap would not bear it."""
    shafts, meshes = train.shafts[:2], train.meshes[:1]
    pair = paper_train(shafts=shafts, meshes=meshes)
    motion = train.integrate(0.9)
    for forged in (dataclasses.replace(motion, train=pair), dataclasses.replace(motion, train=pair, state=None)):
        for call in (lambda m=forged: m.waveform(64), lambda m=forged: m.displacement, lambda m=forged: m.mesh_force,
                     forged.refine, forged.plot):
            with pytest.raises(gt.InputError, match="a motion of 2 meshes: the train has 1"):
                call()
    with pytest.raises(gt.InputError, match="seed: a motion of 2 meshes"):
        pair.response(start=0.8, stop=1.0, seed=motion)
    with pytest.raises(gt.InputError, match="start: a motion of 2 meshes"):
        pair.integrate(0.9, start=motion)
    same_meshes = paper_train(shafts=[train.shafts[0], gt.Shaft(rigid=True), train.shafts[2]])
    with pytest.raises(gt.InputError, match="a state of 10 values: must have 8"):
        dataclasses.replace(motion, train=same_meshes).waveform(64)


def test_results_of_forged_motions_are_not_written(tmp_path):
    results = gt.read_case(ROOT / "namelists" / "single_pair.nml")
    sweep = results.train.sweep(start=0.5, stop=0.6, points=2, stability=True)
    text = results.train.namelist(integration={"start": 0.5, "stop": 0.6, "points": 2})
    forged = dataclasses.replace(sweep[1], multipliers=np.ones(1, complex))
    for motions, direction, told in (
        ([*sweep, sweep[0]], sweep.direction, "direction: must be 'up' or 'down' of each of the 3 motions"),
        ([sweep[0], forged], sweep.direction, "multipliers: must be as many"),
        ([sweep[0], dataclasses.replace(sweep[1], rms=None)], sweep.direction, "integration: rms = None"),
    ):
        wrong = gt.Results(modes=None, response=None, integration=gt.Sweep(motions, direction, "", True), text=text)
        with pytest.raises(gt.InputError, match=told):
            wrong.write(tmp_path / "out.h5")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("start", [
    range(10**12), range(10**30), [range(10**12)] * 10, [10**400] * 10, [1e200] * 10, np.full(10, 1e200), np.array(0.0),
    np.zeros((2, 5)), "at rest!!!", {"state": 1},
], ids=lambda start: str(start)[:20])
def test_starts_that_are_none_are_told_at_once(train, start):
    begin = time.monotonic()
    with pytest.raises(gt.InputError, match=r"^start.*must "):
        train.integrate(0.9, start=start)
    assert time.monotonic() - begin < 5


@pytest.mark.parametrize("frequency", [10**400, -(10**400)])
def test_frequencies_beyond_all_numbers(train, branch, frequency):
    with pytest.raises(gt.InputError, match=r"frequency = .*must be a finite number"):
        branch.at(frequency)
    with pytest.raises(gt.InputError, match=r"frequency = .*must be a"):
        train.integrate(frequency)


@pytest.mark.parametrize("number", [2**31, -(2**31) - 1, 2**63, 10**30, 10**5000], ids=["31", "-31", "63", "10**30", "10**5000"])
def test_integers_too_large_are_told_at_once(train, number):
    for call in (
        lambda: train.response(start=0.8, stop=1.0, harmonics=number),
        lambda: train.response(start=0.8, stop=number, harmonics=number),
        lambda: train.attractors(0.9, random_seed=number),
        lambda: train.sweep(start=0.8, stop=1.0, points=number),
        lambda: dataclasses.replace(train.meshes[0], order=number) and paper_train(
            meshes=[dataclasses.replace(mesh, order=number) for mesh in train.meshes]),
        lambda: train.integrate(0.9).waveform(number),
    ):
        with pytest.raises(gt.InputError, match="whole number"):
            call()


def test_generators_without_end_are_told_at_once(train):
    begin = time.monotonic()
    with pytest.raises(gt.InputError, match="more than 1000 values"):
        paper_train(torque_cos=itertools.count())
    with pytest.raises(gt.InputError, match="more than 1000 values"):
        paper_train(meshes=[dataclasses.replace(mesh, error_sin=itertools.repeat(1e-9)) for mesh in train.meshes])
    with pytest.raises(gt.InputError, match="must be a list of"):
        paper_train(shafts=itertools.repeat(gt.Shaft(rigid=True)))
    with pytest.raises(gt.InputError, match=r"must be a gt\.Motion or a list"):
        train.integrate(0.9, start=itertools.count())
    assert time.monotonic() - begin < 5


def test_sets_have_no_order(train):
    """So they are no lists of harmonics."""
    for amplitudes in ({0.3, 0.1}, frozenset([0.3])):
        with pytest.raises(gt.InputError, match="must be a number or a list of numbers"):
            paper_train(meshes=[dataclasses.replace(mesh, stiffness_cos=amplitudes) for mesh in train.meshes])


def test_messages_show_no_more_than_helps(train):
    with pytest.raises(gt.InputError) as told:
        train.response(start="x" * 10**6, stop=1.0)
    assert len(str(told.value)) < 300


@pytest.mark.skipif(shutil.which("gfortran") is None, reason="no gfortran")
@pytest.mark.parametrize("flags, safe", [("-O0", True), ("-O3", True), ("-Ofast", False), ("-O2 -ffinite-math-only", False)])
def test_a_library_that_cannot_tell_nan_knows_it(flags, safe, tmp_path):
    """What the check of every train asks, compiled with flags that are refused, and with others."""
    (tmp_path / "asks.f90").write_text(
        "program asks\nuse geartrain_base_arithmetic, only: tells_nan\nprint '(l1)', tells_nan()\nend program asks\n")
    sources = [ROOT / "src" / "geartrain" / "base" / f"{name}.f90" for name in ("kinds", "arithmetic")]
    subprocess.run(["gfortran", *flags.split(), *sources, "asks.f90", "-o", "asks"], cwd=tmp_path, check=True)
    assert subprocess.run(["./asks"], cwd=tmp_path, capture_output=True, text=True, check=True).stdout.strip() == "FT"[safe]


@pytest.mark.parametrize(("asked", "kernels"), [({}, None), ({"OPENBLAS_CORETYPE": "Prescott"}, "Prescott")])
def test_openblas_takes_the_kernels_that_the_processor_can_take(asked, kernels):
    """OpenBLAS takes a model that it does not know for one of 2004. The choice of the user stays."""
    code = """
import ctypes
import geartrain
for path in {line.split()[-1] for line in open("/proc/self/maps") if "/libopenblas" in line}:
    library = ctypes.CDLL(path)
    library.openblas_get_corename.restype = ctypes.c_char_p
    print(library.openblas_get_corename().decode())
"""
    flags = Path("/proc/cpuinfo").read_text().split()
    if not {"avx2", "fma"} <= set(flags):
        pytest.skip("this processor has no AVX2")
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_CORETYPE"}
    done = subprocess.run([sys.executable, "-c", code], env={**environment, **asked}, capture_output=True, text=True, check=True)
    found = done.stdout.split()
    if not found:
        pytest.skip("the package is linked with another BLAS")
    assert (found == [kernels]) if kernels else ("Prescott" not in found)
