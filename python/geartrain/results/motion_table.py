"""Motions as the fields of a table, and back: what a results file has of a sweep or a search."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box, Group
from .._core.dataset import dataset
from .._core.description import part_labels
from .._core.units import hertz_of, speed_of
from ..errors import InputError
from .motion_check import NUMBERS, OTHER_TORQUES, SHARES, TORQUES, UNCERTAINTIES, VALUES, check_motion

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["ATTRACTORS", "INTEGRATION", "motions_dataset", "motions_of", "orbits_of", "put_motions", "put_table"]

Array = NDArray[Any]

INTEGRATION, ATTRACTORS = "/integration", "/attractors"
_LOOSE = "/motions"


def motions_of(box: Box, path: str = "") -> list[dict[str, Any]]:
    """The motions of a group of the results, or those on their own, each as keywords of `Motion`."""
    group = (box.results() if path else box.show("motions")).get(path or _LOOSE, Group())
    return [_motion(group, place) for place in range(len(group.arrays.get("frequency", ())))]


def _motion(group: Group, place: int) -> dict[str, Any]:
    """One motion of a group; what is NaN throughout it does not have."""
    row = {name: values[place] for name, values in group.arrays.items() if len(values) > place and name in _FIELDS}
    nothing = np.full(len(group.arrays["mesh"]), np.nan)
    coefficients = row.get("coefficients", nothing[:, np.newaxis])
    there = ~np.isnan(coefficients).all(axis=0)
    multipliers, state = (None if row.get(name) is None or np.isnan(row[name]).all() else row[name]
                          for name in ("multipliers", "initial_state"))
    # By the growth rate over a part of a long period, without multipliers.
    assessed = bool(row.get("assessed", False))
    return {
        **{name: row.get(name, nothing) for name in VALUES},
        **{name: row.get(name) for name in (*TORQUES, *OTHER_TORQUES, *SHARES)},
        **{name: None if row.get(name) is None or np.isnan(row[name]).all() else row[name] for name in UNCERTAINTIES},
        "window": float(np.nan_to_num(row.get("window", 0.0))),
        **{name: float(row.get(name, np.nan)) for name in ("frequency", *NUMBERS)},
        "lyapunov_error": float(np.nan_to_num(row.get("lyapunov_error", 0.0))),
        "period": int(row["period"]),
        "kind": row["kind"],
        "coefficients": coefficients[:, there] if there.any() else nothing[:, np.newaxis],
        "stable": bool(row["stable"]) if multipliers is not None else bool(row["assessed_stable"]) if assessed else None,
        "undecided": bool(row["assessed_undecided"] if assessed else row.get("undecided", False)),
        "floating": bool(row.get("floating", False)),
        "multipliers": multipliers,
        "state": state,
    }


_FIELDS = {
    *VALUES, *TORQUES, *OTHER_TORQUES, *SHARES, *UNCERTAINTIES, *NUMBERS, "window",
    *("frequency", "period", "kind", "coefficients", "stable", "undecided", "floating", "multipliers", "initial_state"),
    *("assessed", "assessed_stable", "assessed_undecided"),
}


def orbits_of(motions: Sequence[Any]) -> list[int]:
    """Number of the orbit of each motion of one train, from 1: a turn of the planets of a symmetric set makes no other."""
    train = motions[0].train if motions else None
    if train is None or len(motions) < 2 or not any(mesh.carrier for mesh in train.meshes):
        return list(range(1, len(motions) + 1))
    with train._ask() as box:
        put_motions(box, *motions)
        return [int(number) for number in box.show("orbits")["/orbits"].column("orbit")]


def put_motions(box: Box, *motions: Any, what: str = "motion", only_state: bool = False) -> None:
    """Put motions of the case's train on their own; ``what`` is what messages call them, ``only_state`` as in `check_motion`."""
    put_table(box, _LOOSE, "motion", motions, {}, {}, what, only_state)


def put_table(
    box: Box, path: str, along: str, motions: Sequence[Any], attributes: Mapping[str, Any], arrays: Mapping[str, Any], what: str,
    only_state: bool = False,
) -> None:
    """Put motions as one table, along the dimension ``along``."""
    meshes, states = box.sizes()
    for motion in motions:
        check_motion(motion, what, meshes, states, only_state=only_state)
    if len({len(motion.multipliers) for motion in motions if motion.multipliers is not None}) > 1:
        raise InputError(f"{what}: multipliers: must be as many of one motion as of another")
    columns = as_columns(motions) if motions else {}
    columns.pop("true_ac_rms", None)
    if only_state:
        columns.update({name: np.full((len(motions), meshes), np.nan) for name in VALUES})
    columns[along] = np.arange(1, len(motions) + 1, dtype=np.intc)
    what, like = ("motions", ATTRACTORS) if path == _LOOSE else ("results", path)
    box.put(path, attributes, {**columns, **arrays} if motions else columns, what, like)


def as_columns(motions: Sequence[Any]) -> dict[str, Any]:
    """Motions as fields by their names in a results file; None for what none of them has."""
    multipliers = _padded([motion.multipliers for motion in motions])
    numbers = {name: np.array([float(getattr(motion, name)) for motion in motions]) for name in NUMBERS}
    if np.isnan(numbers["lyapunov_exponent"]).all():
        numbers["lyapunov_error"] = numbers["lyapunov_exponent"]
    known = multipliers is not None
    return {
        "frequency": np.array([float(motion.frequency) for motion in motions]),
        "period": np.array([motion.period for motion in motions], np.intc),
        "kind": np.array([motion.kind for motion in motions], object),
        **{name: np.array([getattr(motion, name) for motion in motions], float) for name in VALUES},
        **{name: _padded([getattr(motion, name) for motion in motions])
           for name in (*TORQUES, *OTHER_TORQUES, *SHARES, *UNCERTAINTIES)},
        "window": np.array([float(motion.window) for motion in motions]) if any(motion.window for motion in motions) else None,
        "true_ac_rms": np.array([motion.rms for motion in motions], float) / np.sqrt(2),
        "coefficients": _padded([motion.coefficients for motion in motions]),
        **{name: None if np.isnan(values).all() else values for name, values in numbers.items()},
        "floating": np.array([bool(motion.floating) for motion in motions]) if any(m.floating for m in motions) else None,
        "initial_state": _padded([motion.state for motion in motions]),
        "multipliers": multipliers,
        "stable": np.array([bool(motion.stable) for motion in motions]) if known else None,
        "undecided": np.array([bool(motion.undecided) for motion in motions]) if known else None,
    }


def motions_dataset(
    path: str, motions: Sequence[Any], coordinates: tuple[str, ...] = (), attributes: Mapping[str, Any] | None = None,
    **columns: Any,
) -> Dataset:
    """Motions as the table of a group of the results file."""
    train, frequency = motions[0].train if motions else None, np.array([motion.frequency for motion in motions])
    values = as_columns(motions)
    speeds = {"speed": speed_of(train, frequency), "fundamental_frequency": hertz_of(train, frequency)}
    return dataset(path, {**values, **part_labels(train, values), **speeds, **columns}, dict(attributes or {}), coordinates)


def _padded(rows: list[Any]) -> Array | None:
    """Arrays of one shape but for the last dimension, filled up with NaN; None where there is none."""
    known = [row for row in rows if row is not None]
    if not known:
        return None
    length = max(row.shape[-1] for row in known)
    table = np.full((len(rows), *known[0].shape[:-1], length), np.nan, complex if known[0].dtype.kind == "c" else float)
    for place, row in enumerate(rows):
        if row is not None:
            table[place, ..., : row.shape[-1]] = row
    return table
