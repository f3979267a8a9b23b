"""A branch between its points: cubics along the branch, by which a picture of few points is smooth."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Between", "is_slope", "position", "slopes", "value_at"]

Array = NDArray[np.float64]
#: Places at which a step is drawn.
_PLACES = 8


def is_slope(name: str) -> bool:
    """Whether a field is a derivative along the branch, which no picture shows."""
    return name.endswith("_slope")


class Between:
    """A branch with places between its points; without the lengths of an earlier version's results its points alone."""

    def __init__(self, branch: Any) -> None:
        along = branch.others.get("arclength")
        count = len(branch.segment)
        if along is not None and len(along) != count:
            along = None  # points chosen by hand
        self._along = np.arange(count, dtype=float) if along is None else np.asarray(along)
        step = np.diff(self._along)
        joined = (np.diff(branch.segment) == 0) & (step > 0) & (along is not None)
        inner = np.where(joined, _PLACES - 1, 0)
        #: The point before each place, and the share of the step from there.
        self._point = np.repeat(np.arange(count), np.append(inner, 0) + 1) if count else np.zeros(0, int)
        first = np.append(0, np.cumsum(np.append(inner, 0) + 1)[:-1]) if count else np.zeros(0, int)
        self._share = (np.arange(len(self._point)) - first[self._point]) / _PLACES
        self._step = np.append(step, 0.0)
        self._joined = joined
        self._slopes = {"rms": branch.others.get("rms_slope")} if along is not None else {}
        if self._slopes:
            self._slopes["true_ac_rms"] = self._slopes["rms"] / np.sqrt(2)
        self.frequency = self.values(branch._free, branch.others.get("free_slope"))
        self.segment = branch.segment[self._point]
        self.stable = None if branch.stable is None else self._stable(branch)

    def of(self, name: str, values: Array) -> Array:
        """A field at the places, (places, columns)."""
        return self.values(values, self._slopes.get(name))

    def values(self, values: Array, slope: Array | None = None) -> Array:
        """Values at the places of the cubics through those at the points; unless the derivatives are given, without overshoot."""
        if slope is None:
            slope = slopes(self._along, values, self._joined)
        shape = (-1,) + (1,) * (values.ndim - 1)
        here, there = self._point, np.minimum(self._point + 1, len(values) - 1)
        t, length = self._share.reshape(shape), self._step[here].reshape(shape)
        found: Array = ((1 - t) ** 2 * ((1 + 2 * t) * values[here] + t * length * slope[here])
                        + t**2 * ((3 - 2 * t) * values[there] - (1 - t) * length * slope[there]))
        return np.where(t == 0, values[here], found)

    def _stable(self, branch: Any) -> NDArray[np.bool_]:
        """Stability at the places: it changes at the special point of the step, else amid the step."""
        changes = np.full(len(branch.stable), 0.5)
        for special in branch.special_points:
            point = special.point
            if special.kind != "fold" and 0 <= point < len(changes) - 1:
                at = special.frequency if special.parameter is None else special.parameter
                ends = branch._free[point], branch._free[point + 1]
                changes[point] = np.clip((at - ends[0]) / (ends[1] - ends[0]), 0, 1) if ends[0] != ends[1] else 0.5
        after = (self._share > changes[self._point]) & (self._share > 0)
        stable: NDArray[np.bool_] = branch.stable[np.minimum(self._point + after, len(changes) - 1)]
        return stable


def position(between: Between, free: float, rms: Array, wanted: Array) -> tuple[int, float]:
    """Where a branch has a frequency (or parameter) and, of all such places, the rms nearest to that wanted.

    Gives a place and the share of the step from there. A fold lies beyond the places on either side of it: places themselves count
    as well, by their distance in frequency.
    """
    at = between.frequency
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (free - at[:-1]) / np.diff(at)
    first = np.flatnonzero((np.diff(between.segment) == 0) & (share >= 0) & (share <= 1))
    shares = share[first, np.newaxis]
    scale, extent = np.abs(rms).max() or 1.0, np.ptp(at) or 1.0
    crossed = np.abs((1 - shares) * rms[first] + shares * rms[first + 1] - wanted).max(axis=1, initial=0.0) / scale
    near = np.abs(rms - wanted).max(axis=1, initial=0.0) / scale + np.abs(at - free) / extent
    place = int(near.argmin())
    if len(first) and crossed.min() <= near[place]:
        one = int(crossed.argmin())
        return int(first[one]), float(share[first[one]])
    return place, 0.0


def value_at(values: Array, where: tuple[int, float]) -> Array:
    """Values at a position, (columns,)."""
    place, share = where
    found: Array = values[place] if share == 0 else (1 - share) * values[place] + share * values[place + 1]
    return found


def slopes(along: Array, values: Array, joined: NDArray[np.bool_]) -> Array:
    """Derivatives of cubics that rise and fall with the values (F. N. Fritsch and J. Butland, SIAM J. Sci. Stat. Comput. 5 (1984)
    300-304); at an end of a segment the chord."""
    shape = (-1,) + (1,) * (values.ndim - 1)
    found = np.zeros(values.shape)
    if len(along) < 2:
        return found
    step = np.where(joined, np.diff(along), 1.0).reshape(shape)
    chord = np.where(joined.reshape(shape), np.diff(values, axis=0) / step, np.nan)
    before, after = chord[:-1], chord[1:]
    weight = step[:-1] + 2 * step[1:], 2 * step[:-1] + step[1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = sum(weight) / (weight[0] / before + weight[1] / after)
    found[1:-1] = np.where(np.isnan(before), after, np.where(np.isnan(after), before, np.where(before * after > 0, mean, 0.0)))
    found[0], found[-1] = chord[0], chord[-1]
    return np.where(np.isnan(values), np.nan, np.nan_to_num(found))
