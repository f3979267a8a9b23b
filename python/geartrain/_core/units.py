"""Units of frequencies and lengths: in which calls take them, and in which results are told and drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, shown
from .box import Words
from .description import Description

__all__ = [
    "Unit",
    "Units",
    "both_units",
    "frequency_words",
    "hertz_of",
    "in_own_unit",
    "lambda_of",
    "length_unit",
    "own_lambda",
    "speed_of",
    "units_of",
]

Unit = Literal["Lambda", "rpm", "Hz"]
Numbers = TypeVar("Numbers", float, "NDArray[np.float64]")


def lambda_of(train: Description | None, frequency: float, unit: str | None) -> float:
    """Lambda of a frequency in a unit."""
    return float(frequency) * (1 / _at_one(train, unit))


def speed_of(train: Description | None, frequency: Numbers) -> Numbers | None:
    """Speed [rpm] at Lambda; None where the train does not tell."""
    speed = train._outline["speed"] if isinstance(train, Description) else 0.0
    return frequency * speed if speed else None


def hertz_of(train: Description | None, frequency: Numbers) -> Numbers | None:
    """Frequency of the fundamental [Hz] at Lambda; None without a train."""
    hertz = train._outline["fundamental_frequency"] if isinstance(train, Description) else 0.0
    return frequency * hertz if hertz else None


def own_lambda(frequency: float, speed: float | None) -> float | None:
    """Lambda in a table; None where it is the speed in rpm, which the table has."""
    return None if speed is not None and abs(frequency - speed) <= 1e-9 * speed else frequency


def in_own_unit(words: str, train: Any) -> str:
    """A sentence of a result with "3600 rpm" in place of "Lambda = 3600" where Lambda is the speed in rpm."""
    if not isinstance(words, Words) or not isinstance(train, Description) or units_of(train, None).unit != "rpm":
        return words
    text, done = "", 0
    for _, _, first, last in words.places.reshape(-1, 4):
        text += f"{words[done:int(first) - 1]}{words[int(first) - 1:int(last)].removeprefix('Lambda = ')} rpm"
        done = int(last)
    return text + words[done:]


def frequency_words(frequency: float, train: Any) -> str:
    """A frequency in a sentence."""
    own = isinstance(train, Description) and units_of(train, None).unit == "rpm"
    return f"{frequency:g} rpm" if own else f"Lambda = {frequency:g}"


def length_unit(train: Description | None) -> str:
    """Unit of displacements over the characteristic length where it has a name, as the head of a column has it.

    The displacement of a coupling is 1 um for a twist of 1 mrad.
    """
    if not isinstance(train, Description):
        return ""
    length = train._outline["characteristic_length"]
    if abs(length - 1e-6) < 1e-18:
        return " " + both_units(train, "um", "mrad")
    return " " + both_units(train, "m", "krad") if abs(length - 1.0) < 1e-12 else ""


def both_units(train: Description, mesh: str, coupling: str) -> str:
    """The units of meshes and of couplings in brackets: ``[um, mrad]``, or one of them where the train has one kind alone."""
    there = (len(train.couplings) < max(1, len(train.mesh_elements)), bool(train.couplings))
    return f"[{', '.join(unit for unit, one in zip((mesh, coupling), there) if one)}]"


def _at_one(train: Description | None, unit: Any) -> float:
    """The value of a unit at Lambda = 1; where it is not known the executable has the words for it."""
    name = str(unit)
    if unit is None or name == "Lambda":
        return 1.0
    known = train._outline if isinstance(train, Description) else {}
    value = float(known.get({"rpm": "speed", "Hz": "fundamental_frequency"}.get(name, ""), 0.0))
    if not value and isinstance(train, Description):
        try:
            train._ask_at(1.0, {"unit": unit})
        except InputError as error:
            told = [line.removeprefix("&integration: ") for line in str(error).splitlines()]
            raise InputError("\n".join(line for line in told if line.startswith("unit"))) from None
    if not value:
        raise InputError(f"unit = {shown(unit)}: must be 'Lambda', or another unit that the train of the result tells")
    return value


@dataclass(frozen=True)
class Units:
    """In which a result is drawn.

    Attributes
    ----------
    unit : str
        Of frequencies.
    per_lambda : float
        What Lambda = 1 is in it.
    frequency : str
        Label of an axis of frequencies.
    length : str
        Unit of displacements, as a label has it: they are drawn as they are.
    velocity : str
        Of velocities, which are drawn times ``velocity_factor``.
    time : str
        Label of an axis of times.
    time_factor : float
        What a time of 1/characteristic_frequency is there times Lambda where ``unit`` is Lambda.
    """

    unit: str
    per_lambda: float
    frequency: str
    length: str
    velocity: str
    velocity_factor: float
    time: str
    time_factor: float


def units_of(train: Description | None, unit: str | None) -> Units:
    """The units in which to draw a result; unless told rpm where Lambda is the speed in rpm, else Lambda."""
    if not isinstance(train, Description):
        _at_one(train, unit)
        return _PLAIN
    if unit is None:
        unit = "rpm" if train.characteristic_frequency is None and train._outline["speed"] else "Lambda"
    units = replace(_PLAIN, unit=unit, per_lambda=_at_one(train, unit))
    omega = 2 * np.pi * float(train._outline["fundamental_frequency"])
    if unit != "Lambda":
        label = f"speed of {train.speed_name}  [rpm]" if unit == "rpm" else "fundamental frequency  [Hz]"
        units = replace(units, frequency=label, time="time  [ms]", time_factor=1e3 / omega)
    # A characteristic length that was left out is 1 um.
    if train.characteristic_length is None:
        units = replace(units, length=both_units(train, r"$\mu$m", "mrad"), velocity=both_units(train, "mm/s", "rad/s"),
                        velocity_factor=1e-3 * omega)
    return units


_PLAIN = Units(
    "Lambda", 1.0, r"fundamental frequency  $\Lambda$", r"$/\, b_c$", r"$/\, b_c \omega_c$", 1.0,
    "time, periods of the fundamental", 1 / (2 * np.pi),
)
