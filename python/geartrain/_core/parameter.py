"""Parameters by their names, ``"mesh 2 half_backlash"``: which variables of a train or of an analysis they are."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from numbers import Real
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, shown
from ..variables import PARTS, VARIABLES
from .box import Box
from .description import Description
from .gradient import refuse_without_effect
from .namelist import parse
from .variable import Part, Variable

__all__ = [
    "Target", "add_targets", "assigned", "check_effects", "checked_column", "label", "own_value", "targets_of", "value_in",
    "with_values",
]

AnyTrain = TypeVar("AnyTrain", bound=Description)

_VARIATION = "stiffness_variation"
_WHOLE = {"teeth"}  # lists of whole numbers: no multiples of them


class Target(NamedTuple):
    """A variable that a parameter sets.

    Attributes
    ----------
    place : str
        ``'train'``, ``'mesh 2'``, ``'shaft 1'``, ``'body 3'`` or the name of the analysis.
    variable : str
        Its keyword.
    element : int
        Which value of a list, from 1; 0 for a variable of one value, and for a list of one value.
    factor : float
        What the value of the parameter is multiplied by.
    """

    place: str
    variable: str
    element: int
    factor: float = 1.0

    @property
    def kind(self) -> str:
        """Kind of a value, as in the table of variables; ``''`` of an argument that is not in it."""
        row = VARIABLES.get(self.place.partition(" ")[0], {}).get(self.variable)
        return "" if row is None else row.kind.removesuffix("s") if row.kind.endswith("s") else row.kind


def label(name: Any) -> str:
    """The name of a parameter, several that take the same value separated by commas."""
    names = name if isinstance(name, tuple) else (name,)
    if not names or not all(isinstance(item, str) for item in names):
        raise InputError(f"parameter {shown(name)}: must be a name, or a tuple of names")
    return ", ".join(item.strip() for item in names)


def add_targets(name: str, found: Sequence[Target], known: list[Target]) -> None:
    """Add the variables that a parameter sets to those that others set; none may be set twice."""
    for target in found:
        if any(target[:2] == other[:2] and target.element in (0, other.element) for other in known):
            raise InputError(f"parameter {shown(name)}: {target.place} {target.variable} is set by another one as well")
        known.append(target)


def targets_of(name: str, train: Description, analysis: str, settings: Mapping[str, Any], relative: bool = False) -> list[Target]:
    """The variables that a parameter sets.

    Parameters
    ----------
    name : str
        As in a case: a variable of ``&train``; ``mesh``, ``shaft`` or ``body``, a number or ``*`` for all, and a variable; a body's
        own name and a variable; the name of the analysis and a variable of it; ``stiffness_variation``. After a variable that is
        a list the number of one of its values. Several, separated by commas, are set together.
    train : Description
    analysis : str
        The call of the study.
    settings : mapping
        Its keywords with their values.
    relative : bool
        Whether values are multiples of the train's own.
    """
    found = [target for item in name.split(",") for target in _targets(item.strip(), train, analysis, settings, relative)]
    if not relative:
        return found
    return [target._replace(factor=_own(target, train, settings)) if target.factor == 1 else target for target in found]


def _targets(name: str, train: Description, analysis: str, settings: Mapping[str, Any], relative: bool) -> list[Target]:
    if name == _VARIATION:
        return _variation(train, relative)
    places = _places(train, analysis)
    parsed = re.fullmatch(r"(?:(.+) )??([a-z]\w*)(?: (\d+))?", name)
    place, variable, element = (parsed[1] or "train", parsed[2], int(parsed[3] or 0)) if parsed else ("", "", 0)
    if parsed and parsed[3] and not element:
        raise InputError(f"parameter {shown(name)}: the values of a list are numbered from 1")
    words = places.get(place, ())
    if not words and (counted := _beyond(place, train)):
        raise InputError(f"parameter {shown(name)}: {counted}")
    if not words or variable not in _variables(words[0], settings if place == analysis else {}):
        raise InputError(f"parameter {shown(name)}: there is none of this name{_meant(name, places, settings, analysis)}")
    targets = []
    for word in words:
        target = Target(word, variable, element)
        values = own_value(target, train, settings)
        if not _is_list(target):
            if element:
                raise InputError(f"parameter {shown(name)}: {variable} is no list")
        elif element > len(values):
            raise InputError(f"parameter {shown(name)}: {variable} of {word} has {len(values)} values")
        elif not element and len(values) > 1:
            if not relative or variable in _WHOLE:
                scale = ", or relative=True to scale them all" if analysis != "train" and variable not in _WHOLE else ""
                raise InputError(f"parameter {shown(name)}: {variable} of {word} has {len(values)} values: say which, "
                                 f"'{name} 1'{scale}")
            targets += [target._replace(element=place) for place in range(1, len(values) + 1)]
            continue
        targets.append(target._replace(element=0) if _is_list(target) and len(values) == 1 else target)
    return targets


def _variation(train: Description, relative: bool) -> list[Target]:
    """All harmonics of kappa, scaled alike so that the largest amplitude of any mesh is the value, as over it elsewhere."""
    if derived := _derived(train):
        raise InputError(f"parameter {_VARIATION!r}: the harmonics of mesh {derived[0]} follow from its drawing, contact ratio or "
                         "table: give them, or take the train that with_values gives for a value")
    rows = [
        (Target(f"mesh {number}", variable, element if len(values) > 1 else 0), float(value))
        for number, mesh in enumerate(train.meshes, 1)
        for variable in ("stiffness_cos", "stiffness_sin")
        for values in [getattr(mesh, variable) or ()]
        for element, value in enumerate(values, 1)
    ]
    squares: dict[tuple[str, int], float] = {}
    for target, value in rows:
        harmonic = target.place, max(target.element, 1)
        squares[harmonic] = squares.get(harmonic, 0.0) + value**2
    largest = max(squares.values(), default=0.0) ** 0.5
    if not largest:
        raise InputError(f"parameter {_VARIATION!r}: no mesh is given a stiffness_cos or stiffness_sin to scale")
    return [target._replace(factor=value if relative else value / largest) for target, value in rows]


def _derived(train: Description) -> list[int]:
    """Numbers of the meshes whose harmonics follow from a drawing, a contact ratio or a table."""
    free = [number for number, mesh in enumerate(train.meshes, 1) if not (mesh.stiffness_cos or mesh.stiffness_sin)]
    explained = train.explain() if free else {}
    return [number for number in free if {"stiffness_cos", "stiffness_sin"} & explained[f"mesh {number}"].keys()]


def _with_harmonics_given(train: AnyTrain) -> AnyTrain:
    """The same train with all harmonics of its mesh stiffnesses given, as continuation over them has it."""
    if not _derived(train):
        return train
    with Box(copy=train._kept) as box:
        groups = parse(box.text("case with variation"))
    _, kind = PARTS["mesh"]
    return replace(train, meshes=[kind(**values) for name, values in groups if name == "mesh"])


def _places(train: Description, analysis: str) -> dict[str, list[str]]:
    """What may stand before a variable, and the places that it means."""
    places = {"train": ["train"], analysis: [analysis]}
    for kind, (parts, _) in PARTS.items():
        own = [f"{kind} {number}" for number in range(1, 1 + len(getattr(train, parts)))]
        places |= {place: [place] for place in own} | ({f"{kind} *": own} if own else {})
        for place, part in zip(own, getattr(train, parts)):
            if getattr(part, "name", None):
                places.setdefault(part.name, [place])
                places.setdefault(f"{kind} {part.name}", [place])
    return places


def _beyond(place: str, train: Description) -> str:
    """What to say of a number beyond those of its kind; empty of another place."""
    kind, _, number = place.partition(" ")
    if kind not in PARTS or not (number.isdecimal() or number == "*"):
        return ""
    parts = len(getattr(train, PARTS[kind][0]))
    if not parts:
        return f"the train has no &{kind}"
    return f"the train has &{kind} 1" + (f" to {parts}" if parts > 1 else "")


def _variables(place: str, settings: Mapping[str, Any]) -> Iterable[str]:
    """The variables of a place; those of an analysis are its keywords."""
    rows: Mapping[str, Variable] = VARIABLES.get(place.partition(" ")[0], {})
    return {**rows, **settings} if settings else rows


def _meant(name: str, places: Mapping[str, list[str]], settings: Mapping[str, Any], analysis: str) -> str:
    known = [_VARIATION] + [
        variable if place == "train" else f"{place} {variable}"
        for place, words in places.items() for variable in _variables(words[0], settings if place == analysis else {})
    ]
    near = get_close_matches(re.sub(r" \d+$", "", name), known, n=1)
    return f' (did you mean "{near[0]}"?)' if near else ': it is a variable of &train, or as in "mesh 2 half_backlash"'


def _part(train: Description, place: str) -> Part:
    kind, _, number = place.partition(" ")
    part: Part = getattr(train, PARTS[kind][0])[int(number) - 1] if number else train
    return part


def _is_list(target: Target) -> bool:
    row = VARIABLES.get(target.place.partition(" ")[0], {}).get(target.variable)
    return row is not None and row.kind.endswith("s")


def own_value(target: Target, train: Description, settings: Mapping[str, Any]) -> Any:
    """The own value of a variable; no value of a list that is not given is an empty list."""
    named = target.place.partition(" ")[0] in ("train", *PARTS)
    value = getattr(_part(train, target.place), target.variable) if named else settings.get(target.variable)
    if not _is_list(target):
        return value
    return () if value is None else value if isinstance(value, Sequence) else (value,)


def _own(target: Target, train: Description, settings: Mapping[str, Any]) -> float:
    value = own_value(target, train, settings)
    if _is_list(target):
        value = value[max(0, target.element - 1)] if value else None
    if value is None or isinstance(value, (bool, str)):
        raise InputError(f"parameter {target.place} {target.variable}: has no number of its own that relative=True could multiply")
    return float(value)


def value_in(train: Description, name: str) -> float | None:
    """The value of a parameter in a train, of several parts that of the first; None where the train does not give it."""
    for target in targets_of(name, train, "train", {}):
        value = own_value(target, train, {})
        if _is_list(target):
            value = value[max(0, target.element - 1)] if value else None
        if target.factor and isinstance(value, Real) and not isinstance(value, bool):
            return float(value) / target.factor
    return None


def checked_column(target: Target, values: NDArray[Any]) -> NDArray[Any]:
    """The values of a variable at every point, of its type, from those of its parameter."""
    kind, found = target.kind, values
    if target.factor != 1:
        found = np.asarray(values, float) * target.factor
    numbers = found.dtype.kind in "biuf"
    if kind == "integer" and numbers and (found == np.round(found)).all():
        return found.astype(np.int64)
    if kind == "real" and numbers and found.dtype.kind != "b":
        return found.astype(np.float64)
    if kind == "logical" and found.dtype.kind == "b":
        return found
    if kind in ("text", "name") and found.dtype.kind in "UOT":
        return found.astype(str)
    if not kind and found.dtype.kind in "biufU":
        return found
    wrong = [place for place, value in enumerate(values.tolist()) if kind not in ("real", "integer") or not _fits(value, kind)]
    which = shown(values.tolist())
    if wrong and len(values) > 1:
        which = f"value {wrong[0]}, counted from 0, {shown(values[wrong[0]].item())}"
    raise InputError(f"{target.place} {target.variable}: {which}: must be of type {kind or 'number or text'}")


def _fits(value: Any, kind: str) -> bool:
    """Whether a value, perhaps as a text, is a number of a kind."""
    try:
        number = float(value)
    except (ValueError, OverflowError):  # a text, or an integer beyond all numbers
        return False
    return kind == "real" or number == round(number)


def assigned(
    train: AnyTrain, settings: Mapping[str, Any], targets: Sequence[Target], values: Sequence[Any]
) -> tuple[AnyTrain, dict[str, Any]]:
    """The train and the settings with the values of the targets in place of their own."""
    changes: dict[str, dict[str, Any]] = {}
    for target, value in zip(targets, values):
        place = changes.setdefault(target.place, {})
        if target.element:
            known = place.get(target.variable)
            now = list(own_value(target, train, settings)) if known is None else known
            now[target.element - 1] = value
            value = now
        elif _is_list(target) and not isinstance(value, list):
            value = [value]
        place[target.variable] = value
    own = changes.pop("train", {})
    further = dict(settings)
    for kind, (parts, _) in PARTS.items():
        if any(place.startswith(f"{kind} ") for place in changes):
            own[parts] = tuple(
                replace(part, **changes.pop(f"{kind} {number}", {})) for number, part in enumerate(getattr(train, parts), 1)
            )
    for values_of_call in changes.values():
        further |= values_of_call
    return (replace(train, **own) if own else train), further


def with_values(train: AnyTrain, values: Mapping[str, Any]) -> AnyTrain:
    """The train with the values of parameters in place of its own."""
    targets: list[Target] = []
    numbers: list[Any] = []
    lists: dict[Target, Any] = {}
    if not isinstance(values, Mapping):
        raise InputError(f"values = {shown(values)}: must be a mapping of values by names")
    for key, value in values.items():
        name = label(key)
        if not isinstance(value, (str, bool, Real, np.generic)) and getattr(value, "shape", None) != ():
            lists |= _list_of(train, name, value)
            continue
        if _VARIATION in name.replace(" ", "").split(","):
            train = _with_harmonics_given(train)
        found = targets_of(name, train, "train", {})
        add_targets(name, found, targets)
        numbers += [checked_column(target, np.asarray([value]))[0].item() for target in found]
    for target in lists:
        add_targets(target.place, [target], targets)
    changed = assigned(train, {}, targets, [*numbers, *lists.values()])[0]
    check_effects(changed, [target for target in targets if target not in lists])
    return changed


def _list_of(train: Description, name: str, values: Any) -> dict[Target, list[float]]:
    """All values of a list of numbers, by the variables that take them."""
    place, _, variable = name.rpartition(" ")
    row = VARIABLES.get(_places(train, "train").get(place or "train", [""])[0].partition(" ")[0], {}).get(variable)
    numbers = np.asarray(values)
    if row is None or row.kind != "reals" or numbers.ndim != 1 or numbers.dtype.kind not in "iuf":
        raise InputError(f"parameter {shown(name)}: {shown(values)}: must be one value, or numbers of a list; a value of a list is "
                         "named by its number, as in 'mesh 1 stiffness_cos 2'")
    return {Target(part, variable, 0): [float(value) for value in numbers] for part in _places(train, "train")[place or "train"]}


def check_effects(train: Description, targets: Sequence[Target]) -> None:
    """Refuse variables of a train that nothing follows from, such as the diameter of a shaft whose stiffness is given."""
    names = [f"{place} {variable}".removeprefix("train ") + (f" {element}" if element else "")
             for place, variable, element, _ in targets if place.partition(" ")[0] in ("train", *PARTS)]
    refuse_without_effect(Box(copy=train._kept), names)
