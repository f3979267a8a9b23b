"""The search for every periodic motion at one speed."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._core.box import Box
from .._core.parameter import value_in
from .._core.units import Unit, lambda_of
from .._core.watch import quiet
from ..errors import InputError, SolverError, shown
from .branch import Branch
from .motion import Motion, from_state
from .motion_table import motions_of, put_motions
from .motions import Find, Motions, adds_up, index_of, index_sum
from .orbit import least_period, replace_period, same_orbit
from .planet_images import PlanetImages

__all__ = ["find_motions"]

Array = NDArray[np.float64]

_SPREAD, _WIDER = 2.0, 1.5  # box of the random states over the largest state known; its growth where motions are missing
_BATCH = 100  # random states between two looks at the indices
_HARMONICS = 12  # of the fundamental in a random waveform
_DECADES, _MEANS = (-2.0, 0.3), (-0.5, 2.0)  # its size over the box, as a power of 10; its mean over that of a motion known
# Share of those beside motions known, and as powers of 10 how far beside, the same for all meshes but for a little. Of 1,300 of
# period 4 beside those of figure 9 (0.01) at Lambda = 2.4, 395 led to other motions from 10**-2.0 to 10**-1.5, 12 from 10**-0.5.
_NEAR, _NEARER, _UNEVEN = 3 / 4, (-3.0, -1.0), 0.3
_WAVEFORMS = 24  # random waveforms for a random state: they take a fifth of the time of shooting, and find more
_PUSH = 1e-3  # relative, by which a flow begins beside an unstable motion
_SETTLING = (3, 10, 30)  # periods of the fundamental that a random state is integrated for before it is tried
_PATIENCE = 4  # times as many random states are tried at most where the indices do not add up, or lately something new was found
_ROUND = (0.7, 1.4)  # of the speed, between which branches are followed: those that pass it give their other motions there
_WIDTH = (0.3, 3.0)  # of the gap of one mesh, between which they are followed at constant speed. From 0.7 to 1.4 it finds less
_POINTS = 3000  # after which such a branch is given up
_SPEED, _DEEP = "speed", "speed, with bifurcations"  # what the branches of motions are followed over, besides the gaps
_ROUGH, _EXACT, _NEARBY = 1e-2, 1e-5, 1.001  # tolerance of such a branch; that of a point from which shooting leads away, and how
# far its branch goes, over the speed


def find_motions(
    train: Any, frequency: float, unit: Unit, period: int, starts: int, seeds: int, random_seed: int, response: Branch | None
) -> Motions:
    """What `Train.motions` is documented to do."""
    numbers = {"period": (period, 1, 64), "starts": (starts, 1, None), "seeds": (seeds, 0, None),
               "random_seed": (random_seed, 0, None)}
    for name, (value, least, most) in numbers.items():
        if isinstance(value, bool) or not isinstance(value, Integral) or not least <= value <= (most or 2**31 - 1):
            allowed = f"from {least} to {most}" if most else f">= {least}"
            raise InputError(f"{name} = {shown(value)}: must be a whole number {allowed}")
    if response is not None and not isinstance(response, Branch):
        raise InputError(f"response = {shown(response)}: must be a gt.Branch")
    if response is not None and response.parameter_name:
        raise InputError(f"response: a branch over {response.parameter_name}: must be one over frequency")
    if isinstance(frequency, bool) or not isinstance(frequency, Real) or not 0 < frequency < float("inf"):
        raise InputError(f"frequency = {shown(frequency)}: must be a number > 0")
    at = lambda_of(train, float(frequency), unit)
    train._refuse("motions")
    return _search(train, at, int(period), int(starts), int(seeds), int(random_seed), response)


def _search(
    train: Any, frequency: float, period: int, starts: int, seeds: int, random_seed: int, response: Branch | None
) -> Motions:
    """The motions at Lambda."""
    at_infinity = _multipliers_at_infinity(train, frequency)
    known = _Known(train, frequency, {n: index_of(at_infinity, n) for n in range(1, period + 1)})
    branches = _round_about(train, frequency, period.bit_length() - 1) if response is None else [response, *response.branches]
    for branch in branches:
        for motion in branch.at(frequency):
            known.add_balanced(motion, branch.origin or "response", (_SPEED, _DEEP) if response is None else ())
    _follow(train, frequency, known)
    attractors = train.attractors(frequency, starts=starts, random_seed=random_seed)
    others = []
    for motion in attractors:
        if 0 < motion.period <= period:
            known.add_near(motion, "random start")
        elif not motion.unbounded:
            others.append(motion)
    moments = np.random.default_rng(random_seed)
    tried, spread, rich, poor = 0, _SPREAD, 0, 0
    pushed: set[int] = set()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        while tried < seeds or (tried < _PATIENCE * seeds and not (known.adds_up() and poor > rich)):
            spread *= 1.0 if tried < seeds or known.adds_up() else _WIDER
            before = len(known.found)
            states = list(_random_states(train, frequency, known, others, spread, moments, min(seeds, _BATCH)))
            tried += len(states)
            tries = [(state, n, how) for state, how in states for n in range(1, period + 1)]
            for found, (_, n, how) in zip(pool.map(lambda one: known.shoot(one[0], one[1]), tries), tries, strict=True):
                if found is not None:
                    known.add(found, f"shooting for period {n} from {how}")
            guesses = list(_random_waveforms(known, others, spread, moments, _WAVEFORMS * len(states)))
            for balanced in _distinct(motion for motions in pool.map(known.balance, guesses) for motion in motions):
                known.add_balanced(balanced, f"the balance for period {balanced.period} from a random waveform", ())
            _leave_unstable(train, frequency, known, pushed)
            _follow(train, frequency, known)
            rich, poor = (rich + 1, 0) if len(known.found) > before else (rich, poor + 1)
            if not states:
                break
    return Motions(known.found, frequency, known.expected_sum, others, tried)


class _Known:
    """The orbits found so far at a Lambda, each once."""

    def __init__(self, train: Any, frequency: float, expected_sum: Mapping[int, int | None]) -> None:
        self.train = train
        self.frequency = frequency
        self.period = max(expected_sum)
        self.expected_sum = expected_sum
        self.found: list[Find] = []
        # Those whose branches were: over speed; with what bifurcates from these; over the gap of each mesh, by its name.
        self.followed: dict[str, list[Motion]] = {name: [] for name in (_SPEED, _DEEP, *_gaps(train))}
        # Motions that a turn of planets makes of others are known without a search, and lead to nothing else.
        self.images = PlanetImages(train)
        self.turned: list[Motion] = []

    def shoot(self, state: Array, period: int) -> Motion | None:
        """The orbit of a period near a state; None where shooting finds none."""
        with self.train._ask_at(self.frequency, {}) as box:
            start = replace(from_state(state, *box.sizes()), frequency=self.frequency, period=period)
            put_motions(box, start, only_state=True)
            return self._orbit(box)

    def _orbit(self, box: Box) -> Motion | None:
        """What shooting from the motion in a box finds."""
        try:
            box.check(box.work("shoot", quiet()))
        except SolverError:
            return None
        return Motion(train=self.train, **motions_of(box)[0])

    def balance(self, guess: Motion) -> list[Motion]:
        """The motions of the truncated balance near a waveform, one or none."""
        try:
            branch: Branch = self.train.response(
                start=self.frequency, stop=_NEARBY * self.frequency, subharmonic=guess.period, seed=guess,
                harmonics=_HARMONICS * guess.period, max_points=2, stability=False)
        except SolverError:
            return []
        return branch.at(self.frequency)

    def add_near(self, motion: Motion, how: str) -> None:
        """Add the exact orbit near a motion, where there is one."""
        orbit = self._nearest(motion)
        if orbit is not None:
            self.add(orbit, how)

    def add_balanced(self, motion: Motion, how: str, followed: Iterable[str]) -> None:
        """Add the exact orbit near a motion of a branch; where shooting leads away it is balanced more exactly first."""
        orbit = self._nearest(motion)
        if orbit is None or not _agree(orbit, motion):
            try:
                exact = self.train.response(seed=motion, subharmonic=motion.period, start=self.frequency,
                                            stop=_NEARBY * self.frequency, harmonics=0, tolerance=_EXACT, stability=False)
                orbit = self._nearest(exact.at(self.frequency)[0]) or orbit
            except (SolverError, IndexError):
                pass
        if orbit is not None:
            self.add(orbit, how, followed=followed)

    def _nearest(self, motion: Motion) -> Motion | None:
        with self.train._ask_at(self.frequency, {}) as box:
            put_motions(box, motion)
            return self._orbit(box)

    def add(self, motion: Motion, how: str, *, followed: Iterable[str] = ()) -> None:
        """Add an orbit, with its least period, unless it is known or its period is too long.

        ``followed`` are the lists of those followed that its branch is in.
        """
        least = least_period(motion)
        if least < motion.period and motion.state is not None:
            shorter = self.shoot(motion.state, least)
            if shorter is None or not same_orbit(replace_period(shorter, motion.period), motion):
                return
            motion = shorter
        if motion.period > self.period:
            return
        same = next((other for other, _ in self.found if same_orbit(motion, other)), None)
        if same is None:
            self.found.append((motion, how))
            self._add_images(motion, how)
        for name in followed:
            self.followed[name].append(same or motion)

    def _add_images(self, motion: Motion, how: str) -> None:
        """Add what turns of planets make of a motion."""
        for image in self.images.of(motion):
            orbit = self._nearest(image)
            if orbit is None or not same_orbit(orbit, image):
                continue
            self.found.append((orbit, f"{how}, with planets exchanged"))
            self.turned.append(orbit)
            for followed in self.followed.values():
                followed.append(orbit)

    def adds_up(self) -> bool:
        motions = [motion for motion, _ in self.found]
        return adds_up({n: index_sum(motions, n) for n in self.expected_sum}, self.expected_sum) is not False


def _random_states(
    train: Any, frequency: float, known: _Known, others: Sequence[Motion], spread: float, moments: np.random.Generator, number: int
) -> Iterator[tuple[Array, str]]:
    """States in a box round all that is known, and what they become after some periods."""
    states = [motion.state for motion in (*(motion for motion, _ in known.found), *others) if motion.state is not None]
    if not states:
        return
    reach = spread * np.abs(states).max(axis=0)
    reach = np.maximum(reach, 1e-3 * reach.max())
    for _ in range((number + 1) // 2):
        state = moments.uniform(-reach, reach)
        yield state, "a random state"
        try:
            later = train.integrate(frequency, start=state, max_periods=int(moments.choice(_SETTLING)), stability=False)
        except SolverError:  # it grows without bound
            continue
        if later.state is not None:
            yield later.state, "the flow from a random state"


def _random_waveforms(
    known: _Known, others: Sequence[Motion], spread: float, moments: np.random.Generator, number: int
) -> Iterator[Motion]:
    """Motions known with a little added to them, and waveforms about as large as what is known; more of them for longer periods.

    Their harmonics fall as those behind a natural frequency do. Newton's method on the balance finds from them what random states
    hardly find, motions that a flow leaves at once.
    """
    found = [motion for motion, _ in known.found]
    motions = [*found, *others]
    if not motions:
        return
    try:
        known.train._ask(response={"start": known.frequency, "stop": _NEARBY * known.frequency, "harmonics": _HARMONICS})
    except InputError:  # the meshes are excited at higher harmonics, as those of a gearbox are by its slowest shaft
        return
    scale = np.max([np.maximum(np.abs(motion.mean), motion.rms) for motion in motions], axis=0)
    scale = np.maximum(scale, 1e-3 * scale.max())[:, None]
    ratio = known.frequency / _frequency_of_meshes(known.train)
    periods = np.arange(1, known.period + 1)
    for _ in range(number):
        period = int(moments.choice(periods, p=periods / periods.sum()))
        of_this_period = [motion for motion in found if period % motion.period == 0]
        near = len(of_this_period) > 0 and moments.random() < _NEAR
        if near:
            decades = moments.uniform(*_NEARER) + moments.uniform(-_UNEVEN, _UNEVEN, scale.shape)
        else:
            decades = moments.uniform(*_DECADES, scale.shape)
        order = np.arange(1, _HARMONICS * period + 1) / period
        sizes = spread * scale * 10**decades / (order * (1 + (order * ratio) ** 2))
        coefficients = np.zeros((len(scale), 1 + 2 * len(order)))
        coefficients[:, 1::2] = sizes * moments.normal(size=sizes.shape)
        coefficients[:, 2::2] = sizes * moments.normal(size=sizes.shape)
        if near:
            beside = replace_period(of_this_period[moments.choice(len(of_this_period))], period).coefficients
            kept = min(beside.shape[1], coefficients.shape[1])
            coefficients[:, :kept] += beside[:, :kept]
            coefficients[:, 0] += (scale * 10**decades)[:, 0] * moments.normal(size=len(scale))
        else:
            coefficients[:, 0] = motions[moments.choice(len(motions))].mean * moments.uniform(*_MEANS, len(scale))
        yield replace(motions[0], period=period, coefficients=coefficients, state=None, multipliers=None)


def _frequency_of_meshes(train: Any) -> float:
    """Natural frequency of the train, in Lambda, each mode counted as much as the meshes have of its energy."""
    modes = train.modes()
    shares = [
        sum(share for element, share in modes.energy_shares(mode).items() if element.startswith("mesh"))
        for mode in range(1, len(modes.natural_frequency) + 1)
    ]
    return float(np.average(modes.natural_frequency, weights=shares))


def _distinct(motions: Iterable[Motion]) -> Iterator[Motion]:
    """Each motion once, by its period and rms."""
    seen: set[Any] = set()
    for motion in motions:
        key = motion.period, *(f"{rms:.3e}" for rms in motion.rms)
        if key not in seen:
            seen.add(key)
            yield motion


def _round_about(train: Any, frequency: float, doublings: int, **settings: Any) -> list[Branch]:
    """The branch of motions that passes a Lambda, the response unless another is told; with doublings also what bifurcates.

    Shooting makes every motion exact afterwards: a tighter tolerance would cost ten times as much and find no more.
    """
    low, high = _ROUND
    branch: Branch = train.response(start=low * frequency, stop=high * frequency, harmonics=0, tolerance=_ROUGH, max_points=_POINTS,
                                    period_doublings=doublings, branch_points=doublings > 0, **settings)
    return [branch, *branch.branches]


def _follow(train: Any, frequency: float, known: _Known) -> None:
    """The other motions at this speed on the branches of those known: each has its other half behind a fold.

    Over the gap of a mesh an island may hang together with another one. What bifurcates from the branches over speed costs ten
    times as much. It is followed where the indices show that motions are missing.
    """
    for name, followed in known.followed.items():
        for motion, _ in known.found:  # which grows meanwhile
            if motion in followed or (name == _DEEP and known.adds_up()):
                continue
            followed.append(motion)
            if name.startswith("mesh ") and known.images.repeats(motion, int(name.split()[1])):
                continue
            how = f"the branch of the motion of period {motion.period}"
            if name in (_SPEED, _DEEP):
                _follow_over_speed(train, frequency, known, motion, how, deep=name == _DEEP)
            else:
                _follow_over_gap(train, frequency, known, motion, name, f"{how} over {name}")
    if any(motion not in known.followed[_SPEED] for motion, _ in known.found):
        _follow(train, frequency, known)


def _follow_over_speed(train: Any, frequency: float, known: _Known, motion: Motion, how: str, *, deep: bool) -> None:
    """The motions at this speed on the branch of a motion, and when deep on what bifurcates from it."""
    doublings = (known.period // motion.period).bit_length() - 1 if deep else 0
    try:
        branches = _round_about(train, frequency, doublings, subharmonic=motion.period, seed=motion)
    except SolverError:
        return
    for branch in branches:
        origin = f"{branch.origin}, of " if branch.origin else ""
        for other in branch.at(frequency):
            known.add_balanced(other, f"{origin}{how}", (_SPEED, _DEEP) if deep else (_SPEED,))


def _follow_over_gap(train: Any, frequency: float, known: _Known, motion: Motion, gap: str, how: str) -> None:
    """The motions of the train on the branch of one of them over the gap of a mesh."""
    own = value_in(train, gap)
    assert own is not None  # as `_gaps` gives it
    low, high = _WIDTH
    try:
        branch = train.continuation(parameter=gap, start=low * own, stop=high * own, frequency=frequency, seed=motion,
                                    subharmonic=motion.period, harmonics=0, tolerance=_ROUGH, max_points=_POINTS, stability=False)
    except (SolverError, InputError):  # there are gaps with which the train is out of order
        return
    for other in branch.at(own):
        known.add_balanced(other, how, (gap,))


def _gaps(train: Any) -> list[str]:
    """Names of the gaps of the meshes that have one."""
    names = [f"mesh {mesh} {name}" for mesh in range(1, len(train.meshes) + 1) for name in ("half_backlash", "backlash")]
    names += [f"coupling {number} half_play" for number in range(1, len(train.couplings) + 1)]
    names += [f"bearing {number} half_clearance" for number in range(1, len(train.bearings) + 1)]
    return [name for name in names if value_in(train, name)]


def _leave_unstable(train: Any, frequency: float, known: _Known, pushed: set[int]) -> None:
    """What the flows on either side of each unstable motion settle on."""
    for motion, _ in list(known.found):
        if motion.stable or motion.state is None or id(motion) in pushed or any(motion is turned for turned in known.turned):
            continue
        pushed.add(id(motion))
        for push in (_PUSH, -_PUSH):
            try:
                later = train.integrate(frequency, start=motion.state * (1 + push))
            except SolverError:  # it grows without bound
                continue
            if 0 < later.period <= known.period:
                known.add_near(later, f"the flow beside the unstable motion of period {motion.period}")


def _multipliers_at_infinity(train: Any, frequency: float) -> NDArray[np.complex128] | None:
    """Those of the train without backlash; None where the train is not linear at large amplitude either."""
    if any(mesh.back_phase or mesh.back_stiffness not in (None, mesh.stiffness) for mesh in train.meshes):
        return None
    if any(coupling.angle for coupling in train.couplings):
        return None
    linear = replace(train, meshes=[replace(mesh, half_backlash=0.0, backlash=0.0) for mesh in train.meshes],
                     couplings=[replace(coupling, half_play=0.0) for coupling in train.couplings],
                     bearings=[replace(bearing, half_clearance=0.0, flats=None) for bearing in train.bearings])
    branch = linear.response(start=frequency, stop=_NEARBY * frequency, harmonics=0, tolerance=_ROUGH, amplitude_limit=1e15)
    multipliers: NDArray[np.complex128] | None = branch.multipliers
    return None if multipliers is None else multipliers[0]


def _agree(orbit: Motion, motion: Motion) -> bool:
    """Whether the waveform of an orbit is within the tolerance that the motion was balanced to."""
    return orbit.period == motion.period and float(np.abs(orbit.rms - motion.rms).max()) <= _ROUGH * float(orbit.rms.max())
