"""
From the drawing
================

Teeth, modules, face widths, backlash and diameters are enough input. Radii, stiffnesses (ISO 6336-1), orders and inertias follow
from them, and ``explain`` lists each with its formula. The speed is in rpm.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "reducer.nml").train
train.plot(speed=3000)

# %%
# Values derived for the mesh of the first stage:

mesh = train.explain()["mesh 1"]
print(f"contact ratio {mesh['contact_ratio']:.3f}, overlap ratio {mesh['overlap_ratio']:.3f}")
print(f"stiffness {mesh['stiffness'] / 1e6:.0f} N/um, half backlash {mesh['half_backlash'] * 1e6:.1f} um")

# %%
# The train may resonate where an order of a mesh meets a natural frequency. The Campbell diagram shows these speeds.

ax = train.campbell(start=200, stop=4000).plot(highest=1500)
plt.show()
