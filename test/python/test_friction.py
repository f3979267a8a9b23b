"""Dry friction of couplings: closed forms after Den Hartog, and equations of their own solved from event to event."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from coupling_model import LENGTH, PER_TWIST, RATE, rotor
from friction_model import Events, random_train
from scipy.optimize import fsolve

import geartrain as gt
from geartrain.results.motion import from_state

INERTIA, STIFFNESS = 0.02, 4.0e3
NATURAL = np.sqrt(STIFFNESS / INERTIA)


def oscillator(swing, friction, **given):
    """Den Hartog's: a rotor on a spring with dry friction, under a harmonic torque."""
    train = rotor(0.0, **{"stiffness": STIFFNESS, "friction_torque": friction, **given})
    return replace(train, bodies=[replace(train.bodies[0], torque_cos=[swing]), train.bodies[1]])


def without_stop(ratio, swing, friction):
    """Amplitude [rad] of a motion that never stops for longer than an instant (Den Hartog 1931)."""
    v = 1 / (1 - ratio**2)
    u = np.sin(np.pi / ratio) / (ratio * (1 + np.cos(np.pi / ratio)))
    return swing / STIFFNESS * np.sqrt(v**2 - (friction / swing * u) ** 2)


def with_stop(ratio, swing, friction):
    """Amplitude [rad] and share of the half period at rest of a motion with one stop a half period (Den Hartog 1931)."""
    omega = ratio * NATURAL
    a = swing / STIFFNESS / (1 - ratio**2)

    def moving(t, x0, t0):  # from the release at t0 with negative velocity
        c = x0 - friction / STIFFNESS - a * np.cos(omega * t0)
        d = a * ratio * np.sin(omega * t0)
        s = NATURAL * (t - t0)
        return (friction / STIFFNESS + a * np.cos(omega * t) + c * np.cos(s) + d * np.sin(s),
                -a * omega * np.sin(omega * t) + NATURAL * (d * np.cos(s) - c * np.sin(s)))

    def gaps(z):
        x0, t0, t1 = z[0] * swing / STIFFNESS, z[1] / omega, z[2] / omega
        x, v = moving(t1, x0, t0)
        return [(swing * np.cos(omega * t0) - STIFFNESS * x0 + friction) / swing, v / (omega * swing / STIFFNESS),
                (x + x0) * STIFFNESS / swing]

    for start in product((0.3, 0.8, 1.3), (0.5, 0.8, 1.2, 2.0), (2.6, 3.0, 3.4, 3.8, 4.2)):
        z, _, status, _ = fsolve(gaps, start, xtol=1e-15, full_output=True)
        if status == 1 and z[0] > 0 and 0 < z[1] < z[2] < z[1] + np.pi and np.abs(gaps(z)).max() < 1e-13:
            t = np.linspace(z[1], z[2], 2001)[1:-1] / omega
            if (moving(t, z[0] * swing / STIFFNESS, z[1] / omega)[1] < 0).all():
                return z[0] * swing / STIFFNESS, 1 - (z[2] - z[1]) / np.pi
    raise AssertionError("no motion with one stop")


@pytest.mark.parametrize("ratio, friction", [(0.7, 20.0), (0.9, 60.0), (1.3, 40.0), (2.0, 50.0), (0.9, 78.0)])
def test_without_a_stop(ratio, friction):
    motion = oscillator(100.0, friction).integrate(frequency=ratio * NATURAL / RATE)
    amplitude = without_stop(ratio, 100.0, friction)
    assert motion.period == 1 and motion.stable
    assert motion.maximum[0] / PER_TWIST == pytest.approx(amplitude, rel=1e-10)
    assert motion.minimum[0] / PER_TWIST == pytest.approx(-amplitude, rel=1e-10)
    # Friction takes four times the amplitude, and the torque gives it.
    assert motion.coupling_energy_loss[0] == pytest.approx(4 * friction * amplitude, rel=1e-10)
    assert motion.refine().maximum[0] / PER_TWIST == pytest.approx(amplitude, rel=1e-10)


@pytest.mark.parametrize("ratio, friction", [(0.4, 60.0), (0.5, 75.0), (0.7, 80.0), (0.55, 90.0), (1.2, 75.0)])
def test_with_a_stop(ratio, friction):
    motion = oscillator(100.0, friction).integrate(frequency=ratio * NATURAL / RATE)
    amplitude, rest = with_stop(ratio, 100.0, friction)
    assert rest > 0.01
    assert motion.maximum[0] / PER_TWIST == pytest.approx(amplitude, rel=1e-10)
    assert motion.coupling_energy_loss[0] == pytest.approx(4 * friction * amplitude, rel=1e-10)
    # It forgets: one who stops has no velocity, and soon no other place.
    assert np.abs(motion.multipliers).min() < 1e-14


# Networks against equations of their own (friction_model.py)


@pytest.mark.nightly
def test_random_networks(times):
    compared = stuck = 0
    for seed in range(times(60)):
        train = random_train(seed)
        frequency = 0.2 + 0.03 * (seed % 11)
        motion = train.integrate(frequency=frequency)
        if not motion.period or motion.period > 4:
            continue
        compared += 1
        displacement, loss, multipliers, sticks = Events(train, frequency * RATE).fly(motion, 1024)
        stuck += sticks
        scale = np.abs(displacement).max(axis=0)
        assert np.abs(displacement[-1] - displacement[0]).max() < 1e-8 * scale.max(), seed
        cycle = displacement[:-1]
        rms = np.sqrt(2 * ((cycle - cycle.mean(axis=0)) ** 2).mean(axis=0))
        assert motion.rms == pytest.approx(rms, abs=1e-8 * scale.max()), seed
        assert motion.coupling_energy_loss == pytest.approx(loss, rel=1e-5, abs=1e-12), seed
        assert np.abs(np.sort(abs(motion.multipliers)) - np.sort(abs(multipliers))).max() < 1e-6, seed
    assert compared >= 0.6 * times(60) and stuck >= 0.3 * times(60)


# What sticks throughout


def test_sticks_throughout():
    """Below its friction a coupling stands still, carries the torque, and keeps the twist that it has."""
    train = oscillator(30.0, 60.0)
    motion = train.integrate(frequency=0.3)
    assert motion.period == 1 and motion.stable and not motion.undecided
    assert motion.rms[0] == 0 and motion.coupling_energy_loss[0] == 0
    assert motion.coupling_torque_maximum[0] == pytest.approx(30.0, rel=1e-12)
    assert motion.coupling_torque_minimum[0] == pytest.approx(-30.0, rel=1e-12)
    twist = 0.5 * 30.0 / STIFFNESS * PER_TWIST  # the spring adds half as much
    moved = train.integrate(frequency=0.3, start=[twist, 0.0])
    assert moved.mean[0] == pytest.approx(twist, rel=1e-12) and moved.stable
    assert sorted(abs(moved.multipliers)) == [0.0, 1.0]
    refined = moved.refine()
    assert refined.mean[0] == pytest.approx(twist, rel=1e-12) and refined.stable


def test_comes_to_rest():
    """Free vibration loses 2 F/k a half period, and stops where the spring no longer overcomes the friction."""
    train = oscillator(0.0, 10.0)
    start = np.array([0.02 * PER_TWIST, 0.0])  # 8 F/k: extremes at 8, -6, 4, -2, 0 of F/k
    motion = replace(from_state(start, 1, 2), frequency=NATURAL / RATE, train=train, coefficients=np.zeros((1, 1)), period=0)
    path = motion.trajectory(4)
    unit = 10.0 / STIFFNESS * PER_TWIST
    half = (len(path.time) // 4) / 2
    extremes = [path.displacement[round(k * half), 0] / unit for k in range(5)]
    assert extremes == pytest.approx([8, -6, 4, -2, 0], abs=1e-9)
    assert np.abs(path.displacement[round(4 * half):, 0] / unit).max() < 1e-9


# Every analysis


def clutch(friction):
    """A clutch with friction and an idle gear pair with backlash."""
    return gt.Train(
        characteristic_length=LENGTH, characteristic_frequency=RATE,
        bodies=[gt.Body(name="engine", inertia=0.1, torque=10.0, torque_cos=[40.0]), gt.Body(name="hub", inertia=0.004),
                gt.Body(name="wheel", inertia=0.01, torque=-1.0), gt.Body(name="car", inertia=0.5, balances=True)],
        shafts=[gt.Shaft(between=("hub", "car"), stiffness=8e3, damping_ratio=0.03)],
        meshes=[gt.Mesh(between=("hub", "wheel"), driving_radius=0.03, driven_radius=0.06, stiffness=2e7, damping_ratio=0.1,
                        half_backlash=20e-6)],
        couplings=[gt.Coupling(between=("engine", "hub"), stiffness=1.5e3, half_play=0.002, damping=0.4, damping_acts="contact",
                               friction_torque=friction)],
    )


def test_all_of_time_integration(tmp_path):
    train = clutch(6.0)
    sweep = train.sweep(start=0.15, stop=0.25, points=3)
    for motion in sweep:
        assert motion.period > 0
        # What is lost is what the other elements do not take of the work of the torque.
        refined = motion.refine()
        assert refined.rms == pytest.approx(motion.rms, rel=1e-8)
        assert refined.coupling_energy_loss == pytest.approx(motion.coupling_energy_loss, rel=1e-7)
        torque = refined.coupling_torque[:, 0]
        assert refined.coupling_torque_maximum[0] >= torque.max() - 1e-9
        assert refined.mesh_force_maximum[1] == refined.coupling_torque_maximum[0]
    case = tmp_path / "clutch.nml"
    case.write_text(train.namelist(integration={"from": 0.15, "to": 0.25, "points": 3}))
    gt.read_case(case).run().write(tmp_path / "clutch.h5")
    again = gt.read_results(tmp_path / "clutch.h5").integration
    assert again[0].coupling_energy_loss == pytest.approx(sweep[0].coupling_energy_loss)
    assert again[0].train.couplings[0].friction_torque == 6.0
    run_up = train.run_up(start=0.15, stop=0.16, duration=2.0)
    assert run_up.coupling_torque == pytest.approx(run_up.mesh_force[:, 1:])
    # The run-up is slow: its torque has the extremes of the steady motion.
    assert run_up.coupling_torque.max() == pytest.approx(sweep[0].coupling_torque_maximum[0], rel=0.05)
    found = train.attractors(frequency=0.2, starts=4, random_seed=1)
    assert any(np.abs(motion.rms - sweep[1].rms).max() < 1e-6 * sweep[1].rms.max() for motion in found)
    assert "friction_torque" in str(train.explain())


def same_as_integrated(train, branch, points):
    """How many of some points are what time integration settles on."""
    same = 0
    for point in points:
        motion = train.integrate(frequency=float(branch.frequency[point]))
        if motion.period != branch.subharmonic or np.abs(motion.rms - branch.rms[point]).max() > 1e-8 * motion.rms.max():
            continue
        same += 1
        assert branch.stable[point] == motion.stable
        assert np.abs(np.sort(abs(branch.multipliers[point])) - np.sort(abs(motion.multipliers))).max() < 1e-6
        assert branch.coupling_energy_loss[point] == pytest.approx(motion.coupling_energy_loss, rel=1e-7, abs=1e-9)
        assert branch.coupling_torque_maximum[point] == pytest.approx(motion.coupling_torque_maximum, rel=1e-7)
    return same


# The response: branches of orbits by shooting


@pytest.mark.parametrize("friction", [75.0, 90.0])
def test_response_after_den_hartog(friction):
    """Friction of 78.5 N m and more, pi/4 of the torque, bounds the resonance."""
    branch = oscillator(100.0, friction).response(start=1.1 * NATURAL / RATE, stop=2.0 * NATURAL / RATE)
    assert branch.complete and branch.stable.all() and (branch.error_estimate < 1e-10).all()
    compared = 0
    for frequency, largest, smallest, loss in zip(branch.frequency, branch.maximum[:, 0], branch.minimum[:, 0],
                                                  branch.coupling_energy_loss[:, 0]):
        try:
            amplitude = with_stop(frequency * RATE / NATURAL, 100.0, friction)[0]
        except AssertionError:
            continue  # without a stop, or more than one
        compared += 1
        assert largest / PER_TWIST == pytest.approx(amplitude, rel=1e-10)
        assert smallest / PER_TWIST == pytest.approx(-amplitude, rel=1e-10)
        assert loss == pytest.approx(4 * friction * amplitude, rel=1e-10)
    assert compared > 3


def test_response_over_friction():
    """From motions without a stop to those with one, by Den Hartog's formulas."""
    train, ratio = oscillator(100.0, 20.0), 0.7
    branch = train.continuation(parameter="coupling 1 friction_torque", start=10.0, stop=80.0, frequency=ratio * NATURAL / RATE)
    assert branch.complete and branch.stable.all()
    stopped = 0
    for friction, largest in zip(branch.parameter, branch.maximum[:, 0]):
        try:
            amplitude = with_stop(ratio, 100.0, friction)[0]
            stopped += 1
        except AssertionError:
            amplitude = without_stop(ratio, 100.0, friction)
        if 65 < friction < 75:
            continue  # either may be the one that moves, or two stops
        assert largest / PER_TWIST == pytest.approx(amplitude, rel=1e-10)
    assert 0 < stopped < len(branch)


def test_response_through_sticking():
    """A clutch that sticks throughout but for its resonance: its points are those of time integration."""
    train = clutch(60.0)
    train = replace(train, bodies=[train.bodies[0], train.bodies[1], train.bodies[3]], meshes=[])
    branch = train.response(start=0.05, stop=0.6)
    assert branch.complete
    sticks = branch.coupling_energy_loss[:, 0] == 0
    assert sticks[[0, -1]].all() and not sticks.all()
    for point in (*range(0, len(branch), max(1, len(branch) // 12)), len(branch) - 1):
        motion = train.integrate(frequency=float(branch.frequency[point]))
        assert branch.rms[point] == pytest.approx(motion.rms, rel=1e-8, abs=1e-12)
        assert branch.coupling_torque_maximum[point] == pytest.approx(motion.coupling_torque_maximum, rel=1e-7)
        assert branch.coupling_energy_loss[point] == pytest.approx(motion.coupling_energy_loss, rel=1e-6, abs=1e-9)
        assert branch.stable[point] and motion.stable
        assert np.sort(abs(branch.multipliers[point])) == pytest.approx(np.sort(abs(motion.multipliers)), abs=1e-6)
    assert "sticks throughout at" in branch.report()


def same_as_events(train, branch, points):
    """Compares points with equations of their own; whether any stuck."""
    stuck = False
    for point in points:
        frequency = float(branch.frequency[point])
        motion = min(branch.at(frequency), key=lambda found: np.abs(found.rms - branch.rms[point]).max())
        displacement, loss, multipliers, sticks = Events(train, frequency * RATE).fly(motion, 1024)
        stuck |= sticks
        scale = np.abs(displacement).max()
        assert np.abs(displacement[-1] - displacement[0]).max() < 1e-8 * scale, point
        cycle = displacement[:-1]
        assert branch.rms[point] == pytest.approx(np.sqrt(2 * cycle.var(axis=0)), abs=1e-8 * scale), point
        assert branch.coupling_energy_loss[point] == pytest.approx(loss, rel=1e-5, abs=1e-12), point
        assert np.abs(np.sort(abs(branch.multipliers[point])) - np.sort(abs(multipliers))).max() < 1e-6, point
    return stuck


@pytest.mark.nightly
def test_response_of_random_networks(times):
    """Trains with backlash, couplings of several stages and friction: points of their branches by equations of their own."""
    stuck = followed = 0
    for seed in range(times(10)):
        train = random_train(seed)
        branch = train.response(start=0.4, stop=0.6, max_points=300)
        if len(branch) < 2:
            continue
        followed += 1
        # At a fold a frequency that is off by rounding, 1e-13, moves the motion by the square root of it.
        folds = {special.point for special in branch.special_points if special.kind == "fold"}
        middle = next(point for point in range(len(branch) // 2, len(branch)) if point not in folds)
        stuck += same_as_events(train, branch, [0, middle])
    assert followed >= 0.8 * times(10) and stuck >= 0.2 * times(10)


def test_response_of_a_rattling_clutch(tmp_path):
    """Folds and changes of stability with backlash; the file, a motion to begin with, and motions at a speed."""
    train = clutch(6.0)
    branch = train.response(start=0.6, stop=0.5)
    assert branch.complete and (branch.special_points[0].kind, branch.stable.all()) == ("period doubling", False)
    special = branch.special_points[0]
    # One multiplier is -1 there, as on either side of it one is.
    before, after = (min(branch.multipliers[special.point + k].real) for k in (0, 1))
    assert (before + 1) * (after + 1) < 0
    assert same_as_integrated(train, branch, [0, special.point]) == 2
    doubled = train.integrate(frequency=0.54)
    assert doubled.period == 2
    follows = train.response(start=0.535, stop=0.545, subharmonic=2, seed=doubled)
    assert follows.complete and follows.stable.any()
    assert any(np.abs(motion.rms - doubled.rms).max() < 1e-8 for motion in follows.at(0.54))
    branch.write(tmp_path / "response.h5")
    again = gt.read_results(tmp_path / "response.h5").response
    assert (again.rms == branch.rms).all() and again.special_points[0].frequency == special.frequency
    refined = branch.refine()
    assert (refined.rms == branch.rms).all() and (refined.correction == 0).all()


def test_interpolated_onsets_are_undecided():
    """Beside dry friction there is no balance to solve for a contact onset: it lies between two points, and says so."""
    onsets = [onset for friction in (6.0, 0.0) for onset in clutch(friction).response(start=0.3, stop=0.1).onsets]
    interpolated = [onset for onset in onsets if onset.undecided]
    assert 0 < len(interpolated) < len(onsets)
    assert onsets[: len(interpolated)] == interpolated


def test_no_friction_is_no_friction():
    motion, other = (replace(clutch(0.0), couplings=[replace(clutch(0.0).couplings[0], friction_torque=value)])
                     .integrate(frequency=0.2) for value in (0.0, None))
    assert (motion.coefficients == other.coefficients).all() and (motion.multipliers == other.multipliers).all()
    little = clutch(1e-9).integrate(frequency=0.2)
    assert little.rms == pytest.approx(motion.rms, rel=1e-6)


def test_refusals(tmp_path):
    train = clutch(6.0)
    over = {"parameter": "coupling 1 stiffness", "parameter_start": 1e3, "parameter_stop": 2e3}
    with pytest.raises(gt.InputError, match="find motions with friction by shooting and time integration"):
        train.stability_map(start=0.1, stop=0.2, **over)
    for asked in ({"period_doublings": 1}, {"branch_points": True}, {"coefficients": "sampled"}, {"control": "local"}):
        with pytest.raises(gt.InputError, match="for a train with friction_torque"):
            train.response(start=0.1, stop=0.2, **asked)
    case = tmp_path / "follow.nml"
    case.write_text(train.namelist(response={"start": 0.1, "stop": 0.3}, attractors={"frequency": 0.2, "follow": True}))
    with pytest.raises(gt.InputError, match="begin a response with a motion found here"):
        gt.read_case(case).run()
    branch = train.response(start=0.6, stop=0.54)
    for ask in (branch.audit, lambda: branch.special_points[0].exact(), lambda: branch.period_doubled(branch.special_points[0])):
        with pytest.raises((gt.InputError, gt.SolverError), match="friction_torque"):
            ask()
    motion = train.integrate(frequency=0.2)
    with pytest.raises(gt.InputError, match="take differences of refined motions"):
        motion.gradient("rms", ["coupling 1 friction_torque"])
    with pytest.raises(gt.InputError, match="nothing determines their torques"):
        replace(train, couplings=[*train.couplings, replace(train.couplings[0], half_play=None)])
    with pytest.raises(gt.InputError, match="lacks stiffness"):
        rotor(1.0, friction_torque=5.0)


def test_idle_rattle():
    """More friction than the torque of the predamper: it sticks, and the idle wheel is hit harder."""
    case = gt.read_case(Path(__file__).resolve().parents[2] / "namelists" / "driveline.nml")
    lighter = case.run().integration[0]
    branch = case.train.response(start=705.0, stop=700.0, unit="rpm")
    assert branch.complete and branch.rms[-1] == pytest.approx(lighter.rms, rel=1e-8)
    train = replace(case.train, couplings=[replace(case.train.couplings[0], friction_torque=6.0)])
    harder = train.integrate(frequency=700.0)
    assert lighter.separation_fraction[1] > 0.05 and harder.separation_fraction[1] > 0.05
    # The loss, by Taylor series of each step, is the area of the loop; two events of the stick lie between samples.
    twist, torque = lighter.hysteresis_loop().lines[0].get_data()
    area = ((torque[1:] + torque[:-1]) / 2 * np.diff(twist)).sum() * 1e-3
    assert area == pytest.approx(lighter.coupling_energy_loss[0], rel=1e-4)
    with pytest.raises(gt.InputError, match="coupling = 2: must be 1 to 1"):
        lighter.hysteresis_loop(2)
    assert lighter.coupling_energy_loss[0] > 0.1 and harder.mesh_force_maximum[1] > 1.2 * lighter.mesh_force_maximum[1]


def driveline():
    return gt.read_case(Path(__file__).resolve().parents[2] / "namelists" / "driveline.nml").train


@pytest.mark.full
def test_steps_of_the_idle_rattle():
    """Steps grow with the twists, which are a hundred times the plays of the gears: with steps of 0.2 it takes 70 points."""
    train = driveline()
    branch = train.response(start=600.0, stop=608.0, unit="rpm", harmonics=62, seed=train.integrate(frequency=600.0))
    assert branch.complete and len(branch) < 35
    (motion,) = branch.at(604.0)
    assert motion.rms == pytest.approx(train.integrate(frequency=604.0, harmonics=62).rms, rel=1e-8)


@pytest.mark.nightly
def test_response_of_the_idle_rattle():
    """Many sharp bends, where an idle wheel just reaches a flank: none is taken for the end, and no fold is lost."""
    train = driveline()
    branch = train.response(start=600.0, stop=1200.0, unit="rpm", harmonics=62)
    # With steps of 0.2 the range took 14,255 points.
    assert branch.complete and len(branch) < 2500
    folds = [special.frequency for special in branch.special_points if special.kind == "fold"]
    # Of the branch with steps of 0.2, which ended at 1054.74 rpm before it came to the last fold.
    assert folds[:2] == pytest.approx([619.525504, 633.11563], rel=1e-7)
    stable = np.flatnonzero(branch.stable & (branch.frequency > 640))
    points = stable[:: max(1, len(stable) // 6)]
    assert same_as_integrated(train, branch, points) >= len(points) // 2


def test_beside_bearings():
    """Very stiff bearings change nothing, and stand after the couplings: each torque and loss is still its own."""
    damped = {"mass": 1.0, "stiffness": [1e12, 1e12], "damping": [1e3, 1e3]}

    def train(bearings, **axes):
        motor = gt.Body(name="motor", inertia=0.02, torque=40.0, torque_cos=[20.0])
        load = gt.Body(name="load", inertia=0.3, balances=True)
        pinion = gt.Body(name="pinion", inertia=0.002, position=axes.get("pinion"))
        wheel = gt.Body(name="wheel", inertia=0.02, position=axes.get("wheel"))
        mesh = gt.Mesh(between=("pinion", "wheel"), driving_radius=0.035, driven_radius=0.058, stiffness=2e8, damping_ratio=0.05,
                       half_backlash=20e-6, stiffness_cos=[0.1])
        coupling = gt.Coupling(between=("motor", "pinion"), stiffness=5e3, half_play=0.005, damping_ratio=0.02, friction_torque=3.0)
        shaft = gt.Shaft(between=("wheel", "load"), stiffness=5e4, damping_ratio=0.03)
        return gt.Train(bodies=[motor, pinion, wheel, load], shafts=[shaft], meshes=[mesh], couplings=[coupling], bearings=bearings,
                        characteristic_frequency=1e4, characteristic_length=20e-6)

    plain = train([]).integrate(frequency=0.04)
    carried = train([gt.Bearing(body=name, **damped) for name in ("pinion", "wheel")], pinion=(0.0, 0.0), wheel=(0.1, 0.0))
    stiff = carried.integrate(frequency=0.04)
    # Bearings of 1e12 N/m beside a mesh of 2e8 N/m: 4e-4 of its stiffness, and less of the motion's figures.
    np.testing.assert_allclose(stiff.rms[:2], plain.rms, rtol=4e-4)
    for name in ("coupling_torque_mean", "coupling_torque_maximum", "coupling_energy_loss", "shaft_torque_mean"):
        np.testing.assert_allclose(getattr(stiff, name), getattr(plain, name), rtol=4e-4)
    force = 40.0 / 0.035
    assert np.hypot(*stiff.bearing_force_mean[0]) == pytest.approx(force, rel=1e-3)
