"""True error over estimated error on the paper's figures: every point sampled is compared with shooting at the same Lambda.

Where the branch turns before that Lambda, so that no exact motion of its kind is there, the true error is the distance to the
motion of the exact fold. The table tells how many points these are, and what comes of the distance to whatever motion there is at
that Lambda.

Run after scripts/setup:  .venv/bin/python benchmarks/error_estimate.py [CASE ...]     (names of namelists/, default: all)
The exact motions at the Lambda of a point are those of a branch traced to 1e-6, each polished by shooting to about 1e-11; the true
error is the distance to the nearest one, or to a fold that the point lies beyond, if that is nearer.
"""

import dataclasses
import sys
from pathlib import Path

import numpy as np

import geartrain as gt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "example" / "paper"))

from paper_cases import case_texts, paper_case

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


def folds(reference):
    """Lambda of each fold, the side on which its branches are (+1 above, -1 below), coefficients."""
    turns = [special.frequency for special in reference.special_points if special.kind == "fold"]
    places = [np.argmin(abs(reference.frequency - frequency)) for frequency in turns]
    return [
        (
            reference.frequency[i],
            np.sign(reference.frequency[i - 1] + reference.frequency[i + 1] - 2 * reference.frequency[i]),
            reference.coefficients[i],
        )
        for i in places
    ]


def ratios(branch, reference):
    """Estimate, true error, doubt and distance to the motions at the same Lambda of points spread evenly along it, (points, 4)."""
    turns = folds(reference)
    rows = []
    for i in np.unique(np.linspace(0, len(branch) - 1, POINTS).astype(int)):
        frequency, coefficients = branch.frequency[i], branch.coefficients[i]
        motions = [motion.coefficients for motion in exact_motions(reference, frequency)]
        same = min((distance(coefficients, motion) for motion in motions), default=np.inf)
        beyond = [motion for fold, side, motion in turns if side * (frequency - fold) < 0]
        true = min((distance(coefficients, motion) for motion in beyond), default=np.inf)
        rows.append((branch.error_estimate[i], min(true, same), branch.estimate_doubtful[i], same))
    return np.array(rows)


def main():
    folder = Path(__file__).parent.parent / "namelists"
    names = sys.argv[1:] or sorted({path.stem for path in folder.glob("*.nml")} | case_texts().keys())
    print("case                   R points doubtful median within 3  not doubtful within 3, 6  beyond fold  same Lambda within 3")
    everything = []
    for name in names:
        case = paper_case(name)
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
    sure = rows[:, 2] == 0
    ratio = (rows[:, [1, 3]] + FLOOR) / (rows[:, :1] + FLOOR)
    within = [(ratio < factor) & (ratio > 1 / factor) for factor in (3, 6)]
    beyond = (rows[:, 1] < rows[:, 3]).mean()
    print(
        f"{name:20s} {harmonics!s:>3s} {len(rows):6d} {1 - sure.mean():8.1%} {np.median(ratio[:, 0]):6.2f} "
        f"{within[0][:, 0].mean():8.1%}{within[0][sure, 0].mean():16.1%} {within[1][sure, 0].mean():8.1%} "
        f"{beyond:11.1%} {within[0][:, 1].mean():8.1%}",
        flush=True,
    )


if __name__ == "__main__":
    main()
