"""
Two stages
==========

This is the train of Al-shyyab and Kahraman (2007): two gear pairs joined by a shaft. A chain lists its shafts and meshes from motor
to load, without names. Harmonic balance follows the response through its folds. Time integration (black) is an independent check:
it stays on the stable (solid) parts and jumps where they end, at other speeds when the speed rises than when it falls.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

case = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "fig03.nml")
branch = case.train.response(start=0.4, stop=1.2, harmonics=12)
ax = branch.plot(mesh=2, jumps=True)
sweep = case.train.sweep(start=0.41, stop=1.19, points=79, direction="both")
sweep.plot(mesh=2, ax=ax, color="black", markersize=3, label="_nolegend_")

# Motions of the period of the fundamental from integration lie on the branch.
periodic = [motion for motion in sweep if motion.period == 1]
off = [min(abs(motion.rms - known.rms).max() for known in branch.at(motion.frequency)) for motion in periodic]
assert len(periodic) > 150 and max(off) < 5e-3
plt.show()
