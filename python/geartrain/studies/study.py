"""Studies: an analysis of a train at every point of a space of parameters."""

from __future__ import annotations

import inspect
import os
import tempfile
import time
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core.extras import extra
from .._core.watch import time_limit
from ..case import read_results
from ..errors import InputError, Interrupted, SolverError, plain, shown
from ..results.branch import Branch
from ..train import Train
from .quantity import check_kept
from .space import Space
from .study_dataset import dataset_of
from .study_engine import compute_all, cores, executor_of
from .study_failures import failures_of, words_of
from .study_plan import CALLS, Plan
from .study_progress import Progress
from .study_store import DONE, Store
from .study_worker import record_of

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["Study", "StudyExplanation", "read_study"]

_BATCH = 3.0  # s that a batch should take
_SPREAD = 4  # batches of a worker, at least, so that all end at about the same time
_SMALL = 2.0  # s of work for which no processes are started
_TRIALS = 0.2  # s of runs of the train itself, by which the time of a point is guessed
_LONGEST_TRIAL = 10.0  # s after which such a run is stopped: the points may take less, as other numbers may end them earlier
_NO_ESTIMATE = f"expected: unknown, since the train itself takes longer than {_LONGEST_TRIAL:g} s"


@dataclass(frozen=True)
class StudyExplanation:
    """What a study is going to do; printed it is a text.

    Attributes
    ----------
    points : int
        Of the space.
    duplicates : int
        Points that are one with an earlier one; they are computed once.
    done, failed : int
        Those in the folder, and those of them that failed.
    seconds_a_point : float or None
        As measured in the folder, else by the train itself; None where its analysis fails or takes longer than 10 s.
    seconds : float or None
        Expected of what is left, on all cores of this machine.
    problem : str
        Why the first point is refused; empty where it is not.
    text : str
    """

    points: int
    duplicates: int
    done: int
    failed: int
    seconds_a_point: float | None
    seconds: float | None
    problem: str
    text: str = field(repr=False)

    def __str__(self) -> str:
        return self.text

    __repr__ = __str__


class Study:
    """An analysis of a train at every point of a space of parameters.

    Results go into a folder, from where `run` goes on after whatever has stopped it; a point that is there is not computed again.

    Parameters
    ----------
    train : Train
    space : Space
    keep : sequence of str
        What is kept of each result: a field, ``"rms"`` (ragged ones are filled up with NaN); of branches ``"peaks"``, ``"jumps"``,
        ``"special_points"``, ``"bands_without_stability"``, ``"separation_ranges"``, ``"back_collision_ranges"``; numbers such
        as ``"largest dynamic_factor"``, ``"smallest mesh 2 minimum"`` (of all stable motions), ``"first jump up"``,
        ``"last falling jump"`` (Lambda).
    **analysis
        A call of the train with its keywords, one of them: ``response=dict(start=0.2, stop=2.6)``, ``modes={}``,
        ``integrate=dict(frequency=0.9)``, ...

    Attributes
    ----------
    train, space, keep
    call : str
        Name of the call.
    settings : dict
        All its keywords, defaults included.

    Raises
    ------
    InputError
        Where a name is not right; a value that is not allowed makes a failed point.

    Examples
    --------
    >>> space = gt.Space({"input_torque": [100.0, 150.0], "mesh 2 half_backlash": [20e-6, 30e-6]})
    >>> study = gt.Study(train, space, response=dict(start=0.2, stop=2.6), keep=["jumps", "largest dynamic_factor"])
    >>> dataset = study.run("runs/torque")  # doctest: +SKIP
    >>> dataset["largest dynamic_factor"].sel(input_torque=150.0).values.round(3)  # doctest: +SKIP
    array([6.846, 6.468])
    >>> study.function(["largest dynamic_factor", "first jump up"])([[150.0, 30e-6]]).round(3)
    array([[6.468, 0.462]])
    """

    def __init__(self, train: Train, space: Space, *, keep: Sequence[str], **analysis: Any) -> None:
        if not isinstance(train, Train):
            raise InputError(f"train = {shown(train)}: must be a gt.Train")
        if not isinstance(space, Space):
            raise InputError(f"space = {shown(space)}: must be a gt.Space")
        if len(analysis) != 1:
            told = ", ".join(analysis) or "none"
            raise InputError(f"analysis: {told}: must be one call of the train, as response=dict(start=0.2, stop=2.6)")
        if isinstance(keep, str) or not keep or not all(isinstance(item, str) for item in keep):
            raise InputError(f"keep = {shown(keep)}: must be a list of names")
        (call, settings), = analysis.items()
        call = "sweep" if call == "integration" else call
        if call not in CALLS:
            raise InputError(f"{call}: a train has no such call: must be one of {', '.join(CALLS)}")
        keywords = {{"from": "start", "to": "stop"}.get(key, key): value for key, value in settings.items()}
        try:
            bound = inspect.signature(getattr(Train, call)).bind(train, **keywords)
        except TypeError as error:
            raise InputError(f"{call}: {error}") from None
        bound.apply_defaults()
        del bound.arguments["self"]
        given = {**bound.arguments, **bound.arguments.pop("settings", {})}
        check_kept(keep, call)
        self.train, self.space, self.keep, self.call = train, space, tuple(keep), call
        self.settings = {key: value for key, value in given.items() if value is not None}
        self._plan = Plan.of(train, space, call, self.settings, keep)
        self._folder: str | None = None

    def __len__(self) -> int:
        return len(self.space)

    def __repr__(self) -> str:
        return f"<Study of {len(self)} points: {self.call} of {self.space!r}>"

    def explain(self, folder: str | os.PathLike[str] | None = None) -> StudyExplanation:
        """Tell what would be done, before anything is.

        Parameters
        ----------
        folder : path-like, optional
            Where results are or will be; that of the last `run` unless told.
        """
        plan, store = self._plan, self._store(folder)
        statuses = store.statuses() if store is not None and store.batches.is_dir() else {}
        own = [status for key in plan.known if (status := statuses.get(key)) is not None]
        problem, seconds = "", None
        try:
            seconds = self._seconds_a_point(store if own else None)
        except Exception as error:  # noqa: BLE001 (told instead)
            problem = f"the train itself: {error}"
        left = len(plan.distinct) - len(own)
        total, expected = None, _NO_ESTIMATE
        if seconds is not None:
            total = seconds * left / max(1, min(cores(), left))
            expected = f"expected: {_duration(seconds)} a point, {_duration(total)} on {cores()} cores"
        told = [
            f"{self.call} of {len(plan)} points, {len(plan) - len(plan.distinct)} of them duplicates",
            *(f"   {name}: {_range(values)}" + (" of the train's own" if self.space.relative[name] else "")
              for axis in self.space.axes for name, values in axis.columns.items()),
            f"stored of each point: {', '.join(self.keep)}",
            f"points done: {len(own)}" + (f", {sum(status != DONE for status in own)} of them failed" if own else "")
            + f"; to do: {left}",
            problem or expected,
        ]
        failed = sum(status != DONE for status in own)
        if failed and store is not None:
            told.append(words_of(plan, failures_of(plan, store)))
        return StudyExplanation(
            len(plan), len(plan) - len(plan.distinct), len(own), failed, seconds, total, problem, "\n".join(told)
        )

    def run(
        self, folder: str | os.PathLike[str], executor: Any = None, *, retry: bool = False, progress: bool = True
    ) -> Dataset:
        """Compute the points that are not yet in the folder.

        Parameters
        ----------
        folder : path-like
            Any number of processes on any machines that see it may work on the same study at the same time.
        executor : Executor or Client, optional
            All cores of this machine unless told; an executor of ``concurrent.futures``, or a client of ``dask.distributed``, whose
            workers must see the folder by the same path.
        retry : bool
            Whether points that failed are computed again.
        progress : bool
            Whether a bar shows how far it is, on a terminal or in a notebook.

        Returns
        -------
        xarray.Dataset
            As `dataset` gives it.

        Raises
        ------
        Interrupted
            On Ctrl-C; what is done is in the folder, and the same call goes on.
        SolverError
            Where the executor gives up; likewise.
        OSError
            Where the folder cannot be written; likewise.
        """
        theirs = executor_of(executor)
        self._folder = os.fspath(folder)
        store, plan, note = self._begun(folder, cores())
        store.mend()
        run_plan(plan, store, range(plan.blocks), theirs, retry=retry, progress=progress, note=note)
        found = dataset_of(plan, store)
        failed = np.flatnonzero(found.status.values != DONE)
        if len(failed):
            message = found.message.values.flat[failed[0]]
            words = f"{len(failed)} of {len(self)} points failed, the first with {message} at {plan.told(int(failed[0]))}; "
            warnings.warn(plain(words + "study.explain() tells more", lines=True), stacklevel=2)
        return found

    def prepare(self, folder: str | os.PathLike[str], parts: int = 1) -> None:
        """Write what ``geartrain-study FOLDER --part 1/PARTS`` computes, without computing it.

        Parameters
        ----------
        folder : path-like
        parts : int
            Of the array job: there are some batches for each.
        """
        self._folder = os.fspath(folder)
        self._begun(folder, parts)

    def dataset(self, folder: str | os.PathLike[str] | None = None) -> Dataset:
        """What is in the folder: a labelled Dataset, with the status of every point; that of the last `run` unless told."""
        store = self._store(folder)
        if store is None:
            raise InputError("folder: must be told, as there has been no run")
        return dataset_of(self._plan, store)

    def branch(self, point: int | Sequence[int], folder: str | os.PathLike[str] | None = None) -> Any:
        """The whole result at a point; a branch is kept as a file in the folder of the last `run`.

        Parameters
        ----------
        point : int or sequence of int
            Its number, from 0, or its places along the axes of the space.
        """
        point = self._number_of(point)
        store = self._store(folder)
        path = None if store is None else store.branches / f"{self._plan.key(point).decode()}.h5"
        if path is not None and path.exists():
            return read_results(path).response
        result = self._plan.result(point)
        if path is not None and isinstance(result, Branch):
            path.parent.mkdir(parents=True, exist_ok=True)
            result.write(path)
        return result

    def function(
        self, outputs: Sequence[str], folder: str | os.PathLike[str] | None = None, executor: Any = None
    ) -> Callable[[ArrayLike], NDArray[np.float64]]:
        """The study as a function of its parameters, for SALib, OpenTURNS, SciPy and the like.

        Parameters
        ----------
        outputs : sequence of str
            Numbers, as in ``keep``: ``"largest dynamic_factor"``, ``"first jump up"``.
        folder : path-like, optional
            Where results are kept, and taken from; else they are forgotten. Workers on other machines need one that they see.
        executor : Executor or Client, optional
            As in `run`.

        Returns
        -------
        callable
            Of an array (points, parameters), in the order of ``space.parameters``, gives (points, outputs); of (parameters,) gives
            (outputs,). NaN where a point failed or has no such thing.
        """
        names = list(outputs)

        def function(sample: ArrayLike) -> NDArray[np.float64]:
            table = np.asarray(sample, float)
            space = self.space.with_sample(np.atleast_2d(table))
            study = Study(self.train, space, keep=names, **{self.call: self.settings})
            if table.ndim == 1 and folder is None:
                kept = record_of(study._plan, 0).kept
                return np.array([float(kept[name].values) if name in kept else np.nan for name in names])
            with tempfile.TemporaryDirectory(prefix="geartrain-") as temporary:
                dataset = study.run(folder or temporary, executor, progress=len(table) > 1)
            columns = [dataset[name].values.astype(float) if name in dataset else np.full(len(space), np.nan) for name in names]
            found = np.stack(columns, axis=-1)
            if found.shape != (len(space), len(names)):
                raise InputError(f"outputs = {shown(names)}: must be single numbers, such as 'largest dynamic_factor'")
            return found[0] if table.ndim == 1 else found

        return function

    # ----------------------------------------------------------------------------------------------- inside

    def _number_of(self, point: int | Sequence[int]) -> int:
        """The number of a point that is told by it, or by its places along the axes."""
        shape = self.space.shape
        places, sizes = ((point,), (len(self),)) if isinstance(point, (int, np.integer)) else (tuple(np.atleast_1d(point)), shape)
        whole = all(isinstance(place, (int, np.integer)) and not isinstance(place, bool) for place in places)
        if whole and len(places) == len(sizes) and all(0 <= place < size for place, size in zip(places, sizes)):
            return int(np.ravel_multi_index(places, sizes))
        along = ", ".join(f"0 to {len(axis) - 1} of {axis.name}" for axis in self.space.axes)
        places_along = f", or {len(shape)} places, {along}" if len(shape) > 1 else ""
        raise InputError(f"point = {shown(point)}: must be a number from 0 to {len(self) - 1}{places_along}")


    def _store(self, folder: str | os.PathLike[str] | None) -> Store | None:
        known = folder if folder is not None else self._folder
        return None if known is None else Store(known)

    def _begun(self, folder: str | os.PathLike[str], workers: int) -> tuple[Store, Plan, str]:
        """The folder with the plan in it, the plan in the batches that it has there, and a note where its time is not known."""
        extra("xarray")  # rather now than after the work
        store = Store(folder)
        store.make()
        seconds: float | None = 1.0
        with suppress(Exception):
            seconds = self._seconds_a_point(store)
        note = "" if seconds is not None else _NO_ESTIMATE
        seconds = _LONGEST_TRIAL if seconds is None else seconds
        batch = max(1, min(round(_BATCH / max(seconds, 1e-6)), len(self._plan.distinct) // (_SPREAD * workers)))
        return store, store.put_plan(self._plan.in_batches_of(batch, seconds)), note

    def _seconds_a_point(self, store: Store | None) -> float | None:
        """Of the points in the folder, else of the train itself; None where that takes longer than `_LONGEST_TRIAL`."""
        for path in store.paths() if store is not None else ():
            batch = store.read(path) if store is not None else None
            if batch is not None:
                own = [second for key, second in zip(batch.keys.tolist(), batch.seconds) if key in self._plan.known]
                if own:
                    return float(np.mean(own))
        begun, best = time.perf_counter(), np.inf
        while time.perf_counter() - begun < _TRIALS:
            one = time.perf_counter()
            try:
                with time_limit(_LONGEST_TRIAL):
                    getattr(self.train, self.call)(**self.settings)
            except TimeoutError:
                return None
            best = min(best, time.perf_counter() - one)
        return float(best)


def run_plan(
    plan: Plan, store: Store, blocks: Sequence[int], executor: Any = None, *, workers: int = 0, retry: bool = False,
    progress: bool = True, patient: bool = True, note: str = "",
) -> Progress:
    """Compute batches of a plan whose points are not yet in the folder; workers are all cores unless told. The bar has the note."""
    if retry:
        store.forget([plan.key(failure.point) for failure in failures_of(plan, store, blocks)])
    there = store.statuses().keys()
    left = [block for block in blocks if not there >= {plan.key(point) for point in plan.block(block)}]
    with Progress(plan, store, progress, note) as told:
        try:
            compute_all(str(store.folder), plan.digest, left, executor, workers or _workers(plan, left), told, patient)
            told()
        except KeyboardInterrupt as error:
            raise Interrupted(f"study stopped; {_there(told.look(), plan, store)}") from error
        except SolverError as error:
            raise SolverError(f"{error}; {_there(told.look(), plan, store)}") from error
    return told


def _there(points: int, plan: Plan, store: Store) -> str:
    return f"{points} of {len(plan.distinct)} points are in {store.folder}: the same call goes on from there"


def _workers(plan: Plan, left: Sequence[int]) -> int:
    """All cores, or this process alone for little work."""
    return cores() if len(left) * plan.batch * plan.seconds > _SMALL else 1


def read_study(folder: str | os.PathLike[str]) -> Study:
    """The study of a folder, the latest begun there: `Study.dataset`, `Study.explain`, `Study.branch`, `Study.run` need no script.

    Parameters
    ----------
    folder : path-like
    """
    plan = Store(folder).plan()
    study = Study(plan.train, Space.of(plan.axes, plan.relative), keep=plan.keep, **{plan.call: plan.settings})
    study._folder = os.fspath(folder)
    return study


def _range(values: NDArray[Any]) -> str:
    if values.dtype.kind == "U" or len(values) == 1:
        return ", ".join(map(str, dict.fromkeys(values.tolist())))[:80]
    return f"{len(values)} values from {values.min():g} to {values.max():g}"


def _duration(seconds: float) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0), ("s", 1.0)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e3:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"
