"""Bearings whose clearance is nearly round: flats."""

import numpy as np
import pytest
from bearing_model import LENGTH, compare, pair
from scipy.optimize import brentq

import geartrain as gt

ROUND = {"stiffness": [2e8, 2e8], "damping": [600.0, 600.0], "half_clearance": 8e-6}


@pytest.mark.full
def test_flats():
    """Twelve and eight flats: six springs round the pinion, four round the wheel, by shooting and by equations of their own."""
    train = pair(half_backlash=2e-5, stiffness_cos=[0.25], pinion={**ROUND, "flats": 12}, wheel={**ROUND, "flats": 8})
    assert train.mesh_elements[5:] == ("bearing 1 30", "bearing 1 60", "bearing 1 120", "bearing 1 150", "bearing 2 45",
                                       "bearing 2 135")
    assert train.mesh_labels[5:7] == ("pinion bearing 30", "pinion bearing 60")
    motion = train.integrate(frequency=0.6).refine()
    compare(train, motion)
    force = motion.bearing_force
    assert force.mean(0) == pytest.approx(motion.bearing_force_mean, rel=1e-4, abs=1.0)
    assert len(motion.state) == 2 * (1 + 4)


@pytest.mark.parametrize("flats", [8, 12, 16, 24])
def test_round_clearance(flats):
    """At rest in a ring of springs without number, F = 2 k/pi (r a - c sin a) with cos(a) = c/r, from which flats are off.

    The springs are a trapezoidal rule in the angle, of a function with a kink: the error falls with the square of their number.
    """
    clearance, stiffness = 8e-6, 2e8
    train = pair(pinion={**ROUND, "flats": flats})
    told = train.explain()["bearing 1"]
    assert told["corner_clearance"] == pytest.approx(clearance / np.cos(np.pi / flats), rel=1e-12)
    force = np.hypot(*told["mean_force"])
    assert told["mean_force"] == pytest.approx(pair().explain()["bearing 1"]["mean_force"], rel=1e-9)

    def ring(r):
        angle = np.arccos(clearance / r)
        return 2 * stiffness / np.pi * (r * angle - clearance * np.sin(angle)) - force

    wanted = brentq(ring, clearance, 10 * clearance + force / stiffness)
    rest = train.integrate(frequency=0.5).mean[1:3] * LENGTH
    assert np.hypot(*rest) == pytest.approx(wanted, rel=2.0 / flats**2)
    assert rest / np.hypot(*rest) == pytest.approx(told["mean_force"] / force, abs=4.0 / flats**2)


def test_parameters_of_flats():
    """The clearance moves all springs of a ring; a stiffness is that of both directions, and no parameter of its own."""
    def moved(**given):
        train = pair(stiffness_cos=[0.25], pinion={**ROUND, "flats": 12, **given})
        return train.response(start=0.6, stop=0.601, harmonics=12).at(0.6)[0]

    motion, change = moved(), 1e-9
    found = motion.gradient("mean", ["bearing 1 half_clearance", "bearing 1 mass"])
    wanted = (moved(half_clearance=8e-6 + change).mean - moved(half_clearance=8e-6 - change).mean) / (2 * change)
    assert np.abs(wanted[1:3]).min() > 0.3 / LENGTH
    assert found[:, 0] == pytest.approx(wanted, rel=1e-4, abs=1e-4 / LENGTH)
    with pytest.raises(gt.InputError, match="with more than four flats it is the same in x and y"):
        motion.gradient("mean", ["bearing 1 stiffness 1"])


def test_turned_flats():
    """A plane turned by the angle between two flats changes nothing but the directions of the forces."""
    given = {"half_backlash": 2e-5, "stiffness_cos": [0.2]}
    supports = {"pinion": {**ROUND, "flats": 8}, "wheel": {**ROUND, "half_clearance": 0.0}}
    one, other = (pair(**given, **supports, line_of_action=line).response(start=0.7, stop=0.7001, harmonics=10).at(0.7)[0]
                  for line in (30.0, 75.0))
    assert other.rms[0] == pytest.approx(one.rms[0], rel=1e-9)
    turn = np.sqrt(0.5) * np.array([[1.0, 1.0], [-1.0, 1.0]])
    assert other.bearing_force_mean == pytest.approx(one.bearing_force_mean @ turn, rel=1e-9)


@pytest.mark.full
def test_basins_of_flats():
    """Each start reaches the motion that time integration from rest does; a spring of the ring follows from the others."""
    train = pair(half_backlash=2e-5, stiffness_cos=[0.25], pinion={**ROUND, "flats": 8})
    basins = train.basins(0.6, mesh=1, points=(2, 2))
    assert basins.complete and not basins.unsettled and not basins.unbounded
    motion = train.integrate(frequency=0.6)
    for found in basins.motions:
        assert found.rms == pytest.approx(motion.rms, rel=1e-6)
    with pytest.raises(gt.InputError, match="this one closes a loop"):
        train.basins(0.6, mesh=6, points=(2, 2))
