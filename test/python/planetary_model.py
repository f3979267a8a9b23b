"""Equations of motion of trains with carriers, in angles of one sense, and their periodic motions by integration and shooting.

Nothing here calls geartrain. A train gives its numbers only: its speeds, rows, torques and forces are derived anew.
The unit of time is 1/characteristic_frequency, and displacements are in characteristic lengths.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from scipy.integrate import DOP853
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq, linear_sum_assignment

#: Relative error of a step of the integration [1]; samples of a step between which contact events are looked for.
ACCURACY, SAMPLES = 1e-13, 12
#: Nodes on (0, 1) and weights of the quadrature over a step.
NODES, WEIGHTS = (np.polynomial.legendre.leggauss(8)[0] + 1) / 2, np.polynomial.legendre.leggauss(8)[1] / 2
#: Places on [0, 1] of the samples for the extremes of a step, and the Chebyshev polynomials there.
PLACES = (1 - np.cos(np.pi * np.arange(9) / 8)) / 2
POLYNOMIALS = chebyshev.chebvander(2 * PLACES - 1, 8)


def listed(values, count=None):
    """The values of a variable that may be absent, a number or a list; followed by zeros where ``count`` is given."""
    values = np.atleast_1d(np.array([] if values is None else values, float))
    return values if count is None else np.pad(values, (0, count - len(values)))


@dataclass
class Element:
    """A shaft or a mesh: its row of absolute rotations, and its force."""

    row: np.ndarray  # displacement per rotation of each body [m], or [1] of a shaft
    stiffness: float
    damping: float
    source: object  # the gt.Mesh, None of a shaft
    backlash: float = 0.0  # half of it [m]


class Model:
    """A train in angles of one sense, positive as the body that `speed_of` names turns."""

    def __init__(self, train):
        self.train, self.bodies = train, train.bodies
        self.number = {body.name: number for number, body in enumerate(train.bodies)}
        self.inertia = np.array([body.inertia or 0.0 for body in train.bodies])
        self.held = np.array([bool(body.held) for body in train.bodies])
        self.support = np.array([body.stiffness_to_ground or 0.0 for body in train.bodies])
        self.drag = np.array([body.damping_to_ground or 0.0 for body in train.bodies])
        self.length, self.omega = train.characteristic_length, train.characteristic_frequency
        self._find_speeds()
        self._find_elements()
        self._find_coordinates()
        self._find_torques()
        self._find_excitation()

    # Speeds and senses

    def _willis(self, mesh):
        """Row of speeds r_a (n_a - n_c) + q r_b (n_b - n_c), q = -1 of an internal pair; numbers of a and c (or None)."""
        one, other = (self.number[name] for name in mesh.between)
        row = np.zeros(len(self.bodies))
        driven = (-1.0 if mesh.internal else 1.0) * mesh.driven_radius
        row[one] += mesh.driving_radius
        row[other] += driven
        carrier = self.number[mesh.carrier] if mesh.carrier else None
        if carrier is not None:
            row[carrier] -= mesh.driving_radius + driven
        return row, one, carrier

    def _find_speeds(self):
        count = len(self.bodies)
        rows = [self._willis(mesh)[0] / mesh.driving_radius for mesh in self.train.meshes or ()]
        for shaft in self.train.shafts or ():
            row = np.zeros(count)
            row[self.number[shaft.between[0]]], row[self.number[shaft.between[1]]] = 1.0, -1.0
            rows.append(row)
        rows += [np.eye(count)[body] for body in range(count) if self.held[body] or self.support[body]]
        self.rigid = null_space(np.array(rows), rcond=1e-9)
        moving = np.abs(self.rigid).max(axis=1, initial=0.0) > 1e-9
        first = self.number[self.train.speed_of] if self.train.speed_of else int(np.argmax(moving))
        rows += [
            np.eye(count)[body] - self.bodies[body].speed_ratio * np.eye(count)[first]
            for body in range(count)
            if self.bodies[body].speed_ratio is not None and body != first
        ]
        speed = null_space(np.array(rows), rcond=1e-9)
        assert speed.shape[1] <= 1, "speeds are not determined"
        self.speed = speed[:, 0] / speed[first, 0] if speed.shape[1] else np.zeros(count)
        self.speed[np.abs(self.speed) < 1e-9] = 0.0
        self.sense = np.where(self.speed < 0, -1.0, 1.0)
        if not speed.shape[1]:
            self._join_senses()

    def _join_senses(self):
        """Senses of bodies that do not turn: those in which gears on axes that stand still would turn together."""
        joints = [(*(self.number[name] for name in shaft.between), 1.0) for shaft in self.train.shafts or ()]
        joints += [(*(self.number[name] for name in mesh.between), 1.0 if mesh.internal else -1.0)
                   for mesh in self.train.meshes or () if not mesh.carrier]
        self.sense[:] = 0.0
        while (self.sense == 0).any():
            self.sense[np.argmax(self.sense == 0)] = 1.0
            for _ in self.bodies:
                for one, other, turn in joints:
                    if self.sense[one] and not self.sense[other]:
                        self.sense[other] = turn * self.sense[one]
                    elif self.sense[other] and not self.sense[one]:
                        self.sense[one] = turn * self.sense[other]

    # Elements

    def _find_elements(self):
        self.elements = []
        self.still = self.held.copy()  # held, or on a rigid shaft with a held body
        for _ in self.bodies:
            for shaft in self.train.shafts or ():
                ends = [self.number[name] for name in shaft.between]
                if shaft.rigid and self.still[ends].any():
                    self.still[ends] = True
        for shaft in self.train.shafts or ():
            if shaft.rigid:
                continue
            one, other = (self.number[name] for name in shaft.between)
            row = np.zeros(len(self.bodies))
            row[one], row[other] = self.sense[one], -self.sense[one]
            flexibility = sum(0.0 if self.still[body] else 1.0 / self.inertia[body] for body in (one, other))
            damping = shaft.damping
            if damping is None:
                damping = 2.0 * (shaft.damping_ratio or 0.0) * np.sqrt(shaft.stiffness / flexibility)
            self.elements.append(Element(row, shaft.stiffness, damping, None))
        self.shafts = len(self.elements)
        for mesh in self.train.meshes or ():
            row, driving, carrier = self._willis(mesh)
            lead = self.speed[driving] - (0.0 if carrier is None else self.speed[carrier])
            if abs(lead) < 1e-9:
                lead = 1.0 if carrier is not None else self.sense[driving]
            row = np.sign(lead) * row
            damping = mesh.damping
            if damping is None:
                flexibility = sum(0.0 if self.still[body] else radius**2 / self.inertia[body] for body, radius in zip(
                    (self.number[name] for name in mesh.between), (mesh.driving_radius, mesh.driven_radius)))
                damping = 2.0 * (mesh.damping_ratio or 0.0) * np.sqrt(mesh.stiffness / flexibility)
            self.elements.append(Element(row, mesh.stiffness, damping, mesh, mesh.half_backlash or 0.0))

    # Coordinates

    def _find_coordinates(self):
        """Coordinates Theta = P xi without held bodies and rigid shafts, then modes of the train with all meshes in contact."""
        count = len(self.bodies)
        constraints = [np.eye(count)[body] for body in range(count) if self.held[body]]
        for shaft in self.train.shafts or ():
            if shaft.rigid:
                one, other = (self.number[name] for name in shaft.between)
                constraints.append(np.eye(count)[one] - np.eye(count)[other])
        reduce = null_space(np.array(constraints)) if constraints else np.eye(count)
        self.reduce, rows = reduce, np.array([element.row for element in self.elements])
        stiffness = rows.T @ np.diag([element.stiffness for element in self.elements]) @ rows + np.diag(self.support)
        self.mass = reduce.T @ np.diag(self.inertia) @ reduce
        squares, modes = eigh(reduce.T @ stiffness @ reduce / self.omega**2, self.mass)
        motions = self.rigid.shape[1]
        assert (np.abs(squares[:motions]) < 1e-7 * squares[-1]).all() and (squares[motions:] > 1e-9 * squares[-1]).all()
        self.frequencies = np.sqrt(squares[motions:])
        self.modes, self.free = reduce @ modes[:, motions:], reduce @ modes[:, :motions]
        least = 1e-9 * np.abs(self.free).max(initial=0.0) * self.drag.max()
        if not np.abs(self.free.T @ np.diag(self.drag)).max(initial=0.0) > least:
            self.free = self.free[:, :0]  # without drag no force depends on the motion of the whole train
        self.count, self.more = self.modes.shape[1], self.free.shape[1]
        self.rows = rows
        self.shapes = rows @ self.modes / self.length
        self.fixed = np.hstack([self.modes, self.free])

    def _find_torques(self):
        """Mean torques in one sense, with those of the balancing bodies, which do no work together with the others."""
        self.given_torque = self.sense * np.array([body.torque or 0.0 for body in self.bodies])
        self.mean_torque = self.balanced(self.given_torque)
        orders = max([1, *(len(listed(values)) for body in self.bodies for values in (body.torque_cos, body.torque_sin))])
        self.torque_cos = np.array([sense * listed(body.torque_cos, orders) for sense, body in zip(self.sense, self.bodies)])
        self.torque_sin = np.array([sense * listed(body.torque_sin, orders) for sense, body in zip(self.sense, self.bodies)])

    def balanced(self, torque):
        """Torques with those of the balancing bodies such that they do no work on a motion of the whole train."""
        balancing = [number for number, body in enumerate(self.bodies) if body.balances]
        torque = torque.copy()
        if balancing:
            torque[balancing] += np.linalg.solve(self.rigid[balancing].T, -(self.rigid.T @ torque))
        return torque

    # Excitation

    def _find_excitation(self):
        """Complex amplitudes of stiffness, error and torque at harmonics 1, 2, ... of the fundamental."""
        meshes = [element.source for element in self.elements]
        orders = [self.torque_cos.shape[1]]
        orders += [(mesh.order or 1) * max(len(listed(values)) for values in (
            mesh.stiffness_cos, mesh.stiffness_sin, mesh.error_cos, mesh.error_sin)) for mesh in meshes if mesh is not None]
        self.orders = np.arange(1, max(orders) + 1)
        self.drive, self.back, self.error = np.zeros((3, len(meshes), len(self.orders)), complex)
        self.placed = np.array([0.0 if mesh is None else mesh.error_mean or 0.0 for mesh in meshes]) / self.length
        self.back_share = np.ones(len(meshes))
        for number, mesh in enumerate(meshes):
            if mesh is None:
                continue
            self.back_share[number] = (mesh.back_stiffness or mesh.stiffness) / mesh.stiffness
            self.drive[number] = self._amplitudes(mesh, mesh.stiffness_cos, mesh.stiffness_sin, mesh.phase or 0.0)
            self.back[number] = self._amplitudes(mesh, mesh.stiffness_cos, mesh.stiffness_sin,
                                                 (mesh.phase or 0.0) + (mesh.back_phase or 0.0))
            self.error[number] = self._amplitudes(mesh, mesh.error_cos, mesh.error_sin, mesh.phase or 0.0) / self.length
        self.torques = np.pad(self.torque_cos - 1j * self.torque_sin, ((0, 0), (0, len(self.orders) - self.torque_cos.shape[1])))

    def _amplitudes(self, mesh, cosines, sines, phase):
        amplitudes = np.zeros(len(self.orders), complex)
        for values, factor in ((listed(cosines), 1.0), (listed(sines), -1j)):
            for harmonic, value in enumerate(values, 1):
                amplitudes[(mesh.order or 1) * harmonic - 1] += factor * value * np.exp(-1j * harmonic * phase)
        return amplitudes

    def solve(self, torque, omega):
        """Amplitudes of the rotations [rad] of bodies on rigid shafts and springs to ground alone, under torques on all bodies."""
        reduce = self.reduce
        matrix = reduce.T @ np.diag(self.support + 1j * omega * self.drag - omega**2 * self.inertia) @ reduce
        return reduce @ np.linalg.solve(matrix, reduce.T @ torque)

    def wave(self, phase):
        return np.exp(1j * self.orders * phase)


class Flow:
    """Motions of a model at a frequency Lambda, by integration from one contact event to the next, with their tangents."""

    def __init__(self, model, frequency):
        self.model, self.frequency, self.rise = model, frequency, 0.0
        self.mean_torque = model.mean_torque
        elements = model.elements
        self.stiffness = np.array([element.stiffness for element in elements])
        self.always = np.array([element.source is None or element.source.damping_acts != "contact" for element in elements])
        self.damping = np.array([element.damping for element in elements])
        self.wall = np.array([element.backlash for element in elements]) / model.length
        self.gapped = self.wall > 0
        self.size = 2 * model.count + model.more
        # Accelerations of the coordinates per force of each element and per torque on each body, time in 1/omega.
        self.by_force = -(model.fixed.T @ model.rows.T) * model.length / model.omega**2
        self.by_torque = model.fixed.T / model.omega**2
        self.to_ground = -(model.fixed.T @ (model.drag[:, None] * model.fixed)) / model.omega
        self.spring = -(model.fixed.T @ (model.support[:, None] * model.modes)) / model.omega**2
        self.rate_shapes = model.rows @ model.fixed / model.length
        # State in displacements near 1.
        self.scale = 1.0 / max(np.abs(model.shapes).max(), 1e-300)

    def accelerate(self, rise, acceleration):
        """The flow of a run-up from time 0 on: rise of Lambda per unit of time, and mean accelerations of the bodies [rad/s^2]."""
        flow = Flow(self.model, self.frequency)
        flow.rise, flow.mean_torque = rise, self.model.balanced(self.model.given_torque - self.model.inertia * acceleration)
        return flow

    def phase(self, time):
        return (self.frequency + self.rise * time / 2) * time

    def speed(self, time):
        return self.frequency + self.rise * time

    def region(self, displacement):
        return np.where(self.gapped, np.where(displacement > self.wall, 1, np.where(displacement < -self.wall, -1, 0)), 1)

    def displacement(self, time, state):
        return self.model.shapes @ state[: self.model.count] * self.scale + self.error(time)

    def rate(self, time, state):
        rate = self.rate_shapes @ state[self.model.count : self.size] * self.scale
        return rate + self.error_rate(time)

    def error(self, time):
        return self.model.placed + (self.model.error @ self.model.wave(self.phase(time))).real

    def error_rate(self, time):
        return (self.model.error @ (1j * self.speed(time) * self.model.orders * self.model.wave(self.phase(time)))).real

    def force(self, time, state, region):
        """Forces of the elements over characteristic length, N/m."""
        slope, offset, damping = self.law(self.model.wave(self.phase(time)), region)
        return slope * (self.displacement(time, state) - offset) + damping * self.rate(time, state)

    def law(self, wave, region):
        """Stiffness, displacement without force, and damping of the elements in their regions."""
        model = self.model
        drive, back = 1.0 + (model.drive @ wave).real, model.back_share * (1.0 + (model.back @ wave).real)
        slope = self.stiffness * np.where(region > 0, drive, np.where(region < 0, back, 0.0))
        damping = np.where(self.always | (region != 0), self.damping, 0.0) * model.omega
        return slope, region * self.wall, damping

    def derivative(self, time, columns, region):
        """Derivative of a state (first column) and its tangents."""
        model, n = self.model, self.model.count
        wave = model.wave(self.phase(time))
        slope, offset, damping = self.law(wave, region)
        displacement = model.shapes @ columns[:n] * self.scale
        rate = self.rate_shapes @ columns[n:] * self.scale
        displacement[:, 0] += model.placed + (model.error @ wave).real - offset
        rate[:, 0] += (model.error @ (1j * self.speed(time) * model.orders * wave)).real
        accelerations = self.by_force @ (slope[:, None] * displacement + damping[:, None] * rate) / self.scale
        accelerations += self.to_ground @ columns[n:] + self.spring @ columns[:n]
        accelerations[:, 0] += self.by_torque @ (self.mean_torque + (model.torques @ wave).real) / self.scale
        return np.vstack([columns[n : 2 * n], accelerations])

    def run(self, state, begin, end, tangents=True, observe=None):
        """State at the end, and the matrix of tangents; ``observe(step)`` gets each step."""
        columns = np.column_stack([state, np.eye(self.size)]) if tangents else np.array(state)[:, None]
        time, region = begin, self.region(self.displacement(begin, state))
        on_wall = np.abs(np.abs(self.displacement(begin, state)) - self.wall) < 1e-12
        if (self.gapped & on_wall).any():
            region = self.region(self.displacement(begin, state) + 1e-9 * self.rate(begin, state))
        largest = 0.3 / self.model.frequencies[-1]
        while time < end:
            shape = columns.shape
            solver = DOP853(
                lambda t, y: self.derivative(t, y.reshape(shape), region).ravel(), time, columns.ravel(), end,  # noqa: B023
                rtol=ACCURACY, atol=ACCURACY * np.abs(columns[:, 0]).max(), max_step=min(largest, (end - begin) / 8))
            while solver.status == "running":
                solver.step()
                assert solver.status != "failed", "the integration failed"
                dense = solver.dense_output()
                event = self._event(dense, solver.t_old, solver.t, region, shape)
                if observe is not None:
                    observe(Step(dense, solver.t_old, event[0] if event else solver.t, region.copy(), shape))
                if event:
                    time, element, new = event
                    columns = self._pass(time, dense(time).reshape(shape), region, element, new)
                    region = region.copy()
                    region[element] = new
                    break
            else:
                time, columns = solver.t, solver.y.reshape(shape)
        return columns[:, 0], columns[:, 1:]

    def _event(self, dense, begin, end, region, shape):
        """First wall passed within a step: time, element and its new region."""
        times = begin + (end - begin) * np.linspace(0, 1, SAMPLES + 1)[1:]
        states = dense(times).reshape(*shape, -1)[:, 0]
        for place, time in enumerate(times):
            at = self.displacement(time, states[:, place])
            found = self.region(at)
            changed = np.flatnonzero(found != region)
            if not len(changed):
                continue
            before = begin if place == 0 else times[place - 1]
            events = []
            for element in changed:
                wall = self.wall[element] * (1 if max(found[element], region[element]) == 1 else -1)
                if region[element] * found[element] == -1:
                    wall = region[element] * self.wall[element]
                new = region[element] + np.sign(found[element] - region[element])

                def distance(t, element=element, wall=wall):
                    return self.displacement(t, dense(t).reshape(shape)[:, 0])[element] - wall

                # A mesh that passes its wall at the same time as the mesh before is behind it already.
                at_once = distance(before) * distance(time) >= 0
                events.append((before if at_once else brentq(distance, before, time, xtol=1e-15, rtol=1e-15), element, new))
            return min(events)
        return None

    def _pass(self, time, columns, region, element, new):
        """Tangents behind an event: the saltation matrix of a force that jumps."""
        after = region.copy()
        after[element] = new
        jump = self.derivative(time, columns, after)[:, 0] - self.derivative(time, columns, region)[:, 0]
        if columns.shape[1] == 1 or not np.abs(jump).max() > 0:
            return columns
        normal = np.zeros(self.size)
        normal[: self.model.count] = self.model.shapes[element] * self.scale
        speed = self.rate(time, columns[:, 0])[element]
        columns = columns.copy()
        columns[:, 1:] += np.outer(jump, normal @ columns[:, 1:]) / speed
        return columns

    def settle(self, periods, state=None, cycles=1):
        """State after so many periods of the fundamental, from rest in contact unless a state is given."""
        state = self.at_rest() if state is None else state
        period = 2 * np.pi / self.frequency
        for _ in range(periods):
            state, _ = self.run(state, 0.0, period * cycles, tangents=False)
        return state

    def at_rest(self):
        """State at rest under the mean torques, with the drive flanks in contact."""
        n = self.model.count
        matrix = self.by_force[:n] @ (self.stiffness[:, None] * self.model.shapes) + self.spring[:n]
        load = self.by_torque[:n] @ self.model.mean_torque
        load -= self.by_force[:n] @ (self.stiffness * (self.wall - self.model.placed))
        return np.concatenate([np.linalg.solve(matrix, -load) / self.scale, np.zeros(self.size - n)])

    def state_of(self, force, displacement, cycles=1):
        """State at time 0 of a periodic motion of so many cycles, from its forces [N] of a period, (samples, elements), and the
        mean displacements of the elements in characteristic lengths, (elements): the start of shooting."""
        model = self.model
        count = min(len(force) // 2, 400 * cycles)
        waves = np.fft.rfft(force, axis=0)[: count + 1] / len(force)
        rotation, rate = np.zeros((2, len(model.bodies)))
        for harmonic in range(1, count):
            omega = harmonic * self.frequency * model.omega / cycles
            torque = -2.0 * model.rows.T @ waves[harmonic]
            if harmonic % cycles == 0 and harmonic // cycles <= len(model.orders):
                torque = torque + model.torques[:, harmonic // cycles - 1]
            amplitude = model.solve(torque, omega)
            rotation += amplitude.real
            rate += (1j * omega / model.omega * amplitude).real
        rows, right = model.rows / model.length, displacement - model.placed
        if model.support.any():
            rows = np.vstack([rows, np.diag(model.support) / model.support.max()])
            right = np.concatenate([right, (model.mean_torque - model.rows.T @ waves[0].real) / model.support.max()])
            right[len(displacement):][model.support == 0] = 0.0
        rotation += model.reduce @ np.linalg.lstsq(rows @ model.reduce, right, rcond=1e-10)[0]
        momentum = model.inertia[:, None] * model.fixed
        return np.concatenate([momentum[:, : model.count].T @ rotation, momentum.T @ rate]) / self.scale

    def shoot(self, state, cycles=1, iterations=30, tolerance=3e-12):
        """Periodic motion near a state."""
        period = 2 * np.pi * cycles / self.frequency
        least = np.inf
        for _ in range(iterations):
            end, matrix = self.run(state, 0.0, period)
            step = np.linalg.lstsq(matrix - np.eye(self.size), state - end, rcond=1e-13)[0]
            size = np.abs(step).max() / np.abs(state).max()
            if size < tolerance or (size < 1e-9 and size > least / 2):
                break
            least = min(least, size)
            state = state + step
        else:
            raise AssertionError(f"shooting does not converge: step {size:.1e}")
        return Orbit(self, state + step, cycles)


@dataclass
class Step:
    """A step between contact events."""

    dense: object
    begin: float
    end: float
    region: np.ndarray
    shape: tuple

    def states(self, fractions):
        times = self.begin + (self.end - self.begin) * np.asarray(fractions)
        return times, self.dense(times).reshape(*self.shape, -1)[:, 0]


class Orbit:
    """A periodic motion with its figures."""

    def __init__(self, flow, state, cycles):
        self.flow, self.state, self.cycles = flow, state, cycles
        self.period = 2 * np.pi * cycles / flow.frequency
        count = len(flow.model.elements)
        sums = np.zeros((6, count))  # p, p^2, F, F^2, separation, back contact
        self.minimum, self.maximum = np.full(count, np.inf), np.full(count, -np.inf)
        self.force_minimum, self.force_maximum = np.full(count, np.inf), np.full(count, -np.inf)

        def observe(step):
            times, states = step.states(NODES)
            width = step.end - step.begin
            for time, weight, now in zip(times, WEIGHTS, states.T):
                p, force = flow.displacement(time, now), flow.force(time, now, step.region)
                sums[:4] += weight * width * np.array([p, p**2, force, force**2])
            sums[4] += width * (step.region == 0)
            sums[5] += width * (step.region < 0)
            self._extremes(step)

        self.end, self.matrix = flow.run(state, 0.0, self.period, observe=observe)
        self.mean = sums[0] / self.period
        self.true_ac_rms = np.sqrt(np.maximum(sums[1] / self.period - self.mean**2, 0.0))
        unit = flow.model.length
        self.force_mean = sums[2] / self.period * unit
        self.force_minimum, self.force_maximum = self.force_minimum * unit, self.force_maximum * unit
        self.separation, self.back_contact = sums[4] / self.period, sums[5] / self.period
        self.multipliers = np.linalg.eigvals(self.matrix)

    def _extremes(self, step):
        """Includes the extremes of a step, by a polynomial through samples of displacement and force."""
        times, states = step.states(PLACES)
        values = np.array([np.concatenate([self.flow.displacement(time, now), self.flow.force(time, now, step.region)])
                           for time, now in zip(times, states.T)]).T
        low, high = values.min(axis=1), values.max(axis=1)
        series = np.linalg.solve(POLYNOMIALS, values.T)
        slopes = chebyshev.chebval(2 * PLACES - 1, chebyshev.chebder(series))
        for number in np.flatnonzero(slopes.min(axis=1) * slopes.max(axis=1) <= 0):
            roots = chebyshev.chebroots(chebyshev.chebder(series[:, number]))
            inner = chebyshev.chebval(roots[(np.abs(roots.imag) < 1e-9) & (np.abs(roots.real) < 1)].real, series[:, number])
            low[number], high[number] = min(low[number], *inner, low[number]), max(high[number], *inner, high[number])
        count = len(low) // 2
        self.minimum, self.maximum = np.minimum(self.minimum, low[:count]), np.maximum(self.maximum, high[:count])
        self.force_minimum = np.minimum(self.force_minimum, low[count:])
        self.force_maximum = np.maximum(self.force_maximum, high[count:])


def linear_response(model, frequency, orders):
    """Complex amplitudes of the displacements of all elements in characteristic lengths, (elements, orders), of a train without
    backlash and with constant stiffness: equations of all bodies, without modes."""
    free = [body for body in range(len(model.bodies)) if not model.held[body]]
    rows = model.rows[:, free]
    stiffness, damping = (np.array([getattr(element, name) for element in model.elements]) for name in ("stiffness", "damping"))
    amplitudes = np.zeros((len(model.elements), orders), complex)
    matrix = rows.T @ (stiffness[:, None] * rows) + np.diag(model.support[free])
    placed = model.placed * model.length
    mean = np.linalg.lstsq(matrix, model.mean_torque[free] - rows.T @ (stiffness * placed), rcond=1e-12)[0]
    for order in range(1, min(orders, len(model.orders)) + 1):
        omega = order * frequency * model.omega
        errors, torque = model.error[:, order - 1] * model.length, model.torques[:, order - 1]
        dynamic = stiffness + 1j * omega * damping
        matrix = rows.T @ (dynamic[:, None] * rows) - omega**2 * np.diag(model.inertia[free])
        matrix = matrix + np.diag(model.support[free] + 1j * omega * model.drag[free])
        rotation = np.linalg.solve(matrix, torque[free] - rows.T @ (dynamic * errors))
        amplitudes[:, order - 1] = (rows @ rotation + errors) / model.length
    return (rows @ mean + placed) / model.length, amplitudes


def farthest(found, known):
    """Largest distance of values to their partners among as many or more known values."""
    distance = np.abs(np.asarray(known)[:, None] - np.asarray(found)[None, :])
    return distance[linear_sum_assignment(distance)].max(initial=0.0)
