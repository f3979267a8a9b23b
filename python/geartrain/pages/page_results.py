"""Results as what a page shows of them: curves with their points, tables, the train."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import described
from .._core.description import Description, contact_words, element_name, is_of_ring, load_signs, part_names
from .._core.units import both_units, hertz_of, in_own_unit, length_unit, speed_of, units_of
from ..errors import InputError
from ..plots.captions import caption, first_quantity, force_unit, force_words, is_drawn
from ..results.campbell import exciting_orders
from ..results.curve import Between, is_slope, position, value_at
from ..results.motion_table import as_columns
from ..results.orders import named_orders
from ..results.special_point import SpecialPoints
from ..results.stability_map import map_words
from ..variables import ANALYSES
from .page_drawings import schematic, stages
from .page_force import force_laws, largest_difference
from .page_loads import largest_loads, load_sharing
from .page_pack import Block

__all__ = ["ALONG", "quantities", "shown_results"]

#: What quantities have a column for, in words for several. Displacements of couplings and bearings stand among the meshes.
ALONG = {"mesh": "meshes", "shaft": "shafts", "coupling": "couplings", "bearing axis": "bearings", "held": "held bodies",
         "planet": "planets"}

Array = NDArray[np.float64]

#: Largest difference between forces as the page computes them and the program's, over the largest force, for them to be shown: of
#: branches; of motions that time integration found, whose coefficients leave out what lies above their highest harmonic.
_ALIKE, _ALIKE_SETTLED = 0.005, 0.02
#: Coefficients below this, over the largest amplitude of the mesh at the point, are not seen, and are kept as 0.
_SEEN = 1e-6
#: Fields of a point that are told as they are where a point is chosen.
_FACTS = ("error_estimate", "estimate_doubtful", "correction", "harmonics", "second_estimate", "lyapunov_exponent",
          "lyapunov_error", "share", "floating", "count_undecided")


def quantities(words: str = "mesh force", unit: str = "N") -> dict[str, dict[str, str]]:
    """What can be drawn over the speed: fields with a column for each mesh, shaft, ...; what they are called, their unit.

    Parameters
    ----------
    words, unit : str
        What the force of meshes is called; its unit.
    """
    about = described()["/response"].about
    found = {
        name: {"along": along, "unit": unit if name == "mesh_force_maximum" else own, "words": caption(name, words)}
        for name, (dimensions, own, _) in about.items()
        if (along := " ".join(dimensions[1:])) in ALONG and not is_slope(name)
    }
    return {**found, "peak_to_peak": {**found["maximum"], "words": caption("peak_to_peak")}}


def shown_results(results: Any, name: str, block: Block, every: int = 1) -> dict[str, Any]:
    """Results, or a branch alone, as a page shows them; their numbers go into the block.

    Parameters
    ----------
    results : Results or Branch
    name : str
        What the page calls them; the title of the train unless told.
    block : Block
    every : int
        Of every so many points the coefficients and multipliers are kept.
    """
    alone = hasattr(results, "special_points")
    response = results if alone else results.response
    branches = ([response] if response is not None else []) + list(results.branches)
    parts = {part: None if alone else getattr(results, part, None)
             for part in ("modes", "integration", "attractors", "stability_map", "run_up", "locus")}
    train = _train_of([*branches, *parts.values()])
    shown = [_of_branch(branch, place == 0 and response is not None, block, every) for place, branch in enumerate(branches)]
    over = branches[0].parameter_name if branches else ""
    notes = [] if alone or not results.ended else [results.ended]
    others = [name for name in ANALYSES if name not in (*parts, "response") and getattr(results, name, None) is not None]
    if others and not alone:
        notes.append(f"In the file, but not on this page: {', '.join(others)}")
    for kind in ("integration", "attractors"):
        if parts[kind] and over:
            notes.append(f"{kind} is over frequency, and not drawn over {over}")
        elif parts[kind]:
            shown.append(_of_motions(parts[kind], kind, block, every))
    settled = [motion for kind in ("integration", "attractors") for motion in parts[kind] or ()
               if (motion.period or motion.window) and not over]
    laws, forces = _laws(train, branches, settled)
    tables = [table for place, branch in enumerate(branches) for table in _tables(branch, place, shown[place]["name"])]
    if parts["modes"] is not None:
        tables.append(_table("Natural modes", {
            "mode": list(range(1, len(parts["modes"].natural_frequency) + 1)),
            **({"natural frequency, Lambda": parts["modes"].natural_frequency.tolist()}
               if units_of(train, None).unit == "Lambda" else {}),
            **({} if (hertz := hertz_of(train, 1.0)) is None else
               {"natural frequency [Hz]": (hertz * parts["modes"].natural_frequency).tolist()}),
            "damping, % of critical": (100 * parts["modes"].damping_ratio).tolist(),
        }))
    return {
        "name": name or train.title or "",
        "title": train.title or "",
        "notes": notes,
        "over": over,
        "overUnit": branches[0].parameter_unit if branches else "",
        "warnings": list(train.warnings),
        "perLambda": {"Lambda": 1.0, "rpm": speed_of(train, 1.0), "Hz": hertz_of(train, 1.0)},
        "unit": units_of(train, None).unit,
        "drawn": is_drawn(train),
        "first": {"mesh_force": "mesh_force_maximum"}.get(first := first_quantity(train), first),
        "speedOf": train.speed_name,
        "length": train._outline["characteristic_length"],
        "lengthUnit": length_unit(train).strip(" []"),
        "velocityUnit": both_units(train, "mm/s", "rad/s").strip("[]"),
        "forceUnit": force_unit(train),
        "forceWords": force_words(train),
        "parts": _parts(train),
        "elements": list(train.mesh_elements),
        "laws": laws,
        "forces": forces,
        "slowest": min((order.order for order in exciting_orders(train)), default=1),
        "orderNames": [[order, words] for order, words in named_orders(train).items()],
        "series": shown,
        "tables": tables,
        "schematic": schematic(train),
        "stages": stages(train),
        "explanation": str(train.explain()),
        "loci": [] if parts["locus"] is None else [_of_locus(parts["locus"], block)],
        "map": None if parts["stability_map"] is None else _of_map(parts["stability_map"], block),
        "runUp": None if parts["run_up"] is None else _of_run_up(parts["run_up"], block),
    }


def _parts(train: Description) -> dict[str, list[str]]:
    """Names of what quantities have a column for."""
    counts = {"mesh": len(train.mesh_labels), "shaft": len(train.shaft_labels), "coupling": len(train.couplings),
              "bearing axis": 2 * len(train.bearings), "held": sum(bool(body.held) for body in train.bodies or ()),
              "planet": len(train.planet_labels)}
    return {along: list(part_names(train, along, counts[along])) for along in ALONG}


def _train_of(parts: Iterable[Any]) -> Description:
    """The train of the first part that has one."""
    for part in parts:
        first = part[0] if isinstance(part, list) and part else part
        train = getattr(first, "train", None)
        if isinstance(train, Description):
            return train
    raise InputError("page: there is nothing in these results that a page could show")


def _of_branch(branch: Any, first: bool, block: Block, every: int) -> dict[str, Any]:
    origins = (("period doubling", "cascade"), ("branch point", "branch"))
    kind = next((kind for words, kind in origins if branch.origin.startswith(words)), "response" if first else "island")
    arrays = branch.arrays()
    arrays["true_ac_rms"] = branch.true_ac_rms
    names = [name for name in quantities() if (name == "peak_to_peak" or arrays.get(name) is not None)]
    between = Between(branch) if len(branch) else None
    curves = {} if between is None else {name: between.of(name, _quantity(arrays, name)) for name in names}

    def values(at: float, rms: Array) -> dict[str, Array]:
        """Of each quantity the values where the branch has this frequency (or parameter) and this rms."""
        if between is None or not np.isfinite(rms).all():
            return {}
        where = position(between, at, curves["rms"], rms)
        return {**{name: value_at(curve, where) for name, curve in curves.items()}, "rms": rms, "true_ac_rms": rms / np.sqrt(2)}

    known = branch.stable is not None
    ranges = [
        [mesh, what, float(low), float(high), words]
        for what, of, ranges_of in (("apart", "separation", branch.separation_ranges),
                                    ("back", "back collision", branch.back_collision_ranges))
        for mesh, words in contact_words(branch.train, range(branch.rms.shape[1]), of).items()
        for low, high in ranges_of(mesh + 1, known)
    ]
    return {
        **_points(arrays, block, every),
        "kind": kind,
        "name": "response" if first else branch.origin or "branch",
        "across": block.add(branch.parameter, "f8"),
        "ended": in_own_unit(branch.ended, branch.train),
        "complete": branch.complete,
        "period": block.add(np.full(len(branch), branch.subharmonic), "i4"),
        "orders": [int(order) for order in branch.orders],
        "jumps": [
            {"at": _free(jump), "kind": jump.kind, "direction": jump.direction, "before": values(_free(jump), jump.before),
             "after": values(_free(jump), jump.after)}
            for jump in branch.jumps
        ],
        "specials": [
            {"kind": special.kind, "at": _free(special), "point": special.point, "values": values(_free(special), special.rms)}
            for special in branch.special_points
        ],
        "ranges": ranges,
        "bands": branch.bands_without_stability if known else [],
        "ofStable": known,
    }


def _of_motions(motions: Any, kind: str, block: Block, every: int) -> dict[str, Any]:
    """A sweep by integration, or attractors."""
    columns = as_columns(motions)
    words = {"integration": "time integration", "attractors": "attractors"}[kind]
    harmonics = (np.shape(columns["coefficients"])[-1] - 1) // 2
    if columns["stable"] is not None:
        columns["stable"] = [2 if motion.stable is None else int(motion.stable) for motion in motions]  # 2: not known
    return {
        **_points(columns, block, every),
        "kind": kind,
        "name": words,
        "ended": in_own_unit(motions.ended, motions[0].train if motions else None),
        "complete": motions.complete,
        "period": block.add(columns["period"], "i4"),
        "window": block.add(columns["window"], "f8"),
        "kinds": list(columns["kind"]),
        "directions": list(getattr(motions, "direction", ())),
        "orders": list(range(1, harmonics + 1)),
        "jumps": [], "specials": [], "ranges": [], "bands": [], "ofStable": False,
    }


def _points(arrays: Mapping[str, Any], block: Block, every: int) -> dict[str, Any]:
    """Points of a branch or of a sweep."""
    multipliers = arrays.get("multipliers")
    if multipliers is not None:
        multipliers = np.stack([multipliers.real, multipliers.imag], axis=-1)[::every]
    return {
        "every": every,
        "count": len(arrays["frequency"]),
        "lambda": block.add(arrays["frequency"], "f8"),
        "stable": block.add(arrays.get("stable"), "u1"),
        "undecided": block.add(arrays.get("undecided"), "u1"),
        "segment": block.add(arrays.get("segment"), "i4"),
        "along": block.add(arrays.get("arclength"), "f8"),
        "acrossSlope": block.add(arrays.get("free_slope"), "f8"),
        "rmsSlope": block.add(arrays.get("rms_slope"), "f8"),
        "facts": {name: block.add(arrays[name]) for name in _FACTS if arrays.get(name) is not None},
        "values": {name: block.add(_quantity(arrays, name)) for name in quantities()
                   if name == "peak_to_peak" or arrays.get(name) is not None},
        "coefficients": block.add(_seen(arrays["coefficients"][::every]), drawn=True),
        "multipliers": block.add(multipliers, drawn=True),
    }


def _quantity(arrays: Mapping[str, Any], name: str) -> Array:
    """The values of a quantity."""
    values: Array = arrays["maximum"] - arrays["minimum"] if name == "peak_to_peak" else np.asarray(arrays[name])
    # x and y of the bearings side by side.
    return values.reshape(len(values), -1) if values.ndim > 2 else values


def _seen(coefficients: Array) -> Array:
    """Coefficients without those that no picture shows; a motion of hunting teeth has thousands of them."""
    cosine, sine = coefficients[..., 1::2], coefficients[..., 2::2]
    amplitude = np.hypot(cosine, sine)
    largest = np.nanmax(amplitude, axis=-1, keepdims=True, initial=0.0)
    kept = coefficients.copy()
    unseen = np.repeat(amplitude < _SEEN * largest, 2, axis=-1)
    kept[..., 1:][unseen] = 0.0
    return kept


def _laws(train: Description, branches: Sequence[Any], settled: Sequence[Any]) -> tuple[list[Any], str]:
    """The force laws; None, and why, of a mesh whose largest forces they do not give."""
    tried = [(_ALIKE, branch.frequency, np.full(len(branch), branch.subharmonic), branch.orders, branch.coefficients,
              branch.mesh_force_maximum) for branch in branches if len(branch)]
    if settled:
        columns = as_columns(settled)
        orders = np.arange(1, (columns["coefficients"].shape[-1] + 1) // 2)
        frequency, coefficients, largest = (columns[name] for name in ("frequency", "coefficients", "mesh_force_maximum"))
        period = columns["period"] if columns["window"] is None else np.maximum(columns["period"], columns["window"])
        tried.append((_ALIKE_SETTLED, frequency, period, orders, coefficients, largest))
    if not tried:
        return [], ""
    laws = force_laws(train, float(tried[0][1][0]))
    off = []
    for mesh, (law, sign) in enumerate(zip(laws, load_signs(train))):
        # Of a ring of springs the sum of their mean forces is known, and not which of them bear it.
        signs = (1, -1, 0) if is_of_ring(train, mesh) else (sign,)
        if all(any(largest_difference(law, mesh, one, *values) > most for most, *values in tried) for one in signs):
            off.append(mesh)
    words = ", ".join(train.mesh_elements[mesh] for mesh in off)
    told = f"The force of {words} over time is not shown: its law is not one that this page can compute." if off else ""
    return [None if mesh in off else law for mesh, law in enumerate(laws)], told


def _tables(branch: Any, place: int, name: str) -> list[dict[str, Any]]:
    """What is read off a branch, as tables; with the point of each row where there is one."""
    peaks, jumps = branch.peaks(), branch.jumps
    specials = SpecialPoints(branch.special_points, branch.train)
    ends = [peak for peak, _ in getattr(peaks, "ends", ())]
    found = [
        _table("Peaks", peaks._table(), [[place, peak.point] for peak in [*peaks, *ends]], branch.train),
        _table("Jumps", jumps._table(), [[place, _nearest(branch, jump)] for jump in jumps], branch.train),
        _table("Special points", specials._table(), [[place, special.point] for special in specials], branch.train),
    ]
    unit = f" [{branch.parameter_unit}]" if branch.parameter_unit not in ("", "1") else ""
    found[1:1] = [_table(*largest_loads(branch, place)), _table(*load_sharing(branch, place))]
    found.append(_table(*_bands(branch)))
    for table in found:
        table["branch"] = "" if place == 0 else name
        _name_rms(table, is_drawn(branch.train))
        table["headings"] = [branch.parameter_name + unit if heading == "parameter" else heading for heading in table["headings"]]
    return [table for table in found if table["rows"]]


def _name_rms(table: dict[str, Any], drawn: bool) -> None:
    """Say which rms a table has: that of the paper, or of a train with a drawing the true one, of which it is sqrt(2) times."""
    columns = [place for place, heading in enumerate(table["headings"]) if heading.startswith("rms")]
    factor = float(np.sqrt(0.5)) if drawn else 1.0
    for place in columns:
        rest = table["headings"][place].removeprefix("rms of the paper")
        table["headings"][place] = f"true rms{rest}" if drawn else f"rms of the paper{rest}"
    table["rows"] = [[None if cell is None else factor * cell if place in columns else cell for place, cell in enumerate(row)]
                     for row in table["rows"]]


def _bands(branch: Any) -> tuple[str, dict[str, list[Any]]]:
    """Where no motion of the branch is stable: the largest forces of stable motions tell nothing there."""
    bands = branch.bands_without_stability if branch.stable is not None else np.empty((0, 2))
    units = units_of(branch.train, None)
    name, factor = (units.unit, units.per_lambda) if branch.parameter is None else (branch.parameter_name, 1.0)
    return "Without a stable motion", {f"{name} from": list(factor * bands[:, 0]), "to": list(factor * bands[:, 1])}


def _free(place: Any) -> float:
    """Where a jump or a special point is: Lambda, or the value of the parameter that its branch goes over."""
    value: float = place.frequency if place.parameter is None else place.parameter
    return value


def _nearest(branch: Any, jump: Any) -> int:
    """The point of a branch nearest to where a jump begins."""
    across = branch.frequency if branch.parameter is None else branch.parameter
    apart = np.abs(across - _free(jump)) / (np.ptp(across) or 1.0) + np.abs(branch.rms - jump.before).max(axis=1) / branch.rms.max()
    return int(apart.argmin())


def _table(name: str, columns: Mapping[str, Sequence[Any]], points: Sequence[Sequence[int]] = (),
           train: Description | None = None) -> dict[str, Any]:
    """A table: headings and rows; a column of lists becomes one for each mesh of the train."""
    flat: dict[str, list[Any]] = {}
    before = ""
    for heading, values in columns.items():
        if all(value is None for value in values):
            continue
        widest = max((np.size(value) for value in values if isinstance(value, np.ndarray)), default=0)
        if not widest:
            flat[heading] = list(values)
        # In the printed table "rms [um] before" and "after" stand side by side; here they may be sorted by.
        words = before.replace("before", "after") if heading == "after" else heading
        before = heading
        for mesh in range(widest):
            flat[f"{words}, {element_name(train, mesh)}" if widest > 1 else words] = [value[mesh] for value in values]
    return {"name": name, "headings": list(flat), "rows": list(zip(*flat.values())), "points": list(points)}


def _of_map(chart: Any, block: Block) -> dict[str, Any]:
    """A stability map."""
    return {
        "parameter": chart.name, "unit": chart.unit, "ended": chart.ended, "linear": chart.linear,
        "words": map_words(chart),
        "lambda": block.add(chart.frequency, "f8"), "values": block.add(chart.parameter, "f8"),
        "motions": block.add(chart.motions, "i4"), "stable_motions": block.add(chart.stable_motions, "i4"),
        "spectral_radius": block.add(chart.spectral_radius),
        "multiplier": block.add(np.stack([chart.multiplier.real, chart.multiplier.imag], axis=-1)),
    }


def _of_locus(locus: Any, block: Block) -> dict[str, Any]:
    """The curve of a special point over frequency and a parameter."""
    return {
        "kind": locus.kind, "parameter": locus.parameter_name, "ended": locus.ended,
        "lambda": block.add(locus.frequency, "f8"), "values": block.add(locus.parameter, "f8"),
        "specials": [{"kind": point.kind, "at": point.frequency, "value": point.parameter} for point in locus.special_points],
    }


def _of_run_up(run_up: Any, block: Block) -> dict[str, Any]:
    """Extremes of a run-up over its windows."""
    frequency = np.interp(run_up.window_time, run_up.time, run_up.frequency)
    return {
        "ended": in_own_unit(run_up.ended, run_up.train), "lambda": block.add(frequency, "f8"),
        "time": block.add(run_up.window_time),
        "mesh": {"low": block.add(run_up.mesh_force_minimum), "high": block.add(run_up.mesh_force_maximum)},
        "shaft": {"low": block.add(run_up.shaft_torque_minimum), "high": block.add(run_up.shaft_torque_maximum)},
    }
