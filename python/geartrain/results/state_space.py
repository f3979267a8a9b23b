"""A train as a linear system with torques as inputs: for controllers."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description
from ..errors import InputError, shown
from .modes import Modes

__all__ = ["StateSpace", "averaged", "state_space_of"]

Array = NDArray[np.float64]
_SAMPLES, _MOST = 2048, 2**19  # of a mesh cycle, for the share of time in contact; of a period of the fundamental


@dataclass(frozen=True, eq=False, repr=False)
class StateSpace:
    """dx/dt = A x + B u, y = C x + D u, in SI units and seconds: deviations from the steady motion of the mean train in contact, or
    of the train averaged over a periodic motion.

    Attributes
    ----------
    A, B, C, D : ndarray
        (states, states), (states, inputs), (outputs, states) and (outputs, inputs).
    states : tuple of str
        Coordinates of the elastic modes [rad], ``'mode 1'``; then the rates of all modes and of the rigid motions,
        ``'rate of mode 1'``, ``'rate of rigid motion 1'``. Angles of rigid motions, on which nothing depends, are none.
    inputs : tuple of str
        Bodies whose torques [N m] are the inputs, positive in the sense in which the body turns.
    outputs : tuple of str
        Elements, ``'shaft 1'``, ``'mesh 1'`` or ``'ground 2'`` (the spring to ground of the second body), with torque or force;
        bodies with their speed, positive as they turn.
    units : tuple of str
        Of the outputs: N m, N or rad/s.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<StateSpace: {len(self.states)} states, inputs {', '.join(self.inputs)}; outputs {', '.join(self.outputs)}>"

    def response(self, frequency: float) -> Array:
        """Outputs over inputs at a frequency [Hz], complex, (outputs, inputs)."""
        found: Array = self.C @ np.linalg.solve(2j * np.pi * frequency * np.eye(len(self.states)) - self.A, self.B) + self.D
        return found


def state_space_of(train: Description, modes: Modes, inputs: Sequence[str] | None, outputs: Sequence[str] | None) -> StateSpace:
    """The state space in the coordinates of the modes, whose displacements follow from their energies."""
    if modes.rotation is None or modes.energy is None or not train.bodies:
        raise InputError("state_space: needs a train of bodies: give &body, and the names of bodies in between")
    numbers = train.explain()
    bodies = tuple(modes.body or ())
    motions = np.zeros((0, len(bodies))) if modes.rigid_rotation is None else modes.rigid_rotation
    asked, told = _named("inputs", inputs, bodies, bodies), _named("outputs", outputs, modes.element, (*modes.element, *bodies))
    stiffness = np.array([_stiffness(train, modes, place) for place in range(len(modes.element))])
    damping = np.array([0.0 if name.startswith("ground") else _of_element(numbers, name, "damping") for name in modes.element])
    elastic, rigid = len(modes.natural_frequency), len(motions)

    # Twist or stretch of the elements, and rotation of the bodies, by the coordinates of the motions.
    stretch = np.zeros((len(modes.element), elastic + rigid))
    stretch[:, :elastic] = (np.sign(modes.shape) * np.sqrt(modes.energy / stiffness)).T
    rotation = np.vstack([modes.rotation, motions]).T
    omega = modes.natural_frequency * numbers["train"]["characteristic_frequency"]
    inertia = np.array([numbers[name].get("inertia", 0.0) if name in numbers else 0.0 for name in bodies])
    mass = np.diag([*(modes.energy.sum(axis=1) / omega**2), *np.zeros(rigid)])
    mass[elastic:, elastic:] = motions * inertia @ motions.T
    grounded = {body.name: body.damping_to_ground or 0.0 for body in train.bodies}
    ground = np.array([grounded.get(name, 0.0) for name in bodies])
    resistance = stretch.T * damping @ stretch + rotation.T * ground @ rotation
    forces = np.hstack([np.vstack([np.diag(np.diag(mass)[:elastic] * omega**2), np.zeros((rigid, elastic))]), resistance])

    size = 2 * elastic + rigid
    a, b = np.zeros((size, size)), np.zeros((size, len(asked)))
    a[:elastic, elastic:2 * elastic] = np.eye(elastic)
    a[elastic:] = -np.linalg.solve(mass, forces)
    b[elastic:] = np.linalg.solve(mass, rotation[[bodies.index(name) for name in asked]].T)
    c, units = np.zeros((len(told), size)), []
    for row, name in enumerate(told):
        if name in modes.element:
            place = modes.element.index(name)
            c[row] = [*(stiffness[place] * stretch[place, :elastic]), *(damping[place] * stretch[place])]
            units.append("N m" if name.startswith(("shaft", "coupling", "ground")) else "N")
        else:
            c[row, elastic:] = rotation[bodies.index(name)]
            units.append("rad/s")
    motion = [f"mode {number}" for number in range(1, elastic + 1)] + [f"rigid motion {number}" for number in range(1, rigid + 1)]
    states = (*motion[:elastic], *(f"rate of {name}" for name in motion))
    return StateSpace(a, b, c, np.zeros((len(told), len(asked))), states, asked, told, tuple(units))


def averaged(train: Any, motion: Any) -> Any:
    """The train with the stiffness and damping that its teeth have on average over a periodic motion: none while they are apart."""
    if getattr(motion, "kind", "") != "periodic":
        raise InputError(f"at = {shown(motion)}: must be a periodic motion")
    if train.couplings or train.bearings or motion.displacement.shape[1] != len(train.meshes):
        raise InputError("at: must be a motion of this train, and the train without couplings and bearings")
    numbers, meshes = train.explain(), []
    fastest = max(numbers[f"mesh {number}"]["order"] for number in range(1, len(train.meshes) + 1))
    waves = motion.trajectory(motion.period, samples=min(_SAMPLES * int(max(1, fastest)), _MOST)).displacement
    for place, mesh in enumerate(train.meshes):
        name = f"mesh {place + 1}"
        if mesh.driving_tooth_stiffness is not None or mesh.driven_tooth_stiffness is not None or mesh.table_loads is not None:
            raise InputError(f"at: {name} has stiffnesses of single teeth or of loads, which are not averaged")
        about, displacement = numbers[name], waves[:, place] * numbers["train"]["characteristic_length"]
        gap = about.get("half_backlash", 0.0)
        drive = displacement > gap if gap else np.ones(len(displacement), bool)
        back = displacement < -gap if gap else ~drive
        angle = 2 * np.pi * motion.period * about["order"] * np.arange(len(displacement)) / len(displacement)
        share = np.where(drive, _kappa(about, angle), 0.0).mean()
        share += (mesh.back_stiffness or about["stiffness"]) / about["stiffness"] * np.where(
            back, _kappa(about, angle - (mesh.back_phase or 0.0)), 0.0).mean()
        if share <= 0:
            raise InputError(f"at: the teeth of {name} do not touch in this motion")
        touches = (drive | back).mean() if mesh.damping_acts == "contact" else 1.0
        meshes.append(replace(mesh, stiffness=float(share * about["stiffness"]), damping=float(touches * about["damping"]),
                              damping_ratio=None, loss_factor=None, back_stiffness=None, stiffness_table=None,
                              stiffness_cos=None, stiffness_sin=None, contact_ratio=None))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the train as it is has told them
        return replace(train, meshes=meshes)


def _kappa(about: Any, angle: Array) -> Array:
    """Mesh stiffness over its mean at angles of the mesh cycle."""
    found = np.ones(len(angle))
    for values, wave in ((about.get("stiffness_cos"), np.cos), (about.get("stiffness_sin"), np.sin)):
        for harmonic, value in enumerate(np.atleast_1d([] if values is None else values), 1):
            found += value * wave(harmonic * angle)
    return found


def _named(argument: str, names: Sequence[str] | None, usual: Sequence[str], known: Sequence[str]) -> tuple[str, ...]:
    """Names that were asked for, each of which must be known."""
    if names is None:
        return tuple(usual)
    if isinstance(names, str) or not names or any(name not in known for name in names):
        raise InputError(f"{argument} = {shown(names)}: must be a list of names: {', '.join(known)}")
    return tuple(names)


def _of_element(numbers: Any, name: str, what: str) -> float:
    """Stiffness or damping of an element; of a bearing that of its direction."""
    place, direction = (name[:-2], name[-1]) if name.startswith("bearing") else (name, "x")
    value = numbers[place].get(what, 0.0)
    return float(value if np.ndim(value) == 0 else value["xy".index(direction)])


def _stiffness(train: Description, modes: Modes, place: int) -> float:
    """Stiffness of an element in contact under the mean load: that of its stage, where it has stages."""
    name = modes.element[place]
    kind, number = name.split()[0], int(name.split()[1]) - 1
    if kind == "ground":
        assert modes.body is not None
        return next(body.stiffness_to_ground or 0.0 for body in train.bodies or () if body.name == modes.body[number])
    part = train.couplings[number] if kind == "coupling" else train.meshes[number] if kind == "mesh" else None
    if kind == "bearing" and name.split()[2] not in ("x", "y"):
        raise InputError(f"state_space: {name}: a clearance with more than four flats is no linear element")
    if getattr(part, "friction_torque", 0.0):
        raise InputError(f"state_space: {name} has dry friction, which is not linear: leave out its friction_torque")
    if getattr(part, "table_loads", None) is not None:
        raise InputError(f"state_space: {name} has table_loads: give its stiffness at the working load in their place")
    numbers = train.explain()[name] if kind != "bearing" else {}
    if "stages" not in numbers:
        return _of_element(train.explain(), name, "stiffness")
    # Bodies turn alike where nothing is deflected.
    assert modes.rotation is not None and modes.energy is not None and modes.body is not None
    one, other = (modes.rotation[:, modes.body.index(body)] for body in train.couplings[number].between or ())
    mode = int(np.argmax(modes.energy[:, place]))
    return float(modes.energy[mode, place] / (one - other)[mode] ** 2)
