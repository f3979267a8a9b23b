"""Nonlinear torsional dynamics of gear trains.

Periodic motions of geared shafts with backlash and varying mesh stiffness: harmonic balance with continuation,
Floquet stability, time integration. Everything is computed by the Fortran library of the same name.

Frequency is Lambda, the fundamental frequency over the train's characteristic frequency; displacement is that of
the meshes, over the characteristic length. Calls and pictures with ``unit`` take and show rpm and Hz as well.

Examples
--------
The train of Al-shyyab and Kahraman (2007), which is the ``train`` of all examples here:

>>> import geartrain as gt
>>> def mesh(driving_inertia, driven_inertia, stiffness):
...     return gt.Mesh(driving_radius=0.05, driven_radius=0.10, driving_inertia=driving_inertia,
...                    driven_inertia=driven_inertia, stiffness=stiffness, damping_ratio=0.05,
...                    half_backlash=30e-6, stiffness_cos=[0.3])
>>> train = gt.Train(
...     input_torque=150.0, prime_mover_inertia=2.3e-7, load_inertia=2.3e-7,
...     characteristic_length=30e-6, characteristic_frequency=9870.0,
...     shafts=[gt.Shaft(stiffness=k, damping_ratio=0.01) for k in (1e3, 1e8, 1e3)],
...     meshes=[mesh(0.0023, 0.037, 2.5e8), mesh(0.0046, 0.074, 5e8)])
>>> train.natural_frequencies().round(4)
array([ 0.9571,  1.8662,  6.6807,  6.681 , 15.9206])
>>> branch = train.response(start=0.2, stop=2.6)
>>> branch.ended
'reached Lambda = 2.6'
>>> [motion.stable for motion in branch.at(0.6)]
[True, False, True]
"""

from __future__ import annotations

from ._core import box as _box
from ._core.explanation import Explanation
from ._core.suggest import suggest_names
from .case import Case, Results, read_case, read_results
from .errors import DrawingWarning, InputError, Interrupted, NotDifferentiableWarning, SolverError
from .files.load_cycles import LoadCycles
from .files.rexs import read_rexs
from .files.table_file import read_table
from .pages.page import Page, page
from .plots.draw import plot_style
from .results.attractors import Attractors
from .results.audit import Audit
from .results.basins import Basins
from .results.bifurcation_diagram import BifurcationDiagram
from .results.branch import Branch
from .results.campbell import Campbell, Crossing, Order
from .results.exact_point import ExactPoint
from .results.locus import Locus, LocusPoint
from .results.lyapunov import LyapunovSpectrum
from .results.modes import Modes
from .results.motion import Motion
from .results.motions import Motions
from .results.run_up import RunUp
from .results.simulator import Simulator
from .results.special_point import SpecialPoint
from .results.stability_map import StabilityMap
from .results.state_space import StateSpace
from .results.summary import Jump, Peak, Peaks
from .results.sweep import Sweep
from .results.trajectory import Trajectory
from .studies.space import Space
from .studies.study import Study, StudyExplanation, read_study
from .studies.tolerance_class import pitch_errors
from .train import Train
from .variables import Bearing, Body, Coupling, Mesh, Planetary, Shaft

__all__ = [
    "Attractors",
    "Audit",
    "Basins",
    "Bearing",
    "BifurcationDiagram",
    "Body",
    "Branch",
    "Campbell",
    "Case",
    "Coupling",
    "Crossing",
    "DrawingWarning",
    "ExactPoint",
    "Explanation",
    "InputError",
    "Interrupted",
    "Jump",
    "LoadCycles",
    "Locus",
    "LocusPoint",
    "LyapunovSpectrum",
    "Mesh",
    "Modes",
    "Motion",
    "Motions",
    "NotDifferentiableWarning",
    "Order",
    "Page",
    "Peak",
    "Peaks",
    "Planetary",
    "Results",
    "RunUp",
    "Shaft",
    "Simulator",
    "SolverError",
    "Space",
    "SpecialPoint",
    "StabilityMap",
    "StateSpace",
    "Study",
    "StudyExplanation",
    "Sweep",
    "Train",
    "Trajectory",
    "page",
    "pitch_errors",
    "plot_style",
    "read_case",
    "read_results",
    "read_rexs",
    "read_study",
    "read_table",
]

with _box.Box() as _opened:
    __version__ = _opened.text("version")

suggest_names(globals())
