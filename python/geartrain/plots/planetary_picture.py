"""A planetary stage as a picture: front view with the planets at their angles, and lever diagram of the speeds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description
from ..errors import InputError, shown
from .draw import COLORS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["STAGE_RATIOS", "STAGE_SIZE", "draw_stage", "planet_angles", "stages_of"]

Array = NDArray[np.float64]

#: Width and height of a picture [inches]; widths of front view and lever diagram to each other.
STAGE_SIZE, STAGE_RATIOS = (8.5, 4.6), (1.2, 1.0)

_MOST_TEETH = 400  # drawn as ticks


def stages_of(train: Description) -> dict[str, Mapping[str, Any]]:
    """What `Description.explain` has of the planetary sets, by their names."""
    return {name: told for name, told in train.explain().items() if "planets" in told and "carrier" in told}


def planet_angles(told: Mapping[str, Any], teeth: int) -> Array:
    """Angles of the planets from the first one [turns], in the sense in which the sun turns seen from the carrier.

    They are those nearest to equal spacing that have the phases of the meshes. ``told`` has the numbers of the set, ``teeth`` the
    number of teeth of its sun, or of its ring where it has no sun; 0: not known.
    """
    number = int(told["planets"])
    equal = np.arange(number) / number
    if not teeth:
        return equal
    kind, sense = ("sun", 1) if "sun_phase" in told else ("ring", -1)
    lag = np.asarray(told[f"{kind}_phase"]) - told[f"{kind}_phase"][0]
    near: list[Array] = [(sense * lag + np.round(teeth * even - sense * lag)) / teeth for even in (equal, -equal)]
    # Planets may be numbered against the sense of the sun, as in a Ravigneaux set on the sun that turns backwards.
    backwards = not np.allclose(near[0], equal) and np.allclose(near[1], -equal)
    return near[int(backwards)]


def _sense(told: Mapping[str, Any]) -> int:
    """Sense in which the sun turns seen from the carrier, as the signs of the speeds: 1 counter-clockwise in the picture, -1."""
    if "carrier_turns" not in told:
        return 1
    slip = told["sun_turns"] - told["carrier_turns"] if "sun_turns" in told else told["carrier_turns"] - told["ring_turns"]
    return -1 if slip < 0 else 1


def draw_stage(train: Description, name: str | None, axes: tuple[Axes, Axes], speed: float | None = None) -> Axes:
    """Draw a stage on two axes, see `Train.plot_stage`."""
    stages = stages_of(train)
    if not stages:
        raise InputError("plot_stage: the train has no planetary set")
    name = next(iter(stages)) if name is None else name
    if not isinstance(name, str) or name not in stages:
        raise InputError(f"name = {shown(name)}: must be {', '.join(map(repr, stages))}")
    told = stages[name]
    front, lever = axes
    _draw_front(train, told, front)
    front.set_title(name, fontsize=10)
    _draw_lever(train, told, lever, speed)
    return front


def _draw_front(train: Description, told: Mapping[str, Any], ax: Axes) -> None:
    from matplotlib.patches import Circle, Polygon

    numbers = train.explain()
    sun, ring = (int(told[f"{kind}_meshes"][0]) if f"{kind}_meshes" in told else 0 for kind in ("sun", "ring"))
    radius = {"sun": _radius(train, numbers, sun, told, "sun"), "ring": _radius(train, numbers, ring, told, "ring")}
    teeth = {"sun": _teeth(train, sun, told, "sun"), "ring": _teeth(train, ring, told, "ring")}
    planet, planet_teeth = _planet(train, numbers, sun or ring, told, "sun" if sun else "ring")
    distance = (radius["sun"] or 0) + planet if sun else radius["ring"] - planet
    angles = _sense(told) * planet_angles(told, teeth["sun"] or teeth["ring"])
    places = distance * np.stack([-np.sin(2 * np.pi * angles), np.cos(2 * np.pi * angles)], axis=1)
    ax.add_patch(Polygon(places, closed=True, facecolor="0.93", edgecolor="0.6", linewidth=1.0, zorder=0))
    share = told.get("load_share")
    for number, place in enumerate(places):
        _draw_gear(ax, place, planet, planet_teeth, COLORS[0])
        words = f"{number + 1}" if share is None else f"{number + 1}\n{100 * share[number] + 0.0:.3g} %"
        ax.annotate(words, tuple(place), ha="center", va="center", fontsize=8)
    if sun:
        _draw_gear(ax, np.zeros(2), radius["sun"], teeth["sun"], COLORS[1])
        ax.annotate(_member(told["sun"]), (0.0, 0.0), ha="center", va="center", fontsize=8)
    largest = distance + planet
    if ring:
        _draw_gear(ax, np.zeros(2), radius["ring"], teeth["ring"], COLORS[2], inside=True)
        rim = 1.1 * radius["ring"]
        ax.add_patch(Circle((0.0, 0.0), rim, facecolor="none", edgecolor=COLORS[2], linewidth=1.2))
        ax.annotate(_member(told["ring"]), (0.0, -1.03 * rim), ha="center", va="top", fontsize=8)
        largest = rim
    ax.set_xlim(-1.08 * largest, 1.08 * largest)
    ax.set_ylim(-1.2 * largest, 1.08 * largest)
    ax.set_aspect("equal")
    ax.set_axis_off()


def _draw_gear(ax: Axes, place: Array, radius: float, teeth: int, color: str, *, inside: bool = False) -> None:
    """A circle with a tick for each tooth; inwards of a ring."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    face = "none" if inside else "white"
    ax.add_patch(Circle(tuple(place), radius, facecolor=face, edgecolor=color, linewidth=1.2, zorder=1))
    if not 0 < teeth <= _MOST_TEETH:
        return
    angle = 2 * np.pi * np.arange(teeth) / teeth
    ways = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    height = min(0.06 * radius, 2 * radius / teeth) * (-1 if inside else 1)
    ax.add_collection(LineCollection(list(np.stack([place + radius * ways, place + (radius + height) * ways], axis=1)),
                                     colors=color, linewidths=0.8, zorder=1))


def _draw_lever(train: Description, told: Mapping[str, Any], ax: Axes, speed: float | None) -> None:
    """Sun, carrier and ring on a line at distances by the teeth; their speeds across."""
    factor = 1.0 if speed is None else speed
    points = {"carrier": 0.0}
    sun, ring = (int(told[f"{kind}_meshes"][0]) if f"{kind}_meshes" in told else 0 for kind in ("sun", "ring"))
    numbers = train.explain()
    of_sun = _teeth(train, sun, told, "sun") or _radius(train, numbers, sun, told, "sun")
    of_ring = _teeth(train, ring, told, "ring") or _radius(train, numbers, ring, told, "ring")
    if sun:
        points["sun"] = 1.0 if not ring else of_ring / (of_sun + of_ring)
    if ring:
        points["ring"] = -1.0 if not sun else -of_sun / (of_sun + of_ring)
    turns = {member: factor * float(told[f"{member}_turns"]) for member in points if f"{member}_turns" in told}
    unit = f"turns per turn of {train.speed_name}" if speed is None else "speed  [rpm]"
    ax.axvline(0.0, color="0.4", linewidth=1.0)
    order = sorted(points, key=lambda member: points[member])
    if len(turns) == len(points):
        ax.plot([turns[member] for member in order], [points[member] for member in order], color="0.4", linewidth=1.5, zorder=2)
    for member, color in (("sun", COLORS[1]), ("carrier", "0.3"), ("ring", COLORS[2])):
        if member not in points:
            continue
        height, at = points[member], turns.get(member, 0.0)
        ax.plot([0.0, at], [height, height], color=color, linewidth=3.0, solid_capstyle="butt", zorder=3)
        ax.plot([at], [height], marker="o", color=color, zorder=4)
        words = _member(told[member])
        if member in turns:
            words += f"\n{at:.4g}"
        # The lever may pass below the words.
        behind = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
        ax.annotate(words, (at, height), (8, 5), textcoords="offset points", fontsize=8, va="bottom", bbox=behind, zorder=5)
    if "planet_turns" in told:
        ax.set_title(f"planets: {factor * float(told['planet_turns']):.4g}", fontsize=8, loc="left", color=COLORS[0])
    ax.set_xlabel(unit)
    ax.set_yticks([])
    ax.margins(x=0.35, y=0.15)
    for side in ("left", "top", "right"):
        ax.spines[side].set_visible(False)
    ax.grid(visible=False)


def _member(words: str) -> str:
    return str(words).strip().replace(", held", " (held)")


def _place_of(train: Description, mesh: int, told: Mapping[str, Any], kind: str) -> int:
    """Which gear of a mesh, 0 or 1, is the sun or the ring."""
    between = train.meshes[mesh - 1].between
    body = str(told[kind]).strip().removesuffix(", held")
    return 0 if between is not None and between[0] == body else 1


def _radius(train: Description, numbers: Mapping[str, Any], mesh: int, told: Mapping[str, Any], kind: str) -> float:
    return _radius_at(numbers, mesh, _place_of(train, mesh, told, kind)) if mesh else 0.0


def _radius_at(numbers: Mapping[str, Any], mesh: int, place: int) -> float:
    """Radius of the reference circle, of the base circle where no drawing tells more."""
    own = numbers[f"mesh {mesh}"]
    return float(own["reference_diameter"][place]) / 2 if "reference_diameter" in own else float(own["base_radius"][place])


def _teeth(train: Description, mesh: int, told: Mapping[str, Any], kind: str) -> int:
    teeth = train.meshes[mesh - 1].teeth if mesh else None
    return 0 if teeth is None else round(float(np.atleast_1d(teeth)[_place_of(train, mesh, told, kind)]))


def _planet(train: Description, numbers: Mapping[str, Any], mesh: int, told: Mapping[str, Any], kind: str) -> tuple[float, int]:
    """Radius and teeth of a planet, in its mesh with sun or ring."""
    place = 1 - _place_of(train, mesh, told, kind)
    teeth = train.meshes[mesh - 1].teeth
    return _radius_at(numbers, mesh, place), 0 if teeth is None else round(float(np.atleast_1d(teeth)[place]))
