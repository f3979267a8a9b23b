"""Sweeps of a train of equal branches: a flow without any disturbance stays on a symmetric motion that repels, and so tells no
attractor."""

import numpy as np
import pytest
from conftest import equal_wheels

import geartrain as gt


@pytest.fixture(scope="module")
def train():
    return equal_wheels(0.7)


@pytest.mark.parametrize("frequency", [0.5, 1.2515])
def test_what_a_diagram_calls_periodic_attracts(train, frequency):
    chart = train.bifurcation_diagram(start=frequency, stop=frequency, points=1, direction="up", transient=300)
    if chart.kind[0] == "periodic":
        assert chart.lyapunov_exponents[0, 0] < chart.lyapunov_errors[0, 0]
        assert chart.period[0] > 0
    else:
        # The meshes are alike on the symmetric motion, and the flow has left it.
        apart = np.abs(chart.displacement[0, :, 0] - chart.displacement[0, :, 1]).max()
        assert apart > 1e-3 and chart.kind[0] != ""


@pytest.mark.full
def test_every_periodic_motion_of_a_diagram_attracts(train):
    chart = train.bifurcation_diagram(start=0.48, stop=1.3, points=42, direction="both", transient=300)
    periodic = np.array(chart.kind) == "periodic"
    assert 10 < periodic.sum() < len(periodic)
    assert (chart.lyapunov_exponents[periodic, 0] < chart.lyapunov_errors[periodic, 0]).all()


@pytest.mark.parametrize("frequency", [0.5, 0.504])
def test_integration_leaves_a_motion_that_repels(train, frequency):
    """Begun exactly on the symmetric motion of the response, which no rounding disturbs."""
    symmetric = [motion for motion in train.response(start=frequency, stop=frequency + 0.001, harmonics=8).at(frequency)
                 if not motion.stable and motion.rms[0] == pytest.approx(motion.rms[1], rel=1e-9)]
    for motion in symmetric:
        exact = motion.refine()
        found = train.integrate(frequency, start=exact, stability=True, max_periods=3000)
        assert found.period == 0 or found.stable


def test_a_settled_motion_is_not_disturbed():
    """Where the symmetric motion attracts, its meshes stay alike to rounding."""
    train = equal_wheels(0.3)
    found = train.integrate(1.2, stability=True)
    assert found.stable and isinstance(found, gt.Motion)
    np.testing.assert_allclose(found.rms[0], found.rms[1], rtol=1e-9)
