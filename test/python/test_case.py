"""Case files: the same numbers as the executable's."""

import pickle
import subprocess

import h5py
import numpy as np
import pytest
from conftest import ROOT, assert_equal_files

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


def test_results_in_short(results):
    title, *told = repr(results).splitlines()
    assert title == "<Results of 'Al-shyyab and Kahraman 2007, figure 3'"
    assert told[0].strip() == "modes: 5 modes"
    assert told[1].strip().startswith(f"response: Branch of {len(results.response)} points: ") and "(Lambda 0.2 to 2.6)" in told[1]
    assert "integration: Sweep of" in told[2] and len(told) == 3 + bool(results.branches)


@pytest.fixture(scope="module")
def islands():
    return gt.read_case(ROOT / "namelists" / "fig13.nml").run()


def test_island_of_figure_13(islands):
    """Stable period 3 at 2.4 beside period 1: rms of time integration from another code's hands, docs/paper.md."""
    assert islands.ended == "" and islands.response.branches == []
    assert [motion.period for motion in islands.attractors] == [1, 3]
    np.testing.assert_allclose(islands.attractors[1].rms, [0.2427, 0.9228], atol=5e-5)
    assert islands.attractors[1].share == pytest.approx(0.185, abs=0.05)
    (island,) = islands.branches
    assert island.closed and island.subharmonic == 3 and islands.attractors.branches == [island]
    refined = [motion.refine() for motion in island.at(2.4) if motion.stable]
    np.testing.assert_allclose(refined[0].rms, islands.attractors[1].rms, atol=1e-7)


def test_calls_equal_the_run_of_figure_13(islands):
    case = gt.read_case(ROOT / "namelists" / "fig13.nml")
    response = case.train.response(**case.response)
    found = case.train.attractors(**{**case.attractors, "follow": response})
    np.testing.assert_array_equal(found.branches[0].coefficients, islands.branches[0].coefficients)
    assert [motion.share for motion in found] == [motion.share for motion in islands.attractors]


def test_run_of_figure_13_equals_the_executable(executable, islands, tmp_path):
    path = tmp_path / "out.h5"
    done = subprocess.run(
        [executable, ROOT / "namelists" / "fig13.nml", "--output", path], check=True, capture_output=True, text=True
    )
    assert "Branch 1, period 3: attractor 2 at Lambda = 2.4" in done.stdout and "did not settle" in done.stdout
    pickle.loads(pickle.dumps(islands)).write(tmp_path / "python.h5")
    assert_equal_files(path, tmp_path / "python.h5")


def test_period_two_of_figure_12():
    """One branch from each doubling near 2 w_a, a single one for both near 2 w_b, and one with back collisions of mesh 1."""
    results = gt.read_case(ROOT / "namelists" / "fig12.nml").run()
    assert results.ended == "" and [branch.subharmonic for branch in results.branches] == [2, 2, 2, 2]
    assert results.branches[:3] == results.response.branches
    assert results.branches[3:] == results.attractors.branches
    for branch in [results.response, *results.branches]:  # the last one has a part traced backwards from its seed
        for special in branch.special_points:
            if special.kind != "fold":
                low, high = sorted(branch.frequency[special.point : special.point + 2])
                assert low <= special.frequency <= high, (branch.origin, special)
    assert any(special.kind != "fold" for special in results.branches[3].special_points)
    # Found independently by time integration: period 2 at 1.92, 0.45639898 and 0.54946446.
    stable = [motion for branch in results.branches for motion in branch.at(1.92) if motion.stable]
    assert any(np.allclose(motion.refine().rms, [0.45639898, 0.54946446], atol=2e-8) for motion in stable)
    for frequency in (1.76, 1.85, 1.95, 2.03, 3.52, 3.7, 3.9):  # throughout the ranges without stable period-1 motion
        assert not any(motion.stable for motion in results.response.at(frequency))
        assert any(motion.stable for branch in results.branches for motion in branch.at(frequency))


def test_place_that_cannot_be_written(results):
    with pytest.raises(OSError, match="nowhere"):
        results.write("nowhere/at/all.h5")
