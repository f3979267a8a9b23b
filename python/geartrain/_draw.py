"""What pictures share: response curves, stable solid, unstable dashed; axes, lines of a spectrum."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ._extras import extra
from .errors import InputError, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "UNSTABLE", "add_keys", "check_number", "draw_curve", "draw_lines", "draw_range", "line_style", "new_axes", "put_legend",
    "runs",
]

#: Line style of unstable motions.
UNSTABLE = (0, (3, 1.5))


def runs(stable: ArrayLike | None, segment: ArrayLike) -> Iterator[tuple[slice, bool]]:
    """Pieces of one stability, each up to the first point of the next piece of the same segment."""
    segment = np.asarray(segment)
    if not segment.size:  # an empty piece, which has a name and a colour
        yield slice(0, 0), True
        return
    verdict = np.ones(segment.shape, bool) if stable is None else np.asarray(stable, bool)
    new_segment = np.flatnonzero(np.diff(segment)) + 1
    cuts = np.union1d(new_segment, np.flatnonzero(np.diff(verdict)) + 1)
    for first, last in zip([0, *cuts], [*cuts, len(segment)]):
        joined = last < len(segment) and last not in new_segment
        yield slice(int(first), int(last) + joined), bool(verdict[first])


def draw_curve(
    ax: Axes,
    frequency: ArrayLike,
    values: ArrayLike,
    stable: ArrayLike | None,
    segment: ArrayLike | None = None,
    label: str | None = None,
    **style: Any,
) -> None:
    """Draw a curve; ``label`` names its first stable piece, or its first."""
    style = line_style(style)
    frequency, values = np.asarray(frequency), np.asarray(values)
    pieces = list(runs(stable, np.ones(frequency.shape) if segment is None else segment))
    named = next((i for i, piece in enumerate(pieces) if piece[1]), 0)
    color = style.pop("color", None) or ax._get_lines.get_next_color()  # type: ignore[attr-defined]
    for i, (piece, is_stable) in enumerate(pieces):
        ax.plot(
            frequency[piece],
            values[piece],
            **{"linestyle": "-" if is_stable else UNSTABLE, "color": color, **style},
            label=label if i == named else None,
        )


def draw_range(
    ax: Axes, frequency: ArrayLike, low: ArrayLike, high: ArrayLike, stable: ArrayLike | None, segment: ArrayLike, color: Any,
) -> None:
    """Shade what lies between two curves of stable motions; the curve does not turn within a piece of them."""
    frequency, low, high = np.asarray(frequency), np.asarray(low), np.asarray(high)
    for piece, is_stable in runs(stable, segment):
        if is_stable:
            ax.fill_between(frequency[piece], low[piece], high[piece], color=color, alpha=0.15, linewidth=0)


def add_keys(ax: Axes, keys: Mapping[str, tuple[Any, ...]]) -> None:
    """Further entries of a legend by their names, with handles that are drawn side by side and stand for nothing else."""
    from matplotlib.container import Container

    known = ax.get_legend_handles_labels()[1]
    for name, handles in keys.items():
        if name not in known:
            ax.add_container(Container(handles, label=name))


def put_legend(ax: Axes, own: bool, raised: float = 0.0, title: str | None = None) -> None:
    """A legend: above axes that were made for the picture, where it hides nothing; on others where it hides least.

    Above it has as many columns as the axes have room for, and does not shrink them.
    """
    from matplotlib.legend_handler import HandlerTuple

    options: dict[str, Any] = {
        "handler_map": {tuple: HandlerTuple(ndivide=None, pad=0.3)}, "title": title, "title_fontsize": "small",
    }
    entries = len(ax.get_legend_handles_labels()[0])
    if not own:
        ax.legend(loc="best", **options)
        return
    room = ax.get_window_extent().width
    for columns in range(min(4, entries), 0, -1):
        legend = ax.legend(
            loc="lower center", bbox_to_anchor=(0.5, 1.0 + raised), ncols=columns, frameon=False, **options
        )
        if legend.get_window_extent().width <= room:
            return


def draw_lines(ax: Axes, places: ArrayLike, heights: ArrayLike, width: float, color: Any) -> None:
    """Lines of a spectrum, each at its place with a mark on top; wide ones show behind narrow ones drawn later."""
    ax.vlines(places, 0.0, heights, colors=[color], linewidth=width, alpha=0.8)
    ax.plot(places, heights, linestyle="none", marker="o", markersize=2.0 + width / 2, color=color, alpha=0.8)


def line_style(style: dict[str, Any]) -> dict[str, Any]:
    """The style of a line with matplotlib's short names (c, ls, lw) written out."""
    from matplotlib.cbook import normalize_kwargs
    from matplotlib.lines import Line2D

    named: dict[str, Any] = normalize_kwargs(style, Line2D)
    return named


def new_axes(ax: Axes | None, **figure: Any) -> Axes:
    """The axes given, or those of a new figure."""
    if ax is not None:
        return ax
    made: Axes = extra("matplotlib.pyplot").subplots(layout="constrained", **figure)[1]
    return made


def check_number(name: str, number: Any, most: int) -> None:
    """Refuse the number of a mesh (shaft, mode) that is not there; they count from 1."""
    if isinstance(number, bool) or number not in range(1, most + 1):
        raise InputError(f"{name} = {shown(number)}: must be 1 to {most}")
