"""Errors of single teeth and of a gear's revolution, against a SciPy integrator with equations of its own and closed forms."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, run
from scipy.integrate import solve_ivp

import geartrain as gt
from geartrain.results.orders import named_orders, orders_of, owners_of

TEETH, GEAR = 20, 31
#: Cumulative pitch errors of 20 teeth [m], drawn once.
PITCH = 1e-6 * np.array([
    0.0, 2.1, 3.7, 3.0, 5.2, 7.9, 7.1, 20.8, 10.4, 9.2, 9.9, 8.1, 8.6, 6.0, 6.4, 3.9, 2.2, 2.8, 0.3, -1.1,
])
RADIUS, WHEEL = 0.05, 0.0775
INERTIA, WHEEL_INERTIA = 2.3e-3, 1.33e-2
STIFFNESS, GAP, TORQUE = 2.5e8, 30e-6, 150.0
MASS = 1 / (RADIUS**2 / INERTIA + WHEEL**2 / WHEEL_INERTIA)
DAMPING = 2 * 0.07 * np.sqrt(STIFFNESS * MASS)
#: Natural frequency of the pair over the revolution of the pinion at 1 rpm.
OWN_SPEED = np.sqrt(STIFFNESS / MASS) * 60 / (2 * np.pi)


def pair(stiffness_cos=(0.2,), **errors):
    """A pair without anything else: one degree of freedom."""
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=(TEETH, GEAR), driving_radius=RADIUS, driven_radius=WHEEL,
                   stiffness=STIFFNESS, damping=DAMPING, half_backlash=GAP, stiffness_cos=list(stiffness_cos), **errors)
    bodies = [gt.Body(name="pinion", inertia=INERTIA, torque=TORQUE),
              gt.Body(name="wheel", inertia=WHEEL_INERTIA, balances=True)]
    return gt.Train(bodies=bodies, shafts=[], meshes=[mesh])


def interpolate(values, angle):
    """The trigonometric polynomial through equidistant values by its kernel sin(n u/2) cot(u/2)/n, of an even number."""
    n = len(values)
    u = angle - 2 * np.pi * np.arange(n) / n
    near = np.abs(np.sin(u / 2)) < 1e-9
    return float(values[near.argmax()] if near.any() else values @ (np.sin(n * u / 2) / (n * np.tan(u / 2))))


class Pair:
    """m p'' + c p' + k kappa(t) g(p) = F + m e'', integrated from wall to wall."""

    def __init__(self, speed):
        self.omega = 2 * np.pi / 60 * speed
        self.period = 60 / speed
        # Amplitudes of the second derivative: by the values of the interpolation on a fine grid.
        fine = 64
        samples = [interpolate(PITCH, 2 * np.pi * i / fine) for i in range(fine)]
        self.orders = 1j * np.arange(TEETH // 2 + 1)
        self.bend = (self.orders * self.omega) ** 2 * np.fft.rfft(samples)[: len(self.orders)] * 2 / fine

    def rate(self, side):
        def f(t, y):
            angle = self.omega * t
            bend = (self.bend @ np.exp(self.orders * angle)).real
            kappa = 1 + 0.2 * math.cos(TEETH * angle)
            force = DAMPING * y[1] + STIFFNESS * kappa * (y[0] - side * GAP) * abs(side)
            return [y[1], (TORQUE / RADIUS - force) / MASS + bend]

        return f

    def fly(self, y, times):
        """States at times of one period, displacements where the velocity is 0, and how often the teeth part."""
        start, stop, parted, turns = 0.0, self.period, 0, []
        side = int(y[0] > GAP) - int(y[0] < -GAP)
        found = np.empty((len(times), 2))
        while start < stop:
            events = []
            for wall in {1: [GAP], 0: [GAP, -GAP], -1: [-GAP]}[side]:
                def event(_, y, wall=wall):
                    return y[0] - wall
                # Out of a region: down through its lower, up through its upper wall.
                event.terminal, event.direction = True, -1 if (side, wall) in ((1, GAP), (0, -GAP)) else 1
                events.append(event)
            events.append(lambda _, y: y[1])
            done = solve_ivp(self.rate(side), (start, stop), y, "DOP853", rtol=1e-12, atol=[1e-17, 1e-13], events=events,
                             dense_output=len(times) > 0, max_step=self.period / TEETH / 50)  # no separation is shorter
            inside = (times >= start) & (times <= done.t[-1])
            if inside.any():
                found[inside] = done.sol(times[inside]).T
            start, y = done.t[-1], done.y[:, -1]
            turns += [state[0] for state in done.y_events[-1]]
            if done.status == 1:
                parted += side == 1
                side += int(np.sign(y[1]))
                y[0] = GAP if side + (y[1] < 0) > 0 else -GAP
        return y, found, turns, parted

    def settle(self, y):
        """One revolution later: mean, amplitudes of the orders, extremes, separations."""
        y = self.fly(y, np.empty(0))[0]
        samples = 4096
        _, found, turns, parted = self.fly(y, self.period * np.arange(samples) / samples)
        spectrum = np.fft.rfft(found[:, 0]) / samples
        return found[:, 0].mean(), np.abs(spectrum) * 2, max(turns), min(turns), parted


# Of the mesh frequency over the natural frequency; the mesh is loaded by 12 um at rest.
@pytest.mark.full
@pytest.mark.parametrize("share, separations", [(0.37, 0), (0.91, 1), (1.0, 20)])
def test_pitch_errors_against_another_integrator(share, separations):
    """Mean, extremes and the orders 19, 20, 21 of the revolution, in contact and with separation.

    Both integrate with an error of 1e-12 of the displacement a step, some hundred steps a period.
    """
    speed = share * OWN_SPEED / TEETH
    motion = pair(driving_pitch_error=PITCH).integrate(frequency=speed).refine()
    assert motion.period == 1
    unit = 1e-6
    coefficients = motion.coefficients[0] * unit
    cosine, sine = coefficients[1::2], coefficients[2::2]
    other = Pair(speed)
    start = [coefficients[0] + cosine.sum(), other.omega * np.arange(1, len(sine) + 1) @ sine]
    mean, amplitude, maximum, minimum, parted = other.settle(np.array(start))
    assert parted == separations
    assert coefficients[0] == pytest.approx(mean, rel=1e-8)
    for order in (1, 2, 19, 20, 21):
        found = np.hypot(cosine[order - 1], sine[order - 1])
        assert found == pytest.approx(amplitude[order], abs=1e-8 * mean)
    assert [motion.maximum[0] * unit, motion.minimum[0] * unit] == pytest.approx([maximum, minimum], abs=1e-8 * mean)


def test_sidebands_in_contact_against_the_closed_form():
    """A linear pair, m p'' + c p' + k p = F + m e'': each order of the error by itself; 1e-10 is the rounding of e''."""
    runout, phase, cosine, sine = 3e-6, 0.7, [1e-6, 0.0, 2e-6], [0.0, 0.5e-6]
    train = pair((), driving_pitch_error=PITCH, driven_runout=runout, driven_runout_phase=phase, driven_error_cos=cosine,
                 driven_error_sin=sine, error_cos=[2e-6])
    # The period is that of hunting teeth: 31 turns of the pinion, 20 of the wheel.
    assert train.explain()["mesh 1"]["order"] == TEETH * GEAR
    speed = 0.45 * OWN_SPEED / TEETH
    branch = train.response(start=speed, stop=speed * 1.0001, unit="rpm", harmonics=0, tolerance=1e-9, max_points=2)
    motion = branch.at(branch.frequency[0])[0]
    found = motion.coefficients[0][1::2] - 1j * motion.coefficients[0][2::2]
    omega = 2 * np.pi / 60 * speed / GEAR
    error = np.zeros(len(found) + 1, complex)
    angles = 2 * np.pi * np.arange(TEETH) / TEETH
    for k in range(1, TEETH // 2 + 1):
        error[GEAR * k] += (1 if 2 * k == TEETH else 2) / TEETH * PITCH @ np.exp(-1j * k * angles)
    error[TEETH] += runout * np.exp(-1j * phase) + cosine[0] - 1j * 0.0
    error[2 * TEETH] += cosine[1] - 1j * sine[1]
    error[3 * TEETH] += cosine[2]
    error[TEETH * GEAR] += 2e-6
    s = 1j * omega * np.arange(len(error))
    expected = (MASS * s**2 * error / (MASS * s**2 + DAMPING * s + STIFFNESS))[1:] * 1e6
    assert found == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


def test_the_same_errors_in_other_words():
    """Pitch errors as harmonics, a runout as its harmonic, and all delayed by a phase of the mesh."""
    angles = 2 * np.pi * np.arange(TEETH) / TEETH
    share = np.where(2 * np.arange(1, 11) == TEETH, 1, 2) / TEETH
    amplitude = share * np.array([PITCH @ np.exp(-1j * k * angles) for k in range(1, 11)])
    one = pair(driving_pitch_error=PITCH, driving_runout=2e-6, driving_runout_phase=-1.1).explain()["mesh 1"]
    amplitude[0] += 2e-6 * np.exp(1.1j)
    assert one["driving_error_cos"] - 1j * one["driving_error_sin"] == pytest.approx(amplitude, abs=1e-20)
    assert one["error_mean"] == pytest.approx(PITCH.mean(), rel=1e-14)
    # A lag of three and a half mesh cycles is one of the teeth as well.
    late = pair(driving_pitch_error=PITCH, phase=7 * np.pi).explain()["mesh 1"]
    values = [sum((late["driving_error_cos"][k] * np.cos((k + 1) * a) + late["driving_error_sin"][k] * np.sin((k + 1) * a)
                   for k in range(10)), late["error_mean"]) for a in angles + np.pi / TEETH]
    assert values == pytest.approx(np.roll(PITCH, 3), abs=1e-18)


@pytest.mark.parametrize("errors, words", [
    ({"driving_pitch_error": PITCH[1:]}, "driving_pitch_error = 19 values: must have a value for each of the 20 teeth"),
    ({"driven_pitch_error": [1e-6, np.nan]}, "driven_pitch_error value 2 = nan: must be a finite number"),
    ({"driven_pitch_error": [1e-6]}, "driven_pitch_error = 1 values: must have a value for each of the 31 teeth"),
    ({"driving_runout": -1e-6}, "driving_runout = -1e-06: must be >= 0"),
    ({"driving_error_cos": [5.0]}, "driving_error_cos harmonic 1 = 5.0: must be >= -1 and <= 1 m"),
    ({"teeth": None, "driving_runout": 1e-6, "order": 20}, "driving_runout = ...: must be left out unless every mesh has teeth"),
])
def test_wrong_errors_are_refused(errors, words):
    with pytest.raises(gt.InputError) as caught:
        train = pair()
        replace(train, meshes=[replace(train.meshes[0], **errors)], characteristic_length=1e-6,
                characteristic_frequency=1.0).natural_frequencies()
    assert words in str(caught.value)


def test_too_few_harmonics_for_the_mesh_are_refused():
    """The error of the gear has order 1, that of the mesh order 20."""
    with pytest.raises(gt.InputError, match="must be >= 20: the transmission error of &mesh 1 has no lower harmonic"):
        pair((), driving_runout=1e-6, error_cos=[1e-6]).response(start=100.0, stop=200.0, harmonics=6)


def test_runout_as_a_parameter():
    """The gradient of a linear pair is the motion of runout 1 m."""
    train = pair((), driving_runout=2e-6, driven_error_cos=[1e-6])
    speed = 0.45 * OWN_SPEED / TEETH
    for name in ("mesh 1 driving_runout", "mesh 1 driven_error_cos 1"):
        motion = train.response(start=speed, stop=1.0001 * speed, harmonics=0, max_points=2, refine=False).at(speed)[0]
        gradient = motion.gradient("rms", [name])
        step = 1e-9
        changed = train.with_values({name: train.meshes[0].driving_runout + step if "runout" in name else 1e-6 + step})
        other = changed.response(start=speed, stop=1.0001 * speed, harmonics=0, max_points=2, refine=False).at(speed)[0]
        assert np.ravel(gradient)[0] == pytest.approx((other.rms[0] - motion.rms[0]) / step, rel=1e-3)


def test_sidebands_have_owners():
    """The errors have orders up to 10 of the pinion: 19, 21 and 39 come from their product with the stiffness."""
    pytest.importorskip("xarray")
    speed = 0.37 * OWN_SPEED / TEETH
    train = pair(driving_pitch_error=PITCH)
    branch = train.response(start=speed, stop=1.0001 * speed, harmonics=0, tolerance=1e-8, max_points=2)
    table = branch.at(speed)[0].orders(1e-9)
    owner = dict(zip(table.order.values.tolist(), table.owner.values.tolist(), strict=True))
    assert owner[1] == "pinion" and owner[3] == "3 x pinion" and owner[20] == "mesh 1" and owner[40] == "2 x mesh 1"
    assert owner[19] == "1 x mesh 1 - 1 x pinion" and owner[22] == "1 x mesh 1 + 2 x pinion"
    assert owner[39] == "2 x mesh 1 - 1 x pinion" and owner[25] == "1 x mesh 1 + 5 x pinion"
    assert owner.get(180, "9 x mesh 1") == "9 x mesh 1"
    assert table.amplitude.dims == ("order", "mesh") and table.per_revolution.values.tolist() == table.order.values.tolist()


def two_stages_with_an_error(gear):
    """Orders of the meshes 60 and 34, of the pinion a 3, of the shaft between 2."""
    common = {"normal_module": 3e-3, "face_width": 0.02, "stiffness": 2e8, "damping_ratio": 0.05, "stiffness_cos": [0.2, 0.1]}
    error = {"driving_pitch_error": [1e-6 * tooth for tooth in range(20)]} if gear == 1 else {
        "driven_error_cos": [2e-6, *49 * [0.0], 1e-9]}
    return gt.Train(
        characteristic_frequency=1e3, shafts=[gt.Shaft(between=("b", "c"), stiffness=2e5, damping_ratio=0.02)],
        bodies=[gt.Body(name="a", inertia=0.002, torque=50.0), gt.Body(name="b", inertia=0.01), gt.Body(name="c", inertia=0.003),
                gt.Body(name="d", inertia=0.05, balances=True)],
        meshes=[gt.Mesh(between=("a", "b"), teeth=[20, 30], **error, **common),
                gt.Mesh(between=("c", "d"), teeth=[17, 41], **common)])


def test_orders_that_errors_do_not_cause():
    """Sums of two mesh orders that have no name are sums all the same, though the gear with errors has a line there."""
    train = two_stages_with_an_error(1)
    names = {4 * 60 - 3 * 34: "4 x mesh 1 - 3 x mesh 2", 60 - 3: "1 x mesh 1 - 1 x a", 2 * 60 + 3 * 3: "2 x mesh 1 + 3 x a",
             2 * 60 + 5 * 34: "2 x mesh 1 + 5 x mesh 2"}
    assert owners_of(train, names, {}) == [*names.values()]
    assert owners_of(train, [4 * 60 - 3 * 34 + 0.5], {}) == [""]  # a sub-harmonic


def test_orders_that_are_multiples_of_another_mesh():
    """A wheel with errors turns with the pinion of the next stage: its sideband 4 x 30 - 1 is 7 x 17 too."""
    train = two_stages_with_an_error(2)
    assert named_orders(train)[119.0] == "7 x mesh 2" and named_orders(train)[118.0] == "4 x mesh 1 - 2 x b"
    assert orders_of(train, ["4 x mesh 1 - 1 x b", "mesh 1 - 1 x b"]) == {119.0: "7 x mesh 2", 29.0: "1 x mesh 1 - 1 x b"}


def test_causes_of_peaks_that_have_two(executable, tmp_path):
    """Harmonics of the error of the wheel beside multiples of the next mesh frequency, which its nonlinearity excites."""
    train = two_stages_with_an_error(2)
    case = train.namelist() + "&response from = 1060.0, to = 980.0, unit = 'rpm', harmonics = 0, tolerance = 1e-3 /\n"
    (tmp_path / "case.nml").write_text(case)
    said = run(executable, "case.nml", "--verbose", cwd=tmp_path).stdout
    assert "3 x mesh 2 (indirectly); 51 x revolution of b" in said


def test_explained_series_are_whole():
    """Runout gives a cosine of order 1 alone; sines go on."""
    one = pair(driven_runout=10e-6, driven_error_sin=[0.0, 2e-6], stiffness_sin=[0.0, 0.1], stiffness_cos=[0.2])
    told = one.explain()["mesh 1"]
    assert told["driven_error_cos"].tolist() == pytest.approx([10e-6, 0.0]) and told["driven_error_sin"].tolist() == [0.0, 2e-6]
    assert told["stiffness_cos"].tolist() == [0.2, 0.0] and told["stiffness_sin"].tolist() == [0.0, 0.1]
    drawn = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    given = replace(drawn, meshes=[replace(mesh, contact_ratio=1.55) for mesh in drawn.meshes])
    assert given.explain()["mesh 1"]["contact_ratio"] == 1.55 and drawn.explain()["mesh 1"]["contact_ratio"] > 1.56


def test_two_stages_with_errors_of_their_gears():
    """Their common period is hours: what to give is said, and the motion does not depend on what is given."""
    reducer = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    meshes = [replace(mesh, driving_runout=12e-6, driven_runout=20e-6) for mesh in reducer.meshes]
    with pytest.raises(gt.InputError, match=r"lacks characteristic_frequency .* Give 1.0, and speeds with unit = 'rpm'"):
        replace(reducer, meshes=meshes).natural_frequencies()
    one, other = (
        replace(reducer, meshes=meshes, characteristic_frequency=unit).integrate(1450.0, unit="rpm") for unit in (1.0, 7.0)
    )
    assert one.rms == pytest.approx(other.rms, rel=1e-6)
    assert one.mesh_force_maximum == pytest.approx(other.mesh_force_maximum, rel=1e-6)
    assert one.shaft_torque_mean == pytest.approx(90.0 * np.array([1.0, 71 / 23, 71 / 23 * 80 / 19]), rel=1e-3)


def test_the_case_of_the_pages():
    """Numbers of docs/case-studies.md."""
    train = gt.read_case(ROOT / "namelists" / "pitch_errors.nml").train
    pinion = {"driven_runout": 0.0, "driven_runout_phase": 0.0}
    for errors, force, orders in (({}, 3345, {1: 0.0370, 19: 0.0080, 20: 2.812, 21: 0.0080}),
                                  ({"driving_pitch_error": None}, 3323, {1: 2.812})):
        alone = replace(train, meshes=[replace(train.meshes[0], **pinion, **errors)])
        branch = alone.response(start=3000.0, stop=3001.0, harmonics=0, max_points=2)
        motion = branch.at(branch.frequency[0])[0]
        assert motion.mesh_force_maximum[0] == pytest.approx(force, abs=0.6)
        order, amplitude = motion.spectrum()
        for number, height in orders.items():
            assert amplitude[order.tolist().index(number), 0] == pytest.approx(height, rel=6e-3)


def test_a_low_peak_has_the_order_that_makes_it():
    """95 x pinion meets the mode of 485 Hz; in mesh 2 that makes a peak between two points, of which one is higher than it is."""
    order = np.arange(1, 116)
    steps = 2 / 23 * np.fft.fft(np.resize(PITCH, 23))[order % 23] * np.sinc(order / 23) * np.sinc(0.5 * order / 23)
    train = gt.Train(
        bodies=[gt.Body(name="motor", inertia=5e-4, torque=90.0), gt.Body(name="pinion", inertia=1e-3),
                gt.Body(name="wheel", inertia=0.04), gt.Body(name="pinion 2", inertia=3e-3),
                gt.Body(name="machine", inertia=0.9, balances=True)],
        meshes=[gt.Mesh(between=("pinion", "wheel"), teeth=(23, 69), normal_module=2.5e-3, helix_angle=15.0, face_width=40e-3,
                        damping_ratio=0.05, backlash=250e-6, driving_error_cos=steps.real, driving_error_sin=-steps.imag),
                gt.Mesh(between=("pinion 2", "machine"), teeth=(20, 80), normal_module=4e-3, helix_angle=15.0, face_width=70e-3,
                        damping_ratio=0.05, backlash=250e-6)],
        shafts=[gt.Shaft(between=("motor", "pinion"), stiffness=4e4, damping_ratio=0.01),
                gt.Shaft(between=("wheel", "pinion 2"), stiffness=3e5, damping_ratio=0.01)])
    branch = train.response(start=300.0, stop=330.0, unit="rpm", harmonics=0, tolerance=1e-3)
    table = branch.report(verbose=True).partition("RESONANCES")[2].partition("SHAFTS")[0]
    rows = re.findall(r"^ +([\d.]+) +([\d.]+) +([\d.]+) +(\S+) .*  (\S.*)$", table, re.MULTILINE)
    assert [row[1] for row in rows] == ["96", "95", "92", "89"]
    for speed, order, hertz, mode, source in rows:
        assert mode == "1" and f"{order} x revolution of pinion" in source.replace("4 x mesh 1", "92 x revolution of pinion")
        assert float(hertz) == pytest.approx(485.0, rel=2e-3) == pytest.approx(float(speed) / 60 * float(order), rel=2e-3)


def test_a_peak_of_two_meshes():
    """Both stiffnesses vary: their product has the sum of both orders, of which no mesh has one itself."""
    train = gt.Train(
        bodies=[gt.Body(name="pinion", inertia=1e-3, torque=90.0), gt.Body(name="wheel", inertia=0.04),
                gt.Body(name="machine", inertia=0.9, balances=True)],
        meshes=[gt.Mesh(between=("pinion", "wheel"), teeth=(20, 30), driving_radius=0.02, driven_radius=0.03, stiffness=3e8,
                        stiffness_cos=0.25, damping_ratio=0.01),
                gt.Mesh(between=("wheel", "machine"), teeth=(21, 70), driving_radius=0.03, driven_radius=0.1, stiffness=3e8,
                        stiffness_cos=0.25, damping_ratio=0.01)])
    branch = train.response(start=3000.0, stop=3300.0, unit="rpm", harmonics=0, tolerance=1e-3)
    table = branch.report(verbose=True).partition("RESONANCES")[2]
    assert re.search(r"^ +315\d\.\d +34 +17\d\d  2 .*  mesh 1 \+ mesh 2$", table, re.MULTILINE), table
