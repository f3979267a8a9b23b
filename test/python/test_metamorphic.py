"""Nothing depends on a unit: the image of a train has the image of its results, for random trains, transformations and analyses."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from metamorphic import combinations, disagreement, nudged
from metamorphic_branches import Plan
from random_trains import random_train
from transformations import TRANSFORMATIONS, plain, unchanged

#: Analyses that take the least time.
SHORT = {"modes", "integrate", "response", "over_parameter", "lyapunov_spectrum", "run_up"}
#: Largest share of the trains with nothing to compare, or with results that rounding decides [1].
OPEN = 0.15


def judge(seed, transformation, analysis, spoil=None):
    """The verdict on a train: 'same', 'undecided', 'nothing to compare', or what is wrong, in words.

    ``spoil`` changes the image as it should not be.
    """
    rng = np.random.default_rng(seed)
    train = random_train(rng)
    if analysis == "run_up":
        train = plain(train)  # with teeth inertias take torques to accelerate
    plan = Plan(train, rng)
    starts = analysis in {"attractors", "basins"}
    image = TRANSFORMATIONS[transformation](train, rng, starts)
    loops = len(train.shafts) + len(train.meshes) >= len(train.bodies)
    if starts and (loops or not (image.starts or analysis == "basins")):
        # Which mesh of a loop follows from the others, so that no start is drawn for it, depends on the stiffness of each.
        return "nothing to compare"
    if spoil:
        image = spoil(image)
    wrong = disagreement(analysis, train, image, plan)
    if wrong is None:
        return "nothing to compare"
    if wrong and analysis != "modes":
        # What a long flight reaches may be decided by rounding, and whether a step gets to another branch by its length, which is
        # another one where meshes are weighed otherwise: then the train does not agree with itself.
        images = [unchanged(train, nudged(train, rng)) for _ in range(8)]
        if image.weighs:
            images += [unchanged(train, step=step) for step in (0.03, 0.02)]
        if any(disagreement(analysis, train, other, plan) for other in images):
            return "undecided"
    return wrong or "same"


def check(seeds, names=None):
    """Check a train for each seed, each with the next combination of a transformation and an analysis."""
    pairs = [pair for pair in combinations() if names is None or pair[1] in names]
    order = np.random.default_rng(0).permutation(len(pairs))
    verdicts, wrong = Counter(), []
    for seed in seeds:
        pair = pairs[order[seed % len(pairs)]]
        verdict = judge(seed, *pair)
        verdicts[verdict] += 1
        if verdict not in {"same", "undecided", "nothing to compare"}:
            wrong.append(f"train {seed}, {pair[0]}, {pair[1]}: {verdict}")
    assert not wrong, "\n".join(wrong)
    assert len(seeds) - verdicts["same"] <= max(3, OPEN * len(seeds)), verdicts


def test_some_random_trains(times):
    check(range(times(200)), SHORT)


@pytest.mark.full
def test_random_trains(times):
    """Every analysis and every transformation: 50 trains by day, 5000 with every combination by night."""
    check(range(times(5000, share=100)))


@pytest.mark.parametrize("transformation", TRANSFORMATIONS)
def test_a_wrong_image_is_seen(transformation):
    """An inertia that is off by 1e-5 is seen by an analysis of each transformation."""

    def spoil(image):
        first, *others = image.train.bodies
        return replace(image, train=replace(image.train, bodies=[replace(first, inertia=first.inertia * (1 + 1e-5)), *others]))

    analysis = "response" if transformation == "subharmonic" else "modes"
    assert judge(5, transformation, analysis) == "same"
    assert judge(5, transformation, analysis, spoil) not in {"same", "undecided", "nothing to compare"}


@pytest.mark.parametrize(("transformation", "change"), [
    ("mirror", {"mirrored": False}), ("homogeneity", {"displacement": 1.0001}), ("gauge", {"force": 1.0001}),
    ("units", {"frequency": 1.0001}), ("phase", {"phase": 1e-4}), ("parallel", {"force": 1.0001}), ("orders", {"cycles": 1})])
def test_a_wrong_expectation_is_seen(transformation, change):
    """A result that is expected to be another is seen by a response."""

    def spoil(image):
        return replace(image, **{name: getattr(image, name) * value if isinstance(value, float) and name != "phase" else
                                 value + getattr(image, name) if name == "phase" else value for name, value in change.items()})

    assert judge(5, transformation, "response") == "same"
    assert judge(5, transformation, "response", spoil) not in {"same", "undecided", "nothing to compare"}
