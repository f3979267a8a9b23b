"""
Bearings
========

A bearing lets the axis of a body move in the transverse plane, as far as its springs and its clearance allow. The forces of the
bearings are what a housing hears.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "bearings.nml").train
print(train.modes())

# %%
# Minimum, mean and maximum of the force of the pinion's bearings in the direction y, in which most of the tooth force acts.

branch = train.response(start=6000, stop=1500, unit="rpm", harmonics=8, stability=False)
figure, (over_speed, plane) = plt.subplots(1, 2, figsize=(9.0, 4.0))
for words in ("minimum", "mean", "maximum"):
    over_speed.plot(branch.speed, getattr(branch, f"bearing_force_{words}")[:, 0, 1], label=words)
over_speed.set(xlabel="speed [rpm]", ylabel="force of the pinion's bearings, y [N]")
over_speed.legend()
worst = abs(branch.bearing_force_minimum[:, 0, 1]).argmax()
print(f"largest force {abs(branch.bearing_force_minimum[worst, 0, 1]):.0f} N at {branch.speed[worst]:.0f} rpm")

# %%
# The tooth force presses the axis of the pinion against its clearance of 5 um, the square, and into the springs behind it. At the
# resonance it moves back towards the clearance in every mesh cycle.

for speed in (3216, 5000):
    motion = train.integrate(frequency=speed)
    plane.plot(motion.displacement[:, 1], motion.displacement[:, 2], label=f"{speed} rpm")
plane.plot([-5, 5, 5, -5, -5], [-5, -5, 5, 5, -5], "k:", label="clearance")
plane.set(xlabel="x of the pinion [um]", ylabel="y of the pinion [um]", aspect="equal")
plane.legend()
figure.tight_layout()
