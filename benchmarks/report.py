"""The report: docs/speed.md. Its numbers come from the rows, and no sentence claims what no row shows."""

from pathlib import Path

import numpy as np

import geartrain as gt
import pictures
from timing import spread

TARGETS = (1e-2, 1e-4, 1e-6, 1e-8)


WHERE = """## Where each method should be used

| for | use | rows that show it |
|---|---|---|
| a whole curve, folds and unstable motions included | harmonic balance, `harmonics = 6` to `24` | figure 3, R = 6 to 24 |
| a curve to a given error | `harmonics = 0` with `tolerance` | figure 3, the rows with a tolerance |
| motions to more digits than the fastest balance gives | `motion.refine()`, shooting | fastest method, columns 1e-6 and 1e-8 |
| a stiffness that jumps | few harmonics, then `refine()` | fastest method, square wave |
| where given initial conditions lead, unknown periods | time integration | needs no start; times in the picture |
| comparing with the paper and other codes | `coefficients = 'sampled'` | error over R: its lines level off |
"""


def table(header, rows):
    """A markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


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

A fold over Lambda and the stiffness variation, 0.05 to 0.5, through its cusp: figure 3's of the resonance at 1.55, and that of
one gear pair (`namelists/single_pair.nml`), by `train.locus` and by AUTO-07p with `ISW = 2`. Measured alone by
`python benchmarks/locus.py`. Times are of the processor, of the curve alone. The error is the distance in Lambda of points from
`special.exact()` of the train with that stiffness variation, at 12 points of each curve. With exact backlash the derivatives of
AUTO's collocation jump where a collocation point passes a corner, so its corners are rounded over a width of p, in units of half
the backlash, and the motion is that of another train.

{table(header, locus_rows(found["rows"]))}"""


def machine_section(found):
    versions = ", ".join(f"{name} {value}" for name, value in found["versions"].items())
    return f"""{found["processor"]}, {found["cores"]} cores, {found["system"]}; one core and one thread for every tool. {versions}.
The load before the first measurement was {found["load"]:.1f}. Times are medians, with the shortest and the longest in brackets.
"""


def curve_rows(rows):
    for row in rows:
        errors = row["errors"]
        yield (
            row["label"], row["points"], spread(row["process"]), spread(row["curve"]) if row["curve"] else "",
            duration([value / row["points"] for value in row["curve"] or row["process"]]), "yes" if row["stability"] else "no",
            f"{errors['median']:.0e}", f"{errors['largest']:.0e} at {errors['largest_at']:.3f}",
        )  # fmt: skip


def ratio_rows(rows):
    """How many times geartrain (multipliers at every point) is faster than the tools beside it: at R = 6, and the fastest of its
    rows whose median and largest error are both below the tool's."""
    own = next(row for row in rows if row["label"] == "geartrain, R = 6")
    for row in rows:
        if row["tool"] == "geartrain":
            continue
        process = np.median(row["process"]) / np.median(own["process"])
        calls = ""
        if row["curve"] and not row["swept"]:
            like = own["curve"] if row["stability"] else own["without"]
            calls = f"{np.median(row['curve']) / np.median(like):,.3g}"
        exact = [
            (np.median(row["process"]) / np.median(other["process"]), other["label"].removeprefix("geartrain, "))
            for other in rows
            if other["tool"] == "geartrain" and all(other["errors"][key] < row["errors"][key] for key in ("median", "largest"))
        ]
        times, name = max(exact, default=(0, ""))
        yield row["label"], f"{process:,.3g}", calls, f"{times:,.3g}, {name}" if exact else "none"


def curve_section(found):
    rows = found["rows"]
    skipped = "".join(f"- {item['label']}: not measured: {item['reason']}\n" for item in found["skipped"])
    swept = [
        f"{row['label']}: {row['run']} of its {row['points']}, {row['errors']['elsewhere']} settled on motions off this curve"
        for row in rows
        if row["swept"]
    ]
    partial = f"SciPy ran a part of its frequencies, the time is scaled to all of them ({'; '.join(swept)})." if swept else ""
    tools = sorted({row["tool"] for row in rows} - {"geartrain"})
    check = ""
    if found["check"]:
        check = f"""Shooting itself was checked by SciPy's DOP853 at rtol 1e-12 on {found["check"]["orbits"]} orbits,
stable and unstable: rms agrees to {found["check"]["rms"]:.0e} (relative), and after a period the orbits close to
{found["check"]["closure"]:.0e}."""
    return f"""## Figure 3 beside other tools

The whole curve, Lambda 0.2 to 2.6, through its 8 folds, in one run: {", ".join(tools)}.
*Process* is from the start of the process to its end; for geartrain that is the executable, the case read and the HDF5 file closed,
multipliers at every point. *Call* is the same curve within a process that has run one before. The error is that of rms, the larger
of both meshes, relative to shooting at the same Lambda, at up to 100 points of each tool's own, those left out that are nearer than
0.01 to a fold.

{table(("tool", "points", "process", "call", "a point", "stability", "error, median", "largest, at Lambda"), curve_rows(rows))}
{check}

{partial}
pyHarm, jaxcont and SciPy compute no stability. Most of jaxcont's process is import and compilation:
its second curve takes what stands under *call*.
The definitions of the train for these tools are ours (`benchmarks/peers/`), in all five elements: 5 (1 + 2R) unknowns.
The largest errors stand where the curve is nearly vertical: there a small error in Lambda is a large one in rms.
{skipped}
How many times longer than geartrain at R = 6 with multipliers; calls of tools without stability are set beside the call without
it. R = 6 is what the paper and the tools use; in its few worst points it is no more exact than they are, and SciPy's sweep is more
exact throughout. The last column is against geartrain's fastest row whose median and largest error are both below the tool's:

{table(("tool", "process", "call", "process, more exact than the tool"), ratio_rows(rows))}
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

The error here is that of the waveform: the largest deviation of any mesh at any instant from shooting, over the largest
alternating displacement. Time is that of a point of a branch without multipliers; for integration that of settling from the steady
motion of a neighbouring frequency. The error of shooting is its agreement with DOP853 on figure 3, above.

![Error of the waveform over time of a point, five cases](speed/accuracy.png)

![Error of the waveform over number of harmonics, five cases](speed/order.png)

{table(("case", "what", "Lambda", "order by theory", "fitted, R >= 12"), orders)}
Teeth that part make a jump in the third derivative of p, so that |p_k| falls as k^-4 and the largest error as R^-3; a jump of
the stiffness is one in the second derivative, k^-3 and R^-2.

Which method gets a point fastest below an error of the waveform, and its time; *shooting* is harmonic balance at R = 12 and
`refine` together:

{table(("case", *(f"{target:.0e}" for target in TARGETS)), choice)}"""


def above_first(rows):
    """Memory of each size less that of the smallest, which is mostly that of the libraries; none where it is no more."""
    first = rows[0]["memory"][0]
    return [{"size": row["size"], "memory": [row["memory"][0] - first]} for row in rows if row["memory"][0] > 1.02 * first]


def size_rows(rows):
    return [
        (row["size"], *(spread(row[key]) if key in row else "not measured" for key in ("without", "with")))
        for row in rows
    ]  # fmt: skip


def scale_section(found):
    memory = {row["size"]: f"{row['memory'][0] / 2**20:.1f} MiB" for row in found["memory"]}
    shafts = [(*row, memory.get(row[0], "")) for row in size_rows(found["shafts"])]
    slopes = [
        (what, f"{value:.2f}" if value is not None else "")
        for what, value in (
            ("time by shafts, without multipliers", pictures.exponent(found["shafts"], "without")),
            ("time by shafts, with multipliers", pictures.exponent(found["shafts"], "with")),
            ("time by harmonics, without multipliers", pictures.exponent(found["harmonics"], "without")),
            ("memory above that of the smallest train, by shafts", pictures.exponent(above_first(found["memory"]), "memory")),
        )
    ]
    # What was measured before there were trees has none.
    trees = tree_rows(found.get("trees", {"chain": []}))
    missing = " *Not measured*: the size before took too long." if "not measured" in str(shafts) else ""
    return f"""## Size

The time of a point at R = 6 for chains of figure 3's gear pairs, teeth parting at the first of them: a share of a call of at
most {found["points"]} points, which is most of it where the train is small, and with multipliers of locating where motions lose
their stability, which long chains do often. And the peak memory of the executable, libraries included.{missing}

{table(("shafts", "a point, without multipliers", "with", "memory"), shafts)}
A point of trees beside chains, of as many equal pairs each, all loaded alike, contact and stability never lost:

{table(("meshes", "shape", "without multipliers", "over the chain's", "with", "over the chain's"), trees)}
And of figure 3's train for more harmonics:

{table(("R", "a point, without multipliers", "with"), size_rows(found["harmonics"]))}
![Time of a point and memory over size](speed/scale.png)

Exponents, fitted over the upper half of the sizes:

{table(("what", "exponent"), slopes)}"""


def tree_rows(trees):
    """Times of a point, and what they are over the chain's."""
    for at, first in enumerate(trees["chain"]):
        for shape, rows in trees.items():
            cells = []
            for what in ("without", "with"):
                times, chain = (row[at].get(what) for row in (rows, trees["chain"]))
                cells += [spread(times), f"{np.median(times) / np.median(chain):.2f}"] if times and chain else ["not measured", ""]
            yield first["size"], shape, *cells


def cores_section(found):
    rows = [
        (row["what"], spread(row["one"]), spread(row["every"]), f"{np.median(row['one']) / np.median(row['every']):.2f}",
         "yes" if row["same"] else "**no**")
        for row in found["rows"]
    ]  # fmt: skip
    return f"""## Many cases, all cores

One call of the executable, to closed files, on one thread and on {found["cores"]}.

{table(("what", "1 thread", f"{found['cores']} threads", "faster by", "the same bits"), rows)}"""


def study_section(found):
    plain = found["rows"]["plain loop"][1]
    rows = [
        (engine, f"{wall:.0f} s", f"{cpu:.0f} s", f"{cpu / plain - 1:.1%}",
         f"{plain / ((1 if engine == 'plain loop' else found['workers']) * wall):.2f}", f"{memory:.0f} MB")
        for engine, (wall, cpu, memory) in found["rows"].items()
    ]  # fmt: skip
    return f"""## Studies

{found["points"]} responses of figure 3's train, each value of its meshes within 10 % ([studies.md](studies.md)), by
{found["workers"]} processes; each engine in a process of its own. Overhead is processor time, of all processes, above that of a
plain loop; efficiency is the plain loop's time over processes times wall time.

{table(("engine", "wall time", "processor time", "overhead", "efficiency", "client's memory"), rows)}
{found["read"]} points are read back in {found["seconds"]:.1f} s, a Dataset of {found["size"]:.0f} MB."""


def gearboxes_section(found):
    rows = [(row["case"], spread(row["seconds"])) for row in found["rows"]]
    return f"""## Real gearboxes

Whole runs of the executable, processor time. The wind turbine of 750 kW has three stages (120/21, 82/23, 88/22; its common period
is 328 turns of the generator, 7216 cycles of its fastest mesh), the truck two countershafts and four idle meshes that rattle
(`test/python/gearboxes.py`), the reducer two stages (`namelists/reducer.nml`). Beside another commit: `python
benchmarks/real_gearboxes.py EXECUTABLE`.

{table(("case", "processor time"), rows)}"""


def operations():
    """Floating-point operations of a point of figure 3 at R = 6: three solves, the monodromy matrix, its eigenvalues.

    The matrix: 10 columns, in each 5 elements with 8 multiplications and additions a term (three neighbours' springs and dampers,
    two sums), 2.5 terms a radian of the fastest mode (docs/numerics.md); what varies in the stiffness is not counted.
    """
    train = gt.read_case("namelists/fig03.nml").train
    frequency = train.response(start=0.2, stop=2.6, harmonics=6, stability=False).frequency
    radians = train.natural_frequencies()[-1] * 2 * np.pi * float(np.mean(1 / frequency))
    return {"three solves": 3 * (2 / 3 * 27**3 + 2 * 27**2), "monodromy matrix": 10 * 5 * 2 * 8 * 2.5 * radians,
            "its eigenvalues": 25 * 10**3}  # fmt: skip


def floor_section(machine, curve):
    own = next(row for row in curve["rows"] if row["label"] == "geartrain, R = 6")
    lapack = 3 * machine["solve"] + machine["eigenvalues"]
    with_, without = (np.median(own[key]) / own["points"] for key in ("curve", "without"))
    counts = operations()
    solves, all_ = counts["three solves"], sum(counts.values())
    rows = [(what, f"{count / 1e3:.0f}", duration([count / machine["flops"]])) for what, count in counts.items()]
    measured = [
        ("a point without multipliers", duration([without]), f"{without / (solves / machine['flops']):.0f} x",
         f"{without / (3 * machine['solve']):.1f} x"),
        ("a point with multipliers", duration([with_]), f"{with_ / (all_ / machine['flops']):.0f} x", f"{with_ / lapack:.1f} x"),
    ]  # fmt: skip
    return f"""## How far from what the machine could do

A point of figure 3 at R = 6 takes about three Newton steps, each a solve for 27 unknowns, and the monodromy matrix of 10 states.
Large matrices are multiplied at {machine["flops"] / 1e9:.0f} GFLOP/s on this core; at that rate, which nothing so small can
reach, the operations take:

{table(("what", "1000 operations", "at the rate of large matrices"), rows)}
LAPACK, called from Python, takes {duration([machine["solve"]])} for one such solve (dgesv) and
{duration([machine["eigenvalues"]])} for the eigenvalues (dgeev). What geartrain takes, over the operations' time and over
LAPACK's (of the solves, and of the eigenvalues where there are any; the matrices' making not counted):

{table(("what", "measured", "over the operations", "over LAPACK"), measured)}"""


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
        floor_section(found["machine"], found["curve"]),
    )  # fmt: skip
    intro = f"""# Speed against error

Written by `benchmarks/run`, which installs the peers that packages provide, measures everything below on the machine at hand and
draws the pictures. Measured: {measured}.

"""
    Path(path).write_text(intro + "\n".join(sections), encoding="utf-8")
