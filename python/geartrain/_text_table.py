"""Rows of results as a table of text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

__all__ = ["Rows", "text_table"]

Row = TypeVar("Row")


class Rows(list[Row]):
    """A list of results that is printed as a table; ``length`` is the unit of displacements in its headings."""

    length: str

    def __init__(self, rows: Iterable[Row] = (), length: str = "") -> None:
        super().__init__(rows)
        self.length = length

    def _table(self) -> Mapping[str, Sequence[Any]]:
        """The columns by their headings."""
        raise NotImplementedError

    def __str__(self) -> str:
        return text_table(self._table())

    __repr__ = __str__


def text_table(columns: Mapping[str, Sequence[Any]]) -> str:
    """Columns by their headings; a column without any value is left out. Without any row: none."""
    if not any(len(values) for values in columns.values()):
        return "none"
    shown = {heading: [_text(value) for value in values] for heading, values in columns.items()
             if any(value is not None for value in values)}
    widths = {heading: max(map(len, (heading, *texts))) for heading, texts in shown.items()}
    rows = [list(shown), *map(list, zip(*shown.values()))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(row, widths.values())) for row in rows)


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, np.ndarray):
        return "" if np.isnan(value).any() else "  ".join(f"{number:.5g}" for number in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)
