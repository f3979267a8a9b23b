"""Captions: what axes, menus and tables call the quantities of motions, in words of the trade."""

from __future__ import annotations

from .._core.description import Description
from .._core.units import units_of

__all__ = [
    "CAPTIONS", "LENGTHS", "caption", "first_quantity", "force_unit", "force_words", "is_drawn", "motion_words", "number_words",
]

#: Of fields with a column for each mesh or shaft, and of what pictures compute from them.
CAPTIONS = {
    "rms": "rms of the paper (true rms times \u221a2)",
    "true_ac_rms": "true rms",
    "peak_to_peak": "peak to peak",
    "mean": "mean",
    "minimum": "smallest",
    "maximum": "largest",
    "mesh_force": "largest mesh force",
    "mesh_force_maximum": "largest mesh force",
    "dynamic_factor": "dynamic factor, largest over mean mesh force",
    "separation_fraction": "share of time without contact",
    "back_contact_fraction": "share of time on the back flanks",
    "load_share": "share of the mean load of the planets",
    "load_share_maximum": "largest force over the mean load of all planets",
    "shaft_torque": "shaft torque, smallest to largest",
    "shaft_torque_minimum": "smallest shaft torque",
    "shaft_torque_maximum": "largest shaft torque",
    "shaft_torque_mean": "mean shaft torque",
    "reaction_torque_minimum": "smallest torque of the support",
    "reaction_torque_maximum": "largest torque of the support",
    "reaction_torque_mean": "mean torque of the support",
    "reaction_torque": "torque of the support, smallest to largest",
    "coupling_torque": "coupling torque, smallest to largest",
    "coupling_torque_minimum": "smallest coupling torque",
    "coupling_torque_maximum": "largest coupling torque",
    "coupling_torque_mean": "mean coupling torque",
    "coupling_energy_loss": "energy loss of the coupling in a period of the fundamental",
    "bearing_force": "bearing force, smallest to largest",
    "bearing_force_minimum": "smallest bearing force",
    "bearing_force_maximum": "largest bearing force",
    "bearing_force_mean": "mean bearing force",
    "bearing_force_rms": "true rms of the bearing force without its mean",
}
#: Displacements of meshes, over the characteristic length.
LENGTHS = ("rms", "true_ac_rms", "peak_to_peak", "mean", "minimum", "maximum")


def caption(name: str, force: str = "mesh force") -> str:
    """What a quantity is called, where the force of meshes is called ``force``."""
    words = CAPTIONS.get(name, name.replace("_", " ")).replace("mesh force", force)
    return f"mesh displacement, {words}" if name in LENGTHS else words


def is_drawn(train: Description | None) -> bool:
    """Whether results are in rpm: the train is given by its drawing, and Lambda is the speed."""
    return units_of(train, None).unit == "rpm"


def force_unit(train: Description | None) -> str:
    """Unit of the force of meshes, after which the couplings stand with their torque."""
    if train is None or not train.couplings:
        return "N"
    return "N, of couplings N m" if train.meshes or train.bearings else "N m"


def force_words(train: Description | None) -> str:
    """What the forces of meshes are called, beside which couplings and bearings stand."""
    if train is None or (train.meshes and not train.bearings):
        return "mesh force"
    there = (train.meshes, "mesh"), (not train.meshes and train.couplings, "coupling"), (train.bearings, "bearing")
    words = " or ".join(word for elements, word in there if elements)
    return f"{words} {'force' if train.meshes or train.bearings else 'torque'}"


def first_quantity(train: Description | None) -> str:
    """What a picture shows unless told: the mesh force of a train with a drawing, else the rms of the paper."""
    return "mesh_force" if is_drawn(train) else "rms"


def number_words(value: float) -> str:
    """A number with four digits, or the digits before its point."""
    return f"{value:.0f}" if 1000 <= abs(value) < 1e7 else f"{value:.4g}"


def motion_words(train: Description | None, frequency: float, period: int, kind: str, stable: bool | None) -> str:
    """At which speed a motion is, and after how many periods of the fundamental it repeats where that is not one."""
    if is_drawn(train) and train is not None:
        words = f"{number_words(frequency)} rpm of {train.speed_name}"
    else:
        hertz = units_of(train, "Hz").per_lambda * frequency if isinstance(train, Description) else None
        words = rf"$\Lambda$ = {frequency:.4g}" + ("" if hertz is None else f" ({number_words(hertz)} Hz)")
    if period > 1:
        words += f", repeats after {period} periods"
    elif not period and kind:
        words += f", {kind}"
    return f"{words}, unstable" if stable is False else words
