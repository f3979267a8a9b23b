"""The example of docs/design.md: design by derivatives, against differences, a method without derivatives, and Monte Carlo."""

import re

import numpy as np
import pytest
from conftest import ROOT

import design

pytestmark = pytest.mark.full


def test_factors_of_ranges_change_as_their_derivatives_say():
    problem, x, step = design.FactorsOfRanges(), np.array([6.5, 0.4]), 1e-4
    values, slopes = problem.factors(x)
    decides = slopes.any(axis=1)
    assert decides.sum() >= 2 and values[decides].max() == values.max()
    for place, side in enumerate(np.eye(2) * step):
        change = problem.factors(x + side, derivatives=False)[0] - problem.factors(x - side, derivatives=False)[0]
        np.testing.assert_allclose(slopes[decides, place], change[decides] / (2 * step), rtol=2e-3, atol=2e-4)


@pytest.mark.nightly
def test_optimum_of_two_methods():
    best = design.least_factor(np.array([7.0, 0.0]))
    simplex = design.least_factor(best.x + np.array([0.03, 0.06]), gradients=False)  # begun nearby
    assert best.value <= simplex.value + 1e-3 and best.value == pytest.approx(simplex.value, rel=5e-3)
    assert best.responses < simplex.responses
    quantile, nominal = design.robust_factor(best.x, draws=4)
    assert best.value < quantile.value <= nominal


def test_least_change_puts_the_jump_at_the_limit():
    found, without = design.least_change(0.8), design.least_change(0.8, gradients=False)
    np.testing.assert_allclose(found.x, without.x, rtol=1e-5)
    assert found.responses < without.responses
    jump, slope = design.JumpOfPair().fold(*found.x)
    assert jump == pytest.approx(0.8, abs=1e-8)
    change = found.x / design.JumpOfPair.nominal - 1  # of the least change the direction is the one of the fold's derivatives
    scaled = slope * design.JumpOfPair.nominal
    assert abs(change @ scaled) == pytest.approx(np.linalg.norm(change) * np.linalg.norm(scaled), rel=1e-5)


def test_probability_of_a_jump(times):
    found = design.reliability(0.86, samples=times(400, share=4))
    assert found.first_order == pytest.approx(found.second_order, rel=0.02)
    assert abs(found.monte_carlo - found.second_order) < 2 * found.error  # four standard deviations


def test_the_lines_of_the_page_run(monkeypatch):
    """Those of docs/design.md; no derivative of theirs is missing."""
    monkeypatch.chdir(ROOT)
    block = re.search(r"```python\n(.*?)```", (ROOT / "docs" / "design.md").read_text(encoding="utf-8"), re.DOTALL)[1]
    page = {"__name__": "page"}
    exec(compile(block, "docs/design.md", "exec"), page)
    lines = re.findall(r"^\w+\.\w*gradient\(.*\)(?=  )", block, re.MULTILINE)
    assert len(lines) == 3
    for line in lines:
        assert np.isfinite(eval(line, page)).all()
    assert page["softer"].shafts[1].stiffness == 1e7
