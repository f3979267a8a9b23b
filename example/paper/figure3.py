"""Draws the paper's figure 3 from the executable's results: ``python example/paper/figure3.py RESULTS_FOLDER``.

Reads ``fig03.h5`` and ``fig03_linear.h5`` (the same train without backlash) and writes ``fig03.png`` beside them.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

import geartrain as gt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["STYLE", "draw_figure", "main"]

STYLE: Any = {**gt.plot_style(), "font.size": 11, "axes.labelsize": 12, "legend.fontsize": 10}

_BLUE, _GREY, _RED = "C0", "0.55", "C3"


def draw_figure(folder: Path, dpi: int = 160) -> Path:
    """Draw ``fig03.png`` from the results in a folder.

    Parameters
    ----------
    folder : path
    dpi : int

    Returns
    -------
    path
        Of the picture.
    """
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.lines import Line2D

    with h5py.File(folder / "fig03.h5") as file, h5py.File(folder / "fig03_linear.h5") as linear_file:
        curve = _read(file["response"])
        marks = _read(file["integration"]) if "integration" in file else None
        linear = _read(linear_file["response"])
        linear_marks = _read(linear_file["integration"]) if "integration" in linear_file else None
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, 1, figsize=(8.0, 7.6), sharex=True, layout="constrained")
        for mesh, ax in enumerate(axes):
            _draw_panel(ax, mesh, curve, linear, marks, linear_marks)
        axes[-1].set_xlabel(r"mesh frequency  $\Lambda = \omega / \omega_c$")
        legend = [
            Line2D([], [], color=_BLUE, lw=2.2, label="stable"),
            Line2D([], [], color=_BLUE, lw=2.2, ls=(0, (3, 1.5)), label="unstable"),
            Line2D([], [], color=_GREY, lw=1.0, label="no backlash, stable"),
            Line2D([], [], color=_GREY, lw=1.0, ls=(0, (3, 1.5)), label="unstable"),
        ]
        if marks is not None:
            legend.append(Line2D([], [], **_MARKS, label="integration, period 1"))
            legend.append(Line2D([], [], **_OTHER_MARKS, label="other periods"))
        if linear_marks is not None:
            legend.append(Line2D([], [], **_LINEAR_MARKS, label="integration, no backlash"))
        figure.legend(handles=legend, loc="outside upper center", ncols=4, frameon=False)
        picture = folder / "fig03.png"
        figure.savefig(picture, dpi=dpi)
        plt.close(figure)
    return picture


_MARKS: dict[str, Any] = {"ls": "none", "marker": "s", "ms": 2.4, "mfc": "none", "mec": _RED, "mew": 0.6}
_OTHER_MARKS: dict[str, Any] = {**_MARKS, "marker": "D", "ms": 2.4, "mec": "C1"}
_LINEAR_MARKS: dict[str, Any] = {**_MARKS, "ms": 1.8, "mec": "0.35", "mew": 0.5}


def _draw_panel(
    ax: Axes,
    mesh: int,
    curve: dict[str, Any],
    linear: dict[str, Any],
    marks: dict[str, Any] | None,
    linear_marks: dict[str, Any] | None,
) -> None:
    _draw_curve(ax, linear, mesh, color=_GREY, lw=1.0)
    _draw_curve(ax, curve, mesh, color=_BLUE, lw=2.2)
    if linear_marks is not None:
        ax.plot(linear_marks["frequency"], linear_marks["rms"][:, mesh], **_LINEAR_MARKS)
    if marks is not None:
        for chosen, style in ((marks["period"] == 1, _MARKS), (marks["period"] > 1, _OTHER_MARKS)):
            ax.plot(marks["frequency"][chosen], marks["rms"][chosen, mesh], **style)
    top = curve["rms"][:, mesh].max() if marks is None else max(curve["rms"][:, mesh].max(), marks["rms"][:, mesh].max())
    ax.set_xlim(0.2, 2.6)
    ax.set_ylim(0.0, 1.12 * top)
    ax.set_ylabel(rf"rms of $p_{2 * (mesh + 1)} / b_c$")
    ax.set_title(f"({'ab'[mesh]})  mesh {mesh + 1}", loc="left", fontsize=12, fontweight="bold")


def _draw_curve(ax: Axes, curve: dict[str, Any], mesh: int, **style: Any) -> None:
    """Stable solid, unstable dashed: each line goes on to the first point of the other kind."""
    for part in np.unique(curve["segment"]):
        frequency, rms, stable = (curve[name][curve["segment"] == part] for name in ("frequency", "rms", "stable"))
        for shown, dashes in ((stable == 1, "-"), (stable == 0, (0, (3, 1.5)))):
            reached = shown | np.append(False, shown[:-1])
            ax.plot(frequency, np.where(reached, rms[:, mesh], np.nan), ls=dashes, **style)


def _read(group: Any) -> dict[str, Any]:
    """The arrays that are drawn; None for those that the group lacks."""
    names = ("frequency", "rms", "stable", "segment", "period")
    return {name: np.asarray(group[name]) if name in group else None for name in names}


def main(arguments: list[str]) -> int:
    """Run the module as a program; the exit status."""
    if len(arguments) != 1:
        print("usage: python example/paper/figure3.py RESULTS_FOLDER", file=sys.stderr)
        return 2
    try:
        print(draw_figure(Path(arguments[0])))
    except (OSError, KeyError) as error:
        print(f"figure3: {error}", file=sys.stderr)
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
