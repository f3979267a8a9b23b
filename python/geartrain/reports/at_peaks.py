"""What a report tells of the highest peaks of a response: which numbers of the train raise them, and their sidebands."""

from __future__ import annotations

import warnings
from collections.abc import Container, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from .._core.box import Box
from .._core.description import Description
from .._core.gradient import derivable
from .._core.parameter import value_in
from ..errors import InputError, NotDifferentiableWarning
from ..results.order_table import named_spectrum
from ..results.orders import gears_with_errors, named_orders
from .document import Document

__all__ = ["sensitivities", "sidebands"]

#: Peaks that have a column; parameters that have a row; parameters that are tried.
_PEAKS, _ROWS, _TRIED = 3, 10, 60
#: Peaks that are nearer to one another are one [of their frequency].
_NEAR = 0.01
#: Orders that are listed, and the least amplitude [of the largest one].
_ORDERS, _LEAST = 10, 1e-4
#: Multiples of a mesh frequency, and sidebands on either side of each, of the table.
_MULTIPLES, _SIDEBANDS = 3, 3

_OF_SHAFTS = ("stiffness", "damping_ratio", "damping", "loss_factor")
_OF_MESHES = ("stiffness", "damping_ratio", "damping", "loss_factor", "half_backlash", "error_cos 1", "error_sin 1")
_OF_BODIES = ("torque", "inertia")
_OF_TRAINS = ("input_torque", "stiffness_variation")


def sensitivities(made: Document, branch: Any, train: Description) -> None:
    """The derivatives of the largest mesh forces at the highest peaks."""
    peaks, stable = _highest(branch)
    if branch is None or branch.parameter is not None or not peaks:
        return
    values, heads = _parameters(train, train.explain()), []
    columns: list[dict[str, float]] = []
    for peak in peaks:
        motion = _motion_at(branch, peak.frequency, peak.mesh - 1, peak.rms)
        if motion is None or not peak.mesh_force_maximum:
            continue
        if not columns:
            values = {name: values[name] for name in derivable(Box(copy=train._kept), values)}
        columns.append(_shares(motion, peak, values))
        at = f"Lambda {peak.frequency:.6g}" if peak.speed is None else f"{peak.speed:.6g} rpm"
        heads.append(f"{train.mesh_elements[peak.mesh - 1]} at {at}{_doubt(peak)}")
    names = list(dict.fromkeys(name for column in columns for name in column))
    weight = {name: max(abs(column.get(name, 0.0)) for column in columns) for name in names}
    kept = sorted((name for name in names if weight[name] > 5e-4), key=lambda name: -weight[name])[:_ROWS]
    if not kept:
        return
    made.heading("Sensitivities")
    made.table(["", *heads], [[name, *(f"{column[name]:+.3f}" if name in column else "" for column in columns)] for name in kept])
    made.sentence(f"Change of the largest mesh force at the highest {stable}peaks, in per cent, where the number grows by one per "
                  "cent, at constant speed; by the derivatives of the periodic motion. The numbers that matter most come first.")


def _highest(branch: Any, meshes: Container[int] | None = None, most: int = _PEAKS) -> tuple[list[Any], str]:
    """The peaks of largest dynamic factor, or force without a mean load, at different speeds, but those that are surely unstable,
    as the table of resonances has them; ``"stable "`` where an unstable one would be among them."""
    found: list[Any] = []
    if branch is None or not len(branch.frequency):
        return found, ""
    with warnings.catch_warnings(), suppress(InputError):  # a branch without the settings of its response has none
        warnings.simplefilter("ignore")
        found = [peak for peak in branch.peaks() if meshes is None or peak.mesh in meshes]
    found.sort(key=lambda peak: (-np.nan_to_num(peak.dynamic_factor), -peak.mesh_force_maximum))
    kept = _apart([peak for peak in found if peak.stable is not False or peak.undecided])[:most]
    return kept, "" if kept == _apart(found)[:most] else "stable "


def _apart(found: Sequence[Any]) -> list[Any]:
    """The first peaks at different speeds."""
    kept: list[Any] = []
    for peak in found:
        if all(abs(peak.frequency - other.frequency) > _NEAR * other.frequency for other in kept):
            kept.append(peak)
    return kept


def _doubt(peak: Any) -> str:
    return " (stability undecided)" if peak.undecided else ""


def _motion_at(branch: Any, frequency: float, mesh: int, rms: float) -> Any:
    """The motion whose rms of a mesh, counted from 0, is nearest."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        motions = branch.at(frequency)
    return min(motions, key=lambda motion: abs(motion.rms[mesh] - rms), default=None)


def _shares(motion: Any, peak: Any, values: Mapping[str, float]) -> dict[str, float]:
    """Relative change of the largest force over that of each parameter."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotDifferentiableWarning)
        rates = motion.gradient("mesh_force_maximum", list(values))[peak.mesh - 1]
    return {name: float(rate) * value / peak.mesh_force_maximum for (name, value), rate in zip(values.items(), rates)
            if np.isfinite(rate)}


def _parameters(train: Description, numbers: Mapping[str, Any]) -> dict[str, float]:
    """The numbers of a train that are tried, other than 0, with their values."""
    parts = {"shaft": (len(train.shafts), _OF_SHAFTS), "mesh": (len(train.meshes), _OF_MESHES)}
    names = [*_OF_TRAINS] + [f"{body.name} {item}" for body in train.bodies for item in _OF_BODIES]
    names += [f"{part} {number} {item}" for part, (count, items) in parts.items() for number in range(1, count + 1)
              for item in items]
    found = {}
    for name in names[:_TRIED]:
        value = _value(train, numbers, name)
        if value:
            found[name] = value
    return found


def _value(train: Description, numbers: Mapping[str, Any], name: str) -> float | None:
    """The value that is given, or else that the drawing gives."""
    if name == "stiffness_variation":
        return _variation(numbers)
    try:
        value = value_in(train, name)
    except InputError:
        return None
    part, _, item = name.rpartition(" ")
    if value is None and item in numbers.get(part, {}) and np.ndim(numbers[part][item]) == 0:
        value = float(numbers[part][item])
    return value


def _variation(numbers: Mapping[str, Any]) -> float:
    """The largest amplitude of kappa."""
    largest = 0.0
    for part in numbers:
        cosine, sine = (np.ravel(numbers[part].get(item, 0.0)) for item in ("stiffness_cos", "stiffness_sin"))
        count = max(len(cosine), len(sine))
        sides = [np.pad(side, (0, count - len(side))) for side in (cosine, sine)]
        largest = max(largest, float(np.hypot(*sides).max(initial=0.0)))
    return largest


def sidebands(made: Document, results: Any, train: Description) -> None:
    """The orders of a motion and what they come from, where gears have errors of their own."""
    errors = gears_with_errors(train)
    if not errors:
        return
    made.heading("Orders and sidebands")
    motion, where = _loudest(results, {number for number, *_ in errors}, train)
    if motion is None:
        made.sentence(where)
        return
    at = f"Lambda {motion.frequency:.6g}" if motion.speed is None else f"{motion.speed:.6g} rpm"
    unit = "um" if train.characteristic_length is None else "characteristic lengths"
    places = range(-_SIDEBANDS, _SIDEBANDS + 1)
    head = ["sidebands of", "by turns of", "in", *(f"{far:+d}" if far else "0" for far in places)]
    rows: list[list[str]] = []
    others = {order: name for order, name in named_orders(train).items() if " + " not in name and " - " not in name}
    shared: dict[float, str] = {}
    for what, told in (("displacement", unit), ("mesh_force", "N")):
        lines = dict(zip(*(values.tolist() for values in motion.spectrum(what))))
        for number, gear, mesh, turn in errors:
            for times in range(1, _MULTIPLES + 1):
                orders = [times * mesh + far * turn for far in places]
                cells = [_cell(lines.get(order), number - 1) for order in orders]
                same = [far != 0 and cell != "" and order in others for far, cell, order in zip(places, cells, orders)]
                shared.update({order: others[order] for order, also in zip(orders, same) if also})
                rows.append([f"{times} x mesh {number}", gear, told,
                             *(f"{cell}*" if also else cell for cell, also in zip(cells, same))])
    made.table(head, rows)
    also = ", ".join(sorted(shared.values()))
    made.sentence(f"Amplitudes of the displacement and of the force of the mesh itself, at {where}, {at}: at multiples of its "
                  "frequency (0), and as many revolutions of the gear below and above them."
                  + (f" *: an order of another cause too, {also}, which may be the larger one." if also else ""))

    order, amplitude, owner, ratio = named_spectrum(motion, _LEAST)
    gears = {gear for _, gear, *_ in errors}
    rank = np.argsort(-(amplitude / amplitude.max(axis=0)).max(axis=1), kind="stable")
    sides = np.array([any(gear in name for gear in gears) for name in owner], dtype=bool)
    largest = np.sort(np.concatenate([rank[~sides[rank]][:_ORDERS], rank[sides[rank]][:_ORDERS]]))
    rows = [[f"{order[i] / (ratio or 1):.6g}", owner[i], *(f"{value:.4g}" for value in amplitude[i])] for i in largest]
    made.table([f"order of {train.speed_name}" if ratio else "order", "what it comes from", *train.mesh_elements], rows)
    least = "a ten-thousandth of the largest amplitude"
    made.sentence(f"Amplitudes of the mesh displacements of the same motion, in {unit}: the {_ORDERS} largest orders of the meshes "
                  + (f"and the {_ORDERS} largest of gears with errors, from {least} on." if sides.any() else
                     f"from {least} on; no order of a gear with errors has as much."))


def _cell(amplitude: Any, mesh: int) -> str:
    return "" if amplitude is None or not amplitude[mesh] else f"{amplitude[mesh]:.3g}"


def _loudest(results: Any, meshes: Container[int], train: Description) -> tuple[Any, str]:
    """A motion at the highest peak of the meshes, or at their largest force, and where that is; None, and why."""
    branch = results.response
    if branch is not None and branch.parameter is None and len(branch.frequency):
        peaks, kind = _highest(branch, meshes, 1)
        if peaks:
            peak = peaks[0]
            motion = _motion_at(branch, peak.frequency, peak.mesh - 1, peak.rms)
            if motion is not None:
                return motion, f"the highest {kind}peak of {train.mesh_elements[peak.mesh - 1]}{_doubt(peak)}"
        own = [place for place in range(branch.mesh_force_maximum.shape[1]) if place + 1 in meshes]
        force = branch.mesh_force_maximum[:, own].max(axis=1)
        stable = branch.stable is not None and np.where(branch.stable, force, 0.0)
        point = int(np.argmax(stable if np.any(stable) else force))
        mesh = own[int(branch.mesh_force_maximum[point, own].argmax())]
        motion = _motion_at(branch, branch.frequency[point], mesh, branch.rms[point, mesh])
        if motion is not None:
            return motion, f"the largest mesh force, as no mesh with errors has a {kind}peak within the range"
    motions = [motion for motion in (results.integration or ()) if getattr(motion, "period", 0)]
    if motions:
        return max(motions, key=lambda motion: float(np.max(motion.mesh_force_maximum))), "the largest mesh force"
    return None, ("Gears have errors, and orders take a motion at a speed: a response over the speed, or motions that &integration "
                  "found to be periodic.")
