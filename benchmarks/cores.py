"""Many cases and the rows of a map on one thread and on all cores: times, and whether the bits are the same."""

import hashlib
import os
import tempfile
from pathlib import Path

import h5py

from paper_cases import case_texts
from timing import run, timed

CURVES = ("fig03", "fig04_k3_5e5", "fig06_050", "fig06_100", "fig07_042", "fig08_rectangular", "fig09_003", "fig10", "fig11")


def content(folder):
    """A digest of all datasets in the HDF5 files of a folder."""
    digest = hashlib.sha256()

    def add(name, item):
        digest.update(name.encode())
        if isinstance(item, h5py.Dataset):
            digest.update(repr(item[()]).encode() if item.dtype.hasobject else item[()].tobytes())

    for path in sorted(Path(folder).glob("*.h5")):
        with h5py.File(path) as file:
            file.visititems(add)
    return digest.hexdigest()


def on_threads(executable, cases, threads):
    """Wall seconds of one call with all the cases on so many threads, and the digest of what it wrote."""
    with tempfile.TemporaryDirectory() as folder:
        for case in cases:
            text = case_texts().get(case) or Path(f"namelists/{case}.nml").read_text(encoding="utf-8")
            (Path(folder) / f"{case}.nml").write_text(text, encoding="utf-8")
        command = [executable.resolve(), *(f"{case}.nml" for case in cases)]
        environment = {**os.environ, "OMP_NUM_THREADS": str(threads)}
        seconds, _ = timed(lambda: run(command, cwd=folder, env=environment), 3, patience=30)
        return seconds, content(folder)


def measure(quick, executable, say):
    """Rows: what was computed, seconds on one thread and on all cores, same bits or not."""
    cores = os.cpu_count()
    works = [(f"{len(CURVES)} figures: curves and integration", CURVES),
             ("stability map 200 x 200, linear train", ("map_linear",)),
             ("stability map 200 x 200, nonlinear train", ("map_nonlinear",))]  # fmt: skip
    rows = []
    for what, cases in works[1:2] if quick else works:
        say(f"{what}, 1 and {cores} threads")
        one, first = on_threads(executable, cases, 1)
        every, second = on_threads(executable, cases, cores)
        rows.append({"what": what, "one": one, "every": every, "same": first == second})
    return {"rows": rows, "cores": cores}
