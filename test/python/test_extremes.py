"""Extremes and means of a motion against a great many samples of it: forces have kinks and jumps at contact events."""

import bearing_model
import coupling_model
import numpy as np
import pytest

import geartrain as gt

SAMPLES = 100_000


def compare(found, samples):
    """No sample lies beyond an extreme; an extreme exceeds the samples by no more than the signal moves between two of them."""
    apart = np.abs(np.diff(samples, axis=0)).max(0)
    rounding = 1e-9 * np.abs(samples).max()
    for extreme, inside in ((found[0], -samples.min(0)), (found[1], samples.max(0))):
        assert (extreme >= inside - rounding).all()
        assert (extreme <= inside + apart + rounding).all()


@pytest.mark.parametrize("model", [coupling_model, bearing_model])
def test_random_trains(model, times):
    compared = 0
    for seed in range(times(40, 8)):
        train = model.random_train(seed)
        motion = train.integrate(frequency=0.3 + 0.05 * (seed % 11))
        if motion.period != 1:
            continue
        compared += 1
        path = motion.trajectory(1, samples=SAMPLES)
        compare((-motion.minimum, motion.maximum), path.displacement)
        pairs = len(train.meshes)
        couplings = path.mesh_force[:, pairs:pairs + len(train.couplings)]
        if len(train.couplings):
            compare((-motion.coupling_torque_minimum, motion.coupling_torque_maximum), couplings)
            scale = np.abs(couplings).max(0)
            assert (np.abs(motion.coupling_torque_mean - couplings.mean(0)) < 1e-6 * scale).all()
    assert compared > times(40, 8) / 3


def test_mean_of_a_rigid_shaft():
    """Its mean torque is what the load takes, though the teeth strike: damping acts from contact on, so that the torque jumps."""
    bodies = [gt.Body(name="motor", inertia=0.01, torque=100.0), gt.Body(name="pinion", inertia=0.002),
              gt.Body(name="wheel", inertia=0.02, balances=True)]
    mesh = gt.Mesh(between=("pinion", "wheel"), driving_radius=0.05, driven_radius=0.1, stiffness=2e8, stiffness_cos=[0.3],
                   damping=1500.0, half_backlash=2e-5)
    train = gt.Train(characteristic_length=2e-5, characteristic_frequency=1e4, bodies=bodies, meshes=[mesh],
                     shafts=[gt.Shaft(between=("motor", "pinion"), rigid=True)])
    apart = 0.0
    branch = train.response(start=0.7, stop=1.5, harmonics=24)
    for motion in [each for frequency in (0.8, 0.9, 1.0, 1.1, 1.3) for each in branch.at(frequency)]:
        exact = motion.refine()
        apart = max(apart, exact.separation_fraction[0])
        force = exact.mesh_force_maximum[0]
        # The motor is accelerated by what the torque lacks: shaft = torque - share of the motor in (torque - force r).
        share = 0.01 / 0.012
        assert exact.shaft_torque_mean[0] == pytest.approx(100.0 - share * (100.0 - 0.05 * 2000.0), rel=1e-11)
        assert exact.shaft_torque_maximum[0] == pytest.approx(100.0 - share * (100.0 - 0.05 * force), rel=1e-12)
    assert apart > 0.1
