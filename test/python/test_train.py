"""Trains: names, checks and what is linear."""

import copy
import inspect
import pickle

import numpy as np
import pytest
from conftest import ROOT, paper_train, single_pair

import geartrain as gt


def test_version():
    assert gt.__version__ == "0.1.0"


def test_natural_frequencies_of_the_paper(train):
    expected = [0.9571, 1.8662, 6.6807, 6.6810, 15.9206]
    np.testing.assert_allclose(train.natural_frequencies(), expected, atol=5e-5)


def test_modes(train):
    modes = train.modes()
    assert modes.element == ("shaft 1", "mesh 1", "shaft 2", "mesh 2", "shaft 3")
    assert modes.shape.shape == (5, 5)
    np.testing.assert_allclose(abs(modes.shape).max(axis=1), 1)
    assert (modes.damped_frequency < modes.natural_frequency).all()


def test_series_may_be_numbers_lists_or_arrays():
    given = [gt.Mesh(stiffness_cos=value) for value in (0.3, [0.3], (0.3,), np.array([0.3]))]
    assert all(mesh == given[0] for mesh in given)


def test_rigid_shafts_and_zero_inertias():
    np.testing.assert_allclose(single_pair(0.8, stiffness_cos=0.3).natural_frequencies(), [1.0])


def test_bad_value_is_told_as_by_the_executable():
    with pytest.raises(gt.InputError, match=r"^&mesh 2: stiffness = -1\.0: must be > 0"):
        paper_train(meshes=[paper_train().meshes[0], gt.Mesh(
            driving_radius=0.05, driven_radius=0.1, driving_inertia=1, driven_inertia=1, stiffness=-1.0)])


def test_every_problem_is_told_at_once():
    with pytest.raises(gt.InputError) as caught:
        paper_train(characteristic_length=-1.0, characteristic_frequency=float("nan"))
    message = str(caught.value)
    assert "characteristic_length" in message and "characteristic_frequency" in message


@pytest.mark.parametrize(("name", "value"), [
    ("input_torque", [1.0, 2.0]), ("input_torque", "150"), ("input_torque", True), ("input_torque", 1j),
    ("torque_cos", "0.1"), ("torque_cos", [[1.0]]), ("torque_cos", {1: 2}), ("title", 3), ("title", "two\nlines"),
    ("shafts", 3), ("meshes", [gt.Shaft()]), ("shafts", []),
])
def test_wrong_kinds_are_input_errors(name, value):
    with pytest.raises(gt.InputError, match=name.rstrip("es") if value == [] else name):
        paper_train(**{name: value})


@pytest.mark.parametrize("settings", [
    {"start": "0.2", "stop": 2.6}, {"start": 0.2, "stop": [2.6]}, {"start": 0.2, "stop": 2.6, "harmonics": 6.5},
    {"start": 0.2, "stop": 2.6, "stability": 1}, {"start": 0.2, "stop": 2.6, "control": "manual"},
    {"start": -0.2, "stop": 2.6}, {"start": 0.2, "stop": 2.6, "subharmonic": 0}, {"start": 0.2, "stop": 0.2},
    {"start": 0.2, "stop": float("nan")}, {"start": 0.2, "stop": 2.6, "seed": 3},
])
def test_wrong_settings_are_input_errors(train, settings):
    with pytest.raises(gt.InputError):
        train.response(**settings)


@pytest.mark.parametrize(("call", "keywords"), [
    ("integrate", {"frequency": -1.0}), ("integrate", {"frequency": "a"}), ("integrate", {"frequency": float("inf")}),
    ("integrate", {"frequency": 0.9, "start": [1.0, 2.0]}), ("integrate", {"frequency": 0.9, "start": "rest"}),
    ("integrate", {"frequency": 0.9, "start": np.full(10, np.nan)}), ("integrate", {"frequency": 0.9, "tolerance": -1}),
    ("attractors", {"frequency": 0.9, "starts": 0}), ("attractors", {"frequency": 0.9, "starts": 1.5}),
    ("attractors", {"frequency": 0.9, "random_seed": 2**40}),
    ("attractors", {"frequency": 0.9, "follow": True}),
    ("sweep", {"start": 0.2, "stop": 1.0, "points": -1}),
    ("sweep", {"start": 0.2, "stop": 1.0, "direction": "left"}), ("sweep", {"start": 0.2, "stop": 1.0, "points": "a"}),
])
def test_wrong_calls_are_input_errors(train, call, keywords):
    with pytest.raises(gt.InputError):
        getattr(train, call)(**keywords)


def test_motion_of_another_train_is_refused(train, branch):
    pair = gt.read_case(ROOT / "namelists" / "single_pair.nml").train
    motion = branch.at(0.9)[0]
    with pytest.raises(gt.InputError, match="mesh"):
        pair.response(start=0.2, stop=2.0, seed=motion)
    with pytest.raises(gt.InputError, match="mesh"):
        pair.integrate(0.8, start=motion)


def test_train_can_be_copied_and_pickled(train):
    assert copy.deepcopy(train) == train == pickle.loads(pickle.dumps(train))


def test_keywords_are_the_names_of_the_case_file():
    case = gt.read_case(ROOT / "namelists" / "fig03.nml")
    assert set(case.response) == set(inspect.signature(gt.Train.response).parameters) - {"self", "seed"}
    assert set(case.integration) == set(inspect.signature(gt.Train.sweep).parameters) - {"self"}
    case = gt.read_case(ROOT / "namelists" / "fig13.nml")
    assert set(case.attractors) == set(inspect.signature(gt.Train.attractors).parameters) - {"self"}


def test_file_without_the_train_is_told_with_its_line(tmp_path):
    path = tmp_path / "bad.nml"
    path.write_text("&train\n   input_torqe = 3\n/\n")
    with pytest.raises(gt.InputError, match=r"bad\.nml:2:4: error: .*input_torqe"):
        gt.read_case(path)


def test_missing_file():
    with pytest.raises((OSError, gt.InputError), match="nowhere"):
        gt.read_case("nowhere.nml")


def test_damping_to_ground_is_one_more_state():
    train = gt.Train(
        characteristic_length=1e-5,
        characteristic_frequency=1e4,
        bodies=[
            gt.Body(name="a", inertia=2e-3, torque=40.0, damping_to_ground=0.8),
            gt.Body(name="b", inertia=7e-3, balances=True),
        ],
        shafts=[],
        meshes=[
            gt.Mesh(
                between=("a", "b"),
                driving_radius=0.05,
                driven_radius=0.08,
                stiffness=1e8,
                damping_ratio=0.05,
                half_backlash=1e-5,
                stiffness_cos=[0.3],
            )
        ],
    )
    branch = train.response(start=0.6, stop=0.7, harmonics=12)
    assert branch.multipliers.shape[1] == 3
    motion = train.integrate(frequency=0.65)
    assert len(motion.state) == 3
    again = train.integrate(frequency=0.65, start=motion.state)
    assert np.abs(again.rms - motion.rms).max() < 1e-9
    assert np.abs(branch.at(0.65)[0].refine().rms - motion.rms).max() < 1e-9


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
@pytest.mark.parametrize(("name", "frequency", "unit"), [
    ("fig03", 0.7, "Lambda"), ("branched", 2.4, "Lambda"), ("planetary", 3000.0, "rpm"), ("clutch", 1200.0, "rpm"),
    ("bearings", 4000.0, "rpm"),
])
def test_the_values_of_a_state_have_names(name, frequency, unit):
    """Displacements and velocities of meshes, couplings and bearings at time 0, as the coefficients of the motion have them."""
    train = gt.read_case(ROOT / f"namelists/{name}.nml").train
    modes, motion = train.modes(), train.integrate(frequency, unit=unit)
    assert motion.kind == "periodic"
    values = dict(zip(modes.state, motion.state, strict=True))
    with_play = [element for element in modes.element if not element.startswith(("shaft", "ground"))]
    assert len(with_play) == len(motion.coefficients)
    named = [number for number, element in enumerate(with_play) if element in values]
    assert named
    for number in named:
        mean, cosines, sines = motion.coefficients[number, 0], motion.coefficients[number, 1::2], motion.coefficients[number, 2::2]
        rate = np.arange(1, len(sines) + 1) @ sines * motion.frequency / motion.period
        assert values[with_play[number]] == pytest.approx(mean + cosines.sum(), abs=1e-6 * np.abs(motion.state).max())
        assert values[f"rate of {with_play[number]}"] == pytest.approx(rate, abs=1e-4 * np.abs(motion.state).max())
