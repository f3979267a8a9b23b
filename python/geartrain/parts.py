"""The parts of a gear train."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from itertools import islice
from typing import Any

__all__ = ["MESH", "SHAFT", "Mesh", "Series", "Shaft", "freeze_series"]

Series = float | Sequence[float]

_MOST = 1000  # values of a series: what a case file may hold; one more is told as too many, an endless one as well

_ELEMENT = dict.fromkeys(("stiffness", "damping_ratio", "damping"), "number")
SHAFT = {**_ELEMENT, "rigid": "flag"}
MESH = {
    **_ELEMENT,
    **dict.fromkeys(("driving_radius", "driven_radius", "driving_inertia", "driven_inertia"), "number"),
    **dict.fromkeys(("stiffness_cos", "stiffness_sin", "error_cos", "error_sin"), "series"),
    "half_backlash": "number",
    "order": "integer",
}


@dataclass(frozen=True, kw_only=True)
class Shaft:
    """A torsional shaft.

    Parameters
    ----------
    stiffness : float
        [N m/rad]; not for a rigid shaft.
    damping_ratio : float, optional
        c/(2 sqrt(k m)) with m = 1/(1/I_a + 1/I_b) of the inertias at its ends; or ``damping``.
    damping : float, optional
        [N m s/rad]
    rigid : bool, optional
        The inertias at its ends move as one.
    """

    stiffness: float | None = None
    damping_ratio: float | None = None
    damping: float | None = None
    rigid: bool | None = None


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A gear pair.

    Parameters
    ----------
    driving_radius, driven_radius : float
        Base circle radii [m].
    driving_inertia, driven_inertia : float
        [kg m^2]
    stiffness : float
        Mean mesh stiffness [N/m].
    damping_ratio : float, optional
        c/(2 sqrt(k m)) with m = I_a I_b/(r_a^2 I_b + r_b^2 I_a); or ``damping``.
    damping : float, optional
        [N s/m]
    half_backlash : float, optional
        [m]; 0 makes the mesh linear.
    stiffness_cos, stiffness_sin : float or sequence of float, optional
        Harmonics 1.. of the stiffness over its mean.
    error_cos, error_sin : float or sequence of float, optional
        Harmonics 1.. of the static transmission error [m].
    order : int, optional
        This mesh's frequency as a multiple of the fundamental.
    """

    driving_radius: float | None = None
    driven_radius: float | None = None
    driving_inertia: float | None = None
    driven_inertia: float | None = None
    stiffness: float | None = None
    damping_ratio: float | None = None
    damping: float | None = None
    half_backlash: float | None = None
    stiffness_cos: Series | None = None
    stiffness_sin: Series | None = None
    error_cos: Series | None = None
    error_sin: Series | None = None
    order: int | None = None

    def __post_init__(self) -> None:
        freeze_series(self, MESH)


def freeze_series(part: Any, kinds: Mapping[str, str]) -> None:
    """Make tuples of the series, whichever way they were given, of no more of them than it takes to see that they are too many."""
    for name, kind in kinds.items():
        value = getattr(part, name)
        if kind != "series" or value is None or isinstance(value, (str, bytes, bytearray, Mapping, AbstractSet)):
            continue
        # An array without dimensions says that it can be iterated over, and cannot; the check tells.
        with contextlib.suppress(TypeError):
            object.__setattr__(part, name, tuple(islice(value, _MOST + 1)) if isinstance(value, Iterable) else (value,))
