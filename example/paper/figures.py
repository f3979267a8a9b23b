"""Draws the paper's figures 3 to 13 from their case files: ``python example/paper/figures.py [NUMBER ...] [--results FOLDER]``.

The table ``FIGURES`` says which case files make which figure. Each curve is computed in a process of its own and leaves its
results file in the results folder; time integration, started on its stable motions, gives the marks.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from curves import Curve, Drawn, compute, natural_frequencies
from figure3 import STYLE, draw_figure
from geartrain import InputError, SolverError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture

__all__ = ["FIGURES", "Figure", "draw", "main"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Figure:
    """A figure of the paper.

    Attributes
    ----------
    title : str
    curves : tuple of Curve
    top : tuple of float
        Largest rms shown in each panel: branches of back collision climb without bound.
    panels : str
        What has a panel of its own: ``'mesh'`` or ``'curve'``.
    left, right : float
        Range of Lambda shown.
    """

    title: str
    curves: tuple[Curve, ...]
    top: tuple[float, ...] = (1.0, 3.4)
    panels: str = "mesh"
    left: float = 0.2
    right: float = 2.6


FIGURES = {
    3: Figure("Harmonic balance and time integration", (Curve("fig03", ""), Curve("fig03_linear", ""))),
    4: Figure(
        "Stiffness of the middle shaft",
        tuple(
            Curve(f"fig04_k3_{name}", rf"$k_3 = {tex}$ N m/rad")
            for name, tex in (("2e4", r"2\cdot 10^4"), ("5e5", r"5\cdot 10^5"), ("1e6", "10^6"), ("1e8", "10^8"))
        ),
        top=(1.5, 3.4),
    ),
    5: Figure("Natural frequencies", (Curve("fig05", ""),)),
    6: Figure("Input torque", tuple(Curve(f"fig06_{torque:03}", rf"$T_1$ = {torque} N m") for torque in (150, 100, 50))),
    7: Figure(
        "Amplitude of the mesh stiffness",
        tuple(Curve(f"fig07_0{tenths}", rf"$\kappa_2 = 0.{tenths.rstrip('0')}$") for tenths in ("42", "30", "20", "10")),
        top=(2.0, 6.0),
    ),
    8: Figure(
        "Square-wave mesh stiffness",
        (
            Curve("fig08_rectangular", r"square wave, $\kappa_{10} = +0.084$", seeds=(0.33,)),
            Curve("fig08_printed", r"as printed, $\kappa_{10} = -0.085$", seeds=(0.33,)),
        ),
        top=(2.0, 6.0),
    ),
    9: Figure(
        "Mesh damping",
        (
            Curve("fig09_005", r"$\zeta_m = 0.05$"),
            Curve("fig09_003", r"$\zeta_m = 0.03$"),
            Curve("fig09_001", r"$\zeta_m = 0.01$", seeds=(0.33, 0.7)),
        ),
        top=(3.4, 6.0, 6.0),
        panels="curve",
    ),
    10: Figure("Mesh frequencies 1 to 2", (Curve("fig10", "$m_2 = 1, m_4 = 2$"),), top=(2.0, 6.0)),
    11: Figure("Mesh frequencies 3 to 2", (Curve("fig11", "$m_2 = 3, m_4 = 2$"),), top=(2.0, 6.0)),
    12: Figure(
        "Period-2 motions",
        (
            Curve("fig12", "period 1"),
            Curve("fig12", "period 2", 2),
        ),
        top=(5.0, 6.0),
        right=4.2,
    ),
    13: Figure(
        "Period-3 motions",
        (Curve("fig13", "period 1"), Curve("fig13", "period 3", 3)),
        top=(1.0, 2.8),
        left=1.4,
        right=3.0,
    ),
}

_COLORS: tuple[str, ...] = tuple(STYLE["axes.prop_cycle"].by_key()["color"])
_MARKS = ("s", "o", "^", "D")
_DPI = 90
_THIN = 0.7  # line width of period-1 branches found from random starts


# ---------------------------------------------------------------------------------------------------- draw


def draw(figure: Figure, curves: Sequence[Drawn]) -> Picture:
    """Draw a figure of response curves.

    Parameters
    ----------
    figure : Figure
    curves : sequence of Drawn
        In the order of the figure's.

    Returns
    -------
    matplotlib.figure.Figure
    """
    plt = _pyplot()
    picture: Picture
    by_mesh = figure.panels == "mesh"
    with plt.rc_context(STYLE):
        picture, axes = plt.subplots(len(figure.top), 1, figsize=(8.0, 7.6), sharex=True, layout="constrained")
        for place, ax in enumerate(axes):
            if by_mesh:
                entries = [(drawn, place, curve.label) for curve, drawn in zip(figure.curves, curves)]
                title, ylabel = f"mesh {place + 1}", rf"rms of $p_{2 * (place + 1)} / b_c$"
            else:
                entries = [(curves[place], mesh, rf"mesh {mesh + 1}, $p_{2 * (mesh + 1)}$") for mesh in range(2)]
                title, ylabel = figure.curves[place].label, "rms $/ b_c$"
            for (drawn, mesh, label), color, mark in zip(entries, _palette(figure), _MARKS):
                _draw_one(ax, drawn, mesh, label, color, mark)
            ax.set_xlim(figure.left, figure.right)
            ax.set_ylim(0.0, figure.top[place])
            ax.set_ylabel(ylabel)
            ax.label_outer()
            ax.set_title(f"({'abc'[place]})  {title}", loc="left", fontsize=12, fontweight="bold")
        axes[-1].set_xlabel(r"mesh frequency  $\Lambda = \omega / \omega_c$")
        _legend(picture, axes[0], any(len(drawn.branches) > 1 and drawn.branches[1].subharmonic == 1 for drawn in curves))
    return picture


def _palette(figure: Figure) -> tuple[str, ...]:
    """Period-1 motions under others are grey."""
    return ("0.55", *_COLORS) if figure.curves[-1].period > 1 else _COLORS


def _draw_one(ax: Axes, drawn: Drawn, mesh: int, label: str, color: str, mark: str) -> None:
    for place, branch in enumerate(drawn.branches):
        name = "_nolegend_" if place else label
        width = _THIN if place and branch.subharmonic == 1 else 1.5
        replace(branch, branches=[]).plot(mesh + 1, ax, label=name, color=color, lw=width)
    marks = [(motion.frequency, motion.rms[mesh]) for motion in drawn.marks]
    if marks:
        ax.plot(*np.transpose(marks), ls="none", marker=mark, ms=3.4, mfc="none", mec=color, mew=0.8)


def _legend(picture: Picture, ax: Axes, further: bool) -> None:
    from matplotlib.lines import Line2D

    curves: list[Any] = ax.get_legend_handles_labels()[0]
    handles = [
        Line2D([], [], color=curve.get_color(), lw=1.5, marker=mark, ms=4, mfc="none", label=curve.get_label())
        for curve, mark in zip(curves, _MARKS)
    ] + [
        Line2D([], [], color="black", lw=1.5, label="stable"),
        Line2D([], [], color="black", lw=1.5, ls=(0, (3, 1.5)), label="unstable"),
        Line2D([], [], ls="none", label="marks: time integration"),
    ]
    if further:
        handles.append(Line2D([], [], color="black", lw=_THIN, label="not joined to the others"))
    picture.legend(handles=handles, loc="outside upper center", ncols=3, frameon=False)


def _draw_natural_frequencies(stiffness: Array, frequency: Array) -> Picture:
    plt = _pyplot()
    picture: Picture
    with plt.rc_context(STYLE):
        picture, ax = plt.subplots(figsize=(8.0, 5.2), layout="constrained")
        order = "abdec"  # with the stiffest shaft
        for name, color in zip(sorted(order), _COLORS):
            values = frequency[:, order.index(name)]
            ax.semilogx(stiffness, values, color=color, lw=1.8, ls="--" if name == "e" else "-", label=rf"$\omega_{name}$")
        ax.set_xlim(stiffness[0], stiffness[-1])
        ax.set_ylim(0.0, 10.0)
        ax.set_xlabel("stiffness of the middle shaft  $k_3$  [N m/rad]")
        ax.set_ylabel(r"natural frequency $/\, \omega_c$")
        ax.legend(frameon=False)
    return picture


def _pyplot() -> Any:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


# ------------------------------------------------------------------------------------------------- command


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; the exit status."""
    parser = argparse.ArgumentParser(description="Draw the paper's figures 3 to 13.")
    parser.add_argument("numbers", metavar="NUMBER", nargs="*", type=_number, help="figures; all unless told")
    parser.add_argument("--results", metavar="FOLDER", type=Path, default=Path("results"), help="for what is made [results]")
    options = parser.parse_args(arguments)
    try:
        options.results.mkdir(parents=True, exist_ok=True)
        with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
            at_work = {number: _submit(pool, number, options) for number in options.numbers or FIGURES}
            for number, work in at_work.items():
                print(_finish(number, [item.result() for item in work], options.results), flush=True)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except SolverError as error:
        print(f"figures: {error}", file=sys.stderr)
        return 3
    except OSError as error:
        print(f"figures: {error}", file=sys.stderr)
        return 4
    return 0


def _number(text: str) -> int:
    if not text.isdecimal() or int(text) not in FIGURES:
        raise argparse.ArgumentTypeError(f"{text!r}: must be {min(FIGURES)} to {max(FIGURES)}")
    return int(text)


def _submit(pool: ProcessPoolExecutor, number: int, options: argparse.Namespace) -> list[Any]:
    if number == 5:
        return [pool.submit(natural_frequencies, options.results)]
    work = partial(compute, results=options.results)
    return [pool.submit(work, curve) for curve in FIGURES[number].curves]


def _finish(number: int, results: list[Any], folder: Path) -> str:
    """Draw a figure; what there is to say of it."""
    figure = FIGURES[number]
    path = folder / f"fig{number:02}.png"
    lines = [f"figure {number}: {figure.title}: {path}"]
    if number == 3:
        draw_figure(folder, _DPI)
        return lines[0]
    picture = _draw_natural_frequencies(*results[0]) if number == 5 else draw(figure, results)
    picture.savefig(path, dpi=_DPI)
    _pyplot().close(picture)
    for curve, drawn in zip(figure.curves, results if number != 5 else ()):
        lines.append(
            f"   {curve.case}, period {curve.period}: integration keeps {len(drawn.marks)} of {drawn.tried} motions, "
            f"rms within {drawn.difference:.0e}"
        )
        for branch in drawn.branches:
            folds = sum(special.kind == "fold" for special in branch.special_points)
            lines.append(f"      {len(branch)} points, {folds} folds; {branch.ended}")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
