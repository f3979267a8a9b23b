"""Changes of stability that come in pairs within a step are listed: the default step beside a tenth of it."""

import numpy as np
import pytest
from metamorphic_branches import Plan
from random_trains import random_train

from paper_cases import chain

#: Special points of a branch that are likely to be far apart.
FEW = 30
KINDS = {"period doubling", "neimark-sacker"}


def lists(seed):
    """The changes of stability with the default step and with a tenth; None where a branch is not complete or folds differ."""
    rng = np.random.default_rng(seed)
    train = random_train(rng)
    plan = Plan(train, rng)
    ends = {"start": 0.6 * plan.start, "stop": 1.6 * plan.stop, "harmonics": plan.harmonics, "max_points": 6000}
    known = train.response(**ends)
    if len(known.special_points) > FEW or not known.complete:
        return None
    exact = train.response(step=0.005, **ends)
    if not exact.complete or len(folds(exact)) != len(folds(known)):
        return None
    return changes(known), changes(exact)


def folds(branch):
    return [point for point in branch.special_points if point.kind not in KINDS]


def changes(branch):
    return sorted((point.kind, point.frequency) for point in branch.special_points if point.kind in KINDS)


@pytest.mark.parametrize("seed", [155, 276])
def test_a_pair_within_a_step(seed):
    """Two Neimark-Sacker points between two points of the branch, of two pairs close to the circle and of one."""
    known, exact = lists(seed)
    assert [kind for kind, _ in known] == [kind for kind, _ in exact]
    np.testing.assert_allclose([frequency for _, frequency in known], [frequency for _, frequency in exact], rtol=1e-6)


@pytest.mark.parametrize("seed", [155, 276])
def test_a_point_between_the_changes_of_a_pair(seed):
    """The motions between two changes of stability within a step are on a point of their own, and may be what a sweep jumps to."""
    rng = np.random.default_rng(seed)
    train = random_train(rng)
    plan = Plan(train, rng)
    branch = train.response(start=0.6 * plan.start, stop=1.6 * plan.stop, harmonics=plan.harmonics, max_points=6000)
    outside = (np.abs(branch.multipliers) > 1).sum(axis=1)
    steps = [point.point for point in branch.special_points if point.kind in KINDS]
    assert steps and all(outside[step] != outside[step + 1] for step in steps)
    # The point lies where the two steps beside it meet, and what is listed in them lies on its two sides.
    inside = [point for point in branch.special_points if point.kind in KINDS and point.point + 1 in steps]
    assert inside
    for point in inside:
        low, high = sorted(branch.frequency[point.point:point.point + 2])
        assert low <= point.frequency <= high


def test_reals_that_pair_outside_the_circle():
    """Each change has its multipliers on two sides: two real ones outside that become a pair, beside a pair, are no passage."""
    train = chain(22)
    branch = train.response(start=0.84, stop=0.7, harmonics=6)
    points = [point for point in branch.special_points if point.kind in KINDS]
    assert len(points) > 20
    for point in points:
        outside = []
        for beside in (point.frequency - 1e-6, point.frequency + 1e-6):
            seed = min(branch.at(beside), key=lambda motion: np.abs(motion.rms - point.rms).sum())
            near = train.response(start=beside, stop=beside - 1e-9, harmonics=6, multipliers=True, seed=seed, max_points=2)
            outside.append((np.abs(near.multipliers[0]) > 1 + 1e-9).sum())
        assert abs(outside[1] - outside[0]) == (1 if point.kind == "period doubling" else 2)


@pytest.mark.nightly
def test_random_trains(times):
    """Of 245 random loaded trains eight lost changes of stability when only the counts at both ends were compared."""
    both = [lists(seed) for seed in range(60, 60 + times(270))]
    compared = [pair for pair in both if pair]
    lost = [pair for pair in compared if len(pair[0]) < len(pair[1])]
    assert len(compared) > 0.7 * len(both) and len(lost) <= 0.015 * len(compared)
