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
#: What remains of forces that cancel [of their sum].
_ROUNDING = 1e-9


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
    parts : tuple of complex
        Of a mesh both of these with their phases.
    """

    order: int
    name: str
    element: str
    amplitude: float
    parts: tuple[complex, ...] = ()


def excitations(train: Description) -> Iterator[Excitation]:
    """Harmonics with an amplitude: of mesh stiffness, transmission error and torques."""
    numbers = train.explain()
    for number in range(1, len(train.meshes) + 1):
        about = numbers[f"mesh {number}"]
        stiffness = _series(about.get("stiffness_cos"), about.get("stiffness_sin"))
        error = _series(about.get("error_cos"), about.get("error_sin"))
        harmonics = max(len(stiffness), len(error))
        stiffness, error = (np.pad(values, (0, harmonics - len(values))) for values in (stiffness, error))
        parts = np.array([about["stiffness"] * error, about.get("mean_force", 0.0) * stiffness])
        yield from _harmonics(f"mesh {number}", f"mesh {number}", about["order"], np.abs(parts).sum(axis=0),
                              np.maximum(np.abs(stiffness), np.abs(error)), parts)
        for place, which in enumerate(("driving", "driven")):
            own = _amplitudes(about.get(f"{which}_error_cos"), about.get(f"{which}_error_sin"))
            gear = f"revolution of {gear_names(train, number)[place]}"
            order = about.get(f"{which}_revolution_order", 1)
            yield from _harmonics(gear, f"mesh {number}", order, about["stiffness"] * own, own)
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


def _series(cosine: Any, sine: Any) -> NDArray[np.complex128]:
    """Complex amplitudes of the harmonics of a series."""
    series = [np.atleast_1d(np.asarray([] if part is None else part, float)) for part in (cosine, sine)]
    longest = max(map(len, series))
    real, imaginary = (np.pad(part, (0, longest - len(part))) for part in series)
    found: NDArray[np.complex128] = real - 1j * imaginary
    return found


def _amplitudes(cosine: Any, sine: Any) -> Array:
    return np.abs(_series(cosine, sine))


def _harmonics(
    name: str, element: str, base: int, amplitude: Array, counts: Array, parts: NDArray[np.complex128] | None = None
) -> Iterator[Excitation]:
    for place, (value, size) in enumerate(zip(amplitude, counts)):
        if size > _LEAST:
            words = name if place == 0 else f"{place + 1} x {name}"
            own = () if parts is None else tuple(parts[:, place].tolist())
            yield Excitation((place + 1) * int(base), words, element, float(value), own)


class Resonances:
    """Mesh forces at which the modes resonate with harmonic excitations: linear, all teeth in contact, mean stiffness.

    With phi the rotations of a mode, psi the displacements of the meshes and U the sum of stiffness times squared displacement over
    all shafts and meshes, an excitation F of mesh m makes the amplitude k_j psi_j psi_m F/(2 zeta U) of
    the force of mesh j. At mesh m it is the share of mesh m in the energy of the mode times F/(2 zeta).
    """

    def __init__(self, train: Description, modes: Modes) -> None:
        numbers, bodies = train.explain(), train.body_labels
        self._carrier = {f"mesh {number}": mesh.carrier for number, mesh in enumerate(train.meshes, 1) if mesh.carrier}
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
        """Amplitudes [N] of the meshes where a mode, from 1, resonates.

        Excitations add up with the most unfavourable phases, but meshes on one carrier with their own, which the teeth give: what
        planets in sequence do to the torsion of a set cancels.
        """
        row = mode - 1
        work, sets = 0.0, dict[tuple[str, int], list[complex]]()
        for cause in causes:
            shape, carrier = float(self._shape[cause.element][row]), self._carrier.get(cause.element)
            if carrier is None or not cause.parts:
                work += abs(shape) * cause.amplitude
            else:
                for place, part in enumerate(cause.parts):
                    sets.setdefault((carrier, place), []).append(shape * part)
        for own in sets.values():
            together = abs(sum(own))
            work += together if together > _ROUNDING * sum(map(abs, own)) else 0.0
        found: Array = self._force[:, row] * work / (2 * max(self._damping[row], _LEAST_DAMPING) * (self._energy[row] or 1.0))
        return found

    def over_mean(self, forces: Array) -> float:
        """The largest of the amplitudes over the mean forces of their meshes."""
        return float((forces / self._mean).max(initial=0.0))
