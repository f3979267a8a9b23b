"""
One pair
========

Two gears are the smallest train. The mesh is stiffer while two tooth pairs touch than while one pair does, and this varying
stiffness excites vibration. The mesh has backlash, so the teeth lose contact where the vibration is large.
"""

import matplotlib.pyplot as plt

import geartrain as gt

train = gt.Train(
    title="one pair",
    characteristic_length=30e-6,  # m, unit of displacements
    characteristic_frequency=9870.0,  # rad/s: Lambda is the mesh frequency over this value
    bodies=[
        gt.Body(name="pinion", inertia=0.0023, torque=150.0),  # kg m^2, N m
        gt.Body(name="wheel", inertia=0.037, balances=True),  # its torque balances the other torques
    ],
    meshes=[gt.Mesh(
        between=("pinion", "wheel"), driving_radius=0.05, driven_radius=0.10,  # m, of the base circles
        stiffness=2.5e8, damping_ratio=0.05, half_backlash=30e-6,  # N/m, 1, m
        stiffness_cos=[0.3],  # kappa(t) = 1 + 0.3 cos(mesh frequency t)
    )],
)
branch = train.response(start=0.2, stop=2.6, harmonics=12)
ax = branch.plot(jumps=True, ranges=True)
print(branch.jumps)
plt.show()
