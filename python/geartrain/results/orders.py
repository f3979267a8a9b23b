"""Orders by name: what a line of a spectrum comes from."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from itertools import permutations, product

from .._core.description import Description
from ..errors import InputError, shown
from .campbell import exciting_orders
from .excitation import gear_names

__all__ = ["named_orders", "names_of_causes", "orders_of", "owners_of"]

_MULTIPLES, _SUMS = 8, 5  # largest multiple of a mesh order; largest of both multiples of a sum or difference that has a name
_FAR_SUMS = 20  # and of one that explains a line of a spectrum better than a sideband far from its mesh order
_SIDEBANDS = 3  # sidebands on either side that have names


def named_orders(train: Description) -> dict[float, str]:
    """Names of orders, in multiples of the fundamental: of meshes, multiples, sums, differences, sidebands, and of revolutions.

    Empty where all meshes have the order 1 and the speed is not known: each order is a multiple of the fundamental then.
    """
    named: dict[float, str] = {}
    for order, name in _all_names(train):
        named.setdefault(order, name)
    return named


def names_of_causes(train: Description) -> dict[float, str]:
    """Names of `named_orders` and of what excites: a torque or a gear whose revolutions excite comes before bodies that turn as
    often."""
    exciting = {float(cause.order): cause.name.replace("revolution of ", "") for cause in exciting_orders(train)}
    meshes = mesh_orders(train).values()
    revolving = {float(cause.order): exciting[float(cause.order)] for cause in exciting_orders(train)
                 if "revolution of" in cause.name and cause.order not in meshes}
    return {**exciting, **named_orders(train), **revolving}


def mesh_orders(train: Description) -> dict[int, int]:
    """Orders of the meshes by their numbers; without meshes whose gears turn as one."""
    numbers = train.explain()
    orders = {number: int(numbers[f"mesh {number}"]["order"]) for number in range(1, len(train.meshes) + 1)}
    return {number: order for number, order in orders.items() if order}


def _all_names(train: Description) -> list[tuple[float, str]]:
    """Orders and their names; of several names of an order a body comes first, then multiples of a mesh, then the simplest."""
    meshes: dict[int, str] = {}
    for number, order in mesh_orders(train).items():
        meshes[order] = f"{meshes[order]}, {number}" if order in meshes else f"mesh {number}"
    if meshes.keys() == {1} and not train._outline["speed"]:
        return []
    known = [(0, times * base, _times(times, name)) for base, name in meshes.items() for times in range(1, _MULTIPLES + 1)]
    known += _sums(meshes, _SUMS)
    for number, gear, mesh, turn in gears_with_errors(train):
        for times, far, side in product(range(1, _MULTIPLES + 1), range(1, _SIDEBANDS + 1), (1, -1)):
            name = f"{times} x mesh {number} {'+' if side > 0 else '-'} {far} x {gear}"
            known.append((times + far + 1, times * mesh + side * far * turn, name))
    numbers = train.explain()
    bodies: dict[float, str] = {}
    for body in train.body_labels:
        turns = numbers["train"].get("speed_ratio", 0.0) * abs(numbers.get(body, {}).get("turns", 0.0))
        if turns and turns not in meshes:
            bodies[turns] = f"{bodies[turns]}, {body}" if turns in bodies else body
    return [*bodies.items(), *((float(order), name) for _, order, name in sorted(known) if order > 0)]


def _sums(meshes: dict[int, str], most: int) -> list[tuple[int, int, str]]:
    """Sums and differences of multiples of two mesh orders: both multiples together, order and name."""
    found = []
    for (base, name), (other, second) in permutations(meshes.items(), 2):
        for times, others in product(range(1, most), repeat=2):
            if times + others <= most:
                words = _times(times, name), _times(others, second)
                found.append((times + others, times * base - others * other, " - ".join(words)))
                if base > other:
                    found.append((times + others, times * base + others * other, " + ".join(words)))
    return found


def _times(times: int, name: str) -> str:
    return name if times == 1 else f"{times} x {name}"


def gears_with_errors(train: Description) -> list[tuple[int, str, int, int]]:
    """Number of the mesh, name of the gear, orders of the mesh and of the revolution of the gear, of gears with errors."""
    numbers = train.explain()
    found = []
    for number in range(1, len(train.meshes) + 1):
        about = numbers[f"mesh {number}"]
        for name, which in zip(gear_names(train, number), ("driving", "driven"), strict=True):
            if f"{which}_revolution_order" in about:
                found.append((number, name, int(about["order"]), int(about[f"{which}_revolution_order"])))
    return found


def owners_of(train: Description, orders: Iterable[float], names: dict[float, str]) -> list[str]:
    """What each order comes from: its name, or what takes the fewest multiples; ``''`` where nothing is known."""
    gears, meshes = gears_with_errors(train), mesh_orders(train)
    exact = {round(order, 6): name for order, name in names.items()}
    sums: dict[int, tuple[float, str]] = {}
    for count, order, name in _sums({order: f"mesh {number}" for number, order in reversed(meshes.items())}, _FAR_SUMS):
        sums[order] = min(sums.get(order, (count, name)), (count, name))

    def owner(order: float) -> str:
        found = [(order / mesh, f"{order / mesh:.0f} x mesh {number}") for number, mesh in meshes.items() if not order % mesh]
        found += [sums[int(order)]] if order.is_integer() and int(order) in sums else []
        for number, gear, mesh, turn in gears:
            times = round(order / mesh)
            far = (order - times * mesh) / turn
            if abs(far - round(far)) < 1e-6:
                turns = f"{abs(round(far))} x {gear}"
                name = f"{times} x mesh {number} {'+' if far > 0 else '-'} {turns}" if times else turns
                found.append((times + abs(far) + 1, name))
        return min(found)[1] if found else ""

    return [exact.get(round(float(order), 6)) or owner(float(order)) for order in orders]


def orders_of(train: Description | None, orders: Iterable[float | str] | None) -> dict[float, str]:
    """Orders with what to call them: numbers are multiples of the fundamental, names are as `names_of_causes` has them.

    None: the orders of the meshes and their doubles. An order without a name is called by its owner, or by its number.
    """
    if orders is None:
        meshes = [] if train is None else list(map(float, train._outline["order"]))
        return _called(train, sorted({*meshes, *(2 * order for order in meshes)}))
    every = [] if train is None else [*names_of_causes(train).items(), *_all_names(train)]
    known = {single: order for order, name in every for single in _singly(name)}
    known = {**{name.removeprefix("1 x "): order for name, order in known.items()}, **known}
    found = []
    for order in orders:
        if isinstance(order, str) and order not in known:
            near = difflib.get_close_matches(order, known, 1)
            hint = f" (did you mean {near[0]!r}?)" if near else ""
            such = f" or a name such as {', '.join(map(repr, sorted(known, key=len)[:3]))}" if known else ""
            raise InputError(f"orders: {shown(order)} is no order of this train{hint}: must be a multiple of the fundamental{such}")
        found.append(known[order] if isinstance(order, str) else float(order))
    return _called(train, found)


def _called(train: Description | None, orders: list[float]) -> dict[float, str]:
    owners = [""] * len(orders) if train is None else owners_of(train, orders, names_of_causes(train))
    return {order: owner or f"{order:.4g}" for order, owner in zip(orders, owners, strict=True)}


def _singly(name: str) -> list[str]:
    """``'engine, input'``: both names of the order; ``'mesh 1, 2'``: mesh 1 and mesh 2."""
    first, *others = name.split(", ") if " - " not in name and " + " not in name else [name]
    return [first, *(first[:first.rindex(" ") + 1] + other if other.isdigit() else other for other in others)]
