"""Figure 3's train for the Python peers, assembled from Table 1 by I theta'' + B^T F = T and p = B theta.

Displacements p of the five elastic elements (shaft, mesh, shaft, mesh, shaft) over b_c, time times omega_c, forces over k b_c:
   MASS p'' + DAMPING p' + elastic(p, t) = LOAD,   elastic = p in a shaft, (1 + 0.3 cos Lambda t) g(p) in a mesh.
Every peer reports through `report`, so that all are timed and judged alike.
"""

import argparse
import json
import time

import numpy as np

OMEGA_C, LENGTH, TORQUE, KAPPA = 9870.0, 30e-6, 150.0, 0.3
START, STOP = 0.2, 2.6
MESHES = np.array([1, 3])

_inertia = np.array([2.3e-7, 0.0023, 0.037, 0.0046, 0.074, 2.3e-7])  # kg m^2
_left = np.array([0.05, 0.05, 0.05, 0.05, 0.1])  # radii at an element's two inertias; a shaft's twist is measured
_right = np.array([0.05, 0.1, 0.05, 0.1, 0.1])  # along the base circle of a gear on it
_stiffness = np.array([1e3 / 0.05**2, 2.5e8, 1e8 / 0.05**2, 5e8, 1e3 / 0.1**2])  # N/m
_ratio = np.array([0.01, 0.05, 0.01, 0.05, 0.01])

_b = np.zeros((5, 6))
for _n in range(5):
    _b[_n, _n : _n + 2] = _left[_n], -_right[_n]
_static = np.array([TORQUE, TORQUE, 2 * TORQUE, 2 * TORQUE, 4 * TORQUE]) / _left  # N; the output torque balances it
_damping = 2 * _ratio * np.sqrt(_stiffness / (_b**2 @ (1 / _inertia)))
FLEXIBILITY = (_b / _inertia) @ _b.T * _stiffness / OMEGA_C**2  # p'' = -FLEXIBILITY (elastic + DAMPING p' - LOAD)
MASS = np.linalg.inv(FLEXIBILITY)
DAMPING = _damping * OMEGA_C / _stiffness
LOAD = _static / (_stiffness * LENGTH)
REST = LOAD + np.isin(np.arange(5), MESHES)


def rms(harmonics):
    """The paper's rms of both meshes; harmonics (points, 1 + 2R, 5): mean, cos 1, sin 1, ... of every element."""
    return np.sqrt((np.asarray(harmonics)[:, 1:, MESHES] ** 2).sum(axis=1))


def arguments(**defaults):
    """Command line of a peer: --repeats, --output and what the peer has of its own, all numbers."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--output", required=True)
    parser.add_argument("--repeats", type=int, default=0)
    for name, value in defaults.items():
        parser.add_argument(f"--{name}", type=type(value), default=value)
    return parser.parse_args()


def repeated(call, repeats):
    """Wall seconds of the first call, which compiles what the tool compiles, and of each repeat; the last result."""
    seconds = []
    for _ in range(1 + repeats):
        begun = time.perf_counter()
        result = call()
        seconds.append(time.perf_counter() - begun)
    return seconds[0], seconds[1:], result


def report(path, **fields):
    """Write what a peer found: tool, first, seconds, frequency (points,), rms (points, 2), stable (points,) or None."""
    with open(path, "w", encoding="utf-8") as file:
        json.dump(fields, file, default=np.ndarray.tolist)
