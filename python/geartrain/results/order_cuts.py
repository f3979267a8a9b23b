"""Order cuts of a run-up: the amplitude of each order over the speed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.extras import extra
from .._core.warn import warn
from ..errors import InputError, shown
from .orders import gears_with_errors, mesh_orders, orders_of

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["cut_orders"]

Array = NDArray[np.float64]

#: Windows over the ramp, and the shares of a Hann window's cycles that separate two orders.
_PICTURES, _APART = 400, 4.0
#: Largest share of a ramp in a window that is chosen here, and sidebands of a gear with errors on either side.
_WIDEST, _SIDEBANDS = 0.25, 3


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
    wide = _window(run_up, named, float(turns[-1])) if cycles is None else cycles
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


def _window(run_up: Any, named: dict[float, str], turns: float) -> float:
    """As many cycles of the fundamental as separate the orders, from one another and from lines of the meshes beside them."""
    lines = {0.0, *named, *_lines(run_up.train, max(named))}
    pairs = [(abs(line - number), number, line) for number in named for line in lines if line != number]
    apart = min(pairs)[0]
    widest = max(_WIDEST * turns, min(turns, _APART / min(named)))
    mixed = [(number, line) for distance, number, line in sorted(pairs) if _APART / distance > widest and line]
    if mixed:
        number, line = mixed[0]
        warn(f"order cuts: windows of {widest:.4g} cycles of the fundamental, a quarter of the ramp, do not separate order "
             f"{number:g} from {line:g}: a slower ramp does, or cycles = {_APART / abs(number - line):.4g}")
    return min(_APART / apart, widest)


def _lines(train: Any, highest: float) -> set[float]:
    """Multiples of mesh orders up to beyond the highest order wanted, and sidebands of gears with errors."""
    if train is None:
        return set()
    meshes = {float(order) for order in mesh_orders(train).values()}
    found = {times * order for order in meshes for times in range(1, int(highest // order) + 2)}
    for _, _, mesh, turn in gears_with_errors(train):
        found |= {times * mesh + side * turn for times in range(int(highest // mesh) + 2)
                  for side in range(-_SIDEBANDS, _SIDEBANDS + 1)}
    return {line for line in found if line > 0}
