"""Speed against error on figure 3: harmonic balance at several R, time integration, and SciPy, side by side in one run.

Run after scripts/setup:  .venv/bin/python benchmarks/speed_against_error.py
The error is that of rms (largest of the two meshes, relative) at five frequencies, against shooting (about 1e-11).
"""

import platform
import statistics
import time

import numpy as np
import scipy
from scipy.integrate import solve_ivp

import geartrain as gt

FREQUENCIES = [0.7, 0.9, 1.0, 1.2, 1.6]
REPEATS = 7


def median_time(call, repeats=REPEATS):
    """Median wall time of a call [s], after one warm-up, and its last result."""
    call()
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        result = call()
        times.append(time.perf_counter() - begun)
    return statistics.median(times), result


def scipy_settled(train, frequency, periods):
    """rms of both meshes by DOP853 (rtol 1e-8) over `periods` mesh periods from rest; the last one is measured."""
    inertia = np.array([2.3e-7, 0.0023, 0.037, 0.0046, 0.074, 2.3e-7])
    # theta -> element displacement: shaft, mesh, shaft, mesh, shaft.
    b = np.zeros((5, 6))
    for row, (left, right) in enumerate([(1, 1), (0.05, 0.1), (1, 1), (0.05, 0.1), (1, 1)]):
        b[row, row : row + 2] = left, -right
    k = np.array([1e3, 2.5e8, 1e8, 5e8, 1e3])
    equivalent = 1 / (b**2 @ (1 / inertia))
    c = 2 * np.array([0.01, 0.05, 0.01, 0.05, 0.01]) * np.sqrt(k * equivalent)
    g = (b / inertia) @ b.T
    load = np.array([150, 150 / 0.05, 300, 300 / 0.05, 600])
    gap, rate = 30e-6, frequency * 9870.0

    def rates(t, x):
        p, v = x[:5], x[5:]
        spring = p.copy()
        spring[1::2] = np.maximum(p[1::2] - gap, 0) + np.minimum(p[1::2] + gap, 0)
        force = k * spring
        force[1::2] *= 1 + 0.3 * np.cos(rate * t)
        drive = np.zeros(5)
        drive[0] = 150 / inertia[0]
        drive[4] = 600 / inertia[5]
        return np.concatenate([v, drive - g @ (force + c * v)])

    period = 2 * np.pi / rate
    rest = load / k
    rest[1::2] += gap
    end = periods * period
    times = end - period * (1 - np.arange(1024) / 1024)
    x = solve_ivp(rates, (0, end), np.concatenate([rest, np.zeros(5)]), method="DOP853", rtol=1e-8, atol=1e-14, t_eval=times)
    p = x.y[[1, 3]] / gap
    return np.sqrt(2) * p.std(axis=1)


def main():
    train = gt.read_case("namelists/fig03.nml").train
    print(f"geartrain {gt.__version__}, SciPy {scipy.__version__}, NumPy {np.__version__}, Python {platform.python_version()}")
    print(f"{platform.machine()}, median of {REPEATS} runs, one thread\n")
    branch = train.response(start=0.2, stop=2.6, harmonics=24)
    reference = {f: [motion.refine() for motion in branch.at(f)] for f in FREQUENCIES}

    def error(find):
        """Largest relative rms error over all solutions at all frequencies."""
        worst = 0.0
        for frequency, motions in reference.items():
            for motion, found in zip(motions, find(frequency), strict=True):
                worst = max(worst, np.max(np.abs(found.rms - motion.rms) / motion.rms))
        return worst

    print("harmonic balance, whole curve 0.2 to 2.6            points   ms/curve   us/point   rms error")
    for harmonics in (3, 6, 12, 24, 48):
        for stability in (True, False):
            seconds, curve = median_time(
                lambda h=harmonics, s=stability: train.response(start=0.2, stop=2.6, harmonics=h, stability=s))
            name = f"R = {harmonics}" + (", with multipliers" if stability else "")
            points = len(curve.frequency)
            print(f"  {name:49} {points:6d} {seconds * 1e3:10.1f} {seconds / points * 1e6:10.1f}   {error(curve.at):.1e}")

    frequency = 0.9
    exact = reference[frequency][0].rms
    print("\none steady motion at Lambda = 0.9                                ms   rms error")
    seconds, motion = median_time(lambda: reference[frequency][0].refine())
    print(f"  {'shooting from a known motion':57} {seconds * 1e3:8.2f}   {np.max(np.abs(motion.rms - exact) / exact):.1e}")
    seconds, motion = median_time(lambda: train.integrate(frequency=frequency))
    print(f"  {'time integration from rest until steady':57} {seconds * 1e3:8.2f}   "
          f"{np.max(np.abs(motion.rms - exact) / exact):.1e}")
    seconds, rms = median_time(lambda: scipy_settled(train, frequency, 100), 1)
    print(f"  {'SciPy solve_ivp DOP853 rtol 1e-8, 100 mesh periods':57} {seconds * 1e3:8.2f}   "
          f"{np.max(np.abs(rms - exact) / exact):.1e}")


if __name__ == "__main__":
    main()
