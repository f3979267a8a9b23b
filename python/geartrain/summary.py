"""What one reads off a branch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Jump", "Peak"]


@dataclass(frozen=True)
class Peak:
    """A local maximum of the rms of a mesh along a branch.

    Attributes
    ----------
    frequency, rms : float
        Lambda and rms, by a parabola through the highest point and its neighbours.
    point : int
        Index of the highest point.
    stable : bool or None
        Of that point; None where stability was not asked for.
    undecided : bool
        Whether ``stable`` is a guess.
    """

    frequency: float
    rms: float
    point: int
    stable: bool | None
    undecided: bool = False


@dataclass(frozen=True, eq=False)
class Jump:
    """Where a sweep in speed jumps: the stable motion that it follows ends there.

    Attributes
    ----------
    frequency : float
        Lambda.
    kind : str
        ``'jump up'`` or ``'jump down'``: to a larger or a smaller amplitude, all meshes together. ``'leaves'``: the branch has no
        other stable motion there.
    speed : str
        ``'rising'`` or ``'falling'``: the way in which the sweep goes that jumps here.
    cause : str
        Kind of the special point at which the stable motion ends.
    before : ndarray, (meshes,)
        rms before the jump.
    after : ndarray, (meshes,)
        rms after it: of the stable motion of the branch with the nearest rms; nan where the jump leaves the branch.
    candidates : int
        Other stable motions of the branch at this frequency. With more than one ``after`` is a guess: a sweep may reach another, or
        a motion of another period; ``train.integrate(start=...)`` tells.
    undecided : bool
        Whether it rests on undecided points: no decided point near it is stable on one side and none unstable on the other, or the
        motion after it is undecided.
    """

    frequency: float
    kind: str
    speed: str
    cause: str
    before: NDArray[np.float64]
    after: NDArray[np.float64]
    candidates: int
    undecided: bool = False
