"""The pictures of the report."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import NullLocator

import geartrain as gt

plt.rcParams.update(gt.plot_style())

STYLES = {
    "exact": ("C0", "o", "-"), "adaptive": ("C2", "s", "-"), "sampled, Q = 64": ("0.75", "v", ":"),
    "sampled, Q = 256": ("0.55", "v", ":"), "sampled, Q = 1024": ("0.35", "v", ":"), "sampled, Q = 4096": ("0.15", "v", ":"),
    "integration": ("C1", "^", "--"), "shooting": ("black", "*", "none"),
}  # fmt: skip
PEER_STYLES = {
    "geartrain": ("C0", "o"), "geartrain, adaptive": ("C2", "s"), "pyHarm": ("C3", "v"),
    "jaxcont": ("C4", "D"), "AUTO-07p": ("C5", "s"), "SciPy": ("C1", "^"),
}  # fmt: skip


def save(figure, path):
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_peers(found, path):
    """Median error of rms, with a bar to the largest: over the time of the whole process, over that of a point in a call."""
    figure, both = plt.subplots(1, 2, figsize=(12.5, 5.2), layout="constrained", sharey=True)
    for axes, time_of, what in (
        (both[0], lambda row: np.median(row["process"]), "time of the curve, whole process [s]"),
        (both[1], lambda row: np.median(row["curve"] or row["process"]) / row["points"], "time of a point within a process [s]"),
    ):
        for name, rows in grouped(found["rows"]).items():
            color, marker = PEER_STYLES[name]
            rows = sorted(rows, key=time_of)
            time, middle = [time_of(row) for row in rows], [row["errors"]["median"] for row in rows]
            bars = [np.zeros(len(rows)), [row["errors"]["largest"] - row["errors"]["median"] for row in rows]]
            axes.errorbar(time, middle, bars, color=color, marker=marker, linewidth=1, capsize=2, label=name)
            for x, row in zip(time, rows):
                setting = row["label"].split(", ")[-1].replace("tolerance ", "").replace("intervals", "int.")
                offset = (4, 3) if name in ("pyHarm", "geartrain, adaptive") else (4, -9)
                side = "left"
                if name == "geartrain":  # the adaptive rows lie on its right
                    offset, side = (-5, -9), "right"
                axes.annotate(
                    setting, (x, row["errors"]["median"]), offset, textcoords="offset points", fontsize=7, color=color, ha=side
                )
        axes.set(xscale="log", yscale="log", xlabel=what)
        axes.margins(x=0.12)
        axes.grid(alpha=0.3)
    both[0].set(ylabel="relative error of rms: median (marker), largest (bar)")
    both[1].legend(fontsize=8, loc="upper right")
    figure.suptitle("Figure 3's curve")
    save(figure, path)


def grouped(rows):
    """Rows by tool, geartrain's with a tolerance by themselves."""
    groups = {}
    for row in rows:
        name = next(tool for tool in PEER_STYLES if row["tool"].startswith(tool))
        if row.get("adaptive"):
            name = "geartrain, adaptive"
        groups.setdefault(name, []).append(row)
    return groups


def label_sizes(axes, sizes):
    """A logarithmic axis that names the sizes measured, and no others."""
    axes.set_xscale("log")
    axes.set_xticks(sizes, [str(size) for size in sizes])
    axes.xaxis.set_minor_locator(NullLocator())


def panels(cases):
    figure, axes = plt.subplots(2, 3, figsize=(12, 7.5), layout="constrained")
    for place, case in zip(axes.flat, cases, strict=False):
        place.set(xscale="log", yscale="log", title=f"{case['name']}, Lambda = {case['frequency']:g}")
        place.grid(alpha=0.3)
    for place in axes.flat[len(cases) :]:
        place.axis("off")
    return figure, axes


def draw_accuracy(found, path):
    """Error of the waveform over the time of a point, a panel a case."""
    figure, axes = panels(found["cases"])
    for place, case in zip(axes.flat, found["cases"], strict=False):
        for name, rows in case["lines"].items():
            color, marker, line = STYLES[name]
            times, errors = [np.median(row["seconds"]) for row in rows], [row["error"] for row in rows]
            size = 9 if name == "shooting" else 4
            place.plot(times, errors, line, color=color, marker=marker, markersize=size, label=name)
        place.set(xlabel="time of a point [s]", ylabel="error of the waveform")
    axes.flat[-1].legend(*axes.flat[0].get_legend_handles_labels(), loc="center", fontsize=11)
    save(figure, path)


def draw_orders(found, path):
    """Error of the waveform over R, exact and sampled, with the slope that theory has."""
    figure, axes = panels(found["cases"])
    for place, case in zip(axes.flat, found["cases"], strict=False):
        for name, rows in case["lines"].items():
            if name in ("adaptive", "integration", "shooting"):
                continue
            color, marker, line = STYLES[name]
            harmonics, errors = [row["harmonics"] for row in rows], [row["error"] for row in rows]
            place.plot(harmonics, errors, line, color=color, marker=marker, markersize=4, label=name)
        exact = case["lines"]["exact"]
        if case["order"] and len(exact) > 2:
            span = np.array([12, exact[-1]["harmonics"]])
            middle = exact[len(exact) // 2]
            line = 2 * middle["error"] * (span / middle["harmonics"]) ** -float(case["order"])
            place.plot(span, line, "--", color="black", linewidth=1)
            place.annotate(f"R^-{case['order']}", (span[0], line[0]), (4, 4), textcoords="offset points")
        label_sizes(place, [row["harmonics"] for row in exact])
        place.set(xlabel="harmonics R", ylabel="error of the waveform")
    axes.flat[-1].legend(*axes.flat[0].get_legend_handles_labels(), loc="center", fontsize=11)
    save(figure, path)


def draw_scale(found, path):
    """Time over shafts, time over harmonics, memory over shafts."""
    figure, axes = plt.subplots(1, 3, figsize=(12, 4), layout="constrained")
    for place, rows, what in ((axes[0], found["shafts"], "shafts"), (axes[1], found["harmonics"], "harmonics R")):
        label_sizes(place, [row["size"] for row in rows][:: 1 + len(rows) // 8])
        for key, color, marker in (("without", "C0", "o"), ("with", "C3", "s")):
            known = [(row["size"], np.median(row[key])) for row in rows if key in row]
            place.plot(*zip(*known, strict=True), color=color, marker=marker, markersize=4, label=f"{key} multipliers")
        size = np.array([rows[0]["size"], rows[-1]["size"]])
        place.plot(size, np.median(rows[0]["without"]) * size / size[0], "k--", linewidth=1, label="linear")
        place.set(xlabel=what, ylabel="time of a call of few points [s]")
        place.legend(fontsize=8)
    sizes, peaks = zip(*((row["size"], row["memory"][0] / 2**20) for row in found["memory"]))
    axes[2].plot(sizes, peaks, "o-", markersize=4)
    axes[2].set(xlabel="shafts", ylabel="peak memory of the executable [MiB]")
    label_sizes(axes[2], [row["size"] for row in found["memory"]][:: 1 + len(found["memory"]) // 8])
    for place in axes:
        place.grid(alpha=0.3)
    for place in axes[:2]:
        place.set(yscale="log")
    axes[2].set_ylim(0, 1.2 * axes[2].get_ylim()[1])
    save(figure, path)
