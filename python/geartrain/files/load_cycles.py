"""Cycles of a load, as the rainflow method counts them."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.extras import extra
from ..errors import InputError, shown

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["LoadCycles"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class LoadCycles:
    """Cycles of a torque or a force.

    Attributes
    ----------
    title : str
        What was counted.
    unit : str
        Of range and mean.
    duration : float
        Time over which they were counted [s].
    range : ndarray, (cycles,)
        Largest less smallest value of each cycle.
    mean : ndarray, (cycles,)
        Mean of the two.
    count : ndarray, (cycles,)
        1, or 0.5 of a half cycle.
    """

    title: str
    unit: str
    duration: float
    range: Array
    mean: Array
    count: Array

    def __repr__(self) -> str:
        largest = self.range.max(initial=0.0)
        told = f"{self.count.sum():g} cycles in {self.duration:g} s, the largest {largest:.6g} {self.unit}"
        return f"<LoadCycles of {self.title}: {told}>"

    def damage_equivalent(self, exponent: float, cycles: float | None = None) -> float:
        """Range of equal cycles that do the same damage by the rule of Palmgren and Miner, for an S-N curve of one slope.

        Parameters
        ----------
        exponent : float
            Of the S-N curve: N is proportional to range to the power of minus ``exponent``. Of gears by ISO 6336-6 about 6 to 17.
        cycles : float, optional
            Number of equal cycles in the ``duration``; unless told as many as were counted.

        Returns
        -------
        float
            (sum of count range^m / cycles)^(1/m).
        """
        for name, value in (("exponent", exponent), ("cycles", 1.0 if cycles is None else cycles)):
            if isinstance(value, bool) or not isinstance(value, Real) or not 0 < value < float("inf"):
                raise InputError(f"{name} = {shown(value)}: must be a number > 0")
        largest = float(self.range.max(initial=0.0))
        if largest == 0:
            return 0.0
        number = float(self.count.sum()) if cycles is None else float(cycles)
        # Over the largest range, so that a large exponent does not overflow.
        return largest * float((self.count @ (self.range / largest) ** exponent / number) ** (1 / exponent))

    def spectrum(self) -> tuple[Array, Array]:
        """The load spectrum: ranges from the largest on, and how many cycles have this range or a larger one."""
        order = np.argsort(-self.range, kind="stable")
        return self.range[order], np.cumsum(self.count[order])

    def to_dataframe(self) -> DataFrame:
        """A row for each cycle; needs pandas."""
        columns: dict[str, Any] = {f"range [{self.unit}]": self.range, f"mean [{self.unit}]": self.mean, "count": self.count}
        frame: DataFrame = extra("pandas").DataFrame(columns)
        return frame
