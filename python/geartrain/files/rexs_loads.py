"""Loads of a REXS file: torques on bodies, what balances them, and which gear of a pair drives."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .rexs_file import Component
from .rexs_gears import Entry, Pair
from .rexs_machine import Machine
from .rexs_source import Source
from .rexs_statics import forces, free_motions, speeds

__all__ = ["Loads", "read_loads"]

Array = NDArray[np.float64]

#: Line load [N/m] where no torque is given: from 100 N/mm on the mesh stiffness of ISO 6336-1 does not depend on the load.
_LINE_LOAD = 1e5
#: Part of a torque that bearings, seals and teeth may take.
_LOSSES = 0.1
#: Power of the drag of an idle part over the largest power of a load.
_DRAG = 1e-3


@dataclass
class Loads:
    """What acts on the bodies at rest, and how they turn.

    Attributes
    ----------
    reference : int
        Body whose speed is "the speed".
    speed : float
        Its speed [rpm]; 0 where the file has none.
    told_speed : str
    speeds : ndarray
        Of every body about the common direction, over that of the reference body where no speed is given.
    torques : dict
        Torque of a body in its own sense of rotation [N m], and its words.
    balancing : dict
        Bodies whose torques balance, and their words.
    ratios : dict
        Bodies whose speeds the gears leave free: speed over that of the reference.
    held : dict
        Bodies that stand still beside the housing, and why.
    forces : ndarray
        Of every link at rest.
    """

    reference: int
    speed: float
    told_speed: str
    speeds: Array
    torques: dict[int, tuple[float, str]] = field(default_factory=dict)
    balancing: dict[int, str] = field(default_factory=dict)
    ratios: dict[int, float] = field(default_factory=dict)
    held: dict[int, str] = field(default_factory=dict)
    forces: Array = field(default_factory=lambda: np.zeros(0))

    def entries(self, place: int) -> dict[str, Entry]:
        found = {}
        if place in self.torques:
            found["torque"] = Entry(*self.torques[place])
        if place in self.balancing:
            found["balances"] = Entry(True, self.balancing[place])
        if place in self.ratios:
            found["speed_ratio"] = Entry(self.ratios[place], "speeds of the file")
        return found

    def flow(self, spring: int, first: int) -> float:
        """Power that the first body gives to a spring."""
        return float(self.forces[spring] * self.speeds[first])

    def power(self, machine: Machine, pair: Pair) -> float:
        """Power that gear_1 of a pair gives to the mesh, seen from the carrier of the pair."""
        link = len(machine.springs) + machine.pairs.index(pair)
        first, carrier = machine.bodies_of(pair)[0], machine.carrier_of(pair)
        turning = self.speeds[first] - (0.0 if carrier is None else self.speeds[carrier])
        return float(self.forces[link] * machine.links[link].factors[0] * turning)

    def drives(self, machine: Machine, pair: Pair) -> bool:
        """Whether gear_1 of a pair drives; of an idle pair it does."""
        small = 1e-9 * float(np.abs(self.forces).max(initial=0.0)) * float(np.abs(self.speeds).max(initial=0.0))
        return self.power(machine, pair) >= -small


def read_loads(machine: Machine) -> Loads:
    """The loads of a file; what cannot be determined is refused by ``source``."""
    source, count = machine.source, len(machine.network.bodies)
    given, stopped = _given_speeds(machine)
    housing = [place for place in machine.kept if machine.network.bodies[place].held]
    motions = _motions(machine, [*housing, *stopped], count)
    if given and len(motions) > len(given):
        stopped |= _without_speed(machine)
        motions = _motions(machine, [*housing, *stopped], count)
    if not len(motions):
        source.refuse("nothing can turn: the gears lock, or the housing holds all shafts")
    found = speeds(motions, given)
    if found is None:
        source.note("assumed", "speeds of shafts contradict the numbers of teeth; that of the first shaft holds")
        given = dict([next(iter(given.items()))])
        found = speeds(motions, given)
    loads = _loads_of(machine)
    reference = next(iter(given), loads[0][0])
    if not given:
        source.note("missing", f"speed of the gearbox (defines_speed, rotational_speed), so no &response is asked for; the "
                               f"sense of {loads[0][1]} by its torque")
        found = speeds(motions, {reference: machine.sense[reference] * _sign(source, loads)})
    if found is None or np.linalg.matrix_rank(motions[:, list(given) or [reference]]) < len(motions):
        source.refuse(f"has {len(motions)} independent speeds, and gives {len(given)} (defines_speed, rotational_speed of "
                      f"shafts): give the others, or let a coupling be engaged")
    _check_speeds(machine, found, given)
    speed = abs(given.get(reference, 0.0))
    made = Loads(reference, speed, f"{speed:g} 1/min in the file" if speed else "MISSING", found)
    made.held = dict(stopped)
    _put_torques(machine, made, loads, motions)
    others = [place for place in given if place != reference][: len(motions) - 1]
    made.ratios = {place: float(found[place] * found[reference] / found[reference] ** 2) for place in others}
    for place, ratio in made.ratios.items():
        made.ratios[place] = ratio * machine.sense[place] * machine.sense[reference]
    return made


def _motions(machine: Machine, held: list[int], count: int) -> Array:
    """Free motions of the bodies that are kept."""
    left = [place for place in range(count) if place not in set(machine.kept)]
    return free_motions(machine.links, count, [*held, *left])


def _given_speeds(machine: Machine) -> tuple[dict[int, float], dict[int, str]]:
    """Speeds [rpm] of bodies about the common direction, and the bodies whose speed is given as 0."""
    source = machine.source
    shafts = [shaft for shaft in source.file.of_kind("shaft") if source.truth(shaft, "defines_speed")]
    if not any(source.number(shaft, "rotational_speed") for shaft in shafts):
        shafts += [shaft for shaft in source.file.of_kind("shaft") if source.truth(shaft, "defines_speed") is None][:50]
        shafts = [shaft for shaft in shafts if source.number(shaft, "rotational_speed")][:1]
    given: dict[int, float] = {}
    stopped: dict[int, str] = {}
    for shaft in shafts:
        bodies = [body for body in machine.network.on_shaft.get(shaft.number, []) if body in set(machine.kept)]
        speed = source.number(shaft, "rotational_speed")
        if speed is None or not bodies or machine.network.bodies[bodies[0]].held:
            continue
        if speed == 0:
            stopped[bodies[0]] = f"{shaft}: rotational_speed = 0"
            source.note("assumed", "held, as its rotational_speed is 0", shaft)
        else:
            loaded = [body for body in bodies if machine.network.bodies[body].loads]
            given[(loaded or bodies)[0]] = speed * float(machine.sense[bodies[0]])
    return given, stopped


def _check_speeds(machine: Machine, found: Array, given: dict[int, float]) -> None:
    """Say where the teeth give a shaft another speed than the file does."""
    for shaft in machine.source.file.of_kind("shaft") if given else []:
        bodies = [body for body in machine.network.on_shaft.get(shaft.number, []) if body in set(machine.kept)]
        speed = machine.source.number(shaft, "rotational_speed")
        if speed and bodies and not set(bodies) & set(given) and abs(abs(found[bodies[0]]) - abs(speed)) > 0.01 * abs(speed):
            turns = float(found[bodies[0]] * machine.sense[bodies[0]])
            machine.source.note("not used", f"its speed of {speed:g} 1/min: by the teeth it turns at {turns:.6g} 1/min", shaft)


def _without_speed(machine: Machine) -> dict[int, str]:
    """Bodies of shafts that define a speed and have none, which stand still: some programs leave out a speed of 0."""
    source, found = machine.source, {}
    for shaft in source.file.of_kind("shaft"):
        bodies = [body for body in machine.network.on_shaft.get(shaft.number, []) if body in set(machine.kept)]
        if source.truth(shaft, "defines_speed") and source.number(shaft, "rotational_speed") is None and bodies:
            found[bodies[0]] = f"MISSING: speed of {shaft}"
            source.note("missing", "rotational_speed of a shaft that defines the speed; held", shaft)
    return found


def _loads_of(machine: Machine) -> list[tuple[int, Component]]:
    kept = set(machine.kept)
    bodies = enumerate(machine.network.bodies)
    return [(place, load) for place, body in bodies if place in kept and not body.held for load in body.loads]


def _sign(source: Source, loads: list[tuple[int, Component]]) -> float:
    return math.copysign(1.0, source.number(loads[0][1], "torque_around_u_axis") or 1.0)


def _put_torques(machine: Machine, made: Loads, loads: list[tuple[int, Component]], motions: Array) -> None:
    """Torques that are given, and the bodies that balance them."""
    source, known = machine.source, {}
    defined = [row for row in loads if source.truth(row[1], "defines_torque")]
    for place, load in defined or loads:
        torque = _torque(machine, made, place, load)
        if torque is not None:
            known[load.number] = torque
    if len(known) == len(loads) and len(loads) > 1:
        place, load = loads[-1]
        source.note("assumed", f"balances all other torques; its own, {known.pop(load.number)[0]:g} N m, is not used", load)
    free = [row for row in loads if row[1].number not in known]
    # Of those whose torque does not count so far, some have one all the same: they balance last.
    own = {load.number: torque for place, load in free if (torque := _torque(machine, made, place, load)) is not None}
    _choose_balancing(machine, made, sorted(free, key=lambda row: row[1].number in own), motions)
    for place, load in free:
        if load.number in own and place not in made.balancing:
            known[load.number] = own[load.number]
            source.note("assumed", f"its torque of {own[load.number][0]:g} N m acts, although it does not define the torque", load)
    torques = np.zeros(len(machine.network.bodies))
    for place, load in loads:
        if load.number in known and place not in made.balancing:
            given, told = known[load.number]
            torques[place] += given * machine.sense[place]
            way = math.copysign(1.0, made.speeds[place]) * given * machine.sense[place]
            made.torques[place] = made.torques.get(place, (0.0, ""))[0] + way, told
    held = [place for place in machine.kept if machine.network.bodies[place].held or place in made.held]
    if not torques.any():
        torques = _usual(machine, made, loads, held)
    for place, load in free:
        if place not in {*made.balancing, *made.held, *made.torques}:
            source.note("missing", "torque; 0", load)
    made.forces = forces(machine.links, torques, list(made.balancing), held)
    _check_balance(machine, made, loads, torques)
    dragged = _drag(machine, made, torques)
    if dragged.any():
        made.forces = forces(machine.links, torques + dragged, list(made.balancing), held)


def _check_balance(machine: Machine, made: Loads, loads: list[tuple[int, Component]], torques: Array) -> None:
    """Say where the torque in the file of a load that balances is another one, by more than losses."""
    for place, load in loads if len(made.balancing) == 1 else []:
        given = machine.source.number(load, "torque_around_u_axis") if place in made.balancing and made.speeds[place] else None
        if given is not None:
            needed = -float(torques @ made.speeds) / float(made.speeds[place]) * float(machine.sense[place])
            if abs(needed - given) > _LOSSES * abs(needed):
                machine.source.note("not used", f"its torque of {given:g} N m: {needed:.6g} N m balances the others", load)


def _drag(machine: Machine, made: Loads, torques: Array) -> Array:
    """A drag on idle parts, whose teeth would float in their backlash without any mean force; about the common direction."""
    pairs, count = made.forces[len(machine.springs):], len(torques)
    found, most = np.zeros(count), np.abs(made.forces).max(initial=0.0)
    power = _DRAG * float(np.abs(torques * made.speeds).max(initial=0.0))
    for place, pair in enumerate(machine.pairs):
        if abs(pairs[place]) > 1e-6 * most or machine.carrier_of(pair) is not None:
            continue
        beyond = _beyond(machine, len(machine.springs) + place, made.reference)
        ends = [body for body in machine.bodies_of(pair) if body in beyond]
        if len(ends) == 1 and made.speeds[ends[0]] != 0 and ends[0] not in made.torques and not beyond & set(made.balancing):
            drag = power / abs(float(made.speeds[ends[0]]))
            found[ends[0]] = -math.copysign(drag, made.speeds[ends[0]])
            made.torques[ends[0]] = -float(f"{drag:.3g}"), "MISSING: drag of an idle part, 0.1 % of the power"
            machine.source.note("missing", "drag of idle parts, without which teeth float in their backlash; 0.1 % of the power",
                                machine.names[ends[0]])
    return found


def _beyond(machine: Machine, link: int, first: int) -> set[int]:
    """Bodies that are joined to one of them by no other link than this one."""
    reached, new = {first}, [first]
    while new:
        body = new.pop()
        for number, other in enumerate(machine.links):
            if number != link and body in other.bodies:
                near = set(other.bodies) - reached
                reached |= near
                new += near
    return set(machine.kept) - reached


def _torque(machine: Machine, made: Loads, place: int, load: Component) -> tuple[float, str] | None:
    """Torque of a load about the axis of its shaft [N m], by its power where it has no torque."""
    source = machine.source
    torque = source.number(load, "torque_around_u_axis")
    power, speed = source.number(load, "power"), made.speeds[place] * machine.sense[place] * math.pi / 30
    if torque is not None:
        if power is not None and made.speed and abs(abs(power) - abs(torque * speed)) > _LOSSES * abs(torque * speed):
            source.note("not used", f"its power of {power / 1e3:g} kW: {torque:g} N m at {abs(speed) * 30 / math.pi:.6g} 1/min are "
                                    f"{abs(torque * speed) / 1e3:.4g} kW", load)
        return torque, str(load)
    if power is None:
        return None
    if not made.speed or speed == 0:
        source.note("missing", "speed, where the power is known alone", load)
        return None
    return float(power / speed), f"{load}: {power / 1e3:g} kW at {abs(speed) * 30 / math.pi:.6g} 1/min"


def _choose_balancing(machine: Machine, made: Loads, free: list[tuple[int, Component]], motions: Array) -> None:
    """As many bodies as there are independent speeds, of those whose torque is not given."""
    source, rank = machine.source, 0
    for place, load in free:
        if place in made.balancing:
            continue
        chosen = [*made.balancing, place]
        if np.linalg.matrix_rank(motions[:, chosen], tol=1e-9) > rank:
            unused = source.number(load, "torque_around_u_axis")
            made.balancing[place] = f"{load}, whose torque " + ("is not given" if unused is None else
                                                                f"of {unused:g} N m in the file follows from the others")
            rank += 1
        if rank == len(motions):
            break
    if rank < len(motions):
        source.refuse(f"has {len(motions)} independent speeds and {rank} external loads that can balance the torques: an "
                      f"external_load with transmits_torque and without torque is wanted")


def _usual(machine: Machine, made: Loads, loads: list[tuple[int, Component]], held: list[int]) -> Array:
    """The torque at which the most loaded mesh has a line load of 100 N/mm, where none is given."""
    # The shaft whose speed is given drives.
    first = [row for row in loads if row[0] == made.reference and len(made.balancing) == 1]
    others = [row for row in loads if row[0] not in made.balancing and row[0] not in held]
    place, load = next(iter([*first, *others]), loads[0])
    if place in made.balancing and len(made.balancing) == 1:
        other = next((row[0] for row in loads if row[0] != place), None)
        if other is None:
            machine.source.refuse(f"{load} is the only external load that transmits torque: a second one is wanted")
        made.balancing = {other: f"{next(row[1] for row in loads if row[0] == other)}, whose torque is not given"}
    torques = np.zeros(len(machine.network.bodies))
    torques[place] = math.copysign(1.0, made.speeds[place])
    unit = forces(machine.links, torques, list(made.balancing), held)[len(machine.springs):]
    loads_of = [abs(force) * link.factors[0] / (pair.gears[0].reference / 2) / (pair.width.value if pair.width else 1.0)
                for force, link, pair in zip(unit, machine.links[len(machine.springs):], machine.pairs)]
    value = float(f"{_LINE_LOAD / max(loads_of):.3g}") if max(loads_of, default=0.0) > 0 else 1.0
    machine.source.note("missing", f"torque; {value:g} N m, at which the most loaded mesh has 100 N/mm of face width", load)
    made.torques[place] = value, f"MISSING: torque of {load}"
    return torques * value
