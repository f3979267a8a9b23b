"""Case files: the same input and the same results as the executable's."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._core.box import Box, Group, file_name, fortran, one_blas_thread
from ._core.namelist import parse
from ._core.table import Found
from ._core.units import in_own_unit, units_of
from ._core.watch import watched
from .pages.page import Page, page
from .reports.report_file import write_report
from .results.attractors import Attractors
from .results.basins import Basins
from .results.bifurcation_diagram import BifurcationDiagram
from .results.branch import Branch
from .results.locus import Locus
from .results.modes import Modes
from .results.motion_table import ATTRACTORS, INTEGRATION
from .results.run_up import RunUp
from .results.stability_map import StabilityMap
from .results.sweep import Sweep
from .train import Train
from .variables import ANALYSES, VARIABLES

__all__ = ["Case", "Results", "read_case", "read_results"]


@dataclass(frozen=True, eq=False, repr=False)
class Results:
    """What a case's run gave; None for what it did not ask for.

    Attributes
    ----------
    modes : Modes or None
    response : Branch or None
    integration : Sweep or None
    attractors : Attractors or None
    basins : Basins or None
    bifurcation_diagram : BifurcationDiagram or None
    stability_map : StabilityMap or None
    run_up : RunUp or None
    locus : Locus or None
    branches : list of Branch
        Further branches: those of ``response.branches``, then those of ``attractors.branches``.
    ended : str
        Why it ended early, in words; empty where it did not.
    text : str
        The resolved case.
    others : mapping
        Results of further analyses by their names; they are attributes as well.
    """

    modes: Modes | None
    response: Branch | None
    integration: Sweep | None
    attractors: Attractors | None = None
    basins: Basins | None = None
    bifurcation_diagram: BifurcationDiagram | None = None
    stability_map: StabilityMap | None = None
    run_up: RunUp | None = None
    locus: Locus | None = None
    branches: list[Branch] = field(default_factory=list)
    ended: str = ""
    text: str = field(default="", repr=False)
    others: Mapping[str, Found] = field(default_factory=dict)

    def __repr__(self) -> str:
        """The title, and each analysis with what it has and the range that it covers."""
        told = [f"<Results{f' of {title!r}' if (title := dict(parse(self.text)).get('train', {}).get('title')) else ''}"]
        told += [f"{name}: {_in_short(result)}" for name in ANALYSES if (result := getattr(self, name, None)) is not None]
        told += [f"branches: {len(self.branches)}"] if self.branches else []
        told += [self.ended] if self.ended else []
        return "\n   ".join(told) + ">"

    def __str__(self) -> str:
        return self.report()

    def report(self, path: str | os.PathLike[str] | None = None, *, verbose: bool = False) -> str:
        """The report that the executable prints, without the time of the run and the file; `str` of results is the same text.

        Parameters
        ----------
        path : path-like, optional
            Where to write it as a document with the train, the numbers of its drawing, pictures, dynamic factors and what is not
            modelled: ends in ``.pdf`` or ``.html``; needs matplotlib.
        verbose : bool
            Every peak, jump, special point and range, as with ``--verbose``.

        Raises
        ------
        InputError
            Where the path has another ending.
        OSError
            Where it cannot be written.
        """
        with self._filled() as box:
            text = box.report(verbose)
        if path is not None:
            write_report(self, path, text)
        return text

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the HDF5 file that the executable writes; `read_results` gives the results back.

        Parameters
        ----------
        path : path-like

        Raises
        ------
        OSError
        """
        with self._filled() as box:
            box.write(path)

    def _filled(self) -> Box:
        """A box with the case and all results."""
        box = Box(self.text)
        for name in ANALYSES:
            result = getattr(self, name, None)
            if result is not None:
                result._put(box)
        for place, branch in enumerate(self.branches, 1):
            branch._put(box, place)
        return box

    def page(self, path: str | os.PathLike[str] | None = None, *, compare: Any = None) -> Page:
        """The results as a page for a browser, as `geartrain.page` gives it; needs plotly.

        Parameters
        ----------
        path : path-like, optional
            Where to write it.
        compare : Results, Branch or path-like, optional
            Laid over these: results, or a results file.
        """
        if isinstance(compare, (str, os.PathLike)):
            compare = read_results(compare)
        return page(self, path, compare=compare)

    def __getattr__(self, name: str) -> Any:
        # Only what is no attribute comes here; `others` itself is not there yet while results are copied.
        try:
            return self.__dict__["others"][name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}") from None


@dataclass(frozen=True)
class Case:
    """A train and the analyses wanted of it, as read from a file by `read_case`.

    Attributes
    ----------
    train : Train
    modes : bool
        Whether they are wanted.
    response, integration, attractors, basins, bifurcation_diagram, stability_map, run_up : mapping or None
        The group's variables, as keywords of `Train.response`, `Train.sweep`, `Train.attractors`, `Train.basins`,
        `Train.bifurcation_diagram`, `Train.stability_map` and `Train.run_up`; None where it is absent.
    output : str or None
        The output file named in ``&output``.
    text : str
        The resolved case: every variable, defaults included.
    others : mapping
        The variables of further analyses by their names.
    """

    train: Train
    modes: bool
    response: Mapping[str, Any] | None
    integration: Mapping[str, Any] | None
    attractors: Mapping[str, Any] | None
    basins: Mapping[str, Any] | None
    bifurcation_diagram: Mapping[str, Any] | None
    stability_map: Mapping[str, Any] | None
    run_up: Mapping[str, Any] | None
    output: str | None
    text: str = field(repr=False)
    others: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def run(self, resume: str | os.PathLike[str] | None = None) -> Results:
        """Compute everything that the case asks for.

        Parameters
        ----------
        resume : path-like, optional
            The checkpoint of a run of this case that was killed, ``FILE.h5.partial``, to go on from: the results are the same.

        Returns
        -------
        Results
            Equal to what the executable writes.

        Raises
        ------
        Interrupted
            On Ctrl-C, with the results so far.
        InputError
            Where ``resume`` is the checkpoint of another case.
        OSError
            Where it cannot be read.
        """
        checkpoint = b"" if resume is None else file_name(resume)

        def work(progress: NDArray[np.float64]) -> Results:
            with Box(self.text) as box:
                with one_blas_thread:
                    status = fortran.run_all(box.handle, b"", checkpoint, progress)
                results = self._results(box, box.text("message"))
                box.check(status, whole=False)
                return results

        return watched(work, "run")

    def _results(self, box: Box, ended: str) -> Results:
        """The results that the box holds."""
        settings = self.response or {}
        branches = Branch._all_from(box, self.train, settings)
        bifurcated = [branch for branch in branches if not branch.origin.startswith("attractor")]
        response = Branch._from(box, self.train, settings)
        if response is not None:
            response.branches.extend(bifurcated)
        return Results(
            modes=Modes._from(box, self.train),
            response=response,
            integration=Sweep._from(box, self.train) if INTEGRATION in box.results() else None,
            attractors=Attractors._from(box, self.train, branches[len(bifurcated):]) if ATTRACTORS in box.results() else None,
            basins=Basins._from(box, self.train),
            bifurcation_diagram=BifurcationDiagram._from(box, self.train),
            stability_map=StabilityMap._from(box, self.train),
            run_up=RunUp._from(box, self.train),
            locus=Locus._from(box, self.train),
            branches=branches,
            ended=ended,
            text=self.text,
            others={name: Found._from(box, name) for name in _others(Results) if f"/{name}" in box.results()},
        )

    @classmethod
    def _from(cls, box: Box) -> Case:
        """The case that the box holds."""
        text = box.text("case")
        groups = parse(text)
        one = dict(groups)
        for name in one.keys() & set(ANALYSES):
            # A variable that is not in force, as &response frequency without parameter, is not in the text.
            one[name] = {**dict.fromkeys(VARIABLES.get(name, {})), **one[name]}
        return cls(
            train=Train._of(groups),
            modes="modes" in one,
            response=one.get("response"),
            integration=one.get("integration"),
            attractors=one.get("attractors"),
            basins=one.get("basins"),
            bifurcation_diagram=one.get("bifurcation_diagram"),
            stability_map=one.get("stability_map"),
            run_up=one.get("run_up"),
            output=one.get("output", {}).get("file"),
            text=text,
            others={name: one[name] for name in _others(cls) if name in one},
        )


def read_case(path: str | os.PathLike[str]) -> Case:
    """Read a case file.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    Case

    Raises
    ------
    InputError
        With the executable's message: every problem with its line and column.
    """
    with Box() as box:
        box.read("case", file_name(path))
        return Case._from(box)


def read_results(path: str | os.PathLike[str]) -> Results:
    """Read a results file, whichever of the executable and `Results.write` wrote it, or the checkpoint of a run under way.

    Parameters
    ----------
    path : path-like

    Returns
    -------
    Results
        As `Case.run` gives them: branches know their train, and go on from there (`Branch.at`, `Branch.refine`, ...).

    Raises
    ------
    OSError
        Where it cannot be read, or any bit of it is not what this version of geartrain wrote.

    Examples
    --------
    >>> results = gt.read_results("results/fig03.h5")  # doctest: +SKIP
    >>> results.response.at(0.9)[0].rms  # doctest: +SKIP
    array([0.41033627, 0.71441951])
    """
    with Box() as box:
        box.read("results", file_name(path))
        case = Case._from(box)
        told = [
            f"{name.replace('_', ' ')} ended early: {in_own_unit(group.attributes['ended'], case.train)}"
            for name in ANALYSES
            if not (group := box.results().get(f"/{name}", Group())).attributes.get("complete", True)
        ]
        return case._results(box, "\n".join(told))


def _in_short(result: Any) -> str:
    """A result in a line."""
    count = len(result.natural_frequency) if isinstance(result, Modes) else 0
    words = f"{count} modes" if count else repr(result).strip("<>")
    frequency = np.ravel(getattr(result, "frequency", ()))
    if len(frequency) and np.isfinite(frequency).all():
        ends = f"{frequency.min():g} to {frequency.max():g}"
        train = getattr(result[0] if isinstance(result, list) else result, "train", None)
        words += f" ({ends} rpm)" if units_of(train, None).unit == "rpm" else f" (Lambda {ends})"
    return words.splitlines()[0]


def _others(kind: type[Case | Results]) -> list[str]:
    """Analyses that a class has no attribute for."""
    return [name for name in ANALYSES if name not in {item.name for item in fields(kind)}]
