"""The steady motions on which random starts settle."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from .._core.box import Box
from .._core.description import Description
from .branch import Branch
from .motion import Motion
from .motion_table import ATTRACTORS, motions_dataset, motions_of, put_table

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["Attractors"]


class Attractors(list[Motion]):
    """The steady motions that random starts settled on at one frequency, largest share first: a list of `Motion`.

    Chaotic and quasi-periodic motions have the ``period`` 0, their ``kind`` and ``lyapunov_exponent``; flows of equal mean and
    spread of all coordinates at phase 0 count as one such motion.

    Attributes
    ----------
    frequency : float
        Lambda.
    starts, random_seed : int
        Starts done, and what they were made from.
    unsettled : float
        Share of the starts that settled on none: not steady after ``max_periods``, or run away.
    ended : str
        Why it ended, in words, and that the train floats in its gaps where it does.
    complete : bool
        Whether all starts were done.
    branches : list of Branch
        Those through motions on no branch known before, where such motions were to be followed.
    """

    def __init__(
        self,
        motions: Iterable[Motion],
        frequency: float = float("nan"),
        starts: int = 0,
        random_seed: int = 0,
        unsettled: float = 0.0,
        ended: str = "",
        complete: bool = False,
        branches: Iterable[Branch] = (),
    ) -> None:
        super().__init__(motions)
        self.frequency = frequency
        self.starts = starts
        self.random_seed = random_seed
        self.unsettled = unsettled
        self.ended = ended
        self.complete = complete
        self.branches = list(branches)

    @property
    def speed(self) -> float | None:
        """Speed [rpm]; None where not every mesh has teeth, or without a motion."""
        return self[0].speed if self else None

    @property
    def fundamental_frequency(self) -> float | None:
        """Frequency of the fundamental [Hz]; None without a motion."""
        return self[0].fundamental_frequency if self else None

    def to_dataset(self) -> Dataset:
        """The motions as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        attributes = self._attributes()
        del attributes["frequency"]
        return motions_dataset(ATTRACTORS, self, ("speed", "fundamental_frequency"), attributes)

    def __repr__(self) -> str:
        return f"<{len(self)} attractors from {self.starts} starts, {self.unsettled:.1%} unsettled: {self.ended}>"

    @classmethod
    def _from(cls, box: Box, train: Description, branches: Iterable[Branch] = ()) -> Attractors:
        motions = [Motion(train=train, **fields) for fields in motions_of(box, ATTRACTORS)]
        known = box.results()[ATTRACTORS].attributes
        names = ("frequency", "starts", "random_seed", "unsettled", "ended", "complete")
        return cls(motions, **{name: known[name] for name in names}, branches=branches)

    def _put(self, box: Box) -> None:
        """Put it into a box as its result."""
        put_table(box, ATTRACTORS, "motion", self, self._attributes(), {}, "attractors")

    def _attributes(self) -> dict[str, Any]:
        """Those of the group of the results file."""
        return {name: value for name, value in vars(self).items() if name != "branches"}
