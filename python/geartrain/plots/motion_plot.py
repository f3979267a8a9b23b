"""A motion as pictures: time history and spectrum, phase plane, Poincare section."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description, half_gaps, part_names
from .._core.units import Unit, Units, units_of
from ..errors import InputError, shown
from ..results.campbell import exciting_orders
from ..results.motion_check import check_motion
from ..results.orders import named_orders
from ..results.trajectory import Trajectory
from .captions import force_unit, force_words, motion_words
from .draw import DASHES, check_number, draw_lines, draws, line_style, marker_of, new_axes, put_legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Pictures"]

Array = NDArray[np.float64]

#: Lines of a spectrum that are drawn, and that are named, relative to the largest; most names.
_VISIBLE, _NAMED, _MOST_NAMES = 3e-3, 0.03, 12
#: Periods of the fundamental of a motion without a period.
_HISTORY, _PLANE, _SECTION = 16, 100, 1000
#: Periods of the slowest excitation that a time history shows at least.
_SHOWN = 4
#: Longest chord of a phase plane, over the extent of the motion; most points of a closed curve.
_CHORD, _POINTS = 0.005, 200_000
#: Height of a letter of a name, along which it stands, in points.
_LETTER = 4.2
#: Twist of a coupling [mrad] per displacement [m]: on a radius of 1 mm.
_MRAD = 1e6
#: Least room for a name, over the width of the axes.
_ROOM = 0.022


class Pictures:
    """A motion as pictures."""

    frequency: float
    period: int
    window: float
    kind: str
    stable: Any
    rms: Array
    coupling_energy_loss: Array | None
    train: Description | None

    def trajectory(self, periods: int, *, samples: int = 0) -> Trajectory:
        """The motion over a number of periods."""
        raise NotImplementedError

    def spectrum(self, what: str = "displacement") -> tuple[Array, Array]:
        """Orders and amplitudes."""
        raise NotImplementedError

    def _samples(self) -> int:
        """Samples of a period of the fundamental: 256, or 32 of the fastest mesh."""
        return max(256, 32 * int(max(self.train._outline["order"])) if self.train else 0)

    @draws
    def plot(
        self, mesh: int | None = None, axes: Sequence[Axes] | None = None, *, periods: float | None = None,
        spectrum: str = "displacement", unit: Unit | None = None, **style: Any,
    ) -> Sequence[Axes]:
        """Draw the time history of displacement and force, and a spectrum: of meshes, couplings and bearings.

        The legend names the speed. Where meshes have different orders, or bodies their revolutions, the largest lines of the
        spectrum have names.

        Parameters
        ----------
        mesh : int, optional
            Which mesh, coupling or direction of a bearing, counted from 1 in the order of ``mesh_labels``; all unless told.
        axes : three of matplotlib.axes.Axes, optional
            Where to draw displacement, force and spectrum; a new figure unless told.
        periods : float, optional
            Periods of the fundamental, 0.1 for a tenth of one. Unless told a period of the motion, or 16 where it has none; of a
            train whose slowest excitation has an order n > 1, as one with hunting teeth, not more than 4/n, or 16/n: a few tooth
            periods.
        spectrum : {'displacement', 'mesh_force'}
            Of what the spectrum is.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Lambda: time in periods of the fundamental, orders in its multiples. rpm: time in ms, orders in multiples of the speed.
            Hz: time in ms, the spectrum over the frequency. Unless told rpm where Lambda is the speed in rpm, else Lambda.
        **style
            For the lines of matplotlib's ``plot``.

        Returns
        -------
        sequence of matplotlib.axes.Axes

        Examples
        --------
        >>> axes = branch.at(0.9)[0].plot(mesh=2)
        >>> axes[0].figure.savefig("motion.png")  # doctest: +SKIP
        """
        units = units_of(self.train, unit)
        chosen = self._chosen(mesh)
        history, part = self._history(periods)
        if axes is None:
            axes = new_axes(None, 3, figsize=(6.4, 7.2))
        if len(axes) < 3:
            raise InputError(f"axes = {shown(axes)}: must be three axes of matplotlib")
        style = line_style(style)
        names = part_names(self.train, "mesh", len(self.rms))
        time = history.time[part] * self._time_factor(units)
        if spectrum not in ("displacement", "mesh_force"):
            raise InputError(f"spectrum = {shown(spectrum)}: must be 'displacement' or 'mesh_force'")
        order, amplitude = self.spectrum(spectrum)
        visible = (amplitude > _VISIBLE * amplitude.max(initial=0.0)).any(axis=1)
        places = order * self._order_factor(units)
        for row, column in enumerate(chosen):
            own = {"label": names[column], "linestyle": DASHES[row % len(DASHES)], **style}
            (line,) = axes[0].plot(time, history.displacement[part, column], **own)
            axes[1].plot(time, history.mesh_force[part, column], **{**own, "color": line.get_color()})
            width = max(1.0, 3.0 - row) if len(chosen) > 1 else 1.5
            draw_lines(axes[2], places[visible], amplitude[visible, column], width, line.get_color(), marker_of(row))
        if visible.any():
            # From below 0, so that a slow line stands clear of the frame.
            right = 1.03 * places[visible][-1] + places[0]
            axes[2].set_xlim(-0.02 * right, right)
            axes[2].set_ylim(0, 1.1 * amplitude[:, chosen].max())
            self._name_lines(axes[2], order, places, amplitude[:, chosen].max(axis=1))
        axes[0].set_ylabel(f"displacement {units.length}")
        axes[1].set_ylabel(f"{force_words(self.train)}  [{force_unit(self.train)}]")
        axes[1].set_xlabel(units.time)
        axes[2].set_ylabel(f"amplitude {units.length}" if spectrum == "displacement" else f"amplitude  [{force_unit(self.train)}]")
        turns = f"order, per revolution of {self.train.speed_name}" if self.train is not None else ""
        axes[2].set_xlabel({"Lambda": r"order, multiples of $\Lambda$", "rpm": turns, "Hz": "frequency  [Hz]"}[units.unit])
        for ax in axes[:2]:
            ax.margins(x=0)
        put_legend(axes[0], own=True, title=self._words())
        axes[0].figure.align_ylabels(list(axes)[:3])
        return axes

    @draws
    def phase_plane(self, mesh: int = 1, ax: Axes | None = None, *, periods: int | None = None, **style: Any) -> Axes:
        """Draw the velocity of a mesh over its displacement; grey where the teeth are apart.

        Parameters
        ----------
        mesh : int
            Counted from 1.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        periods : int, optional
            Periods of the fundamental; unless told a period of the motion, or 100 where it has none, or 1 where it has a window.
        **style
            For the line of matplotlib's ``plot``.
        """
        fine = 4 * self._samples()
        ax, path, units = self._plane(mesh, ax, periods or self.period or (1 if self.window else _PLANE), fine)
        if self.period:
            # The equal spacing in time leaves long chords where the velocity is large, as in a contact.
            points = [values[:, mesh - 1] / (np.ptp(values[:, mesh - 1]) or 1.0) for values in (path.displacement, path.velocity)]
            longest = float(np.hypot(*np.diff(points)).max(initial=0.0))
            finer = min(int(np.ceil(longest / _CHORD)), _POINTS // len(path.time))
            if finer > 1:
                path = self.trajectory(periods or self.period, samples=finer * fine)
        displacement, velocity = path.displacement[:, mesh - 1], path.velocity[:, mesh - 1] * units.velocity_factor
        ends = [0] if self.period else []
        ax.plot(
            np.append(displacement, displacement[ends]), np.append(velocity, velocity[ends]),
            **{"linewidth": 1.0 if self.period and fine == 1024 else 0.4, **line_style(style)},
        )
        return self._with_gap(ax, mesh)

    @draws
    def poincare_section(self, mesh: int = 1, ax: Axes | None = None, *, periods: int | None = None, **style: Any) -> Axes:
        """Draw the velocity of a mesh over its displacement once in each period of the fundamental, at phase 0.

        As many points as periods of a periodic motion, a closed curve of a quasi-periodic and a cloud of a chaotic one.

        Parameters
        ----------
        mesh : int
            Counted from 1.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        periods : int, optional
            Periods of the fundamental; unless told a period of the motion, or 1000 where it has none.
        **style
            For the points of matplotlib's ``plot``.
        """
        ax, path, units = self._plane(mesh, ax, periods or self.period or _SECTION, 1)
        displacement, velocity = path.section
        ax.plot(
            displacement[:, mesh - 1], velocity[:, mesh - 1] * units.velocity_factor,
            **{"linestyle": "none", "marker": "o", "markersize": 5.0 if self.period else 1.5, **line_style(style)},
        )
        return self._with_gap(ax, mesh)

    @draws
    def hysteresis_loop(self, coupling: int = 1, ax: Axes | None = None, *, periods: int | None = None, **style: Any) -> Axes:
        """Draw the torque of a coupling, damping and dry friction included, over its twist from rest or mid-play.

        The area is what the coupling loses.

        Parameters
        ----------
        coupling : int
            Counted from 1.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        periods : int, optional
            Periods of the fundamental; unless told a period of the motion, or 100 where it has none, or 1 where it has a window.
        **style
            For the line of matplotlib's ``plot``.

        Examples
        --------
        >>> idle = gt.read_case("namelists/driveline.nml").train.integrate(700.0)
        >>> ax = idle.hysteresis_loop()
        >>> ax.get_xlabel(), ax.get_title().split(": ")[-1]
        ('twist of engine - input  [mrad]', 'loses 5.85 W')
        """
        check_motion(self)
        if self.train is None or not self.train.couplings:
            raise InputError("hysteresis_loop: the train of the motion is not known" if self.train is None else
                             "hysteresis_loop: the train has no coupling")
        check_number("coupling", coupling, len(self.train.couplings))
        mesh = len(self.train.meshes) + coupling
        ax, path, _ = self._plane(mesh, ax, periods or self.period or (1 if self.window else _PLANE), 4 * self._samples())
        twist = path.displacement[:, mesh - 1] * self.train._outline["characteristic_length"] * _MRAD
        torque = path.mesh_force[:, mesh - 1]
        ends = [0] if self.period else []
        ax.plot(np.append(twist, twist[ends]), np.append(torque, torque[ends]), **{"linewidth": 1.0, **line_style(style)})
        name = part_names(self.train, "coupling", len(self.train.couplings))[coupling - 1]
        ax.set_xlabel(f"twist of {name}  [mrad]")
        ax.set_ylabel("torque  [N m]")
        losses = self.coupling_energy_loss
        if losses is not None:
            power = losses[coupling - 1] * self.frequency * self.train._outline["fundamental_frequency"]
            ax.set_title(f"{self._words()}: loses {power:.3g} W", fontsize="medium")
        return ax

    def _plane(self, mesh: int, ax: Axes | None, periods: int, samples: int) -> tuple[Axes, Trajectory, Units]:
        """Axes of displacement and velocity."""
        units = units_of(self.train, None)
        self._chosen(mesh)
        path = self.trajectory(periods, samples=samples)
        ax = new_axes(ax)
        name = part_names(self.train, "mesh", len(self.rms))[mesh - 1]
        ax.set_xlabel(f"displacement of {name} {units.length}")
        ax.set_ylabel(f"velocity {units.velocity}")
        ax.set_title(self._words(), fontsize="medium")
        return ax, path, units

    def _with_gap(self, ax: Axes, mesh: int) -> Axes:
        """The gap of a mesh in grey, as far as the motion comes near it."""
        if self.train is not None:
            half = half_gaps(self.train)[mesh - 1]
            ends = ax.get_xlim()
            ax.axvspan(-half, half, color="0.92", zorder=0)
            ax.set_xlim(ends)
        return ax

    def _words(self) -> str:
        """The speed and what kind of motion it is."""
        return motion_words(self.train, float(self.frequency), self.period, self.kind, self.stable)

    def _chosen(self, mesh: int | None) -> Sequence[int]:
        """Columns of the meshes to draw."""
        check_motion(self)
        if mesh is None:
            return range(len(self.rms))
        check_number("mesh", mesh, len(self.rms))
        return [mesh - 1]

    def _history(self, periods: float | None) -> tuple[Any, slice]:
        """What has the time histories, and which of its samples to draw."""
        if periods is not None:
            if isinstance(periods, bool) or not isinstance(periods, Real) or not 0 < periods < float("inf"):
                raise InputError(f"periods = {shown(periods)}: must be a number > 0")
            path = self.trajectory(ceil(periods))
            return path, slice(0, max(2, round(float(periods) * path.samples_per_period)))
        own: Any = self
        whole = self.period or self.window or _HISTORY
        slowest = min((order.order for order in exciting_orders(self.train)), default=1) if self.train else 1
        share = min(1.0, max(_SHOWN, whole) / (slowest * whole))
        return own, slice(0, max(2, ceil(share * len(own.time))))

    def _time_factor(self, units: Units) -> float:
        return units.time_factor * (self.frequency if units.unit == "Lambda" else 1.0)

    def _order_factor(self, units: Units) -> float:
        """What the order 1, in multiples of Lambda, is on the axis of the spectrum."""
        if units.unit == "Lambda" or self.train is None:
            return 1.0
        return units.per_lambda * self.frequency if units.unit == "Hz" else 1.0 / self.train.explain()["train"]["speed_ratio"]

    def _name_lines(self, ax: Axes, order: Array, places: Array, height: Array) -> None:
        """Names at the largest lines: multiples of the mesh orders, their sums and differences, and revolutions of bodies."""
        names = {} if self.train is None else {**_exciting_names(self.train), **named_orders(self.train)}
        # The lines of a window lie beside the orders.
        near = 0.5 / self.window if self.window else 1e-9
        taken: list[float] = []
        top, tall = ax.get_ylim()[1], ax.get_window_extent().height * 72 / ax.figure.dpi
        for line in np.argsort(-height)[:_MOST_NAMES]:
            name = next((name for known, name in names.items() if abs(order[line] - known) < near), None)
            free = all(abs(places[line] - place) > _ROOM * ax.get_xlim()[1] for place in taken)
            if name and free and height[line] > _NAMED * height.max():
                taken.append(float(places[line]))
                ax.annotate(name, (places[line], height[line]), (0, 4), textcoords="offset points", rotation=90, ha="center",
                            va="bottom", fontsize=7)
                top = max(top, height[line] * tall / max(tall - _LETTER * len(name) - 6, 0.3 * tall))
        ax.set_ylim(0, top)


def _exciting_names(train: Description) -> dict[float, str]:
    """Names of the orders that excite a train whose orders have names."""
    if not named_orders(train):
        return {}
    return {float(order.order): order.name.replace("revolution of ", "") for order in exciting_orders(train)}
