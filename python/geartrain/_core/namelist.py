"""Namelist text from Python values and back, so that Fortran checks a Python call as it checks a case file."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from collections.abc import Set as AbstractSet
from numbers import Integral, Real
from typing import Any

from ..errors import plain, shown
from ..variables import VARIABLES
from .variable import Variable

__all__ = ["group", "in_words_of_the_call", "parse", "values"]

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


def group(name: str, variables: Variables, given: Mapping[str, Value], problems: dict[str, str], place: str = "") -> str:
    """One namelist group; the arguments are those of `values`."""
    lines = [f"   {key} = {_text(value)}" for key, value in values(name, variables, given, problems, place).items()]
    return "\n".join([f"&{name}", *lines, "/", ""])


def values(
    name: str, variables: Variables, given: Mapping[str, Value], problems: dict[str, str], place: str = ""
) -> dict[str, Value]:
    """What is given for the variables of a group, by their names in the case file, each of the type that its kind has.

    Parameters
    ----------
    name : str
        The group, without ``&``.
    variables : mapping of str to Variable
        Those of the group by their keywords.
    given : mapping
        By keywords, or by names in the case file; those that are None are left out, so that Fortran's default holds.
    problems : dict of str to str
        Takes up what is of another kind, messages by the names of the variables; the result goes without them.
    place : str
        What messages call the group, ``&name`` unless told.
    """
    found: dict[str, Value] = {}
    label = place or "&" + name
    for word, value in given.items():
        if value is None:
            continue
        key = _KEYWORDS.get(word, word)
        if key not in variables:
            problems[f"{label}: {key}"] = f"{label}: there is no {key}: must be one of {', '.join(variables) or 'none'}"
            continue
        if key != word and given.get(key) is not None:
            problems[f"{label}: {key}"] = f"{label}: {key} is given twice, also as {word}: leave out one of the two"
            continue
        kind = variables[key].kind
        try:
            taken = _list(value, _TAKEN[kind[:-1]]) if kind.endswith("s") else _TAKEN[kind](value)
        except (TypeError, ValueError, OverflowError):
            problems[f"{label}: {key}"] = f"{label}: {key} = {shown(value)}: must be {_WANTED[kind]}"
            continue
        if taken != []:
            found[variables[key].name] = taken
    return found


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


def _real(value: Value) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise TypeError
    return float(value)


def _integer(value: Value) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise TypeError
    if abs(int(value)) >= 2**31:
        raise OverflowError
    return int(value)


def _logical(value: Value) -> bool:
    if value is True or value is False or type(value).__name__ in ("bool_", "bool"):
        return bool(value)
    raise TypeError


def _line(value: Value) -> str:
    # As the table of variables has it (plain_text.f90): every other character is allowed, be it a space without a break.
    if not isinstance(value, str) or plain(value) != value:
        raise TypeError
    return value


def _list(value: Value, take: Callable[[Value], Value]) -> list[Value]:
    """A list, or one value of it."""
    if isinstance(value, (str, Real)):
        return [take(value)]
    if isinstance(value, (bytes, bytearray, Mapping, AbstractSet)) or not isinstance(value, Iterable):
        raise TypeError
    return [take(item) for item in value]


_TAKEN: dict[str, Callable[[Value], Value]] = {
    "real": _real, "integer": _integer, "logical": _logical, "text": _line, "name": _line
}


def _text(value: Value) -> str:
    """A value as a namelist has it."""
    if isinstance(value, list):
        return ", ".join(map(_text, value))
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    return (".true." if value else ".false.") if isinstance(value, bool) else repr(value)


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
