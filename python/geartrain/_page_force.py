"""The force law of the meshes in numbers that a page can compute with, asked of the program by trying it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .description import Description
from .motion import Motion

__all__ = ["force_laws", "force_of", "largest_difference"]

Array = NDArray[np.float64]

#: Samples of a period of the fastest mesh; harmonics of kappa below this, over its mean, are rounding.
_SAMPLES, _ROUNDING = 256, 1e-9
#: Most samples of a trial.
_MOST = 2**19


def force_laws(train: Description) -> list[dict[str, Any]]:
    """Of each mesh: half backlash over the characteristic length, stiffness of both flanks over the phase, damping of the regions.

    They are found from the program's own force at made-up motions: at rest on either flank, and moving slowly on a flank and in the
    gap. With p the displacement, v its derivative by the phase of the fundamental and Lambda the frequency, the force in N is
    stiffness(phase) (p -+ half) + damping Lambda v.

    Returns
    -------
    list of dict
        ``half``; ``drive`` and ``back``, each ``[[order, cos, sin], ...]``, the mean with order 0; ``damping`` of back flank, gap,
        drive flank.
    """
    numbers = train.explain()
    meshes = len(train.meshes)
    half = np.array([numbers[f"mesh {mesh}"].get("half_backlash", 0.0) for mesh in range(1, meshes + 1)])
    half /= numbers["train"]["characteristic_length"]
    order = int(max(train._outline["order"], default=1))
    samples = int(min(_SAMPLES * max(order, 1), _MOST))
    phase = 2 * np.pi * np.arange(samples) / samples

    def force(mean: Array, amplitude: Array) -> Array:
        """At p = mean + amplitude sin(phase), (samples, meshes)."""
        return _trial(train, np.stack([mean, 0 * mean, amplitude], axis=1), samples)

    still = np.zeros(meshes)
    flanks = {}
    for name, side in (("drive", 1.0), ("back", -1.0)):
        far = force(side * (half + 2.0), still)
        flanks[name] = side * (far - force(side * (half + 1.0), still))
    moved = np.where(half > 0, 0.5 * half, 1.0)
    damping = []
    for name, mean in (("back", -half - 2.0), ("gap", still), ("drive", half + 2.0)):
        amplitude = moved if name == "gap" else np.ones(meshes)
        elastic = flanks[name] * (np.abs(mean) - half) * np.sign(mean) if name != "gap" else np.where(half > 0, 0.0, 1.0) * 0.0
        displaced = amplitude * np.sin(phase)[:, np.newaxis]
        if name != "gap":
            elastic = elastic + flanks[name] * displaced
        else:
            elastic = np.where(half > 0, 0.0, flanks["drive"] * displaced)
        velocity = amplitude * np.cos(phase)[:, np.newaxis]
        rest = force(mean, amplitude) - elastic
        damping.append((rest * velocity).sum(axis=0) / (velocity**2).sum(axis=0))
    return [
        {
            "half": float(half[mesh]),
            "drive": _harmonics(flanks["drive"][:, mesh]),
            "back": _harmonics(flanks["back"][:, mesh]),
            "damping": [float(region[mesh]) for region in damping],
        }
        for mesh in range(meshes)
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
        Of the static force, in whose direction the force is told.
    frequency, period : ndarray, (points,)
    orders : ndarray, (harmonics,)
        In multiples of Lambda/period.
    coefficients : ndarray, (points, meshes, 1 + 2*harmonics)
    known : ndarray, (points, meshes)
        Largest forces as the program has them [N].
    """
    worst = 0.0
    scale = np.nanmax(np.abs(known[:, mesh]), initial=0.0)
    for point in np.unique(np.linspace(0, len(frequency) - 1, min(len(frequency), 40)).astype(int)):
        row = coefficients[point, mesh]
        if not (np.isfinite(row[0]) and np.isfinite(known[point, mesh]) and period[point] > 0):
            continue
        angle = 2 * np.pi * np.arange(samples := int(max(1024, 16 * orders[-1]))) / samples
        wave = np.exp(1j * np.outer(angle, orders))
        amplitude = np.nan_to_num(row[1::2] - 1j * row[2::2])
        displacement = row[0] + (wave @ amplitude).real
        velocity = (wave @ (1j * orders * amplitude)).real / period[point]
        force = sign * force_of(law, frequency[point], angle * period[point], displacement, velocity)
        worst = max(worst, abs(force.max() - known[point, mesh]) / (scale or 1.0))
    return float(worst)


def _trial(train: Description, coefficients: Array, samples: int) -> Array:
    """The program's force at a made-up motion at Lambda = 1, (samples, meshes)."""
    nothing = np.zeros(len(coefficients))
    motion = Motion(
        frequency=1.0, period=1, rms=nothing, mean=nothing, minimum=nothing, maximum=nothing, mesh_force_maximum=nothing,
        dynamic_factor=nothing, separation_fraction=nothing, back_contact_fraction=nothing, coefficients=coefficients, train=train,
    )
    return motion._sample(samples)[2]


def _harmonics(values: Array) -> list[list[float]]:
    """A function of the phase as order, cosine, sine."""
    spectrum = np.fft.rfft(values) / len(values)
    largest = np.abs(spectrum).max() or 1.0
    return [
        [int(order), float((1 if order == 0 else 2) * spectrum[order].real), float(0.0 if order == 0 else -2 * spectrum[order].imag)]
        for order in np.flatnonzero(np.abs(spectrum) > _ROUNDING * largest)
    ]
