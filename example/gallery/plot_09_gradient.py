"""
A gradient
==========

``gradient`` gives the derivatives of a result with respect to all parameters of the train, in less time than one more motion takes.
The picture shows by how many per cent the largest force of each mesh changes when a parameter grows by one per cent.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import geartrain as gt

plt.rcParams.update(gt.plot_style())
train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "fig03.nml").train
motion = train.response(start=0.2, stop=2.6, harmonics=12).at(1.3)[0]
values = {"input_torque": 150.0, "shaft 2 stiffness": 1e8, "mesh 1 stiffness": 2.5e8, "mesh 2 stiffness": 5e8,
          "mesh 1 damping_ratio": 0.05, "mesh 2 damping_ratio": 0.05, "mesh 1 half_backlash": 30e-6, "mesh 2 half_backlash": 30e-6}
slope = motion.gradient("mesh_force_maximum", list(values))
per_cent = slope * np.array(list(values.values())) / motion.mesh_force_maximum[:, np.newaxis]

figure, ax = plt.subplots(layout="constrained")
for mesh, hatch in enumerate(("", "///")):
    place = np.arange(len(values)) + 0.4 * mesh - 0.2
    ax.barh(place, per_cent[mesh], 0.4, hatch=hatch, edgecolor="white", label=f"mesh {mesh + 1}")
ax.set_yticks(range(len(values)), values)
ax.invert_yaxis()
ax.set_xlabel("change of the largest mesh force  [%] by 1 % of the parameter")
ax.legend()

# %%
# The teeth stay in contact here, so the backlash has no effect. The difference of two trains confirms a derivative.

assert np.allclose(per_cent[:, -2:], 0)
stiffer = train.with_values({"mesh 1 stiffness": 2.5e8 * 1.0001}).response(start=0.2, stop=2.6, harmonics=12).at(1.3)[0]
difference = 1e4 * (stiffer.mesh_force_maximum / motion.mesh_force_maximum - 1)
assert np.allclose(per_cent[:, 2], difference, rtol=1e-2, atol=1e-4)
plt.show()
