"""Derivatives with respect to parameters: shapes, differences of responses, and what is refused or has none."""

import pickle
import warnings
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, paper_train, reducer, single_pair

import geartrain as gt

NAMES = ["input_torque", "mesh 1 stiffness_cos 1", "mesh * half_backlash", "shaft 2 stiffness"]


def test_shapes(branch):
    motion = branch.at(0.9)[0]
    for figure in ("rms", "mean", "minimum", "maximum", "mesh_force_maximum", "dynamic_factor"):
        assert motion.gradient(figure, NAMES).shape == (2, 4)
    assert motion.gradient("shaft_torque_maximum", NAMES).shape == (3, 4)
    assert motion.gradient("rms", []).shape == (2, 0)
    assert branch.special_points[0].gradient(NAMES).shape == (4,)
    assert motion.train.frequency_gradient(NAMES).shape == (5, 4)


def test_scales(branch):
    """Torque and gap together scale a motion; so do all stiffnesses and inertias, at frequencies that stay."""
    motion = branch.at(0.6)[2]
    torque, gap = motion.gradient("rms", ["input_torque", "mesh * half_backlash"]).T
    np.testing.assert_allclose(150 * torque + 30e-6 * gap, motion.rms, rtol=1e-9)
    frequency = motion.train.natural_frequencies()
    stiffness = motion.train.frequency_gradient(["mesh * stiffness"]) * 1.0
    assert (stiffness >= 0).all() and stiffness.shape == (len(frequency), 1)


@pytest.mark.parametrize("figure", ["rms", "mean", "maximum", "shaft_torque_maximum"])
def test_differences_of_responses(branch, figure):
    motion = branch.at(0.9)[0]
    step = 5e-5

    def at(damping):
        train = paper_train()
        train = replace(train, meshes=[replace(train.meshes[0], damping_ratio=damping), train.meshes[1]])
        found = train.response(start=0.9, stop=0.91, harmonics=6, seed=motion, stability=False).at(0.9)
        return getattr(found[0], figure)

    expected = (at(0.05 + step) - at(0.05 - step)) / (2 * step)
    np.testing.assert_allclose(motion.gradient(figure, ["mesh 1 damping_ratio"])[:, 0], expected, rtol=1e-4)


def test_drawing():
    train = reducer()
    names = ["mesh 1 face_width", "mesh 1 stiffness", "shaft 1 diameter 1", "body wheel 1 inertia"]
    drawn = train.frequency_gradient(names)
    # Other words for the same: those of `Space` and `with_values`.
    same = ["mesh 1 face_width", "mesh 1 stiffness", "shaft 1 diameter", "wheel 1 inertia"]
    np.testing.assert_array_equal(train.frequency_gradient(same), drawn)
    for name, value in zip(names, (0.04, 1e9, 0.03, 0.01)):
        assert train.with_values({name: value}).namelist() == train.with_values({same[names.index(name)]: value}).namelist()
    changed = replace(train, meshes=[replace(train.meshes[0], face_width=0.04004), train.meshes[1]])
    expected = (changed.natural_frequencies() - train.natural_frequencies()) / 0.00004
    np.testing.assert_allclose(drawn[:, 0], expected, rtol=2e-2, atol=1e-6 * np.abs(drawn[:, 0]).max())
    assert (drawn[:, [1, 2]] >= -1e-12).all() and (drawn[:, 3] <= 1e-9).all()


def test_torques_beside_the_reaction_of_a_held_body():
    """Which is no shaft, though it is found with their torques; against differences."""
    train = gt.read_case(ROOT / "namelists" / "planetary.nml").train

    def at(inertia):
        changed = replace(train, bodies=[replace(train.bodies[0], inertia=inertia), *train.bodies[1:]])
        return changed.response(start=2190.0, stop=2210.0, harmonics=4, stability=False).at(2200.0)[0]

    step = 2e-6
    expected = (at(0.02 + step).shaft_torque_maximum - at(0.02 - step).shaft_torque_maximum) / (2 * step)
    found = at(0.02).gradient("shaft_torque_maximum", ["body motor inertia"])
    np.testing.assert_allclose(found[:, 0], expected, rtol=1e-5)


def test_a_saved_branch_keeps_them(branch):
    again = pickle.loads(pickle.dumps(branch))
    np.testing.assert_array_equal(again.special_points[3].gradient(NAMES), branch.special_points[3].gradient(NAMES))


@pytest.mark.parametrize(("parameters", "words"), [
    (["mesh 1 stifness"], 'did you mean "stiffness"'), (["mesh 3 stiffness"], "1 to 2"), (["mesh 1 order"], "no continuous"),
    (["characteristic_length"], "unit"), (["mesh 1 stiffness_cos 2"], "a list"), ("input_torque", "list of names"), ([1], "list"),
    (["body 1 inertia"], "must begin with"), (["shaft 1 damping"], "not in force"),
])
def test_refused(branch, parameters, words):
    for call in (lambda names: branch.at(0.9)[0].gradient("rms", names), branch.special_points[0].gradient,
                 branch.train.frequency_gradient):
        with pytest.raises(gt.InputError, match=words):
            call(parameters)
    for figure, told in (("rmss", "did you mean"), ("separation_fraction", "no derivatives but of rms")):
        with pytest.raises(gt.InputError, match=told):
            branch.at(0.9)[0].gradient(figure, NAMES)


def test_a_motion_made_by_hand_is_checked(branch):
    motion = branch.at(0.9)[0]
    for changed in ({"frequency": 0.0}, {"frequency": np.nan}, {"coefficients": motion.coefficients[:1]}, {"period": 0}):
        with pytest.raises(gt.InputError):
            replace(motion, **changed).gradient("rms", NAMES)


def test_no_derivative(branch):
    fold = next(special for special in branch.special_points if special.kind == "fold")
    nearest = min(branch.at(fold.frequency), key=lambda motion: abs(motion.rms - fold.rms).max())
    with pytest.warns(gt.NotDifferentiableWarning, match="fold") as told:
        assert np.isnan(nearest.gradient("rms", NAMES)).all()
    assert set(told[0].message.reasons) == set(NAMES)
    at_edges = [motion for edge in np.ravel(branch.separation_ranges(2)) for motion in branch.at(edge)]
    grazing = min(at_edges, key=lambda motion: abs(motion.minimum[1] - 1))
    with pytest.warns(gt.NotDifferentiableWarning, match="grazes"):
        assert np.isnan(grazing.gradient("rms", NAMES)).all()
    pair = single_pair(0.4, stiffness_cos=[0.3])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_allclose(pair.frequency_gradient(["mesh 1 stiffness"]), 0.5, rtol=1e-12)


def test_a_star_means_all_in_which_the_parameter_is_in_force():
    """The sum of the single ones, of given and of derived values; the others are left out."""
    train = reducer()
    for name, single in (
        ("body * inertia", [f"{body.name} inertia" for body in train.bodies]),
        ("body * torque", [f"{body.name} torque" for body in train.bodies[:-1]]),
        ("mesh * face_width", ["mesh 1 face_width", "mesh 2 face_width"]),
        ("mesh * phase", ["mesh 1 phase", "mesh 2 phase"]),
    ):
        expected = train.frequency_gradient(single).sum(axis=1)
        np.testing.assert_allclose(train.frequency_gradient([name])[:, 0], expected, rtol=1e-6, atol=1e-9 * abs(expected).max())
    stiff = replace(train, shafts=[replace(train.shafts[0], stiffness=1e5), *train.shafts[1:]])
    expected = stiff.frequency_gradient(["shaft 2 diameter", "shaft 3 diameter"]).sum(axis=1)
    np.testing.assert_allclose(stiff.frequency_gradient(["shaft * diameter"])[:, 0], expected, rtol=1e-6)


@pytest.mark.parametrize(("name", "told"), [
    ("load torque", "the torque of this body balances those of all others"),
    ("mesh 1 driving_radius", "the numbers of teeth tell the ratio of the radii"),
    ("mesh * driven_radius", "the numbers of teeth"),
    ("shaft 1 diameter", "what would follow from it is given"),
    ("shaft 1 shear_modulus", "what would follow from it is given"),
    ("mesh 1 density", "what would follow from it is given"),
    ("input_torque", "it is that of a chain; bodies have torques"),
])
def test_what_is_not_in_force_is_refused(name, told):
    train = reducer()
    names = {"pinion 1", "wheel 1"}
    train = replace(train, shafts=[replace(train.shafts[0], stiffness=1e5), *train.shafts[1:]],
                    bodies=[replace(body, inertia=1e-2) if body.name in names else body for body in train.bodies])
    with pytest.raises(gt.InputError, match=f"not in force in this train: {told}"):
        train.frequency_gradient([name])


def test_a_backlash_of_no_drawing_is_not_in_force(branch):
    for name in ("mesh 1 backlash", "mesh * backlash"):
        with pytest.raises(gt.InputError, match="not in force"):
            branch.at(0.9)[0].gradient("rms", [name])


def test_one_sided_at_the_end_of_a_range():
    """No damping; straight teeth, by quotients towards the one side that there is."""
    train = paper_train().with_values({"mesh 1 damping_ratio": 0.0})
    motion = train.response(start=0.60, stop=0.62, harmonics=8, stability=False).at(0.61)[0]

    def rms(damping):
        changed = train.with_values({"mesh 1 damping_ratio": damping})
        return changed.response(start=0.61, stop=0.62, harmonics=8, stability=False, seed=motion).at(0.61)[0].rms

    expected = (-3 * rms(0.0) + 4 * rms(1e-4) - rms(2e-4)) / 2e-4
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_allclose(motion.gradient("rms", ["mesh 1 damping_ratio"])[:, 0], expected, rtol=2e-3)
        straight = reducer().with_values({"mesh * helix_angle": 0.0})
    drawn = straight.frequency_gradient(["mesh 1 helix_angle", "mesh 1 face_width"])
    # Base radii, contact ratio and stiffness are even in the angle of straight teeth: the derivative is 0.
    assert np.isfinite(drawn).all() and (abs(drawn[:, 0]) < 1e-8 * straight.natural_frequencies()).all()


def test_units_of_frequencies():
    train = reducer()
    names = ["shaft 1 stiffness", "mesh 2 stiffness"]
    for unit in ("rpm", "Hz"):
        changed = train.with_values({"shaft 1 stiffness": 27000.0})
        ratio = changed.natural_frequencies(unit=unit) / changed.natural_frequencies()
        found, expected = train.frequency_gradient(names, unit=unit).T, ratio * train.frequency_gradient(names).T
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_jump_has_the_gradient_of_its_special_point(branch):
    for jump in branch.jumps:
        assert jump.special_point.frequency == jump.frequency and jump.special_point.kind == jump.cause
        if jump.cause == "fold":
            np.testing.assert_array_equal(jump.gradient(NAMES), jump.special_point.gradient(NAMES))
    with pytest.raises(gt.SolverError, match="no derivatives"):
        replace(branch.jumps[0], special_point=None).gradient(NAMES)


def test_a_warning_says_each_reason_once():
    told = gt.NotDifferentiableWarning({"a": "it is so", "b": "it is so", "c": "it is not"})
    assert str(told) == "No derivative with respect to a, b: it is so. No derivative with respect to c: it is not."
    assert str(pickle.loads(pickle.dumps(told))) == str(told)
