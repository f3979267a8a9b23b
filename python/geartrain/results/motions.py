"""Every periodic motion at one speed that was found, and whether their number adds up."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from .._core.text_table import text_table
from .._core.units import length_unit
from .motion import Motion
from .motion_table import orbits_of

__all__ = ["Find", "Motions", "adds_up", "index_of", "index_sum"]

Find = tuple[Motion, str]

_NEAR_ONE = 1e-6  # distance of a real multiplier from 1 below which the index of a motion is not known


class Motions(list[Motion]):
    """The periodic motions at one speed, stable ones first: a list of `Motion`, each by shooting to about 1e-11.

    Printed it is a table.

    The sum of the indices tells whether motions are missing. The index of a fixed point of the period map's n-th iterate is the
    sign of det(1 - M^n), M its monodromy matrix; a motion of period d counts d times where d divides n. At large amplitude the gap
    does not matter: the period map approaches the linear one of the train without backlash, and the sum over all fixed points is
    the sign of det(1 - M^n) of this one (the degree of an asymptotically linear map, Krasnosel'skii): 1, but for parametric
    resonances. Another sum is proof that some are missing; the right sum is no proof that none is: motions come and go in pairs.

    Attributes
    ----------
    frequency : float
        Lambda.
    how : list of str
        How each was found first, (motions,).
    index_sum, expected_sum : dict of int to int or None
        The sum for every period up to the one asked for, and what it must be; None where a multiplier is too near to 1 to tell, or
        where back flanks of another stiffness or phase make a train that is not linear at large amplitude either.
    complete : bool or None
        Whether all sums are as they must be; None where one of them is not known.
    others : list of Motion
        Attractors that random starts settled on without a period, or with a longer one.
    tried : int
        Random states from which shooting was begun.
    orbit : list of int
        Number of the orbit of each, from 1, (motions,): motions that differ only by a turn of the planets of a symmetric planetary
        set have one number.
    """

    def __init__(
        self, found: Iterable[Find] = (), frequency: float = float("nan"), expected_sum: Mapping[int, int | None] | None = None,
        others: Iterable[Motion] = (), tried: int = 0,
    ) -> None:
        ordered = sorted(found, key=lambda find: (not find[0].stable, find[0].period, tuple(find[0].rms)))
        super().__init__(motion for motion, _ in ordered)
        self.how = [how for _, how in ordered]
        self.frequency = frequency
        self.expected_sum = dict(expected_sum or {})
        self.index_sum = {n: index_sum(self, n) for n in self.expected_sum}
        self.complete = adds_up(self.index_sum, self.expected_sum)
        self.others = list(others)
        self.tried = tried
        self.orbit = orbits_of(self)

    def __str__(self) -> str:
        unit = length_unit(self[0].train) if self else ""
        table = text_table({
            "period": [motion.period for motion in self],
            f"rms{unit}": [motion.rms for motion in self],
            "largest multiplier": [float(np.abs(motion.multipliers).max()) if motion.multipliers is not None else None
                                   for motion in self],
            "stable": [bool(motion.stable) for motion in self],
            "found": self.how,
        })
        return f"{table}\n{self._verdict()}{self._symmetry()}"

    def _symmetry(self) -> str:
        orbits = max(self.orbit, default=0)
        return "" if orbits == len(self) else f"; up to a turn of the planets of symmetric sets these are {orbits} motions"

    def _verdict(self) -> str:
        if self.complete:
            return "the sums of the indices are as expected"
        sums = ", ".join(f"{self.index_sum[n]} of period {n} (must be {expected})" for n, expected in self.expected_sum.items()
                         if expected is None or self.index_sum[n] != expected)
        sums = sums.replace("None", "unknown")
        missing = "motions are missing" if self.complete is False else "not known whether motions are missing"
        return f"{missing}: the sum of the indices is {sums}"

    def __repr__(self) -> str:
        return f"<{len(self)} motions at Lambda = {self.frequency:g}: {self._verdict()}{self._symmetry()}>"


def index_sum(motions: Iterable[Motion], period: int) -> int | None:
    """Sum of the indices of all fixed points of the period map's iterate number ``period``; None where one of them is not known."""
    total = 0
    for motion in motions:
        if period % motion.period:
            continue
        index = index_of(motion.multipliers, period // motion.period)
        if index is None:
            return None
        total += index * motion.period
    return total


def adds_up(sums: Mapping[int, int | None], expected: Mapping[int, int | None]) -> bool | None:
    """Whether sums are as expected; None where one is not known and the others are as expected."""
    verdicts = {None if sums[n] is None or expected[n] is None else sums[n] == expected[n] for n in expected}
    return False if False in verdicts else None if None in verdicts or not verdicts else True


def index_of(multipliers: NDArray[np.complex128] | None, times: int) -> int | None:
    """Sign of det(1 - M^times); complex multipliers come in pairs, so that only real ones above 1 matter."""
    if multipliers is None:
        return None
    real = multipliers[np.abs(multipliers.imag) <= 1e-12 * np.abs(multipliers)].real ** times
    if (np.abs(real - 1) < _NEAR_ONE).any():
        return None
    return -1 if np.count_nonzero(real > 1) % 2 else 1
