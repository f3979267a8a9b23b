"""Bodies of a REXS file: what turns as one, and the shafts between."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise

from .rexs_file import Component
from .rexs_shaft import Piece, Rotor, density_of, read_shaft
from .rexs_source import Source

__all__ = ["HOUSING", "Body", "Network", "Spring", "build", "middle_of"]

#: The body that stands still.
HOUSING = "housing"
#: Torsional stiffness [N m/rad] from which a coupling is rigid: shafts of gearboxes have 1e3 to 1e9.
_RIGID = 1e11


@dataclass
class Body:
    """What turns as one.

    Attributes
    ----------
    name : str
    axis : Rotor or None
        A shaft of it.
    pieces : list of Piece
    inertias : list of (float, str)
        Inertias [kg m^2] that are given as such, and their components.
    loads : list of Component
        External loads that transmit torque.
    """

    name: str = ""
    axis: Rotor | None = None
    pieces: list[Piece] = field(default_factory=list)
    inertias: list[tuple[float, str]] = field(default_factory=list)
    loads: list[Component] = field(default_factory=list)
    held: bool = False


@dataclass
class Spring:
    """A torsional spring between two bodies: the sections of a shaft, or the stiffness of a coupling [N m/rad]."""

    bodies: tuple[int, int]
    source: str
    pieces: list[Piece] = field(default_factory=list)
    shear_modulus: float = 0.0
    stiffness: float | None = None


class Network:
    """Bodies and springs, and on which body each gear is.

    Attributes
    ----------
    bodies : list of Body
    springs : list of Spring
    gears : dict of int
        Body of each gear, by the number of its component.
    carriers : dict of int
        Body of the carrier of each planetary stage, by the number of its component.
    planets : dict of int
        Planetary stage of each body that rides on a carrier.
    on_shaft : dict of list of int
        Bodies along each shaft, by the number of its component.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.bodies: list[Body] = []
        self.springs: list[Spring] = []
        self.gears: dict[int, int] = {}
        self.carriers: dict[int, int] = {}
        self.planets: dict[int, int] = {}
        self.on_shaft: dict[int, list[int]] = {}
        self.rotors = {shaft.number: read_shaft(source, shaft) for shaft in source.file.of_kind("shaft")}
        self._parent: dict[Hashable, Hashable] = {}
        self._couplings: list[tuple[Hashable, Hashable, float, Component]] = []

    # Nodes: ("shaft", number, u), ("part", number) or HOUSING.

    def find(self, node: Hashable) -> Hashable:
        while self._parent.setdefault(node, node) != node:
            node = self._parent[node]
        return node

    def join(self, one: Hashable, other: Hashable) -> None:
        """Let two nodes turn as one; the housing stays itself."""
        first, second = self.find(one), self.find(other)
        if first == HOUSING:
            first, second = second, first
        self._parent[first] = second

    def place(self, shaft: int, u: float) -> Hashable:
        """The node of a place on a shaft."""
        self.rotors[shaft].places.append(u)
        return "shaft", shaft, u


def build(source: Source) -> Network:
    """Bodies and springs of a file."""
    network = Network(source)
    gears = _place_gears(network)
    loads = _place(network, "external_load")
    masses = _place(network, "additional_mass")
    _connect(network)
    _make_carriers(network)
    _merge_places(network)
    _make_bodies(network, gears, loads, masses)
    return network


def _place_gears(network: Network) -> dict[int, Hashable]:
    """The node of every gear, on its shaft or on the shaft that its hub is joined to."""
    source, found = network.source, {}
    for gear in source.file.of_kind("cylindrical_gear", "ring_gear"):
        shaft = _shaft_of(source, gear)
        if shaft is None:
            shaft = next((roles["inner_part"] for roles in source.file.related("side", outer_part=gear.number)
                          if roles.get("inner_part") is not None and roles["inner_part"].kind == "shaft"
                          and _joins(roles.get("assembly"))), None)
        if shaft is None:
            source.wrong(gear, "is on no shaft")
            continue
        found[gear.number] = network.place(shaft.number, middle_of(source, gear, network.rotors[shaft.number]))
    return found


def middle_of(source: Source, gear: Component, rotor: Rotor) -> float:
    """u-coordinate of the middle of a gear on its shaft [m]."""
    placed = _by_position(source, gear, rotor)
    if placed is not None:
        return placed
    u = _coordinate(source, gear, rotor)
    # In version 1.0 the coordinate is that of the begin of the gear, later that of its middle.
    return u + (source.number(gear, "face_width") or 0.0) / 2 if source.file.version == "1.0" else u


def _coordinate(source: Source, component: Component, rotor: Rotor, name: str = "u_coordinate_on_shaft") -> float:
    """u-coordinate of a component on its shaft [m], by its position where it has none."""
    u = source.number(component, name)
    u = _by_position(source, component, rotor) if u is None else u
    if u is None:
        source.note("missing", "place on its shaft; u = 0", component)
    return u or 0.0


def _by_position(source: Source, component: Component, rotor: Rotor) -> float | None:
    position = source.vector(component, "support_vector")
    known = position is not None and rotor.origin is not None and rotor.axis is not None
    return round(float((position - rotor.origin) @ rotor.axis), 9) if known else None  # type: ignore[operator]


def _place(network: Network, kind: str) -> list[tuple[Component, Hashable]]:
    """Loads or masses on shafts, with their nodes; of loads those that transmit torque."""
    source, found = network.source, []
    for component in source.file.of_kind(kind):
        if kind == "external_load" and source.truth(component, "transmits_torque") is False:
            continue
        shaft = _shaft_of(source, component)
        if shaft is not None:
            found.append((component, network.place(shaft.number, _coordinate(source, component, network.rotors[shaft.number]))))
    return found


def _shaft_of(source: Source, component: Component) -> Component | None:
    """The shaft to which a component belongs by a relation of assembly."""
    shafts = [roles["assembly"] for roles in source.file.related("assembly", part=component.number)
              if roles.get("assembly") is not None and roles["assembly"].kind == "shaft"]
    if len({shaft.number for shaft in shafts}) > 1:
        source.wrong(component, f"is on {len(shafts)} shafts: {', '.join(map(str, shafts))}")
    return shafts[0] if shafts else None


def _joins(component: Component | None) -> bool:
    """Whether a connection joins a hub to a shaft: a key, a spline, an interference fit."""
    return component is not None and component.kind.endswith(("_connection", "_fit"))


def _connect(network: Network) -> None:
    """Couplings and connections of shafts, side plates and the housing."""
    source = network.source
    for roles in source.file.related("side"):
        component, inner, outer = roles.get("assembly"), roles.get("inner_part"), roles.get("outer_part")
        if component is None or inner is None or outer is None or (inner.kind, outer.kind) == ("shaft", "cylindrical_gear"):
            continue
        if component.kind in ("coupling", "switchable_coupling"):
            stiffness = _stiffness(source, component)
        elif _joins(component):
            stiffness = float("inf")
            source.note("assumed", "rigid in torsion, without play", component)
        else:
            continue
        ends = [_end(network, component, part, side) for part, side in ((inner, "inner"), (outer, "outer"))]
        if stiffness > 0:
            network._couplings.append((ends[0], ends[1], stiffness, component))


def _end(network: Network, component: Component, part: Component, side: str) -> Hashable:
    """The node that one side of a coupling takes."""
    if part.kind == "gear_casing":
        return HOUSING
    if part.kind != "shaft":
        return "part", part.number
    u = _coordinate(network.source, component, network.rotors[part.number], f"u_coordinate_on_shaft_{side}_side")
    return network.place(part.number, u)


def _stiffness(source: Source, component: Component) -> float:
    """Torsional stiffness of a coupling [N m/rad]; 0 where it is open or transmits no torque."""
    if component.kind == "switchable_coupling":
        engaged = source.truths(component, "is_engaged")
        unit = next(source.file.of_kind("gear_unit"), None)
        gear = 1 if unit is None else int(source.number(unit, "gear_shift_index") or 1)
        if len(engaged) > 1:
            source.note("assumed", f"gear {gear} of {len(engaged)} is engaged, as the file's gear_shift_index tells")
        if engaged and not engaged[min(gear, len(engaged)) - 1]:
            return 0.0
    stiffness = source.number(component, "rotational_stiffness")
    if stiffness is None:
        source.note("missing", "torsional stiffness; rigid", component)
        return float("inf")
    if stiffness < 0:
        source.wrong(component, f"rotational_stiffness = {stiffness:g} N m/rad: must be 0 (open) or above")
    if stiffness >= _RIGID:
        source.note("assumed", f"rigid, as a torsional stiffness of {stiffness:g} N m/rad means", component)
    return stiffness


def _make_carriers(network: Network) -> None:
    """Let plates and pins of a planet carrier turn as one, and find where they are on its shafts."""
    source = network.source
    for stage in source.file.of_kind("planetary_stage"):
        carrier: Hashable = "part", stage.number
        shafts = [roles["shaft"] for roles in source.file.related("planet_carrier_shaft", planetary_stage=stage.number)]
        pins = [roles["shaft"] for roles in source.file.related("planet_pin", planetary_stage=stage.number)]
        planets = [roles["shaft"] for roles in source.file.related("planet_shaft", planetary_stage=stage.number)]
        holders = [roles["part"] for roles in source.file.related("assembly", assembly=stage.number)
                   if roles["part"].kind == "planet_carrier"]
        plates = [roles["part"] for holder in holders for roles in source.file.related("assembly", assembly=holder.number)
                  if roles["part"].kind == "side_plate"]
        if len(holders) > 1 or not planets:
            source.wrong(stage, f"has {len(holders)} planet carriers, {len(planets)} planet shafts: must have one, and one or more")
            continue
        for plate in plates:
            network.join(("part", plate.number), carrier)
        for pin in pins:
            for u in network.rotors[pin.number].places or [network.place(pin.number, 0.0)[2]]:  # type: ignore[index]
                network.join(("shaft", pin.number, u), carrier)
        for planet in planets:
            places = network.rotors[planet.number].places
            for u in places[1:]:
                network.join(("shaft", planet.number, u), ("shaft", planet.number, places[0]))
        network.carriers[stage.number] = -1
        # A carrier of plates is joined to its shafts by couplings; without plates its shafts are rigid and carry the planets.
        coupled = {end for row in network._couplings for end in row[:2]}
        if not any(("part", plate.number) in coupled for plate in plates):
            for shaft in shafts:
                middle = sum(network.rotors[shaft.number].ends) / 2
                network.join(network.place(shaft.number, middle), carrier)
                source.note("assumed", "the carrier is in the middle of its shaft, as it has no plates, and has the inertia of "
                                       "that shaft and of its planets", stage)
        source.note("assumed", "the carrier is rigid between its plates and pins; planets turn freely on it", stage)


def _merge_places(network: Network) -> None:
    for number, rotor in network.rotors.items():
        for u, kept in rotor.join_near(network.source).items():
            if u != kept:
                network.join(("shaft", number, u), ("shaft", number, kept))
    for one, other, stiffness, _ in network._couplings:
        if stiffness >= _RIGID:
            network.join(one, other)


def _make_bodies(
    network: Network, gears: Mapping[int, Hashable], loads: list[tuple[Component, Hashable]],
    masses: list[tuple[Component, Hashable]],
) -> None:
    """The bodies with their pieces, and the springs between them."""
    source, numbers = network.source, {}

    def body(node: Hashable) -> int:
        root = network.find(node)
        if root not in numbers:
            numbers[root] = len(network.bodies)
            network.bodies.append(Body(held=root == network.find(HOUSING)))
        return numbers[root]

    for number, node in gears.items():
        network.gears[number] = body(node)
    for load, node in loads:
        network.bodies[body(node)].loads.append(load)
    for mass, node in masses:
        inertia = source.number(mass, "moment_of_inertia_u_axis")
        if inertia is None or inertia <= 0:
            source.note("missing", "moment of inertia about the axis; 0", mass)
        else:
            network.bodies[body(node)].inertias.append((inertia, str(mass)))
    for stage in network.carriers:
        network.carriers[stage] = body(("part", stage))
    for stage in network.carriers:
        for roles in source.file.related("planet_shaft", planetary_stage=stage):
            number = roles["shaft"].number
            for u in network.rotors[number].places[:1]:
                network.planets[body(("shaft", number, u))] = stage
    pins = {relation.roles.get("shaft") for relation in source.file.relations if relation.kind == "planet_pin"}
    for number, rotor in network.rotors.items():
        if rotor.places and number not in pins:
            _lay_out(network, rotor, [body(("shaft", number, u)) for u in rotor.places])
    for one, other, stiffness, component in network._couplings:
        ends = body(one), body(other)
        if stiffness < _RIGID and ends[0] != ends[1]:
            network.springs.append(Spring(ends, str(component), stiffness=stiffness))
    for plate in source.file.of_kind("side_plate"):
        _add_plate(network, plate, body(("part", plate.number)))


def _lay_out(network: Network, rotor: Rotor, bodies: list[int]) -> None:
    """Give the sections of a shaft to its places, half of each stretch to either, and the springs between."""
    source, places, (begin, end) = network.source, rotor.places, rotor.ends
    network.on_shaft[rotor.component.number] = bodies
    cuts = [begin, *[(one + other) / 2 for one, other in pairwise(places)], end]
    for number, first, last in zip(bodies, cuts, cuts[1:]):
        part = network.bodies[number]
        part.pieces += rotor.between(first, last, springs=False)
        part.axis = part.axis or rotor
    for one, other, first, last in zip(bodies, bodies[1:], places, places[1:]):
        if one == other:
            continue
        pieces = list(rotor.between(first, last, springs=True))
        if sum(piece.width for piece in pieces) < (last - first) * (1 - 1e-6):
            told = f"; {', '.join(rotor.empty)}: without length" if rotor.empty else ""
            source.wrong(rotor.component, f"has no section all the way from {1e3 * first:g} mm to {1e3 * last:g} mm{told}")
        network.springs.append(Spring((one, other), str(rotor.component), pieces, rotor.shear_modulus))


def _add_plate(network: Network, plate: Component, number: int) -> None:
    source = network.source
    outer, width = source.number(plate, "outer_diameter"), source.number(plate, "length")
    bore = source.number(plate, "inner_diameter") or 0.0
    if outer is None or width is None or not outer > bore >= 0 or width <= 0:
        source.note("missing", "dimensions; without inertia", plate)
        return
    source.note("assumed", "a full disc, without the holes for the planets", plate)
    network.bodies[number].pieces.append(Piece(outer, bore, width, density_of(source, plate), str(plate)))
