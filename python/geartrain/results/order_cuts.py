"""Order cuts of a run-up: the amplitude of each order over the speed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.extras import extra
from ..errors import InputError, shown
from .orders import orders_of

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["cut_orders"]

Array = NDArray[np.float64]

#: Windows over the ramp, and the shares of a Hann window's cycles that separate two orders.
_PICTURES, _APART = 400, 4.0


def cut_orders(run_up: Any, orders: Iterable[float | str] | None, what: str, cycles: float | None) -> Dataset:
    """Amplitude and phase of orders along a `RunUp`, as its ``order_cuts`` describes them."""
    xarray = extra("xarray")
    along = {"mesh_force": "mesh", "displacement": "mesh", "shaft_torque": "shaft"}.get(what)
    if along is None:
        raise InputError(f"what = {shown(what)}: must be 'mesh_force', 'shaft_torque', 'displacement'")
    named = orders_of(run_up.train, orders)
    if not named or min(named) <= 0:
        raise InputError(f"orders = {shown(orders)}: must be multiples of the fundamental above 0, at least one")
    time, values, numbers = run_up.time, getattr(run_up, what), np.array(sorted(named))
    begin, end = run_up.fundamental_frequency[0], run_up.fundamental_frequency[-1]
    turns = time * (begin + (end - begin) * time / (2 * time[-1]))  # of the fundamental
    highest = 0.5 / float(np.diff(turns).max())
    if numbers[-1] > highest:
        raise InputError(f"orders: {numbers[-1]:g}: must be at most {highest:.6g}, half of the samples in a cycle of the "
                         "fundamental at the highest speed")
    apart = float(np.diff(numbers, prepend=0.0).min())
    wide = min(_APART / apart, float(turns[-1])) if cycles is None else cycles
    if isinstance(wide, bool) or not isinstance(wide, (int, float)) or not 0 < wide <= turns[-1]:
        raise InputError(f"cycles = {shown(cycles)}: must be above 0 and at most {turns[-1]:.6g}, the cycles of the fundamental")
    middles = np.linspace(wide / 2, turns[-1] - wide / 2, _PICTURES if wide < turns[-1] else 1)
    found = np.empty((len(numbers), values.shape[1], len(middles)), dtype=complex)
    for place, middle in enumerate(middles):
        first, last = np.searchsorted(turns, [middle - wide / 2, middle + wide / 2])
        part = slice(max(first - 1, 0), last + 1)
        weight = np.cos(np.pi * np.clip((turns[part] - middle) / wide, -0.5, 0.5)) ** 2
        weight *= np.gradient(turns[part])  # samples are equidistant in time, windows in turns
        turning = np.exp(-2j * np.pi * np.outer(numbers, turns[part]))
        centred = values[part] - weight @ values[part] / weight.sum()
        found[:, :, place] = 2 * (turning * weight) @ centred / weight.sum()
    at = np.interp(middles, turns, time)
    unit = {"mesh_force": "N", "shaft_torque": "N m", "displacement": "characteristic_length"}[what]
    labels = getattr(run_up, f"{along}_label")
    coordinates: dict[str, Any] = {
        "order": ("order", numbers, {"description": "multiples of the fundamental"}),
        "order_name": ("order", [named[number] for number in numbers]),
        along: (along, np.arange(1, len(labels) + 1, dtype=np.intc)), f"{along}_label": (along, list(labels)),
        "time": ("time", at, {"units": "s", "description": "middle of each window"}),
        "frequency": ("time", np.interp(at, time, run_up.frequency), {"description": "Lambda"}),
        "fundamental_frequency": ("time", np.interp(at, time, run_up.fundamental_frequency), {"units": "Hz"})}
    if run_up.speed is not None:
        coordinates["speed"] = "time", np.interp(at, time, run_up.speed), {"units": "rpm"}
    dimensions = ("order", along, "time")
    made: Dataset = xarray.Dataset(
        {"amplitude": (dimensions, np.abs(found), {"units": unit, "description": "amplitude of the order"}),
         "phase": (dimensions, np.angle(found), {"units": "rad", "description": "its lead over the cosine of the order"})},
        coordinates, {"what": what, "cycles": float(wide)})
    return made
