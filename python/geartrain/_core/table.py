"""What an analysis gives, as the fields of a group of the results file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np

from .box import Box, Group
from .dataset import dataset
from .description import Description

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["Found", "Table"]

Any_table = TypeVar("Any_table", bound="Table")  # typing.Self needs Python 3.11


class Table:
    """A result with the fields of a group as attributes: a dataclass extends it and says which, of what type and meaning."""

    path: ClassVar[str]
    #: Attributes that the group has under another name, and that name.
    names: ClassVar[Mapping[str, str]] = {}
    train: Description | None

    @classmethod
    def _from(cls: type[Any_table], box: Box, train: Description | None = None) -> Any_table | None:  # noqa: PYI019
        """The result that the box holds, of a train; None where it has none."""
        group = box.results().get(cls.path)
        if group is None or not any(map(len, group.arrays.values())):
            return None
        known = {**group.values(), "train": train}
        return cls(**{item.name: known.get(cls.names.get(item.name, item.name)) for item in fields(cls)})  # type: ignore[arg-type]

    def _columns(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Attributes and arrays by their names in the group."""
        values = {self.names.get(name, name): value for name, value in vars(self).items() if name != "train"}
        arrays = {name: value for name, value in values.items() if isinstance(value, (np.ndarray, tuple))}
        return {name: value for name, value in values.items() if name not in arrays}, arrays

    def _put(self, box: Box) -> None:
        """Put it into a box as its result."""
        attributes, arrays = self._columns()
        box.put(self.path, attributes, arrays)

    def to_dataset(self) -> Dataset:
        """The fields as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        attributes, arrays = self._columns()
        return dataset(self.path, arrays, {name: value for name, value in attributes.items() if value is not None})


@dataclass(frozen=True, eq=False)
class Found:
    """The result of an analysis that has no class of its own: its fields are attributes, by their names in the results file."""

    name: str
    group: Group

    @classmethod
    def _from(cls, box: Box, name: str) -> Found:
        return cls(name, box.results()[f"/{name}"])

    def __getattr__(self, name: str) -> Any:
        # Only what is no attribute comes here; `group` itself is not there yet while a result is copied.
        try:
            return self.__dict__["group"].values()[name]
        except KeyError:
            raise AttributeError(f"{self.__dict__.get('name')!r} has no field {name!r}") from None

    def _put(self, box: Box) -> None:
        box.put(f"/{self.name}", self.group.attributes, self.group.arrays)

    def to_dataset(self) -> Dataset:
        """The fields as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        return dataset(f"/{self.name}", self.group.arrays, self.group.attributes)
