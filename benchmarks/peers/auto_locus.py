"""AUTO-07p: the curve of a fold over Lambda and the stiffness variation, from auto_train.f90 or auto_pair.f90.

The mesh stiffness grows from 0 to 0.3 at Lambda = 2.6, Lambda falls until the second fold, and from the first one the fold is
followed both ways. Where the backlash is exact the derivatives of collocation jump as a collocation point passes a corner of it;
the corners are rounded over `width`.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

SCRIPT = """
import resource
settings = dict(e='{equations}', NDIM={dimension}, IPS=2, ILP=1, ISP=2, ISW=1, NTST={intervals}, NCOL=4, IAD=3, JAC=1, NMX=2000,
                NPR=0, IID=0, ITMX=12, ITNW=5, NWTN=3, EPSL=1e-7, EPSU=1e-7, EPSS={located}, DSMIN=1e-6, DSMAX=0.05, IADS=1,
                NPAR=12, THL={{11: 0}})

def used():
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return children.ru_utime + children.ru_stime

start = run(ICP=[2, 11], UZSTOP={{2: 0.3}}, DS=0.01, PAR={{5: {width}}}, **settings)
curve = run(start('UZ1'), ICP=[1, 11], UZSTOP={{1: [{lowest}, 2.61]}}, DS=-0.01, **settings)
settings.update(ISW=2, ICP=[1, 2, 11], UZSTOP={{2: [0.05, 0.5]}}, ILP=0, ISP=0)
data = run(curve('LP1'), DS=0.01, **settings)
with open('seconds', 'w') as file:
    for name, step in (('one', 0.01), ('other', -0.01)):
        before = used()
        save(run(data, DS=step, **settings), name)
        print(used() - before, file=file)
"""


def locus(equations, dimension, lowest, width, intervals):
    """CPU seconds of the curve, its (Lambda, parameter), (points, 2), and whether both sides got to an end of the range."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(Path(__file__).with_name(f"{equations}.f90"), folder)
        (folder / "script.auto").write_text(SCRIPT.format(
            equations=equations, dimension=dimension, lowest=lowest, width=width, intervals=intervals,
            located=1e-5 if width > 0 else 1e-2))  # fmt: skip
        subprocess.run(["auto-07p", "script.auto"], cwd=folder, check=True, capture_output=True, stdin=subprocess.DEVNULL)
        seconds = sum(map(float, (folder / "seconds").read_text().split()))
        points, ended = [], True
        for side in ("b.one", "b.other"):
            lines = (folder / side).read_text().splitlines()
            # BR, PT, TY, LAB, Lambda, norm, maxima, then the other parameters: the first of them the stiffness variation.
            names = next(line for line in reversed(lines) if "PAR(1)" in line)
            place = names.replace("MAX U", "MAX_U").split().index("PAR(2)")
            rows = [line.split() for line in lines if line.split()[0] != "0"]
            points += [(float(row[4]), float(row[place])) for row in rows]
            ended = ended and rows[-1][2] == "-54"
    return seconds, np.array(points), ended
