"""Derivatives with respect to parameters of a train, over the border."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, NotDifferentiableWarning, shown
from .box import Box
from .warn import warn
from .watch import quiet, watched

__all__ = ["derivable", "gradient_of", "refuse_without_effect"]

Array = NDArray[np.float64]


def gradient_of(
    box: Box, what: str, parameters: Sequence[str], number: int = 0, frequency: float = 0.0, coefficients: Array | None = None
) -> Array:
    """The derivatives, (items, parameters), from a box, which is closed; the other arguments as ``differentiate`` has them."""
    terms = np.zeros((1, 1)) if coefficients is None else coefficients
    with box:
        if isinstance(parameters, str) or not all(isinstance(name, str) and name.strip() for name in parameters):
            raise InputError(f"parameters = {shown(parameters)}: must be a list of names, such as 'mesh 1 half_backlash'")
        names = "\n".join(" ".join(name.split()) for name in parameters)

        def work(progress: Array) -> tuple[Array, list[str]]:
            box.gradient(what, names, progress, number, frequency, terms)
            group = box.show("gradient")["/gradient"]
            return group.arrays["value"].T, [reason.strip() for reason in group.arrays["reason"]]

        values, reasons = watched(work, "gradient", in_parts=False)
    told = {name: reason for name, reason in zip(parameters, reasons) if reason}
    if told:
        warn(NotDifferentiableWarning(told))
    return values


def derivable(box: Box, parameters: Iterable[str]) -> list[str]:
    """The names that have derivatives in the train of a box, which is closed: others are refused, as of a number not in force."""
    left = list(parameters)
    with box:
        while left:
            try:
                box.gradient("/parameters", "\n".join(left), quiet(), 0, 0.0, np.zeros((1, 1)))
                break
            except InputError as error:
                refused = [name for name in left if f'parameter "{name}"' in str(error)]
                if not refused:
                    raise
                left = [name for name in left if name not in refused]
    return left


def refuse_without_effect(box: Box, parameters: Sequence[str]) -> None:
    """Refuse parameters without effect in the train of a box, which is closed; other problems are told elsewhere."""
    with box:
        try:
            box.gradient("/parameters", "\n".join(parameters), quiet(), 0, 0.0, np.zeros((1, 1)))
        except InputError as error:
            told = [line for line in str(error).splitlines() if "what would follow from it" in line]
            if told:
                raise InputError("\n".join(told)) from None
