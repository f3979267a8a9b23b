"""The numbers of a REXS file in SI units, and the notes on what was assumed, what is missing and what is not used."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, plain, shown
from .rexs_file import Attribute, Component, RexsFile

__all__ = ["Source"]

#: Units by what they measure, that of the standard first: the factor of each to SI, of angles to degrees, of speeds to rpm.
_UNITS = {
    "length": {"mm": 1e-3, "mum": 1e-6, "m": 1.0},
    "direction": {"mm": 1e-3, "none": 1.0, "m": 1.0},
    "number": {"none": 1.0},
    "share": {"%": 0.01, "none": 1.0},
    "angle": {"deg": 1.0, "°": 1.0, "rad": 180 / math.pi},
    "speed": {"1 / min": 1.0, "1 / s": 60.0, "rad / s": 30 / math.pi},
    "torque": {"N m": 1.0, "N mm": 1e-3, "kN m": 1e3},
    "power": {"kW": 1e3, "W": 1.0},
    "inertia": {"kg m^2": 1.0, "kg mm^2": 1e-6},
    "density": {"kg / dm^3": 1e3, "kg / m^3": 1.0, "g / cm^3": 1e3},
    "modulus": {"N / mm^2": 1e6, "MPa": 1e6, "GPa": 1e9, "N / m^2": 1.0},
    "stiffness": {"N mm / rad": 1e-3, "N m / rad": 1.0},
}

#: What attributes measure that are no lengths.
_MEASURED = {
    **dict.fromkeys(("number_of_teeth", "addendum_modification_coefficient", "addendum_coefficient_reference_profile",
                     "poisson_ratio", "gear_shift_index"), "number"),
    **dict.fromkeys(("helix_angle_reference_diameter", "normal_pressure_angle"), "angle"),
    "operating_time_fraction": "share", "u_axis_vector": "direction", "rotational_speed": "speed", "torque_around_u_axis": "torque",
    "power": "power", "moment_of_inertia_u_axis": "inertia", "density": "density", "elastic_modulus": "modulus",
    "shear_modulus": "modulus",
    "rotational_stiffness": "stiffness",
}

#: What the name of an attribute was in other versions of the standard (changelogs of fva-net/rexs-api-java).
_FORMER = {
    "tooth_thickness_deviation_tolerance_series_din_3967_1978": ("din_3967_deviation_tolerance_series",),
    "operating_time_fraction": ("load_duration_fraction",),
}

_TRUTHS = {"true": True, "1": True, "false": False, "0": False}

_LARGEST = 1e30  # of couplings that are meant to be rigid


class Source:
    """A file with its load case, what of it is used, and what is to be said of it.

    Attributes
    ----------
    file : RexsFile
    used : set
        Types of components and names of attributes that were asked for.
    """

    def __init__(self, file: RexsFile, load_case: int | None) -> None:
        self.file = file
        self._notes: dict[tuple[str, str], dict[str, None]] = {}
        self.used: set[tuple[str, str]] = set()
        self.problems: list[str] = []
        self._set: dict[int, Component] = {}
        self._set = self._load_case(load_case)

    # What is to be said.

    def note(self, kind: str, told: str, *of: Any) -> None:
        """Say what was ``assumed``, is ``missing`` or is ``not used``; the same of several components once."""
        self._notes.setdefault((kind, told), {}).update(dict.fromkeys(map(str, of)))

    @property
    def notes(self) -> list[str]:
        """One an assumption; each begins with ``assumed:``, ``missing:`` or ``not used:``."""
        return [plain(": ".join(word for word in (kind, _some([*of]), told) if word)) for (kind, told), of in self._notes.items()]

    def wrong(self, component: Component, told: str, line: int = 0) -> None:
        """Keep a problem; `check` raises them all. Its line is that of the attribute that it begins with, else of the component."""
        of = component.attributes.get(told.split(" ")[0].rstrip(":"))
        line = line or (of.line if of else component.line)
        self.problems.append(f"{self.file.path}:{line}: error: {component.kind} {plain(str(component))}: {told}")

    def refuse(self, told: str) -> NoReturn:
        """End at once, with all problems so far."""
        raise InputError("\n".join([*dict.fromkeys(self.problems), f"{self.file.path}: error: {told}"]))

    def check(self) -> None:
        """Raise the problems so far."""
        if self.problems:
            raise InputError("\n".join(dict.fromkeys(self.problems)))

    # What the file says.

    def find(self, component: Component, name: str) -> Attribute | None:
        """The attribute by its newest name, of the load case before that of the component."""
        for known in (name, *_FORMER.get(name, ())):
            self.used.add((component.kind, known))
            for of in (self._set.get(component.number), component):
                if of is not None and known in of.attributes:
                    found = of.attributes[known]
                    return None if found.value is None or found.value == "" else found
        return None

    def number(self, component: Component, name: str, *, least: float | None = None, required: bool = False) -> float | None:
        """A number in SI units, angles in degrees and speeds in rpm; None where it is absent.

        Parameters
        ----------
        least : float, optional
            What it must be above.
        """
        found = self.find(component, name)
        if found is None:
            if required:
                self.wrong(component, f"{name}: is missing")
            return None
        value = self._real(component, name, found)
        if value is not None and least is not None and not value > least:
            self.wrong(component, f"{name} = {shown(found.value)}: must be above {least:g}", found.line)
            return None
        return value

    def text(self, component: Component, name: str) -> str | None:
        """A text; None where it is absent."""
        found = self.find(component, name)
        return found.value if found is not None and isinstance(found.value, str) else None

    def truth(self, component: Component, name: str) -> bool | None:
        """A truth value; None where it is absent."""
        found = self.find(component, name)
        return self._truth(component, name, found) if found else None

    def truths(self, component: Component, name: str) -> list[bool]:
        """Truth values of a list, or of one value."""
        found = self.find(component, name)
        if found is None:
            return []
        values = found.value if isinstance(found.value, list) else [found.value]
        return [bool(self._truth(component, name, found._replace(value=value))) for value in values]

    def vector(self, component: Component, name: str) -> NDArray[np.float64] | None:
        """Three numbers in SI units; None where they are absent."""
        found = self.find(component, name)
        if found is None or found.value in ([], False):  # a published file has false for vectors that are not given
            return None
        if not isinstance(found.value, list) or len(found.value) != 3:
            self.wrong(component, f"{name} = {shown(found.value)}: must be three numbers", found.line)
            return None
        values = [self._real(component, name, found._replace(value=value)) for value in found.value]
        return None if None in values else np.array(values, dtype=float)

    def _truth(self, component: Component, name: str, found: Attribute) -> bool | None:
        word = str(found.value).strip().lower()
        if word not in _TRUTHS:
            self.wrong(component, f"{name} = {shown(found.value)}: must be true or false", found.line)
        return _TRUTHS.get(word)

    def _real(self, component: Component, name: str, found: Attribute) -> float | None:
        units = _UNITS[_MEASURED.get(name, "length")]
        unit = found.unit or next(iter(units))
        if unit not in units:
            self.wrong(component, f"{name}: unit {shown(unit)}: must be {' or '.join(units)}", found.line)
            return None
        if not found.unit and unit != "none":
            self.note("assumed", f"in {unit}, the unit of the standard, as it has none", f"{name} of {component}")
        try:
            value = float("nan") if isinstance(found.value, (bool, list)) else float(found.value) * units[unit]
        except (TypeError, ValueError, OverflowError):
            value = float("nan")
        if not abs(value) <= _LARGEST:
            self.wrong(component, f"{name} = {shown(found.value)}: must be a number", found.line)
            return None
        return value

    # Load cases.

    def _load_case(self, wanted: int | None) -> dict[int, Component]:
        """What the load case wanted sets; unless told the one of the longest time, where the loads are in load cases alone."""
        cases = self.file.load_cases
        if wanted is not None and not 1 <= wanted <= len(cases):
            raise InputError(f"load_case = {shown(wanted)}: {self.file.path} has "
                             f"{f'load cases 1 to {len(cases)}' if cases else 'no load cases'}")
        if not cases:
            return {}
        if wanted is None and any(name in load.attributes for load in self.file.of_kind("external_load")
                                  for name in ("torque_around_u_axis", "power")):
            self.note("not used", f"a load spectrum of {len(cases)} load cases: loads stand beside it; load_case = 1 ... takes one")
            return {}
        chosen = wanted or 1 + max(range(len(cases)), key=lambda place: self._share(cases[place]))
        if wanted is None:
            shares = ", ".join(f"{place} of {self._share(case):.3g} %" for place, case in enumerate(cases, 1))
            total = sum(map(self._share, cases))
            if total > 100.5:
                shares += f", which are {total:.4g} % together"
            self.note("assumed", f"load case {chosen} of the load spectrum, that of the longest time; load_case takes another: "
                                 f"{shares}")
        return cases[chosen - 1]

    def _share(self, case: dict[int, Component]) -> float:
        """Share of a load case in the time [%]; 0 where it is not told."""
        for component in _of(case.values(), "gear_unit"):
            share = self.number(component, "operating_time_fraction")
            if share is not None and not 0 <= share <= 1:
                self.wrong(component, f"operating_time_fraction = {100 * share:g} %: must be 0 to 100 %")
            elif share is not None:
                return 100 * share
        return 0.0


def _some(names: list[str]) -> str:
    """Names, three at most, and how many more."""
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def _of(components: Iterable[Component], kind: str) -> Iterable[Component]:
    return (component for component in components if component.kind == kind)

