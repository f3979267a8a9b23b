"""What a study computes: the point's train and call by its number, and its key; as a file and back."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import blake2b
from itertools import islice, repeat
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box
from .._core.namelist import parse
from .._core.parameter import Target, add_targets, assigned, check_effects, checked_column, own_value, targets_of
from .._core.sealed import DamagedError, distrust, seal, unseal
from ..errors import DrawingWarning, InputError, shown
from ..train import Train
from ..variables import PARTS
from .quantity import Quantity, taken
from .space import Axis, Space

__all__ = ["CALLS", "Plan", "is_key"]

#: Of the records of points: what is written by another version is not taken for done.
_RESULTS_VERSION = 2

#: Calls of a train whose results can be kept.
CALLS = (
    "response", "continuation", "integrate", "sweep", "attractors", "basins", "bifurcation_diagram", "lyapunov_spectrum", "motions",
    "stability_map", "campbell", "run_up", "modes",
)

_LONGEST = 200  # characters of the values of a point in a message
_TRIED = 20  # points among which one is allowed, as a rule

with Box() as _opened:
    _PROGRAM = _opened.text("version")


@dataclass(frozen=True, eq=False)
class Plan:
    """A study as its processes know it.

    Attributes
    ----------
    case : str
        The train as a case file's text.
    call : str
        The call of the train, ``'response'``.
    settings : mapping
        All its keywords.
    keep : tuple of str
    axes : tuple of Axis
        Those of the space.
    relative : mapping
        By parameters, whether their values are multiples of the train's own.
    targets : tuple of Target
    columns : tuple of ndarray, (points,)
        The values of the targets at every point.
    keys : ndarray of bytes, (points,)
        Of each point a hash of its resolved case, its call with all keywords, what is kept, and the version of the results.
    batch : int
        Points that are computed in one go.
    seconds : float
        Expected of a point.
    """

    case: str
    call: str
    settings: Mapping[str, Any]
    keep: tuple[str, ...]
    axes: tuple[Axis, ...]
    relative: Mapping[str, bool]
    targets: tuple[Target, ...]
    columns: tuple[NDArray[Any], ...]
    keys: NDArray[np.bytes_]
    batch: int = 1
    seconds: float = 1.0

    @classmethod
    def of(cls, train: Train, space: Space, call: str, settings: Mapping[str, Any], keep: Sequence[str]) -> Plan:
        """The plan of a study; an error where a name or the type of a value is not right."""
        try:
            settings = json.loads(json.dumps(settings, default=_plain))
        except TypeError as error:
            raise InputError(f"{call}: {error}: a study takes numbers, texts and lists of them") from None
        targets: list[Target] = []
        columns = []
        for name, values in space.columns().items():
            found = targets_of(name, train, call, settings, space.relative[name])
            add_targets(name, found, targets)
            columns += [checked_column(target, values) for target in found]
        _check_effects(train, settings, targets, columns)
        keys = _keys(train, call, settings, keep, targets, columns)
        text = train.namelist()
        return cls(text, call, settings, tuple(keep), space.axes, space.relative, tuple(targets), tuple(columns), keys)

    def __len__(self) -> int:
        return len(self.keys)

    @cached_property
    def train(self) -> Train:
        """The train with its own values."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DrawingWarning)  # told when the train was made
            return Train._of(parse(self.case))

    @cached_property
    def digest(self) -> str:
        """Of all that tells this plan from another."""
        axes = b"".join(values.tobytes() for axis in self.axes for values in axis.columns.values())
        return _hash(self._about(0, 0).encode() + self.keys.tobytes() + axes)

    @cached_property
    def distinct(self) -> NDArray[np.intp]:
        """The points without those that have the key of one before them, ascending."""
        return np.sort(np.unique(self.keys, return_index=True)[1])

    @cached_property
    def known(self) -> set[bytes]:
        """The keys."""
        return set(self.keys.tolist())

    @cached_property
    def _values(self) -> dict[str, NDArray[Any]]:
        return Space.of(self.axes, self.relative).columns()

    def told(self, point: int) -> str:
        """The point in words, with the values of its parameters."""
        items = ((name, column[point].item()) for name, column in self._values.items())
        values = ", ".join(f"{name} = {value:.6g}" if isinstance(value, float) else f"{name} = {value}" for name, value in items)
        return f"point {point} ({values if len(values) <= _LONGEST else values[: _LONGEST - 3] + '...'})"

    @property
    def blocks(self) -> int:
        """Number of batches."""
        return -(-len(self.distinct) // self.batch)

    def block(self, number: int) -> list[int]:
        """The points of a batch."""
        points: list[int] = self.distinct[number * self.batch : (number + 1) * self.batch].tolist()
        return points

    def key(self, point: int) -> bytes:
        """Of a point."""
        return bytes(self.keys[point])

    def result(self, point: int) -> Any:
        """What the call gives at a point."""
        train, settings = assigned(self.train, self.settings, self.targets, [column[point].item() for column in self.columns])
        return getattr(train, self.call)(**settings)

    def compute(self, point: int) -> dict[str, Quantity]:
        """What is kept of it."""
        return taken(self.result(point), self.keep)

    # -------------------------------------------------------------------------------------------- as a file

    def _about(self, batch: int, seconds: float) -> str:
        about = {
            "program": _PROGRAM, "case": self.case, "call": self.call, "settings": self.settings, "keep": self.keep,
            "axes": [[axis.name, list(axis.columns)] for axis in self.axes], "relative": self.relative,
            "targets": self.targets, "batch": batch, "seconds": seconds,
        }
        return json.dumps(about)

    def dump(self) -> bytes:
        """As the bytes of a file."""
        axes: dict[str, Any] = {f"axis {name}": values for axis in self.axes for name, values in axis.columns.items()}
        columns: dict[str, Any] = {f"column {number}": column for number, column in enumerate(self.columns)}
        return seal({"about": np.array(self._about(self.batch, self.seconds)), "keys": self.keys, **axes, **columns})

    @classmethod
    def load(cls, text: bytes) -> Plan:
        """Read the bytes that `dump` wrote; `DamagedError` where they hold no plan."""
        file = unseal(text)
        with distrust():
            about = json.loads(file["about"].item())
            axes = tuple(Axis(name, {item: file[f"axis {item}"] for item in names}) for name, names in about["axes"])
            targets = tuple(Target(*row) for row in about["targets"])
            columns = tuple(file[f"column {number}"] for number in range(len(targets)))
            plan = cls(str(about["case"]), str(about["call"]), dict(about["settings"]), tuple(about["keep"]), axes,
                       dict(about["relative"]), targets, columns, file["keys"], int(about["batch"]), float(about["seconds"]))
            for point, key in enumerate(plan.keys.tolist()):
                if not is_key(key):  # keys are names of files
                    raise DamagedError(f"key {point} = {shown(key)}: must be 32 digits of 0-9a-f")
            if plan.call not in CALLS:
                raise DamagedError(f"call = {shown(plan.call)}: must be one of {', '.join(CALLS)}")
            if plan.batch < 1 or any(len(column) != len(plan) for column in columns) or prod(map(len, axes)) != len(plan):
                raise DamagedError("the lists differ in length")
            _ = plan.train
        return plan

    def in_batches_of(self, points: int, seconds: float) -> Plan:
        """The same, with so many points computed in one go, each in so many seconds."""
        return replace(self, batch=points, seconds=seconds)


def is_key(key: bytes) -> bool:
    """Whether it may be a key of a point."""
    return re.fullmatch(rb"[0-9a-f]{32}", key) is not None


def _check_effects(
    train: Train, settings: Mapping[str, Any], targets: Sequence[Target], columns: Sequence[NDArray[Any]]
) -> None:
    """Refuse parameters without effect, by the first point that is allowed."""
    for values in islice(zip(*columns), _TRIED):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DrawingWarning)
            try:
                first = assigned(train, settings, targets, [value.item() for value in values])[0]
            except InputError:  # told where the point is computed
                continue
        check_effects(first, targets)
        return


def _plain(value: Any) -> Any:
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(shown(value))


def _hash(text: bytes) -> str:
    return blake2b(text, digest_size=16).hexdigest()


def _keys(
    train: Train, call: str, settings: Mapping[str, Any], keep: Sequence[str], targets: Sequence[Target],
    columns: Sequence[NDArray[Any]],
) -> NDArray[np.bytes_]:
    """Hashes of a text with the values of each point in the places of the targets."""
    with Box(train.namelist()) as box:
        groups = parse(box.text("case"))
    case: dict[str, dict[str, Any]] = {call: dict(settings)}
    numbers = dict.fromkeys(PARTS, 0)
    for name, values in groups:
        numbers[name] = numbers.get(name, 0) + 1
        case[f"{name} {numbers[name]}" if name in PARTS else name] = {key: value for key, value in values.items() if key != "title"}
    for number, target in enumerate(targets):
        known, hole = case[target.place], f"\0{number}\0"
        if target.element:
            # Of the values as they are given: the resolved case may write fewer.
            series = known.get(target.variable)
            if not isinstance(series, list) or len(series) < target.element:
                series = known[target.variable] = list(own_value(target, train, settings))
            series[target.element - 1] = hole
        else:
            known[target.variable] = hole
    about = json.dumps([_RESULTS_VERSION, _PROGRAM, call, list(keep), case], sort_keys=True)
    holes = sorted(range(len(targets)), key=lambda number: about.index(json.dumps(f"\0{number}\0")))
    rest = about
    texts: list[Iterable[str]] = []
    for number in holes:
        before, _, rest = rest.partition(json.dumps(f"\0{number}\0"))
        texts += [repeat(before), map(json.dumps, columns[number].tolist())]
    rows = zip(*texts, repeat(rest)) if holes else repeat((rest,), 1)
    return np.array([_hash("".join(row).encode()) for row in rows], "S32")
