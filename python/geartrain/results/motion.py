"""A steady motion: its figures, its course over time, and the same orbit to integration accuracy."""

from __future__ import annotations

import os
from collections.abc import Sequence, Sized
from dataclasses import dataclass, field
from functools import cached_property
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._core.box import Box, fortran, one_blas_thread
from .._core.description import Description, bearings_of
from .._core.gradient import gradient_of
from .._core.units import hertz_of, speed_of
from .._core.warn import warn
from .._core.watch import quiet, watched
from ..errors import InputError, SolverError, shown
from ..files.recording import Channel, Recording, channels_of
from ..plots.motion_plot import Pictures
from .motion_check import check_motion, check_states
from .motion_table import INTEGRATION, motions_dataset, motions_of, put_motions
from .order_table import order_table
from .trajectory import Trajectory

if TYPE_CHECKING:
    from xarray import Dataset

__all__ = ["Motion", "from_state"]

Array = NDArray[np.float64]

_LONGEST = 16  # periods of the fundamental that stand for one period where none was found


@dataclass(frozen=True, eq=False)
class Motion(Pictures, Recording):
    """A steady motion of a train, whichever method found it. Displacements are over the characteristic length.

    Attributes
    ----------
    frequency : float
        Lambda, the fundamental frequency over the characteristic frequency.
    period : int
        In periods of the fundamental; 0 where none was found.
    window : float
        Window from time 0 on over which the figures are taken, in periods of the fundamental, where the common period of the
        meshes is too long for them; 0 where they are those of a period.
    rms_uncertainty, mean_uncertainty, minimum_uncertainty, maximum_uncertainty, force_uncertainty : ndarray, (meshes,), or None
        What a window ten times as long would change of ``rms``, ``mean``, ``minimum``, ``maximum`` and ``mesh_force_maximum``,
        in 95 of 100 cases at most; None without a window.
    torque_mean_uncertainty, torque_min_uncertainty, torque_max_uncertainty : ndarray, (shafts,), or None
        Likewise of ``shaft_torque_mean``, ``shaft_torque_minimum`` and ``shaft_torque_maximum``.
    ringing : float
        Of a motion with a window: amplitude of free vibrations that take too long to die out, when they were last read, over the
        alternating displacement, the largest of all meshes. nan where it is not known.
    rms : ndarray, (meshes,)
        The paper's: square root of the sum of squared harmonic amplitudes, sqrt(2) times the true AC rms.
    mean, minimum, maximum : ndarray, (meshes,)
        Of the mesh displacement.
    mesh_force_maximum : ndarray, (meshes,)
        Largest mesh force over the period in N, damping included, in the direction of the static force.
    dynamic_factor : ndarray, (meshes,)
        The same over the static mesh force; nan where there is no static force.
    separation_fraction, back_contact_fraction : ndarray, (meshes,)
        Shares of the period with the teeth apart, and with the back flanks in contact; 0 without backlash.
    coefficients : ndarray, (meshes, 1 + 2*harmonics)
        Mean, cos 1, sin 1, cos 2, ... of the frequency Lambda/period, or Lambda/window.
    stable : bool or None
        None where no multipliers were asked for; ``refine`` finds them. Known without multipliers on a branch of long period.
    undecided : bool
        ``stable`` is a guess: the largest multiplier is as near to the unit circle as it is uncertain.
    floating : bool
        Some mesh bears on neither flank of its gap and no mean torque holds it: its mean position is not unique, any other in the
        gap would do. Of motions that time integration or ``refine`` gave.
    multipliers : ndarray of complex, (states,), or None
        Floquet multipliers over one period of the motion.
    state : ndarray, (2*elements,), or None
        Displacement of every elastic element at time 0, then its velocity (per 1/characteristic_frequency), where integration gave
        the motion: a mesh's displacement, a shaft's twist less its static twist times the base radius of the gear at its end (the
        driving one of the mesh that follows; for the last shaft the driven one before it), all over characteristic_length.
        ``train.modes().state`` names the values.
    error_estimate : float
        Relative error of the waveform as estimated; nan where there is no estimate.
    reading_error_estimate : float
        Error, as estimated, of the shaft torque, bearing force or displacement of a mesh without backlash where it is largest, by
        harmonics that are not carried, over its alternating part; nan where there is no estimate.
    share : float
        Share of the random starts that settled here (`Train.attractors`); nan where none were counted.
    lyapunov_exponent : float
        Largest Lyapunov exponent per unit of time (1/characteristic_frequency), of motions that integration gave: positive is
        chaos, about 0 a quasi-periodic motion; of a periodic motion ln(largest multiplier)/time.
    lyapunov_error : float
        What ``lyapunov_exponent`` is uncertain by, at 95 %; 0 for a periodic motion.
    kind : str
        ``"periodic"``; ``"stationary"`` where it has settled and the figures are those of a window; where integration found no
        period ``"chaotic"``, ``"quasi-periodic"``, ``"still settling"`` (or of a longer period than 16), ``"undecided"``, or
        ``"unbounded"`` where it was given up because it grew without bound.
    shaft_torque_mean, shaft_torque_minimum, shaft_torque_maximum : ndarray, (shafts,), or None
        In N m, over the period; NaN where rigid shafts side by side leave it undetermined.
    reaction_torque_mean, reaction_torque_minimum, reaction_torque_maximum : ndarray, (held bodies,), or None
        Torque in N m by which each held body is held, over the period; None where no body is held.
    load_share, load_share_maximum : ndarray, (planets of all planetary sets,), or None
        Mean and largest force of each planet with the sun (with the ring, without a sun) over the sum of the mean forces of its
        set; nan without load, None without planets.
    coupling_torque_mean, coupling_torque_minimum, coupling_torque_maximum : ndarray, (couplings,), or None
        In N m, over the period, positive where the first body of a coupling drives; None without couplings.
    bearing_force_mean, bearing_force_rms, bearing_force_minimum, bearing_force_maximum : ndarray, (bearings, 2), or None
        In N, in x and y, over the period, positive where the body pushes in the positive direction; ``rms`` is the root mean
        square over time without the mean. None without bearings.
    coupling_energy_loss : ndarray, (couplings,), or None
        Energy in J that damping and friction of each coupling take in a period of the fundamental; times
        ``fundamental_frequency`` it is a power in W. None without couplings.
    train : Train
        The train that moves so.
    """

    frequency: float
    period: int
    rms: Array
    mean: Array
    minimum: Array
    maximum: Array
    mesh_force_maximum: Array
    dynamic_factor: Array
    separation_fraction: Array
    back_contact_fraction: Array
    coefficients: Array = field(repr=False)
    stable: bool | None = None
    multipliers: NDArray[np.complex128] | None = field(default=None, repr=False)
    state: Array | None = field(default=None, repr=False)
    error_estimate: float = float("nan")
    reading_error_estimate: float = float("nan")
    share: float = float("nan")
    shaft_torque_mean: Array | None = None
    shaft_torque_minimum: Array | None = None
    shaft_torque_maximum: Array | None = None
    undecided: bool = False
    lyapunov_exponent: float = float("nan")
    lyapunov_error: float = 0.0
    kind: str = "periodic"
    window: float = 0.0
    ringing: float = float("nan")
    rms_uncertainty: Array | None = None
    mean_uncertainty: Array | None = None
    minimum_uncertainty: Array | None = None
    maximum_uncertainty: Array | None = None
    force_uncertainty: Array | None = None
    torque_mean_uncertainty: Array | None = None
    torque_min_uncertainty: Array | None = None
    torque_max_uncertainty: Array | None = None
    floating: bool = False
    reaction_torque_mean: Array | None = None
    reaction_torque_minimum: Array | None = None
    reaction_torque_maximum: Array | None = None
    load_share: Array | None = None
    load_share_maximum: Array | None = None
    coupling_torque_mean: Array | None = None
    coupling_torque_minimum: Array | None = None
    coupling_torque_maximum: Array | None = None
    bearing_force_mean: Array | None = None
    bearing_force_rms: Array | None = None
    bearing_force_minimum: Array | None = None
    bearing_force_maximum: Array | None = None
    coupling_energy_loss: Array | None = None
    train: Description | None = field(default=None, repr=False)

    @property
    def true_ac_rms(self) -> Array:
        """Root mean square over time of the displacement less its mean, (meshes,): ``rms`` over sqrt(2)."""
        check_motion(self)
        true: Array = self.rms / np.sqrt(2)
        return true

    @property
    def unbounded(self) -> bool:
        """Whether integration gave it up because it grew without bound: a state, but no figures and no waveform; period 0."""
        return self.kind == "unbounded"

    @property
    def speed(self) -> float | None:
        """Speed [rpm] of the body that `Train.speed_name` tells; None where not every mesh has teeth."""
        return speed_of(self.train, self.frequency)

    @property
    def fundamental_frequency(self) -> float | None:
        """Frequency of the fundamental [Hz]; None without a train."""
        return hertz_of(self.train, self.frequency)

    @property
    def time(self) -> Array:
        """Times of ``displacement``, over a period or the window, in units of 1/characteristic_frequency, (samples,)."""
        return self._period[0]

    @property
    def displacement(self) -> Array:
        """Mesh displacement over one period, or over the window, (samples, meshes)."""
        return self._period[1]

    @property
    def mesh_force(self) -> Array:
        """Mesh force in N, of a coupling torque in N m, over one period or the window, damping included, (samples, meshes)."""
        return self._period[2]

    @property
    def shaft_torque(self) -> Array:
        """Torque of the shafts in N m over one period, positive where the first body of a shaft drives, (samples, shafts)."""
        return self._period[3]

    @property
    def reaction_torque(self) -> Array:
        """Torque in N m by which each held body is held, over one period or the window, (samples, held bodies)."""
        return self._period[5]

    @property
    def coupling_torque(self) -> Array:
        """Torque of the couplings in N m over one period or the window, (samples, couplings); positive: the first body drives."""
        return self._period[6]

    @property
    def bearing_force(self) -> Array:
        """Forces on the bearings in N, in x and y, over one period or the window, (samples, bearings, 2)."""
        return bearings_of(self.mesh_force, self.train)

    @cached_property
    def _period(self) -> tuple[Array, ...]:
        check_motion(self)
        harmonics = (self.coefficients.shape[-1] - 1) // 2
        return self._sample(max(256 * max(self.period or 1, 1), 16 * harmonics))

    def waveform(self, samples: int) -> tuple[Array, Array]:
        """Sample one period.

        Parameters
        ----------
        samples : int
            Evenly spaced, the first at time 0.

        Returns
        -------
        time : ndarray, (samples,)
            In units of 1/characteristic_frequency.
        displacement : ndarray, (samples, meshes)
        """
        _check_count("samples", samples, 1)
        time, displacement, *_ = self._sample(samples)
        return time, displacement

    def trajectory(self, periods: int, *, samples: int = 0) -> Trajectory:
        """The motion over a number of periods of the fundamental from phase 0 on.

        A periodic motion repeats itself, any other goes on by integration from its state.

        Parameters
        ----------
        periods : int
            Periods of the fundamental.
        samples : int
            Evenly spaced, of each period of the fundamental; 0: 256, or 32 of a period of the fastest mesh.

        Returns
        -------
        Trajectory

        Raises
        ------
        Interrupted
            On Ctrl-C.
        MemoryError
            Where the machine has not as much memory as the samples take.

        Examples
        --------
        The Poincare section of a motion of period 2:

        >>> displacement, velocity = train.integrate(1.92).trajectory(6).section
        >>> displacement[:, 0].round(4)
        array([1.5649, 1.8222, 1.5649, 1.8222, 1.5649, 1.8222])
        """
        _check_count("periods", periods, 1)
        _check_count("samples", samples, 0)
        check_motion(self)
        if not self.period and self.state is None:
            raise SolverError(f"the motion at Lambda = {self.frequency:g} has no period and no state to go on from")
        samples = samples or self._samples()
        own = self.period or periods
        if max(own, periods) * samples >= 2**31:
            raise InputError(f"periods = {periods}: of {samples} samples each, must be below {2**31 // samples}")
        values = 1 + 3 * len(self.rms) + (len(self.train.shafts) if self.train else 0)
        if 8 * values * periods * samples > os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"):
            raise MemoryError(f"no memory for {periods} periods of {samples} samples: give fewer of either")
        time, displacement, force, torque, velocity, *_ = watched(
            lambda progress: self._sample(own * samples, 0 if self.period else periods, progress), "trajectory", in_parts=False
        )
        repeated = np.arange(periods * samples) % len(time)
        times = np.arange(len(repeated), dtype=float) * (2 * np.pi / (self.frequency * samples))
        return Trajectory(times, displacement[repeated], velocity[repeated], force[repeated], torque[repeated], samples)

    def _sample(self, samples: int, periods: int = 0, progress: Array | None = None) -> tuple[Array, ...]:
        """Time, displacement, force, shaft torque, velocity, reaction and coupling torque, over a period or periods."""
        watch = quiet() if progress is None else progress
        with self._box() as box:
            shafts = len(self.train.shafts) if self.train else 0
            held = sum(bool(body.held) for body in self.train.bodies or ()) if self.train else 0
            couplings = len(self.train.couplings) if self.train else 0
            with one_blas_thread:
                time, displacement, velocity, force, torque = fortran.sample_waveform(
                    box.handle, periods, samples, len(self.rms), shafts + held + couplings, watch
                )
            shaft, reaction, coupling = np.split(torque, [shafts, shafts + held], axis=1)
            return time, displacement, force, shaft, velocity, reaction, coupling

    def _recorded(self, periods: int, dense: int) -> tuple[Array, list[Channel], bool]:
        _check_count("periods", periods, 1)
        own = periods == 1 and dense > 1 and bool(self.period)
        path = self.trajectory(self.period if own else periods, samples=dense * self._samples())
        hertz = self.fundamental_frequency or 1.0
        seconds = path.time * (self.frequency / (2 * np.pi * hertz))
        return seconds, channels_of(self.train, path.mesh_force, path.shaft_torque), own

    def spectrum(self, what: str = "displacement") -> tuple[Array, Array]:
        """Amplitudes of the harmonics of a displacement, force or torque; the mean is left out.

        Parameters
        ----------
        what : {'displacement', 'mesh_force', 'shaft_torque', 'coupling_torque', 'bearing_force'}
            The displacement of the meshes by its ``coefficients``; forces and torques by their samples.

        Returns
        -------
        order : ndarray, (harmonics,)
            In multiples of Lambda, hence 1/2, 1, 3/2, ... for a motion of period 2.
        amplitude : ndarray, (harmonics, meshes), (harmonics, shafts), ..., or (harmonics, bearings, 2)
            Over the characteristic length, in N, or in N m.

        Examples
        --------
        >>> order, amplitude = branch.at(0.9)[0].spectrum()
        >>> order, amplitude[:, 0].round(3)
        (array([1., 2., 3., 4., 5., 6.]), array([0.157, 0.376, 0.049, 0.004, 0.001, 0.   ]))
        """
        check_motion(self)
        kinds = ("displacement", "mesh_force", "shaft_torque", "coupling_torque", "bearing_force")
        if what not in kinds:
            raise InputError(f"what = {shown(what)}: must be {', '.join(map(repr, kinds))}")
        cosine, sine = self.coefficients[:, 1::2], self.coefficients[:, 2::2]
        whole = self.period or self.window or _LONGEST
        if what == "displacement":
            return np.arange(1, cosine.shape[1] + 1) / whole, np.hypot(cosine, sine).T
        values = getattr(self, what)
        amplitude = 2 * np.abs(np.fft.rfft(values, axis=0)[1:]) / len(values)
        # Half of the lines: those above are of the corners of the force, which the samples do not resolve.
        order = np.arange(1, len(amplitude) // 2 + 1) / whole
        return order, amplitude[:len(order)]

    def orders(self, least: float = 1e-3, what: str = "displacement") -> Dataset:
        """The orders of the motion with their owners, ``'2 x mesh 1 - 1 x pinion'``; needs xarray.

        Parameters
        ----------
        least : float
            Amplitude below which an order is left out, over the largest amplitude of the mesh, shaft, ...; 0 to 1.
        what : str
            As in `spectrum`.
        """
        return order_table(self, least, what)

    def refine(self) -> Motion:
        """The same orbit to integration accuracy (about 1e-11), by shooting with exact contact events.

        Returns
        -------
        Motion
            With its multipliers.

        Raises
        ------
        SolverError
            Where shooting does not converge.

        Warns
        -----
        UserWarning
            Where the orbit found lies farther away than ten times the estimated error: it may be another one, as next to a fold or
            a period doubling.

        Examples
        --------
        >>> refined = branch.at(0.9)[0].refine()
        >>> refined.rms.round(8)
        array([0.41003761, 0.7144016 ])
        >>> refined.error_estimate < 1e-10
        True
        """

        def work(progress: NDArray[np.float64]) -> Motion:
            with self._box("refine") as box:
                box.check(box.work("shoot", progress))
                return Motion(train=self.train, **motions_of(box)[0])

        refined = watched(work, "refinement")
        moved = float(np.abs(refined.rms - self.rms).max() / max(refined.rms.max(), np.finfo(float).tiny))
        if moved > max(10 * self.error_estimate, 1e-6):
            warn(
                f"refine: the rms moved by {moved:.2g} (relative) at Lambda = {self.frequency:g}, where the estimated error is "
                f"{self.error_estimate:.2g}: the orbit may be another one"
            )
        return refined

    def gradient(self, figure: str, parameters: Sequence[str]) -> Array:
        """Derivatives of a figure with respect to parameters of the train, at constant speed, by the implicit function theorem.

        The harmonic balance with the harmonics of ``coefficients`` is R(p, Lambda, parameter) = 0, so dp = -(dR/dp)^-1 dR. All
        parameters take one factorization. ``mesh * half_backlash`` means all meshes alike in which it is in force: the derivative
        is the sum of theirs. ``stiffness_variation`` is the largest amplitude of kappa with all others in proportion.

        Parameters
        ----------
        figure : str
            ``'rms'``, ``'mean'``, ``'minimum'``, ``'maximum'``, ``'mesh_force_maximum'``, ``'dynamic_factor'``,
            ``'shaft_torque_mean'``, ``'shaft_torque_minimum'`` or ``'shaft_torque_maximum'``.
        parameters : sequence of str
            Names as in the case: ``'input_torque'``, ``'mesh 2 half_backlash'``, ``'shaft 1 stiffness'``,
            ``'mesh 1 stiffness_cos 2'`` (a value of a list), ``'motor inertia'``. Of a number that the drawing gives, such as
            ``'mesh 1 stiffness'``, the derivative is as if it were given; of one of the drawing, such as ``'mesh 1 face_width'``,
            through all that follows from it. At an end of its range, such as a damping ratio or a helix angle of 0, the derivative
            is one-sided.

        Returns
        -------
        ndarray, (meshes, parameters) or (shafts, parameters)
            In the unit of the figure over that of the parameter in the case. Displacements are over the characteristic length,
            1e-6 m where it is left out; forces are in N, torques in N m. Angles of the drawing are in degrees, phases in rad. NaN
            where there is no derivative.

        Raises
        ------
        InputError
            Where a name is unknown, not continuous, a unit of the results, or not in force in this train: not given, or without
            effect, as the diameter of a shaft whose stiffness is given.

        Warns
        -----
        NotDifferentiableWarning
            With its ``reasons``: at a fold, where a tooth grazes the edge of its gap, where two extremes are equal, where gears
            of a loop would lock, or where the train is of another kind with the parameter not 0, such as a backlash.

        Examples
        --------
        >>> motion = branch.at(0.9)[0]
        >>> motion.gradient("dynamic_factor", ["mesh 1 damping_ratio", "stiffness_variation"]).round(3)
        array([[-32.743,   7.676],
               [ -8.755,   4.72 ]])
        """
        box = Box(copy=self._train_of("gradient")._kept)
        check_motion(self, "gradient", *box.sizes())
        return gradient_of(box, figure, parameters, self.period, float(self.frequency), self.coefficients)

    def to_dataset(self) -> Dataset:
        """The motion as an xarray Dataset with the names, units and coordinates of the results file; needs xarray."""
        return motions_dataset(INTEGRATION, [self]).isel(point=0, drop=True)

    def _box(self, what: str = "motion") -> Box:
        """A box of the motion; ``what`` is what messages call it."""
        train = self._train_of(what)
        try:
            box = train._ask_at(self.frequency, {})
        except InputError as error:
            raise InputError(str(error).replace("&integration", what)) from None
        put_motions(box, self, what=what)
        return box

    def _train_of(self, what: str) -> Description:
        """The train of a motion that has a waveform; ``what`` as in `_box`."""
        if self.train is None:
            raise ValueError("this motion has no train")
        if not isinstance(self.train, Description):
            raise InputError(f"{what}: train = {shown(self.train)}: must be a gt.Train")
        if self.unbounded:
            raise SolverError(f"the motion grows without bound at Lambda = {self.frequency:g}: it has no waveform")
        return self.train


def _check_count(name: str, number: Any, least: int) -> None:
    if isinstance(number, bool) or not isinstance(number, Integral) or not least <= int(number) < 2**31:
        raise InputError(f"{name} = {shown(number)}: must be a whole number >= {least} and below {2**31}")


def from_state(state: ArrayLike, meshes: int, states: int, what: str = "start") -> Motion:
    """A motion of which only the state is known; ``states`` is how many values it must have, ``what`` what messages call it."""
    if not isinstance(state, np.ndarray):
        # A list without end, or of such lists, is not to be looked through.
        _check_length(state, states, what)
        if isinstance(state, Sequence) and any(isinstance(item, Sized) and not np.isscalar(item) for item in state):
            raise InputError(f"{what} = {shown(state)}: must be a gt.Motion or a list of numbers, and has lists in it")
    try:
        values = np.array(state, float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} = {shown(state)}: must be a gt.Motion or a list of numbers") from None
    if values.ndim != 1 or not np.isfinite(values).all():
        raise InputError(f"{what}: must be a gt.Motion or finite numbers of shape (2*elements,), is {values.shape}")
    nothing = np.zeros(meshes)
    return Motion(
        frequency=0.0,
        period=1,
        rms=nothing,
        mean=nothing,
        minimum=nothing,
        maximum=nothing,
        mesh_force_maximum=nothing,
        dynamic_factor=nothing,
        separation_fraction=nothing,
        back_contact_fraction=nothing,
        coefficients=np.zeros((meshes, 0)),
        state=values,
    )


def _check_length(state: Any, states: int, what: str) -> None:
    if not isinstance(state, Sized) or isinstance(state, (str, bytes)):
        return
    try:
        number = len(state)
    except (OverflowError, TypeError):  # a range of more items than Python counts; an array of no dimension
        raise InputError(f"{what} = {shown(state)}: must be a gt.Motion or a list of {states} numbers") from None
    check_states(number, states, what)
