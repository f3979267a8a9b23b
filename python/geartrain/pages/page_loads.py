"""Tables of a page: largest forces and torques of a branch, and how the planets of its planetary sets share the load."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import part_names
from .._core.units import hertz_of, speed_of
from ..plots.planetary_picture import stages_of
from ..results.summary import speeds

__all__ = ["largest_loads", "load_sharing"]

#: Name, columns, and the branch and point of each row.
Loads = tuple[str, dict[str, list[Any]], list[list[int]]]

#: Mesh load factor above which the printed report names the planet: equal planets differ by rounding.
_UNEVEN = 1.0005


def largest_loads(branch: Any, place: int) -> Loads:
    """The largest force of each mesh, torque of each shaft and reaction of each held body, of stable motions if there are any.

    ``place`` is the number of the branch on its page.
    """
    arrays, train = branch.arrays(), branch.train
    counts, words = _counts(branch)
    parts = [(label, "N m" if element.startswith("coupling") else "N", arrays["mesh_force_maximum"][:, mesh],
              arrays["dynamic_factor"][:, mesh])
             for mesh, (label, element) in enumerate(zip(train.mesh_labels, train.mesh_elements))]
    for along, name in (("shaft", "shaft_torque"), ("held", "reaction_torque")):
        highest, lowest = arrays.get(f"{name}_maximum"), arrays.get(f"{name}_minimum")
        if highest is not None and lowest is not None:
            both = np.maximum(highest, -lowest)
            labels = part_names(train, along, both.shape[1])
            parts += [(f"reaction of {label}" if along == "held" else label, "N m", both[:, part], None)
                      for part, label in enumerate(labels)]
    # Rigid shafts side by side have no torque of their own.
    parts = [part for part in parts if np.isfinite(part[2][counts]).any()]
    points = [int(np.nanargmax(np.where(counts, values, np.nan))) for _, _, values, _ in parts]
    columns = {
        "part": [label for label, *_ in parts],
        "force or torque": [float(values[point]) for point, (_, _, values, _) in zip(points, parts)],
        "unit": [unit for _, unit, _, _ in parts],
        "dynamic factor": [None if factor is None else float(factor[point]) for point, (*_, factor) in zip(points, parts)],
        **_speeds_at(branch, points),
    }
    return f"Largest forces and torques{words}", columns, [[place, point] for point in points]


def load_sharing(branch: Any, place: int) -> Loads:
    """The mesh load factor of each planetary set and its largest force of a planet, of stable motions if there are any.

    ``place`` is the number of the branch on its page. Sets without load, and trains without sets, have no rows.
    """
    arrays = branch.arrays()
    counts, words = _counts(branch)
    kinds = {"load_share": "K_gamma: largest mean load over an even share",
             "load_share_maximum": "largest force over an even share"}
    rows: list[tuple[str, str, float, int | None]] = []
    points: list[int] = []
    first = 0
    for name, told in stages_of(branch.train).items():
        last = first + int(told["planets"])
        for field, quantity in kinds.items():
            share = arrays.get(field)
            if share is None or share.shape[1] < last:
                continue
            own = np.where(counts[:, np.newaxis], (last - first) * share[:, first:last], np.nan)
            if not np.isfinite(own).any():
                continue
            point, planet = np.unravel_index(np.nanargmax(own), own.shape)
            value = float(own[point, planet])
            rows.append((name, quantity, value, int(planet) + 1 if value > _UNEVEN else None))
            points.append(int(point))
        first = last
    columns = dict(zip(("set", "quantity", "value", "planet"), map(list, zip(*rows))))
    return f"Load sharing of planets{words}", {**columns, **_speeds_at(branch, points)}, [[place, point] for point in points]


def _counts(branch: Any) -> tuple[NDArray[np.bool_], str]:
    """Which points count, the stable ones or all where none is stable, and the words for the name of a table."""
    if branch.stable is None or not branch.stable.any():
        return np.ones(len(branch), bool), ""
    return branch.stable, ", stable motions"


def _speeds_at(branch: Any, points: Sequence[int]) -> dict[str, list[Any]]:
    """The columns of a table that state the speed, or the parameter, of points of a branch."""
    found = []
    for point in points:
        at = float(branch.frequency[point])
        found.append(SimpleNamespace(
            frequency=at, speed=speed_of(branch.train, at), fundamental_frequency=hertz_of(branch.train, at),
            parameter=None if branch.parameter is None else float(branch.parameter[point])))
    return speeds(found)
