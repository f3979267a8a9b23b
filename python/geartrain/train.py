"""A gear train and what can be asked of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._core.box import Box
from ._core.description import Description
from ._core.gradient import gradient_of
from ._core.namelist import in_words_of_the_call
from ._core.parameter import value_in, with_values
from ._core.units import Unit, lambda_of, units_of
from ._core.variable import takes
from ._core.watch import quiet, watched
from .errors import InputError, SolverError, shown
from .plots.draw import new_axes
from .plots.planetary_picture import draw_stage
from .plots.schematic import draw_schematic, figure_size
from .results.attractors import Attractors
from .results.basins import Basins
from .results.bifurcation_diagram import BifurcationDiagram
from .results.branch import Branch
from .results.campbell import Campbell
from .results.exact_point import ExactPoint
from .results.locus import Locus
from .results.lyapunov import LyapunovSpectrum
from .results.modes import Modes
from .results.motion import Motion, from_state
from .results.motion_search import find_motions
from .results.motion_table import motions_of, put_motions
from .results.motions import Motions
from .results.run_up import RunUp
from .results.special_point import SpecialPoint
from .results.stability_map import StabilityMap
from .results.sweep import Sweep
from .variables import (
    PARTS,
    VARIABLES,
    AttractorsKeywords,
    BasinsKeywords,
    BifurcationDiagramKeywords,
    IntegrateKeywords,
    IntegrationKeywords,
    ResponseKeywords,
    RunUpKeywords,
    StabilityMapKeywords,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from typing_extensions import Self, Unpack


__all__ = ["Train"]

Result = TypeVar("Result")


class Train(Description):
    """A gear train: M shafts in a chain, M-1 meshes between them, an inertia at either end. All input is SI.

    Every name is that of the case file. What is not given takes the case file's default. A train cannot be changed;
    ``dataclasses.replace`` makes a changed one.

    Parameters
    ----------
    **variables
    shafts : sequence of Shaft
    meshes : sequence of Mesh

    Raises
    ------
    InputError
        Where a value is not allowed; the message tells every problem.

    Examples
    --------
    The single pair x'' + 0.1 x' + (1 + 0.3 cos Lambda t) g(x) = 0.4:

    >>> import geartrain as gt
    >>> pair = gt.Train(
    ...     input_torque=0.4, prime_mover_inertia=0.0, load_inertia=0.0,
    ...     characteristic_length=1.0, characteristic_frequency=1.0,
    ...     shafts=[gt.Shaft(rigid=True), gt.Shaft(rigid=True)],
    ...     meshes=[gt.Mesh(driving_radius=1.0, driven_radius=1.0, driving_inertia=2.0, driven_inertia=2.0,
    ...                     stiffness=1.0, damping_ratio=0.05, half_backlash=1.0, stiffness_cos=[0.3])])
    >>> pair.natural_frequencies()
    array([1.])
    >>> pair.integrate(frequency=0.8).true_ac_rms.round(6)
    array([0.251373])
    """

    #: What a train was made of where it was read from a file of another program: what was assumed, is missing, is not used.
    notes = ()  # type: tuple[str, ...]

    def with_values(self, values: Mapping[str, Any]) -> Self:
        """A train like this one with other values of parameters, as an optimiser or a loop over designs wants it.

        Parameters
        ----------
        values : mapping
            A value each, in the unit of its variable in the case: SI, but for angles of the drawing, ``'mesh 1 helix_angle'``,
            in degrees. The names are those of `Space` and `Motion.gradient`: ``'input_torque'``, ``'mesh 2 half_backlash'``,
            ``'mesh * damping_ratio'`` of all meshes, ``'mesh 1 stiffness_cos 2'`` of a list, ``'stiffness_variation'``, the largest
            amplitude of all harmonics of the mesh stiffnesses, which the train then gives in place of what they follow from; a
            tuple of names for several with the same value. A list, ``'mesh 1 driving_pitch_error'``, takes all its numbers.

        Raises
        ------
        InputError
            Where a name is unknown, a value is not allowed, or one variable is set twice.

        Examples
        --------
        >>> softer = train.with_values({"shaft 2 stiffness": 2e7, "mesh * damping_ratio": 0.06})
        >>> softer.shafts[1].stiffness, [mesh.damping_ratio for mesh in softer.meshes]
        (20000000.0, [0.06, 0.06])
        """
        return with_values(self, values)

    def natural_frequencies(self, *, unit: Unit = "Lambda") -> NDArray[np.float64]:
        """Undamped natural frequencies of the mean system, ascending.

        Parameters
        ----------
        unit : {'Lambda', 'rpm', 'Hz'}
            Lambda: over the characteristic frequency. rpm: the speed at which the fundamental has that frequency, as Lambda is
            where ``characteristic_frequency`` is left out. Hz: what a measurement tells.

        Returns
        -------
        ndarray, (modes,)
            The elastic modes; a rigid-body mode is left out.

        Examples
        --------
        >>> train.natural_frequencies(unit="Hz").round(1)
        array([ 1503.4,  2931.6, 10494.4, 10494.9, 25009.1])
        """
        return self.modes().natural_frequency / lambda_of(self, 1.0, unit)

    @property
    def rigid_motions(self) -> NDArray[np.float64]:
        """Rotation of each body in the motions that deflect no element, the largest 1, (motions, bodies); bodies turn in their own
        senses. One motion turns the whole train, a differential has two, a train that a spring to ground holds has none."""
        found = self.modes().rigid_rotation
        return np.zeros((0, len(self.body_labels))) if found is None else found

    def frequency_gradient(self, parameters: Sequence[str], *, unit: Unit = "Lambda") -> NDArray[np.float64]:
        """Derivatives of the natural frequencies with respect to parameters.

        Parameters
        ----------
        parameters : sequence of str
            As in `Motion.gradient`, whose errors and warnings are these as well.
        unit : {'Lambda', 'rpm', 'Hz'}
            Of the natural frequencies, as in `natural_frequencies`.

        Returns
        -------
        ndarray, (modes, parameters)
            x . (dK - omega^2 dM) x/(2 omega) with the mode x of x . M x = 1, over the unit of the parameter; NaN where natural
            frequencies that are equal part.

        Examples
        --------
        >>> (train.frequency_gradient(["mesh * stiffness"], unit="Hz")[:2, 0] * 1e6).round(2)  # Hz per N/um
        array([1.53, 5.78])
        """
        return gradient_of(Box(copy=self._kept), "/frequency", parameters) / lambda_of(self, 1.0, unit)

    def modes(self) -> Modes:
        """Natural frequencies, damping ratios and mode shapes of the mean system."""
        return self._found("modes", {}, lambda box: Modes._from(box, self), in_parts=False)

    @takes(VARIABLES["response"], ResponseKeywords)
    def response(self, *, seed: Motion | None = None, **settings: Unpack[ResponseKeywords]) -> Branch:
        """Follow the periodic motions by harmonic balance and continuation, through the folds.

        Parameters
        ----------
        **settings
            The variables of ``&response``.
        seed : Motion, optional
            A motion of the branch wanted, to start from in place of ``start``.

        Returns
        -------
        Branch
            Its ``ended`` tells why it ended; its ``branches`` are those that bifurcate from it.

        Raises
        ------
        InputError
        Interrupted
            On Ctrl-C, with the branch so far.

        Examples
        --------
        With ``train`` as in the package's example:

        >>> branch = train.response(start=0.2, stop=2.6)
        >>> branch.rms.max(axis=0).round(2)
        array([0.86, 3.05])
        >>> [round(special.frequency, 3) for special in branch.special_points if special.kind == "fold"]
        [0.462, 0.459, 0.792, 0.566, 0.732, 0.616, 1.664, 1.547]

        Period-2 motions as well:

        >>> both = train.response(start=2.2, stop=4.2, period_doublings=1)
        >>> [(twice.subharmonic, twice.origin[:47]) for twice in both.branches]
        [(2, 'period doubling of the response at Lambda = 3.5')]
        """
        asked = self._ask(response=settings)
        if seed is not None and not isinstance(seed, Motion):
            raise InputError(f"seed = {shown(seed)}: must be a gt.Motion")
        if seed is not None and seed.unbounded:
            raise InputError("seed: a motion that grew without bound: must be a periodic one")

        def work(progress: NDArray[np.float64]) -> Branch:
            with asked as box:
                if seed is not None:
                    put_motions(box, seed, what="seed")
                status = box.run("response", progress)
                branch = Branch._from(box, self, settings)
                box.check(status, whole=branch is None)
                if branch is None:
                    raise SolverError(box.ended() or "no point found")
                branch.branches.extend(Branch._all_from(box, self, settings))
                return branch

        return watched(work, "response")

    def continuation(
        self, *, parameter: str, start: float, stop: float, frequency: float, seed: Motion | None = None, **settings: Any
    ) -> Branch:
        """Follow the periodic motions at constant frequency over a parameter of the train, through the folds.

        Parameters
        ----------
        parameter : str
            A number of the train, as in `Train.with_values`: ``'input_torque'``, ``'mesh 2 half_backlash'``,
            ``'shaft 2 stiffness'``, ``'mesh * damping_ratio'`` (of all meshes alike), ``'stiffness_variation'``.
        start, stop : float
            First and last value, in the unit of the parameter, in either order; 0 and below where the parameter may be.
        frequency : float
            Lambda, or in ``unit``.
        seed : Motion, optional
            A motion at this frequency to start from in place of ``start``: of this train, whose own value of the parameter lies
            between ``start`` and ``stop``, or of this train with such a value, as `Branch.at` of another branch over the parameter
            gives it.
        **settings
            Further variables of ``&response``.

        Returns
        -------
        Branch
            Its ``parameter`` has the values, its ``frequency`` is constant. Special points, peaks and jumps have the value as well.

        Raises
        ------
        InputError
            Also where the train is out of order with a value in the range, or of another kind: with another number of coordinates.
        SolverError
            No motion to start from.
        Interrupted
            On Ctrl-C, with the branch so far.

        Examples
        --------
        >>> over = train.continuation(parameter="input_torque", start=100, stop=400, frequency=0.7)
        >>> over.parameter[[0, -1]], over.parameter_unit, over.complete
        (array([100., 400.]), 'N m', True)
        """
        if not isinstance(parameter, str) or not parameter.strip():
            raise InputError(f"parameter = {shown(parameter)}: must be the name of a number of the train, as 'input_torque'")
        train = self
        if isinstance(seed, Motion) and isinstance(seed.train, Description):
            at = value_in(seed.train, parameter)
            train = self if at is None else self.with_values({parameter: at})
        asked: Any = {"start": start, "stop": stop, "parameter": parameter, "frequency": frequency, **settings}
        branch: Branch = train.response(seed=seed, **asked)
        return branch

    @takes(VARIABLES["integration"], IntegrateKeywords, stability=True)
    def integrate(
        self, frequency: float, *, start: Motion | ArrayLike | None = None, **settings: Unpack[IntegrateKeywords]
    ) -> Motion:
        """Integrate over time until the motion is steady.

        Parameters
        ----------
        frequency : float
            Lambda, or in ``unit``.
        start : Motion or array_like, optional
            Where to start: a motion, or displacement and then velocity of every elastic element, (2*elements,), as
            ``Motion.state``.
        **settings
            Variables of ``&integration``.

        Returns
        -------
        Motion
            Its ``period`` is 0 where none was found.

        Raises
        ------
        SolverError
            Where the motion grows without bound.

        Examples
        --------
        >>> motion = train.integrate(frequency=1.92)
        >>> motion.period, motion.rms.round(6)
        (2, array([0.456399, 0.549464]))
        """
        asked = self._ask_at(frequency, settings)
        at = lambda_of(self, frequency, settings["unit"])

        def work(progress: NDArray[np.float64]) -> Motion:
            with asked as box:
                self._put_start(box, start, "start")
                box.check(box.work("integrate", progress, at))
                return Motion(train=self, **motions_of(box)[0])

        return watched(work, "integration")

    @takes(VARIABLES["integration"], IntegrationKeywords)
    def sweep(self, **settings: Unpack[IntegrationKeywords]) -> Sweep:
        """Integrate at one frequency after another, each from where the one before settled.

        Parameters
        ----------
        **settings
            The variables of ``&integration``.

        Returns
        -------
        Sweep
            A list of `Motion` that also knows its ``direction``.

        Examples
        --------
        A jump: the motion at 0.6 depends on where it came from.

        >>> motions = train.sweep(start=0.4, stop=0.8, points=3, direction="both")
        >>> motions.direction
        ('up', 'up', 'up', 'down', 'down', 'down')
        >>> motions.rms[[1, 4], 1].round(3)
        array([0.212, 2.133])
        """
        asked = self._ask(integration=settings)

        def work(progress: NDArray[np.float64]) -> Sweep:
            with asked as box:
                status = box.run("integration", progress)
                motions = Sweep._from(box, self)
                box.check(status, whole=not motions)
                return motions

        return watched(work, "integration", settings["points"] * (1 + (settings["direction"] == "both")))

    @takes(VARIABLES["attractors"], AttractorsKeywords)
    def attractors(
        self, frequency: float, *, follow: Branch | bool = False, **settings: Unpack[AttractorsKeywords]
    ) -> Attractors:
        """The steady motions on which random starts settle.

        Parameters
        ----------
        frequency : float
            Lambda, or in ``unit``.
        **settings
            Variables of ``&attractors``.
        follow : Branch, optional
            A response: each motion found that lies neither on it nor on its ``branches`` is followed with the response's settings
            over its range, as an island that closes on itself where it does.

        Returns
        -------
        Attractors
            A list of `Motion`, each with its ``share`` of the starts; ``unsettled`` is the share of those that settled on none,
            ``branches`` are those followed.

        Examples
        --------
        >>> found = train.attractors(frequency=0.6, starts=20)
        >>> for motion in found:
        ...     print(f"{motion.share:.2f} {motion.rms.round(3)}")
        0.70 [0.166 0.212]
        0.30 [0.493 2.133]
        >>> found.unsettled
        0.0
        """
        if follow is True or not isinstance(follow, (bool, Branch)):
            raise InputError(f"follow = {shown(follow)}: must be a gt.Branch, the response whose range and settings are meant")
        known = follow if isinstance(follow, Branch) else None
        traced = None if known is None else known.settings
        asked = self._ask(response=traced, attractors={"frequency": frequency, "follow": known is not None, **settings})

        def work(progress: NDArray[np.float64]) -> Attractors:
            with asked as box:
                branches = [] if known is None else [known, *known.branches]
                for place, branch in enumerate(branches):
                    branch._put(box, place)
                box.check(box.run("attractors", progress))
                return Attractors._from(box, self, Branch._all_from(box, self, traced or {}, max(1, len(branches))))

        return watched(work, "attractors", settings["starts"])

    @takes(VARIABLES["basins"], BasinsKeywords)
    def basins(
        self, frequency: float, mesh: int = 1, points: tuple[int, int] = (200, 200), *,
        state: Motion | ArrayLike | None = None, **settings: Unpack[BasinsKeywords],
    ) -> Basins:
        """Which steady motion each start reaches, over displacement and velocity of a mesh at phase 0, on all cores.

        The motions are found by random starts first. Each start of the grid flies until it is in a ball about a known motion that
        no flow leaves; what is in none after ``max_periods`` is settled the long way and may add a motion.

        Parameters
        ----------
        frequency : float
            Lambda, or in ``unit``.
        mesh : int
            Number of the mesh, from 1, that closes no loop.
        points : (int, int)
            Starts along the displacement and along the velocity.
        state : Motion or array_like, optional
            What the starts have beside: that of a motion, or displacement and then velocity of every elastic element, as
            ``Motion.state``; at rest unless told.
        **settings
            Variables of ``&basins``.

        Returns
        -------
        Basins

        Raises
        ------
        InputError
        Interrupted
            On Ctrl-C, with the rows so far.

        Examples
        --------
        >>> basins = train.basins(0.7, mesh=2, points=(20, 20), starts=20)
        >>> basins.label.shape, basins.complete
        ((20, 20), True)
        """
        if (not isinstance(points, Sequence) or len(points) != 2
                or any(isinstance(value, bool) or not isinstance(value, Integral) for value in points)):
            raise InputError(f"points = {shown(points)}: must be two whole numbers, along the displacement and the velocity")
        grid = {"displacement_points": int(points[0]), "velocity_points": int(points[1])}
        asked = self._ask(basins={"frequency": frequency, "mesh": mesh, **grid, **settings})

        def work(progress: NDArray[np.float64]) -> Basins:
            with asked as box:
                self._put_start(box, state, "state")
                status = box.run("basins", progress)
                found = Basins._from(box, self)
                box.check(status, whole=found is None)
                if found is None:
                    raise SolverError("nothing found")
                return found

        return watched(work, "basins", grid["velocity_points"], "rows")

    @takes(VARIABLES["bifurcation_diagram"], BifurcationDiagramKeywords)
    def bifurcation_diagram(
        self, *, seed: Motion | ArrayLike | None = None, **settings: Unpack[BifurcationDiagramKeywords]
    ) -> BifurcationDiagram:
        """Sections of the attractors over frequency, with their Lyapunov exponents and rotation numbers; up and down at once.

        Parameters
        ----------
        **settings
            The variables of ``&bifurcation_diagram``.
        seed : Motion or array_like, optional
            What each direction begins with: a motion, or a state as ``Motion.state``; at rest unless told.

        Returns
        -------
        BifurcationDiagram

        Raises
        ------
        InputError
        Interrupted
            On Ctrl-C, with the points so far.

        Examples
        --------
        >>> diagram = train.bifurcation_diagram(start=1.85, stop=2.0, points=2, direction="up")
        >>> diagram.period, diagram.displacement.shape
        (array([2, 2], dtype=int32), (2, 200, 2))
        """
        return self._diagram(seed, "seed", settings)

    def _diagram(self, seed: Motion | ArrayLike | None, what: str, settings: Mapping[str, Any]) -> BifurcationDiagram:
        asked = self._ask(bifurcation_diagram=settings)

        def work(progress: NDArray[np.float64]) -> BifurcationDiagram:
            with asked as box:
                self._put_start(box, seed, what)
                status = box.run("bifurcation_diagram", progress)
                found = BifurcationDiagram._from(box, self)
                box.check(status, whole=found is None)
                if found is None:
                    raise SolverError("nothing found")
                return found

        return watched(work, "bifurcation diagram", settings["points"] * (1 + (settings["direction"] == "both")))

    def lyapunov_spectrum(
        self, frequency: float, *, unit: Unit = "Lambda", start: Motion | ArrayLike | None = None, transient: int = 500,
        periods: int = 4000, long_period: bool = False,
    ) -> LyapunovSpectrum:
        """All Lyapunov exponents of what the flow does in the long run, and its sections.

        Parameters
        ----------
        frequency : float
            Lambda, or in ``unit``.
        unit : {'Lambda', 'rpm', 'Hz'}
        start : Motion or array_like, optional
            Where to start: a motion, or a state as ``Motion.state``; at rest unless told.
        transient, periods : int, default 500 and 4000
            Periods of the fundamental before the average, and those averaged over; where the average drifts, the last part of them
            whose halves agree. Where the kind is ``'undecided'`` more of them decide. A chaotic transient that lasts longer than
            both is taken for the attractor.
        long_period : bool
            Computed even where a period has more than 500 cycles of a mesh, as with hunting teeth.

        Returns
        -------
        LyapunovSpectrum

        Raises
        ------
        InputError
        SolverError
            Where the flow grows without bound, or does not settle otherwise.
        Interrupted
            On Ctrl-C.

        Examples
        --------
        >>> spectrum = train.lyapunov_spectrum(1.92, periods=200)
        >>> spectrum.kind, spectrum.dimension
        ('periodic', 0.0)
        """
        try:
            found = self._diagram(start, "start", {"start": frequency, "stop": frequency, "unit": unit, "points": 1,
                                                   "direction": "up", "transient": transient, "sections": periods,
                                                   "long_period": long_period})
        except InputError as error:
            told = in_words_of_the_call(str(error), {"start": "frequency", "stop": "frequency", "sections": "periods"})
            told = told.replace("&bifurcation_diagram", "lyapunov_spectrum")
            raise InputError("\n".join(dict.fromkeys(told.splitlines()))) from None
        if not np.isfinite(found.lyapunov_exponents).all():
            raise SolverError(f"lyapunov_spectrum: no exponents at Lambda = {found.frequency[0]:g}: the flow is {found.kind[0]}")
        return LyapunovSpectrum._of(found)

    def motions(
        self, frequency: float, *, unit: Unit = "Lambda", period: int = 4, starts: int = 100, seeds: int = 200,
        random_seed: int = 0, response: Branch | None = None,
    ) -> Motions:
        """Every periodic motion at one speed that can be found, stable or not, each to about 1e-11.

        Looked for on the response and its period-doubled and crossing branches, by random starts of time integration, by shooting
        for every period from random states and from what these become after some periods of time integration, and by the balance
        from random waveforms; further ones are tried where the sum of indices shows that motions are missing (`Motions`), and as
        long as they find something new. Islands whose motions at this speed are all unstable are found by the random states and
        waveforms alone.

        Parameters
        ----------
        frequency : float
            Lambda, or in ``unit``.
        unit : {'Lambda', 'rpm', 'Hz'}
        period : int
            Longest period, in periods of the fundamental, 64 at most.
        starts : int
            Random starts of time integration.
        seeds : int
            Random states to begin shooting from; four times as many random waveforms for the balance; of both up to four times as
            many where motions are missing or the last ones found something new.
        random_seed : int
        response : Branch, optional
            A response that reaches this speed; one is followed round about it unless told.

        Returns
        -------
        Motions
            A list of `Motion`; ``how`` tells how each was found, ``complete`` whether the indices add up.

        Raises
        ------
        InputError
        Interrupted
            On Ctrl-C.

        Examples
        --------
        >>> found = train.motions(0.7, period=2, starts=20, seeds=40)
        >>> [(motion.period, bool(motion.stable)) for motion in found], found.index_sum
        ([(1, True), (1, True), (1, True), (1, False), (1, False)], {1: 1, 2: 1})
        """
        return find_motions(self, frequency, unit, period, starts, seeds, random_seed, response)

    @takes(VARIABLES["stability_map"], StabilityMapKeywords)
    def stability_map(self, **settings: Unpack[StabilityMapKeywords]) -> StabilityMap:
        """Stability over frequency and one parameter of the train, on all cores.

        Parameters
        ----------
        **settings
            The variables of ``&stability_map``. ``parameter`` is a number of the train, as in `Train.continuation`; trains with
            teeth need ``harmonics=0``.

        Returns
        -------
        StabilityMap

        Raises
        ------
        InputError
        Interrupted
            On Ctrl-C, with the rows so far.

        Examples
        --------
        >>> chart = train.stability_map(start=1.7, stop=2.1, points=41, parameter_start=0.0, parameter_stop=0.3,
        ...                             parameter_points=4, linear=True)
        >>> chart.frequency[chart.spectral_radius[-1] > 1][[0, -1]].round(2)
        array([1.78, 2.04])

        Over any number of a train that is given by its drawing:

        >>> reducer = gt.read_case("namelists/reducer.nml").train
        >>> chart = reducer.stability_map(start=1500, stop=1600, unit="rpm", points=2, harmonics=0, parameter="motor torque",
        ...                               parameter_start=60.0, parameter_stop=90.0, parameter_points=2)
        >>> chart.stable_motions
        array([[1, 1],
               [1, 1]], dtype=int32)
        """
        bar = settings["parameter_points"], "rows", settings["parameter"]
        return self._found("stability_map", settings, lambda box: StabilityMap._from(box, self), *bar)

    def campbell(self, *, start: float, stop: float, unit: Unit | None = None) -> Campbell:
        """Natural frequencies of the mean train, the orders that excite them, and the speeds where they meet.

        Parameters
        ----------
        start, stop : float
            Range of the frequency.
        unit : {'Lambda', 'rpm', 'Hz'}, optional
            Of the range; unless told rpm where Lambda is the speed in rpm, else Lambda.

        Returns
        -------
        Campbell
            Printed it is a table of the crossings, ranked by the mesh force that they make.

        Examples
        --------
        >>> diagram = train.campbell(start=0.2, stop=2.6)
        >>> [(crossing.mode, round(crossing.frequency, 3)) for crossing in diagram.crossings]
        [(1, 0.957), (2, 1.866)]
        """
        in_unit = units_of(self, unit).unit
        for name, value in (("start", start), ("stop", stop)):
            if isinstance(value, bool) or not isinstance(value, Real) or not 0 < value < float("inf"):
                raise InputError(f"{name} = {shown(value)}: must be a number > 0")
        return Campbell.of(self, self.modes(), lambda_of(self, start, in_unit), lambda_of(self, stop, in_unit))

    def plot(self, ax: Axes | None = None, *, speed: float | None = None) -> Axes:
        """Draw the train: bodies as discs, larger with their base radii and dashed without a gear; shafts as lines, meshes dotted.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; a new figure unless told.
        speed : float, optional
            In rpm, of the body that tells the speed: the speed of every body is told then, else its turns per turn of that body.

        Returns
        -------
        matplotlib.axes.Axes

        Examples
        --------
        >>> train.plot().figure.savefig("train.png")  # doctest: +SKIP
        """
        return draw_schematic(self, new_axes(ax, figsize=figure_size(self)), speed=speed)

    def plot_stage(self, name: str | None = None, *, speed: float | None = None) -> Axes:
        """Draw a planetary set: front view with the planets at their angles, and beside it the lever diagram of the speeds.

        Each planet has its share of the static load. The lever has sun, carrier and ring at distances by their teeth; the speeds
        across it lie on a line.

        Parameters
        ----------
        name : str, optional
            Of the set, as `explain` has it; the first unless told.
        speed : float, optional
            In rpm, of the body that tells the speed; unless told speeds are turns per turn of that body.

        Returns
        -------
        matplotlib.axes.Axes
            Of the front view; the lever diagram is the other one of its figure.

        Examples
        --------
        >>> train.plot_stage("stage 1").figure.savefig("stage.png")  # doctest: +SKIP
        """
        front, lever = new_axes(None, ncols=2, figsize=(8.5, 4.6), width_ratios=(1.2, 1.0))
        return draw_stage(self, name, (front, lever), speed)

    @takes(VARIABLES["run_up"], RunUpKeywords)
    def run_up(self, *, seed: Motion | ArrayLike | None = None, **settings: Unpack[RunUpKeywords]) -> RunUp:
        """Integrate while the speed goes linearly in time from one value to another, up or down.

        Parameters
        ----------
        **settings
            The variables of ``&run_up``.
        seed : Motion or array_like, optional
            What to settle from at ``start``: a motion, or a state as ``Motion.state``; at rest unless told. With
            ``max_periods=0`` the ramp begins with it as it is.

        Returns
        -------
        RunUp

        Raises
        ------
        InputError
        Interrupted
            On Ctrl-C, with the samples so far.

        Examples
        --------
        >>> run_up = train.run_up(start=0.4, stop=1.2, duration=0.5)
        >>> run_up.ended
        'reached Lambda = 1.2'
        >>> run_up.mesh_force_maximum.max(axis=0).round(-3)
        array([ 7000., 25000.])
        """
        asked = self._ask(run_up=settings)

        def work(progress: NDArray[np.float64]) -> RunUp:
            with asked as box:
                self._put_start(box, seed, "seed")
                status = box.run("run_up", progress)
                found = RunUp._from(box, self)
                box.check(status, whole=found is None)
                if found is None:
                    raise SolverError("nothing found")
                return found

        return watched(work, "run up", unit="periods")

    def locus(self, special: SpecialPoint | ExactPoint, *, parameter: str, start: float, stop: float) -> Locus:
        """Follow a special point or a contact onset of the exact motion over frequency and a number of the train.

        Parameters
        ----------
        special : SpecialPoint or ExactPoint
            A fold, a period doubling, a Neimark-Sacker point or a contact onset of this train; or a branch point, where the
            parameter leaves the train as symmetric as it is.
        parameter : str
            Name of the number, as in `Space`: ``'input_torque'``, ``'mesh 2 half_backlash'``, ``'stiffness_variation'``.
        start, stop : float
            Ends of the range of the parameter in its unit; the value that the train has lies between them.

        Returns
        -------
        Locus
            With the points at which two conditions meet: cusps, resonances, grazing.

        Raises
        ------
        InputError
        SolverError
            Where the exact motion has no such special point.
        Interrupted
            On Ctrl-C.

        Examples
        --------
        >>> fold = branch.special_points[0]
        >>> locus = train.locus(fold, parameter="stiffness_variation", start=0.25, stop=0.35)
        >>> locus.complete, locus.parameter[[0, -1]], [(point.kind, round(point.parameter, 4)) for point in locus.special_points]
        (True, array([0.35, 0.35]), [('grazing on a fold', 0.3274), ('cusp', 0.2681)])
        """
        if not isinstance(special, (SpecialPoint, ExactPoint)):
            raise InputError(f"special = {shown(special)}: must be a special point, one of a branch's special_points or onsets")
        if isinstance(special, SpecialPoint):
            self._refuse("locus")  # before the special point is made exact, which may take minutes
        exact = special.exact() if isinstance(special, SpecialPoint) else special
        settings = {"kind": exact.kind.replace(" ", "_"), "near": exact.frequency, "mesh": exact.mesh or 0,
                    "parameter": parameter, "start": start, "stop": stop}
        asked = self._ask(locus=settings)

        def work(progress: NDArray[np.float64]) -> Locus:
            with asked as box:
                put_motions(box, exact.motion, what="special")
                box.check(box.run("locus", progress))
                found = Locus._from(box, self)
                if found is None:
                    raise SolverError("nothing found")
                # The curve begins at the special point, which is exact.
                if np.abs(found.frequency - exact.frequency).min() > 1e-7 * exact.frequency:
                    raise InputError(f"special = {exact!r}: is of another train; this one has none there")
                return found

        return watched(work, "locus")

    @classmethod
    def _of(cls, groups: Sequence[tuple[str, dict[str, Any]]]) -> Train:
        """The train of a case's groups, as `_namelist.parse` gives them."""
        lists: dict[str, Any] = {
            parts: [kind(**values) for name, values in groups if name == group] for group, (parts, kind) in PARTS.items()
        }
        return cls(**dict(groups)["train"], **lists)

    def _refuse(self, what: str) -> None:
        """Raise `InputError` where the period is too long for ``'motions'`` or for a ``'locus'``."""
        with Box(copy=self._kept) as box:
            box.check(box.work(what, quiet()))

    @staticmethod
    def _put_start(box: Box, start: Motion | ArrayLike | None, what: str) -> None:
        """Put a motion, or a state of one, to start from; ``what`` is what messages call it."""
        if isinstance(start, Motion):
            put_motions(box, start, what=what)
        elif start is not None:
            put_motions(box, from_state(start, *box.sizes(), what), what=what, only_state=True)

    def _found(
        self, name: str, settings: Mapping[str, Any], take: Callable[[Box], Result | None], *bar: Any, **more: Any
    ) -> Result:
        """Run an analysis and take what it gives out of the box; what follows are arguments of `watched`."""
        asked = self._ask(**{name: settings})

        def work(progress: NDArray[np.float64]) -> Result:
            with asked as box:
                box.check(box.run(name, progress))
                found = take(box)
                if found is None:
                    raise SolverError("nothing found")
                return found

        return watched(work, name.replace("_", " "), *bar, **more)
