"""The curve of a fold over Lambda and the stiffness variation, 0.05 to 0.5, by `Train.locus` and by AUTO-07p, on one core:
``python benchmarks/locus.py`` from the root, in five minutes. Times are of the processor, which other work on the machine hardly
changes.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import geartrain as gt
from timing import one_core, spread

sys.path.append(str(Path(__file__).parent / "peers"))
import auto_locus

# Name, case, the stretch of Lambda with both folds at any stiffness variation, and the equations for AUTO: their file, number and
# the least Lambda of the curve from which it takes the fold.
TRAINS = (
    ("figure 3", "fig03", (1.1, 2.2), ("auto_train", 12, 1.5)), ("one pair", "single_pair", (0.45, 1.3), ("auto_pair", 4, 0.7)),
)
# Widths over which AUTO's corners are rounded, and its intervals.
AUTO_RUNS = ((0.01, 100), (0.001, 200), (0.0, 100))
JUDGED = 12


def errors(train, stretch, points):
    """Distance in Lambda of some of the points from the nearest exact fold of the train with their stiffness variation, told
    where the curve is within 0.01 of its cusp apart: there Lambda of a fold hardly tells the error."""
    cusp = points[:, 1].min()
    fair = points[points[:, 1] > cusp + 0.01]
    found = []
    for frequency, value in fair[np.linspace(0, len(fair) - 1, JUDGED).astype(int)]:
        branch = train.with_values({"stiffness_variation": float(value)}).response(start=stretch[0], stop=stretch[1], harmonics=12)
        folds = [special.exact().frequency for special in branch.special_points if special.kind == "fold"]
        found.append(min(abs(np.array(folds) - frequency)))
    return np.array(found)


def measure(quick, _executable, say):
    """A row for each train and tool: points, processor seconds of each repeat, median and largest error."""
    rows = []
    for name, case, stretch, equations in TRAINS:
        train = gt.read_case(f"namelists/{case}.nml").train
        branch = train.response(start=stretch[0], stop=stretch[1], harmonics=12)
        fold = next(special for special in branch.special_points if special.kind == "fold").exact()
        seconds = []
        say(f"{name}, geartrain")
        for _ in range(3 if quick else 9):
            begun = time.process_time()
            locus = train.locus(fold, parameter="stiffness_variation", start=0.05, stop=0.5)
            seconds.append(time.process_time() - begun)
        points = np.column_stack([locus.frequency, locus.parameter])
        rows.append({"train": name, "tool": "geartrain", "seconds": seconds, "points": len(locus), "whole": locus.complete,
                     "errors": errors(train, stretch, points)})
        for width, intervals in AUTO_RUNS:
            label = f"AUTO-07p, {intervals} intervals, " + (f"corners rounded over {width:g}" if width else "exact backlash")
            say(f"{name}, {label}")
            try:
                runs = [auto_locus.locus(*equations, width, intervals) for _ in range(1 if quick or width < 0.01 else 3)]
            except (OSError, subprocess.CalledProcessError) as error:
                rows.append({"train": name, "tool": label, "failed": str(error)})
                continue
            _, points, whole = runs[-1]
            found = errors(train, stretch, points) if len(points) > JUDGED else None
            rows.append({"train": name, "tool": label, "seconds": [run[0] for run in runs], "points": len(points), "whole": whole,
                         "errors": found})
    return {"rows": rows}


def main():
    """Print the table."""
    with one_core():
        found = measure("--quick" in sys.argv, None, lambda text: print(text, file=sys.stderr, flush=True))
    print("| train | tool | points | whole curve | processor time | a point | error in Lambda, median | largest |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for row in found["rows"]:
        if "failed" in row:
            print(f"| {row['train']} | {row['tool']} | {row['failed']} | | | | | |")
            continue
        told = ("", "") if row["errors"] is None else (f"{np.median(row['errors']):.0e}", f"{max(row['errors']):.0e}")
        whole = "yes" if row["whole"] else "no"
        print(f"| {row['train']} | {row['tool']} | {row['points']} | {whole} | {spread(row['seconds'])} | "
              f"{spread([np.median(row['seconds']) / row['points']])} | {told[0]} | {told[1]} |")


if __name__ == "__main__":
    main()
