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
cases = Path(sys.argv[0]).resolve().parents[2] / "namelists"
train = gt.read_case(cases / "fig03.nml").train
chart = train.stability_map(
    start=0.5, stop=4.5, points=120, linear=True,
    parameter="stiffness_variation", parameter_start=0.0, parameter_stop=0.5, parameter_points=40,
)
ax = chart.plot()
for frequency in train.natural_frequencies()[:2]:
    ax.axvline(2 * frequency, color="black", linestyle=":")
    assert chart.spectral_radius[-1, abs(chart.frequency - 2 * frequency).argmin()] > 1
assert (chart.spectral_radius[0] < 1).all()

# %%
# With backlash, and over any number of the train: the reducer of the gallery over the torque of its motor. Where there is no stable
# motion of the period of the fundamental, its teeth do something else. Trains with teeth need ``harmonics=0``.

reducer = gt.read_case(cases / "reducer.nml").train
chart = reducer.stability_map(
    start=1450, stop=1500, unit="rpm", points=11, harmonics=0, tolerance=1e-2,
    parameter="motor torque", parameter_start=10.0, parameter_stop=90.0, parameter_points=4,
)
chart.plot("stable_motions")
print(chart)
plt.show()
