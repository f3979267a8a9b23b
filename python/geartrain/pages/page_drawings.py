"""Drawings on a page, as SVG: the train, and each planetary set."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from .._core.description import Description
from .._core.extras import extra
from ..plots.draw import plot_style
from ..plots.planetary_picture import STAGE_RATIOS, STAGE_SIZE, draw_stage, stages_of
from ..plots.schematic import draw_schematic, figure_size

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["schematic", "stages"]


def schematic(train: Description) -> str:
    """The train as an SVG drawing."""
    figure = _figure(figure_size(train))
    draw_schematic(train, figure.add_subplot())
    return _svg(figure)


def stages(train: Description) -> list[dict[str, str]]:
    """Name and SVG drawing of each planetary set of a train."""
    found = []
    for name in stages_of(train):
        with extra("matplotlib").rc_context(plot_style()):
            figure = _figure(STAGE_SIZE)
            draw_stage(train, name, tuple(figure.subplots(1, 2, width_ratios=STAGE_RATIOS)))
        found.append({"name": name, "svg": _svg(figure)})
    return found


def _figure(size: tuple[float, float]) -> Figure:
    """An empty figure that pyplot does not know."""
    figure: Figure = extra("matplotlib.figure").Figure(figsize=size, layout="constrained")
    return figure


def _svg(figure: Figure) -> str:
    """A figure as SVG: letters are paths, so that no font has to be there; equal figures have equal text."""
    text = io.StringIO()
    with extra("matplotlib").rc_context({"svg.hashsalt": "geartrain", "svg.fonttype": "path"}):
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()
