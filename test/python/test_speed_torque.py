"""Mean torques that follow the speed, against SciPy with equations of its own and trains of constant torque."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from scipy.integrate import solve_ivp
from scipy.optimize import root

import geartrain as gt

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")

TEETH, GEAR = 20, 31
RADIUS, WHEEL = 0.05, 0.0775
INERTIA, WHEEL_INERTIA = 2.3e-3, 1.33e-2
STIFFNESS, GAP = 2.5e8, 30e-6
MASS = 1 / (RADIUS**2 / INERTIA + WHEEL**2 / WHEEL_INERTIA)
DAMPING = 2 * 0.05 * np.sqrt(STIFFNESS * MASS)
#: Speed of the pinion at which the mesh frequency is the natural one [rpm].
OWN = np.sqrt(STIFFNESS / MASS) * 60 / (2 * np.pi) / TEETH
#: The torque of the wheel is as given at this speed of the wheel [rpm].
AT, TORQUE = 0.8 * OWN * TEETH / GEAR, 232.5


def pair(torque=TORQUE, exponent=2.0, **fan):
    """A motor that balances drives a propeller: one degree of freedom."""
    if exponent:
        fan = {"torque_speed_exponent": exponent, "torque_speed": AT} | fan
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=(TEETH, GEAR), driving_radius=RADIUS, driven_radius=WHEEL,
                   stiffness=STIFFNESS, damping=DAMPING, half_backlash=GAP, stiffness_cos=[0.25], error_cos=[4e-6])
    return gt.Train(bodies=[gt.Body(name="pinion", inertia=INERTIA, balances=True),
                            gt.Body(name="wheel", inertia=WHEEL_INERTIA, torque=-torque, **fan)], shafts=[], meshes=[mesh])


def reducer(exponent=2.0, torque=-300.0):
    """A motor on a rigid shaft, two stages, a fan on an elastic shaft, and a pump of constant power on the middle one."""
    fan = {"torque_speed_exponent": exponent, "torque_speed": 300.0} if exponent else {}
    pump = {"torque_speed_exponent": -1.0, "torque_speed": 900.0} if exponent else {}
    stage = {"damping_ratio": 0.06, "half_backlash": 20e-6, "stiffness_cos": [0.2], "normal_module": 3e-3}
    bodies = [gt.Body(name="motor", inertia=0.01, balances=True), gt.Body(name="a", inertia=2e-3), gt.Body(name="b", inertia=0.02),
              gt.Body(name="c", inertia=4e-3, torque=-30.0 if exponent else 0.0, **pump), gt.Body(name="d", inertia=0.05),
              gt.Body(name="fan", inertia=0.4, torque=torque, **fan)]
    return gt.Train(
        bodies=bodies, shafts=[gt.Shaft(between=("motor", "a"), rigid=True),
                               gt.Shaft(between=("b", "c"), stiffness=2e4, damping_ratio=0.02),
                               gt.Shaft(between=("d", "fan"), stiffness=4e4, damping_ratio=0.02)],
        meshes=[gt.Mesh(between=("a", "b"), teeth=(20, 40), stiffness=3e8, **stage),
                gt.Mesh(between=("c", "d"), teeth=(20, 60), stiffness=4e8, **stage)])


def constant(speed):
    """The reducer with the torques that it has at a speed of the motor [rpm], constant."""
    train = reducer(exponent=0.0, torque=-300.0 * (speed / 6 / 300.0) ** 2)
    return train.with_values({"c torque": -30.0 * (speed / 2 / 900.0) ** -1})


def rate(time, y, speed, acceleration):
    """m p'' + c p' + k kappa g(p) = F(speed) + m e'', with the wheel's torque by the square of its speed."""
    omega = (speed + acceleration * time) * 2 * np.pi / 60
    angle = (speed * time + acceleration * time**2 / 2) * 2 * np.pi / 60 * TEETH
    torque = TORQUE * ((speed + acceleration * time) * TEETH / GEAR / AT) ** 2
    # The inertia of the wheel: what accelerates it comes through the mesh.
    load = (torque + WHEEL_INERTIA * acceleration * 2 * np.pi / 60 * TEETH / GEAR) / WHEEL
    bend = -4e-6 * ((TEETH * omega) ** 2 * np.cos(angle) + TEETH * acceleration * 2 * np.pi / 60 * np.sin(angle))
    g = y[0] - np.clip(y[0], -GAP, GAP)
    return [y[1], (load - DAMPING * y[1] - STIFFNESS * (1 + 0.25 * np.cos(angle)) * g) / MASS + bend]


@pytest.mark.full
@pytest.mark.parametrize("share", [0.45, 0.93])  # in contact; with separation
def test_a_branch_against_another_integrator(share):
    """Mean and amplitudes of the branch, made exact; SciPy crosses corners of the force with an error of about 1e-8."""
    speed = share * OWN
    branch = pair().response(start=0.98 * speed, stop=1.02 * speed, unit="rpm", harmonics=12)
    found = max((motion for motion in branch.at(speed, unit="rpm") if motion.stable), key=lambda motion: motion.rms[0])
    motion = found.refine()
    # 12 harmonics of a waveform with corners.
    assert found.mean[0] == pytest.approx(motion.mean[0], rel=1e-4)
    assert (motion.minimum[0] < GAP * 1e6) == (share > 0.9)
    period = 60 / speed / TEETH
    coefficients = motion.coefficients[0] * 1e-6
    orders = np.arange(1, len(coefficients) // 2 + 1)
    start = [coefficients[0] + coefficients[1::2].sum(), 2 * np.pi / period * orders @ coefficients[2::2]]

    def flight(y, times=None):
        return solve_ivp(rate, (0, period), y, "DOP853", rtol=1e-11, atol=1e-16, args=(speed, 0.0), max_step=period / 200,
                         t_eval=times)

    scale = np.array([GAP, GAP * 2 * np.pi / period])
    closed = root(lambda y: flight(y * scale).y[:, -1] / scale - y, start / scale, tol=1e-10).x * scale
    done = flight(closed, period * np.arange(256) / 256)
    spectrum = np.fft.rfft(done.y[0]) / 256
    assert coefficients[0] == pytest.approx(spectrum[0].real, rel=1e-6)
    found = np.hypot(coefficients[1::2], coefficients[2::2])[:3]
    assert found == pytest.approx(2 * abs(spectrum[1:4]), abs=1e-6 * coefficients[0])
    static = TORQUE * (speed * TEETH / GEAR / AT) ** 2 / WHEEL
    assert motion.dynamic_factor[0] == pytest.approx(motion.mesh_force_maximum[0] / static, rel=1e-12)


@pytest.mark.full
def test_a_run_up_against_another_integrator():
    """In contact; the start settles to a tolerance, and what this leaves has decayed in a tenth of the ramp."""
    begin, end, duration = 0.3 * OWN, 0.5 * OWN, 0.05
    run = pair().run_up(start=begin, stop=end, duration=duration, unit="rpm")
    acceleration = (end - begin) / duration
    first = run.displacement[0, 0] * 1e-6
    # The run-up begins with the steady motion at its first speed.
    steady = pair().integrate(frequency=begin, unit="rpm").refine().coefficients[0] * 1e-6
    orders = np.arange(1, len(steady) // 2 + 1)
    velocity = 2 * np.pi * TEETH * begin / 60 * orders @ steady[2::2]
    done = solve_ivp(rate, (0, duration), [first, velocity], "DOP853", rtol=1e-11, atol=1e-17, args=(begin, acceleration),
                     t_eval=run.time[::50])
    late = slice(10, None)
    assert 1e6 * done.y[0][late] == pytest.approx(run.displacement[::50, 0][late], abs=1e-6 * abs(run.displacement).max())


@pytest.mark.parametrize("speed", [1300.0, 2600.0])
def test_every_figure_is_that_of_constant_torques(speed):
    """Balance, time integration and shooting at one speed, with rigid and elastic shafts; the balance is solved to 1e-10."""
    branch = reducer().response(start=1200.0, stop=2700.0, unit="rpm", harmonics=6)
    other = constant(speed).response(start=speed, stop=speed + 1, unit="rpm", harmonics=6)
    found, expected = (each.at(speed, unit="rpm")[0] for each in (branch, other))
    flown, reference = (train.integrate(frequency=speed, unit="rpm") for train in (reducer(), constant(speed)))
    refined = found.refine()
    for one, two, digits in ((found, expected, 1e-8), (flown, reference, 1e-8), (refined, expected.refine(), 1e-9)):
        for name in ("coefficients", "mean", "rms", "mesh_force_maximum", "dynamic_factor", "shaft_torque_mean",
                     "shaft_torque_maximum", "shaft_torque_minimum"):
            value = getattr(two, name)
            if value is None:
                continue
            assert getattr(one, name) == pytest.approx(value, rel=digits, abs=digits * np.abs(value).max()), name
    assert found.shaft_torque == pytest.approx(expected.shaft_torque, rel=1e-7)


def test_derivatives_by_the_chain_rule():
    """At constant speed the derivative by a torque is that of the constant train times the factor of the speed."""
    speed = 2600.0
    factor = (speed / 6 / 300.0) ** 2
    one = reducer().response(start=speed, stop=speed + 1, unit="rpm", harmonics=6).at(speed, unit="rpm")[0]
    two = constant(speed).response(start=speed, stop=speed + 1, unit="rpm", harmonics=6).at(speed, unit="rpm")[0]
    for figure in ("rms", "mesh_force_maximum", "dynamic_factor", "shaft_torque_maximum"):
        found = one.gradient(figure, ["fan torque", "fan torque_speed_exponent", "fan torque_speed", "shaft 3 stiffness"])
        known = two.gradient(figure, ["fan torque", "shaft 3 stiffness"])
        by_factor = known[:, 0] * -300.0 * factor
        of_power, of_speed = np.log(speed / 6 / 300.0), -2 / 300.0
        expected = np.column_stack([known[:, 0] * factor, by_factor * of_power, by_factor * of_speed, known[:, 1]])
        # Derivatives by numbers that others follow from are differences.
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-6 * abs(expected).max(axis=0).min())


@pytest.mark.full
def test_a_fold_and_its_derivative():
    """A fold by shooting is where the branches of constant torque have two motions less; its derivative against differences."""
    def folds(train):
        branch = train.response(start=0.6 * OWN, stop=1.4 * OWN, unit="rpm", harmonics=12)
        return [special for special in branch.special_points if special.kind == "fold"]

    fold = folds(pair())[0]
    exact = fold.exact()
    assert exact.frequency == pytest.approx(fold.frequency, rel=1e-3)
    # At the fold the train of constant torque has a fold as well where the torque is that of this speed.
    torque = TORQUE * (exact.frequency * TEETH / GEAR / AT) ** 2
    still = min((special.exact().frequency for special in folds(pair(torque, 0.0))), key=lambda f: abs(f - exact.frequency))
    assert still == pytest.approx(exact.frequency, rel=1e-8)
    step = 1e-4 * TORQUE
    ahead, behind = (min((special.exact().frequency for special in folds(pair(TORQUE + sign * step))),
                         key=lambda f: abs(f - exact.frequency)) for sign in (1, -1))
    # A curve in two parameters passes through the folds of other trains.
    locus = pair().locus(fold, parameter="wheel torque", start=-1.02 * TORQUE, stop=-0.98 * TORQUE)
    middle = len(locus.frequency) // 2
    there = [special.exact().frequency for special in folds(pair(-locus.parameter[middle]))]
    assert min(abs(there - locus.frequency[middle])) < 1e-9 * locus.frequency[middle]
    # The derivative is that of the balance with 12 harmonics.
    assert fold.gradient(["wheel torque"])[0] == pytest.approx(-(ahead - behind) / (2 * step), rel=2e-2)


@pytest.mark.parametrize("body, words", [
    ({"torque_speed": None}, "lacks torque_speed"),
    ({"torque_speed_exponent": 9.0}, "must be"),
    ({"torque": 0.0, "balances": True}, "contradicts balances"),
])
def test_what_cannot_follow_is_refused(body, words):
    with pytest.raises(gt.InputError, match=words):
        pair(**body) if "torque" not in body else gt.Train(
            bodies=[gt.Body(name="pinion", inertia=INERTIA, torque=10.0),
                    gt.Body(name="wheel", inertia=WHEEL_INERTIA, balances=True, torque_speed_exponent=2.0, torque_speed=AT)],
            shafts=[], meshes=pair().meshes)


def test_an_exponent_of_zero_is_a_torque_that_follows_nothing(tmp_path):
    """A study over exponents has its point at 0; where the exponent may have been forgotten a warning says what that means."""
    with pytest.warns(gt.DrawingWarning, match="&body 2: torque_speed has no effect where torque_speed_exponent is 0"):
        still = replace(pair(), bodies=[pair().bodies[0], replace(pair().bodies[1], torque_speed_exponent=0.0)])
    (tmp_path / "case.nml").write_text(still.namelist())
    assert gt.read_case(tmp_path / "case.nml").train.warnings == still.warnings and not pair().warnings
    asked = {"frequency": OWN / 2, "unit": "rpm"}
    study = gt.Study(pair(), gt.Space({"wheel torque_speed_exponent": [0.0, 2.0]}), integrate=asked, keep=["mesh_force_maximum"])
    found = study.run(tmp_path / "study", ThreadPoolExecutor(1), progress=False)
    assert found.mesh_force_maximum.values.ravel() == pytest.approx(
        [train.integrate(**asked).mesh_force_maximum[0] for train in (pair(exponent=0.0), pair())], rel=1e-9)


def test_without_teeth_there_is_no_speed():
    mesh = gt.Mesh(between=("pinion", "wheel"), driving_radius=RADIUS, driven_radius=WHEEL, stiffness=STIFFNESS, damping_ratio=0.05)
    with pytest.raises(gt.InputError, match="unless every mesh has teeth"):
        gt.Train(bodies=pair().bodies, shafts=[], meshes=[mesh], characteristic_length=1e-6, characteristic_frequency=1.0)


def test_the_load_is_told():
    text = pair().response(start=0.4 * OWN, stop=0.41 * OWN, unit="rpm", harmonics=3).report()
    assert "with the power 2 of the speed" in text


def test_a_fan_behind_a_planetary_stage():
    """Reactions and load shares at another speed than that of the torque, as with the torque of this speed."""
    case = gt.read_case(ROOT / "namelists" / "planetary.nml").train

    def stage(torque, **fan):
        bodies = [replace(body, balances=not body.balances, torque=torque if body.balances else None,
                          **(fan if body.balances else {})) if body.balances or body.torque else body for body in case.bodies]
        # Stiffnesses by the drawing are those of the torque as given.
        return replace(case, bodies=bodies, meshes=[replace(mesh, stiffness=1e9) for mesh in case.meshes])

    speed = 4000.0
    fan = stage(-900.0, torque_speed_exponent=2.0, torque_speed=1000.0)
    turns = fan.explain()["load"]["turns"]
    other = stage(-900.0 * (turns * speed / 1000.0) ** 2)
    one, two = (train.integrate(frequency=speed, unit="rpm") for train in (fan, other))
    for name in ("rms", "mesh_force_maximum", "dynamic_factor", "shaft_torque_mean", "reaction_torque", "load_share"):
        assert getattr(one, name) == pytest.approx(getattr(two, name), rel=1e-9), name
