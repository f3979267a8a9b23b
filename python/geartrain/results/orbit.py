"""When two motions are one orbit: by their waveforms, whatever period they were solved with and wherever they begin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .motion import Motion

__all__ = ["least_period", "replace_period", "same_orbit"]

_SAME = 1e-6  # distance of two orbits found by shooting, relative, below which they are one; shooting is good to 1e-11


def least_period(motion: Motion) -> int:
    """The least period of which the waveform is, by the harmonics that it lacks."""
    amplitude = np.hypot(motion.coefficients[:, 1::2], motion.coefficients[:, 2::2]).max(axis=0)
    order = np.arange(1, len(amplitude) + 1)
    scale = max(float(amplitude.max(initial=0.0)), float(np.abs(motion.coefficients[:, 0]).max()) * 1e-3)
    for period in range(1, motion.period):
        if motion.period % period == 0 and (amplitude[order % (motion.period // period) > 0] < _SAME * scale).all():
            return period
    return motion.period


def replace_period(motion: Motion, period: int) -> Motion:
    """The motion as one of a multiple of its period."""
    times = period // motion.period
    old = motion.coefficients
    new = np.zeros((len(old), 1 + 2 * times * ((old.shape[1] - 1) // 2)))
    new[:, 0] = old[:, 0]
    for harmonic in range(1, (old.shape[1] - 1) // 2 + 1):
        new[:, 2 * times * harmonic - 1:2 * times * harmonic + 1] = old[:, 2 * harmonic - 1:2 * harmonic + 1]
    return replace(motion, period=period, coefficients=new)


def same_orbit(one: Motion, other: Motion) -> bool:
    """Whether two motions are one orbit, begun perhaps some periods of the fundamental apart."""
    if one.period != other.period:
        return False
    harmonics = (min(one.coefficients.shape[1], other.coefficients.shape[1]) - 1) // 2
    first, second = _complex(one, harmonics), _complex(other, harmonics)
    scale = max(float(np.abs(first).max()), float(np.abs(second).max()))
    turn = np.exp(2j * np.pi * np.arange(harmonics + 1) / one.period)
    return any(float(np.abs(first * turn**shift - second).max()) < _SAME * scale for shift in range(one.period))


def _complex(motion: Motion, harmonics: int) -> NDArray[np.complex128]:
    """Mean and complex amplitudes, (meshes, 1 + harmonics)."""
    kept = motion.coefficients[:, : 1 + 2 * harmonics]
    return np.hstack([kept[:, :1] + 0j, kept[:, 1::2] - 1j * kept[:, 2::2]])
