"""Basins of attraction: which steady motion each start reaches."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box
from .._core.description import Description
from .._core.extras import extra
from .._core.table import Table
from .._core.units import frequency_words, units_of
from ..errors import InputError, shown
from ..plots.draw import COLORS, draws, new_axes
from .motion import Motion
from .motion_table import motions_dataset, motions_of, orbits_of, put_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset

__all__ = ["Basins"]

Array = NDArray[np.float64]

_OTHERS = {0: ("settles on none of these", "0.85"), -1: ("grows without bound", "0.35"), -2: ("not done", "1.0")}


@dataclass(frozen=True, eq=False, repr=False)
class Basins(Table):
    """Which steady motion each start reaches, over displacement and velocity of a mesh at phase 0.

    Attributes
    ----------
    motions : list of Motion
        As random starts found them, ``share`` that of the random starts, largest first; then those that only starts of the grid
        found.
    frequency : float
        Lambda.
    mesh : int
        Number of the mesh, from 1.
    displacement, velocity : ndarray, (displacements,), (velocities,)
        Of the mesh, over the characteristic length, and over this times the characteristic frequency.
    label : ndarray of int, (velocities, displacements)
        Number of the motion that the start reaches, from 1; 0 where it settles on none, -1 where it grows without bound, -2 where
        the map was stopped before.
    grid_share, grid_share_error : ndarray, (motions,)
        Share of the starts of the grid, and its standard error as the share of the area, from how the neighbours of each start
        agree.
    share_error : ndarray, (motions,)
        Standard error of the motions' ``share``. Random starts are spread over the displacements and velocities of all meshes,
        those of the grid over one mesh's alone: the two shares differ.
    unsettled, unbounded : float
        Shares of the starts of the grid.
    start_state : ndarray, (2*elements,)
        State at phase 0 that the starts have, as ``Motion.state``, but for the displacement and velocity of the mesh.
    displacement_place, velocity_place : int
        Places of these in the state, from 1.
    starts, random_seed : int
        Random starts, and what they were made from.
    ended : str
        Why it ended, in words.
    complete : bool
        Whether all starts are done.
    train : Train
    """

    path = "/basins"
    names = {"mesh": "mesh_number"}  # noqa: RUF012 (with an annotation it would be a field)

    frequency: float
    mesh: int
    displacement: Array
    velocity: Array
    label: NDArray[np.intc]
    grid_share: Array
    grid_share_error: Array
    share_error: Array
    start_state: Array
    displacement_place: int
    velocity_place: int
    unsettled: float
    unbounded: float
    starts: int
    random_seed: int
    ended: str
    complete: bool
    motions: list[Motion] = field(default_factory=list)
    train: Description | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        rows, columns = self.label.shape
        at = frequency_words(self.frequency, self.train)
        return f"<Basins of {len(self.motions)} motions at {at}, {rows} x {columns} starts: {self.ended}>"

    @property
    def orbit(self) -> list[int]:
        """Number of the orbit of each of ``motions``, from 1: those that differ only by a turn of the planets of a symmetric
        planetary set have one number."""
        return orbits_of(self.motions)

    def start(self, displacement: float, velocity: float) -> Array:
        """The state at phase 0 of a start, (2*elements,), from which `Train.integrate` shows the way to its motion.

        Parameters
        ----------
        displacement, velocity : float
            Of the mesh, as those of the starts.
        """
        state = np.array(self.start_state)
        state[self.displacement_place - 1], state[self.velocity_place - 1] = displacement, velocity
        return state

    def motion_at(self, displacement: float, velocity: float) -> Motion | None:
        """The motion that the nearest start reaches; None where it reaches none.

        Parameters
        ----------
        displacement, velocity : float
            Of the mesh, as those of the starts.

        Raises
        ------
        InputError
            Outside the range of the starts.
        """
        places = []
        for name, value, starts in (("velocity", velocity, self.velocity), ("displacement", displacement, self.displacement)):
            if not starts.min() <= value <= starts.max():
                raise InputError(f"{name} = {shown(value)}: must be {starts.min():g} to {starts.max():g}, the range of the starts")
            places.append(int(np.abs(starts - value).argmin()))
        number = int(self.label[places[0], places[1]])
        return self.motions[number - 1] if number > 0 else None

    @draws
    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the map, a colour for each motion.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        **style
            For matplotlib's ``pcolormesh``.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> basins.plot().figure.savefig("basins.png")  # doctest: +SKIP
        """
        colors = extra("matplotlib.colors")
        patches = extra("matplotlib.patches")
        ax = new_axes(ax)
        drawn = [(number, self._named(number), COLORS[(number - 1) % len(COLORS)]) for number in range(1, len(self.motions) + 1)]
        drawn += [(number, *told) for number, told in _OTHERS.items()]
        drawn = [(number, name, color) for number, name, color in drawn if (self.label == number).any()]
        place = np.zeros(self.label.shape, int)
        for at, (number, _, _) in enumerate(drawn):
            place[self.label == number] = at
        palette = colors.ListedColormap([color for _, _, color in drawn])
        ax.pcolormesh(self.displacement, self.velocity, place, **{
            "shading": "nearest", "rasterized": True, "cmap": palette, "vmin": -0.5, "vmax": len(drawn) - 0.5, **style})
        handles = [patches.Patch(facecolor=color, edgecolor="0.5", label=name) for _, name, color in drawn]
        ax.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.14), frameon=False, fontsize="small")
        ax.grid(visible=False)
        ax.set_xlabel(f"displacement of mesh {self.mesh} at the start  {units_of(self.train, None).length}")
        ax.set_ylabel(rf"velocity of mesh {self.mesh} at the start  $/\, b_c \omega_c$")
        return ax

    def _named(self, number: int) -> str:
        motion = self.motions[number - 1]
        rms = ", ".join(f"{value:.3g}" for value in motion.rms)
        repeats = "one period" if motion.period == 1 else f"{motion.period} periods"
        return f"repeats after {repeats}, rms of the paper {rms}: {self.grid_share[number - 1]:.1%}"

    def to_dataset(self) -> Dataset:
        """The fields as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        attributes, arrays = self._columns()
        return motions_dataset(self.path, self.motions, (), attributes, **arrays)

    @classmethod
    def _from(cls, box: Box, train: Description | None = None) -> Basins | None:
        found = super()._from(box, train)
        if found is None:
            return None
        return replace(
            found,
            frequency=box.results()[cls.path].attributes["frequency"],  # the motions have a column of this name
            motions=[Motion(train=train, **fields) for fields in motions_of(box, cls.path)],
        )

    def _columns(self) -> tuple[dict[str, Any], dict[str, Any]]:
        attributes, arrays = super()._columns()
        del attributes["motions"]
        return attributes, arrays

    def _put(self, box: Box) -> None:
        attributes, arrays = self._columns()
        put_table(box, self.path, "motion", self.motions, attributes, arrays, "basins")
