"""Pictures: what is drawn are the results, on axes in their units; and what only pictures need."""

import pickle
from dataclasses import replace
from itertools import combinations

import matplotlib as mpl
import numpy as np
import pytest
from conftest import single_pair
from matplotlib import pyplot as plt

import geartrain as gt
from geartrain.plots.draw import COLORS

mpl.use("Agg")
pytestmark = pytest.mark.usefixtures("closed_figures")


# ---------------------------------------------------------------------------------------------- over speed


@pytest.mark.parametrize(("unit", "label", "factor"), [
    (None, r"fundamental frequency  $\Lambda$", 1.0), ("Lambda", r"fundamental frequency  $\Lambda$", 1.0),
    ("Hz", "fundamental frequency  [Hz]", 9870.0 / (2 * np.pi)),
])
def test_a_response_in_its_units(branch, unit, label, factor):
    ax = branch.plot(mesh=2, unit=unit)
    assert ax.get_xlabel() == label
    assert ax.get_ylabel() == "mesh displacement, rms of the paper\n(true rms times \u221a2)  $/\\, b_c$"
    drawn = {(x, y) for line in ax.lines for x, y in zip(*line.get_data(), strict=True)}
    # With places between the points, see test_fewer_points.py.
    assert drawn > set(zip(factor * branch.frequency, branch.rms[:, 1], strict=True))


def test_any_quantity_of_a_response(branch):
    ax = branch.plot(quantity="mesh_force")
    assert ax.get_ylabel() == "largest mesh force  [N]"
    drawn = np.concatenate([line.get_ydata() for line in ax.lines])
    assert set(drawn) > set(branch.mesh_force_maximum.ravel())
    assert drawn.max() == branch.mesh_force_maximum.max()
    assert branch.plot(quantity="dynamic_factor", mesh=1).get_ylabel() == "dynamic factor, largest over mean mesh force"
    assert branch.plot(quantity="true_ac_rms").get_ylabel() == r"mesh displacement, true rms  $/\, b_c$"
    swing = np.concatenate([line.get_ydata() for line in branch.plot(quantity="peak_to_peak").lines])
    assert set(swing) > set((branch.maximum - branch.minimum).ravel())
    with pytest.raises(gt.InputError, match=r"quantity = 'colour': must be .*'rms'.*'mesh_force'"):
        branch.plot(quantity="colour")
    with pytest.raises(gt.InputError, match="quantity = 'rms': is of each mesh"):
        branch.plot(shaft=1, quantity="rms")
    assert "torque" in branch.plot(shaft=1).get_ylabel()


def test_jumps_and_ranges_of_a_response(branch):
    plain, ax = branch.plot(mesh=2), branch.plot(mesh=2, jumps=True, ranges=True)
    arrows = {(text.xyann[0], text.xyann[1], text.xy[1]) for text in ax.texts if text.arrow_patch is not None}
    assert arrows == {(jump.frequency, jump.before[1], jump.after[1]) for jump in branch.jumps if np.isfinite(jump.after).all()}
    vertical = {line.get_xdata()[0] for line in ax.lines if line.get_linestyle() == ":"}
    assert vertical == {jump.frequency for jump in branch.jumps if not np.isfinite(jump.after).all()}
    strips = {(patch.get_x(), patch.get_x() + patch.get_width()) for patch in ax.patches}
    ranges = [*branch.separation_ranges(2, stable=True), *branch.back_collision_ranges(2, stable=True)]
    np.testing.assert_allclose(sorted(strips), sorted(map(tuple, ranges)))
    assert len(plain.patches) == 0 and ax.get_xlim() == pytest.approx(plain.get_xlim())
    legend = [text.get_text() for text in ax.get_legend().get_texts()]
    assert legend == ["mesh 2", "unstable", "jump", "switches to another vibration", "teeth separate", "back flanks collide"]


def test_jumps_of_any_quantity(branch):
    """The force before a jump is that of the fold, the force after it lies on a curve at the same speed."""
    ax = branch.plot(mesh=2, quantity="mesh_force", jumps=True)
    arrows = [(text.xyann[0], text.xyann[1], text.xy[1]) for text in ax.texts if text.arrow_patch is not None]
    lands = [jump for jump in branch.jumps if np.isfinite(jump.after).all()]
    assert len(arrows) == len(lands) > 2
    for (at, before, after), jump in zip(arrows, lands, strict=True):
        known = max(branch.at(jump.frequency), key=lambda motion: -abs(motion.rms - jump.after).max())
        assert at == jump.frequency and after == pytest.approx(known.mesh_force_maximum[1], rel=5e-3)
        fold = min(branch.special_points, key=lambda special: abs(special.frequency - jump.frequency))
        assert before == pytest.approx(branch.mesh_force_maximum[fold.point, 1], rel=0.05)


def test_the_scale_is_that_of_the_stable_motions(branch, train):
    """All stable motions that repeat after one period are inside; what is stable and larger is told."""
    for quantity, values in (("rms", branch.rms), ("mesh_force", branch.mesh_force_maximum)):
        bottom, top = branch.plot(quantity=quantity).get_ylim()
        assert bottom == 0 and values[branch.stable].max() < top < 1.2 * values[branch.stable].max()
    part = branch.stable & (branch.frequency > 1.0)
    cut = replace(branch, stable=part)
    top = cut.plot(quantity="mesh_force").get_ylim()[1]
    assert top < 1.2 * branch.mesh_force_maximum[part].max() < branch.mesh_force_maximum.max()
    doubled = train.response(start=1.5, stop=2.3, period_doublings=1)
    larger = [other.mesh_force_maximum[other.stable].max() for other in doubled.branches if other.subharmonic == 2]
    ax = doubled.plot(quantity="mesh_force")
    if max(larger) > ax.get_ylim()[1]:
        assert any("repeats after 2 periods" in text.get_text() for text in ax.texts)


def test_unequal_shafts_have_panels(branch):
    """Shafts 1 and 3 of figure 3 hold their mean torque, shaft 2 swings by 2900 N m."""
    ax = branch.plot(quantity="shaft_torque")
    panels = ax.figure.axes
    assert len(panels) == 3 and ax is panels[0]
    assert [panel.texts[0].get_text() for panel in panels] == list(branch.train.shaft_labels)
    assert {panel.get_xlim() for panel in panels} == {ax.get_xlim()} and panels[-1].get_xlabel()
    for panel, mean in zip(panels, (150.0, 300.0, 600.0), strict=True):
        low, high = panel.get_ylim()
        assert low < mean < high and high - low > 0.05 * mean
    ax.figure.canvas.draw()
    assert all(panel.yaxis.get_offset_text().get_text() == "" for panel in panels)
    given = plt.figure().subplots()
    assert branch.plot(quantity="shaft_torque", ax=given) is given and len(given.figure.axes) == 1
    # Axes of the user are scaled as a picture of its own, unless they hold something already.
    empty, taken = plt.figure().subplots(1, 2)
    taken.plot([0.4, 0.5], [0.0, 100.0])
    for axes in (empty, taken):
        branch.plot(ax=axes, quantity="rms")
    assert empty.get_ylim() == branch.plot(quantity="rms").get_ylim() and taken.get_ylim()[1] > 100
    assert len(branch.plot(quantity="mesh_force").figure.axes) == 1


@pytest.mark.full
def test_a_train_with_a_drawing_opens_on_its_mesh_force(drawn_branch):
    branch = drawn_branch
    ax = branch.plot()
    assert ax.get_ylabel() == "largest mesh force  [N]" and ax.get_xlabel() == "speed of motor  [rpm]"
    assert max(line.get_ydata().max() for line in ax.lines) == pytest.approx(branch.mesh_force_maximum.max(), rel=1e-6)
    ax.figure.canvas.draw()
    for axis in (ax.xaxis, ax.yaxis):
        assert axis.get_offset_text().get_text() == ""
        assert all(text.get_text().lstrip("\u2212").replace(".", "").isdigit() for text in axis.get_ticklabels())


def test_a_response_that_ended_early_says_so(branch):
    """Two stubs: the range between them is hatched, the legend says why, and no jump is told where there is none."""
    low, high = branch.frequency < 0.4, branch.frequency > 2.0
    kept = low | high
    points = {name: values[kept] for name, values in branch.arrays().items() if values is not None and name not in branch.others}
    points["segment"] = np.where(low, 1, 2)[kept]
    ended = "from Lambda = 0.2: step below 1e-9"
    stubs = replace(branch, **points, special_points=[], complete=False, ended=ended)
    ax = stubs.plot()
    (gap,) = ax.patches
    ends = branch.frequency[low].max(), branch.frequency[high].min()
    assert (gap.get_x(), gap.get_x() + gap.get_width()) == pytest.approx(ends)
    assert [text.get_text() for text in ax.get_legend().get_texts()][-1] == "not computed"
    assert ax.get_legend().get_title().get_text() == ended
    long = replace(stubs, ended="; ".join([ended] * 7)).plot().get_legend().get_title().get_text()  # in one line
    assert long.startswith(ended) and long.endswith(" ...") and len(long) <= 64 and "\n" not in long
    assert not stubs.plot(ax=plt.figure().subplots()).patches and not branch.plot().patches


def test_a_legend_leaves_the_axes_their_width(branch):
    """Names of many letters stand in as many columns as there is room for."""
    from geartrain.plots.draw import new_axes, put_legend

    ax = new_axes(None)
    for place in range(3):
        ax.plot([0, 1], [place, place], label="a gear of a long name - another " + "x" * 10 * place)
    put_legend(ax, own=True)
    ax.figure.canvas.draw()
    legend = ax.get_legend().get_window_extent()
    assert ax.get_window_extent().width > 0.8 * ax.figure.bbox.width
    assert legend.x0 >= 0 and legend.x1 <= ax.figure.bbox.width


def test_the_torque_of_the_shafts_over_speed(branch, monkeypatch):
    """Smallest and largest in one colour, with what lies between them shaded, of shafts that are not rigid."""
    from geartrain._core.box import Group, described
    from geartrain.plots import response_plot

    fields = {name: (("point", "shaft"), "N m", "") for name in ("shaft_torque_minimum", "shaft_torque_maximum")}
    listed = {**described(), "/response": Group(about={**described()["/response"].about, **fields})}
    monkeypatch.setattr(response_plot, "described", lambda: listed)
    torque = np.array([100.0, np.nan, 300.0]) + 50 * branch.rms[:, :1]
    turned = replace(branch, others={**branch.others, **dict(zip(fields, (torque, 2 * torque), strict=True))})
    ax = turned.plot(quantity="shaft_torque")
    assert ax.get_ylabel() == "shaft torque, smallest to largest  [N m]"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["shaft 1", "shaft 3", "unstable"]
    for color, column in zip(COLORS, (0, 2)):
        drawn = {y for line in ax.lines if mpl.colors.same_color(line.get_color(), color) for y in line.get_ydata()}
        assert drawn > {*torque[:, column], *(2 * torque[:, column])}
        # What is shaded are the stable motions, each from the smallest to the largest torque.
        shaded = [shade.get_paths()[0].vertices for shade in ax.collections
                  if mpl.colors.same_color(shade.get_facecolor()[0, :3], color)]
        assert shaded and {*np.concatenate(shaded)[:, 1]} <= drawn
        stable = branch.frequency[branch.stable]
        assert {*stable} <= {*np.concatenate(shaded)[:, 0]}
    assert len(turned.plot(quantity="shaft_torque", shaft=3).lines) == len(ax.lines) // 2
    with pytest.raises(gt.InputError, match="shaft = 4: must be 1 to 3"):
        turned.plot(quantity="shaft_torque", shaft=4)


def test_a_sweep_in_rpm(drawn):
    sweep = drawn.sweep(start=1500.0, stop=1520.0, points=2, direction="both")
    assert sweep.plot().get_ylabel() == "largest mesh force  [N]"
    ax = sweep.plot(mesh=1, quantity="true_ac_rms")
    assert ax.get_xlabel() == "speed of motor  [rpm]" and ax.get_ylabel() == r"mesh displacement, true rms  [$\mu$m]"
    up, down, *_ = ax.lines
    np.testing.assert_allclose(up.get_xdata(), [1500.0, 1520.0])
    np.testing.assert_allclose(up.get_ydata(), sweep.rms[:2, 0] / np.sqrt(2), rtol=1e-15)
    np.testing.assert_allclose(down.get_ydata(), sweep.rms[2:, 0] / np.sqrt(2), rtol=1e-15)
    with pytest.raises(gt.InputError, match="quantity = 'shaft_torques': must be"):
        sweep.plot(quantity="shaft_torques")


def test_peaks_are_a_table(branch):
    peaks = branch.peaks()
    assert isinstance(peaks, list) and [peak.mesh for peak in peaks] == [1] * len(branch.peaks(1)) + [2] * len(branch.peaks(2))
    heading, *rows = str(peaks).splitlines()
    assert heading.split()[:2] == ["mesh", "fundamental"] and "speed" not in heading and len(rows) == len(peaks)
    highest = max(peaks, key=lambda peak: peak.rms)
    assert f"{highest.rms:.6g}" in rows[peaks.index(highest)] and rows[peaks.index(highest)].endswith("yes")
    assert highest.mesh_force_maximum == branch.mesh_force_maximum[highest.point, highest.mesh - 1]
    assert str(branch.peaks(1)[:0]) == "[]" and not branch.peaks().ends


def test_the_largest_at_an_end_of_the_range_is_no_peak_but_told(train):
    """Mesh 2 of figure 3 peaks at 0.73: a range that ends before it has its largest rms and force at the end."""
    part = train.response(start=0.62, stop=0.70, harmonics=6)
    peaks = part.peaks(2)
    ((end, what),) = peaks.ends
    assert what == "largest rms and largest force" and end.frequency in {0.62, 0.7} and end.mesh == 2
    assert end.rms == part.rms[:, 1].max() and end.mesh_force_maximum == part.mesh_force_maximum[part.stable, 1].max()
    *_, last = str(peaks).splitlines()
    assert last.endswith(what) and "at the end of the range" in str(peaks)
    assert pickle.loads(pickle.dumps(peaks)) == peaks and str(pickle.loads(pickle.dumps(peaks))) == str(peaks)


@pytest.mark.full
def test_jumps_and_special_points_are_tables(branch, drawn_branch):
    heading, *rows = str(branch.jumps).splitlines()
    assert len(rows) == len(branch.jumps) and "jump down" in rows[0] and heading.split()[:3] == ["sweep", "fundamental", "[Hz]"]
    heading, *rows = str(branch.special_points).splitlines()
    assert len(rows) == len(branch.special_points) and rows[0].split()[0] == branch.special_points[0].kind == "fold"
    assert isinstance(branch.jumps, list) and isinstance(branch.special_points, list)
    told = str(drawn_branch.jumps)
    assert "speed [rpm]" in told and "rms of the paper [um] before" in told and "Lambda" not in told
    assert "rms of the paper [um]" in str(drawn_branch.special_points) and "rms of the paper [um]" in str(drawn_branch.peaks())


def test_a_stability_map_in_hertz(train):
    chart = train.stability_map(start=0.4, stop=0.6, points=4, parameter_start=0.1, parameter_stop=0.3, parameter_points=3)
    assert chart.plot().get_xlabel() == r"fundamental frequency  $\Lambda$" and chart.speed is None
    ax = chart.plot(unit="Hz")
    assert ax.get_xlabel() == "fundamental frequency  [Hz]"
    left, right = (chart.fundamental_frequency[place] for place in (0, -1))
    cell = (right - left) / 3
    assert ax.get_xlim() == pytest.approx((left - cell / 2, right + cell / 2))
    np.testing.assert_array_equal(chart.to_dataset().fundamental_frequency, chart.fundamental_frequency)


# ------------------------------------------------------------------------------------------------- motions


def test_a_trajectory_goes_on_as_the_equations_do():
    """Two frequencies: p'' + p = 1.4 + e'' in contact, solved by hand."""
    frequency, error = np.sqrt(2), 0.05
    train = single_pair(0.4, damping_ratio=0.0, error_cos=error)
    motion = train.integrate(frequency, start=[1.5, 0.1])
    assert motion.period == 0 and motion.minimum[0] > 1
    path = motion.trajectory(200, samples=8)
    forced = -error * frequency**2 / (1 - frequency**2)
    begin, rate = motion.state
    free = begin - 1.4 - forced
    time = path.time
    expected = 1.4 + forced * np.cos(frequency * time) + free * np.cos(time) + rate * np.sin(time)
    np.testing.assert_allclose(time, np.arange(1600) * 2 * np.pi / frequency / 8, rtol=1e-14)
    np.testing.assert_allclose(path.displacement[:, 0], expected, atol=1e-9)
    velocity = -forced * frequency * np.sin(frequency * time) - free * np.sin(time) + rate * np.cos(time)
    np.testing.assert_allclose(path.velocity[:, 0], velocity, atol=1e-9)
    np.testing.assert_allclose(path.mesh_force[:, 0], expected - 1.0, atol=1e-9)
    displacement, velocity = path.section
    np.testing.assert_array_equal(displacement, path.displacement[::8])
    assert displacement.shape == velocity.shape == (200, 1)


def test_a_trajectory_of_a_periodic_motion_repeats_itself(branch, train):
    for motion in (branch.at(0.9)[0], train.integrate(1.92)):  # a sum of harmonics; an orbit of period 2
        path = motion.trajectory(5)
        own = 256 * motion.period
        assert path.samples_per_period == 256 and path.displacement.shape == (5 * 256, 2)
        np.testing.assert_array_equal(path.displacement[own:], path.displacement[:-own])
        np.testing.assert_allclose(path.displacement[:own], motion.waveform(own)[1], rtol=1e-14)
        slope = (np.roll(path.displacement, -1, 0) - np.roll(path.displacement, 1, 0))[:own] / (path.time[2] - path.time[0])
        np.testing.assert_allclose(path.velocity[1:own - 1], slope[1:-1], atol=2e-3)
    for wrong in (0, 2.5, True, "many"):
        with pytest.raises(gt.InputError, match=r"periods = .*: must be a whole number >= 1"):
            motion.trajectory(wrong)


def test_a_chaotic_motion_as_pictures():
    motion = single_pair(0.4, stiffness_cos=0.6).integrate(1.9)
    assert motion.kind == "chaotic"
    path = motion.trajectory(60, samples=4)
    assert motion.minimum[0] - 0.05 < path.displacement.min() and path.displacement.max() < motion.maximum[0] + 0.05
    (points,) = motion.poincare_section(periods=50).lines
    np.testing.assert_allclose(points.get_data(), np.array(motion.trajectory(50, samples=1).section)[..., 0])
    ax = motion.phase_plane(periods=30)
    assert ax.get_xlabel() == r"displacement of mesh 1 $/\, b_c$" and ax.get_ylabel() == r"velocity $/\, b_c \omega_c$"
    assert len(ax.lines[0].get_xdata()) == 30 * 1024
    (gap,) = ax.patches
    assert (gap.get_x(), gap.get_width()) == (-1.0, 2.0)
    assert motion.plot(periods=40)[0].lines[0].get_xdata()[-1] == pytest.approx(40, abs=0.01)


def test_a_motion_of_the_reducer_in_ms_and_orders(drawn):
    motion = drawn.integrate(1500.0)
    axes = motion.plot(mesh=2)
    assert [ax.get_ylabel() for ax in axes] == [r"displacement [$\mu$m]", "mesh force  [N]", r"amplitude [$\mu$m]"]
    assert axes[1].get_xlabel() == "time  [ms]" and axes[2].get_xlabel() == "order, per revolution of motor"
    assert axes[0].get_legend().get_title().get_text() == "1500 rpm of motor"
    time, displacement = axes[0].lines[0].get_data()
    # Four cycles of mesh 2, the slowest excitation; a whole period is a revolution of the middle shaft.
    np.testing.assert_array_equal(displacement, motion.displacement[:len(displacement), 1])
    whole = 1e3 * 60 / 1500 * 71 / 23
    assert time[-1] == pytest.approx(4 / 19 * whole, rel=1e-3)
    for periods in (0.5, 1, 2):
        assert motion.plot(periods=periods)[0].lines[0].get_xdata()[-1] == pytest.approx(periods * whole, rel=1e-3)
    with pytest.raises(gt.InputError, match=r"periods = 0: must be a number > 0"):
        motion.plot(periods=0)
    # Each line of the spectrum stands at its order, whichever the mesh, and clear of the frame.
    both = motion.plot()[2]
    assert len({tuple(line.get_xdata()) for line in both.lines}) == 1 and both.get_xlim()[0] < 0
    np.testing.assert_array_equal([segment[0, 0] for segment in both.collections[1].get_segments()], both.lines[0].get_xdata())
    named = {text.get_text(): text.xy[0] for text in axes[2].texts}
    assert named["mesh 1"] == pytest.approx(23) and named["mesh 2"] == pytest.approx(23 / 71 * 19)
    assert named["2 x mesh 2"] == pytest.approx(2 * 23 / 71 * 19)
    hertz = motion.plot(mesh=2, unit="Hz")[2]
    assert {text.get_text(): text.xy[0] for text in hertz.texts}["mesh 1"] == pytest.approx(23 * 1500 / 60)
    plane = motion.phase_plane(2)
    assert plane.get_ylabel() == "velocity [mm/s]"
    points = plane.lines[0].get_xydata() / np.ptp(plane.lines[0].get_xydata(), axis=0)
    assert np.hypot(*np.diff(points, axis=0).T).max() < 0.006
    (point,) = motion.poincare_section(2).lines
    assert len(point.get_xdata()) == 1


def test_a_waterfall_has_absolute_levels(drawn):
    """Colours in dB over 1 N with amplitudes beside them; names of orders that do not overlap."""
    run_up = drawn.run_up(start=1400, stop=2000, unit="rpm", duration=0.5)
    ax = run_up.waterfall()
    (image,) = ax.collections
    largest = 20 * np.log10(run_up.spectra()[2].max())
    assert image.get_array().max() == pytest.approx(largest, abs=0.1)
    assert largest <= image.get_clim()[1] <= largest + 1
    bar = image.colorbar.ax
    assert bar.get_ylabel() == "dB re 1 N"
    (amplitude,) = bar.child_axes
    assert amplitude.get_ylabel() == "amplitude  [N]"
    ax.figure.canvas.draw()
    np.testing.assert_allclose(amplitude.get_ylim(), 10 ** (np.array(bar.get_ylim()) / 20))
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) >= 3 and not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    assert run_up.waterfall("shaft_torque", 2).collections[0].colorbar.ax.get_ylabel() == "dB re 1 N m"


# ---------------------------------------------------------------------------------------------- the style


def test_pictures_have_one_style_that_needs_no_colour(branch):
    """The first colours differ by 10 in lightness (CIE L*) at least; meshes have marks; given axes keep their colours."""
    channels = np.array([mpl.colors.to_rgb(color) for color in COLORS[:3]])
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    lightness = np.sort(116 * np.cbrt(linear @ [0.2126, 0.7152, 0.0722]) - 16)
    assert np.diff(lightness).min() > 10
    looks = {(line.get_color(), line.get_marker()) for line in branch.plot().lines}
    assert looks == set(zip(COLORS, ("o", "s"), strict=False))
    assert len({*branch.plot().lines[0].get_markevery()}) < len(branch)
    given = plt.figure().subplots()
    given.set_prop_cycle(color=["black"])
    assert {line.get_color() for line in branch.plot(ax=given).lines} == {"black"}


def test_every_plot_takes_axes_and_gives_them(train, branch):
    motion, sweep = branch.at(0.9)[0], train.sweep(start=0.4, stop=0.5, points=2)
    chart = train.stability_map(start=0.5, stop=1.0, points=2, linear=True, parameter_start=0.0, parameter_stop=0.1,
                                parameter_points=2)
    run_up = train.run_up(start=0.4, stop=0.5, duration=0.05)
    for draw in (branch.plot, sweep.plot, train.plot, train.modes().plot, train.campbell(start=0.2, stop=1.0).plot, chart.plot,
                 run_up.plot, run_up.waterfall, motion.phase_plane, motion.poincare_section):
        ax = plt.figure().subplots()
        assert draw(ax=ax) is ax
    axes = plt.figure().subplots(3)
    assert motion.plot(axes=axes) is axes
