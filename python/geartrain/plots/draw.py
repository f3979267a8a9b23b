"""What pictures share: their style; response curves, stable solid, unstable dashed; axes, lines of a spectrum."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core.extras import extra
from .._core.variable import refuse_unknown
from ..errors import InputError, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = [
    "COLORS", "DASHES", "UNSTABLE", "add_keys", "check_number", "draw_curve", "draw_lines", "draw_range", "draws",
    "line_style", "marker_of", "new_axes", "plot_style", "put_legend", "runs",
]

Call = TypeVar("Call", bound=Callable[..., Any])

#: Colours of M. Okabe and K. Ito, which the colour-blind tell apart; the first ones differ most in lightness, for print in grey.
COLORS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9", "#000000")
#: Of the meshes or shafts of a picture, beside their colours: marks on curves over speed, dashes of time histories.
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1.2)))
#: Line style of unstable motions.
UNSTABLE = (0, (3, 1.5))
#: Marks of a curve on a way as long as each axis: few on steep parts, where those of a narrow peak would hide it.
_MARKS_ACROSS, _MARKS_UP = 10, 2


def marker_of(number: int) -> str:
    """Mark of a mesh or shaft of a picture, from 0 on; another one where its colour comes again."""
    return _MARKERS[(number + number // len(COLORS)) % len(_MARKERS)]


def plot_style() -> dict[str, Any]:
    """The style of all pictures, as settings of matplotlib.

    Pictures on axes of their own have it; axes that are given keep theirs.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> with plt.rc_context(gt.plot_style()):
    ...     figure, axes = plt.subplots(2)
    """
    return {
        "axes.prop_cycle": extra("matplotlib").cycler(color=COLORS),
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "0.92",
        "axes.axisbelow": True,
        "axes.formatter.useoffset": False,
        "axes.formatter.limits": (-4, 7),
        "hatch.linewidth": 0.6,
    }


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
    mark: str | None = None,
    **style: Any,
) -> None:
    """Draw a curve; ``label`` names its first stable piece, or its first; ``mark`` stands at equal distances along it."""
    style = line_style(style)
    frequency, values = np.asarray(frequency), np.asarray(values)
    marks = _marks(frequency, values)
    pieces = list(runs(stable, np.ones(frequency.shape) if segment is None else segment))
    named = next((i for i, piece in enumerate(pieces) if piece[1]), 0)
    color = style.pop("color", None) or ax._get_lines.get_next_color()  # type: ignore[attr-defined]
    for i, (piece, is_stable) in enumerate(pieces):
        own: dict[str, Any] = {"linestyle": "-" if is_stable else UNSTABLE, "color": color}
        if mark is not None:
            own |= {"marker": mark, "markersize": 4.5, "markevery": np.flatnonzero(marks[piece]).tolist()}
        ax.plot(frequency[piece], values[piece], **{**own, **style}, label=label if i == named else None)


def _marks(across: NDArray[Any], up: NDArray[Any]) -> NDArray[np.bool_]:
    """Which points of a curve have marks: those next to equal distances along it."""
    if not (np.isfinite(across) & np.isfinite(up)).any():
        return np.zeros(len(across), bool)
    ways = [count * np.nan_to_num(np.diff(values)) / (np.nanmax(values) - np.nanmin(values) or 1.0)
            for values, count in ((across, _MARKS_ACROSS), (up, _MARKS_UP))]
    along = np.append(0.5, 0.5 + np.hypot(*ways).cumsum())
    stands: NDArray[np.bool_] = np.diff(np.floor(along), prepend=0.0) > 0
    return stands


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


def draw_lines(ax: Axes, places: ArrayLike, heights: ArrayLike, width: float, color: Any, marker: str = "o") -> None:
    """Lines of a spectrum, each at its place with a mark on top; wide ones show behind narrow ones drawn later."""
    ax.vlines(places, 0.0, heights, colors=[color], linewidth=width, alpha=0.8)
    ax.plot(places, heights, linestyle="none", marker=marker, markersize=2.0 + width / 2, color=color, alpha=0.8)


def draws(call: Call) -> Call:
    """For a call that hands its ``**style`` to matplotlib: a keyword that neither of them has is told as in other calls."""
    own = [item.name for item in inspect.signature(call).parameters.values() if item.kind is not item.VAR_KEYWORD]

    @functools.wraps(call)
    def drawn(*given: Any, **settings: Any) -> Any:
        try:
            return call(*given, **settings)
        except (AttributeError, TypeError) as error:
            # Which keywords there are only matplotlib knows, for each kind of picture.
            unknown = [name for name in settings if name not in own and f"unexpected keyword argument {name!r}" in str(error)]
            if not unknown:
                raise
            properties = extra("matplotlib.artist").ArtistInspector(extra("matplotlib.lines").Line2D).get_setters()
            refuse_unknown(call.__name__, unknown, [*own[1:], *(name for name in properties if name not in unknown)])
            raise

    return cast(Call, drawn)


def line_style(style: dict[str, Any]) -> dict[str, Any]:
    """The style of a line with matplotlib's short names (c, ls, lw) written out."""
    from matplotlib.cbook import normalize_kwargs
    from matplotlib.lines import Line2D

    named: dict[str, Any] = normalize_kwargs(style, Line2D)
    return named


def new_axes(ax: Any | None, rows: int = 1, **figure: Any) -> Any:
    """The axes given, or those of a new figure."""
    if ax is not None:
        return ax
    plt = extra("matplotlib.pyplot")
    with plt.rc_context(plot_style()):
        return plt.subplots(rows, layout="constrained", **figure)[1]


def check_number(name: str, number: Any, most: int) -> None:
    """Refuse the number of a mesh (shaft, mode) that is not there; they count from 1."""
    if isinstance(number, bool) or number not in range(1, most + 1):
        raise InputError(f"{name} = {shown(number)}: must be 1 to {most}")
