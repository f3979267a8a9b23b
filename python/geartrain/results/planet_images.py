"""Images of a motion: the motions that a turn of the planets of a symmetric set, or an exchange of equal planets, makes of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .motion import Motion
from .motion_check import VALUES
from .orbit import same_orbit

__all__ = ["PlanetImages"]


@dataclass
class _Exchange:
    """Mesh j of the image moves as mesh source[j] of the motion did, by a shift earlier [rad of Lambda]."""

    source: NDArray[np.intp]
    shift: float

    def of(self, motion: Motion) -> Motion:
        """The image of a motion, without its state and multipliers."""
        coefficients = motion.coefficients[self.source]
        angle = self.shift / motion.period * np.arange(1, (coefficients.shape[1] + 1) // 2)
        cosine, sine = coefficients[:, 1::2].copy(), coefficients[:, 2::2].copy()
        coefficients[:, 1::2] = cosine * np.cos(angle) - sine * np.sin(angle)
        coefficients[:, 2::2] = sine * np.cos(angle) + cosine * np.sin(angle)
        values = {name: getattr(motion, name)[self.source] for name in VALUES if name != "coefficients"}
        return replace(motion, **{**values, "coefficients": coefficients, "state": None, "multipliers": None})


class PlanetImages:
    """The exchanges of planets that leave a train as it is."""

    def __init__(self, train: Any) -> None:
        with train._ask() as box:
            group = box.show("symmetries")["/symmetries"]
            shift = np.atleast_1d(group.column("shift")).astype(float)
            columns = (np.asarray(group.column(name), int) for name in ("planet", "kind"))
            planet, kind = (column.reshape(len(shift), column.size // max(1, len(shift))) for column in columns)
        self._turns = [_turn(one, other, by) for one, other, by in zip(planet, kind, shift, strict=True)]
        # Planets in phase: any two may change places.
        self._swaps = [_swap(one, other, a, b) for one, other, by in zip(planet, kind, shift, strict=True) if abs(by) == 0
                       for b in range(2, one.max() + 1) for a in range(1, b)]
        self._planets = planet

    def of(self, motion: Motion) -> Iterator[Motion]:
        """Each image once that is another motion."""
        known = [motion]
        for one in known:
            for exchange in (*self._turns, *self._swaps):
                image = exchange.of(one)
                if not any(same_orbit(image, other) for other in known):
                    known.append(image)
                    yield image

    def repeats(self, motion: Motion, mesh: int) -> bool:
        """Whether a mesh, from 1, does in a motion what the mesh of a planet before it does."""
        for planets, turn in zip(self._planets, self._turns, strict=True):
            if planets[mesh - 1] > 1 and same_orbit(turn.of(motion), motion):
                return True
        return any(swap.source[mesh - 1] < mesh - 1 and same_orbit(swap.of(motion), motion) for swap in self._swaps)


def _turn(planet: NDArray[np.int_], kind: NDArray[np.int_], shift: float) -> _Exchange:
    """The turn by which each planet takes the place of the one before it."""
    last = planet.max()
    return _exchange(planet, kind, {number: (number - 2) % last + 1 for number in range(1, last + 1)}, shift)


def _swap(planet: NDArray[np.int_], kind: NDArray[np.int_], one: int, other: int) -> _Exchange:
    return _exchange(planet, kind, {one: other, other: one}, 0.0)


def _exchange(planet: NDArray[np.int_], kind: NDArray[np.int_], source: dict[int, int], shift: float) -> _Exchange:
    """The exchange by which planet n moves as planet source[n] did."""
    meshes = np.arange(len(planet))
    for mesh in np.flatnonzero(planet > 0):
        from_planet = source.get(int(planet[mesh]), int(planet[mesh]))
        meshes[mesh] = np.flatnonzero((planet == from_planet) & (kind == kind[mesh]))[0]
    return _Exchange(meshes, shift)
