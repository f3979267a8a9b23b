"""Draws the paper's figures 3 to 13 from their case files: ``geartrain-figures [NUMBER ...] [--results FOLDER]``.

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
from itertools import permutations
from multiprocessing import get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._draw import STYLE, draw_curve
from .branch import Branch
from .case import read_case
from .errors import InputError, SolverError
from .motion import Motion

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Picture

__all__ = ["FIGURES", "Curve", "Drawn", "Figure", "compute", "draw", "main", "natural_frequencies", "once"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """A curve of a figure.

    Attributes
    ----------
    case : str
        Name of its case file, without ``.nml``.
    label : str
    period : int
        Of the motions in mesh periods. Those above 1 need a seed: the motion of this period and of the largest rms on
        which ``starts`` random starts settle at ``seed``, or the one that integration settles on where ``starts`` is 0.
    seed : float
        Lambda.
    starts : int
    """

    case: str
    label: str
    period: int = 1
    seed: float = 0.0
    starts: int = 0


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


@dataclass(frozen=True)
class Drawn:
    """What a curve is drawn from: the branch, and what integration makes of its stable motions."""

    branch: Branch
    kept: Sequence[Motion]
    left: int  # stable motions from which integration went elsewhere, or was not steady after _PATIENCE periods
    difference: float  # largest relative difference of the rms


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
            Curve("fig08_rectangular", r"square wave, $\kappa_{10} = +0.084$"),
            Curve("fig08_printed", r"as printed, $\kappa_{10} = -0.085$"),
        ),
        top=(2.0, 6.0),
    ),
    9: Figure(
        "Mesh damping",
        tuple(Curve(f"fig09_0{hundredths:02}", rf"$\zeta_m = 0.{hundredths:02}$") for hundredths in (5, 3, 1)),
        top=(3.4, 6.0, 6.0),
        panels="curve",
    ),
    10: Figure("Mesh frequencies 1 to 2", (Curve("fig10", "$m_2 = 1, m_4 = 2$"),), top=(2.0, 6.0)),
    11: Figure("Mesh frequencies 3 to 2", (Curve("fig11", "$m_2 = 3, m_4 = 2$"),), top=(2.0, 6.0)),
    12: Figure(
        "Period-2 motions",
        (
            Curve("fig12", "period 1"),
            Curve("fig12", r"period 2 near $2\omega_a$", 2, 1.92),
            Curve("fig12", r"period 2 near $2\omega_b$", 2, 3.7),
            Curve("fig12", r"period 2 near $2\omega_b$, back collisions", 2, 2.8, 200),
        ),
        top=(5.0, 6.0),
        right=4.2,
    ),
    13: Figure(
        "Period-3 motions",
        (Curve("fig13", "period 1"), Curve("fig13", r"period 3 near $3\omega_a$", 3, 2.4, 200)),
        top=(1.0, 2.8),
        left=1.4,
        right=3.0,
    ),
}

_COLORS = ("#1f4e9c", "#c8391e", "#2e8b57", "#8a5fb0")
_SPACING = 0.05  # Lambda from one mark to the next
_KEPT = 1e-2  # relative difference of the rms up to which integration has stayed on the motion it began with
_PATIENCE = 20000  # mesh periods: a soft shaft between the gear pairs damps little
_DPI = 90
_SHAFT_RANGE = np.logspace(3, 9, 241)  # stiffness of the middle shaft in figure 5, N m/rad


# ------------------------------------------------------------------------------------------------- compute


def compute(curve: Curve, cases: Path, results: Path) -> Drawn | None:
    """Compute a curve; the whole case goes to the results folder.

    Parameters
    ----------
    curve : Curve
    cases, results : path
        Folders.

    Returns
    -------
    Drawn or None
        None for a case without a response, or with an integration of its own.
    """
    case = read_case(cases / f"{curve.case}.nml")
    if curve.period == 1:
        result = case.run()
        result.write(results / f"{curve.case}.h5")
        if result.response is None or result.integration is not None:
            return None
        branch = result.response
    else:
        train = case.train
        found = train.attractors(curve.seed, starts=curve.starts) if curve.starts else [train.integrate(curve.seed)]
        seeds = [motion for motion in found if motion.period == curve.period]
        if not seeds:
            raise SolverError(f"{curve.case}: no motion of period {curve.period} at Lambda = {curve.seed}")
        seed = max(seeds, key=lambda motion: motion.rms.max())
        branch = train.response(start=0.2, stop=4.6, subharmonic=curve.period, harmonics=8 * curve.period, seed=seed)
    return _integrated(branch)


def _integrated(branch: Branch) -> Drawn:
    """Integrate from the branch's stable motions; those that stay are the marks."""
    kept: list[Motion] = []
    left, difference = 0, 0.0
    first = np.ceil(branch.frequency.min() / _SPACING)
    for frequency in _SPACING * np.arange(first, branch.frequency.max() / _SPACING):
        seen: list[Array] = []
        for motion in branch.at(float(frequency)):
            twin = any(np.allclose(motion.rms, rms, rtol=1e-5) for rms in seen)
            seen.append(motion.rms)
            if twin or not motion.stable:
                continue
            settled = branch.train.integrate(  # type: ignore[union-attr]
                float(frequency), start=motion, stability=False, max_periods=_PATIENCE, tolerance=1e-7
            )
            change = float(np.max(np.abs(settled.rms - motion.rms)) / np.max(motion.rms))
            if settled.period == branch.subharmonic and change < _KEPT:
                kept.append(settled)
                difference = max(difference, change)
            else:
                left += 1
    return Drawn(branch, kept, left, difference)


def natural_frequencies(cases: Path, results: Path) -> tuple[Array, Array]:
    """Figure 5: natural frequencies over the stiffness of the middle shaft, each mode followed by its shape.

    Parameters
    ----------
    cases, results : path
        Folders.

    Returns
    -------
    stiffness : ndarray, (points,)
        N m/rad.
    frequency : ndarray, (points, modes)
        In the order that the modes have with the stiffest shaft.
    """
    case = read_case(cases / "fig05.nml")
    case.run().write(results / "fig05.h5")
    train = case.train
    radius = [mesh.driving_radius for mesh in train.meshes] + [train.meshes[-1].driven_radius]
    frequency, before = [], None
    for stiffness in _SHAFT_RANGE[::-1]:
        shafts = list(train.shafts)
        middle = len(shafts) // 2
        shafts[middle] = replace(shafts[middle], stiffness=float(stiffness))
        modes = replace(train, shafts=shafts).modes()
        # Times the root of the stiffness, shapes of different modes are perpendicular; a shaft's twist is an arc in them.
        energy = [shaft.stiffness / r**2 for shaft, r in zip(shafts, radius)]
        for place, mesh in enumerate(train.meshes):
            energy.insert(2 * place + 1, mesh.stiffness)
        shape = modes.shape * np.sqrt(energy)
        shape /= np.linalg.norm(shape, axis=1, keepdims=True)
        if before is None:
            order = list(range(len(shape)))
        else:
            overlap = np.abs(before @ shape.T) ** 2
            order = list(max(permutations(range(len(shape))), key=lambda chosen: overlap[range(len(shape)), chosen].sum()))
        before = shape[order]
        frequency.append(modes.natural_frequency[order])
    return _SHAFT_RANGE, np.array(frequency[::-1])


def once(branch: Branch) -> slice:
    """The points of a sub-harmonic branch without its repetition.

    Where such a branch passes a motion of period 1, its sub-harmonics change sign and it goes on through the same motions a
    mesh period later.
    """
    harmonic = np.arange(1, (branch.coefficients.shape[-1] - 1) // 2 + 1)
    own = np.repeat(harmonic % branch.subharmonic != 0, 2)
    values = branch.coefficients[:, :, 1:][:, :, own].reshape(len(branch), -1)
    cuts = np.flatnonzero(np.einsum("ij,ij->i", values[1:], values[:-1]) < 0)
    if branch.subharmonic == 1 or not len(cuts):
        return slice(0, len(branch))
    if branch.closed and len(cuts) > 1:
        return slice(int(cuts[0]), int(cuts[1]) + 2)
    return slice(int(cuts[0]), None) if cuts[0] < len(branch) // 2 else slice(0, int(cuts[0]) + 2)


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
            for (drawn, mesh, label), color in zip(entries, _palette(figure)):
                _draw_one(ax, drawn, mesh, label, color)
            ax.set_xlim(figure.left, figure.right)
            ax.set_ylim(0.0, figure.top[place])
            ax.set_ylabel(ylabel)
            ax.set_title(f"({'abc'[place]})  {title}", loc="left", fontsize=12, fontweight="bold")
        axes[-1].set_xlabel(r"mesh frequency  $\Lambda = \omega / \omega_c$")
        _legend(picture, axes[0])
    return picture


def _palette(figure: Figure) -> tuple[str, ...]:
    """Period-1 motions under others are grey."""
    return ("0.55", *_COLORS) if figure.curves[-1].period > 1 else _COLORS


def _draw_one(ax: Axes, drawn: Drawn, mesh: int, label: str, color: str) -> None:
    branch, kept = drawn.branch, once(drawn.branch)
    stable = None if branch.stable is None else branch.stable[kept]
    style: dict[str, Any] = {"color": color, "lw": 1.5}
    draw_curve(ax, branch.frequency[kept], branch.rms[kept, mesh], stable, branch.part[kept], label, **style)
    marks = [(motion.frequency, motion.rms[mesh]) for motion in drawn.kept]
    if marks:
        ax.plot(*np.transpose(marks), ls="none", marker="s", ms=3.4, mfc="none", mec=color, mew=0.8)


def _legend(picture: Picture, ax: Axes) -> None:
    from matplotlib.lines import Line2D

    handles, _ = ax.get_legend_handles_labels()
    handles += [
        Line2D([], [], color="black", lw=1.5, label="stable"),
        Line2D([], [], color="black", lw=1.5, ls=(0, (3, 1.5)), label="unstable"),
        Line2D([], [], ls="none", marker="s", ms=3.4, mfc="none", mec="black", mew=0.8, label="time integration"),
    ]
    picture.legend(handles=handles, loc="outside upper center", ncols=min(4, len(handles)), frameon=False)


def _draw_natural_frequencies(stiffness: Array, frequency: Array) -> Picture:
    plt = _pyplot()
    with plt.rc_context(STYLE):
        picture, ax = plt.subplots(figsize=(8.0, 5.2), layout="constrained")
        order = "abdec"  # with the stiffest shaft
        for name, color in zip(sorted(order), (*_COLORS, "#d98a1f")):
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
    parser = argparse.ArgumentParser(prog="geartrain-figures", description="Draw the paper's figures 3 to 13.")
    parser.add_argument("numbers", metavar="NUMBER", nargs="*", type=_number, help="figures; all unless told")
    parser.add_argument("--results", metavar="FOLDER", type=Path, default=Path("results"), help="for what is made [results]")
    parser.add_argument("--cases", metavar="FOLDER", type=Path, default=Path("namelists"), help="of case files [namelists]")
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
        print(f"geartrain-figures: {error}", file=sys.stderr)
        return 3
    except OSError as error:
        print(f"geartrain-figures: {error}", file=sys.stderr)
        return 4
    return 0


def _number(text: str) -> int:
    if not text.isdecimal() or int(text) not in FIGURES:
        raise argparse.ArgumentTypeError(f"{text!r}: must be {min(FIGURES)} to {max(FIGURES)}")
    return int(text)


def _submit(pool: ProcessPoolExecutor, number: int, options: argparse.Namespace) -> list[Any]:
    if number == 5:
        return [pool.submit(natural_frequencies, options.cases, options.results)]
    work = partial(compute, cases=options.cases, results=options.results)
    return [pool.submit(work, curve) for curve in FIGURES[number].curves]


def _finish(number: int, results: list[Any], folder: Path) -> str:
    """Draw a figure; what there is to say of it."""
    figure = FIGURES[number]
    path = folder / f"fig{number:02}.png"
    lines = [f"figure {number}: {figure.title}: {path}"]
    if number == 3:
        from .demo import draw_figure

        draw_figure(folder, _DPI)
        return lines[0]
    picture = _draw_natural_frequencies(*results[0]) if number == 5 else draw(figure, results)
    picture.savefig(path, dpi=_DPI)
    _pyplot().close(picture)
    for curve, drawn in zip(figure.curves, results if number != 5 else ()):
        branch = drawn.branch
        folds = sum(special.kind == "fold" for special in branch.special_points)
        lines.append(
            f"   {curve.case}, period {curve.period}: {len(branch)} points, {folds} folds; integration keeps "
            f"{len(drawn.kept)} of {len(drawn.kept) + drawn.left} motions, rms within {drawn.difference:.1e}\n"
            f"      {branch.ended}"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
