"""Derivatives of special points are those of the listed frequencies: beside the lists of trains with a slightly other parameter."""

import warnings
from dataclasses import replace
from itertools import takewhile

import numpy as np
import pytest
from conftest import equal_stages, paper_train
from metamorphic_branches import Plan
from random_trains import random_train

import geartrain as gt

#: Steps of the differences, relative, the first twice the second, and Lambda's least noise as a branch lists it, relative.
STEPS, NOISE = (2e-5, 1e-5), 1e-10


def derivative(point, name):
    """The derivative and, where there is none, why."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        value = point.gradient([name])[0]
    return value, " ".join(str(warning.message) for warning in told)


def nearest(point, points):
    """The point of a list that has the kind of another point and lies next to it."""
    return min((other for other in points if other.kind == point.kind), key=lambda other: abs(other.frequency - point.frequency),
               default=None)


def compare(respond, name, value, kinds=("fold", "period doubling", "neimark-sacker"), steps=STEPS, noise=NOISE):
    """How many derivatives agree with differences of the lists and how many are refused; any other one fails."""
    here = respond(value).special_points
    sides = {step: respond(value * (1 + step)).special_points for step in (*steps, *(-step for step in steps))}
    # A list may have a point more than another: from there on points at equal places are different points.
    alike = list(takewhile(lambda rows: all(nearest(rows[0], side) is row for row, side in zip(rows[1:], sides.values()))
                           and np.ptp([row.frequency for row in rows]) < 1e-3 * rows[0].frequency, zip(here, *sides.values())))
    agreed = refused = 0
    for point, *others in alike:
        if point.kind not in kinds:
            continue
        found, why = derivative(point, name)
        if np.isnan(found):
            assert why
            refused += 1
            continue
        at = dict(zip(sides, [other.frequency for other in others]))
        wide, narrow = ((at[step] - at[-step]) / (2 * step * value) for step in steps)
        # The fourth difference of five equally spaced places holds next to nothing but what their location is uncertain by.
        ends, beside = (sum(at[sign * step] for sign in (1, -1)) for step in steps)
        uncertain = max(noise * point.frequency, abs(ends - 4 * beside + 6 * point.frequency))
        error = abs(wide - narrow) + uncertain / (min(steps) * value)
        np.testing.assert_allclose(found, (4 * narrow - wide) / 3, rtol=1e-6, atol=error,
                                   err_msg=f"{point.kind} at {point.frequency}")
        agreed += 1
    return agreed, refused


def of_random_train(seed, **settings):
    rng = np.random.default_rng(seed)
    train = random_train(rng)
    plan = Plan(train, rng)
    stop = plan.start + (plan.stop - plan.start) / (3 if settings else 1)

    def respond(variation):
        changed = train.with_values({"stiffness_variation": variation})
        return changed.response(start=plan.start, stop=stop, harmonics=plan.harmonics, **settings)

    return respond, "stiffness_variation", plan.variation


@pytest.mark.parametrize("seed", [1, 15, 26, 400])
def test_random_trains(seed):
    agreed, refused = compare(*of_random_train(seed))
    assert agreed > 2 and not refused


@pytest.mark.full
def test_more_random_trains(times):
    counts = np.sum([compare(*of_random_train(seed)) for seed in range(100, 100 + times(400, 40))], axis=0)
    assert counts[0] > 10 * counts[1]


@pytest.mark.nightly
def test_many_points_close_together():
    """Newton's method must not go to another special point without a word."""
    agreed, refused = compare(*of_random_train(3545))
    assert agreed >= 15 and agreed > 2 * refused


@pytest.mark.parametrize("harmonics", [4, 12])
def test_a_period_doubling_with_few_harmonics(harmonics):
    """The listed doubling is that of the multipliers, elsewhere than that of the balance of twice the period."""

    def respond(damping):
        train = paper_train()
        train = replace(train, meshes=[train.meshes[0], replace(train.meshes[1], damping_ratio=damping)])
        return train.response(start=1.62, stop=2.2, harmonics=harmonics)

    agreed, refused = compare(respond, "mesh 2 damping_ratio", 0.05, kinds=("period doubling",), steps=(2e-3, 1e-3))
    assert agreed == 2 and not refused


@pytest.mark.full
def test_a_refined_branch_has_those_of_the_exact_points():
    agreed, refused = compare(*of_random_train(6, refine=True), steps=(2e-4, 1e-4))
    assert agreed > 2 and not refused


def test_a_refined_branch_has_those_of_its_branch_points():
    def respond(variation):
        return equal_stages(variation).response(start=0.84, stop=0.95, harmonics=12, refine=True)

    agreed, refused = compare(respond, "stiffness_variation", 0.3, kinds=("branch point",), steps=(2e-4, 1e-4))
    assert agreed == 2 and not refused


def test_what_has_none(branch):
    with pytest.raises(gt.SolverError, match="contact onset"):
        branch.onsets[0].gradient(["input_torque"])
    crossing = equal_stages(0.3).response(start=0.84, stop=0.95, harmonics=12)
    point = next(point for point in crossing.special_points if point.kind == "branch point")
    with pytest.raises(gt.SolverError, match="refined"):
        point.gradient(["stiffness_variation"])


def test_a_parameter_of_zero():
    """Transmission errors are micrometres: a step in metres would lead to another train."""
    def fold(error):
        meshes = [gt.Mesh(driving_radius=0.05, driven_radius=0.10, driving_inertia=driving, driven_inertia=driven,
                          stiffness=stiffness, half_backlash=30e-6, damping_ratio=0.05, stiffness_cos=[0.3], error_cos=[error])
                  for driving, driven, stiffness in ((0.0023, 0.037, 2.5e8), (0.0046, 0.074, 5e8))]
        branch = paper_train(meshes=meshes).response(start=1.5, stop=1.7, refine=True)
        return next(point for point in branch.special_points if point.kind == "fold")

    found = fold(0.0).gradient(["mesh 1 error_cos", "mesh 2 error_cos"])
    wide, narrow = ((fold(step).frequency - fold(-step).frequency) / (2 * step) for step in (2e-9, 1e-9))
    np.testing.assert_allclose(found.sum(), (4 * narrow - wide) / 3, rtol=1e-6, atol=abs(wide - narrow))
