"""Drawings whose teeth make the common period of all meshes very long: mesh frequencies are taken nearby, with a shorter period.
Where there are none near enough, what computes with whole periods refuses them, time integration does not."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT

import geartrain as gt


def stages(*teeth, **more):
    """Stages in a row by their teeth, from a motor to a load."""
    mesh = dict(normal_module=2e-3, face_width=0.03, backlash=6e-5, damping_ratio=0.05, stiffness_harmonics=1, **more)
    bodies, shafts, meshes = [gt.Body(name="motor", inertia=0.003, torque=40.0)], [], []
    for number, pair in enumerate(teeth, 1):
        pinion, wheel = f"pinion {number}", f"wheel {number}"
        bodies += [gt.Body(name=pinion), gt.Body(name=wheel)]
        shafts.append(gt.Shaft(between=(bodies[-3].name, pinion), stiffness=3e4 * 3**number, damping_ratio=0.05))
        meshes.append(gt.Mesh(between=(pinion, wheel), teeth=pair, **mesh))
    bodies.append(gt.Body(name="load", inertia=0.5, balances=True))
    shafts.append(gt.Shaft(between=(bodies[-2].name, "load"), stiffness=1e6, damping_ratio=0.05))
    return gt.Train(bodies=bodies, shafts=shafts, meshes=meshes)


@pytest.fixture(scope="module")
def train():
    """The first mesh goes through 101 times 107 cycles before all repeat."""
    return stages((23, 101), (19, 107), (17, 61))


@pytest.fixture(scope="module")
def given():
    """Figure 3's train with orders that are given, not derived from teeth."""
    train = gt.read_case(ROOT / "namelists" / "fig03.nml").train
    meshes = [replace(mesh, order=order) for mesh, order in zip(train.meshes, (10807, 2033), strict=True)]
    return replace(train, meshes=meshes)


def orders(train):
    told = train.explain()
    return np.array([told[f"mesh {number}"]["order"] for number in range(1, len(train.meshes) + 1)])


def test_the_drawing_is_read(train):
    exact, nearby = np.array([101 * 107, 19 * 107, 19 * 17]), orders(train)
    ratio = nearby / exact
    assert nearby.max() <= 10000 and ratio.max() / ratio.min() - 1 < 2e-5
    told = train.explain()
    # Cycles of the first mesh in a turn of its pinion.
    assert np.isclose(nearby[0] / told["train"]["speed_ratio"], 23, rtol=1e-5)
    assert told["train"]["fundamental"] == "about 346 turns of motor, by the teeth 10807/23"
    assert (np.array(train.natural_frequencies(unit="rpm")) > 0).all()


def test_equal_and_simple_ratios_are_kept():
    """Two stages of equal teeth ahead of one another: mesh frequencies in the ratio 1 to 2 before a hunting pair stay so."""
    found = orders(stages((20, 40), (20, 40), (23, 127), (19, 107)))
    exact = np.array([4.0, 2.0, 23 / 20, 19 * 23 / 127 / 20])
    assert found[0] == 2 * found[1] and found[0] < 80 * 127
    np.testing.assert_allclose(found / found[0], exact / exact[0], rtol=2e-5)


def test_what_needs_the_common_period_says_so(given):
    words = "repeat themselves after 10807 cycles of mesh 1, .* more than 10000 .* integrate in time"
    with pytest.raises(gt.InputError, match=words):
        given.response(start=1e-4, stop=2e-4, harmonics=0)
    with pytest.raises(gt.InputError, match=words):
        given.stability_map(start=1e-4, stop=2e-4, parameter="mesh_damping_ratio", parameter_start=0.01,
                            parameter_stop=0.05)


def test_a_run_up_of_a_part_of_the_period(train):
    """It begins at rest, and lasts for less than the common period of twenty seconds."""
    found = train.run_up(start=1000.0, stop=1400.0, unit="rpm", duration=0.1, max_periods=0)
    assert found.complete and found.speed[-1] == pytest.approx(1400.0, rel=1e-3)
    force = found.mesh_force_maximum.max(axis=0)
    assert np.isfinite(force).all() and (force > 0).all()


@pytest.mark.nightly
def test_a_window_has_the_forces_of_a_tenth_of_the_common_period(train):
    found = train.integrate(1000.0)
    assert found.period == 0 and found.kind == "stationary"
    # Flown on from the state found, at constant speed, for a tenth of the period: the forces stay within those of the window.
    share = train.run_up(start=1000.0, stop=1000.0, duration=0.1 / found.fundamental_frequency, seed=found, max_periods=0)
    reached = share.mesh_force_maximum.max(axis=0)
    assert (reached <= found.mesh_force_maximum + found.force_uncertainty).all()
    assert (reached > 0.9 * found.mesh_force_maximum).all()


def test_five_hunting_stages():
    """Together they repeat themselves after 3e9 turns: orders nearby, by the ratios of the teeth to the error that is warned of."""
    teeth = ((23, 71), (29, 73), (31, 79), (37, 83), (41, 89))
    with pytest.warns(gt.DrawingWarning) as caught:
        train = stages(*teeth)
    messages = [str(one.message) for one in caught]
    told = next(words for words in messages if "millions of cycles of this mesh; the mesh frequencies are taken" in words)
    off = float(told.split("are taken ")[1].split(" off")[0])
    speed, about = 1.0, train.explain()
    for number, (driving, driven) in enumerate(teeth, 1):
        found = about[f"mesh {number}"]["order"] / about["train"]["speed_ratio"]
        assert found == pytest.approx(driving * speed, rel=1.001 * off)
        speed *= driving / driven
    assert off < 1e-4


@pytest.mark.full
@pytest.mark.parametrize("start, stop, apart, allowed", [
    (0.72, 0.95, 0.001, 1e-5), pytest.param(1.6, 1.9, 0.4, 3e-3, marks=pytest.mark.nightly)])
def test_a_short_line_has_the_motions_of_the_period(start, stop, apart, allowed):
    """Two meshes of 5003 and 1301 cycles, whose contacts are found on a line of 73 cycles or more; torques that are next to nothing
    make five sources, for which they are found in every cycle of the period. Allowed is a third of the tolerance where the sets of
    harmonics differ."""
    train = gt.read_case(ROOT / "namelists" / "fig03.nml").train
    train = replace(train, meshes=[replace(mesh, order=order) for mesh, order in zip(train.meshes, (5003, 1301), strict=True)])
    torque = np.zeros(13)
    torque[[6, 10, 12]] = 1e-9
    asked = dict(start=start / 5003, stop=stop / 5003, harmonics=0, tolerance=1e-2, stability=False)
    short, whole = train.response(**asked), replace(train, torque_cos=list(torque)).response(**asked)
    assert short.complete and short.error_estimate.max() <= 1e-2 and short.separation_fraction.max() > apart
    along = np.argsort(whole.frequency)
    for name in ("rms", "separation_fraction"):
        found, expected = getattr(short, name), getattr(whole, name)[along]
        for mesh in range(2):
            at = np.interp(short.frequency, whole.frequency[along], expected[:, mesh])
            scale = found[:, mesh].max() if name == "rms" else 1.0
            np.testing.assert_allclose(found[:, mesh], at, rtol=0, atol=allowed * scale, err_msg=name)
