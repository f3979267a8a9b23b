"""A motion followed over many periods of the fundamental."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Trajectory"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion of any kind over many periods of the fundamental, from phase 0 on.

    Attributes
    ----------
    time : ndarray, (samples,)
        In units of 1/characteristic_frequency.
    displacement : ndarray, (samples, meshes)
        Over the characteristic length.
    velocity : ndarray, (samples, meshes)
        Its derivative by ``time``.
    mesh_force : ndarray, (samples, meshes)
        In N, damping included.
    shaft_torque : ndarray, (samples, shafts)
        In N m.
    samples_per_period : int
        Samples of each period of the fundamental.
    """

    time: Array
    displacement: Array
    velocity: Array
    mesh_force: Array
    shaft_torque: Array
    samples_per_period: int

    @property
    def section(self) -> tuple[Array, Array]:
        """The Poincare section at phase 0: displacement and velocity once in each period of the fundamental, (periods, meshes)."""
        return self.displacement[:: self.samples_per_period], self.velocity[:: self.samples_per_period]
