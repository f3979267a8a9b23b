"""How planets share the load: placement errors, meshes apart at rest, load shares as results."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT
from planetary_model import Flow, Model
from planetary_trains import FREQUENCY, RING_MESH, SUN_MESH, TEETH, planetary, radius, train_of
from test_carriers import close, same_motion, shot

import geartrain as gt
from geartrain.plots.planetary_picture import planet_angles

LINEAR = {"stiffness_cos": None, "stiffness_sin": None}


def misplaced(errors, torque=300.0, drag=0.0, **more):
    """The stage of `planetary_trains` with planets placed with errors, which shift both their meshes."""
    return planetary(len(errors), torque=torque, planet={"torque": drag} if drag else None,
                     sun_mesh={"error_mean": errors, **more}, ring_mesh={"error_mean": errors, **more})


def shares_at_rest(train):
    number = len(train.meshes) // 2
    force = np.array([train.explain()[f"mesh {mesh}"]["mean_force"] for mesh in range(1, number + 1)])
    return force / force.sum()


@pytest.mark.parametrize("errors", [
    (0.0, 0.0, 0.0), (0.0, 2e-6, -1e-6), (0.0, 0.0, -20e-6), (0.0, 15e-6, -20e-6), (3e-6, 3e-6, 3e-6),
    (0.0, 1e-6, -1e-6, 2e-6), (0.0, 4e-6, -30e-6, 1e-6, -3e-6),
])
def test_shares_at_rest(errors):
    """Planets as springs in parallel, each with its error: those of the largest errors bear, as many as the load reaches."""
    planets = len(errors)
    teeth = {3: TEETH, 4: (20, 20, 60), 5: (19, 21, 61)}[planets]
    load = 300.0 / radius(teeth[0])
    stiffness = 1 / (1 / SUN_MESH["stiffness"] + 1 / RING_MESH["stiffness"])
    place = 2 * np.array(errors)
    bears = np.zeros(planets, bool)
    for number in np.argsort(-place):  # the next planet joins while the level of the others is above its place
        bears[number] = True
        common = (load / stiffness - place[bears].sum()) / bears.sum()
        if common + place[number] <= 0:
            bears[number] = False
            break
    common = (load / stiffness - place[bears].sum()) / bears.sum()
    known = np.where(bears, stiffness * (common + place), 0.0)
    train = planetary(planets, teeth, sun_mesh={"error_mean": errors}, ring_mesh={"error_mean": errors})
    told = train.explain()
    for kind in range(2):
        found = [told[f"mesh {kind * planets + number}"]["mean_force"] for number in range(1, planets + 1)]
        np.testing.assert_allclose(found, known, rtol=1e-11, atol=1e-11 * load)
    (stage,) = (group for name, group in told.items() if name.startswith("planetary"))
    np.testing.assert_allclose(stage["load_share"], known / load, rtol=1e-11, atol=1e-11)
    assert stage["mesh_load_factor"] == pytest.approx(planets * known.max() / load, rel=1e-11)


def test_interference_of_linear_meshes():
    """Without backlash a thick tooth loads both flanks of a loop even without any torque."""
    train = planetary(torque=0.0, sun_mesh={**LINEAR, "half_backlash": 0.0, "error_mean": (9e-6, 0.0, 0.0)},
                      ring_mesh={**LINEAR, "half_backlash": 0.0})
    stiffness = 1 / (1 / SUN_MESH["stiffness"] + 1 / RING_MESH["stiffness"])
    force = np.array([train.explain()[f"mesh {mesh}"]["mean_force"] for mesh in range(1, 7)])
    np.testing.assert_allclose(force, np.tile([2, -1, -1], 2) * stiffness * 3e-6, rtol=1e-11)


MISPLACED = {
    "all bear": lambda: misplaced((0.0, 1.5e-6, -1e-6)),
    "one apart at rest": lambda: misplaced((0.0, 0.0, -20e-6), drag=-0.5),
    "two apart at rest": lambda: misplaced((0.0, -22e-6, -20e-6), drag=-0.5),
    "back flanks bear": lambda: misplaced((0.0, 0.0, 40e-6), torque=20.0, half_backlash=5e-6),
    "damping in contact": lambda: misplaced((0.0, 1e-6, -20e-6), drag=-0.5, damping_acts="contact"),
    "linear": lambda: misplaced((0.0, 3e-6, -2e-6), half_backlash=0.0, **LINEAR),
    "coast": lambda: misplaced((0.0, 1.5e-6, -1e-6), torque=-300.0),
    "five planets": lambda: planetary(5, (19, 21, 61), torque=200.0, sun_mesh={"error_mean": (0.0, 1e-6, 0.0, -1e-6, 0.5e-6)}),
    "star": lambda: planetary(held="arm", last="ring", ring_mesh={"error_mean": (0.0, 4e-6, -1e-6)}),
}


@pytest.mark.parametrize("name", [
    "one apart at rest", *(pytest.param(name, marks=pytest.mark.full) for name in MISPLACED if name != "one apart at rest")])
@pytest.mark.parametrize("place", [1.5, *(pytest.param(place, marks=pytest.mark.nightly) for place in (0.9, 2.1))])
def test_motions_of_misplaced_planets(name, place):
    """Mean, AC, extremes, multipliers, and the load shares, against equations of the tests' own."""
    branch = MISPLACED[name]().response(start=place, stop=1.01 * place, harmonics=12)
    for motion in branch.at(place)[:1]:
        exact = same_motion(motion)
        orbit, planets = shot(exact), len(exact.load_share)
        force, largest = orbit.force_mean[:planets], orbit.force_maximum[:planets]
        if force.sum() < 0:
            largest = -orbit.force_minimum[:planets]
        close(exact.load_share, force / force.sum(), 1e-8, "load share", 1.0)
        # Largest and smallest force are the figures of the direction of the static force.
        there = np.sign(force) == np.sign(force.sum())
        close(exact.load_share_maximum[there], (largest / abs(force.sum()))[there], 1e-7, "largest share", largest.max())
        close(motion.load_share, exact.load_share, 20 * max(motion.error_estimate, 1e-12), "load share of the balance", 1.0)


def test_an_error_between_sun_and_ring_shifts_nothing():
    """Only the sum of both errors of a planet is felt: a planet turned by itself has the errors +d and -d."""
    settings = {"start": 1.5, "stop": 1.52, "harmonics": 8}
    train = misplaced((0.0, 1e-6, -1e-6))
    turned = replace(train, meshes=[
        replace(mesh, error_mean=(mesh.error_mean or 0.0) + (7e-6 if "sun" in mesh.between else -7e-6)) for mesh in train.meshes])
    one, other = train.response(**settings), turned.response(**settings)
    close(other.at(1.51)[0].coefficients, one.at(1.51)[0].coefficients, 1e-10, "coefficients")


def test_an_error_in_a_tree_shifts_nothing():
    pinion = gt.Body(name="pinion", inertia=2e-3, torque=100.0)
    wheel = gt.Body(name="wheel", inertia=9e-3, balances=True)
    mesh = gt.Mesh(between=("pinion", "wheel"), driving_radius=0.04, driven_radius=0.07, stiffness=4e8, damping_ratio=0.05,
                   half_backlash=1e-5, stiffness_cos=[0.2])
    one, other = (train_of([pinion, wheel], [replace(mesh, error_mean=error)]).response(start=0.8, stop=0.82, harmonics=6)
                  for error in (None, 5e-6))
    assert np.array_equal(one.coefficients, other.coefficients)


def test_bodies_on_springs_in_a_loop():
    """A loop through ground: two bodies on springs and a mesh with backlash between them."""
    bodies = [gt.Body(name="pinion", inertia=2e-3, torque=150.0, torque_cos=[20.0], stiffness_to_ground=4e5, damping_to_ground=1.0),
              gt.Body(name="wheel", inertia=9e-3, torque=-30.0, stiffness_to_ground=6e5, damping_to_ground=2.0)]
    mesh = gt.Mesh(between=("pinion", "wheel"), driving_radius=0.04, driven_radius=0.07, stiffness=4e8, damping_ratio=0.05,
                   half_backlash=2e-6, stiffness_cos=[0.2], error_mean=1e-6)
    train = train_of(bodies, [mesh])
    same_motion(train.response(start=1.0, stop=1.02, harmonics=10).at(1.01)[0])


def test_settling_of_misplaced_planets():
    """Time integration from rest comes to the motion of the balance."""
    train = misplaced((0.0, 1.5e-6, -1e-6))
    settled = train.integrate(0.55)
    (motion,) = (found.refine() for found in train.response(start=0.55, stop=0.56, harmonics=12).at(0.55)[:1])
    close(settled.coefficients[:, :9], motion.coefficients[:, :9], 1e-7, "coefficients")
    close(settled.load_share, motion.load_share, 1e-7, "load share", 1.0)


@pytest.mark.nightly
def test_run_up_of_misplaced_planets():
    train, duration, start, stop = misplaced((0.0, 1.5e-6, -1e-6), drag=-0.5), 0.01, 0.6, 0.7
    found = train.run_up(start=start, stop=stop, duration=duration)
    model = Model(train)
    flow = Flow(model, start).accelerate((stop - start) / (duration * model.omega), 0.0 * model.speed)
    steady = Flow(model, start)
    state, time = steady.shoot(steady.settle(60)).state, 0.0
    for sample in (0, 50, 150):
        if sample:
            state, _ = flow.run(state, time, found.time[sample] * FREQUENCY, tangents=False)
            time = found.time[sample] * FREQUENCY
        close(found.displacement[sample], flow.displacement(time, state), 1e-7, f"sample {sample}")


def test_gradient_with_respect_to_an_error():
    train = misplaced((0.0, 1.5e-6, -1e-6))
    name, step = "mesh 2 error_mean", 3e-9
    motion = train.response(start=1.5, stop=1.51, harmonics=10, stability=False).at(1.5)[0]
    changed = []
    for sign in (-1, 1):
        meshes = list(train.meshes)
        meshes[1] = replace(meshes[1], error_mean=meshes[1].error_mean + sign * step)
        changed += replace(train, meshes=meshes).response(start=1.5, stop=1.51, harmonics=10, stability=False).at(1.5)[:1]
    for figure in ("mean", "mesh_force_maximum"):
        found = motion.gradient(figure, [name])[:, 0]
        values = [getattr(other, figure) for other in changed]
        close(found, (values[1] - values[0]) / (2 * step), 1e-5, figure)


def test_branch_over_an_error():
    """Shares along a branch over the error of a planet, from contact of all planets to one apart."""
    train = misplaced((0.0, 0.0, -1e-6), drag=-0.5)
    branch = train.continuation(parameter="mesh 3 error_mean", start=-1e-6, stop=-15e-6, frequency=0.55, harmonics=6)
    assert branch.complete
    assert branch.load_share[0, 2] > 0.25 and branch.load_share[-1, 2] < 0.05
    np.testing.assert_allclose(branch.load_share.sum(axis=1), 1.0, rtol=1e-12)


# The short form


def short(**more):
    bodies = [gt.Body(name="sun", inertia=8.2e-4, torque=600.0), gt.Body(name="ring", held=True),
              gt.Body(name="arm", inertia=0.085, balances=True)]
    stage = gt.Planetary(**{**dict(
        name="stage 1", sun="sun", ring="ring", carrier="arm", teeth=(27, 36, 99), planets=3, normal_module=4e-3,
        planet_inertia=2.2e-3, stiffness=(1e9, 1.2e9), half_backlash=(4e-5, 5e-5), damping_ratio=0.03, stiffness_harmonics=2),
        **more})
    return gt.Train(bodies=bodies, planetaries=[stage])


def test_planet_errors_are_those_of_both_meshes():
    train = short(planet_errors=(0.0, 5e-6, -2e-6))
    assert [mesh.error_mean or 0.0 for mesh in train.meshes] == 2 * [0.0, 5e-6, -2e-6]
    told = train.explain()["stage 1"]
    assert np.argmax(told["load_share"]) == 1  # positive: the planet bears more
    with pytest.raises(gt.InputError, match="planet_errors = 2 values: must be 3 values, one a planet"):
        short(planet_errors=(0.0, 1e-6))


PLANET = "mesh stage 1 sun 2 error_mean, mesh stage 1 ring 2 error_mean"


def test_parameters_that_take_the_same_value():
    """The place of a planet is the error_mean of both its meshes: the response over it has the motions of trains with these."""
    branch = short().response(start=0.0, stop=6e-6, parameter=PLANET, frequency=2200.0, harmonics=4, stability=False)
    assert branch.complete and branch.parameter_name == PLANET and branch.parameter_unit == "m"
    for error in (1e-6, 4e-6):
        given = short(planet_errors=(0.0, error, 0.0)).response(start=2190.0, stop=2210.0, harmonics=4, stability=False)
        close(branch.at(error)[0].rms, given.at(2200.0)[0].rms, 1e-7, f"rms at an error of {error}")
    motion = branch.at(4e-6)[0]
    both = motion.gradient("rms", PLANET.split(", ")).sum(axis=1)
    close(motion.gradient("rms", [PLANET])[:, 0], both, 1e-9, "derivative with respect to both")  # of differences of trains
    with pytest.raises(gt.InputError, match="names one number twice"):
        motion.gradient("rms", ["mesh 2 error_mean, mesh stage 1 sun 2 error_mean"])
    with pytest.raises(gt.InputError, match="have the same unit"):
        motion.gradient("rms", ["mesh 1 error_mean, mesh 1 stiffness"])
    with pytest.raises(gt.InputError, match="stands for all harmonics by itself"):
        motion.gradient("rms", ["stiffness_variation, mesh 1 damping_ratio"])
    with pytest.raises(gt.InputError, match="at most 399 characters"):
        motion.gradient("rms", [", ".join(f"mesh {number} stiffness_cos {number}" for number in range(1, 20))])
    with pytest.raises(gt.InputError, match=r"must tell which &mesh: 1 to 6, or [*] for all, or its name"):
        motion.gradient("rms", ["mesh stage 1 sun 4 error_mean"])


@pytest.fixture(scope="module")
def branch():
    return short(planet_errors=(0.0, 3e-6, -2e-6)).response(start=2000.0, stop=2400.0, unit="rpm", harmonics=4, stability=False)


def test_report_tells_the_mesh_load_factor(branch):
    factor, largest = 3 * branch.load_share.max(), 3 * branch.load_share_maximum.max()
    words = " ".join(branch.report().split())
    assert f"Planets of stage 1: mesh load factor K_gamma (largest mean load over an even share) at most {factor:.4g}"[:-2] in words
    assert f"largest force of a planet {largest:.4g}"[:-2] in words and "of planet 2 at" in words


def test_shares_in_files_and_tables(branch, tmp_path):
    path = tmp_path / "shares.h5"
    branch.write(path)
    again = gt.read_results(path).response
    assert np.array_equal(again.load_share, branch.load_share)
    assert np.array_equal(again.load_share_maximum, branch.load_share_maximum)
    points = branch.to_dataset()
    assert list(points.planet_label.values) == [f"stage 1 planet {number}" for number in (1, 2, 3)]
    assert points.load_share.dims == ("point", "planet")
    assert "load_share, planet 2" in branch.to_dataframe().columns
    motion = branch.at(branch.frequency[3])[0]
    close(motion.load_share, branch.load_share[3], 1e-12, "load share of a motion")


def test_picture_of_load_sharing(branch):
    ax = branch.plot(quantity="load_share")
    assert ax.get_ylabel() == "share of the mean load of the planets"
    assert len(ax.lines) >= 3
    with pytest.raises(gt.InputError, match="is of each planet, and of no other part"):
        branch.plot(quantity="load_share", mesh=1)


def test_trains_without_planets_have_no_shares():
    pinion = gt.Body(name="pinion", inertia=2e-3, torque=100.0)
    wheel = gt.Body(name="wheel", inertia=9e-3, balances=True)
    train = train_of([pinion, wheel], [gt.Mesh(between=("pinion", "wheel"), driving_radius=0.04, driven_radius=0.07,
                                               stiffness=4e8)])
    branch = train.response(start=0.8, stop=0.82, harmonics=2)
    assert branch.load_share is None and branch.at(0.81)[0].load_share is None


# Symmetry, modes, pictures


def test_motions_are_counted_up_to_a_turn_of_the_planets(branch):
    """Sequential planets may all move on by one place; two of them may change places only in phase."""
    turned, swapped = [1, 2, 0, 4, 5, 3], [1, 0, 2, 4, 3, 5]
    for teeth, known in (((26, 31, 88), [1, 1, 2]), ((27, 36, 99), [1, 1, 1])):
        train = short(teeth=teeth)
        even = replace(branch.at(branch.frequency[3])[0], rms=np.ones(6), mean=np.ones(6), minimum=-np.ones(6), maximum=np.ones(6))
        flat = [replace(even, train=train, **{
            name: getattr(even, name) * np.tile([1.0, 2.0, 3.0], 2)[order] for name in ("rms", "mean", "minimum", "maximum")})
            for order in (list(range(6)), turned, swapped)]
        motions = gt.Motions([(motion, "made") for motion in flat])
        assert sorted(motions.orbit) == known
        words = f"up to a turn of the planets of symmetric sets these are {max(known)} motion"
        assert words in str(motions) and words in repr(motions)


@pytest.mark.parametrize("teeth, planets", [((27, 36, 99), 3), ((20, 20, 60), 4), ((19, 21, 61), 5)])
def test_modes_are_torsional_or_of_planets(teeth, planets):
    """N - 1 equal modes of the planets at sqrt((k_s + k_r)/m_p); the others are torsional."""
    modes = short(teeth=teeth, planets=planets).modes()
    own = np.array(modes.kind) == "planets of stage 1"
    assert own.sum() == planets - 1 and (np.array(modes.kind)[~own] == "torsional").all()
    known = np.sqrt(2.2e9 / 2.2e-3) * radius(teeth[1]) / (2 * np.pi)
    np.testing.assert_allclose(modes.natural_frequency_hertz[own], known, rtol=1e-9)
    assert "planets of stage 1" in str(modes)


def test_planet_pass_orders():
    diagram = short().campbell(start=500.0, stop=4000.0, unit="rpm")
    assert diagram.planet_passes == {"stage 1": pytest.approx(3 * 27 / 126, rel=1e-12)}
    labels = [text.get_text() for text in diagram.plot().get_legend().get_texts()]
    assert any(label.startswith("planet pass of stage 1") for label in labels)


def test_stage_picture():
    train = short()
    ax = train.plot_stage()
    front, lever = ax.figure.axes
    assert front is ax and lever.get_xlabel() == "turns per turn of sun"
    assert "speed" in train.plot_stage("stage 1", speed=1500.0).figure.axes[1].get_xlabel()
    with pytest.raises(gt.InputError, match="name = 'stage 2': must be 'stage 1'"):
        train.plot_stage("stage 2")


def test_angles_of_planets_follow_from_their_phases():
    angles = (0.0, 99.0, 189.0, 270.0)
    told = short(teeth=(19, 21, 61), planets=None, angles=angles).explain()["stage 1"]
    np.testing.assert_allclose(360 * planet_angles(told, 19), angles, atol=1e-9)


def test_planets_turn_with_the_sun_in_the_picture():
    """Positive speeds turn counter-clockwise; the sun of the long planets of a Ravigneaux set turns backwards, as their angles."""
    train = gt.read_case(ROOT / "namelists" / "ravigneaux.nml").train
    for name in ("short", "long"):
        words = {text.get_text().split("\n")[0]: text.xy for text in train.plot_stage(name).texts}
        angles = [np.degrees(np.arctan2(-words[planet][0], words[planet][1])) % 360 for planet in "123"]
        np.testing.assert_allclose(angles, [0.0, 120.0, 240.0], atol=1e-9, err_msg=name)
    split = gt.read_case(ROOT / "namelists" / "hybrid.nml").train.plot_stage("split")  # whose sun turns backwards
    (x, y), = (text.xy for text in split.texts if text.get_text().startswith("2\n"))
    assert x > 0 and y == pytest.approx(0.0, abs=1e-9 * x)
