"""Calls into Fortran: a box holds a case and fields in, fields out, and is freed before the call returns."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

import geartrain._geartrain as fortran

from ._motion_check import VALUES, check_motion
from ._namelist import in_words_of_the_call
from .errors import InputError, SolverError

__all__ = ["ATTRACTORS", "INTEGRATION", "LOOSE", "Box", "Group", "as_columns", "file_name", "fortran"]

Array = NDArray[Any]

LOOSE, INTEGRATION, ATTRACTORS = "/motions", "/integration", "/attractors"  # which motions of a box

_INPUT, _ENDED_EARLY, _FILE = 2, 3, 4


@dataclass
class Group:
    """Fields by name, as a group of the results file has them.

    Attributes
    ----------
    attributes : dict
    arrays : dict of ndarray
        Those along dimensions, axes included.
    about : dict of tuple
        Of each array its dimensions, its unit and what it is.
    """

    attributes: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, Array] = field(default_factory=dict)
    about: dict[str, tuple[tuple[str, ...], str, str]] = field(default_factory=dict)

    def column(self, name: str, *shape: int) -> Array:
        """An array of a list; none of an empty one."""
        return self.arrays.get(name, np.zeros((0, *shape)))

    def rows(self, *names: str) -> list[tuple[Any, ...]]:
        """The items of a list, of each the fields of these names; False for one that is not there."""
        columns = [self.arrays.get(name) for name in names]
        number = max((len(column) for column in columns if column is not None), default=0)
        return [tuple(False if column is None else column[place] for column in columns) for place in range(number)]


class Box:
    """One call's data on the Fortran side; use it in a ``with`` statement.

    Parameters
    ----------
    text : str, optional
        Namelist text of the case, made from the keywords of a call: errors are then in its words.
    copy : Box, optional
        One whose case and response it begins with.
    """

    def __init__(self, text: str | None = None, copy: Box | None = None) -> None:
        self._handle: int = fortran.open_box() if copy is None else fortran.open_copy(copy.handle)
        self._of_call = text is not None or copy is not None
        self._put = ""
        self._results: dict[str, Group] | None = None
        if text is None:
            return
        try:
            self.check(fortran.read_text(self._handle, text.encode()))
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Box:  # noqa: PYI034 typing.Self is younger than Python 3.10  # noqa: PYI034 (typing.Self needs Python 3.11)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if fortran is not None:  # as at the end of the interpreter
            self.close()

    def close(self) -> None:
        """Free what it holds; it is of no use then."""
        handle, self._handle = getattr(self, "_handle", 0), 0
        if handle:
            fortran.close_box(handle)

    @property
    def handle(self) -> int:
        """What Fortran knows the box by; what was put into it has been taken over."""
        self.take()
        return self._handle

    def take(self) -> None:
        """Let Fortran take over what was put into the box."""
        if self._put:
            what, self._put = self._put, ""
            self.check(fortran.take_fields(self._handle, what))

    def check(self, status: int, whole: bool = True) -> None:
        """Raise the error that the status stands for; work that ended early passes unless the whole is needed."""
        if status == 0 or (status == _ENDED_EARLY and not whole):
            return
        kinds = {_INPUT: InputError, _ENDED_EARLY: SolverError, _FILE: OSError}
        message = self.text("message")
        raise kinds.get(status, RuntimeError)(in_words_of_the_call(message) if self._of_call else message)

    def text(self, name: str) -> str:
        """A text of the box, see ``text_size`` in border/fields.f90."""
        size = fortran.text_size(self.handle, name)
        return fortran.copy_text(self.handle, name, size).tobytes().decode(errors="replace") if size else ""

    # ------------------------------------------------------------------------------------------------- out

    def show(self, what: str = "results") -> dict[str, Group]:
        """What the box holds as fields, by the paths of their groups; see ``show_fields`` in border/fields.f90."""
        fortran.show_fields(self.handle, what)
        groups: dict[str, Group] = {}
        for line, row in enumerate(self.text("fields").split("\n")[:-1], 1):
            path, name, kind, size, extents, dimensions, unit, description = row.split("\t")
            group = groups.setdefault(path, Group())
            names = tuple(dimensions.split())
            values = self._values(line, kind, int(size), tuple(map(int, extents.split()))[::-1])
            if not names:
                group.attributes[name] = values.item()
                continue
            if names[-1] == "complex" and name != "complex":
                pairs, names = np.ascontiguousarray(values), names[:-1]
                values = pairs.view(np.complex128)[..., 0] if pairs.size else np.zeros(pairs.shape[:-1], complex)
            group.arrays[name] = values
            group.about[name] = names, unit, description
        return groups

    def _values(self, line: int, kind: str, size: int, shape: tuple[int, ...]) -> Array:
        items = int(np.prod(shape))
        if kind == "t":
            text = fortran.copy_texts(self.handle, line, size).tobytes().decode(errors="replace") if size else ""
            return np.array(text.split("\0")[:items], object).reshape(shape)
        if kind == "r":
            return (fortran.copy_reals(self.handle, line, items) if items else np.zeros(0)).reshape(shape)
        whole = (fortran.copy_integers(self.handle, line, items) if items else np.zeros(0, np.intc)).reshape(shape)
        return whole == 1 if kind == "l" else whole

    def results(self) -> dict[str, Group]:
        """The groups of the results; they are shown once, after the work is done."""
        if self._results is None:
            self._results = self.show()
        return self._results

    def modes(self) -> dict[str, Any] | None:
        group = self.results().get("/modes")
        if group is None or not len(group.arrays["mode"]):
            return None
        names = ("natural_frequency", "damped_frequency", "damping_ratio", "shape")
        return {"element": tuple(group.arrays["element"]), **{name: group.arrays[name] for name in names}}

    def has(self, path: str) -> bool:
        """Whether motions of this kind were computed, be it none in the end."""
        return path in self.results()

    def motions(self, path: str = LOOSE) -> list[dict[str, Any]]:
        """The motions of a group, each as keywords of `Motion`."""
        group = (self.show("motions") if path == LOOSE else self.results()).get(path, Group())
        return [_motion(group, place) for place in range(len(group.arrays.get("frequency", ())))]

    def sweep(self) -> dict[str, Any]:
        group = self.results()[INTEGRATION]
        return {
            "direction": tuple(group.arrays.get("direction", ())),
            **{name: group.attributes[name] for name in ("ended", "complete")},
        }

    def attractors(self) -> dict[str, Any]:
        return self.results()[ATTRACTORS].attributes

    def branch(self, place: int = 0) -> dict[str, Any] | None:
        """The response (place 0) or a further branch as fields by name; None where it has no point."""
        path = f"/branch_{place}" if place else "/response"
        group = self.results().get(path, Group())
        if "frequency" not in group.arrays or not (place or len(group.arrays["frequency"])):
            return None
        specials = self.results().get(f"{path}/special_points")
        attributes = {name: value for name, value in group.attributes.items() if name not in ("coordinates", "harmonics")}
        return {
            **{name: values for name, values in group.arrays.items() if name not in _DERIVED},
            **attributes,
            "special_points": [] if specials is None else specials.rows("kind", "frequency", "after_point", "undecided", "rms"),
        }

    def ended(self) -> str:
        """Why the response ended."""
        return str(self.results().get("/response", Group()).attributes.get("ended", ""))

    def stability_map(self) -> dict[str, Any] | None:
        group = self.results().get("/stability_map")
        if group is None or "parameter" not in group.arrays:
            return None
        names = ("frequency", "parameter", "motions", "stable_motions", "multiplier", "rms", "row_done", "row_whole")
        attributes = group.attributes
        return {
            **{name: group.arrays.get(name) for name in names},
            **{name: attributes[name] for name in ("linear", "ended", "complete")},
            "name": attributes["parameter_name"],
            "unit": attributes["parameter_unit"],
        }

    def audit(self) -> dict[str, Any]:
        group = self.show("audit")["/audit"]
        texts = {name: tuple(values) for name, values in group.arrays.items() if values.dtype.kind == "O"}
        point = group.arrays["point"] - 1
        arrays = {name: values for name, values in group.arrays.items() if name != "row"}
        return {**arrays, **texts, "point": point, **group.attributes, "table": self.text("audit")}

    def read_off(self, what: str) -> Group:
        """A list read off the box's branch, see ``show_fields``."""
        return next(iter(self.show(what).values()), Group())

    # -------------------------------------------------------------------------------------------------- in

    def put(self, path: str, attributes: Mapping[str, Any], arrays: Mapping[str, Any], what: str = "results", **axes: int) -> None:
        """Put a group, whose fields Fortran takes by their names; what is None is not there."""
        if self._put != what:
            self.take()
        self._put = what
        self._results = None
        for name, length in axes.items():
            self._put_field(path, name, np.arange(1, length + 1, dtype=np.intc))
        for fields in (attributes, arrays):
            for name, value in fields.items():
                if value is not None:
                    self._put_field(path, name, np.asarray(value))

    def _put_field(self, path: str, name: str, values: Array) -> None:
        if values.dtype.kind == "c":
            values = np.ascontiguousarray(values, complex)[..., np.newaxis].view(np.float64)
        rank, extents = values.ndim, [*values.shape[::-1], 0, 0, 0, 0][:4]
        flat = values.ravel() if values.size else np.zeros(1, values.dtype)  # f2py passes no empty array
        place = (self._handle, path.encode(), name.encode(), rank, extents)
        if values.dtype.kind in "UO":
            text = "".join(f"{item}\0" for item in values.ravel()) or "\0"
            fortran.put_texts(*place, np.frombuffer(text.encode(), np.int8))
        elif values.dtype.kind in "biu":
            fortran.put_integers(*place, int(values.dtype.kind == "b"), flat.astype(np.intc))
        else:
            fortran.put_reals(*place, flat.astype(float))

    def sizes(self) -> tuple[int, int]:
        """Meshes of the case's train, and the size of its states."""
        meshes, states = map(int, fortran.train_sizes(self._handle))
        return meshes, states

    def put_modes(self, modes: Any) -> None:
        names = ("element", "natural_frequency", "damped_frequency", "damping_ratio", "shape")
        arrays = {name: getattr(modes, name) for name in names}
        self.put("/modes", {}, arrays, mode=len(modes.natural_frequency))

    def put_motions(self, *motions: Any, what: str = "motion", only_state: bool = False) -> None:
        """Put motions of the case's train; ``what`` is what messages call them, ``only_state`` as in `check_motion`."""
        self._put_list(LOOSE, "motion", what, motions, {}, {}, only_state)

    def put_sweep(self, sweep: Any) -> None:
        if len(sweep.direction) != len(sweep) or not {*sweep.direction} <= {"up", "down"}:
            raise InputError(f"integration: direction: must be 'up' or 'down' of each of the {len(sweep)} motions")
        attributes = {"ended": sweep.ended, "complete": sweep.complete}
        self._put_list(INTEGRATION, "point", "integration", sweep, attributes, {"direction": list(sweep.direction)})

    def put_attractors(self, found: Any) -> None:
        names = ("ended", "complete", "frequency", "starts", "random_seed", "unsettled")
        self._put_list(ATTRACTORS, "motion", "attractors", found, {name: getattr(found, name) for name in names}, {})

    def _put_list(
        self, path: str, along: str, what: str, motions: Iterable[Any], attributes: Mapping[str, Any],
        arrays: Mapping[str, Any], only_state: bool = False,
    ) -> None:
        """Put motions as one table."""
        motions = list(motions)
        for motion in motions:
            check_motion(motion, what, *self.sizes(), only_state=only_state)
        if len({len(motion.multipliers) for motion in motions if motion.multipliers is not None}) > 1:
            raise InputError(f"{what}: multipliers: must be as many of one motion as of another")
        columns = as_columns(motions)
        del columns["true_ac_rms"]
        if only_state:
            columns.update({name: np.full((len(motions), self.sizes()[0]), np.nan) for name in VALUES})
        axes = {along: len(motions), "mesh": self.sizes()[0]}
        if columns["initial_state"] is not None:
            axes["coordinate"] = columns["initial_state"].shape[1]
        if columns["multipliers"] is not None:
            axes["state"] = columns["multipliers"].shape[1]
        self.put(path, attributes, {**columns, **arrays} if motions else {}, "motions" if path == LOOSE else "results", **axes)

    def put_stability_map(self, chart: Any) -> None:
        names = ("frequency", "parameter", "motions", "stable_motions", "multiplier", "rms", "row_done", "row_whole")
        attributes = {
            "parameter_name": chart.name, "parameter_unit": chart.unit, "linear": chart.linear,
            "ended": chart.ended, "complete": chart.complete,
        }
        axes = {} if chart.rms is None else {"mesh": chart.rms.shape[-1]}
        self.put("/stability_map", attributes, {name: getattr(chart, name) for name in names}, **axes)

    def put_branches(self, branches: list[Any]) -> None:
        """Put further branches."""
        for place, branch in enumerate(branches, 1):
            self.put_branch(branch, place)

    def put_branch(self, branch: Any, place: int = 0) -> None:
        """Put the response (place 0) or a further branch."""
        path = f"/branch_{place}" if place else "/response"
        attributes = {
            "ended": branch.ended, "origin": branch.origin or None, "complete": branch.complete, "closed": branch.closed,
            "subharmonic": branch.subharmonic, "harmonics": (branch.coefficients.shape[-1] - 1) // 2,
        }
        arrays = branch.arrays()
        axes = {"point": len(branch), "mesh": branch.rms.shape[-1]}
        if branch.multipliers is not None:
            axes["state"] = branch.multipliers.shape[-1]
        self.put(path, attributes, arrays, **axes)
        specials = branch.special_points
        if specials:
            columns = {
                "kind": [special.kind for special in specials],
                "frequency": [float(special.frequency) for special in specials],
                "after_point": [special.point + 1 for special in specials],
                "rms": np.stack([special.rms for special in specials]),
            }
            self.put(f"{path}/special_points", {}, columns, special_point=len(specials))


#: Numbers of a motion, one each.
_NUMBERS = ("error_estimate", "share", "lyapunov_exponent", "lyapunov_error")
#: Fields of a branch that follow from others, and axes.
_DERIVED = {"point", "mesh", "state", "coefficient", "complex", "true_ac_rms"}


def file_name(path: str | os.PathLike[str]) -> bytes:
    """The path as Fortran wants it."""
    return os.fsencode(path)


def _motion(group: Group, place: int) -> dict[str, Any]:
    """One motion of a group, as keywords of `Motion`; what is NaN throughout it does not have."""
    meshes = len(group.arrays["mesh"])
    row = {name: values[place] for name, values in group.arrays.items() if len(group.about[name][0]) and name in _OF_MOTION}
    nothing = np.full(meshes, np.nan)
    coefficients = row.get("coefficients", nothing[:, np.newaxis])
    there = ~np.isnan(coefficients).all(axis=0)
    multipliers, state = (None if row.get(name) is None or np.isnan(row[name]).all() else row[name]
                          for name in ("multipliers", "initial_state"))
    return {
        **{name: row.get(name, nothing) for name in VALUES},
        **{name: float(row.get(name, np.nan)) for name in ("frequency", *_NUMBERS)},
        "lyapunov_error": float(np.nan_to_num(row.get("lyapunov_error", 0.0))),
        "period": int(row["period"]),
        "kind": row["kind"],
        "coefficients": coefficients[:, there] if there.any() else nothing[:, np.newaxis],
        "stable": None if multipliers is None else bool(row["stable"]),
        "undecided": bool(row.get("undecided", False)),
        "floating": bool(row.get("floating", False)),
        "multipliers": multipliers,
        "state": state,
    }


_OF_MOTION = {
    *VALUES, *_NUMBERS,
    *("frequency", "period", "kind", "coefficients", "stable", "undecided", "floating", "multipliers", "initial_state"),
}


def as_columns(motions: Sequence[Any]) -> dict[str, Any]:
    """Motions as fields by their names in a results file; None for what none of them has."""
    multipliers = _padded([motion.multipliers for motion in motions])
    numbers = {name: np.array([float(getattr(motion, name)) for motion in motions]) for name in _NUMBERS}
    if np.isnan(numbers["lyapunov_exponent"]).all():
        numbers["lyapunov_error"] = numbers["lyapunov_exponent"]
    known = multipliers is not None
    return {
        "frequency": np.array([float(motion.frequency) for motion in motions]),
        "period": np.array([motion.period for motion in motions], np.intc),
        "kind": np.array([motion.kind for motion in motions], object),
        **{name: np.array([getattr(motion, name) for motion in motions], float) for name in VALUES},
        "true_ac_rms": np.array([motion.rms for motion in motions], float) / np.sqrt(2),
        "coefficients": _padded([motion.coefficients for motion in motions]),
        **{name: None if np.isnan(values).all() else values for name, values in numbers.items()},
        "floating": np.array([bool(motion.floating) for motion in motions]) if any(m.floating for m in motions) else None,
        "initial_state": _padded([motion.state for motion in motions]),
        "multipliers": multipliers,
        "stable": np.array([bool(motion.stable) for motion in motions]) if known else None,
        "undecided": np.array([bool(motion.undecided) for motion in motions]) if known else None,
    }


def _padded(rows: list[Any]) -> Array | None:
    """Arrays of one shape but for the last dimension, filled up with NaN; None where there is none."""
    known = [row for row in rows if row is not None]
    if not known:
        return None
    length = max(row.shape[-1] for row in known)
    table = np.full((len(rows), *known[0].shape[:-1], length), np.nan, complex if known[0].dtype.kind == "c" else float)
    for place, row in enumerate(rows):
        if row is not None:
            table[place, ..., : row.shape[-1]] = row
    return table
