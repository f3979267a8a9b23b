"""A gear train and what can be asked of it."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ._core.box import Box
from ._core.gradient import gradient_of
from ._core.units import Unit, lambda_of, units_of
from .analyses.in_time import InTime
from .analyses.on_the_balance import OnTheBalance
from .errors import InputError, shown
from .plots.draw import new_axes
from .plots.planetary_picture import STAGE_RATIOS, STAGE_SIZE, draw_stage
from .plots.schematic import draw_schematic, figure_size
from .results.campbell import Campbell
from .results.modes import Modes
from .results.state_space import StateSpace, averaged, state_space_of
from .variables import PARTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from .results.motion import Motion


__all__ = ["Train"]


class Train(OnTheBalance, InTime):
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

    def state_space(
        self, *, inputs: Sequence[str] | None = None, outputs: Sequence[str] | None = None, at: Motion | None = None,
    ) -> StateSpace:
        """The train as a linear system, for controllers: contact everywhere, mean mesh stiffness, torques of bodies as inputs.

        Parameters
        ----------
        inputs : sequence of str, optional
            Names of bodies; all unless told.
        outputs : sequence of str, optional
            Elements as `modes` names them, ``'shaft 1'``, ``'mesh 1'``, for their torques and forces, and bodies for their speeds;
            all elements unless told.
        at : Motion, optional
            A periodic motion of this train: its meshes then have the stiffness and damping that they have on average over it, with
            teeth apart for a part of the time. Of trains of shafts and gear pairs.

        Returns
        -------
        StateSpace

        Raises
        ------
        InputError
            Where an element is not linear, or the motion is not periodic or of another train.

        Examples
        --------
        >>> reducer = gt.read_case("namelists/reducer.nml").train
        >>> system = reducer.state_space(inputs=["motor"], outputs=["shaft 1", "load"])
        >>> system.A.shape, system.units
        ((11, 11), ('N m', 'rad/s'))
        """
        train = self if at is None else averaged(self, at)
        return state_space_of(train, train.modes(), inputs, outputs)

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
            It is negative where the body turns in the opposite sense.

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

        Each planet has its share of the static load; positive speeds turn counter-clockwise. The lever has sun, carrier and ring
        at distances by their teeth; the speeds across it lie on a line.

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
        front, lever = new_axes(None, ncols=2, figsize=STAGE_SIZE, width_ratios=STAGE_RATIOS)
        return draw_stage(self, name, (front, lever), speed)

    @classmethod
    def _of(cls, groups: Sequence[tuple[str, dict[str, Any]]]) -> Train:
        """The train of a case's groups, as `_namelist.parse` gives them."""
        lists: dict[str, Any] = {
            parts: [kind(**values) for name, values in groups if name == group] for group, (parts, kind) in PARTS.items()
        }
        return cls(**dict(groups)["train"], **lists)
