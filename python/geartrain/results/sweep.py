"""Motions over frequency, each from where the one before settled."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box
from .._core.description import Description
from .._core.units import Unit, hertz_of, in_own_unit, speed_of
from ..errors import InputError
from ..plots.draw import draws
from ..plots.response_plot import plot_visits
from .motion import Motion
from .motion_table import INTEGRATION, motions_dataset, motions_of, put_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset

__all__ = ["Sweep"]

Array = NDArray[np.float64]


class Sweep(list[Motion]):
    """Motions over frequency, in the order in which they were visited: a list of `Motion`.

    Where a motion grew without bound (`Motion.unbounded`) its figures are nan, and the sweep goes on from rest.

    Attributes
    ----------
    direction : tuple of str
        ``'up'`` or ``'down'``, one a motion.
    ended : str
        Why it ended, in words, and that the train floats in its gaps where it does.
    complete : bool
        Whether it got to its end.
    """

    def __init__(
        self, motions: Iterable[Motion], direction: tuple[str, ...] = (), ended: str = "", complete: bool = False
    ) -> None:
        super().__init__(motions)
        self.direction = direction
        self.ended = ended
        self.complete = complete

    @property
    def frequency(self) -> Array:
        """Lambda, (motions,)."""
        return np.array([motion.frequency for motion in self])

    @property
    def rms(self) -> Array:
        """(motions, meshes)."""
        return np.array([motion.rms for motion in self])

    @property
    def dynamic_factor(self) -> Array:
        """(motions, meshes)."""
        return np.array([motion.dynamic_factor for motion in self])

    @property
    def mesh_force_maximum(self) -> Array:
        """Largest mesh force [N], (motions, meshes)."""
        return np.array([motion.mesh_force_maximum for motion in self])

    @property
    def shaft_torque_minimum(self) -> Array:
        """Smallest torque of each shaft [N m], (motions, shafts)."""
        return np.array([motion.shaft_torque_minimum for motion in self])

    @property
    def shaft_torque_maximum(self) -> Array:
        """Largest torque of each shaft [N m], (motions, shafts)."""
        return np.array([motion.shaft_torque_maximum for motion in self])

    @property
    def load_share(self) -> Array | None:
        """Share of each planet in the mean load of its planetary set, (motions, planets); None without planets."""
        return self._shares("load_share")

    @property
    def load_share_maximum(self) -> Array | None:
        """Largest force of each planet over the mean load of its set, (motions, planets); None without planets."""
        return self._shares("load_share_maximum")

    def _shares(self, name: str) -> Array | None:
        rows = [getattr(motion, name) for motion in self]
        known = [row for row in rows if row is not None]
        return np.array([np.full_like(known[0], np.nan) if row is None else row for row in rows]) if known else None

    @property
    def speed(self) -> Array | None:
        """Speed [rpm] of the body that `Train.speed_name` tells, (motions,); None where not every mesh has teeth."""
        return speed_of(self[0].train if self else None, self.frequency)

    @property
    def fundamental_frequency(self) -> Array | None:
        """Frequency of the fundamental [Hz], (motions,); None without a train."""
        return hertz_of(self[0].train if self else None, self.frequency)

    @draws
    def plot(
        self, mesh: int | None = None, ax: Axes | None = None, *, quantity: str | None = None, shaft: int | None = None,
        coupling: int | None = None, bearing: int | None = None, unit: Unit | None = None, **style: Any,
    ) -> Axes:
        """Draw a quantity over the speed: a triangle for each motion, upwards and full with rising, downwards with falling speed.

        The keywords are those of `Branch.plot`.

        Examples
        --------
        >>> ax = train.sweep(start=0.4, stop=0.8, points=3, direction="both").plot(quantity="mesh_force")
        >>> ax.get_ylabel()
        'largest mesh force  [N]'
        """
        parts = {"mesh": mesh, "shaft": shaft, "coupling": coupling, "bearing": bearing}
        return plot_visits(self, self[0].train if self else None, ax, quantity, parts, unit, style)

    def to_dataset(self) -> Dataset:
        """The motions as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        attributes = {"ended": self.ended, "complete": self.complete}
        coordinates = ("frequency", "speed", "fundamental_frequency", "direction")
        return motions_dataset(INTEGRATION, self, coordinates, attributes, direction=list(self.direction))

    def __str__(self) -> str:
        return self.report() if self and self[0].train is not None else repr(self)

    def report(self, *, verbose: bool = False) -> str:
        """The report that the executable prints of these motions: `str` of a sweep is the same text.

        Parameters
        ----------
        verbose : bool
            Every range, as with ``--verbose``.

        Examples
        --------
        >>> print(train.sweep(start=0.4, stop=0.8, points=3).report().splitlines()[1])
        Time integration: Lambda 0.4 to 0.8, 3 motions
        """
        train = self[0].train
        if train is None:
            raise ValueError("this sweep has no train")
        ways = sorted({*self.direction}) or ["up"]
        settings = {
            "start": float(self.frequency.min()), "stop": float(self.frequency.max()),
            "points": max(self.direction.count(way) for way in ways), "direction": ways[0] if len(ways) == 1 else "both",
        }
        with train._ask(integration=settings) as box:
            self._put(box)
            return box.report(verbose)

    def __repr__(self) -> str:
        return f"<Sweep of {len(self)} motions: {in_own_unit(self.ended, self[0].train if self else None)}>"

    @classmethod
    def _from(cls, box: Box, train: Description) -> Sweep:
        group = box.results()[INTEGRATION]
        motions = [Motion(train=train, **fields) for fields in motions_of(box, INTEGRATION)]
        ended, complete = group.attributes["ended"], group.attributes["complete"]
        return cls(motions, tuple(group.arrays.get("direction", ())), ended, complete)

    def _put(self, box: Box) -> None:
        """Put it into a box as its result."""
        if len(self.direction) != len(self) or not {*self.direction} <= {"up", "down"}:
            raise InputError(f"integration: direction: must be 'up' or 'down' of each of the {len(self)} motions")
        attributes = {"ended": self.ended, "complete": self.complete}
        put_table(box, INTEGRATION, "point", self, attributes, {"direction": list(self.direction)}, "integration")
