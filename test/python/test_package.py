"""The package: documented examples run, no executable stack, and every module is installed."""

import doctest
import importlib
import pkgutil
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT

import geartrain as gt
from geartrain import _geartrain

MODULES = ["geartrain", *(module.name for module in pkgutil.walk_packages(gt.__path__, "geartrain."))]


@pytest.mark.parametrize("name", [name for name in MODULES if not name.endswith("._geartrain")])
def test_examples_in_docstrings(name, train, branch, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = {"gt": gt, "train": train, "branch": branch}
    assert doctest.testmod(importlib.import_module(name), extraglobs=names).failed == 0


def test_public_calls_have_examples():
    for call in (gt.Train, gt.Train.response, gt.Train.integrate, gt.Train.attractors, gt.Branch.at, gt.Motion.refine):
        assert ">>> " in call.__doc__, call


def test_every_module_is_installed():
    sources, installed = ROOT / "python" / "geartrain", Path(gt.__file__).parent
    here = [path.relative_to(sources) for path in sources.rglob("*.py")] + [Path("py.typed")]
    assert len(here) > 100 and [path for path in here if not (installed / path).is_file()] == []


def test_public_names_are_in_the_api():
    documented = set(re.findall(r":: geartrain\.(\w+)$", (ROOT / "docs" / "api.md").read_text(encoding="utf-8"), re.MULTILINE))
    assert documented == set(gt.__all__)


@pytest.mark.skipif(not shutil.which("readelf"), reason="no readelf")
def test_stack_is_not_executable():
    headers = subprocess.run(["readelf", "-lW", _geartrain.__file__], capture_output=True, text=True, check=True).stdout
    (stack,) = [line for line in headers.splitlines() if "GNU_STACK" in line]
    assert "RWE" not in stack
