"""Cracked and missing teeth, pitch errors as steps, and drawn pitch errors, with windows and equations of their own."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from test_pitch_errors import DAMPING, GAP, MASS, OWN_SPEED, PITCH, RADIUS, STIFFNESS, TEETH, TORQUE, pair

import geartrain as gt
from geartrain.studies.tolerance_class import pitch_tolerances

#: Factor of each of 20 teeth: one is cracked.
CRACKED = [1.0] * 7 + [0.6] + [1.0] * 12
FINE = 2**14


def windows(values, window, highest, phase=0.0, middle=0.5):
    """Mean and complex amplitudes of a sum of windows at the teeth, up to an order of the revolution, by the FFT of samples.

    At a contact ratio of 1 to 2 kappa has its two pairs at the beginning of a mesh cycle, and one alone in its middle.
    """
    x = np.arange(FINE) / FINE * len(values) - phase / (2 * np.pi) - middle
    apart = (x[:, None] - np.arange(len(values)) + len(values) / 2) % len(values) - len(values) / 2
    amplitude = np.fft.rfft(window(apart) @ np.asarray(values)) / FINE
    return amplitude[0].real, 2 * amplitude[1:highest + 1]


def blend(x):
    return np.where(abs(x) < 1, np.cos(np.pi * x / 2) ** 2, 0.0)


def trapezoid(ratio):
    return lambda x: np.clip((ratio / 2 - abs(x)) / (ratio - 1), 0.0, min(1.0, 1 / (ratio - 1)))


@pytest.mark.full
@pytest.mark.parametrize("share, phase, parts", [(0.37, 0.5, False), pytest.param(0.93, 1.1, True, marks=pytest.mark.nightly)])
def test_a_cracked_tooth_against_another_integrator(share, phase, parts):
    """Mean, orders of the revolution and of sidebands; SciPy steps over the corners of the force with errors of 1e-8."""
    speed = share * OWN_SPEED / TEETH
    train = pair(driving_tooth_stiffness=CRACKED, driving_pitch_error=PITCH if parts else None, phase=phase)
    motion = train.integrate(frequency=speed).refine()
    mean, amplitude = windows(CRACKED, blend, 2 * TEETH, phase)
    orders = np.arange(1, len(amplitude) + 1)
    angles = 2 * np.pi * np.arange(TEETH) / TEETH
    # The highest order of an even number of values is a cosine.
    error = np.array([(1 if 2 * k == TEETH else 2) / TEETH * PITCH @ np.exp(-1j * k * angles) for k in range(1, 11)])
    error = error * np.exp(-1j * np.arange(1, 11) * phase / TEETH) * parts
    # Of the middle order of the polynomial the sine is 0 before the delay.
    omega = 2 * np.pi / 60 * speed
    # Splines through 2^12 values of up to 60 orders are exact to 1e-9, and fast.
    angle = np.linspace(0, 2 * np.pi, 2**12 + 1)
    kappas = (1 + 0.2 * np.cos(TEETH * angle - phase)) * (mean + (amplitude @ np.exp(1j * np.outer(orders, angle))).real)
    bends = -((np.arange(1, 11) * omega) ** 2 * error @ np.exp(1j * np.outer(np.arange(1, 11), angle))).real
    both = CubicSpline(angle, np.column_stack([kappas, bends]))

    def rate(time, y):
        kappa, bend = both(omega * time % (2 * np.pi))
        g = y[0] - np.clip(y[0], -GAP, GAP)
        return [y[1], (TORQUE / RADIUS - DAMPING * y[1] - STIFFNESS * kappa * g) / MASS + bend]

    coefficients = motion.coefficients[0] * 1e-6
    assert (motion.minimum[0] * 1e-6 < GAP) == parts
    start = [coefficients[0] + coefficients[1::2].sum(), omega * np.arange(1, len(coefficients) // 2 + 1) @ coefficients[2::2]]
    period, turns = 2 * np.pi / omega, 2
    done = solve_ivp(rate, (0, turns * period), start, "DOP853", rtol=1e-10, atol=1e-15,
                     max_step=period / TEETH / (50 if parts else 5), t_eval=period * (turns - 1 + np.arange(2048) / 2048))
    spectrum = np.fft.rfft(done.y[0]) / 2048
    assert coefficients[0] == pytest.approx(spectrum[0].real, rel=1e-7)
    for order in (1, 2, 19, 20, 21, 39, 40, 41):
        found = coefficients[2 * order - 1] - 1j * coefficients[2 * order]
        assert found == pytest.approx(2 * spectrum[order], abs=1e-6 * coefficients[0])


def test_equal_teeth_change_nothing():
    """Factors of 1, and a factor of all teeth that is one of the stiffness."""
    speed = 0.45 * OWN_SPEED / TEETH
    plain = pair().integrate(frequency=speed)
    for train, other in ((pair(driven_tooth_stiffness=[1.0] * 31), plain),
                         (pair(driving_tooth_stiffness=[0.9] * TEETH), None)):
        found = train.integrate(frequency=speed)
        if other is None:
            mesh = replace(pair().meshes[0], stiffness=0.9 * STIFFNESS)
            other = replace(pair(), meshes=[mesh]).integrate(frequency=speed)
        # Both periods are of one mesh cycle; the revolution of the factors has as many.
        assert found.mean[0] == pytest.approx(other.mean[0], rel=1e-9)
        assert found.rms[0] == pytest.approx(other.rms[0], rel=1e-8)


@pytest.mark.nightly  # all motions of 40 orders of a revolution
def test_a_response_with_a_cracked_tooth():
    """The balance chooses the harmonics; shooting finds the same motion, and sidebands have names."""
    train = pair(driving_tooth_stiffness=CRACKED)
    speed = 0.42 * OWN_SPEED / TEETH
    branch = train.response(start=0.995 * speed, stop=1.005 * speed, unit="rpm", harmonics=0, tolerance=1e-4)
    motion = branch.at(speed, unit="rpm")[0]
    refined = motion.refine()
    assert motion.rms[0] == pytest.approx(refined.rms[0], rel=1e-4)
    owners = motion.orders().owner.values
    assert {"1 x mesh 1 - 1 x pinion", "1 x mesh 1 + 1 x pinion"} <= {*owners}


def test_steps_against_the_transform_of_the_trapezoid():
    """Sampling a function of corners at 2^14 points has an error of some 1e-7 of it."""
    for ratio, middle in ((1.3, 0.5), (1.8, 0.5), (2.3, 0.0)):
        train = pair((), driving_pitch_error=PITCH, pitch_error_form="steps", contact_ratio=ratio)
        mean, amplitude = windows(PITCH, trapezoid(ratio), 5 * TEETH, middle=middle)
        told = train.explain()["mesh 1"]
        assert told["driving_error_cos"] == pytest.approx(amplitude.real, abs=1e-6 * abs(PITCH).max())
        assert told["driving_error_sin"] == pytest.approx(-amplitude.imag, abs=1e-6 * abs(PITCH).max())
        assert told["error_mean"] == pytest.approx(mean, rel=1e-9)


@pytest.mark.parametrize("ratio", [1.3, 1.6, 1.9])
def test_teeth_change_while_two_pairs_bear(ratio):
    """Where kappa is low a tooth bears alone, with its own error, which changes where kappa is high."""
    told = pair((), driving_pitch_error=PITCH, pitch_error_form="steps", contact_ratio=ratio,
                stiffness_harmonics=100).explain()["mesh 1"]

    def series(name, x, base, mean):
        """Value at x mesh cycles, of orders of the revolution or of the mesh."""
        orders = np.arange(1, len(told[f"{name}_cos"]) + 1)
        angle = 2 * np.pi / base * np.outer(x, orders)
        sine = told.get(f"{name}_sin", np.zeros(len(orders)))
        return mean + np.cos(angle) @ told[f"{name}_cos"] + np.sin(angle) @ sine

    alone = np.arange(TEETH) + 0.5
    wave = 1 + sum(2 * np.sin(h * np.pi * (ratio - 1)) / (h * np.pi * ratio) * np.cos(2 * np.pi * h * alone) for h in range(1, 400))
    assert np.allclose(wave, 1 / ratio, rtol=0.02)  # one pair of `ratio` in the mean
    assert np.allclose(series("driving_error", alone, TEETH, told["error_mean"]), PITCH, rtol=0, atol=0.02 * np.ptp(PITCH))
    inside = np.arange(TEETH)[:, None] + 0.5 + np.linspace(-0.45, 0.45, 7) * (2 - ratio)
    assert np.ptp(series("driving_error", inside.ravel(), TEETH, 0.0).reshape(inside.shape), axis=1).max() < 0.1 * np.ptp(PITCH)


def test_steps_of_helical_teeth_are_averaged_over_the_face():
    """The ends of the face are the overlap ratio apart: the mean of trapezoids between, by the middle of 100 slices."""
    bodies = [gt.Body(name="a", inertia=1e-3, torque=100.0), gt.Body(name="b", inertia=2e-3, balances=True)]
    mesh = gt.Mesh(between=("a", "b"), teeth=(TEETH, 31), normal_module=3e-3, helix_angle=20.0, face_width=40e-3,
                   driving_pitch_error=PITCH, pitch_error_form="steps")
    told = gt.Train(bodies=bodies, meshes=[mesh]).explain()["mesh 1"]
    assert told["overlap_ratio"] > 1
    window = trapezoid(told["contact_ratio"])
    slices = told["overlap_ratio"] * ((np.arange(100) + 0.5) / 100 - 0.5)
    mean, amplitude = windows(PITCH, lambda x: sum(window(x + shift) for shift in slices) / 100, 5 * TEETH)
    assert told["driving_error_cos"] == pytest.approx(amplitude.real, abs=3e-5 * abs(PITCH).max())
    assert told["driving_error_sin"] == pytest.approx(-amplitude.imag, abs=3e-5 * abs(PITCH).max())
    assert told["error_mean"] == pytest.approx(mean, rel=1e-9)


@pytest.mark.parametrize("errors, words", [
    ({"driving_tooth_stiffness": [1.0] * 3}, "must have a value for each of the 20 teeth"),
    ({"driving_tooth_stiffness": [0.0] * TEETH}, "no tooth bears"),
    ({"driving_tooth_stiffness": [-1.0] * TEETH}, "must be"),
    ({"driving_pitch_error": PITCH, "pitch_error_form": "steps"}, "lacks contact_ratio"),
    ({"driving_pitch_error": PITCH, "pitch_error_form": "stairs"}, "polynomial"),
])
def test_wrong_teeth_are_refused(errors, words):
    with pytest.raises(gt.InputError, match=words):
        pair(**errors)


def test_drawn_pitch_errors_are_within_their_class():
    """The tolerances by numbers of their own: d = 60 mm, m = 3 mm, class 5 and the step of sqrt(2) between classes."""
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=(20, 31), normal_module=3e-3)
    single, total = pitch_tolerances(20, 3e-3, 0.0, 5)
    assert (single, total) == pytest.approx((6.26e-6, 18.480282e-6), rel=1e-7)
    assert pitch_tolerances(20, 3e-3, 0.0, 9) == pytest.approx((4 * single, 4 * total))
    found = gt.pitch_errors(mesh, "driving", 5, samples=400) / np.cos(np.radians(20))
    steps = np.diff(found, axis=1, append=found[:, :1])
    assert abs(steps).max() <= single and np.ptp(found, axis=1).max() <= total
    assert abs(found.mean(axis=1)).max() < 1e-18
    # Three standard deviations are the tolerance; 5 % for 8000 values, those beyond left out, and eccentricity.
    assert steps.std() == pytest.approx(single / 3, rel=0.05)
    assert np.array_equal(found, gt.pitch_errors(mesh, "driving", 5, samples=400) / np.cos(np.radians(20)))
    assert not np.array_equal(found[0], gt.pitch_errors(mesh, "driving", 5, random_seed=1) / np.cos(np.radians(20)))
    with pytest.raises(gt.InputError, match="1 to 11"):
        gt.pitch_errors(mesh, "driving", 12)
    with pytest.raises(gt.InputError, match="5 to 1000 teeth"):
        gt.pitch_errors(replace(mesh, normal_module=1e-4), "driving", 5)


@pytest.mark.full  # two responses in a study
def test_a_production_of_gears(tmp_path):
    """Each point of a study is the train with the errors of its gear."""
    train = pair(driving_pitch_error=[0.0] * TEETH)
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=(20, 31), normal_module=5e-3)
    table = gt.pitch_errors(mesh, "driving", 7, samples=2)
    space = gt.Space(sample=table, names=[f"mesh 1 driving_pitch_error {tooth}" for tooth in range(1, TEETH + 1)])
    speed = 0.4 * OWN_SPEED / TEETH
    asked = {"start": speed, "stop": speed * 1.01, "unit": "rpm", "harmonics": 0}
    study = gt.Study(train, space, keep=["largest mesh_force_maximum"], response=asked)
    study.run(tmp_path / "production")
    found = study.dataset(tmp_path / "production")["largest mesh_force_maximum"].values.ravel()
    for force, errors in zip(found, table):
        branch = train.with_values({"mesh 1 driving_pitch_error": errors}).response(**asked)
        assert force == pytest.approx(branch.mesh_force_maximum.max(), rel=1e-9)
    assert found[0] != found[1]
