"""The orders of a motion as a table: amplitudes, and what each order comes from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import part_names
from .._core.extras import extra
from ..errors import InputError, shown
from .orders import names_of_causes, owners_of

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["named_spectrum", "order_table"]

Array = NDArray[np.float64]


#: What orders may be of beside displacements: the dimension, with its name in `part_names`, and the unit.
_FORCES = {"mesh_force": ("mesh", "mesh", "N"), "shaft_torque": ("shaft", "shaft", "N m"),
           "coupling_torque": ("coupling", "coupling", "N m"), "bearing_force": ("bearing", "bearing axis", "N")}


def named_spectrum(
    motion: Any, least: float, what: str = "displacement"
) -> tuple[Array, Array, list[str], float | None]:
    """Orders whose amplitude in some mesh, shaft, ... is at least a share of the largest one there, owners, turns of the speed.

    Returns
    -------
    order : ndarray, (orders,)
        Multiples of the fundamental.
    amplitude : ndarray, (orders, meshes), or shafts, couplings, bearings in x and y
    owner : list of str
    ratio : float or None
        Orders of the fundamental in an order of the speed, where it is known.
    """
    order, amplitude = motion.spectrum(what)
    amplitude = amplitude.reshape(len(order), -1)
    kept = ((amplitude >= least * amplitude.max(axis=0, initial=0.0)) & (amplitude > 0)).any(axis=1)
    train = motion.train
    ratio = train.explain()["train"].get("speed_ratio")
    return order[kept], amplitude[kept], owners_of(train, order[kept], names_of_causes(train)), ratio or None


def order_table(motion: Any, least: float, what: str) -> Dataset:
    """The orders of `named_spectrum` as a dataset."""
    if np.ndim(least) or not 0 <= least <= 1:
        raise InputError(f"least = {shown(least)}: must be 0 to 1")
    order, amplitude, owner, ratio = named_spectrum(motion, least, what)
    along, named, unit = _FORCES.get(what, ("mesh", "mesh", "1"))
    train = motion.train
    data = {
        "amplitude": (("order", along), amplitude, {
            "units": unit, "description": f"amplitude of the {what.replace('_', ' ')}" if what in _FORCES else
            "amplitude of the mesh displacement over the characteristic length"}),
        "owner": ("order", owner, {"description": "what the order comes from"}),
    }
    coordinates: dict[str, Any] = {
        "order": ("order", order, {"units": "1", "description": "multiple of the fundamental"}),
        along: (along, list(part_names(train, named, amplitude.shape[1]))),
    }
    if ratio:
        coordinates["per_revolution"] = ("order", order / ratio, {
            "units": "1", "description": f"multiple of the revolution of {train.speed_name}"})
    table: Dataset = extra("xarray").Dataset(data, coordinates)
    return table
