"""Beside a fold two motions are near one another: which of them a refined point is does not hang on rounding."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from conftest import paper_train

#: Relative errors of the coefficients from which points are refined.
NOISE = (1e-14, 1e-9)


@pytest.fixture(scope="module")
def doubled():
    """Branches of twice the period of figure 3's train, with many folds."""
    return paper_train().response(start=0.2, stop=2.6, period_doublings=1).branches


@pytest.fixture(scope="module")
def whole(doubled):
    """The branches, refined as they are."""
    return [branch.refine() for branch in doubled]


def refined(branch, noise):
    """Refined from the same motions a period of the excitation later, where odd harmonics of a doubled motion change sign."""
    random = np.random.default_rng(1)
    factors = 1 + noise * random.uniform(-1, 1, branch.coefficients.shape)
    odd = branch.orders % 2 == 1
    factors[..., 1:] *= np.where(np.repeat(odd, 2), -1, 1)
    return dataclasses.replace(branch, coefficients=branch.coefficients * factors).refine()


def beside_folds(branch, reach=4):
    """Numbers of the points next to folds."""
    folds = [point.point for point in branch.special_points if point.kind == "fold"]
    near = {at + k for at in folds for k in range(-reach, reach + 1)}
    return sorted(at for at in near if 0 <= at < len(branch.frequency))


@pytest.mark.full
@pytest.mark.parametrize("number", [0, 1])
def test_refined_points_keep_their_side(doubled, whole, number):
    branch, plain = doubled[number], whole[number]
    near = beside_folds(branch)
    assert len(near) > 30
    for noise in NOISE:
        other = refined(branch, noise)
        # Whether Newton's method finds an orbit from a point on the fold itself may hang on rounding; which one it finds may not.
        found = [{at for at in near if side.correction[at] > 0} for side in (plain, other)]
        assert len(found[0] ^ found[1]) <= 3
        both = sorted(found[0] & found[1])
        np.testing.assert_allclose(other.rms[both], plain.rms[both], rtol=1e-6)
        assert [bool(value) for value in other.stable[both]] == [bool(value) for value in plain.stable[both]]
        told = [[(jump.kind, jump.direction, jump.undecided) for jump in side.jumps] for side in (plain, other)]
        assert told[0] == told[1]
        for known, found in zip(plain.jumps, other.jumps, strict=True):
            np.testing.assert_allclose(found.after, known.after, rtol=1e-3)


@pytest.mark.full
def test_side_is_that_of_the_branch(doubled, whole):
    """Between two folds the number of real multipliers above 1 stays odd or even, to the last point beside either fold."""
    for branch, exact in zip(doubled, whole, strict=True):
        real = (exact.multipliers.imag == 0) & (exact.multipliers.real > 1)
        odd = real.sum(axis=1) % 2
        turns = {at.point + 1 for at in branch.special_points if at.kind in ("fold", "branch point")}
        turns |= {0, len(odd), *(np.flatnonzero(np.diff(branch.segment)) + 1)}
        for first, last in pairwise(sorted(turns)):
            kept = [at for at in range(first, last) if exact.correction[at] > 0]
            assert len({int(odd[at]) for at in kept}) <= 1, (branch.frequency[first], branch.frequency[last - 1])


def test_a_jump_leaves_its_own_fold():
    """Beside an exact fold the points of the balance pass its Lambda again: that is no motion to jump to."""
    branch = paper_train().response(start=0.2, stop=2.6, refine=True, period_doublings=1)
    for side in (branch, *branch.branches):
        for jump in side.jumps:
            if jump.cause == "fold" and jump.kind != "leaves":
                assert np.linalg.norm(jump.after - jump.before) > 0.02 * np.linalg.norm(jump.before)
