"""
A stability map
===============

Without backlash the train is linear. Its varying mesh stiffness can still make vibration grow without bound (parametric
resonance), as on a swing that is pumped at twice its frequency. Wide unstable regions stand at twice the natural frequencies
(dotted), a thin one at the first natural frequency. Damping lifts the tips of these regions off the axis.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

plt.rcParams.update(gt.plot_style())
train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "fig03.nml").train
chart = train.stability_map(
    start=0.5, stop=4.5, points=120, linear=True,
    parameter="stiffness_variation", parameter_start=0.0, parameter_stop=0.5, parameter_points=40,
)
ax = chart.plot()
for frequency in train.natural_frequencies()[:2]:
    ax.axvline(2 * frequency, color="black", linestyle=":")
    assert chart.spectral_radius[-1, abs(chart.frequency - 2 * frequency).argmin()] > 1
assert (chart.spectral_radius[0] < 1).all()
plt.show()
