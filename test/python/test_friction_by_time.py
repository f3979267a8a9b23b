"""Motions with dry friction that settle for a number of time constants: windows, and trains with hunting teeth."""

from dataclasses import replace

import numpy as np
import pytest
from test_friction import clutch, driveline

import geartrain as gt


@pytest.mark.parametrize(("friction", "frequency"), [(6.0, 0.2), (6.0, 0.54), (0.5, 0.2)])
def test_window(friction, frequency):
    """A periodic motion: its window has the rms and maximum of the exact orbit, to the ringing that the result reports."""
    train = clutch(friction)
    whole, window = train.integrate(frequency=frequency), train.integrate(frequency=frequency, window=20)
    assert whole.kind == "periodic" and window.kind == "stationary"
    assert (np.abs(window.rms - whole.rms) <= window.ringing * whole.rms + 1e-12).all()
    assert (np.abs(window.maximum - whole.maximum) <= window.ringing * np.ptp(whole.displacement, axis=0) + 1e-12).all()


def hunting_driveline():
    """Two stages whose common period is 41 turns of the engine, with an idle gear, behind a clutch with dry friction."""
    given = driveline()
    gears = {"between": [("input", "counter"), ("counter", "output"), ("counter", "idle")], "teeth": [(23, 41), (29, 37), (31, 35)]}
    return gt.Train(
        bodies=[gt.Body(name="engine", inertia=0.15, torque=40.0, revolution_torque_cos=[0.0, 60.0]), given.bodies[1],
                gt.Body(name="counter", inertia=3e-3), gt.Body(name="output", inertia=2e-3),
                gt.Body(name="idle", inertia=1e-3, torque=-0.2), gt.Body(name="car", inertia=0.8, balances=True)],
        shafts=[gt.Shaft(between=("output", "car"), stiffness=2e4, damping_ratio=0.05)],
        couplings=[replace(given.couplings[0], friction_torque=8.0)],
        meshes=[replace(given.meshes[0], between=between, teeth=teeth) for between, teeth in zip(*gears.values())])


@pytest.mark.full
def test_hunting_teeth_and_friction():
    """The same motion from rest and from another state, where a run-up begins as well."""
    train = hunting_driveline()
    motion = train.integrate(frequency=900.0)
    assert motion.kind == "stationary" and motion.ringing < 1e-6 and motion.coupling_energy_loss[0] > 10
    state = motion.state.copy()
    state[:4] *= 1.05
    other = train.integrate(frequency=900.0, start=list(state))
    assert other.rms == pytest.approx(motion.rms, rel=1e-6)
    assert (other.force_uncertainty < 0.01 * other.mesh_force_maximum)[:2].all()
    held = train.run_up(start=900.0, stop=900.0, unit="rpm", duration=0.5)
    assert held.complete and "steady" not in held.ended and held.start_ringing < 1e-6
    assert (held.mesh_force_maximum.max(axis=0) <= motion.mesh_force_maximum + motion.force_uncertainty).all()
