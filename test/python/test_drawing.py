"""Trains as a drawing gives them: what is derived is told, and speeds are in rpm and Hz."""

import copy
import pickle
import warnings
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from conftest import REDUCER, ROOT, paper_train, reducer, run

import geartrain as gt


@pytest.fixture(scope="module")
def drawn():
    return reducer()


def test_explain_is_a_mapping_of_numbers(drawn):
    explained = drawn.explain()
    bodies = ["motor", "pinion 1", "wheel 1", "pinion 2", "wheel 2", "load"]
    assert list(explained) == ["train", *bodies, "shaft 1", "shaft 2", "shaft 3", "mesh 1", "mesh 2"]
    assert explained["shaft 1"]["stiffness"] == pytest.approx(np.pi * 8e10 * 0.03**4 / (32 * 0.15))
    beta = np.radians(15)
    transverse = np.arctan(np.tan(np.radians(20)) / np.cos(beta))
    radius = np.array([23, 71]) * 2.5e-3 / np.cos(beta) * np.cos(transverse) / 2
    np.testing.assert_allclose(explained["mesh 1"]["base_radius"], radius)
    assert explained["mesh 1"]["overlap_ratio"] == pytest.approx(0.04 * np.sin(beta) / (np.pi * 2.5e-3))
    assert explained["mesh 1"]["half_backlash"] == pytest.approx(30e-6 * np.cos(transverse))
    pitch = 19 * 4e-3 / np.cos(beta)
    assert explained["pinion 2"]["inertia"] == pytest.approx(np.pi * 7850 * 0.07 * pitch**4 / 32)
    assert explained["train"]["speed_ratio"] == pytest.approx(71 / 23)
    assert (explained["mesh 1"]["order"], explained["mesh 2"]["order"]) == (71, 19)
    assert explained["train"]["fundamental"] == "one turn of wheel 1"
    assert explained.unit["mesh 1"]["base_radius"] == "m" and "ISO 21771" in explained.about["mesh 1"]["base_radius"]
    assert explained.about["motor"]["inertia"] == "as given" and "discs" not in explained.about["motor"]["inertia"]


def test_a_mesh_whose_second_gear_drives_is_told(drawn):
    first, second = drawn.meshes
    turned = replace(first, between=first.between[::-1], teeth=first.teeth[::-1])
    explained = replace(drawn, meshes=[turned, second]).explain()
    assert explained["mesh 1"]["mean_force"] == pytest.approx(-drawn.explain()["mesh 1"]["mean_force"])
    assert "negative: the second body drives the first" in explained.about["mesh 1"]["mean_force"]
    assert "negative" not in explained.about["mesh 2"]["mean_force"]


def test_a_speed_outside_the_range_of_a_branch_is_told(drawn):
    branch = drawn.response(start=1450, stop=1460, unit="rpm", harmonics=0, tolerance=1e-2, stability=False)
    assert len(branch.at(1455, unit="rpm")) == 1 and "reached 1460 rpm" in repr(branch)
    with pytest.warns(UserWarning, match="^1461 rpm: outside the range of the branch, 1450 to 1460$"):
        assert branch.at(1461, unit="rpm") == []
    # No step is wider than a hundredth of the range.
    assert np.abs(np.diff(branch.frequency)).max() < 0.1 * 1.1


def test_why_a_run_up_ended_is_told_in_rpm_also_once_kept(drawn, tmp_path):
    case = tmp_path / "case.nml"
    case.write_text(drawn.namelist(run_up={"start": 1450, "stop": 1460, "duration": 0.02}), encoding="utf-8")
    results = gt.read_case(case).run()
    results.write(tmp_path / "case.h5")
    for found in (results.run_up, pickle.loads(pickle.dumps(results)).run_up, gt.read_results(tmp_path / "case.h5").run_up):
        assert found.ended.startswith("reached Lambda = 1460") and "reached 1460 rpm" in repr(found)


def test_explanation_cannot_be_changed_and_is_plain_python(drawn):
    explained = drawn.explain()
    with pytest.raises(TypeError):
        explained["motor"]["inertia"] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        explained["mesh 1"]["base_radius"][0] = 1.0
    same = pickle.loads(pickle.dumps(explained))
    assert str(same) == str(explained) == repr(copy.deepcopy(explained))
    assert same["mesh 2"]["contact_ratio"] == explained["mesh 2"]["contact_ratio"]


def test_explanation_is_that_of_the_executable(drawn, executable, tmp_path):
    (tmp_path / "case.nml").write_text(drawn.namelist())
    done = run(executable, "--explain", tmp_path / "case.nml")
    assert done.returncode == 0 and str(drawn.explain()) in done.stdout


def test_a_scalar_is_a_list_of_one(drawn):
    shafts = [gt.Shaft(between=shaft.between, diameter=shaft.diameter[0], length=shaft.length[0]) for shaft in drawn.shafts]
    assert reducer(shafts=shafts).explain()["shaft 1"]["stiffness"] == drawn.explain()["shaft 1"]["stiffness"]


def test_a_formula_outside_its_range_is_warned_of(drawn):
    assert drawn.warnings == ()
    text = "&mesh 1: the gear of 15 teeth is undercut"
    with pytest.warns(gt.DrawingWarning, match=text) as told:
        train = reducer(teeth=(15, 71))
    assert len(told) == len(train.warnings) == 1 and train.warnings[0] == str(told[0].message)
    assert told[0].filename.endswith("conftest.py") and f"Warning: {train.warnings[0]}" in str(train.explain())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        paper_train()
        reducer()
    rattle = ROOT / "namelists" / "rattle.nml"
    with pytest.warns(gt.DrawingWarning, match="far below the loads for which ISO 6336-1 holds.*stiffness") as told:
        found = gt.read_case(rattle).train
        replace(found, title="another")
        copy.deepcopy(found)
        gt.read_case(rattle)
    assert {Path(warning.filename).name for warning in told} == {Path(__file__).name}


def test_a_frequency_may_be_asked_for_in_rpm_and_hertz(drawn):
    """Of a train whose Lambda is the speed, and of one with a characteristic frequency of its own."""
    own = reducer(characteristic_frequency=500.0, characteristic_length=1e-6)
    hertz = 1500.0 / 60 / (71 / 23)
    plain = drawn.integrate(1500.0)
    assert plain.speed == pytest.approx(1500.0, rel=1e-12) and plain.fundamental_frequency == pytest.approx(hertz)
    for motion in (own.integrate(1500.0, unit="rpm"), own.integrate(hertz, unit="Hz"), drawn.integrate(hertz, unit="Hz")):
        assert motion.speed == pytest.approx(1500.0) and motion.fundamental_frequency == pytest.approx(hertz)
        np.testing.assert_allclose(motion.rms, plain.rms, rtol=1e-6)
    assert own.integrate(1500.0, unit="rpm").frequency == pytest.approx(2 * np.pi * hertz / 500)
    (found,) = own.attractors(1500.0, unit="rpm", starts=2)
    assert found.speed == pytest.approx(1500.0)
    sweep = drawn.sweep(start=1500.0, stop=1520.0, points=2, unit="rpm")
    np.testing.assert_allclose(sweep.speed, [1500.0, 1520.0])
    np.testing.assert_allclose(sweep.to_dataset().speed, sweep.speed)


def test_speeds_of_a_response():
    """As the file tells them, with each point, peak, jump and special point."""
    train = paper_train()
    branch = train.response(start=0.5, stop=0.9)
    assert branch.speed is None and "speed" not in branch.others
    hertz = 9870.0 / (2 * np.pi)
    np.testing.assert_allclose(branch.fundamental_frequency, branch.frequency * hertz)
    for found in (*branch.peaks(2), *branch.jumps, *branch.special_points):
        assert found.speed is None and found.fundamental_frequency == pytest.approx(found.frequency * hertz)
    np.testing.assert_allclose(branch.to_dataset().fundamental_frequency, branch.fundamental_frequency)
    np.testing.assert_array_equal(branch.at(0.6 * hertz, unit="Hz")[0].rms, branch.at(0.6)[0].rms)
    meshes = [gt.Mesh(**{name: getattr(mesh, name) for name in mesh.variables} | {"teeth": (25, 50)}) for mesh in train.meshes]
    toothed = paper_train(meshes=[*meshes[:1], gt.Mesh(**{
        name: getattr(meshes[1], name) for name in meshes[1].variables} | {"teeth": (50, 100)})])
    with_speed = toothed.response(start=0.5, stop=0.9)
    np.testing.assert_array_equal(with_speed.frequency, branch.frequency)
    # A mesh of 25 teeth on the driving end: 25 periods of the fundamental a turn.
    np.testing.assert_allclose(with_speed.speed, 60 * hertz / 25 * branch.frequency)
    for found in (*with_speed.peaks(), *with_speed.jumps, *with_speed.special_points):
        assert found.speed == pytest.approx(found.frequency * 60 * hertz / 25)


@pytest.mark.parametrize("unit", ["rpm", "mph", 3])
def test_a_unit_that_is_not_known_is_told_in_the_words_of_the_executable(branch, train, unit):
    reason = "needs teeth of every mesh, which tell the speed" if unit == "rpm" else "must be"
    respond = partial(train.response, start=0.2, stop=1.0)
    for ask in (partial(branch.at, 0.9), partial(train.integrate, 0.9), respond):
        with pytest.raises(gt.InputError, match=f"unit = .*{reason}"):
            ask(unit=unit)
    for draw in (branch.plot, branch.at(0.9)[0].plot, train.campbell(start=0.2, stop=1.0).plot):
        with pytest.raises(gt.InputError, match=f"^unit = .*{reason}"):
            draw(unit=unit)


def test_the_case_file_gives_the_train(drawn, tmp_path):
    (tmp_path / "case.nml").write_text(drawn.namelist())
    assert gt.read_case(tmp_path / "case.nml").train.explain()["mesh 1"]["stiffness"] == drawn.explain()["mesh 1"]["stiffness"]
    assert REDUCER["speed_of"] == "motor" == drawn.speed_name


def test_natural_frequencies_in_hertz(drawn):
    """Lambda of a train whose characteristic frequency is left out is the speed in rpm."""
    hertz = drawn.natural_frequencies(unit="Hz")
    np.testing.assert_allclose(hertz, drawn.modes().natural_frequency_hertz, rtol=1e-14)
    np.testing.assert_allclose(drawn.natural_frequencies(unit="rpm"), drawn.natural_frequencies(), rtol=1e-14)
    assert f"{hertz[0]:.6g}" in str(drawn.modes()).splitlines()[1]
    with pytest.raises(gt.InputError, match="unit = 'knots'"):
        drawn.natural_frequencies(unit="knots")


def test_a_train_and_its_parts_in_short(drawn):
    assert repr(drawn) == "<Train 'two-stage reducer': 6 bodies, 3 shafts, 2 meshes of order 19, 71>"
    assert repr(gt.Mesh(teeth=(23, 71))) == "Mesh(teeth=(23, 71))"
    with pytest.raises(KeyError, match=r"mesh 3: must be one of train, motor, .*mesh 2"):
        drawn.explain()["mesh 3"]
    assert drawn.explain().get("mesh 3") is None
