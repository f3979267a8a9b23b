"""Trains whose shafts are so soft that a range of speeds is short beside the natural frequencies of the meshes."""

import pytest

import geartrain as gt

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")


def differential():
    """Two axles on a differential with double planets: the lowest mode is at 67 Hz, those of the meshes are from 11 kHz on."""
    bodies = [gt.Body(name="input", inertia=0.05, torque=300.0), gt.Body(name="ring", inertia=0.01),
              gt.Body(name="sun", inertia=0.002), gt.Body(name="carrier", inertia=0.01),
              gt.Body(name="front axle", inertia=3.0, balances=True, speed_ratio=1.05),
              gt.Body(name="rear axle", inertia=3.0, balances=True)]
    shafts = [gt.Shaft(between=("input", "ring"), stiffness=2e4, damping_ratio=0.02),
              gt.Shaft(between=("sun", "front axle"), stiffness=1e4, damping_ratio=0.02),
              gt.Shaft(between=("carrier", "rear axle"), stiffness=1e4, damping_ratio=0.02)]
    common = {"normal_module": 2e-3, "face_width": 0.02, "backlash": 80e-6, "damping_ratio": 0.05}
    inner = gt.Planetary(name="inner", sun="sun", carrier="carrier", teeth=(36, 16, 0), planets=3, sun_error_cos=2e-6, **common)
    outer = gt.Planetary(name="outer", ring="ring", carrier="carrier", teeth=(0, 16, 72), planets=3, ring_error_cos=2e-6, **common)
    meshes = [gt.Mesh(between=(f"inner planet {n}", f"outer planet {n}"), carrier="carrier", teeth=(16, 16), error_cos=2e-6,
                      **common) for n in (1, 2, 3)]
    return gt.Train(speed_of="input", bodies=bodies, shafts=shafts, meshes=meshes, planetaries=[inner, outer])


def test_a_response_is_no_loop():
    """Where the order 5 leaves the resonance at 222 rpm the motion comes to lie near the one at 200 rpm, with its tangent."""
    train = differential()
    branch = train.response(start=200, stop=300, unit="rpm", harmonics=0, tolerance=1e-3)
    assert branch.complete and not branch.closed
    motion = branch.at(250.0)[0]
    flown = train.integrate(250.0, unit="rpm")
    assert motion.mesh_force_maximum[0] == pytest.approx(flown.mesh_force_maximum[0], rel=1e-3)
