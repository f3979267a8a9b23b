"""Planetary sets that turn as one: direct gears, and power splits whose machines turn alike."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, run

import geartrain as gt
from geartrain.results.excitation import excitations
from geartrain.results.orders import named_orders

STIFF = 1e14
AT = np.linspace(1500.0, 4000.0, 6)


def locked(stiffness=1e9, lock=1e6):
    """A motor drives sun and carrier, which a clutch joins; the ring drives a gear pair."""
    bodies = [gt.Body(name="motor", inertia=0.02, torque=300.0), gt.Body(name="sun", inertia=8.2e-4),
              gt.Body(name="ring", inertia=0.12), gt.Body(name="arm", inertia=0.085), gt.Body(name="pinion", inertia=1e-3),
              gt.Body(name="wheel", inertia=0.02), gt.Body(name="load", inertia=2.0, balances=True)]
    shafts = [gt.Shaft(between=("motor", "sun"), stiffness=2e5, damping_ratio=0.02),
              gt.Shaft(between=("sun", "arm"), stiffness=lock),
              gt.Shaft(between=("ring", "pinion"), stiffness=3e5, damping_ratio=0.02),
              gt.Shaft(between=("wheel", "load"), stiffness=5e5, damping_ratio=0.02)]
    stage = gt.Planetary(name="stage 1", sun="sun", ring="ring", carrier="arm", teeth=(18, 21, 60), planets=3,
                         normal_module=4e-3, planet_inertia=2.2e-3, stiffness=(stiffness, 1.2 * stiffness), damping_ratio=0.03,
                         half_backlash=4e-5, sun_error_cos=2e-6, sun_stiffness_cos=0.2)
    with pytest.warns(gt.DrawingWarning, match="turn as one with their carrier 'arm'"):
        return gt.Train(bodies=bodies, shafts=shafts, planetaries=[stage], meshes=[FINAL])


FINAL = gt.Mesh(between=("pinion", "wheel"), teeth=(23, 71), normal_module=3e-3, face_width=0.04, backlash=100e-6,
                damping_ratio=0.05, stiffness_harmonics=3)


def test_a_stiff_lock_makes_one_body():
    """Sun, carrier, ring and planets as one inertia: with springs 1e5 times stiffer than the pair they differ by about 1e-5."""
    train = locked(STIFF, STIFF)
    whole = 8.2e-4 + 0.12 + 0.085 + 3 * 2.2e-3
    bodies = [gt.Body(name="motor", inertia=0.02, torque=300.0), gt.Body(name="set", inertia=whole),
              gt.Body(name="pinion", inertia=1e-3), gt.Body(name="wheel", inertia=0.02),
              gt.Body(name="load", inertia=2.0, balances=True)]
    shafts = [gt.Shaft(between=("motor", "set"), stiffness=2e5, damping=locked_damping(train, 1)),
              gt.Shaft(between=("set", "pinion"), stiffness=3e5, damping=locked_damping(train, 3)),
              gt.Shaft(between=("wheel", "load"), stiffness=5e5, damping=locked_damping(train, 4))]
    simple = gt.Train(bodies=bodies, shafts=shafts, meshes=[FINAL])
    found, wanted = (one.response(start=AT[0], stop=AT[-1], unit="rpm", harmonics=12, stability=False) for one in (train, simple))
    for speed in AT:
        assert found.at(speed)[0].rms[0] == pytest.approx(wanted.at(speed)[0].rms[0], rel=1e-4), speed


def locked_damping(train, shaft):
    return train.explain()[f"shaft {shaft}"]["damping"]


def test_modes_of_a_locked_set():
    """Against an eigenproblem of its own: absolute angles, rows of the meshes on the carrier by base radii."""
    train = locked()
    about = train.explain()
    names = [str(body.name) for body in train.bodies]
    inertia = np.array([body.inertia for body in train.bodies], dtype=float)
    stiffness = np.zeros((len(names), len(names)))

    def add(k, **entries):
        row = np.zeros(len(names))
        for name, entry in entries.items():
            row[names.index(name.replace("_", " "))] = entry
        stiffness[:] += k * np.outer(row, row)

    sun, planet = about["mesh 2"]["base_radius"]
    ring = about["mesh 5"]["base_radius"][1]
    for number in (1, 2, 3):
        own = f"stage_1_planet_{number}"
        add(1e9, sun=sun, arm=-sun - planet, **{own: planet})
        add(1.2e9, ring=-ring, arm=ring - planet, **{own: planet})
    pinion, wheel = about["mesh 1"]["base_radius"]
    add(about["mesh 1"]["stiffness"], pinion=pinion, wheel=wheel)
    for one, other, k in (("motor", "sun", 2e5), ("sun", "arm", 1e6), ("ring", "pinion", 3e5), ("wheel", "load", 5e5)):
        add(k, **{one: 1.0, other: -1.0})
    scale = 1 / np.sqrt(inertia)
    wanted = np.sqrt(np.sort(np.linalg.eigvalsh(scale[:, None] * stiffness * scale))[1:]) / (2 * np.pi)
    found = about["train"]["natural_frequency"]
    assert found == pytest.approx(wanted, rel=1e-9)
    # The reaction of the sun's meshes passes the clutch beside the motor's torque.
    force = np.mean([about[f"mesh {number}"]["mean_force"] for number in (2, 3, 4)])
    assert about["shaft 2"]["mean_torque"] == pytest.approx(300.0 - 3 * force * sun, rel=1e-9)


def test_a_locked_set_excites_nothing():
    train = locked()
    assert [train.explain()[f"mesh {number}"]["order"] for number in (1, 2, 5)] == [1, 0, 0]
    assert {cause.element for cause in excitations(train)} == {"mesh 1"}
    assert named_orders(train)[2.0] == "2 x mesh 1"


def test_a_rigid_lock_is_refused():
    with pytest.raises(gt.InputError, match="locked by a &shaft with a stiffness"):
        gt.Train(bodies=[gt.Body(name="sun", inertia=1e-3, torque=300.0), gt.Body(name="ring", inertia=0.1, balances=True),
                         gt.Body(name="arm", inertia=0.08)], shafts=[gt.Shaft(between=("sun", "arm"), rigid=True)],
                 planetaries=[gt.Planetary(name="a", sun="sun", ring="ring", carrier="arm", teeth=(18, 21, 60), planets=3,
                                           normal_module=4e-3, planet_inertia=2e-3, stiffness=(1e9, 1e9), damping_ratio=0.03,
                                           half_backlash=4e-5)])


def test_machines_that_turn_alike(executable, tmp_path):
    """A power split whose second motor turns as fast as the first: its set turns as one."""
    case = (ROOT / "namelists" / "hybrid.nml").read_text(encoding="utf-8").replace("speed_ratio = 2.0", "speed_ratio = 1.0")
    (tmp_path / "case.nml").write_text(case)
    found = run(executable, "--check", "case.nml", cwd=tmp_path)
    assert found.returncode == 0
    assert "turn as one with their carrier" in found.stderr


def test_gears_that_stand_still():
    """The ring of a power split is stopped by its ratio, and with it a gear pair: it excites nothing, and a warning says so."""
    bodies = [gt.Body(name="sun", inertia=1e-3, torque=100.0), gt.Body(name="arm", inertia=0.08, balances=True),
              gt.Body(name="ring", inertia=0.1, speed_ratio=0.0), gt.Body(name="wheel", inertia=0.01, balances=True)]
    stage = gt.Planetary(name="a", sun="sun", ring="ring", carrier="arm", teeth=(18, 21, 60), planets=3, normal_module=4e-3,
                         planet_inertia=2e-3, stiffness=(1e9, 1e9), damping_ratio=0.03, half_backlash=4e-5)
    mesh = gt.Mesh(between=("ring", "wheel"), teeth=(70, 71), driving_radius=0.2, driven_radius=0.2 * 71 / 70, stiffness=1e8,
                   damping_ratio=0.05, half_backlash=5e-5, error_cos=3e-6, stiffness_cos=0.2)
    with pytest.warns(gt.DrawingWarning, match="the gears of ring - wheel stand still: here"):
        train = gt.Train(bodies=bodies, planetaries=[stage], meshes=[mesh])
    assert train.explain()["mesh 1"]["order"] == 0
    with pytest.warns(gt.DrawingWarning):
        without = replace(train, meshes=[replace(train.meshes[0], error_cos=None, stiffness_cos=None), *train.meshes[1:]])
    found, wanted = (each.integrate(3000.0, unit="rpm").mesh_force for each in (train, without))
    assert np.ptp(wanted[:, 0]) > 1 and found == pytest.approx(wanted, rel=1e-9, abs=1e-6)
