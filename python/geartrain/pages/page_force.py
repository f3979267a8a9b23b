"""The force law of the meshes in numbers that a page can compute with, asked of the program by trying it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description, half_gaps
from ..results.motion import Motion

__all__ = ["force_laws", "force_of", "largest_difference"]

Array = NDArray[np.float64]

#: Samples of a period of the fastest mesh, as many as it takes; harmonics of kappa below this, over its mean, are rounding.
_SAMPLES, _ROUNDING = (16, 64, 256), 1e-9
#: Most samples of a trial, and of one that finds a damping; points of a branch at which forces are compared.
_MOST, _FEW, _TRIED = 2**19, 2**10, 40


def force_laws(train: Description, frequency: float) -> list[dict[str, Any]]:
    """Of each mesh: half backlash over the characteristic length, stiffness of both flanks over the phase, damping of the regions.

    They are found from the program's own force at made-up motions: at rest on either flank, and moving on a flank and in the gap.
    With p the displacement, v its derivative by the phase of the fundamental and Lambda the frequency, the force in N (of a
    coupling the torque in N m) is
    stiffness(phase) (p -+ half) + damping Lambda v.

    Parameters
    ----------
    train : Description
    frequency : float
        A Lambda that the train can have.

    Returns
    -------
    list of dict
        ``half``; ``drive`` and ``back``, each ``[[order, cos, sin], ...]``, the mean with order 0; ``damping`` of back flank, gap,
        drive flank.
    """
    half = half_gaps(train)
    still, one = np.zeros(len(half)), np.ones(len(half))
    for fine in _SAMPLES:
        samples = min(2 ** int(np.ceil(np.log2(fine * max(train._outline["order"])))), _MOST)
        drive, back = (side * _trial(train, frequency, side * (half + 1), still, samples) for side in (1, -1))
        if samples == _MOST or (_resolved(drive) and _resolved(back)):
            break
    few = min(samples, _FEW)
    phase = 2 * np.pi * np.arange(few)[:, np.newaxis] / few

    def damping(mean: Array, amplitude: Array, stiffness: Array, origin: Array) -> Array:
        """What is left of the force without its elastic part, over the velocity."""
        elastic = stiffness * (mean + amplitude * np.sin(phase) - origin)
        velocity = frequency * amplitude * np.cos(phase)
        force = _trial(train, frequency, mean, amplitude, few)
        found: Array = ((force - elastic) * velocity).sum(axis=0) / (velocity**2).sum(axis=0)
        return found

    # Without a gap the drive flank is everywhere.
    in_gap = np.where(half > 0, half / 2, 1.0)
    slopes = back[::samples // few], np.where(half > 0, 0.0, drive[::samples // few]), drive[::samples // few]
    dampings = [damping(-half - 2, one, slopes[0], -half), damping(still, in_gap, slopes[1], still),
                damping(half + 2, one, slopes[2], half)]
    return [
        {
            "half": float(half[mesh]),
            "drive": _harmonics(drive[:, mesh]),
            "back": _harmonics(back[:, mesh]),
            "damping": [float(region[mesh]) for region in dampings],
        }
        for mesh in range(len(half))
    ]


def force_of(law: dict[str, Any], frequency: float, phase: Array, displacement: Array, velocity: Array) -> Array:
    """The force [N] of a mesh as the page computes it.

    Parameters
    ----------
    law : dict
        Of `force_laws`.
    frequency : float
        Lambda.
    phase, displacement, velocity : ndarray
        Phase of the fundamental, displacement over the characteristic length, its derivative by the phase, of one shape.
    """
    half = law["half"]
    drive, back = (sum(cos * np.cos(order * phase) + sin * np.sin(order * phase) for order, cos, sin in law[name])
                   for name in ("drive", "back"))
    on_drive, on_back = displacement > half, displacement < -half
    if half == 0:
        on_drive = np.ones(on_drive.shape, bool)
    region = np.where(on_drive, 2, np.where(on_back, 0, 1))
    elastic = np.where(on_drive, drive * (displacement - half), np.where(on_back, back * (displacement + half), 0.0))
    found: Array = elastic + np.array(law["damping"])[region] * frequency * velocity
    return found


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
