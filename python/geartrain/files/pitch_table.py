"""Measured pitch errors from a text file: cumulative, a tooth a line."""

from __future__ import annotations

import os
import re
from typing import NamedTuple

from ..errors import InputError, shown

__all__ = ["PitchTable", "read_pitch_table"]

#: Largest file [bytes]: a gear of 100,000 teeth.
_LARGEST = 4 * 2**20
#: Units that a heading may name [m].
_UNITS = {"um": 1e-6, "\N{MICRO SIGN}m": 1e-6, "\N{GREEK SMALL LETTER MU}m": 1e-6, "mm": 1e-3, "m": 1.0}
#: Larger errors, and a table whose largest error is smaller, are a mistake of the unit [m].
_MOST, _LEAST = 1e-3, 1e-9


class PitchTable(NamedTuple):
    """Errors [m], a tooth a value; whether the file gives their unit; its last line."""

    errors: list[float]
    has_unit: bool
    last: int


def read_pitch_table(path: str | os.PathLike[str]) -> PitchTable:
    """Read a table: a line has an error, or the number of a tooth from 1 on and its error; commas, semicolons (with decimal
    commas), tabs or spaces between them. A heading, or a comment ``#``, may have the unit in brackets; else it is um."""
    name = os.fspath(path)
    with open(path, "rb") as stream:
        data = stream.read(_LARGEST + 1)
    if len(data) > _LARGEST:
        raise InputError(f"{name}: error: has more than {_LARGEST >> 20} MB")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[:error.start].count(b"\n") + 1
        raise InputError(f"{name}:{line}: error: no text in UTF-8") from None
    unit: str | None = None
    found: list[float] = []
    last = 0
    for number, row in enumerate(text.splitlines(), 1):
        words = [word for word in re.split(r"[;\t]" if ";" in row or "\t" in row else r"[,\s]", row.strip()) if word.strip()]
        if not words:
            continue
        heading = row.lstrip().startswith("#") or (not found and _number(words[-1]) is None)
        if heading:
            # A number in brackets is that of a component.
            for word in re.findall(r"\[\s*([^\]\d]+?)\s*\]", row):
                if unit is not None or word not in _UNITS:
                    raise InputError(f"{name}:{number}: error: unit {shown(word)}: must be [um], [mm] or [m], once in the file")
                unit = word
            continue
        found.append(_error(f"{name}:{number}", words, len(found) + 1) * _UNITS[unit or "um"])
        last = number
        if abs(found[-1]) > _MOST:
            raise InputError(f"{name}:{number}: error: {shown(words[-1])} {unit or 'um'}: must be at most 1 mm"
                             f"{'' if unit else '; a heading with [um], [mm] or [m] gives the unit'}")
    if not found:
        raise InputError(f"{name}: error: has no numbers: must have a pitch error a tooth")
    largest = max(map(abs, found))
    if 0 < largest < _LEAST:
        raise InputError(f"{name}: error: the largest error is {largest:.3g} m: must be at least 1e-9 m"
                         f"{'' if unit else '; a heading with [um], [mm] or [m] gives the unit'}")
    return PitchTable(found, unit is not None, last)


def _error(place: str, words: list[str], tooth: int) -> float:
    """The error of a line, which is that of a tooth."""
    numbers = [_number(word) for word in words]
    value = numbers[-1]
    if len(numbers) > 2 or None in numbers or value is None or not abs(value) < float("inf"):
        raise InputError(f"{place}: error: {shown(' '.join(words))}: must be a pitch error, or the number of a tooth and its error")
    if len(numbers) == 2 and numbers[0] != tooth:
        raise InputError(f"{place}: error: tooth {shown(words[0])}: must be {tooth}: all teeth in their order, from 1 on")
    return value


def _number(word: str) -> float | None:
    """A number, with a decimal point or comma."""
    try:
        return float(word.replace(",", "."))
    except ValueError:
        return None
