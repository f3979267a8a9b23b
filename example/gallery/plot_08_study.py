"""
A study
=======

A study makes the same analysis of many trains: here of eight damping ratios by eight variations of the mesh stiffness. All cores
work on it, or the cores of a cluster. A folder stores the finished points, so that a stopped study continues. Each process imports
this script once more, hence the line ``if __name__ == "__main__":``.
"""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import geartrain as gt

plt.rcParams.update(gt.plot_style())
train = gt.read_case(Path(sys.argv[0]).resolve().parents[2] / "namelists" / "fig03.nml").train
space = gt.Space({"mesh * damping_ratio": np.linspace(0.03, 0.1, 8), "stiffness_variation": np.linspace(0.05, 0.4, 8)})
study = gt.Study(train, space, response={"start": 0.2, "stop": 2.6}, keep=["largest dynamic_factor"])

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        dataset = study.run(folder)

    figure, ax = plt.subplots(layout="constrained")
    largest = dataset["largest dynamic_factor"]
    lines = ax.contour(*(largest[name] for name in largest.dims[::-1]), largest, levels=[1.5, 2, 3, 4, 5, 6], colors="black")
    ax.clabel(lines)
    ax.set_xlabel("variation of the mesh stiffness")
    ax.set_ylabel("damping ratio of the meshes")
    ax.set_title("largest mesh force over the mean, of all stable motions", fontsize=10)
    plt.show()
