"""Orders by name: what a line of a spectrum comes from."""

from __future__ import annotations

from itertools import permutations

from .description import Description

__all__ = ["named_orders"]

_MULTIPLES, _SUMS = 8, 5  # largest multiple of a mesh order; largest of both multiples of a sum or difference


def named_orders(train: Description) -> dict[float, str]:
    """Names of orders, in multiples of the fundamental: of the meshes, their multiples, sums and differences, and of revolutions.

    Empty where all meshes have the order 1 and the speed is not known: each order is a multiple of the fundamental then.
    """
    meshes: dict[int, str] = {}
    for number, order in enumerate(map(int, train._outline["order"]), 1):
        meshes[order] = f"{meshes[order]}, {number}" if order in meshes else f"mesh {number}"
    if meshes.keys() == {1} and not train._outline["speed"]:
        return {}
    multiples = [(times, base, name if times == 1 else f"{times} x {name}") for base, name in meshes.items()
                 for times in range(1, _MULTIPLES + 1)]
    known = [(times, times * base, name) for times, base, name in multiples]
    for (times, base, name), (others, other, second) in permutations(multiples, 2):
        if base != other and times + others <= _SUMS:
            known.append((times + others, times * base - others * other, f"{name} - {second}"))
            if base > other:
                known.append((times + others, times * base + others * other, f"{name} + {second}"))
    # Of two names of an order the simpler one comes last, and stays.
    named = {float(order): name for _, order, name in sorted(known, reverse=True) if order > 0}
    numbers = train.explain()
    bodies: dict[float, str] = {}
    for body in train.body_labels:
        turns = numbers["train"].get("speed_ratio", 0.0) * numbers.get(body, {}).get("turns", 0.0)
        if turns and turns not in meshes:
            bodies[turns] = f"{bodies[turns]}, {body}" if turns in bodies else body
    return {**named, **bodies}
