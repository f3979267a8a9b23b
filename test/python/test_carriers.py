"""Trains with gears on carriers against equations of their own (planetary_model.py): frequencies, responses, motions."""

from dataclasses import replace

import numpy as np
import pytest
from planetary_model import Flow, Model, farthest, linear_response
from planetary_trains import (
    FREQUENCY,
    INERTIA,
    LENGTH,
    LINEAR,
    RING_MESH,
    SUN_MESH,
    TEETH,
    mesh_of,
    planetary,
    power_split,
    radius,
    random_rows,
    ravigneaux,
    train_of,
    two_stages,
)

import geartrain as gt

#: Natural frequencies of the stage of `planetary_trains` with equal planets [Hz]: planets, teeth, member held, frequencies.
PRINTED = [
    (3, TEETH, "ring", [5149.07092, 6580.49593, 6580.49593, 11043.24781]),
    (3, TEETH, "arm", [5310.92252, 6580.49593, 6580.49593, 10939.89885]),
    (3, TEETH, "sun", [3742.89403, 6580.49593, 6580.49593, 7060.27313]),
    (3, TEETH, None, [6013.831913, 6580.49593, 6580.49593, 11058.367317]),
    (4, (20, 20, 60), "ring", [5192.82031, *[5982.26902] * 3, 14078.91302]),
    (5, (19, 21, 61), "ring", [5573.24213, *[6281.38247] * 4, 14961.97337]),
]
WITHOUT_EXCITATION = {"error_cos": None, "error_sin": None}
UNEQUAL = {
    "sun_mesh": {"half_backlash": (20e-6, 21e-6, 19.5e-6), "stiffness": (1e9, 0.7e9, 1.3e9)},
    "ring_mesh": {"stiffness": (1.2e9, 1.0e9, 1.5e9), "phase": (0.0, 0.4, 1.0)},
}


def held_stage(planets, teeth, held, **more):
    """A stage with one member held, or none: then sun and ring turn independently."""
    ends = {"ring": ("sun", "arm"), "arm": ("sun", "ring"), "sun": ("ring", "arm"), None: ("sun", "arm")}[held]
    bodies = None if held else {"ring": {"balances": True, "speed_ratio": -0.1}}
    return planetary(planets, teeth, held, first=ends[0], last=ends[1], bodies=bodies, **more)


# Natural frequencies


@pytest.mark.parametrize("planets, teeth, held, known", PRINTED)
def test_printed_frequencies(planets, teeth, held, known):
    found = held_stage(planets, teeth, held).natural_frequencies(unit="Hz")
    digits = np.array([6 if (held is None and value < 6100) or (value > 11058.3 and held is None) else 5 for value in known])
    assert (np.abs(found - known) <= 0.50001 * 10.0**-digits).all()


@pytest.mark.parametrize("planets, teeth", [(3, TEETH), (4, (20, 20, 60)), (5, (19, 21, 61))])
@pytest.mark.parametrize("held", ["ring", "arm", "sun", None])
def test_closed_form_of_frequencies(planets, teeth, held):
    """The torsional modes solve lambda^2 - N (k_s a + k_r d) lambda + N^2 k_s k_r (a d - o^2) = 0; planet modes (k_s + k_r)/m_p."""
    found = held_stage(planets, teeth, held).natural_frequencies() * FREQUENCY
    masses = [inertia / radius(z) ** 2 for inertia, z in zip(INERTIA, (*teeth, teeth[0] + teeth[1]))]
    masses[3] = INERTIA[3] / (radius(teeth[0]) + radius(teeth[1])) ** 2
    flexibility = [0.0 if held == name else 1.0 / mass for name, mass in zip(("sun", "planet", "ring", "arm"), masses)]
    sun, planet, ring, arm = flexibility
    ks, kr = SUN_MESH["stiffness"], RING_MESH["stiffness"]
    a, d, o = sun + arm + planet / planets, ring + arm + planet / planets, arm - planet / planets
    half = planets * (ks * a + kr * d) / 2
    product = planets**2 * ks * kr * (a * d - o**2)
    upper = half + np.sqrt(half**2 - product)
    squares = np.sort([product / upper, upper, *[(ks + kr) * planet] * (planets - 1)])
    np.testing.assert_allclose(found, np.sqrt(squares), rtol=1e-12)


@pytest.mark.parametrize("train", [ravigneaux(1), ravigneaux(2), ravigneaux(3), two_stages(), power_split(), power_split(1.9)],
                         ids=["Ravigneaux 1", "Ravigneaux 2", "Ravigneaux reverse", "two stages", "split", "split, overdrive"])
def test_frequencies_against_all_bodies(train):
    np.testing.assert_allclose(train.natural_frequencies(), Model(train).frequencies, rtol=1e-9)


# Periodic motions with backlash


def close(found, known, tolerance, what, scale=None):
    scale = np.abs(known).max(initial=0.0) if scale is None else scale
    error = np.abs(np.asarray(found) - known).max(initial=0.0)
    assert error <= tolerance * scale, f"{what}: {error / scale:.1e}"


def shot(motion):
    """The orbit of the tests' own equations nearest to a motion."""
    model = Model(motion.train)
    flow = Flow(model, motion.frequency)
    elastic = [number for number, shaft in enumerate(motion.train.shafts or ()) if not shaft.rigid]
    torque = motion.shaft_torque[:, elastic] if elastic else np.zeros((len(motion.mesh_force), 0))
    stiffness = np.array([element.stiffness for element in model.elements[: model.shafts]])
    mean = np.concatenate([torque.mean(axis=0) / stiffness / model.length, motion.mean])
    return flow.shoot(flow.state_of(np.hstack([torque, motion.mesh_force]), mean, motion.period), motion.period)


def same_motion(motion):
    """Check a motion, refined, against the tests' own integration."""
    exact = motion.refine()
    orbit = shot(exact)
    meshes = slice(orbit.flow.model.shafts, None)
    scale = max(np.abs(exact.minimum).max(), np.abs(exact.maximum).max())
    for name in ("mean", "true_ac_rms", "minimum", "maximum"):
        close(getattr(exact, name), getattr(orbit, name)[meshes], 1e-8, name, scale)
    close(exact.separation_fraction, orbit.separation[meshes], 1e-7, "separation", 1.0)
    close(exact.back_contact_fraction, orbit.back_contact[meshes], 1e-7, "back contact", 1.0)
    assert len(exact.multipliers) == len(orbit.multipliers)
    assert farthest(exact.multipliers, orbit.multipliers) < 1e-7
    shafts = slice(None, orbit.flow.model.shafts)
    elastic = [number for number, shaft in enumerate(motion.train.shafts or ()) if not shaft.rigid]
    for name, known in (("mean", orbit.force_mean), ("minimum", orbit.force_minimum), ("maximum", orbit.force_maximum)):
        if elastic:
            close(getattr(exact, f"shaft_torque_{name}")[elastic], known[shafts], 1e-8, f"shaft torque {name}",
                  np.abs(orbit.force_maximum[shafts]).max())
    return exact


def check_branch(train, places, harmonics=8, most=3, near=False, **settings):
    """Check the motions of a branch at some frequencies; near: a short branch at each."""
    branch = None if near else train.response(start=0.3, stop=3.0, harmonics=harmonics, **settings)
    motions = []
    for place in places:
        at = train.response(start=place, stop=1.01 * place, harmonics=harmonics, **settings) if near else branch
        motions += [same_motion(motion) for motion in at.at(place)[:most]]
    assert motions
    return motions


def test_in_phase():
    motions = check_branch(planetary(phases=False), [2.0], near=True, most=1)
    assert all(np.ptp(motion.true_ac_rms[:3]) < 1e-9 * motion.true_ac_rms.max() for motion in motions)


def test_contact_lost_in_some_planets():
    motions = check_branch(planetary(**UNEQUAL), [1.5], near=True, most=1)
    assert any(0 < (motion.separation_fraction > 0).sum() < 6 for motion in motions)


def test_differential():
    motions = check_branch(power_split(), [0.9], near=True, most=1)
    assert any((motion.back_contact_fraction > 0).any() for motion in motions)


SETS = {
    "in phase": lambda: planetary(phases=False), "sequential": planetary, "unequal": lambda: planetary(**UNEQUAL),
    "four planets": lambda: planetary(4, (20, 20, 60)), "five planets": lambda: planetary(5, (19, 21, 61), torque=200.0),
    "star": lambda: planetary(held="arm", last="ring"), "sun held": lambda: planetary(held="sun", first="ring"),
    "arm drives": lambda: planetary(first="arm", last="sun", torque=900.0), "coast": lambda: planetary(torque=-300.0),
    "Ravigneaux": lambda: ravigneaux(2), "two stages": two_stages, "split": power_split,
    "split, overdrive": lambda: power_split(1.9),
    "ring on a spring": lambda: planetary(held=None, bodies={"ring": {"stiffness_to_ground": 2e6, "damping_to_ground": 20.0}}),
    "arm excited": lambda: planetary(bodies={"arm": {"torque_cos": [50.0, 20.0], "torque_sin": [10.0], "damping_to_ground": 4.0}}),
    "planets dragged": lambda: planetary(planet={"torque": (-3.0, 2.0, 0.0), "damping_to_ground": (0.5, 0.0, 1.0)}, **UNEQUAL),
    "damping in contact": lambda: planetary(sun_mesh={"damping_acts": "contact"}, ring_mesh={"damping_acts": "contact"}),
    "back flanks": lambda: planetary(torque=60.0, sun_mesh={"back_stiffness": 0.7e9, "back_phase": 0.5, "half_backlash": 6e-6},
                                     ring_mesh={"half_backlash": 5e-6, "back_stiffness": 1.0e9}),
}


@pytest.mark.parametrize("place", [pytest.param(1.5, marks=pytest.mark.full),
                                   *(pytest.param(place, marks=pytest.mark.nightly) for place in (0.9, 2.1))])
@pytest.mark.parametrize("name", SETS)
def test_motions(name, place):
    check_branch(SETS[name](), [place], harmonics=12, near=True)


@pytest.mark.nightly
@pytest.mark.parametrize("name", SETS)
def test_motions_of_branches(name):
    """Also unstable motions, and those of twice the period."""
    check_branch(SETS[name](), [0.7, 0.9, 1.2, 1.5, 1.8, 2.1, 2.6], harmonics=12)
    check_branch(SETS[name](), [1.2, 2.6], harmonics=16, near=True, subharmonic=2)


# Supports


def test_wheel_on_a_spring():
    """Closed form of two bodies: the driven wheel on a spring k_2 to ground."""
    k, zeta, k2, c2, torque = 4e8, 0.05, 3e6, 15.0, 30.0
    inertia, radii = (2e-3, 9e-3), (0.04, 0.07)
    bodies = [gt.Body(name="pinion", inertia=inertia[0], torque=200.0, torque_cos=[torque]),
              gt.Body(name="wheel", inertia=inertia[1], stiffness_to_ground=k2, damping_to_ground=c2)]
    train = train_of(bodies, [gt.Mesh(between=("pinion", "wheel"), driving_radius=radii[0], driven_radius=radii[1], stiffness=k,
                                      damping_ratio=zeta, error_sin=[2e-6])])
    found = train.response(start=0.8, stop=0.81, harmonics=2).at(0.8)[0].coefficients[0]
    omega = 0.8 * FREQUENCY
    damping = 2 * zeta * np.sqrt(k / sum(r**2 / i for r, i in zip(radii, inertia)))
    one = -radii[0] ** 2 / (inertia[0] * omega**2)
    other = radii[1] ** 2 / (k2 + 1j * omega * c2 - inertia[1] * omega**2)
    known = (one * torque / radii[0] - 2e-6j) / (1 + (k + 1j * omega * damping) * (one + other)) / LENGTH
    close(found[1] - 1j * found[2], known, 1e-12, "amplitude", abs(known))
    close(found[0], 200.0 / radii[0] / k / LENGTH, 1e-12, "mean")


def test_held_wheel_is_one_of_endless_inertia():
    """The ring held, and a ring of 1e12 times the inertia that a ratio of speeds keeps at rest."""
    held = planetary(torque=300.0).response(start=0.9, stop=0.91, harmonics=8)
    heavy = planetary(held=None, bodies={"ring": {"inertia": 1e12 * INERTIA[2], "balances": True, "speed_ratio": 0.0}},
                      ring_mesh={"damping_ratio": None, "damping": 2 * 0.035 * np.sqrt(1.2e9 * INERTIA[1]) / radius(TEETH[1])},
                      ).response(start=0.9, stop=0.91, harmonics=8)
    close(heavy.at(0.9)[0].coefficients, held.at(0.9)[0].coefficients, 1e-9, "coefficients")


def test_star_set_has_no_need_of_a_carrier():
    """A set whose carrier stands still is a train on fixed axes."""
    train = planetary(held="arm", last="ring")
    fixed = replace(train, bodies=[body for body in train.bodies if body.name != "arm"],
                    meshes=[replace(mesh, carrier=None) for mesh in train.meshes])
    np.testing.assert_allclose(fixed.natural_frequencies(), train.natural_frequencies(), rtol=1e-12)
    one, other = (found.response(start=0.9, stop=0.91, harmonics=8).at(0.9)[0].refine() for found in (train, fixed))
    close(one.coefficients, other.coefficients[:, : one.coefficients.shape[1]], 1e-10, "coefficients")  # shooting ends by tolerance


# Orders and speeds


def toothed(held="ring", first="sun", last="arm", bodies=None, **changes):
    """A stage whose meshes have teeth beside their radii."""
    train = planetary(held=held, first=first, last=last, bodies=bodies, phases=False, **changes)
    return replace(train, meshes=[
        replace(mesh, teeth=TEETH[:2] if "sun" in mesh.between else TEETH[1:], error_cos=None, error_sin=None)
        for mesh in train.meshes])


@pytest.mark.parametrize("changes, wanted", [
    # Meshes per turn of the body that has the speed: z_s z_r/(z_s + z_r) per turn of the sun, z_r per turn of the arm, ...
    ({}, 17 * 61 / 78), ({"speed_of": "arm"}, 61.0), ({"held": "arm", "last": "ring"}, 17.0),
    ({"held": "sun", "first": "ring", "speed_of": "ring"}, 17 * 61 / 78),
    ({"held": "sun", "first": "ring", "speed_of": "arm"}, 17.0),
    ({"held": None, "speed_of": "arm", "bodies": {"ring": {"balances": True, "speed_ratio": 0.5}}}, 30.5),
])
def test_mesh_frequency_is_that_of_teeth_against_the_carrier(changes, wanted):
    told = toothed(**changes).explain()
    assert told["train"]["speed_ratio"] == pytest.approx(1 / wanted, rel=1e-12)
    assert {told[f"mesh {number}"]["order"] for number in range(1, 7)} == {1}


@pytest.mark.full
@pytest.mark.parametrize("changes", [
    *(pytest.param(changes, marks=pytest.mark.nightly) for changes in
      ({"held": "sun", "first": "ring"}, {}, {"held": "arm", "last": "ring"}, {"speed_of": "planet 1"})),
    {"held": None, "speed_of": "arm", "bodies": {"ring": {"balances": True, "speed_ratio": 0.5}}},
])
def test_run_up(changes):
    """The mean torques less what accelerates the inertias, absolute speeds of all bodies, and a frequency that rises."""
    train, duration, start, stop = toothed(**changes), 0.02, 0.6, 0.9
    model = Model(train)
    sun, arm = model.number["sun"], model.number["arm"]
    turns = 1 / (TEETH[0] * abs(model.speed[sun] - model.speed[arm]))
    acceleration = model.speed * turns * (stop - start) * model.omega / duration
    ramp = Flow(model, start).accelerate((stop - start) / (duration * model.omega), acceleration)
    steady = Flow(model, start)
    steady.mean_torque = ramp.mean_torque
    state = steady.shoot(steady.settle(15)).state
    found = train.run_up(start=start, stop=stop, duration=duration)
    time = 0.0
    for sample in (0, 50, 150, 300):
        if sample:
            state, _ = ramp.run(state, time, found.time[sample] * model.omega, tangents=False)
            time = found.time[sample] * model.omega
        close(found.displacement[sample], ramp.displacement(time, state), 1e-8, f"sample {sample}")


# Random rows


def same_linear_response(seed):
    train = random_rows(np.random.default_rng(seed))
    model = Model(train)
    np.testing.assert_allclose(train.natural_frequencies(), model.frequencies, rtol=1e-9)
    frequency = float(np.random.default_rng(seed + 10**6).uniform(0.3, 3.0))
    motion = train.response(start=frequency, stop=1.01 * frequency, harmonics=3).at(frequency)[0]
    mean, amplitude = linear_response(model, frequency, 3)
    found = motion.coefficients[:, 1::2] - 1j * motion.coefficients[:, 2::2]
    close(found, amplitude[model.shafts :], 1e-9, "amplitudes")
    close(motion.coefficients[:, 0], mean[model.shafts :], 1e-9, "mean", max(np.abs(mean).max(), 1e-9))
    elements = model.elements[: model.shafts]
    if elements:
        rate = 1j * frequency * model.omega * np.arange(1, 4)
        waves = np.exp(1j * np.outer(motion.time * frequency, np.arange(1, 4)))
        for number, element in enumerate(elements):
            torque = (element.stiffness + rate * element.damping) * amplitude[number] * model.length
            known = element.stiffness * mean[number] * model.length + (waves @ torque).real
            close(motion.shaft_torque[:, number], known, 1e-9, f"torque of shaft {number + 1}")


def same_motion_with_backlash(seed):
    rng = np.random.default_rng(10000 + seed)
    train, frequency = random_rows(rng, backlash=True), float(rng.uniform(0.3, 3.0))
    motions = train.response(start=frequency, stop=1.02 * frequency, harmonics=10).at(frequency)
    if not motions:
        pytest.skip("the branch has no motion there")
    same_motion(motions[0])


@pytest.mark.parametrize("seed", [
    *range(5), *(pytest.param(seed, marks=pytest.mark.full) for seed in range(5, 20)),
    *(pytest.param(seed, marks=pytest.mark.nightly) for seed in range(20, 200)),
])
def test_random_rows(seed):
    same_linear_response(seed)


@pytest.mark.parametrize("seed", [
    *(pytest.param(seed, marks=pytest.mark.full) for seed in range(4)),
    *(pytest.param(seed, marks=pytest.mark.nightly) for seed in range(4, 60)),
])
def test_random_rows_with_backlash(seed):
    same_motion_with_backlash(seed)


# The same train in another form


def renumbered(train):
    """Planets in another order; their meshes with them. The order of meshes and whether forces change their sign."""
    planets = [body for body in train.bodies if body.name.startswith("planet")]
    others = [body for body in train.bodies if body not in planets]
    count = len(train.meshes) // 2
    order = np.concatenate([np.roll(np.arange(count), 1), count + np.roll(np.arange(count), 1)])
    bodies = [others[1], *planets[::-1], others[0], *others[2:]]
    return replace(train, bodies=bodies, meshes=[train.meshes[i] for i in order]), order, 1


def written_backwards(train):
    """The other gear of each mesh first: the flanks exchange their names, and displacements their signs."""
    def negative(values):
        return None if values is None else [-value for value in values]

    meshes = [replace(mesh, between=mesh.between[::-1], driving_radius=mesh.driven_radius, driven_radius=mesh.driving_radius,
                      error_cos=negative(mesh.error_cos), error_sin=negative(mesh.error_sin)) for mesh in train.meshes]
    return replace(train, meshes=meshes), np.arange(len(meshes)), -1


def counted_the_other_way(train):
    """Speeds refer to a planet, which turns against the sun: all angles of one sense change their signs."""
    return replace(train, speed_of="planet 1"), np.arange(len(train.meshes)), 1


def on_the_coast(train):
    """Torques and errors of the opposite sign: all displacements change theirs."""
    def negative(values):
        return None if values is None else [-value for value in values]

    bodies = [replace(body, torque=-body.torque if body.torque else None) for body in train.bodies]
    meshes = [replace(mesh, error_cos=negative(mesh.error_cos), error_sin=negative(mesh.error_sin)) for mesh in train.meshes]
    return replace(train, bodies=bodies, meshes=meshes), np.arange(len(meshes)), -1


@pytest.mark.parametrize("form", [renumbered, written_backwards, counted_the_other_way, on_the_coast])
@pytest.mark.parametrize("law", ["linear", pytest.param("backlash", marks=pytest.mark.full)])
def test_another_form(form, law):
    more = {name: {**values, **(LINEAR if law == "linear" else {})} for name, values in UNEQUAL.items()}
    train = planetary(**more)
    image, order, sign = form(train)
    np.testing.assert_allclose(image.natural_frequencies(), train.natural_frequencies(), rtol=1e-12)
    one, other = (found.response(start=2.0, stop=2.01, harmonics=8).at(2.0)[0] for found in (train, image))
    # Newton's method on motions with backlash ends by a tolerance; the linear response is one solution of linear equations.
    tolerance = 1e-12 if law == "linear" else 1e-10
    if law == "backlash":
        one, other = one.refine(), other.refine()
        assert farthest(one.multipliers, other.multipliers) < 1e-8
    close(other.coefficients, sign * one.coefficients[order], tolerance, "coefficients")


# What is refused and what is marked


def test_mesh_with_a_held_gear_alone():
    """The limits of stiffness and damping take a held body as one that does not move, not as one without inertia."""
    bodies = [gt.Body(name="arm", inertia=0.01, torque=50.0), gt.Body(name="ring", held=True),
              gt.Body(name="planet", inertia=0.005), gt.Body(name="load", inertia=0.008, balances=True)]
    train = train_of(bodies, [mesh_of("planet", "ring", (20, 35), carrier="arm", internal=True, stiffness=3e8)],
                     [gt.Shaft(between=("planet", "load"), stiffness=2e5, damping_ratio=0.03)])
    np.testing.assert_allclose(train.natural_frequencies(), Model(train).frequencies, rtol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_held_body_that_the_gears_hold_anyway(seed):
    """A held body whose speed is 0 by the other gears adds no condition."""
    speed = np.random.default_rng(seed).uniform(0.6, 1.5, 2)
    bodies = [gt.Body(name="one", inertia=0.01, torque=50.0), gt.Body(name="two", inertia=0.01, balances=True),
              gt.Body(name="three", held=True)]
    share = speed[1] / speed.sum()
    meshes = [gt.Mesh(between=("three", "one"), carrier="two", internal=True, driving_radius=0.07, driven_radius=0.07 * share,
                      stiffness=5e8, damping_ratio=0.05),
              gt.Mesh(between=("one", "two"), driving_radius=0.04, driven_radius=0.04 * speed[0] / speed[1], stiffness=5e8,
                      damping_ratio=0.05)]
    train = train_of(bodies, meshes)
    np.testing.assert_allclose(train.natural_frequencies(), Model(train).frequencies, rtol=1e-9)


def test_warning_names_a_spring_to_ground():
    train = planetary(held=None, bodies={"ring": {"stiffness_to_ground": 1e4}}, sun_mesh=LINEAR, ring_mesh=LINEAR)
    assert all(text.isprintable() and "mesh 0" not in text for text in train.warnings)


def test_a_mesh_apart_in_a_loop_does_not_float():
    """A planet that its torque presses on the ring has one position, whatever its mesh with the sun does."""
    train = planetary(planet={"torque": (0.0, 2.0, 0.0)}, sun_mesh={"half_backlash": (15e-6, 40e-6, 15e-6)}, phases=False)
    motion = train.response(start=2.0, stop=2.01, harmonics=8).at(2.0)[0].refine()
    apart = motion.separation_fraction[1] > 0.999
    unique = np.abs(motion.multipliers - 1).min() > 1e-6
    assert not (apart and unique and motion.floating)


def test_refinement_repeats_itself():
    """The ring on a shaft to a held body: one motion, the same numbers each time."""
    train = planetary()
    bodies = [replace(body, held=None) if body.name == "ring" else body for body in train.bodies]
    train = replace(train, bodies=[*bodies, gt.Body(name="wall", held=True)],
                    shafts=[gt.Shaft(between=("ring", "wall"), stiffness=2e6, damping_ratio=0.05)])
    branch = train.response(start=0.3, stop=3.0, harmonics=8)
    means = [branch.at(1.5)[-1].refine().mean for _ in range(20)]
    for mean in means[1:]:
        close(mean, means[0], 1e-10, "mean")
