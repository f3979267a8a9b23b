"""Calls into Fortran: a box holds a case and motions in, results out, and is freed before the call returns."""

from __future__ import annotations

import os
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import geartrain._geartrain as fortran

from ._motion_check import VALUES, check_motion
from ._namelist import in_words_of_the_call
from .errors import InputError, SolverError

if TYPE_CHECKING:
    from .modes import Modes

__all__ = ["ATTRACTORS", "INTEGRATION", "LOOSE", "Box", "file_name", "fortran"]

Array = NDArray[np.float64]

LOOSE, INTEGRATION, ATTRACTORS = 0, 1, 2  # which motions of a box

_INPUT, _ENDED_EARLY, _FILE = 2, 3, 4


class Box:
    """One call's data on the Fortran side; use it in a ``with`` statement.

    Parameters
    ----------
    text : str, optional
        Namelist text of the case, made from the keywords of a call: errors are then in its words.
    """

    def __init__(self, text: str | None = None) -> None:
        self.handle: int = fortran.open_box()
        self._of_call = text is not None
        if text is None:
            return
        try:
            self.check(fortran.read_text(self.handle, text.encode()))
        except BaseException:
            fortran.close_box(self.handle)
            raise

    def __enter__(self) -> Box:  # noqa: PYI034 typing.Self is younger than Python 3.10  # noqa: PYI034 (typing.Self needs Python 3.11)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free what it holds; it is of no use then."""
        fortran.close_box(self.handle)

    def check(self, status: int, whole: bool = True) -> None:
        """Raise the error that the status stands for; work that ended early passes unless the whole is needed."""
        if status == 0 or (status == _ENDED_EARLY and not whole):
            return
        kinds = {_INPUT: InputError, _ENDED_EARLY: SolverError, _FILE: OSError}
        message = self.text("message")
        raise kinds.get(status, RuntimeError)(in_words_of_the_call(message) if self._of_call else message)

    def text(self, name: str, place: int = 0) -> str:
        """A text of the box, see ``text_size`` in border/text.f90."""
        size = fortran.text_size(self.handle, name, place)
        return fortran.copy_text(self.handle, name, place, size).tobytes().decode(errors="replace") if size else ""

    # ------------------------------------------------------------------------------------------------- out

    def modes(self) -> dict[str, Any] | None:
        elements, modes = map(int, fortran.modes_sizes(self.handle))
        if not modes:
            return None
        values, shapes = fortran.copy_modes(self.handle, elements, modes)
        return {
            "natural_frequency": values[:, 0],
            "damped_frequency": values[:, 1],
            "damping_ratio": values[:, 2],
            "shape": shapes.T,
            "element": tuple(self.text("elements").splitlines()),
        }

    def has(self, kind: int) -> bool:
        """Whether motions of this kind were computed, be it none in the end."""
        return bool(fortran.motions_sizes(self.handle, kind)[0] >= 0)

    def motions(self, kind: int = LOOSE) -> list[dict[str, Any]]:
        kinds = self.text("kinds", kind).splitlines() if self.has(kind) else []
        return [{**self._motion(kind, place), "kind": name} for place, name in enumerate(kinds, 1)]

    def _motion(self, kind: int, place: int) -> dict[str, Any]:
        terms, meshes, states, roots, period, *marks = map(int, fortran.motion_sizes(self.handle, kind, place))
        stable, undecided, floating = map(bool, marks)
        numbers, coefficients, values, state, multipliers = fortran.copy_motion(
            self.handle, kind, place, terms, meshes, states, roots
        )
        return {
            "frequency": float(numbers[0]),
            "period": period,
            "coefficients": coefficients.T,
            **_by_name(values.T),
            "stable": stable if roots else None,
            "undecided": undecided,
            "floating": floating,
            "multipliers": _complex(multipliers.T) if roots else None,
            "state": state if states else None,
            "error_estimate": _known(numbers[1]),
            "share": _known(numbers[2]),
            "lyapunov_exponent": float(numbers[3]),
            "lyapunov_error": float(numbers[4]),
        }

    def sweep(self) -> dict[str, Any]:
        return {
            "direction": tuple(self.text("directions").splitlines()),
            "ended": self.text("integration"),
            "complete": bool(fortran.motions_sizes(self.handle, INTEGRATION)[1]),
        }

    def attractors(self) -> dict[str, Any]:
        (frequency, unsettled), (random_seed, starts, complete) = fortran.copy_attractors(self.handle)
        return {
            "frequency": float(frequency),
            "starts": int(starts),
            "random_seed": int(random_seed),
            "unsettled": float(unsettled),
            "ended": self.text("attractors"),
            "complete": bool(complete),
        }

    def branch(self, place: int = 0) -> dict[str, Any] | None:
        """The response (place 0), None where it has no point; or a further branch."""
        sizes = map(int, fortran.branch_sizes(self.handle, place))
        points, meshes, states, terms, _specials, subharmonic, complete, closed = sizes
        if not points and place == 0:
            return None
        numbers, coefficients, values, marks, multipliers = fortran.copy_branch(
            self.handle, place, points, meshes, states, terms
        )
        kinds = self.text("special points", place).splitlines()
        return {
            "frequency": numbers[:, 0],
            **_by_name(values.T),
            "stable": marks[:, 1] == 1 if states else None,
            "undecided": marks[:, 4] == 1 if states else None,
            "count_undecided": marks[:, 6] == 1 if states else None,
            "second_estimate": np.where(numbers[:, 2] < 0, np.nan, numbers[:, 2]) if states else None,
            "multipliers": _complex(multipliers.T) if states else None,
            "coefficients": coefficients.T,
            "error_estimate": np.where(numbers[:, 1] < 0, np.nan, numbers[:, 1]),
            "estimate_doubtful": marks[:, 2] == 1,
            "harmonics": marks[:, 3],
            "part": marks[:, 0],
            "correction": np.where(numbers[:, 3] < 0, np.nan, numbers[:, 3]) if marks[:, 5].all() else None,
            "special_points": [
                (kind, *fortran.copy_special(self.handle, place, special, meshes)) for special, kind in enumerate(kinds, 1)
            ],
            "subharmonic": subharmonic,
            "ended": self.text("branch", place),
            "origin": self.text("origin", place),
            "complete": bool(complete),
            "closed": bool(closed),
        }

    def stability_map(self) -> dict[str, Any] | None:
        points, rows, meshes, linear, complete = map(int, fortran.map_sizes(self.handle))
        if not points:
            return None
        frequency, parameter, counts, multiplier, rms, marks = fortran.copy_map(self.handle, points, rows, meshes)
        return {
            "name": self.text("map name"),
            "unit": self.text("map unit"),
            "linear": bool(linear),
            "frequency": frequency,
            "parameter": parameter,
            "motions": counts[:, :, 0].T,
            "stable_motions": counts[:, :, 1].T,
            "multiplier": _complex(multiplier.T),
            "rms": rms.T if meshes else None,
            "row_done": marks[:, 0] == 1,
            "row_whole": marks[:, 1] == 1,
            "ended": self.text("map"),
            "complete": bool(complete),
        }

    def audit(self) -> dict[str, Any]:
        rows, (points, as_estimated, doubtful, special_points, confirmed, wrong_verdicts, ok) = fortran.audit_sizes(self.handle)
        numbers, marks = fortran.copy_audit(self.handle, rows)
        return {
            "kind": tuple(self.text("audit kinds").splitlines()),
            "frequency": numbers[:, 0],
            **dict(zip(("exact_frequency", "error_estimate", "error", "ratio"), np.where(numbers < 0, np.nan, numbers).T[1:])),
            "point": marks[:, 0] - 1,
            **dict(zip(("estimate_doubtful", "estimate_wrong", "verdict_wrong"), marks.T[1:] == 1)),
            "verdict": tuple(self.text("audit verdicts").splitlines()),
            "exact_verdict": tuple(self.text("exact verdicts").splitlines()),
            "finding": tuple(self.text("findings").splitlines()),
            "points": int(points),
            "as_estimated": int(as_estimated),
            "doubtful": int(doubtful),
            "special_points": int(special_points),
            "confirmed": int(confirmed),
            "wrong_verdicts": int(wrong_verdicts),
            "ok": bool(ok),
            "table": self.text("audit"),
        }

    def read_off(self, what: str, mesh: int = 1, stable: bool = False) -> Array:
        """A list read off the box's branch, one row an entry, see ``summarize`` in box.f90."""
        columns, rows = map(int, fortran.read_off(self.handle, what, mesh, int(stable)))
        table: Array = fortran.copy_table(self.handle, columns, rows).T
        return table

    # -------------------------------------------------------------------------------------------------- in

    def put_modes(self, modes: Modes) -> None:
        values = np.stack([modes.natural_frequency, modes.damped_frequency, modes.damping_ratio], axis=1)
        fortran.put_modes(self.handle, _columns(modes.element, 16), values, modes.shape.T)

    def sizes(self) -> tuple[int, int]:
        """Meshes of the case's train, and the size of its states."""
        meshes, states = map(int, fortran.train_sizes(self.handle))
        return meshes, states

    def put_motions(self, *motions: Any, what: str = "motion", only_state: bool = False) -> None:
        """Put motions of the case's train; ``what`` is what messages call them, ``only_state`` as in `check_motion`."""
        for motion in motions:
            check_motion(motion, what, *self.sizes(), only_state=only_state)
        fortran.reserve_motions(self.handle, len(motions))
        for place, motion in enumerate(motions, 1):
            fortran.put_motion(
                self.handle,
                place,
                motion.kind.encode(),
                motion.period,
                int(bool(motion.stable)),
                int(motion.undecided),
                int(motion.floating),
                [
                    *(motion.frequency, *np.nan_to_num([motion.error_estimate, motion.share], nan=-1.0)),
                    *(motion.lyapunov_exponent, motion.lyapunov_error),
                ],
                motion.coefficients.T,
                _in_columns(motion),
                np.zeros(0) if motion.state is None else motion.state,
                np.zeros((2, 0)) if motion.multipliers is None else _pairs(motion.multipliers),
            )

    def put_sweep(self, sweep: Any) -> None:
        if len(sweep.direction) != len(sweep) or not {*sweep.direction} <= {"up", "down"}:
            raise InputError(f"integration: direction: must be 'up' or 'down' of each of the {len(sweep)} motions")
        self._put_alike("integration", sweep)
        fortran.put_sweep(self.handle, _columns(sweep.direction, 4), sweep.ended.encode(), int(sweep.complete))

    def put_attractors(self, found: Any) -> None:
        self._put_alike("attractors", found)
        fortran.put_attractors(
            self.handle, found.ended.encode(), [found.frequency, found.unsettled],
            [found.random_seed, found.starts, found.complete],
        )

    def _put_alike(self, what: str, motions: Any) -> None:
        """Put motions that are written as one table."""
        self.put_motions(*motions, what=what)
        if len({len(motion.multipliers) for motion in motions if motion.multipliers is not None}) > 1:
            raise InputError(f"{what}: multipliers: must be as many of one motion as of another")

    def put_stability_map(self, chart: Any) -> None:
        shape = (0, len(chart.frequency), len(chart.parameter))
        fortran.put_map(
            self.handle,
            chart.name.encode(),
            chart.unit.encode(),
            chart.ended.encode(),
            [chart.linear, chart.complete],
            chart.frequency,
            chart.parameter,
            np.stack([chart.motions.T, chart.stable_motions.T], axis=2),
            _pairs(chart.multiplier),
            np.zeros(shape) if chart.rms is None else chart.rms.T,
            np.stack([chart.row_done, chart.row_whole], axis=1),
        )

    def put_branches(self, branches: list[Any]) -> None:
        """Put further branches."""
        fortran.reserve_branches(self.handle, len(branches))
        for place, branch in enumerate(branches, 1):
            self.put_branch(branch, place)

    def put_branch(self, branch: Any, place: int = 0) -> None:
        stable = np.zeros(len(branch), bool) if branch.stable is None else branch.stable
        roots = np.zeros((len(branch), 0)) if branch.multipliers is None else branch.multipliers
        correction = np.full(len(branch), np.nan) if branch.correction is None else branch.correction
        refined = np.full(len(branch), branch.correction is not None)
        undecided = np.zeros(len(branch), bool) if branch.undecided is None else branch.undecided
        counts = undecided if branch.count_undecided is None else branch.count_undecided
        second = np.full(len(branch), np.nan) if branch.second_estimate is None else branch.second_estimate
        # A point without a correction is tried (again) where the branch is refined (refinement.f90).
        estimates = np.nan_to_num([branch.error_estimate, second, np.nan_to_num(correction, nan=-2.0)], nan=-1.0)
        marks = [branch.part, stable, branch.estimate_doubtful, branch.harmonics, undecided, refined, counts]
        fortran.put_branch(
            self.handle,
            place,
            branch.ended.encode(),
            branch.origin.encode(),
            [branch.subharmonic, branch.complete, branch.closed, len(branch.special_points), len(branch)],
            _some(np.stack([branch.frequency, *estimates], axis=1)),
            _some(branch.coefficients).T,
            _some(_in_columns(branch).swapaxes(0, 1)).swapaxes(0, 1),
            _some(np.stack(marks, axis=1)),
            _pairs(_some(roots).astype(complex)),
        )
        for number, special in enumerate(branch.special_points, 1):
            fortran.put_special(
                self.handle, place, number, special.kind.encode(), special.frequency, special.point + 1, special.rms
            )


def file_name(path: str | os.PathLike[str]) -> bytes:
    """The path as Fortran wants it."""
    return os.fsencode(path)


def _by_name(values: Array) -> dict[str, Array]:
    """The values of every mesh by their names; no dynamic factor (negative in Fortran) is NaN."""
    named = dict(zip(VALUES, values))
    factor = named["dynamic_factor"]
    named["dynamic_factor"] = np.where(factor < 0, np.nan, factor)
    return named


def _in_columns(owner: Any) -> Array:
    """The inverse of ``_by_name``."""
    values = {name: getattr(owner, name) for name in VALUES}
    values["dynamic_factor"] = np.nan_to_num(values["dynamic_factor"], nan=-1.0)
    return np.stack(list(values.values())).T


def _complex(pairs: Array) -> NDArray[np.complex128]:
    """From (..., 2), real and imaginary part."""
    return np.ascontiguousarray(pairs).view(np.complex128)[..., 0]


def _pairs(values: NDArray[np.complex128]) -> Array:
    """The inverse of ``_complex``, in Fortran's order of dimensions."""
    return np.ascontiguousarray(values)[..., np.newaxis].view(np.float64).T


def _some(rows: NDArray[Any]) -> NDArray[Any]:
    """One row of zeros for none: f2py passes no empty array."""
    return rows if len(rows) else np.zeros((1, *rows.shape[1:]), rows.dtype)


def _known(value: float) -> float:
    """NaN for the negative number that stands for "not known" in Fortran."""
    return float(value) if value >= 0 else float("nan")


def _columns(items: tuple[str, ...], width: int) -> bytes:
    return "".join(item.ljust(width) for item in items).encode()
