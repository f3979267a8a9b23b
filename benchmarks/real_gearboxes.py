"""Real gearboxes: ``python benchmarks/real_gearboxes.py [OTHER]``, with OTHER the executable of another commit.

Reports the processor time of whole runs of the executable on one core: the least of three runs, alternated with the other one.
A run stops after ten minutes. The trains are in ``test/python/gearboxes.py`` and ``namelists/reducer.nml``.
"""

from __future__ import annotations

import os
import re
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "test" / "python"))

from gearboxes import PLANETARY_TURBINE, REFERENCE_TURBINE, TRANSAXLE, TRUCK, WIND_TURBINE  # noqa: E402

PATIENCE, REPEATS = 600, 3
#: Exit status of a run that ended early and has written what it found.
ENDED_EARLY = 3
OWN = ROOT / "build" / "release" / "geartrain"
REDUCER = re.sub(r"(?ms)^&(modes|response|integration|run_up).*?/$", "", (ROOT / "namelists/reducer.nml").read_text("utf-8"))
TURBINE = WIND_TURBINE.format(torque="322.0e3")
CASES = {
    "wind turbine, response from 1100 to 1900 rpm, tolerance 1e-3, with verdicts":
        TURBINE + "&response from = 1100.0, to = 1900.0, unit = 'rpm', harmonics = 0, tolerance = 1e-3 /\n",
    "wind turbine, run-up from 1100 to 1900 rpm in 20 s":
        TURBINE + "&run_up from = 1100.0, to = 1900.0, unit = 'rpm', duration = 20.0 /\n",
    "two-stage reducer, response from 200 to 4000 rpm, tolerance 1e-3, with verdicts":
        REDUCER + "&response from = 200.0, to = 4000.0, unit = 'rpm', harmonics = 0, tolerance = 1e-3 /\n",
    "truck with idle gears, integration at three speeds":
        TRUCK + "&integration from = 800.0, to = 1600.0, points = 3, unit = 'rpm' /\n",
    "wind turbine with its planetary stage, response from 1100 to 1900 rpm, tolerance 1e-3, with verdicts":
        PLANETARY_TURBINE + "&response from = 1100.0, to = 1900.0, unit = 'rpm', harmonics = 0, tolerance = 1e-3 /\n",
    "NREL 5 MW reference gearbox, response from 900 to 1100 rpm, tolerance 1e-3, with verdicts":
        REFERENCE_TURBINE + "&response from = 900.0, to = 1100.0, unit = 'rpm', harmonics = 0, tolerance = 1e-3 /\n",
    "transaxle in reverse, response from 700 to 5500 rpm, tolerance 1e-3, with verdicts":
        TRANSAXLE + "&response from = 700.0, to = 5500.0, unit = 'rpm', harmonics = 0, tolerance = 1e-3 /\n",
}


def run(executable: Path, text: str) -> tuple[float, bool]:
    """Processor time of a run [s], infinite where it takes more than `PATIENCE`, and whether the response is complete."""
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "case.nml"
        case.write_text(text + f"&output file = '{folder}/case.h5' /\n", encoding="utf-8")
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        try:
            done = subprocess.run([executable, case], check=False, timeout=PATIENCE, capture_output=True,
                                  env={**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"})
        except subprocess.TimeoutExpired:
            return float("inf"), False
        if done.returncode not in (0, ENDED_EARLY):
            done.check_returncode()
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, done.returncode == 0


def measure(quick: bool, executable: Path, say: Callable[[str], None]) -> dict[str, list[dict[str, Any]]]:
    """A row for each case."""
    rows = []
    for name, text in CASES.items():
        say(name)
        runs = [run(Path(executable).resolve(), text) for _ in range(1 if quick else REPEATS)]
        rows.append({"case": name, "seconds": [seconds for seconds, _ in runs], "complete": all(complete for _, complete in runs)})
    return {"rows": rows}


def main() -> None:
    """Print a row for each case."""
    executables = [OWN, *map(Path, sys.argv[1:])]
    for name, text in CASES.items():
        least = [float("inf")] * len(executables)
        for repeat in range(REPEATS):
            for place, executable in enumerate(executables):
                if repeat == 0 or least[place] < PATIENCE:
                    least[place] = min(least[place], run(executable, text)[0])
        told = [f"{value:.2f} s" if value < PATIENCE else f"more than {PATIENCE} s" for value in least]
        print(f"{name}: {', '.join(told)}", flush=True)


if __name__ == "__main__":
    main()
