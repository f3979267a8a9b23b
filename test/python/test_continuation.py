"""Branches over a parameter of the train at constant speed: what the calls, the file and the pictures make of them."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, paper_train, single_pair

import geartrain as gt


@pytest.fixture(scope="module")
def pair():
    """A single pair that is driven just below its resonance: over its torque the branch turns twice."""
    return gt.Train(
        input_torque=0.5, torque_cos=[0.1], prime_mover_inertia=0.0, load_inertia=0.0, characteristic_length=1.0,
        characteristic_frequency=1.0, shafts=[gt.Shaft(rigid=True), gt.Shaft(rigid=True)],
        meshes=[gt.Mesh(driving_radius=1.0, driven_radius=1.0, driving_inertia=2.0, driven_inertia=2.0, stiffness=1.0,
                        damping_ratio=0.05, half_backlash=1.0, stiffness_cos=[0.2])],
    )


@pytest.fixture(scope="module")
def over_torque(pair):
    return pair.continuation(parameter="input_torque", start=0.05, stop=1.0, frequency=0.9, harmonics=9)


def test_a_branch_over_the_torque(pair, over_torque):
    branch = over_torque
    assert (branch.parameter_name, branch.parameter_unit, branch.complete) == ("input_torque", "N m", True)
    assert branch.ended == "reached input_torque = 1 N m"
    assert branch.parameter[[0, -1]].tolist() == [0.05, 1.0] and (branch.frequency == 0.9).all()
    folds = [special for special in branch.special_points if special.kind == "fold"]
    assert len(folds) == 2 and {special.frequency for special in folds} == {0.9}
    # The folds are where the rising and the falling torque jump.
    assert sorted(jump.parameter for jump in branch.jumps) == sorted(special.parameter for special in folds)
    assert "parameter" in str(branch.jumps) and branch.peaks(1)[0].parameter > 0.1
    low, high = branch.separation_ranges(1)[0]
    assert 0.05 <= low < high < 1.0


def test_onsets_have_the_value_of_the_parameter(over_torque):
    assert {onset.frequency for onset in over_torque.onsets} == {0.9}
    for onset in over_torque.onsets:
        assert min(abs(motion.rms - onset.rms).max() for motion in over_torque.at(onset.parameter)) < 2e-5


def test_motions_at_a_value_have_its_train(pair, over_torque):
    low, high = sorted(special.parameter for special in over_torque.special_points)
    motions = over_torque.at((low + high) / 2)
    assert len(motions) == 3 and [motion.stable for motion in motions].count(True) == 2
    for motion in motions:
        assert motion.train.input_torque == (low + high) / 2 and motion.frequency == 0.9
        # The same motion of the train with this torque, solved by itself.
        near = motion.train.response(start=0.8999, stop=0.9001, seed=motion, harmonics=9).at(0.9)
        assert min(abs(other.rms[0] - motion.rms[0]) for other in near) < 1e-10
    # A motion of the middle seeds the whole branch, both ways.
    again = pair.continuation(parameter="input_torque", start=0.05, stop=1.0, frequency=0.9, harmonics=9, seed=motions[1])
    assert again.complete and sorted(special.parameter for special in again.special_points) == pytest.approx([low, high], rel=1e-9)


def test_the_slope_is_the_derivative(pair):
    h = 1e-4
    branch = pair.continuation(parameter="input_torque", start=0.5 - h, stop=0.5 + h, frequency=0.95, harmonics=9)
    slope = (branch.rms[-1, 0] - branch.rms[0, 0]) / (2 * h)
    motion = branch.at(0.5)[0]
    # The difference has an error of second order in h, about 1e-8.
    assert motion.gradient("rms", ["input_torque"])[0, 0] == pytest.approx(slope, rel=1e-6)


def test_doubled_and_refined(pair):
    branch = pair.continuation(parameter="stiffness_variation", start=0.1, stop=0.5, frequency=1.9, harmonics=9, period_doublings=1)
    doubling = next(special for special in branch.special_points if special.kind == "period doubling")
    (twice,) = branch.branches
    assert twice.subharmonic == 2 and twice.parameter_name == "stiffness_variation"
    assert twice.origin.startswith("period doubling of the response at stiffness_variation = ")
    again = branch.period_doubled(doubling)
    assert again.parameter[-1] == 0.5 and "Lambda" not in again.ended
    refined = branch.refine()
    assert np.nanmax(refined.correction) < 1e-3
    motion = refined.at(0.25)[0]
    assert motion.train.meshes[0].stiffness_cos == pytest.approx([0.25], rel=1e-12)
    # An orbit of the train with this value: shooting leaves it as it is.
    assert motion.refine().rms == pytest.approx(motion.rms, rel=1e-10)


def test_file_and_copy(over_torque, tmp_path):
    path = tmp_path / "branch.h5"
    over_torque.write(path)
    read = gt.read_results(path).response
    for branch in (read, pickle.loads(pickle.dumps(over_torque))):
        assert np.array_equal(branch.parameter, over_torque.parameter) and np.array_equal(branch.frequency, over_torque.frequency)
        assert (branch.parameter_name, branch.parameter_unit) == ("input_torque", "N m")
        assert [special.parameter for special in branch.special_points] == [s.parameter for s in over_torque.special_points]
        assert [jump.parameter for jump in branch.jumps] == [jump.parameter for jump in over_torque.jumps]
        assert np.array_equal(branch.half_backlash, over_torque.half_backlash)
        assert len(branch.at(0.14)) == 3


def test_dataset(over_torque):
    pytest.importorskip("xarray")
    points = over_torque.to_dataset()
    assert points.parameter.attrs["units"] == "N m" and points.attrs["parameter_name"] == "input_torque"
    assert "parameter" in points.coords and points.rms.shape == over_torque.rms.shape


def test_picture(over_torque):
    pytest.importorskip("matplotlib")
    ax = over_torque.plot(jumps=True, ranges=True)
    assert ax.get_xlabel() == "input torque  [N m]"
    assert max(np.nanmax(line.get_xdata()) for line in ax.lines if len(line.get_xdata())) == 1.0
    with pytest.raises(gt.InputError, match="goes over input_torque"):
        over_torque.plot(unit="Hz")


def test_case_file(pair, over_torque, tmp_path):
    text = pair.namelist(response={"start": 0.05, "stop": 1.0, "parameter": "input_torque", "frequency": 0.9, "harmonics": 9})
    path = tmp_path / "case.nml"
    path.write_text(text)
    found = gt.read_case(path).run().response
    assert np.array_equal(found.parameter, over_torque.parameter) and np.array_equal(found.rms, over_torque.rms)


def test_study_over_a_parameter(pair, tmp_path):
    pytest.importorskip("xarray")
    settings = {"start": 0.05, "stop": 1.0, "parameter": "input_torque", "frequency": 0.9, "harmonics": 9}
    keep = ["jumps", "special_points", "first jump up", "rms", "separation_ranges"]
    found = gt.Study(pair, gt.Space({"mesh 1 damping_ratio": [0.05, 0.055]}), response=settings, keep=keep).run(tmp_path)
    up = found["first jump up"]
    assert up.attrs["units"] == "N m" and 0.1 < up[0] and float(up[0]) in found.jump_parameter.values


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"parameter": "input_torqe"}, r'did you mean "input_torque"\?'),
        ({"parameter": ""}, "must be the name of a number"),
        ({"parameter": "mesh 1 half_backlash", "start": -1.0}, r"= -1.0: .*half_backlash = -1.0: must be >= 0 m"),
        ({"parameter": "mesh 1 order"}, "no continuous parameter"),
        ({"frequency": -1.0}, "frequency = -1.0"),
        ({"stop": 0.05}, "must differ"),
    ],
)
def test_refused(pair, changes, words):
    asked = {"parameter": "input_torque", "start": 0.05, "stop": 1.0, "frequency": 0.9, **changes}
    with pytest.raises(gt.InputError, match=words):
        pair.continuation(**asked)


def test_what_needs_a_branch_over_frequency(pair, over_torque):
    fold = next(special for special in over_torque.special_points if special.kind == "fold")
    for call in (over_torque.audit, lambda: fold.gradient(["input_torque"]),
                 lambda: pair.motions(0.9, response=over_torque)):
        with pytest.raises(gt.InputError, match="over"):
            call()
    with pytest.raises(gt.InputError, match="unit of the parameter"):
        over_torque.at(0.1, unit="Hz")


def test_a_torque_to_nothing():
    """Without errors the motion scales with the torque; at 0 it has neither multipliers nor a position in the gap."""
    pair = single_pair(0.4, stiffness_cos=[0.3])
    through = pair.continuation(parameter="input_torque", start=-0.4, stop=0.8, frequency=0.6)
    assert through.ended.count("the motion vanishes there with all that excites it") == 2
    assert (np.diff(np.unique(through.segment)) == 1).all() and not through.special_points
    to_nothing = pair.continuation(parameter="input_torque", start=0.0, stop=0.8, frequency=0.8)
    assert "reached input_torque = 0.0" in to_nothing.ended and not to_nothing.special_points
    loaded = to_nothing.parameter > 1e-6
    scaled = to_nothing.rms[loaded, 0] / to_nothing.parameter[loaded]
    assert scaled == pytest.approx(scaled[0], rel=1e-6)


@pytest.mark.parametrize("unit", [1.0, 1e6, 1e-6])
def test_special_points_under_a_torque_that_fluctuates_alone(unit):
    """Whatever the unit of frequency, in which the acceleration may be tiny: they are not taken for those of a train at rest."""
    pair = replace(single_pair(0.0, stiffness_cos=[0.6]), torque_cos=[0.9], characteristic_frequency=unit)
    branch = pair.response(start=0.3 / unit, stop=0.5 / unit, harmonics=12)
    doublings = [special.frequency * unit for special in branch.special_points if special.kind == "period doubling"]
    assert doublings[:2] == pytest.approx([0.310018, 0.402416], abs=2e-6)
    over = pair.continuation(parameter="torque_cos 1", start=0.4, stop=1.0, frequency=0.35 / unit, harmonics=12)
    plain = replace(pair, characteristic_frequency=1.0)
    same = plain.continuation(parameter="torque_cos 1", start=0.4, stop=1.0, frequency=0.35, harmonics=12)
    told = [[(special.kind, special.parameter) for special in one.special_points] for one in (over, same)]
    assert [kind for kind, _ in told[0]] == [kind for kind, _ in told[1]] and told[1]
    assert [value for _, value in told[0]] == pytest.approx([value for _, value in told[1]], abs=1e-6)


def test_the_variation_of_harmonics_that_follow():
    """From a contact ratio and a phase: the train of a value gives them, all scaled alike, and the phase with them."""
    given = single_pair(0.4, stiffness_cos=[0.3])
    pair = replace(given, meshes=[replace(given.meshes[0], stiffness_cos=None, contact_ratio=1.4, stiffness_harmonics=3, phase=0.2,
                                          error_cos=[0.1])])
    explained = pair.explain()["mesh 1"]
    own = np.hypot(explained["stiffness_cos"], explained["stiffness_sin"]).max()
    same = pair.with_values({"stiffness_variation": own})
    assert same.integrate(0.7).rms == pytest.approx(pair.integrate(0.7).rms, rel=1e-9)
    branch = pair.continuation(parameter="stiffness_variation", start=0.05, stop=0.5, frequency=0.7)
    for value in (0.1, 0.3):
        motion = branch.at(value)[0]
        assert np.hypot(motion.train.meshes[0].stiffness_cos, motion.train.meshes[0].stiffness_sin).max() == pytest.approx(value)
        assert motion.train.response(start=0.7, stop=0.71).at(0.7)[0].rms == pytest.approx(motion.rms, rel=1e-9)
    with pytest.raises(gt.InputError, match="mesh 1 follow from its drawing, contact ratio or table"):
        gt.Study(pair, gt.Space({"stiffness_variation": [0.1, 0.2]}), modes={}, keep=["natural_frequency"])


def test_the_stiffness_variation_is_an_amplitude_everywhere():
    """Of cosine and sine together: the motions of a branch over it are those of the train with that value."""
    train = single_pair(0.4, stiffness_cos=[0.3], stiffness_sin=[0.2])
    mesh = train.with_values({"stiffness_variation": 0.4}).meshes[0]
    assert np.hypot(mesh.stiffness_cos[0], mesh.stiffness_sin[0]) == pytest.approx(0.4, rel=1e-14)
    assert mesh.stiffness_sin[0] / mesh.stiffness_cos[0] == pytest.approx(2 / 3, rel=1e-14)
    branch = train.continuation(parameter="stiffness_variation", start=0.1, stop=0.4, frequency=0.3, harmonics=24)
    motion = branch.at(0.4)[0]
    assert motion.refine().rms == pytest.approx(motion.rms, rel=1e-4)
    other = train.with_values({"stiffness_variation": 0.4}).response(start=0.3, stop=0.31, harmonics=24).at(0.3)[0]
    assert other.rms == pytest.approx(motion.rms, rel=1e-6)


@pytest.mark.parametrize("harmonics", [0, 30])
def test_an_excitation_that_begins_at_nothing_is_carried(harmonics):
    """From 0 on: harmonics are planned for the train amid the path, also when their number changes on the way."""
    train = paper_train()
    first, second = train.meshes
    train = replace(train, meshes=[replace(first, order=2, stiffness_cos=[0.3]),
                                               replace(second, order=3, stiffness_cos=[0.0], error_cos=[3e-6])])
    branch = train.continuation(parameter="mesh 2 error_cos 1", start=0.0, stop=9e-6, frequency=0.2, harmonics=harmonics,
                                tolerance=1e-5)
    assert branch.complete and branch.parameter.min() == 0.0
    changed = replace(train, meshes=[train.meshes[0], replace(train.meshes[1], error_cos=[9e-6])])
    end = branch.rms[np.argmax(branch.parameter)]
    settled = changed.integrate(0.2)
    assert settled.period == 1
    np.testing.assert_allclose(end, settled.rms, rtol=1e-3)
    # The third harmonic of Lambda is the error of mesh 2, which no multiple of 2 is.
    assert np.abs(branch.coefficients[np.argmax(branch.parameter), 1, 5:7]).max() > 1e-3


@pytest.mark.parametrize(("case", "tolerance"), [("bearings", 0.1), ("fig11", 0.03)])
@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_fewer_harmonics_do_not_lead_back(case, tolerance):
    # Where the branch is steep, each change between 8 and 9 harmonics once led back to where it had been.
    results = gt.read_case(ROOT / "namelists" / f"{case}.nml")
    settings = {**results.response, "harmonics": 0, "tolerance": tolerance, "stability": False}
    branch = results.train.response(**settings)
    assert branch.complete
    assert len(branch.frequency) < 1000
