"""`read_rexs`: a gearbox of a REXS file as a train, and as the text of a case."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path
from typing import Any

from ..errors import InputError, plain
from ..train import Train
from .rexs_draft import Draft
from .rexs_file import RexsFile, read_file
from .rexs_source import Source
from .rexs_train import draft_of

__all__ = ["case_of_rexs", "read_rexs"]

#: Types of components whose attributes are read; of others only their number is told.
_READ = ("shaft", "shaft_section", "cylindrical_gear", "ring_gear", "cylindrical_stage", "external_load", "coupling",
         "switchable_coupling", "additional_mass", "side_plate")
_RESULTS = 12


def read_rexs(path: str | os.PathLike[str], *, load_case: int | None = None) -> Train:
    """Read a gearbox from a REXS file, versions 1.0 to 2.0: ``.rexs`` (XML), ``.rexsj`` (JSON), ``.rexsz`` (zip).

    Shafts with sections, cylindrical and planetary stages, couplings, loads and materials are read. Bevel and worm stages are
    refused.

    Parameters
    ----------
    path : path-like
    load_case : int, optional
        Of the load spectrum, from 1 on. Unless told the loads beside it, or the load case of the longest time.

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
    draft, source, _ = _drafted(path, load_case)
    train = Train._of([group for group in draft.values() if group[0] not in ("modes", "response")])
    object.__setattr__(train, "notes", tuple(source.notes))
    return train


def case_of_rexs(path: str | os.PathLike[str], *, load_case: int | None = None) -> str:
    """The case of a REXS file as text: every number with the component that it is of."""
    draft, source, file = _drafted(path, load_case)
    head = [f"From {Path(path).name}: REXS {file.version}, written by {file.application or 'an unknown program'}",
            "Numbers are in SI units, angles in degrees. Each has its unit and the component that it is of."]
    return draft.text([plain(line) for line in head], source.notes)


def _drafted(path: str | os.PathLike[str], load_case: int | None) -> tuple[Draft, Source, RexsFile]:
    if isinstance(load_case, bool) or not isinstance(load_case, (int, type(None))):
        raise InputError(f"load_case = {load_case!r}: must be a whole number")
    file = read_file(path)
    source = Source(file, load_case)
    for component in file.components.values():
        if "data_source" in component.attributes or "referenced_component_id" in component.attributes:
            source.wrong(component, "refers to another file, which is not read: export the gearbox as one file")
    title = " ".join(Path(path).stem.split())
    draft = draft_of(source, plain(title)[:80])
    _tell_unused(source, draft)
    return draft, source, file


def _tell_unused(source: Source, draft: Draft) -> None:
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
