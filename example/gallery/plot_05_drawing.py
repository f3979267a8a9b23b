"""
From the drawing
================

Teeth, modules, face widths, backlash and diameters are enough: radii, stiffnesses (ISO 6336-1), orders and inertias follow, and
``explain`` tells each with its formula. Speeds are then in rpm.
"""

import geartrain as gt

train = gt.read_case("../../namelists/reducer.nml").train
train.plot(speed=3000)

# %%
# What the mesh of the first stage became:

mesh = train.explain()["mesh 1"]
print(f"contact ratio {mesh['contact_ratio']:.3f}, overlap ratio {mesh['overlap_ratio']:.3f}")
print(f"stiffness {mesh['stiffness'] / 1e6:.0f} N/um, half backlash {mesh['half_backlash'] * 1e6:.1f} um")

# %%
# Where an order of a mesh meets a natural frequency, the train may resonate: the Campbell diagram.

ax = train.campbell(start=200, stop=4000).plot(highest=1500)
