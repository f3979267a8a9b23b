"""
Sub-harmonics
=============

Between 1.75 and 2.04 the train of two stages has no stable motion with the period of the mesh cycle. A multiplier passes -1, and a
motion of twice the period takes over. ``period_doublings`` follows the branches that begin there (thin lines).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

plt.rcParams.update(gt.plot_style())
train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "fig03.nml").train
branch = train.response(start=1.2, stop=2.6, harmonics=8, period_doublings=1)
((low, high),) = branch.bands_without_stability
assert abs(low - 1.75) < 0.01 and abs(high - 2.04) < 0.01
ax = branch.plot(mesh=1)
ax.set_ylim(0, 1.5)

# %%
# At 1.92 time integration settles on the motion of twice the period. Shooting from the point of the branch gives the same motion.

motion = train.integrate(frequency=1.92)
refined = next(found for doubled in branch.branches for found in doubled.at(1.92) if found.stable).refine()
assert motion.period == refined.period == 2
assert abs(motion.rms - refined.rms).max() < 1e-8

axes = motion.plot()
plt.show()
