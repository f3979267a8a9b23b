"""What the heading of a column of pitch errors says: its unit, and whether they are cumulative or single."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from ..errors import InputError, shown

__all__ = ["UNITS", "Heading", "is_unit", "kind_of", "read_heading", "unit_of", "unit_of_comment", "values_in"]

#: Units that a heading may name [m].
UNITS = {**dict.fromkeys(("um", "\N{MICRO SIGN}m", "\N{GREEK SMALL LETTER MU}m", "mum", "micron", "microns"), 1e-6),
         **dict.fromkeys(("micrometer", "micrometre", "mikrometer"), 1e-6), "mm": 1e-3, "nm": 1e-9, "m": 1.0}

#: Words of headings: some mean cumulative errors, some single ones, some neither. ISO 1328-1 writes Fp and fp.
_CUMULATIVE = re.compile(r"F_?pi?|(?i:cum(ulative)?|kumul\w*|accumulated|total|index|(summen?|gesamt)(teilung\w*)?|"
                         r"teilungs-?(summen?|gesamt)\w*)")
_SINGLE = re.compile(r"f_?p(t|i|ti)?|(?i:single|individual|adjacent|einzel(teilung\w*)?|teilungs-?einzel\w*)")
_NEITHER = re.compile(r"(?i:errors?|dev|deviations?|(teilungs-?)?(abweichung(en)?|fehler)|pitch|teilung(en)?|values?|werte?|"
                      r"measured|gemessen|left|right|links?|rechts?|[lr][fh]?|flanks?|flanken?|linke|rechte|iso|1328(-1)?)")
_OTHER_UNITS = re.compile(r"(?i)(micro-?|u|\N{MICRO SIGN})?inch(es)?|(u|\N{MICRO SIGN})in|mils?|thou|zoll")
#: Where a unit may stand: in brackets, after 'in' or '/', or after a comma.
_PLACES = (r"\[([^\]]*)\]", r"\(([^)]*)\)", r"\bin\s+(.+)$", r"/\s*(\S+)\s*$", r",\s*(\S+)\s*$")


class Heading(NamedTuple):
    """1: cumulative errors, 2: single ones, 0: it does not say; its unit, or None."""

    kind: int
    unit: str | None


def read_heading(place: str, text: str, chosen: bool = False) -> Heading:
    """The heading of a column, every word of which must be known: errors of something else, or in another unit, are refused.

    Beside 'Fp' or 'fp' a column that was ``chosen`` by its heading may have other words, as the name of the gear.
    """
    units, rest = [], text
    for pattern in _PLACES:
        for inside in re.findall(pattern, rest, re.IGNORECASE):
            if unit_of(inside):
                units.append(unit_of(inside))
            elif pattern.startswith(r"\[") or not all(map(_is_known, inside.split())):
                raise InputError(f"{place}: error: unit {shown(inside.strip())}: must be um, mm, nm or m")
        rest = re.sub(pattern, lambda match: " " if unit_of(match[1]) else f" {match[1]} ", rest, flags=re.IGNORECASE)
    if len({*units}) > 1:
        raise InputError(f"{place}: error: units {shown(' and '.join(map(str, units)))}: must be one")
    words = rest.split()
    unknown = [word for word in words if not _is_known(word)]
    if unknown and not (chosen and kind_of(words)):
        hint = "; TABLE#HEADING takes a column by its heading" if kind_of(words) else ""
        raise InputError(f"{place}: error: heading {shown(text.strip())}: {shown(' '.join(unknown))}: must say pitch errors, "
                         f"cumulative ('Fp') or single ('fp'){hint}")
    return Heading(kind_of(words), units[0] if units else None)


def unit_of_comment(place: str, text: str) -> str | None:
    """The unit in a comment, in brackets, after 'unit' or as 'values in um'. A number in brackets belongs to the name of a
    component, and brackets beside a number to that number."""
    text = re.sub(r"\d\s*[\[(][^\])]*[\])]|[\[(][^\])]*[\])]\s*[:=;]\s*[-+\d]", " ", text)
    found = [inside for inside in re.findall(r"\[([^\]]*)\]", text) if not re.search(r"\d", inside) or is_unit(inside.split()[-1])]
    found += [inside for inside in re.findall(r"\(([^)]*)\)", text) if is_unit(inside)]
    found += re.findall(r"(?i)(?:unit|einheit)(?:s|en)?[\s:;=,\t]+(\S+)", text) + values_in(text)
    units = [unit_of(inside) for inside in found]
    if None in units or len({*units}) > 1:
        raise InputError(f"{place}: error: unit {shown(' and '.join(found))}: must be um, mm, nm or m, once")
    return units[0] if units else None


def values_in(text: str) -> list[str]:
    """Of a line as 'all values in 0.1 um' what follows 'in' and ends with a unit, also with one that is not read."""
    return [inside for inside in re.findall(r"(?i)\bin\s+((?:\d[\d.,/]*\s*)?[^\s.,;:)]+)", text)
            if is_unit(word := re.sub(r"^[\d.,/\s]+", "", inside)) or _OTHER_UNITS.fullmatch(word)]


def kind_of(words: Sequence[str]) -> int:
    """1: cumulative; 2: single; 0: not said, or both."""
    kinds = {kind for word in words for kind, known in ((1, _CUMULATIVE), (2, _SINGLE)) if known.fullmatch(word)}
    return kinds.pop() if len(kinds) == 1 else 0


def is_unit(word: str) -> bool:
    """Whether a word is a unit of length."""
    return unit_of(word) is not None


def unit_of(word: str) -> str | None:
    """A unit as `UNITS` has it; capitals do not matter where there is no other unit."""
    found = word.strip()
    return found if found in UNITS else found.lower() if found.lower() in UNITS and found != "M" else None


def _is_known(word: str) -> bool:
    return any(known.fullmatch(word) for known in (_NEITHER, _CUMULATIVE, _SINGLE))
