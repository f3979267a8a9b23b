"""The numbers of docs/case-studies.md, from the drawings in namelists/."""

from dataclasses import replace

import numpy as np
import pytest

import geartrain as gt
from case_studies import CASES, rattle_threshold, rigid_threshold, with_body, with_engine_torque, with_meshes

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")


def study(name):
    return gt.read_case(CASES / f"{name}.nml")


def largest(run_up, what, start=0.0, stop=np.inf):
    speed = np.interp(run_up.window_time, run_up.time, run_up.speed)
    return getattr(run_up, f"{what}_maximum")[(speed >= start) & (speed <= stop)].max(axis=0)


def apart(run_up, mesh):
    """Speeds at which the smallest force of a mesh is not positive."""
    speed = np.interp(run_up.window_time, run_up.time, run_up.speed)
    return speed[run_up.mesh_force_minimum[:, mesh - 1] <= 0]


def test_reducer_from_its_drawing():
    train = study("reducer").train
    told = train.explain()
    assert told["mesh 1"]["contact_ratio"] == pytest.approx(1.619, abs=1e-3)
    assert told["mesh 2"]["stiffness"] == pytest.approx(1.331e9, rel=1e-3)
    assert told["train"]["speed_ratio"] == pytest.approx(71 / 23)
    campbell = train.campbell(start=200, stop=4000)
    crossings = {(crossing.order.name, crossing.mode): crossing.speed for crossing in campbell.crossings}
    assert crossings["mesh 2", 1] == pytest.approx(947, abs=1)
    assert crossings["mesh 1", 3] == pytest.approx(1688, abs=1)
    assert crossings["mesh 2", 2] == pytest.approx(3097, abs=1)


def test_reducer_response():
    case = study("reducer")
    sweep = case.train.sweep(start=1676, stop=1688, points=3)
    branch = case.train.response(start=1660, stop=1690, harmonics=0, tolerance=1e-3)
    for motion in sweep:
        nearest = min(branch.at(motion.frequency), key=lambda found: abs(found.rms - motion.rms).max())
        np.testing.assert_allclose(nearest.rms, motion.rms, rtol=1e-3)
    assert [jump.kind for jump in branch.jumps] == ["jump down", "jump up"]
    np.testing.assert_allclose([jump.speed for jump in branch.jumps], [1667.4, 1673.1], atol=0.1)
    # The backlash follows from the drawing; a branch knows of it.
    np.testing.assert_allclose(branch.separation_ranges(1), [[1667.4, 1690.0]], atol=0.1)
    assert len(branch.separation_ranges(2)) == 0


def test_reducer_phase_of_the_error():
    train = study("reducer").train
    motions = [each.integrate(1500) for each in (train, with_meshes(train, error_cos=[-3e-6]))]
    np.testing.assert_allclose([motion.true_ac_rms for motion in motions], [[0.0699, 0.4159], [0.4819, 0.4322]], atol=1e-4)
    branch = train.response(start=1490, stop=1510, harmonics=0, tolerance=1e-3)
    np.testing.assert_allclose(branch.at(1500)[0].rms, motions[0].rms, rtol=1e-3)


def test_reducer_run_up():
    case = study("reducer")
    run_up = case.train.run_up(**case.run_up)
    np.testing.assert_allclose(largest(run_up, "mesh_force"), [8996, 13719], rtol=1e-3)
    np.testing.assert_allclose(largest(run_up, "shaft_torque"), [241.9, 520.6, 1422.9], rtol=2e-3)
    # The resonance of the load's shaft at 947 rpm, passed in seconds.
    assert largest(run_up, "shaft_torque", 900, 1050)[2] == pytest.approx(1377, abs=2)
    steady = case.train.response(start=940, stop=955, harmonics=0, tolerance=1e-3).shaft_torque_maximum[:, 2].max()
    assert steady == pytest.approx(1853, abs=5)


def test_rattle_threshold():
    case = study("rattle")
    speed = case.integration["start"]
    rigid = rigid_threshold(case.train, speed)
    assert rigid == pytest.approx({"loose 1": 55.2, "loose 3": 42.3}, abs=0.1)
    assert rattle_threshold(case.train, 2, speed) == pytest.approx(53.9, abs=0.2)
    assert rattle_threshold(case.train, 3, speed) == pytest.approx(41.6, abs=0.2)
    with_error = with_meshes(case.train, error_cos=[1e-6])
    assert rattle_threshold(with_error, 2, speed) == pytest.approx(27.5, abs=0.2)
    assert rattle_threshold(with_error, 3, speed) == pytest.approx(5.5, abs=0.2)
    clutch, drive = case.train.shafts
    soft = [replace(case.train, shafts=[replace(clutch, stiffness=value), drive]) for value in (300.0, 50.0)]
    assert [rigid_threshold(train, speed)["loose 3"] for train in soft] == pytest.approx([44.0, 58.0], abs=0.1)
    # The loaded pair stays in contact, the third wheel reaches its back flanks.
    motions = [with_engine_torque(case.train, amplitude).integrate(speed) for amplitude in (91.0, 94.0)]
    assert not any(motion.separation_fraction[0] > 0 for motion in motions)
    assert [motion.back_contact_fraction[2] > 0 for motion in motions] == [False, True]


@pytest.mark.parametrize(("torque", "ranges", "force"), [
    (10.0, [(1619, 2034), (5134, 6589), (11558, 15500)], 2615), (20.0, [(1780, 1886), (5668, 6013)], 1897),
    (40.0, [(1851, 1894), (5905, 5987)], 4104), (60.0, [(1894, 1920)], 5682), (65.0, [], 5809),
])
def test_electric_car(torque, ranges, force):
    case = study("electric_car")
    train = with_body(case.train, "motor", torque=torque)
    run_up = train.run_up(**case.run_up)
    # Next to the end the smallest force of 20 N m is about 0.
    speed = apart(run_up, 1)
    speed = speed[speed < 15500]
    pieces = np.split(speed, np.flatnonzero(np.diff(speed) > 500) + 1) if len(speed) else []
    np.testing.assert_allclose(np.ravel([(piece[0], piece[-1]) for piece in pieces]), np.ravel(ranges), atol=25)
    assert largest(run_up, "mesh_force")[0] == pytest.approx(force, rel=1e-2)
    apart_at = {10.0: 5058, 20.0: 15723}
    assert apart(run_up, 2)[:1] == pytest.approx([apart_at[torque]] if torque in apart_at else [], abs=25)


@pytest.mark.parametrize(("torque", "speeds"), [(10.0, (1795, 5727)), (60.0, (1862, 5939))])
def test_electric_car_resonances_move_with_the_load(torque, speeds):
    crossings = with_body(study("electric_car").train, "motor", torque=torque).campbell(start=500, stop=16000).crossings
    found = [crossing.speed for crossing in crossings if crossing.mode == 2 and crossing.order.name in ("mesh 1", "mesh 2")]
    np.testing.assert_allclose(found, speeds, atol=1)


def test_two_engines():
    case = study("two_engines")
    sweep = case.train.sweep(start=450, stop=520, points=15)
    hammers = np.array([motion.separation_fraction[1] > 0 for motion in sweep])
    np.testing.assert_array_equal(hammers, sweep.frequency >= 500)
    both = with_body(case.train, "engine 2", torque=16e3).integrate(550)
    np.testing.assert_allclose(both.mesh_force.mean(axis=0), [128848, 103079], rtol=1e-4)
    assert not both.separation_fraction.any()
