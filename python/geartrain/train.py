"""A gear train and what can be asked of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._box import Box, fortran
from ._request import TRAIN, case_text, text_at
from ._watch import watched
from .branch import Branch
from .errors import InputError, SolverError, shown
from .modes import Modes
from .motion import Attractors, Motion, Sweep, from_state
from .parts import Mesh, Series, Shaft, freeze_series
from .stability_map import StabilityMap

__all__ = ["Train"]


@dataclass(frozen=True, kw_only=True)
class Train:
    """A gear train: M shafts in a chain, M-1 meshes between them, an inertia at either end. All input is SI.

    Every name is that of the case file, where its unit and range are told. What is not given takes the case file's
    default. A train cannot be changed; ``dataclasses.replace`` makes a changed one.

    Parameters
    ----------
    input_torque : float
        Mean input torque [N m]; the output torque balances it by itself.
    prime_mover_inertia, load_inertia : float
        Inertias at the two ends [kg m^2]; 0 is allowed on a rigid shaft.
    characteristic_length : float
        Unit of mesh displacement [m].
    characteristic_frequency : float
        Unit of frequency [rad/s].
    shafts : sequence of Shaft
    meshes : sequence of Mesh
    torque_cos, torque_sin : float or sequence of float, optional
        Harmonics 1.. of the input torque [N m].
    title : str, optional

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

    input_torque: float | None = None
    prime_mover_inertia: float | None = None
    load_inertia: float | None = None
    characteristic_length: float | None = None
    characteristic_frequency: float | None = None
    shafts: Sequence[Shaft] = ()
    meshes: Sequence[Mesh] = ()
    torque_cos: Series | None = None
    torque_sin: Series | None = None
    title: str | None = None

    def __post_init__(self) -> None:
        for name, kind in (("shafts", Shaft), ("meshes", Mesh)):
            parts = getattr(self, name)
            if not isinstance(parts, Sequence) or not all(isinstance(part, kind) for part in parts):
                raise InputError(f"{name} = {shown(parts)}: must be a list of gt.{kind.__name__}")
            object.__setattr__(self, name, tuple(parts))
        freeze_series(self, TRAIN)
        with Box(self.namelist()):
            pass

    def namelist(
        self,
        modes: bool = False,
        response: Mapping[str, Any] | None = None,
        integration: Mapping[str, Any] | None = None,
        attractors: Mapping[str, Any] | None = None,
        stability_map: Mapping[str, Any] | None = None,
    ) -> str:
        """The train, and the analyses wanted, as a case file's text.

        Parameters
        ----------
        modes : bool
        response, integration, attractors, stability_map : mapping, optional
            The variables of the group by their keywords, hence ``start`` and ``stop`` for ``from`` and ``to``.
        """
        analyses = {
            "modes": {} if modes else None,
            "response": response,
            "integration": integration,
            "attractors": attractors,
            "stability_map": stability_map,
        }
        return case_text(self, analyses)

    def natural_frequencies(self) -> NDArray[np.float64]:
        """Undamped natural frequencies of the mean system, over the characteristic frequency, ascending.

        Returns
        -------
        ndarray, (modes,)
            The elastic modes; a rigid-body mode is left out.
        """
        return self.modes().natural_frequency

    def modes(self) -> Modes:
        """Natural frequencies, damping ratios and mode shapes of the mean system.

        Returns
        -------
        Modes
        """
        text = self.namelist()

        def work(progress: NDArray[np.float64]) -> Modes:
            with Box(text) as box:
                box.check(fortran.find_modes(box.handle, progress))
                return Modes(**(box.modes() or {}))

        return watched(work, "modes", in_parts=False)

    def response(
        self,
        *,
        start: float,
        stop: float,
        harmonics: int = 6,
        subharmonic: int = 1,
        stability: bool = True,
        seed: Motion | None = None,
        amplitude_limit: float | None = None,
        coefficients: str | None = None,
        samples: int | None = None,
        control: str | None = None,
        tolerance: float | None = None,
        step: float | None = None,
        max_points: int | None = None,
        period_doublings: int = 0,
        branch_points: bool = False,
        refine: bool = False,
    ) -> Branch:
        """Follow the periodic motions by harmonic balance and continuation, through the folds.

        Parameters
        ----------
        start, stop : float
            Lambda; the branch is followed downwards where ``start`` is above ``stop``.
        harmonics : int
            Of Lambda/subharmonic; 0 lets the program choose them for ``tolerance``.
        subharmonic : int
            Period of the motions in fundamental mesh periods.
        stability : bool
            Floquet multipliers of every point.
        seed : Motion, optional
            A motion of the branch wanted, to start from in place of ``start``.
        amplitude_limit : float, optional
            Rms over characteristic length beyond which the branch is followed but not recorded; unless told 12 with
            backlash, 10000 for a linear train, both times the power of ten nearest to its gap or deflection.
        coefficients : {'exact', 'sampled'}, optional
            How the force's Fourier coefficients are found; ``samples`` a period where sampled.
        samples : int, optional
        control : {'arclength', 'local'}, optional
        tolerance : float, optional
            Relative error of the waveform to aim at where ``harmonics`` is 0.
        step : float, optional
            Largest step along the branch.
        max_points : int, optional
        period_doublings : int
            How often a period doubling is followed: 1 gives the branches of twice the period, 2 those of four times as well, ...
        branch_points : bool
            Whether the branches of the same period that cross at branch points are followed: where a multiplier passes +1
            without a fold, as where equal stages begin to move differently.
        refine : bool
            Every point polished by shooting in the end, see `Branch.refine`.

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
        settings = {
            "start": start,
            "stop": stop,
            "harmonics": harmonics,
            "subharmonic": subharmonic,
            "stability": stability,
            "amplitude_limit": amplitude_limit,
            "coefficients": coefficients,
            "samples": samples,
            "control": control,
            "tolerance": tolerance,
            "step": step,
            "max_points": max_points,
            "period_doublings": period_doublings,
            "branch_points": branch_points,
            "refine": refine,
        }
        text = self.namelist(response=settings)
        if seed is not None and not isinstance(seed, Motion):
            raise InputError(f"seed = {shown(seed)}: must be a gt.Motion")
        if seed is not None and seed.unbounded:
            raise InputError("seed: a motion that grew without bound: must be a periodic one")

        def work(progress: NDArray[np.float64]) -> Branch:
            with Box(text) as box:
                if seed is not None:
                    box.put_motions(seed, what="seed")
                status = fortran.follow_response(box.handle, progress)
                branch = Branch._from(box, self, settings)
                box.check(status, whole=branch is None)
                if branch is None:
                    raise SolverError(box.ended() or "no point found")
                branch.branches.extend(Branch._all_from(box, self, settings))
                return branch

        return watched(work, "response")

    def integrate(
        self,
        frequency: float,
        *,
        start: Motion | ArrayLike | None = None,
        stability: bool = True,
        harmonics: int | None = None,
        max_periods: int | None = None,
        tolerance: float | None = None,
    ) -> Motion:
        """Integrate over time until the motion is steady.

        Parameters
        ----------
        frequency : float
            Lambda.
        start : Motion or array_like, optional
            Where to start: a motion, or displacement and then velocity of every elastic element, (2*elements,), as `Motion.state`.
        stability : bool
            Floquet multipliers of the motion.
        harmonics : int, optional
            Of Lambda, to store; unless told 16 of the highest mesh order.
        max_periods : int, optional
            Mesh periods after which an unsettled motion is given up.
        tolerance : float, optional
            Relative change over a period at which the motion counts as steady.

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
        settings = {"stability": stability, "harmonics": harmonics, "max_periods": max_periods, "tolerance": tolerance}
        text = text_at(self, frequency, settings)

        def work(progress: NDArray[np.float64]) -> Motion:
            with Box(text) as box:
                if isinstance(start, Motion):
                    box.put_motions(start, what="start")
                elif start is not None:
                    box.put_motions(from_state(start, *box.sizes()), what="start", only_state=True)
                box.check(fortran.integrate_at(box.handle, frequency, progress))
                return Motion(train=self, **box.motions()[0])

        return watched(work, "integration")

    def sweep(
        self,
        *,
        start: float,
        stop: float,
        points: int = 121,
        direction: str = "up",
        stability: bool | None = None,
        harmonics: int | None = None,
        max_periods: int | None = None,
        tolerance: float | None = None,
    ) -> Sweep:
        """Integrate at one frequency after another, each from where the one before settled.

        Parameters
        ----------
        start, stop : float
            The range of Lambda.
        points : int
        direction : {'up', 'down', 'both'}
        stability, harmonics, max_periods, tolerance
            As in `integrate`.

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
        settings = {
            "start": start,
            "stop": stop,
            "points": points,
            "direction": direction,
            "stability": stability,
            "harmonics": harmonics,
            "max_periods": max_periods,
            "tolerance": tolerance,
        }
        text = self.namelist(integration=settings)

        def work(progress: NDArray[np.float64]) -> Sweep:
            with Box(text) as box:
                status = fortran.sweep_range(box.handle, progress)
                motions = Sweep._from(box, self)
                box.check(status, whole=not motions)
                return motions

        return watched(work, "integration", points * (1 + (direction == "both")))

    def attractors(
        self,
        frequency: float,
        *,
        starts: int = 200,
        random_seed: int = 0,
        follow: Branch | bool = False,
        stability: bool = True,
        harmonics: int | None = None,
        max_periods: int | None = None,
        tolerance: float | None = None,
    ) -> Attractors:
        """The steady motions on which random starts settle.

        Parameters
        ----------
        frequency : float
            Lambda.
        starts : int
            How many.
        random_seed : int
            The same seed gives the same starts.
        follow : Branch, optional
            A response: each motion found that lies neither on it nor on its ``branches`` is followed with the response's settings
            over its range, as an island that closes on itself where it does.
        stability, harmonics, max_periods, tolerance
            As in `integrate`.

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
        0.55 [0.166 0.212]
        0.45 [0.493 2.133]
        >>> found.unsettled
        0.0
        """
        if follow is True or not isinstance(follow, (bool, Branch)):
            raise InputError(f"follow = {shown(follow)}: must be a gt.Branch, the response whose range and settings are meant")
        settings = {
            "frequency": frequency,
            "starts": starts,
            "random_seed": random_seed,
            "follow": follow is not False,
            "stability": stability,
            "harmonics": harmonics,
            "max_periods": max_periods,
            "tolerance": tolerance,
        }
        known = follow if isinstance(follow, Branch) else None
        asked = None if known is None else known.settings
        text = self.namelist(response=asked, attractors=settings)

        def work(progress: NDArray[np.float64]) -> Attractors:
            with Box(text) as box:
                if known is not None:
                    box.put_branch(known)
                    box.put_branches(known.branches)
                status = fortran.find_attractors(box.handle, progress)
                box.check(status)
                first = 1 + (0 if known is None else len(known.branches))
                return Attractors._from(box, self, Branch._all_from(box, self, asked or {}, first))

        return watched(work, "attractors", starts)

    def stability_map(
        self,
        *,
        start: float,
        stop: float,
        parameter_start: float,
        parameter_stop: float,
        parameter: str = "stiffness_variation",
        linear: bool = False,
        points: int = 200,
        parameter_points: int = 200,
        harmonics: int = 6,
    ) -> StabilityMap:
        """Stability over frequency and one parameter, on all cores.

        Parameters
        ----------
        start, stop : float
            The range of Lambda.
        parameter_start, parameter_stop : float
            That of the parameter.
        parameter : {'stiffness_variation', 'mesh_damping_ratio', 'input_torque', 'half_backlash'}
            ``stiffness_variation`` is the largest amplitude of any harmonic of the mesh stiffnesses, all scaled alike; the others
            are variables of the train or of every mesh.
        linear : bool
            Of the train without backlash, all teeth in contact; else of the motions on the response branch of every row.
        points, parameter_points : int
            Of the grid.
        harmonics : int
            Of the motions; a linear map needs none.

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
        """
        settings = {
            "start": start,
            "stop": stop,
            "points": points,
            "parameter": parameter,
            "parameter_start": parameter_start,
            "parameter_stop": parameter_stop,
            "parameter_points": parameter_points,
            "linear": linear,
            "harmonics": harmonics,
        }
        text = self.namelist(stability_map=settings)

        def work(progress: NDArray[np.float64]) -> StabilityMap:
            with Box(text) as box:
                box.check(fortran.map_stability(box.handle, progress))
                return StabilityMap(**(box.stability_map() or {}))

        return watched(work, "stability map", parameter_points, "rows", parameter)
