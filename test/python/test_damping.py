"""Damping by loss factors and by ratios of the modes, and warnings of modes of hardly any: against eigenvalues by NumPy."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from conftest import paper_train, reducer
from scipy.optimize import nnls

import geartrain as gt


def undamped(train, **changes):
    """The train without damping of its own, then with the given changes of it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        bare = replace(train, shafts=[replace(shaft, damping_ratio=None) for shaft in train.shafts],
                       meshes=[replace(mesh, damping_ratio=None) for mesh in train.meshes])
        return replace(bare, **changes)


def matrices(train):
    """Inertias and, of the elements shaft 1, mesh 1, ..., gradients of the displacement, stiffnesses and dampings; of a network."""
    told, names = train.explain(), [body.name for body in train.bodies]
    inertia = np.array([told[name]["inertia"] for name in names])
    rows, stiffness, damping = [], [], []
    for k in range(max(len(train.shafts), len(train.meshes))):
        for kind, parts in (("shaft", train.shafts), ("mesh", train.meshes)):
            if k < len(parts):
                numbers = told[f"{kind} {k + 1}"]
                radii = (1.0, 1.0) if kind == "shaft" else numbers["base_radius"]
                row = np.zeros(len(names))
                row[names.index(parts[k].between[0])] = radii[0]
                row[names.index(parts[k].between[1])] = -radii[1]
                rows.append(row)
                stiffness.append(numbers["stiffness"])
                damping.append(numbers["damping"])
    return inertia, np.array(rows), np.array(stiffness), np.array(damping)


def modes_by_numpy(train):
    """Natural frequencies [rad/s], shares of strain energy (mode, element), and ratios by the eigenvalues of the damped train."""
    inertia, rows, stiffness, damping = matrices(train)
    square, shapes = np.linalg.eigh((rows.T * stiffness) @ rows / np.sqrt(np.outer(inertia, inertia)))
    frequency = np.sqrt(square[1:])
    strain = rows @ (shapes[:, 1:] / np.sqrt(inertia)[:, None])
    shares = (stiffness[:, None] * strain**2 / square[1:]).T
    n = len(inertia)
    state = np.block([[np.zeros((n, n)), np.eye(n)],
                      [-(rows.T * stiffness) @ rows / inertia[:, None], -(rows.T * damping) @ rows / inertia[:, None]]])
    values = np.linalg.eigvals(state)
    values = values[(values.imag > 0) & (abs(values) > 0.1 * frequency[0])]
    values = values[np.argsort(abs(values))]
    return frequency, shares, -values.real / abs(values)


def test_one_ratio_for_all_modes():
    train = undamped(reducer(), modal_damping=[0.02])
    frequency, shares, ratios = modes_by_numpy(train)
    assert train.explain()["train"]["mode_damping_ratio"] == pytest.approx(0.02, rel=1e-6)
    assert ratios == pytest.approx(0.02, rel=0.01)  # the modes are coupled in second order
    modes = train.modes()
    assert modes.damping_ratio == pytest.approx(ratios, rel=1e-8)
    assert modes.natural_frequency_hertz * 2 * np.pi == pytest.approx(frequency, rel=1e-9)
    _, _, stiffness, damping = matrices(train)
    wanted = np.linalg.solve(shares * frequency[:, None] / (2 * stiffness), np.full(5, 0.02))
    assert (wanted > 0).all() and damping == pytest.approx(wanted, rel=1e-6)
    assert train.warnings == ()


def test_a_ratio_for_each_mode():
    asked = [0.01, 0.02, 0.03, 0.05]
    train = undamped(reducer(), modal_damping=asked)
    assert train.explain()["train"]["mode_damping_ratio"] == pytest.approx([*asked, 0.05], rel=1e-6)


def test_ratios_out_of_reach_are_the_nearest_and_told():
    """High modes cannot have less damping than the elements that damp the low ones give them."""
    asked = np.array([0.05, 0.05, 0.05, 0.0005, 0.0005])
    with pytest.warns(gt.DrawingWarning, match=r"modal_damping is not met: mode 1 has 0\.\d+ in place of 0\.05"):
        train = replace(undamped(reducer()), modal_damping=list(asked))
    frequency, shares, _ = modes_by_numpy(train)
    _, _, stiffness, damping = matrices(train)
    matrix = shares * frequency[:, None] / (2 * stiffness) / asked[:, None]
    scale = np.linalg.norm(matrix, axis=0)
    wanted = nnls(matrix / scale, np.ones(5))[0] / scale
    assert (wanted == 0).any()
    assert matrix @ damping == pytest.approx(matrix @ wanted, rel=1e-6)
    ratio = matrix @ wanted * asked
    assert train.explain()["train"]["mode_damping_ratio"] == pytest.approx(ratio, rel=1e-6)
    # The report marks the modes that miss their ratio, and no other.
    words = str(train.response(start=1000, stop=1001, unit="rpm", harmonics=0, tolerance=1e-2, stability=False))
    marked = re.findall(r"^ +(\d) .*; modal_damping asks for (\S+) %$", words, re.MULTILINE)
    missed = np.flatnonzero(abs(ratio / asked - 1) > 0.05)
    assert missed.size and marked == [(str(mode + 1), f"{100 * asked[mode]:g}") for mode in missed]


def test_elements_with_damping_of_their_own_keep_it():
    bare = undamped(reducer())
    shafts = [replace(bare.shafts[0], damping=0.3), *bare.shafts[1:]]
    train = replace(bare, shafts=shafts, modal_damping=[0.02])
    assert train.explain()["shaft 1"]["damping"] == 0.3
    assert train.explain()["train"]["mode_damping_ratio"] == pytest.approx(0.02, rel=0.4)


def test_damping_to_ground_counts():
    bare = undamped(reducer())
    drag = replace(bare, bodies=[replace(bare.bodies[0], damping_to_ground=0.1), *bare.bodies[1:]])
    own = drag.explain()["train"]["mode_damping_ratio"]
    assert own[0] > 1e-4
    train = replace(drag, modal_damping=[0.02])
    assert train.explain()["train"]["mode_damping_ratio"] == pytest.approx(0.02, rel=1e-5)
    assert train.modes().damping_ratio == pytest.approx(0.02, rel=0.02)
    inertia, rows, stiffness, _ = matrices(bare)
    square, shapes = np.linalg.eigh((rows.T * stiffness) @ rows / np.sqrt(np.outer(inertia, inertia)))
    assert own == pytest.approx(0.1 * (shapes[0, 1:] ** 2 / inertia[0]) / (2 * np.sqrt(square[1:])), rel=1e-6)


def test_equal_branches_get_equal_damping():
    bodies = [gt.Body(name="sun", inertia=0.01, torque=100.0), *(gt.Body(name=f"p{k}", inertia=0.001) for k in range(3)),
              gt.Body(name="ring", inertia=0.1, balances=True)]
    pair = {"driving_radius": 0.05, "driven_radius": 0.03, "stiffness": 2e8}
    meshes = [mesh for k in range(3) for mesh in (
        gt.Mesh(between=("sun", f"p{k}"), **pair),
        gt.Mesh(between=(f"p{k}", "ring"), internal=True, driving_radius=0.03, driven_radius=0.11, stiffness=3e8))]
    given = {"bodies": bodies, "shafts": [], "meshes": meshes, "characteristic_length": 1e-6, "characteristic_frequency": 1e3}
    # Six meshes, two kinds of them, and four modes: not all ratios are within reach.
    with pytest.warns(gt.DrawingWarning, match=r"not met: mode 1 has 0\.0218 in place of 0\.03, mode 4 has 0\.0365"):
        train = gt.Train(**given, modal_damping=[0.03])
    told = train.explain()
    damping = [told[f"mesh {k}"]["damping"] for k in range(1, 7)]
    assert damping[0] == damping[2] == damping[4] and damping[1] == damping[3] == damping[5]
    ratios = told["train"]["mode_damping_ratio"]
    assert train.modes().damping_ratio == pytest.approx(ratios, rel=0.02)
    # Modes 2 and 3 are a pair of equal frequency: no other coefficients >= 0 of the two kinds come nearer.
    effects = []
    for kind in (0, 1):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            alone = gt.Train(**{**given, "meshes": [replace(mesh, damping=1.0 if k % 2 == kind else 0.0)
                                                    for k, mesh in enumerate(meshes)]})
        effects.append(alone.explain()["train"]["mode_damping_ratio"])
    scale = np.linalg.norm(effects, axis=1)
    assert damping[:2] == pytest.approx(nnls(np.transpose(effects) / scale, np.full(4, 0.03))[0] / scale, rel=1e-6)


def test_loss_factors():
    train = undamped(reducer())
    train = replace(train, shafts=[replace(shaft, loss_factor=0.02) for shaft in train.shafts],
                    meshes=[replace(mesh, loss_factor=0.06) for mesh in train.meshes])
    frequency, shares, ratios = modes_by_numpy(train)
    _, _, stiffness, damping = matrices(train)
    eta = np.array([0.02, 0.06, 0.02, 0.06, 0.02])
    assert damping == pytest.approx(eta * stiffness / frequency[shares.argmax(axis=0)], rel=1e-9)
    assert train.modes().damping_ratio == pytest.approx(ratios, rel=1e-8)
    assert "natural frequency of mode 1" in str(train.explain())


def test_a_single_pair_has_half_the_loss_factor():
    pair = gt.read_case("namelists/single_pair.nml").train
    train = undamped(pair, meshes=[replace(pair.meshes[0], damping_ratio=None, loss_factor=0.08)])
    assert train.modes().damping_ratio == pytest.approx([0.04], rel=1e-9)
    assert undamped(pair, modal_damping=[0.04]).modes().damping_ratio == pytest.approx([0.04], rel=1e-9)


def test_results_are_those_of_the_coefficients():
    train = undamped(paper_train(), modal_damping=[0.02])
    told = train.explain()
    same = undamped(paper_train(), shafts=[replace(shaft, damping_ratio=None, damping=told[f"shaft {k}"]["damping"])
                                           for k, shaft in enumerate(train.shafts, 1)],
                    meshes=[replace(mesh, damping_ratio=None, damping=told[f"mesh {k}"]["damping"])
                            for k, mesh in enumerate(train.meshes, 1)])
    one, other = (side.response(start=0.6, stop=0.7, harmonics=6) for side in (train, same))
    assert one.rms[-1] == pytest.approx(other.rms[-1], rel=1e-9)


@pytest.mark.parametrize("given", [{"modal_damping": [0.02]}, "loss_factor"])
def test_derivatives_and_continuation(given):
    """Damping follows the modes along a parameter."""
    train = undamped(reducer(), **(given if isinstance(given, dict) else {}))
    if given == "loss_factor":
        train = replace(train, shafts=[replace(shaft, loss_factor=0.02) for shaft in train.shafts],
                        meshes=[replace(mesh, loss_factor=0.06) for mesh in train.meshes])
    names = ["shaft 3 diameter", "load inertia"] + (["modal_damping 1"] if given != "loss_factor" else ["mesh * loss_factor"])
    motion = train.response(start=1500.0, stop=1501.0, unit="rpm", harmonics=0, tolerance=1e-6).at(1500.0, unit="rpm")[0]
    found = motion.gradient("rms", names)
    for k, name in enumerate(names):
        value = {"shaft 3 diameter": 0.060, "load inertia": 1.5, "modal_damping 1": 0.02, "mesh * loss_factor": 0.06}[name]
        step = 1e-5 * value
        sides = [train.with_values({name: value + h}).integrate(1500.0, unit="rpm", start=motion).refine().rms
                 for h in (-step, step)]
        assert found[:, k] == pytest.approx((sides[1] - sides[0]) / (2 * step), rel=1e-4, abs=1e-8 * abs(found[:, k]).max())
    branch = train.continuation(parameter="load inertia", start=1.5, stop=1.6, frequency=1500.0, unit="rpm", harmonics=0)
    there = train.with_values({"load inertia": 1.6}).response(start=1500.0, stop=1501.0, unit="rpm", harmonics=0)
    assert branch.rms[-1] == pytest.approx(there.rms[0], rel=1e-3)


def test_a_loss_factor_that_changes_its_mode_along_a_parameter():
    train = undamped(reducer())
    train = replace(train, shafts=[replace(shaft, loss_factor=0.02) for shaft in train.shafts])
    with pytest.raises(gt.InputError, match="most strain energy in another mode"):
        train.continuation(parameter="shaft 1 diameter", start=0.01, stop=0.2, frequency=1500.0, unit="rpm", harmonics=0)


def test_hardly_damped_modes_are_told(executable, tmp_path):
    train = reducer()
    with pytest.warns(gt.DrawingWarning, match=r"mode 1 at 97\.2 Hz has only 0\.\d+ of critical damping: 82 % of its strain energy "
                                               r"is in shaft 3 \(wheel 2 - load\), whose damping_ratio = 0\.001 is that of its end "
                                               r"inertias alone, at \d+ Hz; at the frequency of the mode it is 0\.000"):
        train = replace(train, shafts=[replace(shaft, damping_ratio=0.001) for shaft in train.shafts])
    low = train.modes().damping_ratio < 1e-3
    assert low.any() and sum("of critical damping" in told for told in train.warnings) == min(3, low.sum()) + (low.sum() > 3)
    with pytest.warns(gt.DrawingWarning, match=r"mode 2 at 318 Hz has no damping: 46 % of .* is in shaft 2 .* has none"):
        replace(train, shafts=[replace(shaft, damping_ratio=None) for shaft in train.shafts],
                meshes=[replace(mesh, damping_ratio=None) for mesh in train.meshes])
    assert reducer().warnings == ()


@pytest.mark.parametrize("change, words", [
    ({"modal_damping": [0.02]}, "modal_damping = 0.02: needs a shaft, mesh or coupling without damping of its own"),
    ({"modal_damping": [-0.1]}, "modal_damping.*must be >= 0"),
])
def test_trains_that_are_refused(change, words):
    with pytest.raises(gt.InputError, match=words):
        replace(reducer(), **change)


def test_elements_that_are_refused():
    train = reducer()
    with pytest.raises(gt.InputError, match=r"damping_ratio = .*: contradicts loss_factor"):
        replace(train, shafts=[replace(train.shafts[0], loss_factor=0.1), *train.shafts[1:]])
    with pytest.raises(gt.InputError, match=r"loss_factor = 0\.1: contradicts rigid"):
        replace(paper_train(), shafts=[gt.Shaft(rigid=True, loss_factor=0.1), *paper_train().shafts[1:]])
    with pytest.raises(gt.InputError, match=r"is value 6, but the train has 5 elastic modes"):
        undamped(train, modal_damping=[0.01] * 6)
    softer = undamped(paper_train(), modal_damping=[0.02])
    with pytest.raises(gt.InputError, match=r"must be >= 0 and <= 2"):
        replace(softer, modal_damping=None, shafts=[replace(softer.shafts[0], loss_factor=3.0), *softer.shafts[1:]])
