"""Curves over speed: which quantity, and a branch with its jumps and ranges."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._box import described
from ._curve import Between, is_slope
from ._draw import MARKERS, UNSTABLE, add_keys, check_number, draw_curve, draw_range, draws, line_style, new_axes, put_legend
from ._units import Unit, Units, units_of
from .description import Description, mesh_names
from .errors import InputError, shown
from .summary import Readings

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Curves", "Quantity", "plot_visits"]

Array = NDArray[np.float64]
#: Entries of a legend by their names.
Keys = dict[str, tuple[Any, ...]]

#: Displacements, which are over the characteristic length.
_LENGTHS = {"rms", "true_ac_rms", "mean", "minimum", "maximum"}
#: Short names for fields that are drawn together.
_TOGETHER = {"mesh_force": ("mesh_force_maximum",), "shaft_torque": ("shaft_torque_minimum", "shaft_torque_maximum")}


@dataclass(frozen=True)
class Quantity:
    """What is drawn over speed: fields of the points that have a column for each mesh or for each shaft."""

    name: str
    along: str
    unit: str
    names: Sequence[str]
    fields: Sequence[str]
    values: Sequence[Array]

    @classmethod
    def of(cls, name: str, train: Description | None, path: str, get: Callable[[str], Array | None]) -> Quantity:
        """The quantity of a name; ``path`` is that of the result's group in a results file, ``get`` gives its fields."""
        about = described()[path].about
        columns = {field: row[0][1] for field, row in about.items()
                   if len(row[0]) == 2 and row[0][1] in {"mesh", "shaft"} and not is_slope(field)}
        there = {field: values for field in columns if (values := get(field)) is not None}
        known = {**{field: (field,) for field in there}, **{short: of for short, of in _TOGETHER.items() if {*of} <= {*there}}}
        if not isinstance(name, str) or name not in known:
            raise InputError(f"quantity = {shown(name)}: must be {', '.join(map(repr, known))}")
        first = known[name][0]
        number = there[first].shape[1]
        names = mesh_names(train, number) if columns[first] == "mesh" or train is None else train.shaft_labels
        return cls(name, columns[first], about[first][1], names, known[name], [there[field] for field in known[name]])

    def label(self, units: Units) -> str:
        """Of its axis."""
        words = "largest mesh force" if self.name.startswith("mesh_force") else self.name.replace("_", " ")
        if len(self.values) > 1:
            words = f"{words}, smallest to largest"
        if self.name in _LENGTHS:
            return f"mesh displacement  {words} {units.length}"
        return words if self.unit == "1" else f"{words}  [{self.unit}]"

    def chosen(self, mesh: int | None, shaft: int | None) -> Sequence[int]:
        """Columns to draw: the mesh or the shaft asked for, or all that have values."""
        number, other = (mesh, shaft) if self.along == "mesh" else (shaft, mesh)
        if other is not None:
            raise InputError(f"quantity = {shown(self.name)}: is of each {self.along}, and of no other part")
        if number is not None:
            check_number(self.along, number, len(self.names))
            return [number - 1]
        # The torque of a rigid shaft is not known: NaN throughout.
        known = [self.along == "mesh" or not np.isnan(self.values[0][:, column]).all() for column in range(len(self.names))]
        return [column for column, there in enumerate(known) if there]


class Curves(Readings):
    """A branch as a picture."""

    frequency: Array
    segment: NDArray[np.intc]
    parameter_unit: str
    ended: str
    complete: bool
    closed: bool
    origin: str
    settings: Mapping[str, Any]
    branches: Sequence[Any]
    train: Description | None

    @draws
    def plot(
        self, mesh: int | None = None, ax: Axes | None = None, *, quantity: str = "rms", shaft: int | None = None,
        unit: Unit | None = None, jumps: bool = False, ranges: bool = False, **style: Any,
    ) -> Axes:
        """Draw a quantity over the speed: stable solid, unstable dashed; ``branches`` thinner.

        On axes of its own what a response that ended early has not computed is hatched, and the legend says why.

        Parameters
        ----------
        mesh, shaft : int, optional
            Which one, counted from 1; all of them unless told.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        quantity : str
            A field with a column for each mesh or for each shaft, such as ``'rms'``, ``'dynamic_factor'``,
            ``'mesh_force_maximum'``; ``'mesh_force'`` in short, and ``'shaft_torque'`` for smallest and largest torque.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the frequency of a branch over frequency; unless told rpm where Lambda is the speed in rpm, else Lambda.
        jumps : bool
            Mark where a sweep in speed jumps, with arrows where the quantity is ``'rms'``.
        ranges : bool
            Mark above the axes where the teeth of each mesh separate, and where the back flanks collide: of the stable motions,
            or of all where stability is not known.
        **style
            For the lines of matplotlib's ``plot``.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> ax = branch.plot(mesh=2, color="black", jumps=True, ranges=True)
        >>> ax.figure.savefig("response.png")  # doctest: +SKIP
        """
        if self.parameter_name and unit is not None:
            raise InputError(f"unit = {shown(unit)}: this branch goes over {self.parameter_name}, not over frequency")
        units = units_of(self.train, unit)
        factor = 1.0 if self.parameter_name else units.per_lambda
        curves = [Quantity.of(quantity, branch.train, "/response", partial(_field, branch)) for branch in (self, *self.branches)]
        smooth = [Between(branch) for branch in (self, *self.branches)]
        columns = curves[0].chosen(mesh, shaft)
        own, ax = ax is None, new_axes(ax)
        style = line_style(style)
        label = style.pop("label", None)
        colors = []
        for column in columns:
            thin: dict[str, Any] = {}
            mark = MARKERS[column % len(MARKERS)] if len(columns) > 1 and not {"linestyle", "marker"} & style.keys() else None
            for between, curve in zip(smooth, curves):
                frequency = factor * between.frequency
                drawn = [between.of(field, values)[:, column] for field, values in zip(curve.fields, curve.values)]
                for values in drawn:
                    name = None if thin else label or curve.names[column]
                    draw_curve(ax, frequency, values, between.stable, between.segment, name, mark, **{**thin, **style})
                    # The same colour, whether it was given or the next of the cycle.
                    thin = {"color": ax.lines[-1].get_color()}
                if len(drawn) > 1:
                    draw_range(ax, frequency, drawn[0], drawn[1], between.stable, between.segment, thin["color"])
                thin["linewidth"], mark = 0.8, None
            colors.append(thin["color"])
        keys = self._mark_unstable(style)
        if jumps:
            keys |= self._mark_jumps(ax, factor, columns if quantity == "rms" else None)
        strips = 0.0
        if ranges:
            of_meshes = curves[0].along == "mesh"
            rows = dict(zip(columns, colors)) if of_meshes else dict.fromkeys(range(self.rms.shape[1]), "0.3")
            strips, told = self._mark_ranges(ax, factor, rows, names=not of_meshes)
            keys |= told
        # On axes with other pictures another branch may have what this one left out.
        gaps = self._mark_gaps(ax, factor) if own else {}
        keys |= gaps
        dimension = f"  [{self.parameter_unit}]" if self.parameter_unit not in {"", "1"} else ""
        ax.set_xlabel(f"{self.parameter_name.replace('_', ' ')}{dimension}" if self.parameter_name else units.frequency)
        ax.set_ylabel(curves[0].label(units))
        if len(columns) > 1 or jumps or ranges or (keys and own):
            add_keys(ax, keys)
            put_legend(ax, own, strips, title=fill(self.ended, 64) if gaps else None)
        return ax

    def _mark_unstable(self, style: dict[str, Any]) -> Keys:
        """What the legend says of dashed lines, where there are any."""
        from matplotlib.lines import Line2D

        dashed = "linestyle" not in style and any(
            branch.stable is not None and not branch.stable.all() for branch in (self, *self.branches)
        )
        return {"unstable": (Line2D([], [], color="0.35", linestyle=UNSTABLE),)} if dashed else {}

    def _mark_gaps(self, ax: Axes, factor: float) -> Keys:
        """Hatch what a branch that ended early leaves out of its range."""
        from matplotlib.patches import Patch

        if self.complete or self.closed or self.origin or not len(self.frequency):
            return {}
        segments = [self._free[self.segment == number] for number in np.unique(self.segment)]
        asked = self._range()
        covered = sorted((float(part.min()), float(part.max())) for part in segments)
        covered = [(-np.inf, min(asked, default=-np.inf)), *covered, (max(asked, default=np.inf), np.inf)]
        gaps, reached = [], covered[0][1]
        for low, high in covered[1:]:
            if low > reached + 1e-9 * abs(low) and np.isfinite([low, reached]).all():
                gaps.append((reached, low))
            reached = max(reached, high)
        hatched: dict[str, Any] = {"facecolor": "none", "edgecolor": "0.75", "hatch": "///", "linewidth": 0.0}
        for ends in gaps:
            ax.axvspan(*(factor * end for end in ends), zorder=0, **hatched)
        return {"not computed": (Patch(**hatched),)} if gaps else {}

    def _mark_jumps(self, ax: Axes, factor: float, columns: Sequence[int] | None) -> Keys:
        """Arrows from the rms before to the rms after, or a line where no motion is known; without columns a line at each."""
        from matplotlib.lines import Line2D

        arrow = {"arrowstyle": "->", "color": "0.35", "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
        for jump in self.jumps:
            at = factor * (jump.frequency if jump.parameter is None else jump.parameter)
            for column in columns or ():
                if np.isfinite(jump.after[column]):
                    ax.annotate("", (at, jump.after[column]), (at, jump.before[column]), arrowprops=arrow)
            if columns is None or not np.isfinite(jump.after).all():
                ax.axvline(at, color="0.35", linewidth=0.8, linestyle=":")
        keys = {}
        if columns is None or any(np.isfinite(jump.after).any() for jump in self.jumps):
            keys["jump"] = (Line2D([], [], color="0.35", linewidth=0.9, linestyle="-" if columns else ":"),)
        if columns is not None and not all(np.isfinite(jump.after).all() for jump in self.jumps):
            keys["leaves the branch"] = (Line2D([], [], color="0.35", linewidth=0.8, linestyle=":"),)
        return keys if self.jumps else {}

    def _mark_ranges(self, ax: Axes, factor: float, rows: Mapping[int, Any], names: bool) -> tuple[float, Keys]:
        """Strips above the axes, a row for each mesh that has any: light where teeth separate, dark where back flanks collide.

        ``rows`` are the colours of the meshes; with ``names`` each row has that of its mesh beside it. Gives their height over that
        of the axes, and the entries of the legend.
        """
        from matplotlib.patches import Patch

        known = self.stable is not None
        row, keys = 0, Keys()
        for column, color in rows.items():
            apart, behind = self.separation_ranges(column + 1, known), self.back_collision_ranges(column + 1, known)
            bottom = 1.012 + 0.026 * row
            if not len(apart) and not len(behind):
                continue
            row += 1
            if names:
                ax.annotate(f"mesh {column + 1}", (1.0, bottom + 0.01), (3, 0), xycoords="axes fraction",
                            textcoords="offset points", va="center", fontsize=6)
            for ends, alpha, name in ((apart, 0.35, "teeth separate"), (behind, 1.0, "back flanks collide")):
                for low, high in factor * ends:
                    ax.axvspan(low, high, bottom, bottom + 0.02, color=color, alpha=alpha, linewidth=0, clip_on=False)
                patch = Patch(color=color, alpha=alpha, linewidth=0)
                if len(ends) and (color != "0.3" or name not in keys):
                    keys[name] = (*keys.get(name, ()), patch)
        return 0.012 * bool(row) + 0.026 * row, keys


def plot_visits(
    motions: Any, train: Description | None, mesh: int | None, ax: Axes | None, quantity: str, shaft: int | None, unit: Unit | None,
    style: dict[str, Any],
) -> Axes:
    """Draw a quantity of the motions of a sweep, see `Sweep.plot`."""
    units = units_of(train, unit)
    curve = Quantity.of(quantity, train, "/integration", lambda name: _column(motions, name))
    columns = curve.chosen(mesh, shaft)
    own_axes, ax = ax is None, new_axes(ax)
    style = line_style(style)
    label = style.pop("label", None)
    ways = np.array(motions.direction, object)
    frequency = units.per_lambda * motions.frequency
    for column in columns:
        color: dict[str, Any] = {}
        for way in dict.fromkeys(motions.direction):
            marks = {"marker": "^", "fillstyle": "full"} if way == "up" else {"marker": "v", "fillstyle": "none"}
            there = ways == way
            for values in curve.values:
                own = {"linestyle": "none", "markersize": 4, **marks, **color, **style}
                name = None if color else label or curve.names[column]
                (line,) = ax.plot(frequency[there], values[there, column], label=name, **own)
                color = {"color": line.get_color()}
            if len(curve.values) > 1:
                low, high = (values[there, column] for values in curve.values)
                ax.vlines(frequency[there], low, high, colors=[color["color"]], alpha=0.25, linewidth=0.8)
    if len({*motions.direction}) > 1:
        ax.plot([], [], "k^", markersize=4, label="rising")
        ax.plot([], [], "kv", markersize=4, fillstyle="none", label="falling")
    ax.set_xlabel(units.frequency)
    ax.set_ylabel(curve.label(units))
    if ax.get_legend_handles_labels()[0]:
        put_legend(ax, own_axes)
    return ax


def _field(branch: Any, name: str) -> Array | None:
    """A field of the points; None for one that is not there."""
    values: Array | None = getattr(branch, name, None)
    return values


def _column(motions: Any, name: str) -> Array | None:
    """A field of all motions; None where a motion does not have it."""
    values = [getattr(motion, name, None) for motion in motions]
    return None if not values or any(value is None for value in values) else np.array(values, float)
