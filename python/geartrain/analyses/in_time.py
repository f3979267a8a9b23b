"""What time integration can be asked of a train."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Integral
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core.namelist import in_words_of_the_call
from .._core.units import Unit, lambda_of
from .._core.variable import takes
from .._core.watch import watched
from ..errors import InputError, SolverError, shown
from ..files.fmu import write_unit
from ..results.attractors import Attractors
from ..results.basins import Basins
from ..results.bifurcation_diagram import BifurcationDiagram
from ..results.branch import Branch
from ..results.lyapunov import LyapunovSpectrum
from ..results.motion import Motion
from ..results.motion_table import motions_of
from ..results.run_up import RunUp
from ..results.simulator import Simulator
from ..results.sweep import Sweep
from ..variables import (
    VARIABLES,
    AttractorsKeywords,
    BasinsKeywords,
    BifurcationDiagramKeywords,
    IntegrateKeywords,
    IntegrationKeywords,
    RunUpKeywords,
)
from .analysable import Analysable

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["InTime"]


class InTime(Analysable):
    """A train and its motions in time."""

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
        return self._found("run_up", settings, lambda box: RunUp._from(box, self), start=(seed, "seed"), unit="periods")

    def simulator(
        self, frequency: float | None = None, *, start: Motion | ArrayLike | None = None, unit: Unit = "Lambda"
    ) -> Simulator:
        """The train under torques from outside, step by step: as a part of a larger simulation.

        Parameters
        ----------
        frequency : float
            Lambda of the mean rotation at the beginning, or in ``unit``. May be left out where ``start`` is a motion.
        start : Motion or array_like, optional
            Motion or state to begin with, as of `integrate`; at rest under the mean torques unless told.
        unit : {'Lambda', 'rpm', 'Hz'}

        Returns
        -------
        Simulator

        Raises
        ------
        InputError
            Where the train has no bodies, not every mesh has teeth, it has more or less than one rigid motion, or a torque that
            follows the speed.

        Examples
        --------
        >>> reducer = gt.read_case("namelists/reducer.nml").train
        >>> reducer.simulator(1500.0, unit="rpm").advance(0.01)
        <Simulator at 0.01 s, 1500 rpm>
        """
        return Simulator(self, frequency, start=start, unit=unit)

    def write_fmu(
        self, path: str | PathLike[str], frequency: float | None = None, *, start: Motion | ArrayLike | None = None,
        unit: Unit = "Lambda", inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None
    ) -> Path:
        """Write a functional mock-up unit of `simulator` (FMI 2.0, co-simulation), for programs that simulate whole machines.

        The torques of the inputs are constant over a communication step. Parameter ``initial_speed`` [rpm]; inputs
        ``motor.torque`` [N m]; outputs ``speed`` [rpm], ``mesh_1.force`` [N], ``shaft_1.torque`` [N m], ``load.speed`` [rad/s].
        It runs where Python has geartrain, with the same Python. Needs pythonfmu.

        Parameters
        ----------
        path : str or path
            Ends in ``.fmu``.
        frequency, start, unit
            As of `simulator`.
        inputs : sequence of str, optional
            Names of bodies; unless told all with a mean torque.
        outputs : sequence of str, optional
            Of ``Simulator.names``; all unless told.

        Returns
        -------
        Path
            Of the unit.

        Raises
        ------
        InputError
            As of `simulator`, and where a name is unknown.
        OSError
            Where it cannot be written.

        Examples
        --------
        >>> unit = reducer.write_fmu("reducer.fmu", 1500.0, unit="rpm", inputs=["motor"], outputs=["mesh 1"])  # doctest: +SKIP
        """
        return write_unit(self.simulator(frequency, start=start, unit=unit), path, start is not None, inputs, outputs)

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
        whole = {"frequency": frequency, "mesh": mesh, **grid, **settings}
        return self._found("basins", whole, lambda box: Basins._from(box, self), grid["velocity_points"], "rows",
                           start=(state, "state"))

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
        points = settings["points"] * (1 + (settings["direction"] == "both"))
        return self._found("bifurcation_diagram", settings, lambda box: BifurcationDiagram._from(box, self), points,
                           start=(seed, what))

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
            both is taken for the attractor. The multipliers of a periodic motion give its exponents, without an average.
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
