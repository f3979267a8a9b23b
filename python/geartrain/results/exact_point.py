"""Special points of the exact motion, by shooting."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box
from .._core.description import Description
from .._core.units import hertz_of, speed_of
from .._core.watch import watched
from .motion import Motion
from .motion_table import motions_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["ExactPoint", "exact_point"]

#: Distance from the unit circle, or from the value at which it crosses, within which a multiplier is critical.
_CRITICAL = 1e-6
#: What Fortran tells where there is no contact event is larger.
_NO_EVENT = 1e300


@dataclass(frozen=True, eq=False)
class ExactPoint:
    """A special point or a contact onset of the exact motion.

    Attributes
    ----------
    kind : str
        ``'fold'``, ``'period doubling'``, ``'neimark-sacker'``, ``'branch point'``, ``'separation'`` or ``'back contact'``.
    frequency : float
        Lambda.
    motion : Motion
        The motion there.
    mesh : int or None
        Of a contact onset the number of the mesh.
    before, after : int or None
        Multipliers outside the unit circle just before and just after it along the branch; None where there is no motion beside
        it.
    criticality : str
        Of a period doubling or a Neimark-Sacker point ``'supercritical'`` (the doubled, or quasi-periodic, motions are stable where
        this one is unstable, as far as its other multipliers go) or ``'subcritical'``; empty where the motion stays on linear
        pieces, and for other kinds.
    slowest_event : float or None
        Smallest mesh speed at a contact event, dimensionless; None where there is no event. Near 0 the motion grazes a wall of the
        gap, and the multipliers change there like a square root.
    speed, fundamental_frequency : float or None
        In rpm, where every mesh has teeth; in Hz.
    multiplicity : int
        Number of multipliers, or pairs, that pass the unit circle together. Above 1 the frequency is where their mean passes it.
    """

    kind: str
    frequency: float
    motion: Motion = field(repr=False)
    mesh: int | None = None
    before: int | None = None
    after: int | None = None
    criticality: str = ""
    slowest_event: float | None = None
    speed: float | None = None
    fundamental_frequency: float | None = None
    multiplicity: int = 1

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Of the motion, (states,)."""
        found = self.motion.multipliers
        assert found is not None
        return found

    @property
    def critical(self) -> NDArray[np.complex128]:
        """The multipliers on the unit circle, to 1e-6, (critical,)."""
        return self.multipliers[abs(abs(self.multipliers) - 1) < _CRITICAL]

    @property
    def crossing(self) -> int | None:
        """How many multipliers cross the unit circle here at once; None where it is not known."""
        return None if self.before is None or self.after is None else abs(self.after - self.before)


def exact_point(box: Box, train: Description, number: int, onset: bool) -> ExactPoint:
    """The exact point of special point or contact onset ``number``, from 1, of the branch of a box, which is closed."""

    def work(progress: ArrayLike) -> ExactPoint:
        with box:
            box.check(box.work("exact", np.asarray(progress), number, onset))
            found = box.show("exact")["/exact"].attributes
            motion = Motion(train=train, **motions_of(box)[0])
            counts = {name: None if found[name] < 0 else int(found[name]) for name in ("before", "after")}
            return ExactPoint(
                str(found["kind"]).strip(), float(found["frequency"]), motion, int(found["mesh"]) or None, **counts,
                criticality=str(found["criticality"]).strip(),
                slowest_event=float(found["slowest_event"]) if found["slowest_event"] < _NO_EVENT else None,
                speed=speed_of(train, float(found["frequency"])), fundamental_frequency=hertz_of(train, float(found["frequency"])),
                multiplicity=int(found["multiplicity"]),
            )

    return watched(work, "exact", in_parts=False)
