"""Planetary stages of a REXS file: sets of equal planets with a sun, a ring or both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .rexs_file import Component
from .rexs_gears import STEEL, Entry, Gear, Pair
from .rexs_loads import Loads
from .rexs_machine import Machine, rims

__all__ = ["Stage", "add_planets", "find_stages"]


@dataclass(frozen=True)
class Stage:
    """A planetary set: its component, the bodies of its planets and its carrier, what it is given by."""

    component: Component
    planets: list[int]
    carrier: int
    entries: dict[str, Entry]


def find_stages(machine: Machine, loads: Loads) -> list[Stage]:
    """The planetary stages that are sets; the meshes of others stand for themselves."""
    found = []
    for number, carrier in machine.network.carriers.items():
        planets = [body for body, stage in machine.network.planets.items() if stage == number and body in set(machine.kept)]
        if not planets:
            continue
        component = machine.source.file.components[number]
        stage = _set_of(machine, loads, component, planets, carrier)
        if stage is None:
            machine.source.note("assumed", "no set of equal planets with one gear each; its meshes stand for themselves", component)
        else:
            found.append(stage)
    return found


def _set_of(machine: Machine, loads: Loads, component: Component, planets: list[int], carrier: int) -> Stage | None:
    """The set that a stage is; None where its planets are not equal, or mesh with others than a sun and a ring."""
    pairs = [[pair for pair in machine.pairs if body in machine.bodies_of(pair)] for body in planets]
    suns = [[pair for pair in row if not pair.internal] for row in pairs]
    rings = [[pair for pair in row if pair.internal] for row in pairs]
    if len(planets) < 2 or ({len(row) for row in suns} - {1} and {len(row) for row in suns} - {0}):
        return None
    if {len(row) for row in rings} not in ({0}, {1}) or {len(row) for row in suns} not in ({0}, {1}):
        return None
    sun, ring = suns[0][0] if suns[0] else None, rings[0][0] if rings[0] else None
    gears = _Gears.of(machine, sun, ring, planets[0])
    if gears is None or any(_Gears.of(machine, one[0] if one else None, other[0] if other else None, body) != gears.like(body)
                            for one, other, body in zip(suns, rings, planets)):
        return None
    entries = gears.entries(machine, loads, component, planets, carrier, [pair for pair in (sun, ring) if pair])
    return Stage(component, planets, carrier, entries)


@dataclass(frozen=True)
class _Gears:
    """Gears and pairs of one planet: numbers and face widths that all planets of a set share, and the bodies of sun and ring."""

    planet: int
    sun_body: int | None
    ring_body: int | None
    teeth: tuple[int, int, int]
    shifts: tuple[float, float, float]
    widths: tuple[float, ...]

    @classmethod
    def of(cls, machine: Machine, sun: Pair | None, ring: Pair | None, planet: int) -> _Gears | None:
        parts = [_other(machine, pair, planet) if pair else None for pair in (sun, ring)]
        own = [_own(machine, pair, planet) for pair in (sun, ring) if pair]
        if not own or any(gear[0].component != own[0][0].component for gear in own):
            return None
        body = [None if part is None else machine.network.gears[part[0].component.number] for part in parts]
        teeth = [0 if part is None else part[0].teeth for part in parts]
        shift = [0.0 if part is None else part[1] for part in parts]
        return cls(planet, body[0], body[1], (teeth[0], own[0][0].teeth, teeth[1]),
                   (round(shift[0], 9), round(own[0][1], 9), round(shift[1], 9)),
                   tuple(round(pair.width.value, 9) for pair in (sun, ring) if pair and pair.width))

    def like(self, planet: int) -> _Gears:
        return replace(self, planet=planet)

    def entries(
        self, machine: Machine, loads: Loads, component: Component, planets: list[int], carrier: int, pairs: list[Pair]
    ) -> dict[str, Entry]:
        """What the set is given by."""
        names = machine.names
        own, _ = _own(machine, pairs[0], self.planet)
        told = ", ".join(dict.fromkeys(str(gear.component) for pair in pairs for gear in pair.gears))
        first = pairs[0].entries((0, 1))
        turning = loads.speeds[self.sun_body if self.sun_body is not None else self.ring_body or 0] - loads.speeds[carrier]
        angles = _angles(machine, planets, carrier, math.copysign(1.0, turning))
        found = {"name": Entry(_plain(component), "")}
        found |= {"sun": Entry(names[self.sun_body], "")} if self.sun_body is not None else {}
        found |= {"ring": Entry(names[self.ring_body], "")} if self.ring_body is not None else {}
        found["carrier"] = Entry(names[carrier], "")
        found["teeth"] = Entry(list(self.teeth), told)
        found |= {"planets": Entry(len(planets), f"{len(planets)} planet shafts at equal angles")} if angles is None else \
                 {"angles": Entry(angles, "positions of the planet shafts")}
        found["driving"] = Entry("sun" if _sun_drives(machine, loads, pairs, self) else "ring", "torques of the file")
        found |= {name: first[name] for name in ("normal_module", "pressure_angle", "helix_angle", "face_width") if name in first}
        found["profile_shift"] = Entry(list(self.shifts), told)
        if pairs[0].distance is not None:
            found["centre_distance"] = Entry(pairs[0].distance, str(pairs[0].stage))
        tips = _tips(pairs, self)
        found |= {} if tips is None else {"tip_diameter": Entry(tips, told)}
        found["dedendum"] = pairs[0].dedendum
        pieces = [*machine.network.bodies[self.planet].pieces, *rims(machine, self.planet)]
        shafts = ", ".join(dict.fromkeys(piece.source for piece in pieces)) or str(own.component)
        if pieces:
            found["planet_inertia"] = Entry(sum(piece.inertia for piece in pieces), shafts)
            found["planet_mass"] = Entry(sum(piece.mass for piece in pieces), shafts)
        if len(pairs) > 1 and first.get("face_width") and (width := pairs[1].width) and width.value != first["face_width"].value:
            found["ring_face_width"] = width
        if any(pair.moduli for pair in pairs):
            found["elastic_modulus"] = Entry(_moduli(machine, pairs, self.planet), f"materials of {told}")
        plays = [pair.backlash for pair in pairs]
        found["backlash"] = Entry([play.value for play in plays], "; ".join(dict.fromkeys(play.told for play in plays)))
        found["damping_ratio"] = Entry(0.05, "MISSING: REXS has no damping")
        return found


def _other(machine: Machine, pair: Pair, planet: int) -> tuple[Gear, float]:
    place = 1 - machine.bodies_of(pair).index(planet)
    return pair.gears[place], pair.shifts[place]


def _own(machine: Machine, pair: Pair, planet: int) -> tuple[Gear, float]:
    place = machine.bodies_of(pair).index(planet)
    return pair.gears[place], pair.shifts[place]


def _plain(component: Component) -> str:
    return " ".join(str(component).split()).encode()[:44].decode(errors="ignore")


def _sun_drives(machine: Machine, loads: Loads, pairs: list[Pair], gears: _Gears) -> bool:
    """Whether the sun drives the planets, seen from the carrier; without a sun the ring does not either way count."""
    pair = pairs[0]
    first = machine.bodies_of(pair)[0] != gears.planet
    gives = loads.power(machine, pair) * (1 if first else -1) >= 0
    return gives if gears.sun_body is not None else not gives


def _tips(pairs: list[Pair], gears: _Gears) -> list[float] | None:
    """Tip diameters of sun, planet and ring; None where one is missing."""
    known = {gear.component.number: tip for pair in pairs if pair.tips for gear, tip in zip(pair.gears, pair.tips)}
    if len(pairs) < 2 or len(known) < 3:
        return None
    sun = next(gear for gear in pairs[0].gears if gear.component not in [one.component for one in pairs[1].gears])
    ring = next(gear for gear in pairs[1].gears if gear.internal)
    own = next(gear for gear in pairs[1].gears if not gear.internal)
    return [known[gear.component.number] for gear in (sun, own, ring)]


def _moduli(machine: Machine, pairs: list[Pair], planet: int) -> list[float]:
    """Moduli of elasticity of sun, planet and ring."""
    found = [STEEL] * 3
    for pair in pairs:
        if pair.moduli:
            own = machine.bodies_of(pair).index(planet)
            found[1], found[2 if pair.internal else 0] = pair.moduli[own], pair.moduli[1 - own]
    return found


def _angles(machine: Machine, planets: list[int], carrier: int, sense: float) -> list[float] | None:
    """Angles of the planets about the axis of the carrier [degree]; None where they are equally spaced or unknown."""
    centre = machine.network.bodies[carrier].axis
    rotors = [machine.network.bodies[body].axis for body in planets]
    unknown = any(rotor is None or rotor.origin is None for rotor in rotors)
    if centre is None or centre.axis is None or centre.origin is None or unknown:
        machine.source.note("missing", "positions of planets; equally spaced")
        return None
    apart = [rotor.origin - centre.origin for rotor in rotors]  # type: ignore[union-attr, operator]
    across = [one - (one @ centre.axis) * centre.axis for one in apart]
    if min(np.linalg.norm(one) for one in across) < 1e-9:
        machine.source.note("missing", "positions of planets, which are on the axis of the carrier; equally spaced")
        return None
    first = across[0] / np.linalg.norm(across[0])
    second = np.cross(centre.axis * machine.sense[carrier], first) * sense
    angles = [math.degrees(math.atan2(float(one @ second), float(one @ first))) % 360 for one in across]
    angles = [0.0 if angle > 360 - 1e-6 else angle for angle in angles]
    spaced = np.sort(angles)
    equal = np.abs(spaced - 360 / len(angles) * np.arange(len(angles))).max() < 0.01
    return None if equal else [round(angle, 6) for angle in angles]


def add_planets(machine: Machine, place: int, stages: Sequence[Stage]) -> list[tuple[float, str]]:
    """Inertias that a carrier has beside its own: of its pins, and of planets that are no set."""
    source, found = machine.source, []
    sets = {stage.component.number for stage in stages}
    for number, carrier in machine.network.carriers.items():
        if carrier != place:
            continue
        for roles in source.file.related("planet_pin", planetary_stage=number):
            rotor = machine.network.rotors[roles["shaft"].number]
            radius = _radius(machine, carrier, rotor.origin)
            pieces = list(rotor.between(*rotor.ends, springs=False))
            if pieces and radius is not None:
                found.append((sum(piece.mass * radius**2 + piece.inertia for piece in pieces), str(rotor.component)))
        for body, stage in machine.network.planets.items():
            axis = machine.network.bodies[body].axis
            radius = _radius(machine, carrier, axis.origin if axis else None)
            if stage == number and number not in sets and radius is not None:
                pieces = [*machine.network.bodies[body].pieces, *rims(machine, body)]
                found.append((sum(piece.mass for piece in pieces) * radius**2, f"mass of {machine.names[body]}"))
    return found


def _radius(machine: Machine, carrier: int, origin: object) -> float | None:
    """Distance of a position from the axis of a carrier [m]."""
    centre = machine.network.bodies[carrier].axis
    if not isinstance(origin, np.ndarray) or centre is None or centre.axis is None or centre.origin is None:
        return None
    return float(np.linalg.norm(np.cross(origin - centre.origin, centre.axis)))
