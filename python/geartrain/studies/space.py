"""The points of a study: which parameters vary, and what values they have."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core.extras import extra
from .._core.parameter import label
from ..errors import InputError, shown

if TYPE_CHECKING:
    from pandas import DataFrame

__all__ = ["Axis", "Space"]

Name = str | tuple[str, ...]


@dataclass(frozen=True)
class Axis:
    """Parameters that go together along a dimension, and their values there."""

    name: str
    columns: Mapping[str, NDArray[Any]]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))


class Space:
    """Points of a study: values of parameters, which are named as in a case, ``"mesh 2 half_backlash"``.

    A name is a variable of ``&train``; ``mesh``, ``shaft`` or ``body``, a number or ``*`` for all, and a variable; a body's own
    name and a variable; ``stiffness_variation``; the analysis and a variable of it, ``"response harmonics"``. A tuple of names
    stands for parameters that take the same value. Spaces multiply: ``space * other`` has every point of one with every point of
    the other.

    Parameters
    ----------
    product : mapping, optional
        Values by names: every combination is a point.
    sample : DataFrame, mapping or array, optional
        A point a row, a column a parameter.
    names : sequence of str, optional
        Those of the columns of an array.
    distributions : mapping, optional
        Distributions of ``scipy.stats`` by names, all drawn together; needs SciPy.
    samples : int, optional
        How many points to draw from the distributions.
    method : {'random', 'sobol', 'latin hypercube'}
        How: independently, or by a scrambled design of ``scipy.stats.qmc``.
    random_seed : int
        The same seed draws the same points.
    relative : bool
        Values are multiples of the train's own: ``"mesh * stiffness"`` of 0.9 is each mesh's stiffness less 10 %.

    Attributes
    ----------
    axes : tuple of Axis
        The dimensions, each with the parameters that go along it.
    relative : dict
        By parameters, whether values are multiples of the train's own.
    distributions : dict
        By parameters.

    Examples
    --------
    >>> space = gt.Space({"input_torque": [50.0, 100.0, 150.0], "mesh 2 half_backlash": np.linspace(10e-6, 60e-6, 11)})
    >>> space
    <Space of 33 points: input_torque (3) x mesh 2 half_backlash (11)>
    >>> from scipy.stats import uniform
    >>> gt.Space(distributions={"mesh * stiffness": uniform(0.9, 0.2)}, samples=64, method="sobol", relative=True)
    <Space of 64 points: sample (64) of mesh * stiffness, relative>
    """

    def __init__(
        self,
        product: Mapping[Name, ArrayLike] | None = None,
        *,
        sample: DataFrame | Mapping[Name, ArrayLike] | ArrayLike | None = None,
        names: Sequence[Name] | None = None,
        distributions: Mapping[Name, Any] | None = None,
        samples: int | None = None,
        method: str = "random",
        random_seed: int = 0,
        relative: bool = False,
    ) -> None:
        axes = []
        for name, values in (product or {}).items():
            if hasattr(values, "ppf") or hasattr(values, "icdf"):
                raise InputError(f"parameter {label(name)!r}: a distribution: give it in distributions={{...}}, with samples=")
            axes.append(Axis(label(name), {label(name): _column(label(name), values)}))
        self.distributions: dict[str, Any] = {label(name): value for name, value in (distributions or {}).items()}
        if sample is not None and self.distributions:
            raise InputError("sample and distributions: give one of the two, and multiply spaces: Space(...) * Space(...)")
        if sample is not None:
            axes.append(_axis(_columns(sample, names)))
        if self.distributions:
            axes.append(_axis(_drawn(self.distributions, samples, method, random_seed)))
        if not axes:
            raise InputError("a space has values of at least one parameter: product, sample or distributions")
        self._set(axes, {name: relative for axis in axes for name in axis.columns})

    @classmethod
    def of(cls, axes: Sequence[Axis], relative: Mapping[str, bool]) -> Space:
        """The space of these axes."""
        found = object.__new__(cls)
        found.distributions = {}
        found._set(axes, relative)
        return found

    def _set(self, axes: Sequence[Axis], relative: Mapping[str, bool]) -> None:
        names = [name for axis in axes for name in axis.columns]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"parameter {name!r}: is given twice")
        self.axes = tuple(axes)
        self.relative = dict(relative)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names; several that take the same value are one, separated by commas."""
        return tuple(name for axis in self.axes for name in axis.columns)

    @property
    def shape(self) -> tuple[int, ...]:
        """Points along each axis."""
        return tuple(map(len, self.axes))

    def __len__(self) -> int:
        return math.prod(self.shape)

    def columns(self) -> dict[str, NDArray[Any]]:
        """The value of each parameter at every point, the last axis the fastest."""
        places = np.indices(self.shape).reshape(len(self.axes), -1)
        return {name: values[place] for axis, place in zip(self.axes, places) for name, values in axis.columns.items()}

    def with_sample(self, sample: ArrayLike) -> Space:
        """The same parameters with other values, a point a row, a parameter a column."""
        table = np.asarray(sample)
        if table.ndim != 2 or table.shape[1] != len(self.parameters):
            columns = f"{len(self.parameters)} columns, {', '.join(self.parameters)}"
            raise InputError(f"sample: of shape {table.shape}: must have {columns}")
        found = Space(sample=dict(zip(self.parameters, table.T)))
        found.relative = self.relative
        return found

    def __mul__(self, other: Space) -> Space:
        taken = {axis.name for axis in self.axes}
        renamed = [Axis(f"{axis.name} 2", axis.columns) if axis.name in taken else axis for axis in other.axes]
        found = Space.of((*self.axes, *renamed), {**self.relative, **other.relative})
        found.distributions = {**self.distributions, **other.distributions}
        return found

    def __repr__(self) -> str:
        told = (
            f"{axis.name} ({len(axis)})" + ("" if {*axis.columns} == {axis.name} else f" of {', '.join(axis.columns)}")
            for axis in self.axes
        )
        return f"<Space of {len(self)} points: {' x '.join(told)}{', relative' if any(self.relative.values()) else ''}>"


def _axis(columns: Mapping[str, NDArray[Any]]) -> Axis:
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) != 1:
        raise InputError(f"sample: columns of different lengths: {lengths}" if lengths else "sample: has no columns")
    return Axis("sample", columns)


def _columns(sample: Any, names: Sequence[Name] | None) -> dict[str, NDArray[Any]]:
    if isinstance(sample, Mapping) or hasattr(sample, "columns"):
        if names is not None:
            raise InputError("names: the columns of the sample have names of their own")
        own = list(sample if isinstance(sample, Mapping) else sample.columns)
        unnamed = [str(name) for name in own if str(name).startswith("Unnamed: ")]  # as pandas calls them
        if unnamed:
            raise InputError(f"sample: column {unnamed[0]!r} has no name: an index, which to_csv(..., index=False) leaves out and "
                             "read_csv(..., index_col=0) takes?")
        if own and not len(sample[own[0]]):
            raise InputError("sample: has no rows")
        return {label(name): _column(label(name), sample[name]) for name in own}
    table = np.asarray(sample)
    if names is None or table.ndim != 2 or table.shape[1] != len(names):
        raise InputError(f"sample: an array of shape {table.shape}: must be (points, parameters), with names= of the parameters")
    return {label(name): _column(label(name), table[:, place]) for place, name in enumerate(names)}


def _column(name: str, values: Any) -> NDArray[Any]:
    column = np.atleast_1d(np.asarray(values))
    if not column.size:
        raise InputError(f"parameter {name!r}: has no values: must be a list of numbers or of texts")
    if column.dtype.kind == "O":
        column = np.array(column.tolist())
    if column.ndim != 1 or not len(column) or column.dtype.kind not in "biufU":
        raise InputError(f"parameter {name!r}: {shown(values)}: must be a list of numbers or of texts")
    if column.dtype.kind == "f" and not np.isfinite(column).all():
        wrong = np.flatnonzero(~np.isfinite(column))
        more = f", nor are {len(wrong) - 1} more" if len(wrong) > 1 else ""
        raise InputError(f"parameter {name!r}: value {wrong[0]}, counted from 0, is not finite{more}")
    return column


def _drawn(distributions: Mapping[str, Any], samples: int | None, method: str, random_seed: int) -> dict[str, NDArray[Any]]:
    """Values of the distributions: their quantiles at points of the unit cube."""
    if samples is None or isinstance(samples, bool) or samples < 1:
        raise InputError(f"samples = {shown(samples)}: must be the number of points to draw from the distributions")
    generator = np.random.default_rng(random_seed)
    size = len(distributions)
    if method == "random":
        cube = generator.random((samples, size))
    elif method in ("sobol", "latin hypercube"):
        qmc = extra("scipy.stats.qmc")
        engine = qmc.Sobol if method == "sobol" else qmc.LatinHypercube
        cube = engine(size, rng=generator).random(samples)
    else:
        raise InputError(f"method = {shown(method)}: must be 'random', 'sobol' or 'latin hypercube'")
    found = {}
    for place, (name, distribution) in enumerate(distributions.items()):
        quantile = getattr(distribution, "ppf", None) or getattr(distribution, "icdf", None)
        if quantile is None:
            raise InputError(f"parameter {name!r}: {shown(distribution)}: must be a distribution of scipy.stats")
        found[name] = _column(name, quantile(cube[:, place]))
    return found
