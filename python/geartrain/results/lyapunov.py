"""All Lyapunov exponents of what the flow does in the long run at one frequency."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description
from .bifurcation_diagram import BifurcationDiagram

__all__ = ["LyapunovSpectrum"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovSpectrum:
    """Lyapunov exponents of the flow at one frequency, and its sections.

    The phase of the excitation, whose exponent is 0, is not counted: one exponent is 0 on a torus, none on a periodic motion.

    Attributes
    ----------
    frequency : float
        Lambda.
    exponents, errors : ndarray, (2*elements,)
        Per unit of time (1/characteristic frequency), largest first, and their uncertainties at 95 %.
    kind : str
        As of `BifurcationDiagram`.
    period : int
        In periods of the fundamental; 0 where none was found.
    rotation_number : float
        See `BifurcationDiagram`.
    displacement, velocity : ndarray, (periods, meshes)
        Sections, at phase 0 of each period averaged over.
    state : ndarray, (2*elements,)
        At phase 0 after the last period, as ``Motion.state``.
    train : Train
    """

    frequency: float
    exponents: Array
    errors: Array
    kind: str
    period: int
    rotation_number: float
    displacement: Array
    velocity: Array
    state: Array
    train: Description | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        first = ", ".join(f"{value:.3g}" for value in self.exponents[:3])
        return f"<LyapunovSpectrum at Lambda = {self.frequency:g}, {self.kind}: {first}, ...>"

    @property
    def dimension(self) -> float:
        """Of the attractor in its sections, after Kaplan and Yorke: 0 of a periodic motion, 1 of a torus, more in chaos."""
        exponents = np.where(np.abs(self.exponents) <= self.errors, 0.0, self.exponents)
        sums = np.cumsum(exponents)
        whole = int((sums >= 0).argmin()) if (sums < 0).any() else len(sums)
        if whole in {0, len(sums)}:
            return float(whole)
        return whole + float(sums[whole - 1] / -exponents[whole])

    @classmethod
    def _of(cls, found: BifurcationDiagram) -> LyapunovSpectrum:
        """From a diagram of one point."""
        return cls(
            frequency=float(found.frequency[0]), exponents=found.lyapunov_exponents[0], errors=found.lyapunov_errors[0],
            kind=found.kind[0], period=int(found.period[0]), rotation_number=float(found.rotation_number[0]),
            displacement=found.displacement[0], velocity=found.velocity[0], state=found.final_state[0], train=found.train,
        )
