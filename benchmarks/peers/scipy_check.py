"""SciPy's opinion on orbits that geartrain's shooting found: one period by DOP853 at rtol 1e-12 from each orbit's own state.

Reads --orbits, a JSON list of {frequency, state}; state as geartrain gives it (`Motion.state`).
"""

import json

import numpy as np

from figure3 import LOAD, MESHES, arguments, report
from scipy_sweep import integrate, measured_rms

# geartrain counts a shaft's displacement from its static twist.
OFFSET = np.where(np.isin(np.arange(10), MESHES), 0, np.append(LOAD, np.zeros(5)))


def main():
    options = arguments(orbits="")
    found, closure = [], []
    with open(options.orbits, encoding="utf-8") as file:
        orbits = json.load(file)
    for orbit in orbits:
        times = np.arange(4096) / 4096
        run = integrate(orbit["frequency"], orbit["state"] + OFFSET, 0, 1, 1e-12, np.append(times, 1))
        found.append(measured_rms(run.y[:, :-1]))
        closure.append(np.abs(run.y[:, -1] - run.y[:, 0]).max())
    report(options.output, rms=found, closure=closure)


if __name__ == "__main__":
    main()
