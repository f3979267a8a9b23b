"""Stability maps and refined branches: the same from Python, from the executable and from its file."""

import os
import pickle
import subprocess

import h5py
import matplotlib as mpl
import numpy as np
import pytest
import xarray
from conftest import ROOT

import geartrain as gt

mpl.use("Agg")

RANGE = {"start": 0.4, "stop": 2.2, "points": 10, "parameter_start": 0.1, "parameter_stop": 0.3, "parameter_points": 3}


@pytest.fixture(scope="module")
def chart(train):
    return train.stability_map(**RANGE)


def test_shapes_and_what_they_say(train, chart):
    assert chart.motions.shape == chart.stable_motions.shape == chart.multiplier.shape == (3, 10)
    assert chart.rms.shape == (3, 10, 2)
    assert chart.complete and chart.row_done.all() and chart.row_whole.all()
    assert ((chart.spectral_radius < 1) == (chart.stable_motions > 0)).all()
    # The last row is figure 3's train: the solutions of its response at the same Lambda.
    branch = train.response(start=0.4, stop=2.2)
    for k, frequency in enumerate(chart.frequency):
        motions = branch.at(frequency)
        assert len(motions) == chart.motions[-1, k]
        assert sum(motion.stable for motion in motions) == chart.stable_motions[-1, k]
        radius = min(abs(motion.multipliers).max() for motion in motions)
        assert chart.spectral_radius[-1, k] == pytest.approx(radius, abs=1e-6)
    assert pickle.loads(pickle.dumps(chart)).ended == chart.ended


def test_a_linear_map_has_no_rms(train):
    chart = train.stability_map(**RANGE, linear=True)
    assert chart.rms is None and (chart.motions == 1).all()


@pytest.mark.parametrize("what", ["spectral_radius", "stable_motions", "motions"])
def test_plot(chart, what):
    ax = chart.plot(what)
    assert "kappa" in ax.get_ylabel() and "Lambda" in ax.get_xlabel()
    mpl.pyplot.close(ax.figure)


def test_a_map_says_what_it_shows(train, chart):
    """A map of stable motions alone is no white picture, and each tells what its grid cannot show."""
    step = np.diff(chart.frequency).max()
    ax = chart.plot()
    title = ax.get_title().replace(";\n", "; ")
    assert title == f"stable in part of the map; ranges narrower than {step:.4g} Lambda, the step, may be missed"
    assert ax.collections[0].get_clim()[1] - 1 == pytest.approx(min(0.5, abs(chart.spectral_radius - 1).max()))
    mpl.pyplot.close(ax.figure)
    calm = train.stability_map(**{**RANGE, "parameter_start": 1e-4, "parameter_stop": 2e-4}, linear=True)
    ax = calm.plot()
    largest = calm.spectral_radius.max()
    assert largest < 1 and ax.get_title().startswith(f"stable everywhere: |multiplier| at most {largest:.4g};")
    low, high = ax.collections[0].get_clim()
    far = abs(calm.spectral_radius - 1).max()
    assert (low, high) == pytest.approx((1 - min(0.5, far), 1 + min(0.5, far)))
    mpl.pyplot.close(ax.figure)


def test_plot_knows_what_it_can_draw(chart):
    with pytest.raises(gt.InputError, match="what = 'rms': must be"):
        chart.plot("rms")


def test_bad_input_has_the_words_of_the_case_file(train):
    with pytest.raises(gt.InputError, match=r"&stability_map: parameter_points = 2: must be 1 where"):
        train.stability_map(start=1.0, stop=2.0, parameter_start=0.1, parameter_stop=0.1, parameter_points=2)
    with pytest.raises(gt.InputError, match=r"parameter = 'kappa': .*no variable of &train"):
        train.stability_map(start=1.0, stop=2.0, parameter_start=0.1, parameter_stop=0.2, parameter="kappa")


def test_case_file_executable_and_python_agree(executable, tmp_path, train, chart):
    names = {"start": "from", "stop": "to", "parameter_start": "parameter_from", "parameter_stop": "parameter_to"}
    group = "&stability_map " + ", ".join(f"{names.get(name, name)} = {value}" for name, value in RANGE.items()) + " /\n"
    case = tmp_path / "map.nml"
    case.write_text(train.namelist() + group)
    for threads in ("1", "3"):
        command = [executable, case, "--output", tmp_path / f"{threads}.h5"]
        done = subprocess.run(
            command, check=True, capture_output=True, text=True, env={**os.environ, "OMP_NUM_THREADS": threads}
        )
        assert "Stability map: 3 values of stiffness_variation with 10 frequencies each" in done.stdout
    results = gt.read_case(case).run()
    results.write(tmp_path / "python.h5")
    with h5py.File(tmp_path / "1.h5") as one, h5py.File(tmp_path / "3.h5") as three, h5py.File(tmp_path / "python.h5") as mine:
        for name in one["stability_map"]:
            values = one["stability_map"][name][()]
            if values.dtype.kind == "O":
                continue
            assert three["stability_map"][name][()].tobytes() == values.tobytes(), name
            assert mine["stability_map"][name][()].tobytes() == values.tobytes(), name
    assert (results.stability_map.multiplier == chart.multiplier).all()
    data = xarray.open_dataset(tmp_path / "1.h5", group="stability_map")
    assert data.spectral_radius.dims == ("parameter", "frequency") and data.rms.dims == ("parameter", "frequency", "mesh")
    assert data.parameter.values == pytest.approx([0.1, 0.2, 0.3])
    assert np.isfinite(data.spectral_radius.sel(parameter=0.3, frequency=0.6, method="nearest"))


@pytest.mark.parametrize("name", ["map_linear", "map_nonlinear"])
def test_the_namelists_are_in_order(name):
    assert gt.read_case(ROOT / "namelists" / f"{name}.nml").stability_map["points"] == 200


def test_refined_branch_in_python_and_in_the_file(executable, tmp_path, train):
    settings = {"start": 0.4, "stop": 0.9}
    branch = train.response(**settings)
    refined = branch.refine()
    at_once = train.response(**settings, refine=True)
    assert branch.correction is None
    for name in ("rms", "multipliers", "coefficients", "correction", "error_estimate"):
        np.testing.assert_array_equal(getattr(refined, name), getattr(at_once, name))
    done = ~np.isnan(refined.correction)
    assert np.average(done, weights=np.gradient(branch.others["arclength"])) > 0.95 and refined.error_estimate[done].max() < 2e-11
    assert (refined.rms[~done] == branch.rms[~done]).all()
    # A point, and a motion of the branch, are what shooting makes of the motion at that Lambda.
    for motion in (refined.at(0.9)[0], branch.at(0.9)[0].refine()):
        np.testing.assert_allclose(motion.rms, refined.rms[-1], rtol=1e-9)
    assert len(refined.at(0.6)) == len(branch.at(0.6)) == 3
    case = tmp_path / "refined.nml"
    case.write_text(train.namelist(response={**settings, "refine": True}))
    subprocess.run([executable, case, "--output", tmp_path / "r.h5"], check=True, capture_output=True)
    gt.read_case(case).run().write(tmp_path / "python.h5")
    with h5py.File(tmp_path / "r.h5") as file, h5py.File(tmp_path / "python.h5") as mine:
        for name in ("rms", "multipliers", "correction"):
            np.testing.assert_array_equal(file["response"][name][()], mine["response"][name][()])
        np.testing.assert_array_equal(file["response/correction"][()], refined.correction)
