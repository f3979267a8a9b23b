"""Planetary sets described in another way are the same sets: planets renumbered, angles from another origin, members exchanged."""

from dataclasses import replace

import numpy as np
import pytest
from planetary_trains import planetary
from test_planet_symmetry import stage

ERRORS = (0.0, 2e-6, -1e-6)
RESPONSE = {"start": 1.6, "stop": 1.62, "harmonics": 8}


def same(one, other, meshes=slice(None), sign=1.0, tolerance=1e-12):
    """Compare two branches; ``meshes`` are those of the second one in the order of the first, ``sign`` turns displacements over."""
    assert len(one) == len(other)
    np.testing.assert_allclose(other.frequency, one.frequency, rtol=tolerance)
    for name in ("rms", "mean"):
        first, second = getattr(one, name), getattr(other, name)[:, meshes]
        second = second * sign if name == "mean" else second
        np.testing.assert_allclose(second, first, atol=tolerance * np.abs(first).max())
    assert (one.stable == other.stable).all()


@pytest.mark.parametrize("teeth", [(27, 36, 99), (26, 31, 88)])
def test_renumbered_planets(teeth):
    one = stage(teeth=teeth, planets=None, angles=(0.0, 120.0, 240.0), planet_errors=ERRORS)
    other = stage(teeth=teeth, planets=None, angles=(0.0, 240.0, 120.0), planet_errors=(ERRORS[0], ERRORS[2], ERRORS[1]))
    same(one.response(**RESPONSE), other.response(**RESPONSE), [0, 2, 1, 3, 5, 4])


@pytest.mark.parametrize("teeth", [(27, 36, 99), (26, 31, 88)])
def test_origin_of_angles(teeth):
    """Another origin, and another planet named first: a shift in time."""
    one = stage(teeth=teeth, planets=None, angles=(0.0, 120.0, 240.0), planet_errors=ERRORS).response(**RESPONSE)
    turned = stage(teeth=teeth, planets=None, angles=(30.0, 150.0, 270.0), planet_errors=ERRORS).response(**RESPONSE)
    same(one, turned)
    first = stage(teeth=teeth, planets=None, angles=(120.0, 240.0, 0.0), planet_errors=(*ERRORS[1:], ERRORS[0]))
    same(one, first.response(**RESPONSE), [2, 0, 1, 5, 3, 4])


def exchanged(mesh):
    """The mesh with its other member written first: displacement and error change their signs."""
    turned = {name: None if getattr(mesh, name) is None else tuple(-value for value in getattr(mesh, name))
              for name in ("error_cos", "error_sin")}
    return replace(mesh, between=mesh.between[::-1], driving_radius=mesh.driven_radius, driven_radius=mesh.driving_radius, **turned)


@pytest.mark.parametrize("which", [range(3), range(3, 6), range(6)], ids=["sun", "ring", "both"])
def test_member_written_first(which):
    """Planets in sequence whose meshes lose contact."""
    train = planetary()
    other = replace(train, meshes=[exchanged(mesh) if number in which else mesh for number, mesh in enumerate(train.meshes)])
    sign = np.where(np.isin(np.arange(6), list(which)), -1.0, 1.0)
    settings = {"start": 1.72, "stop": 1.75, "harmonics": 8}
    one = train.response(**settings)
    assert (one.minimum < 2.0).any()
    same(one, other.response(**settings), sign=sign)
