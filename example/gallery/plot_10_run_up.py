"""
A run-up
========

The reducer of the drawing runs up from 200 to 4000 rpm in two seconds. The pictures show the mesh forces over the speed, and the
spectra of the force of mesh 1. The rising lines are orders of the meshes. Near 1700 and 3100 rpm the teeth hammer, and the spectrum
is broad.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

plt.rcParams.update(gt.plot_style())
train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "reducer.nml").train
run_up = train.run_up(start=200, stop=4000, unit="rpm", duration=2.0)
below = run_up.mesh_force_minimum[:, 0] <= 0
apart = run_up.speed[run_up.time.searchsorted(run_up.window_time[below])]
assert all(((apart > near - 150) & (apart < near + 250)).any() for near in (1700, 3100)) and apart.min() > 1500
figure, axes = plt.subplots(2, layout="constrained", figsize=(7, 7))
run_up.plot(ax=axes[0])
run_up.waterfall(number=1, ax=axes[1], highest=5000)
axes[0].set_xlabel("")
plt.show()
