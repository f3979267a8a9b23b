"""Natural frequencies and mode shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._table import Table

__all__ = ["Modes"]


@dataclass(frozen=True, eq=False)
class Modes(Table):
    """Modes of the mean linear system: contact everywhere, mean mesh stiffness; a rigid-body mode is left out.

    Attributes
    ----------
    natural_frequency : ndarray, (modes,)
        Undamped, over the characteristic frequency, ascending.
    damped_frequency : ndarray, (modes,)
        Imaginary part of the damped eigenvalue, over the characteristic frequency.
    damping_ratio : ndarray, (modes,)
    shape : ndarray, (modes, elements)
        Displacement of each elastic element, the largest of a mode being 1.
    element : tuple of str
        What the elements are: ``'shaft 1'``, ``'mesh 1'``, ...
    element_label : tuple of str
        Names of the two bodies that each joins, ``'pinion - wheel'``; in a chain as ``element``.
    """

    path = "/modes"

    natural_frequency: NDArray[np.float64]
    damped_frequency: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    shape: NDArray[np.float64]
    element: tuple[str, ...]
    element_label: tuple[str, ...]
