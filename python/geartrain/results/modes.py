"""Natural frequencies and mode shapes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._core.dataset import dataset
from .._core.description import Description
from .._core.table import Table
from .._core.text_table import text_table
from .._core.units import hertz_of
from ..plots.draw import check_number, new_axes
from ..plots.schematic import draw_schematic, figure_size

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset

__all__ = ["Modes"]


@dataclass(frozen=True, eq=False, repr=False)
class Modes(Table):
    """Modes of the mean linear system: contact everywhere, mean mesh stiffness; a rigid-body mode is left out.

    Attributes
    ----------
    natural_frequency : ndarray, (modes,)
        Undamped, over the characteristic frequency, ascending.
    damped_frequency : ndarray, (modes,)
        Imaginary part of the damped eigenvalue, over the characteristic frequency.
    damping_ratio : ndarray, (modes,)
    shape : ndarray, (modes, elements)
        Displacement of each elastic element, the largest of a mode being 1.
    element : tuple of str
        What the elements are: ``'shaft 1'``, ``'mesh 1'``, ...
    element_label : tuple of str
        Names of the two bodies that each joins, ``'pinion - wheel'``; in a chain as ``element``.
    state : tuple of str, or None
        What the values of ``Motion.state`` are: ``'mesh 1'``, the displacement of this element, ``'rate of mesh 1'``, its velocity.
        None of a file written by an earlier version.
    body : tuple of str, or None
        Names of the bodies; None of a file written by an earlier version.
    rotation : ndarray, (modes, bodies), or None
        Rotation of each body, positive as it turns when the train runs, the turning of the whole train left out, the largest of a
        mode being 1.
    energy : ndarray, (modes, elements), or None
        Stiffness times squared displacement of each element in the motion with this rotation [N m].
    rigid_rotation : ndarray, (motions, bodies), or None
        Rotation of each body in the motions that deflect no element, the largest 1; None where springs to ground hold the train.
    kind : tuple of str, or None
        With planetary sets ``'torsional'``, the planets of each set move alike; ``'planets of stage 1'``, where sun, ring and
        carrier stand still; else ``'mixed'``. None without planetary sets.
    train : Train
    """

    path = "/modes"

    natural_frequency: NDArray[np.float64]
    damped_frequency: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    shape: NDArray[np.float64]
    element: tuple[str, ...]
    element_label: tuple[str, ...]
    state: tuple[str, ...] | None = None
    body: tuple[str, ...] | None = None
    rotation: NDArray[np.float64] | None = None
    energy: NDArray[np.float64] | None = None
    rigid_rotation: NDArray[np.float64] | None = None
    kind: tuple[str, ...] | None = None
    train: Description | None = field(default=None, repr=False)

    def __str__(self) -> str:
        hertz = self.natural_frequency_hertz
        return text_table({
            "mode": range(1, len(self.natural_frequency) + 1),
            "natural [Hz]": [None] * len(self.natural_frequency) if hertz is None else hertz.tolist(),
            "Lambda": self.natural_frequency.tolist(),
            "damping [%]": (100 * self.damping_ratio).tolist(),
            **({} if self.kind is None else {"kind": list(self.kind)}),
        })

    __repr__ = __str__

    @property
    def natural_frequency_hertz(self) -> NDArray[np.float64] | None:
        """Undamped natural frequencies in Hz, (modes,); None without a train."""
        return hertz_of(self.train, self.natural_frequency)

    def to_dataset(self) -> Dataset:
        """The modes as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        attributes, arrays = self._columns()
        hertz = {"natural_frequency_hertz": self.natural_frequency_hertz}
        return dataset(self.path, {**arrays, **hertz}, attributes, ("natural_frequency_hertz",))

    def energy_shares(self, mode: int) -> dict[str, float]:
        """Share of each element in the potential energy of a mode, counted from 1, by the names of ``element``."""
        check_number("mode", mode, len(self.natural_frequency))
        if self.energy is None:
            raise ValueError("these modes were written by an earlier version, without energies")
        energy = self.energy[mode - 1]
        return dict(zip(self.element, (energy / energy.sum()).tolist()))

    def plot(self, mode: int = 1, ax: Axes | None = None) -> Axes:
        """Draw a mode on the train: the colour of a body is its rotation, a line is as thick as the element has potential energy.

        Parameters
        ----------
        mode : int
            Counted from 1.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> train.modes().plot(2).figure.savefig("mode.png")  # doctest: +SKIP
        """
        shares = self.energy_shares(mode)
        if self.train is None or self.rotation is None:
            raise ValueError("these modes have no train, or no rotations of its bodies")
        ax = new_axes(ax, figsize=figure_size(self.train))
        from matplotlib import colormaps
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import Normalize

        shades = ScalarMappable(Normalize(-1, 1), colormaps["coolwarm"])
        draw_schematic(self.train, ax, body_color=shades.to_rgba(self.rotation[mode - 1]), strength=shares)
        figure = ax.get_figure()
        assert figure is not None
        figure.colorbar(shades, ax=ax, label="rotation, over the largest", shrink=0.8, ticks=[-1, 0, 1])
        hertz = self.natural_frequency_hertz
        assert hertz is not None
        damping = 100 * self.damping_ratio[mode - 1]
        kind = "" if self.kind is None else f",  {self.kind[mode - 1]}"
        ax.set_title(f"mode {mode}:  {hertz[mode - 1]:.4g} Hz,  {damping:.2g} % of critical damping{kind}", fontsize=10)
        return ax
