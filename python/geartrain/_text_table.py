"""Rows of results as a table of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

__all__ = ["text_table"]


def text_table(columns: Mapping[str, Sequence[Any]]) -> str:
    """Columns by their headings; a column without any value is left out."""
    shown = {heading: [_text(value) for value in values] for heading, values in columns.items()
             if any(value is not None for value in values) or not values}
    widths = {heading: max(map(len, (heading, *texts))) for heading, texts in shown.items()}
    rows = [list(shown), *map(list, zip(*shown.values()))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(row, widths.values())) for row in rows)


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
