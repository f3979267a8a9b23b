"""Special points of a branch: folds and bifurcations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.gradient import gradient_of
from .._core.text_table import Rows
from ..errors import SolverError
from .exact_point import ExactPoint, exact_point
from .summary import speeds

__all__ = ["SpecialPoint", "SpecialPoints"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpecialPoint:
    """A place on a branch that a reader looks for.

    Attributes
    ----------
    kind : str
        ``'fold'``, ``'period doubling'``, ``'neimark-sacker'`` or ``'branch point'``; on a branch of long period without
        multipliers ``'stability change'``, where the growth rate passes 0; of a contact onset ``'separation'`` or
        ``'back contact'``, of a coupling also ``'stage 2 reached'``: stages count from the play, or from the lowest torque on.
    frequency : float
        Lambda.
    point : int
        Index of the branch's point before it.
    rms : ndarray, (meshes,)
    undecided : bool
        Whether it rests on undecided points: on one side of it the next points are all undecided. Of a contact onset whether it
        is interpolated between points.
    speed, fundamental_frequency : float or None
        In rpm, where every mesh has teeth; in Hz.
    parameter : float or None
        Value of the parameter, on a branch over one.
    correction : float or None
        Of a refined branch the change of Lambda by refinement, which is the error that it had; NaN: shooting finds none of its kind
        near it, it is that of the balance.
    branch : Branch or None
        The one that it was found on.
    mesh : int or None
        Of a contact onset the number of the mesh.
    multiplicity : int
        Multipliers, or pairs, that pass the unit circle together: N - 1 where N equal branches begin to move differently.
    """

    kind: str
    frequency: float
    point: int
    rms: Array
    undecided: bool = False
    speed: float | None = None
    fundamental_frequency: float | None = None
    parameter: float | None = None
    correction: float | None = None
    branch: Any = field(default=None, repr=False)
    mesh: int | None = None
    multiplicity: int = 1

    def gradient(self, parameters: Sequence[str]) -> Array:
        """Derivatives of ``frequency`` with respect to parameters of the train.

        The listed ``frequency`` is differentiated: the change of the frequency that a response with as many harmonics lists when
        the parameter changes slightly. A fold is the fold of the harmonic balance. A period doubling or a Neimark-Sacker point is
        the crossing of a multiplier of the balanced motion. On a refined branch every special point is the exact one. With few
        harmonics the ``frequency`` itself has an
        error, and so has its derivative: ``correction`` of a refined branch is that error.

        Lambda is ``frequency``: where ``characteristic_frequency`` is left out, as on a drawing, it is the speed in rpm.

        Parameters
        ----------
        parameters : sequence of str
            Names as in `Motion.gradient`.

        Returns
        -------
        ndarray, (parameters,)
            Of Lambda [1, or rpm as above] over the unit of the parameter, which is that of the case (angles of the drawing in
            degrees, phases in rad); NaN where there is no derivative, with a `NotDifferentiableWarning` that says why: the
            motion grazes the edge of a gap, or Newton's method finds another special point than the listed one.

        Raises
        ------
        InputError
        SolverError
            Of a branch point that is not refined, and of a contact onset.

        Warns
        -----
        NotDifferentiableWarning

        Examples
        --------
        >>> fold = branch.special_points[0]
        >>> fold.kind, fold.gradient(["mesh 1 damping_ratio", "stiffness_variation"]).round(4)
        ('fold', array([ 0.0067, -0.1799]))
        """
        place, onset = self._place()
        if onset:
            raise SolverError(f"gradient: there are no derivatives of a contact onset ({self.kind})")
        found: Array = gradient_of(self.branch._box(), "/special", parameters, place)[0]
        return found

    def exact(self) -> ExactPoint:
        """The special point of the exact motion near it, by shooting: to about 1e-10 of Lambda, but for rounding.

        Returns
        -------
        ExactPoint
            With the motion there, and how many multipliers cross the unit circle.

        Raises
        ------
        SolverError
            Where the exact motion has none of this kind near it.

        Examples
        --------
        >>> fold = branch.special_points[0].exact()
        >>> fold.kind, fold.crossing, round(fold.frequency, 9)
        ('fold', 1, 0.462118423)
        """
        place, onset = self._place()
        return exact_point(self.branch._box(), self.branch.train, place, onset)

    def _place(self) -> tuple[int, bool]:
        """Its number, from 1, among the special points of its branch, and whether it is among the contact onsets instead."""
        if self.branch is None:
            raise ValueError("this special point has no branch")
        onset = self.mesh is not None
        rows = self.branch.onsets if onset else self.branch.special_points
        return next(place for place, own in enumerate(rows, 1) if own is self), onset


class SpecialPoints(Rows[SpecialPoint]):
    """Special points of a branch: a list of `SpecialPoint` that is printed as a table."""

    def _table(self) -> Mapping[str, Sequence[Any]]:
        return {
            "kind": [special.kind for special in self],
            **speeds(self),
            f"rms of the paper{self.length}": [special.rms for special in self],
            "undecided": [special.undecided or None for special in self],
            "multiplicity": [special.multiplicity if special.multiplicity > 1 else None for special in self],
        }
