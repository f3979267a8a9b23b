"""Examples of studies: sensitivities by other libraries, the tolerance study, the array job, the pages' own lines."""

import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from conftest import ROOT, paper_train
from test_study import computed, pair_study

import geartrain as gt
import sensitivity
import tolerance
from geartrain.studies.study_store import Store

pytestmark = pytest.mark.full


@pytest.mark.parametrize("method", sensitivity.METHODS)
def test_published_indices_of_ishigamis_function(method):
    first, total = sensitivity.METHODS[method](sensitivity.ishigami, [(-np.pi, np.pi)] * 3, 4096)
    np.testing.assert_allclose(first[0], sensitivity.ISHIGAMI_FIRST, atol=0.05)  # Monte Carlo of 4096 points: about 3/sqrt(4096)
    np.testing.assert_allclose(total[0], sensitivity.ISHIGAMI_TOTAL, atol=0.05)


@pytest.mark.parametrize("method", [
    pytest.param(method, marks=() if method == "SALib" else pytest.mark.nightly) for method in sensitivity.METHODS])
def test_a_study_is_a_function_like_ishigamis(method, tmp_path):
    """The natural frequency of a gear pair is sqrt(k/m): for small variations half the relative change of k."""
    ranges = {"mesh 1 stiffness": (0.95, 1.05), "input_torque": (0.3, 0.5)}
    study = gt.Study(pair_study().train, gt.Space(ranges), modes={}, keep=["largest natural_frequency"])
    function = study.function(["largest natural_frequency", "smallest natural_frequency"], tmp_path)
    first, total = sensitivity.METHODS[method](function, list(ranges.values()), 256)
    np.testing.assert_allclose(first, [[1, 0], [1, 0]], atol=0.05)  # Monte Carlo of 256 points
    np.testing.assert_allclose(total, [[1, 0], [1, 0]], atol=0.02)
    known = len(computed(tmp_path))
    sensitivity.METHODS[method](function, list(ranges.values()), 256)
    assert len(computed(tmp_path)) == known  # the folder has them all


def test_a_function_of_one_point_or_many():
    function = pair_study().function(["largest rms", "first jump up", "last falling jump"])
    several = function([[0.3, 0.04], [0.5, 0.05], [0.3, 2.0]])
    assert several.shape == (3, 3)
    np.testing.assert_array_equal(function([0.5, 0.05]), several[1])
    branch = pair_study().branch((2, 1))
    assert several[1].tolist() == [
        branch.rms[branch.stable].max(), min(jump.frequency for jump in branch.jumps if jump.kind == "jump up"),
        max(jump.frequency for jump in branch.jumps if jump.direction == "falling"),
    ]
    assert np.isnan(several[2, 1:]).all()  # so much damping lets nothing jump
    with pytest.raises(gt.InputError, match="must have 2 columns"):
        function([[0.3]])
    with pytest.raises(gt.InputError, match="must be single numbers"):
        pair_study().function(["rms"])([[0.3, 0.04]])


def test_the_tolerance_study(tmp_path, capsys):
    tolerance.main("processes", tmp_path / "runs", tmp_path, base=2)
    said = capsys.readouterr().out
    assert "16 of 16 trains done" in said and "mesh 2 dynamic_factor" in said
    assert {"tolerance.png", "tolerance_indices.png"} <= {path.name for path in tmp_path.iterdir()}
    found = tolerance.tolerance_study(2).dataset(tmp_path / "runs")
    changed = found.isel(sample=3)
    meshes = [
        replace(mesh, **{name: getattr(mesh, name) * float(changed[f"mesh {number} {name}"])
                         for name in ("damping_ratio", "half_backlash", "stiffness")})
        for number, mesh in enumerate(paper_train().meshes, 1)
    ]
    branch = paper_train(meshes=meshes).response(start=0.2, stop=2.6)
    assert changed["largest mesh 2 dynamic_factor"] == branch.dynamic_factor[branch.stable, 1].max()
    np.testing.assert_array_equal(np.sort(changed.jump_frequency.dropna("jump")), [jump.frequency for jump in branch.jumps])


@pytest.mark.nightly
def test_the_same_study_on_dask(tmp_path):
    pytest.importorskip("distributed")
    tolerance.main("processes", tmp_path / "one", tmp_path, base=2)
    command = [sys.executable, ROOT / "example" / "tolerance.py", "dask", tmp_path / "other", tmp_path, "2"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0 and "16 of 16 trains done" in done.stdout, done.stderr
    study = tolerance.tolerance_study(2)
    assert study.dataset(tmp_path / "one").identical(study.dataset(tmp_path / "other"))


def test_the_array_job(tmp_path):
    """The script as SLURM would run it, task by task."""
    study = pair_study()
    study.prepare(tmp_path, parts=3)
    for task in (1, 2, 3):
        environment = {**os.environ, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_ARRAY_TASK_COUNT": "3",
                       "PATH": f"{os.path.dirname(sys.executable)}:{os.environ['PATH']}"}
        subprocess.run([ROOT / "example" / "study_slurm.sh", tmp_path], env=environment, check=True, capture_output=True)
    assert (study.dataset(tmp_path).status == "done").all() and not any(Store(tmp_path).suspects.iterdir())


def test_a_queue_of_this_machine(tmp_path):
    pytest.importorskip("dask_jobqueue")
    study = pair_study()
    study.prepare(tmp_path, parts=3)
    command = [sys.executable, ROOT / "example" / "study_jobqueue.py", tmp_path, "local", "2"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0 and done.stdout == "6 of 6 points done\n", done.stderr
    assert len(computed(tmp_path)) == len(set(computed(tmp_path))) == 6


def test_the_lines_of_the_page_run(tmp_path, monkeypatch):
    """Those of docs/studies.md, block after block."""
    text = (ROOT / "docs" / "studies.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) >= 3
    monkeypatch.chdir(tmp_path)
    (tmp_path / "namelists").symlink_to(ROOT / "namelists")
    np.savetxt("samples.csv", np.linspace([100.0, 25e-6], [150.0, 35e-6], 6), delimiter=",", comments="",
               header="input_torque,mesh 2 half_backlash")
    names = {"__name__": "page"}
    for block in blocks:
        exec(compile(block, "docs/studies.md", "exec"), names)
