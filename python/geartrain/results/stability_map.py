"""Stability maps (stability charts; of a linear train Ince-Strutt diagrams) over frequency and one parameter."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.dataset import dataset
from .._core.description import Description
from .._core.extras import extra
from .._core.table import Table
from .._core.units import Unit, hertz_of, speed_of, units_of
from ..errors import InputError, shown
from ..plots.captions import number_words
from ..plots.draw import COLORS, draws, new_axes
from .locus import Locus

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset

__all__ = ["StabilityMap"]

Array = NDArray[np.float64]

_NAMES = {
    "stiffness_variation": r"stiffness variation  $\kappa$",
    "mesh_damping_ratio": r"mesh damping ratio  $\zeta$",
    "input_torque": "input torque",
    "half_backlash": "half backlash",
}
# Short names of a map, and the same parameters by the names of a locus.
_OF_EVERY_MESH = {"mesh_damping_ratio": "mesh * damping_ratio", "half_backlash": "mesh * half_backlash"}
_TITLES = {
    "spectral_radius": "largest |multiplier|, stable below 1",
    "stable_motions": "number of stable motions",
    "motions": "number of motions",
}


@dataclass(frozen=True, eq=False, repr=False)
class StabilityMap(Table):
    """Stability on a grid of a parameter (rows) and Lambda.

    Attributes
    ----------
    name, unit : str
        The parameter, as in ``&stability_map``, and its unit.
    linear : bool
        Whether it is that of the train without backlash.
    frequency : ndarray, (points,)
        Lambda.
    parameter : ndarray, (rows,)
    motions, stable_motions : ndarray of int, (rows, points)
        Motions of the period of the fundamental on the branch that each row has, and how many of them are stable. Without a
        stable one the train does something else, of a longer period or of none.
    multiplier : ndarray of complex, (rows, points)
        The Floquet multiplier of largest magnitude, over a period of the fundamental, of the motion that has it smallest: near
        -1 the period doubles, near +1 there is a fold or a resonance at a natural frequency. NaN where there is no motion.
    rms : ndarray, (rows, points, meshes), or None
        The largest of the stable motions, over the characteristic length; NaN where there is none. None for a linear map.
    row_done, row_whole : ndarray of bool, (rows,)
        Whether the row is computed, as every row is that a map holds, be it stopped early; whether its branch got through the
        range, so that no motion of it is missing.
    ended : str
        Why it ended, in words.
    complete : bool
        Whether all rows are done and whole.
    mesh_label : tuple of str, or None
        Of each mesh, see `Train.mesh_labels`; None for a linear map.
    train : Train
    """

    path = "/stability_map"
    names = {"name": "parameter_name", "unit": "parameter_unit"}  # noqa: RUF012 (with an annotation it would be a field)

    name: str
    unit: str
    linear: bool
    frequency: Array
    parameter: Array
    motions: NDArray[np.intc]
    stable_motions: NDArray[np.intc]
    multiplier: NDArray[np.complex128]
    rms: Array | None
    row_done: NDArray[np.bool_]
    row_whole: NDArray[np.bool_]
    ended: str
    complete: bool
    mesh_label: tuple[str, ...] | None = None
    train: Description | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        rows, points = self.motions.shape
        return f"<StabilityMap of {self.name} x Lambda, {rows} x {points}: {self.ended}>"

    @property
    def spectral_radius(self) -> Array:
        """Magnitude of ``multiplier``, (rows, points): below 1 there is a stable motion."""
        return np.abs(self.multiplier)

    @property
    def speed(self) -> Array | None:
        """Speed [rpm] of the body that `Train.speed_name` tells, (points,); None where not every mesh has teeth."""
        return speed_of(self.train, self.frequency)

    @property
    def fundamental_frequency(self) -> Array | None:
        """Frequency of the fundamental [Hz], (points,); None without a train."""
        return hertz_of(self.train, self.frequency)

    @draws
    def plot(
        self, what: str = "spectral_radius", ax: Axes | None = None, *, curves: Locus | Iterable[Locus] = (),
        unit: Unit | None = None, **style: Any,
    ) -> Axes:
        """Draw the map, with the boundary of stability as a line.

        Parameters
        ----------
        what : {'spectral_radius', 'stable_motions', 'motions'}
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        curves : Locus or iterable of Locus
            Drawn over the map: curves of special points over the same parameter, of the same train.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the frequency; unless told rpm where Lambda is the speed in rpm, else Lambda.
        **style
            For matplotlib's ``pcolormesh``.

        Returns
        -------
        matplotlib.axes.Axes

        Raises
        ------
        InputError
            Also where a curve is over another parameter.

        Examples
        --------
        >>> chart.plot().figure.savefig("map.png")  # doctest: +SKIP
        """
        if what not in _TITLES:
            raise InputError(f"what = {shown(what)}: must be {', '.join(map(repr, _TITLES))}")
        curves = [curves] if isinstance(curves, Locus) else list(curves)
        for curve in curves:
            if not isinstance(curve, Locus):
                raise InputError(f"curves: {shown(curve)} is no gt.Locus")
            if _full(curve.parameter_name) != _full(self.name):
                raise InputError(f"curves: {curve!r} is over {curve.parameter_name!r}, the map over {self.name!r}")
        units = units_of(self.train, unit)
        frequency = units.per_lambda * self.frequency
        plt = extra("matplotlib.pyplot")
        ax = new_axes(ax)
        values: NDArray[Any] = getattr(self, what)
        if what == "spectral_radius":
            # White is 1. Where all multipliers are near 1, fewer colours would leave a white picture.
            far = float(np.nanmax(abs(values - 1), initial=0.0))
            half = min(0.5, far) if far > 0 else 0.5
            defaults: dict[str, Any] = {"cmap": "RdBu_r", "vmin": 1 - half, "vmax": 1 + half}
        else:
            values = np.ma.masked_less(values, 0)
            most = max(1, int(values.max()) if values.count() else 1)
            colours = plt.get_cmap("viridis", most + 1)
            defaults = {"cmap": colours, "vmin": -0.5, "vmax": most + 0.5}
        # Rasterised, so that a picture as vectors stays small; set off from the grid by half a cell on each side.
        image = ax.pcolormesh(
            frequency, self.parameter, values, **{"shading": "nearest", "rasterized": True, **defaults, **style}
        )
        figure = ax.get_figure()
        assert figure is not None
        bar = figure.colorbar(image, ax=ax, label=_TITLES[what])
        if what != "spectral_radius":
            bar.set_ticks(range(most + 1))
        elif min(values.shape) > 1 and np.nanmin(values) < 1 < np.nanmax(values):
            ax.contour(frequency, self.parameter, values, levels=[1.0], colors="black", linewidths=0.8)
        if curves:
            limits = ax.axis()
            # Set off from the colours of the map.
            rim = extra("matplotlib.patheffects").withStroke(linewidth=3.5, foreground="white")
            for curve, color in zip(curves, cycle(COLORS)):
                curve.plot(ax, across="frequency", unit=unit, color=color, path_effects=[rim])
            ax.axis(limits)
            ax.legend(fontsize=8)
        ax.grid(visible=False)
        ax.set_title(map_words(self, unit).replace("; ", ";\n"), fontsize=8)
        ax.set_xlabel(units.frequency)
        ax.set_ylabel(_NAMES.get(self.name, self.name.replace("_", " ")) + (f"  [{self.unit}]" if self.unit != "1" else ""))
        return ax

    def to_dataset(self) -> Dataset:
        """The map as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        attributes, arrays = self._columns()
        derived = {name: getattr(self, name) for name in ("spectral_radius", "speed", "fundamental_frequency")}
        found = dataset(self.path, {**arrays, **derived}, attributes)
        found["parameter"].attrs["units"] = self.unit
        return found


def map_words(chart: StabilityMap, unit: Unit | None = None) -> str:
    """Whether a map has stable and unstable points, and how narrow a range of frequencies it does not show."""
    units = units_of(chart.train, unit)
    stable = chart.stable_motions > 0
    words = "stable in part of the map"
    if stable.all():
        words = f"stable everywhere: |multiplier| at most {number_words(float(np.nanmax(chart.spectral_radius)))}"
    elif not stable.any():
        words = "no stable motion of this period anywhere"
    if len(chart.frequency) > 1:
        step = units.per_lambda * float(np.diff(chart.frequency).max())
        words += f"; ranges narrower than {number_words(step)} {units.unit}, the step, may be missed"
    return words


def _full(name: str) -> str:
    """The name by which a locus knows a parameter; a body may be named without the word body."""
    return _OF_EVERY_MESH.get(name, name).removeprefix("body ")
