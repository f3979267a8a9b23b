"""Response curves: stable solid, unstable dashed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .errors import InputError, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["check_mesh", "draw_curve", "label_axes", "runs"]


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
    from matplotlib.cbook import normalize_kwargs
    from matplotlib.lines import Line2D

    style = normalize_kwargs(style, Line2D)
    frequency, values = np.asarray(frequency), np.asarray(values)
    pieces = list(runs(stable, np.ones(frequency.shape) if segment is None else segment))
    named = next((i for i, piece in enumerate(pieces) if piece[1]), 0)
    color = style.pop("color", None) or ax._get_lines.get_next_color()  # type: ignore[attr-defined]
    for i, (piece, is_stable) in enumerate(pieces):
        ax.plot(
            frequency[piece],
            values[piece],
            **{"linestyle": "-" if is_stable else (0, (3, 1.5)), "color": color, **style},
            label=label if i == named else None,
        )


def check_mesh(mesh: int, meshes: int) -> None:
    """Refuse the number of a mesh that is not there; they count from 1."""
    if isinstance(mesh, bool) or mesh not in range(1, meshes + 1):
        raise InputError(f"mesh = {shown(mesh)}: must be 1 to {meshes}")


def label_axes(ax: Axes) -> None:
    """Names of the paper's axes."""
    ax.set_xlabel(r"mesh frequency  $\Lambda$")
    ax.set_ylabel(r"mesh displacement  rms $/\, b_c$")
