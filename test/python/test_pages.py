"""The Python of the pages and of the ladder runs as it stands."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rexs_files import one_stage

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("page", ["python.md", "output.md"])
def test_the_lines_of_a_page_run(page, executable, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "namelists").symlink_to(ROOT / "namelists")
    if page == "output.md":
        (tmp_path / "results").mkdir()
        subprocess.run([executable, ROOT / "namelists" / "fig03.nml"], cwd="results", check=True, capture_output=True)
    else:  # a gearbox of another program, and its pinion's pitch errors in um
        one_stage().write(tmp_path / "gearbox.rexs")
        np.savetxt(tmp_path / "pinion.txt", 3 * np.sin(2 * np.pi * np.arange(23) / 23))
    names = {"__name__": "page"}
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.DOTALL)
    assert blocks
    for block in blocks:
        exec(compile(block, page, "exec"), names)


@pytest.mark.full
@pytest.mark.parametrize("script", [
    # The site runs all of them: by day the simplest, and the one that starts processes of its own.
    pytest.param(script, id=script.stem, marks=() if script.stem in ("plot_01_one_pair", "plot_08_study") else pytest.mark.nightly)
    for script in sorted((ROOT / "example" / "gallery").glob("plot_*.py"))])
def test_a_step_of_the_ladder_runs_as_a_script(script, tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.iterdir())
