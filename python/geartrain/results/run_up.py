"""Motions while the speed goes linearly in time from one value to another."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core.dataset import dataset
from .._core.description import Description, bearings_of
from .._core.table import Table
from .._core.units import Unit, in_own_unit, units_of
from ..errors import InputError, shown
from ..files.recording import Channel, Recording, channels_of
from ..plots.captions import force_unit
from ..plots.draw import COLORS, draws, new_axes, put_legend
from ..plots.panels import are_unequal, name_height, new_panels, scale
from .campbell import exciting_orders
from .order_cuts import cut_orders
from .orders import orders_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from xarray import Dataset

__all__ = ["RunUp"]

Array = NDArray[np.float64]

#: What is drawn: its dimension beside time, and the label of its axis.
_KINDS = {
    "mesh_force": ("mesh", "mesh force, smallest to largest", "N"),
    "shaft_torque": ("shaft", "shaft torque, smallest to largest", "N m"),
    "displacement": ("mesh", "mesh displacement, smallest to largest", ""),
}
#: Most rows of a waterfall; neighbouring lines of a spectrum share a row.
_ROWS = 600
_MOST_PICTURES = 100_000
#: Least amplitude that a waterfall has room for, over the largest; levels below the largest that its colours show [dB].
_SEEN, _DEPTH = 1e-3, 80.0


@dataclass(frozen=True, eq=False, repr=False)
class RunUp(Table, Recording):
    """The motion of a train while Lambda goes linearly in time from one value to another.

    The speed is prescribed. Forces and torques have the part that accelerates the inertias where every mesh has teeth, which tell
    how fast each body turns; given torques stay as they are, and the body that balances takes what remains. Without teeth the
    ramp is of the frequency only.

    Attributes
    ----------
    time : ndarray, (samples,)
        [s], equidistant.
    frequency : ndarray, (samples,)
        Lambda.
    fundamental_frequency : ndarray, (samples,)
        Frequency of the fundamental [Hz].
    speed : ndarray, (samples,), or None
        [rpm]; None where not every mesh has teeth.
    displacement : ndarray, (samples, meshes)
        Over the characteristic length.
    mesh_force : ndarray, (samples, meshes)
        [N], of a coupling the torque [N m], damping and the acceleration of the inertias included.
    shaft_torque : ndarray, (samples, shafts)
        [N m], damping, static torque and the acceleration of the inertias included; NaN where rigid shafts side by side leave
        it undetermined.
    window_time : ndarray, (windows,)
        Middle of each window [s]; a window is a cycle of the slowest mesh.
    mesh_force_minimum, mesh_force_maximum : ndarray, (windows, meshes)
        Extremes over each window [N], between samples as well.
    shaft_torque_minimum, shaft_torque_maximum : ndarray, (windows, shafts)
        Likewise [N m].
    reaction_torque : ndarray, (samples, held bodies), or None
        Torque by which each held body is held [N m]; None where none is held.
    reaction_torque_minimum, reaction_torque_maximum : ndarray, (windows, held bodies), or None
        Likewise over each window.
    state : ndarray
        At the end of the last window, as ``Motion.state``.
    start_period : int
        Period of the steady motion with which it begins; 0 where it begins with a state of no steady motion, or its period is not
        known because it is too long.
    start_settling : float
        Time for which it settled by the time constants of the train before it begins [s], where the common period of the meshes is
        too long; 0 where it settled from period to period, or not at all.
    start_ringing : float
        Amplitude of free vibrations that take too long to die out, when they were last read, over the alternating displacement,
        the largest of all meshes, where it settled by time constants; nan where it is not known.
    ended : str
        Why it ended, in words.
    complete : bool
        Whether it reached the end of the ramp.
    mesh_label, shaft_label, held_label : tuple of str
        Of each mesh, of each shaft and of each held body.
    train : Train or None
    """

    path = "/run_up"

    time: Array
    frequency: Array
    fundamental_frequency: Array
    displacement: Array
    mesh_force: Array
    shaft_torque: Array
    window_time: Array
    mesh_force_minimum: Array
    mesh_force_maximum: Array
    shaft_torque_minimum: Array
    shaft_torque_maximum: Array
    state: Array
    start_period: int
    ended: str
    complete: bool
    mesh_label: tuple[str, ...]
    shaft_label: tuple[str, ...]
    speed: Array | None = None
    train: Description | None = None
    start_settling: float = 0.0
    start_ringing: float = float("nan")
    reaction_torque: Array | None = None
    reaction_torque_minimum: Array | None = None
    reaction_torque_maximum: Array | None = None
    held_label: tuple[str, ...] | None = None

    def __repr__(self) -> str:
        return f"<RunUp over {self.time[-1]:.6g} s, {len(self.time)} samples: {in_own_unit(self.ended, self.train)}>"

    @property
    def coupling_torque(self) -> Array:
        """Torque of the couplings [N m], (samples, couplings): those of ``mesh_force``."""
        first = len(self.train.meshes) if self.train else 0
        return self.mesh_force[:, first:first + len(self.train.couplings)] if self.train else self.mesh_force[:, :0]

    @property
    def bearing_force(self) -> Array:
        """Forces on the bearings [N], in x and y, (samples, bearings, 2): the last of ``mesh_force``."""
        return bearings_of(self.mesh_force, self.train)

    def to_dataset(self) -> Dataset:
        """The run-up as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        attributes, arrays = self._columns()
        attributes = {name: value for name, value in attributes.items() if value is not None}
        return dataset(self.path, arrays, attributes, ("frequency", "speed", "fundamental_frequency", "window_time"))

    def order_cuts(
        self, orders: Iterable[float | str] | None = None, *, what: str = "mesh_force", cycles: float | None = None
    ) -> Dataset:
        """Amplitude and phase of orders over the speed, as an xarray Dataset; needs xarray.

        Each order is followed by its own phase, in windows of equally many cycles with the weights of Hann.

        Parameters
        ----------
        orders : iterable of float or str, optional
            As in `waterfall`: names, or multiples of the fundamental, which may turn slower than any shaft.
        what : {'mesh_force', 'shaft_torque', 'displacement'}
        cycles : float, optional
            Cycles of the fundamental in a window. Default: as many as separate the orders from one another and from multiples of
            mesh orders and sidebands beside them, at most a quarter of the ramp; a warning says where that is not enough.

        Returns
        -------
        xarray.Dataset
            ``amplitude`` and ``phase`` (order, mesh or shaft, time), with the names of the orders, the speed and the time.

        Examples
        --------
        >>> run_up = train.run_up(start=0.4, stop=0.8, duration=0.2)
        >>> run_up.order_cuts([1, 2]).amplitude.sizes  # doctest: +SKIP
        Frozen({'order': 2, 'mesh': 2, 'time': 400})
        """
        return cut_orders(self, orders, what, cycles)

    def _recorded(self, periods: int, dense: int) -> tuple[Array, list[Channel], bool]:
        channels = channels_of(self.train, self.mesh_force, self.shaft_torque)
        if self.speed is not None:
            channels.append(Channel("speed", "speed", "", "rpm", self.speed))
        return self.time, channels, False

    @draws
    def plot(self, what: str = "mesh_force", ax: Axes | None = None, *, unit: Unit | None = None, **style: Any) -> Axes:
        """Draw the range that each force, torque or displacement goes through, over the frequency.

        The range is that of a period of the slowest excitation, as of the torque of an engine, or of the slowest mesh. On axes of
        their own shafts or meshes too unequal for one picture have panels one below another, of which the uppermost is returned.

        Parameters
        ----------
        what : {'mesh_force', 'shaft_torque', 'displacement'}
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the frequency; unless told rpm where Lambda is the speed in rpm, else Lambda.
        **style
            For matplotlib's ``fill_between``.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> run_up = train.run_up(start=0.4, stop=0.8, duration=0.2)
        >>> run_up.plot().figure.savefig("run_up.png")  # doctest: +SKIP
        """
        along, label, dimension = _one_of("what", what, _KINDS)
        units = units_of(self.train, unit)
        frequency = self.frequency * units.per_lambda
        if what == "displacement":
            # The first sample of each window, by the phase.
            turns = self.time * (self.fundamental_frequency[0] + self.fundamental_frequency) / 2
            first = np.unique(np.floor(turns * (len(self.window_time) / turns[-1])), return_index=True)[1]
            low, high = np.minimum.reduceat(self.displacement, first), np.maximum.reduceat(self.displacement, first)
            frequency = frequency[first]
        else:
            low, high = getattr(self, f"{what}_minimum"), getattr(self, f"{what}_maximum")
            frequency = np.interp(self.window_time, self.time, frequency)
        wide = self._windows_of_the_slowest()
        low, high = -_running_maximum(-low, wide), _running_maximum(high, wide)
        names = getattr(self, f"{along}_label")
        known = [place for place in range(len(names)) if not np.isnan(low[:, place]).any()]
        parts = [np.concatenate([low[:, place], high[:, place]]) for place in known]
        own, split = ax is None, ax is None and are_unequal(parts, ranges=True)
        axes = new_panels(ax, [names[place] for place in known], split) or [new_axes(ax)]
        for place, part, panel in zip(known, parts, axes):
            look: dict[str, Any] = {"color": COLORS[place % len(COLORS)], "alpha": 0.7, "lw": 1.0} if split else {
                "alpha": 0.7, "lw": 1.0, "label": names[place]}
            panel.fill_between(frequency, low[:, place], high[:, place], **{**look, **style})
            if split:
                scale(panel, part, from_zero=False)
        axes[-1].set_xlim(frequency[0], frequency[-1] if frequency[-1] != frequency[0] else None)
        axes[-1].set_xlabel(units.frequency)
        if what == "mesh_force":
            dimension = force_unit(self.train)
        name_height(axes, f"{label}  {units.length}" if what == "displacement" else f"{label}  [{dimension}]")
        if not split:
            put_legend(axes[0], own)
        return axes[0]

    def _windows_of_the_slowest(self) -> int:
        """Windows in a period of the slowest excitation; a window is a period of the slowest mesh."""
        if self.train is None:
            return 1
        slowest = min((order.order for order in exciting_orders(self.train)), default=1)
        return max(1, ceil(int(min(self.train._outline["order"])) / slowest))

    def spectra(self, what: str = "mesh_force", number: int = 1, pictures: int = 200) -> tuple[Array, Array, Array]:
        """Amplitude spectra of overlapping stretches of the ramp, each weighted by a Hann window, its mean left out.

        Parameters
        ----------
        what : {'mesh_force', 'shaft_torque', 'displacement'}
        number : int
            Of the mesh or of the shaft, from 1.
        pictures : int
            Number of stretches. Each is as long as a tooth mesh takes to change its frequency by about two lines of the spectrum.

        Returns
        -------
        time : ndarray, (pictures,)
            Middle of each stretch [s].
        frequency : ndarray, (lines,)
            [Hz]
        amplitude : ndarray, (pictures, lines)
            In the unit of what it is of.
        """
        along, *_ = _one_of("what", what, _KINDS)
        labels = getattr(self, f"{along}_label")
        if isinstance(number, bool) or number not in range(1, len(labels) + 1):
            raise InputError(f"number = {shown(number)}: must be 1 to {len(labels)}, the number of a {along}")
        if isinstance(pictures, bool) or not isinstance(pictures, Integral) or not 1 <= pictures <= _MOST_PICTURES:
            raise InputError(f"pictures = {shown(pictures)}: must be a whole number from 1 to {_MOST_PICTURES}")
        values: Array = getattr(self, what)[:, number - 1]
        samples, rate = len(values), (len(values) - 1) / self.time[-1]
        # The samples are 32 of a period of the fastest mesh, unless asked otherwise.
        order = max(1.0, rate / (32 * self.fundamental_frequency.max()))
        drift = order * abs(self.fundamental_frequency[-1] - self.fundamental_frequency[0]) / self.time[-1]
        length = int(min(samples, max(64, 2 * rate / np.sqrt(max(drift, (16 / self.time[-1]) ** 2)))))
        weight = np.hanning(length)
        first = np.unique(np.linspace(0, samples - length, pictures).astype(int))
        amplitude = np.array([
            np.abs(np.fft.rfft((stretch - stretch.mean()) * weight))
            for stretch in (values[place:place + length] for place in first)
        ]) * (2 / weight.sum())
        return self.time[first] + (length - 1) / (2 * rate), np.fft.rfftfreq(length, 1 / rate), amplitude

    @draws
    def waterfall(
        self, what: str = "mesh_force", number: int = 1, ax: Axes | None = None, *, unit: Unit | None = None,
        orders: Iterable[float | str] | None = None, highest: float | None = None, **style: Any,
    ) -> Axes:
        """Draw the `spectra`: amplitude as colour over the speed and the frequency, with both its value and its level in dB.

        Levels are over 1 N, 1 N m or the unit of displacements.

        Parameters
        ----------
        what : {'mesh_force', 'shaft_torque', 'displacement'}
        number : int
            Of the mesh or of the shaft, from 1.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the speed, along which the spectra stand; unless told rpm where Lambda is the speed in rpm, else Lambda.
        orders : iterable of float or str, optional
            To draw as lines: multiples of the fundamental frequency, ``Order.order`` of a Campbell diagram, or names such as
            ``'mesh 1'``, ``'2 x mesh 1'``, ``'mesh 2 - mesh 1'`` and, of a train with teeth, the name of a body for its
            revolution. Unless told the meshes and their doubles.
        highest : float, optional
            Highest frequency drawn [Hz]; unless told that of the highest amplitude above a thousandth of the largest, up to an
            eighth of the sampling rate.
        **style
            For matplotlib's ``pcolormesh``.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> run_up = train.run_up(start=0.4, stop=0.8, duration=0.2)
        >>> ax = run_up.waterfall(number=2, orders=[1, 2, 3], highest=6000.0)
        >>> ax.get_ylabel()
        'frequency  [Hz]'
        """
        time, lines, amplitude = self.spectra(what, number)
        along, _, dimension = _one_of("what", what, _KINDS)
        units = units_of(self.train, unit)
        ax = new_axes(ax, figsize=(7.4, 4.8))
        if highest is None:
            seen = amplitude[:, lines <= lines[-1] / 4].max(axis=0)
            highest = 1.05 * float(lines[np.flatnonzero(seen >= _SEEN * seen.max())[-1]]) or float(lines[-1]) / 4
        count = max(2, int(np.searchsorted(lines, highest, side="right")))
        group = np.arange(0, count, -(-count // _ROWS))
        shares = np.maximum.reduceat(amplitude[:, :count], group, axis=1)
        largest = shares.max() or 1.0
        speed = np.interp(time, self.time, self.frequency * units.per_lambda)
        across = speed if np.ptp(speed) > 0 else time
        level = 20 * np.log10(np.maximum(shares, 1e-5 * largest)).T
        top = float(np.ceil(level.max()))
        image = ax.pcolormesh(
            across, lines[group], level,
            **{"shading": "nearest", "rasterized": True, "vmin": top - _DEPTH, "vmax": top, **style},
        )
        _name_levels(ax, image, units.length if what == "displacement" else f"[{dimension}]")
        fundamental = np.interp(time, self.time, self.fundamental_frequency)
        # Width of a letter and of the frame of a name, and its height, over the axes.
        extent, point = ax.get_window_extent(), ax.figure.dpi / 72
        letter, frame, tall = 5.0 * point / extent.width, 8.0 * point / extent.width, 14.0 * point / extent.height
        taken: list[tuple[float, float, float]] = []
        for order, name in orders_of(self.train, orders).items():
            ax.plot(across, order * fundamental, color="white", lw=1.0, ls="--")
            inside = np.flatnonzero((order * fundamental <= 0.97 * highest) & (order * fundamental >= 0.03 * highest))
            wide = letter * len(name) + frame
            # Near the fast end of the line, inside of the frame and clear of other names; nowhere else than there.
            for end in inside[np.argsort(-fundamental[inside])]:
                place = float((across[end] - across[0]) / (across[-1] - across[0])), float(order * fundamental[end] / highest)
                clear = all(abs(place[0] - x) > (wide + other) / 2 or abs(place[1] - y) > tall for x, y, other in taken)
                if clear and wide / 2 < place[0] < 1 - wide / 2:
                    taken.append((*place, wide))
                    ax.annotate(name, (across[end], order * fundamental[end]), color="white", ha="center", va="center",
                                fontsize=8, bbox={"boxstyle": "round,pad=0.15", "facecolor": "0.15", "edgecolor": "none"})
                    break
        ax.set_ylim(0, highest)
        ax.set_xlim(across[0], across[-1])
        ax.grid(visible=False)
        ax.set_xlabel(units.frequency if across is speed else "time  [s]")
        ax.set_ylabel("frequency  [Hz]")
        ax.set_title(f"{what.replace('_', ' ')}, {getattr(self, f'{along}_label')[number - 1]}")
        return ax


def _name_levels(ax: Axes, image: Any, unit: str) -> None:
    """A bar of the colours with levels in dB on its right and amplitudes on its left."""
    from matplotlib.ticker import FuncFormatter, LogLocator

    figure = ax.get_figure()
    assert figure is not None
    bar = figure.colorbar(image, ax=ax, label=f"dB re 1 {unit.strip('[] ')}", pad=0.02)
    amplitude = bar.ax.secondary_yaxis("left", functions=(_amplitude, _level))
    amplitude.set_yscale("log")
    amplitude.yaxis.set_major_locator(LogLocator())
    amplitude.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    amplitude.set_ylabel(f"amplitude  {unit}")


def _amplitude(level: ArrayLike) -> ArrayLike:
    """The amplitude of a level in dB."""
    found: Array = 10.0 ** (np.asarray(level, float) / 20)
    return found


def _level(amplitude: ArrayLike) -> ArrayLike:
    """The level of an amplitude in dB; -inf of zero."""
    with np.errstate(divide="ignore"):
        found: Array = 20 * np.log10(np.asarray(amplitude, float))
    return found


def _running_maximum(values: Array, wide: int) -> Array:
    """Largest of each column over so many rows around each row, as many as there are at the ends."""
    before = (wide - 1) // 2
    padded = np.pad(values, ((before, wide - 1 - before), (0, 0)), mode="edge")
    largest: Array = np.lib.stride_tricks.sliding_window_view(padded, wide, axis=0).max(axis=-1)
    return largest


def _one_of(name: str, value: str, table: dict[str, tuple[str, str, str]]) -> tuple[str, str, str]:
    """The row of a table by its name."""
    if value not in table:
        raise InputError(f"{name} = {shown(value)}: must be {', '.join(map(repr, table))}")
    return table[value]
