"""Warnings that point to the line of the user."""

from __future__ import annotations

import sys
import warnings

from ..errors import plain

__all__ = ["warn"]

#: Modules whose lines are not the user's: those of the package, and the standard library's that make its dataclasses.
_OWN = {"geartrain", "dataclasses", "copy"}


def warn(message: str | Warning, category: type[Warning] = UserWarning) -> None:
    """Warn at the nearest line outside of the package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).partition(".")[0] in _OWN:
        level, frame = level + 1, frame.f_back
    warnings.warn(plain(message, lines=True) if isinstance(message, str) else message, category, stacklevel=level)
