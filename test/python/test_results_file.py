"""The file that the executable writes, as h5py and xarray see it."""

import os
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest
import xarray

PAIR = """
&train
   title = 'Zahnräder, ein Paar'
   input_torque = 0.4, prime_mover_inertia = 0.0, load_inertia = 0.0
   characteristic_length = 1.0, characteristic_frequency = 1.0
/
&shaft rigid = .true. /
&mesh
   driving_radius = 1.0, driven_radius = 1.0, driving_inertia = 2.0, driven_inertia = 2.0
   stiffness = 1.0, damping_ratio = 0.05, half_backlash = 1.0, stiffness_cos = 0.3
/
&shaft rigid = .true. /
"""
MODES = "&modes /\n"
RESPONSE = "&response from = 0.2, to = 2.6, harmonics = 4 /\n"
INTEGRATION = "&integration from = 0.6, to = 0.8, points = 3, direction = 'both', harmonics = 8, stability = .true. /\n"


def run(executable, folder, analyses, name="pair.h5"):
    case = folder / "pair.nml"
    case.write_text(PAIR + analyses, encoding="utf-8")
    return subprocess.run(
        [executable, case, "--output", folder / name], capture_output=True, text=True, encoding="utf-8", check=False
    )


@pytest.fixture(scope="module")
def path(executable, tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    done = run(executable, folder, MODES + RESPONSE + INTEGRATION)
    assert done.returncode == 0, done.stderr
    assert sorted(file.name for file in folder.iterdir()) == ["pair.h5", "pair.nml"]
    return folder / "pair.h5"


def test_root_tells_what_it_is(path):
    with h5py.File(path) as file:
        assert file.attrs["format_version"] == 3
        assert file.attrs["title"] == "Zahnräder, ein Paar"
        assert "damping_ratio = 0.05" in file.attrs["input"]
        assert "max_points" in file.attrs["input"], "defaults are included"
        assert set(file) == {"modes", "response", "integration"}


def test_the_input_in_the_file_gives_the_same_file_again(path, executable, tmp_path):
    with h5py.File(path) as file:
        (tmp_path / "again.nml").write_text(file.attrs["input"], encoding="utf-8")
    command = [executable, tmp_path / "again.nml", "--output", tmp_path / "again.h5"]
    subprocess.run(command, capture_output=True, check=True)
    with h5py.File(path) as first, h5py.File(tmp_path / "again.h5") as second:
        assert first.attrs["input"].split("&output")[0] == second.attrs["input"].split("&output")[0]
        np.testing.assert_array_equal(first["response/rms"], second["response/rms"])


def test_every_dataset_says_what_it_is(path):
    def look(name, item):
        if isinstance(item, h5py.Dataset):
            assert item.attrs["description"], name
            assert "units" in item.attrs, name
            assert item.is_scale or all(len(dimension) == 1 for dimension in item.dims), name

    with h5py.File(path) as file:
        file.visititems(look)


def test_shapes_of_the_response(path):
    with h5py.File(path) as file:
        group = file["response"]
        points = len(group["frequency"])
        assert points > 50
        loads = ("mesh_force_maximum", "dynamic_factor", "separation_fraction", "back_contact_fraction")
        for name in ("rms", "true_ac_rms", "mean", "minimum", "maximum", *loads):
            assert group[name].shape == (points, 1), name
        assert group["coefficients"].shape == (points, 1, 9)
        assert group["multipliers"].shape == (points, 2, 2)
        for name in ("stable", "error_estimate", "estimate_doubtful", "harmonics", "segment"):
            assert group[name].shape == (points,), name
        assert group.attrs["harmonics"] == 4
        assert group.attrs["subharmonic"] == 1
        assert group.attrs["complete"] == 1
        assert group.attrs["closed"] == 0
        assert group.attrs["ended"]


def test_rms_is_that_of_the_coefficients(path):
    with h5py.File(path) as file:
        for group in (file["response"], file["integration"]):
            coefficients = group["coefficients"][...]
            rms = np.sqrt((coefficients[:, :, 1:] ** 2).sum(axis=2))
            # The integration's rms is of the whole motion, not of the harmonics stored.
            np.testing.assert_allclose(rms, group["rms"], rtol=1e-12 if group.name == "/response" else 1e-4)
            np.testing.assert_allclose(coefficients[:, :, 0], group["mean"], rtol=1e-12)
            np.testing.assert_allclose(group["true_ac_rms"] * np.sqrt(2), group["rms"], rtol=1e-14)


def test_xarray_opens_each_group(path):
    response = xarray.open_dataset(path, group="response", engine="h5netcdf")
    assert response.rms.dims == ("point", "mesh")
    assert response.coefficients.dims == ("point", "mesh", "coefficient")
    assert response.multipliers.dims == ("point", "state", "complex")
    assert response.stable.dtype == bool
    assert "frequency" in response.coords
    assert list(response.coefficient.values[:4]) == ["mean", "cos 1", "sin 1", "cos 2"]
    np.testing.assert_array_equal(response.coefficients.sel(coefficient="mean"), response["mean"])
    multipliers = response.multipliers.sel(complex="real") + 1j * response.multipliers.sel(complex="imaginary")
    np.testing.assert_array_equal((abs(multipliers) < 1).all("state"), response.stable)

    integration = xarray.open_dataset(path, group="integration", engine="h5netcdf")
    assert list(integration.direction.values) == ["up"] * 3 + ["down"] * 3
    np.testing.assert_allclose(integration.frequency, [0.6, 0.7, 0.8, 0.8, 0.7, 0.6])
    assert integration.period.dims == ("point",)

    modes = xarray.open_dataset(path, group="modes", engine="h5netcdf")
    assert modes.natural_frequency.shape == (1,)
    assert list(modes.element.values) == ["mesh 1"]

    special = xarray.open_dataset(path, group="response/special_points", engine="h5netcdf")
    assert set(special.kind.values) <= {"fold", "period doubling", "neimark-sacker", "branch point"}
    assert special.rms.dims == ("special_point", "mesh")


def test_attractors_and_branches(executable, tmp_path):
    analyses = "&response from = 1.2, to = 2.6, period_doublings = 1 /\n"
    analyses += "&attractors frequency = 2.1, starts = 8, random_seed = 3 /\n"
    case = tmp_path / "pair.nml"
    case.write_text(PAIR.replace("stiffness_cos = 0.3", "stiffness_cos = 0.6") + analyses, encoding="utf-8")
    done = subprocess.run([executable, case, "--output", tmp_path / "pair.h5"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "pair.h5") as file:
        branches = [name for name in file if name.startswith("branch_")]
        assert branches
        for name in branches:
            places = {"ended_places", "origin_places"}
            assert datasets(file["response"]) == datasets(file[name]) - places, "the same layout"
            assert "separation_ranges" in file[name], "what one reads off each branch"
            np.testing.assert_array_equal(file[name]["minimum"][:] < 1, file[name]["separation_fraction"][:] > 0)
            assert set(file[name].attrs) == {*file["response"].attrs, "origin"}
            assert file[name].attrs["origin"] in " ".join(done.stdout.split())
            assert file[name].attrs["subharmonic"] == 2
        attributes = file["attractors"].attrs
        assert (attributes["starts"], attributes["random_seed"], attributes["complete"]) == (8, 3, 1)
        assert attributes["unsettled"] + sum(file["attractors/share"]) == pytest.approx(1)
    attractors = xarray.open_dataset(tmp_path / "pair.h5", group="attractors", engine="h5netcdf")
    assert attractors.rms.dims == ("motion", "mesh") and attractors.multipliers.dims == ("motion", "state", "complex")
    for name in ("mean", "minimum", "maximum", "dynamic_factor", "separation_fraction", "back_contact_fraction"):
        assert attractors[name].dims == ("motion", "mesh")
    np.testing.assert_allclose(attractors.dynamic_factor * 0.4, attractors.mesh_force_maximum, rtol=1e-12)
    assert attractors.stable.all() and (np.diff(attractors.share) <= 0).all() and (attractors.frequency == 2.1).all()


def datasets(group):
    return {name for name, item in group.items() if isinstance(item, h5py.Dataset)}


def test_a_branch_that_ended_early_is_told(executable, tmp_path):
    analyses = "&response from = 1.2, to = 2.6, period_doublings = 1, max_points = 75 /\n"
    case = tmp_path / "pair.nml"
    case.write_text(PAIR.replace("stiffness_cos = 0.3", "stiffness_cos = 0.6") + analyses, encoding="utf-8")
    done = subprocess.run([executable, case, "--output", tmp_path / "pair.h5"], capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert "branch 2, period doubling of the response at" in done.stderr and "max_points = 75 reached" in done.stderr


def test_what_one_reads_off_the_branch(path):
    """The summary against the points that it is made of."""
    response = xarray.open_dataset(path, group="response", engine="h5netcdf")
    np.testing.assert_allclose(response.dynamic_factor * 0.4, response.mesh_force_maximum, rtol=1e-12)
    np.testing.assert_array_equal(response.minimum < 1, response.separation_fraction > 0)

    peaks = xarray.open_dataset(path, group="response/peaks", engine="h5netcdf")
    above = peaks.rms - response.rms.values[peaks.point - 1, peaks["mesh"] - 1]
    assert (above >= 0).all() and (above < 1e-3).all()
    np.testing.assert_array_equal(peaks.stable, response.stable.values[peaks.point - 1])

    jumps = xarray.open_dataset(path, group="response/jumps", engine="h5netcdf")
    assert jumps.rms_before.dims == jumps.rms_after.dims == ("jump", "mesh")
    assert set(jumps.kind.values) <= {"jump up", "jump down", "leaves"}
    assert ("jump up", "rising") in zip(jumps.kind.values, jumps.direction.values)
    up = (jumps.rms_after > jumps.rms_before).all("mesh")
    np.testing.assert_array_equal(up, jumps.kind == "jump up")

    ranges = xarray.open_dataset(path, group="response/separation_ranges", engine="h5netcdf")
    every = ranges.where(~ranges.stable, drop=True)
    apart = response.frequency[(response.minimum < 1).any("mesh")]
    assert all(((every["from"] <= f) & (f <= every["to"])).any() for f in apart)

    bands = xarray.open_dataset(path, group="response/bands_without_stability", engine="h5netcdf")
    inside = (response.frequency > float(bands["from"][0])) & (response.frequency < float(bands["to"][0]))
    assert not response.stable[inside].any()

    integration = xarray.open_dataset(path, group="integration", engine="h5netcdf")
    assert integration.dynamic_factor.dims == ("point", "mesh")
    assert (integration.dynamic_factor >= 1).all()


def test_only_what_was_asked_for_is_written(executable, tmp_path):
    done = run(executable, tmp_path, "&response from = 0.3, to = 0.4, stability = .false. /\n")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "pair.h5") as file:
        assert set(file) == {"response"}
        assert not {"stable", "multipliers", "state", "complex"} & set(file["response"])


def test_what_ended_early_is_written_and_told(executable, tmp_path):
    done = run(executable, tmp_path, "&response from = 0.2, to = 2.6, max_points = 10 /\n")
    assert done.returncode == 3
    with h5py.File(tmp_path / "pair.h5") as file:
        assert file["response"].attrs["complete"] == 0
        assert file["response"].attrs["ended"] in done.stderr
        assert len(file["response/frequency"]) >= 10


@pytest.mark.parametrize(("name", "reason"), [("missing/pair.h5", "there is no folder"), (".", "it is a folder")])
def test_a_place_that_cannot_be_written_to_is_told(executable, tmp_path, name, reason):
    done = run(executable, tmp_path, RESPONSE, name)
    assert done.returncode == 4
    assert reason in done.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["pair.nml"]


@pytest.mark.skipif(os.name != "posix", reason="kills with a signal")
def _has_integration(partial):
    """Whether the checkpoint is one that the sweep has written: the one before it holds the response alone."""
    if not partial.exists():
        return False
    with h5py.File(partial) as file:
        return "integration/frequency" in file


def test_a_killed_run_leaves_a_readable_file(executable, tmp_path):
    case = tmp_path / "long.nml"
    case.write_text(PAIR + RESPONSE + "&integration from = 0.2, to = 2.6, points = 100000 /\n", encoding="utf-8")
    partial = tmp_path / "long.h5.partial"
    work = subprocess.Popen(
        [executable, case, "--output", tmp_path / "long.h5"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        limit = time.monotonic() + 60
        while not _has_integration(partial) and time.monotonic() < limit:
            time.sleep(0.1)
        assert work.poll() is None
    finally:
        work.send_signal(signal.SIGKILL)
        work.wait()
    with h5py.File(partial) as file:
        assert file["response"].attrs["complete"] == 1
        assert file["integration"].attrs["complete"] == 0
        assert len(file["integration/frequency"]) > 0
        assert np.isfinite(file["integration/rms"]).all()
