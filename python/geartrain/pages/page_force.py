"""The force law of the meshes in numbers that a page can compute with, asked of the program by trying it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description, corners, half_gaps
from ..results.motion import Motion

__all__ = ["force_laws", "force_of", "largest_difference"]

Array = NDArray[np.float64]

#: Samples of a period of the fastest mesh, as many as it takes; harmonics of kappa below this, over its mean, are rounding.
_SAMPLES, _ROUNDING = (16, 64, 256), 1e-9
#: Most samples of a trial, and of one that finds a damping; points of a branch at which forces are compared.
_MOST, _FEW, _TRIED = 2**19, 2**10, 40


def force_laws(train: Description, frequency: float) -> list[dict[str, Any]]:
    """Of each mesh, coupling or bearing: the regions of its displacement, and in each of them stiffness, offset and damping.

    They are found from the program's own force at made-up motions: at rest at two places of each region, and moving within it.
    With p the displacement, v its derivative by the phase of the fundamental and Lambda the frequency, the force in N (of a
    coupling the torque in N m) is
    stiffness(phase) p + offset(phase) + damping Lambda v.

    Parameters
    ----------
    train : Description
    frequency : float
        A Lambda that the train can have.

    Returns
    -------
    list of dict
        ``half``, half of the gap over the characteristic length; ``corners``, displacements between the regions, ascending; of
        each region ``stiffness`` and ``offset``, ``[[order, cos, sin], ...]``, the mean with order 0, and ``damping``.
    """
    walls = corners(train)
    regions = [_regions(train, frequency, walls, place) for place in range(max(map(len, walls)) + 1)]
    return [
        {"half": float(half), "corners": walls[mesh].tolist(),
         **{name: [region[name][mesh] for region in regions[:len(walls[mesh]) + 1]] for name in regions[0]}}
        for mesh, half in enumerate(half_gaps(train))
    ]


def _regions(train: Description, frequency: float, walls: Sequence[Array], place: int) -> dict[str, list[Any]]:
    """Stiffness, offset and damping in the region at a place, counted from 0 and of all; of those with fewer in their last."""
    inner = [_inner(corner, min(place, len(corner))) for corner in walls]
    low, high = (np.array(ends) for ends in zip(*inner))
    nothing = np.zeros(len(low))
    for fine in _SAMPLES:
        samples = min(2 ** int(np.ceil(np.log2(fine * max(train._outline["order"])))), _MOST)
        below, above = (_trial(train, frequency, ends, nothing, samples) for ends in (low, high))
        if samples == _MOST or (_resolved(below) and _resolved(above)):
            break
    stiffness = (above - below) / (high - low)
    offset = below - stiffness * low
    # A force that is proportional to p has an offset of rounding.
    offset[np.abs(offset) < _ROUNDING * np.abs(above).max(axis=0)] = 0.0
    few = min(samples, _FEW)
    mean, amplitude = (low + high) / 2, (high - low) / 2
    phase = 2 * np.pi * np.arange(few)[:, np.newaxis] / few
    velocity = frequency * amplitude * np.cos(phase)
    elastic = stiffness[::samples // few] * (mean + amplitude * np.sin(phase)) + offset[::samples // few]
    moving = _trial(train, frequency, mean, amplitude, few)
    damping = ((moving - elastic) * velocity).sum(axis=0) / (velocity**2).sum(axis=0)
    return {"stiffness": [_harmonics(values) for values in stiffness.T], "offset": [_harmonics(values) for values in offset.T],
            "damping": damping.tolist()}


def _inner(corner: Array, place: int) -> tuple[float, float]:
    """Two displacements well within a region."""
    if len(corner) == 0:
        return -1.0, 1.0
    if place == 0:
        return corner[0] - 2.0, corner[0] - 1.0
    if place == len(corner):
        return corner[-1] + 1.0, corner[-1] + 2.0
    width = corner[place] - corner[place - 1]
    return corner[place - 1] + width / 4, corner[place] - width / 4


def force_of(law: dict[str, Any], frequency: float, phase: Array, displacement: Array, velocity: Array) -> Array:
    """The force [N] of a mesh, or the torque [N m] of a coupling, as the page computes it.

    Parameters
    ----------
    law : dict
        Of `force_laws`.
    frequency : float
        Lambda.
    phase, displacement, velocity : ndarray
        Phase of the fundamental, displacement over the characteristic length, its derivative by the phase, of one shape.
    """
    region = np.searchsorted(law["corners"], displacement)
    found = np.array(law["damping"])[region] * frequency * velocity
    for place, (stiffness, offset) in enumerate(zip(law["stiffness"], law["offset"])):
        here = region == place
        found[here] += _series(stiffness, phase[here]) * displacement[here] + _series(offset, phase[here])
    return found


def _series(terms: list[list[float]], phase: Array) -> Array:
    """The sum of harmonics of the phase."""
    return sum((cos * np.cos(order * phase) + sin * np.sin(order * phase) for order, cos, sin in terms), np.zeros(len(phase)))


def largest_difference(
    law: dict[str, Any], mesh: int, sign: float, frequency: Array, period: Array, orders: Array, coefficients: Array, known: Array,
) -> float:
    """By how much the largest force over a period is off at most, over the largest force, against that of the program.

    Parameters
    ----------
    law : dict
    mesh : int
        Its column.
    sign : float
        Of the static force, in whose direction the force is told; 0: in either direction.
    frequency, period : ndarray, (points,)
    orders : ndarray, (harmonics,)
        In multiples of Lambda/period.
    coefficients : ndarray, (points, meshes, 1 + 2*harmonics)
    known : ndarray, (points, meshes)
        Largest forces as the program has them [N].
    """
    worst = 0.0
    scale = np.nanmax(np.abs(known[:, mesh]), initial=0.0) or 1.0
    samples = 2 ** int(np.ceil(np.log2(max(1024, 16 * orders[-1]))))
    angle = 2 * np.pi * np.arange(samples) / samples
    points = np.flatnonzero(np.isfinite(coefficients[:, mesh, 0]) & np.isfinite(known[:, mesh]) & (period > 0))
    tried = max(2, min(_TRIED, len(points), _MOST // samples))
    for point in points[np.linspace(0, len(points) - 1, tried).astype(int)] if len(points) else ():
        row = np.nan_to_num(coefficients[point, mesh])
        spectrum = np.zeros(samples // 2 + 1, complex)
        spectrum[orders] = samples / 2 * (row[1::2] - 1j * row[2::2])
        displacement = row[0] + np.fft.irfft(spectrum)
        velocity = np.fft.irfft(1j * np.arange(len(spectrum)) * spectrum) / period[point]
        force = force_of(law, frequency[point], angle * period[point], displacement, velocity)
        force = sign * force if sign else np.abs(force)
        worst = max(worst, abs(force.max() - known[point, mesh]) / scale)
    return float(worst)


def _trial(train: Description, frequency: float, mean: Array, amplitude: Array, samples: int) -> Array:
    """The program's force where p = mean + amplitude sin(phase), (samples, meshes)."""
    nothing = np.zeros(len(mean))
    motion = Motion(
        frequency=frequency, period=1, rms=nothing, mean=nothing, minimum=nothing, maximum=nothing, mesh_force_maximum=nothing,
        dynamic_factor=nothing, separation_fraction=nothing, back_contact_fraction=nothing,
        coefficients=np.stack([mean, nothing, amplitude], axis=1), train=train,
    )
    return motion._sample(samples)[2]


def _resolved(values: Array) -> bool:
    """Whether the upper half of the spectrum of each column is rounding."""
    amplitude = np.abs(np.fft.rfft(values, axis=0))
    return bool((amplitude[len(amplitude) // 2:] <= _ROUNDING * amplitude.max(axis=0)).all())


def _harmonics(values: Array) -> list[list[float]]:
    """A function of the phase as order, cosine, sine."""
    spectrum = np.fft.rfft(values) / len(values)
    largest = np.abs(spectrum).max() or 1.0
    spectrum[1:] *= 2
    return [[int(order), float(spectrum[order].real), -float(spectrum[order].imag)]
            for order in np.flatnonzero(np.abs(spectrum) > _ROUNDING * largest)]
