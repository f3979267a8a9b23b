"""Sobol indices of any function (points, parameters) -> (points, outputs), by SALib, OpenTURNS and SciPy.

`Study.function` is such a function; so is the one of Ishigami and Homma (1990), whose indices are known in closed form. Printed by
`python example/sensitivity.py`: both, by all three.
"""

from pathlib import Path

import numpy as np
import openturns
from SALib.analyze import sobol as salib_analysis
from SALib.sample import sobol as salib_design
from scipy import stats

import geartrain as gt

CASE = Path(__file__).resolve().parent.parent / "namelists" / "single_pair.nml"


def ishigami(sample):
    """sin x1 + 7 sin^2 x2 + x3^4 sin(x1)/10, each x uniform from -pi to pi."""
    x = np.asarray(sample)
    return (np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0]))[:, np.newaxis]


#: Indices of Ishigami's function, of the first order and total: shares of V1 = (1 + pi^4/50)^2/2, V2 = 49/8 and V13 = 8 pi^8/22500.
ISHIGAMI_FIRST, ISHIGAMI_TOTAL = np.array([0.313905, 0.442411, 0.0]), np.array([0.557589, 0.442411, 0.243684])


def by_salib(function, ranges, points=256):
    """Indices of the first order and total ones, (outputs, parameters) each."""
    problem = {"num_vars": len(ranges), "names": [f"x{place}" for place in range(len(ranges))], "bounds": ranges}
    outputs = function(salib_design.sample(problem, points, calc_second_order=False, seed=1))
    found = [salib_analysis.analyze(problem, output, calc_second_order=False, seed=1) for output in outputs.T]
    return np.array([one["S1"] for one in found]), np.array([one["ST"] for one in found])


def by_openturns(function, ranges, points=256):
    """Likewise."""
    openturns.RandomGenerator.SetSeed(1)
    inputs = openturns.JointDistribution([openturns.Uniform(*ends) for ends in ranges])
    base = openturns.LowDiscrepancyExperiment(openturns.SobolSequence(), inputs, points)
    design = openturns.SobolIndicesExperiment(base).generate()
    outputs = openturns.PythonFunction(len(ranges), function(np.array(design[:1])).shape[1], func_sample=function)(design)
    found = [openturns.SaltelliSensitivityAlgorithm(design, outputs.getMarginal(place), points)
             for place in range(outputs.getDimension())]
    return np.array([one.getFirstOrderIndices() for one in found]), np.array([one.getTotalOrderIndices() for one in found])


def by_scipy(function, ranges, points=256):
    """Likewise; SciPy has parameters and outputs first, points last."""
    inputs = [stats.uniform(low, high - low) for low, high in ranges]
    found = stats.sobol_indices(func=lambda sample: function(sample.T).T, n=points, dists=inputs, rng=1)
    return np.atleast_2d(found.first_order), np.atleast_2d(found.total_order)


METHODS = {"SALib": by_salib, "OpenTURNS": by_openturns, "SciPy": by_scipy}


def pair_function():
    """The highest rms of a gear pair over torque, damping ratio and stiffness variation, as a function; and their ranges."""
    ranges = {"input_torque": (0.3, 0.5), "mesh 1 damping_ratio": (0.04, 0.06), "stiffness_variation": (0.1, 0.3)}
    study = gt.Study(gt.read_case(CASE).train, gt.Space(ranges), keep=["largest rms"], response={"start": 0.4, "stop": 1.2})
    return study.function(["largest rms"]), list(ranges.values())


if __name__ == "__main__":
    functions = ("Ishigami", ishigami, [(-np.pi, np.pi)] * 3, 4096), ("gear pair", *pair_function(), 128)
    for title, function, ranges, points in functions:
        for name, method in METHODS.items():
            first, total = method(function, ranges, points)
            print(f"{title:10s} {name:10s} first order {first[0].round(3)}  total {total[0].round(3)}")
