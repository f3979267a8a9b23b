"""`read_rexs`: a gearbox of a REXS file as a train, and as the text of a case."""

from __future__ import annotations

import difflib
import math
import os
import re
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import DrawingWarning, InputError, plain, shown
from ..train import Train
from .pitch_table import read_pitch_table
from .rexs_draft import Draft
from .rexs_file import RexsFile, read_file
from .rexs_gears import Entry
from .rexs_source import Source
from .rexs_train import draft_of

__all__ = ["case_of_rexs", "read_rexs"]

#: Types of components whose attributes are read; of others only their number is told.
_READ = ("shaft", "shaft_section", "cylindrical_gear", "ring_gear", "cylindrical_stage", "external_load", "coupling",
         "switchable_coupling", "additional_mass", "side_plate", "planet_carrier")
_RESULTS = 12
#: Most cycles of the fastest mesh in the period of a response (train/nearby_orders.f90); speeds of an integration instead.
_MOST_CYCLES, _POINTS = 10000, 11


def read_rexs(
    path: str | os.PathLike[str], *, load_case: int | None = None,
    pitch_errors: Mapping[str, str | os.PathLike[str]] | None = None,
) -> Train:
    """Read a gearbox from a REXS file, versions 1.0 to 2.0: ``.rexs`` (XML), ``.rexsj`` (JSON), ``.rexsz`` (zip).

    Shafts with sections, cylindrical and planetary stages, couplings, loads and materials are read. Bevel and worm stages are
    refused.

    Parameters
    ----------
    path : path-like
    load_case : int, optional
        Of the load spectrum, from 1 on. Unless told the loads beside it, or the load case of the longest time.
    pitch_errors : dict, optional
        Files with measured pitch errors of gears: ``{"mesh 1 driving": "pinion.txt"}``, or by the gear's own name, with its
        number as in ``"Pinion 1 [11]"`` where several gears have that name. A line has the cumulative error of a tooth on the
        reference circle, as ISO 1328-1 measures it, in the order in which the teeth engage; positive: towards the mate. The number
        of the tooth may stand before it. The heading of the column may have the unit, ``[um]`` (the default), ``[mm]``, ``[nm]`` or
        ``[m]``, and says of several columns which one counts: ``Fp``, cumulative, or else ``fp``, single pitch errors, which are
        summed. Text before and after the numbers is passed over.

    Returns
    -------
    Train
        Its ``notes`` list what was assumed, what is missing, and what is not used.

    Raises
    ------
    InputError
        With the line of each problem.
    OSError
        Where it cannot be read.

    Examples
    --------
    >>> train = gt.read_rexs("gearbox.rexs")  # doctest: +SKIP
    >>> [note for note in train.notes if note.startswith("missing")]  # doctest: +SKIP
    ['missing: inertia of the machine at Load [38], which REXS does not have; ...']
    """
    draft, source, _ = _drafted(path, load_case, pitch_errors)
    train = Train._of([group for group in draft.values() if group[0] not in ("modes", "response")])
    object.__setattr__(train, "notes", tuple(source.notes))
    return train


def case_of_rexs(
    path: str | os.PathLike[str], *, load_case: int | None = None,
    pitch_errors: Mapping[str, str | os.PathLike[str]] | None = None,
) -> str:
    """The case of a REXS file as text: every number with the component that it is of."""
    draft, source, file = _drafted(path, load_case, pitch_errors)
    if pitch_errors:
        _ask_in_time(draft, source)
    head = [f"From {Path(path).name}: REXS {file.version}, written by {file.application or 'an unknown program'}",
            "Numbers are in SI units, angles in degrees. Each has its unit and the component that it is of."]
    return draft.text([plain(line) for line in head], source.notes)


def _drafted(
    path: str | os.PathLike[str], load_case: int | None, pitch_errors: Mapping[str, str | os.PathLike[str]] | None,
) -> tuple[Draft, Source, RexsFile]:
    if isinstance(load_case, bool) or not isinstance(load_case, (int, type(None))):
        raise InputError(f"load_case = {load_case!r}: must be a whole number")
    file = read_file(path)
    source = Source(file, load_case)
    for component in file.components.values():
        if "data_source" in component.attributes or "referenced_component_id" in component.attributes:
            source.wrong(component, "refers to another file, which is not read: export the gearbox as one file")
    title = " ".join(Path(path).stem.split())
    draft = draft_of(source, plain(title)[:80])
    for gear, table in (pitch_errors or {}).items():
        _add_pitch_errors(draft, source, gear, table)
    _tell_unused(source)
    source.check()
    return draft, source, file


def _ask_in_time(draft: Draft, source: Source) -> None:
    """Ask for time integration where the errors of all gears together repeat themselves after too many cycles for a response."""
    unit = {"characteristic_frequency": 1.0}  # the frequency of a long period may be too far from all others
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DrawingWarning)
        train = Train._of([(group, {**values, **unit} if group == "train" else values) for group, values in draft.values()
                           if group not in ("modes", "response")])
    if max(train._outline["order"]) <= _MOST_CYCLES:
        return
    for place, (group, _, entries) in enumerate(draft.groups):
        if group == "train":
            entries["characteristic_frequency"] = Entry(1.0, "speeds are in rpm")
        elif group == "response":
            asked = {name: entries[name] for name in ("from", "to", "unit")}
            draft.groups[place] = "integration", "in time, as the errors repeat themselves too late for a response", {
                **asked, "points": Entry(_POINTS, "")}
            source.note("assumed", f"integration in time at {_POINTS} speeds in place of a response: with these errors the motion "
                                   f"repeats itself after more than {_MOST_CYCLES} mesh cycles")


def _add_pitch_errors(draft: Draft, source: Source, gear: str, path: str | os.PathLike[str]) -> None:
    """Measured pitch errors of a gear, from the reference circle to the line of action."""
    group, side = _find_gear(draft, gear, [str(one) for one in source.file.of_kind("cylindrical_gear", "ring_gear")])
    table, name = read_pitch_table(path), plain(Path(path).name)
    teeth = group["teeth"].value[side == "driven"]
    if len(table.errors) != teeth:
        raise InputError(f"{os.fspath(path)}:{table.last}: error: has {len(table.errors)} pitch errors, and the gear {shown(gear)} "
                         f"has {teeth} teeth")
    if f"{side}_pitch_error" in group:
        raise InputError(f"pitch errors of {shown(gear)}: are given twice")
    normal, helix = (math.radians(group[angle].value) for angle in ("pressure_angle", "helix_angle"))
    slope = math.cos(math.atan2(math.tan(normal), math.cos(helix)))
    group[f"{side}_pitch_error"] = Entry([float(f"{slope * error:.7g}") for error in table.errors],
                                         f"{name}, along the line of action")
    group.setdefault("pitch_error_form", Entry("steps", "with sidebands of the mesh; 'polynomial': smooth, without"))
    source.note("assumed", "cumulative pitch errors on the reference circle, in the order in which the teeth engage, positive: "
                           f"towards the mate; times {slope:.5f}, the cosine of the pressure angle, along the line of action", name)
    for told in table.assumed:
        source.note("assumed", told, name)


def _find_gear(draft: Draft, gear: str, labels: Sequence[str]) -> tuple[dict[str, Entry], str]:
    """The mesh of a gear, ``'mesh 1 driving'``, its label or its label without the number, and which of its gears it is."""
    meshes = [entries for kind, _, entries in draft.groups if kind == "mesh"]
    known = {f"mesh {number} {side}": (entries, side) for number, entries in enumerate(meshes, 1) for side in ("driving", "driven")}
    if gear in known:
        return known[gear]
    alike = [label for label in labels if re.sub(r" \[\d+\]$", "", label) == gear]
    if gear not in labels and len(alike) > 1:
        raise InputError(f"pitch errors of {shown(gear)}: {len(alike)} gears have this name: say {' or '.join(map(repr, alike))}")
    gear = alike[0] if gear not in labels and alike else gear
    # The teeth stand beside the names of both gears.
    named = [place for place, (entries, side) in known.items() if isinstance(gear, str) and
             (entries["teeth"].told.startswith(f"{gear}, ") if side == "driving" else entries["teeth"].told.endswith(f", {gear}"))]
    if len(named) == 1:
        return known[named[0]]
    if named:
        raise InputError(f"pitch errors of {shown(gear)}: it is in several meshes, with a flank for each: say {' or '.join(named)}")
    listed = [f"mesh {number} driving or driven ({entries['teeth'].told})" for number, entries in enumerate(meshes, 1)]
    words = [*known, *(word for entries in meshes for word in entries["teeth"].told.split(", "))]
    near = [word for word in words if word.startswith(f"{gear} ")] or difflib.get_close_matches(str(gear), words, 1)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    raise InputError(f"pitch errors of {shown(gear)}: there is no such gear{hint}; gears of planetary sets take none. There is: "
                     f"{'; '.join(listed) or 'no mesh outside planetary sets'}")


def _tell_unused(source: Source) -> None:
    """What of the file has no part in the case: types of components, then attributes of those that are read."""
    kinds = Counter(component.kind for component in source.file.components.values())
    asked = {kind for kind, _ in source.used}
    for kind, count in sorted(kinds.items()):
        if kind not in asked and kind not in ("gear_casing", "planetary_stage", "planet_carrier", "gear_unit"):
            source.note("not used", f"{count} {kind}")
    for kind in _READ:
        names: dict[str, Any] = {}
        for component in source.file.of_kind(kind):
            names.update(dict.fromkeys(component.attributes))
        left = sorted(name for name in names if (kind, name) not in source.used)
        if left:
            more = f" and {len(left) - _RESULTS} more" if len(left) > _RESULTS else ""
            source.note("not used", f"{kind}: {', '.join(left[:_RESULTS])}{more}")
