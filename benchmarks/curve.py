"""Figure 3's whole curve, 0.2 to 2.6, by geartrain and by every peer that is installed, in one run."""

import json
import tempfile
from pathlib import Path

import h5py
import numpy as np

import geartrain as gt
from cases import nearest
from timing import run, timed

START, STOP = 0.2, 2.6
PEERS = Path(__file__).parent / "peers"
PEER_PYTHON = Path(".venv-peers/bin/python")
NEAR_FOLD = 0.01  # points nearer in Lambda are not judged: at a fold the error at constant Lambda is unbounded
JUDGED = 100  # points of each curve
ELSEWHERE = 0.3  # relative distance in rms beyond which a settled motion is another one, not a wrong one


def geartrain_runs(quick):
    """Label and &response of every geartrain row."""
    fixed = (6,) if quick else (3, 6, 12, 24, 48)
    tolerances = (1e-5,) if quick else (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    for harmonics in fixed:
        yield f"geartrain, R = {harmonics}", {"harmonics": harmonics}
    for tolerance in tolerances:
        yield f"geartrain, tolerance {tolerance:.0e}", {"harmonics": 0, "tolerance": tolerance}


def peer_runs(quick):
    """Label, script, its options, and the repeats of a full run; what only a full run has comes later."""
    yield "pyHarm, R = 6", "pyharm", {"harmonics": 6, "samples": 128}, 5
    yield "jaxcont, R = 6", "jaxcont", {"harmonics": 6, "samples": 128}, 9
    yield "AUTO-07p, 100 intervals", "auto", {"intervals": 100}, 0
    yield "SciPy sweep, rtol 1e-8", "scipy", {"every": 40 if quick else 20, "rtol": 1e-8}, 0
    if quick:
        return
    for harmonics, samples in ((12, 256), (24, 512)):
        yield f"pyHarm, R = {harmonics}", "pyharm", {"harmonics": harmonics, "samples": samples}, 0
        yield f"jaxcont, R = {harmonics}", "jaxcont", {"harmonics": harmonics, "samples": samples}, 3
    yield "AUTO-07p, 40 intervals", "auto", {"intervals": 40}, 0
    yield "AUTO-07p, 200 intervals", "auto", {"intervals": 200}, 0
    yield "SciPy sweep, rtol 1e-5", "scipy", {"every": 40, "rtol": 1e-5}, 0


SCRIPTS = {
    "pyharm": "pyharm_curve.py", "jaxcont": "jaxcont_curve.py", "auto": "auto_curve.py", "scipy": "scipy_sweep.py",
    "check": "scipy_check.py",
}  # fmt: skip


class Reference:
    """Figure 3 by shooting, wherever it is asked for."""

    def __init__(self, train):
        self.branch = train.response(start=START, stop=STOP, harmonics=24)
        self.folds = [special.frequency for special in self.branch.special_points if special.kind == "fold"]
        doublings = sorted(special.frequency for special in self.branch.special_points if special.kind == "period doubling")
        self.doubled = doublings[0], doublings[-1]

    def errors(self, frequency, rms, stable_only):
        """Relative error of rms, the larger of both meshes, at points taken evenly from a curve: median and largest."""
        fair = [
            point
            for point, value in enumerate(frequency)
            if START <= value <= STOP and min(abs(value - fold) for fold in self.folds) > NEAR_FOLD
            and not (stable_only and self.doubled[0] < value < self.doubled[1])
        ]  # fmt: skip
        chosen = [fair[place] for place in np.unique(np.linspace(0, len(fair) - 1, JUDGED).astype(int))]
        found = []
        for point in chosen:
            exact = nearest(self.branch.at(float(frequency[point])), rms[point]).refine()
            found.append((np.abs(rms[point] / exact.rms - 1).max(), frequency[point]))
        # A sweep may settle on a motion that is no part of the curve (an island): that is no error of it.
        judged = [entry for entry in found if not (stable_only and entry[0] > ELSEWHERE)]
        largest, at = max(judged)
        middle = np.median([error for error, _ in judged])
        return {"median": middle, "largest": largest, "largest_at": at, "elsewhere": len(found) - len(judged)}

    def orbits(self):
        return [motion.refine() for value in (0.4, 0.7, 0.9, 1.6) for motion in self.branch.at(value)]


def run_peer(script, options, folder):
    """Wall seconds of the process, and what it reports."""
    output = folder / "peer.json"
    command = [PEER_PYTHON, PEERS / SCRIPTS[script], "--output", output]
    for name, value in options.items():
        command += [f"--{name}", value]
    seconds = run(command)
    return seconds, json.loads(output.read_text(encoding="utf-8"))


def run_geartrain(executable, train, settings, repeats, folder):
    """One row: the executable from start to closed file, with multipliers; and the library's call alone."""
    case, output = folder / "case.nml", folder / "case.h5"
    settings = {"start": START, "stop": STOP, **settings}
    case.write_text(train.namelist(response=settings), encoding="utf-8")
    process, _ = timed(lambda: run([executable, case, "--output", output]), repeats, patience=4)
    with h5py.File(output) as file:
        frequency, rms = file["response/frequency"][:], file["response/rms"][:]
    row = {"process": process, "frequency": frequency, "rms": rms, "stability": True, "points": len(frequency)}
    row["curve"], _ = timed(lambda: train.response(**settings), repeats, patience=2)
    return row


def measure(quick, executable, say):
    """Rows of the table, those that could not be run with their reason, and how well the reference itself agrees with SciPy."""
    train = gt.read_case("namelists/fig03.nml").train
    reference = Reference(train)
    rows, skipped = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for label, settings in geartrain_runs(quick):
            say(label)
            row = run_geartrain(executable, train, settings, 3 if quick else 11, folder)
            rows.append({"label": label, "tool": "geartrain", "adaptive": "tolerance" in settings, "swept": False, **row})
        for label, script, options, repeats in peer_runs(quick):
            say(label)
            try:
                processes = [run_peer(script, options, folder)]
                # The whole process again where it is short, then many curves in one warm process.
                processes += [run_peer(script, options, folder) for _ in range(0 if quick or not repeats else 2)]
                found = processes[-1][1]
                if repeats:
                    _, found = run_peer(script, {**options, "repeats": 2 if quick else repeats}, folder)
            except (RuntimeError, OSError) as error:
                skipped.append({"label": label, "reason": str(error)})
                continue
            swept = "run" in found  # only a part of the sweep, its time scaled to the whole
            rows.append({
                "label": label, "tool": found["tool"], "swept": swept, "stability": found["stable"] is not None,
                "process": found["seconds"] if swept else [seconds for seconds, _ in processes], "curve": found["seconds"],
                "points": found["of"] if swept else len(found["frequency"]), "run": len(found["frequency"]),
                "frequency": found["frequency"], "rms": found["rms"],
            })  # fmt: skip
        say("errors of all curves")
        for row in rows:
            row["errors"] = reference.errors(np.array(row["frequency"]), np.array(row["rms"]), row["swept"])
            del row["frequency"], row["rms"]
        orbits = reference.orbits()
        (folder / "orbits.json").write_text(json.dumps(
            [{"frequency": orbit.frequency, "state": orbit.state.tolist()} for orbit in orbits]), encoding="utf-8")  # fmt: skip
        check = None
        try:
            _, found = run_peer("check", {"orbits": folder / "orbits.json"}, folder)
            deviations = [np.abs(np.array(rms) / orbit.rms - 1).max() for rms, orbit in zip(found["rms"], orbits, strict=True)]
            check = {"orbits": len(orbits), "rms": max(deviations), "closure": max(found["closure"])}
        except (RuntimeError, OSError) as error:
            skipped.append({"label": "SciPy's check of the reference", "reason": str(error)})
    return {"rows": rows, "skipped": skipped, "check": check}
