"""Bifurcation diagrams: sections of the attractors over frequency."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description
from .._core.table import Table
from .._core.units import Unit, hertz_of, speed_of, units_of
from ..errors import InputError, shown
from ..plots.draw import COLORS, draws, new_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["BifurcationDiagram"]

Array = NDArray[np.float64]

#: Names of the directions of a sweep.
_SPEEDS = {"up": "rising speed", "down": "falling speed"}


@dataclass(frozen=True, eq=False, repr=False)
class BifurcationDiagram(Table):
    """Sections of the attractors over frequency, each frequency begun with the last state of the one before.

    Attributes
    ----------
    frequency : ndarray, (points,)
        Lambda, in the order visited.
    direction : tuple of str
        ``'up'`` or ``'down'`` at each point.
    kind : tuple of str
        ``'periodic'``, ``'quasi-periodic'``, ``'chaotic'``, ``'still settling'`` (or of a period longer than half the sections),
        ``'undecided'``, ``'unbounded'``; empty where the diagram was stopped before.
    period : ndarray of int, (points,)
        In periods of the fundamental; 0 where none was found.
    displacement, velocity : ndarray, (points, sections, meshes)
        Of the meshes at phase 0 of successive periods of the fundamental, over the characteristic length, and over this times the
        characteristic frequency; NaN of a mesh that closes a loop.
    lyapunov_exponents, lyapunov_errors : ndarray, (points, 2*elements)
        Per unit of time (1/characteristic frequency), largest first, and their uncertainties at 95 %.
    rotation_number : ndarray, (points,)
        Of a quasi-periodic motion the turns of its sections about their middle in a period of the fundamental, 0 to 1/2: the
        distance of its second frequency over that of the fundamental from the nearest whole number; on a torus about a motion of
        period n from the nearest multiple of 1/n. NaN of any other, and where
        the sections go round no point of a plane of displacement and velocity.
    final_state : ndarray, (points, 2*elements)
        At phase 0 after the last section, as ``Motion.state``.
    ended : str
        Why it ended, in words.
    complete : bool
        Whether all points are done.
    mesh_label : tuple of str
        Of each mesh, see `Train.mesh_labels`.
    train : Train
    """

    path = "/bifurcation_diagram"

    frequency: Array
    direction: tuple[str, ...]
    kind: tuple[str, ...]
    period: NDArray[np.intc]
    displacement: Array
    velocity: Array
    lyapunov_exponents: Array
    lyapunov_errors: Array
    rotation_number: Array
    final_state: Array
    ended: str
    complete: bool
    mesh_label: tuple[str, ...] | None = None
    train: Description | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        return f"<BifurcationDiagram of {len(self.frequency)} points: {self.ended}>"

    @property
    def speed(self) -> Array | None:
        """Speed [rpm] of the body that `Train.speed_name` tells, (points,); None where not every mesh has teeth."""
        return speed_of(self.train, self.frequency)

    @property
    def fundamental_frequency(self) -> Array | None:
        """Frequency of the fundamental [Hz], (points,); None without a train."""
        return hertz_of(self.train, self.frequency)

    @draws
    def plot(self, mesh: int = 1, ax: Axes | None = None, *, what: str = "displacement", unit: Unit | None = None,
             **style: Any) -> Axes:
        """Draw the sections of a mesh, or the largest Lyapunov exponents.

        Parameters
        ----------
        mesh : int
            Its number, from 1.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        what : {'displacement', 'velocity', 'lyapunov_exponents'}
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the frequency; unless told rpm where Lambda is the speed in rpm, else Lambda.
        **style
            For matplotlib's ``plot``.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> diagram.plot(mesh=2).figure.savefig("diagram.png")  # doctest: +SKIP
        """
        units = units_of(self.train, unit)
        titles = {"displacement": f"displacement of mesh {mesh}, once a period  {units.length}",
                  "velocity": rf"velocity of mesh {mesh}, once a period  $/\, b_c \omega_c$",
                  "lyapunov_exponents": r"two largest Lyapunov exponents  $/\, \omega_c$"}
        if what not in titles:
            raise InputError(f"what = {shown(what)}: must be {', '.join(map(repr, titles))}")
        meshes = self.displacement.shape[2]
        if what != "lyapunov_exponents" and (isinstance(mesh, bool) or mesh not in range(1, meshes + 1)):
            raise InputError(f"mesh = {shown(mesh)}: must be 1 to {meshes}")
        ax = new_axes(ax)
        values: Array = getattr(self, what)
        values = values[:, :2] if what == "lyapunov_exponents" else values[:, :, mesh - 1]
        directions = list(dict.fromkeys(self.direction))
        for direction, color, marker in zip(directions, COLORS, ("o", "s")):
            there = np.array(self.direction) == direction
            frequency = np.repeat(units.per_lambda * self.frequency[there], values.shape[1])
            ax.plot(frequency, values[there].ravel(), **{
                "linestyle": "none", "marker": marker, "markersize": 2.4 if direction == directions[0] else 1.2,
                "markeredgewidth": 0, "color": color, "label": _SPEEDS[direction], "rasterized": True, **style})
        if len(directions) > 1:
            ax.legend(frameon=False, markerscale=3)
        ax.set_xlabel(units.frequency)
        ax.set_ylabel(titles[what])
        return ax
