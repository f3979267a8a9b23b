"""Resonances much narrower than the steps of a response over a wide range: against a closed form, and responses over them alone."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT

import geartrain as gt
from paper_cases import chain

RADIUS, INERTIA, STIFFNESS, ERROR = 0.05, 0.002, 2e8, 1e-6


def pair(ratio, deflection=5e-3, **changes):
    """Two equal gears with a sinusoidal transmission error, in contact throughout: p'' + 2 ratio p' + p = error Lambda^2 cos."""
    length = 20e-6
    values = {"characteristic_length": length, "characteristic_frequency": np.sqrt(2 * STIFFNESS * RADIUS**2 / INERTIA), **changes}
    mesh = gt.Mesh(between=("pinion", "wheel"), driving_radius=RADIUS, driven_radius=RADIUS, stiffness=STIFFNESS,
                   damping_ratio=ratio, half_backlash=length, error_cos=[ERROR])
    bodies = [gt.Body(name="pinion", inertia=INERTIA, torque=deflection * STIFFNESS * RADIUS),
              gt.Body(name="wheel", inertia=INERTIA, balances=True)]
    return gt.Train(bodies=bodies, meshes=[mesh], **values)


@pytest.mark.parametrize("stability", [False, True])
@pytest.mark.parametrize("harmonics", [0, 3])
@pytest.mark.parametrize("ratio", [1e-2, 1e-3, 1e-4])
def test_peak_of_a_pair(ratio, harmonics, stability):
    """Its height and place after the closed form, to the digits of the peaks."""
    branch = pair(ratio).response(start=0.3, stop=2.6, harmonics=harmonics, stability=stability)
    peak = max(branch.peaks(), key=lambda peak: peak.rms)
    # The largest value of Lambda^2/|1 - Lambda^2 + 2i ratio Lambda|, times the error; the rms of the paper is the amplitude.
    assert peak.frequency == pytest.approx(1 / np.sqrt(1 - 2 * ratio**2), rel=1e-7)
    assert peak.rms == pytest.approx(ERROR / 20e-6 / (2 * ratio * np.sqrt(1 - ratio**2)), rel=1e-6)


@pytest.mark.parametrize(
    "settings", [{"subharmonic": 2, "harmonics": 6}, {"control": "local"}, {"coefficients": "sampled"}, {"step": 2.0}])
@pytest.mark.parametrize("ratio", [1e-2, 1e-3])
def test_peak_with_other_settings(ratio, settings):
    """The same peak whatever the way to it."""
    branch = pair(ratio).response(start=0.3, stop=2.6, **{"harmonics": 3, **settings})
    peak = max(branch.peaks(), key=lambda peak: peak.rms)
    assert peak.frequency == pytest.approx(1 / np.sqrt(1 - 2 * ratio**2), rel=1e-7)
    assert peak.rms == pytest.approx(ERROR / 20e-6 / (2 * ratio * np.sqrt(1 - ratio**2)), rel=1e-6)


@pytest.mark.parametrize("harmonics", [0, 24])
@pytest.mark.parametrize("order", [3, 7, 20])
@pytest.mark.parametrize("ratio", [3e-2, 1e-3])
def test_peak_of_a_high_order(ratio, order, harmonics):
    """An error with a small first order and one whose resonance is the only one in the range, whatever harmonics are carried."""
    given = pair(ratio, 6e-5)
    error = [1e-7] + [0.0] * (order - 2) + [ratio * given.characteristic_length]
    given = replace(given, meshes=[replace(given.meshes[0], error_cos=error)])
    branch = given.response(start=0.3 / order, stop=min(0.95, 2.6 / order), harmonics=harmonics, stability=False)
    peak = max(branch.peaks(), key=lambda peak: peak.rms)
    assert peak.frequency == pytest.approx(1 / np.sqrt(1 - 2 * ratio**2) / order, rel=1e-4)
    assert peak.rms == pytest.approx(1 / (2 * np.sqrt(1 - ratio**2)), rel=2e-3)


def light(seed):
    """The paper's train with little damping and little variation of the stiffness."""
    rng = np.random.default_rng(seed)
    ratio = 10 ** rng.uniform(-4, -1.5)
    meshes = [{"stiffness": 10 ** rng.uniform(8, 9), "damping_ratio": ratio * 10 ** rng.uniform(-0.3, 0.3),
               "stiffness_cos": [min(0.4, ratio * 10 ** rng.uniform(-0.5, 1))], "half_backlash": rng.choice([0.0, 3e-5])}
              for _ in range(2)]
    train = gt.read_case(ROOT / "namelists" / "fig03.nml").train
    return replace(train, meshes=[replace(mesh, **values) for mesh, values in zip(train.meshes, meshes)],
                   shafts=[replace(shaft, damping_ratio=ratio) for shaft in train.shafts]), rng


@pytest.mark.parametrize("ratio", [3e-3, 1e-3])
@pytest.mark.parametrize("deflection", [1e-3, 1e-1])
def test_beside_an_antiresonance(ratio, deflection):
    """A step from where the teeth follow the error by the free vibration of wheel and disc: the other end allows for a resonance.

    And a static deflection beside which the peak is small: it is drawn since it stands out of the motion beside it.
    """
    alone = pair(ratio, deflection)
    disc = gt.Body(name="disc", inertia=0.5 * INERTIA)
    shaft = gt.Shaft(between=("wheel", "disc"), stiffness=STIFFNESS * RADIUS**2, damping_ratio=ratio)
    train = replace(alone, bodies=[*alone.bodies, disc], shafts=[shaft])
    settings = {"harmonics": 3, "stability": False}
    modes, absorbed = train.modes(), np.sqrt(1.5)  # of wheel and disc without the mesh: k (1/I + 2/I) over 2 k/I
    for natural, width in zip(modes.natural_frequency, modes.damping_ratio):
        peak = train.response(start=natural * (1 - 6 * width), stop=natural * (1 + 6 * width), **settings).peaks()[0]
        for start in (absorbed, 0.98 * absorbed, 1.02 * absorbed):
            wide = train.response(start=start, stop=natural + 0.3 * np.sign(natural - start), **settings)
            assert max(found.rms for found in wide.peaks()) == pytest.approx(peak.rms, rel=1e-6)


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
@pytest.mark.parametrize(("share", "accuracy"), [(1e-2, 0.05), (1e-3, 1e-3), (1e-4, 1e-3)])
@pytest.mark.parametrize("stability", [False, True])
def test_torque_of_a_light_disc(share, accuracy, stability):
    """The torque of its shaft against the linear equations; where the mesh feels its resonance there are points beside the peak."""
    ratio, mesh_ratio, inertia = 1e-3, 0.05, share * INERTIA
    alone = pair(mesh_ratio, 5e-4)
    stiffness = inertia * (0.6 * alone.characteristic_frequency) ** 2
    train = replace(alone, bodies=[*alone.bodies, gt.Body(name="disc", inertia=inertia)],
                    shafts=[gt.Shaft(between=("wheel", "disc"), stiffness=stiffness, damping_ratio=ratio)])
    branch = train.response(start=0.3, stop=2.6, harmonics=3, stability=stability)
    mesh, shaft = np.array([RADIUS, -RADIUS, 0.0]), np.array([0.0, 1.0, -1.0])
    joint = 1 / (1 / INERTIA + 1 / inertia)
    damping = 2 * mesh_ratio * np.sqrt(STIFFNESS * INERTIA / RADIUS**2 / 2), 2 * ratio * np.sqrt(stiffness * joint)
    highest = 0.0
    for speed in np.linspace(0.595, 0.605, 4001) * alone.characteristic_frequency:
        force = STIFFNESS + 1j * speed * damping[0], stiffness + 1j * speed * damping[1]
        matrix = force[0] * np.outer(mesh, mesh) + force[1] * np.outer(shaft, shaft)
        matrix -= speed**2 * np.diag([INERTIA, INERTIA, inertia])
        highest = max(highest, abs(force[1] * (shaft @ np.linalg.solve(matrix, force[0] * mesh * ERROR))))
    assert branch.shaft_torque_maximum.max() == pytest.approx(highest, rel=accuracy)


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_random_trains(times):
    """Over resonances by the mean stiffness and half of it, between points; where the branch does not turn back, nor nearly."""
    compared = 0
    for seed in range(times(200)):
        train, rng = light(seed)
        settings = {"harmonics": int(rng.choice([0, 3, 6])), "stability": False}
        wide = train.response(start=0.3, stop=2.6, **{**settings, "stability": bool(rng.integers(2))})
        if (np.diff(wide.frequency) <= 0).any():
            continue
        modes = train.modes()
        for natural, ratio in zip(modes.natural_frequency, modes.damping_ratio):
            for at in (natural, natural / 2):
                if not 0.35 < at < 2.4:
                    continue
                alone = train.response(start=at * (1 - 6 * ratio), stop=at * (1 + 6 * ratio), **settings)
                between = np.array([np.interp(alone.frequency, wide.frequency, rms) for rms in wide.rms.T]).T
                compared += 1
                # Lower peaks do not stand out of the motion beside them.
                assert np.abs(between - alone.rms).max() < max(0.2 * alone.rms.max(), 1e-3), (seed, at)
    assert compared > times(200)


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
@pytest.mark.parametrize("harmonics", [0, 3])
@pytest.mark.parametrize("ratio", [1e-2, 1e-3, 1e-4])
def test_peak_in_a_large_train(ratio, harmonics):
    """The pair with 70 small discs on soft shafts, whose resonances are far below: the closed form of the pair alone."""
    alone = pair(ratio)
    discs = [gt.Body(name=f"disc {i}", inertia=1e-7) for i in range(70)]
    shafts = [gt.Shaft(between=("wheel", f"disc {i}"), stiffness=5e-3 * (1 + i / 100), damping_ratio=1e-5) for i in range(70)]
    branch = replace(alone, bodies=[*alone.bodies, *discs], shafts=shafts).response(
        start=0.3, stop=2.6, harmonics=harmonics, stability=False)
    peak = max(branch.peaks(), key=lambda peak: peak.rms)
    assert peak.frequency == pytest.approx(1 / np.sqrt(1 - 2 * ratio**2), rel=2e-6)
    assert peak.rms == pytest.approx(ERROR / 20e-6 / (2 * ratio * np.sqrt(1 - ratio**2)), rel=2e-4)


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_modes_of_a_large_train():
    """Each of twenty modes of a chain of 40 shafts, over its resonance alone and in a response that began with ten points."""
    ratio, given = 1e-3, chain(40)
    shafts = [replace(shaft, damping_ratio=ratio) for shaft in given.shafts]
    meshes = [replace(mesh, damping_ratio=ratio, stiffness_cos=[ratio], error_cos=[0.0, 2e-9]) for mesh in given.meshes]
    train = replace(given, shafts=shafts, meshes=meshes)
    settings = {"harmonics": 3, "stability": False}
    wide = train.response(start=1.2, stop=2.0, **settings)
    modes, compared = train.modes(), 0
    for natural, width in zip(modes.natural_frequency, modes.damping_ratio):
        if not 1.25 < natural < 1.95:
            continue
        alone = train.response(start=natural * (1 - 6 * width), stop=natural * (1 + 6 * width), **settings)
        between = np.array([np.interp(alone.frequency, wide.frequency, rms) for rms in wide.rms.T]).T
        compared += 1
        # The tolerance of a curve is of all meshes together, 5e-3.
        assert np.abs(between - alone.rms).max() < 3e-3, natural
    assert compared == 20


@pytest.mark.parametrize("stability", [False, True])
@pytest.mark.parametrize("ratio", [1e-2, 1e-3, 1e-4])
def test_peak_over_a_stiffness(ratio, stability):
    """At constant speed over the stiffness, whose resonance has the height of that over speed."""
    branch = pair(ratio).continuation(parameter="mesh 1 stiffness", start=0.5 * STIFFNESS, stop=2 * STIFFNESS, frequency=1.0,
                                      harmonics=3, stability=stability)
    peak = max(branch.peaks(), key=lambda peak: peak.rms)
    assert peak.parameter == pytest.approx(STIFFNESS * (1 - 2 * ratio**2), rel=1e-7)
    assert peak.rms == pytest.approx(ERROR / 20e-6 / (2 * ratio * np.sqrt(1 - ratio**2)), rel=1e-6)
