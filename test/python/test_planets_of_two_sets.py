"""Planets of two sets on one carrier: pairs that mesh, as in a Ravigneaux set, and stepped planets, which shafts join."""

import numpy as np
import pytest
from conftest import ROOT, run

import geartrain as gt

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")


@pytest.mark.parametrize(("phase", "said"), [
    (2.1, ""), (4.1887902047863905, "pair 2 lags 0.666667 cycles behind pair 1, but short sun 2 lags 0.333333 behind short sun 1"),
])
def test_phases_of_meshes_between_planets(executable, tmp_path, phase, said):
    """Two decimals are enough; a place that the planet does not have is warned of, with the phase that it has."""
    case = (ROOT / "namelists" / "ravigneaux.nml").read_text(encoding="utf-8")
    (tmp_path / "case.nml").write_text(case.replace("name = 'pair 2', ", f"name = 'pair 2', phase = {phase}, "))
    warned = [line for line in run(executable, "--check", "case.nml", cwd=tmp_path).stderr.splitlines() if "phase:" in line]
    assert warned == [] if said == "" else len(warned) == 1 and said in warned[0] and "phase = 2.094395" in warned[0]


def test_meshes_between_planets_have_the_phases_of_their_places():
    """Where they have none of their own: 31 psi cycles at psi turns, from the first, which may have one."""
    train = gt.read_case(ROOT / "namelists" / "ravigneaux.nml").train
    pairs = [mesh for mesh in train.meshes if mesh.name.startswith("pair")]
    wanted = [0.0, 2 * np.pi * (31 / 3 % 1), 2 * np.pi * (62 / 3 % 1)]
    assert [mesh.phase or 0.0 for mesh in pairs] == pytest.approx(wanted, abs=1e-12)
    # The same in Python, with the gears of a pair the other way round.
    common = {"carrier": "carrier", "normal_module": 1.4e-3, "helix_angle": 20.0, "face_width": 0.024, "damping_ratio": 0.05,
              "backlash": 60e-6}
    sets = [gt.Planetary(name="short", sun="small sun", teeth=(31, 20, 0), planets=3, profile_shift=(0.2, 0.3, 0.0), **common),
            gt.Planetary(name="long", sun="large sun", ring="ring", teeth=(38, 23, 85), angles=(0, 240, 120),
                         profile_shift=(0.22, 0.3, -0.263945), **common)]
    meshes = [gt.Mesh(between=(f"short planet {n}", f"long planet {n}"), teeth=(20, 23), profile_shift=(0.3, 0.3), **common)
              for n in (1, 3)]
    meshes.insert(1, gt.Mesh(between=("long planet 2", "short planet 2"), teeth=(23, 20), profile_shift=(0.3, 0.3), **common))
    bodies = [body for body in train.bodies if "planet" not in body.name]
    made = gt.Train(bodies=bodies, shafts=train.shafts, meshes=meshes, planetaries=sets, title="same")
    assert [mesh.phase or 0.0 for mesh in made.meshes[:3]] == pytest.approx(wanted, abs=1e-12)


def rows(angles):
    """Stepped planets: planets of one set mesh with the sun, those of the other with the ring."""
    bodies = [gt.Body(name="sun", inertia=1e-3, torque=50.0), gt.Body(name="arm", inertia=0.05, balances=True),
              gt.Body(name="ring", held=True)]
    common = {"carrier": "arm", "normal_module": 2e-3, "face_width": 0.02, "damping_ratio": 0.05, "backlash": 60e-6}
    return gt.Train(bodies=bodies, planetaries=[
        gt.Planetary(name="big", sun="sun", teeth=(20, 50, 0), planets=3, **common),
        gt.Planetary(name="small", ring="ring", teeth=(0, 20, 90), angles=angles, **common),
    ], shafts=[gt.Shaft(between=(f"big planet {n}", f"small planet {n}"), rigid=True) for n in (1, 2, 3)])


@pytest.mark.parametrize("angles", [(0, 120, 240), (30, 150, 270)])
def test_stepped_planets(angles):
    """By Willis: with the ring held the sun turns 1 + z_p z_r/(z_s z_q) times as fast as the carrier."""
    assert rows(angles).explain()["arm"]["turns"] == pytest.approx(1 / (1 + 50 * 90 / (20 * 20)), rel=1e-12)


@pytest.mark.parametrize("angles", [(0, 60, 240), (0, 240, 120)])
def test_stepped_planets_at_two_places(angles):
    with pytest.raises(gt.InputError, match="must put the planets at the places of the planets of 'big'"):
        rows(angles)
