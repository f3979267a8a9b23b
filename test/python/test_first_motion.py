"""Where the response of a train of many loaded meshes begins, though neither rest nor integration leads to a periodic motion."""

import numpy as np
import pytest

import geartrain as gt
from paper_cases import chain


def loaded_train(seed):
    """A tree of seven to nine bodies, all joined by meshes and all loaded, with little damping and much variation of stiffness."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(6, 9))
    turns, ends = [1.0], []
    for body in range(1, count + 1):
        to = int(rng.integers(max(0, body - 2), body))
        turns.append(turns[to] * rng.uniform(0.6, 1.4))
        ends.append((to, body))
    torque = rng.uniform(60, 240)
    bodies = []
    for body, speed in enumerate(turns):
        more = {}
        if body == 0:
            more["torque"] = torque
        elif body == count:
            more["balances"] = True
        else:
            more["torque"] = -rng.uniform(0.05, 0.12) * torque / speed
        bodies.append(gt.Body(name=f"b{body + 1}", inertia=rng.uniform(0.8, 4) * (0.05 / speed) ** 2, **more))
    meshes = []
    for one, other in ends:
        radius = rng.uniform(0.03, 0.08)
        meshes.append(gt.Mesh(
            between=(f"b{one + 1}", f"b{other + 1}"), driving_radius=radius, driven_radius=radius * turns[one] / turns[other],
            stiffness=10 ** rng.uniform(8, 8.7), damping_ratio=0.012, half_backlash=rng.uniform(10e-6, 60e-6),
            stiffness_cos=[rng.uniform(0.1, 0.7)], phase=rng.uniform(0, 6)))
    frequency = np.random.default_rng(seed + 1000).uniform(0.5, 1.3)
    return gt.Train(characteristic_length=30e-6, characteristic_frequency=1e4, bodies=bodies, meshes=meshes), frequency


# Of seed 0 and 3 the search ended without a motion after a quarter of a minute.
@pytest.mark.parametrize("seed", [3, pytest.param(0, marks=pytest.mark.full), pytest.param(5, marks=pytest.mark.nightly)])
def test_a_response_begins(seed):
    train, frequency = loaded_train(seed)
    branch = train.response(start=frequency, stop=frequency + 0.01, harmonics=6, stability=False, max_points=3)
    assert len(branch) > 0
    assert np.isfinite(branch.rms).all()


@pytest.mark.filterwarnings("ignore:.*critical damping")
def test_a_train_that_rings_for_long():
    """Free vibrations of a hundred shafts outlast every integration: the branch is followed from where rest leads to it."""
    train = chain(100)
    asked = {"harmonics": 6, "stability": False}
    branch = train.response(start=0.826, stop=0.819, **asked)
    same = train.response(start=0.84, stop=0.819, **asked)  # where Newton's method from rest finds a motion
    assert branch.complete and same.complete
    np.testing.assert_allclose(branch.at(0.82)[0].rms, same.at(0.82)[0].rms, rtol=0, atol=1e-9 * branch.rms.max())


@pytest.mark.full
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_a_first_motion_of_few_harmonics_gets_as_many_as_the_tolerance_needs(tolerance):
    """A coupling hits its stops: from 6 harmonics, a third off, Newton's method does not lead to 200; the flow does."""
    bodies = [gt.Body(name="a", inertia=0.01, torque=50.0, torque_cos=[10.0, 5.0], torque_sin=[0.0, 8.0]),
              gt.Body(name="b", inertia=0.004), gt.Body(name="c", inertia=0.02),
              gt.Body(name="d", inertia=0.05, balances=True, damping_to_ground=0.5)]
    mesh = gt.Mesh(between=("b", "c"), driving_radius=0.05, driven_radius=0.08, order=6, stiffness=3e8, stiffness_cos=[0.2],
                   damping=2000.0, half_backlash=1e-5, error_cos=[1e-6])
    train = gt.Train(characteristic_frequency=774.4, characteristic_length=2.193e-5, bodies=bodies, meshes=[mesh],
                     shafts=[gt.Shaft(between=("c", "d"), damping=2.0, stiffness=3e4)],
                     couplings=[gt.Coupling(between=("a", "b"), damping=0.5, half_play=0.008793, stiffness=8000.0)])
    branch = train.response(start=0.5408, stop=0.5462, harmonics=0, tolerance=tolerance, max_points=4)
    motion = branch.at(0.5408)[0]
    exact = motion.refine()
    # 384 harmonics, the most, leave an estimate of 4e-6.
    assert branch.error_estimate[0] < max(tolerance, 5e-6) and branch.harmonics[0] >= 200
    assert motion.rms == pytest.approx(exact.rms, rel=max(tolerance, 5e-6))
    assert motion.stable and not motion.undecided


@pytest.mark.full
@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_a_planet_that_rattles():
    """An error of 10 um unloads a planet: its motion has more harmonics than a balance takes, and the search says so soon."""
    bodies = [gt.Body(name="motor", inertia=0.05, torque=300.0), gt.Body(name="sun", inertia=8e-4),
              gt.Body(name="ring", inertia=0.12, held=True), gt.Body(name="arm", inertia=0.085),
              gt.Body(name="pinion", inertia=2e-3), gt.Body(name="wheel", inertia=4e-2),
              gt.Body(name="load", inertia=1.0, balances=True)]
    drawn = {"pressure_angle": 20.0, "face_width": 0.03, "backlash": 80e-6, "damping_ratio": 0.04, "stiffness_harmonics": 3}
    stage = gt.Planetary(name="stage 1", sun="sun", ring="ring", carrier="arm", teeth=(21, 33, 87), planets=3, normal_module=3e-3,
                         planet_errors=[0.0, 10e-6, -5e-6], **drawn)
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=(27, 64), normal_module=4e-3, helix_angle=12.0, **drawn)
    shafts = [gt.Shaft(between=("motor", "sun"), stiffness=2e4, damping_ratio=0.03),
              gt.Shaft(between=("arm", "pinion"), stiffness=3e5, damping_ratio=0.03),
              gt.Shaft(between=("wheel", "load"), stiffness=3e5, damping_ratio=0.03)]
    train = gt.Train(bodies=bodies, planetaries=[stage], meshes=[mesh], shafts=shafts)
    motion = train.integrate(800.0)
    assert motion.kind == "periodic" and motion.separation_fraction.max() > 0.5
    # Whether Newton's method finds a solution of so few harmonics hangs on their number; it had searched for minutes.
    try:
        branch = train.response(start=800.0, stop=801.0, unit="rpm", harmonics=0, stability=False, max_points=3)
    except gt.SolverError as error:
        assert "that on which time integration settles has more harmonics than a response takes" in str(error)
    else:
        assert len(branch) > 0


@pytest.mark.full
@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_an_unloaded_planet_of_a_differential():
    """It rattles in six meshes with backlash: the branch takes 143 to 266 harmonics, where it began with 6 and kept them."""
    bodies = [gt.Body(name="engine", inertia=0.15, torque=200.0), gt.Body(name="ring", inertia=0.004), gt.Body(name="sun"),
              gt.Body(name="carrier", inertia=0.003), gt.Body(name="front", inertia=2.0, balances=True),
              gt.Body(name="rear", inertia=3.0, balances=True, speed_ratio=1.25)]
    stage = gt.Planetary(name="differential", sun="sun", ring="ring", carrier="carrier", teeth=(28, 17, 62), planets=3,
                         driving="ring", normal_module=2e-3, face_width=0.025, profile_shift=(0.0, 0.0, 0.0), backlash=80e-6,
                         damping_ratio=0.05, stiffness_harmonics=3, ring_phase=0.4, planet_errors=[0.0, 3e-6, -2e-6])
    shafts = [gt.Shaft(between=("engine", "ring"), stiffness=15000.0, damping_ratio=0.05),
              gt.Shaft(between=("sun", "front"), stiffness=8000.0, damping_ratio=0.03),
              gt.Shaft(between=("carrier", "rear"), stiffness=9000.0, damping_ratio=0.03)]
    train = gt.Train(bodies=bodies, planetaries=[stage], shafts=shafts)
    branch = train.response(start=520.0, stop=600.0, unit="rpm", harmonics=0, tolerance=1e-3, stability=False)
    # At constant speed a small error of the speed is a large one of the motion where the branch is nearly vertical.
    steep = (branch.error_estimate > 1e-3).nonzero()[0]
    assert ("nearly vertical" in branch.ended) == (len(steep) > 0) and branch.ended.startswith("reached 600 rpm")
    assert len(steep) < 3 and (branch.error_estimate < 2e-3).all()
    assert all(np.ptp(branch.frequency[point - 1:point + 2]) < 0.1 for point in steep)
    [motion] = branch.at(522.0, unit="rpm")
    settled = train.integrate(522.0, unit="rpm")
    assert settled.kind == "periodic" and settled.separation_fraction.max() > 0.5
    np.testing.assert_allclose(motion.rms, settled.rms, rtol=1e-3)
