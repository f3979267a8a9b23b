"""What can go wrong, as exceptions."""

from __future__ import annotations

import re
from typing import Any

__all__ = ["DrawingWarning", "InputError", "Interrupted", "NotDifferentiableWarning", "SolverError", "plain", "shown"]

_LONGEST = 80  # characters of a value in a message

#: Characters that act on the line or the terminal that shows them, as `acting` in plain_text.f90 lists them, and surrogates,
#: which no stream can write.
_ACTING = re.compile(
    "[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u206f\ufeff\ufff9-\ufffb\U000e0000-\U000e007f\ud800-\udfff]"
)


def plain(text: str, lines: bool = False) -> str:
    r"""A text with every character that acts on the line or the terminal as its code, such as ``\x1b``.

    Parameters
    ----------
    text : str
        A plain text stays as it is, so that a text may be escaped twice.
    lines : bool
        Whether the text has several lines, whose newlines stay.
    """
    return _ACTING.sub(lambda found: "\n" if lines and found[0] == "\n" else _code(found[0]), text)


def _code(character: str) -> str:
    number = ord(character)
    return f"\\x{number:02x}" if number < 256 else f"\\u{number:04x}" if number < 65536 else f"\\U{number:08x}"


class _Told(BaseException):
    """An error or a warning whose message is escaped: names of files and texts read from files may contain anything."""

    def __init__(self, *values: Any) -> None:
        super().__init__(*(plain(value, lines=True) if isinstance(value, str) else value for value in values))


class InputError(_Told, ValueError):
    """Bad input; the message is the executable's own, with the names that a call has, one problem a line."""


class DrawingWarning(_Told, UserWarning):
    """A formula of the drawing is used outside its range, teeth are cut or meet as no involute, or a mode lacks damping."""


class NotDifferentiableWarning(_Told, UserWarning):
    """Derivatives that do not exist and are NaN.

    Attributes
    ----------
    reasons : dict
        Why, by the name of the parameter.
    """

    def __init__(self, reasons: dict[str, str]) -> None:
        names: dict[str, list[str]] = {}
        for name, reason in reasons.items():
            names.setdefault(reason, []).append(name)
        super().__init__(" ".join(f"No derivative with respect to {', '.join(of)}: {reason}." for reason, of in names.items()))
        self.reasons = reasons

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.reasons,)


class SolverError(_Told, RuntimeError):
    """A computation that cannot give what was asked for; the message says why."""


class Interrupted(_Told, KeyboardInterrupt):
    """Ctrl-C during long work.

    Attributes
    ----------
    result : Branch, Sweep, Results, list of Motion, or None
        What was computed before.
    """

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.args[0], self.result)


def shown(value: Any) -> str:
    """A value in a message: its ``repr``, not more of it than helps."""
    try:
        text = repr(value)
    except ValueError:  # an integer of more digits than Python writes
        return "an integer too long to be written"
    text = plain(text)
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."
