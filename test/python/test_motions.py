"""Every motion at one speed: known sets, the sum of indices, and how orbits are told apart."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, paper_train, single_pair

import geartrain as gt
from geartrain.results.motion_search import _follow, _Known, _multipliers_at_infinity, _random_waveforms
from geartrain.results.motions import index_sum
from geartrain.results.orbit import least_period, replace_period, same_orbit
from paper_cases import paper_case

pytestmark = pytest.mark.full


def test_figure_3_where_two_motions_of_period_2_coexist():
    """At 1.2 a second period-2 motion, unstable, lies between the two stable ones: neither a sweep nor a random start finds it."""
    found = paper_train().motions(1.2, period=2, starts=6, seeds=6)
    assert [(motion.period, motion.stable) for motion in found] == [(1, True), (2, True), (2, False)]
    assert found.index_sum == found.expected_sum == {1: 1, 2: 1} and found.complete
    assert found.how[2].endswith((" from a random state", " from a random waveform"))
    assert str(found).endswith("the sums of the indices are as expected")


@pytest.mark.nightly
def test_a_parametric_resonance_turns_the_sum():
    """At 1.92 the train without backlash has a multiplier below -1: of period 2 the sum is -1."""
    train = paper_train()
    linear = replace(train, meshes=[replace(mesh, half_backlash=0.0) for mesh in train.meshes])
    assert np.min(linear.response(start=1.92, stop=1.93, harmonics=1).multipliers[0].real) < -1
    found = train.motions(1.92, period=2, starts=20, seeds=20)
    assert found.expected_sum == {1: 1, 2: -1} and found.complete
    assert [(motion.period, motion.stable) for motion in found] == [(2, True), (1, False), (2, False)]


@pytest.mark.nightly
def test_the_branch_of_every_motion_is_followed():
    """One of four unstable motions of period 4 on a branch that the response does not lead to: its folds lead to the others.

    And over the gap of mesh 1 to those of another such branch.
    """
    known = _Known(paper_case("fig07_042").train, 2.4, dict.fromkeys(range(1, 5)))
    state = [-0.018260979, 0.67695533, -0.0062071734, -0.48918234, -0.00060837274,
             0.1575611, -1.8351707, 0.0072783731, -0.51642438, -0.00055055801]
    known.add(known.shoot(np.array(state), 4), "told")
    _follow(known.train, 2.4, known)
    rms = sorted(motion.rms.tolist() for motion, _ in known.found)
    assert np.round(rms[:4], 3).tolist() == [[1.615, 1.940], [1.627, 1.867], [1.963, 2.052], [1.974, 1.805]]
    assert np.round(rms[4:], 3).tolist() == [[2.341, 2.047], [2.353, 1.866], [2.382, 1.882], [2.414, 1.982]]
    assert [how.endswith("over mesh 1 half_backlash") for _, how in known.found] == 4 * [False] + 4 * [True]
    one = known.train.response(start=1.5, stop=4.0, subharmonic=4, seed=known.found[0][0], harmonics=0, tolerance=1e-2)
    assert len(one.at(2.4)) == 4


@pytest.mark.nightly
def test_an_island_that_is_unstable_at_this_speed():
    """Lambda 1.919 to 2.495, both motions at 2.4 unstable and of opposite index: neither starts nor the indices tell of it."""
    train = paper_train(input_torque=223.9).with_values({
        "mesh 1 driving_inertia": 0.0042508344, "mesh 1 driven_inertia": 0.037585609, "mesh 1 stiffness": 483801588.5,
        "mesh 1 damping_ratio": 0.02796457, "mesh 1 half_backlash": 3.4814159e-05, "mesh 1 stiffness_cos": 0.21065779,
        "mesh 2 driving_inertia": 0.0034953484, "mesh 2 driven_inertia": 0.023563942, "mesh 2 stiffness": 418491593.6,
        "mesh 2 damping_ratio": 0.053140467, "mesh 2 half_backlash": 5.2393675e-05, "mesh 2 stiffness_cos": 0.24220609,
        "shaft 2 stiffness": 9081437.3})
    found = train.motions(2.4, period=2, starts=20, seeds=40)
    assert found.complete and len(found) == 7
    island = [motion for motion in found if 1.2 < motion.rms[0] < 1.4]
    assert [motion.rms.round(4).tolist() for motion in island] == [[1.2415, 1.0727], [1.3753, 0.6302]]
    branch = train.response(start=1.9, stop=2.6, subharmonic=2, seed=island[0], harmonics=0, tolerance=1e-3)
    assert branch.closed and len(branch.at(2.4)) == 2 and not any(motion.stable for motion in branch.at(2.4))


def test_a_gearbox_excited_at_high_harmonics_of_its_slowest_shaft():
    """Its balance takes 71 harmonics at least: so does that of the train without backlash; random waveforms are left out."""
    train = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    multipliers = _multipliers_at_infinity(train, 825.0)
    assert len(multipliers) == 10 and (np.abs(multipliers) < 1).all()
    known = _Known(train, 825.0, {1: 1})
    known.found.append((_motion(np.ones((2, 3)), 1), "told"))
    assert not list(_random_waveforms(known, [], 2.0, np.random.default_rng(0), 1))


def test_coexisting_motions_of_a_single_pair():
    """Figures measured independently (README): two stable motions, and the unstable one between them."""
    found = single_pair(0.4, stiffness_cos=[0.3]).motions(0.8, period=1, starts=10, seeds=10)
    assert [motion.stable for motion in found] == [True, True, False]
    assert sorted(float(motion.true_ac_rms[0]) for motion in found[:2]) == pytest.approx([0.251372945, 0.716758700], abs=1e-9)


def test_a_missing_motion_is_told():
    found = paper_train().motions(0.7, period=1, starts=5, seeds=5)
    fewer = gt.Motions([(motion, how) for motion, how in zip(found, found.how) if motion.stable], 0.7, {1: 1})
    assert fewer.complete is False and fewer.index_sum == {1: 3}
    assert "motions are missing: the sum of the indices is 3 of period 1 (must be 1)" in str(fewer)


def test_index_is_the_sign_of_the_determinant():
    moments = np.random.default_rng(3)
    for times in (1, 2, 3):
        for _ in range(50):
            matrix = moments.normal(size=(4, 4))
            motion = replace(_motion(np.zeros((1, 3)), 1), multipliers=np.linalg.eigvals(matrix))
            determinant = np.linalg.det(np.eye(4) - np.linalg.matrix_power(matrix, times))
            assert index_sum([motion], times) == np.sign(determinant)


def test_an_orbit_begun_a_period_later_is_the_same():
    train = paper_train()
    motion = train.integrate(1.92).refine()
    assert motion.period == 2
    later = train.integrate(1.92, start=np.concatenate([*_section(train, motion)])).refine()
    assert same_orbit(motion, later) and not same_orbit(motion, replace(later, coefficients=1.001 * later.coefficients))


def test_least_period_of_a_motion_solved_as_a_longer_one():
    motion = paper_train().integrate(0.9).refine()
    assert least_period(motion) == 1
    assert least_period(replace_period(motion, 4)) == 1 and replace_period(motion, 4).period == 4
    doubled = paper_train().integrate(1.92).refine()
    assert least_period(replace_period(doubled, 4)) == 2


@pytest.mark.parametrize("wrong", [{"period": 0}, {"period": 65}, {"starts": 0}, {"seeds": -1}, {"random_seed": 0.5},
                                   {"response": 3}])
def test_bad_arguments(wrong):
    with pytest.raises(gt.InputError, match=next(iter(wrong))):
        paper_train().motions(0.7, **wrong)
    with pytest.raises(gt.InputError, match="frequency"):
        paper_train().motions(-1.0)


def _section(train, motion):
    """The state one period of the fundamental later."""
    return [train.integrate(motion.frequency, start=motion.state, max_periods=1).state]


def _motion(coefficients, period):
    numbers = np.zeros(len(coefficients))
    return gt.Motion(
        frequency=1.0, period=period, rms=numbers, mean=numbers, minimum=numbers, maximum=numbers, mesh_force_maximum=numbers,
        dynamic_factor=numbers, separation_fraction=numbers, back_contact_fraction=numbers, coefficients=coefficients,
    )
