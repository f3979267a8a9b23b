"""Case files: the same numbers as the executable's."""

import pickle
import subprocess

import h5py
import numpy as np
import pytest
from conftest import ROOT

import geartrain as gt

CASE = ROOT / "namelists" / "fig03.nml"


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """Figure 3 with fewer points of integration."""
    path = tmp_path_factory.mktemp("case") / "fig03.nml"
    path.write_text(CASE.read_text().replace("points = 121", "points = 7"))
    return path


@pytest.fixture(scope="module")
def results(case):
    return gt.read_case(case).run()


def test_reading(case):
    read = gt.read_case(case)
    assert read.modes and read.output == "fig03.h5"
    assert read.response["start"] == 0.2 and read.integration["points"] == 7
    assert read.train.meshes[1].stiffness == 5e8 and read.train.meshes[1].stiffness_cos == (0.3,)


def test_calls_equal_the_run(case, results):
    read = gt.read_case(case)
    branch = read.train.response(**read.response)
    sweep = read.train.sweep(**read.integration)
    np.testing.assert_array_equal(branch.coefficients, results.response.coefficients)
    np.testing.assert_array_equal(sweep.rms, results.integration.rms)
    np.testing.assert_array_equal(read.train.modes().shape, results.modes.shape)
    assert results.ended == ""


def test_run_equals_the_executable(executable, case, results, tmp_path):
    path = tmp_path / "out.h5"
    subprocess.run([executable, case, "--output", path], check=True, capture_output=True)
    with h5py.File(path) as file:
        for name in ("frequency", "rms", "mean", "minimum", "maximum", "stable", "coefficients"):
            np.testing.assert_array_equal(getattr(results.response, name), file["response"][name][()], err_msg=name)
        for name in ("frequency", "rms"):
            np.testing.assert_array_equal(getattr(results.integration, name), file["integration"][name][()])
    results.write(tmp_path / "python.h5")
    assert_equal_files(path, tmp_path / "python.h5")
    pickle.loads(pickle.dumps(results)).write(tmp_path / "python.h5")
    assert_equal_files(path, tmp_path / "python.h5")


def assert_equal_files(one, other):
    with h5py.File(one) as first, h5py.File(other) as second:
        names = []
        first.visit(names.append)
        others = []
        second.visit(others.append)
        assert names == others and names
        assert first.attrs["input"] == second.attrs["input"]
        for name in names:
            assert set(first[name].attrs) == set(second[name].attrs)
            if isinstance(first[name], h5py.Dataset):
                np.testing.assert_array_equal(first[name][()], second[name][()], err_msg=name)


def test_place_that_cannot_be_written(results):
    with pytest.raises(OSError, match="nowhere"):
        results.write("nowhere/at/all.h5")
