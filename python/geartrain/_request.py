"""What is asked of Fortran, as the text of a case file, and what is wrong with it in the words of the call."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import fields
from itertools import zip_longest
from numbers import Real
from typing import TYPE_CHECKING, Any

from ._box import Box
from ._namelist import group, in_words_of_the_call
from .errors import InputError, shown
from .parts import MESH, SHAFT, Mesh, Shaft

if TYPE_CHECKING:
    from .train import Train

__all__ = ["TRAIN", "case_text", "text_at"]

TRAIN = {
    **dict.fromkeys(("input_torque", "prime_mover_inertia", "load_inertia"), "number"),
    **dict.fromkeys(("characteristic_length", "characteristic_frequency"), "number"),
    **dict.fromkeys(("torque_cos", "torque_sin"), "series"),
    "title": "text",
}
#: The variables of each analysis by their keywords, and their kinds (see _namelist.py).
_ANALYSES: dict[str, dict[str, str]] = {
    "modes": {},
    "response": {
        **dict.fromkeys(("start", "stop", "amplitude_limit", "tolerance", "step"), "number"),
        **dict.fromkeys(("harmonics", "subharmonic", "samples", "max_points", "period_doublings"), "integer"),
        **dict.fromkeys(("coefficients", "control"), "text"),
        **dict.fromkeys(("stability", "branch_points", "refine"), "flag"),
    },
    "integration": {
        **dict.fromkeys(("start", "stop", "tolerance"), "number"),
        **dict.fromkeys(("points", "harmonics", "max_periods"), "integer"),
        "direction": "text",
        "stability": "flag",
    },
    "attractors": {
        **dict.fromkeys(("frequency", "tolerance"), "number"),
        **dict.fromkeys(("starts", "random_seed", "harmonics", "max_periods"), "integer"),
        **dict.fromkeys(("follow", "stability"), "flag"),
    },
    "stability_map": {
        **dict.fromkeys(("start", "stop", "parameter_start", "parameter_stop"), "number"),
        **dict.fromkeys(("points", "parameter_points", "harmonics"), "integer"),
        "parameter": "text",
        "linear": "flag",
    },
}


def case_text(train: Train, analyses: Mapping[str, Mapping[str, Any] | None]) -> str:
    """The train and the analyses wanted, by their groups; raises `InputError` with everything that is wrong with them."""
    problems: dict[str, str] = {}
    text = group("train", TRAIN, {name: getattr(train, name) for name in TRAIN}, problems)
    for number, (shaft, mesh) in enumerate(zip_longest(train.shafts, train.meshes), 1):
        if shaft is not None:
            text += group("shaft", SHAFT, _values(shaft), problems, f"&shaft {number}")
        if mesh is not None:
            text += group("mesh", MESH, _values(mesh), problems, f"&mesh {number}")
    for name, settings in analyses.items():
        if settings is not None:
            text += group(name, _ANALYSES[name], settings, problems)
    if problems:
        raise InputError("\n".join([*problems.values(), *_further_problems(text, problems)]))
    return text


def text_at(train: Train, frequency: float, settings: Mapping[str, Any]) -> str:
    """The case's text for integration at one frequency, which is both ends of the range."""
    if isinstance(frequency, bool) or not isinstance(frequency, Real):
        raise InputError(f"frequency = {shown(frequency)}: must be a number")
    try:
        text = train.namelist(integration={"start": frequency, "stop": frequency, "points": 1, **settings})
        with Box(text):
            return text
    except InputError as error:
        told = in_words_of_the_call(str(error), {"start": "frequency", "stop": "frequency"})
        raise InputError("\n".join(dict.fromkeys(told.splitlines()))) from None


def _values(part: Shaft | Mesh) -> dict[str, Any]:
    return {item.name: getattr(part, item.name) for item in fields(part)}


def _further_problems(text: str, known: Mapping[str, str]) -> list[str]:
    """What Fortran says of the other values; not what follows from the lack of those whose problems are known."""
    try:
        with Box(text):
            return []
    except InputError as error:
        return [line for line in str(error).splitlines() if not any(_follows(line, name) for name in known)]


def _follows(line: str, name: str) -> bool:
    """Whether the problem comes of the lack of a variable, ``&mesh 2: stiffness``, and is not one of its namesake elsewhere."""
    place, _, variable = name.rpartition(": ")
    if not re.search(rf"\b{variable}\b", line):
        return False
    return line.startswith(f"{place}:") or f": {variable} = " not in line
