"""The pictures of docs/case-studies.md, into a folder: ``python example/case_studies.py FOLDER``, in two minutes.

Run from the root of the project, where ``namelists/`` holds the drawings.
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import geartrain as gt

__all__ = ["at_propeller_speed", "draw_rattle", "draw_reducer", "main", "rattle_threshold", "rigid_mesh_amplitudes",
           "rigid_threshold", "with_body", "with_engine_torque", "with_meshes"]

CASES = Path(__file__).parent.parent / "namelists"


def with_body(train: gt.Train, name: str, **changes: Any) -> gt.Train:
    """Give the train with other values of a body."""
    return replace(train, bodies=[replace(body, **changes) if body.name == name else body for body in train.bodies])


def with_meshes(train: gt.Train, **changes: Any) -> gt.Train:
    """Give the train with other values of all meshes."""
    return replace(train, meshes=[replace(mesh, **changes) for mesh in train.meshes])


def with_engine_torque(train: gt.Train, amplitude: float) -> gt.Train:
    """Give the train with another amplitude of order 2 of the engine [N m]."""
    return with_body(train, "engine", revolution_torque_cos=(0.0, amplitude))


def rattle_threshold(train: gt.Train, mesh: int, speed: float, low: float = 1.0, high: float = 100.0) -> float:
    """Find the torque amplitude [N m] from which on a mesh (from 1) separates, by bisection to 0.1 N m."""
    while high - low > 0.1:
        middle = (low + high) / 2
        motion = with_engine_torque(train, middle).integrate(speed, unit="rpm")
        if motion.separation_fraction[mesh - 1] > 0:
            high = middle
        else:
            low = middle
    return (low + high) / 2


def rigid_threshold(train: gt.Train, speed: float) -> dict[str, float]:
    """Compute for each loose wheel the amplitude [N m] at which its inertia torque is its drag, all teeth rigid and in contact."""
    told = train.explain()
    inertia = {body.name: float(told[body.name]["inertia"]) for body in train.bodies}
    turns = {body.name: abs(float(told[body.name]["turns"])) for body in train.bodies}
    loose = {body.name: -body.torque for body in train.bodies if body.name.startswith("loose")}
    # Engine, gearbox, car; all angles are those of the input.
    gearbox = sum(inertia[name] * turns[name] ** 2 for name in ("input", "output", *loose))
    mass = np.diag([inertia["engine"], gearbox, inertia["car"] * turns["car"] ** 2])
    omega = 2 * 2 * np.pi * speed / 60
    matrix = -(omega**2) * mass.astype(complex)
    for place, shaft in enumerate(train.shafts):
        ends = [inertia[name] for name in shaft.between]
        damping = 2 * shaft.damping_ratio * np.sqrt(shaft.stiffness * ends[0] * ends[1] / sum(ends))
        dynamic = (shaft.stiffness + 1j * omega * damping) * turns[shaft.between[0]] ** 2
        matrix[place:place + 2, place:place + 2] += dynamic * np.array([[1, -1], [-1, 1]])
    acceleration = omega**2 * abs(np.linalg.solve(matrix, [1, 0, 0])[1])
    return {name: drag / (inertia[name] * turns[name] * acceleration) for name, drag in loose.items()}


def at_propeller_speed(train: gt.Train, speed: float, share: float = 0.5) -> gt.Train:
    """Give the ship's drive at a speed of the propeller [rpm], whose torque goes with its square; share of the HP turbine."""
    torque = 22.24e6 * 0.11298 * (speed / 85) ** 2
    train = with_body(train, "propeller", torque_cos=(0.1 * torque,))
    train = with_body(train, "LP turbine", torque=(1 - share) * torque / 40.0424)
    return with_body(train, "HP turbine", torque=share * torque / 78.2365)


def rigid_mesh_amplitudes(train: gt.Train, hertz: float) -> tuple[Any, Any]:
    """Compute amplitudes of shaft torques [N m] and mesh forces [N] under the first torque_cos, all teeth rigid and in contact."""
    omega = 2 * np.pi * hertz
    place = {body.name: row for row, body in enumerate(train.bodies)}
    size, meshes = len(place), len(train.meshes)
    system = np.zeros((size + meshes, size + meshes), dtype=complex)
    torque = np.zeros(size + meshes)
    for row, body in enumerate(train.bodies):
        system[row, row] = -(omega**2) * body.inertia + 1j * omega * body.damping_to_ground
        torque[row] = (body.torque_cos or [0.0])[0]
    for shaft in train.shafts:
        ends = [place[name] for name in shaft.between]
        mass = 1 / sum(1 / train.bodies[end].inertia for end in ends)
        damping = 2 * shaft.damping_ratio * np.sqrt(shaft.stiffness * mass)
        system[np.ix_(ends, ends)] += (shaft.stiffness + 1j * omega * damping) * np.array([[1, -1], [-1, 1]])
    # The forces of the meshes are the multipliers of r_a theta_a = r_b theta_b.
    for row, mesh in enumerate(train.meshes, size):
        for name, radius in zip(mesh.between, (mesh.driving_radius, -mesh.driven_radius)):
            system[row, place[name]] = system[place[name], row] = radius
    solution = np.linalg.solve(system, torque)
    twist = [solution[place[a]] - solution[place[b]] for a, b in (shaft.between for shaft in train.shafts)]
    return abs(np.array([shaft.stiffness for shaft in train.shafts]) * twist), abs(solution[size:])


def draw_reducer(folder: Path) -> None:
    """Response and run-up of the two-stage reducer."""
    case = gt.read_case(CASES / "reducer.nml")
    response = case.train.response(start=200, stop=4000, unit="rpm", harmonics=0, tolerance=1e-3)
    print(response.peaks(1), response.peaks(2), response.jumps, response.ended, sep="\n")
    layout = {"figsize": (8, 9), "sharex": True, "constrained_layout": True, "height_ratios": (2, 1, 1, 1)}
    figure, axes = plt.subplots(4, 1, **layout)
    response.plot(ax=axes[0], jumps=True)
    axes[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    for shaft, (ax, label) in enumerate(zip(axes[1:], case.train.shaft_labels), 1):
        response.plot(ax=ax, quantity="shaft_torque", shaft=shaft, color=f"C{shaft - 1}")
        ax.set_title(label, loc="left", fontsize="medium")
        ax.set_ylabel("torque  [N m]")
    for ax in axes[:-1]:
        ax.set_xlabel("")
    figure.savefig(folder / "reducer_response.png", dpi=80)
    run_up = case.train.run_up(**case.run_up)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), constrained_layout=True)
    run_up.plot("mesh_force", ax=left)
    run_up.waterfall("mesh_force", 1, ax=right, highest=5000)
    figure.savefig(folder / "reducer_run_up.png", dpi=80)


def draw_rattle(folder: Path) -> None:
    """Extremes of the forces on the loose wheels over the engine's torque."""
    case = gt.read_case(CASES / "rattle.nml")
    speed = case.integration["start"]
    amplitude = np.arange(1.0, 125.0, 3.0)
    force = [with_engine_torque(case.train, value).integrate(speed, unit="rpm").mesh_force for value in amplitude]
    rigid = rigid_threshold(case.train, speed)
    figure, ax = plt.subplots(figsize=(7, 4), constrained_layout=True)
    for mesh, (name, color) in enumerate(zip(rigid, ("C0", "C1")), 1):
        look = {"color": color, "marker": "os"[mesh - 1], "markevery": 4, "markersize": 4.5}
        ax.plot(amplitude, [each[:, mesh].max() for each in force], **look, label=" - ".join(case.train.meshes[mesh].between))
        ax.plot(amplitude, [each[:, mesh].min() for each in force], **look)
        ax.axvline(rigid[name], color=color, ls=":")
        print(name, rigid[name], rattle_threshold(case.train, mesh + 1, speed))
    ax.plot([], [], color="black", ls=":", label="drag = inertia x acceleration")
    ax.set_xlabel("amplitude of order 2 of the engine  [N m]")
    ax.set_ylabel("largest and smallest mesh force  [N]")
    ax.legend()
    figure.savefig(folder / "rattle.png", dpi=80)


def main() -> None:
    """Draw all pictures."""
    folder = Path(sys.argv[1])
    plt.rcParams.update(gt.plot_style())
    warnings.simplefilter("ignore", gt.DrawingWarning)
    draw_rattle(folder)
    draw_reducer(folder)


if __name__ == "__main__":
    main()
