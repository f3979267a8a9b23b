"""The relative error of each mesh: a mesh of small amplitude has a larger one than all meshes together."""

import numpy as np
import pytest
from conftest import ROOT

from geartrain import read_case


@pytest.fixture(scope="module")
def train():
    return read_case(ROOT / "namelists" / "fig03.nml").train


@pytest.mark.parametrize("frequency", [0.45, 0.95, 1.25, 1.8, 2.2])
def test_each_mesh_is_as_wrong_as_estimated(train, frequency):
    """Against 60 harmonics; the estimate is of first order in an error of at most 2e-3. At 2.2 the error is 1e-13."""
    few, many = (
        train.response(start=frequency, stop=1.001 * frequency, harmonics=harmonics, max_points=2) for harmonics in (6, 60)
    )
    missing = many.coefficients[0].copy()
    missing[:, : few.coefficients.shape[2]] -= few.coefficients[0]
    amplitude = np.sqrt(np.sum(few.coefficients[0][:, 1:] ** 2, axis=1))
    error = np.sqrt(2 * missing[:, 0] ** 2 + np.sum(missing[:, 1:] ** 2, axis=1)) / amplitude
    np.testing.assert_allclose(few.mesh_error_estimate[0], error, rtol=0.1)


def test_a_mesh_beyond_the_tolerance_is_told(train):
    """At Lambda 1.8 mesh 2 has a ninth of the amplitude of mesh 1."""
    branch = train.response(start=1.75, stop=1.9, harmonics=0, tolerance=3e-4, shaft_torque=False)
    assert branch.error_estimate.max() < 3e-4
    assert branch.mesh_error_estimate[:, 1].max() > 9e-4
    assert "mesh 2 has a small amplitude: its relative error is up to 0.00175" in branch.ended
    branch = train.response(start=1.75, stop=1.9, harmonics=0, tolerance=1e-4, shaft_torque=False)
    assert branch.ended == "reached Lambda = 1.9"
