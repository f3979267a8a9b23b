"""REXS files: XML, JSON or a zip archive, as components, relations and load cases.

REXS is the Reusable Engineering EXchange Standard of FVA e.V., versions 1.0 to 2.0 (rexs.info). Files are data: document types, and
with them entities, are refused, sizes are bounded, and each problem has a line.
"""

from __future__ import annotations

import base64
import binascii
import json
import os
import re
import struct
import zipfile
import zlib
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple
from xml.parsers import expat

from ..errors import InputError, plain, shown

__all__ = ["Attribute", "Component", "Relation", "RexsFile", "read_file"]

#: Largest file, and largest file in an archive [bytes]. The largest gearboxes published have 1 MB.
LARGEST = 64 * 2**20
#: Most files of an archive, and deepest nesting of elements.
_MOST_FILES, _DEEPEST = 1000, 64
#: Roles that relations have, of those that are read.
_ROLES = {
    "assembly": ("assembly", "part"), "ordered_assembly": ("assembly", "part"), "side": ("assembly", "inner_part", "outer_part"),
    "stage": ("stage", "gear_1", "gear_2"), "flank": ("gear",), "reference": ("origin", "referenced"),
    "ordered_reference": ("origin", "referenced"), "central_shaft": ("planetary_stage", "shaft"),
    "planet_shaft": ("planetary_stage", "shaft"), "planet_pin": ("planetary_stage", "shaft"),
    "planet_carrier_shaft": ("planetary_stage", "shaft"),
}
#: What components are in these roles.
_KINDS = {"shaft": ("shaft",), "planetary_stage": ("planetary_stage",)}
#: Formats of coded arrays: the letter of `struct`.
_CODES = {"int32": "i", "int_32": "i", "float32": "f", "float_32": "f", "float64": "d", "float_64": "d"}


class Attribute(NamedTuple):
    """Value of an attribute: text, a number, a truth value or a list of these; its unit and its line."""

    value: Any
    unit: str
    line: int


@dataclass(frozen=True)
class Component:
    """A component: its number, its type as ``cylindrical_gear``, its name, its attributes and its line."""

    number: int
    kind: str
    name: str
    line: int
    attributes: dict[str, Attribute] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.name if re.search(r"\[\d+\]$", self.name) else f"{self.name or self.kind} [{self.number}]"


class Relation(NamedTuple):
    """A relation: its type as ``assembly``, and the numbers of its components by their roles."""

    kind: str
    roles: Mapping[str, int]
    line: int


@dataclass(frozen=True)
class RexsFile:
    """What a file holds.

    Attributes
    ----------
    path : str
    version, application : str
    components : dict of Component
        By their numbers.
    relations : list of Relation
    load_cases : list of dict
        Components with the attributes that a load case sets, by their numbers.
    """

    path: str
    version: str
    application: str
    components: dict[int, Component]
    relations: list[Relation]
    load_cases: list[dict[int, Component]]

    def __post_init__(self) -> None:
        for relation in self.relations:
            told = self._wrong(relation)
            if told:
                raise InputError(f"{self.path}:{relation.line}: error: relation {plain(relation.kind)}: {plain(told)}")

    def _wrong(self, relation: Relation) -> str:
        """What is wrong with a relation; '' where nothing is."""
        for role, number in relation.roles.items():
            if number not in self.components:
                return f"{role} {number} is no component of the file"
            if relation.kind in _ROLES and self.components[number].kind not in _KINDS.get(role, (self.components[number].kind,)):
                return f"{role} {number} is a {self.components[number].kind}"
        lacking = [role for role in _ROLES.get(relation.kind, ()) if role not in relation.roles]
        return f"has no {' and no '.join(lacking)}" if lacking else ""

    def of_kind(self, *kinds: str) -> Iterator[Component]:
        """Components of these types, in the order of the file."""
        return (component for component in self.components.values() if component.kind in kinds)

    def related(self, kind: str, **roles: int) -> Iterator[Mapping[str, Component]]:
        """Components by their roles in the relations of a type in which ``roles`` are these components."""
        first = next(iter(roles.items()), None)
        for relation in self._relations.get((kind, first), []):
            if all(relation.roles.get(role) == number for role, number in roles.items()):
                yield {role: self.components[number] for role, number in relation.roles.items()}

    @cached_property
    def _relations(self) -> dict[tuple[str, tuple[str, int] | None], list[Relation]]:
        """Relations by their type, and by their type and one of their roles."""
        found: dict[tuple[str, tuple[str, int] | None], list[Relation]] = {}
        for relation in self.relations:
            for key in (None, *relation.roles.items()):
                found.setdefault((relation.kind, key), []).append(relation)
        return found


def read_file(path: str | os.PathLike[str]) -> RexsFile:
    """Read a file, whichever of the three formats it has.

    Raises
    ------
    InputError
        Where it is damaged or no REXS file.
    OSError
    """
    with open(path, "rb") as stream:
        data = stream.read(LARGEST + 1)
    name = os.fspath(path)
    if len(data) > LARGEST:
        raise InputError(f"{name}: error: has more than {LARGEST >> 20} MB, which no gearbox needs")
    if data[:2] == b"PK":
        name, data = _unpacked(path, name)
    start = data.lstrip(b"\xef\xbb\xbf\xff\xfe\x00 \t\r\n")[:1]  # marks of encodings, and spaces
    if not start:
        raise InputError(f"{name}: error: the file is empty")
    made: _Maker = _Maker(name)
    (_read_json if start in b"{[" else _read_xml)(made, data)
    return made.file()


def _unpacked(path: str | os.PathLike[str], name: str) -> tuple[str, bytes]:
    """The one REXS file of an archive: its name and its bytes."""
    try:
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
            if len(members) > _MOST_FILES:
                raise InputError(f"{name}: error: an archive of {len(members)} files; at most {_MOST_FILES} are read")
            found = [member for member in members if _is_model(member.filename)]
            if len(found) != 1:
                told = ", ".join(shown(member.filename) for member in found[:5]) or "none"
                raise InputError(f"{name}: error: an archive must have one file .rexs or .rexsj; it has {told}")
            with archive.open(found[0]) as stream:
                data = stream.read(LARGEST + 1)
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError, struct.error) as error:
        if isinstance(error, InputError):
            raise
        told = str(error) if isinstance(error, (RuntimeError, zipfile.BadZipFile)) else "the archive is damaged"
        raise InputError(f"{name}: error: cannot be unpacked: {told}") from None
    if len(data) > LARGEST:
        raise InputError(f"{name}: error: {found[0].filename!r} unpacks to more than {LARGEST >> 20} MB, which no gearbox needs")
    return f"{name}/{found[0].filename}", data


def _is_model(name: str) -> bool:
    parts = Path(name).parts
    hidden = any(part.startswith((".", "__")) for part in parts)
    return not hidden and name.lower().endswith((".rexs", ".rexsj", ".rexs.xml", ".rexs.json"))


class _Maker:
    """Takes up what a reader finds, with checks, and makes the `RexsFile` of it."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.version = ""
        self.application = ""
        self.components: dict[int, Component] = {}
        self.relations: list[Relation] = []
        self.load_cases: list[dict[int, Component]] = []

    def file(self) -> RexsFile:
        if not self.components:
            raise InputError(f"{self.path}: error: no components: is this a REXS file?")
        for part in (part for case in self.load_cases for part in case.values()):
            of = self.components.get(part.number)
            if of is None or part.kind not in ("", of.kind):
                told = "is no component of the file" if of is None else f"is a {of.kind}"
                raise self.wrong(part.line, f"load case: {plain(part.kind)} {part.number} {told}")
        return RexsFile(self.path, self.version, self.application, self.components, self.relations, self.load_cases)

    def attribute(self, component: Component, name: str, made: Attribute) -> None:
        if name in component.attributes:
            raise self.wrong(made.line, f"{component.kind} {component}: {plain(name)} stands in it twice")
        component.attributes[name] = made

    def wrong(self, line: int, told: str) -> InputError:
        return InputError(f"{self.path}:{line}: error: {told}")

    def model(self, version: Any, application: Any, line: int) -> None:
        self.version, self.application = str(version or ""), str(application or "")
        if not re.fullmatch(r"1\.\d+(\.\d+)?|2\.0(\.\d+)?", self.version):
            raise self.wrong(line, f"version {shown(self.version)}: must be 1.0 to 2.0 of REXS")

    def component(self, number: Any, kind: Any, name: Any, line: int, into: dict[int, Component] | None = None) -> Component:
        components = self.components if into is None else into
        name = plain(" ".join(str(name or "").split()))  # it becomes a name of the case
        made = Component(self.number(number, "component", line), str(kind or ""), name, line)
        if made.number in components:
            raise self.wrong(line, f"component {made.number} stands in the file twice")
        components[made.number] = made
        return made

    def relation(self, kind: Any, roles: list[tuple[Any, Any]], line: int) -> None:
        found = {str(role): self.number(number, "relation", line) for role, number in roles}
        self.relations.append(Relation(str(kind or ""), found, line))

    def number(self, value: Any, what: str, line: int) -> int:
        text = str(value).strip()
        if isinstance(value, bool) or not re.fullmatch(r"\d{1,9}(\.0)?", text):
            raise self.wrong(line, f"{what}: id = {shown(value)}: must be a whole number")
        return int(float(text))

    def coded(self, text: str, code: str, line: int) -> list[float]:
        """Numbers of an array in base64."""
        letter = _CODES.get(code.lower())
        if letter is None:
            raise self.wrong(line, f"an array of code {shown(code)}: must be int32, float32 or float64")
        try:
            data = base64.b64decode("".join(text.split()), validate=True)
            return list(struct.unpack(f"<{len(data) // struct.calcsize(letter)}{letter}", data))
        except (binascii.Error, struct.error, ValueError):
            raise self.wrong(line, f"an array of code {code} cannot be decoded") from None


def _read_xml(made: _Maker, data: bytes) -> None:
    """Read XML by expat, which knows lines; document types, with which entities begin, are refused."""
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    _XmlReader(made, parser)
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise made.wrong(error.lineno, f"no well-formed XML: {expat.ErrorString(error.code)}") from None
    except (UnicodeError, LookupError) as error:
        raise made.wrong(parser.CurrentLineNumber, f"no readable text: {error}") from None


class _XmlReader:
    """The handlers of expat: what element is open, and what it has so far."""

    def __init__(self, made: _Maker, parser: Any) -> None:
        self.made = made
        self.parser = parser
        self.open: list[str] = []
        self.text: list[str] = []
        self.into: dict[int, Component] = made.components
        self.component: Component | None = None
        self.attribute: tuple[str, str, int] | None = None
        self.items: list[Any] | None = None
        self.code = ""
        self.relation: tuple[str, list[tuple[Any, Any]], int] | None = None
        parser.StartDoctypeDeclHandler = self.refuse
        parser.EntityDeclHandler = self.refuse
        parser.StartElementHandler = self.start
        parser.EndElementHandler = self.end
        parser.CharacterDataHandler = self.text.append

    def refuse(self, *_: Any) -> None:
        raise self.made.wrong(self.parser.CurrentLineNumber, "a document type (<!DOCTYPE ...>) is not read: REXS has none")

    def start(self, tag: str, given: dict[str, str]) -> None:
        tag, line = tag.rpartition(" ")[2], self.parser.CurrentLineNumber
        if not self.open and tag != "model":
            raise self.made.wrong(line, f"begins with <{shown(tag)[1:-1]}>, a REXS file with <model>")
        if len(self.open) == _DEEPEST:
            raise self.made.wrong(line, f"elements within elements, {_DEEPEST} deep")
        self.open.append(tag)
        self.text.clear()
        if tag == "model":
            self.made.model(given.get("version"), given.get("applicationId"), line)
        elif tag == "relation":
            self.relation = given.get("type", ""), [], line
        elif tag == "ref" and self.relation:
            self.relation[1].append((given.get("role"), given.get("id")))
        elif tag in ("load_spectrum", "accumulation"):
            self.into = {}  # results over all load cases, which are not used
        elif tag == "load_case":
            self.into = {}
            self.made.load_cases.append(self.into)
        elif tag == "component":
            self.component = self.made.component(given.get("id"), given.get("type"), given.get("name"), line, self.into)
        elif tag == "attribute" and self.component:
            self.attribute, self.items, self.code = (given.get("id", ""), given.get("unit", ""), line), None, ""
        elif tag in ("array", "matrix") and self.attribute:
            self.items, self.code = [], given.get("code", "")

    def end(self, tag: str) -> None:
        tag = tag.rpartition(" ")[2]
        text = "".join(self.text).strip()
        self.text.clear()
        self.open.pop()
        if tag == "c" and self.items is not None:
            self.items.append(text)
        elif tag == "array" and self.attribute and self.code and text:
            self.items = list(self.made.coded(text, self.code, self.attribute[2]))
        elif tag == "attribute" and self.attribute and self.component:
            name, unit, line = self.attribute
            self.made.attribute(self.component, name, Attribute(text if self.items is None else self.items, unit, line))
            self.attribute = self.items = None
        elif tag == "component":
            self.component = None
        elif tag == "relation" and self.relation:
            self.made.relation(*self.relation)
            self.relation = None
        elif tag == "load_spectrum":
            self.into = self.made.components


def _read_json(made: _Maker, data: bytes) -> None:
    try:
        text = data.decode(json.detect_encoding(data))
        whole = json.loads(text)
    except UnicodeError as error:
        raise InputError(f"{made.path}: error: no readable text: {error}") from None
    except json.JSONDecodeError as error:
        raise made.wrong(error.lineno, f"no well-formed JSON: {error.msg}, column {error.colno}") from None
    except (RecursionError, ValueError) as error:
        raise InputError(f"{made.path}: error: no well-formed JSON: {error or 'values within values, too deep'}") from None
    model = whole.get("model") if isinstance(whole, dict) else None
    if not isinstance(model, dict):
        raise made.wrong(1, 'begins with no {"model": {...}}, as a REXS file does')
    line = _lines(text)
    made.model(model.get("version"), model.get("applicationId"), 1)
    for place, row in enumerate(_rows(made, model, "relations")):
        refs = [(ref.get("role"), ref.get("id")) for ref in _rows(made, row, "refs")]
        made.relation(row.get("type"), refs, line("relations", place))
    for place, row in enumerate(_rows(made, model, "components")):
        _take_json(made, row, line("components", place), made.components)
    spectrum = model.get("load_spectrum")
    for row in _rows(made, spectrum, "load_cases") if isinstance(spectrum, dict) else []:
        made.load_cases.append({})
        for component in _rows(made, row, "components"):
            _take_json(made, component, 1, made.load_cases[-1])


def _take_json(made: _Maker, row: Mapping[str, Any], line: int, into: dict[int, Component]) -> None:
    component = made.component(row.get("id"), row.get("type"), row.get("name"), line, into)
    for given in _rows(made, row, "attributes"):
        value = next((value for key, value in given.items() if key not in ("id", "unit")), None)
        if isinstance(value, dict) and "code" in value:
            value = made.coded(str(value.get("value")), str(value["code"]), line)
        made.attribute(component, str(given.get("id")), Attribute(value, str(given.get("unit") or ""), line))


def _rows(made: _Maker, of: Mapping[str, Any], name: str) -> list[dict[str, Any]]:
    rows = of.get(name) or []
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise made.wrong(1, f'"{name}": must be a list of objects')
    return rows


def _lines(text: str) -> Callable[[str, int], int]:
    """The line of each object of a list of the model, which `json` does not tell: its objects decoded again, one by one."""
    starts = [match.start() for match in re.finditer("\n", text)]
    decoder = json.JSONDecoder()
    known: dict[str, list[int]] = {}

    def line(name: str, place: int) -> int:
        if name not in known:
            known[name] = []
            found = re.search(rf'"{name}"\s*:\s*\[', text)
            at = found.end() if found else len(text)
            while (start := re.compile(r"[\s,]*(?=\{)").match(text, at)) is not None:
                known[name].append(bisect_right(starts, start.end()) + 1)
                _, at = decoder.raw_decode(text, start.end())
        return known[name][place] if place < len(known[name]) else 1

    return line
