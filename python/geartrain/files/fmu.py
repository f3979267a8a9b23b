"""A functional mock-up unit of a train: FMI 2.0 for co-simulation, made by pythonfmu."""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path

from .._core.extras import extra
from ..errors import InputError, shown
from ..results.simulator import Simulator

__all__ = ["write_unit"]

#: The program within the unit; its class has the name of the file.
_SCRIPT = '''"""The gear train of this unit; needs the Python package geartrain where it runs."""

import ctypes

from geartrain.files.fmu_slave import TrainSlave


class {name}(TrainSlave):
    """See modelDescription.xml."""

    def __init__(self, **kwargs):
        # For each instance pythonfmu 0.7 gives back a reference to the names of this module that it never took.
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))
        super().__init__(**kwargs)
'''


def write_unit(
    simulator: Simulator, path: str | os.PathLike[str], has_start: bool, inputs: Sequence[str] | None,
    outputs: Sequence[str] | None
) -> Path:
    """Write a unit that begins as the simulator is; ``has_start``: with its state, else at rest."""
    builder = extra("pythonfmu").FmuBuilder
    train, target = simulator.train, Path(path)
    if target.suffix != ".fmu" or target.is_dir():
        raise InputError(f"path = {shown(path)}: must be the path of a file that ends in .fmu")
    name = re.sub(r"^(?=\d)", "_", re.sub(r"\W", "_", target.stem, flags=re.ASCII))
    moved = [body.name for body in train.bodies if body.name and not body.held and (body.torque or body.balances)]
    settings = {
        "frequency": simulator.frequency, "state": simulator.state.tolist() if has_start else None,
        "inputs": _chosen("inputs", inputs, train.body_labels, moved),
        "outputs": _chosen("outputs", outputs, simulator.names, simulator.names),
    }
    if not target.absolute().parent.is_dir():
        raise OSError(f"{target.absolute().parent}: no such folder")
    with tempfile.TemporaryDirectory() as place, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the case, which its reader has had
        folder, made = Path(place), Path(place) / "made.fmu"
        script, case, unit = folder / f"geartrain_unit_{name}.py", folder / "case.nml", folder / "unit.json"
        script.write_text(_SCRIPT.format(name=name))
        case.write_text(train.namelist(), encoding="utf-8")
        unit.write_text(json.dumps(settings))
        searched = sys.path.copy()
        try:
            builder.build_FMU(script, made, [case, unit])
        finally:  # which leaves the folder of the script and its module behind
            sys.path[:] = searched
            sys.modules.pop(script.stem, None)
        beside = target.with_name(f".{target.name}.{os.getpid()}")
        beside.write_bytes(made.read_bytes())
        beside.replace(target)
    return target


def _chosen(argument: str, names: Sequence[str] | None, known: Sequence[str], usual: Sequence[str]) -> list[str]:
    """Names that were asked for, each of which must be known."""
    if names is None:
        return list(usual)
    if isinstance(names, str) or any(name not in known for name in names):
        raise InputError(f"{argument} = {shown(names)}: must be a list of names: {', '.join(known)}")
    return list(dict.fromkeys(names))
