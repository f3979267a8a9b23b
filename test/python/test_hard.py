"""Undecided verdicts and motions that never repeat, as Python sees them."""

import math
import pickle

import numpy as np
import pytest
from conftest import ROOT

import geartrain as gt

CASE = ROOT / "namelists" / "fig03.nml"


def pair(damping_ratio, kappa):
    """x'' + 2 zeta x' + (1 + kappa cos Lambda t) g(x) = 1 with b = 1."""
    mesh = gt.Mesh(
        driving_radius=1.0, driven_radius=1.0, driving_inertia=2.0, driven_inertia=2.0, stiffness=1.0,
        damping_ratio=damping_ratio, half_backlash=1.0, stiffness_cos=[kappa],
    )
    return gt.Train(
        input_torque=1.0, prime_mover_inertia=0.0, load_inertia=0.0, characteristic_length=1.0, characteristic_frequency=1.0,
        shafts=[gt.Shaft(rigid=True), gt.Shaft(rigid=True)], meshes=[mesh],
    )


def test_chaos_has_an_exponent_and_no_period():
    motion = pair(0.05, 0.6).integrate(frequency=1.9, max_periods=1000)
    assert motion.period == 0
    # 0.0275 over 20000 mesh periods, by a tangent and by the distance of two motions (test/hard_motions.f90).
    assert motion.lyapunov_exponent == pytest.approx(0.0275, abs=2e-3)
    assert pickle.loads(pickle.dumps(motion)).lyapunov_exponent == motion.lyapunov_exponent


def test_periodic_motion_has_no_exponent():
    assert math.isnan(pair(0.05, 0.1).integrate(frequency=0.4).lyapunov_exponent)


def test_folds_are_undecided():
    branch = gt.read_case(CASE).train.response(start=0.4, stop=0.8, harmonics=6)
    assert branch.undecided.dtype == bool and branch.undecided.shape == branch.frequency.shape
    folds = [special.point for special in branch.special_points if special.kind == "fold"]
    assert len(folds) >= 6
    assert branch.undecided[folds].all()
    assert 0 < branch.undecided.sum() < 0.1 * len(branch)
    near = abs(abs(branch.multipliers).max(axis=1) - 1) < 0.1
    assert near[np.isfinite(branch.second_estimate)].all()
    assert any(motion.undecided for motion in branch.at(float(branch.frequency[folds[0]])))
