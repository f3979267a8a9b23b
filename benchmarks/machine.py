"""The machine: what it is, and how fast it does the linear algebra that no code can do without."""

import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.linalg.lapack import dgeev, dgesv

import geartrain as gt
from timing import timed


def first_line(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[0]
    except (OSError, subprocess.CalledProcessError, IndexError):
        return "unknown"


def processor():
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines() if Path("/proc/cpuinfo").exists() else []:
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


def repeated(call, times):
    """Median seconds of one of many calls in a row."""
    seconds, _ = timed(lambda: [call() for _ in range(times)], 9)
    return float(np.median(seconds)) / times


def measure(quick, executable, say):
    """What the machine is, and seconds of LAPACK's work for a point of figure 3 at R = 6."""
    random = np.random.default_rng(0)
    unknowns = 2 * 13 + 1  # mean and 6 harmonics of two meshes, and Lambda
    matrix, right = random.standard_normal((unknowns, unknowns)) + 9 * np.eye(unknowns), np.ones(unknowns)
    states = random.standard_normal((10, 10))
    large = random.standard_normal((600, 600))
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "load": os.getloadavg()[0],
        "versions": {
            "geartrain": gt.__version__,
            "commit": first_line("git", "describe", "--always", "--dirty"),
            "compiler": first_line("gfortran", "--version"),
            "Python": platform.python_version(),
            "NumPy": np.__version__,
            "SciPy": version("scipy"),
        },
        "solve": repeated(lambda: dgesv(matrix, right), 2000),
        "eigenvalues": repeated(lambda: dgeev(states, compute_vl=0, compute_vr=0), 2000),
        "flops": 2 * 600**3 / repeated(lambda: large @ large, 20),
    }
