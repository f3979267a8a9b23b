"""Nonlinear torsional dynamics of gear trains.

Periodic motions of geared shafts with backlash and varying mesh stiffness: harmonic balance with continuation,
Floquet stability, time integration. Everything is computed by the Fortran library of the same name.

Frequency is Lambda, the fundamental mesh frequency over the train's characteristic frequency; displacement is that of
the meshes, over the characteristic length.
"""

from __future__ import annotations

from ._box import Box as _Box
from .branch import Branch, SpecialPoint
from .case import Case, Results, read_case
from .errors import InputError, Interrupted, SolverError
from .modes import Modes
from .motion import Motion, Sweep
from .train import Mesh, Shaft, Train

__all__ = [
    "Branch",
    "Case",
    "InputError",
    "Interrupted",
    "Mesh",
    "Modes",
    "Motion",
    "Results",
    "Shaft",
    "SolverError",
    "SpecialPoint",
    "Sweep",
    "Train",
    "read_case",
]

with _Box() as _box:
    __version__ = _box.text("version")
