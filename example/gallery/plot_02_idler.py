"""
An idler
========

An idler has two meshes, and each mesh excites it once per tooth. The two excitations add up or cancel, depending on their phase.
``phase`` is the lag of the second mesh in the mesh cycle; it follows from the angle between the three centres. In opposite phase
the meshes hardly excite the resonance near 1.2, and excite another resonance near 2.4.
"""

import matplotlib.pyplot as plt

import geartrain as gt

plt.rcParams.update(gt.plot_style())


def train(phase):
    """Give the train whose second mesh lags by a phase [rad of the mesh cycle]."""
    pair = {"stiffness": 2.5e8, "damping_ratio": 0.08, "half_backlash": 30e-6, "stiffness_cos": [0.2]}
    return gt.Train(
        characteristic_length=30e-6, characteristic_frequency=9870.0,
        bodies=[
            gt.Body(name="pinion", inertia=0.0023, torque=150.0),
            gt.Body(name="idler", inertia=0.0046),
            gt.Body(name="wheel", inertia=0.037, balances=True),
        ],
        meshes=[
            gt.Mesh(between=("pinion", "idler"), driving_radius=0.05, driven_radius=0.06, **pair),
            gt.Mesh(between=("idler", "wheel"), driving_radius=0.06, driven_radius=0.10, phase=phase, **pair),
        ],
    )


figure, axes = plt.subplots(2, sharex=True, sharey=True, layout="constrained")
for ax, phase, words in zip(axes, (0.0, 3.14159), ("in phase", "in opposite phase")):
    branch = train(phase).response(start=0.2, stop=2.6, harmonics=12)
    branch.plot(ax=ax, quantity="dynamic_factor")
    ax.set_title(f"meshes {words}: at most {branch.dynamic_factor.max():.2f} times the mean force", fontsize=10)
    near = (branch.frequency > 1.0) & (branch.frequency < 1.4)
    assert (branch.dynamic_factor[near].max() > 2.5) == (phase == 0)
axes[0].set_xlabel("")
plt.show()
