"""A study's Dataset as what a page shows of it: a column for each parameter and each number that is kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import InputError
from .page_pack import Block

__all__ = ["shown_study"]

#: Most places along a dimension of its own, such as jumps, of which each becomes a column; a field with more is left out.
_PLACES = 12


def shown_study(dataset: Any, block: Block, results: Mapping[int, int]) -> dict[str, Any]:
    """The points of a study; ``results`` are the files of the page by the points that they are of."""
    if "status" not in dataset:
        raise InputError("results: must be gt.Results, a gt.Branch or the Dataset of a gt.Study, which has 'status'")
    axes = dataset["status"].dims
    count = int(dataset["status"].size)
    wrong = [point for point in results if not 0 <= point < count]
    if wrong:
        raise InputError(f"branches: point {wrong[0]}: must be from 0 to {count - 1}")
    parameters: list[dict[str, Any]] = []
    outputs: list[dict[str, Any]] = []
    texts: list[dict[str, Any]] = []
    left_out: list[str] = []
    for name, values in {**dataset.coords, **dataset.data_vars}.items():
        own = [dimension for dimension in values.dims if dimension not in axes]
        known = name in dataset.coords
        if len(own) == len(values.dims) or (known and own) or name == "sample":
            continue
        if any(values.sizes[dimension] > _PLACES for dimension in own):
            left_out.append(str(name))
            continue
        whole = values.broadcast_like(dataset["status"]).transpose(*axes, *own)
        columns = np.asarray(whole.values).reshape(count, -1)
        for place, label in enumerate(_labels(dataset, values, own)):
            column, words = columns[:, place], f"{name}{label}"
            if column.dtype.kind in "OU":
                texts.append({"name": words, "values": [str(text) for text in column]})
                continue
            numbers = column.astype(float)
            finite = numbers[np.isfinite(numbers)]
            if finite.size:
                told = {"name": words, "unit": values.attrs.get("units", ""), "constant": bool(np.ptp(finite) == 0),
                        "values": block.add(numbers, "f8")}
                (parameters if known else outputs).append(told)
    return {
        "title": dataset.attrs.get("title", ""),
        "about": f"Study of {count} points: {dataset.attrs.get('analysis', 'results')}",
        "count": count,
        "parameters": len(parameters),
        "columns": parameters + outputs,
        "leftOut": left_out,
        "texts": [text for text in texts if any(text["values"])],
        "results": dict(results),
    }


def _labels(dataset: Any, values: Any, own: list[str]) -> list[str]:
    """What is added to the name of a field at each place along its own dimensions."""
    labels = [""]
    for dimension in own:
        if f"{dimension}_label" in dataset.coords:
            places = [f", {name}" for name in dataset[f"{dimension}_label"].values]
        else:
            places = [f", {dimension} {place}" for place in dataset[dimension].values]
        labels = [label + place for label in labels for place in places]
    return labels
