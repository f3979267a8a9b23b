"""Curves of special points over frequency and a number of the train."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box, Group
from .._core.description import Description
from .._core.table import Table
from .._core.text_table import Rows
from .._core.units import Unit, own_lambda, speed_of, units_of
from ..errors import InputError, shown
from ..plots.draw import draws, new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Self

__all__ = ["Locus", "LocusPoint"]

Array = NDArray[np.float64]

_SPECIAL = "/locus/special_points"


@dataclass(frozen=True)
class LocusPoint:
    """A point of a curve at which two conditions meet.

    Attributes
    ----------
    kind : str
        On the curve of a fold ``'cusp'``, ``'isola centre'``, ``'1:1 resonance'`` or ``'fold-flip'``; of a period doubling
        ``'generalized doubling'``, ``'1:2 resonance'`` or ``'fold-flip'``; of a Neimark-Sacker point ``'1:1 resonance'`` to
        ``'1:4 resonance'``, ``'fold-neimark-sacker'`` or ``'flip-neimark-sacker'``; of a contact onset ``'grazing on a fold'`` or
        ``'grazing on a doubling'``, as on the curves of folds and doublings where a mesh touches a wall of its gap with no speed;
        likewise of a Neimark-Sacker point and a branch point ``'grazing'``.
    frequency : float
        Lambda.
    parameter : float
        In the unit of the parameter.
    point : int
        Index of the curve's point before it.
    speed : float or None
        In rpm, where every mesh has teeth.
    """

    kind: str
    frequency: float
    parameter: float
    point: int
    speed: float | None = None


class LocusPoints(Rows[LocusPoint]):
    """Points of a curve at which two conditions meet: a list that is printed as a table."""

    def _table(self) -> Mapping[str, Sequence[Any]]:
        return {
            "kind": [point.kind for point in self],
            "speed [rpm]": [point.speed for point in self],
            "Lambda": [own_lambda(point.frequency, point.speed) for point in self],
            "parameter": [point.parameter for point in self],
        }


@dataclass(frozen=True, eq=False, repr=False)
class Locus(Table):
    """The curve of a special point or a contact onset of the exact motion over frequency and a number of the train.

    Attributes
    ----------
    frequency : ndarray, (points,)
        Lambda.
    parameter : ndarray, (points,)
        In the unit of the parameter.
    kind : str
        As of `ExactPoint`.
    special_points : list of LocusPoint
        Where two conditions meet: cusps, resonances, grazing.
    initial_state : ndarray, (points, states)
        Of the motion, as ``Motion.state``.
    multipliers : ndarray of complex, (points, states)
        Of the motion.
    parameter_name : str
    mesh : int
        Of a contact onset the number of the mesh, else 0.
    period : int
        Of the motions, in periods of the fundamental.
    start_frequency : float
        Lambda of the special point with which it began, at the train's own value.
    ended : str
        Why it ended on either side, in words.
    ends : tuple of str
        Why it ended at its first and at its last point: ``'range'`` (the end of the range of the parameter), ``'closed'``,
        ``'corner'`` (the motion grazes a wall of a gap, and the curve was not found beyond), ``'double point'``, ``'limit'``,
        ``'symmetry'``, ``'cancelled'`` or ``'failed'``. Empty in files written before.
    complete, closed : bool
        Whether it got to the ends of the range, or closed; whether it came back to where it began.
    train : Train or None
    """

    path: ClassVar[str] = "/locus"

    frequency: Array
    parameter: Array
    kind: str
    initial_state: Array
    multipliers: NDArray[np.complex128]
    parameter_name: str
    mesh: int
    period: int
    start_frequency: float
    ended: str
    complete: bool
    closed: bool
    ends: tuple[str, ...] = ()
    special_points: list[LocusPoint] = field(default_factory=list)
    train: Description | None = None

    def __len__(self) -> int:
        return len(self.frequency)

    def __repr__(self) -> str:
        return f"<Locus of a {self.kind} over {self.parameter_name}, {len(self)} points: {self.ended}>"

    @classmethod
    def _from(cls, box: Box, train: Description | None = None) -> Self | None:
        found = super()._from(box, train)
        if found is None:
            return None
        rows = box.results().get(_SPECIAL, Group()).rows("kind", "frequency", "parameter", "after_point")
        return replace(found, kind=found.kind.strip(), special_points=LocusPoints(
            LocusPoint(kind.strip(), float(frequency), float(parameter), int(point) - 1, speed_of(train, float(frequency)))
            for kind, frequency, parameter, point in rows
        ))

    def _columns(self) -> tuple[dict[str, Any], dict[str, Any]]:
        attributes, arrays = super()._columns()
        attributes.pop("special_points")
        return attributes, arrays

    def _put(self, box: Box) -> None:
        super()._put(box)
        if self.special_points:
            names = {"kind": "kind", "frequency": "frequency", "parameter": "parameter"}
            columns: dict[str, Any] = {name: [getattr(point, own) for point in self.special_points] for own, name in names.items()}
            box.put(_SPECIAL, {}, {**columns, "after_point": [point.point + 1 for point in self.special_points]})

    @draws
    def plot(
        self, ax: Axes | None = None, *, across: Literal["parameter", "frequency"] = "parameter", unit: Unit | None = None,
        **style: Any,
    ) -> Axes:
        """Draw the curve, frequency over the parameter, with its special points; over a stability map see `StabilityMap.plot`.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        across : {'parameter', 'frequency'}
            What the horizontal axis is.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the frequency; unless told rpm where Lambda is the speed in rpm, else Lambda.
        **style
            For matplotlib's ``plot``.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
        """
        units = units_of(self.train, unit)
        ax = new_axes(ax)
        if across not in ("parameter", "frequency"):
            raise InputError(f"across = {shown(across)}: must be 'parameter' or 'frequency'")

        def turned(parameter: Any, frequency: Any) -> tuple[Any, Any]:
            return (frequency, parameter) if across == "frequency" else (parameter, frequency)

        line, = ax.plot(*turned(self.parameter, self.frequency * units.per_lambda), **{"lw": 1.5, "label": self.kind, **style})
        for point in self.special_points:
            place = turned(point.parameter, point.frequency * units.per_lambda)
            ax.plot(*place, "o", ms=5, color=line.get_color())
            ax.annotate(point.kind, place, xytext=(6, 4), textcoords="offset points", fontsize=8, annotation_clip=True)
        x_label, y_label = turned(self.parameter_name, units.frequency)
        ax.set_xlabel(x_label)
        ax.set_ylabel(y_label)
        return ax
