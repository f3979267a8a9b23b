"""Lyapunov exponents and rotation numbers against SciPy and the Fourier transform: ``python benchmarks/without_period.py``.

Figure 4's train near the sums of its natural frequencies. The largest exponent is also the mean rate at which two neighbouring
flights by SciPy part, with equations of their own (benchmarks/peers/figure3.py), brought back to a distance of 1e-7 every four
periods, over 4,000 periods and with twice the standard error of 20 blocks. The rotation number is also the frequency of the largest
line of the sections. Ten minutes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import geartrain as gt

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / folder) for folder in ("benchmarks/peers", "example/paper")]

import figure3  # noqa: E402
import scipy_sweep  # noqa: E402
from paper_cases import paper_case  # noqa: E402

__all__ = ["main"]

CASES = (("5e5", "w_a + w_b", 2.305), ("5e5", "w_a + w_c", 2.49), ("1e6", "w_a + w_b", 2.2))
GROUPS, PERIODS, DISTANCE = 1000, 4, 1e-7


def line_of(values: np.ndarray) -> float:
    """Frequency per sample of the largest line of a series, below 1/2, with Hann's window."""
    from scipy.optimize import minimize_scalar

    count = len(values)
    windowed = (values - values.mean()) * (1 - np.cos(2 * np.pi * np.arange(count) / count))
    highest = np.abs(np.fft.rfft(windowed)).argmax()

    def less(rate: float) -> float:
        return -abs(windowed @ np.exp(-2j * np.pi * rate * np.arange(count)))

    around = ((highest - 1) / count, (highest + 1) / count)
    return float(minimize_scalar(less, bounds=around, method="bounded", options={"xatol": 1e-12}).x)


def rate_of_parting(train: gt.Train, stiffness: float, frequency: float, state: np.ndarray) -> tuple[float, float]:
    """Largest Lyapunov exponent by two flights of SciPy, and twice its standard error."""
    peer_stiffness = np.array([shaft.stiffness for shaft in train.shafts])
    assert peer_stiffness[1] == stiffness, "the case file is not of this stiffness"
    flexibility, damping, load = of_stiffness(stiffness)
    length = 2 * np.pi / frequency
    begin = state + np.append(np.where(np.isin(np.arange(5), figure3.MESHES), 0, load), np.zeros(5))
    apart = np.random.default_rng(1).normal(size=10)
    apart *= DISTANCE / np.linalg.norm(apart)
    rates = []
    for _ in range(GROUPS):
        ends = [scipy_sweep.solve_ivp(scipy_sweep.rates, (0, PERIODS * length), start, method="DOP853", rtol=1e-10, atol=1e-12,
                                      args=(frequency, flexibility, damping, load)).y[:, -1] for start in (begin, begin + apart)]
        distance = np.linalg.norm(ends[1] - ends[0])
        rates.append(np.log(distance / DISTANCE) / (PERIODS * length))
        begin, apart = ends[0], (ends[1] - ends[0]) * DISTANCE / distance
    blocks = np.reshape(rates[GROUPS // 5:], (20, -1)).mean(axis=1)
    return float(blocks.mean()), float(2 * blocks.std(ddof=1) / np.sqrt(20))


def of_stiffness(stiffness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Matrices of the peers' train with this stiffness [N m/rad] of the shaft in the middle."""
    of_elements = figure3._stiffness.copy()
    of_elements[2] = stiffness / 0.05**2
    b, inertia = figure3._b, figure3._inertia
    flexibility = (b / inertia) @ b.T * of_elements / figure3.OMEGA_C**2
    damping = 2 * figure3._ratio * np.sqrt(of_elements / (b**2 @ (1 / inertia))) * figure3.OMEGA_C / of_elements
    return flexibility, damping, figure3._static / (of_elements * figure3.LENGTH)


def main() -> None:
    """Print the rows."""
    for name, sums, frequency in CASES:
        train = paper_case(f"fig04_k3_{name}").train
        found = train.lyapunov_spectrum(frequency, transient=8000, periods=8192)
        rate, error = rate_of_parting(train, float(name), frequency, found.state)
        line = line_of(found.displacement[:, 1])
        turns = f"{found.rotation_number:.10f}, by the transform {line:.10f} or {1 - line:.10f}"
        print(f"k3 = {name}, {sums}, Lambda = {frequency}: {found.kind}, "
              f"exponent {found.exponents[0]:.5f} +- {found.errors[0]:.5f}, by SciPy {rate:.5f} +- {error:.5f}; "
              f"rotation number {'none' if np.isnan(found.rotation_number) else turns}", flush=True)


if __name__ == "__main__":
    main()
