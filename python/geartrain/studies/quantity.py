"""What a study keeps of each result: fields, lists read off a branch, and single numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .._core.box import described
from ..errors import InputError, shown
from ..results.branch import Branch

__all__ = ["Quantity", "check_kept", "taken"]

#: Calls of a train whose group in a results file is not of the same name.
_GROUPS = {"integrate": "integration", "sweep": "integration"}

#: Lists read off a branch: what each is asked for as, the group that describes it, what a row of it is called.
_LISTS = {
    "peaks": ("peaks", "/response/peaks", "peak"),
    "jumps": ("jumps", "/response/jumps", "jump"),
    "bands_without_stability": ("bands", "/response/bands_without_stability", "band"),
    "separation_ranges": ("separation", "/response/separation_ranges", "separation_range"),
    "back_collision_ranges": ("back collision", "/response/back_collision_ranges", "back_collision_range"),
}
_SPECIAL = "special_points"
_DERIVED = {"speed", "speed_from", "speed_to", "fundamental_frequency"}  # there is no speed where the train does not tell
_EXTREME = re.compile(r"(largest|smallest) (?:(mesh|shaft) (\d+) )?(\w+)")
_JUMP = re.compile(r"(first|last) (?:(rising|falling) )?jump(?: (up|down))?")


class Quantity(NamedTuple):
    """Values with the dimensions, the unit and the description that they have in the Dataset."""

    values: NDArray[Any]
    dimensions: tuple[str, ...] = ()
    unit: str = "1"
    description: str = ""


def check_kept(keep: Sequence[str], call: str) -> None:
    """Raise an error where a study cannot keep something of the results of a call."""
    group = described().get(f"/{_GROUPS.get(call, call)}")
    fields = [] if group is None else [name for name in group.about if not name.endswith("_label")]
    of_branch = call == "response"
    known = [*fields, *((*_LISTS, _SPECIAL) if of_branch else ())]
    for name in keep:
        extreme = _EXTREME.fullmatch(name)
        if (of_branch and _JUMP.fullmatch(name)) or (extreme[4] if extreme else name) in known or group is None:
            continue
        near = get_close_matches(extreme[4] if extreme else name, known, n=1)
        meant = f' (did you mean "{near[0]}"?)' if near else f": must be one of {', '.join(known)}"
        raise InputError(f"keep: {shown(name)}: results of {call} have none of this name{meant}; or as in "
                         '"largest dynamic_factor", "smallest mesh 2 minimum", "first jump up", "last falling jump"')


def taken(result: Any, keep: Sequence[str]) -> dict[str, Quantity]:
    """What is kept of a result, by the names in the Dataset."""
    source = _of_branch(result) if isinstance(result, Branch) else _of_dataset(result)
    found: dict[str, Quantity] = {}
    for name in keep:
        if name in _LISTS and isinstance(result, Branch):
            found |= _list(result, name)
        elif name == _SPECIAL and isinstance(result, Branch):
            found |= _specials(result)
        elif extreme := _EXTREME.fullmatch(name):
            found[name] = _extreme(name, extreme, source, result)
        elif jump := _JUMP.fullmatch(name):
            found[name] = _jump(name, jump, result)
        else:
            found[name] = source(name)
            along = found[name].dimensions[:1]
            if name != "frequency" and along in (("point",), ("motion",)):
                found["frequency"] = source("frequency")
                if getattr(result, "parameter_name", ""):
                    found["parameter"] = source("parameter")
    for name, told in (("ended", "why the analysis ended"), ("complete", "whether it got to its end")):
        if hasattr(result, name):
            found[name] = Quantity(np.array(getattr(result, name)), (), "", told)
    return found


def _of_branch(branch: Branch) -> Callable[[str], Quantity]:
    about = described()["/response"].about

    def field(name: str) -> Quantity:
        value = getattr(branch, name, None)
        if value is None or name not in about:
            raise InputError(f"{name}: this branch has none")
        dimensions, unit, told = about[name]
        return Quantity(np.asarray(value), dimensions, branch.parameter_unit if name == "parameter" else unit, told)

    return field


def _of_dataset(result: Any) -> Callable[[str], Quantity]:
    found = None

    def field(name: str) -> Quantity:
        nonlocal found
        if found is None:
            found = result.to_dataset()
        if name not in found:
            raise InputError(f"{name}: the result has none")
        data = found[name]
        return Quantity(data.values, tuple(data.dims), data.attrs.get("units", ""), data.attrs.get("description", ""))

    return field


def _list(branch: Branch, name: str) -> dict[str, Quantity]:
    asked, path, row = _LISTS[name]
    about = described()[path].about
    group = branch._read_off(asked)
    first = next(iter(about))
    columns: dict[str, Quantity] = {}
    for field, (dimensions, unit, told) in about.items():
        # A branch goes over frequency or over a parameter, and its figures have the one or the other.
        if field in {"frequency", "parameter"} - {branch._free_name}:
            continue
        if branch.parameter_name and field in {"parameter", "from", "to"}:
            unit = branch.parameter_unit
        if dimensions[0] == first and field != first and (field in group.arrays or field not in _DERIVED):
            shape = (0, *(branch.rms.shape[1] for _ in dimensions[1:]))
            columns[field] = Quantity(group.column(field, *shape[1:]), (row, *dimensions[1:]), unit, told)
    if name == "peaks":
        of_points = described()["/response"].about
        place, mesh = (columns[field].values.astype(int) - 1 for field in ("point", "mesh"))
        for field in ("mesh_force_maximum", "dynamic_factor"):
            columns[field] = Quantity(getattr(branch, field)[place, mesh], (row,), *of_points[field][1:])
    return {f"{row}_{field}": quantity for field, quantity in columns.items()}


def _specials(branch: Branch) -> dict[str, Quantity]:
    specials, row = branch.special_points, "special_point"
    about = described()["/response/special_points"].about
    values: dict[str, NDArray[Any]] = {
        "kind": np.array([special.kind for special in specials], str),
        "frequency": np.array([special.frequency for special in specials], float),
        **({"parameter": np.array([special.parameter for special in specials], float)} if branch.parameter_name else {}),
        "rms": np.array([special.rms for special in specials], float).reshape(len(specials), branch.rms.shape[1]),
        "undecided": np.array([special.undecided for special in specials], bool),
    }
    return {f"{row}_{name}": Quantity(value, (row, *about[name][0][1:]), *about[name][1:]) for name, value in values.items()}


def _extreme(name: str, words: re.Match[str], source: Callable[[str], Quantity], result: Any) -> Quantity:
    """The largest or smallest value of a field, of the stable motions where stability is known."""
    which, part, number, field = words.groups()
    sources = [_of_branch(branch) for branch in (result, *result.branches)] if isinstance(result, Branch) else [source]
    values = []
    for each in sources:
        array, dimensions, unit, told = each(field)
        if part:
            if part not in dimensions or not 1 <= int(number) <= array.shape[dimensions.index(part)]:
                raise InputError(f"{name}: {field} has no {part} {number}")
            array = array.take(int(number) - 1, dimensions.index(part))
        if isinstance(result, Branch) and dimensions[:1] == ("point",) and result.stable is not None:
            array = array[each("stable").values]
        values.append(array.ravel())
    every = np.concatenate(values)
    every = every[~np.isnan(every)] if every.dtype.kind == "f" else every
    value = (every.max() if which == "largest" else every.min()) if every.size else np.nan
    place = f"of {part} {number} " if part else ""
    return Quantity(np.array(value, float), (), unit, f"{which} {place}of all stable motions: {told}")


def _jump(name: str, words: re.Match[str], result: Any) -> Quantity:
    """Lambda, or value of the branch's parameter, of the first or last jump of a kind; NaN where there is none."""
    which, direction, kind = words.groups()
    jumps = result._read_off("jumps")
    over = result._free_name
    right = np.ones(len(jumps.column(over)), bool)
    if direction:
        right &= jumps.column("direction") == direction
    if kind:
        right &= jumps.column("kind") == f"jump {kind}"
    found = jumps.column(over)[right]
    value = np.nan if not found.size else found.min() if which == "first" else found.max()
    unit, what = (result.parameter_unit, result.parameter_name) if result.parameter_name else ("1", "Lambda")
    return Quantity(np.array(value, float), (), unit, f"{what} of the {name}; NaN where there is none")
