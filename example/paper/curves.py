"""What the paper's figures are drawn from: branches with what integration makes of them, and natural frequencies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations, product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geartrain import Branch, Motion, SolverError, Train
from paper_cases import paper_case

__all__ = ["Curve", "Drawn", "compute", "natural_frequencies"]

Array = NDArray[np.float64]

_SPACING = 0.05  # Lambda from one mark to the next
_SAME = 1e-2  # relative difference of rms up to which two motions pass for the same
_PATIENCE = 20000  # periods of the fundamental: a soft shaft between the gear pairs damps little
_STARTS = 100
_SHAFT_RANGE = np.logspace(3, 9, 241)  # stiffness of the middle shaft in figure 5, N m/rad


@dataclass(frozen=True)
class Curve:
    """A curve of a figure.

    Attributes
    ----------
    case : str
        Name of its case, see ``paper_cases.py``.
    label : str
    period : int
        Of the motions in periods of the fundamental.
    seeds : tuple of float
        Lambdas at which random starts look for further branches than those of the case: islands.
    """

    case: str
    label: str
    period: int = 1
    seeds: tuple[float, ...] = ()


@dataclass(frozen=True)
class Drawn:
    """What a curve is drawn from.

    Attributes
    ----------
    branches : list of Branch
    marks : list of Motion
        What integration makes of stable motions of the branches.
    tried : int
        Stable motions from which it began. Those not among the marks went elsewhere, or were not steady after _PATIENCE periods.
    difference : float
        Largest difference of rms between the marks and the motions they began with, over the larger rms of the two meshes.
    """

    branches: list[Branch]
    marks: list[Motion]
    tried: int
    difference: float


def compute(curve: Curve, results: Path) -> Drawn | None:
    """Compute a curve; the whole case goes to the results folder.

    Parameters
    ----------
    curve : Curve
    results : path
        Folder.

    Returns
    -------
    Drawn or None
        None for a case without a response, or with an integration of its own.
    """
    case = paper_case(curve.case)
    result = case.run()
    # Curves of one case are computed side by side: one of them writes.
    if curve.period == 1:
        result.write(results / f"{curve.case}.h5")
    if result.response is None or result.integration is not None:
        return None
    response = result.response
    further = list(result.branches)
    for frequency in curve.seeds:
        # What was found at one frequency is known at the next.
        known = replace(response, branches=further)
        further += case.train.attractors(frequency, starts=_STARTS, follow=known).branches
    branches = [branch for branch in (response, *further) if branch.subharmonic == curve.period]
    if not branches:
        raise SolverError(f"{curve.case}: no motion of period {curve.period}")
    return _integrated(case.train, branches)


def _integrated(train: Train, branches: list[Branch]) -> Drawn:
    """Integrate from stable motions of the branches; those that stay are the marks."""
    marks: list[Motion] = []
    tried, difference = 0, 0.0
    for branch, frequency in product(branches, _SPACING * np.arange(4, 84)):
        seen: list[Array] = []
        if not branch.frequency.min() <= frequency <= branch.frequency.max():
            continue
        for motion in branch.at(float(frequency)):
            twin = any(np.allclose(motion.rms, rms, rtol=1e-5) for rms in seen)
            seen.append(motion.rms)
            if twin or not motion.stable:
                continue
            tried += 1
            settled = train.integrate(float(frequency), start=motion, stability=False, max_periods=_PATIENCE, tolerance=1e-7)
            change = float(np.max(np.abs(settled.rms - motion.rms)) / np.max(motion.rms))
            if settled.period == branch.subharmonic and change < _SAME:
                marks.append(settled)
                difference = max(difference, change)
    return Drawn(branches, marks, tried, difference)


def natural_frequencies(results: Path) -> tuple[Array, Array]:
    """Figure 5: natural frequencies over the stiffness of the middle shaft, each mode followed by its shape.

    Parameters
    ----------
    results : path
        Folder.

    Returns
    -------
    stiffness : ndarray, (points,)
        N m/rad.
    frequency : ndarray, (points, modes)
        In the order that the modes have with the stiffest shaft.
    """
    case = paper_case("fig05")
    case.run().write(results / "fig05.h5")
    train = case.train
    radius = np.array([*(mesh.driving_radius for mesh in train.meshes), train.meshes[-1].driven_radius], float)
    frequency, before = [], None
    for stiffness in _SHAFT_RANGE[::-1]:
        shafts = list(train.shafts)
        middle = len(shafts) // 2
        shafts[middle] = replace(shafts[middle], stiffness=float(stiffness))
        modes = replace(train, shafts=shafts).modes()
        # Times the root of the stiffness, shapes of different modes are perpendicular; a shaft's twist is an arc in them.
        energy = np.empty(modes.shape.shape[1])
        energy[0::2] = np.array([shaft.stiffness for shaft in shafts]) / np.square(radius)
        energy[1::2] = [mesh.stiffness for mesh in train.meshes]
        shape = modes.shape * np.sqrt(energy)
        shape /= np.linalg.norm(shape, axis=1, keepdims=True)
        if before is None:
            order = list(range(len(shape)))
        else:
            overlap = np.abs(before @ shape.T) ** 2
            order = list(max(permutations(range(len(shape))), key=lambda chosen: overlap[range(len(shape)), list(chosen)].sum()))
        before = shape[order]
        frequency.append(modes.natural_frequency[order])
    return _SHAFT_RANGE, np.array(frequency[::-1])
