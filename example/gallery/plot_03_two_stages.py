"""
Two stages
==========

The train of Al-shyyab and Kahraman (2007): two pairs, joined by a shaft. Shafts and meshes of a chain stand in their order, without
names. The response is followed through its folds by harmonic balance; time integration, which knows nothing of branches, stays on
the solid parts and jumps where they end, elsewhere with rising than with falling speed.
"""

import geartrain as gt

case = gt.read_case("../../namelists/fig03.nml")
branch = case.train.response(start=0.4, stop=1.2, harmonics=12)
ax = branch.plot(mesh=2, jumps=True)
sweep = case.train.sweep(start=0.41, stop=1.19, points=79, direction="both")
sweep.plot(mesh=2, ax=ax, color="black", markersize=3, label="_nolegend_")

# Where integration found a period of the fundamental it stands on the branch.
periodic = [motion for motion in sweep if motion.period == 1]
off = [min(abs(motion.rms - known.rms).max() for known in branch.at(motion.frequency)) for motion in periodic]
assert len(periodic) > 150 and max(off) < 5e-3
