"""Gear pairs of a REXS file: what a mesh is given by."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from .din3967 import mean_thinning
from .rexs_file import Component
from .rexs_shaft import material_of, modulus_of
from .rexs_source import Source

__all__ = ["STEEL", "Entry", "Gear", "Pair", "read_pairs"]

#: Modulus of elasticity where a gear has none [N/m^2], as of a mesh.
STEEL = 2.06e11
#: Tooth thickness where a file has none: what most files of the standard have.
_SERIES = "c25"
#: Sum of profile shifts that a centre distance may differ by: more than any backlash of DIN 3967.
_TOO_FAR = 0.08
#: Modules [m], from those of watches to those of mills; others are a mistake of the unit.
_MODULES = 0.02e-3, 0.2
#: Centre distance over that of the reference circles beyond which it is in another unit: the working pressure angle is 62 degrees.
_APART = 2.0
#: Kinds of stages that have another geometry.
_OTHERS = ("bevel_stage", "hypoid_stage", "worm_stage", "crown_stage", "beveloid_stage")


class Entry(NamedTuple):
    """A value of a case with the words that stand beside it."""

    value: Any
    told: str


@dataclass(frozen=True)
class Gear:
    """A gear: its teeth, its profile shift, diameters and face width [m], thinning of its teeth [m] or None."""

    component: Component
    teeth: int
    shift: float | None
    module: float
    helix: float
    pressure: float | None
    width: float | None
    tip: float | None
    series: str | None

    @property
    def internal(self) -> bool:
        return self.component.kind == "ring_gear"

    @property
    def reference(self) -> float:
        """Reference diameter [m]."""
        return self.teeth * self.module / math.cos(math.radians(self.helix))


@dataclass
class Pair:
    """A gear pair.

    Attributes
    ----------
    stage : Component
    gears : tuple of Gear
        gear_1 and gear_2 of the file.
    internal : bool
    distance : float or None
        Centre distance [m].
    backlash : Entry
    width : Entry or None
    shifts : tuple of float
    """

    stage: Component
    gears: tuple[Gear, Gear]
    distance: float | None
    width: Entry | None
    shifts: tuple[float, float]
    backlash: Entry
    tips: tuple[float, float] | None
    dedendum: Entry
    moduli: tuple[float, float] | None

    @property
    def internal(self) -> bool:
        return self.gears[0].internal or self.gears[1].internal

    def entries(self, order: tuple[int, int]) -> dict[str, Entry]:
        """What the mesh is given by, driving gear first."""
        one, other = (self.gears[place] for place in order)
        names = f"{one.component}, {other.component}"
        found = {
            "teeth": Entry([one.teeth, other.teeth], names),
            "normal_module": Entry(one.module, f"{one.component}"),
            "pressure_angle": Entry(one.pressure or 20.0, f"{one.component}" if one.pressure else "MISSING: 20 degrees"),
            "helix_angle": Entry(abs(one.helix), f"{one.component}"),
            "face_width": self.width,
            "profile_shift": Entry([self.shifts[place] for place in order], names),
            "centre_distance": None if self.distance is None else Entry(self.distance, str(self.stage)),
            "tip_diameter": None if self.tips is None else Entry([self.tips[place] for place in order], names),
            "dedendum": self.dedendum,
            "internal": Entry(True, f"{(other if other.internal else one).component}") if self.internal else None,
            "backlash": self.backlash,
            "elastic_modulus": None if self.moduli is None else Entry([self.moduli[place] for place in order],
                                                                      f"materials of {names}"),
        }
        return {name: entry for name, entry in found.items() if entry is not None}


def read_pairs(source: Source, distance: Callable[[Component, Component], float | None]) -> list[Pair]:
    """All cylindrical stages of a file; the distance of the axes of two gears by their positions is ``distance``."""
    for stage in source.file.of_kind(*_OTHERS):
        source.wrong(stage, "only cylindrical and planetary stages are read; give the mesh by hand")
    found = []
    shifts: dict[int, float] = {}
    for stage in source.file.of_kind("cylindrical_stage"):
        related = list(source.file.related("stage", stage=stage.number))
        if any(roles != related[0] for roles in related):
            source.wrong(stage, f"has {len(related)} relations to gears, and not to the same: must have one")
            continue
        roles = related[0] if related else {}
        kinds = [roles[name].kind for name in ("gear_1", "gear_2") if name in roles]
        if len(kinds) < 2 or {*kinds} - {"cylindrical_gear", "ring_gear"} or roles["gear_1"] is roles["gear_2"]:
            told = f": {' and '.join(kinds)}" if kinds else ""
            source.wrong(stage, f"has no relation to two cylindrical gears, gear_1 and gear_2{told}")
            continue
        gears = [_read_gear(source, roles[name]) for name in ("gear_1", "gear_2")]
        if gears[0] is not None and gears[1] is not None:
            pair = _pair(source, stage, (gears[0], gears[1]), distance, shifts)
            if pair is not None:
                found.append(pair)
    return found


def _read_gear(source: Source, component: Component) -> Gear | None:
    teeth = source.number(component, "number_of_teeth", required=True)
    module = source.number(component, "normal_module", least=0.0, required=True)
    if teeth is None or module is None:
        return None
    if abs(teeth) < 3 or teeth != round(teeth) or teeth > 100000:
        source.wrong(component, f"number_of_teeth = {teeth:g}: must be a whole number from 3 on")
        return None
    if not _MODULES[0] <= module <= _MODULES[1]:
        source.wrong(component, f"normal_module = {1e3 * module:g} mm: must be {1e3 * _MODULES[0]:g} to {1e3 * _MODULES[1]:g} mm")
        return None
    helix = source.number(component, "helix_angle_reference_diameter")
    if helix is None:
        source.note("missing", "helix angle; 0", component)
        helix = 0.0
    if abs(helix) > 60:
        source.wrong(component, f"helix_angle_reference_diameter = {helix:g} degrees: must be at most 60")
        return None
    tip = source.number(component, "tip_diameter")
    flanks = _flanks(source, component)
    shift = _of_flanks(source, component, flanks, "addendum_modification_coefficient")
    return Gear(component, round(abs(teeth)), shift, module, helix, _of_flanks(source, component, flanks, "normal_pressure_angle"),
                source.number(component, "face_width", least=0.0), None if tip is None else abs(tip),
                source.text(component, "tooth_thickness_deviation_tolerance_series_din_3967_1978"))


def _flanks(source: Source, component: Component) -> list[Component]:
    roles: Mapping[str, Component] = next(source.file.related("flank", gear=component.number), {})
    return [roles[side] for side in ("left", "right") if side in roles]


def _of_flanks(source: Source, gear: Component, flanks: list[Component], name: str) -> float | None:
    """A number of the left flank, of the right one, or of the gear itself."""
    found = [value for value in (source.number(part, name) for part in (*flanks, gear)) if value is not None]
    if found and any(abs(value - found[0]) > 1e-6 for value in found):
        source.note("assumed", f"flanks differ in {name}, {found[0]:g} and {found[1]:g}; those of the left flank", gear)
    return found[0] if found else None


def _pair(
    source: Source, stage: Component, gears: tuple[Gear, Gear], distance: Callable[[Component, Component], float | None],
    known: dict[int, float],
) -> Pair | None:
    one, other = gears
    if abs(one.module - other.module) > 1e-3 * one.module or abs(abs(one.helix) - abs(other.helix)) > 0.01:
        source.wrong(stage, f"{one.component} and {other.component} differ in module or helix angle: {1e3 * one.module:g} mm and "
                            f"{1e3 * other.module:g} mm, {one.helix:g} and {other.helix:g} degrees: must be parallel axes")
        return None
    if one.internal and other.internal:
        source.wrong(stage, f"{one.component} and {other.component} are ring gears both")
        return None
    if not one.internal and not other.internal and one.helix * other.helix > 1e-4:
        source.wrong(stage, f"{one.component} and {other.component} have helix angles of the same hand: must be parallel axes")
        return None
    gears = _with_pressure_angle(source, stage, gears)
    between = _distance(source, stage, gears, distance)
    shifts = _shifts(source, stage, gears, between, known)
    return Pair(stage, gears, between, _width(source, stage, gears), shifts, _backlash(source, stage, gears, between, shifts),
                _tips(source, gears, shifts), _dedendum(source, gears), _moduli(source, gears))


def _with_pressure_angle(source: Source, stage: Component, gears: tuple[Gear, Gear]) -> tuple[Gear, Gear]:
    """Gears with the normal pressure angle of both; a missing one is taken from the mate."""
    one, other = gears
    if one.pressure is not None and other.pressure is not None and abs(one.pressure - other.pressure) > 1e-3:
        source.wrong(stage, f"{one.component} and {other.component} differ in normal pressure angle: {one.pressure:g} and "
                            f"{other.pressure:g} degrees")
    common = one.pressure or other.pressure
    for gear in gears:
        if gear.pressure is None:
            told = f"{common:g} degrees, taken from its mate" if common else "20 degrees"
            source.note("missing", f"normal pressure angle; {told}", gear.component)
    return replace(one, pressure=one.pressure or common), replace(other, pressure=other.pressure or common)


def _distance(
    source: Source, stage: Component, gears: tuple[Gear, Gear], positions: Callable[[Component, Component], float | None]
) -> float | None:
    given = source.number(stage, "center_distance")
    placed = positions(gears[0].component, gears[1].component)
    if given is not None and given != 0:
        if placed is not None and abs(placed - abs(given)) > 1e-4:
            source.note("assumed", f"centre distance {1e3 * abs(given):g} mm, although axes are {1e3 * placed:g} mm apart", stage)
        return _likely(source, stage, gears, abs(given))
    if placed is not None and placed > 0:
        source.note("assumed", f"centre distance {1e3 * placed:.6g} mm, by the positions of the gears", stage)
        return _likely(source, stage, gears, placed)
    source.note("missing", "centre distance; that of flanks without backlash", stage)
    return None


def _likely(source: Source, stage: Component, gears: tuple[Gear, Gear], distance: float) -> float:
    """A centre distance, refused where no profile shift leads to it."""
    usual = abs(sum(-gear.reference if gear.internal else gear.reference for gear in gears)) / 2
    if usual > 0 and not 1 / _APART < distance / usual < _APART:
        source.wrong(stage, f"a centre distance of {1e3 * distance:g} mm: reference circles of {gears[0].teeth} and "
                            f"{gears[1].teeth} teeth touch at {1e3 * usual:.6g} mm, and no profile shift changes that so much")
    return distance


def _shifts(
    source: Source, stage: Component, gears: tuple[Gear, Gear], distance: float | None, known: dict[int, float]
) -> tuple[float, float]:
    """Profile shifts; those that are missing follow from the centre distance, once for all stages of a gear.

    Parameters
    ----------
    known : dict
        Of gears whose shift followed from a stage before; takes up those of this one.
    """
    found = [known.get(gear.component.number, gear.shift) for gear in gears]
    needed = _sum_of_shifts(gears, distance)
    off = abs(sum(value or 0.0 for value in found) - needed)
    if None not in found and 0.0 in found and distance is not None and off > _TOO_FAR:
        # A value that a program has left out stands in some files as 0.
        place = found.index(0.0)
        source.note("assumed", "a profile shift of 0 contradicts the centre distance and counts as missing", gears[place].component)
        found[place] = None
    lacking = found.count(None)
    if lacking:
        share = (needed - sum(value or 0.0 for value in found)) / lacking
        for place, gear in enumerate(gears):
            if found[place] is None:
                found[place] = known[gear.component.number] = share
                source.note("missing", f"profile shift; {share or 0.0:.4g}, by the centre distance", gear.component)
    return found[0] or 0.0, found[1] or 0.0


def _sum_of_shifts(gears: tuple[Gear, Gear], distance: float | None) -> float:
    """x1 + x2 of flanks without backlash (ISO 21771), teeth of a ring counted negative."""
    if distance is None:
        return 0.0
    count = sum(-gear.teeth if gear.internal else gear.teeth for gear in gears)
    base, transverse = _base_circles(gears)
    if not 0 < base < distance:
        return 0.0
    working = math.acos(base / distance)
    normal = math.radians(gears[0].pressure or 20.0)
    return count * (math.tan(working) - working - math.tan(transverse) + transverse) / (2 * math.tan(normal))


def _width(source: Source, stage: Component, gears: tuple[Gear, Gear]) -> Entry | None:
    widths = [gear.width for gear in gears if gear.width is not None]
    common = source.number(stage, "common_face_width")
    if common is not None and common > 0 and all(common <= 1.001 * width for width in widths):
        return Entry(common, str(stage))
    if common is not None and widths:
        source.note("assumed", f"face width {1e3 * min(widths):g} mm, the smaller one, not {1e3 * common:g} mm", stage)
    if not widths:
        source.wrong(stage, "no face width: face_width of a gear is missing")
        return None
    for gear in gears:
        if gear.width is None:
            source.note("missing", f"face width; {1e3 * min(widths):g} mm, that of its mate", gear.component)
    known = " and ".join(str(gear.component) for gear in gears if gear.width is not None)
    return Entry(min(widths), known + (", the smaller one" if len(widths) > 1 else ""))


def _tips(source: Source, gears: tuple[Gear, Gear], shifts: tuple[float, float]) -> tuple[float, float] | None:
    """Tip diameters; None where one is missing or cannot be."""
    for gear, shift in zip(gears, shifts):
        usual = gear.reference + (-2 if gear.internal else 2) * gear.module
        if gear.tip is not None and abs(gear.tip - usual) > (0.9 + 2 * abs(shift)) * gear.module:
            source.note("assumed", f"a tip diameter of {1e3 * gear.tip:g} mm cannot be, at {gear.teeth} teeth of module "
                                   f"{1e3 * gear.module:g} mm; those of the pair are of the basic rack", gear.component)
            return None
    one, other = (gear.tip for gear in gears)
    if one is not None and other is not None:
        return one, other
    if one is not None or other is not None:
        source.note("missing", "tip diameter; those of the pair are of the basic rack", gears[one is not None].component)
    return None


def _backlash(
    source: Source, stage: Component, gears: tuple[Gear, Gear], distance: float | None, shifts: tuple[float, float]
) -> Entry:
    """Circumferential backlash at the working pitch circles: as computed by another program, or by DIN 3967 and the distance."""
    for section, factor in (("transverse", 1.0), ("normal", _normal_to_circle(gears, distance))):
        least, most = (source.number(stage, f"{end}_{section}_backlash") for end in ("minimum", "maximum"))
        if least is not None and most is not None and 0 <= least <= most:
            mean, told = (least + most) / 2 * factor, ", normal to the flanks" if section == "normal" else ""
            ends = f"{1e6 * least:.0f} and {1e6 * most:.0f} um{told}"
            source.note("assumed", f"backlash {1e6 * mean:.0f} um, the mean of {ends}", stage)
            return Entry(mean, f"{stage}, mean of smallest and largest{told}")
        if least is not None or most is not None:
            source.note("not used", f"{section} backlash: must have a smallest and a largest value from 0 on", stage)
    given = [gear.series for gear in gears if gear.series]
    if not given:
        source.note("missing", f"backlash; that of DIN 3967 {_SERIES}", stage)
    for gear in gears if given else ():
        if not gear.series:
            source.note("missing", f"tooth thickness (DIN 3967); {given[0]}, as of its mate", gear.component)
    names = [gear.series or (given[0] if given else _SERIES) for gear in gears]
    thinning = [mean_thinning(name, gear.reference) for name, gear in zip(names, gears)]
    if thinning[0] is None or thinning[1] is None:
        source.note("missing", f"backlash: DIN 3967 {' and '.join(names)} is in no table; 0", stage)
        return Entry(0.0, f"MISSING: backlash of {stage}")
    count = abs(sum(-gear.teeth if gear.internal else gear.teeth for gear in gears))
    helix = math.cos(math.radians(gears[0].helix))
    wider = 1.0 if distance is None or count == 0 else distance / (count * gears[0].module / (2 * helix))
    # Where axes are farther apart than flanks of full thickness need, that is backlash too.
    apart = 0.0 if distance is None else 2 * gears[0].module * math.tan(math.radians(gears[0].pressure or 20.0)) * (
        _sum_of_shifts(gears, distance) - sum(shifts))
    value = (thinning[0] + thinning[1] + apart) / helix * wider
    word = " and ".join(dict.fromkeys(names))
    more = f", {1e6 * apart / helix * wider:.0f} um of them by the centre distance" if abs(apart) > 0.5e-6 else ""
    if value < 0:
        source.wrong(stage, f"a centre distance of {1e3 * (distance or 0.0):g} mm: teeth thinned by DIN 3967 {word} overlap by "
                            f"{-1e6 * value:.0f} um")
    if given:
        told = f"backlash {1e6 * value:.0f} um, by DIN 3967 {word}: mean tooth thickness, mean distance{more}"
        source.note("assumed", told, stage)
    return Entry(value, (f"{stage}: DIN 3967 {word}" if given else f"MISSING: DIN 3967 {word}") + more)


def _normal_to_circle(gears: tuple[Gear, Gear], distance: float | None) -> float:
    """Backlash at the working pitch circles over that normal to the flanks (ISO 21771)."""
    base, transverse = _base_circles(gears)
    working = transverse if distance is None or distance <= base else math.acos(base / distance)
    helix = math.asin(math.sin(math.radians(gears[0].helix)) * math.cos(math.radians(gears[0].pressure or 20.0)))
    return 1 / (math.cos(working) * math.cos(helix))


def _base_circles(gears: tuple[Gear, Gear]) -> tuple[float, float]:
    """Sum of the base radii [m], that of a ring counted negative; transverse pressure angle [rad]."""
    count = abs(sum(-gear.teeth if gear.internal else gear.teeth for gear in gears))
    normal, helix = math.radians(gears[0].pressure or 20.0), math.radians(gears[0].helix)
    transverse = math.atan(math.tan(normal) / math.cos(helix))
    return count * gears[0].module / (2 * math.cos(helix)) * math.cos(transverse), transverse


def _dedendum(source: Source, gears: tuple[Gear, Gear]) -> Entry:
    """Dedendum of the basic rack, the addendum of a rack-shaped tool over the module; the mean of both gears."""
    found = [(tool, value) for gear in gears for tool in _tools(source, gear.component)
             if (value := source.number(tool, "addendum_coefficient_reference_profile")) is not None and 1 <= value <= 2]
    if not found:
        source.note("missing", "dedendum, as no gear has a rack_shaped_tool; 1.25 modules, as ISO 53 has it")
        return Entry(1.25, "MISSING: no rack-shaped tool; that of ISO 53")
    return Entry(sum(value for _, value in found) / len(found), ", ".join(dict.fromkeys(str(tool) for tool, _ in found)))


def _tools(source: Source, gear: Component) -> list[Component]:
    """The rack-shaped tool that a gear, or the manufacturing of its flanks, refers to."""
    file = source.file
    referred = [roles for kind in ("ordered_reference", "reference") for roles in file.related(kind, origin=gear.number)]
    steps = [roles for flank in _flanks(source, gear) for roles in file.related("manufacturing_step", workpiece=flank.number)]
    found = [roles.get("referenced") for roles in referred] + [roles.get("tool") for roles in steps]
    return [tool for tool in found if tool is not None and tool.kind == "rack_shaped_tool"][:1]


def _moduli(source: Source, gears: tuple[Gear, Gear]) -> tuple[float, float] | None:
    """Moduli of elasticity of the materials; None where none has one."""
    found = [modulus_of(source, gear.component) if material_of(source, gear.component) else None for gear in gears]
    if not any(found):
        return None
    for gear, modulus in zip(gears, found):
        if not modulus or modulus == math.inf:
            source.note("missing", "modulus of elasticity; that of steel, 2.06e11 N/m^2", gear.component)
    one, other = (STEEL if not modulus or modulus == math.inf else modulus for modulus in found)
    return one, other
