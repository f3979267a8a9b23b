"""Trains whose orders have a common divisor are the train of order 1 at other frequencies: all that is found is the same."""

import numpy as np
import pytest
from conftest import paper_train, single_pair

import geartrain as gt

ORDERS = (2, 3, 4)


def train(order):
    """Figure 3's train; a motion of period p of order 1 at Lambda is one of order g at Lambda/g."""
    meshes = [
        gt.Mesh(driving_radius=0.05, driven_radius=0.10, driving_inertia=driving, driven_inertia=driven, stiffness=stiffness,
                damping_ratio=0.05, half_backlash=30e-6, stiffness_cos=[0.3], order=order)
        for driving, driven, stiffness in ((0.0023, 0.037, 2.5e8), (0.0046, 0.074, 5e8))
    ]
    return paper_train(meshes=meshes)


def response(order, start, stop, harmonics=12, **settings):
    return train(order).response(start=start / order, stop=stop / order, harmonics=harmonics * order, **settings)


@pytest.fixture(scope="module")
def plain():
    return response(1, 1.7, 2.1, period_doublings=1)


@pytest.fixture(scope="module", params=ORDERS)
def order(request):
    return request.param


@pytest.fixture(scope="module")
def branch(order):
    return response(order, 1.7, 2.1, period_doublings=1)


def same_points(found, expected, order, rel=1e-7):
    assert [point.kind for point in found] == [point.kind for point in expected]
    assert [order * point.frequency for point in found] == pytest.approx([point.frequency for point in expected], rel=rel)


def same_curve(found, expected, order):
    """Of the same ends, and the frequency between them."""
    wanted = np.interp(found.parameter, expected.parameter, expected.frequency)
    assert order * found.frequency[[0, -1]] == pytest.approx(expected.frequency[[0, -1]], rel=1e-9)
    assert order * found.frequency == pytest.approx(wanted, rel=1e-4)


def test_special_points_jumps_and_branches(plain, branch, order):
    assert plain.special_points
    same_points(branch.special_points, plain.special_points, order)
    same_points(branch.special_points, plain.special_points, order)
    assert [jump.cause for jump in branch.jumps] == [jump.cause for jump in plain.jumps]
    assert len(branch.branches) == len(plain.branches) == 2
    for doubled, known in zip(branch.branches, plain.branches):
        # Two periods of the excitation are one of the fundamental, or two.
        assert doubled.subharmonic == (1 if order % 2 == 0 else 2)
        for frequency in (1.76, 1.92):
            found = sorted(motion.rms[0] for motion in doubled.at(frequency / order))
            wanted = sorted(motion.rms[0] for motion in known.at(frequency))
            assert found == pytest.approx(wanted, rel=1e-8)


def test_exact_points_and_audit(plain, branch, order):
    for found, known in zip(branch.special_points, plain.special_points):
        exact, wanted = found.exact(), known.exact()
        assert order * exact.frequency == pytest.approx(wanted.frequency, rel=1e-10)
        assert (exact.before, exact.after, exact.criticality) == (wanted.before, wanted.after, wanted.criticality)
        assert abs(exact.motion.multipliers[0]) == pytest.approx(abs(wanted.motion.multipliers[0]) ** order, rel=1e-8)
    found = branch.audit(points=10)
    assert found.ok, found
    refined = response(order, 1.7, 2.1, refine=True)
    same_points(refined.special_points, [point.exact() for point in plain.special_points], order, rel=1e-10)


def test_a_fold_and_its_curve(order):
    known = response(1, 0.5, 0.9).special_points[0]
    found = response(order, 0.5, 0.9).special_points[0]
    same_points([found.exact()], [known.exact()], order, rel=1e-10)
    assert found.gradient(["input_torque"]) * order == pytest.approx(known.gradient(["input_torque"]), rel=1e-6)
    curve, wanted = (
        train(times).locus(point, parameter="stiffness_variation", start=0.28, stop=0.32)
        for times, point in ((order, found), (1, known))
    )
    assert curve.complete and wanted.complete
    same_curve(curve, wanted, order)


def test_the_curve_of_a_period_doubling(plain, branch, order):
    curve, wanted = (
        train(times).locus(point, parameter="stiffness_variation", start=0.28, stop=0.32)
        for times, point in ((order, branch.special_points[0]), (1, plain.special_points[0]))
    )
    assert curve.complete and wanted.complete
    same_curve(curve, wanted, order)
    gradient, known = (source.special_points[0].gradient(["mesh 1 stiffness"]) for source in (branch, plain))
    assert order * gradient == pytest.approx(known, rel=1e-6)


@pytest.fixture(scope="module")
def motions(order):
    """A motion of twice the excitation's period, of the train of this order and of order 1."""
    found, known = train(order).integrate(1.92 / order), train(1).integrate(1.92)
    assert known.period == 2 and found.period == (1 if order % 2 == 0 else 2)
    assert found.rms == pytest.approx(known.rms, rel=1e-7)
    return found, known


def test_a_seed_is_followed(motions, order):
    found, known = motions
    seeded = response(order, 1.9, 1.95, harmonics=12 * found.period, subharmonic=found.period, seed=found)
    wanted, = response(1, 1.9, 1.95, harmonics=24, subharmonic=2, seed=known).at(1.93)
    motion, = seeded.at(1.93 / order)
    # 3 carries all harmonics of Lambda/2, of which only each third is there.
    assert motion.rms == pytest.approx(wanted.rms, rel=1e-7)
    assert motion.refine().rms == pytest.approx(wanted.refine().rms, rel=1e-10)
    assert abs(motion.multipliers[0]) == pytest.approx(abs(wanted.multipliers[0]) ** (order * found.period / 2), rel=1e-6)
    assert seeded.audit(points=5).ok


def test_the_seed_of_a_branch_over_a_parameter_is_followed(motions, order):
    found, known = motions
    values = {"parameter": "mesh 1 damping_ratio", "start": 0.049, "stop": 0.051}
    seeded = train(order).continuation(
        frequency=1.92 / order, seed=found, harmonics=12 * order * found.period, subharmonic=found.period, **values)
    branch = train(1).continuation(frequency=1.92, seed=known, harmonics=24, subharmonic=2, **values)
    motion, = seeded.at(0.0505)
    wanted, = branch.at(0.0505)
    assert motion.rms == pytest.approx(wanted.rms, rel=1e-7)


def test_gradients_are_those_of_the_motion(motions, order):
    found, known = motions
    names = ["mesh 1 damping_ratio", "mesh 2 stiffness"]
    assert found.gradient("rms", names) == pytest.approx(known.gradient("rms", names), rel=1e-4)


def test_attractors_are_followed_on_their_own_branch(order):
    follow = response(order, 1.9, 1.95)
    found = train(order).attractors(frequency=1.92 / order, starts=4, random_seed=2, follow=follow)
    assert len(found.branches) == len(found) > 1
    for branch in found.branches:
        motion, = branch.at(1.92 / order)
        assert any(motion.refine().rms == pytest.approx(other.rms, rel=1e-7) for other in found)


def test_stability_of_a_pair_over_an_even_order():
    """A pair of order 2 doubles its period where that of order 1 does."""
    plain = single_pair(0.4, stiffness_cos=[0.3]).response(start=1.2, stop=2.6, harmonics=12)
    even = single_pair(0.4, stiffness_cos=[0.3], order=2).response(start=0.6, stop=1.3, harmonics=24)
    assert any(point.kind == "period doubling" for point in plain.special_points)
    same_points(even.special_points, plain.special_points, 2)
