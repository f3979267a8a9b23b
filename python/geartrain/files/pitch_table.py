"""Measured pitch errors from a text file, as a measuring machine or a spreadsheet writes it: a tooth a line."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple

from ..errors import InputError, shown
from .text_file import decoded, read_bytes

__all__ = ["PitchTable", "read_pitch_table"]

#: Largest file [bytes]: a gear of 100,000 teeth.
_LARGEST = 4 * 2**20
#: Units that a heading may name [m], and some that it may not.
_UNITS = {**dict.fromkeys(("um", "\N{MICRO SIGN}m", "\N{GREEK SMALL LETTER MU}m", "mum"), 1e-6), "mm": 1e-3, "nm": 1e-9, "m": 1.0}
_REFUSED = {"cm", "inch", "in", "zoll", "mil", "thou", "uin", "deg", "rad", "mrad", "urad", "arcsec", "arcmin", "\N{DEGREE SIGN}"}
#: Larger errors, and errors of a smaller range, are a mistake of the unit [m]: class 1 of ISO 1328-1 allows a micrometre and more.
_MOST, _LEAST = 1e-3, 0.5e-6
#: Headings of columns, without spaces and underscores: Fp and fp of ISO 1328-1, or words.
_CUMULATIVE = re.compile(r"Fp|(?i:.*(cumul|accumul|total|summe|gesamt))")
_SINGLE = re.compile(r"fp|(?i:.*(single|individual|adjacent|einzel))")


class PitchTable(NamedTuple):
    """Cumulative errors [m], a tooth a value; the last line of them; what was assumed."""

    errors: list[float]
    last: int
    assumed: list[str]


class _Row(NamedTuple):
    """A line of numbers: its number, its words, their values."""

    line: int
    words: list[str]
    values: list[float]


def read_pitch_table(path: str | os.PathLike[str]) -> PitchTable:
    """Read a table: a line has an error, or the number of a tooth and its error.

    Between numbers stand commas, semicolons, tabs or spaces; with all but commas alone a comma is a decimal comma. Text may stand
    before and after the numbers. The heading of the column, or a comment ``#``, may have the unit; else it is um. Of several
    columns that of cumulative errors counts by its heading, ``Fp``; single pitch errors, ``fp``, are summed.
    """
    name = os.fspath(path)
    lines = decoded(name, read_bytes(path, _LARGEST)).splitlines()
    rows, heads = _rows(name, lines)
    columns = _headings(lines, rows[0], heads)
    place, single = _column(name, rows, heads, columns)
    if single is None:  # a line of text before the numbers may say it
        told = [_squeezed(word) for line in heads for word in lines[line - 1].split()]
        single = any(map(_SINGLE.match, told)) and not any(map(_CUMULATIVE.match, told))
    unit = _unit_of(name, heads[-1], columns[place]) if columns[place] else None
    for line in heads if unit is None else []:
        if (line == heads[-1] and not any(columns)) or re.match(r"\s*(#|unit|einheit)", lines[line - 1], re.IGNORECASE):
            found = _unit_of(name, line, lines[line - 1])
            if found and unit and found != unit:
                raise InputError(f"{name}:{line}: error: unit {shown(found)}: another line has {shown(unit)}")
            unit = found or unit
    values = [row.values[place] * _UNITS[unit or "um"] for row in rows]
    assumed = [] if unit else ["in um, as no heading has a unit"]
    if single:
        values = _summed(name, rows, place, values)
        assumed.append("single pitch errors, summed from tooth 1 on")
    _check_size(name, rows, place, values, unit, assumed)
    return PitchTable(values, rows[-1].line, assumed)


def _rows(name: str, lines: Sequence[str]) -> tuple[list[_Row], list[int]]:
    """The lines of numbers, and the numbers of the lines of text before them, of comments too."""
    rows: list[_Row] = []
    heads: list[int] = []
    after = 0
    comma = _has_decimal_commas(lines)
    for number, line in enumerate(lines, 1):
        words = _cells(line, "" if comma else _separator(line))
        values = [_number(word) for word in words]
        is_text = [value is None and word != "" for word, value in zip(words, values)]
        if not line.strip() or line.lstrip().startswith("#") or (is_text[0] if rows else any(is_text)):
            heads += [number] if line.strip() and not rows else []
            after = after or (number if rows and line.strip() and not line.lstrip().startswith("#") else 0)
            continue
        place = f"{name}:{number}: error: {shown(line.strip())}"
        if after:
            raise InputError(f"{name}:{after}: error: {shown(lines[after - 1].strip())}: stands between lines of numbers")
        if any(is_text) or not all(abs(value or 0.0) < float("inf") for value in values):
            raise InputError(f"{place}: must be a pitch error, or the number of a tooth and its error")
        if None in values:
            raise InputError(f"{place}: a number is missing")
        if rows and len(words) != len(rows[0].words):
            raise InputError(f"{place}: has {len(words)} numbers, and line {rows[0].line} has {len(rows[0].words)}")
        rows.append(_Row(number, words, [value or 0.0 for value in values]))
    if not rows:
        raise InputError(f"{name}: error: has no numbers: must have a pitch error a tooth")
    return rows, heads


def _separator(line: str) -> str:
    """What stands between the words of a line; a comma without a space beside spaces is a decimal comma."""
    found = next((mark for mark in ";\t" if mark in line), "")
    return found or ("," if re.search(r",\s", line) or ("," in line and not re.search(r"\s", line.strip())) else " ")


def _cells(line: str, separator: str) -> list[str]:
    """The words of a line, of which the last may be followed by a separator."""
    if separator in ("", " "):
        return line.split() or [""]
    words = [word.strip() for word in line.strip(" ").split(separator)]
    return words[:-1] if len(words) > 2 and not words[-1] else words


def _has_decimal_commas(lines: Sequence[str]) -> bool:
    """Whether all commas are within numbers of a single column: they do not follow the numbers of teeth."""
    pairs = [match for line in lines if (match := re.fullmatch(r"\s*([-+]?\d*),\d+\s*", line))]
    teeth = [[str(number) for number in range(first, first + len(pairs))] for first in (0, 1)]
    return bool(pairs) and [pair[1] for pair in pairs] not in teeth and not any(_separator(line) in ";\t" for line in lines)


def _headings(lines: Sequence[str], first: _Row, heads: Sequence[int]) -> list[str]:
    """The headings of columns: the last line of text before the numbers, where it has as many; else each is ''."""
    none = [""] * len(first.values)
    if not heads:
        return none
    line = lines[heads[-1] - 1].lstrip("# ")
    separator = _separator(lines[first.line - 1])
    found = re.findall(r"[^\s\[(]+(?:\s*\[[^]]*\]|\s*\([^)]*\)|\s+in\s+\S+|\s*/\s*\S+)?", line) if separator == " " else \
        _cells(line, separator) if len(none) > 1 else [line]
    if len(none) == 1 and len(found) > 1:
        found = [line]
    return found if len(found) == len(none) else none


def _squeezed(heading: str) -> str:
    return re.sub(r"[\s_'\"#]", "", heading)


def _column(name: str, rows: Sequence[_Row], heads: Sequence[int], columns: Sequence[str]) -> tuple[int, bool | None]:
    """Place of the column of errors, and whether they are of single pitches; None where its heading does not say."""
    kinds = [1 if _CUMULATIVE.match(_squeezed(column)) else 2 if _SINGLE.match(_squeezed(column)) else 0 for column in columns]
    places = list(range(len(columns)))
    if len(columns) > 1 and not kinds[0]:
        _check_teeth(name, rows)
        places = places[1:]
    for kind in (1, 2):
        found = [place for place in places if kinds[place] == kind]
        if len(found) > 1:
            told = " and ".join(shown(columns[place]) for place in found)
            raise InputError(f"{name}:{heads[-1]}: error: {told}: must be one column of {'cumulative' if kind == 1 else 'single'} "
                             "pitch errors, that of the flank that bears")
        if found:
            return found[0], kind == 2
    if len(places) > 1:
        raise InputError(f"{name}:{rows[0].line}: error: {shown(' '.join(rows[0].words))}: must be a pitch error, or the number of "
                         "a tooth and its error; of more columns a heading 'Fp' (cumulative) or 'fp' (single) says which")
    return places[0], None


def _check_teeth(name: str, rows: Sequence[_Row]) -> None:
    """The first of several columns numbers the teeth, from 1 or from 0 on in their order."""
    begin = 0 if all(row.values[0] == place for place, row in enumerate(rows)) else 1
    for place, row in enumerate(rows, begin):
        if row.values[0] != place:
            raise InputError(f"{name}:{row.line}: error: tooth {shown(row.words[0])}: must be {place}: all teeth in their order; "
                             "where a comma is a decimal comma, semicolons or spaces part the numbers")


def _unit_of(name: str, line: int, text: str) -> str | None:
    """The unit that a text has in brackets, after 'in', 'unit' or '/'; None where it has none."""
    bracketed = re.findall(r"\[\s*([^\]\d]+?)\s*\]", text)  # a number in brackets is that of a component
    others = [next(filter(None, words)) for words in
              re.findall(r"\(\s*([^)\s]+?)\s*\)|\bin\s+(\S+)\s*$|/\s*(\S+)\s*$|(?i:unit|einheit)[\s:;=,\t]+(\S+)", text)]
    found = [*bracketed, *(word for word in others if word in _UNITS or word.lower() in _REFUSED)]
    if any(word not in _UNITS for word in found) or len({*found}) > 1:
        raise InputError(f"{name}:{line}: error: unit {shown(' and '.join(found))}: must be [um], [mm], [nm] or [m], once")
    return found[0] if found else None


def _summed(name: str, rows: Sequence[_Row], place: int, values: list[float]) -> list[float]:
    """Cumulative errors of single ones, which sum to 0 round the revolution, but for what was rounded."""
    last = min(int(Decimal(row.words[place].replace(",", ".")).as_tuple().exponent) for row in rows)
    scale = max((value / row.values[place] for value, row in zip(values, rows) if row.values[place]), default=0.0)
    total, allowed = sum(values), scale * 10.0**last * len(values)**0.5
    if abs(total) > allowed:
        raise InputError(f"{name}: error: single pitch errors sum to {total / (scale or 1.0):.4g}: must be 0 round the revolution, "
                         f"to {allowed / (scale or 1.0):.2g} by their rounding")
    found, reached = [], 0.0
    for value in values:
        reached += value - total / len(values)
        found.append(reached)
    return found


def _check_size(
    name: str, rows: Sequence[_Row], place: int, values: Sequence[float], unit: str | None, assumed: list[str],
) -> None:
    """Errors that are too large or too small for a gear are in another unit."""
    hint = "" if unit else "; a heading with [um], [mm] or [m] gives the unit"
    for row, value in zip(rows, values):
        if abs(value) > _MOST:
            raise InputError(f"{name}:{row.line}: error: {shown(row.words[place])} {unit or 'um'}: must be at most 1 mm{hint}")
    spread = max(values) - min(values)
    if 0 < spread < _LEAST and not unit:
        raise InputError(f"{name}: error: the errors differ by {1e6 * spread:.3g} um: must be at least {1e6 * _LEAST:g} um{hint}")
    if 0 < spread < _LEAST:
        assumed.append(f"errors that differ by {1e6 * spread:.3g} um alone: smaller than any class of ISO 1328-1 allows")


def _number(word: str) -> float | None:
    """A number, with a decimal point or comma."""
    try:
        return float(word.replace(",", "."))
    except ValueError:
        return None
