"""The report: docs/speed.md. Its numbers come from the rows, and no sentence claims what no row shows."""

import textwrap
from pathlib import Path

import numpy as np

import pictures
from timing import spread

TARGETS = (1e-2, 1e-4, 1e-6, 1e-8)
MAX_COLUMNS = 132


WHERE = """## Which method to use

| for | use |
|---|---|
| a whole curve, folds and unstable motions included | harmonic balance, `harmonics = 6` to `24` |
| a curve to a given error | `harmonics = 0` with `tolerance` |
| motions to an error below 1e-6; a stiffness that jumps | few harmonics, then `motion.refine()`, which is shooting |
| where given initial conditions lead, unknown periods | time integration |
| comparing with the paper and other codes | `coefficients = 'sampled'` |
"""


def table(header, rows):
    """A markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def filled(text):
    """The text with its lines broken at the largest number of columns, but for tables."""
    return "\n".join(
        line if line.startswith("|") else textwrap.fill(line, MAX_COLUMNS, break_long_words=False, break_on_hyphens=False)
        for line in text.split("\n")
    )


def duration(seconds):
    return spread([float(np.median(seconds))])


def locus_rows(rows):
    for row in rows:
        if "failed" in row:
            yield row["train"], row["tool"], row["failed"], "", "", "", "", ""
            continue
        told = [f"{value(row['errors']):.0e}" for value in (np.median, max)] if row["errors"] is not None else ["", ""]
        each = spread([float(np.median(row["seconds"])) / row["points"]])
        yield row["train"], row["tool"], row["points"], "yes" if row["whole"] else "no", spread(row["seconds"]), each, *told


def locus_section(found):
    header = ("train", "tool", "points", "to both ends", "processor time", "a point", "error of Lambda, median", "largest")
    return f"""## The curve of a fold

A fold is followed over Lambda and the stiffness variation, from 0.05 to 0.5, through its cusp, by `train.locus` and AUTO-07p with
`ISW = 2`: a fold of figure 3 at the resonance 1.55, and one of one gear pair (`namelists/single_pair.nml`). The error is the
distance in Lambda from `special.exact()` of the train with that stiffness variation, at 12 points of each curve. With exact
backlash the derivatives of AUTO's collocation jump at corners, which are therefore rounded over a width of p, in units of half the
backlash.

{table(header, locus_rows(found["rows"]))}"""


def machine_section(found):
    versions = ", ".join(f"{name} {value}" for name, value in found["versions"].items())
    return f"""{found["processor"]}, {found["cores"]} cores, {found["system"]}; one core and one thread for every tool. {versions}.
The load of the machine before the first measurement was {found["load"]:.1f}.
Times are medians, with the shortest and the longest in brackets.
"""


def curve_rows(rows):
    for row in rows:
        errors = row["errors"]
        yield (
            row["label"], row["points"], spread(row["process"]), duration(row["curve"]) if row["curve"] else "",
            duration([value / row["points"] for value in row["curve"] or row["process"]]), "yes" if row["stability"] else "no",
            f"{errors['median']:.0e}", f"{errors['largest']:.0e} at {errors['largest_at']:.3f}",
        )  # fmt: skip


def curve_section(found):
    rows = found["rows"]
    skipped = "".join(f"- {item['label']}: not measured: {item['reason']}\n" for item in found["skipped"])
    swept = [
        f"{row['label']}: {row['run']} of its {row['points']}, {row['errors']['elsewhere']} settled on motions of other curves"
        for row in rows
        if row["swept"]
    ]
    partial = f"SciPy ran a part of its frequencies, and its time is scaled to all of them ({'; '.join(swept)})." if swept else ""
    tools = sorted({row["tool"] for row in rows} - {"geartrain"})
    check = ""
    if found["check"]:
        check = f"""SciPy's DOP853 at rtol 1e-12 checked shooting itself on {found["check"]["orbits"]} orbits,
stable and unstable: rms agrees to {found["check"]["rms"]:.0e} (relative), and after a period the orbits close to
{found["check"]["closure"]:.0e}."""
    return f"""## Figure 3 beside other tools

Each tool computes the whole curve, Lambda 0.2 to 2.6, through its 8 folds, in one run: {", ".join(tools)}.
*Process* is the time from the start of a process to its end. For geartrain the process is the executable with multipliers
at every point, from the case file to the closed HDF5 file. *Call* is the time of the same curve in a process that has
computed one before. The error is the relative error of rms against
shooting at the same Lambda, for the worse mesh, at up to 100 points of each tool farther than 0.01 from a fold.

{table(("tool", "points", "process", "call", "a point", "stability", "error, median", "largest, at Lambda"), curve_rows(rows))}
{check}

{partial}
pyHarm, jaxcont and SciPy compute no stability. Most of jaxcont's process is import and compilation; *call* is its second curve.
The authors of geartrain wrote the train for these tools (`benchmarks/peers/`), with 5 (1 + 2R) unknowns. The largest errors occur
where the curve is nearly vertical. With a tolerance the harmonics suffice for the torques of the shafts too, so rms is more
exact than asked.
{skipped}
The paper and the tools use R = 6. At its few worst points geartrain at R = 6 is no more exact than the tools, and SciPy's sweep is
more exact everywhere.

![Error of rms over time of a point, geartrain and peers](speed/peers.png)
"""


def fastest(case, target):
    """Name and time of the method that first gets a point of this case below an error."""
    reached = [
        (np.median(row["seconds"]), f"{name}, {row['setting']}")
        for name, rows in case["lines"].items()
        for row in rows
        if row["error"] <= target
    ]  # fmt: skip
    seconds, name = min(reached)
    return f"{name}: {duration([seconds])}"


def errors_by_harmonics(case):
    rows = {row["harmonics"]: row["error"] for row in case["lines"]["exact"]}
    return ", ".join(f"{rows[count]:.0e} at R = {count}" for count in (6, 12, 24) if count in rows)


def accuracy_section(found):
    cases = found["cases"]
    choice = [(case["name"], *(fastest(case, target) for target in TARGETS)) for case in cases]
    orders = [
        (
            case["name"], case["what"], f"{case['frequency']:g}",
            "spectral" if case["order"] is None else f"R^-{case['order']}",
            errors_by_harmonics(case) if case["order"] is None else f"R^-{case['fitted']:.2f}" if case["fitted"] else "not fitted",
        )
        for case in cases
    ]  # fmt: skip
    return f"""## Error against time of a point

The error of the waveform is the largest deviation of any mesh at any instant from shooting, over the largest alternating
displacement. Time is the time of one point of a branch without multipliers. For integration it is the time to settle from the
steady motion of a neighbouring frequency.

![Error of the waveform over time of a point, five cases](speed/accuracy.png)

![Error of the waveform over number of harmonics, five cases](speed/order.png)

{table(("case", "what", "Lambda", "order by theory", "fitted, R >= 12"), orders)}
The next table has the fastest method below an error of the waveform, and its time. *Shooting* is harmonic balance at R = 12 and
`refine` together:

{table(("case", *(f"{target:.0e}" for target in TARGETS)), choice)}"""


def size_rows(rows, *shape):
    return [
        (row["size"], *shape, *(duration(row[key]) if row.get(key) else "not measured" for key in ("without", "with")),
         row["points"])
        for row in rows
    ]  # fmt: skip


def scale_section(found):
    memory = {row["size"]: f"{row['memory'][0] / 2**20:.1f} MiB" for row in found["memory"]}
    shafts = [(*row, memory.get(row[0], "")) for row in size_rows(found["shafts"][::2])]
    # What was measured before there were trees has none.
    trees = tree_rows(found.get("trees", {"chain": []}))
    missing = " *Not measured*: the size before took too long." if "not measured" in str(shafts) else ""
    return f"""## Size

The table has the time of a call from Python for a range of 0.01 at R = 6, from a motion that is known, with all that a call does
before and after its points: chains of figure 3's gear pairs, with tooth separation at the first of them. Memory is the peak of the
executable with its libraries.{missing} The motions of the long chains are unstable: all multipliers outside the unit circle are
found.

{table(("shafts", "a call, without multipliers", "with", "points", "memory"), shafts)}
Trees and chains of equal pairs without separation are stable, which a bound shows without multipliers:

{table(("meshes", "shape", "a call, without multipliers", "with", "points"), trees)}
Figure 3's train with more harmonics:

{table(("R", "a call, without multipliers", "with", "points"), size_rows(found["harmonics"][::2]))}
![Time of a call of few points and memory over size](speed/scale.png)
"""


def tree_rows(trees):
    """Times of a call for each shape, of the largest size."""
    sizes = sorted({row["size"] for rows in trees.values() for row in rows})
    return [row for shape, rows in trees.items() for row in size_rows(rows, shape) if row[0] == sizes[-1]]


def cores_section(found):
    rows = [
        (row["what"], spread(row["one"]), spread(row["every"]), f"{np.median(row['one']) / np.median(row['every']):.2f}",
         "yes" if row["same"] else "**no**")
        for row in found["rows"]
    ]  # fmt: skip
    return f"""## Many cases, all cores

The time is measured for one call of the executable until all files are closed, on one thread and on {found["cores"]}.

{table(("what", "1 thread", f"{found['cores']} threads", "faster by", "the same bits"), rows)}"""


def study_section(found):
    plain = found["rows"]["plain loop"][1]
    rows = [
        (engine, f"{wall:.0f} s", f"{cpu:.0f} s", f"{cpu / plain - 1:.1%}",
         f"{plain / ((1 if engine == 'plain loop' else found['workers']) * wall):.2f}", f"{memory:.0f} MB")
        for engine, (wall, cpu, memory) in found["rows"].items()
    ]  # fmt: skip
    return f"""## Studies

{found["points"]} responses of figure 3's train, with each value of its meshes within 10 % ([studies.md](studies.md)), on
{found["workers"]} processes. Overhead compares the processor time of all processes with that of the plain loop.
Efficiency is the time of the plain loop over the product of processes and wall time.

{table(("engine", "wall time", "processor time", "overhead", "efficiency", "client's memory"), rows)}
{found["read"]} points are read back in {found["seconds"]:.1f} s, a Dataset of {found["size"]:.0f} MB."""


def gearboxes_section(found):
    rows = [(row["case"], spread(row["seconds"]), "yes" if row["complete"] else "no") for row in found["rows"]]
    return f"""## Real gearboxes

The table has the processor time of whole runs of the executable. The gearbox of a wind turbine of 750 kW has three stages (120/21,
82/23, 88/22); its common period is 7216 cycles of its fastest mesh. The gearbox of a truck has two countershafts and four idle
meshes that rattle (`test/python/gearboxes.py`). The reducer has two stages (`namelists/reducer.nml`). `python
benchmarks/real_gearboxes.py EXECUTABLE` measures another executable.

{table(("case", "processor time", "complete"), rows)}"""


def write(found, path):
    """docs/speed.md and its pictures, from the rows of all parts."""
    folder = path.with_suffix("")
    folder.mkdir(exist_ok=True)
    pictures.draw_peers(found["curve"], folder / "peers.png")
    pictures.draw_accuracy(found["accuracy"], folder / "accuracy.png")
    pictures.draw_orders(found["accuracy"], folder / "order.png")
    pictures.draw_scale(found["scale"], folder / "scale.png")
    measured = "; ".join(f"{name} {part['measured']}" for name, part in found.items())
    sections = (
        machine_section(found["machine"]), WHERE, curve_section(found["curve"]), accuracy_section(found["accuracy"]),
        scale_section(found["scale"]), cores_section(found["cores"]), study_section(found["study"]),
        locus_section(found["locus"]), gearboxes_section(found["gearboxes"]),
    )  # fmt: skip
    intro = f"""# Speed against error

`benchmarks/run` writes this page. It installs the other tools from packages, measures all of them on the machine at hand and draws
the pictures. Measured: {measured}.

"""
    text = intro + "\n\n".join(section.strip() for section in sections) + "\n"
    Path(path).write_text(filled(text), encoding="utf-8")
