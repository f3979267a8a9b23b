"""What a motion must be before it is handed to Fortran: none that a method gives is refused, of those made by hand many."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any

import numpy as np

from ..errors import InputError, shown

__all__ = ["NUMBERS", "OTHER_TORQUES", "SHARES", "TORQUES", "UNCERTAINTIES", "VALUES", "check_motion", "check_states"]

#: Values of every shaft; None where the motion has none.
TORQUES = ("shaft_torque_mean", "shaft_torque_minimum", "shaft_torque_maximum")
#: Values of every held body and of every coupling, and forces of every bearing; None where the train has none.
OTHER_TORQUES = (
    *(f"{of}_torque_{what}" for of in ("reaction", "coupling") for what in ("mean", "minimum", "maximum")),
    *(f"bearing_force_{what}" for what in ("mean", "rms", "minimum", "maximum")), "coupling_energy_loss",
)
#: Values of every planet of planetary sets; None where the train has none.
SHARES = ("load_share", "load_share_maximum")
#: What a longer window changes of the figures, of every mesh and of every shaft; None where there is no window.
UNCERTAINTIES = (
    *("rms_uncertainty", "mean_uncertainty", "minimum_uncertainty", "maximum_uncertainty", "force_uncertainty"),
    *("torque_mean_uncertainty", "torque_min_uncertainty", "torque_max_uncertainty"),
)
#: Values of every mesh, in Fortran's order.
VALUES = (
    *("rms", "mean", "minimum", "maximum"),
    *("mesh_force_maximum", "dynamic_factor", "separation_fraction", "back_contact_fraction"),
)
#: Numbers of a motion, one each.
NUMBERS = ("error_estimate", "reading_error_estimate", "share", "lyapunov_exponent", "lyapunov_error", "ringing")
_KINDS = ("periodic", "stationary", "chaotic", "quasi-periodic", "still settling", "undecided", "unbounded")
_LARGEST = 1e20  # of any number, as in a case file
_LONGEST = 2**31 - 1  # periods of the fundamental, what Fortran can count; the harmonics must hold them as well


def check_motion(
    motion: Any, what: str = "motion", meshes: int | None = None, states: int | None = None, *, only_state: bool = False
) -> None:
    """Raise `InputError` where a motion is none that any method gives.

    Parameters
    ----------
    motion : Motion
    what : str
        What messages call it.
    meshes, states : int, optional
        Those of the train that it is to be a motion of.
    only_state : bool
        It stands for a state: there are no coefficients, and the frequency means nothing.
    """
    _check_numbers(motion, what)
    coefficients = motion.coefficients
    if not _is_array(coefficients, 2):
        raise InputError(f"{what}: coefficients = {shown(coefficients)}: must be an array of numbers, (meshes, 1 + 2*harmonics)")
    found, terms = coefficients.shape
    if meshes is not None and found != meshes:
        raise InputError(f"{what}: a motion of {found} meshes: the train has {meshes}: must be as many")
    for name in VALUES:
        value = getattr(motion, name)
        if not _is_array(value, 1) or len(value) != found:
            raise InputError(f"{what}: {name} = {shown(value)}: must be an array of numbers, one of each mesh, hence {found}")
    for name in TORQUES:
        value = getattr(motion, name)
        if value is not None and (not _is_array(value, 1) or len(value) != len(np.atleast_1d(motion.shaft_torque_mean))):
            raise InputError(f"{what}: {name} = {shown(value)}: must be an array of numbers, one of each shaft, or None")
    for name in SHARES:
        value = getattr(motion, name)
        if value is not None and (not _is_array(value, 1) or len(value) != len(np.atleast_1d(motion.load_share))):
            raise InputError(f"{what}: {name} = {shown(value)}: must be an array of numbers, one of each planet, or None")
    for name in UNCERTAINTIES:
        value = getattr(motion, name)
        count = len(np.atleast_1d(motion.shaft_torque_mean)) if name.startswith("torque") else found
        if value is not None and (not _is_array(value, 1) or len(value) != count):
            raise InputError(f"{what}: {name} = {shown(value)}: must be an array of {count} numbers, or None")
    _check_state(motion, what, states)
    if only_state:
        return
    if terms % 2 == 0:
        raise InputError(f"{what}: coefficients of shape {coefficients.shape}: must be (meshes, 1 + 2*harmonics)")
    if motion.unbounded:
        return
    if not (np.abs(coefficients) <= _LARGEST).all():
        raise InputError(f"{what}: coefficients: must be finite numbers of a magnitude up to {_LARGEST:g}")
    harmonics = terms // 2
    if motion.period > max(harmonics, 1):
        raise InputError(
            f"{what}: period = {shown(motion.period)}: has {harmonics} harmonics, of which none is the fundamental itself: "
            "must be at most that many"
        )


def check_states(number: int, states: int, what: str) -> None:
    """Raise `InputError` where a state has another number of values than the train."""
    if number != states:
        raise InputError(
            f"{what}: a state of {number} values: must have {states} (displacement of each elastic element, then the velocities)"
        )


def _check_numbers(motion: Any, what: str) -> None:
    """What is one number, flag or word."""
    if isinstance(motion.period, bool) or not isinstance(motion.period, Integral) or not 0 <= int(motion.period) <= _LONGEST:
        raise InputError(f"{what}: period = {shown(motion.period)}: must be a whole number >= 0 and <= {_LONGEST}")
    if not (_is_number(motion.frequency) and np.isfinite(float(motion.frequency))):
        raise InputError(f"{what}: frequency = {shown(motion.frequency)}: must be a finite number")
    if not (_is_number(motion.window) and 0 <= float(motion.window) <= _LARGEST):
        raise InputError(f"{what}: window = {shown(motion.window)}: must be a finite number >= 0")
    for name in NUMBERS:
        if not _is_number(getattr(motion, name)):
            raise InputError(f"{what}: {name} = {shown(getattr(motion, name))}: must be a number")
    for name in ("stable", "undecided", "floating"):
        value = getattr(motion, name)
        if not isinstance(value, (bool, np.bool_)) and not (name == "stable" and value is None):
            raise InputError(f"{what}: {name} = {shown(value)}: must be True or False")
    if motion.kind not in _KINDS:
        raise InputError(f"{what}: kind = {shown(motion.kind)}: must be one of {', '.join(map(repr, _KINDS))}")


def _check_state(motion: Any, what: str, states: int | None) -> None:
    """The state and the multipliers, which a motion may lack."""
    state, multipliers = motion.state, motion.multipliers
    if state is None:
        if motion.unbounded:
            raise InputError(f"{what}: state = None: must be given where kind = 'unbounded', which has nothing else")
    elif not _is_array(state, 1) or not (np.abs(state) <= _LARGEST).all():
        raise InputError(f"{what}: state: must be an array of finite numbers of a magnitude up to {_LARGEST:g}, (2*elements,)")
    elif states is not None:
        check_states(len(state), states, what)
    if multipliers is None:
        return
    if not (isinstance(multipliers, np.ndarray) and multipliers.ndim == 1 and multipliers.dtype == np.complex128):
        raise InputError(f"{what}: multipliers = {shown(multipliers)}: must be an array of complex numbers, (states,)")
    if states is not None and len(multipliers) > states:
        raise InputError(f"{what}: {len(multipliers)} multipliers: must be at most {states}, the states of the train")


def _is_array(value: Any, dimensions: int) -> bool:
    return isinstance(value, np.ndarray) and value.ndim == dimensions and value.dtype.kind in "fiu"


def _is_number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    try:
        float(value)
    except OverflowError:
        return False
    return True
