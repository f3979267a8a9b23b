"""A train as it is described, and that as the text of a case file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import zip_longest
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DrawingWarning, InputError, shown
from ..variables import PARTS, VARIABLES, Body, Mesh, TrainVariables
from .box import Box
from .explanation import Explanation
from .namelist import group, in_words_of_the_call, parse, values
from .variable import Part, refuse_unknown
from .warn import warn

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from ..variables import Analyses

__all__ = [
    "Description", "bearings_of", "contact_words", "corners", "element_name", "half_gaps", "is_of_ring", "load_signs",
    "part_labels", "part_names",
]


class Description(TrainVariables):
    """A train as it is described: what results know of their train, and `Train` is beside what can be asked of it."""

    def __post_init__(self) -> None:
        for name, kind in PARTS.values():
            parts = getattr(self, name)
            if not isinstance(parts, Sequence) or not all(isinstance(part, kind) for part in parts):
                raise InputError(f"{name} = {shown(parts)}: must be a list of gt.{kind.__name__}")
            object.__setattr__(self, name, tuple(parts))
        super().__post_init__()
        if self.planetaries:
            self._expand()
        for told in self.warnings:  # which checks the train
            warn(told, DrawingWarning)

    def __repr__(self) -> str:
        parts = ((self.body_labels, "body", "bodies"), (self.shaft_labels, "shaft", "shafts"),
                 (self.couplings, "coupling", "couplings"), (self.bearings, "bearing", "bearings"), (self.meshes, "mesh", "meshes"))
        counts = [f"{len(part)} {word if len(part) == 1 else plural}" for part, word, plural in parts if part]
        orders = ", ".join(str(order) for order in sorted({int(order) for order in self._outline["order"][:len(self.meshes)]}))
        of_order = f" of order {orders}" if orders else ""
        title = f" {self.title!r}" if self.title else ""
        return f"<{type(self).__name__}{title}: {', '.join(counts)}{of_order}>"

    def _expand(self) -> None:
        """Put bodies and meshes in the place of the planetary sets, as Fortran expands them in a case file."""
        with Box(self.namelist()) as box:
            groups = parse(box.text("case"))
        found: dict[str, list[dict[str, Any]]] = {name: [] for name in ("body", "mesh")}
        for name, variables in groups:
            if name in found:
                given = {key: value for key, value in variables.items() if value != VARIABLES[name][key].default}
                found[name].append(given)
        carried = (replace(body, added_inertia=given.get("added_inertia")) for body, given in zip(self.bodies, found["body"]))
        bodies = [*carried, *(Body(**given) for given in found["body"][len(self.bodies):])]
        placed = (replace(mesh, phase=given.get("phase")) if mesh.phase in (None, 0.0) else mesh
                  for mesh, given in zip(self.meshes, found["mesh"]))
        meshes = [*placed, *(Mesh(**given) for given in found["mesh"][len(self.meshes):])]
        for name, parts in (("bodies", bodies), ("meshes", meshes), ("planetaries", ())):
            object.__setattr__(self, name, tuple(parts))

    def namelist(self, **analyses: Unpack[Analyses]) -> str:
        """The train, and the analyses wanted, as a case file's text.

        Parameters
        ----------
        modes : bool
        response, integration, attractors, basins, bifurcation_diagram, stability_map, run_up : mapping, optional
            The variables of the group by their names or by their keywords, hence ``start`` as well as ``from``.
        """
        problems: dict[str, str] = {}
        text = group("train", VARIABLES["train"], self._values(self), problems)
        for name, number, part in self._parts():
            text += group(name, VARIABLES[name], self._values(part), problems, f"&{name} {number}")
        refuse_unknown("namelist", analyses, list(VARIABLES))
        for name, settings in analyses.items():
            if settings is not None and settings is not False:
                text += group(name, VARIABLES[name], settings if isinstance(settings, Mapping) else {}, problems)
        if problems:
            raise InputError("\n".join([*problems.values(), *_further_problems(text, problems)]))
        return text

    def _parts(self) -> Iterator[tuple[str, int, Part]]:
        """The parts with their groups and numbers: shafts and meshes by turns, as they stand in a chain, after all others."""
        lists = {name: [(name, number, part) for number, part in enumerate(getattr(self, parts), 1)]
                 for name, (parts, _) in PARTS.items()}
        chain = zip_longest(lists.pop("shaft"), lists.pop("mesh"))
        for parts in (*lists.values(), *chain):
            yield from (item for item in parts if item is not None)

    @staticmethod
    def _values(part: Part) -> dict[str, Any]:
        return {name: getattr(part, name) for name in part.variables}

    @property
    def mesh_labels(self) -> tuple[str, ...]:
        """Names of meshes, then couplings, by the bodies that they join, ``'pinion - wheel'``; ``'mesh 1'``, ... in a chain.

        Then those of bearings, ``'pinion bearing x'``.
        """
        return tuple(self._outline["mesh"])

    @property
    def mesh_elements(self) -> tuple[str, ...]:
        """What the places along the dimension ``mesh`` of results are: ``'mesh 1'``, ``'coupling 1'``, ``'bearing 1 x'``, ...

        A bearing with more than four flats has further directions, by their angles from the x axis: ``'bearing 1 22.5'``.
        """
        return (*(f"mesh {number}" for number in range(1, len(self.meshes) + 1)),
                *(f"coupling {number}" for number in range(1, len(self.couplings) + 1)),
                *(f"bearing {number} {axis}" for number in range(1, len(self.bearings) + 1) for axis in "xy"),
                *(f"bearing {number + 1} {angle:g}" for number, angle in _further_rows(self)))

    @property
    def shaft_labels(self) -> tuple[str, ...]:
        """Names of the shafts by the bodies that they join, ``'motor - pinion'``; ``'shaft 1'``, ... in a chain."""
        return tuple(self._outline["shaft"])

    @property
    def planet_labels(self) -> tuple[str, ...]:
        """Names of the planets of all planetary sets, set by set, in the order of ``load_share``."""
        return tuple(self._outline["planet"])

    @property
    def body_labels(self) -> tuple[str, ...]:
        """Names of the bodies; ``'driving end'``, ``'driving gear 1'``, ``'driven gear 1'``, ..., ``'driven end'`` in a chain."""
        return tuple(self._outline["body"])

    @property
    def speed_name(self) -> str:
        """Name of the body whose revolutions are the speed."""
        return self.speed_of or self.body_labels[0]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What deserves a second look: formulas of the drawing outside their range, modes of hardly any damping, a line each."""
        with Box(copy=self._kept) as box:
            return tuple(box.text("warnings").splitlines())

    def explain(self) -> Explanation:
        """Every number of the train, derived from the drawing or given, with its formula and source.

        Returns
        -------
        Explanation
            A mapping of mappings; printed it is the text of ``geartrain --explain``.

        Examples
        --------
        >>> train.explain()["mesh 1"]["stiffness_cos"]
        array([0.3])
        """
        with Box(copy=self._kept) as box:
            return Explanation._of(box)

    @cached_property
    def _outline(self) -> dict[str, Any]:
        """Names of bodies, meshes and shafts, orders of the meshes, characteristic length, and what Lambda = 1 is in rpm and Hz."""
        with Box(copy=self._kept) as box:
            return box.show("train")["/train"].values()

    @cached_property
    def _kept(self) -> Box:
        """A box of the train, which stays as it is: the train is read but once."""
        return Box(self.namelist())

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_kept"}

    def _ask(self, **analyses: Mapping[str, Any] | None) -> Box:
        """A box of the train that asks for analyses by their variables, as `namelist` takes them; it may be changed."""
        problems: dict[str, str] = {}
        asked = {
            name: values(name, VARIABLES[name], settings, problems)
            for name, settings in analyses.items() if settings is not None
        }
        box = Box(copy=self._kept)
        try:
            box.ask(asked)
        except InputError as error:
            if not problems:
                raise
            raise InputError("\n".join([*problems.values(), *_others(error, problems)])) from None
        if problems:
            raise InputError("\n".join(problems.values()))
        return box

    def _ask_at(self, frequency: float, settings: Mapping[str, Any]) -> Box:
        """A box that asks for integration at one frequency, which is both ends of the range."""
        if isinstance(frequency, bool) or not isinstance(frequency, Real):
            raise InputError(f"frequency = {shown(frequency)}: must be a number")
        try:
            return self._ask(integration={"start": frequency, "stop": frequency, "points": 1, **settings})
        except InputError as error:
            told = in_words_of_the_call(str(error), {"start": "frequency", "stop": "frequency"})
            raise InputError("\n".join(dict.fromkeys(told.splitlines()))) from None


def bearings_of(force: NDArray[np.float64], train: Description | None) -> NDArray[np.float64]:
    """Forces of bearings, (samples, bearings, 2), of the forces of meshes, couplings and bearings, (samples, meshes)."""
    rows = _further_rows(train) if train is not None else []
    bearings = len(train.bearings) if train is not None else 0
    last = force.shape[1] - len(rows)
    found = force[:, last - 2 * bearings:last].reshape(len(force), bearings, 2).copy()
    for column, (bearing, angle) in enumerate(rows, last):
        found[:, bearing] += force[:, column, np.newaxis] * [np.cos(np.radians(angle)), np.sin(np.radians(angle))]
    return found


def _further_rows(train: Description) -> list[tuple[int, float]]:
    """Directions of bearings beside x and y, [degree] from the x axis, each with the place of its bearing."""
    flats = [int(bearing.flats or 4) for bearing in train.bearings]
    return [(bearing, 360.0 * row / number) for bearing, number in enumerate(flats)
            for row in range(1, number // 2) if row != number // 4]


def half_gaps(train: Description) -> NDArray[np.float64]:
    """Half of the backlash, play or clearance of what stands along the dimension ``mesh``, over the characteristic length."""
    numbers, groups = train.explain(), _groups_of(train)
    # The displacement of a coupling is 1 um for 1 mrad.
    half = [about.get("half_backlash", about.get("half_clearance", 1e-3 * about.get("half_play", 0.0))) for about in groups]
    gaps: NDArray[np.float64] = np.array(half) / numbers["train"]["characteristic_length"]
    return gaps


def corners(train: Description) -> list[NDArray[np.float64]]:
    """Displacements over the characteristic length at which the slope of each force changes, ascending, as of `half_gaps`."""
    length, found = train.explain()["train"]["characteristic_length"], []
    for about, half in zip(_groups_of(train), half_gaps(train)):
        if "corners" in about:
            found.append(1e-3 * np.ravel(about["corners"]) / length)
            continue
        beyond = half + np.concatenate([[0.0], np.ravel(about.get("stage_wall", []))]) / length
        # Without a gap both flanks are one.
        found.append(np.concatenate([-beyond[::-1], beyond]) if half > 0 else beyond[1:])
    return found


def load_signs(train: Description) -> list[int]:
    """Sign of the mean force of what stands along the dimension ``mesh``; 0 where there is none."""
    signs = []
    for element, about in zip(train.mesh_elements, _groups_of(train)):
        mean = np.ravel(about.get("mean_force", about.get("mean_torque", 0.0)))
        axis = element.split()[2:]
        if axis:  # of a bearing
            known = {"x": (1.0, 0.0), "y": (0.0, 1.0)}
            angle = 0.0 if axis[0] in known else np.radians(float(axis[0]))
            mean = np.array([mean @ known.get(axis[0], (np.cos(angle), np.sin(angle)))])
        signs.append(int(np.sign(mean[0])))
    return signs


def contact_words(train: Description | None, places: Iterable[int], what: str) -> dict[int, str]:
    """What is said of ranges without contact, ``'separation'``, or with contact on the other side, ``'back collision'``.

    By the places along the dimension ``mesh`` of which there is something to say: what couplings and bearings bear on the negative
    side by their mean load is no collision.
    """
    known = {"separation": ("teeth separate", "contact is lost"), "back collision": ("back flanks collide", "other side hits")}
    words = known[what]
    if not isinstance(train, Description):
        return {place: words[0] for place in places}
    signs, first = load_signs(train), len(train.meshes)
    return {place: words[place >= first] for place in places if place < first or what == "separation" or signs[place] >= 0}


def element_name(train: Description | None, place: int) -> str:
    """What stands at a place along the dimension ``mesh``, counted from 0: ``'coupling 1'``; without a train a mesh."""
    return train.mesh_elements[place] if isinstance(train, Description) else f"mesh {place + 1}"


def _groups_of(train: Description) -> list[Mapping[str, Any]]:
    """The numbers of what stands along the dimension ``mesh``."""
    numbers = train.explain()
    return [numbers[" ".join(element.split()[:2])] for element in train.mesh_elements]


def is_of_ring(train: Description, place: int) -> bool:
    """Whether a bearing with more than four flats stands at a place along the dimension ``mesh``."""
    kind, number, *_ = train.mesh_elements[place].split()
    return kind == "bearing" and int(train.bearings[int(number) - 1].flats or 4) > 4


def part_names(train: Description | None, along: str, number: int) -> tuple[str, ...]:
    """What the places along a dimension are called: their numbers without a train, or where it has not so many.

    ``along`` is ``'mesh'``, ``'shaft'``, ``'held'``, ``'planet'``, ``'coupling'``, ``'bearing'``, or ``'bearing axis'`` for the
    directions of all bearings.
    """
    labels: Sequence[str] = ()
    if isinstance(train, Description):
        first = len(train.meshes) + len(train.couplings)
        labels = {
            "mesh": train.mesh_labels,
            "shaft": train.shaft_labels,
            "held": tuple(body.name or f"body {number}" for number, body in enumerate(train.bodies or (), 1) if body.held),
            "planet": train.planet_labels,
            "coupling": train.mesh_labels[len(train.meshes):first],
            "bearing": tuple(bearing.body or "" for bearing in train.bearings),
            "bearing axis": train.mesh_labels[first:first + 2 * len(train.bearings)],
        }[along]
    return tuple(labels) if len(labels) == number else tuple(f"{along} {place}" for place in range(1, number + 1))


#: A field that every result with a dimension has.
_ALONG = {"mesh": "rms", "shaft": "shaft_torque_mean", "held": "reaction_torque_mean", "planet": "load_share",
          "coupling": "coupling_torque_mean", "bearing": "bearing_force_mean"}


def part_labels(train: Description | None, fields: Mapping[str, Any]) -> dict[str, tuple[str, ...]]:
    """Names along the dimensions of fields of motions, (motions, parts), as the fields ``mesh_label``, ... of a results file."""
    there = {along: fields[name] for along, name in _ALONG.items() if fields.get(name) is not None and len(fields[name])}
    return {f"{along}_label": part_names(train, along, np.shape(values)[1]) for along, values in there.items()}


def _further_problems(text: str, known: Mapping[str, str]) -> list[str]:
    """What Fortran says of the other values."""
    try:
        with Box(text):
            return []
    except InputError as error:
        return _others(error, known)


def _others(error: InputError, known: Mapping[str, str]) -> list[str]:
    """Problems that do not follow from the lack of those values whose problems are known."""
    return [line for line in str(error).splitlines() if not any(_follows(line, name) for name in known)]


def _follows(line: str, name: str) -> bool:
    """Whether the problem comes of the lack of a variable, ``&mesh 2: stiffness``, and is not one of its namesake elsewhere."""
    place, _, variable = name.rpartition(": ")
    if not re.search(rf"\b{variable}\b", line):
        return False
    return line.startswith(f"{place}:") or f": {variable} = " not in line
