"""Excitations whose lower harmonics are 0: every analysis of orbits gives the motion that integration gives."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import paper_train

import geartrain as gt


def with_meshes(*changes, **values):
    train = paper_train(**values)
    meshes = [replace(mesh, **{"stiffness_cos": [], **change}) for mesh, change in zip(train.meshes, changes, strict=True)]
    return replace(train, meshes=meshes)


def random_sparse(seed):
    """The paper's train where few of many harmonics are excited, all of them multiples of 1, 2 or 3."""
    draw = np.random.default_rng(seed)
    divisor = int(draw.integers(1, 4))

    def harmonics(order, size):
        """Amplitudes of the multiples of ``order`` that are multiples of the divisor too, most of them 0."""
        kept = [h for h in range(1, 7) if (h * order) % divisor == 0 and h * order <= 30]
        return [size * draw.normal() if h in kept and draw.random() < 0.5 else 0.0 for h in range(1, 7)]

    orders = [int(order) for order in draw.integers(1, 7, 2)]
    changes = [
        {"order": order, "stiffness_cos": [0.02 * value for value in harmonics(order, 1.0)], "error_sin": harmonics(order, 1e-6)}
        for order in orders
    ]
    return with_meshes(*changes, torque_sin=harmonics(1, 5.0), input_torque=400.0)


def assert_one_motion(train, frequency):
    """Balance, orbit, exact branch and integration agree."""
    branch = train.response(start=frequency, stop=1.01 * frequency, harmonics=0, tolerance=1e-4, refine=True)
    motion = branch.at(frequency)[0].refine()
    assert motion.rms == pytest.approx(branch.at(frequency)[0].rms, rel=1e-3)
    assert train.integrate(frequency, start=motion).rms == pytest.approx(motion.rms, rel=1e-8)
    audit = branch.audit(points=5)
    assert audit.ok, audit


@pytest.mark.parametrize("frequency", [0.25, 0.40])
def test_mesh_orders_5_and_2_without_the_lowest_harmonic(frequency):
    assert_one_motion(with_meshes({"order": 5, "stiffness_cos": [0, 0.1]}, {"order": 2, "stiffness_cos": [0.1]}), frequency)


def test_torque_of_fourth_order_on_meshes_of_second():
    train = with_meshes({"order": 2, "stiffness_cos": [0.3]}, {"order": 2, "stiffness_cos": [0.3]}, torque_cos=[0, 0, 0, 15])
    assert_one_motion(train, 0.45)


def test_second_order_of_an_engine_on_even_teeth():
    train = gt.Train(
        characteristic_frequency=5000.0,
        bodies=[gt.Body(name="engine", inertia=0.02, torque=80.0, revolution_torque_cos=[0, 20.0]),
                gt.Body(name="pinion", inertia=2e-4), gt.Body(name="wheel", inertia=3e-3),
                gt.Body(name="load", inertia=0.5, balances=True)],
        shafts=[gt.Shaft(between=("engine", "pinion"), stiffness=2e4, damping_ratio=0.05),
                gt.Shaft(between=("wheel", "load"), stiffness=5e4, damping_ratio=0.05)],
        meshes=[gt.Mesh(between=("pinion", "wheel"), teeth=(20, 40), normal_module=3e-3, face_width=0.03, backlash=60e-6,
                        damping_ratio=0.05, stiffness_harmonics=2)],
    )
    assert_one_motion(train, 0.3)


def test_random_sparse_orders(times):
    for seed in range(times(40)):
        assert_one_motion(random_sparse(seed), 0.3)
