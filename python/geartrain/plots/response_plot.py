"""Curves over speed: which quantity, and a branch with its jumps and ranges."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import described
from .._core.description import Description, contact_words, part_names
from .._core.units import Unit, Units, units_of
from ..errors import InputError, shown
from ..results.curve import Between, is_slope, position, value_at
from ..results.summary import Readings
from .captions import LENGTHS, caption, first_quantity, force_unit, force_words, number_words
from .draw import COLORS, UNSTABLE, add_keys, check_number, draw_curve, draw_range, draws, line_style, marker_of, put_legend
from .panels import are_unequal, name_height, new_panels, scale

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Curves", "Quantity", "plot_visits"]

Array = NDArray[np.float64]
#: Entries of a legend by their names.
Keys = dict[str, tuple[Any, ...]]

#: Marks of what lies beyond a picture.
_ARROWS = {"up": "\u25b2", "down": "\u25bc"}
#: Where a long caption takes a second line.
_BREAK = "\n("
#: What the legend says of a speed from which on no motion of the branch is stable nearby.
_SWITCH = "switches to another vibration"
#: Short names for fields that are drawn together.
_TOGETHER = {
    "mesh_force": ("mesh_force_maximum",),
    **{name: (f"{name}_minimum", f"{name}_maximum")
       for name in ("shaft_torque", "reaction_torque", "coupling_torque", "bearing_force")},
}
#: Dimensions beside the points that fields which are drawn have.
_PARTS = ("mesh", "shaft", "held", "planet", "coupling", "bearing axis")


@dataclass(frozen=True)
class Quantity:
    """What is drawn over speed: fields of the points that have a column for each mesh, shaft, ...; two for each bearing."""

    name: str
    words: str
    along: str
    unit: str
    names: Sequence[str]
    fields: Sequence[str]
    values: Sequence[Array]

    @classmethod
    def of(cls, name: str | None, train: Description | None, path: str, get: Callable[[str], Array | None]) -> Quantity:
        """The quantity of a name, or the first to look at; ``path`` is the result's group in a file, ``get`` gives its fields."""
        if name is None:
            name = first_quantity(train)
        about = described()[path].about
        columns = {field: along for field, row in about.items()
                   if (along := " ".join(row[0][1:])) in _PARTS and not is_slope(field)}
        there = {field: values.reshape(len(values), int(np.prod(values.shape[1:])))
                 for field in columns if (values := get(field)) is not None}
        if {"minimum", "maximum"} <= {*there}:
            there["peak_to_peak"] = there["maximum"] - there["minimum"]
            columns["peak_to_peak"], about = columns["maximum"], {**about, "peak_to_peak": about["maximum"]}
        known = {**{field: (field,) for field in there}, **{short: of for short, of in _TOGETHER.items() if {*of} <= {*there}}}
        if not isinstance(name, str) or name not in known:
            raise InputError(f"quantity = {shown(name)}: must be {', '.join(map(repr, known))}")
        first = known[name][0]
        names = part_names(train, columns[first], there[first].shape[1])
        unit = force_unit(train) if first == "mesh_force_maximum" else about[first][1]
        words = caption(name, force_words(train))
        return cls(name, words, columns[first], unit, names, known[name], [there[field] for field in known[name]])

    def label(self, units: Units) -> str:
        """Of its axis."""
        if self.name in LENGTHS:
            return f"{self.words.replace(' (', _BREAK)}  {units.length}"
        return self.words if self.unit == "1" else f"{self.words}  [{self.unit}]"

    @property
    def from_zero(self) -> bool:
        """Whether its axis begins at zero: sizes do, but no ranges and no positions."""
        if self.along != "mesh":
            return self.name in {"bearing_force_rms", "coupling_energy_loss"}
        return len(self.values) == 1 and self.name not in {"mean", "minimum", "maximum"}

    def are_unequal(self, parts: Sequence[Array]) -> bool:
        """Whether parts with these values are drawn each in a panel of its own."""
        is_share = self.unit == "1" and self.name not in LENGTHS
        return not is_share and are_unequal(parts, ranges=self.along not in {"mesh", "planet"})

    def chosen(self, **asked: int | None) -> Sequence[int]:
        """Columns to draw: those of the mesh, shaft, ... asked for by its number, or all that have values."""
        along = self.along.split()[0]
        number = asked.pop(along, None)
        if any(other is not None for other in asked.values()):
            raise InputError(f"quantity = {shown(self.name)}: is of each {along}, and of no other part")
        if number is not None:
            each = 2 if along == "bearing" else 1
            check_number(along, number, len(self.names) // each)
            return range(each * (number - 1), each * number)
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
    subharmonic: int
    origin: str
    settings: Mapping[str, Any]
    branches: Sequence[Any]
    train: Description | None

    @draws
    def plot(
        self, mesh: int | None = None, ax: Axes | None = None, *, quantity: str | None = None, shaft: int | None = None,
        coupling: int | None = None, bearing: int | None = None, unit: Unit | None = None, jumps: bool = False,
        ranges: bool = False, **style: Any,
    ) -> Axes:
        """Draw a quantity over the speed: stable solid, unstable dashed; ``branches`` thinner.

        A picture on axes of its own, or on empty axes, is scaled to the stable motions that repeat after one period, and says where
        stable motions lie beyond. Parts too unequal for one picture have panels one below another, of which the
        uppermost is returned. What a response that ended early has not computed is hatched, and the legend says why.

        Parameters
        ----------
        mesh, shaft, coupling, bearing : int, optional
            Which one, counted from 1; all of them unless told. A bearing has a curve for x and one for y.
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        quantity : str, optional
            A field with a column for each mesh, shaft, coupling, bearing, held body or planet, such as ``'rms'`` (of the paper),
            ``'true_ac_rms'``, ``'dynamic_factor'``, ``'mesh_force_maximum'``, ``'bearing_force_rms'``, ``'load_share'``;
            ``'mesh_force'`` in short, ``'shaft_torque'``, ``'coupling_torque'``, ``'bearing_force'``, ``'reaction_torque'`` for
            smallest and largest value, ``'peak_to_peak'`` of the displacement. Default: the one of the part asked for, else
            ``'mesh_force'`` where Lambda is the speed in rpm, else ``'rms'``.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the frequency of a branch over frequency; unless told rpm where Lambda is the speed in rpm, else Lambda.
        jumps : bool
            Mark where a sweep in speed jumps, with arrows where the quantity has one curve for each mesh or shaft.
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
        parts = {"mesh": mesh, "shaft": shaft, "coupling": coupling, "bearing": bearing}
        quantity = _quantity_of(quantity, parts)
        curves = [Quantity.of(quantity, branch.train, "/response", partial(_field, branch)) for branch in (self, *self.branches)]
        smooth = [Between(branch) for branch in (self, *self.branches)]
        columns = curves[0].chosen(**parts)
        settled = self._settled(curves, columns)
        own, split = ax is None, ax is None and curves[0].are_unequal(settled)
        # Axes that hold nothing yet are scaled as a picture of its own is; what others have drawn keeps its scale.
        scaled = ax is None or not ax.has_data()
        axes = new_panels(ax, [curves[0].names[column] for column in columns], split)
        style = line_style(style)
        label = style.pop("label", None)
        colors = []
        for column, ax in zip(columns, axes):
            thin: dict[str, Any] = {"color": COLORS[column % len(COLORS)]} if split else {}
            mark = marker_of(column) if len(columns) > 1 and not {"linestyle", "marker"} & style.keys() else None
            for number, (between, curve) in enumerate(zip(smooth, curves)):
                frequency = factor * between.frequency
                drawn = [between.of(field, values)[:, column] for field, values in zip(curve.fields, curve.values)]
                for place, values in enumerate(drawn):
                    name = None if number or place or split else label or curve.names[column]
                    draw_curve(ax, frequency, values, between.stable, between.segment, name, mark, **{**thin, **style})
                    # The same colour, whether it was given or the next of the cycle.
                    thin["color"] = ax.lines[-1].get_color()
                if len(drawn) > 1:
                    draw_range(ax, frequency, drawn[0], drawn[1], between.stable, between.segment, thin["color"])
                thin["linewidth"], mark = 0.8, None
            colors.append(thin["color"])
        if scaled:
            self._scale(axes, settled, curves, columns, factor)
        keys = self._mark_unstable(style)
        if jumps:
            keys |= self._mark_jumps(axes, factor, curves[0], columns, smooth[0])
        strips = 0.0
        if ranges and axes:
            of_meshes = curves[0].along == "mesh"
            rows = dict(zip(columns, colors)) if of_meshes else dict.fromkeys(range(self.rms.shape[1]), "0.3")
            strips, told = self._mark_ranges(axes[0], factor, rows, not of_meshes, len(axes) if split else 1)
            keys |= told
        # On axes with other pictures another branch may have what this one left out.
        gaps = self._mark_gaps(axes, factor) if own else {}
        keys |= gaps
        dimension = f"  [{self.parameter_unit}]" if self.parameter_unit not in {"", "1"} else ""
        axes[-1].set_xlabel(f"{self.parameter_name.replace('_', ' ')}{dimension}" if self.parameter_name else units.frequency)
        name_height(axes, curves[0].label(units))
        if len(columns) > 1 or jumps or ranges or (keys and own):
            add_keys(axes[0], keys)
            put_legend(axes[0], own, strips, title=shorten(self.ended, 64, placeholder=" ...") if gaps else None)
        return axes[0]

    def _settled(self, curves: Sequence[Quantity], columns: Sequence[int]) -> list[Array]:
        """Of each column the values of the stable motions that repeat after one period; of all motions where none is known."""
        branches = (self, *self.branches)
        found = []
        for column in columns:
            every = [np.concatenate([values[:, column] for values in curve.values]) for curve in curves]
            chosen = [
                np.concatenate([values[branch.stable, column] for values in curve.values])
                for branch, curve in zip(branches, curves) if branch.stable is not None and branch.subharmonic == 1
            ]
            stable = np.concatenate([np.zeros(0), *chosen])
            found.append(stable if np.isfinite(stable).any() else np.concatenate(every))
        return found

    def _scale(
        self, axes: Sequence[Axes], settled: Sequence[Array], curves: Sequence[Quantity], columns: Sequence[int], factor: float,
    ) -> None:
        """Scale the axes to the stable motions that repeat after one period; tell where the largest stable motion beyond is."""
        unit = "" if curves[0].unit == "1" or curves[0].name in LENGTHS else f" {curves[0].unit}"
        for ax in dict.fromkeys(axes):
            there = [place for place, own in enumerate(axes) if own is ax]
            limits = scale(ax, np.concatenate([settled[place] for place in there]), curves[0].from_zero)
            if limits is None:
                continue
            for sign, sense, edge in ((1, "up", 1), (-1, "down", 0)):
                beyond = [
                    (sign * float(values[point, columns[place]]), factor * float(branch._free[point]), branch.subharmonic)
                    for branch, curve in zip((self, *self.branches), curves) if branch.stable is not None
                    for values in curve.values for place in there
                    for point in np.flatnonzero(branch.stable & (sign * (values[:, columns[place]] - limits[edge]) > 0))
                ]
                if not beyond:
                    continue
                largest, at, period = max(beyond)
                words = f"repeats after {period} periods:" if period > 1 else "stable"
                number = number_words(sign * float(f"{largest:.4g}"))
                ax.annotate(f"{_ARROWS[sense]} {words} {sense} to {number}{unit}", (at, edge), (0, -3 * sign),
                            xycoords=("data", "axes fraction"), textcoords="offset points", ha="center",
                            va="top" if edge else "bottom", fontsize=7,
                            bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85})

    def _mark_unstable(self, style: dict[str, Any]) -> Keys:
        """What the legend says of dashed lines, where there are any."""
        from matplotlib.lines import Line2D

        dashed = "linestyle" not in style and any(
            branch.stable is not None and not branch.stable.all() for branch in (self, *self.branches)
        )
        return {"unstable": (Line2D([], [], color="0.35", linestyle=UNSTABLE),)} if dashed else {}

    def _mark_gaps(self, axes: Sequence[Axes], factor: float) -> Keys:
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
        for ax, ends in product(dict.fromkeys(axes), gaps):
            ax.axvspan(*(factor * end for end in ends), zorder=0, **hatched)
        return {"not computed": (Patch(**hatched),)} if gaps else {}

    def _mark_jumps(
        self, axes: Sequence[Axes], factor: float, curve: Quantity, columns: Sequence[int], between: Between,
    ) -> Keys:
        """Arrows from the motion before to that after, or a line where no motion is known, or each has more than one value."""
        from matplotlib.lines import Line2D

        arrow = {"arrowstyle": "->", "color": "0.35", "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
        single = len(curve.values) == 1
        kinds = set()
        for jump in self.jumps:
            free = jump.frequency if jump.parameter is None else jump.parameter
            at, lands = factor * free, bool(np.isfinite(jump.after).all())
            kinds.add(lands)
            if lands and single:
                before, after = (self._value_at(curve, between, free, rms) for rms in (jump.before, jump.after))
                for column, ax in zip(columns, axes):
                    ax.annotate("", (at, after[column]), (at, before[column]), arrowprops=arrow, annotation_clip=False)
            else:
                for ax in dict.fromkeys(axes):
                    ax.axvline(at, color="0.35", linewidth=0.8, linestyle=":")
        keys = {}
        line = Line2D([], [], color="0.35", linewidth=0.8, linestyle=":")
        if not single and len(kinds) == 2:
            return {f"jump, or {_SWITCH}": (line,)}
        if True in kinds:
            keys["jump"] = (Line2D([], [], color="0.35", linewidth=0.9) if single else line,)
        if False in kinds:
            keys[_SWITCH] = (line,)
        return keys

    def _value_at(self, curve: Quantity, between: Between, free: float, rms: Array) -> Array:
        """The quantity of each column where the branch has the frequency (or parameter) and the rms, as before or after a jump."""
        if curve.name == "rms":
            return rms
        where = position(between, free, between.of("rms", self.rms), rms)
        return value_at(between.of(curve.fields[0], curve.values[0]), where)

    def _mark_ranges(self, ax: Axes, factor: float, rows: Mapping[int, Any], names: bool, panels: int) -> tuple[float, Keys]:
        """Strips above the axes, a row for each mesh that has any: light where teeth separate, dark where back flanks collide.

        ``rows`` are the colours of the meshes; with ``names`` each row has that of its mesh beside it; ``panels`` is how many axes
        share the height of the picture. Gives the height of the rows over that of the axes, and the entries of the legend.
        """
        from matplotlib.patches import Patch

        known = self.stable is not None
        row, keys = 0, Keys()
        separation, collision = (contact_words(self.train, rows, what) for what in ("separation", "back collision"))
        elements = self.train.mesh_elements if isinstance(self.train, Description) else [f"mesh {column + 1}" for column in rows]
        for column, color in rows.items():
            apart = self.separation_ranges(column + 1, known)
            behind = self.back_collision_ranges(column + 1, known) if column in collision else np.empty((0, 2))
            bottom = 1.0 + panels * (0.012 + 0.026 * row)
            if not len(apart) and not len(behind):
                continue
            row += 1
            if names:
                ax.annotate(elements[column], (1.0, bottom + 0.01 * panels), (3, 0), xycoords="axes fraction",
                            textcoords="offset points", va="center", fontsize=6)
            for ends, alpha, name in ((apart, 0.35, separation[column]), (behind, 1.0, collision.get(column, ""))):
                for low, high in factor * ends:
                    ax.axvspan(low, high, bottom, bottom + 0.02 * panels, color=color, alpha=alpha, linewidth=0, clip_on=False)
                patch = Patch(color=color, alpha=alpha, linewidth=0)
                if len(ends) and (color != "0.3" or name not in keys):
                    keys[name] = (*keys.get(name, ()), patch)
        return panels * (0.012 * bool(row) + 0.026 * row), keys


def plot_visits(
    motions: Any, train: Description | None, ax: Axes | None, quantity: str | None, parts: Mapping[str, int | None],
    unit: Unit | None, style: dict[str, Any],
) -> Axes:
    """Draw a quantity of the motions of a sweep, see `Sweep.plot`."""
    units = units_of(train, unit)
    curve = Quantity.of(_quantity_of(quantity, parts), train, "/integration", lambda name: _column(motions, name))
    columns = curve.chosen(**parts)
    drawn = [np.concatenate([values[:, column] for values in curve.values]) for column in columns]
    own_axes, split = ax is None, ax is None and curve.are_unequal(drawn)
    axes = new_panels(ax, [curve.names[column] for column in columns], split)
    style = line_style(style)
    label = style.pop("label", None)
    ways = np.array(motions.direction, object)
    frequency = units.per_lambda * motions.frequency
    for column, part, ax in zip(columns, drawn, axes):
        color: dict[str, Any] = {"color": COLORS[column % len(COLORS)]} if split else {}
        name = None if split else label or curve.names[column]
        for way in dict.fromkeys(motions.direction):
            marks = {"marker": "^", "fillstyle": "full"} if way == "up" else {"marker": "v", "fillstyle": "none"}
            there = ways == way
            for values in curve.values:
                own = {"linestyle": "none", "markersize": 4, **marks, **color, **style}
                (line,) = ax.plot(frequency[there], values[there, column], label=name, **own)
                color, name = {"color": line.get_color()}, None
            if len(curve.values) > 1:
                low, high = (values[there, column] for values in curve.values)
                ax.vlines(frequency[there], low, high, colors=[color["color"]], alpha=0.25, linewidth=0.8)
        if split:
            scale(ax, part, curve.from_zero)
    if len({*motions.direction}) > 1:
        axes[0].plot([], [], "k^", markersize=4, label="rising speed")
        axes[0].plot([], [], "kv", markersize=4, fillstyle="none", label="falling speed")
    axes[-1].set_xlabel(units.frequency)
    name_height(axes, curve.label(units))
    if axes[0].get_legend_handles_labels()[0]:
        put_legend(axes[0], own_axes)
    return axes[0]


def _quantity_of(quantity: str | None, parts: Mapping[str, int | None]) -> str | None:
    """The quantity asked for; where only a part is, its torque or force."""
    if quantity is not None:
        return quantity
    own = {"shaft": "shaft_torque", "coupling": "coupling_torque", "bearing": "bearing_force"}
    return next((name for part, name in own.items() if parts[part] is not None), None)


def _field(branch: Any, name: str) -> Array | None:
    """A field of the points; None for one that is not there."""
    values: Array | None = getattr(branch, name, None)
    return values


def _column(motions: Any, name: str) -> Array | None:
    """A field of all motions; None where a motion does not have it."""
    values = [getattr(motion, name, None) for motion in motions]
    return None if not values or any(value is None for value in values) else np.array(values, float)
