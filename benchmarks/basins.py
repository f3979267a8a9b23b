"""Basins against time integration, start by start: ``python benchmarks/basins.py [STARTS]`` from the root, in ten minutes.

Prints a row for each train and speed: the motions, the time of a map of 200 x 200 starts, how many of a random sample of them (200
unless told) `Train.integrate` settles on another motion than the map tells, and in how many of these the map is wrong: the flow
itself, over 400 periods of the fundamental and without a judgement where it goes, is not at the motion told.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import geartrain as gt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "example" / "paper"))

from paper_cases import paper_case

__all__ = ["main"]

CASES = (("fig03", 0.7, 2), ("fig03", 0.6, 1), ("fig04_k3_5e5", 1.75, 2), ("fig07_042", 0.7, 1), ("single_pair", 0.8, 1))


def reaches(train: gt.Train, frequency: float, start: np.ndarray, told: gt.Motion) -> bool:
    """Whether the flow is at a motion in the last 16 of 400 periods."""
    begin = replace(train.integrate(frequency, start=start, max_periods=1), state=start, period=0)
    last = begin.trajectory(400, samples=64).displacement[-16 * 64:]
    return np.allclose(last.mean(axis=0), told.mean, rtol=1e-3) and np.allclose(np.sqrt(2) * last.std(axis=0), told.rms, rtol=1e-3)


def main() -> None:
    """Print the rows."""
    sample = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    print("train          Lambda  motions  undecided  time of the map [s]  elsewhere by integrate  by the flow")
    for name, frequency, mesh in CASES:
        train = paper_case(name).train
        began = time.perf_counter()
        basins = train.basins(frequency, mesh=mesh)
        spent = time.perf_counter() - began
        moments = np.random.default_rng(1)
        elsewhere = wrong = 0
        for row, column in zip(moments.integers(200, size=sample), moments.integers(200, size=sample)):
            start = basins.start(basins.displacement[column], basins.velocity[row])
            settled = train.integrate(frequency, start=start)
            number = basins.label[row, column]
            told = basins.motions[number - 1] if number > 0 else None
            same = told is not None and settled.period == told.period and np.allclose(settled.rms, told.rms, rtol=1e-6)
            if told is None or told.period == 0:  # no period: the integration must not find one either
                same = settled.period == 0
            elsewhere += not same
            wrong += not same and (told is None or not reaches(train, frequency, start, told))
        row = f"{name:14} {frequency:6.2f} {len(basins.motions):8} {basins.unsettled:10.1%} {spent:20.1f}"
        print(f"{row} {elsewhere:23} {wrong:12}", flush=True)


if __name__ == "__main__":
    main()
