"""Symmetric planetary sets: motions are found with their images, and counted up to the symmetry of the set."""

import subprocess
import sys

import numpy as np
import pytest

import geartrain as gt
from geartrain.results.planet_images import PlanetImages


def stage(planets=3, teeth=(27, 36, 99), **more):
    """A set with its ring held, in short form."""
    values = {"name": "s", "sun": "sun", "ring": "ring", "carrier": "arm", "teeth": teeth, "planets": planets,
              "normal_module": 4e-3, "planet_inertia": 2.2e-3, "stiffness": [1e9, 1.2e9], "half_backlash": [20e-6, 25e-6],
              "damping_ratio": [0.03], "sun_stiffness_cos": [0.3, 0.08], "ring_stiffness_cos": [0.2, 0.1],
              "sun_error_cos": [2e-6], "ring_phase": 0.4, **more}
    bodies = [gt.Body(name="sun", inertia=8.2e-4, torque=300.0), gt.Body(name="ring", held=True),
              gt.Body(name="arm", inertia=0.085, balances=True)]
    return gt.Train(characteristic_length=1e-5, characteristic_frequency=2e4, bodies=bodies, shafts=[],
                    planetaries=[gt.Planetary(**values)])


def followed(response, words):
    return next(branch for branch in response.branches if words in branch.origin)


@pytest.mark.full
@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
@pytest.mark.parametrize("planets, teeth, kind", [(3, (27, 36, 99), 2), (4, (20, 20, 60), 3)])
def test_branches_that_break_the_symmetry(planets, teeth, kind):
    """Planets in phase: N - 1 multipliers +1 together, one branch for each pattern, and the exact point from the balance's."""
    ends = {3: (2.75, 2.9), 4: (1.45, 1.6)}[planets]
    response = stage(planets, teeth).response(start=ends[0], stop=ends[1], harmonics=8, branch_points=True)
    point, = (special for special in response.special_points if special.kind == "branch point")
    assert point.multiplicity == kind
    exact = point.exact()
    assert abs(exact.frequency - point.frequency) < 1e-3 and exact.multiplicity == kind
    assert np.abs(exact.critical - 1).max() < 1e-8
    branch = followed(response, f"1 of {planets} equal branches against {planets - 1}")
    assert np.ptp(branch.rms[:, 1:planets], axis=1).max() < 1e-9 < 1e-3 < np.abs(branch.rms[:, 0] - branch.rms[:, 1]).max()
    # Shooting knows no symmetry.
    motion = branch.at(branch.frequency[len(branch) // 4])[0]
    np.testing.assert_allclose(motion.refine().rms, motion.rms, atol=3 * motion.error_estimate * motion.rms.max())


@pytest.mark.parametrize("teeth", [(27, 36, 99), (26, 31, 88)])
def test_symmetric_motions_stay_so(teeth):
    """In phase all planets move equally; in sequence each one a third of the mesh cycle after the one before it."""
    train = stage(teeth=teeth)
    motion = train.response(start=1.9, stop=1.92, harmonics=8).at(1.9)[0]
    for each in (motion, motion.refine()):
        assert not list(PlanetImages(train).of(each))
        assert np.ptp(each.rms[:3]) < 1e-9


@pytest.mark.parametrize(("planets", "teeth", "asked"), [
    (3, (26, 31, 88), {"start": 1.2, "stop": 2.2, "harmonics": 8}),
    (4, (21, 19, 59), {"start": 2.2, "stop": 3.2, "harmonics": 8}),
    (6, (29, 16, 61), {"start": 1.1, "stop": 2.2, "harmonics": 8}),
    (5, (19, 21, 61), {"start": 1.1, "stop": 1.9, "harmonics": 8}),
    (5, (19, 21, 61), {"start": 1.3, "stop": 1.6, "harmonics": 0}),
    (5, (19, 21, 61), {"start": 1.3, "stop": 1.4, "harmonics": 48}),
])
@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_one_planet_stands_for_all_in_sequence(planets, teeth, asked):
    """The same branch, and what lies on it, without the symmetry: a planet is 1e-14 m off its place."""
    errors = [1e-14] + [0.0] * (planets - 1)
    one, other = (stage(planets, teeth, **more).response(**asked) for more in ({}, {"planet_errors": errors}))
    low, high = asked["start"], asked["stop"]
    for at in np.linspace(low, high, 7)[1:-1]:
        a, b = (sorted(branch.at(at), key=lambda motion: motion.rms[0]) for branch in (one, other))
        assert len(a) == len(b) > 0
        for first, second in zip(a, b):
            assert np.allclose(first.rms, second.rms, rtol=1e-5, atol=0) and first.stable == second.stable
            assert np.ptp(first.rms[:planets]) < 1e-12 * first.rms[0]
    assert [special.kind for special in one.special_points] == [special.kind for special in other.special_points]
    assert np.allclose([special.frequency for special in one.special_points],
                       [special.frequency for special in other.special_points], rtol=1e-5)


@pytest.fixture(scope="module")
def broken():
    """Branch of motions in which one planet moves by itself."""
    response = stage().response(start=2.75, stop=2.9, harmonics=8, branch_points=True)
    return followed(response, "1 of 3 equal branches against 2")


def test_images_are_motions(broken):
    """Of a motion whose planets differ: each planet in the place of the first, as shooting finds it."""
    exact = broken.at(broken.frequency[len(broken) // 2])[0].refine()
    images = list(PlanetImages(exact.train).of(exact))
    assert len(images) == 2
    orders = [np.argmax(np.abs(image.coefficients[:3, 0] - np.median(image.coefficients[:3, 0]))) for image in (exact, *images)]
    assert sorted(orders) == [0, 1, 2]
    for image in images:
        again = image.refine()
        np.testing.assert_allclose(again.coefficients[:, 0], image.coefficients[:, 0], rtol=1e-8)
        np.testing.assert_allclose(np.sort(again.rms), np.sort(exact.rms), rtol=1e-8)
        np.testing.assert_allclose(np.sort(np.abs(again.multipliers)), np.sort(np.abs(exact.multipliers)), atol=1e-7)
    # The meshes of planet 3 do what those of planet 2 do.
    assert [PlanetImages(exact.train).repeats(exact, mesh) for mesh in range(1, 7)] == 2 * [False, False, True]


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_every_other_planet_begins_to_move_by_itself():
    """An even number of planets in sequence: branches leave on which every other planet moves differently."""
    response = stage(4, (21, 19, 59)).response(start=1.1, stop=2.2, harmonics=20, branch_points=True)
    points = [special for special in response.special_points if special.kind == "branch point"]
    assert len(points) > 1
    for point in points:
        exact = point.exact()  # by shooting, which knows no symmetry
        assert exact.frequency == pytest.approx(point.frequency, rel=1e-4) and exact.multiplicity == 1
        assert np.abs(exact.critical - 1).max() < 1e-8
    left = next(branch for branch in response.branches if "branch point" in branch.origin)
    apart = np.abs(left.rms[:, 0] - left.rms[:, 1])
    motion = left.at(left.frequency[apart.argmax()])[0]
    assert np.ptp(motion.rms[:4:2]) < 1e-6 * motion.rms[0] < 1e-3 * abs(motion.rms[0] - motion.rms[1])


@pytest.mark.nightly
def test_basins_count_orbits():
    """At this speed one planet moves by itself, whichever it is: one motion up to a turn of the planets. Another has period 2."""
    basins = stage().basins(frequency=2.95, mesh=1, points=(4, 4))
    assert sum(motion.period == 1 for motion in basins.motions) > 1
    assert len({orbit for orbit, motion in zip(basins.orbit, basins.motions) if motion.period == 1}) == 1
    assert max(basins.orbit) == 2


@pytest.mark.nightly
def test_every_motion_of_a_symmetric_set():
    """Images are found with each motion, so that the indices of all seven add up: they are three up to a turn of planets."""
    found = stage().motions(frequency=2.95, period=1, starts=4, seeds=2)
    assert found.complete
    assert len(found) == 7
    assert sorted(np.bincount(found.orbit)[1:]) == [1, 3, 3]
    assert "these are 3 motions" in str(found)


def test_edges_of_planets_in_sequence():
    """Planets in sequence lose contact at one speed, which is solved for once: there each mesh just touches."""
    branch = stage(teeth=(26, 31, 88)).response(start=1.3, stop=1.5, harmonics=8)
    onsets = [(onset.mesh, onset.frequency) for onset in branch.onsets]
    assert [mesh for mesh, _ in onsets] == [1, 2, 3, 1, 2, 3]
    for mesh, frequency in onsets:
        # The gap of a sun mesh is 2 characteristic lengths.
        assert min(abs(motion.minimum[mesh - 1] - 2.0) for motion in branch.at(frequency)) < 1e-6


def test_equal_planets_rattle_without_end(tmp_path):
    """An unloaded stage whose planets meet their flanks at one instant: rounding made events without end at 1800 rpm."""
    case = tmp_path / "stage.nml"
    case.write_text("""
&train speed_of = 'generator' /
&body name = 'rotor', inertia = 825149.974780143, torque = 6440.0 /
&body name = 'carrier', inertia = 60.0 /
&body name = 'ring', held = .true. /
&body name = 'sun' /
&body name = 'wheel 2' /
&body name = 'pinion 2' /
&body name = 'generator', inertia = 30.279465547651203, balances = .true. /
&shaft between = 'rotor', 'carrier', stiffness = 15746815.38781002, damping_ratio = 0.03 /
&planetary name = 'stage 1', sun = 'sun', ring = 'ring', carrier = 'carrier', teeth = 21, 30, 81, planets = 3,
   normal_module = 10e-3, helix_angle = 7.5, face_width = 0.230, planet_bore = 0.1, backlash = 318.01481413169677e-6,
   damping_ratio = 0.07963708138682965, stiffness_harmonics = 3, sun_error_cos = 2.211694059141936e-05,
   ring_error_cos = 2.211694059141936e-05 /
&shaft between = 'sun', 'wheel 2', diameter = 0.180, length = 0.32569128440389716, damping_ratio = 0.03 /
&mesh between = 'wheel 2', 'pinion 2', teeth = 77, 24, normal_module = 8.25e-3, helix_angle = 14.0, face_width = 0.170,
   backlash = 250e-6, damping_ratio = 0.05, stiffness_harmonics = 3, error_cos = 1.769355247313549e-05 /
&shaft between = 'pinion 2', 'generator', diameter = 0.110, length = 0.7123158791075201, damping_ratio = 0.03 /
&modes /
""")
    call = f"""
import geartrain as gt
motion = gt.read_case({str(case)!r}).train.integrate(1800.0, unit="rpm", max_periods=4, window=20)
assert motion.separation_fraction.min() > 0.1 and motion.kind != "stationary"
"""
    subprocess.run([sys.executable, "-W", "ignore", "-c", call], check=True, timeout=60)


@pytest.mark.full  # three motions by shooting
def test_a_band_ends_at_the_branch_point_of_another_segment():
    """Two planets half a cycle apart part in a pitchfork, listed with one of the segments that meet there."""
    bodies = [gt.Body(name="motor", inertia=0.02, torque=100.0), gt.Body(name="sun"), gt.Body(name="ring", held=True),
              gt.Body(name="carrier", inertia=0.05), gt.Body(name="load", inertia=2.0, balances=True)]
    shafts = [gt.Shaft(between=("motor", "sun"), diameter=0.045, length=0.2, damping_ratio=0.01),
              gt.Shaft(between=("carrier", "load"), diameter=0.09, length=0.25, damping_ratio=0.01)]
    two = gt.Planetary(name="s", sun="sun", ring="ring", carrier="carrier", teeth=[19, 21, 61], planets=2, normal_module=2.5e-3,
                       face_width=0.03, planet_bore=0.015, backlash=80e-6, damping_ratio=0.04, stiffness_harmonics=3,
                       sun_error_cos=8e-6, ring_error_cos=8e-6)
    branch = gt.Train(bodies=bodies, shafts=shafts, planetaries=[two]).response(
        start=2250.0, stop=2400.0, unit="rpm", harmonics=0, tolerance=1e-3)
    point, = (special.frequency for special in branch.special_points if special.kind == "branch point")
    # Beside the pitchfork the planets' own motions are undecided: where they count as stable, no band comes near it.
    for edge in branch.bands_without_stability.ravel():
        assert abs(edge - point) < 1e-9 * point or abs(edge - point) > 5.0
    for at in (2337.0, 2338.6):
        motion = min(branch.at(at), key=lambda one: np.ptp(one.rms[:2]))
        assert at < point and np.ptp(motion.rms[:2]) < 1e-6 and motion.refine().stable


@pytest.mark.full
def test_verdicts_where_growth_is_steep():
    """Between 9693.8 and 9694.3 rpm the largest multiplier of a further branch is 1.45, 0.99, 1.35: no decided point is wrong."""
    train = gt.Train(
        bodies=[gt.Body(name="motor", inertia=0.05, torque=20.0), gt.Body(name="sun", inertia=1e-3),
                gt.Body(name="ring", held=True), gt.Body(name="arm", inertia=0.02, balances=True)],
        shafts=[gt.Shaft(between=("motor", "sun"), stiffness=1e4, damping_ratio=0.05)],
        planetaries=[gt.Planetary(name="set", sun="sun", ring="ring", carrier="arm", teeth=(30, 24, 78), planets=3,
                                  normal_module=2e-3, face_width=0.02, damping_ratio=0.04, backlash=30e-6, stiffness=(2e8, 2.5e8),
                                  stiffness_harmonics=2, sun_error_cos=3e-6, planet_inertia=1.5e-4)])
    branch = train.response(start=3000, stop=20000, unit="rpm", harmonics=0, tolerance=1e-3, branch_points=True)
    steep = 0
    for further in branch.branches:
        for place in np.flatnonzero(~further.undecided & (abs(further.frequency - 9693.8) < 100)):
            found = further.at(float(further.frequency[place]), unit="rpm")
            motion = found[np.argmin([np.abs(one.rms - further.rms[place]).max() for one in found])]
            try:
                refined = motion.refine()
            except gt.SolverError:  # shooting may lead nowhere where a multiplier is above 2, or the motion about to turn
                at = further.frequency[place]
                finer = train.response(seed=motion, start=at - 0.5, stop=at + 0.5, unit="rpm", harmonics=72, max_points=200)
                multipliers = finer.multipliers[np.argmin(abs(finer.frequency - at))]
            else:
                multipliers = refined.multipliers
            assert (np.abs(multipliers).max() < 1) == further.stable[place]
            steep += 1
    assert steep > 4
