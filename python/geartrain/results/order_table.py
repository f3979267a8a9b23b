"""The orders of a motion as a table: amplitudes, and what each order comes from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.extras import extra
from .campbell import exciting_orders
from .orders import named_orders, owners_of

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["named_spectrum", "order_table"]

Array = NDArray[np.float64]


def named_spectrum(motion: Any, least: float) -> tuple[Array, Array, list[str], float | None]:
    """Orders whose amplitude in some mesh is at least a share of the largest one of this mesh, their owners, turns of the speed.

    Returns
    -------
    order : ndarray, (orders,)
        Multiples of the fundamental.
    amplitude : ndarray, (orders, meshes)
    owner : list of str
    ratio : float or None
        Orders of the fundamental in an order of the speed, where it is known.
    """
    order, amplitude = motion.spectrum()
    kept = ((amplitude >= least * amplitude.max(axis=0, initial=0.0)) & (amplitude > 0)).any(axis=1)
    train = motion.train
    ratio = train.explain()["train"].get("speed_ratio")
    exciting = {float(cause.order): cause.name.replace("revolution of ", "") for cause in exciting_orders(train)}
    names = {**exciting, **named_orders(train)}
    return order[kept], amplitude[kept], list(owners_of(train, order[kept], names)), ratio or None


def order_table(motion: Any, least: float) -> Dataset:
    """The orders of `named_spectrum` as a dataset."""
    order, amplitude, owner, ratio = named_spectrum(motion, least)
    train = motion.train
    data = {
        "amplitude": (("order", "mesh"), amplitude, {
            "units": "1", "description": "amplitude of the mesh displacement over the characteristic length"}),
        "owner": ("order", owner, {"description": "what the order comes from"}),
    }
    coordinates: dict[str, Any] = {
        "order": ("order", order, {"units": "1", "description": "multiple of the fundamental"}),
        "mesh": ("mesh", list(train.mesh_labels)),
    }
    if ratio:
        coordinates["per_revolution"] = ("order", order / ratio, {
            "units": "1", "description": f"multiple of the revolution of {train.speed_name}"})
    table: Dataset = extra("xarray").Dataset(data, coordinates)
    return table
