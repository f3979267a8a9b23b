"""Undecided verdicts and motions that never repeat, as Python sees them."""

import math
import pickle
from dataclasses import replace

import h5py
import numpy as np
import pytest
from conftest import ROOT, paper_train, run, single_pair

import geartrain as gt

CASE = ROOT / "namelists" / "fig03.nml"


def test_chaos_has_an_exponent_and_no_period():
    motion = single_pair(1.0, stiffness_cos=[0.6]).integrate(frequency=1.9, max_periods=1000)
    assert motion.period == 0
    # 0.0275 over 20000 periods of the fundamental, by a tangent and by the distance of two motions (test/hard_motions.f90).
    assert motion.lyapunov_exponent == pytest.approx(0.0275, abs=max(2e-3, motion.lyapunov_error))
    assert motion.kind == "chaotic" and 0 < motion.lyapunov_error < motion.lyapunov_exponent
    again = pickle.loads(pickle.dumps(motion))
    assert (again.lyapunov_exponent, again.lyapunov_error, again.kind) == (
        motion.lyapunov_exponent, motion.lyapunov_error, motion.kind,
    )


def test_exponent_of_a_periodic_motion_is_that_of_its_largest_multiplier():
    motion = single_pair(1.0, stiffness_cos=[0.1]).integrate(frequency=0.4, stability=True)
    rate = math.log(abs(motion.multipliers).max()) * 0.4 / (2 * math.pi)
    assert motion.kind == "periodic" and motion.lyapunov_exponent == pytest.approx(rate, rel=1e-12)
    assert motion.error_estimate < 1e-10


def test_folds_are_undecided():
    branch = gt.read_case(CASE).train.response(start=0.4, stop=0.8, harmonics=6)
    assert branch.undecided.dtype == bool and branch.undecided.shape == branch.frequency.shape
    folds = [special.point for special in branch.special_points if special.kind == "fold"]
    assert len(folds) >= 6
    assert branch.undecided[folds].all()
    margin = abs(abs(branch.multipliers).max(axis=1) - 1)
    near = margin < 0.1
    near[folds] = False
    # Beyond 0.1 of the unit circle a verdict is open where the motion itself is doubtful, and nowhere else on this branch.
    assert 0 < (branch.undecided & near).sum() < 0.1 * len(branch)
    assert (branch.undecided[~near] == branch.estimate_doubtful[~near]).all()
    second = np.isfinite(branch.second_estimate)
    assert 0 < second.sum() < 0.35 * len(branch) and not second[branch.estimate_doubtful].any()
    # Decided where the margin is twice what the two estimates differ by.
    differ = abs(branch.second_estimate - abs(branch.multipliers).max(axis=1))
    assert (branch.undecided[second] == (2 * differ >= margin)[second]).all()
    assert (branch.count_undecided | ~branch.undecided).all()
    assert any(motion.undecided for motion in branch.at(float(branch.frequency[folds[0]])))


def test_a_train_without_torque_floats():
    """Its mean position is not unique: a start elsewhere in the gap stays there."""
    train = single_pair(0.0, error_cos=[0.1])
    here, there = (train.integrate(frequency=0.9, start=[start, 0.0]) for start in (0.3, -0.4))
    assert here.floating and there.floating and "floating=True" in repr(here)
    assert here.period == there.period == 1
    assert here.mean - there.mean == pytest.approx(0.7, abs=1e-9)
    assert here.rms == pytest.approx(there.rms, abs=1e-9)
    assert pickle.loads(pickle.dumps(here)).floating
    told = "floats in its gaps, where its mean position is not unique"
    assert told in train.sweep(start=0.8, stop=0.9, points=2).ended
    assert told in train.attractors(frequency=0.9, starts=3).ended
    loaded = replace(train, input_torque=1.0)
    assert not loaded.integrate(frequency=0.4).floating
    assert loaded.sweep(start=0.4, stop=0.45, points=2).ended == "all points done"


def test_what_floats_is_said_in_the_file(tmp_path, executable):
    case, output = tmp_path / "floating.nml", tmp_path / "floating.h5"
    case.write_text(
        paper_train(input_torque=0.0).namelist(integration={"start": 0.9, "stop": 1.0, "points": 2}, attractors={
            "frequency": 0.9, "starts": 2}))
    done = run(executable, case, "--output", output)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("floats in its gaps, where its mean position is not unique") == 2
    results = gt.read_case(case).run()
    results.write(tmp_path / "python.h5")
    for path in (output, tmp_path / "python.h5"):
        with h5py.File(path) as file:
            for group in ("integration", "attractors"):
                assert "floats in its gaps" in file[group].attrs["ended"]
                assert file[group]["floating"][:].all()


@pytest.mark.full
def test_a_slow_vibration_between_two_motions(times):
    # The vibration is larger than the distance of the two motions. Integration must name the motion that a long flight reaches.
    train = gt.Train(
        characteristic_length=3e-5, characteristic_frequency=1e4,
        bodies=[gt.Body(name="motor", inertia=3.45e-3, torque=93.85), gt.Body(name="fan", inertia=5.82e-3, torque=-15.7),
                gt.Body(name="disc", inertia=3.6e-3), gt.Body(name="load", inertia=9.02e-3, balances=True)],
        shafts=[gt.Shaft(between=("motor", "disc"), stiffness=15585, damping_ratio=0.0129),
                gt.Shaft(between=("disc", "load"), stiffness=965634, damping_ratio=0.0414)],
        meshes=[gt.Mesh(between=("motor", "fan"), driving_radius=0.06813, driven_radius=0.05783, stiffness=1.8643e8,
                        damping_ratio=0.05573, half_backlash=33.67e-6, order=3, phase=4.837, stiffness_cos=[0.27065, 0.06392],
                        error_cos=[-2.694e-7], error_sin=[0, 7.3e-7])])
    frequency, random = 0.54662, np.random.default_rng(1)
    goal = train.attractors(frequency, starts=6, max_periods=3000)[0].state
    reached = set()
    for _ in range(times(24, share=2)):
        start = goal + random.choice([1, 3]) * random.normal(size=6) * [1, 0.1, 0.1, 0.3, 0.3, 0.3]
        whole = train.integrate(frequency, start=start, max_periods=1, tolerance=1e-20).trajectory(3000, samples=4).section
        motion = train.integrate(frequency, start=start)
        np.testing.assert_allclose(motion.trajectory(1, samples=4).section[0][0], whole[0][-1], atol=1e-3)
        reached.add(round(motion.rms[0], 3))
    assert len(reached) == 2
