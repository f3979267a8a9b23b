"""Which way bodies turn and which gear of a pair drives: speeds and forces at rest of the network."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Link", "forces", "free_motions", "speeds"]

Array = NDArray[np.float64]

#: Singular values below this over the largest are zero: rows are scaled to 1.
_RANK = 1e-9


class Link(NamedTuple):
    """A row: coefficients of the speeds of bodies, about one direction of all axes; their sum is zero."""

    bodies: tuple[int, ...]
    factors: tuple[float, ...]

    @classmethod
    def spring(cls, one: int, other: int) -> Link:
        return cls((one, other), (1.0, -1.0))

    @classmethod
    def mesh(cls, one: int, other: int, teeth: tuple[int, int], internal: bool, carrier: int | None) -> Link:
        first, second = teeth[0] / max(teeth), (-1 if internal else 1) * teeth[1] / max(teeth)
        if carrier is None:
            return cls((one, other), (first, second))
        return cls((one, other, carrier), (first, second, -first - second))


def _rows(links: Sequence[Link], count: int) -> Array:
    rows = np.zeros((len(links), count))
    for row, link in zip(rows, links):
        np.add.at(row, list(link.bodies), link.factors)
    return rows


def free_motions(links: Sequence[Link], count: int, held: Sequence[int]) -> Array:
    """Independent motions that no link hinders, (motions, bodies)."""
    rows = np.vstack([_rows(links, count), np.eye(count)[list(held)]])
    _, sizes, basis = np.linalg.svd(rows, full_matrices=True)
    rank = int(np.sum(sizes > _RANK * sizes[0])) if len(sizes) else 0
    return basis[rank:]


def speeds(motions: Array, given: dict[int, float]) -> Array | None:
    """Speeds of all bodies from those of some; None where they contradict each other."""
    if not given or not len(motions):
        return np.zeros(motions.shape[1])
    places, wanted = list(given), np.array(list(given.values()))
    amounts, *_ = np.linalg.lstsq(motions[:, places].T, wanted, rcond=None)
    found: Array = amounts @ motions
    far = np.abs(found[places] - wanted).max() > 1e-3 * max(np.abs(wanted).max(), 1e-12)
    return None if far else found


def forces(links: Sequence[Link], torques: Array, balancing: Sequence[int], held: Sequence[int]) -> Array:
    """Force of each link at rest; the bodies ``balancing`` and ``held`` take what torques it needs."""
    count = len(torques)
    free = np.eye(count)[:, [*balancing, *held]]
    found, *_ = np.linalg.lstsq(np.hstack([_rows(links, count).T, -free]), torques, rcond=None)
    return np.asarray(found[: len(links)])
