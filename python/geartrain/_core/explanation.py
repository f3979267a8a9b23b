"""What a train is in numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from ..errors import plain
from .box import Box

__all__ = ["Explanation"]


class Explanation(Mapping[str, Mapping[str, Any]]):
    """Every number of a train, derived from the drawing or given: a mapping of mappings.

    By ``'train'``, the names of the bodies, ``'shaft 1'``, ..., ``'mesh 1'``, ..., and in each by the names of its numbers. Printed
    it is the text of ``geartrain --explain``, which tells each number with its formula, its source and its range.

    Attributes
    ----------
    about : mapping of mappings
        The formula and the source of each number, by the names of the numbers.
    unit : mapping of mappings
        The unit of each number; ``'1'`` where it has none, ``''`` of words.

    Examples
    --------
    >>> explained = train.explain()
    >>> explained["mesh 2"]["stiffness"], explained.unit["mesh 2"]["stiffness"], explained.about["mesh 2"]["stiffness"]
    (500000000.0, 'N/m', 'as given')
    """

    def __init__(
        self, text: str, numbers: Mapping[str, Mapping[str, Any]], about: Mapping[str, Mapping[str, str]],
        unit: Mapping[str, Mapping[str, str]],
    ) -> None:
        self._text = text
        self._numbers = numbers
        self.about = about
        self.unit = unit

    def __getitem__(self, name: str) -> Mapping[str, Any]:
        if name not in self._numbers:
            raise KeyError(plain(f"{name}: must be one of {', '.join(self._numbers)}"))
        return MappingProxyType(self._numbers[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._numbers)

    def __len__(self) -> int:
        return len(self._numbers)

    def __str__(self) -> str:
        return self._text

    __repr__ = __str__

    @classmethod
    def _of(cls, box: Box) -> Explanation:
        """That of the box's train."""
        groups = box.show("explanation")
        for group in groups.values():
            for values in group.arrays.values():
                values.flags.writeable = False
        told = {name: {**group.told, **{item: row[1:] for item, row in group.about.items()}} for name, group in groups.items()}
        about, unit = ({name: {item: row[place] for item, row in rows.items()} for name, rows in told.items()} for place in (1, 0))
        return cls(box.text("explanation").rstrip("\n"), {name: group.values() for name, group in groups.items()}, about, unit)
