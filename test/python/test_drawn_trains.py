"""Trains given by their drawing in the analyses that vary a parameter: computed, and as a train with the changed drawing."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, reducer

import geartrain as gt

COARSE = {"start": 1500.0, "stop": 1504.0, "unit": "rpm", "points": 2, "parameter_points": 2}
RANGES = {"mesh_damping_ratio": (0.02, 0.06), "stiffness_variation": (0.0, 0.1), "half_backlash": (1e-6, 4e-5)}


def ringed(**ring):
    """A pinion in a ring, on a distance that gives its backlash, between a motor with a torque of its revolution and a load."""
    bodies = [gt.Body(name="motor", inertia=1e-3, torque=20.0, revolution_torque_cos=[0.0, 2.0]), gt.Body(name="pinion"),
              gt.Body(name="ring", **ring), gt.Body(name="load", inertia=0.05, balances=True)]
    shafts = [gt.Shaft(between=("motor", "pinion"), diameter=[0.015], length=[0.05], damping_ratio=0.02),
              gt.Shaft(between=("ring", "load"), diameter=[0.02], length=[0.05], damping_ratio=0.02)]
    mesh = gt.Mesh(between=("pinion", "ring"), internal=True, teeth=(20, 62), normal_module=2e-3, face_width=0.02,
                   centre_distance=41.9e-3, bore=(0.01, 0.0), damping_ratio=0.05, error_cos=[2e-6])
    return gt.Train(bodies=bodies, shafts=shafts, meshes=[mesh])


def disc():
    return {"outer_diameter": [0.16], "bore": [0.126], "width": [0.02]}


@pytest.mark.parametrize("train", [reducer(), ringed(**disc())], ids=["reducer", "ring"])
@pytest.mark.parametrize("parameter", ["mesh_damping_ratio", "stiffness_variation"])
def test_linear_map_of_a_drawn_train(train, parameter):
    low, high = RANGES[parameter]
    chart = train.stability_map(**COARSE, parameter=parameter, parameter_start=low, parameter_stop=high, linear=True)
    assert chart.complete
    # A smaller damping or a larger variation: the drawing does not win over the value of the row.
    assert (chart.spectral_radius[0] != chart.spectral_radius[1]).all()


def test_rows_are_those_of_the_changed_train():
    """The multipliers of a row are those of the response of the train with the value of the row."""
    train = ringed(**disc())
    for parameter, value, changed in (
        ("mesh_damping_ratio", 0.03, {"damping_ratio": 0.03}),
        ("half_backlash", 2e-5, {"half_backlash": 2e-5}),
    ):
        chart = train.stability_map(**{**COARSE, "parameter_points": 1}, parameter=parameter, parameter_start=value,
                                    parameter_stop=value, harmonics=0)
        other = replace(train, meshes=[replace(train.meshes[0], **changed)])
        branch = other.response(start=1500.0, stop=1504.0, unit="rpm", harmonics=0, multipliers=True)
        for k, frequency in enumerate(chart.frequency):
            motion, = branch.at(frequency)
            assert chart.motions[0, k] == 1
            assert chart.spectral_radius[0, k] == pytest.approx(abs(motion.multipliers).max(), rel=1e-6)
            assert chart.rms[0, k] == pytest.approx(motion.rms, rel=1e-3)


@pytest.mark.parametrize("parameter, value", [
    ("motor torque", 70.0), ("body load inertia", 2.0), ("shaft 1 stiffness", 3e4), ("shaft 2 diameter", 0.038),
    ("mesh 1 backlash", 2e-5), ("mesh * damping_ratio", 0.03),
])
def test_a_map_over_any_number_of_a_drawing(parameter, value):
    """A node of the map is the motion of the train that has the value from the beginning."""
    train = reducer()
    chart = train.stability_map(**{**COARSE, "parameter_points": 1}, parameter=parameter, parameter_start=value,
                                parameter_stop=value, harmonics=0)
    branch = train.with_values({parameter: value}).response(start=1500.0, stop=1504.0, unit="rpm", harmonics=0, multipliers=True)
    assert chart.name == parameter and chart.motions.tolist() == [[1, 1]]
    for k, frequency in enumerate(chart.frequency):
        motion, = branch.at(frequency)
        assert chart.multiplier[0, k] == pytest.approx(motion.multipliers[0], rel=1e-6)
        assert chart.rms[0, k] == pytest.approx(motion.rms, rel=1e-3)
    linear = train.stability_map(**COARSE, parameter="shaft 1 stiffness", parameter_start=1e4, parameter_stop=3e4, linear=True)
    assert linear.unit == "N m/rad" and (linear.spectral_radius[0] > linear.spectral_radius[1]).all()


def test_maps_in_a_case_file_are_those_of_python(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = {**COARSE, "parameter": "motor torque", "parameter_start": 60.0, "parameter_stop": 90.0, "harmonics": 0}
    (tmp_path / "map.nml").write_text(reducer().namelist(stability_map=settings))
    of_case, own = gt.read_case("map.nml").run().stability_map, reducer().stability_map(**settings)
    assert (of_case.multiplier == own.multiplier).all() and (of_case.name, of_case.unit) == ("motor torque", "N m")
    assert own.plot().get_ylabel() == "motor torque  [N m]"


@pytest.mark.parametrize("parameter, linear, words", [
    ("input_torque", False, 'that of a chain; bodies have torques, as in "motor torque"'),
    ("load torque", False, "the torque of this body balances those of all others"),
    ("mesh 1 half_backlash", False, "contradicts half_backlash"),
    ("mesh * backlash", True, "has no influence on the stability of the linear train"),
    ("", False, "must be given, as in 'stiffness_variation'"),
])
def test_maps_that_are_refused(parameter, linear, words):
    with pytest.raises(gt.InputError, match=words):
        reducer().stability_map(**COARSE, parameter=parameter, parameter_start=1e-6, parameter_stop=2e-6, linear=linear,
                                harmonics=0)


def test_the_reducer_of_the_readme():
    train = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    chart = train.stability_map(**COARSE, parameter="half_backlash", parameter_start=1e-6, parameter_stop=4e-5, harmonics=0,
                                tolerance=1e-2)
    assert chart.complete and (chart.stable_motions > 0).all()


def test_the_default_harmonics_name_the_cure():
    with pytest.raises(gt.InputError, match=r"harmonics = 6: must be >= 71: .*; 0 chooses those that matter"):
        reducer().stability_map(**COARSE, parameter="half_backlash", parameter_start=1e-6, parameter_stop=4e-5)


@pytest.mark.parametrize("parameter, low, high", [
    ("mesh 1 face_width", 0.038, 0.040), ("shaft 1 diameter", 0.029, 0.030),
    pytest.param("mesh 2 backlash", 5e-5, 6e-5, marks=pytest.mark.nightly),
    ("mesh 1 helix_angle", 14.5, 15.0), ("mesh * damping_ratio", 0.04, 0.05), ("body motor torque", 80.0, 90.0),
    ("stiffness_variation", 0.05, 0.1),
])
def test_response_over_a_parameter_of_a_drawing(parameter, low, high):
    branch = reducer().response(parameter=parameter, start=low, stop=high, frequency=1500.0, unit="rpm", harmonics=0,
                                tolerance=1e-2, stability=False)
    assert branch.complete
    assert np.isfinite(branch.rms).all()


def test_a_problem_that_comes_with_a_value_is_one_line():
    """The value contradicts the backlash of the drawing at both ends of the range; no escaped line break stands in the message."""
    with pytest.raises(gt.InputError) as caught:
        reducer().response(parameter="mesh 1 half_backlash", start=1e-6, stop=6e-5, frequency=1500.0, unit="rpm")
    assert "\\x0a" not in str(caught.value)
    assert "backlash = 6.0e-5: contradicts half_backlash" in str(caught.value)


def test_an_internal_gear_without_inertia_is_named():
    with pytest.raises(gt.InputError) as caught:
        ringed().natural_frequencies()
    assert "lacks inertia (> 0 kg m^2) or outer_diameter, bore and width of 'ring'" in str(caught.value)


@pytest.mark.parametrize("teeth, internal, shifts, sign", [((20, 30), False, (-0.6, -0.6), ">"), ((20, 62), True, (0.9, 0.6), "<")])
def test_shifts_without_a_centre_distance(teeth, internal, shifts, sign):
    """Nothing is said of a centre distance that was not given."""
    mesh = replace(reducer().meshes[0], teeth=teeth, internal=internal, profile_shift=shifts, helix_angle=0.0)
    with pytest.raises(gt.InputError) as caught:
        reducer(meshes=[mesh, reducer().meshes[1]])
    assert "centre_distance = 0.0" not in str(caught.value)
    assert f"profile_shift = {shifts[0]}, {shifts[1]}: must have a sum {sign} " in str(caught.value)
