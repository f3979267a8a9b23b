"""Branches and motions: shapes, values (time integration of another code), and the ways from one to the other."""

import copy
import pickle
import warnings
from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from conftest import paper_train, single_pair

import geartrain as gt

matplotlib.use("Agg")


def test_shapes_of_a_branch(branch):
    points = len(branch)
    assert branch.complete and not branch.closed
    assert branch.frequency.shape == branch.error_estimate.shape == branch.segment.shape == (points,)
    assert branch.estimate_doubtful.shape == branch.harmonics.shape == (points,)
    assert branch.estimate_doubtful.mean() < 0.1
    loads = (branch.mesh_force_maximum, branch.dynamic_factor, branch.separation_fraction, branch.back_contact_fraction)
    for values in (branch.rms, branch.mean, branch.minimum, branch.maximum, *loads):
        assert values.shape == (points, 2)
    assert branch.stable.dtype == bool and branch.stable.shape == (points,)
    assert branch.multipliers.shape == (points, 10) and np.iscomplexobj(branch.multipliers)
    assert branch.coefficients.shape == (points, 2, 13)
    np.testing.assert_array_equal(branch.mean, branch.coefficients[:, :, 0])
    rms = np.sqrt((branch.coefficients[:, :, 1:] ** 2).sum(axis=2))
    np.testing.assert_allclose(branch.rms, rms, rtol=1e-13)
    np.testing.assert_array_equal(branch.stable, abs(branch.multipliers).max(axis=1) < 1)


def test_eight_folds(branch):
    folds = [special for special in branch.special_points if special.kind == "fold"]
    assert len(folds) == 8
    for fold in folds:
        low, high = sorted(branch.frequency[fold.point : fold.point + 2])
        assert min(abs(fold.frequency - low), abs(fold.frequency - high)) < 0.05


def test_settings_that_are_absent_cost_nothing(train):
    branch = train.response(start=0.9, stop=1.0, stability=False)
    assert branch.stable is None and branch.multipliers is None
    assert branch.at(0.95)[0].rms.shape == (2,)


def test_solutions_at_a_frequency(branch):
    assert [motion.stable for motion in branch.at(0.6)] == [True, False, True]
    assert branch.at(3.0) == []
    for motion in branch.at(0.6):
        assert motion.frequency == 0.6


@pytest.mark.parametrize(("frequency", "rms", "largest"), [
    (0.4, (0.14980128, 0.18767890), 0.6827),
    (0.9, (0.41003761, 0.71440160), 0.8286),
])
def test_refine_and_integrate_agree(train, branch, frequency, rms, largest):
    refined = branch.at(frequency)[0].refine()
    settled = train.integrate(frequency=frequency)
    for motion in (refined, settled):
        np.testing.assert_allclose(motion.rms, rms, atol=2e-8)
        assert motion.period == 1 and motion.stable
        assert abs(motion.multipliers).max() == pytest.approx(largest, abs=5e-5)
    again = train.integrate(frequency, start=refined.state)
    np.testing.assert_allclose(again.rms, refined.rms, atol=1e-8)


def test_refine_warns_of_another_orbit(train):
    coarse = train.response(start=0.9, stop=0.91, harmonics=3, stability=False).at(0.9)[0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        coarse.refine()
    # Of the rms, three harmonics leave more than 1e-4: a motion that claims to be exact is then another one.
    with pytest.warns(UserWarning, match="may be another one"):
        replace(coarse, error_estimate=1e-9).refine()


def test_period_two(train):
    motion = train.integrate(1.92)
    assert motion.period == 2
    np.testing.assert_allclose(motion.rms, (0.45639898, 0.54946446), atol=2e-8)
    branch = train.response(start=1.6, stop=2.2, subharmonic=2, seed=motion)
    assert branch.subharmonic == 2 and len(branch) > 10


def test_waveform(branch):
    motion = branch.at(0.9)[0]
    assert motion.time.shape == (256,) and motion.displacement.shape == (256, 2)
    assert motion.time[1] * 256 == pytest.approx(2 * np.pi / 0.9)
    np.testing.assert_allclose(motion.displacement.mean(axis=0), motion.mean, rtol=1e-12)
    angle = 0.9 * motion.time[:, np.newaxis]
    series = motion.coefficients[:, 0] + sum(
        motion.coefficients[:, 2 * k - 1] * np.cos(k * angle) + motion.coefficients[:, 2 * k] * np.sin(k * angle)
        for k in range(1, 7)
    )
    np.testing.assert_allclose(motion.displacement, series, atol=1e-12)
    assert motion.waveform(64)[1].shape == (64, 2)
    for samples in (0, True, 2**31):
        with pytest.raises(gt.InputError, match=f"samples = {samples}: must be a whole number >= 1"):
            motion.waveform(samples)


def test_linear_train():
    motion = paper_train(half_backlash=0.0).response(start=0.2, stop=2.6).at(0.9)[0].refine()
    np.testing.assert_allclose(motion.rms, (0.50993678, 1.40266149), atol=2e-8)


def test_mesh_load(train, branch):
    np.testing.assert_allclose(branch.dynamic_factor * (3000.0, 6000.0), branch.mesh_force_maximum, rtol=1e-12)
    apart = branch.minimum < 1
    np.testing.assert_array_equal(apart, branch.separation_fraction > 0)
    np.testing.assert_array_equal(branch.minimum < -1, branch.back_contact_fraction > 0)
    balanced = branch.at(0.9)[0]
    refined, settled = balanced.refine(), train.integrate(0.9)
    for name in ("mesh_force_maximum", "dynamic_factor", "separation_fraction", "back_contact_fraction"):
        np.testing.assert_allclose(getattr(balanced, name), getattr(refined, name), rtol=3e-3, atol=1e-12)
        np.testing.assert_allclose(getattr(settled, name), getattr(refined, name), rtol=1e-7, atol=1e-12)
    for motion in (balanced, refined):
        assert motion.mesh_force.shape == motion.displacement.shape
        np.testing.assert_allclose(motion.mesh_force.max(axis=0), motion.mesh_force_maximum, rtol=1e-3)
    np.testing.assert_allclose(refined.mesh_force.mean(axis=0), (3000.0, 6000.0), rtol=1e-4)


def test_no_static_force_no_dynamic_factor():
    train = paper_train(half_backlash=0.0, input_torque=0.0, torque_cos=[1.0])
    branch = train.response(start=0.6, stop=0.7)
    assert np.isnan(branch.dynamic_factor).all() and (branch.mesh_force_maximum > 0).all()
    (motion,) = branch.at(0.65)
    assert np.isnan(motion.refine().dynamic_factor).all()
    assert np.isnan(train.integrate(0.65, start=motion).dynamic_factor).all()


def test_spectrum(train, branch):
    motion = branch.at(0.9)[0]
    order, amplitude = motion.spectrum()
    np.testing.assert_array_equal(order, np.arange(1, 7))
    assert amplitude.shape == (6, 2)
    np.testing.assert_allclose(np.sqrt((amplitude**2).sum(axis=0)), motion.rms, rtol=1e-12)
    # The DFT of the time history, sampled without aliasing.
    transform = 2 * abs(np.fft.rfft(motion.displacement, axis=0)) / len(motion.time)
    np.testing.assert_allclose(amplitude, transform[1:7], atol=1e-12)
    order, amplitude = train.integrate(1.92).spectrum()
    assert order[0] == 0.5 and amplitude[0, 0] > 0.1, "half orders of a motion of period 2"


def test_peaks_and_bands(branch):
    highest = max(branch.peaks(2), key=lambda peak: peak.rms)
    near = branch.frequency[[highest.point - 1, highest.point + 1]]
    assert near.min() < highest.frequency < near.max()
    # The top between the points: never below the highest of them.
    assert 0 <= highest.rms - branch.rms[highest.point, 1] < 1e-3
    assert highest.stable is True
    np.testing.assert_allclose(branch.bands_without_stability, [[1.7492, 2.0439]], atol=5e-5)


def test_jumps(branch):
    jumps = branch.jumps
    folds = sorted(special.frequency for special in branch.special_points if special.kind == "fold")
    assert [jump.frequency for jump in jumps if jump.cause == "fold"] == folds
    # Claim 41 of docs/claims.md.
    up = [jump for jump in jumps if jump.kind == "jump up" and jump.direction == "rising"]
    assert [round(jump.frequency, 4) for jump in up] == [0.4621, 0.7923, 1.6645]
    assert {0.4586, 1.5473} <= {round(jump.frequency, 4) for jump in jumps if jump.kind == "jump down"}
    for jump in jumps:
        up = np.linalg.norm(jump.after) > np.linalg.norm(jump.before)
        assert up if jump.kind == "jump up" else not up
    assert [jump.cause for jump in jumps if jump.kind == "leaves"] == ["period doubling"] * 2
    assert np.isnan(jumps[-1].after).all()


def test_ranges_of_contact(branch):
    for mesh in (1, 2):
        for ranges, level in ((branch.separation_ranges, 1), (branch.back_collision_ranges, -1)):
            every, stable = ranges(mesh), ranges(mesh, stable=True)
            below = branch.minimum[:, mesh - 1] < level
            for found, points in ((every, below), (stable, below & branch.stable)):
                inside = [((found[:, 0] <= f) & (f <= found[:, 1])).any() for f in branch.frequency[points]]
                assert found.shape[1:] == (2,) and all(inside)
            assert stable.size == 0 or np.ptp(stable, axis=1).sum() <= np.ptp(every, axis=1).sum()
    with pytest.raises(gt.InputError, match="mesh = 0"):
        branch.separation_ranges(0)


def test_readings_without_stability(train):
    plain = train.response(start=0.4, stop=0.6, stability=False)
    assert plain.jumps == [] and plain.bands_without_stability.shape == (0, 2)
    assert {peak.stable for peak in plain.peaks(2)} == {None}
    with pytest.raises(gt.InputError, match="stability"):
        plain.separation_ranges(2, stable=True)


def test_plot_of_a_motion(branch):
    motion = branch.at(0.9)[0]
    axes = motion.plot()
    assert len(axes) == 3 and len(axes[0].lines) == len(axes[1].lines) == 2
    order, amplitude = motion.spectrum()
    for mesh, lines in enumerate(axes[2].collections):
        shown = (amplitude > 3e-3 * amplitude.max()).any(axis=1)
        tops = np.array([segment[1] for segment in lines.get_segments()])
        np.testing.assert_array_equal(tops, np.stack([order, amplitude[:, mesh]], axis=1)[shown])
    assert motion.plot(mesh=2, axes=axes, color="black") is axes
    with pytest.raises(gt.InputError, match="mesh = 3"):
        motion.plot(mesh=3)


def test_sweep(train):
    motions = train.sweep(start=0.5, stop=0.7, points=3, direction="both")
    assert isinstance(motions, list) and motions.complete and motions[0].stable is None
    np.testing.assert_allclose(motions.frequency, [0.5, 0.6, 0.7, 0.7, 0.6, 0.5])
    assert motions.direction == ("up",) * 3 + ("down",) * 3
    assert motions.rms.shape == (6, 2)


def test_attractors(train):
    found = train.attractors(0.6, starts=20)
    assert sum(motion.share for motion in found) == pytest.approx(1)
    assert len(found) == 2 and all(motion.stable for motion in found)
    assert isinstance(found, list) and (found.starts, found.unsettled, found.complete) == (20, 0.0, True)
    again = train.attractors(0.6, starts=20)
    assert [motion.share for motion in again] == [motion.share for motion in found]


def test_starts_that_do_not_settle_are_told(train):
    found = train.attractors(0.6, starts=20, max_periods=8)
    assert 0 < found.unsettled < 1
    assert found.unsettled + sum(motion.share for motion in found) == pytest.approx(1)
    assert f"{found.unsettled:.1%} unsettled" in repr(found)
    same = pickle.loads(pickle.dumps(found))
    assert same.unsettled == found.unsettled and [motion.share for motion in same] == [motion.share for motion in found]


def test_period_doublings(train):
    once = train.response(start=2.2, stop=4.2, period_doublings=1)
    doublings = [special for special in once.special_points if special.kind == "period doubling"]
    assert len(doublings) == 2 and len(once.branches) == 1  # one branch from the one to the other
    (twice,) = once.branches
    assert twice.subharmonic == 2 and twice.complete and twice.origin.startswith("period doubling of the response")
    alone = once.period_doubled(doublings[0])
    np.testing.assert_array_equal(twice.coefficients, alone.coefficients)
    assert {motion.period for motion in twice.at(3.7)} == {2} and twice.settings["harmonics"] == 12
    same = pickle.loads(pickle.dumps(once)).branches[0]
    np.testing.assert_array_equal(same.at(3.7)[0].rms, twice.at(3.7)[0].rms)
    lines = once.plot(mesh=1).lines
    assert len({line.get_color() for line in lines}) == 1
    assert sum(line.get_linewidth() == 0.8 for line in lines) >= 1
    assert train.response(start=0.9, stop=1.0).branches == []


def test_a_branch_without_points(branch, tmp_path):
    """It reads as empty, and is written, drawn and pickled like any other."""
    arrays = [name for name, value in vars(branch).items() if isinstance(value, np.ndarray)]
    others = {name: value[:0] for name, value in branch.others.items()}
    empty = replace(
        branch, special_points=[], ended="nothing found", others=others, **{name: getattr(branch, name)[:0] for name in arrays}
    )
    assert len(empty) == 0 and empty.at(1.6) == [] and empty.peaks(1) == [] and empty.jumps == []
    for ranges in (empty.bands_without_stability, empty.separation_ranges(1), empty.back_collision_ranges(2, stable=True)):
        assert ranges.shape == (0, 2)
    with pytest.raises(gt.InputError, match="mesh = 3"):
        empty.peaks(3)
    ax = empty.plot()
    assert [len(line.get_xdata()) for line in ax.lines] == [0, 0] and len({line.get_color() for line in ax.lines}) == 2
    with_it = replace(branch, branches=[empty])
    assert len(with_it.plot(mesh=1).lines) == len(branch.plot(mesh=1).lines) + 1
    unknown = replace(empty, stable=None, multipliers=None)
    assert unknown.at(1.6) == [] and unknown.jumps == []


def test_a_motion_without_bound(train):
    """At 1.9 the train in contact is unstable: far out, where the backlash is nothing, so is every motion."""
    far = np.zeros(10)
    far[[1, 3]] = 1e3
    with pytest.raises(gt.SolverError, match=r"grows without bound at Lambda = 1\.9"):
        train.integrate(1.9, start=far)
    linear = paper_train(half_backlash=0.0)
    static = linear.response(start=1.9, stop=1.91).at(1.9)[0]
    assert not static.stable  # by its multipliers, hence the sweep must run away
    motions = linear.sweep(start=1.9, stop=2.4, points=2)
    assert [motion.unbounded for motion in motions] == [True, False] and [motion.period for motion in motions] == [0, 1]
    assert motions.complete and motions.rms.shape == (2, 2) and np.isnan(motions.rms[0]).all()
    for ask in (lambda: motions[0].time, lambda: motions[0].displacement, motions[0].refine, motions[0].plot):
        with pytest.raises(gt.SolverError, match="grows without bound"):
            ask()
    assert linear.attractors(1.9, starts=3).unsettled == 1


def test_readings_of_a_doubled_branch(train):
    """Each further branch and each attractor has what a response has."""
    (twice,) = train.response(start=2.2, stop=4.2, period_doublings=1).branches
    np.testing.assert_array_equal(twice.minimum < 1, twice.separation_fraction > 0)
    highest = max(twice.peaks(1), key=lambda peak: peak.rms)
    assert 0 <= highest.rms - twice.rms[highest.point, 0] < 1e-3
    (motion,) = (motion for motion in twice.at(3.7) if motion.stable)
    (settled,) = train.attractors(3.7, starts=8)
    assert settled.period == 2
    for name in ("mesh_force_maximum", "separation_fraction", "back_contact_fraction"):
        np.testing.assert_allclose(getattr(motion, name), getattr(settled, name), rtol=3e-3, atol=1e-12)
    ranges = twice.separation_ranges(1)
    assert all(((ranges[:, 0] <= f) & (f <= ranges[:, 1])).any() for f in twice.frequency[twice.minimum[:, 0] < 1])


def test_attractors_are_followed(train):
    known = train.response(start=1.0, stop=3.2)
    found = train.attractors(2.4, starts=40, follow=known)
    assert [motion.period for motion in found] == [1, 3]
    (island,) = found.branches
    assert island.closed and island.subharmonic == 3 and island.origin == "attractor 2 at Lambda = 2.4"
    assert any(np.allclose(motion.rms, found[1].rms, atol=2e-3) for motion in island.at(2.4))
    with pytest.raises(gt.InputError, match=r"range of &response, 1\.0 to 3\.2"):
        train.attractors(0.6, starts=2, follow=known)


def test_copy_and_pickle(branch, train):
    motion = branch.at(0.9)[0]
    sweep = train.sweep(start=0.5, stop=0.7, points=2)
    for same in (copy.deepcopy(motion), pickle.loads(pickle.dumps(motion))):
        np.testing.assert_array_equal(same.refine().rms, motion.refine().rms)
    for same in (copy.deepcopy(branch), pickle.loads(pickle.dumps(branch))):
        np.testing.assert_array_equal(same.at(0.9)[0].rms, motion.rms)
    for same in (copy.deepcopy(sweep), pickle.loads(pickle.dumps(sweep))):
        np.testing.assert_array_equal(same.rms, sweep.rms)
        assert same.direction == sweep.direction


def test_plot(branch):
    ax = branch.plot(mesh=2)
    styles = {line.get_linestyle() for line in ax.lines}
    assert styles == {"-", "--"}
    assert sum(len(line.get_xdata()) for line in ax.lines) == len(branch) + len(ax.lines) - 1
    assert "Lambda" in ax.get_xlabel() and "b_c" in ax.get_ylabel()
    assert branch.plot(ax=ax) is ax
    assert all(line.get_linestyle() == "--" for line in branch.plot(mesh=1, ls="--", c="k").lines)  # matplotlib's short names
    with pytest.raises(gt.InputError, match="mesh = 3"):
        branch.plot(mesh=3)


def test_parts_are_not_joined(branch):
    from geartrain._draw import runs

    pieces = list(runs([True, True, False, False, True], [1, 1, 1, 2, 2]))
    assert pieces == [(slice(0, 3), True), (slice(2, 3), False), (slice(3, 5), False), (slice(4, 5), True)]


def test_a_linear_pair_without_damping_is_not_chaotic():
    """Its exponent is rounding, 1e-17, and so is what that is uncertain by."""
    motion = single_pair(0.4, damping_ratio=0.0, error_cos=[0.05]).integrate(2**0.5, max_periods=300)
    assert motion.kind in ("quasi-periodic", "periodic")
