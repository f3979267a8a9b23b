"""Panels and scales of pictures over speed: parts of unequal size have axes of their own, scaled to the stable motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .draw import new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["are_unequal", "name_height", "new_panels", "scale", "span"]

Array = NDArray[np.float64]

#: Least extent of a part over that of the whole picture with which it can be read beside the others: of ranges, whose extent is
#: from smallest to largest, and of quantities, whose extent is from zero.
_LEAST_RANGE, _LEAST_SIZE = 0.1, 0.05
#: Least height of a panel over the largest value in it: below it a curve is shown as constant. Room above and below.
_FLAT, _ROOM = 0.05, 0.06


def are_unequal(parts: Sequence[Array], ranges: bool) -> bool:
    """Whether parts, each with its values, cannot be read in one picture."""
    ends = [span(part) for part in parts]
    if len(ends) < 2:
        return False
    if ranges:
        whole = max(high for _, high in ends) - min(low for low, _ in ends)
        return min(high - low for low, high in ends) < _LEAST_RANGE * whole
    sizes = [max(abs(low), abs(high)) for low, high in ends]
    return min(sizes) < _LEAST_SIZE * max(sizes)


def span(values: Array) -> tuple[float, float]:
    """Smallest and largest of the values that are there, 0 and 0 without any."""
    there = values[np.isfinite(values)]
    return (float(there.min()), float(there.max())) if there.size else (0.0, 0.0)


def new_panels(ax: Axes | None, names: Sequence[str], split: bool) -> list[Axes]:
    """The axes of each part: those given, or of a new figure one for all; where ``split`` one below another with their names."""
    if ax is not None or not split:
        return [new_axes(ax)] * len(names)
    axes: list[Axes] = list(new_axes(None, len(names), sharex=True, figsize=(6.4, max(4.8, 1.2 + 1.6 * len(names)))))
    for own, name in zip(axes, names):
        own.annotate(name, (0.0, 1.0), (4, -4), xycoords="axes fraction", textcoords="offset points", va="top", fontsize="small",
                     zorder=6, bbox={"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.85})
    return axes


def name_height(axes: Sequence[Any], label: str) -> None:
    """Name what panels show upwards: once beside all of them."""
    if len(dict.fromkeys(axes)) > 1:
        axes[0].figure.supylabel(label, fontsize="medium")
    else:
        axes[0].set_ylabel(label)


def scale(ax: Axes, values: Array, from_zero: bool) -> tuple[float, float] | None:
    """Scale the axes to values, so that a curve that is constant but for some thousandths looks constant; gives the limits."""
    low, high = span(values)
    if from_zero and low >= 0:
        low = 0.0
    height = max(high - low, _FLAT * max(abs(low), abs(high)))
    if not height:
        return None
    middle = (low + high) / 2
    bottom = 0.0 if from_zero and low == 0.0 else middle - (0.5 + _ROOM) * height
    top = middle + (0.5 + _ROOM) * height
    ax.set_ylim(bottom, top)
    return bottom, top
