"""The orders of a motion as a table: amplitudes, and what each order comes from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .._core.description import part_names
from .._core.extras import extra
from .campbell import exciting_orders
from .orders import named_orders, owners_of

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["order_table"]


#: What orders may be of beside displacements: the dimension, with its name in `part_names`, and the unit.
_FORCES = {"mesh_force": ("mesh", "mesh", "N"), "shaft_torque": ("shaft", "shaft", "N m"),
           "coupling_torque": ("coupling", "coupling", "N m"), "bearing_force": ("bearing", "bearing axis", "N")}


def order_table(motion: Any, least: float, what: str) -> Dataset:
    """The orders of a motion whose amplitude in some mesh, shaft, ... is at least a share of the largest one there."""
    order, amplitude = motion.spectrum(what)
    amplitude = amplitude.reshape(len(order), -1)
    along, named, unit = _FORCES.get(what, ("mesh", "mesh", "1"))
    kept = ((amplitude >= least * amplitude.max(axis=0, initial=0.0)) & (amplitude > 0)).any(axis=1)
    train = motion.train
    ratio = train.explain()["train"].get("speed_ratio")
    exciting = {float(cause.order): cause.name.replace("revolution of ", "") for cause in exciting_orders(train)}
    names = {**exciting, **named_orders(train)}
    data = {
        "amplitude": (("order", along), amplitude[kept], {
            "units": unit, "description": f"amplitude of the {what.replace('_', ' ')}" if what in _FORCES else
            "amplitude of the mesh displacement over the characteristic length"}),
        "owner": ("order", owners_of(train, order[kept], names),
                  {"description": "what the order comes from"}),
    }
    coordinates: dict[str, Any] = {
        "order": ("order", order[kept], {"units": "1", "description": "multiple of the fundamental"}),
        along: (along, list(part_names(train, named, amplitude.shape[1]))),
    }
    if ratio:
        coordinates["per_revolution"] = ("order", order[kept] / ratio, {
            "units": "1", "description": f"multiple of the revolution of {train.speed_name}"})
    table: Dataset = extra("xarray").Dataset(data, coordinates)
    return table
