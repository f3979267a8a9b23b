"""A train under torques from outside, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core.box import Box, fortran
from .._core.description import Description
from .._core.units import Unit, lambda_of, speed_of
from .._core.watch import quiet, watched
from ..errors import InputError, SolverError, shown
from .motion import Motion, from_state
from .motion_table import put_motions

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["Simulator"]

Array = NDArray[np.float64]

_SHORT = 0.01  # s that are simulated before Ctrl-C is listened to


class Simulator:
    """A train under torques from outside, step by step, as a part of a larger simulation; `Train.simulator` makes it.

    The speed is not prescribed: torques that are not in balance accelerate the train. Mesh stiffness, transmission errors and
    alternating torques of the train go on with its rotation. Damping to ground acts on the vibration, as everywhere.

    Attributes
    ----------
    time : float
        Since the beginning [s].
    frequency : float
        Lambda of the mean rotation.
    speed : float
        Mean speed of the body ``Train.speed_name``, without vibration [rpm].
    body_speed : ndarray, (bodies,)
        With vibration, positive as the body turns [rad/s], in the order of ``Train.body_labels``.
    displacement : ndarray, (meshes,)
        Over the characteristic length.
    mesh_force : ndarray, (meshes,)
        Damping included [N]; of a coupling the torque [N m].
    shaft_torque : ndarray, (shafts,)
        [N m]; NaN where rigid shafts side by side leave it undetermined.
    reaction_torque : ndarray, (held bodies,)
        By which each held body is held [N m].
    torque : dict
        On each body at present [N m], besides the alternating torques of the train, positive as the body turns.
    state : ndarray
        As ``Motion.state``.
    phase : float
        Of the fundamental, 0 to 2 pi; a simulator begins at 0.
    """

    def __init__(
        self, train: Description, frequency: float | None = None, *, start: Motion | ArrayLike | None = None, unit: Unit = "Lambda"
    ) -> None:
        if frequency is None and isinstance(start, Motion):
            at = start.frequency
        elif isinstance(frequency, bool) or not isinstance(frequency, Real) or not 0 <= frequency < float("inf"):
            raise InputError(f"frequency = {shown(frequency)}: must be a number >= 0")
        else:
            at = lambda_of(train, float(frequency), unit)
        self.train = train
        self._box = Box(copy=train._kept)
        if isinstance(start, Motion):
            put_motions(self._box, start, what="start")
        elif start is not None:
            put_motions(self._box, from_state(start, *self._box.sizes(), "start"), what="start", only_state=True)
        torque, sizes, status = fortran.begin_simulator(self._box.handle, at, len(train.body_labels))
        self._box.check(status)
        self._sizes = [int(size) for size in sizes]
        self.torque: dict[str, float] = dict(zip(train.body_labels, map(float, torque)))
        self._take(fortran.advance_simulator(*self._arguments(0.0, quiet())))

    def __repr__(self) -> str:
        return f"<Simulator at {self.time:.6g} s, {self.speed:.6g} rpm>"

    def advance(self, duration: float, torque: Mapping[str, float] | None = None) -> Self:
        """Go on under constant torques.

        Parameters
        ----------
        duration : float
            [s].
        torque : mapping, optional
            Torques on bodies by their names [N m]; the others keep theirs. Each replaces the mean torque of the case.

        Returns
        -------
        Simulator
            Itself.

        Raises
        ------
        InputError
            Where a body is unknown, a value is not allowed, or the step has more than ten million mesh cycles.
        SolverError
            Where the motion grows without bound.
        Interrupted
            On Ctrl-C: it stands then where it came to.

        Examples
        --------
        The motor of a drive is switched off, and the load brakes it:

        >>> reducer = gt.read_case("namelists/reducer.nml").train
        >>> simulator = reducer.simulator(1500.0, unit="rpm")
        >>> simulator.advance(0.01).speed
        1500.0
        >>> simulator.advance(0.01, {"motor": 0.0}).speed < 1500
        True
        """
        if isinstance(duration, bool) or not isinstance(duration, Real) or not 0 <= duration < float("inf"):
            raise InputError(f"duration = {shown(duration)}: must be a number >= 0")
        for name, value in (torque or {}).items():
            if name not in self.torque:
                raise InputError(f"torque: {shown(name)}: must be one of {', '.join(self.torque)}")
            if isinstance(value, bool) or not isinstance(value, Real) or not abs(value) < float("inf"):
                raise InputError(f"torque: {name} = {shown(value)}: must be a number")
        before, length = dict(self.torque), float(duration)
        self.torque.update({name: float(value) for name, value in (torque or {}).items()})
        try:
            if length <= _SHORT:
                return self._take(fortran.advance_simulator(*self._arguments(length, quiet())))
            return watched(lambda progress: self._take(fortran.advance_simulator(*self._arguments(length, progress))), "simulator")
        except (InputError, SolverError):
            self.torque = before
            raise

    def value(self, name: str) -> float:
        """Force or torque of an element by its name, ``'mesh 1'``, ``'shaft 2'``; speed of a body by its name [rad/s]."""
        known = self.names
        if name not in known:
            raise InputError(f"name = {shown(name)}: must be one of {', '.join(known)}")
        return float(np.concatenate([self.shaft_torque, self.mesh_force, self.body_speed])[known.index(name)])

    @property
    def names(self) -> tuple[str, ...]:
        """What `value` knows: shafts, meshes with couplings and bearings, bodies."""
        shafts = [f"shaft {number}" for number in range(1, len(self.train.shaft_labels) + 1)]
        return (*shafts, *self.train.mesh_elements, *self.train.body_labels)

    def _arguments(self, duration: float, progress: Array) -> tuple[Any, ...]:
        meshes, shafts, held, states = self._sizes
        torque = np.array(list(self.torque.values()))
        return self._box.handle, torque, duration, progress, meshes, shafts + held, states

    def _take(self, found: tuple[Any, ...]) -> Self:
        self._box.check(found[-1])
        now, self.body_speed, self.displacement, self.mesh_force, torque, self.state, _ = found
        self.time, self.frequency, self.phase = map(float, now)
        self.shaft_torque, self.reaction_torque = np.split(torque, [self._sizes[1]])[:2]
        return self

    @property
    def speed(self) -> float:
        return float(speed_of(self.train, self.frequency) or 0.0)
