"""Results read back from their file, and as Datasets: the same as they were, whoever wrote them."""

import pickle
import subprocess

import h5py
import numpy as np
import pytest
import xarray
from conftest import ROOT, assert_equal_files, run, write_case
from test_faults import kill_at_checkpoint

import geartrain as gt

ANALYSES = (
    "&modes /\n&response from = 1.6, to = 3.6, period_doublings = 1, branch_points = .true. /\n"
    "&integration from = 0.5, to = 0.7, points = 3, direction = 'both' /\n"
    "&attractors frequency = 2.4, starts = 8, follow = .true. /\n"
    "&stability_map from = 0.4, to = 1.6, points = 5, parameter_from = 0.01, parameter_to = 0.1, parameter_points = 3 /\n"
    "&run_up from = 0.4, to = 0.9, duration = 0.1 /\n"
)


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    path = tmp_path_factory.mktemp("reading") / "case.nml"
    path.write_text((ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0] + ANALYSES)
    return path


@pytest.fixture(scope="module")
def path(executable, case):
    output = case.with_suffix(".h5")
    assert subprocess.run([executable, case, "--output", output], capture_output=True, check=False).returncode in (0, 3)
    return output


@pytest.fixture(scope="module")
def results(path):
    return gt.read_results(path)


def same(one, other):
    """Whether two results have the same values, whatever they are made of."""
    if isinstance(one, np.ndarray) and one.dtype.kind in "fc":
        return one.shape == other.shape and np.array_equal(one, other, equal_nan=True)
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(value, other[name]) for name, value in one.items())
    if isinstance(one, float):
        return one == other or (np.isnan(one) and np.isnan(other))
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(same, one, other)) and same_attributes(one, other)
    if type(one).__module__.startswith("geartrain"):
        return same_attributes(one, other)
    return one == other


def same_attributes(one, other):
    if not hasattr(one, "__dict__"):
        return True
    skipped = {"_kept", "branch", "settings", "text", "train", "ended" if isinstance(one, gt.Results) else ""}
    return all(same(value, vars(other)[name]) for name, value in vars(one).items() if name not in skipped)


def test_all_is_there_again(case, results):
    computed = gt.read_case(case).run()
    assert same(computed, results)
    assert results.response.branches and results.attractors.branches, "further branches belong to what they come from"
    assert results.text == computed.text


def test_results_read_are_results(case, results):
    train, response = gt.read_case(case).train, results.response
    fresh = train.response(**{name: value for name, value in response.settings.items() if name != "period_doublings"})
    assert same(response.at(1.7), fresh.at(1.7)) and same(response.jumps, fresh.jumps)
    assert response.plot() is not None and results.stability_map.plot() is not None
    assert results.integration[0].refine().rms == pytest.approx(results.integration[0].rms, abs=1e-7)
    doubling = next(special for special in response.special_points if special.kind == "period doubling")
    assert response.period_doubled(doubling).subharmonic == 2


def test_written_again_it_is_the_same_file(path, results, tmp_path):
    results.write(tmp_path / "again.h5")
    assert_equal_files(path, tmp_path / "again.h5")


def test_a_branch_is_written_and_read(branch, tmp_path):
    branch.write(tmp_path / "branch.h5")
    again = gt.read_results(tmp_path / "branch.h5")
    assert again.integration is None and same(again.response, branch)


def test_datasets_are_those_of_the_file(path, results):
    groups = {
        "modes": results.modes, "response": results.response, "branch_1": results.branches[0],
        "integration": results.integration, "attractors": results.attractors, "stability_map": results.stability_map,
        "run_up": results.run_up,
    }
    for name, result in groups.items():
        stored = xarray.open_dataset(path, group=name, engine="h5netcdf")
        stored = stored.drop_vars({"ended_places", "origin_places"} & set(stored.variables))  # of sentences, for reading back
        found = result.to_dataset()
        radius = {"spectral_radius"} & set(stored)  # whose last bit is that of Fortran's or of numpy's hypotenuse
        xarray.testing.assert_equal(found.drop_vars(radius), stored.drop_vars(radius))
        xarray.testing.assert_allclose(found[radius], stored[radius], rtol=1e-15)
        for variable in stored.variables:
            for attribute in ("units", "description"):
                told = found[variable].attrs[attribute]
                assert told == stored[variable].attrs[attribute] or "number of the multiplier" in told, (name, variable)
    assert results.integration[0].to_dataset().rms.dims == ("mesh",)


TWO_PAIRS = """
&train characteristic_length = 1.0, characteristic_frequency = 1.0 /
&body name = 'Ritzel',  inertia = 2.0, torque = 0.8 /
&body name = 'Großrad', inertia = 2.0 /
&body name = 'Last',    inertia = 3.0, balances = .true. /
&shaft between = 'Großrad', 'Last', stiffness = 0.5, damping_ratio = 0.05 /
&mesh between = 'Ritzel', 'Großrad', driving_radius = 1.0, driven_radius = 1.0, stiffness = 1.0,
      damping_ratio = 0.05, half_backlash = 1.0, stiffness_cos = 0.6 /
&mesh between = 'Ritzel', 'Großrad', driving_radius = 1.0, driven_radius = 1.0, stiffness = 1.0,
      damping_ratio = 0.05, half_backlash = 1.0, stiffness_cos = 0.6 /
"""
OF_TWO_PAIRS = ["Ritzel - Großrad", "Ritzel - Großrad (2)"]


def test_meshes_are_named_by_their_bodies(executable, tmp_path):
    """In every group and picture; beside their numbers, two between the same bodies apart."""
    (tmp_path / "case.nml").write_text(TWO_PAIRS + (
        "&modes /\n&response from = 0.6, to = 4.2, harmonics = 4, period_doublings = 1 /\n"
        "&integration from = 0.5, to = 0.6, points = 2 /\n&attractors frequency = 0.9, starts = 4 /\n"
        "&stability_map from = 0.4, to = 0.6, points = 2, parameter_from = 0.1, parameter_to = 0.2, parameter_points = 2 /\n"
        "&run_up from = 0.4, to = 0.6, duration = 200.0 /\n"
    ), encoding="utf-8")
    done = run(executable, tmp_path / "case.nml", "--output", tmp_path / "case.h5", encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr
    for number, name in enumerate(OF_TWO_PAIRS, 1):
        assert f"mesh {number} ({name}), N " in done.stdout
    # Their figures are equal, and share a sentence.
    assert f"Meshes 1 ({OF_TWO_PAIRS[0]}), 2 ({OF_TWO_PAIRS[1]}): largest force " in done.stdout
    results = gt.read_results(tmp_path / "case.h5")
    groups = {name: getattr(results, name) for name in ("response", "integration", "attractors", "stability_map")}
    for name, result in {**groups, "branch_1": results.response.branches[0]}.items():
        for opened in (xarray.open_dataset(tmp_path / "case.h5", group=name, engine="h5netcdf"), result.to_dataset()):
            assert list(opened.coords["mesh_label"].values) == OF_TWO_PAIRS and opened.mesh_label.dims == ("mesh",), name
            by_name = opened.swap_dims(mesh="mesh_label").rms.sel(mesh_label=OF_TWO_PAIRS[1])
            np.testing.assert_array_equal(by_name, opened.rms.sel(mesh=2))
    assert results.run_up.mesh_label == tuple(OF_TWO_PAIRS) and results.run_up.shaft_label == ("Großrad - Last",)
    assert "shaft 1 (Großrad - Last), N m " in done.stdout
    motion = results.integration[0]
    assert list(motion.to_dataset().mesh_label.values) == list(motion.train.mesh_labels) == OF_TWO_PAIRS
    for ax in (results.response.plot(), motion.plot()[0]):
        assert [text.get_text() for text in ax.get_legend().get_texts()][:len(OF_TWO_PAIRS)] == OF_TWO_PAIRS
    modes = xarray.open_dataset(tmp_path / "case.h5", group="modes", engine="h5netcdf")
    for opened in (modes, results.modes.to_dataset()):
        assert list(opened.element.values) == ["shaft 1", "mesh 1", "mesh 2"]
        assert list(opened.coords["element_label"].values) == ["Großrad - Last", *OF_TWO_PAIRS]
    results.write(tmp_path / "again.h5")
    assert_equal_files(tmp_path / "case.h5", tmp_path / "again.h5")


def test_meshes_of_a_chain_are_named_by_their_numbers(path, results):
    with h5py.File(path) as file:
        for name in ("response", "branch_1", "integration", "attractors", "stability_map"):
            label = file[name]["mesh_label"]
            assert list(label.asstr()) == ["mesh 1", "mesh 2"] and label.dims[0][0] == file[name]["mesh"], name
        assert list(file["modes/element_label"]) == list(file["modes/element"])
    assert results.response.train.mesh_labels == ("mesh 1", "mesh 2")
    assert [text.get_text() for text in results.response.plot().get_legend().get_texts()][:2] == ["mesh 1", "mesh 2"]


def test_a_motion_that_ran_away(tmp_path):
    """It has a state and nothing else, in the file and read back."""
    text = (ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0]
    for old, new in (("stiffness_cos   = 0.3", "stiffness_cos   = 1.9"), ("half_backlash   = 30.0e-6", "half_backlash   = 0.0")):
        text = text.replace(old, new)
    case = tmp_path / "case.nml"
    case.write_text(text + "&integration from = 1.85, to = 1.9, points = 2, stability = .false. /\n")
    computed = gt.read_case(case).run()
    assert any(motion.unbounded for motion in computed.integration)
    computed.write(tmp_path / "out.h5")
    assert same(computed.integration, gt.read_results(tmp_path / "out.h5").integration)


def test_a_run_under_way_can_be_read(executable, tmp_path):
    case = write_case(tmp_path, "&response from = 0.2, to = 2.6, step = 0.0001, max_points = 100000 /\n")
    partial = kill_at_checkpoint(executable, case, tmp_path / "out.h5")
    results = gt.read_results(partial)
    assert len(results.response) > 0 and "response ended early: not yet" in results.ended
    assert all(motion.stable is not None for motion in results.response.at(float(results.response.frequency[1])))


def test_what_is_no_results_file_is_told(path, tmp_path):
    content = path.read_bytes()
    other = tmp_path / "other.h5"
    for damaged in (b"", b"no HDF5", content[:-1], content[:5000] + bytes([content[5000] ^ 1]) + content[5001:]):
        other.write_bytes(damaged)
        with pytest.raises(OSError, match="cannot be read as results: its checksum does not fit"):
            gt.read_results(other)
    with pytest.raises(OSError, match="cannot be read as results: there is no such file"):
        gt.read_results(tmp_path / "nowhere.h5")
    case = write_case(tmp_path, "&modes /\n")
    with pytest.raises(OSError, match="it is a case: run it first, geartrain "):
        gt.read_results(case)
    with h5py.File(other, "w") as file:
        file.attrs["format_version"] = 1
    with pytest.raises(OSError, match=r"an earlier version \(format 1: run its case again\)"):
        gt.read_results(other)


def test_a_branch_pickles_without_what_it_keeps(branch):
    branch.at(0.9)
    again = pickle.loads(pickle.dumps(branch))
    assert same(again.at(0.9), branch.at(0.9))


def test_a_train_without_shafts_is_read(tmp_path):
    """Its lists of shafts have length 0."""
    bodies = [gt.Body(name="motor", inertia=1e-3, torque=10.0), gt.Body(name="load", inertia=1e-2, balances=True)]
    mesh = gt.Mesh(between=("motor", "load"), driving_radius=0.03, driven_radius=0.05, stiffness=2e8, damping_ratio=0.05,
                   half_backlash=30e-6, stiffness_cos=[0.2])
    train = gt.Train(bodies=bodies, meshes=[mesh], characteristic_length=30e-6, characteristic_frequency=1e4)
    branch = train.response(start=0.5, stop=0.6)
    branch.write(tmp_path / "pair.h5")
    found = gt.read_results(tmp_path / "pair.h5").response
    np.testing.assert_array_equal(found.rms, branch.rms)
    assert found.shaft_torque_mean is None or found.shaft_torque_mean.shape[1] == 0
