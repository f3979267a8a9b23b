"""Design by derivatives, the example of docs/design.md: `python example/design.py`, two minutes on one core.

1. Shaft stiffness and mesh phase of figure 3's train for the least largest dynamic factor over a range of speeds.
2. The least change of a gear pair that takes its jump out of a range.
3. As 1, for the 95 % quantile over trains within their tolerances.
4. The probability that a pair of tolerances jumps within the range: first and second order beside Monte Carlo.

A folder for the picture may follow (results).
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import openturns
from numpy.typing import NDArray
from scipy import optimize, stats

import geartrain as gt

__all__ = ["Count", "FactorsOfRanges", "JumpOfPair", "least_change", "least_factor", "main", "reliability", "robust_factor"]

Array = NDArray[np.float64]
CASES = Path(__file__).resolve().parent.parent / "namelists"


class Count(NamedTuple):
    """What an optimisation found and what it cost.

    Attributes
    ----------
    x : ndarray
    value : float
    responses : int
        Branches traced.
    seconds : float
        Of processor time.
    """

    x: Array
    value: float
    responses: int
    seconds: float


class FactorsOfRanges:
    """Largest dynamic factors of figure 3's train in ranges of speed, by the log10 of shaft 2's stiffness and mesh 2's phase.

    Of all motions of the branch, stable or not, so that it changes smoothly where a stable part ends. As the largest factor of a
    range is a maximum over speed, its derivative is the one at constant speed.
    """

    names = ("shaft 2 stiffness", "mesh 2 phase")
    start = np.array([8.0, 0.0])
    bounds = ((5.0, 8.5), (-np.inf, np.inf))

    def __init__(self, ranges: int = 7, low: float = 0.3, high: float = 2.6) -> None:
        self.train = gt.read_case(CASES / "fig03.nml").train.with_values({"mesh * damping_ratio": 0.1})
        self.edges = np.linspace(low, high, ranges + 1)
        self.responses = 0

    def values(self, x: Array) -> dict[str, float]:
        return {"shaft 2 stiffness": 10 ** x[0], "mesh 2 phase": x[1]}

    def factors(self, x: Array, further: dict[str, float] | None = None, derivatives: bool = True) -> tuple[Array, Array]:
        """The largest of each range and mesh, (ranges x meshes), and their derivatives, (ranges x meshes, 2).

        Those below 0.6 of the largest decide nothing: they are as large as at the points of the branch, their derivatives zero.
        """
        train = self.train.with_values({**self.values(x), **(further or {})})
        branch = train.response(start=self.edges[0], stop=self.edges[-1], harmonics=12, stability=False)
        self.responses += 1
        chain = np.array([np.log(10) * 10 ** x[0], 1.0])
        all_largest = branch.dynamic_factor.max()
        largest, slopes = [], []
        for low, high in zip(self.edges, self.edges[1:]):
            inside = np.flatnonzero((branch.frequency >= low) & (branch.frequency <= high))
            for mesh in range(2):
                rough = branch.dynamic_factor[inside, mesh].max()
                motion = _largest(branch, inside, mesh, low, high) if rough > 0.6 * all_largest else None
                largest.append(rough if motion is None else float(motion.dynamic_factor[mesh]))
                decides = derivatives and motion is not None
                slopes.append(motion.gradient("dynamic_factor", self.names)[mesh] * chain if decides else np.zeros(2))
        return np.array(largest), np.array(slopes)


def _largest(branch: gt.Branch, inside: Array, mesh: int, low: float, high: float) -> gt.Motion:
    """The motion with the largest dynamic factor of a mesh between two speeds."""
    at = inside[np.argmax(branch.dynamic_factor[inside, mesh])]
    near = branch.frequency[[max(at - 1, 0), min(at + 1, len(branch) - 1)]]

    def motion(frequency: float) -> gt.Motion:
        return max(branch.at(float(frequency)), key=lambda found: float(found.dynamic_factor[mesh]))

    ends = max(low, near.min()), min(high, near.max())
    found = optimize.minimize_scalar(lambda f: -motion(f).dynamic_factor[mesh], bounds=ends, method="bounded",
                                     options={"xatol": 1e-5})
    return max((motion(found.x), motion(ends[0]), motion(ends[1])), key=lambda one: float(one.dynamic_factor[mesh]))


def least_factor(start: Array = FactorsOfRanges.start, gradients: bool = True) -> Count:
    """The least bound of all factors: by SLSQP with derivatives, or by the method of Nelder and Mead."""
    problem, begun = FactorsOfRanges(), time.process_time()
    if gradients:
        found = _minimax(problem.factors, start, problem.bounds)
    else:
        simplex = np.array([start, start - [0.5, 0], start + np.array([0, 1])])
        found = optimize.minimize(lambda x: problem.factors(x, derivatives=False)[0].max(), start, bounds=problem.bounds,
                                  method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-4, "initial_simplex": simplex})
    value = problem.factors(found.x[:2], derivatives=False)[0].max()
    return Count(found.x[:2], float(value), problem.responses, time.process_time() - begun)


def _minimax(factors: Callable[[Array], tuple[Array, Array]], start: Array, bounds: Sequence[Any]) -> Any:
    """Minimise t subject to t >= every factor: smooth, where the largest factor itself has kinks."""
    scale = np.array([1.0, 2.0])  # a decade of stiffness moves about as much as 2 rad

    @lru_cache(maxsize=4)
    def known(key: bytes) -> tuple[Array, Array]:
        return factors(np.frombuffer(key) * scale)

    def room(z: Array) -> Array:
        return z[2] - known(z[:2].tobytes())[0]

    def slope(z: Array) -> Array:
        slopes = known(z[:2].tobytes())[1]
        return np.column_stack([-slopes * scale, np.ones(len(slopes))])

    z = np.append(start / scale, factors(start)[0].max())
    limits = [(low / unit, high / unit) for (low, high), unit in zip(bounds, scale)] + [(0.0, None)]
    found = optimize.minimize(lambda z: z[2], z, jac=lambda z: np.array([0.0, 0.0, 1.0]), bounds=limits, method="SLSQP",
                              constraints={"type": "ineq", "fun": room, "jac": slope}, options={"ftol": 1e-5, "maxiter": 60})
    found.x = found.x * np.append(scale, 1.0)
    return found


class JumpOfPair:
    """The jump of a gear pair with rising speed, the fold near Lambda 0.84, by damping ratio and stiffness variation."""

    names = ("mesh 1 damping_ratio", "stiffness_variation")
    nominal = np.array([0.05, 0.3])

    def __init__(self) -> None:
        self.train = gt.read_case(CASES / "single_pair.nml").train
        self.responses = 0
        self.fold = lru_cache(maxsize=64)(self._fold)

    def _fold(self, damping: float, variation: float) -> tuple[float, Array]:
        """Lambda of the upper fold and its derivatives."""
        train = self.train.with_values(dict(zip(self.names, (damping, variation))))
        branch = train.response(start=0.5, stop=1.2, harmonics=12)
        self.responses += 1
        folds = [special for special in branch.special_points if special.kind == "fold"]
        upper = max(folds, key=lambda special: special.frequency)
        return upper.frequency, upper.gradient(self.names)


def least_change(limit: float = 0.8, gradients: bool = True) -> Count:
    """The least relative change of damping and stiffness variation that keeps the jump below a speed, by SLSQP."""
    pair, begun = JumpOfPair(), time.process_time()
    jump = {
        "type": "ineq", "fun": lambda y: limit - pair.fold(*(y * pair.nominal))[0],
        **({"jac": lambda y: -pair.fold(*(y * pair.nominal))[1] * pair.nominal} if gradients else {}),
    }
    found = optimize.minimize(lambda y: ((y - 1) ** 2).sum(), np.ones(2), jac=lambda y: 2 * (y - 1), method="SLSQP",
                              bounds=[(0.5, 2.0)] * 2, constraints=jump, options={"ftol": 1e-10})
    return Count(found.x * pair.nominal, float(found.fun), pair.responses, time.process_time() - begun)


def robust_factor(nominal: Array, draws: int = 32) -> tuple[Count, float]:
    """The design with the least 95 % quantile over trains within their tolerances; and the quantile of the nominal optimum."""
    problem, begun = FactorsOfRanges(), time.process_time()
    tolerance = stats.qmc.scale(stats.qmc.Sobol(4, rng=1).random(draws), 0.9, 1.1)
    names = [f"mesh {mesh} {name}" for mesh in (1, 2) for name in ("damping_ratio", "stiffness")]
    own = np.array([value for mesh in problem.train.meshes for value in (mesh.damping_ratio, mesh.stiffness)])
    rows = [dict(zip(names, row * own)) for row in tolerance]

    def quantiles(x: Array) -> tuple[Array, Array]:
        """Of each factor, with the derivatives of the trains that the quantile lies between."""
        found = [problem.factors(x, row) for row in rows]
        values, slopes = np.array([one[0] for one in found]), np.array([one[1] for one in found])
        place = 0.95 * (draws - 1)
        order = np.argsort(values, axis=0)[[int(place), min(int(place) + 1, draws - 1)]]
        share = np.array([1 - place % 1, place % 1])
        columns = np.arange(values.shape[1])
        return share @ values[order, columns], np.einsum("k,kij->ij", share, slopes[order, columns])

    before = quantiles(nominal)[0].max()
    found = _minimax(quantiles, nominal, problem.bounds)
    value = quantiles(found.x[:2])[0].max()
    return Count(found.x[:2], float(value), problem.responses, time.process_time() - begun), float(before)


class Reliability(NamedTuple):
    """Probabilities that the jump lies above a speed.

    Attributes
    ----------
    first_order, second_order : float
        By FORM, and by SORM with Breitung's formula.
    responses : int
        Branches that both took.
    monte_carlo, error : float
        The share of the samples, and 1.96 standard deviations of it.
    design_point : ndarray, (2,)
        The most likely pair of values at the limit.
    samples : ndarray, (samples, 2)
    above : ndarray of bool, (samples,)
    """

    first_order: float
    second_order: float
    responses: int
    monte_carlo: float
    error: float
    design_point: Array
    samples: Array
    above: NDArray[np.bool_]


def reliability(limit: float = 0.86, samples: int = 10_000) -> Reliability:
    """Damping ratio and stiffness variation are normal with a standard deviation of 5 %.

    The methods are OpenTURNS'; first derivatives are given to it, and second ones as differences of them.
    """
    pair = JumpOfPair()
    deviation = 0.05 * pair.nominal

    def second(x: Sequence[float]) -> list[list[list[float]]]:
        steps = 1e-2 * np.diag(deviation)
        rows = [(pair.fold(*(x + step))[1] - pair.fold(*(x - step))[1]) / (2 * step.sum()) for step in steps]
        return ((np.array(rows) + np.array(rows).T) / 2)[:, :, np.newaxis].tolist()

    def first(x: Sequence[float]) -> list[list[float]]:
        return pair.fold(*x)[1].reshape(2, 1).tolist()

    function = openturns.PythonFunction(2, 1, lambda x: [pair.fold(*x)[0]], gradient=first, hessian=second)
    inputs = openturns.RandomVector(openturns.JointDistribution([openturns.Normal(*one) for one in zip(pair.nominal, deviation)]))
    event = openturns.ThresholdEvent(openturns.CompositeRandomVector(function, inputs), openturns.Greater(), limit)
    solver = openturns.AbdoRackwitz()
    solver.setStartingPoint(pair.nominal)
    method = openturns.SORM(solver, event)
    method.run()
    found = method.getResult()
    responses = pair.responses
    values = np.random.default_rng(1).normal(pair.nominal, deviation, (samples, 2))
    study = gt.Study(pair.train, gt.Space(sample=values, names=list(pair.names)), keep=["first jump up"],
                     response={"start": 0.5, "stop": 1.2, "harmonics": 12})
    with tempfile.TemporaryDirectory() as folder:
        above = study.run(folder)["first jump up"].values > limit
    share = float(above.mean())
    linear = openturns.DistFunc.pNormal(-found.getHasoferReliabilityIndex())
    return Reliability(linear, found.getEventProbabilityBreitung(), responses, share, 1.96 * np.sqrt(share * (1 - share) / samples),
                       np.array(found.getPhysicalSpaceDesignPoint()), values, above)


def draw(designs: dict[str, Array], chances: Reliability, path: Path) -> None:
    """Draw the factors over speed of each design, and the samples with the most likely one at the limit."""
    problem = FactorsOfRanges()
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    for place, (name, x) in enumerate(designs.items()):
        branch = problem.train.with_values(problem.values(x)).response(start=problem.edges[0], stop=problem.edges[-1], harmonics=12)
        largest = branch.dynamic_factor.max(axis=1)
        left.plot(branch.frequency, largest, linestyle=("-", "--", "-.", ":")[place % 4], label=f"{name}: {largest.max():.2f}")
    left.set(xlabel="Λ", ylabel="dynamic factor, the larger of both meshes", title="least largest dynamic factor")
    left.legend()
    for above, color, marker, label in ((False, "C0", ".", "jump below 0.86"), (True, "C3", "x", "above")):
        chosen = chances.samples[chances.above == above]
        right.plot(*chosen.T, marker, ms=2, color=color, label=label)
    right.plot(*chances.design_point, "k*", ms=12, label="most likely of these")
    right.set(xlabel="damping ratio", ylabel="stiffness variation", title="where the pair's jump is too high")
    right.legend(markerscale=2)
    figure.savefig(path, dpi=90)
    plt.close(figure)


def main(folder: str = "results") -> None:
    """Answer the four questions, print and draw the answers."""
    plt.rcParams.update(gt.plot_style())
    problem = FactorsOfRanges()
    before = problem.factors(problem.start, derivatives=False)[0].max()
    print(f"largest dynamic factor of the train as it is: {before:.3f}")
    best = least_factor(np.array([7.0, 0.0]))
    for name, found in (
        ("SLSQP with derivatives", least_factor()), ("Nelder-Mead without", least_factor(gradients=False)),
        ("SLSQP from 1e7 N m/rad", best),
    ):  # fmt: skip
        print(f"  {name:23s} {found.value:.3f} at stiffness {10 ** found.x[0]:.3g} N m/rad, phase {found.x[1]:.2f} rad; "
              f"{found.responses} responses, {found.seconds:.1f} s")
    for name, gradients in (("derivatives", True), ("differences", False)):
        found = least_change(gradients=gradients)
        print(f"jump below 0.8 by {name}: damping ratio {found.x[0]:.5f}, stiffness variation {found.x[1]:.5f}; "
              f"{found.responses} responses, {found.seconds:.2f} s")
    robust, nominal = robust_factor(best.x)
    print(f"95 % quantile within tolerances: {nominal:.3f} of the nominal optimum, {robust.value:.3f} at stiffness "
          f"{10 ** robust.x[0]:.3g} N m/rad, phase {robust.x[1]:.2f} rad; {robust.responses} responses, {robust.seconds:.0f} s")
    chances = reliability()
    print(f"probability of a jump above 0.86: {chances.first_order:.4f} first order, {chances.second_order:.4f} second order, "
          f"{chances.responses} responses; {chances.monte_carlo:.4f} +- {chances.error:.4f} of {len(chances.samples)} samples")
    Path(folder).mkdir(parents=True, exist_ok=True)
    designs = {"as it is": problem.start, "optimum": best.x, "robust": robust.x}
    path = Path(folder) / "design.png"
    draw(designs, chances, path)
    print(f"drawn: {path}")


if __name__ == "__main__":
    main(*sys.argv[1:])
