"""Time of a short call against the number of shafts and against the number of harmonics, with multipliers and without; memory."""

import tempfile
from pathlib import Path

import geartrain as gt
from cases import tree
from paper_cases import chain
from timing import peak_memory, timed

RANGE = {"start": 0.84, "stop": 0.83}  # teeth part at the first meshes of the chain, and at both meshes of figure 3
POINTS = 6
SHAPES = ("chain", "comb", "binary tree", "random tree")


def sizes(train_of, counts, settings_of, patience, say):
    """Seconds of a call for each size, with multipliers and without, and its points; sizes are left out once one took too long.

    The branch begins at a motion known beforehand: finding the first one takes no part of the time. Its range is the same whatever
    the number of points by which a commit draws it.
    """
    rows, late = [], {}
    for count in counts:
        row, train, settings = {"size": count}, train_of(count), {**RANGE, **settings_of(count)}
        seed = train.response(**settings, stability=False, max_points=2).at(settings["start"])[0]
        settings.update(seed=seed, max_points=POINTS)
        for stability in (False, True):
            if late.get(stability):
                continue
            say(f"{count}, {'with' if stability else 'without'} multipliers")
            seconds, branch = timed(lambda: train.response(**settings, stability=stability), 5, patience)  # noqa: B023
            row["with" if stability else "without"], row["points"] = seconds, len(branch)
            late[stability] = min(seconds) > patience
        rows.append(row)
    return rows


def memory(executable, counts):
    """Peak resident memory [bytes] of the executable for each number of shafts, no multipliers."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        case, output = Path(name) / "case.nml", Path(name) / "case.h5"
        for count in counts:
            settings = {**RANGE, "max_points": POINTS, "stability": False, "harmonics": 6}
            case.write_text(chain(count).namelist(response=settings), encoding="utf-8")
            rows.append({"size": count, "memory": [peak_memory([executable, case, "--output", output])]})
    return rows


def measure(quick, executable, say):
    """Rows by number of shafts, by number of harmonics, and of trees by number of meshes."""
    shafts = (3, 10, 30) if quick else (3, 6, 10, 20, 30, 60, 100, 200, 300)
    harmonics = (4, 16, 64) if quick else (4, 8, 16, 32, 64, 128, 256)
    patience = 2 if quick else 10
    figure3 = gt.read_case("namelists/fig03.nml").train
    by_shafts = sizes(chain, shafts, lambda _: {"harmonics": 6}, patience, lambda text: say(f"shafts: {text}"))
    # Where every tree has a motion from rest; contact is never lost.
    above = {"start": 1.2, "stop": 1.19, "harmonics": 6}
    meshes = (10, 30) if quick else (10, 30, 100, 300)
    trees = {
        shape: sizes(
            lambda count: tree(shape, count), meshes, lambda _: above, patience, lambda text: say(f"{shape}: {text}"))  # noqa: B023
        for shape in SHAPES
    }  # fmt: skip
    by_harmonics = sizes(
        lambda _: figure3, harmonics, lambda count: {"harmonics": count}, patience, lambda text: say(f"harmonics: {text}"))
    return {"shafts": by_shafts, "harmonics": by_harmonics, "trees": trees, "memory": memory(executable, shafts)}
