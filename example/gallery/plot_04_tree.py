"""
A tree with a loop
==================

Bodies have names, and shafts and meshes join them in any order. Here one pinion drives two wheels, both wheels drive one gear, and
a pump takes 3 of the 150 N m. The lightly loaded mesh of the pump rattles where the loaded meshes stay in contact.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

plt.rcParams.update(gt.plot_style())
train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "branched.nml").train
train.plot()

# %%
# Each strip is a range of speeds in which the teeth of a mesh separate in a stable motion.

branch = train.response(start=0.3, stop=2.6, harmonics=12)
figure, ax = plt.subplots(figsize=(7, 3), layout="constrained")
for mesh, name in enumerate(train.mesh_labels, 1):
    for low, high in branch.separation_ranges(mesh, stable=True):
        ax.barh(mesh, high - low, left=low, color="C0" if "pump" not in name else "C3")
wide = [sum(high - low for low, high in branch.separation_ranges(mesh, stable=True)) for mesh in range(1, 6)]
assert wide[4] > 3 * sum(wide[:4])
ax.set_yticks(range(1, 6), train.mesh_labels)
ax.invert_yaxis()
ax.set_xlim(0.3, 2.6)
ax.set_xlabel(r"fundamental frequency  $\Lambda$")
plt.show()
