"""Which jump of one train is which of the next: the identity of jumps over the points of a study.

Points are visited outwards from the middle of the space, each after a near neighbour. A jump is that jump of the neighbour, or the
last one known on the way there, of the same direction and cause whose Lambda and rms are the most alike.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._core.extras import extra

__all__ = ["Identities", "identify"]

Array = NDArray[np.float64]
Places = NDArray[np.intp]

_FARTHEST = 0.25  # unlikeness beyond which two jumps are not one: relative change of Lambda, and of the rms before the jump
_RIVAL = 2.0  # a second jump less than so many times as unlike makes the identity doubtful
_NEIGHBOURS = 24
_CHUNK = 2000  # points that are matched in one go
_ROUNDS = 3  # of matching each jump with the one that is the most alike, both ways


class Identities(NamedTuple):
    """Attributes: ``number``, (points, jumps), from 0, -1 where there is no jump; ``followed``, (points, jumps); ``total``."""

    number: Places
    followed: NDArray[np.bool_]
    total: int


def identify(
    parameters: Array, frequency: Array, direction: NDArray[np.str_], cause: NDArray[np.str_], rms: Array
) -> Identities:
    """Number the jumps of all points.

    Parameters
    ----------
    parameters : ndarray, (points, parameters)
    frequency : ndarray, (points, jumps)
        NaN where there is no jump.
    direction, cause : ndarray, (points, jumps)
    rms : ndarray, (points, jumps, meshes)
        Before the jump.
    """
    if not frequency.size:
        return Identities(np.full(frequency.shape, -1), np.zeros(frequency.shape, bool), 0)
    found = _Family(frequency, np.char.add(direction.astype(str), cause.astype(str)), rms)
    for points, parents in _generations(parameters):
        for first in range(0, len(points), _CHUNK):
            found.go_on(points[first : first + _CHUNK], parents[first : first + _CHUNK])
    return found.by_frequency()


class _Family:
    """The jumps of all points, numbered as far as points have been visited.

    A jump is known by its place among all, point by point.
    """

    def __init__(self, frequency: Array, kind: NDArray[np.str_], rms: Array) -> None:
        self.shape = frequency.shape
        self.frequency = np.append(frequency.ravel(), np.nan)  # the last one is none
        self.rms = np.append(rms.reshape(-1, rms.shape[2]), np.full((1, rms.shape[2]), np.nan), axis=0)
        self.kind = np.unique(kind, return_inverse=True)[1].ravel()
        self.number = np.full(frequency.size, -1)
        self.followed = np.zeros(frequency.size, bool)
        self.latest = np.zeros(0, int)  # of each number, anywhere
        self.known = np.full((len(frequency), 8), -1)  # of each number, on the way to each point

    def go_on(self, points: Places, parents: Places) -> None:
        """Number the jumps of points whose parents, -1 for none, have been visited."""
        total = len(self.latest)
        known = np.where(parents[:, np.newaxis] < 0, -1, self.known[parents])
        own = points[:, np.newaxis] * self.shape[1] + np.arange(self.shape[1])
        if total:
            table = self._unlike(own[:, :, np.newaxis], known[:, np.newaxis, :total])
            number, sure = _matched(table)
            self.number[own], self.followed[own] = number, sure
        self.followed[own[parents < 0]] = True
        for row, place in zip(*np.nonzero(~np.isnan(self.frequency[own]) & (self.number[own] < 0))):
            self.number[own[row, place]] = self._of_elsewhere(own[row], own[row, place], known[row])
        if len(self.latest) > known.shape[1]:
            wider = max(len(self.latest), 2 * known.shape[1])
            known, self.known = (
                np.pad(array, ((0, 0), (0, wider - array.shape[1])), constant_values=-1) for array in (known, self.known)
            )
        rows, places = np.nonzero(self.number[own] >= 0)
        jumps = own[rows, places]
        known[rows, self.number[jumps]] = jumps
        self.known[points] = known
        self.latest[self.number[jumps]] = jumps

    def _unlike(self, jumps: Places, others: Places) -> Array:
        """0: equal; a number about the relative change; infinite beyond what may be one jump, or where there is none."""
        one, other = self.rms[jumps], self.rms[others]
        size = (one + other).sum(axis=-1)
        change = np.abs(one - other).sum(axis=-1) / np.where(size > 0, size, 1)
        frequency, another = self.frequency[jumps], self.frequency[others]
        unlike = np.abs(frequency - another) / np.maximum(frequency, another) + change
        return np.where((self.kind[jumps] == self.kind[others]) & (unlike < _FARTHEST), unlike, np.inf)

    def _of_elsewhere(self, own: Places, jump: int, known: Places) -> int:
        """The number of a jump that is not known on the way to its point: one that begins elsewhere, or a new one."""
        table = self._unlike(np.array(jump), self.latest)
        taken = self.number[own]
        table[taken[taken >= 0]] = np.inf
        table[np.flatnonzero(known >= 0)] = np.inf
        if not np.isfinite(table).any():
            self.latest = np.append(self.latest, jump)
            return len(self.latest) - 1
        return int(table.argmin())

    def by_frequency(self) -> Identities:
        """Numbered by the median of their Lambda."""
        total = len(self.latest)
        medians = [np.median(self.frequency[:-1][self.number == number]) for number in range(total)]
        renamed = np.full(total + 1, -1)
        renamed[np.argsort(medians, kind="stable")] = np.arange(total)
        there = self.number >= 0
        return Identities(renamed[self.number].reshape(self.shape), (self.followed & there).reshape(self.shape), total)


def _matched(table: Array) -> tuple[Places, NDArray[np.bool_]]:
    """Of unlikenesses (points, jumps, numbers) the number of each jump, -1 for none, and whether it has no rival."""
    left, number = table.copy(), np.full(table.shape[:2], -1)
    rows, jumps = np.ogrid[: table.shape[0], : table.shape[1]]
    for _ in range(_ROUNDS):
        nearest = left.argmin(axis=2)
        mutual = np.take_along_axis(left.argmin(axis=1), nearest, 1) == jumps
        mutual &= np.isfinite(left[rows, jumps, nearest])
        number[mutual] = nearest[mutual]
        row, jump = np.nonzero(mutual)
        left[row, jump, :] = left[row, :, nearest[mutual]] = np.inf
    value = table[rows, jumps, np.maximum(number, 0)]
    rivals = table.copy()
    rivals[rows, jumps, np.maximum(number, 0)] = np.inf
    of_others = np.take_along_axis(rivals.min(axis=1), np.maximum(number, 0), 1)
    return number, (number >= 0) & (np.minimum(rivals.min(axis=2), of_others) >= _RIVAL * value)


def _generations(parameters: Array) -> list[tuple[Places, Places]]:
    """The points, after their neighbours nearer to the middle, and those; the first has none, -1."""
    if not len(parameters):
        return []
    spread = parameters.std(axis=0)
    places = (parameters - parameters.mean(axis=0)) / np.where(spread > 0, spread, 1)
    order = np.argsort((places**2).sum(axis=1), kind="stable")
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    tree: Any = extra("scipy.spatial").cKDTree(places)
    near = tree.query(places, min(_NEIGHBOURS, len(order)))[1].reshape(len(order), -1)
    before = rank[near] < rank[:, np.newaxis]
    parent = np.where(before.any(axis=1), near[np.arange(len(order)), before.argmax(axis=1)], order[0])
    parent[order[0]] = -1
    depth = np.zeros(len(order), int)
    for point in order[1:].tolist():
        depth[point] = depth[parent[point]] + 1
    return [(points, parent[points]) for level in range(depth.max() + 1) for points in [order[depth[order] == level]]]
