"""Error against the time of a point: harmonic balance sampled, exact and adaptive, shooting and time integration."""

import numpy as np

import geartrain as gt
from cases import cases, nearest, reference
from timing import timed

INSTANTS = 8192  # at which waveforms are compared
POINTS = 12  # of a branch over which the time of a point is taken
SAMPLES = (64, 256, 1024, 4096)
STARTED = 12  # harmonics of the motion that shooting begins with (`Case.find`)
SHOOTING_ERROR = 1e-11  # how far it agrees with SciPy's DOP853 (see curve.py, where this is measured)
FLOOR = 1e-11  # below it an error tells of rounding, not of an order


def waveform_error(motion, exact):
    """Largest deviation of any mesh over the period, over the largest alternating displacement."""
    _, found = motion.waveform(INSTANTS)
    _, truth = exact.waveform(INSTANTS)
    return float(np.abs(found - truth).max() / np.abs(truth - exact.mean).max())


def measure_balance(case, seed, exact, repeats, setting, **settings):
    """Time of a point and errors, by continuation without multipliers; None where the branch does not start."""
    settings = {"start": case.frequency, "stop": case.stop, "seed": seed, "stability": False, "max_points": POINTS, **settings}
    try:
        seconds, branch = timed(lambda: case.train.response(**settings), repeats, patience=0.5)
        motion = nearest(branch.at(case.frequency), exact.rms)
    except gt.SolverError:
        return None
    return {
        "setting": setting, "seconds": [value / len(branch) for value in seconds], "error": waveform_error(motion, exact),
        "rms_error": float(np.abs(motion.rms / exact.rms - 1).max()), "harmonics": (motion.coefficients.shape[1] - 1) // 2,
    }  # fmt: skip


def measure_integration(case, before, exact, repeats, tolerance):
    """Time from the steady motion of a neighbouring frequency to the steady motion of this one, as in a sweep."""
    settings = {"frequency": case.frequency, "start": before, "tolerance": tolerance, "stability": False}
    seconds, _ = timed(lambda: case.train.integrate(**settings), repeats, patience=0.5)
    motion = case.train.integrate(**settings, harmonics=500)
    if motion.period != exact.period:
        return None
    return {
        "setting": f"tolerance {tolerance:.0e}", "seconds": seconds, "error": waveform_error(motion, exact),
        "rms_error": float(np.abs(motion.rms / exact.rms - 1).max()),
    }  # fmt: skip


def fitted_order(rows):
    """Slope of log error over log R where the error is neither rounding nor that of a handful of harmonics."""
    fit = [(row["harmonics"], row["error"]) for row in rows if row["harmonics"] >= 12 and row["error"] > FLOOR]
    if len(fit) < 3:
        return None
    return float(-np.polyfit(*np.log(np.array(fit).T), 1)[0])


def measure(quick, executable, say):
    """For every case and method the rows of its line in the picture."""
    harmonics = (3, 6, 12, 24, 48) if quick else (3, 6, 12, 24, 48, 96, 192)
    tolerances = (1e-3, 1e-5) if quick else (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
    settled = (1e-3, 1e-6) if quick else (1e-3, 1e-6, 1e-9)
    repeats = 2 if quick else 7
    found = []
    for case in cases():
        say(f"accuracy: {case.name}")
        seed, before = case.find()
        exact = reference(seed)

        def balance(setting, case=case, seed=seed, exact=exact, **settings):
            return measure_balance(case, seed, exact, repeats, setting, **settings)

        lines = {"exact": [balance(f"R = {count}", harmonics=count) for count in harmonics]}
        for samples in SAMPLES:
            lines[f"sampled, Q = {samples}"] = [
                balance(f"R = {count}", harmonics=count, coefficients="sampled", samples=samples)
                for count in harmonics
                if 6 * count + 2 <= samples  # fewer samples geartrain refuses
            ]
        lines["adaptive"] = [balance(f"tolerance {value:.0e}", harmonics=0, tolerance=value) for value in tolerances]
        lines["integration"] = [measure_integration(case, before, exact, repeats, value) for value in settled]
        refining, _ = timed(seed.refine, repeats, patience=0.5)
        balanced = next(np.median(row["seconds"]) for row in lines["exact"] if row and row["harmonics"] == STARTED)
        lines["shooting"] = [{
            "setting": f"from R = {STARTED}", "error": SHOOTING_ERROR, "rms_error": SHOOTING_ERROR,
            "seconds": [balanced + value for value in refining],
        }]  # fmt: skip
        found.append({
            "name": case.name, "what": case.what, "frequency": case.frequency, "rms": exact.rms, "order": case.order,
            "lines": {name: [row for row in rows if row] for name, rows in lines.items()},
            "fitted": fitted_order([row for row in lines["exact"] if row]),
        })  # fmt: skip
    return {"cases": found}
