"""
Damping
=======

Damping ratios of shafts and meshes refer to the inertias at their own ends; the lowest modes, which move larger inertias, may get
hardly any. A train can be given the damping of its modes instead, as a modal test measures it, or loss factors of its parts.
"""

import sys
from dataclasses import replace
from pathlib import Path

import geartrain as gt

train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "reducer.nml").train
print(train.modes())

# %%
# 2 % of critical damping for every mode: shafts and meshes without damping of their own get the coefficients that give it.

bare = {
    "shafts": [replace(shaft, damping_ratio=None) for shaft in train.shafts],
    "meshes": [replace(mesh, damping_ratio=None) for mesh in train.meshes],
}
tested = replace(train, **bare, modal_damping=[0.02])
print(tested.modes())
print(tested.explain()["shaft 3"])
assert abs(tested.modes().damping_ratio / 0.02 - 1).max() < 0.01

# %%
# Loss factors: each is that of a damper at the frequency of the mode in which the shaft or mesh has most strain energy.

lossy = replace(
    train,
    shafts=[replace(shaft, loss_factor=0.02) for shaft in bare["shafts"]],
    meshes=[replace(mesh, loss_factor=0.06) for mesh in bare["meshes"]],
)
print(lossy.modes())

# %%
# The resonance of the first mode follows its damping.

for words, one in (("as given", train), ("2 % of every mode", tested), ("loss factors", lossy)):
    branch = one.response(start=1450, stop=1550, unit="rpm", harmonics=0, tolerance=1e-2, stability=False)
    print(f"{words}: largest force of mesh 1 over its mean {branch.dynamic_factor[:, 0].max():.3f}")
