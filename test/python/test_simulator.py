"""A train under torques from outside: against run-ups, and against SciPy with angles of the bodies themselves."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geartrain as gt

MOTOR, PINION, WHEEL = 0.02, 0.004, 0.3  # kg m^2
STIFFNESS, DAMPING, MESH, MESH_DAMPING, GAP = 4e3, 2.0, 2e8, 2e3, 40e-6
RADIUS, TEETH = (0.03, 0.09), (20, 60)


def pair(drag=0.0, **more):
    return gt.Train(
        characteristic_length=1e-4, characteristic_frequency=1e4,
        bodies=[gt.Body(name="motor", inertia=MOTOR, torque=60.0), gt.Body(name="pinion", inertia=PINION),
                gt.Body(name="wheel", inertia=WHEEL, balances=True, damping_to_ground=drag)],
        shafts=[gt.Shaft(between=["motor", "pinion"], stiffness=STIFFNESS, damping=DAMPING)],
        meshes=[gt.Mesh(between=["pinion", "wheel"], driving_radius=RADIUS[0], driven_radius=RADIUS[1], teeth=TEETH,
                        stiffness=MESH, damping=MESH_DAMPING, half_backlash=GAP, stiffness_cos=[0.2], error_cos=[3e-6], **more)])


def by_scipy(train, speed, pieces, drag):
    """Speed [rad/s], speeds of the bodies and mesh force at the end: rotations of the bodies, and the mean rotation."""
    inertia, turns = np.array([MOTOR, PINION, WHEEL]), np.array([1.0, 1.0, RADIUS[0] / RADIUS[1]])

    def force(phase, rate, angle, velocity):
        stretch = RADIUS[0] * angle[1] - RADIUS[1] * angle[2] + 3e-6 * np.cos(TEETH[0] * phase)
        fast = RADIUS[0] * velocity[1] - RADIUS[1] * velocity[2] - 3e-6 * TEETH[0] * rate * np.sin(TEETH[0] * phase)
        beyond = np.sign(stretch) * max(abs(stretch) - GAP, 0.0)
        return MESH * (1 + 0.2 * np.cos(TEETH[0] * phase)) * beyond + MESH_DAMPING * fast

    def slope(_, y, torque):
        phase, rate, angle, velocity = y[0], y[1], y[2:5], y[5:8]
        twist = STIFFNESS * (angle[0] - angle[1]) + DAMPING * (velocity[0] - velocity[1])
        line = force(phase, rate, angle, velocity)
        # Damping to ground acts on what is not the mean rotation, whose speed the drift goes to at the end of each piece.
        applied = torque - np.array([twist, RADIUS[0] * line - twist, drag * velocity[2] - RADIUS[1] * line])
        gain = torque @ turns / (inertia @ turns**2)
        return np.concatenate([[rate, gain], velocity, applied / inertia - gain * turns])

    static = 60.0 / RADIUS[0]
    y = np.array([0.0, speed, 60.0 / STIFFNESS, 0.0, 0.0, 0.0, 0.0, 0.0])
    y[4] = -(GAP + static / MESH - 3e-6) / RADIUS[1]
    start = train.simulator(speed * 30 / np.pi, unit="rpm")
    # The mesh is stretched by its mean force; its speed is 0, so that the bodies make up for the transmission error.
    y[4] = (RADIUS[0] * y[3] + 3e-6 - start.displacement[0] * 1e-4) / RADIUS[1]
    y[5:8] = start.body_speed - speed * turns
    for duration, torque in pieces:
        y = solve_ivp(slope, (0, duration), y, "DOP853", args=(np.array(torque),), rtol=1e-11, atol=1e-13, max_step=2e-5).y[:, -1]
        drift = (inertia * turns) @ y[5:8] / (inertia @ turns**2)
        y[1] += drift
        y[5:8] -= drift * turns
    return y[1], y[1] * turns + y[5:8], force(y[0], y[1], y[2:5], y[5:8])


@pytest.mark.parametrize("drag, begin", [(0.0, 300.0), (0.4, 300.0), (0.0, 0.0)])
def test_torques_out_of_balance_against_scipy(drag, begin):
    train = pair(drag)
    simulator = train.simulator(begin * 30 / np.pi, unit="rpm")
    load = simulator.torque["wheel"]
    assert load == pytest.approx(-180.0, rel=1e-12)
    pieces = [(0.004, (90.0, 0.0, load)), (0.003, (-40.0, 0.0, load)), (0.005, (60.0, 5.0, -100.0)), (0.004, (0.0, 0.0, 0.0))]
    for duration, torque in pieces:
        simulator.advance(duration, dict(zip(train.body_labels, torque)))
    speed, bodies, force = by_scipy(train, begin, pieces, drag)
    # Both to 1e-11 a step; SciPy does not meet the walls exactly, which leaves some 1e-8.
    assert simulator.speed * np.pi / 30 == pytest.approx(speed, rel=1e-9)
    np.testing.assert_allclose(simulator.body_speed, bodies, rtol=1e-7)
    np.testing.assert_allclose(simulator.mesh_force, force, atol=1e-5 * 180 / RADIUS[1])
    assert simulator.time == pytest.approx(0.016, rel=1e-12)


def test_constant_acceleration_is_a_run_up():
    train = gt.read_case("namelists/reducer.nml").train
    state = train.simulator(1500.0, unit="rpm").state
    numbers, ratio = train.explain(), dict(zip(train.body_labels, train.rigid_motions[0]))
    turns = {name: ratio[name] / ratio[train.speed_name] for name in ratio}
    for stop in (1600.0, 1400.0):
        run_up = train.run_up(start=1500.0, stop=stop, unit="rpm", duration=0.02, max_periods=0, seed=state)
        rate = (stop - 1500) * np.pi / 30 / 0.02
        simulator = train.simulator(1500.0, unit="rpm", start=state)
        extra = sum(numbers[name]["inertia"] * turns[name] ** 2 for name in turns) * rate / turns["load"]
        load = simulator.torque["load"] + extra
        for _ in range(7):
            simulator.advance(0.02 / 7, {"load": load})
        # Rounding: the same equations, accelerated by torques of inertia there and by one torque here.
        assert simulator.speed == pytest.approx(stop, rel=1e-12)
        np.testing.assert_allclose(simulator.state, run_up.state, atol=1e-11 * abs(run_up.state).max())
        np.testing.assert_allclose(simulator.mesh_force, run_up.mesh_force[-1], rtol=1e-9)
        np.testing.assert_allclose(simulator.shaft_torque, run_up.shaft_torque[-1], rtol=1e-9)


def rubbing():
    """The pair with a clutch that sticks and slips in place of its shaft, driven by an engine's second order."""
    clutch = gt.Coupling(between=["motor", "pinion"], stiffness=STIFFNESS, damping=0.5, friction_torque=12.0)
    train = pair()
    motor = replace(train.bodies[0], torque_cos=None, revolution_torque_cos=[0.0, 45.0])
    return replace(train, shafts=[], couplings=[clutch], bodies=[motor, *train.bodies[1:]])


@pytest.mark.parametrize("make, speed", [(lambda: gt.read_case("namelists/reducer.nml").train, 1500.0), (rubbing, 1700.0)])
def test_a_steady_motion_stays(make, speed):
    train = make()
    motion = train.integrate(speed, unit="rpm")
    assert all(motion.coupling_energy_loss > 0.1) if train.couplings else motion.coupling_energy_loss is None
    simulator = train.simulator(start=motion)
    assert simulator.frequency == motion.frequency
    period = motion.period * 2 * np.pi / (motion.frequency * train.explain()["train"]["characteristic_frequency"])
    simulator.advance(period)
    np.testing.assert_allclose(simulator.state, motion.state, atol=1e-6 * abs(motion.state).max())
    assert min(simulator.phase, 2 * np.pi - simulator.phase) < 1e-9
    assert simulator.value("mesh 1") == simulator.mesh_force[0]
    assert simulator.value("motor") == simulator.body_speed[train.body_labels.index("motor")]


def test_bad_input_is_told():
    train = pair()
    simulator = train.simulator(0.5)
    for call, words in (
        (lambda: simulator.advance(-1.0), "duration = -1.0: must be a number >= 0"),
        (lambda: simulator.advance(1e-3, {"moter": 1.0}), "torque: 'moter': must be one of motor, pinion, wheel"),
        (lambda: simulator.advance(1e-3, {"motor": float("nan")}), "torque: motor = nan: must be a number"),
        (lambda: simulator.advance(1e-2, {"motor": 1e12}), r"2\.776e9 mesh cycles in one step, at speeds to which the"),
        (lambda: simulator.advance(1e300), "mesh cycles in one step"),
        (lambda: simulator.value("mesh 2"), "name = 'mesh 2': must be one of shaft 1, mesh 1, motor, pinion, wheel"),
        (lambda: train.simulator(-1.0), "frequency = -1.0: must be a number >= 0"),
        (lambda: gt.read_case("namelists/fig03.nml").train.simulator(0.5), "needs a train of bodies"),
    ):
        with pytest.raises(gt.InputError, match=words):
            call()
    # What is refused leaves no torque behind.
    assert simulator.torque["motor"] == 60.0 and simulator.advance(1e-4).time == pytest.approx(1e-4)
