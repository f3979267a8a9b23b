"""What several test files use: trains, cases, the executable and files that it writes."""

import os
import signal
import subprocess
from collections import Counter
from itertools import chain, pairwise
from pathlib import Path

import h5py
import numpy as np
import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads take memory, which some tests limit

import geartrain as gt

# A job in the background of a shell ignores Ctrl-C, and so would the programs that the tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)

ROOT = Path(__file__).resolve().parents[2]


def texts(ax):
    """What is written in axes."""
    return [text.get_text() for text in ax.texts]


def paper_train(half_backlash=30e-6, **changes):
    shafts = [gt.Shaft(stiffness=stiffness, damping_ratio=0.01) for stiffness in (1e3, 1e8, 1e3)]
    meshes = [
        gt.Mesh(driving_radius=0.05, driven_radius=0.10, driving_inertia=driving, driven_inertia=driven,
                stiffness=stiffness, damping_ratio=0.05, half_backlash=half_backlash, stiffness_cos=[0.3])
        for driving, driven, stiffness in ((0.0023, 0.037, 2.5e8), (0.0046, 0.074, 5e8))
    ]
    values = {
        "input_torque": 150.0, "prime_mover_inertia": 2.3e-7, "load_inertia": 2.3e-7,
        "characteristic_length": 30e-6, "characteristic_frequency": 9870.0, "shafts": shafts, "meshes": meshes,
    }
    return gt.Train(**{**values, **changes})


REDUCER = {"title": "two-stage reducer", "speed_of": "motor"}


def reducer(shafts=None, teeth=(23, 71), **changes):
    """A reducer of two helical stages as a drawing gives it; ``teeth`` are those of the first stage."""
    names = ("motor", "pinion 1", "wheel 1", "pinion 2", "wheel 2", "load")
    bodies = [gt.Body(name="motor", inertia=0.02, torque=90.0), *(gt.Body(name=name) for name in names[1:-1]),
              gt.Body(name="load", inertia=1.5, balances=True)]
    ends = list(pairwise(names))
    sections = ((0.030, 0.150), (0.040, 0.120), (0.060, 0.200))
    shafts = shafts or [gt.Shaft(between=between, diameter=[diameter], length=[length], damping_ratio=0.01)
                        for between, (diameter, length) in zip(ends[::2], sections, strict=True)]
    drawn = {"helix_angle": 15.0, "backlash": 60e-6, "damping_ratio": 0.05, "stiffness_harmonics": 3, "error_cos": 3e-6}
    meshes = [gt.Mesh(between=ends[1], teeth=teeth, normal_module=2.5e-3, face_width=0.040, **drawn),
              gt.Mesh(between=ends[3], teeth=(19, 80), normal_module=4e-3, face_width=0.070, **drawn)]
    return gt.Train(**{**REDUCER, "bodies": bodies, "shafts": shafts, "meshes": meshes, **changes})


def single_pair(torque, damping_ratio=0.05, **mesh):
    """x'' + 2 zeta x' + kappa(t) g(x) = torque with b = 1: two gears on rigid shafts; `mesh` says what excites them."""
    return gt.Train(
        input_torque=torque, prime_mover_inertia=0.0, load_inertia=0.0, characteristic_length=1.0, characteristic_frequency=1.0,
        shafts=[gt.Shaft(rigid=True), gt.Shaft(rigid=True)],
        meshes=[gt.Mesh(driving_radius=1.0, driven_radius=1.0, driving_inertia=2.0, driven_inertia=2.0, stiffness=1.0,
                        damping_ratio=damping_ratio, half_backlash=1.0, **mesh)],
    )


def equal_stages(stiffness_variation):
    """Two equal pairs on an undamped shaft, whose motions may break the symmetry (test/validation_bifurcations.f90)."""
    mesh = gt.Mesh(driving_radius=0.05, driven_radius=0.05, driving_inertia=0.003, driven_inertia=0.003, stiffness=2.5e8,
                   damping_ratio=0.05, half_backlash=30e-6, stiffness_cos=[stiffness_variation])
    shafts = [gt.Shaft(rigid=True), gt.Shaft(stiffness=1e5, damping=0.0), gt.Shaft(rigid=True)]
    return gt.Train(input_torque=100.0, prime_mover_inertia=0.0, load_inertia=0.0, characteristic_length=30e-6,
                    characteristic_frequency=2e4, shafts=shafts, meshes=[mesh, mesh])


def equal_wheels(stiffness_variation=0.3, phase=0.0):
    """A pinion between two equal wheels, whose motions may be symmetric with a shift by half their period.

    So are motions of period 2 of meshes in phase, and those of period 1 of meshes in opposite phase (pi).
    """
    mesh = dict(driving_radius=0.05, driven_radius=0.06, stiffness=2.5e8, damping_ratio=0.04, half_backlash=30e-6,
                stiffness_cos=[stiffness_variation])
    bodies = [gt.Body(name="pinion", inertia=0.004, torque=200.0), gt.Body(name="one", inertia=0.0052, torque=-120.0),
              gt.Body(name="other", inertia=0.0052, balances=True)]
    return gt.Train(characteristic_length=30e-6, characteristic_frequency=9870.0, bodies=bodies,
                    meshes=[gt.Mesh(between=("pinion", "one"), **mesh), gt.Mesh(between=("pinion", "other"), phase=phase, **mesh)])


def unlike_pairs():
    """Three bodies in a row with unlike meshes, transmission errors and a phase."""
    bodies = [gt.Body(name="one", inertia=0.0021, torque=120.0), gt.Body(name="two", inertia=0.0067),
              gt.Body(name="three", inertia=0.031, balances=True)]
    meshes = [
        gt.Mesh(between=("one", "two"), driving_radius=0.047, driven_radius=0.082, stiffness=2.1e8, damping_ratio=0.045,
                half_backlash=27e-6, stiffness_cos=[0.27, 0.06], error_cos=[2e-6], error_sin=[0.0, 1e-6]),
        gt.Mesh(between=("two", "three"), driving_radius=0.052, driven_radius=0.097, stiffness=3.7e8, damping_ratio=0.055,
                half_backlash=33e-6, stiffness_cos=[0.21], stiffness_sin=[0.12], error_cos=[1.5e-6], phase=0.7),
    ]
    return gt.Train(characteristic_length=30e-6, characteristic_frequency=9870.0, bodies=bodies, meshes=meshes)


def write_case(folder, analyses, name="case.nml"):
    """The case file of figure 3 with other analyses."""
    path = folder / name
    path.write_text((ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0] + analyses)
    return path


def run(executable, *arguments, **options):
    """What the executable says to its arguments."""
    return subprocess.run([executable, *arguments], **{"capture_output": True, "text": True, "check": False, **options})


def assert_equal_files(one, other):
    with h5py.File(one) as first, h5py.File(other) as second:
        names = []
        first.visit(names.append)
        others = []
        second.visit(others.append)
        assert names == others and names
        assert first.attrs["input"] == second.attrs["input"]
        for name in names:
            assert set(first[name].attrs) == set(second[name].attrs)
            if isinstance(first[name], h5py.Dataset):
                np.testing.assert_array_equal(first[name][()], second[name][()], err_msg=name)


def pytest_addoption(parser):
    parser.addoption("--seed", type=int, default=0, help="of what the tests with files from elsewhere draw")
    parser.addoption("--all-repetitions", action="store_true", help="repeat in full what is repeated a tenth as often by day")


@pytest.fixture(scope="session")
def seed(request):
    """Of what a test draws; another one by night."""
    return request.config.getoption("--seed")


@pytest.fixture(scope="session")
def times(request):
    """How often a test whose cost is repetition repeats what it does, of so many times by night: by day a share of them."""
    return lambda count, share=10: count if request.config.getoption("--all-repetitions") else -(-count // share)


@pytest.fixture(scope="session")
def train():
    return paper_train()


@pytest.fixture(scope="session")
def branch(train):
    return train.response(start=0.2, stop=2.6)


@pytest.fixture(scope="session")
def page_results(tmp_path_factory):
    """Every kind of thing that a page shows, of the train of figure 3."""
    case = tmp_path_factory.mktemp("page") / "case.nml"
    case.write_text((ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0] + """
        &modes /
        &response from = 1.5, to = 2.3, period_doublings = 1 /
        &integration from = 1.6, to = 2.2, points = 7, direction = 'both', stability = .true. /
        &attractors frequency = 1.6, starts = 4 /
        &stability_map from = 1.6, to = 2.2, points = 13, parameter_from = 0.0, parameter_to = 0.4, parameter_points = 5 /
        &locus kind = 'period_doubling', near = 1.75, parameter = 'stiffness_variation', from = 0.2, to = 0.4 /
    """)
    return gt.read_case(case).run()


@pytest.fixture(scope="session")
def over_backlash(train):
    """A branch over a parameter of the train."""
    return train.continuation(parameter="mesh 2 half_backlash", start=10e-6, stop=40e-6, frequency=0.7)


@pytest.fixture(scope="session")
def page_path(page_results, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    page_results.page(path)
    return path


@pytest.fixture(scope="session")
def drawn():
    """A train given by its drawing."""
    return reducer()


@pytest.fixture(scope="session")
def drawn_branch(drawn):
    """A few of its motions, with jumps."""
    return drawn.response(start=1660, stop=1680, unit="rpm", harmonics=0, tolerance=5e-3)


@pytest.fixture(scope="session")
def split():
    """A train with branches."""
    return gt.read_case(ROOT / "namelists" / "branched.nml").train


@pytest.fixture
def closed_figures():
    from matplotlib import pyplot as plt

    yield
    plt.close("all")


@pytest.fixture(scope="session")
def executable():
    """The executable of the package that is tested."""
    return Path(gt.__file__).parent / "bin" / "geartrain"


def pytest_terminal_summary(terminalreporter):
    """Time of each file, slowest first."""
    seconds = Counter()
    for report in chain.from_iterable(terminalreporter.stats.values()):
        if hasattr(report, "duration"):
            seconds[report.nodeid.split("::")[0]] += report.duration
    for path, total in seconds.most_common():
        terminalreporter.write_line(f"{total:8.1f} s  {path}")
