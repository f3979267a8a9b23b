"""A branch has as few points as its tangents allow, and reads as one of many: the default step beside a tenth of it."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import paper_train

from geartrain.results.curve import Between


@pytest.fixture(scope="module")
def case():
    return paper_train(), {"start": 0.2, "stop": 2.6, "harmonics": 6}


@pytest.fixture(scope="module")
def branch(case):
    train, response = case
    return train.response(**response)


@pytest.fixture(scope="module")
def fine(case):
    train, response = case
    return train.response(step=0.01, **response)


def test_points_of_figure_3(branch):
    """Steps along the tangent took 397."""
    assert len(branch) <= 150


@pytest.mark.parametrize("step", [0.01, 0.04])
def test_a_step_bounds_the_steps(case, step):
    train, response = case
    branch = train.response(step=step, **response)
    # A step is measured along the tangent, the curve along itself.
    assert 0.9 * step < np.diff(branch.arclength).max() < 1.2 * step


def test_the_same_special_points(branch, fine):
    assert [special.kind for special in branch.special_points] == [special.kind for special in fine.special_points]
    np.testing.assert_allclose([special.frequency for special in branch.special_points],
                               [special.frequency for special in fine.special_points], rtol=1e-8)


@pytest.mark.parametrize("mesh", [1, 2])
def test_the_same_peaks(branch, fine, mesh):
    """Each is a point of the branch; parabolas through points of long steps were off by 1e-3."""
    peaks, exact = branch.peaks(mesh), fine.peaks(mesh)
    assert len(peaks) == len(exact)
    np.testing.assert_allclose([peak.rms for peak in peaks], [peak.rms for peak in exact], rtol=1e-8)
    np.testing.assert_allclose([peak.frequency for peak in peaks], [peak.frequency for peak in exact], rtol=1e-7)


def test_the_same_jumps_and_ranges(branch, fine):
    assert [(jump.kind, jump.direction) for jump in branch.jumps] == [(jump.kind, jump.direction) for jump in fine.jumps]
    np.testing.assert_allclose([jump.frequency for jump in branch.jumps], [jump.frequency for jump in fine.jumps], rtol=1e-8)
    np.testing.assert_allclose([jump.after for jump in branch.jumps], [jump.after for jump in fine.jumps], rtol=2e-3)
    for mesh in 1, 2:
        np.testing.assert_allclose(branch.separation_ranges(mesh, False), fine.separation_ranges(mesh, False), rtol=1e-8)
        np.testing.assert_allclose(branch.back_collision_ranges(mesh, False), fine.back_collision_ranges(mesh, False), rtol=1e-8)


def test_the_curve_between_the_points(branch):
    """Beside motions solved at the same Lambda amid the steps: within the tolerance of a step, 1e-3, times the steepness."""
    between = Between(branch)
    rms = between.of("rms", branch.rms)
    off = []
    for place in np.flatnonzero((between._share == 0.5) & (np.gradient(between.frequency) != 0))[::3]:
        slope = branch.free_slope[between._point[place]:between._point[place] + 2]
        if np.abs(slope).min() < 0.1:
            continue
        motions = branch.at(float(between.frequency[place]))
        off.append(np.abs(slope).min() * min(float(np.abs(motion.rms - rms[place]).max()) for motion in motions))
    assert len(off) > 20 and max(off) < 1e-3 and np.median(off) < 1e-4


def test_a_picture_has_the_curve(branch):
    pytest.importorskip("matplotlib")
    lines = branch.plot(mesh=2).lines
    places = np.concatenate([np.column_stack(line.get_data()) for line in lines])
    assert len(places) > 5 * len(branch)
    turn = np.abs(np.diff(np.unwrap(np.arctan2(*np.diff(places[places[:, 0] > 1.9], axis=0).T[::-1])))).max()
    assert turn < 0.2  # no corner that is seen


def test_points_between_special_points():
    """Two period doublings within a step, between which the motion is unstable: sweeps leave the branch at both."""
    train = paper_train()
    meshes = [replace(mesh, stiffness_cos=[0.42, 0.0, -0.141, 0.0, 0.084]) for mesh in train.meshes]
    branch = replace(train, meshes=meshes).response(start=0.2, stop=2.6, harmonics=12)
    doublings = [round(jump.frequency, 5) for jump in branch.jumps if jump.cause == "period doubling"]
    assert {0.62836, 0.62939} <= set(doublings)
    lengths = np.array([special.point for special in branch.special_points if special.kind == "period doubling"])
    assert len(set(lengths)) == len(lengths)


def test_old_results_have_no_slopes(branch):
    """Results of before are drawn by their points."""
    others = {name: value for name, value in branch.others.items() if "slope" not in name and name != "arclength"}
    old = replace(branch, others=others)
    assert len(Between(old).frequency) == len(branch)
    assert len(old.peaks(1)) == len(branch.peaks(1))
