"""AUTO-07p: figure 3 by collocation, with Floquet multipliers, from auto_train.f90; exact backlash.

The mesh stiffness grows from 0 to 0.3 at Lambda = 2.6, then Lambda falls to 0.2 (from 0.2 upwards AUTO turns back at the first
contact loss).
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from figure3 import KAPPA, START, STOP, arguments, repeated, report

SCRIPT = """
settings = dict(e='auto_train', NDIM=12, IPS=2, ILP=1, ISP=2, ISW=1, NTST={intervals}, NCOL=4, IAD=3, JAC=1, NMX=9000, NPR=0, IID=0,
                ITMX=9, ITNW=5, NWTN=3, EPSL=1e-7, EPSU=1e-7, EPSS=1e-5, DSMIN=1e-6, DSMAX={step}, IADS=1, NPAR=12, THL={{11: 0}})
start = run(ICP=[2, 11, 3, 4], UZSTOP={{2: {kappa}}}, DS=0.01, **settings)
save(run(start('UZ1'), ICP=[1, 11, 3, 4], UZSTOP={{1: [{low}, {high}]}}, DS=-0.01, **settings), 'curve')
"""


def curve(options):
    """Rows of the curve: point number (negative where stable), Lambda, ..., rms of both meshes."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(Path(__file__).with_name("auto_train.f90"), folder)
        (folder / "script.auto").write_text(SCRIPT.format(
            intervals=options.intervals, step=options.step, kappa=KAPPA, low=START, high=STOP + 0.01))  # fmt: skip
        subprocess.run(["auto-07p", "script.auto"], cwd=folder, check=True, capture_output=True, stdin=subprocess.DEVNULL)
        rows = [line.split() for line in (folder / "b.curve").read_text().splitlines() if line.split()[0] != "0"]
    # BR, PT, TY, LAB, then Lambda, norm, ..., rms 1, rms 2
    return np.array([[float(row[column]) for column in (1, 4, -2, -1)] for row in rows])


def version():
    said = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", "auto-07p"], capture_output=True, text=True, check=False)
    return said.stdout.split("+")[0]


def main():
    options = arguments(intervals=100, step=0.05)
    first, seconds, rows = repeated(lambda: curve(options), options.repeats)
    report(
        options.output, tool=f"AUTO-07p {version()}", first=first, seconds=[first, *seconds], frequency=rows[:, 1],
        rms=rows[:, 2:], stable=(rows[:, 0] < 0).tolist(),
    )  # fmt: skip


if __name__ == "__main__":
    main()
