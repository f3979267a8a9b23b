"""All pairs of a transformation and an analysis, and what is wrong with the results of a pair."""

import warnings
from dataclasses import replace

from metamorphic_branches import (
    NothingFoundError,
    exact,
    gradient,
    locus,
    modes,
    over_parameter,
    refine,
    refined_branch,
    response,
    stability_map,
)
from metamorphic_flows import attractors, basins, bifurcation_diagram, integrate, lyapunov_spectrum, run_up, sweep
from transformations import TRANSFORMATIONS, plain

#: Analyses by their names.
ANALYSES = {function.__name__: function for function in (
    modes, response, exact, refine, refined_branch, gradient, over_parameter, locus, stability_map, integrate, sweep, attractors,
    basins, lyapunov_spectrum, bifurcation_diagram, run_up)}
#: Those that follow a flow for a long time: what it reaches may depend on rounding.
FLOWS = {"integrate", "sweep", "attractors", "basins", "lyapunov_spectrum", "bifurcation_diagram", "run_up"}


def combinations():
    """Pairs of a transformation and an analysis whose results can be compared."""
    left_out = {
        # A flow begins at phase 0: from rest it is another flow, and so is a ramp.
        *(("phase", name) for name in ("sweep", "attractors", "basins", "bifurcation_diagram", "run_up")),
        # Integration and modes know nothing of a period that is looked for.
        *(("subharmonic", name) for name in (*FLOWS, "modes", "stability_map")),
        # A random start of the mirrored train is no mirrored one.
        ("mirror", "attractors"),
    }
    return [(one, other) for one in TRANSFORMATIONS for other in ANALYSES if (one, other) not in left_out]


def nudged(train, rng):
    """The train with all inertias changed by little more than rounding."""
    train = plain(train)
    return replace(train, bodies=[replace(body, inertia=body.inertia * (1 + 1e-12 * rng.uniform(-1, 1))) for body in train.bodies])


def disagreement(analysis, train, image, plan):
    """What is wrong with an analysis of an image, in words; empty where nothing is, None where there is nothing to compare."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            ANALYSES[analysis](train, image, plan)
        except NothingFoundError:
            return None
        except AssertionError as error:
            return " ".join(str(error).split())
    return ""
