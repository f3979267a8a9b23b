"""What a damping ratio refers to, and what is said of a train whose numbers are those of another unit."""

import pytest
from conftest import single_pair

import geartrain as gt


def train(flange):
    """A motor on a shaft, of which half is a flange that another shaft, stiff or rigid, carries."""
    bodies = [gt.Body(name="flange", inertia=0.0015, torque=100.0), gt.Body(name="motor", inertia=0.0015),
              gt.Body(name="pinion", inertia=0.002), gt.Body(name="wheel", inertia=0.02, balances=True)]
    shafts = [gt.Shaft(between=("flange", "motor"), **flange),
              gt.Shaft(between=("motor", "pinion"), stiffness=2e4, damping_ratio=0.05)]
    mesh = gt.Mesh(between=("pinion", "wheel"), driving_radius=0.04, driven_radius=0.08, stiffness=2e8, damping_ratio=0.05,
                   half_backlash=30e-6, stiffness_cos=[0.2])
    return gt.Train(bodies=bodies, shafts=shafts, meshes=[mesh], characteristic_length=30e-6, characteristic_frequency=1e4)


def test_a_rigid_shaft_is_the_limit_of_a_stiff_one():
    """The damping of the shaft beside it does not jump: rms as the compliance of the stiff one has it."""
    with pytest.warns(gt.DrawingWarning, match="shaft 2: damping_ratio = 0.05 of the bodies alone"):
        rigid = train({"rigid": True})
    frequency = 0.27  # next to the resonance of the shaft between motor and pinion, which its damping bounds
    known = rigid.response(start=0.2, stop=0.5, harmonics=6).at(frequency)[0].rms
    off = []
    for stiffness in (1e8, 1e9):
        motion = train({"stiffness": stiffness, "damping_ratio": 0.05}).response(start=0.2, stop=0.5, harmonics=6).at(frequency)[0]
        off.append(abs(motion.rms - known).max() / known.max())
    assert off[1] < 0.2 * off[0] and off[1] < 1e-3


def test_a_stiffness_that_becomes_negative_is_warned_of():
    with pytest.warns(gt.DrawingWarning, match=r"mesh 1: the mesh stiffness falls to -0\.5 times its mean"):
        single_pair(0.4, stiffness_cos=[1.5])
