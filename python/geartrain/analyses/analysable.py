"""How an analysis of a train is run and what it gives is taken."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core.box import Box
from .._core.description import Description
from .._core.parameter import with_values
from .._core.watch import quiet, watched
from ..errors import SolverError
from ..results.motion import Motion, from_state
from ..results.motion_table import put_motions

if TYPE_CHECKING:
    from typing_extensions import Self


__all__ = ["Analysable"]

Result = TypeVar("Result")


class Analysable(Description):
    """A train whose analyses can be run."""

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """A train like this one with other values of parameters, as an optimiser or a loop over designs wants it.

        Parameters
        ----------
        values : mapping
            A value each, in the unit of its variable in the case: SI, but for angles of the drawing, ``'mesh 1 helix_angle'``,
            in degrees. The names are those of `Space` and `Motion.gradient`: ``'input_torque'``, ``'mesh 2 half_backlash'``,
            ``'mesh * damping_ratio'`` of all meshes, ``'mesh 1 stiffness_cos 2'`` of a list, ``'stiffness_variation'``, the largest
            amplitude of all harmonics of the mesh stiffnesses, which the train then gives in place of what they follow from; a
            tuple of names for several with the same value. A list, ``'mesh 1 driving_pitch_error'``, takes all its numbers.

        Raises
        ------
        InputError
            Where a name is unknown, a value is not allowed, or one variable is set twice.

        Examples
        --------
        >>> softer = train.with_values({"shaft 2 stiffness": 2e7, "mesh * damping_ratio": 0.06})
        >>> softer.shafts[1].stiffness, [mesh.damping_ratio for mesh in softer.meshes]
        (20000000.0, [0.06, 0.06])
        """
        return with_values(self, values)

    def _found(
        self, name: str, settings: Mapping[str, Any], take: Callable[[Box], Result | None], *bar: Any,
        start: tuple[Motion | ArrayLike | None, str] = (None, ""), **more: Any
    ) -> Result:
        """Run an analysis and take what it gives out of the box, which may be a part of it.

        ``start`` is a motion or a state to start from, and what messages call it; the rest are arguments of `watched`.
        """
        asked = self._ask(**{name: settings})

        def work(progress: NDArray[np.float64]) -> Result:
            with asked as box:
                self._put_start(box, *start)
                status = box.run(name, progress)
                found = take(box)
                box.check(status, whole=found is None)
                if found is None:
                    raise SolverError("nothing found")
                return found

        return watched(work, name.replace("_", " "), *bar, **more)

    @staticmethod
    def _put_start(box: Box, start: Motion | ArrayLike | None, what: str) -> None:
        """Put a motion, or a state of one, to start from; ``what`` is what messages call it."""
        if isinstance(start, Motion):
            put_motions(box, start, what=what)
        elif start is not None:
            put_motions(box, from_state(start, *box.sizes(), what), what=what, only_state=True)

    def _refuse(self, what: str) -> None:
        """Raise `InputError` where the period is too long for ``'motions'`` or for a ``'locus'``."""
        with Box(copy=self._kept) as box:
            box.check(box.work(what, quiet()))
