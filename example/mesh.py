"""The drawing of docs/glossary.md, which flank is which: ``python example/mesh.py FOLDER``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import geartrain as gt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw_force", "draw_teeth", "main", "tooth"]

Array = NDArray[np.float64]

ANGLE = np.radians(20)
#: Backlash along the pitch circles; lengths are in modules.
BACKLASH = 0.36
DRIVING, DRIVEN = 20, 32


def tooth(teeth: int, middle: float) -> Array:
    """Outline of an involute tooth about the centre of its gear, (points, 2), from one root to the other."""
    pitch = teeth / 2
    base, tip, root = pitch * np.cos(ANGLE), pitch + 1.0, pitch - 1.25
    radius = np.linspace(max(base, root), tip, 40)
    pressure = np.arccos(np.minimum(base / radius, 1.0))
    half_pitch = (np.pi / 2 - BACKLASH / 2) / (2 * pitch)
    half = half_pitch + (np.tan(ANGLE) - ANGLE) - (np.tan(pressure) - pressure)
    radius, half = np.append(root, radius), np.append(half[0], half)
    angle = middle + np.concatenate([-half, half[::-1]])
    both = np.append(radius, radius[::-1])
    return np.column_stack([both * np.cos(angle), both * np.sin(angle)])


def draw_teeth(ax: Axes) -> None:
    """Draw two gears that touch at the pitch point, the origin; the driving one stands left and turns counter-clockwise."""
    half = np.pi / 2 - BACKLASH / 2
    for teeth, centre, first, color, name in (
        (DRIVING, -DRIVING / 2, -half / DRIVING, "C0", "driving gear"),
        (DRIVEN, DRIVEN / 2, np.pi - half / DRIVEN, "C1", "driven gear"),
    ):
        outline = np.concatenate([tooth(teeth, first + turn * 2 * np.pi / teeth) for turn in range(-4, 5)])
        centred = np.concatenate([outline, [[0.0, 0.0]]])
        ax.fill(centred[:, 0] + centre, centred[:, 1], facecolor=color, alpha=0.3, edgecolor="none")
        ax.plot(outline[:, 0] + centre, outline[:, 1], color=color, linewidth=1.4)
        ax.text(3.1 * np.sign(centre), -3.7, name, ha="center", color="black")
    along = np.array([np.sin(ANGLE), np.cos(ANGLE)])
    ax.plot(*np.outer(along, [-4.2, 4.4]), color="black", linewidth=1.0, linestyle=(0, (6, 2)))
    ax.annotate("line of action", 3.7 * along, (2.3, 4.1), arrowprops={"arrowstyle": "-", "linewidth": 0.6})
    ax.annotate("drive flanks\ntouch: $p > b$", (0, 0), (2.3, -2.2), arrowprops={"arrowstyle": "->", "linewidth": 0.8})
    # The back flanks are apart along the other line of action.
    other = np.array([-np.sin(ANGLE), np.cos(ANGLE)])
    back = np.array([0.0, np.pi / 2 - BACKLASH / 2])
    ax.annotate("", back + BACKLASH * np.cos(ANGLE) * other + 0.55 * other, back + BACKLASH * np.cos(ANGLE) * other,
                arrowprops={"arrowstyle": "<-", "linewidth": 0.8})
    ax.annotate("", back - 0.55 * other, back, arrowprops={"arrowstyle": "<-", "linewidth": 0.8})
    ax.annotate("back flanks are\n$2b$ apart; touch\nwhere $p < -b$", back + 0.1 * other, (-5.0, 2.1),
                arrowprops={"arrowstyle": "->", "linewidth": 0.8})
    for x in (-4.3, 4.6):
        ax.annotate("", (x, 0.6), (x, -1.4), arrowprops={"arrowstyle": "-|>", "linewidth": 1.5, "color": "0.3"})
    ax.set_xlim(-5.2, 5.2)
    ax.set_ylim(-4.3, 4.8)
    ax.set_aspect("equal")
    ax.axis("off")


def draw_force(ax: Axes) -> None:
    """Draw the elastic force of a mesh over its displacement."""
    p = np.array([-2.6, -1, 1, 2.6])
    ax.axvspan(-1, 1, color="0.92", zorder=0)
    ax.plot(p, [-1.6, 0, 0, 1.6], color="black")
    rest = 1.9
    ax.plot([rest], [rest - 1], "o", color="black")
    ax.annotate("at rest under\nthe mean torque", (rest, rest - 1), (0.15, 1.3), arrowprops={"arrowstyle": "->", "linewidth": 0.8})
    for x, words in ((-1.85, "back\nflank"), (0, "gap:\nteeth apart"), (1.85, "drive\nflank")):
        ax.text(x, -1.35, words, ha="center", va="center")
    ax.set_xticks([-1, 0, 1], ["$-b$", "0", "$b$"])
    ax.set_yticks([0])
    ax.set_xlabel(r"mesh displacement  $p = r_1\theta_1 - r_2\theta_2 + e$")
    ax.set_ylabel(r"elastic force of the mesh")


def main() -> None:
    """Draw the picture."""
    with plt.rc_context(gt.plot_style()):
        figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.4), layout="constrained")
        draw_teeth(left)
        draw_force(right)
        figure.savefig(Path(sys.argv[1]) / "mesh.png", dpi=100)


if __name__ == "__main__":
    main()
