"""Atlas of the paper's train: python example/atlas.py [FOLDER] [--check]

Curves of all special points of the motions of period 1 and 2 of figure 3's train, over Lambda and the stiffness variation, the
torque and the backlash, drawn over the number of stable motions. --check compares the regions with random starts at 100 places
each, which a random number generator chose before anything was computed. Pictures go to FOLDER (docs).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import ListedColormap
from scipy.ndimage import distance_transform_edt, label

import geartrain as gt

ROOT = Path(__file__).resolve().parents[1]
RANGES = {"stiffness_variation": (0.02, 0.5), "input_torque": (20.0, 300.0), "mesh * half_backlash": (3e-6, 60e-6)}
LABELS = {"stiffness_variation": "kappa, both meshes", "input_torque": "Torque [N m]",
          "mesh * half_backlash": "Half backlash [um], both meshes"}
# Values of the paper's figures: 7 over the stiffness variation, 6 over the torque; all have this backlash.
SECTIONS = {"stiffness_variation": (0.1, 0.2, 0.3, 0.42), "input_torque": (50.0, 100.0, 150.0), "mesh * half_backlash": (30e-6,)}
LAMBDA = (0.3, 2.6)
AMPLITUDE_LIMIT = 12.0
ROWS = 49
NAMES = ("no stable one", "1", "2", "3 or more", "1 of period 2", "1 and 1 of period 2", "more")
COLOURS = ("#dddddd", "#ffffff", "#cfe3f5", "#7fb2dd", "#fde3b5", "#f9c26b", "#c9a0c9")
STYLES = {"fold": ("C0", "-"), "period doubling": ("C3", "-"), "neimark-sacker": ("C4", "-"), "separation": ("C2", ":"),
          "back contact": ("C5", "--")}


def branches_of(train):
    """The response and its branches of period 2."""
    response = train.response(start=LAMBDA[0], stop=LAMBDA[1], harmonics=12, period_doublings=1,
                              amplitude_limit=AMPLITUDE_LIMIT)
    return [response, *(branch for branch in response.branches if branch.subharmonic == 2)]


def is_known(branches, frequency, rms, share):
    """Whether one of the branches passes a motion, within a share of it."""
    return any(np.allclose(own.rms, rms, rtol=share) for branch in branches for own in branch.at(frequency))


def islands_of(train, branches, motions, share):
    """Branches that hang together with none of those known, from motions, unless a share is all in which one differs."""
    found = []
    for motion in motions:
        if is_known([*branches, *found], motion.frequency, motion.rms, share):
            continue
        try:
            island = train.response(start=LAMBDA[0], stop=LAMBDA[1], harmonics=12 * motion.period, subharmonic=motion.period,
                                    amplitude_limit=AMPLITUDE_LIMIT, seed=motion)
        except (gt.SolverError, gt.InputError):
            continue
        # It may have led to a branch that is known, also as one of twice the period.
        places = np.linspace(0, len(island) - 1, 7).astype(int)[1:-1]
        again = sum(is_known([*branches, *found], float(island.frequency[k]), island.rms[k], 1e-2) for k in places)
        if island.stable.any() and again < 3:
            found.append(island)
    return found


def stable_ones(branches):
    """About forty stable motions of each branch: an island may end within a row or two."""
    for branch in branches:
        at = np.flatnonzero(branch.stable)
        for i in at[:: max(len(at) // 40, 1)]:
            frequency = float(branch.frequency[i])
            yield from (motion for motion in branch.at(frequency) if np.allclose(motion.rms, branch.rms[i], rtol=1e-3))


def random_ones(train):
    """Motions of period 1 and 2 that random starts settle at."""
    # Over the whole range, and once more where most motions are.
    for frequency in [*np.linspace(*LAMBDA, 24), *np.linspace(1.0, 1.8, 16)]:
        yield from (motion for motion in train.attractors(frequency, starts=16) if motion.period in (1, 2))


def rows_of(train, parameter, values):
    """All branches for each value: from rest, their doublings, and islands, from random starts and from neighbouring values."""
    trains = [train.with_values({parameter: value}) for value in values]
    rows = [branches_of(each) for each in trains]
    for each, row in zip(trains[::4], rows[::4]):
        row += islands_of(each, row, random_ones(each), 0.01)
    order = range(len(values))
    for steps in (order[1:], order[-2::-1]):
        for k in steps:
            rows[k] += islands_of(trains[k], rows[k], stable_ones(rows[k - steps.step]), 0.1)
    return rows


def crossings(locus, value):
    """Lambda at which a curve has a value of its parameter."""
    below, above = locus.parameter[:-1] - value, locus.parameter[1:] - value
    at = np.flatnonzero(below * above <= 0)
    share = np.clip(below[at] / np.where(below[at] == above[at], 1, below[at] - above[at]), 0, 1)
    return locus.frequency[at] + share * (locus.frequency[at + 1] - locus.frequency[at])


def curves_of(parameter, values, rows):
    """Curves of all special points and onsets of the branches at some values of the parameter, each once."""
    start, stop = RANGES[parameter]
    found = []
    for value, branches in zip(values, rows):
        for branch in branches:
            for special in [*branch.special_points, *branch.onsets]:
                # Of the motions of period 2, a myriad, those that bound stable ones.
                beside = branch.stable[max(special.point - 1, 0):special.point + 2]
                if special.kind not in STYLES or (branch.subharmonic == 2 and not beside.any()):
                    continue
                known = (crossings(curve, value) for curve in found
                         if (curve.kind, curve.mesh, curve.period) == (special.kind, special.mesh or 0, branch.subharmonic))
                if any((np.abs(at - special.frequency) < 2e-3).any() for at in known):
                    continue
                try:
                    curve = branch.train.locus(special, parameter=parameter, start=start, stop=stop)
                except gt.SolverError as error:
                    print(f"  {special.kind} at {special.frequency:.4f}, {parameter} = {value:g}: {error}", flush=True)
                    continue
                print(f"  {curve!r}", flush=True)
                found.append(curve)
    return found


def stable_motions(branches, frequency):
    """Numbers of stable motions of period 1 and 2 at each frequency, (2, frequencies)."""
    found = [[], []]
    for branch in branches:
        folds = {special.point for special in branch.special_points if special.kind == "fold"}
        changes = {special.point: special.frequency for special in branch.special_points if special.kind != "fold"}
        for i in range(len(branch) - 1):
            first, second = ends_of_piece = branch.frequency[i:i + 2]
            ends = branch.stable[i:i + 2]
            if branch.segment[i] != branch.segment[i + 1]:
                continue
            if i in folds or i + 1 in folds:
                # A fold is the end of two pieces: the other point tells which this one is.
                ends = ends[[1, 1]] if i in folds else ends[[0, 0]]
            if ends[0] != ends[1]:
                change = changes.get(i, (first + second) / 2)
                first, second = (first, change) if ends[0] else (change, second)
            if not ends.any():
                continue
            inside = np.flatnonzero((min(first, second) <= frequency) & (frequency < max(first, second)))
            share = (frequency[inside] - ends_of_piece[0]) / np.ptp(ends_of_piece)
            for k, part in zip(inside, share * np.sign(ends_of_piece[1] - ends_of_piece[0])):
                rms = branch.rms[i] + part * (branch.rms[i + 1] - branch.rms[i])
                # A branch that closes but is not seen to may pass a motion many times.
                if not any(own == k and np.allclose(other, rms, rtol=3e-3) for own, other in found[branch.subharmonic - 1]):
                    found[branch.subharmonic - 1].append((k, rms))
    return np.array([np.bincount([k for k, _ in own], minlength=len(frequency)) for own in found])


def kind_of(number):
    """Which of NAMES a pair of numbers is."""
    one, two = number
    if two == 0:
        return min(one, 3)
    return 4 if (one, two) == (0, 1) else 5 if (one, two) == (1, 1) else 6


def label_regions(ax, number, frequency, values):
    """Write into each region of some size how many stable motions there are."""
    pairs = number[:, 0] * 100 + number[:, 1]
    for pair in np.unique(pairs):
        regions, count = label(pairs == pair)
        one, two = divmod(pair, 100)
        text = " + ".join([f"{one}"] * bool(one or not two) + [f"{two} of 2"] * bool(two))
        for region in range(1, count + 1):
            inside = regions == region
            if inside.sum() < 0.006 * inside.size:
                continue
            # The place farthest from the region's edge.
            depth = distance_transform_edt(np.pad(inside, 1), sampling=(8, 1))[1:-1, 1:-1]
            row, column = np.unravel_index(depth.argmax(), depth.shape)
            ax.text(frequency[column], values[row], text, fontsize=7, ha="center", va="center")


def draw(parameter, values, rows, path):
    """The regions of stable motions, and over them the curves."""
    start, stop = RANGES[parameter]
    frequency = np.linspace(*LAMBDA, 461)
    number = np.array([stable_motions(branches, frequency) for branches in rows])
    kinds = np.array([[kind_of(pair) for pair in row.T] for row in number])
    _, ax = plt.subplots(figsize=(10, 7), layout="constrained")
    half = (frequency[1] - frequency[0]) / 2, (values[1] - values[0]) / 2
    ax.imshow(kinds, origin="lower", aspect="auto", cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=6.5, interpolation="nearest",
              extent=(LAMBDA[0] - half[0], LAMBDA[1] + half[0], start - half[1], stop + half[1]))
    told, places = set(), []
    for curve in curves_of(parameter, values[8::8], rows[8::8]):
        colour, line = STYLES[curve.kind]
        name = f"{curve.kind}{', period 2' if curve.period == 2 else ''}"
        ax.plot(curve.frequency, curve.parameter, line, color=colour, lw=1.6 if curve.period == 1 else 0.8,
                label=None if name in told else name)
        told.add(name)
        for point in curve.special_points:
            if not point.kind.startswith("grazing"):
                ax.plot(point.frequency, point.parameter, "k.", ms=4)
                place = np.array([(point.frequency - LAMBDA[0]) / np.ptp(LAMBDA), (point.parameter - start) / (stop - start)])
                # Names where there is room; where many meet, the curves tell which it is.
                if curve.period == 1 and all((np.abs(place - other) > (0.1, 0.025)).any() for other in places):
                    at = (point.frequency, point.parameter)
                    ax.annotate(point.kind, at, xytext=(4, 3), textcoords="offset points", fontsize=6)
                    places.append(place)
    label_regions(ax, number, frequency, values)
    for kind in np.unique(kinds):
        ax.fill_between([], [], color=COLOURS[kind], ec="#888888", label=f"stable: {NAMES[kind]}")
    for value in SECTIONS[parameter]:
        ax.axhline(value, color="k", lw=0.6, ls=(0, (6, 4)))
    ax.set(xlim=LAMBDA, ylim=(start, stop), xlabel="Lambda", ylabel=LABELS[parameter])
    if "[um]" in LABELS[parameter]:
        ax.yaxis.set_major_formatter(lambda value, _: f"{1e6 * value:g}")
    ax.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    plt.savefig(path, dpi=130)
    plt.close()
    print(f"Written: {path}", flush=True)


def check(train, parameter, values, rows, places=100):
    """Random starts at places chosen before: whether they settle on the stable motions that the branches have, and on no other.

    A stable motion that none of them settles on is confirmed where time integration stays at it.
    """
    rng = np.random.default_rng(2026)
    drawn = list(zip(rng.uniform(*LAMBDA, places), rng.uniform(*RANGES[parameter], places)))
    counts = {}
    for frequency, value in drawn:
        other = train.with_values({parameter: value})
        branches = branches_of(other)
        branches += islands_of(other, branches, stable_ones(rows[abs(values - value).argmin()]), 0.1)
        expected = stable_motions(branches, np.array([frequency]))[:, 0].tolist()
        # The branches end where the rms of a mesh passes the amplitude limit.
        settled = [motion for motion in other.attractors(frequency, starts=100)
                   if motion.period in (1, 2) and motion.rms.max() < AMPLITUDE_LIMIT]
        starts = [sum(motion.period == period for motion in settled) for period in (1, 2)]
        unknown = [motion.period for motion in settled if not is_known(branches, frequency, motion.rms, 0.01)]
        outcome = "more by random starts" if unknown else "the same"
        if starts != expected and not unknown:
            stay = all(np.allclose(other.integrate(frequency=frequency, start=motion).rms, motion.rms, rtol=0.01)
                       for branch in branches for motion in branch.at(frequency) if motion.stable)
            outcome = "more on branches, confirmed" if stay else "more on branches, not confirmed"
        counts[outcome] = counts.get(outcome, 0) + 1
        if outcome != "the same":
            print(f"  Lambda {frequency:.4f}, {parameter} {value:.4g}: stable of periods 1 and 2 {expected}, by random starts "
                  f"{starts}: {outcome}", flush=True)
    print(f"{parameter}, {places} places: {counts}", flush=True)


if __name__ == "__main__":
    gt.plot_style()
    folder = Path(next((argument for argument in sys.argv[1:] if not argument.startswith("-")), ROOT / "docs"))
    folder.mkdir(parents=True, exist_ok=True)
    paper = gt.read_case(ROOT / "namelists" / "fig03.nml").train
    for name in RANGES:
        numbers = np.linspace(*RANGES[name], ROWS)
        found = rows_of(paper, name, numbers)
        draw(name, numbers, found, folder / f"atlas_{name.split()[-1]}.png")
        if "--check" in sys.argv:
            check(paper, name, numbers, found)
