"""The machine and the versions of what is measured on it."""

import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

import numpy as np

import geartrain as gt


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


def measure(quick, executable, say):
    """What the machine is, and the versions of what is measured on it."""
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
    }
