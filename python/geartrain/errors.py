"""What can go wrong, as exceptions."""

from __future__ import annotations

from typing import Any

__all__ = ["DrawingWarning", "InputError", "Interrupted", "NotDifferentiableWarning", "SolverError", "shown"]

_LONGEST = 80  # characters of a value in a message


class InputError(ValueError):
    """Bad input; the message is the executable's own, with the names that a call has, one problem a line."""


class DrawingWarning(UserWarning):
    """A formula of the drawing is used outside the range that its source gives, or teeth are cut or meet as no involute."""


class NotDifferentiableWarning(UserWarning):
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


class SolverError(RuntimeError):
    """A computation that cannot give what was asked for; the message says why."""


class Interrupted(KeyboardInterrupt):
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
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."
