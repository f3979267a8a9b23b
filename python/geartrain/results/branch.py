"""Branches of periodic motions over frequency, or over a parameter of the train."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from numbers import Integral, Real
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box, Group, described
from .._core.dataset import dataframe, dataset
from .._core.description import Description, part_labels
from .._core.parameter import with_values
from .._core.units import Unit, frequency_words, hertz_of, in_own_unit, lambda_of, speed_of
from .._core.watch import watched
from ..errors import InputError, SolverError, shown
from ..pages.page import Page, page
from ..plots.response_plot import Curves
from ..reports.report_file import write_report
from .audit import Audit
from .motion import Motion
from .motion_table import motions_of
from .special_point import SpecialPoint, SpecialPoints

if TYPE_CHECKING:
    from pandas import DataFrame
    from xarray import Dataset

__all__ = ["Branch"]

Array = NDArray[np.float64]

#: Fields of a point that follow from others and the train.
_DERIVED = {"true_ac_rms", "speed", "fundamental_frequency"}


@dataclass(frozen=True, eq=False, repr=False)
class Branch(Curves):
    """Periodic motions along a branch, through its folds. Displacements are over the characteristic length.

    Attributes
    ----------
    frequency : ndarray, (points,)
        Lambda; of a branch over a parameter the same at every point.
    parameter : ndarray, (points,), or None
        Of a branch over a parameter its values, in ``parameter_unit``; None over frequency.
    parameter_name, parameter_unit : str
        Name and unit of this parameter, ``'1'`` of a dimensionless one; empty over frequency.
    rms, mean, minimum, maximum : ndarray, (points, meshes)
        As in `Motion`.
    mesh_force_maximum, dynamic_factor, separation_fraction, back_contact_fraction : ndarray, (points, meshes)
        As in `Motion`.
    stable : ndarray of bool, (points,), or None
        None where stability was not asked for.
    undecided : ndarray of bool, (points,), or None
        Where ``stable`` is a guess: the largest multiplier is as near to the unit circle as it is uncertain.
    count_undecided : ndarray of bool, (points,), or None
        Where the number of multipliers outside the unit circle is a guess.
    second_estimate : ndarray, (points,), or None
        Largest magnitude of a multiplier of the motion corrected by its estimated error; nan where it was not needed.
    growth_rate : ndarray, (points,), or None
        Growth rate of the slowest perturbation [1/s], the largest real part of a Floquet exponent; negative where stable.
    multipliers : ndarray of complex, (points, states), or None
        Floquet multipliers over one period of the motion; of a train of 160 states
        (41 flexible shafts) or more the 16 of largest magnitude, to about 1e-3 where all are inside the unit
        circle and ``multipliers=True`` did not ask for digits. None where a period has more than 500 cycles of a mesh and
        ``multipliers=True`` did not ask for them.
    coefficients : ndarray, (points, meshes, 1 + 2*harmonics)
        Mean, cos 1, sin 1, cos 2, ... of the frequency Lambda/subharmonic.
    error_estimate : ndarray, (points,)
        Relative error of the waveform as estimated, against the motion at the same Lambda or, where the branch turns before it,
        that of its fold. The largest force of a mesh that moves little may be off by 20 times as much: the report states its error.
    reading_error_estimate : ndarray, (points,), or None
        Error, as estimated, of the shaft torque, bearing force or displacement of a mesh without backlash where it is largest, by
        harmonics that are not carried, over its alternating part or, of a small one, over a tenth of the largest of its kind.
        None for trains with dry friction.
    estimate_doubtful : ndarray of bool, (points,)
        Where that may be off by more than a small factor: a fold as near as it is itself misplaced, a contact that begins or ends
        within the error, or an error beyond 0.1.
    harmonics : ndarray of int, (points,)
        Harmonics that each point was solved with.
    segment : ndarray of int, (points,)
        Number of the segment; a new one begins where the branch comes back from beyond the amplitude limit, or with the points
        traced from ``stop`` where those from ``start`` do not get there, or get there at another motion than the one from rest.
    special_points : list of SpecialPoint
    subharmonic : int
        Period of the motions in periods of the fundamental.
    ended : str
        Why it ended, in words.
    complete, closed : bool
        Whether it got to its other end; whether it came back to where it began.
    origin : str
        Where a further branch comes from, in words; empty for a response.
    correction : ndarray, (points,), or None
        Of a refined branch: by how much the waveform changed, relative, which is the error that the point had; NaN where shooting
        found no orbit near the point, which is as it was then. None where the branch is not refined.
    load_share, load_share_maximum : ndarray, (points, planets of all planetary sets), or None
        Mean and largest force of each planet with the sun (with the ring, without a sun) over the sum of the mean forces of its
        set, see `Train.planet_labels`; nan without load, None without planets.
    branches : list of Branch
        Those that bifurcate from a response: at period doublings, ``period_doublings`` generations of them, and where
        ``branch_points`` says so at branch points.
    settings : mapping
        What it was asked for, the names of ``&response``.
    train : Train
    others : mapping
        Further fields of the points, by their names in the results file; they are attributes as well.
    """

    frequency: Array
    rms: Array
    mean: Array
    minimum: Array
    maximum: Array
    mesh_force_maximum: Array
    dynamic_factor: Array
    separation_fraction: Array
    back_contact_fraction: Array
    stable: NDArray[np.bool_] | None
    undecided: NDArray[np.bool_] | None
    count_undecided: NDArray[np.bool_] | None
    second_estimate: Array | None
    growth_rate: Array | None
    multipliers: NDArray[np.complex128] | None
    coefficients: Array
    error_estimate: Array
    reading_error_estimate: Array | None
    estimate_doubtful: NDArray[np.bool_]
    harmonics: NDArray[np.intc]
    segment: NDArray[np.intc]
    special_points: list[SpecialPoint]
    subharmonic: int
    ended: str
    complete: bool
    closed: bool
    origin: str = ""
    parameter: Array | None = None
    parameter_name: str = ""
    parameter_unit: str = ""
    correction: Array | None = None
    load_share: Array | None = None
    load_share_maximum: Array | None = None
    branches: list[Branch] = field(default_factory=list)
    settings: Mapping[str, Any] = field(default_factory=dict)
    train: Description | None = None
    others: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.frequency)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        return f"<Branch of {len(self)} {'point' if len(self) == 1 else 'points'}: {in_own_unit(self.ended, self.train)}>"

    def report(self, path: str | os.PathLike[str] | None = None, *, verbose: bool = False) -> str:
        """The report that the executable prints of this branch and its ``branches``: `str` of a branch is the same text.

        Parameters
        ----------
        path : path-like, optional
            Where to write it as a document, ``.pdf`` or ``.html``: see `Results.report`.
        verbose : bool
            Every peak, jump, special point and range, as with ``--verbose``.

        Examples
        --------
        >>> print(branch.report().split("RESONANCES")[0])  # doctest: +SKIP
        """
        if self.train is None:
            raise ValueError("this branch has no train")
        # All are taken at once: a box whose response is taken already would lose it to the others.
        with self.train._ask(response=self.settings) as box:
            for place, branch in enumerate((self, *self.branches)):
                branch._put(box, place)
            text = box.report(verbose)
        if path is not None:
            write_report(SimpleNamespace(response=self, modes=None, run_up=None, integration=None), path, text)
        return text

    def at(self, frequency: float, *, unit: Unit = "Lambda") -> list[Motion]:
        """Every solution of this branch at exactly that frequency, in their order along the branch.

        ``unit`` is that of the frequency: Lambda, rpm or Hz, as in `Train.response`. Of a branch over a parameter ``frequency`` is
        a value of the parameter in its unit, and the train of the motions has it. Outside the range that was asked for the list is
        empty, with a warning.

        Examples
        --------
        >>> for motion in branch.at(0.6):
        ...     print(motion.rms.round(3), "stable" if motion.stable else "unstable")
        [0.166 0.212] stable
        [0.416 1.691] unstable
        [0.491 2.133] stable
        """
        if isinstance(frequency, bool) or not isinstance(frequency, Real):
            raise InputError(f"frequency = {shown(frequency)}: must be a number")
        try:
            frequency = float(frequency)
        except OverflowError:
            raise InputError(f"frequency = {shown(frequency)}: must be a finite number") from None
        train = self.train
        if self.parameter_name and train is not None:
            if unit != "Lambda":
                raise InputError(f"unit = {shown(unit)}: a value of {self.parameter_name} has the unit of the parameter")
            train = with_values(train, {self.parameter_name: frequency})
        else:
            frequency = lambda_of(train, frequency, unit)
        ends = self._range()
        if ends and abs(frequency - sum(ends) / 2) > (0.5 + 1e-9) * abs(ends[0] - ends[1]):
            name = self.parameter_name
            words = f"{name} = {frequency:g}" if name else frequency_words(frequency, train)
            warnings.warn(f"{words}: outside the range of the branch, {min(ends):g} to {max(ends):g}", stacklevel=3)

        def work(progress: NDArray[np.float64]) -> list[Motion]:
            with self._box() as box:
                box.check(box.work("at", progress, frequency))
                return [Motion(train=train, **found) for found in motions_of(box)]

        return watched(work, "at")

    def refine(self) -> Branch:
        """The same branch with every point polished by shooting to about 1e-11, multipliers included.

        Its ``correction`` tells by how much each point moved; its ``at`` gives refined motions. A point near which shooting finds
        no orbit stays as it is, as next to a fold, whose true place is elsewhere. Special points become those of the exact motion
        near them, as `SpecialPoint.exact` has them, where there are such.

        Examples
        --------
        >>> refined = branch.refine()
        >>> round(float(np.nanmedian(refined.correction)), 4), bool(np.isnan(refined.correction).sum() < 20)
        (0.0007, True)
        >>> refined.at(0.9)[0].rms.round(8)
        array([0.41003761, 0.7144016 ])
        """
        train = self.train
        if train is None:
            raise ValueError("this branch has no train")

        def work(progress: NDArray[np.float64]) -> Branch:
            with self._box() as box:
                box.check(box.work("refine", progress))
                refined = Branch._from(box, train, self.settings)
                if refined is None:
                    raise SolverError("no point to refine")
                return replace(refined, settings=self.settings, branches=self.branches)

        return watched(work, "refinement", len(self))

    def audit(self, *, points: int = 20, random_seed: int = 0) -> Audit:
        """A second opinion: points drawn at random and all special points solved anew by shooting.

        Each point's true error is set against its estimate, its stability against the multipliers of the orbit; each fold and
        change of stability is looked for on the exact branch. What is doubtful or undecided counts as wrong nowhere, but is told.
        The same ``random_seed`` draws the same points, all of them where the branch has no more than ``points``.

        Examples
        --------
        >>> audit = branch.audit(points=20)
        >>> print(*repr(audit).split("; "), sep="\\n")
        <Audit: Errors of 20 of 20 points are as estimated
        stability is wrong at 0 points
        10 of 10 special points confirmed
        jumps and contact ranges are not audited>
        >>> audit.ok, float(audit.ratio[:20].max().round(1))
        (True, 1.1)
        """
        for name, value, least in (("points", points, 0), ("random_seed", random_seed, -(2**31) + 1)):
            if isinstance(value, bool) or not isinstance(value, Integral) or not least <= value < 2**31:
                raise InputError(f"{name} = {shown(value)}: must be an integer from {least} to {2**31 - 1}")

        train = self.train
        if train is None:
            raise ValueError("this branch has no train")

        def work(progress: NDArray[np.float64]) -> Audit:
            with self._box() as box:
                box.check(box.work("audit", progress, points, random_seed))
                return Audit._from(box, train)

        return watched(work, "audit", min(points, len(self)) + len(self.special_points))

    def period_doubled(self, special: SpecialPoint) -> Branch:
        """The branch of twice the period that leaves this one at a period doubling, one of its ``special_points``.

        It has twice the harmonics and subharmonic, and ends where it meets the branch of half its period or leaves the range. No
        seed is needed; `SolverError` where no point was found.

        Examples
        --------
        >>> doublings = [special for special in branch.special_points if special.kind == "period doubling"]
        >>> twice = branch.period_doubled(doublings[-1])
        >>> twice.subharmonic, bool(round(twice.frequency[0], 2) == 2.04)
        (2, True)
        """
        if self.train is None:
            raise ValueError("this branch has no train")
        places = [place for place, own in enumerate(self.special_points, 1) if own is special]
        if not places:
            raise InputError(f"special = {shown(special)}: must be one of this branch's special_points")
        train = self.train

        def work(progress: NDArray[np.float64]) -> Branch:
            with self._box() as box:
                status = box.work("double", progress, places[0])
                doubled = Branch._from(box, train, self.settings)
                box.check(status, whole=doubled is None)
                if doubled is None:
                    raise SolverError(box.ended() or "no point found")
                return doubled

        return watched(work, "period doubling")

    @property
    def speed(self) -> Array | None:
        """Speed [rpm] of the body that `Train.speed_name` tells, (points,); None where not every mesh has teeth."""
        return speed_of(self.train, self.frequency)

    @property
    def fundamental_frequency(self) -> Array | None:
        """Frequency of the fundamental [Hz], (points,); None without a train."""
        return hertz_of(self.train, self.frequency)

    @property
    def true_ac_rms(self) -> Array:
        """Root mean square over time of the displacement less its mean, (points, meshes): ``rms`` over sqrt(2)."""
        rms: Array = self.rms / np.sqrt(2)
        return rms

    @cached_property
    def onsets(self) -> list[SpecialPoint]:
        """Contact onsets: where a mesh begins or ceases to separate, or its back flanks to touch, as special points.

        They lie on the branch; those on an interpolation of its points are ``undecided``: with dry friction, and where Newton's
        method fails beside one.

        Examples
        --------
        >>> [(onset.kind, onset.mesh, round(onset.frequency, 4)) for onset in branch.onsets][:2]
        [('separation', 2, 0.4617), ('separation', 2, 0.495)]
        """
        with self._box() as box:
            rows = box.show("onsets")["/onsets"].rows("kind", "mesh", self._free_name, "after_point", "rms", "undecided")
        return SpecialPoints((
            SpecialPoint(kind.strip(), self._lambda(float(value)), int(point) - 1, rms, bool(undecided),
                         *self._speeds(float(value)), branch=self, mesh=int(mesh))
            for kind, mesh, value, point, rms, undecided in rows
        ), self.train)

    def to_dataset(self) -> Dataset:
        """The points as an xarray Dataset with the names, units and coordinates of the results file; needs xarray.

        Examples
        --------
        >>> float(branch.to_dataset().rms.sel(mesh=1).max().round(2))
        0.86
        """
        names = ("ended", "complete", "closed", "subharmonic")
        attributes = {name: getattr(self, name) for name in names} | ({"origin": self.origin} if self.origin else {})
        values = {
            **self.arrays(), "true_ac_rms": self.true_ac_rms, **part_labels(self.train, self.arrays()),
            "speed": self.speed, "fundamental_frequency": self.fundamental_frequency,
        }
        if self.parameter_name:
            attributes |= {"parameter_name": self.parameter_name, "parameter_unit": self.parameter_unit}
            points = dataset("/response", values, attributes, ("parameter", "frequency", "speed", "fundamental_frequency"))
            points["parameter"].attrs.update(units=self.parameter_unit, long_name=self.parameter_name)
            return points
        return dataset("/response", values, attributes, ("frequency", "speed", "fundamental_frequency"))

    def to_dataframe(self) -> DataFrame:
        """A pandas DataFrame with a row for each point: speed, and each field of meshes and shafts by its number; needs pandas.

        What `peaks`, `jumps` and ``special_points`` give has the same call.

        Examples
        --------
        >>> list(branch.to_dataframe().columns[2:4])
        ['rms, mesh 1', 'rms, mesh 2']
        """
        return dataframe(self.to_dataset())

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the branch and its ``branches`` as a results file, which `read_results` gives back as the response of its case.

        Parameters
        ----------
        path : path-like

        Raises
        ------
        OSError
        """
        with self._box() as box:
            for place, branch in enumerate([self, *self.branches]):
                branch._put(box, place)
            box.write(path)

    def page(self, path: str | os.PathLike[str] | None = None, *, compare: Any = None) -> Page:
        """The branch and its ``branches`` as a page for a browser, as `geartrain.page` gives it; needs plotly."""
        return page(self, path, compare=compare)

    def arrays(self) -> dict[str, NDArray[Any] | None]:
        """The fields of the points by their names in the results file; None for what there is not."""
        return {name: getattr(self, name) for name in (*_names()[1], *self.others)}

    def _box(self) -> Box:
        """A box of the branch, which may be changed; the case is read and the fields are put but once."""
        if self.train is None:
            raise ValueError("this branch has no train")
        return Box(copy=self._kept)

    @cached_property
    def _kept(self) -> Box:
        assert self.train is not None
        box = self.train._ask(response=self.settings)
        self._put(box)
        box.take()
        return box

    def _put(self, box: Box, place: int = 0) -> None:
        """Put it into a box as the response (place 0) or a further branch."""
        path = f"/branch_{place}" if place else "/response"
        attributes = {
            "ended": self.ended, "origin": self.origin or None, "complete": self.complete, "closed": self.closed,
            "subharmonic": self.subharmonic, "harmonics": int(self.orders[-1]) if len(self.orders) else 0,
            "parameter_name": self.parameter_name or None, "parameter_unit": self.parameter_unit or None,
        }
        box.put(path, attributes, self.arrays(), like="/response")
        specials = self.special_points
        if specials:
            columns = {
                "kind": [special.kind for special in specials],
                "frequency": None if self.parameter_name else [float(special.frequency) for special in specials],
                "parameter": np.array([special.parameter for special in specials], float) if self.parameter_name else None,
                "after_point": [special.point + 1 for special in specials],
                "rms": np.stack([special.rms for special in specials]),
                "multiplicity": [special.multiplicity for special in specials],
                "correction": None if specials[0].correction is None else [special.correction for special in specials],
            }
            box.put(f"{path}/special_points", {}, columns, like="/response/special_points")

    @property
    def orders(self) -> NDArray[np.intc]:
        """Harmonics of Lambda/subharmonic that ``coefficients`` has: all up to the highest, or the sets that were carried."""
        dense = np.arange(1, (self.coefficients.shape[-1] + 1) // 2, dtype=np.intc)
        return self.others.get("orders", dense)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("_kept", "_lists", "onsets")}

    def __getattr__(self, name: str) -> Any:
        # Only what is no attribute comes here; `others` itself is not there yet while a branch is copied.
        try:
            return self.__dict__["others"][name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}") from None

    @classmethod
    def _from(cls, box: Box, train: Description, settings: Mapping[str, Any], place: int = 0) -> Branch | None:
        """The response of the box (place 0) or a further branch; ``settings`` are those of the response."""
        path = f"/branch_{place}" if place else "/response"
        group = box.results().get(path, Group())
        if "frequency" not in group.arrays or not (place or len(group.arrays["frequency"])):
            return None
        rows = box.results().get(f"{path}/special_points", Group())
        over = "parameter" in group.arrays
        lambdas = group.arrays["frequency"]
        specials = SpecialPoints((
            SpecialPoint(
                kind, frequency := float(lambdas[0] if over else value), int(point) - 1, rms, bool(undecided),
                speed_of(train, frequency), hertz_of(train, frequency), parameter=float(value) if over else None,
                correction=None if correction is False else float(correction), multiplicity=int(multiplicity or 1),
            )
            for kind, value, point, undecided, rms, correction, multiplicity in
            rows.rows("kind", "parameter" if over else "frequency", "after_point", "undecided", "rms", "correction", "multiplicity")
        ), train)
        known, of_points = _names()
        # Axes, and what follows from other fields or the train, are no fields of their own; an attribute may have an array's name.
        arrays = {name: values for name, values in group.arrays.items()
                  if group.about[name][0] != (name,) and not (name in _DERIVED or name.endswith("_label"))}
        told = {name: value for name, value in group.attributes.items() if name in known - arrays.keys()}
        found: dict[str, Any] = {**dict.fromkeys(of_points), **told, **arrays}
        others = {name: found.pop(name) for name in arrays if name not in known}
        settings = _settings_for(settings, found["subharmonic"], (found["coefficients"].shape[-1] - 1) // 2)
        branch = cls(**found, special_points=specials, settings=settings, train=train, others=others)
        for special in specials:
            object.__setattr__(special, "branch", branch)
        return branch

    @classmethod
    def _all_from(cls, box: Box, train: Description, settings: Mapping[str, Any], first: int = 1) -> list[Branch]:
        """The further branches of the box."""
        places = range(first, 1 + sum(path.startswith("/branch_") and path.count("/") == 1 for path in box.results()))
        return [branch for place in places if (branch := cls._from(box, train, settings, place)) is not None]


@cache
def _names() -> tuple[frozenset[str], tuple[str, ...]]:
    """Fields of a branch; those that it has of each point."""
    known = [item.name for item in fields(Branch)]
    return frozenset(known), tuple(name for name in known if name in described()["/response"].about)


def _settings_for(settings: Mapping[str, Any], period: int, harmonics: int) -> dict[str, Any]:
    """The settings that Fortran has used for motions of another period than the response's, see ``settings_for`` there."""
    own = settings.get("subharmonic") or 1
    if period == own:
        return dict(settings)
    changed = {**settings, "subharmonic": period}
    if settings.get("harmonics"):
        changed["harmonics"] = harmonics
    if settings.get("samples"):
        changed["samples"] = max(settings["samples"] * period // own, 8 * harmonics + 2)
    return changed
