"""Excitations of a train by their orders, and the mesh forces at which a mode resonates with one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description

if TYPE_CHECKING:
    from .modes import Modes

__all__ = ["Excitation", "Resonances", "excitations"]

Array = NDArray[np.float64]

#: Amplitudes below this are the rounding of zero. Least damping ratio for which a resonance has a height.
_LEAST, _LEAST_DAMPING = 1e-12, 1e-6


@dataclass(frozen=True)
class Excitation:
    """A harmonic of a mesh or of a torque.

    Attributes
    ----------
    order : int
        In multiples of the fundamental.
    name : str
        ``'2 x mesh 1'``, ``'torque on motor'``, ``'3 x revolution of pinion'``.
    element : str
        ``'mesh 1'``, or the name of the body on which the torque acts.
    amplitude : float
        Force [N] with which the mesh, or torque [N m] with which the body is excited: of a mesh its mean stiffness times the
        amplitude of the transmission error, plus its mean force times the relative amplitude of the stiffness.
    """

    order: int
    name: str
    element: str
    amplitude: float


def excitations(train: Description) -> Iterator[Excitation]:
    """Harmonics with an amplitude: of mesh stiffness, transmission error and torques."""
    numbers = train.explain()
    for number in range(1, len(train.meshes) + 1):
        about = numbers[f"mesh {number}"]
        stiffness = _amplitudes(about.get("stiffness_cos"), about.get("stiffness_sin"))
        error = _amplitudes(about.get("error_cos"), about.get("error_sin"))
        harmonics = max(len(stiffness), len(error))
        stiffness, error = (np.pad(values, (0, harmonics - len(values))) for values in (stiffness, error))
        force = about["stiffness"] * error + abs(about.get("mean_force", 0.0)) * stiffness
        yield from _harmonics(f"mesh {number}", f"mesh {number}", about["order"], force, np.maximum(stiffness, error))
        for place, which in enumerate(("driving", "driven")):
            error = _amplitudes(about.get(f"{which}_error_cos"), about.get(f"{which}_error_sin"))
            gear = f"revolution of {gear_names(train, number)[place]}"
            order = about.get(f"{which}_revolution_order", 1)
            yield from _harmonics(gear, f"mesh {number}", order, about["stiffness"] * error, error)
    for body in train.bodies:
        name = str(body.name)
        torque = _amplitudes(body.torque_cos, body.torque_sin)
        yield from _harmonics(f"torque on {name}", name, 1, torque, torque)
        torque = _amplitudes(body.revolution_torque_cos, body.revolution_torque_sin)
        turn = numbers.get(name, {}).get("revolution_order", 1)
        yield from _harmonics(f"revolution of {name}", name, turn, torque, torque)
        yield from _of_table(name, turn, body)
    torque = _amplitudes(train.torque_cos, train.torque_sin)
    yield from _harmonics("input torque", train.body_labels[0], 1, torque, torque)


def gear_names(train: Description, mesh: int) -> tuple[str, str]:
    """Bodies of the driving and the driven gear of a mesh, from 1."""
    between = train.meshes[mesh - 1].between
    return (between[0], between[1]) if between else (train.body_labels[2 * mesh - 1], train.body_labels[2 * mesh])


def _of_table(name: str, turn: int, body: Any) -> Iterator[Excitation]:
    """Harmonics of a torque over one revolution or two: of two with half orders."""
    if body.torque_table is None or not len(body.torque_table):
        return
    table = np.asarray(body.torque_table, float)
    revolutions = body.torque_revolutions or 1
    torque = np.abs(np.fft.rfft(table)) * 2 / len(table)
    if len(table) % 2 == 0:
        torque[-1] /= 2
    for harmonic in np.flatnonzero(torque > _LEAST * torque.max()):
        if harmonic:
            words = "" if harmonic == revolutions else f"{harmonic / revolutions:g} x "
            yield Excitation(int(harmonic * turn // revolutions), f"{words}revolution of {name}", name, float(torque[harmonic]))


def _amplitudes(cosine: Any, sine: Any) -> Array:
    """Amplitudes of the harmonics of a series."""
    series = [np.atleast_1d(np.asarray([] if part is None else part, float)) for part in (cosine, sine)]
    longest = max(map(len, series))
    found: Array = np.hypot(*(np.pad(part, (0, longest - len(part))) for part in series))
    return found


def _harmonics(name: str, element: str, base: int, amplitude: Array, counts: Array) -> Iterator[Excitation]:
    for harmonic, (value, size) in enumerate(zip(amplitude, counts), 1):
        if size > _LEAST:
            words = name if harmonic == 1 else f"{harmonic} x {name}"
            yield Excitation(harmonic * int(base), words, element, float(value))


class Resonances:
    """Mesh forces at which the modes resonate with harmonic excitations: linear, all teeth in contact, mean stiffness.

    With phi the rotations of a mode, psi the displacements of the meshes and U the sum of stiffness times squared displacement over
    all shafts and meshes, an excitation F of mesh m makes the amplitude k_j psi_j psi_m F/(2 zeta U) of
    the force of mesh j. At mesh m it is the share of mesh m in the energy of the mode times F/(2 zeta).
    """

    def __init__(self, train: Description, modes: Modes) -> None:
        numbers, bodies = train.explain(), train.body_labels
        self._damping = modes.damping_ratio
        self._energy = np.zeros(len(modes.damping_ratio))
        #: Displacement of each mesh and rotation of each body in the modes, by name.
        self._shape: dict[str, Array] = {}
        rotation = np.zeros((len(self._energy), len(bodies))) if modes.rotation is None else modes.rotation
        for place, body in enumerate(bodies):
            self._shape[body] = rotation[:, place]
        force, mean = [], []
        energy = np.zeros(modes.shape.shape) if modes.energy is None else modes.energy
        self._energy += energy.sum(axis=1)
        for place, element in enumerate(modes.element):
            about = numbers.get(element, {})
            if element.startswith("mesh") and "stiffness" in about:
                displacement = np.sign(modes.shape[:, place]) * np.sqrt(energy[:, place] / about["stiffness"])
                self._shape[element] = displacement
                force.append(about["stiffness"] * displacement)
                mean.append(abs(about.get("mean_force", 0.0)))
        self._force = np.abs(np.array(force))
        # A mesh without load is measured by the load of the others.
        self._mean = np.where(np.array(mean) > 0, mean, max(mean, default=0.0) or 1.0)

    def forces(self, mode: int, causes: list[Excitation]) -> Array:
        """Amplitudes [N] of the meshes where a mode, from 1, resonates; excitations add up with the most unfavourable phases."""
        row = mode - 1
        work = sum(abs(self._shape[cause.element][row]) * cause.amplitude for cause in causes)
        found: Array = self._force[:, row] * work / (2 * max(self._damping[row], _LEAST_DAMPING) * (self._energy[row] or 1.0))
        return found

    def over_mean(self, forces: Array) -> float:
        """The largest of the amplitudes over the mean forces of their meshes."""
        return float((forces / self._mean).max(initial=0.0))
