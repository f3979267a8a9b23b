"""Results as xarray Datasets, with the names, units and coordinates that they have in the results file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .box import described
from .extras import extra

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

__all__ = ["dataframe", "dataset", "labels_along"]


def dataset(path: str, values: dict[str, Any], attributes: dict[str, Any], coordinates: tuple[str, ...] = ()) -> Dataset:
    """The fields of a group that there are values of.

    Parameters
    ----------
    path : str
        Of the group in a results file.
    values : dict
        Arrays by their names there; None for what there is not.
    coordinates : tuple of str
        Those that are coordinates beside the axes and their labels.
    attributes : dict
        Those of the group.
    """
    variables: dict[str, Any] = {}
    axes: dict[str, Any] = {}
    about = described()[path].about
    for name, (dimensions, unit, description) in about.items():
        value = values.get(name)
        if value is None:
            continue
        array = np.asarray(value)
        if array.dtype.kind == "c":
            array, dimensions = np.stack([array.real, array.imag], axis=-1), (*dimensions, "complex")
        variables[name] = dimensions, array, {"units": unit, "description": description}
        for dimension, length in zip(dimensions, array.shape):
            axes.setdefault(dimension, (dimension, labels_along(dimension, length, values.get("orders"))))
    told = {name: int(value) if isinstance(value, bool) else value for name, value in attributes.items()}
    found: Dataset = extra("xarray").Dataset(variables, {name: axis for name, axis in axes.items() if name not in variables}, told)
    for axis in found.coords.values():
        if axis.name in about:
            _, unit, description = about[str(axis.name)]
            axis.attrs.update(units=unit, description=description)
    return found.set_coords([name for name in (*coordinates, *(f"{axis}_label" for axis in axes)) if name in variables])


def dataframe(points: Dataset) -> DataFrame:
    """A row for each point, with a column for each field of it, and of each mesh, shaft or planet."""
    columns: dict[str, Any] = {}
    for name, array in [*points.coords.items(), *points.data_vars.items()]:
        if array.dims == ("point",) and name != "point":
            columns[str(name)] = array.values
        elif array.ndim == 2 and "point" in array.dims:
            other = next(str(axis) for axis in array.dims if axis != "point")
            if other in {"mesh", "shaft", "planet", "coupling", "held"}:
                for place in range(array.sizes[other]):
                    columns[f"{name}, {other} {place + 1}"] = array.isel({other: place}).values
        elif array.dims == ("point", "bearing", "axis"):
            for place, axis in np.ndindex(array.shape[1:]):
                columns[f"{name}, bearing {place + 1} {'xy'[axis]}"] = array.values[:, place, axis]
    frame: DataFrame = extra("pandas").DataFrame(columns)
    return frame


def labels_along(dimension: str, length: int, orders: Any = None) -> Any:
    """The places along a dimension, as a results file has them."""
    if dimension == "coefficient":
        return ["mean", *(f"{name} {order}" for order in (range(1, (length + 1) // 2) if orders is None else orders)
                          for name in ("cos", "sin"))]
    named = {"complex": ["real", "imaginary"], "axis": ["x", "y"]}
    return named.get(dimension, np.arange(1, length + 1, dtype=np.intc))
