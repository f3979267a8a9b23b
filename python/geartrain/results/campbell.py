"""Campbell diagrams: natural frequencies, the orders that excite them, and the speeds where they meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description
from .._core.text_table import text_table
from .._core.units import Unit, own_lambda, speed_of, units_of
from ..errors import InputError, shown
from ..plots.draw import COLORS, DASHES, draws, new_axes, put_legend
from ..plots.planetary_picture import stages_of
from .excitation import Resonances, excitations

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .modes import Modes

__all__ = ["Campbell", "Crossing", "Order", "exciting_orders"]

Array = NDArray[np.float64]

_MANY = 5  # names in a legend
#: Amplitude of a mesh force over the mean force from which on a crossing matters; most of these with their speed in a picture.
_MATTERS, _MOST_NAMED = 0.1, 8
_LOOKS: dict[bool, dict[str, Any]] = {True: {"markersize": 6.0, "color": "black"}, False: {"markersize": 3.0, "color": "0.45"}}
_MOST_NEAR = 3  # modes near to one another with names of their own


@dataclass(frozen=True)
class Order:
    """An order that excites the train.

    Attributes
    ----------
    order : int
        In multiples of the fundamental.
    name : str
        What excites: ``'mesh 1'``, ``'2 x mesh 1'``, ``'torque on motor'``, ``'3 x revolution of motor'``; several of one order
        together.
    per_revolution : float or None
        In multiples of the revolutions that are the speed; None where the speed is not known.
    """

    order: int
    name: str
    per_revolution: float | None


@dataclass(frozen=True)
class Crossing:
    """Where an order meets a natural frequency.

    Attributes
    ----------
    order : Order
    mode : int
        Number of the mode, from 1.
    natural_frequency : float
        In Hz.
    frequency : float
        Lambda.
    speed : float or None
        In rpm; None where not every mesh has teeth.
    fundamental_frequency : float
        In Hz.
    mesh_force : ndarray, (meshes,)
        Amplitude of the force of each mesh [N], linear: all teeth in contact, mean mesh stiffness, modal damping. Excitations of
        one order add up with their most unfavourable phases, meshes on one carrier with their own.
    over_mean : float
        The largest of these amplitudes over the mean force of its mesh. Teeth separate from 1 on.
    rank : int
        1 where ``over_mean`` is largest.
    """

    order: Order
    mode: int
    natural_frequency: float
    frequency: float
    speed: float | None
    fundamental_frequency: float
    mesh_force: Array = field(default_factory=lambda: np.zeros(0), repr=False, compare=False)
    over_mean: float = 0.0
    rank: int = 0

    @property
    def matters(self) -> bool:
        """Whether a mesh force has an amplitude of a tenth of its mean or more there, or it is the first in rank."""
        return self.over_mean >= _MATTERS or self.rank == 1


@dataclass(frozen=True, eq=False)
class Campbell:
    """Natural frequencies of the mean train, the orders that excite them, and where they meet; printed a table of the crossings.

    Crossings are ranked by the mesh force that they make: the share of the mode at the excited mesh times the excitation, over
    twice the modal damping ratio.

    Attributes
    ----------
    natural_frequency : ndarray, (modes,)
        In Hz, of the mean linear system.
    damping_ratio : ndarray, (modes,)
    orders : tuple of Order
        Those with an amplitude: of mesh stiffness, transmission error or torque.
    crossings : tuple of Crossing
        By frequency.
    range : tuple of float
        Lambda, from and to.
    planet_passes : mapping of str to float
        Per revolution of the body that tells the speed, by the names of planetary sets: how often a planet passes a tooth of the
        ring (of the sun, without a ring). Nothing in the model excites with these orders; sensors at rest see them.
    train : Train
    """

    natural_frequency: Array
    damping_ratio: Array
    orders: tuple[Order, ...]
    crossings: tuple[Crossing, ...]
    range: tuple[float, float]
    train: Description = field(repr=False)
    planet_passes: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, train: Description, modes: Modes, start: float, stop: float) -> Campbell:
        """The diagram of a train; start and stop are Lambda."""
        low, high = min(start, stop), max(start, stop)
        hertz = train._outline["fundamental_frequency"]
        orders = exciting_orders(train)
        causes = {order.order: [cause for cause in excitations(train) if cause.order == order.order] for order in orders}
        resonances = Resonances(train, modes)
        found = []
        for order in orders:
            for mode, natural in enumerate(map(float, modes.natural_frequency), 1):
                at = natural / order.order
                if low <= at <= high:
                    forces = resonances.forces(mode, causes[order.order])
                    found.append(Crossing(order, mode, natural * hertz, at, speed_of(train, at), at * hertz, forces,
                                          resonances.over_mean(forces)))
        ranks = {id(crossing): rank for rank, crossing in enumerate(sorted(found, key=lambda one: -one.over_mean), 1)}
        ordered = [replace(crossing, rank=ranks[id(crossing)]) for crossing in sorted(found, key=lambda one: one.frequency)]
        passes = {name: float(told.get("ring_planet_pass", told.get("sun_planet_pass", 0.0)))
                  for name, told in stages_of(train).items()} if train._outline["speed"] else {}
        return cls(modes.natural_frequency * hertz, modes.damping_ratio, orders, tuple(ordered), (low, high), train,
                   {name: often for name, often in passes.items() if often > 0})

    def __str__(self) -> str:
        known = any(crossing.order.per_revolution is not None for crossing in self.crossings)
        turns = f"per revolution of {self.train.speed_name}" if known else "per revolution"
        return text_table({
            "speed [rpm]": [crossing.speed for crossing in self.crossings],
            "Lambda": [own_lambda(crossing.frequency, crossing.speed) for crossing in self.crossings],
            "mode": [crossing.mode for crossing in self.crossings],
            "natural [Hz]": [crossing.natural_frequency for crossing in self.crossings],
            "order of fundamental": [crossing.order.order for crossing in self.crossings],
            turns: [crossing.order.per_revolution for crossing in self.crossings],
            "force/mean": [f"{crossing.over_mean:.2g}" for crossing in self.crossings],
            "rank": [crossing.rank for crossing in self.crossings],
            "excited by": [crossing.order.name for crossing in self.crossings],
        })

    __repr__ = __str__

    @draws
    def plot(
        self, ax: Axes | None = None, *, unit: Unit | None = None, highest: float | None = None, **style: Any
    ) -> Axes:
        """Draw natural frequencies and orders over the speed; crossings that matter have large marks and their speed.

        Beside each mode stand its natural frequency and its damping in per cent of the critical damping.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the speed; unless told rpm where Lambda is the speed in rpm, else Lambda.
        highest : float, optional
            Highest frequency drawn [Hz], as where high modes leave little room for the low ones; unless told up to the highest
            natural frequency that an order reaches.
        **style
            For the marks of the crossings, of matplotlib's ``plot``.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> train.campbell(start=0.2, stop=2.6).plot().figure.savefig("campbell.png")  # doctest: +SKIP
        """
        units = units_of(self.train, unit)
        if highest is not None and (isinstance(highest, bool) or not isinstance(highest, Real) or not 0 < highest < np.inf):
            raise InputError(f"highest = {shown(highest)}: must be a number > 0")
        own, ax = ax is None, new_axes(ax, figsize=(8.0, 5.2))
        ends = np.array(self.range)
        # Beyond the highest natural frequency that any order reaches there is nothing to be read.
        reached = [crossing.natural_frequency for crossing in self.crossings]
        top = 1.15 * max(reached, default=float(self.natural_frequency.max(initial=1.0))) if highest is None else float(highest)
        inside = self.natural_frequency[self.natural_frequency <= top]
        for natural in inside:
            ax.axhline(natural, color="black", linewidth=0.9)
        for height, name in _labels(inside, self.damping_ratio, top):
            ax.annotate(name, (1.0, height), (4, 0), xycoords=("axes fraction", "data"), textcoords="offset points", va="center",
                        fontsize=8)
        ax.set_xlim(*units.per_lambda * ends)
        ax.set_ylim(0, top)
        ax.set_xlabel(units.frequency)
        ax.set_ylabel("frequency  [Hz]")
        taken = self._mark_crossings(ax, units.per_lambda, style)
        sources = sorted({_source(order) for order in self.orders})
        for order in self.orders:
            color, dashes = _look(sources.index(_source(order)))
            hertz = order.order * ends * self.train._outline["fundamental_frequency"]
            ax.plot(units.per_lambda * ends, hertz, color=color, linestyle=dashes, linewidth=1.1)
            self._name(ax, order, units.per_lambda * ends, hertz, inside / top, top, color, taken)
        for name, often in self.planet_passes.items():
            turns_hertz = np.array([speed_of(self.train, end) for end in ends], float) / 60
            ax.plot(units.per_lambda * ends, often * turns_hertz, color="0.5", linewidth=0.9, linestyle=(0, (1, 2)),
                    label=f"planet pass of {name}, {often:.4g}")
        for number, source in enumerate(sources):
            color, dashes = _look(number)
            ax.plot([], [], color=color, linestyle=dashes, label=source)
        for matters, words in ((True, f"mesh force \u00b1 {100 * _MATTERS:g} % of its mean or more"), (False, "smaller")):
            if any(crossing.matters is matters for crossing in self.crossings):
                ax.plot([], [], linestyle="none", marker="o", label=words, **{**_LOOKS[matters], **style})
        known = any(order.per_revolution is not None for order in self.orders)
        turns = f"orders per revolution of {self.train.speed_name}"
        put_legend(ax, own, title=turns if known else r"orders of the fundamental $\Lambda$")
        return ax

    def _mark_crossings(self, ax: Axes, per_lambda: float, style: dict[str, Any]) -> list[tuple[float, float]]:
        """Large marks where a crossing matters, the first in rank with their speed; gives where these words stand in the axes."""
        for matters, look in _LOOKS.items():
            some = [crossing for crossing in self.crossings if crossing.matters is matters]
            at = [per_lambda * crossing.frequency for crossing in some]
            heights = [crossing.natural_frequency for crossing in some]
            if some:
                ax.plot(at, heights, **{"linestyle": "none", "marker": "o", "zorder": 3, **look, **style})
        (left, right), top = ax.get_xlim(), ax.get_ylim()[1]
        taken: list[tuple[float, float]] = []
        ranked = sorted((crossing for crossing in self.crossings if crossing.matters), key=lambda crossing: crossing.rank)
        for crossing in [one for one in ranked if one.natural_frequency <= top][:_MOST_NAMED]:
            x, y = (per_lambda * crossing.frequency - left) / (right - left), crossing.natural_frequency / top
            places = [(x + 0.045 * across, y + 0.035 * up) for up in (-1, 1) for across in (1, -1)]
            clear = [place for place in places if 0.0 < place[0] < 0.95 and 0.02 < place[1] < 0.98 and _is_free(place, taken)]
            if clear:
                taken.append(clear[0])
                ax.annotate(_rounded(per_lambda * crossing.frequency), clear[0], xycoords="axes fraction", fontsize=8,
                            fontweight="bold", ha="center", va="center", zorder=5,
                            bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.85})
        return taken

    @staticmethod
    def _name(
        ax: Axes, order: Order, across: Array, hertz: Array, modes: Array, top: float, color: str, taken: list[tuple[float, float]],
    ) -> None:
        """The order on its line, near the upper end, clear of the modes and of the names of other orders where it can be.

        ``modes`` and ``taken`` are heights of modes and places of names, over the extent of the axes.
        """
        end = min(0.97, (0.97 * top - hertz[0]) / max(hertz[1] - hertz[0], 1e-300))
        if end <= 0:
            return
        places = [(share, (hertz[0] + share * (hertz[1] - hertz[0])) / top) for share in np.linspace(end, 0.3 * end, 30)]

        def is_free(place: tuple[float, float]) -> bool:
            return _is_free(place, taken) and bool((np.abs(modes - place[1]) > 0.025).all())

        share, height = next(filter(is_free, places), places[0])
        taken.append((share, height))
        words = f"{order.order if order.per_revolution is None else order.per_revolution:.4g}"
        ax.annotate(words, (across[0] + share * (across[1] - across[0]), height * top), color=color, fontsize=8, ha="center",
                    va="center", bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none"}, zorder=4)


def exciting_orders(train: Description) -> tuple[Order, ...]:
    """Orders of mesh stiffness, transmission error and torques with an amplitude, ascending."""
    names: dict[int, list[str]] = {}
    for cause in excitations(train):
        names.setdefault(cause.order, []).append(cause.name)
    ratio = train.explain()["train"].get("speed_ratio")
    return tuple(Order(order, ", ".join(dict.fromkeys(names[order])), order / ratio if ratio else None) for order in sorted(names))


def _look(number: int) -> tuple[str, Any]:
    """Colour and dashes of a source; lines of the modes are black."""
    return COLORS[number % (len(COLORS) - 1)], DASHES[number % len(DASHES)]


def _source(order: Order) -> str:
    """What excites, without the harmonic; of many the first and the last."""
    names = [name.split(" x ")[-1] for name in order.name.split(", ")]
    return ", ".join(names) if len(names) < _MANY else f"{names[0]}, ..., {names[-1]}"


def _is_free(place: tuple[float, float], taken: list[tuple[float, float]]) -> bool:
    """Whether a word at a place of the axes is clear of the others."""
    return all(abs(place[0] - x) > 0.08 or abs(place[1] - y) > 0.04 for x, y in taken)


def _labels(natural: Array, damping: Array, top: float) -> list[tuple[float, str]]:
    """Heights and names of the modes: two or three near to one another have names below one another, more of them one name."""
    names = [f"mode {mode}: {hertz:.4g} Hz, {100 * ratio:.2g} %" for mode, (hertz, ratio) in enumerate(zip(natural, damping), 1)]
    groups: list[list[int]] = []
    for mode, hertz in enumerate(natural):
        if groups and hertz - natural[groups[-1][0]] < 0.03 * top:
            groups[-1].append(mode)
        else:
            groups.append([mode])
    found = []
    for group in groups:
        low, high, middle = natural[group[0]], natural[group[-1]], float(natural[group].mean())
        if len(group) > _MOST_NEAR:
            found.append((middle, f"modes {group[0] + 1} to {group[-1] + 1}: {low:.4g} to {high:.4g} Hz"))
        else:
            found += [(middle + 0.034 * top * (place - (len(group) - 1) / 2), names[mode]) for place, mode in enumerate(group)]
    return found


def _rounded(value: float) -> str:
    """A speed with four digits or as a whole number."""
    return f"{value:.0f}" if value >= 1000 else f"{value:.4g}"
