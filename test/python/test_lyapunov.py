"""Lyapunov spectra, rotation numbers and bifurcation diagrams against closed forms and multipliers."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import paper_train


def linear(train):
    """The train without backlash at constant stiffness."""
    return replace(train, meshes=[replace(mesh, half_backlash=0.0, stiffness_cos=None) for mesh in train.meshes])


def real_parts(train):
    """Those of the eigenvalues of a linear train, -zeta omega of each mode twice, largest first."""
    modes = train.modes()
    return np.sort(-np.repeat(modes.damping_ratio * modes.natural_frequency, 2))[::-1]


def test_a_linear_train_has_the_real_parts_of_its_eigenvalues():
    train = linear(paper_train())
    found = train.lyapunov_spectrum(0.9, periods=1000)
    assert found.exponents == pytest.approx(real_parts(train), rel=1e-3)
    assert found.kind == "periodic" and found.dimension == 0


@pytest.mark.parametrize("frequency", [0.7, 1.92])
def test_a_periodic_motion_has_those_of_its_multipliers(frequency):
    """ln|multiplier| over the period, period 2 at 1.92."""
    train = paper_train()
    found = train.lyapunov_spectrum(frequency, periods=1000)
    motion = train.integrate(frequency, start=found.state)
    assert found.period == motion.period
    exact = np.sort(np.log(np.abs(motion.multipliers)))[::-1] * frequency / (2 * np.pi * motion.period)
    assert found.exponents == pytest.approx(exact, abs=1e-4)
    assert found.exponents[:4] == pytest.approx(exact[:4], rel=1e-3)
