"""The part of a gearbox that carries its loads: bodies, springs and gear pairs, with their names."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .rexs_file import Component
from .rexs_gears import Gear, Pair, read_pairs
from .rexs_network import HOUSING, Body, Spring, build, middle_of
from .rexs_shaft import Piece, Rotor, density_of
from .rexs_source import Source
from .rexs_statics import Link

__all__ = ["Machine", "rims"]

_MOST_BODIES = 1000
#: Longest name of a body in a case [bytes], with room for the planet of a set.
_LONGEST = 50


class Machine:
    """The part of a gearbox that carries its loads: bodies, springs and pairs, with their names.

    Attributes
    ----------
    source : Source
    network : Network
    pairs : list of Pair
    links : list of Link
        Of the springs, then of the pairs.
    kept : list of int
        The bodies that are kept; the housing only where something holds to it.
    sense : ndarray
        Of every body: its axis along the common direction, 1 or -1.
    names : list of str
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.network = build(source)
        self.pairs = read_pairs(source, self._distance)
        source.check()
        if len(self.network.bodies) > _MOST_BODIES:
            source.refuse(f"{len(self.network.bodies)} bodies: at most {_MOST_BODIES} are read")
        self.sense = self._senses()
        for pair in self.pairs:
            self._look_along(pair)
        self.springs: list[Spring] = self.network.springs
        self.links = [Link.spring(*spring.bodies) for spring in self.springs] + [self._link(pair) for pair in self.pairs]
        self.kept = self._keep()
        self.names = self._names()

    def bodies_of(self, pair: Pair) -> tuple[int, int]:
        one, other = (self.network.gears[gear.component.number] for gear in pair.gears)
        return one, other

    def carrier_of(self, pair: Pair) -> int | None:
        """Body of the carrier on which a gear of a pair rides."""
        stages = {self.network.planets[body] for body in self.bodies_of(pair) if body in self.network.planets}
        return self.network.carriers[min(stages)] if stages else None

    def _link(self, pair: Pair) -> Link:
        teeth = pair.gears[0].teeth, pair.gears[1].teeth
        return Link.mesh(*self.bodies_of(pair), teeth, pair.internal, self.carrier_of(pair))

    def _distance(self, one: Component, other: Component) -> float | None:
        """Distance of the axes of two gears by the positions of their shafts [m]."""
        rotors = [self.rotor(gear) for gear in (one, other)]
        if any(rotor is None or rotor.axis is None or rotor.origin is None for rotor in rotors):
            return None
        apart = rotors[1].origin - rotors[0].origin  # type: ignore[union-attr, operator]
        return float(np.linalg.norm(np.cross(apart, rotors[0].axis)))  # type: ignore[union-attr, arg-type]

    def _look_along(self, pair: Pair) -> None:
        """Say where the faces of two gears do not overlap, by the positions of their shafts."""
        ends = []
        for gear in pair.gears:
            rotor = self.rotor(gear.component)
            if rotor is None or rotor.axis is None or rotor.origin is None or gear.width is None:
                return
            sense = self.sense[self.network.gears[gear.component.number]]
            middle = sense * (rotor.origin @ rotor.axis + middle_of(self.source, gear.component, rotor))
            ends.append((middle - gear.width / 2, middle + gear.width / 2))
        (first, last), (begin, end) = ends
        if min(last, end) < max(first, begin):
            apart = 1e3 * (max(first, begin) - min(last, end))
            self.source.note("assumed", f"its gears mesh, although their faces are {apart:.4g} mm apart along the axes", pair.stage)

    def rotor(self, gear: Component) -> Rotor | None:
        """The shaft of a gear."""
        body = self.network.gears.get(gear.number)
        return None if body is None else self.network.bodies[body].axis

    def _senses(self) -> NDArray[np.float64]:
        """Sense of every body about the direction of the first axis; axes that are not parallel are refused."""
        axes = [body.axis.axis if body.axis else None for body in self.network.bodies]
        known = [axis for axis in axes if axis is not None]
        found = np.ones(len(axes))
        for place, axis in enumerate(axes):
            along = 1.0 if axis is None else float(axis @ known[0])
            if abs(along) < 1 - 1e-6:
                rotor = self.network.bodies[place].axis
                self.source.refuse(f"the axis of {rotor.component if rotor else place} is not parallel to the others: only "
                                   f"cylindrical and planetary stages are read")
            found[place] = math.copysign(1.0, along)
        return found

    def _keep(self) -> list[int]:
        """Bodies that are joined to a load: of several parts that with most meshes."""
        bodies, count = self.network.bodies, len(self.network.bodies)
        label = np.arange(count)
        for link in self.links:
            free = [body for body in link.bodies if not bodies[body].held]
            for body in free[1:]:
                label[label == label[body]] = label[free[0]]
        parts = {label[place] for place, body in enumerate(bodies) if body.loads and not body.held}
        meshes = {part: sum(label[self._free(pair)] == part for pair in self.pairs) for part in parts}
        if not any(meshes.values()):
            self.source.refuse("no gear pair is joined to an external load that transmits torque (external_load, transmits_torque)")
        part = max(sorted(parts), key=lambda one: meshes[one])
        kept = [place for place in range(count) if label[place] == part and not bodies[place].held]
        self._drop(kept)
        held = [place for place, body in enumerate(bodies) if body.held and any(place in link.bodies for link in self.links)]
        return [*kept, *held]

    def along(self, first: int) -> list[int]:
        """The bodies that are kept, from one of them on by the number of springs and meshes between."""
        found, kept = [first], set(self.kept)
        for body in found:
            near = {other for link in self.links if body in link.bodies for other in link.bodies}
            found += sorted(near & kept - set(found))
        return [*found, *(body for body in self.kept if body not in found)]

    def _free(self, pair: Pair) -> int:
        return next((body for body in self.bodies_of(pair) if not self.network.bodies[body].held), self.bodies_of(pair)[0])

    def _drop(self, kept: list[int]) -> None:
        """Leave out springs and pairs of other parts."""
        inside = set(kept)
        left = [pair for pair in self.pairs if self._free(pair) not in inside]
        for pair in left:
            self.source.note("not used", "no load is joined to it", pair.stage)
        self.pairs = [pair for pair in self.pairs if self._free(pair) in inside]
        self.springs = [spring for spring in self.springs if inside & set(spring.bodies)]
        self.links = [Link.spring(*spring.bodies) for spring in self.springs] + [self._link(pair) for pair in self.pairs]

    def _names(self) -> list[str]:
        """Names of bodies: of their only gear, of their load, of their shaft."""
        gears: dict[int, list[Component]] = {}
        for pair in self.pairs:
            for gear, body in zip(pair.gears, self.bodies_of(pair)):
                if gear.component not in gears.setdefault(body, []):
                    gears[body].append(gear.component)
        carriers = {body: self.source.file.components[stage] for stage, body in self.network.carriers.items()}
        taken: set[str] = set()
        found = []
        for place, part in enumerate(self.network.bodies):
            of = gears.get(place, [])
            if part.held:
                name = HOUSING
            elif len(of) == 1:
                name = str(of[0])
            elif place in carriers:
                name = f"carrier of {carriers[place]}"
            elif part.loads:
                name = str(part.loads[0])
            else:
                name = str(part.axis.component) if part.axis else f"body {place + 1}"
            found.append(_unique(name, taken))
        return found


def _unique(name: str, taken: set[str]) -> str:
    """A name that no other body has, not longer than a case takes."""
    plain = " ".join(name.split()).encode()[:_LONGEST].decode(errors="ignore") or "body"
    found, number = plain, 1
    while found.lower() in taken:
        number += 1
        found = f"{plain.encode()[:_LONGEST - 4].decode(errors='ignore')} ({number})"
    taken.add(found.lower())
    return found


def rims(machine: Machine, place: int) -> list[Piece]:
    """The gears of a body as discs of their reference diameters outside of the shaft, a ring inside of its shaft."""
    found: dict[int, Piece] = {}
    for pair in machine.pairs:
        for gear, body in zip(pair.gears, machine.bodies_of(pair)):
            if body == place and gear.component.number not in found:
                piece = _rim(machine, gear, machine.network.bodies[body])
                if piece is not None:
                    found[gear.component.number] = piece
    return list(found.values())


def _rim(machine: Machine, gear: Gear, body: Body) -> Piece | None:
    source, rotor = machine.source, body.axis
    width = gear.width if gear.width is not None else next(
        (pair.width.value for pair in machine.pairs if gear in pair.gears and pair.width), None)
    if width is None or rotor is None:
        return None
    at = rotor.diameters(middle_of(source, gear.component, rotor)) or (0.0, 0.0)
    density = density_of(source, gear.component)
    if gear.internal:
        if at[1] <= gear.reference:
            return None
        return Piece(at[1], gear.reference, width, density, str(gear.component))
    if at[0] >= gear.reference:
        source.note("assumed", "the shaft is thicker than its reference circle; it counts alone", gear.component)
        return None
    return Piece(gear.reference, at[0], width, density, str(gear.component))
