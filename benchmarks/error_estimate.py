"""True error over estimated error on the paper's figures: every point sampled is compared with shooting at the same Lambda.

Run after scripts/setup:  .venv/bin/python benchmarks/error_estimate.py [CASE ...]     (names of namelists/, default: all)
The exact motions at the Lambda of a point are those of a branch traced to 1e-6, each polished by shooting to about 1e-11; the true
error is the distance to the nearest one. Where there is none (the exact branch turns before that Lambda) it counts as infinite.
"""

import dataclasses
import sys
from pathlib import Path

import numpy as np

import geartrain as gt

HARMONICS = [6, 12, 24]
POINTS = 100
FLOOR = 1e-11  # what shooting leaves


def distance(a, b):
    """Relative error of the waveform a, coefficients (meshes, 1 + 2 R), against b."""
    terms = max(a.shape[1], b.shape[1])
    a, b = (np.pad(x, ((0, 0), (0, terms - x.shape[1]))) for x in (a, b))
    difference = a - b
    return np.sqrt((2 * difference[:, 0] ** 2).sum() + (difference[:, 1:] ** 2).sum()) / np.linalg.norm(b[:, 1:])


def exact_motions(reference, frequency):
    """Every motion of the reference at exactly this Lambda, by shooting; one that fails is left out."""
    motions = []
    for motion in reference.at(frequency):
        padding = max(0, 1 + 2 * 128 - motion.coefficients.shape[1])
        padded = np.pad(motion.coefficients, ((0, 0), (0, padding)))
        try:
            motions.append(dataclasses.replace(motion, coefficients=padded).refine())
        except gt.SolverError:
            pass
    return motions


def ratios(branch, reference):
    """Lambda, estimate, true error and doubt of points spread evenly along the branch, (points, 4)."""
    rows = []
    for i in np.unique(np.linspace(0, len(branch) - 1, POINTS).astype(int)):
        exact = exact_motions(reference, branch.frequency[i])
        true = min((distance(branch.coefficients[i], motion.coefficients) for motion in exact), default=np.inf)
        rows.append((branch.frequency[i], branch.error_estimate[i], true, branch.estimate_doubtful[i]))
    return np.array(rows)


def main():
    folder = Path(__file__).parent.parent / "namelists"
    names = sys.argv[1:] or [path.stem for path in sorted(folder.glob("*.nml"))]
    print("case                   R points doubtful median within 3  not doubtful within 3, 6")
    everything = []
    for name in names:
        case = gt.read_case(folder / f"{name}.nml")
        if case.response is None or case.response.get("subharmonic", 1) > 1:
            continue
        settings = {**case.response, "stability": False, "period_doublings": 0}
        limit = settings["amplitude_limit"]  # a branch may pass it where the reference is still below
        further = {"harmonics": 0, "tolerance": 1e-6, "amplitude_limit": 1.5 * limit if limit > 0 else 18.0}
        reference = case.train.response(**{**settings, **further})
        for harmonics in HARMONICS:
            rows = ratios(case.train.response(**{**settings, "harmonics": harmonics}), reference)
            everything.append(rows)
            report(name, harmonics, rows)
    report("all", "", np.concatenate(everything))


def report(name, harmonics, rows):
    """One line of the table."""
    ratio = (rows[:, 2] + FLOOR) / (rows[:, 1] + FLOOR)
    sure = rows[:, 3] == 0
    within = [(ratio < factor) & (ratio > 1 / factor) for factor in (3, 6)]
    print(
        f"{name:20s} {harmonics!s:>3s} {len(rows):6d} {1 - sure.mean():8.1%} {np.median(ratio):6.2f} {within[0].mean():8.1%}"
        f"{within[0][sure].mean():16.1%} {within[1][sure].mean():8.1%}",
        flush=True,
    )


if __name__ == "__main__":
    main()
