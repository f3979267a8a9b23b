"""Special points and contact onsets of the exact motion, against closed forms and earlier findings by shooting."""

import pytest
from conftest import paper_train, single_pair

import geartrain as gt


@pytest.fixture(scope="module")
def branch():
    """The branch of the single pair with f = 0.4, kappa = 0.3, zeta = 0.05: in contact where it doubles."""
    return single_pair(0.4, stiffness_cos=[0.3]).response(start=0.5, stop=2.4)


def only(specials, kind, near):
    found = [special for special in specials if special.kind == kind and abs(special.frequency - near) < 1e-3]
    assert len(found) == 1
    return found[0]


def test_fold(branch):
    fold = only(branch.special_points, "fold", 0.8446).exact()
    # By integration with SciPy's DOP853 at 1e-12.
    assert fold.frequency == pytest.approx(0.844564142, abs=1e-9)
    assert fold.crossing == 1
    assert fold.critical == pytest.approx([1], abs=1e-7)
    assert fold.motion.minimum[0] < 1


def test_doubling(branch):
    doublings = [special.exact() for special in branch.special_points if special.kind == "period doubling"]
    # Zeros of Hill's determinant of Mathieu's equation with damping, 61 harmonics (test/hard_closed_forms.f90).
    assert [doubling.frequency for doubling in doublings] == pytest.approx([1.8831440170837, 2.1063923779291], abs=1e-10)
    assert [doubling.crossing for doubling in doublings] == [1, 1]
    assert doublings[0].critical == pytest.approx([-1], abs=1e-8)


def test_onset_of_separation(branch):
    onset = only(branch.onsets, "separation", 1.128).exact()
    assert onset.mesh == 1 and onset.motion.minimum[0] == pytest.approx(1, abs=1e-9)
    # Figure 3, found by shooting (test/validation_bifurcations.f90).
    paper = paper_train().response(start=1.0, stop=1.2)
    onset = only(paper.onsets, "separation", 1.1028).exact()
    assert onset.mesh == 2 and onset.frequency == pytest.approx(1.1027590, abs=1e-7)
    assert onset.motion.minimum[1] == pytest.approx(1, abs=1e-9)
    assert onset.crossing == 0


@pytest.mark.parametrize("near, criticality", [(0.6177, "supercritical"), (0.6573, "subcritical")])
def test_criticality(near, criticality):
    # The doubled motions by harmonic balance: supercritical where they are on the side on which the branch is unstable.
    train = paper_train().with_values({"mesh * damping_ratio": 0.01})
    branch = train.response(start=0.3, stop=1.0, harmonics=16)
    doubling = min((special for special in branch.special_points if special.kind == "period doubling"),
                   key=lambda special: abs(special.frequency - near))
    exact = doubling.exact()
    doubled = branch.period_doubled(doubling).frequency
    unstable_above = branch.stable[doubling.point]
    assert branch.frequency[doubling.point] < branch.frequency[doubling.point + 1]
    assert (criticality == "supercritical") == ((doubled[6] > doubled[0]) == unstable_above)
    assert exact.criticality == criticality


def test_fold_of_an_island():
    # Figure 9 with zeta = 0.01: a closed branch joined to no other; its motion at 0.85 by random starts, its fold with R = 48
    # (test/hard_branches.f90).
    train = paper_train().with_values({"mesh * damping_ratio": 0.01})
    state = [0.01254298, -2.27472542, -0.08825069, -6.79887307, -0.10168407,
             0.11287488, 2.11040707, 0.0276462, -1.9129191, 0.30859615]
    seed = train.integrate(frequency=0.85, start=state)
    island = train.response(start=0.7, stop=0.9, seed=seed, harmonics=12)
    fold = only(island.special_points, "fold", 0.7443).exact()
    assert fold.frequency == pytest.approx(0.74431157, abs=1e-8)
    assert fold.crossing == 1


def test_none_near(branch):
    fold = only(branch.special_points, "fold", 0.8446)
    with pytest.raises(ValueError, match="no branch"):
        gt.SpecialPoint(fold.kind, fold.frequency, fold.point, fold.rms).exact()
