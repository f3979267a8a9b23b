"""Growth rates: the logarithm of the largest multiplier over the period, where the period is long without the multipliers."""

import numpy as np
import pytest
from conftest import paper_train

import geartrain as gt

#: Mesh orders without a common divisor: the period has 811 cycles of the faster mesh.
SLOW, FAST = 503, 811
#: Multipliers are those of the frequency before the last step of Newton's method, of at most 1e-8 with sets of harmonics.
AT_THE_LAST_STEP = 2e-8


def hunting_train(variation, damping, half_backlash=50e-6, orders=(SLOW, FAST), share=1 / 3):
    """Figure 3's train, whose meshes have other orders."""
    of_meshes = ((0.0023, 0.037, 2.5e8, orders[0], variation), (0.0046, 0.074, 5e8, orders[1], share * variation))
    meshes = [gt.Mesh(driving_radius=0.05, driven_radius=0.10, driving_inertia=driving, driven_inertia=driven, stiffness=stiffness,
                      half_backlash=half_backlash, damping_ratio=damping, stiffness_cos=[amplitude], order=order)
              for driving, driven, stiffness, order, amplitude in of_meshes]
    return paper_train(meshes=meshes)


def by_both(train, start, stop, points):
    """The response without and with multipliers, which are those of the whole period."""
    own, whole = (train.response(start=start / SLOW, stop=stop / SLOW, harmonics=0, tolerance=1e-2, max_points=points,
                                 shaft_torque=False, multipliers=asked) for asked in (False, True))
    assert own.multipliers is None
    np.testing.assert_allclose(own.frequency, whole.frequency, rtol=1e-12)
    known = of_multipliers(train, whole)
    numbers = np.isfinite(known)  # of some unstable motions the multipliers overflow
    assert numbers.mean() > 0.5
    np.testing.assert_allclose(whole.growth_rate[numbers], known[numbers], rtol=AT_THE_LAST_STEP)
    return own, whole


def of_multipliers(train, branch):
    return np.log(abs(branch.multipliers).max(axis=1)) * branch.frequency * train.characteristic_frequency / (2 * np.pi)


def test_short_periods():
    """One field for all trains."""
    train = paper_train()
    branch = train.response(start=0.6, stop=0.7)
    np.testing.assert_allclose(branch.growth_rate, of_multipliers(train, branch), rtol=AT_THE_LAST_STEP)
    decided = ~branch.undecided
    assert (branch.stable == (branch.growth_rate < 0))[decided].all()


def test_refined_points():
    """Those of the multipliers by shooting."""
    train = paper_train()
    branch = train.response(start=0.6, stop=0.62, refine=True)
    np.testing.assert_allclose(branch.growth_rate, of_multipliers(train, branch), rtol=1e-12)


@pytest.mark.parametrize("damping", [0.05, 0.02])
def test_teeth_that_separate(damping):
    own, whole = by_both(hunting_train(0.3, damping), 2.0, 2.05, 6)
    assert (own.separation_fraction[:, 0] > 0.1).all()
    # A rate counts as found where it has changed by less than a quarter; the changes fall from part to part.
    np.testing.assert_allclose(own.growth_rate, whole.growth_rate, rtol=1e-3)
    assert own.stable.all() and not own.undecided.any() and whole.stable.all()


@pytest.mark.parametrize("variation", [0.1, 0.3])
def test_teeth_in_contact(variation):
    """Two parts of the period agree to 1e-4, as a rule, and need no third."""
    own, whole = by_both(hunting_train(variation, 0.05, half_backlash=0.0), 1.6, 2.1, 12)
    np.testing.assert_allclose(own.growth_rate, whole.growth_rate, rtol=1e-2)
    assert own.stable.all() and not own.undecided.any()


@pytest.mark.full
@pytest.mark.parametrize(("variation", "start", "stop"), [(0.3, 1.6, 2.1), pytest.param(0.5, 1.0, 1.3, marks=pytest.mark.nightly)])
def test_slow_beats(variation, start, stop):
    """Two meshes drift past one another in 703 cycles; the train is stable in one part of the beat and unstable in another."""
    orders = (2807, 2811)
    train = hunting_train(variation, 0.03, half_backlash=0.0, orders=orders, share=1)
    own, whole = by_both(train, start * SLOW / orders[0], stop * SLOW / orders[0], 30)
    np.testing.assert_array_equal(own.stable, whole.stable)
    np.testing.assert_allclose(own.growth_rate, whole.growth_rate, rtol=5e-3)


@pytest.mark.full
def test_multipliers_beyond_all_numbers():
    train = hunting_train(0.5, 0.03, half_backlash=0.0, orders=(2807, 2811), share=1)
    own, whole = (train.response(start=1.6 / 2807, stop=2.1 / 2807, harmonics=0, tolerance=1e-2, max_points=25, multipliers=asked)
                  for asked in (False, True))
    beyond = ~np.isfinite(abs(whole.multipliers)).all(axis=1)
    assert beyond.any()
    np.testing.assert_allclose(whole.growth_rate[beyond], own.growth_rate[beyond], rtol=1e-6)
    assert not (own.stable | own.undecided)[beyond].any()


def test_loss_of_stability():
    """Linear meshes of strongly varying stiffness: the multipliers, of 1e100 and more, tell no place where stability is lost."""
    train = hunting_train(0.5, 0.02, half_backlash=0.0)
    own, whole = by_both(train, 1.2, 1.75, 400)
    assert not own.stable.all() and own.stable.any()
    np.testing.assert_array_equal(own.stable, whole.stable)
    np.testing.assert_allclose(own.growth_rate, whole.growth_rate, atol=0.1)
    [change] = [point for point in own.special_points if point.kind == "stability change"]
    around = [train.response(start=change.frequency * (1 - width), stop=change.frequency * (1 + width), harmonics=0, tolerance=1e-2,
                             multipliers=True) for width in (1e-4, 2e-5)]
    for branch in around:
        assert set(branch.stable) == {True, False}
