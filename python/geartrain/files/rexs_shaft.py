"""Shafts of a REXS file: sections along an axis, and places on it that gears, loads and couplings take."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .rexs_file import Component
from .rexs_source import Source

__all__ = ["STEEL_DENSITY", "Piece", "Rotor", "density_of", "modulus_of", "read_shaft"]

STEEL_DENSITY, _STEEL_MODULUS, _STEEL_RATIO = 7850.0, 2.06e11, 0.3
#: Moduli of elasticity of solids that gears and shafts are made of [N/m^2]; some programs make a shaft rigid by a larger one.
_MODULI = 5e8, 1e12
#: Sections that overlap by less are rounded [m].
_ROUNDED = 1e-5
#: Places nearer than this part of the shaft's diameter are one.
_NEAR = 0.1


class Piece(NamedTuple):
    """A hollow cylinder that turns: diameters and width [m], density [kg/m^3], and the component it is of."""

    outer: float
    bore: float
    width: float
    density: float
    source: str

    @property
    def mass(self) -> float:
        return math.pi / 4 * self.density * self.width * (self.outer**2 - self.bore**2)

    @property
    def inertia(self) -> float:
        return math.pi / 32 * self.density * self.width * (self.outer**4 - self.bore**4)


class _Section(NamedTuple):
    """A section: its ends on the shaft, its outer and its inner diameters at them [m], its component."""

    begin: float
    end: float
    outer: tuple[float, float]
    bore: tuple[float, float]
    source: Component

    def at(self, u: float, of: tuple[float, float]) -> float:
        return of[0] + (of[1] - of[0]) * (u - self.begin) / (self.end - self.begin)


@dataclass
class Rotor:
    """A shaft: its axis, its sections and the places on it.

    Attributes
    ----------
    component : Component
    origin, axis : ndarray, or None
        Position of u = 0 [m], direction of the axis.
    sections : list
        In their order along the axis.
    density, shear_modulus : float
        [kg/m^3], [N/m^2]; the modulus is infinite of a rigid shaft.
    places : list of float
        u-coordinates [m] of gears, loads and couplings, ascending.
    empty : list of str
        Sections without a length.
    """

    component: Component
    origin: NDArray[np.float64] | None
    axis: NDArray[np.float64] | None
    density: float
    shear_modulus: float
    sections: list[_Section] = field(default_factory=list)
    places: list[float] = field(default_factory=list)
    empty: list[str] = field(default_factory=list)

    @property
    def ends(self) -> tuple[float, float]:
        ends = [section.begin for section in self.sections] + [section.end for section in self.sections] + self.places
        return (min(ends), max(ends)) if ends else (0.0, 0.0)

    def diameters(self, u: float) -> tuple[float, float] | None:
        """Outer and inner diameter at a place; None where no section is."""
        for section in self.sections:
            if section.begin - 1e-9 <= u <= section.end + 1e-9:
                return section.at(u, section.outer), section.at(u, section.bore)
        return None

    def join_near(self, source: Source) -> dict[float, float]:
        """Join places that are nearer than a tenth of the diameter there; the place that each becomes."""
        joined: dict[float, float] = {}
        kept: list[float] = []
        for u in sorted(set(self.places)):
            near = self.diameters(u)
            rigid = math.isinf(self.shear_modulus)
            if kept and (rigid or u - kept[-1] <= max(1e-6, _NEAR * (near[0] if near else 0.0))):
                if u - kept[-1] > 1e-6 and not rigid:
                    source.note("assumed", "places nearer than a tenth of the diameter are one", self.component)
                joined[u] = kept[-1]
            else:
                kept.append(u)
                joined[u] = u
        self.places = kept
        return joined

    def between(self, begin: float, end: float, springs: bool) -> Iterator[Piece]:
        """The sections from one place to another: cylinders of the same torsional stiffness, or else of the same inertia."""
        for section in self.sections:
            first, last = max(begin, section.begin), min(end, section.end)
            if last - first > 1e-9:
                outer = section.at(first, section.outer), section.at(last, section.outer)
                bore = section.at(first, section.bore), section.at(last, section.bore)
                yield Piece(_equal(outer, bore, springs), sum(bore) / 2, last - first, self.density, str(section.source))


def _equal(outer: tuple[float, float], bore: tuple[float, float], spring: bool) -> float:
    """Outer diameter of the cylinder, with the mean bore, that is as stiff in torsion as a cone, or else as heavy to turn."""
    if outer[0] == outer[1] and bore[0] == bore[1]:
        return outer[0]
    points, weights = np.polynomial.legendre.leggauss(16)
    at = (points + 1) / 2
    polar = (outer[0] + (outer[1] - outer[0]) * at) ** 4 - (bore[0] + (bore[1] - bore[0]) * at) ** 4
    mean = 1 / (weights @ (1 / polar) / 2) if spring else weights @ polar / 2
    return float((mean + (sum(bore) / 2) ** 4) ** 0.25)


def read_shaft(source: Source, component: Component) -> Rotor:
    """A shaft with its sections; what is wrong with them is kept in ``source``."""
    axis = source.vector(component, "u_axis_vector")
    length = 0.0 if axis is None else float(np.linalg.norm(axis))
    rotor = Rotor(component, source.vector(component, "support_vector"), None if axis is None or length == 0 else axis / length,
                  density_of(source, component), _shear_modulus(source, component))
    along = 0.0
    for roles in source.file.related("assembly", assembly=component.number):
        section = roles.get("part")
        if section is None or section.kind != "shaft_section":
            continue
        length_of = source.number(section, "length")
        if length_of is None or length_of == 0:
            source.note("not used", f"a section {'without length' if length_of is None else 'of length 0'}", component)
            rotor.empty.append(str(section))
            continue
        if length_of < 0:
            source.wrong(section, f"length = {1e3 * length_of:g} mm: must be above 0")
            continue
        begin = source.number(section, "u_coordinate_on_shaft")
        begin = along if begin is None else begin
        along = begin + length_of
        outer = source.number(section, "outer_diameter_begin", required=True), source.number(section, "outer_diameter_end")
        bore = source.number(section, "inner_diameter_begin"), source.number(section, "inner_diameter_end")
        if outer[0] is None:
            continue
        outers = outer[0], outer[0] if outer[1] is None else outer[1]
        bores = bore[0] or 0.0, (bore[0] if bore[1] is None else bore[1]) or 0.0
        if not all(big > small >= 0 for big, small in zip(outers, bores)):
            source.wrong(section, f"diameters {_millimetres(outers)} outside, {_millimetres(bores)} inside: leave no wall")
            continue
        if outers[0] != outers[1] or bores[0] != bores[1]:
            source.note("assumed", "cones are cylinders of the same torsional stiffness, or of the same inertia", component)
        rotor.sections.append(_Section(begin, along, outers, bores, section))
    rotor.sections.sort(key=lambda section: section.begin)
    for one, other in pairwise(rotor.sections):
        if other.begin < one.end - _ROUNDED:
            source.wrong(other.source, f"begins at {1e3 * other.begin:g} mm of its shaft, within {one.source}, which ends at "
                                       f"{1e3 * one.end:g} mm")
    return rotor


def _millimetres(values: tuple[float, float]) -> str:
    return " and ".join(f"{1e3 * value:g} mm" for value in values)


def material_of(source: Source, component: Component) -> Component | None:
    """The material that a component refers to."""
    found = [roles["referenced"] for roles in source.file.related("reference", origin=component.number)
             if "referenced" in roles and roles["referenced"].kind == "material"]
    if any(material is not found[0] for material in found):
        source.wrong(component, f"has {len(found)} materials: {', '.join(map(str, found))}")
    return found[0] if found else None


def density_of(source: Source, component: Component) -> float:
    """Density of the material [kg/m^3]; 0 of a rigid part without one, which stands in for others."""
    material = material_of(source, component)
    value = None if material is None else source.number(material, "density")
    if value is not None and 100 <= value <= 30000:
        return value
    if value is None and material is not None and modulus_of(source, component) == math.inf:
        source.note("assumed", "without mass, as its material has no density", component)
        return 0.0
    _no_material(source, component, "density" if value is None else f"density, as {value:g} kg/m^3 is none of a metal")
    return STEEL_DENSITY


def modulus_of(source: Source, component: Component) -> float | None:
    """Modulus of elasticity [N/m^2]; None where the material has none, infinite where it means a rigid part."""
    material = material_of(source, component)
    value = None if material is None else source.number(material, "elastic_modulus")
    if value is not None and value > _MODULI[1]:
        source.note("assumed", f"rigid, as a modulus of elasticity of {value:.3g} N/m^2 means", component)
        return math.inf
    if value is not None and value < _MODULI[0]:
        source.note("assumed", f"a modulus of elasticity of {value:.3g} N/m^2 is none of a solid; 2.06e11 N/m^2 (steel)", material)
        return None
    return value


def _shear_modulus(source: Source, component: Component) -> float:
    material = material_of(source, component)
    modulus = modulus_of(source, component)
    ratio = None if material is None else source.number(material, "poisson_ratio")
    given = None if material is None else source.number(material, "shear_modulus", least=0.0)
    if given is not None and modulus != math.inf:
        if modulus is not None and ratio is not None and not math.isclose(given, modulus / (2 * (1 + ratio)), rel_tol=0.02):
            source.note("assumed", f"the shear modulus of {given:g} N/m^2 as given, though modulus of elasticity and Poisson's "
                                   f"ratio make {modulus / (2 * (1 + ratio)):g} N/m^2", material)
        return given
    if modulus is None:
        _no_material(source, component, "modulus of elasticity")
        modulus = _STEEL_MODULUS
    if ratio is not None and not 0 <= ratio < 0.5:
        source.note("assumed", f"a Poisson's ratio of {ratio:g} is none of a solid; 0.3 (steel)", material)
    if ratio is None or not 0 <= ratio < 0.5:
        ratio = _STEEL_RATIO
    return modulus / (2 * (1 + ratio))


def _no_material(source: Source, component: Component, what: str) -> None:
    source.note("missing", f"{what}; that of steel: 7850 kg/m^3, 2.06e11 N/m^2, Poisson's ratio 0.3", component)
