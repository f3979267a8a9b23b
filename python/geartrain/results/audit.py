"""A second opinion on a branch: points and special points solved anew by shooting."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box
from .._core.description import Description
from .._core.units import hertz_of, speed_of

__all__ = ["Audit"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Audit:
    """What shooting says of a branch, a row for each motion: points first, then special points, in the order of the branch.

    ``print(audit)`` shows it as a table with a line that sums it up.

    Attributes
    ----------
    kind : tuple of str
        ``'point'``, or the kind of a special point.
    frequency, exact_frequency : ndarray, (rows,)
        Lambda as the branch has it, and of the special point of the exact branch; nan for a point and where none was found.
    speed, exact_speed : ndarray, (rows,), or None
        Both in rpm; None where not every mesh has teeth.
    fundamental_frequency, exact_fundamental_frequency : ndarray, (rows,), or None
        Both in Hz.
    unit : str
        Of the frequencies in the table: what the branch was asked in, rpm where Lambda is the speed in rpm.
    point : ndarray of int, (rows,)
        Index of the point; of a special point other than a fold that of the point before it.
    error_estimate, error, ratio : ndarray, (rows,)
        Relative error of the waveform as estimated and as found, the second over the first; nan where not known. Where the
        branch turns before the Lambda of the point the error is that against its fold. Below what shooting itself leaves, about
        1e-11, they count as equal.
    estimate_doubtful : ndarray of bool, (rows,)
        As in `Branch`.
    verdict, exact_verdict : tuple of str
        ``'stable'``, ``'unstable'`` or ``'undecided'`` (by shooting ``'neutral'``, or ``'fold'`` for a point beyond it); of a
        special point the multipliers beyond the unit circle before it and after it. Empty where not known.
    estimate_wrong, verdict_wrong : ndarray of bool, (rows,)
        The error is not within a factor of 3 of its estimate, which is not called doubtful, or no orbit was found near the point;
        the verdicts contradict each other, or the exact branch has no such special point nearby: no such fold, or no other one
        though none of the points next to it is undecided.
    finding : tuple of str
        What is wrong or worth knowing, in words; empty where all is as the branch says.
    points, as_estimated, doubtful : int
        Points audited; those whose error is within a factor of 3 of its estimate; others, whose estimate is called doubtful.
    special_points, confirmed : int
        Special points; those of which nothing is wrong.
    wrong_verdicts : int
        Of points and special points.
    ok : bool
        Whether nothing is wrong.
    """

    kind: tuple[str, ...]
    frequency: Array
    exact_frequency: Array
    point: NDArray[np.intc]
    error_estimate: Array
    error: Array
    ratio: Array
    estimate_doubtful: NDArray[np.bool_]
    verdict: tuple[str, ...]
    exact_verdict: tuple[str, ...]
    estimate_wrong: NDArray[np.bool_]
    verdict_wrong: NDArray[np.bool_]
    finding: tuple[str, ...]
    points: int
    as_estimated: int
    doubtful: int
    special_points: int
    confirmed: int
    wrong_verdicts: int
    ok: bool
    table: str
    unit: str
    speed: Array | None = None
    exact_speed: Array | None = None
    fundamental_frequency: Array | None = None
    exact_fundamental_frequency: Array | None = None

    def __len__(self) -> int:
        return len(self.frequency)

    def __repr__(self) -> str:
        return f"<Audit: {self.table.splitlines()[-1]}>"

    def __str__(self) -> str:
        return self.table

    @classmethod
    def _from(cls, box: Box, train: Description) -> Audit:
        group = box.show("audit")["/audit"]
        values = {**group.values(), "point": group.arrays["point"] - 1, "table": box.text("audit")}
        for name in ("", "exact_"):
            frequency = values[f"{name}frequency"]
            values[f"{name}speed"] = speed_of(train, frequency)
            values[f"{name}fundamental_frequency"] = hertz_of(train, frequency)
        values["unit"] = values["table"].split(maxsplit=1)[0]
        return cls(**{item.name: values[item.name] for item in fields(cls)})
