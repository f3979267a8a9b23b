"""Measures on this machine and writes docs/speed.md with its pictures; benchmarks/run prepares all that this needs.

Each part is a module with `measure(quick, executable, say)`, and a section of the report; its rows are kept in build/benchmarks.
"""

import argparse
import json
import time
import warnings
from contextlib import nullcontext
from pathlib import Path

import numpy as np

import accuracy
import cores
import curve
import geartrain as gt
import locus
import machine
import real_gearboxes
import report
import scale
import study
from timing import one_core

PARTS = {"machine": machine, "curve": curve, "accuracy": accuracy, "scale": scale, "cores": cores, "study": study, "locus": locus,
         "gearboxes": real_gearboxes}
KEPT = Path("build/benchmarks")
EXECUTABLE = Path("build/release/geartrain")


def plain(value):
    """What json does not know of NumPy."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="fewer rows and repeats")
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], help="those to measure; all of them unless told")
    options = parser.parse_args()
    # Long chains of equal pairs have little damping in their lowest modes, which is no matter here.
    warnings.simplefilter("ignore", gt.DrawingWarning)
    KEPT.mkdir(parents=True, exist_ok=True)
    unknown = [name for name in PARTS if options.parts and name not in options.parts and not (KEPT / f"{name}.json").exists()]
    if unknown:
        parser.error(f"nothing is kept of {', '.join(unknown)}: measure all parts first")
    begun = time.perf_counter()

    def say(text):
        print(f"{time.perf_counter() - begun:6.0f} s  {text}", flush=True)

    for name in options.parts or PARTS:
        with nullcontext() if name in ("cores", "study") else one_core():
            found = PARTS[name].measure(options.quick, EXECUTABLE, say)
        found["measured"] = time.strftime("%Y-%m-%d %H:%M") + (", quick" if options.quick else "")
        (KEPT / f"{name}.json").write_text(json.dumps(found, default=plain), encoding="utf-8")
    found = {name: json.loads((KEPT / f"{name}.json").read_text(encoding="utf-8")) for name in PARTS}
    report.write(found, Path("docs/speed.md"))
    say("Written: docs/speed.md")


if __name__ == "__main__":
    main()
