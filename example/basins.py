"""The pictures of docs/basins.md: ``python example/basins.py FOLDER`` from the root of the project, in two minutes."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

sys.path.insert(0, str(Path(__file__).resolve().parent / "paper"))

from paper_cases import paper_case

__all__ = ["main"]


def main() -> None:
    """Draw the basins of figure 3's train at 0.7, and a bifurcation diagram of figure 4's with its exponents."""
    plt.rcParams.update(gt.plot_style())
    folder = Path(sys.argv[1])
    train = gt.read_case("namelists/fig03.nml").train
    figure, axes = plt.subplots(1, 2, figsize=(11, 5.4), layout="constrained")
    for mesh, ax in enumerate(axes, 1):
        train.basins(0.7, mesh=mesh).plot(ax=ax)
    figure.savefig(folder / "basins.png", dpi=82)

    train = paper_case("fig04_k3_5e5").train
    diagram = train.bifurcation_diagram(start=1.0, stop=2.0, points=401)
    figure, axes = plt.subplots(2, 1, figsize=(11, 7), sharex=True, layout="constrained")
    diagram.plot(mesh=2, ax=axes[0])
    diagram.plot(what="lyapunov_exponents", ax=axes[1])
    axes[0].set_xlabel("")
    axes[1].axhline(0.0, color="black", linewidth=0.6)
    axes[1].set_ylim(bottom=-0.03)
    figure.savefig(folder / "bifurcation_diagram.png", dpi=82)


if __name__ == "__main__":
    main()
