"""Rows of results as a table of text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .description import Description, element_name
from .extras import extra
from .units import length_unit

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["Rows", "text_table"]

Row = TypeVar("Row")


class Rows(list[Row]):
    """A list of results of a train that is printed as a table."""

    train: Description | None

    def __init__(self, rows: Iterable[Row] = (), train: Description | None = None) -> None:
        super().__init__(rows)
        self.train = train

    @property
    def length(self) -> str:
        """Unit of displacements, as a heading has it."""
        return length_unit(self.train)

    def _table(self) -> Mapping[str, Sequence[Any]]:
        """The columns by their headings."""
        raise NotImplementedError

    def to_dataframe(self) -> DataFrame:
        """The table as a pandas DataFrame, a row for each result, with numbers as they are; needs pandas.

        A column of values of several meshes becomes a column for each mesh. A column without any value is left out.
        """
        columns: dict[str, list[Any]] = {}
        for heading, values in self._table().items():
            if any(isinstance(value, np.ndarray) for value in values):
                for mesh in range(max(value.size for value in values if isinstance(value, np.ndarray))):
                    own = [value[mesh] if isinstance(value, np.ndarray) else None for value in values]
                    columns[f"{heading}, {element_name(self.train, mesh)}"] = own
            elif any(value is not None for value in values):
                columns[heading] = list(values)
        frame: DataFrame = extra("pandas").DataFrame(columns)
        return frame

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
