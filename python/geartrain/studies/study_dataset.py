"""The records of a study as a labelled xarray Dataset."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.dataset import labels_along
from .._core.extras import extra
from ..variables import VARIABLES
from .jump_identity import identify
from .quantity import Quantity
from .study_plan import Plan
from .study_store import DONE, Store, fill_of

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["MISSING", "dataset_of"]

#: Status of a point that is not computed yet.
MISSING = "missing"


def dataset_of(plan: Plan, store: Store) -> Dataset:
    """Every point of the plan with what the folder has of it; what it has not is filled up with NaN and the like."""
    status, message, kept = _gathered(plan, store)
    if "jump_frequency" in kept:
        kept = _with_identities(plan, kept)
    everywhere = np.unique(plan.keys, return_inverse=True)[1]
    rank = np.argsort(np.argsort(np.unique(plan.keys, return_index=True)[1]))
    rows = rank[everywhere]  # of each point its place among the distinct ones
    shape = tuple(map(len, plan.axes))
    dimensions = tuple(axis.name for axis in plan.axes)
    variables: dict[str, Any] = {
        "status": (dimensions, status[rows].reshape(shape), {"description": "done, failed, set aside or missing"}),
        "message": (dimensions, message[rows].reshape(shape), {"description": "why the point failed or was set aside"}),
    }
    axes: dict[str, int] = {}
    for name, (values, own, unit, told) in kept.items():
        attributes = {"units": unit, "description": told} if unit else {"description": told}
        variables[name] = ((*dimensions, *own), values[rows].reshape(*shape, *values.shape[1:]), attributes)
        axes.update(zip(own, values.shape[1:]))
    coordinates: dict[str, Any] = {}
    for axis in plan.axes:
        for name, values in axis.columns.items():
            coordinates[name] = (axis.name, values, _told(name, plan.relative[name]))
    coordinates |= {name: (name, labels_along(name, length)) for name, length in axes.items()}
    for name, names in (("mesh", plan.train.mesh_labels), ("shaft", plan.train.shaft_labels)):
        if axes.get(name) == len(names):
            coordinates[f"{name}_label"] = (name, list(names))
    attributes = {"case": plan.case, "analysis": plan.call, "settings": json.dumps(plan.settings), "title": plan.train.title or ""}
    found: Dataset = extra("xarray").Dataset(variables, coordinates, attributes)
    return found


def _told(name: str, relative: bool) -> dict[str, str]:
    """Unit and description of a parameter."""
    words = name.split(",")[0].split()
    rows = VARIABLES.get(words[0] if len(words) > 1 and words[0] in VARIABLES else "train" if len(words) == 1 else "body", {})
    row = next((rows[word] for word in reversed(words) if word in rows), None)
    if row is None:
        return {}
    unit = re.search(r"\[(.+?)\]", row.meaning)
    return {"units": "1" if relative or unit is None else unit[1],
            "description": ("over the train's own: " if relative else "") + row.meaning.partition(";")[0]}


def _gathered(plan: Plan, store: Store) -> tuple[NDArray[Any], NDArray[Any], dict[str, Quantity]]:
    """Status, message and what is kept of the distinct points, a row each."""
    place = {plan.key(point): row for row, point in enumerate(plan.distinct.tolist())}
    total = len(place)
    taken: list[tuple[NDArray[np.intp], NDArray[np.intp], Mapping[str, Quantity]]] = []
    status, message = np.full(total, MISSING, "U9"), np.full(total, "", object)
    for path in store.paths():
        batch = store.read(path)
        if batch is None:
            continue
        rows = np.array([place.get(key, -1) for key in batch.keys.tolist()], np.intp)
        better = (rows >= 0) & (status[rows] != DONE)
        if not better.any():
            continue
        own = np.flatnonzero(better)
        rows = rows[own]
        status[rows], message[rows] = batch.status[own], batch.message[own]
        taken.append((rows, own, batch.kept))
    kept: dict[str, Quantity] = {}
    for name in dict.fromkeys(name for _, _, quantities in taken for name in quantities):
        parts = [(rows, own, quantities[name]) for rows, own, quantities in taken if name in quantities]
        full = [quantity.values for _, _, quantity in parts if quantity.values.size] or [parts[0][2].values]
        shape = tuple(map(max, zip(*(quantity.values.shape[1:] for _, _, quantity in parts))))
        kind = np.result_type(*full)
        table = np.full((total, *shape), fill_of(kind), kind)
        for rows, own, quantity in parts:
            if quantity.values.size:
                part = table[(slice(None), *(slice(length) for length in quantity.values.shape[1:]))]
                part[rows] = quantity.values[own]
        kept[name] = parts[0][2]._replace(values=table)
    return status, message, kept


def _with_identities(plan: Plan, kept: dict[str, Quantity]) -> dict[str, Quantity]:
    """Jumps along a dimension where each has its own place at every point, with a mark where it could not be followed there."""
    columns = [column[plan.distinct] for column in plan.columns]
    numbers = [np.unique(column, return_inverse=True)[1] if column.dtype.kind == "U" else column for column in columns]
    parameters = np.stack(numbers, axis=1).astype(float) if numbers else np.zeros((len(plan.distinct), 0))
    frequency, direction, cause, rms = (
        kept[f"jump_{name}"].values for name in ("frequency", "direction", "cause", "rms_before")
    )
    found = identify(parameters, frequency, direction, cause, rms)
    rows, places = np.nonzero(found.number >= 0)
    numbers_there = found.number[rows, places]
    told = "whether the jump is known to be this one: not where it begins, or where it is as much like another"
    changed = {**kept, "jump_followed": Quantity(found.followed, ("jump",), "1", told)}
    for name, quantity in changed.items():
        if quantity.dimensions[:1] == ("jump",):
            values = quantity.values
            table = np.full((len(values), found.total, *values.shape[2:]), fill_of(values.dtype), values.dtype)
            table[rows, numbers_there] = values[rows, places]
            changed[name] = quantity._replace(values=table)
    return changed
