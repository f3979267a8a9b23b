"""Namelist text from Python values and back, so that Fortran checks a Python call as it checks a case file."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from collections.abc import Set as AbstractSet
from numbers import Integral, Real
from typing import Any

from ._variable import Variable
from .errors import shown
from .variables import VARIABLES

__all__ = ["group", "in_words_of_the_call", "parse"]

Value = Any
Variables = Mapping[str, Variable]

#: Names of the case file that are others in a call, as `from` is a word of Python.
_KEYWORDS = {row.name: keyword for rows in VARIABLES.values() for keyword, row in rows.items() if row.name != keyword}

_WANTED = {
    "real": "a number",
    "integer": "a whole number below 2147483648",
    "logical": "True or False",
    "text": "a string of one line without control characters",
    "reals": "a number or a list of numbers",
    "names": "a list of strings",
}


def group(name: str, variables: Variables, values: Mapping[str, Value], problems: dict[str, str], place: str = "") -> str:
    """One namelist group.

    Parameters
    ----------
    name : str
        The group, without ``&``.
    variables : mapping of str to Variable
        Those of the group by their keywords.
    values : mapping
        By keywords, or by names in the case file; those that are None are left out, so that Fortran's default holds.
    problems : dict of str to str
        Takes up what cannot be written, messages by the names of the variables; the group goes without them.
    place : str
        What messages call the group, ``&name`` unless told.
    """
    lines = [f"&{name}"]
    label = place or "&" + name
    for given, value in values.items():
        if value is None:
            continue
        key = _KEYWORDS.get(given, given)
        if key not in variables:
            problems[f"{label}: {key}"] = f"{label}: there is no {key}: must be one of {', '.join(variables) or 'none'}"
            continue
        if key != given and values.get(key) is not None:
            problems[f"{label}: {key}"] = f"{label}: {key} is given twice, also as {given}: leave out one of the two"
            continue
        kind = variables[key].kind
        try:
            text = _list(value, _FORMATS[kind[:-1]]) if kind.endswith("s") else _FORMATS[kind](value)
        except (TypeError, ValueError, OverflowError):
            problems[f"{label}: {key}"] = f"{label}: {key} = {shown(value)}: must be {_WANTED[kind]}"
            continue
        if text:
            lines.append(f"   {variables[key].name} = {text}")
    return "\n".join([*lines, "/", ""])


def in_words_of_the_call(message: str, words: Mapping[str, str] = _KEYWORDS) -> str:
    """A message about a case as one about the call that made it.

    Parameters
    ----------
    message : str
    words : mapping of str to str
        What the call says for a name. A message gives a name before its value, ``: from = -1.0``, after ``lacks``, or in quotes.
    """
    name = rf"""(?:(?<=: )|(?<=lacks )|(?<="))({"|".join(words)})(?= =| \(|"|$)"""
    message = re.sub(name, lambda found: words[found[1]], message, flags=re.MULTILINE)
    return message.replace(".true.", "True").replace(".false.", "False")


def _real(value: Value) -> str:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError
    return repr(float(value))


def _integer(value: Value) -> str:
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise TypeError
    if abs(int(value)) >= 2**31:
        raise OverflowError
    return str(int(value))


def _logical(value: Value) -> str:
    if value is True or value is False or type(value).__name__ in ("bool_", "bool"):
        return ".true." if value else ".false."
    raise TypeError


def _text(value: Value) -> str:
    # As the table of variables has it (variable.f90): every other character is allowed, be it a space without a break.
    if not isinstance(value, str) or any(byte < 32 or byte == 127 for byte in value.encode()):
        raise TypeError
    return "'" + value.replace("'", "''") + "'"


def _list(value: Value, format_of_one: Callable[[Value], str]) -> str:
    """A list, or one value of it."""
    if isinstance(value, (str, Real)):
        return format_of_one(value)
    if isinstance(value, (bytes, bytearray, Mapping, AbstractSet)) or not isinstance(value, Iterable):
        raise TypeError
    return ", ".join(format_of_one(item) for item in value)


_FORMATS = {"real": _real, "integer": _integer, "logical": _logical, "text": _text, "name": _text}

_TOKEN = re.compile(
    r"""(?P<text>'(?:[^']|'')*')|(?P<comment>![^\n]*)|&(?P<group>\w+)|(?P<end>/)
        |(?P<key>[a-z]\w*)\s*=|(?P<value>[^\s,/!'=]+)""",
    re.VERBOSE,
)


def parse(text: str) -> list[tuple[str, dict[str, Value]]]:
    """The groups of a resolved namelist, as Fortran's ``case_text`` writes it, in their order, with keywords for names.

    A variable with several values, or of one in a series, comes as a list where it has more than one.
    """
    groups: list[tuple[str, dict[str, Value]]] = []
    values: list[Value] = []
    for token in _TOKEN.finditer(text):
        kind, word = token.lastgroup, token[token.lastgroup or 0]
        if kind == "group":
            groups.append((word, {}))
        elif kind == "key":
            values = groups[-1][1].setdefault(_KEYWORDS.get(word, word), [])
        elif kind in ("text", "value"):
            values.append(_value(word))
    return [(name, {key: item[0] if len(item) == 1 else item for key, item in found.items()}) for name, found in groups]


def _value(word: str) -> Value:
    if word.startswith("'"):
        return word[1:-1].replace("''", "'")
    if word in (".true.", ".false."):
        return word == ".true."
    try:
        return int(word)
    except ValueError:
        return float(word)
