"""The report of results: train, numbers of its drawing, response, jumps, dynamic factors, load sharing, what is not modelled."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from .._core.box import Box
from .._core.description import Description
from .._core.extras import extra
from ..errors import InputError, shown
from ..plots.planetary_picture import stages_of
from .at_peaks import sensitivities, sidebands
from .document import Document
from .kv import Pair, dynamic_factor

__all__ = ["document_of", "write_report"]

#: Numbers of meshes that are told, with their words.
_MESH = {"contact_ratio": "contact ratio", "overlap_ratio": "overlap ratio", "centre_distance": "centre distance",
         "tip_diameter": "tip diameters", "base_radius": "base radii", "line_load": "line load",
         "single_stiffness": "single stiffness c'",
         "mesh_stiffness": "mesh stiffness c_gamma_alpha", "stiffness": "stiffness", "half_backlash": "half backlash",
         "damping": "damping", "mean_force": "mean force", "order": "order"}
#: Pictures of the response beside the first, and their quantities.
_OTHERS = {"Torques of shafts": "shaft_torque", "Torques of couplings": "coupling_torque", "Forces of bearings": "bearing_force"}
_GIVEN = {"teeth": "teeth", "normal_module": "normal module", "helix_angle": "helix angle", "face_width": "face width",
          "profile_shift": "profile shifts"}

_RIGID = "Bearings and housing: the axes stand still, bodies turn only. Bending of shafts and tilting of gears are left out."
_ON_BEARINGS = ("Housing and gyroscopic moments: bodies on bearings move in their transverse plane, all other axes stand still. "
                "Bending of shafts and tilting of gears are left out.")
_LEFT_OUT = [
    "Friction between teeth, churning and windage, temperature.",
    "Corrections of flanks and the load over the face width, beyond the mesh stiffness and transmission error given.",
    "The inertia of shafts, where no body has it.",
    "Impacts shorter than a mesh cycle in the material of the teeth: contact is a spring with a damper.",
]


def write_report(results: Any, path: str | os.PathLike[str], text: str) -> None:
    """Write a report, PDF or HTML by the ending of its name; ``text`` is the printed report."""
    name = os.fspath(path)
    ending = os.path.splitext(name)[1].lower() if isinstance(name, str) else ""
    if ending not in (".pdf", ".html"):
        raise InputError(f"path = {shown(name)}: must end in .pdf or .html")
    extra("matplotlib.figure")
    made = document_of(results, text)
    data = made.pdf() if ending == ".pdf" else made.html().encode()
    with Box() as box:
        box.write_bytes(path, data)


def document_of(results: Any, text: str) -> Document:
    """The report as a document."""
    train = _train_of(results)
    made = Document((train.title if train is not None else "") or "Gear train")
    sections = _sections(text)
    made.printed(sections.pop("", "").removeprefix(made.title).strip("\n"))
    if "RESULT" in sections:
        made.heading("Result")
        made.printed(sections.pop("RESULT"))
    with extra("matplotlib").rc_context({"figure.max_open_warning": 0}):
        _pictures(made, results)
        if train is not None:
            _dynamic_factors(made, results.response, train)
            _load_sharing(made, results.response, train)
            sensitivities(made, results.response, train)
            sidebands(made, results, train)
        for name, lines in sections.items():
            made.heading(name.capitalize())
            made.printed(lines)
        if train is not None:
            _train(made, train)
    _left_out(made, train)
    return made


def _train_of(results: Any) -> Description | None:
    for part in (results.response, results.modes, results.run_up, *(results.integration or ())[:1]):
        train = getattr(part, "train", None)
        if train is not None:
            found: Description = train
            return found
    return None


def _sections(text: str) -> dict[str, str]:
    """The printed report by its headings, words of capitals."""
    found: dict[str, list[str]] = {"": []}
    for line in text.splitlines():
        if line.isupper() and line.replace(" ", "").isalpha():
            found[line.strip()] = []
        else:
            found[next(reversed(found))].append(line)
    return {name: "\n".join(lines) for name, lines in found.items()}


def _pictures(made: Document, results: Any) -> None:
    branch = results.response
    drawn: list[tuple[str, Any, dict[str, Any]]] = []
    if branch is not None:
        drawn.append(("Response", branch, {}))
        drawn += [(title, branch, {"quantity": quantity}) for title, quantity in _OTHERS.items()]
    elif results.integration:
        drawn.append(("Response by time integration", results.integration, {}))
    if results.run_up is not None:
        drawn.append(("Run-up", results.run_up, {}))
    for title, part, asked in drawn:
        if title in _OTHERS and not _is_there(part, f"{_OTHERS[title]}_maximum"):
            continue
        made.heading(title)
        made.picture(_figure(part.plot(**asked)), title)


def _is_there(branch: Any, name: str) -> bool:
    values = getattr(branch, name, None)
    return values is not None and np.size(values) > 0 and bool(np.isfinite(values).any())


def _figure(axes: Any) -> Any:
    figure = np.ravel(axes)[0].figure
    extra("matplotlib.pyplot").close(figure)
    return figure


def _dynamic_factors(made: Document, branch: Any, train: Description) -> None:
    """The largest dynamic factor of each mesh on the stable part of the response, beside K_v of ISO 6336-1 there."""
    if branch is None or not hasattr(branch, "dynamic_factor") or not len(branch.frequency):
        return
    numbers, rows, beside = train.explain(), [], False
    stable = np.ones(len(branch.frequency), dtype=bool) if branch.stable is None else np.asarray(branch.stable, dtype=bool)
    if not stable.any():
        stable[:] = True
    for place, name in enumerate(train.mesh_elements):
        factors = np.where(stable, branch.dynamic_factor[:, place], np.nan)
        if np.isnan(factors).all():
            continue
        point = int(np.nanargmax(factors))
        speed = None if branch.speed is None else float(branch.speed[point])
        at = f"{branch.frequency[point]:.6g}" if speed is None else f"{speed:.6g}"
        pair = _pair(train, numbers, place) if speed is not None and branch.parameter is None else None
        iso = dynamic_factor(pair, speed * _turns(train, numbers, place)) if pair and speed is not None else None
        beside = beside or iso is not None
        told = ["", ""] if iso is None else [f"{iso[0]:.3g}", f"{iso[1]:.3g}"]
        rows.append([name, train.mesh_labels[place], f"{factors[point]:.4g}", at, *told])
    head = ["mesh", "between", "largest", "at rpm" if branch.speed is not None else "at Lambda", "K_v", "N"]
    made.heading("Dynamic factors")
    made.table(head if beside else head[:4], [row if beside else row[:4] for row in _alike(rows)])
    made.sentence("Largest mesh force over the static one, on the stable part of the response.")
    if beside:
        made.sentence("K_v is that of ISO 6336-1:2006, method B, at the same speed, with the resonance ratio N of the pair alone: "
                      "K_A = 1, no tip relief, and the first harmonic of the transmission error as the effective deviation of "
                      "profile and base pitch, or the largest difference of neighbouring pitch errors of either gear where that is "
                      "larger. It knows neither shafts nor other meshes. Not for meshes on a carrier, internal pairs or "
                      "gears without drawing.")


def _turns(train: Description, numbers: Mapping[str, Any], place: int) -> float:
    """Turns of the driving gear per turn of the body whose speed is told."""
    ends = train.meshes[place].between
    return abs(float(numbers.get(ends[0], {}).get("turns", 0.0))) if ends else 0.0


def _pair(train: Description, numbers: Mapping[str, Any], place: int) -> Pair | None:
    """What K_v needs of a mesh; None where it is not of two drawn gears on axes that stand still."""
    if place >= len(train.meshes):
        return None
    mesh, told = train.meshes[place], numbers[f"mesh {place + 1}"]
    wanted = ("contact_ratio", "overlap_ratio", "single_stiffness", "mesh_stiffness", "line_load", "base_radius")
    if not mesh.between or mesh.carrier or mesh.internal or mesh.face_width is None or any(name not in told for name in wanted):
        return None
    inertias = [float(numbers.get(body, {}).get("inertia", 0.0)) for body in mesh.between]
    if min(inertias) <= 0 or not told["line_load"] > 0 or not _turns(train, numbers, place):
        return None
    first = [float(np.ravel(values)[0]) for values in (mesh.error_cos, mesh.error_sin) if values is not None and np.size(values)]
    profile = float(np.hypot.reduce(first)) if first else 0.0
    pitches = [np.diff(np.append(values, np.ravel(values)[0]))
               for values in (mesh.driving_pitch_error, mesh.driven_pitch_error) if values is not None and np.size(values)]
    teeth: Any = mesh.teeth
    return Pair(
        teeth=round(float(np.ravel(teeth)[0])), radii=tuple(told["base_radius"]), inertias=(inertias[0], inertias[1]),
        width=float(mesh.face_width), contact_ratio=float(told["contact_ratio"] + told["overlap_ratio"]),
        single=float(told["single_stiffness"]), mesh=float(told["mesh_stiffness"]), line_load=float(told["line_load"]),
        base_pitch=max([profile, *(float(np.abs(single).max()) for single in pitches)]), profile=profile)


def _load_sharing(made: Document, branch: Any, train: Description) -> None:
    share = None if branch is None else getattr(branch, "load_share", None)
    if share is None or not np.isfinite(share).any():
        return
    largest = getattr(branch, "load_share_maximum", None)
    rows = [[name, f"{np.nanmin(share[:, place]):.4g}", f"{np.nanmax(share[:, place]):.4g}",
             "" if largest is None else f"{np.nanmax(largest[:, place]):.4g}"] for place, name in enumerate(train.planet_labels)]
    made.heading("Load sharing of planets")
    made.table(["planet", "least mean share", "largest mean share", "largest share at an instant"], rows)
    made.sentence("Force of a planet over the sum of the mean forces of its set, over all points of the response.")


def _train(made: Document, train: Description) -> None:
    """The train and its planetary sets as pictures, and the numbers of its drawing."""
    made.heading("Train")
    draw = getattr(train, "plot", None)
    if draw is not None:
        made.picture(_figure(draw()), "the train")
        for name in stages_of(train):
            made.picture(_figure(train.plot_stage(name)), f"planetary set {name}")  # type: ignore[attr-defined]
    numbers = train.explain()
    held = {body.name for body in train.bodies if body.held}
    bodies = [[name, "held" if name in held else _told(numbers, name, "inertia"), _told(numbers, name, "turns")]
              for name in train.body_labels]
    if bodies:
        made.table(["body", "inertia [kg m^2]", f"turns per turn of {train.speed_of or train.body_labels[0]}"], bodies)
    shafts = [[name, train.shaft_labels[place], *(_told(numbers, name, item) for item in ("stiffness", "damping", "mean_torque"))]
              for place, name in enumerate(f"shaft {number}" for number in range(1, len(train.shafts) + 1)) if name in numbers]
    if shafts:
        made.table(["shaft", "between", "stiffness [N m/rad]", "damping [N m s/rad]", "mean torque [N m]"], shafts)
    names = [f"mesh {number}" for number in range(1, len(train.meshes) + 1)]
    for group in _groups(list(range(len(names))), lambda place: _mesh_rows(train, numbers, place)):
        made.table(["", ", ".join(names[place] for place in group)],
                   _mesh_rows(train, numbers, group[0]))
    for told in train.warnings:
        made.sentence(f"Warning: {told}")


def _mesh_rows(train: Description, numbers: Any, place: int) -> list[list[str]]:
    """The numbers of a mesh: what is given of the gears, then what follows."""
    mesh, name = train.meshes[place], f"mesh {place + 1}"
    units = {"normal_module": "m", "helix_angle": "degree", "face_width": "m"}
    rows = [[f"{word} [{units[item]}]" if item in units else word, _number(getattr(mesh, item))]
            for item, word in _GIVEN.items() if getattr(mesh, item) is not None]
    for item, word in _MESH.items():
        if item in numbers[name]:
            unit = numbers.unit[name].get(item, "1")
            rows.append([word if unit in ("1", "") else f"{word} [{unit}]", _number(numbers[name][item])])
    return rows


def _told(numbers: Any, name: str, item: str) -> str:
    return f"{numbers[name][item]:.6g}" if item in numbers.get(name, {}) else ""


def _groups(places: Sequence[int], key: Any) -> Iterator[list[int]]:
    """Neighbours with the same key."""
    for _, group in groupby(places, key=key):
        yield list(group)


def _alike(rows: list[list[str]]) -> list[list[str]]:
    """Rows of equal numbers as one: their names joined."""
    found = []
    for _, group in groupby(rows, key=lambda row: row[2:]):
        same = list(group)
        numbers = [row[0] for row in same]
        name = numbers[0] if len(same) == 1 else f"{numbers[0]} to {numbers[-1].rpartition(' ')[2]}"
        found.append([name, same[0][1] if len(same) == 1 else f"{same[0][1]}, ...", *same[0][2:]])
    return found


def _number(value: Any) -> str:
    values = np.ravel(value)
    return ", ".join(f"{item:.6g}" if isinstance(item, (float, np.floating)) else str(item) for item in values)


def _left_out(made: Document, train: Description | None) -> None:
    made.heading("What is not modelled")
    made.listed([_ON_BEARINGS if train is not None and train.bearings else _RIGID, *_LEFT_OUT])
    notes = getattr(train, "notes", ())
    if notes:
        made.heading("Notes on the file that the train was read from")
        made.listed(notes)
