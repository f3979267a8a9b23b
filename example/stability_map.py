"""The picture of docs/python.md: ``python example/stability_map.py FOLDER`` from the root of the project, in a minute."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import geartrain as gt

__all__ = ["main"]


def main() -> None:
    """Draw the maps of the linear train above, of the train with backlash below."""
    plt.rcParams.update(gt.plot_style())
    figure, axes = plt.subplots(2, 2, figsize=(11, 6.6), sharex=True, sharey=True, layout="constrained")
    for row, (name, words) in zip(axes, (("linear", "without backlash"), ("nonlinear", "with backlash"))):
        chart = gt.read_case(f"namelists/map_{name}.nml").run().stability_map
        for ax, what in zip(row, ("spectral_radius", "stable_motions")):
            chart.plot(what, ax=ax)
            ax.set_title(words, fontsize=10)
            ax.label_outer()
    figure.savefig(Path(sys.argv[1]) / "stability_map.png", dpi=82)


if __name__ == "__main__":
    main()
