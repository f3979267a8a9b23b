"""A car's driveline from published numbers: modes as published, motions by the published equations in SciPy."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geartrain as gt

#: M. Best's four-mass model of a Ford Mondeo V6 (github.com/bamason2/ttc066-module: coursework/files/Init4.m, drive4.slx) as it is
#: there, referred to the wheels.
RATIO, RADIUS = 2.13 * 3.8, 0.2945
INERTIA = np.array([0.2095 * RATIO**2, 0.0063 * RATIO**2 + 5.1e-3, 1.8176, 1400 * RADIUS**2])
ANGLE, TORQUE = np.array([-0.471, -0.035, 0.0, 0.113, 0.471]) / RATIO, np.array([-175.9, -1.1025, 0.0, 3.5595, 280.3]) * RATIO
DRIVELINE, DRIVELINE_DAMPING, LASH, CREEP = 7200.0, 5.0, np.radians(3.0), 80000.0
#: notes/figures/eigenvector_and_value_table.png of the same source. The speed of the car, which the tyres' damping follows from, is
#: not printed there: by the first eigenvalue it is 4.956 m/s.
CREEPING, OSCILLATING = -779.5, (-2.40 + 22.26j, -86.9 + 366.4j)
SPEED = 4.956


@pytest.fixture(scope="module")
def train():
    return gt.read_case(Path(__file__).resolve().parents[2] / "namelists" / "front_wheel_drive.nml").train


def torques(theta, rate):
    """Of clutch and driveline: table and dead band, whose ends go on."""
    twist = theta[0] - theta[1]
    slope = np.diff(TORQUE) / np.diff(ANGLE)
    part = np.clip(np.searchsorted(ANGLE, twist) - 1, 0, len(slope) - 1)
    clutch = TORQUE[part] + slope[part] * (twist - ANGLE[part]) + RATIO**2 * (rate[0] - rate[1])
    twist = theta[1] - theta[2]
    open_by = np.sign(twist) * max(abs(twist) - LASH / 2, 0.0)
    return clutch, DRIVELINE * open_by + DRIVELINE_DAMPING * (rate[1] - rate[2])


def equations(t, z, mean, swing, omega):
    theta, rate = z[:4], z[4:]
    clutch, driveline = torques(theta, rate)
    tyre = CREEP * RADIUS**2 / SPEED * (rate[2] - rate[3])
    engine = RATIO * (mean + swing * np.cos(3 * omega * t))
    return np.concatenate([rate, np.array([engine - clutch, clutch - driveline, driveline - tyre, tyre - RATIO * mean]) / INERTIA])


def test_the_equations_have_the_published_eigenvalues():
    """What is written out above is the published model: its linear system with the clutch in its stage of drive."""
    rest = np.array([0.3 / RATIO + 2 * LASH, 2 * LASH, 0.0, 0.0])
    point, unit = np.concatenate([rest, np.zeros(4)]), 1e-3
    matrix = np.array([equations(0.0, point + column, 0.0, 0.0, 0.0) - equations(0.0, point, 0.0, 0.0, 0.0)
                       for column in unit * np.eye(8)]).T / unit
    found = np.linalg.eigvals(matrix)
    assert found.real.min() == pytest.approx(CREEPING, abs=0.05)
    for value, digits in zip(OSCILLATING, (0.005, 0.05), strict=True):
        there = found[np.abs(found - value).argmin()]
        assert there.real == pytest.approx(value.real, abs=digits)
        assert there.imag == pytest.approx(value.imag, abs=digits)


def test_published_modes(train):
    """Shuffle and rattle of the car at 5 N m, where the clutch is in its stage of drive and the lash is closed."""
    assert repr(train) == "<Train 'front wheel drive with clutch and lash': 4 bodies, 1 shaft, 2 couplings>"
    modes = train.modes()
    damped = modes.damped_frequency * 2 * np.pi * modes.natural_frequency_hertz / modes.natural_frequency
    for value, digits in zip(OSCILLATING, (0.005, 0.05), strict=True):
        number = np.abs(damped - value.imag).argmin()
        ratio = modes.damping_ratio[number]
        assert damped[number] == pytest.approx(value.imag, abs=digits)
        assert -damped[number] * ratio / np.sqrt(1 - ratio**2) == pytest.approx(value.real, abs=digits)


@pytest.mark.full
@pytest.mark.parametrize("speed", [330.0, 820.0, 1150.0])
def test_motions(train, speed):
    """Torques of clutch and lash over a turn of the engine after 5 s, by when shuffle has decayed to 6e-6."""
    engine = train.bodies[0]
    mean, swing = engine.torque, engine.revolution_torque_cos[2]
    omega = speed * np.pi / 30
    # At rest under the mean torque.
    lash = LASH / 2 + mean * RATIO / DRIVELINE
    clutch = np.interp(mean * RATIO, TORQUE, ANGLE)
    start = np.array([clutch + lash, lash, 0.0, 0.0, 0.0, 0.0, 0.0, -mean * RATIO * SPEED / (CREEP * RADIUS**2)])
    turn = 2 * np.pi / omega
    last = np.ceil(5 / turn) * turn + np.linspace(0, turn, 60001)
    found = solve_ivp(equations, (0, last[-1]), start, "DOP853", last, rtol=1e-9, atol=1e-11, args=(mean, swing, omega),
                      max_step=turn / 20)
    expected = np.array([torques(z[:4], z[4:]) for z in found.y.T]) / RATIO
    motion = train.integrate(speed, unit="rpm")
    # The spring of 1e-5 of the driveline's stiffness; the torque of the clutch is least at a kink, between samples.
    for name in ("minimum", "maximum"):
        values = getattr(motion, f"coupling_torque_{name}")
        assert values == pytest.approx(getattr(expected, name[:3])(axis=0), abs=1e-4 * np.ptp(expected))


def test_largest_torques_of_a_response(train):
    """By the law of each coupling: the harmonics that the balance carries would be off by 0.9 % at the corner of the clutch."""
    branch = train.response(start=900.0, stop=800.0, harmonics=0, tolerance=1e-3)
    np.testing.assert_allclose(branch.coupling_torque_maximum, branch.mesh_force_maximum, rtol=1e-12)
    motion = branch.at(820.0)[0]
    exact = motion.refine()
    span = (exact.coupling_torque_maximum - exact.coupling_torque_minimum).min()
    for name in ("minimum", "maximum"):
        values = getattr(exact, f"coupling_torque_{name}")
        assert getattr(motion, f"coupling_torque_{name}") == pytest.approx(values, abs=2e-3 * span)
