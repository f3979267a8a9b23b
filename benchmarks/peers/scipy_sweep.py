"""SciPy: figure 3 by solve_ivp, up and down over frequency, each from where the one before arrived.

200 mesh periods are run through at every frequency before two are measured. With --every n only every n-th frequency is run, and
the time is scaled by n: each costs the same number of mesh periods.
"""

import numpy as np
import scipy
from scipy.integrate import solve_ivp

from figure3 import DAMPING, FLEXIBILITY, KAPPA, LOAD, MESHES, REST, START, STOP, arguments, repeated, report

try:
    from numba import __version__ as numba_version
    from numba import njit
except ImportError:
    numba_version, njit = None, lambda call: call

FREQUENCIES = 200
SETTLING, MEASURED = 200, 2  # mesh periods


@njit
def rates(t, x, frequency, flexibility, damping, load):
    """First-order form, x = p(5), p'(5)."""
    kappa = 1 + KAPPA * np.cos(frequency * t)
    force = damping * x[5:] - load
    for n in range(5):
        p = x[n]
        force[n] += p if n % 2 == 0 else kappa * (p - min(max(p, -1.0), 1.0))
    result = np.empty(10)
    result[:5] = x[5:]
    result[5:] = -(flexibility @ force)
    return result


def integrate(frequency, state, begin, end, rtol, times=None):
    """solve_ivp between two numbers of mesh periods."""
    period = 2 * np.pi / frequency
    return solve_ivp(
        rates, (begin * period, end * period), state, method="DOP853", rtol=rtol, atol=rtol * 1e-2,
        t_eval=None if times is None else times * period, args=(frequency, FLEXIBILITY, DAMPING, LOAD),
    )  # fmt: skip


def measured_rms(samples):
    """The paper's rms of both meshes from even samples of whole periods, (10, samples)."""
    return np.sqrt(2) * samples[MESHES].std(axis=1)


def main():
    options = arguments(every=1, rtol=1e-8)
    up = np.linspace(START, STOP, FREQUENCIES)[:: options.every]
    visited = np.concatenate([up, up[::-1]])
    integrate(1.0, np.concatenate([REST, np.zeros(5)]), 0, 1, 1e-3)  # compiles

    def sweep():
        state = np.concatenate([REST, np.zeros(5)])
        found = []
        for frequency in visited:
            state = integrate(frequency, state, 0, SETTLING, options.rtol).y[:, -1]
            times = SETTLING + MEASURED * np.arange(1024) / 1024
            run = integrate(frequency, state, SETTLING, SETTLING + MEASURED, options.rtol, times)
            state = run.y[:, -1]
            found.append(measured_rms(run.y))
        return found

    seconds, _, found = repeated(sweep, 0)
    report(
        options.output, tool=f"SciPy {scipy.__version__} DOP853" + (f", numba {numba_version}" if numba_version else ""),
        first=seconds, seconds=[seconds * 2 * FREQUENCIES / len(visited)], run=len(visited), of=2 * FREQUENCIES,
        frequency=visited, rms=np.array(found), stable=None,
    )  # fmt: skip


if __name__ == "__main__":
    main()
