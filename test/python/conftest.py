"""The paper's train and the executable."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a threaded BLAS only gets in the way of threads, see docs/python.md

import geartrain as gt

ROOT = Path(__file__).resolve().parents[2]


def paper_train(half_backlash=30e-6, **changes):
    shafts = [gt.Shaft(stiffness=stiffness, damping_ratio=0.01) for stiffness in (1e3, 1e8, 1e3)]
    meshes = [
        gt.Mesh(driving_radius=0.05, driven_radius=0.10, driving_inertia=driving, driven_inertia=driven,
                stiffness=stiffness, damping_ratio=0.05, half_backlash=half_backlash, stiffness_cos=[0.3])
        for driving, driven, stiffness in ((0.0023, 0.037, 2.5e8), (0.0046, 0.074, 5e8))
    ]
    values = {
        "input_torque": 150.0, "prime_mover_inertia": 2.3e-7, "load_inertia": 2.3e-7,
        "characteristic_length": 30e-6, "characteristic_frequency": 9870.0, "shafts": shafts, "meshes": meshes,
    }
    return gt.Train(**{**values, **changes})


@pytest.fixture(scope="session")
def train():
    return paper_train()


@pytest.fixture(scope="session")
def branch(train):
    return train.response(start=0.2, stop=2.6)


@pytest.fixture(scope="session")
def executable():
    """The release executable, built where fpm is at hand."""
    path = ROOT / "build" / "release" / "bin" / "geartrain"
    if shutil.which("fpm"):
        command = ["fpm", "install", "--profile", "release", "--prefix", "build/release"]
        subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    if not path.exists():
        pytest.skip("no executable and no fpm to build it")
    return path
