"""Campbell diagrams: natural frequencies, the orders that excite them, and the speeds where they meet."""

from __future__ import annotations

from dataclasses import dataclass, field
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._draw import COLORS, DASHES, draws, new_axes, put_legend
from ._text_table import text_table
from ._units import Unit, own_lambda, speed_of, units_of
from .description import Description
from .errors import InputError, shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["Campbell", "Crossing", "Order", "exciting_orders"]

Array = NDArray[np.float64]

_MANY = 5  # names in a legend
_LEAST = 1e-12  # of an amplitude: below it is the rounding of one that is zero


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
    """

    order: Order
    mode: int
    natural_frequency: float
    frequency: float
    speed: float | None
    fundamental_frequency: float


@dataclass(frozen=True, eq=False)
class Campbell:
    """Natural frequencies of the mean train, the orders that excite them, and where they meet; printed, a table of the crossings.

    Attributes
    ----------
    natural_frequency : ndarray, (modes,)
        In Hz, of the mean linear system.
    orders : tuple of Order
        Those with an amplitude: of mesh stiffness, transmission error or torque.
    crossings : tuple of Crossing
        By frequency.
    range : tuple of float
        Lambda, from and to.
    train : Train
    """

    natural_frequency: Array
    orders: tuple[Order, ...]
    crossings: tuple[Crossing, ...]
    range: tuple[float, float]
    train: Description = field(repr=False)

    @classmethod
    def of(cls, train: Description, natural_frequency: Array, start: float, stop: float) -> Campbell:
        """The diagram of a train; natural frequencies and range are Lambda."""
        low, high = min(start, stop), max(start, stop)
        hertz = train._outline["fundamental_frequency"]
        orders = exciting_orders(train)
        crossings = [
            Crossing(order, mode, natural * hertz, at, speed_of(train, at), at * hertz)
            for order in orders for mode, natural in enumerate(map(float, natural_frequency), 1)
            if low <= (at := natural / order.order) <= high
        ]
        ordered = tuple(sorted(crossings, key=lambda crossing: crossing.frequency))
        return cls(natural_frequency * hertz, orders, ordered, (low, high), train)

    def __str__(self) -> str:
        return text_table({
            "speed [rpm]": [crossing.speed for crossing in self.crossings],
            "Lambda": [own_lambda(crossing.frequency, crossing.speed) for crossing in self.crossings],
            "mode": [crossing.mode for crossing in self.crossings],
            "natural [Hz]": [crossing.natural_frequency for crossing in self.crossings],
            "order": [crossing.order.order for crossing in self.crossings],
            "per revolution": [crossing.order.per_revolution for crossing in self.crossings],
            "excited by": [crossing.order.name for crossing in self.crossings],
        })

    __repr__ = __str__

    @draws
    def plot(
        self, ax: Axes | None = None, *, unit: Unit | None = None, highest: float | None = None, **style: Any
    ) -> Axes:
        """Draw natural frequencies and orders over the speed, crossings marked.

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
        for natural, name in zip(inside, _labels(inside, top)):
            ax.axhline(natural, color="black", linewidth=0.9)
            ax.annotate(name, (1.0, natural), (4, 0), xycoords=("axes fraction", "data"), textcoords="offset points", va="center",
                        fontsize=8)
        sources = sorted({_source(order) for order in self.orders})
        taken: list[tuple[float, float]] = []
        for order in self.orders:
            color, dashes = _look(sources.index(_source(order)))
            hertz = order.order * ends * self.train._outline["fundamental_frequency"]
            ax.plot(units.per_lambda * ends, hertz, color=color, linestyle=dashes, linewidth=1.1)
            self._name(ax, order, units.per_lambda * ends, hertz, inside / top, top, color, taken)
        at = [units.per_lambda * crossing.frequency for crossing in self.crossings]
        ax.plot(at, reached, **{"linestyle": "none", "marker": "o", "color": "black", "markersize": 4, "zorder": 3, **style})
        ax.set_xlim(*units.per_lambda * ends)
        ax.set_ylim(0, top)
        ax.set_xlabel(units.frequency)
        ax.set_ylabel("frequency  [Hz]")
        for number, source in enumerate(sources):
            color, dashes = _look(number)
            ax.plot([], [], color=color, linestyle=dashes, label=source)
        known = any(order.per_revolution is not None for order in self.orders)
        put_legend(ax, own, title=f"orders per revolution of {self.train.speed_name}" if known else r"orders of $\Lambda$")
        return ax

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
            others = all(abs(place[0] - x) > 0.07 or abs(place[1] - y) > 0.04 for x, y in taken)
            return others and bool((np.abs(modes - place[1]) > 0.025).all())

        share, height = next(filter(is_free, places), places[0])
        taken.append((share, height))
        words = f"{order.order if order.per_revolution is None else order.per_revolution:.4g}"
        ax.annotate(words, (across[0] + share * (across[1] - across[0]), height * top), color=color, fontsize=8, ha="center",
                    va="center", bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "edgecolor": "none"}, zorder=4)


def exciting_orders(train: Description) -> tuple[Order, ...]:
    """Orders of mesh stiffness, transmission error and torques with an amplitude, ascending."""
    numbers = train.explain()
    found: dict[int, list[str]] = {}

    def add(source: str, base: int, *amplitudes: Any) -> None:
        for series in amplitudes:
            for harmonic, amplitude in enumerate(() if series is None else series, 1):
                name = source if harmonic == 1 else f"{harmonic} x {source}"
                names = found.setdefault(harmonic * base, [])
                if abs(amplitude) > _LEAST and name not in names:
                    names.append(name)

    for number, mesh in enumerate(train.meshes, 1):
        told = numbers[f"mesh {number}"]
        series = [told.get("stiffness_cos"), told.get("stiffness_sin"), mesh.error_cos, mesh.error_sin]
        add(f"mesh {number}", told["order"], *series)
    for body in train.bodies:
        add(f"torque on {body.name}", 1, body.torque_cos, body.torque_sin)
        order = numbers[str(body.name)].get("revolution_order", 1)
        add(f"revolution of {body.name}", order, body.revolution_torque_cos, body.revolution_torque_sin)
    add("input torque", 1, train.torque_cos, train.torque_sin)
    ratio = numbers["train"].get("speed_ratio")
    excited = sorted((int(order), ", ".join(names)) for order, names in found.items() if names)
    return tuple(Order(order, name, order / ratio if ratio else None) for order, name in excited)


def _look(number: int) -> tuple[str, Any]:
    """Colour and dashes of a source; lines of the modes are black."""
    return COLORS[number % (len(COLORS) - 1)], DASHES[number % len(DASHES)]


def _source(order: Order) -> str:
    """What excites, without the harmonic; of many the first and the last."""
    names = [name.split(" x ")[-1] for name in order.name.split(", ")]
    return ", ".join(names) if len(names) < _MANY else f"{names[0]}, ..., {names[-1]}"


def _labels(natural: Array, top: float) -> list[str]:
    """Names of the modes; of modes that are too near to one another the first alone has a name, which tells them all."""
    names = [f"mode {mode}" for mode in range(1, len(natural) + 1)]
    first = 0
    for mode in range(1, len(natural)):
        if natural[mode] - natural[first] < 0.03 * top:
            names[first] = f"modes {first + 1} to {mode + 1}" if mode > first + 1 else f"modes {first + 1}, {mode + 1}"
            names[mode] = ""
        else:
            first = mode
    return names
