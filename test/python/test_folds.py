"""Folds are listed wherever the frequency turns, also where the number of harmonics changes at the fold."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, paper_train
from test_torque_resonances import random_parts

import geartrain as gt
from geartrain.errors import SolverError

pytestmark = pytest.mark.full


def turns(branch):
    """Frequencies at which the points of each segment turn."""
    found = []
    for segment in np.unique(branch.segment):
        frequency = branch.frequency[branch.segment == segment]
        way = np.sign(np.diff(frequency))
        found += list(frequency[1:-1][way[1:] * way[:-1] < 0])
    return sorted(found)


def folds(branch):
    return sorted(special.frequency for special in branch.special_points if special.kind == "fold")


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-5])
def test_as_many_turns_as_folds(tolerance):
    train = gt.read_case(ROOT / "namelists" / "fig03.nml").train
    branch = train.response(start=0.4, stop=1.2, harmonics=0, tolerance=tolerance)
    assert len(folds(branch)) == 6
    assert turns(branch) == pytest.approx(folds(branch), rel=1e-9)


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_fold_that_needs_more_harmonics_than_the_branch_before():
    # Below the fold mesh 1 is in contact and some 40 harmonics do; at the fold it parts, and more than 1000 are carried.
    train = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    train = replace(train, meshes=[replace(mesh, stiffness_harmonics=5) for mesh in train.meshes])
    branch = train.response(start=824, stop=826, unit="rpm", harmonics=0, tolerance=1e-3)
    # A rising sweep by integration jumps between 824.8 and 824.9 rpm.
    assert folds(branch) == pytest.approx([824.873], abs=2e-3)
    assert turns(branch) == pytest.approx(folds(branch), rel=1e-9)
    assert branch.at(824.95, unit="rpm")[0].rms[0] > 6


def test_a_fold_beside_a_doubling_is_not_taken_for_it():
    """The second doubling lies 1.5e-5 before a fold; from the fold a trace of twice the period follows the motions of period 1."""
    train = paper_train().with_values({"mesh * half_backlash": 3.50625e-5})
    response = train.response(start=0.3, stop=2.6, harmonics=12, period_doublings=1)
    at = [special.frequency for special in response.special_points if special.kind == "period doubling"]
    assert at == pytest.approx([0.673073, 0.673844, 1.749211, 2.043854], abs=2e-6)
    assert len(response.branches) == 3  # the first two doublings are the ends of one branch
    for branch in response.branches:
        odd = np.abs(branch.coefficients[:, :, 1:].reshape(len(branch), 2, -1, 2)[:, :, ::2]).max(axis=(1, 2, 3))
        assert branch.subharmonic == 2 and (odd > 1e-5).all()


@pytest.mark.parametrize(("harmonics", "tolerance"), [(0, 1e-2), (0, 1e-5), (12, 1e-3), (30, 1e-3)])
def test_an_exact_fold_is_a_seed(harmonics, tolerance):
    """Of its Lambda the truncated balance may have no motion, or two: the branch begins beside it and turns there."""
    train = paper_train()
    response = train.response(start=0.4, stop=1.2, harmonics=harmonics, tolerance=tolerance)
    for place, special in enumerate(special for special in response.special_points if special.kind == "fold"):
        seed = special.exact().motion
        branch = train.response(start=0.4, stop=1.2, harmonics=harmonics, tolerance=tolerance, seed=seed)
        assert branch.complete and folds(branch) == pytest.approx(folds(response), rel=1e-3), place


def test_a_seed_whose_branch_is_outside_the_range():
    train = paper_train()
    fold = train.response(start=0.4, stop=1.2).special_points[0].exact()
    near = {"start": fold.frequency * (1 - 1e-9), "stop": fold.frequency * (1 + 1e-9), "harmonics": 12}
    with pytest.raises(SolverError, match=r"Newton does not converge from the seed at Lambda = 0\.462118"):
        train.response(**near, seed=fold.motion)


@pytest.mark.parametrize("ends", [(0.84, 0.83), (0.83, 0.84)])
def test_a_seed_at_a_bound(ends):
    """It has a branch on one side alone: no point twice, and no fold where the other way would begin."""
    train = paper_train()
    whole = train.response(start=0.9, stop=0.8, harmonics=6)
    branch = train.response(start=ends[0], stop=ends[1], harmonics=6, seed=whole.at(0.84)[0])
    assert branch.complete and not branch.special_points
    assert (abs(np.diff(branch.frequency)) > 0).all()
    assert "Lambda = 0.84 is the end of the range" in branch.ended


def lightly_damped(seed, variation):
    """A train with light discs and narrow, high resonances, and the ends of a range, in the sense of travel."""
    parts, ends, _ = random_parts(seed)
    rng, train = np.random.default_rng(seed + 10000), parts.train()
    return replace(train, meshes=[replace(mesh, stiffness_cos=list(variation * rng.uniform(-1, 1, 3) * [1, 0.5, 0.3]))
                                  for mesh in train.meshes]), ends


def trace(seed, variation, tolerance, **settings):
    train, (start, stop) = lightly_damped(seed, variation)
    return train.response(start=start, stop=stop, harmonics=0, tolerance=tolerance, max_points=4000, **settings)


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
@pytest.mark.parametrize("seed, variation, tolerance, stability", [
    (17, 0.1, 1e-3, False),  # fewer harmonics led back to the same point, 20000 times
    (93, 0.15, 1e-2, False), (3, 0.3, 1e-3, False), (243, 0.15, 1e-3, True), (5, 0.3, 1e-3, False)])  # no fold was found
def test_the_number_of_harmonics_changes_where_the_branch_is_nearly_vertical(seed, variation, tolerance, stability):
    branch = trace(seed, variation, tolerance, stability=stability)
    motion = np.column_stack([branch.segment, branch.frequency / branch.frequency.max() * 1e9, branch.rms / branch.rms.max() * 1e8])
    assert branch.complete and len(motion) - len(np.unique(np.round(motion), axis=0)) <= 4
    train, (start, stop) = lightly_damped(seed, variation)
    exact = train.response(start=start, stop=stop, harmonics=36, stability=False)
    np.testing.assert_allclose(branch.rms.max(axis=0), exact.rms.max(axis=0), rtol=1e-3)


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_random_trains_of_little_damping(times):
    """Trains that leave their gaps at narrow resonances, with a coarse tolerance: of 150 branches none ended early when written."""
    seeds = range(times(150))
    early = [seed for seed in seeds if not trace(seed, 0.15, 1e-2, stability=False).complete]
    assert len(early) <= 1, early


def test_where_stability_is_lost_without_a_fold_the_other_stable_motions_are_counted():
    branch = gt.read_case(ROOT / "namelists" / "fig10.nml").train.response(start=0.2, stop=2.6, harmonics=8)
    leaving = [jump for jump in branch.jumps if jump.kind == "leaves" and jump.cause == "period doubling" and not jump.undecided]
    assert len(leaving) > 5
    for jump in leaving:
        beyond = branch.at(jump.frequency * (1 + (1e-4 if jump.direction == "rising" else -1e-4)))
        assert jump.candidates == sum(motion.stable and not motion.undecided for motion in beyond) > 0
        assert np.isnan(jump.after).all()
    assert "vibration switches to half its frequency, or jumps to one of 4 other stable motions of this curve" \
        in " ".join(branch.report(verbose=True).split())
