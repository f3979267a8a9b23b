"""What harmonic balance and shooting can be asked of a train."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .._core.description import Description
from .._core.parameter import value_in
from .._core.units import Unit
from .._core.variable import takes
from .._core.watch import watched
from ..errors import InputError, SolverError, shown
from ..results.branch import Branch
from ..results.exact_point import ExactPoint
from ..results.locus import Locus
from ..results.motion import Motion
from ..results.motion_search import find_motions
from ..results.motion_table import put_motions
from ..results.motions import Motions
from ..results.special_point import SpecialPoint
from ..results.stability_map import StabilityMap
from ..variables import VARIABLES, ResponseKeywords, StabilityMapKeywords
from .analysable import Analysable

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = ["OnTheBalance"]


class OnTheBalance(Analysable):
    """A train and its periodic motions."""

    @takes(VARIABLES["response"], ResponseKeywords)
    def response(self, *, seed: Motion | None = None, **settings: Unpack[ResponseKeywords]) -> Branch:
        """Follow the periodic motions by harmonic balance, with ``friction_torque`` by shooting, through the folds.

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
