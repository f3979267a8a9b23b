"""Peaks and contact edges of random trains with couplings and bearings do not depend on the length of steps."""

from dataclasses import replace

import bearing_model
import coupling_model
import numpy as np
import pytest

pytestmark = [pytest.mark.full, pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")]

#: Of 400: an edge beside which another extreme becomes the lowest, a peak that two directions of a bearing share, a peak after a
#: steep rise, dips and peaks within a step.
SEEDS = (402, 5176, 5061, 476, 442)


def random_train(seed):
    """A train with constant meshes among others, some damped in contact alone, harmonics and where its branch begins and ends."""
    rng = np.random.default_rng(seed)
    base = coupling_model.random_train(seed) if seed % 2 else bearing_model.random_train(seed)
    meshes = [replace(mesh, stiffness_cos=None if rng.uniform() < 0.4 else mesh.stiffness_cos,
                      damping_acts="contact" if mesh.half_backlash and rng.uniform() < 0.6 else None) for mesh in base.meshes]
    start = rng.uniform(*((0.15, 0.6) if seed % 2 else (0.3, 1.1)))
    return replace(base, meshes=meshes), {
        "harmonics": 3 if seed > 5000 else (3, 6, 12, 18)[seed % 4], "start": start, "stop": start + 0.2}


@pytest.mark.parametrize("seed", SEEDS)
def test_long_and_short_steps(seed):
    train, settings = random_train(seed)
    coarse = train.response(**settings, stability=False, max_points=300)
    fine = train.response(**settings, stability=False, max_points=10000, step=0.004)
    assert len(fine) > 3 * len(coarse)
    assert not any(onset.undecided for onset in coarse.onsets)
    found = sorted((onset.mesh, onset.kind, onset.frequency) for onset in coarse.onsets)
    expected = sorted((onset.mesh, onset.kind, onset.frequency) for onset in fine.onsets)
    assert [onset[:2] for onset in found] == [onset[:2] for onset in expected]
    assert [onset[2] for onset in found] == pytest.approx([onset[2] for onset in expected], abs=1e-8)
    for mesh in range(1, coarse.rms.shape[1] + 1):
        peaks, expected = coarse.peaks(mesh), fine.peaks(mesh)

        def same(one, other):  # what is not solved is read off a cubic
            return abs(one.frequency - other.frequency) < 2e-5 and abs(one.rms / other.rms - 1) < 1e-5

        assert all(any(same(peak, other) for other in expected) for peak in peaks)
        # A long step has room for a ripple on a peak, of 2 in 10000 in one of these trains.
        ripples = [peak for peak in expected if not any(same(peak, other) for other in peaks)]
        assert all(any(abs(peak.rms / other.rms - 1) < 1e-3 and abs(peak.frequency - other.frequency) < 5e-3 for other in peaks)
                   for peak in ripples)
        assert len(ripples) < 2
