"""Calls into Fortran: a box holds a case, what was computed, and fields on their way in or out; it is freed with its last use."""

from __future__ import annotations

import os
import threading
import weakref
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from math import prod
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

import geartrain._geartrain as fortran

from ..errors import InputError, SolverError, shown
from .namelist import in_words_of_the_call

__all__ = ["Box", "Group", "Words", "described", "file_name", "fortran", "one_blas_thread"]

Array = NDArray[Any]

# Now, while nothing else of this package computes.
fortran.blas_kernels()

_INPUT, _ENDED_EARLY, _FILE, _MEMORY = 2, 3, 4, 5


class _OneBlasThread:
    """While any work is under way OpenBLAS uses one thread; numpy may share it, and gets its threads back.

    Its threads wait for each other longer than they compute on matrices of a hundred rows, many times longer beside other work.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._under_way = 0
        self._before = 0

    def __enter__(self) -> None:
        with self._lock:
            if self._under_way == 0:
                self._before = fortran.blas_threads(1)
            self._under_way += 1

    def __exit__(self, *of_an_error: object) -> None:
        with self._lock:
            self._under_way -= 1
            if self._under_way == 0 and self._before > 1:
                fortran.blas_threads(self._before)


#: For every call that computes.
one_blas_thread = _OneBlasThread()


class Words(str):
    """A sentence of a result, with what it states as values.

    Attributes
    ----------
    places : ndarray
        Of each Lambda in it: from, to, its first and last letter (from 1).
    """

    places: Array


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
    told : dict of tuple
        Of each attribute its unit and what it is.
    """

    attributes: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, Array] = field(default_factory=dict)
    about: dict[str, tuple[tuple[str, ...], str, str]] = field(default_factory=dict)
    told: dict[str, tuple[str, str]] = field(default_factory=dict)

    def column(self, name: str, *shape: int) -> Array:
        """An array of a list; none of an empty one."""
        return self.arrays.get(name, np.zeros((0, *shape)))

    def values(self) -> dict[str, Any]:
        """Attributes and arrays by name, an array of texts as a tuple."""
        texts = {name: tuple(values) for name, values in self.arrays.items() if values.dtype.kind == "O"}
        return {**self.attributes, **self.arrays, **texts}

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
        if self._handle == 0:
            raise MemoryError("there is not enough memory to begin with, 160 MB: is there a limit (ulimit -v)?")
        # No code of Python runs when a closed box goes, as a finalizer would: Ctrl-C would be lost there.
        self._free = weakref.finalize(self, fortran.close_box, self._handle)
        self._free.atexit = False
        self._of_call = text is not None or copy is not None
        self._put = ""
        self._results: dict[str, Group] | None = None
        # A copy keeps the train of the other box, whose sizes are found once.
        self._copied = copy
        self._sizes: tuple[int, int] | None = None
        if text is None:
            return
        try:
            self.read("text", text.encode())
        except BaseException:
            self.close()
            raise

    def read(self, kind: str, text: bytes) -> None:
        """Read a case, and its results; ``kind`` tells what the text is, see ``read_input`` in border/analyses.f90."""
        self.check(fortran.read_input(self._handle, kind, text))

    def __enter__(self) -> Box:  # noqa: PYI034 (typing.Self needs Python 3.11)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Free what it holds; it is of no use then."""
        self._handle = 0
        self._free()

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
        kinds = {_INPUT: InputError, _ENDED_EARLY: SolverError, _FILE: OSError, _MEMORY: MemoryError}
        message = self.text("message")
        raise kinds.get(status, RuntimeError)(in_words_of_the_call(message) if self._of_call else message)

    def text(self, name: str) -> str:
        """A text of the box, see ``text_size`` in border/fields.f90."""
        size = fortran.text_size(self.handle, name)
        return fortran.copy_text(self._handle, size).tobytes().decode(errors="replace") if size else ""

    def report(self, verbose: bool) -> str:
        """The report of the box's case and results, without a newline at the end."""
        return self.text("verbose report" if verbose else "report").rstrip("\n")

    # ------------------------------------------------------------------------------------------------- out

    def show(self, what: str = "results") -> dict[str, Group]:
        """What the box holds as fields, by the paths of their groups; see ``show_fields`` in border/fields.f90."""
        self.check(fortran.show_fields(self.handle, what))
        groups: dict[str, Group] = {}
        for line, row in enumerate(self.text("fields").split("\n")[:-1], 1):
            path, name, kind, size, extents, dimensions, unit, description = row.split("\t")
            group = groups.get(path) or groups.setdefault(path, Group())
            names = tuple(dimensions.split())
            values = self._values(line, kind, int(size), tuple(map(int, extents.split()))[::-1])
            if not names:
                if name != "coordinates":  # which tells readers of the file alone something
                    group.attributes[name] = values.item()
                    group.told[name] = unit, description
                continue
            if names[-1] == "complex" and name != "complex":
                pairs, names = np.ascontiguousarray(values), names[:-1]
                values = pairs.view(np.complex128)[..., 0] if pairs.size else np.zeros(pairs.shape[:-1], complex)
            if name.endswith("_places"):
                sentence = name.removesuffix("_places")
                group.attributes[sentence] = Words(group.attributes[sentence])
                group.attributes[sentence].places = values
                continue
            group.arrays[name] = values
            group.about[name] = names, unit, description
        return groups

    def _values(self, line: int, kind: str, size: int, shape: tuple[int, ...]) -> Array:
        items = prod(shape)
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

    def read_off(self, what: str) -> Group:
        """A list read off the box's branch, see ``show_fields``."""
        return next(iter(self.show(what).values()), Group())

    def ended(self) -> str:
        """Why the response ended."""
        return str(self.results().get("/response", Group()).attributes.get("ended", ""))

    # -------------------------------------------------------------------------------------------------- in

    def ask(self, analyses: Mapping[str, Mapping[str, Any]]) -> None:
        """Make the case ask for analyses by the variables of their groups, as ``_namelist.values`` gives them."""
        for name, values in analyses.items():
            self._begin("variables")
            for variable, value in {"": 0, **values}.items():  # a value without a name makes the group where there is no other
                self._put_field(name, variable, np.asarray(value))
        self.take()

    def put(
        self, path: str, attributes: Mapping[str, Any], arrays: Mapping[str, Any], what: str = "results", like: str = ""
    ) -> None:
        """Put a group.

        Parameters
        ----------
        path : str
        attributes, arrays : mapping
            By the names of the fields; what is None is not there.
        what : str
            What the group becomes, see ``take_fields`` in border/fields.f90.
        like : str
            Path of a group of a results file that has the same dimensions, where it is not this one.
        """
        self._begin(what)
        about = described()[like or path].about
        lengths: dict[str, int] = {}
        for name, value in attributes.items():
            if value is not None:
                self._put_field(path, name, np.asarray(value))
            if isinstance(value, Words):
                self._put_field(path, f"{name}_places", value.places)
        for name, value in arrays.items():
            if value is not None:
                self._put_field(path, name, np.asarray(value))
                lengths.update(zip(about[name][0], np.shape(value)))
        for name in lengths.keys() & about.keys() - arrays.keys():
            if about[name][1]:  # a dimension whose places are numbered, not named
                self._put_field(path, name, np.arange(1, lengths[name] + 1, dtype=np.intc))

    def _begin(self, what: str) -> None:
        if self._put != what:
            self.take()
        self._put = what
        self._results = None

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
        if self._copied is not None:
            return self._copied.sizes()
        if self._sizes is None:
            meshes, states = map(int, fortran.train_sizes(self._handle))
            self._sizes = meshes, states
        return self._sizes

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the results as a file."""
        self.check(fortran.write_path(self.handle, file_name(path)))

    def write_bytes(self, path: str | os.PathLike[str], content: bytes) -> None:
        """Write a file beside and rename it: at any moment there is the whole old file or the whole new one."""
        self.check(fortran.write_bytes(self._handle, file_name(path), np.frombuffer(content, np.int8)))

    # ------------------------------------------------------------------------------------------------ work

    def run(self, name: str, progress: Array) -> int:
        """Run an analysis that the case asks for; the status."""
        with one_blas_thread:
            status: int = fortran.run_analysis(self.handle, name, progress)
        return status

    def work(self, what: str, progress: Array, *values: float) -> int:
        """Work on the box's branch or motion, see ``work`` in box.f90; the status."""
        with one_blas_thread:
            status: int = fortran.do_work(self.handle, what, np.array(values or (0,), float), progress)
        return status

    def gradient(self, what: str, names: str, progress: Array, number: int, frequency: float, coefficients: Array) -> None:
        """Differentiate with respect to parameters, see ``differentiate`` in box.f90."""
        place = (self.handle, what, names.encode(), number, frequency)
        with one_blas_thread:
            status = fortran.find_gradient(*place, np.asfortranarray(coefficients.T, float), progress)
        self.check(status)


@cache
def described() -> dict[str, Group]:
    """All fields of a results file, without values."""
    with Box() as box:
        return box.show("listing")


def file_name(path: str | os.PathLike[str]) -> bytes:
    """The path as Fortran wants it."""
    try:
        name = os.fsencode(path)
    except (TypeError, UnicodeEncodeError):
        raise InputError(f"path = {shown(path)}: must be the path of a file") from None
    if b"\0" in name or not name:
        raise InputError(f"path = {shown(path)}: must be the path of a file, which is not empty and has no character 0")
    return name
