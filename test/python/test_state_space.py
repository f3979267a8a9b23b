"""The train as a linear system: against matrices written by hand, natural frequencies and time integration."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, reducer

import geartrain as gt

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")


def case(name):
    return gt.read_case(ROOT / "namelists" / f"{name}.nml").train


def test_against_matrices_by_hand():
    """I theta'' + B^T (c B theta' + k B theta) = T of the reducer, solved at frequencies about all resonances."""
    train = reducer()
    numbers = train.explain()
    bodies, elements = train.body_labels, ("shaft 1", "mesh 1", "shaft 2", "mesh 2", "shaft 3")
    inertia = np.diag([numbers[name]["inertia"] for name in bodies])
    rows = np.zeros((5, 6))
    for place, name in enumerate(elements):  # each body turns as the train does
        rows[place, place:place + 2] = numbers[name]["base_radius"] * [1, -1] if name.startswith("mesh") else [1, -1]
    k, c = (np.array([numbers[name][what] for name in elements]) for what in ("stiffness", "damping"))
    system = train.state_space(inputs=["motor", "wheel 1"], outputs=[*elements, "pinion 1", "load"])
    assert system.units == ("N m", "N", "N m", "N", "N m", "rad/s", "rad/s") and not system.D.any()
    for frequency in (3.0, 400.0, 1234.0, *train.natural_frequencies(unit="Hz")):
        s = 2j * np.pi * frequency
        # The angle of the rigid motion has no spring: the inertia holds it.
        theta = np.linalg.solve(s**2 * inertia + rows.T * (k + s * c) @ rows, np.eye(6)[:, [0, 2]])
        expected = np.vstack([((k + s * c) * (rows @ theta).T).T, s * theta[[1, 5]]])
        # Rounding of the modes, some 1e-13 of the stiffest, times the resonance ratio of up to 100.
        assert np.allclose(system.response(frequency), expected, rtol=1e-8, atol=1e-9 * abs(expected).max())


def test_springs_to_ground():
    """A pair whose gears are held by springs, against its two equations of motion."""
    train = gt.Train(bodies=[gt.Body(name="pinion", inertia=0.1, torque=10.0, damping_to_ground=2.0),
                             gt.Body(name="wheel", inertia=0.3, stiffness_to_ground=1e5, damping_to_ground=3.0)],
                     meshes=[gt.Mesh(between=("pinion", "wheel"), driving_radius=0.05, driven_radius=0.1, stiffness=1e8,
                                     damping=2e3)], characteristic_length=1e-6, characteristic_frequency=1000.0)
    system = train.state_space(inputs=["pinion"], outputs=["mesh 1", "ground 2", "wheel"])
    assert system.units == ("N", "N m", "rad/s")
    row = np.array([0.05, -0.1])
    for frequency in (3.0, 100.0, *train.natural_frequencies(unit="Hz")):
        s = 2j * np.pi * frequency
        spring = 1e8 + 2e3 * s
        theta = np.linalg.solve(np.diag([0.1 * s**2 + 2.0 * s, 0.3 * s**2 + 3.0 * s + 1e5]) + spring * np.outer(row, row), [1, 0])
        expected = np.array([spring * (row @ theta), 1e5 * theta[1], s * theta[1]])
        # Rounding of the modes times the resonance ratio.
        assert np.allclose(system.response(frequency)[:, 0], expected, rtol=1e-9)


@pytest.mark.parametrize("name", ["reducer", "planetary", "bearings", "clutch"])
def test_eigenvalues_are_those_of_the_modes(name):
    train = case(name)
    modes, system = train.modes(), train.state_space()
    found = np.linalg.eigvals(system.A) / train.explain()["train"]["characteristic_frequency"]
    found = found[abs(found) > 1e-6 * abs(found).max()]  # the rigid motion's is 0
    vibrating = np.sort(found[found.imag > 1e-9 * abs(found).max()].imag)
    assert np.allclose(vibrating, np.sort(modes.damped_frequency[modes.damping_ratio < 1]), rtol=1e-8)
    assert len(system.states) == 2 * len(modes.natural_frequency) + len(train.rigid_motions)


def test_against_time_integration():
    """A torque at the fundamental on a train that is linear: amplitude and lag of shaft torque and mesh force."""
    bodies = [gt.Body(name="motor", inertia=0.02, torque=90.0, torque_cos=[12.0]), gt.Body(name="pinion", inertia=3e-4),
              gt.Body(name="wheel", inertia=2e-3, damping_to_ground=0.4), gt.Body(name="load", inertia=0.5, balances=True)]
    shafts = [gt.Shaft(between=("motor", "pinion"), stiffness=1e4, damping_ratio=0.02),
              gt.Shaft(between=("wheel", "load"), stiffness=2e4, damping_ratio=0.03)]
    mesh = gt.Mesh(between=("pinion", "wheel"), driving_radius=0.03, driven_radius=0.05, stiffness=4e8, damping_ratio=0.05)
    train = gt.Train(bodies=bodies, shafts=shafts, meshes=[mesh], characteristic_frequency=1000.0,
                     characteristic_length=1e-6)
    system = train.state_space(inputs=["motor"], outputs=["shaft 1", "shaft 2", "mesh 1"])
    for ratio in (0.4, 0.9):
        motion = train.integrate(ratio * train.natural_frequencies()[0])
        expected = 12.0 * system.response(motion.fundamental_frequency)[:, 0]
        values = np.column_stack([motion.shaft_torque, motion.mesh_force])
        found = 2 * np.fft.fft(values, axis=0)[motion.period] / len(values)
        # Settled to 1e-9 of the displacement, of which the shaft torque is a difference.
        assert np.allclose(found, expected, rtol=1e-6)


def test_what_is_no_linear_system(paper):
    with pytest.raises(gt.InputError, match="needs a train of bodies"):
        paper.state_space()
    with pytest.raises(gt.InputError, match=r"inputs = \['engine'\]: must be a list of names: motor, pinion 1"):
        reducer().state_space(inputs=["engine"])
    with pytest.raises(gt.InputError, match="coupling 1 has dry friction"):
        train = case("clutch")
        rubbing = [replace(train.couplings[0], friction_torque=3.0), train.couplings[1]]
        replace(train, couplings=rubbing).state_space()


@pytest.fixture(name="paper")
def _paper():
    from conftest import paper_train

    return paper_train()


TABLE = tuple(2.5e8 * (1 + 0.3 * np.cos(2 * np.pi * k / 16)) for k in range(16))


def pair(**more):
    bodies = [gt.Body(name="pinion", inertia=2.3e-3, torque=150.0), gt.Body(name="wheel", inertia=37e-3, balances=True)]
    usual = {"stiffness": 2.5e8, "stiffness_cos": (0.3, 0.05), "stiffness_sin": 0.1}
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=(20, 40), driving_radius=0.05, driven_radius=0.1, damping_ratio=0.02,
                   half_backlash=3e-5, **{**usual, **more})
    return gt.Train(bodies=bodies, meshes=[mesh])


@pytest.mark.parametrize("more", [
    {}, {"stiffness": None, "stiffness_cos": None, "stiffness_sin": None, "stiffness_table": TABLE},
    {"damping_acts": "contact", "back_stiffness": 2e8, "back_phase": 0.4},
])
def test_at_a_motion_that_parts(more):
    """The average of the spring force over the deflection of the teeth while they touch, along the motion itself."""
    train = pair(**more)
    speed = 60 * train.explain()["train"]["natural_frequency"][0] / 20
    motion = train.integrate(0.8 * speed, unit="rpm")
    apart = motion.separation_fraction[0]
    assert 0.05 < apart < 0.95
    about = train.explain()["mesh 1"]
    path = motion.trajectory(motion.period, samples=4096)
    p, rate = path.displacement[:, 0] * 1e-6, path.velocity[:, 0] * 1e-6 * train.explain()["train"]["characteristic_frequency"]
    touches = abs(p) > 3e-5
    damping = about["damping"] * (touches if "damping_acts" in more else 1.0)
    deflection = p - np.copysign(3e-5, p)
    sure = touches & (abs(deflection) > 1e-9)
    stiffness = np.where(sure, (path.mesh_force[:, 0] - damping * rate) / np.where(sure, deflection, 1.0), 0.0)
    mass = 1 / (0.05**2 / 2.3e-3 + 0.1**2 / 37e-3)
    values = np.linalg.eigvals(train.state_space(at=motion).A)
    own = np.roots([1.0, np.mean(damping * np.ones(len(p))) / mass, stiffness.mean() / mass])
    assert sorted(values.imag)[-1] == pytest.approx(max(own.imag), rel=1e-3)
    assert min(values.real[abs(values.imag) > 1]) == pytest.approx(own.real[0], rel=1e-3)


def test_at_a_motion_in_contact():
    train = reducer()
    motion = train.integrate(500.0, unit="rpm")
    assert not motion.separation_fraction.any()
    assert train.state_space(at=motion).A == pytest.approx(train.state_space().A, rel=1e-6, abs=1e-6)
    with pytest.raises(gt.InputError, match="at: must be a motion of this train"):
        pair().state_space(at=motion)


def test_a_rack():
    """A pinion on a rack: the bar slides, its mass in kg and its spring to ground in N/m, against two equations of motion."""
    cosine = np.cos(np.radians(20))
    train = gt.Train(bodies=[gt.Body(name="pinion", inertia=2e-4, torque=10.0),
                             gt.Body(name="bar", inertia=3.0, stiffness_to_ground=1e6)],
                     meshes=[gt.Mesh(between=("pinion", "bar"), driving_radius=0.02, driven_radius=cosine, stiffness=2e8,
                                     damping=50.0)], characteristic_length=1e-6, characteristic_frequency=1000.0)
    row = np.array([0.02, -cosine])
    mass, stiffness = np.diag([2e-4, 3.0]), np.diag([0.0, 1e6]) + 2e8 * np.outer(row, row)
    omega = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)))
    np.testing.assert_allclose(train.natural_frequencies(unit="Hz"), np.sort(omega) / (2 * np.pi), rtol=1e-10)
    assert train.explain()["mesh 1"]["mean_force"] == pytest.approx(10.0 / 0.02, rel=1e-12)
