"""The tolerance study of docs/studies.md: `python example/tolerance.py processes`, or `dask` for a cluster of local processes.

2,048 trains of figure 3's kind whose damping, backlash and stiffness are each within 10 %: where a sweep in speed jumps, how large
the forces are, and which tolerance decides. Stopped at any moment, the same command goes on. The folder of results and the one of
pictures may follow, and how many base points the design has (256).
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as design

import geartrain as gt

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["PARAMETERS", "draw_distributions", "draw_indices", "indices", "jumps_of_all", "main", "tolerance_study"]

CASE = Path(__file__).resolve().parent.parent / "namelists" / "fig03.nml"
PARAMETERS = [f"mesh {mesh} {name}" for mesh in (1, 2) for name in ("damping_ratio", "half_backlash", "stiffness")]
FACTORS = ["largest mesh 1 dynamic_factor", "largest mesh 2 dynamic_factor"]
PROBLEM = {"num_vars": len(PARAMETERS), "names": PARAMETERS, "bounds": [(0.9, 1.1)] * len(PARAMETERS)}


def tolerance_study(base: int = 256) -> gt.Study:
    """Make the study: Saltelli's design of SALib, 8 trains for each base point."""
    sample = design.sample(PROBLEM, base, calc_second_order=False, seed=1)
    space = gt.Space(sample=sample, names=PARAMETERS, relative=True)
    train = gt.read_case(CASE).train
    return gt.Study(train, space, response={"start": 0.2, "stop": 2.6}, keep=["jumps", *FACTORS])


def run(study: gt.Study, folder: Path, engine: str) -> Dataset:
    """Compute what is not yet in the folder."""
    if engine == "processes":
        return study.run(folder)
    import dask
    from dask.distributed import Client, LocalCluster

    dask.config.set({"distributed.worker.profile.enabled": False})  # it looks at the workers a hundred times a second
    with LocalCluster(threads_per_worker=1) as cluster, Client(cluster) as client:
        print(f"dashboard: {client.dashboard_link}")
        return study.run(folder, client)


def jumps_of_all(dataset: Dataset) -> Dataset:
    """Pick the jumps that every train has, and that could be followed from train to train."""
    everywhere = dataset.jump_frequency.notnull().all("sample") & (dataset.jump_followed.mean("sample") > 0.95)
    return dataset.isel(jump=np.flatnonzero(everywhere))


def outputs_of(dataset: Dataset) -> dict[str, Any]:
    """Name the outputs: the speeds of the jumps that every train has, and the dynamic factors."""
    known = jumps_of_all(dataset)
    jumps = {
        f"{known.jump_kind.values[0, place]}, {known.jump_direction.values[0, place]}, {float(at.mean()):.2f}": at.values
        for place, at in enumerate(known.jump_frequency.transpose("jump", "sample"))
    }
    return {**jumps, **{name.replace("largest ", ""): dataset[name].values for name in FACTORS}}


def indices(dataset: Dataset) -> dict[str, Mapping[str, Any]]:
    """Compute the Sobol indices of every output by SALib: ``S1`` and ``ST`` with ``S1_conf`` and ``ST_conf``, of the parameters."""
    return {
        name: analysis.analyze(PROBLEM, values, calc_second_order=False, seed=1) for name, values in outputs_of(dataset).items()
    }


def draw_distributions(dataset: Dataset, path: Path) -> None:
    """Draw where the trains jump, and their largest dynamic factors."""
    figure, (above, below) = plt.subplots(2, figsize=(9, 7), layout="constrained")
    share = dataset.jump_frequency.notnull().mean("sample").values
    common = np.flatnonzero(share > 0.05)
    for row, place in enumerate(common):
        jump = dataset.isel(jump=place)
        there = jump.jump_frequency.notnull().values
        direction = jump.jump_direction.values[there][0]
        above.violinplot(jump.jump_frequency.values[there], [row], orientation="horizontal", widths=0.9, showextrema=False)
        kinds = "/".join(sorted({*jump.jump_kind.values[there]}))
        above.annotate(f"{direction}, {kinds}, {share[place]:.0%}", (float(jump.jump_frequency.max()), row), xytext=(6, 0),
                       textcoords="offset points", va="center", fontsize=7.5)
    above.set(xlabel="Λ of the jump", yticks=[], xlim=(0.4, 2.6), title=f"jumps of {dataset.sizes['sample']} trains")
    for mesh, name in enumerate(FACTORS, 1):
        below.hist(dataset[name].values, bins=60, alpha=0.7, hatch=("", "////")[mesh - 1], label=f"mesh {mesh}")
    below.set(xlabel="largest dynamic factor of all stable motions", ylabel="trains")
    below.legend()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_indices(found: Mapping[str, Mapping[str, Any]], path: Path) -> None:
    """Draw the Sobol indices of the first order, and the total ones."""
    figure, panels = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained", sharey=True)
    for axes, kind, title in zip(panels, ("S1", "ST"), ("first order", "total")):
        table = np.array([one[kind] for one in found.values()])
        picture = axes.imshow(table, vmin=0, vmax=1, cmap="Blues", aspect="auto")
        for (row, column), value in np.ndenumerate(table):
            color = "white" if value > 0.6 else "black"
            axes.text(column, row, f"{round(value, 2) + 0:.2f}", ha="center", va="center", color=color, fontsize=8)
        names = [name.replace("_", " ") for name in PARAMETERS]
        axes.set_xticks(range(len(names)), names, rotation=35, ha="right", fontsize=8)
        axes.set_yticks(range(len(found)), [name.replace("_", " ") for name in found], fontsize=8)
        axes.grid(visible=False)
        axes.set_title(f"Sobol indices, {title}")
    figure.colorbar(picture, ax=panels, shrink=0.8)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main(engine: str, folder: str = "results/tolerance", pictures: str = "results", base: int = 256) -> None:
    """Run the study, print what it says, and draw it."""
    plt.rcParams.update(gt.plot_style())
    study = tolerance_study(base)
    print(study.explain(folder))
    dataset = run(study, Path(folder), engine)
    print(f"{int((dataset.status == 'done').sum())} of {len(study)} trains done")
    for name, values in outputs_of(dataset).items():
        low, middle, high = np.quantile(values, [0.025, 0.5, 0.975])
        print(f"   {name:30s} median {middle:8.4f}   95 % of the trains from {low:.4f} to {high:.4f}")
    Path(pictures).mkdir(parents=True, exist_ok=True)
    draw_distributions(dataset, Path(pictures) / "tolerance.png")
    draw_indices(indices(dataset), Path(pictures) / "tolerance_indices.png")
    print(f"drawn: tolerance.png and tolerance_indices.png in {pictures}")


if __name__ == "__main__":
    given = sys.argv[1:]
    if not given or given[0] not in ("processes", "dask") or len(given) > 4:
        sys.exit(__doc__)
    main(*given[:3], **({"base": int(given[3])} if len(given) > 3 else {}))
