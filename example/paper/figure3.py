"""Draws the paper's figure 3 from the executable's results: ``python example/paper/figure3.py RESULTS_FOLDER``.

Reads ``fig03.h5`` and ``fig03_linear.h5`` (the same train without backlash) and writes ``fig03.png`` beside them.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

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

    results, without_backlash = (gt.read_results(folder / name) for name in ("fig03.h5", "fig03_linear.h5"))
    curve, linear = results.response, without_backlash.response
    assert curve and linear
    marks, linear_marks = results.integration, without_backlash.integration
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
    curve: gt.Branch,
    linear: gt.Branch,
    marks: gt.Sweep | None,
    linear_marks: gt.Sweep | None,
) -> None:
    for branch, color, width in ((linear, _GREY, 1.0), (curve, _BLUE, 2.2)):
        replace(branch, branches=[]).plot(mesh + 1, ax, color=color, lw=width)
    if linear_marks is not None:
        ax.plot(linear_marks.frequency, linear_marks.rms[:, mesh], **_LINEAR_MARKS)
    if marks is not None:
        period = np.array([motion.period for motion in marks])
        for chosen, style in ((period == 1, _MARKS), (period > 1, _OTHER_MARKS)):
            ax.plot(marks.frequency[chosen], marks.rms[chosen, mesh], **style)
    top = max(found.rms[:, mesh].max() for found in (curve, marks) if found is not None)
    ax.set_xlabel("")
    ax.set_xlim(0.2, 2.6)
    ax.set_ylim(0.0, 1.12 * top)
    ax.set_ylabel(rf"rms of $p_{2 * (mesh + 1)} / b_c$")
    ax.set_title(f"({'ab'[mesh]})  mesh {mesh + 1}", loc="left", fontsize=12, fontweight="bold")


def main(arguments: list[str]) -> int:
    """Run the module as a program; the exit status."""
    if len(arguments) != 1:
        print("usage: python example/paper/figure3.py RESULTS_FOLDER", file=sys.stderr)
        return 2
    try:
        print(draw_figure(Path(arguments[0])))
    except (OSError, gt.InputError) as error:
        print(f"figure3: {error}", file=sys.stderr)
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
