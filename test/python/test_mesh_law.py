"""Laws of a mesh of its own, from Python: damping in contact only, back flanks; figures of the library's validations."""

import numpy as np
import pytest
from conftest import single_pair

import geartrain as gt


def test_damping_in_contact_only():
    motion = single_pair(0.4, stiffness_cos=[0.3], damping_acts="contact").integrate(1.0)
    assert motion.mean[0] == pytest.approx(1.282976703, abs=1e-9)
    assert motion.rms[0] / np.sqrt(2) == pytest.approx(0.403882668, abs=1e-9)
    # Nothing bears a force while the teeth are apart, where those of the ordinary mesh drag.
    _, displacement, force, *_ = motion._sample(500)
    apart = abs(displacement[:, 0]) < 1
    assert apart.any()
    assert abs(force[apart, 0]).max() == 0


def test_the_largest_force_is_told_on_both_sides_of_an_impact():
    train = single_pair(0.4, damping_ratio=0.2, stiffness_cos=[0.6], damping_acts="contact")
    motions = train.response(start=0.9, stop=1.0, harmonics=64, stability=False).at(0.95)
    assert motions
    for motion in motions:
        exact = motion.refine()
        assert motion.mesh_force_maximum[0] == pytest.approx(exact.mesh_force_maximum[0], rel=1e-3)
        assert exact.mesh_force_maximum[0] >= exact._sample(4000)[2].max() - 1e-6


def test_back_flanks_without_a_gap_are_refused():
    mesh = gt.Mesh(driving_radius=1.0, driven_radius=1.0, driving_inertia=2.0, driven_inertia=2.0, stiffness=1.0,
                   back_stiffness=2.0)
    ordinary = single_pair(1.0)
    with pytest.raises(gt.InputError, match=r"back_stiffness = 2.*never parts"):
        gt.Train(input_torque=1.0, prime_mover_inertia=0.0, load_inertia=0.0, characteristic_length=1.0,
                 characteristic_frequency=1.0, shafts=ordinary.shafts, meshes=[mesh]).modes()
