"""Which jump of one train is which of the next: the identity of jumps over the points of a study.

Points are visited outwards from the middle of the space, each after a near neighbour. A jump is that jump of the neighbour, or the
last one known on the way there, of the same direction and cause whose Lambda and rms are the most alike.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._extras import extra

__all__ = ["Identities", "identify"]

Array = NDArray[np.float64]

_FARTHEST = 0.25  # unlikeness beyond which two jumps are not one: relative change of Lambda, and of the rms before the jump
_RIVAL = 2.0  # a second jump less than so many times as unlike makes the identity doubtful
_NEIGHBOURS = 24


class Identities(NamedTuple):
    """Attributes: ``number``, (points, jumps), from 0, -1 where there is no jump; ``followed``, (points, jumps); ``total``."""

    number: NDArray[np.intp]
    followed: NDArray[np.bool_]
    total: int


class _Jump(NamedTuple):
    kind: tuple[str, str]
    frequency: float
    rms: tuple[float, ...]

    def unlike(self, other: _Jump) -> float:
        """0: equal; a number about the relative change."""
        if self.kind != other.kind:
            return np.inf
        size = sum(self.rms) + sum(other.rms)
        change = sum(abs(one - two) for one, two in zip(self.rms, other.rms)) / size if size else 0.0
        return abs(self.frequency - other.frequency) / max(self.frequency, other.frequency) + change


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
    there = ~np.isnan(frequency)
    number = np.full(frequency.shape, -1)
    followed = np.zeros(frequency.shape, bool)
    columns = [array.tolist() for array in (direction, cause, frequency, np.nan_to_num(rms), there)]
    jumps = [
        {place: _Jump((way, why), at, tuple(before)) for place, (way, why, at, before, known) in enumerate(zip(*row)) if known}
        for row in zip(*columns)
    ]
    latest: dict[int, _Jump] = {}
    states: dict[int, dict[int, _Jump]] = {}
    for point, parent in _walk(parameters):
        known = states.get(parent, {})
        found = _matched(jumps[point], known)
        for place, jump in jumps[point].items():
            which, sure = found.get(place, (-1, parent < 0))
            if which < 0:  # not known on the way here: perhaps one that begins elsewhere
                taken = {item for item, _ in found.values()}
                elsewhere = {key: other for key, other in latest.items() if key not in taken and key not in known}
                which = _matched({place: jump}, elsewhere).get(place, (len(latest), False))[0]
                found[place] = which, sure
            number[point, place], followed[point, place] = which, sure
            latest[which] = jump
        states[point] = {**known, **{found[place][0]: jump for place, jump in jumps[point].items()}}
    return _by_frequency(Identities(number, followed, len(latest)), frequency)


def _walk(parameters: Array) -> list[tuple[int, int]]:
    """The points, each with a neighbour that comes before it, -1 for the first."""
    if not len(parameters):
        return []
    spread = parameters.std(axis=0)
    places = (parameters - parameters.mean(axis=0)) / np.where(spread > 0, spread, 1)
    order = np.argsort((places**2).sum(axis=1), kind="stable")
    rank = np.empty(len(order), int)
    rank[order] = np.arange(len(order))
    number = min(_NEIGHBOURS, len(order))
    near = extra("scipy.spatial").cKDTree(places).query(places, number)[1].reshape(len(order), number)
    before = rank[near] < rank[:, np.newaxis]
    parent = np.where(before.any(axis=1), near[np.arange(len(order)), before.argmax(axis=1)], order[0])
    parent[order[0]] = -1
    return list(zip(order.tolist(), parent[order].tolist()))


def _matched(jumps: dict[int, _Jump], known: dict[int, _Jump]) -> dict[int, tuple[int, bool]]:
    """Of jumps by their places the numbers of those that they are, and whether there is no doubt."""
    if not jumps or not known:
        return {}
    places, numbers = list(jumps), list(known)
    table = [[jump.unlike(other) for other in known.values()] for jump in jumps.values()]
    pairs = [(value, row, column) for row, line in enumerate(table) for column, value in enumerate(line) if value < _FARTHEST]
    rows = {row for _, row, _ in pairs}
    if len(pairs) > len(rows) or len({column for _, _, column in pairs}) < len(rows):  # not each with one alone
        costs = np.minimum(np.array(table), 1e3)
        chosen = {*zip(*(indices.tolist() for indices in extra("scipy.optimize").linear_sum_assignment(costs)))}
        pairs = [pair for pair in pairs if pair[1:] in chosen]
    found = {}
    for value, row, column in pairs:
        rivals = [table[row][other] for other in range(len(numbers)) if other != column]
        rivals += [table[other][column] for other in range(len(places)) if other != row]
        found[places[row]] = numbers[column], all(rival >= _RIVAL * value for rival in rivals)
    return found


def _by_frequency(found: Identities, frequency: Array) -> Identities:
    """Numbered by the median of their Lambda."""
    medians = [np.median(frequency[found.number == number]) for number in range(found.total)]
    renamed = np.empty(found.total + 1, int)
    renamed[np.argsort(medians, kind="stable")] = np.arange(found.total)
    renamed[-1] = -1
    return found._replace(number=renamed[found.number])
