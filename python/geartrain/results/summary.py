"""What one reads off a branch."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box, Group
from .._core.description import Description, element_name
from .._core.text_table import Rows
from .._core.units import hertz_of, lambda_of, own_lambda, speed_of
from ..errors import InputError, SolverError, shown
from ..plots.captions import force_unit
from ..plots.draw import check_number

__all__ = ["Jump", "Jumps", "Peak", "Peaks", "Readings", "speeds"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Peak:
    """A local maximum of the rms of a mesh along a branch.

    Attributes
    ----------
    frequency, rms : float
        Lambda and rms, by a parabola through the highest point and its neighbours.
    point : int
        Index of the highest point.
    stable : bool or None
        Of that point; None where stability was not asked for.
    undecided : bool
        Whether ``stable`` is a guess.
    mesh : int
        Number of the mesh, from 1.
    mesh_force_maximum, dynamic_factor : float
        Largest mesh force in N at that point, and over the static mesh force.
    speed, fundamental_frequency : float or None
        In rpm, where every mesh has teeth; in Hz.
    parameter : float or None
        Value of the parameter, on a branch over one; Lambda is constant there.
    """

    frequency: float
    rms: float
    point: int
    stable: bool | None
    undecided: bool = False
    mesh: int = 1
    mesh_force_maximum: float = float("nan")
    dynamic_factor: float = float("nan")
    speed: float | None = None
    fundamental_frequency: float | None = None
    parameter: float | None = None


class Peaks(Rows[Peak]):
    """Peaks of a branch: a list of `Peak` that is printed as a table.

    Attributes
    ----------
    ends : sequence of (Peak, str)
        Where the rms or the force of a mesh is largest at an end of the range, so that there may be more beyond, and which of them:
        rows below the peaks, and no peaks themselves.
    """

    ends: Sequence[tuple[Peak, str]] = ()

    def _table(self) -> Mapping[str, Sequence[Any]]:
        rows = [*self, *(peak for peak, _ in self.ends)]
        mixed = self.train is not None and bool(self.train.couplings or self.train.bearings)
        ends = {"at the end of the range": [*[None] * len(self), *(words for _, words in self.ends)]} if self.ends else {}
        return {
            "mesh": [element_name(self.train, peak.mesh - 1) if mixed else peak.mesh for peak in rows],
            **speeds(rows),
            f"rms of the paper{self.length}": [peak.rms for peak in rows],
            f"largest force [{force_unit(self.train)}]": [peak.mesh_force_maximum for peak in rows],
            "dynamic factor": [peak.dynamic_factor for peak in rows],
            "stable": [peak.stable for peak in rows],
            **ends,
        }


@dataclass(frozen=True, eq=False)
class Jump:
    """Where a sweep in speed jumps: the stable motion that it follows ends there.

    Attributes
    ----------
    frequency : float
        Lambda.
    kind : str
        ``'jump up'`` or ``'jump down'``: to a larger or a smaller amplitude, all meshes together. ``'leaves'``: the branch has no
        other stable motion there, or stability is lost without a fold: the sweep goes on beside the branch, or jumps to one of the
        ``candidates``.
    direction : str
        ``'rising'`` or ``'falling'``: the way in which the speed of the sweep goes that jumps here.
    cause : str
        Kind of the special point at which the stable motion ends.
    before : ndarray, (meshes,)
        rms before the jump.
    after : ndarray, (meshes,)
        rms after it: of the stable motion of the branch with the nearest rms; nan where the jump leaves the branch.
    candidates : int
        Other stable motions of the branch at this frequency. With more than one ``after`` is a guess: a sweep may reach another, or
        a motion of another period; ``train.integrate(start=...)`` tells.
    undecided : bool
        Whether the jump is a guess: the nearest decided points are not stable on one side and unstable on the other, or the motion
        after the jump is undecided, or another stable motion ends within the estimated errors of both folds.
    speed, fundamental_frequency : float or None
        In rpm, where every mesh has teeth; in Hz.
    parameter : float or None
        Value of the parameter, on a branch over one: there not the speed changes in the sweep, but the parameter.
    special_point : SpecialPoint or None
        At which the stable motion ends.
    """

    frequency: float
    kind: str
    direction: str
    cause: str
    before: NDArray[np.float64]
    after: NDArray[np.float64]
    candidates: int
    undecided: bool = False
    speed: float | None = None
    fundamental_frequency: float | None = None
    parameter: float | None = None
    special_point: Any = field(default=None, repr=False)

    def gradient(self, parameters: Sequence[str]) -> Array:
        """Derivatives of Lambda of the jump with respect to parameters of the train, (parameters,): see `SpecialPoint.gradient`.

        Examples
        --------
        >>> branch.jumps[0].gradient(["mesh 1 damping_ratio", "stiffness_variation"]).round(4)
        array([ 0.0115, -0.3316])
        """
        if self.special_point is None:
            raise SolverError(f"gradient: the branch has no {self.cause} at the jump: there are no derivatives")
        found: Array = self.special_point.gradient(parameters)
        return found


class Jumps(Rows[Jump]):
    """Jumps of a branch: a list of `Jump` that is printed as a table."""

    def _table(self) -> Mapping[str, Sequence[Any]]:
        return {
            "sweep": [jump.direction for jump in self],
            **speeds(self),
            "what": [jump.kind for jump in self],
            "cause": [jump.cause for jump in self],
            f"rms of the paper{self.length} before": [jump.before for jump in self],
            "after": [jump.after for jump in self],
            "undecided": [jump.undecided or None for jump in self],
        }


class Readings:
    """What one reads off a branch: its peaks and jumps, and ranges of Lambda, or of the parameter that the branch goes over."""

    rms: Array
    frequency: Array
    parameter: Array | None
    parameter_name: str
    stable: NDArray[np.bool_] | None
    undecided: NDArray[np.bool_] | None
    mesh_force_maximum: Array
    dynamic_factor: Array
    settings: Mapping[str, Any]
    train: Description | None
    special_points: Sequence[Any]

    def _box(self) -> Box:
        """A box of the branch, which may be changed."""
        raise NotImplementedError

    def peaks(self, mesh: int | None = None) -> Peaks:
        """The local maxima of the rms of a mesh, counted from 1, in their order along the branch; of all meshes unless told.

        Examples
        --------
        >>> highest = max(branch.peaks(mesh=2), key=lambda peak: peak.rms)
        >>> round(highest.frequency, 3), round(highest.rms, 3), highest.stable
        (0.731, 3.046, True)
        """
        known = self.stable is not None
        found = self._read_off("peaks", 1 if mesh is None else mesh)
        rows = found.rows(self._free_name, "rms", "point", "stable", "undecided", "mesh")
        peaks = Peaks((
            self._peak(float(f), float(rms), int(point) - 1, bool(stable) if known else None, bool(undecided), int(number))
            for f, rms, point, stable, undecided, number in rows
            if mesh is None or number == mesh
        ), self.train)
        peaks.ends = [end for number in range(1, self.rms.shape[1] + 1) if mesh in {None, number} for end in self._at_ends(number)]
        return peaks

    @property
    def _free_name(self) -> str:
        """Name of the field that the branch goes over."""
        return "parameter" if self.parameter_name else "frequency"

    @property
    def _free(self) -> Array:
        """What the branch goes over, (points,): Lambda, or the values of the parameter."""
        return self.frequency if self.parameter is None else self.parameter

    def _range(self) -> list[float]:
        """The ends of the range asked for, where they are known, in what the branch goes over."""
        ends = [float(self.settings[name]) for name in ("start", "stop") if self.settings.get(name) is not None]
        return ends if self.parameter_name else [lambda_of(self.train, end, self.settings.get("unit")) for end in ends]

    def _peak(self, value: float, rms: float, point: int, stable: bool | None, undecided: bool, mesh: int) -> Peak:
        return Peak(
            self._lambda(value), rms, point, stable, undecided, mesh, float(self.mesh_force_maximum[point, mesh - 1]),
            float(self.dynamic_factor[point, mesh - 1]), *self._speeds(value),
        )

    def _at_ends(self, mesh: int) -> Iterator[tuple[Peak, str]]:
        """The ends of the range at which rms or force of a mesh are largest, the force of stable motions where these are known."""
        if not len(self.frequency):
            return
        force = self.mesh_force_maximum[:, mesh - 1]
        if self.stable is not None and self.stable.any():
            force = np.where(self.stable, force, -np.inf)
        largest = {"rms": int(self.rms[:, mesh - 1].argmax()), "force": int(force.argmax())}
        for point in dict.fromkeys(largest.values()):
            at = float(self._free[point])
            ends = self._range()
            if any(abs(at - end) <= 1e-9 * max(map(abs, ends)) for end in ends):
                words = " and ".join(f"largest {name}" for name, place in largest.items() if place == point)
                stable = None if self.stable is None else bool(self.stable[point])
                undecided = self.undecided is not None and bool(self.undecided[point])
                yield self._peak(at, float(self.rms[point, mesh - 1]), point, stable, undecided, mesh), words

    @cached_property
    def jumps(self) -> Jumps:
        """Where a sweep in speed jumps, by frequency; empty where stability was not asked for.

        Examples
        --------
        >>> for jump in branch.jumps[-4:-2]:
        ...     print(f"{jump.direction}, {jump.frequency:.4f}: {jump.kind}, {jump.before.round(2)} -> {jump.after.round(2)}")
        falling, 1.5473: jump down, [0.85 0.17] -> [0.28 0.11]
        rising, 1.6645: jump up, [0.47 0.12] -> [0.73 0.11]
        """
        names = (self._free_name, "kind", "direction", "cause", "rms_before", "rms_after", "candidates", "undecided")
        return Jumps((
            Jump(self._lambda(float(at)), kind, direction, cause, before, after, int(candidates), bool(undecided),
                 *self._speeds(float(at)), self._special_at(float(at), cause))
            for at, kind, direction, cause, before, after, candidates, undecided in self._read_off("jumps").rows(*names)
        ), self.train)

    @property
    def bands_without_stability(self) -> Array:
        """Ranges of Lambda without a stable motion at any level of this branch: from, to; (bands, 2).

        Examples
        --------
        >>> branch.bands_without_stability.round(4)
        array([[1.7492, 2.0439]])
        """
        return _ends(self._read_off("bands"))

    @property
    def undecided_bands(self) -> NDArray[np.bool_]:
        """Which of ``bands_without_stability`` are there by the guess of undecided points alone, (bands,)."""
        guessed: NDArray[np.bool_] = self._read_off("bands").column("undecided") == 1
        return guessed

    def separation_ranges(self, mesh: int, stable: bool = False) -> Array:
        """Ranges of Lambda in which the teeth of a mesh, counted from 1, separate at some instant: from, to; (ranges, 2).

        Those of all motions, or of the stable ones alone.

        Examples
        --------
        >>> branch.separation_ranges(mesh=2).round(3)
        array([[0.459, 0.495],
               [0.566, 1.103]])
        """
        return self._ranges("separation", mesh, stable)

    def back_collision_ranges(self, mesh: int, stable: bool = False) -> Array:
        """Ranges of Lambda in which the back flanks of a mesh collide at some instant, as in `separation_ranges`.

        Examples
        --------
        >>> branch.back_collision_ranges(mesh=2).round(3)
        array([[0.566, 0.732]])
        """
        return self._ranges("back collision", mesh, stable)

    def _special_at(self, value: float, kind: str) -> Any:
        """The special point of a kind at a value of what the branch goes over; None where there is none."""
        places = ((special.frequency if special.parameter is None else special.parameter, special)
                  for special in self.special_points if special.kind == kind)
        return next((special for at, special in places if abs(at - value) <= 1e-9 * abs(value)), None)

    def _lambda(self, value: float) -> float:
        """Lambda at a value of what the branch goes over."""
        return float(self.frequency[0]) if self.parameter_name else value

    def _speeds(self, value: float) -> tuple[float | None, float | None, float | None]:
        """Speed, frequency of the fundamental and parameter at a value of what the branch goes over."""
        at = self._lambda(value)
        return speed_of(self.train, at), hertz_of(self.train, at), value if self.parameter_name else None

    def _read_off(self, what: str, mesh: int = 1) -> Group:
        check_number("mesh", mesh, self.rms.shape[1])
        if what not in self._lists:
            with self._box() as box:
                self._lists[what] = box.read_off(what)
        return self._lists[what]

    @cached_property
    def _lists(self) -> dict[str, Group]:
        """Lists of all meshes that were read off so far: ranges take a search for each end, and pages ask mesh by mesh."""
        return {}

    def _ranges(self, what: str, mesh: int, stable: bool) -> Array:
        check_number("mesh", mesh, self.rms.shape[1])
        if not isinstance(stable, (bool, np.bool_)):
            raise InputError(f"stable = {shown(stable)}: must be True, of the stable motions alone, or False, of all")
        if stable and self.stable is None:
            raise InputError("stable = True: the stability of this branch was not asked for")
        found = self._read_off(what)
        ends: Array = _ends(found)[(found.column("mesh") == mesh) & (found.column("stable") == stable)]
        return ends


def speeds(rows: Iterable[Any]) -> dict[str, list[float | None]]:
    """The columns of a table that tell at which speed, and at which value of a parameter, its rows are."""
    rows = list(rows)
    values = [getattr(row, "parameter", None) for row in rows]
    return {
        **({"parameter": values} if any(value is not None for value in values) else {}),
        "speed [rpm]": [row.speed for row in rows],
        "fundamental [Hz]": [row.fundamental_frequency for row in rows],
        "Lambda": [own_lambda(row.frequency, row.speed) for row in rows],
    }


def _ends(ranges: Group) -> Array:
    """From, to; (ranges, 2)."""
    return np.stack([ranges.column("from"), ranges.column("to")], axis=1)
