"""The train as a picture: bodies as discs, joined by shafts and meshes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description
from .draw import COLORS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Joint", "draw_schematic", "figure_size", "joints_of", "places_of"]

Array = NDArray[np.float64]

_LONGEST = 10  # columns of bodies in a row
_PARTS = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8)  # places along a joint where its words may stand
_PIECE = 0.02  # half the size of a piece of a line: words cover a line rather than other words


@dataclass(frozen=True)
class Joint:
    """A shaft, a mesh or a coupling: its element, ``'shaft 1'``, and the places of the two bodies in `Description.body_labels`."""

    element: str
    ends: tuple[int, int]

    @property
    def is_mesh(self) -> bool:
        """Whether it is a mesh."""
        return self.element.startswith("mesh")


def joints_of(train: Description) -> list[Joint]:
    """The shafts, then the meshes and the couplings of a train."""
    bodies = train.body_labels
    if not train.bodies:  # a chain: shaft, mesh, shaft, ..., and a body at either end of each
        shafts = [Joint(f"shaft {number + 1}", (2 * number, 2 * number + 1)) for number in range(len(train.shafts))]
        return shafts + [Joint(f"mesh {number + 1}", (2 * number + 1, 2 * number + 2)) for number in range(len(train.meshes))]
    ends = {"shaft": [shaft.between for shaft in train.shafts], "mesh": [mesh.between for mesh in train.meshes],
            "coupling": [coupling.between for coupling in train.couplings]}
    return [
        Joint(f"{kind} {number}", (bodies.index(between[0]), bodies.index(between[1])))
        for kind, joined in ends.items() for number, between in enumerate(joined, 1) if between is not None
    ]


def carried_by(train: Description) -> list[tuple[int, int]]:
    """Carriers and what rides on them, as places in `Description.body_labels`: gears of their meshes without a shaft, or all."""
    bodies, found = train.body_labels, dict[tuple[int, int], None]()
    fixed = {name for shaft in train.shafts for name in shaft.between or ()}
    fixed |= {name for coupling in train.couplings for name in coupling.between or ()}
    fixed |= {body.name for body in train.bodies or () if body.held and body.name}
    for mesh in train.meshes:
        if mesh.carrier and mesh.between is not None:
            riders = [name for name in mesh.between if name not in fixed] or mesh.between
            found.update(dict.fromkeys((bodies.index(mesh.carrier), bodies.index(rider)) for rider in riders))
    return list(found)


def bearings_under(train: Description) -> dict[int, int]:
    """Numbers of the bearings, by the places of their bodies in `Description.body_labels`."""
    bodies = train.body_labels
    return {bodies.index(bearing.body): number for number, bearing in enumerate(train.bearings, 1) if bearing.body}


def places_of(bodies: int, joints: Sequence[Joint], first: int = 0) -> Array:
    """Where to draw the bodies, (bodies, 2): in columns by the number of joints from the first one.

    In a column each stands as near as it can to the middle of those that it hangs on in the column before, one apart at least.
    """
    neighbours: list[list[int]] = [[] for _ in range(bodies)]
    for joint in joints:
        one, other = joint.ends
        neighbours[one].append(other)
        neighbours[other].append(one)
    columns, depth = [[first]], {first: 0}
    while columns[-1]:
        columns.append([])
        for body in columns[-2]:
            for other in neighbours[body]:
                if other not in depth:
                    depth[other] = len(columns) - 1
                    columns[-1].append(other)
    places = np.zeros((bodies, 2))
    for number, column in enumerate(columns[:-1]):
        before = {body: [places[other, 1] for other in neighbours[body] if depth[other] == number - 1] for body in column}
        wish = {body: float(np.mean(heights or [0.0])) for body, heights in before.items()}
        order = sorted(column, key=lambda body: -wish[body])
        for body, height in zip(order, _spread([wish[body] for body in order])):
            places[body] = number, height
    return places


def _spread(wish: Sequence[float]) -> list[float]:
    """Heights, descending by 1 at least, nearest to those wished, which descend: blocks of bodies that are in one another's way."""
    blocks: list[tuple[float, int]] = []  # middle, number of bodies
    for height in wish:
        middle, count = height, 1
        while blocks and blocks[-1][0] - (blocks[-1][1] - 1) / 2 < middle + (count - 1) / 2 + 1:
            before, size = blocks.pop()
            # The block's middle is where its bodies wish it on average.
            middle = (size * before + count * middle) / (size + count)
            count += size
        blocks.append((middle, count))
    return [middle + (count - 1) / 2 - place for middle, count in blocks for place in range(count)]


def draw_schematic(
    train: Description, ax: Axes, *, speed: float | None = None, body_color: Sequence[Any] | Array | None = None,
    strength: Mapping[str, float] | None = None,
) -> Axes:
    """Draw a train.

    Parameters
    ----------
    train : Description
    ax : matplotlib.axes.Axes
        Where to draw.
    speed : float, optional
        Of the body whose revolutions are the speed [rpm]: each body then has its own, else its turns; negative where it turns the
        other way.
    body_color : sequence, optional
        Of each body.
    strength : mapping, optional
        Share of each element, told instead of ratios and numbers; its line is as thick.
    """
    bodies, joints, places = train.body_labels, joints_of(train), _places(train)
    numbers = train.explain()
    sizes = _sizes(len(bodies), joints, numbers)
    for pair in carried_by(train):
        ax.plot(*places[list(pair)].T, color="0.7", linewidth=1.0, linestyle="--", zorder=0)
    from matplotlib.patches import Circle

    bearings = bearings_under(train)
    taken: list[tuple[float, ...]] = []  # boxes of discs, words and pieces of lines
    for body, name in enumerate(bodies):
        color = "white" if body_color is None else body_color[body]
        gear = any(body in joint.ends and joint.is_mesh for joint in joints)
        ax.add_patch(Circle(tuple(places[body]), sizes[body], facecolor=color, edgecolor="black", linewidth=1.2, zorder=3,
                            linestyle="-" if gear else (0, (4, 1.5))))
        told = numbers.get(name, {}).get("turns")
        turns = "" if told is None else f"\n{told:.4g} turn" + "s" * (abs(told) != 1)
        rate = f"\n{told * speed:.4g} rpm" if told is not None and speed is not None else turns
        if body in bearings:
            rate += "\n" + _draw_bearing(ax, places[body], sizes[body], bearings[body], strength)
        below = places[body][0], places[body][1] - sizes[body]
        ax.annotate(name + rate, below, (0, -3), textcoords="offset points", ha="center", va="top", fontsize=8, zorder=4,
                    bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8})
        taken.append((*(places[body] - sizes[body]), *(places[body] + sizes[body])))
        taken.append(_box(name + rate, below, (0, -3), 8, "center", "top"))
    for pair in (*carried_by(train), *(joint.ends for joint in joints)):
        one, other = places[list(pair)]
        taken += [(*(at - _PIECE), *(at + _PIECE)) for at in np.linspace(one, other, 33)]
    for joint in joints:
        share = None if strength is None else strength.get(joint.element)
        _draw_joint(ax, joint, places, sizes, _words(joint, train, numbers) if strength is None else "", share, taken)
    ax.set_xlim(places[:, 0].min() - 0.8, places[:, 0].max() + 0.8)
    ax.set_ylim(places[:, 1].min() - (1.1 if bearings else 0.95), places[:, 1].max() + 0.6)
    ax.set_aspect("equal")
    ax.set_axis_off()
    return ax


def figure_size(train: Description) -> tuple[float, float]:
    """Width and height of a figure of the train."""
    width, height = np.ptp(_places(train), axis=0)
    return float(np.clip(width + 1.8, 5.0, 18.0)), float(np.clip(1.05 * height + 2.0, 2.4, 12.0))


def _places(train: Description) -> Array:
    """Where to draw the bodies, the one that tells the speed on the left; a long train in rows, there and back."""
    bodies = train.body_labels
    joints = joints_of(train) + [Joint("carrier", pair) for pair in carried_by(train)]
    across, height = places_of(len(bodies), joints, bodies.index(train.speed_name)).T
    row, column = np.divmod(across, _LONGEST)
    if row.max() > 0:
        column = np.where(row % 2 == 0, column, _LONGEST - 1 - column)
        height = height - row * (np.ptp(height) + 1.5)
    return np.stack([1.6 * column, 1.15 * height], axis=1)


def _sizes(bodies: int, joints: Sequence[Joint], numbers: Mapping[str, Mapping[str, Any]]) -> Array:
    """Radii of the discs, which grow with the largest base radius of a body."""
    radius = np.zeros(bodies)
    for joint in joints:
        if joint.is_mesh:
            np.maximum.at(radius, list(joint.ends), numbers[joint.element]["base_radius"])
    largest = radius.max(initial=0.0) or 1.0
    return np.where(radius > 0, 0.16 + 0.2 * np.sqrt(radius / largest), 0.2)


def _words(joint: Joint, train: Description, numbers: Mapping[str, Mapping[str, Any]]) -> str:
    """What is told of a joint: its name, and the teeth or the ratio of the radii, or the stiffness."""
    told = numbers.get(joint.element, {})  # nothing is told of a rigid shaft
    if not joint.is_mesh:
        from matplotlib.ticker import EngFormatter

        return f"{joint.element}\n" + (EngFormatter("N m/rad", places=1)(told["stiffness"]) if "stiffness" in told else "rigid")
    teeth = train.meshes[int(joint.element.split()[1]) - 1].teeth
    if teeth is not None:
        return f"{joint.element}\n" + " : ".join(f"{float(number):g}" for number in np.atleast_1d(teeth))
    driving, driven = told["base_radius"]
    return f"{joint.element}\n1 : {driven / driving:.4g}"


def _draw_bearing(ax: Axes, place: Array, size: float, number: int, strength: Mapping[str, float] | None) -> str:
    """A bearing as a ring of balls in the middle of its body, of the colour of joints; gives its words."""
    from matplotlib.patches import Circle

    share = None if strength is None else sum(part for name, part in strength.items() if name.startswith(f"bearing {number} "))
    color = "0.45" if share is None else COLORS[3]
    thickness = 1.0 if share is None else 0.5 + 4.5 * share
    for radius in (0.34 * size, 0.66 * size):
        ax.add_patch(Circle(tuple(place), radius, facecolor="none", edgecolor=color, linewidth=thickness, zorder=4))
    turns = 2 * np.pi * np.arange(8) / 8
    for ball in place + 0.5 * size * np.stack([np.cos(turns), np.sin(turns)], axis=1):
        ax.add_patch(Circle(tuple(ball), 0.12 * size, facecolor=color, edgecolor="none", zorder=4))
    return f"bearing {number}" + (f": {100 * share:.3g} %" if share is not None and share >= 0.005 else "")


def _box(words: str, at: Sequence[float], beside: Sequence[float], size: float, ha: str, va: str) -> tuple[float, ...]:
    """Left, bottom, right and top of words of a size in points beside a place, about; 1 is an inch, as in `figure_size`."""
    lines = words.split("\n")
    width, height = (size / 72 * many for many in (0.62 * max(map(len, lines)), 1.2 * len(lines)))
    left = at[0] + beside[0] / 72 - {"left": 0.0, "center": 0.5, "right": 1.0}[ha] * width
    bottom = at[1] + beside[1] / 72 - {"bottom": 0.0, "center": 0.5, "top": 1.0}[va] * height
    return left, bottom, left + width, bottom + height


def _shared(box: Sequence[float], others: Sequence[Sequence[float]]) -> float:
    """Area that a box shares with other boxes."""
    low, high = np.split(np.asarray(others), 2, axis=1)
    common = np.minimum(box[2:], high) - np.maximum(box[:2], low)
    return float(common.clip(min=0.0).prod(axis=1).sum())


def _draw_joint(
    ax: Axes, joint: Joint, places: Array, sizes: Array, words: str, share: float | None, taken: list[tuple[float, ...]],
) -> None:
    """A shaft as a thick line, a mesh as a dotted one, a coupling as a dashed one.

    The words stand beside its middle, or where they cover least of the boxes ``taken``, to which theirs is added.
    """
    one, other = joint.ends
    begin, end = places[one], places[other]
    distance = float(np.hypot(*(end - begin)))
    along = (end - begin) / distance
    color = "0.45" if share is None else COLORS[3]
    thickness = 3.5 if share is None else 1.0 + 9.0 * share
    style = {"mesh": (0, (1, 1)), "coupling": (0, (2.5, 0.8))}.get(joint.element.split()[0], "-")
    ax.plot(*zip(begin, end), color=color, linewidth=thickness, linestyle=style, zorder=1, solid_capstyle="butt")
    if share is not None and share >= 0.005:
        words = f"{joint.element}\n{100 * share:.3g} %"
    if not words:
        return
    away = 4 + thickness / 2
    if abs(along[0]) < 0.1:
        stands = [((away, 0.0), "left", "center"), ((-away, 0.0), "right", "center")]
    elif abs(along[1]) < 0.1:
        stands = [((0.0, away), "center", "bottom"), ((0.0, -away), "center", "top")]
    else:
        rise = int(np.sign(along[1] * along[0]))
        stands = [((-4.0 * rise, away - 3), "right" if rise > 0 else "left", "bottom"),
                  ((4.0 * rise, 3 - away), "left" if rise > 0 else "right", "top")]
    first, last = begin + sizes[one] * along, end - sizes[other] * along
    tried = [((1 - part) * first + part * last, *stand) for stand in stands for part in _PARTS]
    boxes = [_box(words, at, beside, 7, ha, va) for at, beside, ha, va in tried]
    best = int(np.argmin([_shared(box, taken) + 1e-4 * place for place, box in enumerate(boxes)]))
    at, beside, ha, va = tried[best]
    taken.append(boxes[best])
    ax.annotate(words, tuple(at), beside, textcoords="offset points", fontsize=7, color="0.25", zorder=4, ha=ha, va=va)
