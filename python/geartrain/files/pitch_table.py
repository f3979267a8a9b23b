"""Measured pitch errors from a text file, as a measuring machine or a spreadsheet writes it: a tooth a line."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Sequence
from decimal import Decimal
from itertools import pairwise
from typing import NamedTuple

from ..errors import InputError, shown
from .pitch_heading import UNITS, is_unit, kind_of, read_heading, unit_of, unit_of_comment, values_in
from .text_file import decoded, read_bytes

__all__ = ["PitchTable", "read_pitch_table"]

#: Largest file [bytes]: a gear of 100,000 teeth.
_LARGEST = 4 * 2**20
#: Larger errors, and errors of a smaller range, are a mistake of the unit [m]: class 1 of ISO 1328-1 allows a micrometre and more.
_MOST, _LEAST = 1e-3, 0.5e-6


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
    columns the one headed ``Fp``, cumulative errors, is read; a column ``fp`` alone, single pitch errors, is summed. The name
    ``table.txt#Fp left`` asks for the column with this heading.
    """
    name, wanted = os.fspath(path), ""
    if "#" in name and not os.path.exists(name):
        name, _, wanted = name.rpartition("#")
    lines = _without_bars(decoded(name, read_bytes(name, _LARGEST)).splitlines())
    rows, heads = _rows(name, lines)
    columns = _headings(name, lines, rows[0], heads)
    place = _column(name, rows, heads, columns, wanted, "," in lines[rows[0].line - 1])
    kind, unit = read_heading(f"{name}:{heads[-1] if heads else 1}", columns[place], chosen=bool(wanted))
    comments = [line for line in heads if re.match(r"(?i)\s*(#|unit|einheit)", lines[line - 1]) or values_in(lines[line - 1])]
    for line in comments if unit is None else [line for line in comments if re.search(r"(?i)\b(unit|einheit)", lines[line - 1])]:
        found = unit_of_comment(f"{name}:{line}", lines[line - 1])
        if found and unit and found != unit:
            raise InputError(f"{name}:{line}: error: unit {shown(found)}: another line has {shown(unit)}")
        unit = found or unit
    if kind == 0 and any(re.search(r"(?i)(single|individual|adjacent) pitch|einzelteilung", lines[line - 1]) for line in comments):
        kind = 2
    values = [row.values[place] * UNITS[unit or "um"] for row in rows]
    assumed = [] if unit else ["in um, as no heading has a unit"]
    if kind == 2:
        values = _summed(name, rows, place, values)
        assumed.append("single pitch errors, summed from tooth 1 on")
    elif kind == 0:
        assumed.append("cumulative, as no heading has 'fp' or 'single'")
    elif _contradicts(rows, columns, place):
        assumed.append(f"{columns[place]} holds, though the single errors beside it are not its differences")
    _check_size(name, rows, place, values, unit)
    return PitchTable(values, rows[-1].line, assumed)


def _without_bars(lines: list[str]) -> list[str]:
    """Bars between columns as semicolons; between groups of columns they part nothing more than spaces do."""
    cells = [line.strip().strip("|").split("|") for line in lines if "|" in line]
    words = [cell.split() for row in cells for cell in row]
    grouped = any(len(cell) > 1 and all(_number(word) is not None for word in cell) for cell in words)
    return [line.strip().strip("|").replace("|", "  " if grouped else ";") if "|" in line else line for line in lines]


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
            heads += [number] if re.search(r"\w|\[|#", line) and not rows else []  # no rules
            again = any(line.split() == lines[head - 1].split() for head in heads)  # as on the next page
            after = after or (number if rows and line.strip() and not line.lstrip().startswith("#") and not again else 0)
            continue
        place = f"{name}:{number}: error: {shown(line.strip())}"
        if after:
            raise InputError(f"{name}:{after}: error: {shown(lines[after - 1].strip())}: stands between lines of numbers: must be "
                             "one table, of one flank or with a column for each")
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
        words = line.split() or [""]
    elif '"' in line:
        words = next(csv.reader([line.strip()], delimiter=separator))
    else:
        words = line.strip(" ").split(separator)
    words = [word.strip().strip("\"'").replace("\N{MINUS SIGN}", "-") for word in words]
    return words[:-1] if len(words) > 2 and not words[-1] else words


def _has_decimal_commas(lines: Sequence[str]) -> bool:
    """Whether all commas are within numbers of a single column: they do not follow the numbers of teeth."""
    pairs = [match for line in lines if (match := re.fullmatch(r"\s*([-+]?\d*),\d+\s*", line))]
    teeth = [[str(number) for number in range(first, first + len(pairs))] for first in (0, 1)]
    return bool(pairs) and [pair[1] for pair in pairs] not in teeth and not any(_separator(line) in ";\t" for line in lines)


def _headings(name: str, lines: Sequence[str], first: _Row, heads: Sequence[int]) -> list[str]:
    """The headings of columns: the last line of text before the numbers, above which a line of units may stand; else each is ''."""
    count = len(first.values)
    found = [_split(lines[line - 1], _separator(lines[first.line - 1]), count) for line in heads[-2:]]
    if not found or not any(found[-1]):
        text = lines[heads[-1] - 1] if heads else ""
        if not text.lstrip().startswith("#") and any(is_unit(word) or re.fullmatch(r"[Ff]_?p\w*", word)
                                                     for word in re.split(r"[\s;,()\[\]/]+", text)):
            raise InputError(f"{name}:{heads[-1]}: error: {shown(text.strip())}: must have a heading for each of {count} columns, "
                             "parted as the numbers are")
        return [""] * count
    units = [unit_of(cell.strip("[]() ")) or "" for cell in found[-1]]
    if len(found) > 1 and any(found[0]) and all(unit or cell in ("", "-", "[-]") for unit, cell in zip(units[1:], found[-1][1:])):
        return [f"{above} [{unit}]" if unit else above for above, unit in zip(found[0], units)]
    named = [heading for heading in found[-1] if heading]
    if len(heads) > 1 and len({*named}) < len(named):
        groups = _groups(lines[heads[-2] - 1], count)
        return [f"{group} {own}".strip() for group, own in zip(groups, found[-1])]
    return found[-1]


def _groups(line: str, count: int) -> list[str]:
    """The heading of the group of each column, where the line has some: over the first column of a group, or over all alike."""
    mark = next((mark for mark in ";\t" if mark in line), "")
    if mark:
        cells = [cell.strip() for cell in line.split(mark)][:count]
        return [next((cell for cell in reversed(cells[:place + 1]) if cell), "") for place in range(count)]
    cells = [cell for cell in re.split(r"\s{2,}", line.strip()) if cell]
    if len(cells) < 2 or (count - 1) % len(cells) != 0:
        return [""] * count
    each = (count - 1) // len(cells)  # the first column numbers the teeth
    return ["", *(cells[place // each] for place in range(count - 1))]


def _split(line: str, separator: str, count: int) -> list[str]:
    """The cells of a line of headings, where it has as many; else each is ''."""
    line = line.lstrip("# ")
    if count == 1:
        return [line.strip().strip("\"'").rstrip(";,")]
    words = re.findall(r"[^\s\[(]+(?:\s*\[[^]]*\]|\s*\([^)]*\)|\s+in\s+\S+|\s*/\s*\S+)?", line)
    ways = [_cells(line, mark) for mark in (separator, ";", "\t", ",") if mark != " "] + [re.split(r"\s{2,}", line.strip())]
    return next((way for way in [*ways, words] if len(way) == count and _number(way[-1]) is None), [""] * count)


def _column(
    name: str, rows: Sequence[_Row], heads: Sequence[int], columns: Sequence[str], wanted: str, commas: bool
) -> int:
    """Place of the column of errors; ``commas``: there are some among the numbers."""
    kinds = [kind_of([re.sub(r"\W.*", "", word) for word in column.split()]) for column in columns]
    line = heads[-1] if heads else rows[0].line
    places = list(range(len(columns)))
    if len(columns) > 1 and not kinds[0]:
        _check_teeth(name, rows, commas)
        places = places[1:]
    if wanted:
        named = {place: " ".join(columns[place].split()) for place in places}
        found = [place for place in places if named[place].startswith(" ".join(wanted.split()))]  # Fp is not fp
        found = found if len(found) != 0 or not wanted.isdigit() else [place for place in places if place + 1 == int(wanted)]
        if len(found) != 1:
            raise InputError(f"{name}:{line}: error: column {shown(wanted)}: must be the number of a column, {places[0] + 1} to "
                             f"{places[-1] + 1}, or the heading of one of {', '.join(shown(columns[place]) for place in places)}")
        return found[0]
    for kind in (1, 2):
        found = [place for place in places if kinds[place] == kind]
        if len(found) > 1:
            told = " and ".join(shown(columns[place]) for place in found)
            one = columns[found[0]] if columns.count(columns[found[0]]) == 1 else found[0] + 1
            raise InputError(f"{name}:{line}: error: {told}: must be one column of {'cumulative' if kind == 1 else 'single'} pitch "
                             f"errors, for the flank that bears: {os.path.basename(name)}#{one} names one")
        if found:
            return found[0]
    if len(places) > 1:
        raise InputError(f"{name}:{rows[0].line}: error: {shown(' '.join(rows[0].words))}: must be a pitch error, or the number of "
                         "a tooth and its error; of more columns a heading 'Fp' (cumulative) or 'fp' (single) says which")
    return places[0]


def _check_teeth(name: str, rows: Sequence[_Row], commas: bool) -> None:
    """The first of several columns numbers the teeth, from 1 or from 0 on in their order."""
    begin = 0 if all(row.values[0] == place for place, row in enumerate(rows)) else 1
    for place, row in enumerate(rows, begin):
        if row.values[0] != place:
            hint = "; where a comma is a decimal comma, semicolons or spaces part the numbers" if commas else ""
            raise InputError(f"{name}:{row.line}: error: tooth {shown(row.words[0])}: must be {place}: all teeth in their order"
                             f"{hint}")


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


def _contradicts(rows: Sequence[_Row], columns: Sequence[str], place: int) -> bool:
    """Whether single errors of the same flank stand beside cumulative ones and are not their differences."""
    words = [column.split() for column in columns]
    flanks = [[word for word in own if not kind_of([word])] for own in words]
    beside = [other for other, own in enumerate(words) if kind_of(own) == 2 and flanks[other] == flanks[place]]
    if len(beside) != 1 or len(rows) < 3:
        return False
    reached, single = ([row.values[column] for row in rows] for column in (place, beside[0]))
    steps = [after - before for before, after in pairwise(reached)]
    # A step leads to a tooth, or on from it.
    off = min(max(abs(step - error) for step, error in zip(steps, errors)) for errors in (single[1:], single[:-1]))
    return off > 0.1 * (max(reached) - min(reached))


def _check_size(name: str, rows: Sequence[_Row], place: int, values: Sequence[float], unit: str | None) -> None:
    """Errors that are too large or too small for a gear are in another unit."""
    hint = "" if unit else "; a heading with [um], [mm] or [m] gives the unit"
    for row, value in zip(rows, values):
        if abs(value) > _MOST:
            raise InputError(f"{name}:{row.line}: error: {shown(row.words[place])} {unit or 'um'}: must be at most 1 mm{hint}")
    spread = max(values) - min(values)
    if 0 < spread < _LEAST:
        raise InputError(f"{name}: error: the errors differ by {1e6 * spread:.3g} um: must be at least {1e6 * _LEAST:g} um{hint}")


def _number(word: str) -> float | None:
    """A number, with a decimal point or comma."""
    try:
        return float(word.replace(",", "."))
    except ValueError:
        return None
