"""`read_table`: a train from a table of its parts, CSV or a spreadsheet."""

from __future__ import annotations

import csv
import difflib
import io
import os
import re
import zipfile
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from .._core.extras import extra
from .._core.variable import Variable
from ..errors import InputError, shown
from ..train import Train
from ..variables import PARTS, VARIABLES
from .text_file import decoded, read_bytes

__all__ = ["read_table"]

#: Largest file, of a spreadsheet unpacked too [bytes]; most rows.
_LARGEST, _MOST_ROWS = 16 * 2**20, 20_000
#: The word that begins a row of headings, and what may stand below it.
_PART = "part"
_KINDS = ("train", *PARTS)

#: Units that a heading may name, over the unit of the variable.
_UNITS = {
    "m": {"mm": 1e-3, "um": 1e-6, "cm": 1e-2}, "kg m^2": {"kg mm^2": 1e-6, "kg cm^2": 1e-4, "g mm^2": 1e-9},
    "N m": {"N mm": 1e-3, "kN m": 1e3}, "N/m": {"N/mm": 1e3, "N/um": 1e6, "kN/mm": 1e6},
    "N m/rad": {"N mm/rad": 1e-3, "kN m/rad": 1e3}, "rpm": {"1/min": 1.0, "min^-1": 1.0},
    "kg/m^3": {"kg/dm^3": 1e3, "g/cm^3": 1e3}, "N/m^2": {"N/mm^2": 1e6, "MPa": 1e6, "GPa": 1e9}, "kg": {"g": 1e-3},
    "degree": {"deg": 1.0, "\N{DEGREE SIGN}": 1.0},
    "rad": {}, "N m s/rad": {}, "N s/m": {}, "rad/s": {},
}

#: Truth values.
_WORDS = {**dict.fromkeys(("true", ".true.", "yes", "x", "1"), True), **dict.fromkeys(("false", ".false.", "no", "0"), False)}


class _Column(NamedTuple):
    """A heading: the variable as it stands, the number that a heading of a list ends with, or 0, and the unit, or ''."""

    name: str
    place: int
    unit: str


def read_table(path: str | os.PathLike[str]) -> Train:
    """Read a train from a table: CSV (with commas, semicolons or tabs) or a spreadsheet ``.xlsx``.

    A row is a part of the train: ``body``, ``shaft``, ``mesh``, ``planetary``, ``coupling``, or the ``train`` itself. The first
    column is headed ``part``, the others by variables of a case file, with a unit where it is not SI: ``normal_module [mm]``. A row
    that begins with ``part`` has headings for the rows below it. A list stands in one cell, numbers with spaces between, names as
    ``motor - pinion``, or in columns ``teeth 1``, ``teeth 2``. An empty cell is not given. With semicolons a comma is a decimal
    comma.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    Train

    Raises
    ------
    InputError
        With the row of each problem.
    ModuleNotFoundError
        Where a spreadsheet is to be read and openpyxl is not installed.
    OSError

    Examples
    --------
    >>> train = gt.read_table("reducer.csv")  # doctest: +SKIP
    """
    name = os.fspath(path)
    data = read_bytes(path, _LARGEST)
    rows, comma = (_of_spreadsheet(name, data), False) if data[:2] == b"PK" else _of_text(name, data)
    problems: list[str] = []
    groups = _groups(name, rows, comma, problems)
    if problems:
        raise InputError("\n".join(problems))
    if not groups:
        raise InputError(f"{name}: error: no row below a heading {_PART!r}: one a part of the train, {', '.join(_KINDS)}")
    places, counts = {}, Counter[str]()
    for kind, _, place in groups:
        counts[kind] += 1
        places[f"&{kind} {counts[kind]}"] = place
    if not any(kind == "train" for kind, _, _ in groups):
        groups.insert(0, ("train", {}, ""))
    try:
        return Train._of([group[:2] for group in groups])
    except InputError as error:
        raise InputError("\n".join(_placed(line, places) for line in str(error).splitlines())) from None


def _placed(line: str, places: dict[str, str]) -> str:
    """A line of a message after the row of the part that it begins with."""
    place = places.get(line.partition(":")[0])
    return f"{place}: error: {line}" if place else line


Rows = Iterator[tuple[str, Sequence[Any]]]


def _of_text(name: str, data: bytes) -> tuple[Rows, bool]:
    """Rows with their places, and whether commas are decimal commas."""
    text = decoded(name, data)
    heading = next((line for line in text.splitlines() if line.strip().lower().startswith(_PART)), "")
    delimiter = max(",;\t", key=heading.count)

    def rows() -> Rows:
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, skipinitialspace=True, strict=True)
        try:
            for row in reader:
                yield f"{name}:{reader.line_num}", row
        except csv.Error as error:
            raise InputError(f"{name}:{reader.line_num}: error: {error}") from None

    return rows(), delimiter == ";" and bool(re.search(r"\d,\d", text))


def _of_spreadsheet(name: str, data: bytes) -> Rows:
    """Rows of all sheets with their places, values as they were last computed."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(member.file_size for member in archive.infolist()) > _LARGEST:
                raise InputError(f"{name}: error: unpacks to more than {_LARGEST >> 20} MB")
        book = extra("openpyxl").load_workbook(io.BytesIO(data), read_only=True, data_only=True, keep_links=False)
        found = [(f"{name}: sheet {sheet.title!r}, row {number}", row) for sheet in book.worksheets
                 for number, row in zip(range(1, _MOST_ROWS + 2), sheet.iter_rows(values_only=True))]
    except (InputError, ModuleNotFoundError):
        raise
    except Exception as error:  # noqa: BLE001 (whatever the package meets in a damaged file)
        raise InputError(f"{name}: error: is no spreadsheet: {shown(error)}") from None
    return iter(found)


def _groups(name: str, rows: Rows, comma: bool, problems: list[str]) -> list[tuple[str, dict[str, Any], str]]:
    """The parts of a table, as `Train` takes them, and their places; what is wrong goes into ``problems``."""
    columns: list[_Column] | None = None
    found: list[tuple[str, dict[str, Any], str]] = []
    for count, (place, row) in enumerate(rows):
        if count == _MOST_ROWS:
            raise InputError(f"{name}: error: more than {_MOST_ROWS} rows")
        cells = ["" if cell is None else cell.strip() if isinstance(cell, str) else cell for cell in row]
        kind = str(cells[0]).lower() if cells else ""
        if not any(cell != "" for cell in cells) or kind.startswith("#"):
            continue
        if kind == _PART:
            columns = [_heading(str(cell)) for cell in cells]
            named = [(column.name, column.place) for column in columns if column.name]
            twice = next((name for name in named if named.count(name) > 1), None)
            if twice:
                problems.append(f"{place}: error: {shown(' '.join(map(str, filter(None, twice))))}: heads two columns")
        elif columns is None:
            raise InputError(f"{place}: error: begins with {shown(cells[0])}: the first row must have headings, {_PART!r} first")
        elif kind not in _KINDS:
            problems.append(f"{place}: error: {shown(cells[0])}: must be one of {', '.join(_KINDS)}{_near(kind, _KINDS)}")
        else:
            values = _values(place, kind, columns, cells, comma, problems)
            found.append((kind, values, place))
    return found


def _heading(text: str) -> _Column:
    match = re.fullmatch(r"\s*(.*?)\s*(?:\[(.*)\])?\s*", text, re.DOTALL)
    name, unit = (match[1], re.sub("[\N{MICRO SIGN}\N{GREEK SMALL LETTER MU}]", "u", match[2] or "")) if match else (text, "")
    numbered = re.fullmatch(r"(.*\D) (\d{1,3})", name)
    return _Column(numbered[1], int(numbered[2]), unit.strip()) if numbered else _Column(name, 0, unit.strip())


def _values(
    place: str, kind: str, columns: Sequence[_Column], cells: Sequence[Any], comma: bool, problems: list[str],
) -> dict[str, Any]:
    """The variables of a row."""
    variables, found = VARIABLES[kind], {}
    lists: dict[str, dict[int, Any]] = {}
    for number, cell in enumerate(cells[1:], 1):
        if cell == "":
            continue
        column = columns[number] if number < len(columns) else _Column("", 0, "")
        row = variables.get(column.name)
        try:
            if row is None:
                told = _near(column.name, variables) if column.name else ": the column has no heading"
                raise ValueError(f"{shown(column.name)} is no variable of &{kind}{told}")
            value = _value(row, cell, column.unit, comma)
            if column.place:
                lists.setdefault(column.name, {})[column.place] = value[0] if isinstance(value, list) else value
            else:
                found[column.name] = value
        except ValueError as error:
            problems.append(f"{place}: error: column {number + 1}: {error}")
    for name, items in lists.items():
        if sorted(items) != list(range(1, len(items) + 1)):
            told = ", ".join(map(str, sorted(items)))
            problems.append(f"{place}: error: {name}: has {told}: must begin with 1, without gaps")
        found[name] = [items[number] for number in sorted(items)]
    return found


def _value(row: Variable, cell: Any, unit: str, comma: bool) -> Any:
    """The value of a cell, of the kind and in the unit of its variable."""
    factor = _factor(row, unit)
    if row.kind in ("text", "names"):
        text = str(cell)
        return [part.strip() for part in re.split(" [-\N{EN DASH}\N{EM DASH}] ", text)] if row.kind == "names" else text
    if row.kind == "logical":
        word = str(cell).lower()
        if word not in _WORDS:
            raise ValueError(f"{row.name} = {shown(cell)}: must be yes or no")
        return _WORDS[word]
    words = str(cell).split() if isinstance(cell, str) else [cell]
    numbers = [_number(row, word, comma) * factor for word in words]
    if row.kind == "reals":
        return numbers
    if len(numbers) != 1:
        raise ValueError(f"{row.name} = {shown(cell)}: must be one number")
    return int(numbers[0]) if row.kind == "integer" and numbers[0] == int(numbers[0]) else numbers[0]


def _number(row: Variable, word: Any, comma: bool) -> float:
    if comma and isinstance(word, str) and re.fullmatch(r"[+-]?\d{1,3}\.\d{3}", word):
        ways = f"{word.replace('.', '')} or {word.replace('.', ',')}"
        raise ValueError(f"{row.name} = {shown(word)}: must be {ways}: beside decimal commas a point may separate thousands")
    try:
        if isinstance(word, bool):
            raise ValueError
        value = float(word.replace(",", ".") if comma and isinstance(word, str) else word)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{row.name} = {shown(word)}: must be a number") from None
    if abs(value) > 1e300 or value != value:
        raise ValueError(f"{row.name} = {shown(word)}: must be a number")
    return value


def _factor(row: Variable, unit: str) -> float:
    """The unit of a heading over that of its variable."""
    unit = unit.replace("\N{SUPERSCRIPT TWO}", "^2").replace("\N{SUPERSCRIPT THREE}", "^3").replace("\N{MICRO SIGN}", "u")
    own = next((word[1:-1] for word in row.meaning.split("; ") if word.startswith("[") and word.endswith("]")), "")
    if unit in ("", own):
        return 1.0
    known = {name.replace(" ", ""): factor for name, factor in {own: 1.0, **_UNITS.get(own, {})}.items()}
    factor = known.get(unit.replace(" ", "")) if own else None
    if factor is None:
        may = ", ".join([own, *_UNITS.get(own, {})]) if own else "none"
        raise ValueError(f"{row.name} [{unit}]: must be in {may}")
    return factor


def _near(word: str, known: Any) -> str:
    near = difflib.get_close_matches(word, list(known), 1)
    return f" (did you mean {near[0]!r}?)" if near else ""
