"""A case in the making: groups of variables, each value with the words that stand beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..errors import plain
from ..variables import VARIABLES
from .rexs_gears import Entry

__all__ = ["Draft"]

_A_LINE = 8  # numbers


@dataclass
class Draft:
    """Groups of a case, in their order: name, the component that a group is of, values."""

    groups: list[tuple[str, str, dict[str, Entry]]] = field(default_factory=list)

    def add(self, group: str, told: str, entries: Mapping[str, Entry]) -> None:
        self.groups.append((group, told, {name: Entry(_plain(entry.value), entry.told) for name, entry in entries.items()}))

    def values(self) -> list[tuple[str, dict[str, Any]]]:
        """Groups and values, as a train is made of them."""
        return [(group, {name: entry.value for name, entry in entries.items()}) for group, _, entries in self.groups]

    def text(self, head: list[str], notes: list[str]) -> str:
        """The case as text: the lines of the head, the groups, every number with its component, and the notes."""
        lines = [f"! {line}" for line in head]
        for kind, title in (("missing", "What the file does not have: check these values"), ("assumed", "What was assumed"),
                            ("not used", "What is not used")):
            listed = [note.partition(": ")[2] for note in notes if note.startswith(f"{kind}:")]
            if listed:
                lines += ["!", f"! {title}:", *(f"!    {line}" for line in listed)]
        lines.append("")
        for group, told, entries in self.groups:
            lines.append(f"&{group}" + (f"   ! {plain(told)}" if told else ""))
            for name, entry in entries.items():
                value, *more = _lines(name, entry.value)
                words = "; ".join(word for word in (_unit(group, name), plain(entry.told)) if word)
                lines += [f"{value:<60} ! {words}" if words else value, *more]
            lines.append("/")
        return "\n".join(lines) + "\n"


def _lines(name: str, value: Any) -> list[str]:
    """A variable with its value, of long lists some numbers a line."""
    if not isinstance(value, list) or len(value) <= _A_LINE:
        return [f"   {name} = {_text(value)}"]
    rows = [_text(value[first:first + _A_LINE]) for first in range(0, len(value), _A_LINE)]
    return [f"   {name} =", *(f"      {row}," for row in rows[:-1]), f"      {rows[-1]}"]


def _unit(group: str, name: str) -> str:
    """The unit of a variable in brackets, as its text tells it."""
    row = VARIABLES.get(group, {}).get(name)
    found = [word for word in row.meaning.split("; ") if word.startswith("[")] if row else []
    return found[0] if found else ""


def _plain(value: Any) -> Any:
    """A value without the rounding of units and differences: 13 digits."""
    if isinstance(value, float):
        return float(f"{value:.13g}")
    return [_plain(item) for item in value] if isinstance(value, list) else value


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, list):
        return ", ".join(_text(item) for item in value)
    return repr(value)
