"""Equal branches in phase: the planets of a star gear and parallel meshes, which begin to move differently."""

import re
from dataclasses import replace

import numpy as np
import pytest

import geartrain as gt
from geartrain import Body, Mesh, SolverError, Train

#: Lambda at which the star of three planets has the multiplier +1 twice: orbit by SciPy's DOP853 with contact events (relative
#: tolerance 3e-14) of sun, ring and one planet, and the multipliers of one difference mode, (k1 + k2) and (c1 + c2) on a planet.
DOUBLE = 5.189127180121
#: Base radii of 18, 21 and 60 teeth of 4 mm and 20 degrees [m].
SUN, PLANET, RING = (0.002 * teeth * np.cos(np.pi / 9) for teeth in (18, 21, 60))


def star(planets: int, split: int = 1, other: float = 1.0, torque: float = 600.0) -> Train:
    """A star gear; each mesh with the ring as ``split`` parallel ones; ``other`` is a factor of the last
    planet's inertia."""
    bodies = [Body(name="sun", inertia=8.2e-4, torque=torque)]
    meshes = []
    for i in range(planets):
        bodies.append(Body(name=f"planet {i}", inertia=2.2e-3 * (other if i == planets - 1 else 1)))
        meshes.append(Mesh(between=("sun", f"planet {i}"), driving_radius=SUN, driven_radius=PLANET, stiffness=1e9,
                           damping=1308.1774628606531, half_backlash=40e-6, stiffness_cos=[0.30, -0.06]))
        meshes += split * [Mesh(between=(f"planet {i}", "ring"), driving_radius=PLANET, driven_radius=RING,
                                stiffness=1.2e9 / split, damping=2303.7397824345276 / split, half_backlash=50e-6,
                                stiffness_cos=[0.20, 0.05])]
    bodies.append(Body(name="ring", inertia=0.12, balances=True))
    return Train(characteristic_length=40e-6, characteristic_frequency=2000 * np.pi, bodies=bodies, meshes=meshes)


def branch_points(branch):
    return [special for special in branch.special_points if special.kind == "branch point"]


def test_a_double_multiplier_is_a_branch_point_that_is_followed():
    train = star(3)
    response = train.response(start=5.1, stop=5.25, harmonics=8, branch_points=True)
    found, = branch_points(response)
    assert found.multiplicity == 2
    assert abs(found.frequency - DOUBLE) < 2e-4
    exact = found.exact()
    assert abs(exact.frequency - DOUBLE) < 1e-10
    assert (exact.crossing, exact.multiplicity, len(exact.critical)) == (2, 2, 2)
    # On the branch one planet moves by itself and two move equally.
    branch = next(branch for branch in response.branches if "1 of 3 equal branches against 2" in branch.origin)
    one, two, three = (branch.rms[:, mesh] for mesh in (0, 2, 4))
    assert np.abs(two - three).max() < 1e-12 < 1e-3 < np.abs(one - two).max()
    with pytest.raises(SolverError, match="several multipliers"):
        train.locus(exact, parameter="sun torque", start=550.0, stop=650.0)
    with pytest.raises(SolverError, match="no derivatives"):
        found.gradient(["sun torque"])


@pytest.mark.full
def test_integration_settles_on_a_branch_that_is_followed():
    """A random start reaches, at 5.6, a motion whose planets differ; the branch from the double point has it."""
    train = star(3)
    response = train.response(start=5.1, stop=5.85, harmonics=12, branch_points=True)
    settled = [motion for motion in train.attractors(frequency=5.6, starts=8)
               if motion.period == 1 and np.ptp(motion.rms[::2]) > 1e-3]
    assert settled
    points = [point for branch in response.branches for point in branch.at(5.6)]
    for motion in settled:
        assert min(np.abs(np.sort(point.rms) - np.sort(motion.rms)).max() for point in points) < 1e-3


@pytest.mark.parametrize("planets", [2, 3, 4, 5, 6, 7])
def test_any_number_of_planets(planets):
    response = star(planets).response(start=4.0, stop=6.5, harmonics=6)
    found = branch_points(response)
    assert found
    assert all(special.multiplicity == planets - 1 for special in found)
    # The multipliers on both sides, which the balance does not know, have N - 1 more outside on one of them.
    for special in found:
        outside = [(abs(response.multipliers[point]) > 1).sum() for point in (special.point, special.point + 1)]
        assert abs(outside[1] - outside[0]) == planets - 1


@pytest.mark.full
def test_patterns_of_five_planets():
    response = star(5).response(start=4.9, stop=5.4, harmonics=6, branch_points=True)
    origins = [branch.origin for branch in response.branches if "of the response" in branch.origin]
    assert [re.findall(r"(\d) of 5 equal branches against (\d)", origin) for origin in origins] == [[("1", "4")], [("2", "3")]]
    for branch, some in zip(response.branches, (1, 2)):
        suns = branch.rms[:, ::2]
        assert len(branch) > 5
        assert np.ptp(suns[:, :some], axis=1).max() < 1e-12
        assert np.ptp(suns[:, some:], axis=1).max() < 1e-12
        assert np.abs(suns[:, 0] - suns[:, -1]).max() > 1e-3


def test_meshes_split_into_parallel_ones():
    """Each planet has two equal meshes with the ring: the planets are equal as before, at the same Lambda."""
    whole, = branch_points(star(3).response(start=5.1, stop=5.25, harmonics=6))
    split, = branch_points(star(3, split=2).response(start=5.1, stop=5.25, harmonics=6))
    assert split.multiplicity == whole.multiplicity == 2
    assert abs(split.frequency - whole.frequency) < 1e-8


@pytest.mark.parametrize("ends", [(5.1, 5.25), (5.5, 5.85)])
def test_a_branch_point_is_exact_from_either_branch(ends):
    """Where unequal motions cross equal ones the unequal branch leads to the same exact point."""
    response = star(3).response(start=ends[0], stop=ends[1], harmonics=8, branch_points=True)
    special, = branch_points(response)
    exact = special.exact()
    crossing, = (point for point in branch_points(response.branches[0]) if point.multiplicity == 2)
    other = crossing.exact()
    assert abs(other.frequency - exact.frequency) < 1e-9
    assert (other.crossing, other.multiplicity) == (exact.crossing, exact.multiplicity) == (2, 2)
    np.testing.assert_allclose(other.motion.rms, exact.motion.rms, rtol=1e-7)


def test_unequal_planets_are_no_equal_branches():
    """One planet that is 1 percent heavier leaves two equal ones: a multiplier at a time."""
    response = star(3, other=1.01).response(start=5.0, stop=5.4, harmonics=6)
    assert all(special.multiplicity == 1 for special in response.special_points)


def test_a_double_doubling_is_one_special_point():
    response = star(3).response(start=12.8, stop=13.6, harmonics=6, period_doublings=1)
    found, = (special for special in response.special_points if special.kind == "period doubling")
    assert found.multiplicity == 2
    exact = found.exact()
    assert exact.crossing == 2
    assert np.abs(exact.critical + 1).max() < 1e-8
    branch = response.branches[0]
    assert "1 of 3 equal branches against 2" in branch.origin
    assert branch.subharmonic == 2 and len(branch) > 5
    assert np.abs(branch.rms[:, 2] - branch.rms[:, 4]).max() < 1e-12 < 1e-2 < np.abs(branch.rms[:, 0] - branch.rms[:, 2]).max()


def half_a_period_later(coefficients):
    """Coefficients of motions, (mesh, coefficient), half a period later: odd harmonics change their sign."""
    sign = np.ones(coefficients.shape[1])
    sign[1::4] = sign[2::4] = -1
    return coefficients * sign


@pytest.mark.parametrize("harmonics", [6, 20])
def test_two_planets_double_against_one_another(harmonics):
    """One planet moves half a period later as another does, while the third one has half the period."""
    response = star(3).response(start=12.8, stop=13.6, harmonics=harmonics, period_doublings=1)
    branch = response.branches[1]
    assert "1 of 3 equal branches against 1" in branch.origin
    assert branch.subharmonic == 2 and len(branch) > 5
    for coefficients in branch.coefficients:
        np.testing.assert_allclose(coefficients[[2, 3, 0, 1, 4, 5]], half_a_period_later(coefficients), atol=1e-10)
    assert np.abs(branch.rms[:, 0] - branch.rms[:, 4]).max() > 1e-2
    # Shooting knows no symmetry and finds the same motions, stable ones among them.
    refined = branch.refine()
    assert branch.stable.any()
    np.testing.assert_allclose(refined.rms[branch.stable], branch.rms[branch.stable], atol=2e-4)
    # Where this symmetry ends the multiplier +1 is simple. Nothing else is listed where the branch is vertical.
    special, = branch.special_points
    assert (special.kind, special.multiplicity) == ("branch point", 1)
    assert abs(special.frequency - 12.890832) < 2e-6


def test_four_planets_double_against_one_another():
    """One against one, while the two others move equally and have half the period; two against two without any others."""
    response = star(4).response(start=12.8, stop=13.2, harmonics=6, period_doublings=1)
    found = {re.search(r"(\d) of 4 equal branches against (\d)", branch.origin).groups(): branch for branch in response.branches}
    for pair, order in (("1", "1"), [2, 3, 0, 1, 4, 5, 6, 7]), (("2", "2"), [4, 5, 6, 7, 0, 1, 2, 3]):
        branch = found[pair]
        assert len(branch) > 5
        for coefficients in branch.coefficients:
            np.testing.assert_allclose(coefficients[order], half_a_period_later(coefficients), atol=1e-10)
    branch = found["1", "1"]
    assert np.abs(branch.rms[:, 4] - branch.rms[:, 6]).max() < 1e-12 < 1e-2 < np.abs(branch.rms[:, 0] - branch.rms[:, 4]).max()


@pytest.mark.full
def test_integration_settles_on_planets_that_double_against_one_another():
    """At 13.14 random starts reach this motion, in its three numberings, and no other."""
    train = star(3)
    response = train.response(start=13.0, stop=13.3, harmonics=12, period_doublings=1)
    motion, = response.branches[1].at(13.14)
    settled = train.attractors(frequency=13.14, starts=6)
    assert settled
    for other in settled:
        assert other.period == 2
        assert np.abs(np.sort(other.rms) - np.sort(motion.rms)).max() < 1e-4


@pytest.mark.full
def test_branches_of_renumbered_planets_are_one_branch():
    """At 5.6 random starts reach one motion of unequal planets in several numberings: its branch is followed once."""
    train = star(3)
    response = train.response(start=5.1, stop=5.85, harmonics=12)
    found = train.attractors(frequency=5.6, starts=12, follow=response)
    unequal = [np.sort(motion.rms) for motion in found if motion.period == 1]
    assert len(unequal) > 2
    assert all(np.abs(rms - unequal[0]).max() < 1e-6 for rms in unequal)
    assert len([branch for branch in found.branches if branch.subharmonic == 1]) == 1


def test_files_keep_the_multiplicity(tmp_path):
    train = star(3, torque=0.0)
    # A results file of a train without elastic shafts is another matter.
    train = gt.Train(characteristic_length=40e-6, characteristic_frequency=2000 * np.pi,
                     bodies=[Body(name="motor", inertia=8e-2, torque=600.0), *train.bodies], meshes=train.meshes,
                     shafts=[gt.Shaft(between=("motor", "sun"), stiffness=1e4, damping_ratio=0.03)])
    response = train.response(start=5.1, stop=5.25, harmonics=6)
    assert branch_points(response)[0].multiplicity == 2
    response.write(tmp_path / "star.h5")
    again = gt.read_results(tmp_path / "star.h5").response
    assert [point.multiplicity for point in again.special_points] == [point.multiplicity for point in response.special_points]
    assert "multiplicity" in str(again.special_points)


def lumped(planets: int) -> Train:
    """A star gear whose planets move equally: one planet of their inertia, stiffness and damping."""
    train = star(1)
    sun, planet, ring = train.bodies
    meshes = [replace(mesh, stiffness=planets * mesh.stiffness, damping=planets * mesh.damping) for mesh in train.meshes]
    return replace(train, bodies=[sun, replace(planet, inertia=planets * planet.inertia), ring], meshes=meshes)


@pytest.mark.parametrize("planets", [6, 7])
def test_planets_part_and_touch_at_one_instant(planets):
    """Rounding alone tells the order of such events, of which none is passed over. Until rounding grows in motions that differ all
    planets move as the one."""
    many, one = (train.run_up(start=5.6, stop=5.7, duration=0.02, max_periods=0) for train in (star(planets), lumped(planets)))
    assert many.ended == one.ended
    assert (one.displacement < [1, 1.25]).any(axis=0)[1]
    np.testing.assert_allclose(many.displacement[:, :2], one.displacement, atol=1e-9)
