"""From the network of a REXS file to the groups of a case."""

from __future__ import annotations

from collections.abc import Sequence

from .rexs_draft import Draft
from .rexs_gears import Entry, Pair
from .rexs_loads import Loads, read_loads
from .rexs_machine import Machine, rims
from .rexs_network import Spring
from .rexs_planets import Stage, add_planets, find_stages
from .rexs_shaft import Piece
from .rexs_source import Source

__all__ = ["draft_of"]

#: Damping ratios where none is given, as REXS has none.
_MESH_DAMPING, _SHAFT_DAMPING = 0.05, 0.01


def draft_of(source: Source, title: str) -> Draft:
    """The case of a file, every number with the component that it is of."""
    machine = Machine(source)
    loads = read_loads(machine)
    stages = find_stages(machine, loads)
    draft = Draft()
    draft.add("train", "", {"title": Entry(title, ""), "speed_of": Entry(machine.names[loads.reference], loads.told_speed)})
    sets = {number for stage in stages for number in stage.planets}
    for place in machine.along(loads.reference):
        if place not in sets:
            draft.add("body", "", _body(machine, loads, place, stages))
    for stage in stages:
        draft.add("planetary", str(stage.component), stage.entries)
    for spring in machine.springs:
        draft.add("shaft", spring.source, _shaft(machine, loads, spring))
    for pair in machine.pairs:
        if not any(body in sets for body in machine.bodies_of(pair)):
            draft.add("mesh", str(pair.stage), _mesh(machine, loads, pair))
    _ask(draft, loads)
    return draft


def _body(machine: Machine, loads: Loads, place: int, stages: Sequence[Stage]) -> dict[str, Entry]:
    body = machine.network.bodies[place]
    what = _what(machine, place)
    entries = {"name": Entry(machine.names[place], what if what != machine.names[place] else "")}
    if body.held or place in loads.held:
        return {**entries, "held": Entry(True, loads.held.get(place, "the housing holds it"))}
    pieces = [piece for piece in [*body.pieces, *rims(machine, place)] if piece.density > 0]
    for name, of in (("outer_diameter", "outer"), ("bore", "bore"), ("width", "width"), ("density", "density")):
        if pieces:
            told = _told(pieces) if name == "outer_diameter" else ""
            entries[name] = Entry(_once([getattr(piece, of) for piece in pieces], name in ("bore", "density")), told)
    added = [*body.inertias, *add_planets(machine, place, stages)]
    if not pieces and not added:
        machine.source.note("missing", "inertia; a thousandth of that of the lightest other body", machine.names[place])
        entries["inertia"] = Entry(1e-3 * _lightest(machine), "MISSING")
    told = ", ".join(of for _, of in added)
    if body.loads:
        machine.source.note("missing", "inertia of the machine there, which REXS does not have: give it as added_inertia; 0",
                            machine.names[place])
        told = f"{f'{told}; ' if told else ''}MISSING: inertia of the machine at {body.loads[0]}"
    if added or body.loads:
        entries["added_inertia"] = Entry(sum((value for value, _ in added), 0.0), told)
    return {**entries, **loads.entries(place)}


def _once(values: list[float], may: bool) -> list[float]:
    """One value for all, where they are equal and one stands for all."""
    return values[:1] if may and len(set(values)) == 1 else values


def _what(machine: Machine, place: int) -> str:
    """What is on a body, by the names of components."""
    gears = [str(gear.component) for pair in machine.pairs for gear, body in zip(pair.gears, machine.bodies_of(pair))
             if body == place]
    return ", ".join(dict.fromkeys([*gears, *(str(load) for load in machine.network.bodies[place].loads)]))


def _told(pieces: Sequence[Piece]) -> str:
    return ", ".join(dict.fromkeys(piece.source for piece in pieces))


def _lightest(machine: Machine) -> float:
    sums = [sum(piece.inertia for piece in machine.network.bodies[place].pieces) for place in machine.kept]
    return min((value for value in sums if value > 0), default=1e-3)


def _shaft(machine: Machine, loads: Loads, spring: Spring) -> dict[str, Entry]:
    """A shaft or a coupling, driving body first."""
    ends = spring.bodies if loads.flow(machine.springs.index(spring), spring.bodies[0]) >= 0 else spring.bodies[::-1]
    entries = {"between": Entry([machine.names[body] for body in ends], spring.source)}
    if spring.stiffness is not None:
        entries["stiffness"] = Entry(spring.stiffness, spring.source)
    else:
        entries["diameter"] = Entry([piece.outer for piece in spring.pieces], _told(spring.pieces))
        entries["bore"] = Entry(_once([piece.bore for piece in spring.pieces], True), "")
        entries["length"] = Entry([piece.width for piece in spring.pieces], "")
        machine.source.note("missing", "damping, which REXS does not have; damping ratios 0.05 of meshes and 0.01 of shafts")
        entries["shear_modulus"] = Entry(spring.shear_modulus, f"material of {spring.source}")
    entries["damping_ratio"] = Entry(_SHAFT_DAMPING, "MISSING: REXS has no damping")
    return entries


def _mesh(machine: Machine, loads: Loads, pair: Pair) -> dict[str, Entry]:
    """A gear pair, driving gear first."""
    ends = machine.bodies_of(pair)
    order = (0, 1) if loads.drives(machine, pair) else (1, 0)
    entries = {"between": Entry([machine.names[ends[end]] for end in order], str(pair.stage))}
    carrier = machine.carrier_of(pair)
    if carrier is not None:
        entries["carrier"] = Entry(machine.names[carrier], str(pair.stage))
        machine.source.note("missing", "phase in the mesh cycle; 0", pair.stage)
        entries["phase"] = Entry(0.0, "MISSING")
    entries.update(pair.entries(order))
    entries["damping_ratio"] = Entry(_MESH_DAMPING, "MISSING: REXS has no damping")
    return entries


def _ask(draft: Draft, loads: Loads) -> None:
    """The analyses: modes, and the response round about the speed of the file."""
    draft.add("modes", "", {})
    if loads.speed:
        draft.add("response", "from a fifth of the speed of the file to 1.2 times", {
            "from": Entry(float(f"{0.2 * loads.speed:.4g}"), ""), "to": Entry(float(f"{1.2 * loads.speed:.4g}"), ""),
            "unit": Entry("rpm", ""), "harmonics": Entry(0, ""), "tolerance": Entry(1e-3, "")})


