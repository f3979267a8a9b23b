"""Pitch errors of gears that a tolerance class of ISO 1328-1 allows, drawn at random: for studies of a production."""

from __future__ import annotations

import math
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, shown

if TYPE_CHECKING:
    from ..variables import Mesh

__all__ = ["pitch_errors", "pitch_tolerances"]

#: Most gears that are drawn for one that is within its class.
_TRIES = 1000


def pitch_tolerances(teeth: int, normal_module: float, helix_angle: float, tolerance_class: int) -> tuple[float, float]:
    """Tolerances of the single pitch and of the total cumulative pitch [m], ISO 1328-1:2013, 5.3, not rounded; angle in degrees."""
    module = 1e3 * normal_module
    diameter = module * teeth / math.cos(math.radians(helix_angle))
    if not (5 <= teeth <= 1000 and 5 <= diameter <= 15000 and 0.5 <= module <= 70 and abs(helix_angle) <= 45):
        raise InputError(f"ISO 1328-1 is for 5 to 1000 teeth, reference diameters of 5 to 15000 mm, normal modules of 0.5 to 70 mm "
                         f"and helix angles up to 45 degrees, not for {teeth} teeth, {diameter:.6g} mm, {module:.6g} mm, "
                         f"{helix_angle:g} degrees")
    if isinstance(tolerance_class, bool) or not isinstance(tolerance_class, Integral) or not 1 <= tolerance_class <= 11:
        raise InputError(f"tolerance_class = {shown(tolerance_class)}: must be a class of ISO 1328-1, 1 to 11")
    step = 1e-6 * math.sqrt(2) ** (int(tolerance_class) - 5)
    return ((0.001 * diameter + 0.4 * module + 5) * step,
            (0.002 * diameter + 0.55 * math.sqrt(diameter) + 0.7 * module + 12) * step)


def pitch_errors(
    mesh: Mesh, gear: str, tolerance_class: int, *, samples: int | None = None, random_seed: int = 0
) -> NDArray[np.float64]:
    """Draw pitch errors of gears that are within a tolerance class of ISO 1328-1:2013.

    Each tooth is out of place by a normal distribution, by which three standard deviations of a single pitch are its tolerance.
    An eccentricity adds a wave of one revolution with a random phase, whose height has a third of the tolerance of the total
    cumulative pitch as its standard deviation. Gears outside their class are drawn again.

    Parameters
    ----------
    mesh : Mesh
        With ``teeth`` and ``normal_module``; its angles as well.
    gear : {'driving', 'driven'}
    tolerance_class : int
        1 to 11.
    samples : int, optional
        Number of gears; one without it.
    random_seed : int
        The same seed draws the same gears.

    Returns
    -------
    ndarray, (teeth,) or (samples, teeth)
        As ``driving_pitch_error``: along the line of action in the transverse plane [m], with a mean of 0.

    Examples
    --------
    >>> mesh = gt.Mesh(between=("pinion", "wheel"), teeth=(20, 31), normal_module=3e-3, face_width=0.03)
    >>> (1e6 * gt.pitch_errors(mesh, "driving", 6)).round(1)[:4]
    array([ 0.2, -0.4,  1.1,  0. ])
    """
    if gear not in ("driving", "driven"):
        raise InputError(f"gear = {shown(gear)}: must be 'driving' or 'driven'")
    if samples is not None and (isinstance(samples, bool) or not isinstance(samples, Integral) or samples < 1):
        raise InputError(f"samples = {shown(samples)}: must be a number of gears, 1 or more")
    given: Any = mesh.teeth
    if given is None or not mesh.normal_module:
        raise InputError("mesh: must have teeth and normal_module, which give the size of ISO 1328-1")
    teeth = round(float(given[gear == "driven"]))
    helix = math.radians(mesh.helix_angle or 0.0)
    single, total = pitch_tolerances(teeth, mesh.normal_module, math.degrees(helix), tolerance_class)
    normal = math.radians(20.0 if mesh.pressure_angle is None else mesh.pressure_angle)
    # From the reference circle to the line of action.
    slope = math.cos(math.atan2(math.tan(normal), math.cos(helix)))
    generator = np.random.default_rng(random_seed)
    found = [_within(generator, teeth, single, total) * slope for _ in range(1 if samples is None else int(samples))]
    return found[0] if samples is None else np.array(found)


def _within(generator: np.random.Generator, teeth: int, single: float, total: float) -> NDArray[np.float64]:
    """Cumulative pitch errors of a gear within its tolerances."""
    angles = 2 * np.pi * np.arange(teeth) / teeth
    for _ in range(_TRIES):
        places = generator.normal(0.0, single / (3 * math.sqrt(2)), teeth)
        wave = generator.normal(0.0, total / 6) * np.cos(angles - generator.uniform(0.0, 2 * np.pi))
        errors = places + wave
        if np.abs(np.diff(errors, append=errors[0])).max() <= single and np.ptp(errors) <= total:
            centred: NDArray[np.float64] = errors - errors.mean()
            return centred
    raise InputError(f"no gear of {teeth} teeth within its tolerances was drawn in {_TRIES} tries")
