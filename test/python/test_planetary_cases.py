"""The case studies of docs/case-studies.md with planetary sets: a Ravigneaux set, a hybrid transaxle, a geared turbofan."""

from dataclasses import replace

import numpy as np
import pytest

import geartrain as gt
from case_studies import CASES

pytestmark = [pytest.mark.full, pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")]
RESPONSE = {"unit": "rpm", "harmonics": 0, "tolerance": 1e-3}


def train_of(name):
    return gt.read_case(CASES / f"{name}.nml").train


def second_gear(train):
    changes = {"large sun": {"held": True, "torque": None}, "carrier": {"held": None}}
    return replace(train, bodies=[replace(body, **changes.get(body.name, {})) for body in train.bodies])


def shaft_harmonics(motion, shaft):
    """Numbers of the harmonics of the torque of a shaft, by a Fourier transform."""
    amplitude = np.abs(np.fft.rfft(motion.shaft_torque[:, shaft]))[1:20]
    return np.flatnonzero(amplitude > 1e-6 * amplitude.max()) + 1


def test_ravigneaux_ratios_are_those_published():
    """By the published teeth; the set before it turns its input 108/71 times slower than the turbine."""
    first = train_of("ravigneaux")
    for train, published in ((first, 4.171), (second_gear(first), 2.340)):
        assert 108 / 71 / train.explain()["ring"]["turns"] == pytest.approx(published, abs=5e-4)


def test_ravigneaux_reactions():
    first = train_of("ravigneaux")
    ring, large = 31 / 85, 31 / 38
    motion = first.integrate(3500)
    # The drag of 2 N m acts against the turning of the large sun, which turns against the small one.
    assert motion.reaction_torque_mean[0] == pytest.approx((450 - 2 * large) / ring - 450 - 2, rel=1e-7)
    second = second_gear(first)
    motion = second.integrate(1990)
    assert motion.reaction_torque_mean[0] == pytest.approx(450 * (85 / 123 * 69 / 31 - 1), rel=1e-9)
    # Planets in sequence: harmonics 1 and 2 of the meshes cancel in the shafts.
    assert set(shaft_harmonics(motion, 0)) <= {3, 6, 9, 12, 15, 18}


def test_ravigneaux_second_gear():
    branch = second_gear(train_of("ravigneaux")).response(start=4250, stop=4450, **RESPONSE)
    assert branch.speed[branch.mesh_force_maximum[:, 6].argmax()] == pytest.approx(4352, abs=3)
    motion = branch.train.integrate(4350)
    np.testing.assert_allclose(branch.at(4350)[0].mesh_force_maximum, motion.mesh_force_maximum, rtol=1e-3)
    assert not (motion.separation_fraction > 0).any()


def test_ravigneaux_idle_sun_rattles():
    """In first gear the large sun only has its drag."""
    train = train_of("ravigneaux")
    branch = train.response(start=1800, stop=2000, **RESPONSE)
    assert branch.bands_without_stability[-1][1] == pytest.approx(1894, abs=2)
    motion = train.integrate(1930)
    np.testing.assert_allclose(branch.at(1930)[0].mesh_force_maximum, motion.mesh_force_maximum, rtol=1e-3)
    assert (motion.separation_fraction[6:9] > 0).all() and not (np.delete(motion.separation_fraction, [6, 7, 8]) > 0).any()


def test_report_of_equal_planets():
    """Meshes with equal figures have one sentence; each balancing body has its torque."""
    text = str(gt.read_case(CASES / "ravigneaux.nml").train.response(start=4990, stop=5000, **RESPONSE))
    assert "Meshes 7 (long sun 1), 8 (long sun 2), 9 (long sun 3): largest force" in text
    results = gt.read_case(CASES / "hybrid.nml")
    words = " ".join(str(replace(results, response={**results.response, "start": 1999, "stability": False}).run()).split())
    assert "balanced by motor 1 (19.44 N m) and car (-63.74 N m)" in words


def hybrid_amplitudes(train, hertz, torque):
    """Amplitudes of the accelerations of carrier and ring [rad/s^2] with rigid teeth in contact."""
    told = train.explain()
    inertia = {body.name: told[body.name]["inertia"] for body in train.bodies if body.name != "housing"}
    # Speeds of one carrier and one ring by Willis: all gears turn with these two.
    speed = {"carrier": (1, 0), "ring": (0, 1), "motor 1": (108 / 30, -78 / 30), "motor 2": (0, 58 / 22)}
    for number in range(1, 5):
        speed[f"split planet {number}"] = (1 - 78 / 23, 78 / 23)
        speed[f"reduction planet {number}"] = (0, 58 / 18)
    mass = np.zeros((4, 4))
    mass[0, 0], mass[3, 3] = inertia["engine"], inertia["car"]
    mass[1:3, 1:3] = sum(inertia[name] * np.outer(value, value) for name, value in speed.items())
    omega = 2 * np.pi * hertz
    system = -(omega**2) * mass.astype(complex)
    for shaft, first, last in zip(train.shafts, (0, 2), (1, 3)):
        reduced = 1 / sum(1 / inertia[name] for name in shaft.between)
        damping = 2 * shaft.damping_ratio * np.sqrt(shaft.stiffness * reduced)
        ends = np.ix_([first, last], [first, last])
        system[ends] += (shaft.stiffness + 1j * omega * damping) * np.array([[1, -1], [-1, 1]])
    return omega**2 * np.linalg.solve(system, [torque, 0, 0, 0])[1:3]


def test_hybrid():
    """Speeds and torques by Willis; the torque of motor 2 below which its teeth rattle."""
    train = train_of("hybrid")
    assert len(train.rigid_motions) == 2
    told = train.explain()
    assert told["split"]["sun_turns"] == pytest.approx(3.6 - 2.6 * 2)
    assert told["reduction"]["sun_turns"] == pytest.approx(-58 / 22 * 2)
    branch = train.response(start=1000, stop=1001, unit="rpm", harmonics=2, stability=False)
    motion = branch.at(1000)[0]
    # The carrier splits the torque of the engine as 30 : 78; the car has that of motor 2 too.
    assert motion.shaft_torque_mean[1] == pytest.approx(70 * 78 / 108 + 5 * 58 / 22, rel=1e-9)
    # The motion is linear in contact. A mesh parts where its alternating force is its mean, which goes with the torque.
    threshold = 5 * (motion.mesh_force_maximum / motion.mesh_force.mean(axis=0) - 1)[8:]
    inertia = train.bodies[4].inertia
    ring = np.abs(hybrid_amplitudes(train, 2000 / 60, 90.0)[1]) * 58 / 22
    np.testing.assert_allclose(threshold[:4], 3.0448, atol=1e-3)
    np.testing.assert_allclose(threshold[4:], 3.0701, atol=1e-3)
    # With rigid teeth; their stiffness adds (33.3/1233 Hz)^2, and the planets' inertia to the ring meshes.
    assert threshold[0] == pytest.approx(inertia * ring, rel=5e-3)


def test_turbofan():
    """Five stars: the torsion has harmonic 5 only, until one star is misplaced."""
    train = train_of("turbofan")
    assert 1 / train.explain()["ring"]["turns"] == pytest.approx(-3.0625)  # the carrier is held
    equal = train.response(start=5900, stop=6100, **RESPONSE)
    motion = equal.at(6030)[0]
    assert set(shaft_harmonics(motion, 0)) <= {5, 10, 15}
    np.testing.assert_allclose(equal.load_share, 0.2, rtol=1e-9)
    assert motion.reaction_torque_mean[0] == pytest.approx(-20e3 * (1 + 98 / 32), rel=1e-9)
    misplaced = replace(train, meshes=[replace(mesh, error_mean=10e-6) if mesh.name in ("gear sun 2", "gear ring 2") else mesh
                                       for mesh in train.meshes])
    # Springs in parallel: stiffnesses of sun and ring mesh in series, displacements of both meshes.
    sun, ring = (train.explain()[name]["stiffness"] for name in ("mesh 1", "mesh 6"))
    force = 20e3 / (16 * 4.5e-3 / np.cos(np.radians(25)) * np.cos(np.arctan(np.tan(np.radians(20)) / np.cos(np.radians(25)))))
    extra = 2 * 10e-6 * sun * ring / (sun + ring) * 0.8
    assert misplaced.explain()["gear"]["mesh_load_factor"] == pytest.approx(5 * (0.2 + extra / force), rel=2e-3)
    branch = misplaced.response(start=5900, stop=6100, **RESPONSE)
    before, after = (np.ptp([each.at(6030)[0].shaft_torque_minimum[0], each.at(6030)[0].shaft_torque_maximum[0]])
                     for each in (equal, branch))
    assert after > 20 * before
