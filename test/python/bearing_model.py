"""Gear pairs and trees of gears on bearings by equations of their own, in coordinates of their own."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geartrain as gt

__all__ = ["LENGTH", "RATE", "Model", "compare", "pair", "random_train"]

LENGTH, RATE = 10e-6, 1e4  # characteristic_length, characteristic_frequency


def pair(**given):
    """A gear pair on two bearings; what is given goes to the mesh, `pinion` and `wheel` to the bearings."""
    bearings = {"pinion": {"mass": 1.9, "stiffness": [2.0e8, 1.5e8], "damping": [500.0, 600.0]},
                "wheel": {"mass": 6.0, "stiffness": [3.0e8, 2.5e8], "damping": [800.0, 900.0]}}
    for name, values in bearings.items():
        values.update(given.pop(name, {}))
    places = given.pop("places", ([0.0, 0.0], [0.13, 0.095]))
    mesh = {"driving_radius": 0.05, "driven_radius": 0.1, "stiffness": 2.5e8, "damping": 2000.0, **given}
    return gt.Train(
        characteristic_length=LENGTH, characteristic_frequency=RATE, speed_of=mesh.pop("speed_of", None),
        bodies=[gt.Body(name="pinion", inertia=2.3e-3, torque=90.0, position=places[0]),
                gt.Body(name="wheel", inertia=0.037, balances=True, position=places[1])],
        meshes=[gt.Mesh(between=("pinion", "wheel"), **mesh)],
        bearings=[gt.Bearing(body=name, **values) for name, values in bearings.items()],
    )


class Model:
    """A tree of gears in coordinates of its own: r_a theta_a - r_b theta_b of every mesh, then x and y of bodies on bearings."""

    def __init__(self, train):
        bodies = {body.name: place for place, body in enumerate(train.bodies)}
        self.carried = {bearing.body: place for place, bearing in enumerate(train.bearings)}
        self.meshes, self.bearings = train.meshes, train.bearings
        self.turning = np.zeros((len(train.meshes), len(bodies)))
        self.moving = np.zeros((len(train.meshes), 2 * len(train.bearings)))
        for row, mesh in enumerate(train.meshes):
            line = np.radians(train.explain()[f"mesh {row + 1}"].get("line_of_action", 0.0))
            for name, radius, sign in zip(mesh.between, (mesh.driving_radius, mesh.driven_radius), (1, -1)):
                self.turning[row, bodies[name]] = sign * radius
                if name in self.carried:
                    place = 2 * self.carried[name]
                    self.moving[row, place:place + 2] = sign * np.cos(line), sign * np.sin(line)
        inertia = np.array([body.inertia for body in train.bodies])
        torque = np.array([body.torque or 0.0 for body in train.bodies])
        # The load balances all torques: they do no work where all gears turn without deflection.
        rigid = np.linalg.svd(self.turning)[2][-1]
        load = next(place for place, body in enumerate(train.bodies) if body.balances)
        torque[load] = -(torque @ rigid) / rigid[load]
        self.steady = self.turning @ (torque / inertia)
        self.couple = self.turning @ (self.turning / inertia).T
        self.mass = np.repeat([bearing.mass for bearing in train.bearings], 2)
        self.c = np.concatenate([bearing.damping for bearing in train.bearings])
        self.gap = np.array([mesh.half_backlash or 0.0 for mesh in train.meshes])
        self.put_rows(train.bearings)

    def excitation(self, phase):
        """Stiffnesses, errors over their derivative by the phase."""
        stiffness, error, slope = np.empty((3, len(self.meshes)))
        for row, mesh in enumerate(self.meshes):
            order = mesh.order or 1
            cosine, sine = mesh.stiffness_cos or [], mesh.stiffness_sin or []
            stiffness[row] = mesh.stiffness * (1 + sum(a * np.cos(h * order * phase) for h, a in enumerate(cosine, 1))
                                               + sum(a * np.sin(h * order * phase) for h, a in enumerate(sine, 1)))
            errors = list(enumerate(mesh.error_cos or [], 1))
            error[row] = sum(a * np.cos(h * order * phase) for h, a in errors)
            slope[row] = -sum(a * h * order * np.sin(h * order * phase) for h, a in errors)
        return stiffness, error, slope

    def put_rows(self, bearings):
        """Directions of the springs of the bearings, (row, coordinate): x and y of all, then those between them; their gaps."""
        flats = [int(bearing.flats or 4) for bearing in bearings]
        angles = [(place, 90.0 * axis) for place in range(len(flats)) for axis in (0, 1)]
        angles += [(place, 360.0 * row / count) for place, count in enumerate(flats) for row in range(1, count // 2)
                   if row != count // 4]
        self.rows = np.zeros((len(angles), 2 * len(flats)))
        for row, (place, angle) in enumerate(angles):
            self.rows[row, 2 * place:2 * place + 2] = np.round([np.cos(np.radians(angle)), np.sin(np.radians(angle))], 15)
        self.share = np.array([4 / flats[place] * bearings[place].stiffness[row % 2] for row, (place, _) in enumerate(angles)])
        self.play = np.array([bearings[place].half_clearance or 0.0 for place, _ in angles])

    def support(self, u, du):
        """Forces on the bearings, of a column of displacements each."""
        w = self.rows @ u
        spring = self.share[:, None] * np.sign(w) * np.maximum(np.abs(w) - self.play[:, None], 0.0)
        return self.rows.T @ spring + self.c[:, None] * du

    def derivative(self, t, z, omega):
        count = len(self.meshes)
        z = z.reshape(2 * (count + len(self.mass)), -1)
        q, u, dq, du = np.split(z, [count, count + len(self.mass), 2 * count + len(self.mass)])
        stiffness, error, slope = self.excitation(omega * t)
        damping = np.array([mesh.damping for mesh in self.meshes])

        def law(p, gap):
            return np.sign(p) * np.maximum(np.abs(p) - gap, 0.0), (np.abs(p) > gap) * 1.0

        p, dp = q + self.moving @ u, dq + self.moving @ du
        p[:, 0] += error
        dp[:, 0] += omega * slope
        g, contact = law(p[:, 0], self.gap)
        force = (stiffness * contact)[:, None] * p + damping[:, None] * dp
        force[:, 0] = stiffness * g + damping * dp[:, 0]
        contact = np.abs(self.rows @ u[:, 0]) > self.play
        support = self.rows.T @ ((self.share * contact)[:, None] * (self.rows @ u)) + self.c[:, None] * du
        support[:, :1] = self.support(u[:, :1], du[:, :1])
        result = np.empty_like(z)
        result[:count + len(self.mass)] = z[count + len(self.mass):]
        result[count + len(self.mass):2 * count + len(self.mass)] = -self.couple @ force
        result[count + len(self.mass):2 * count + len(self.mass), 0] += self.steady
        result[2 * count + len(self.mass):] = -(self.moving.T @ force + support) / self.mass[:, None]
        return result.ravel()

    def fly(self, motion, samples):
        """Displacements over a period from that of the motion at time 0, as results count them, forces of bearings, multipliers."""
        count, omega = len(self.meshes), motion.frequency * RATE
        period = 2 * np.pi * motion.period / omega
        path = motion.trajectory(motion.period)
        p, dp = path.displacement[0] * LENGTH, path.velocity[0] * LENGTH * RATE
        _, error, slope = self.excitation(0.0)
        own = slice(count, count + len(self.mass))
        q = p[:count] - error - self.moving @ p[own]
        dq = dp[:count] - omega * slope - self.moving @ dp[own]
        start = np.concatenate([q, p[own], dq, dp[own]])
        size = len(start)
        # Displacements and velocities of one unit, so that a tolerance means the same for both.
        unit = np.repeat([LENGTH, LENGTH * RATE], size // 2)
        instants = np.linspace(0, period, samples + 1)

        def scaled(t, z):
            z = z.reshape(size, -1)
            return (self.derivative(t, (z * unit[:, None]).ravel(), omega).reshape(size, -1) / unit[:, None]).ravel()

        found = solve_ivp(scaled, (0, period), np.column_stack([start / unit, np.eye(size)]).ravel(), "DOP853", instants,
                          rtol=2e-13, atol=1e-14, max_step=period / 200)
        end = found.y[:, -1].reshape(size, -1)[:, 1:]
        path = found.y.reshape(size, -1, samples + 1)[:, 0] * unit[:, None]
        u, du = path[count:size // 2], path[size // 2 + count:]
        errors = np.array([self.excitation(omega * t)[1] for t in instants]).T
        out = np.concatenate([path[:count] + self.moving @ u + errors, self.rows @ u]) / LENGTH
        return out, self.support(u, du), np.linalg.eigvals(end)


def compare(train, motion, samples=720):
    """A motion by shooting against its own path by other equations."""
    path, support, multipliers = Model(train).fly(motion, samples)
    scale = np.abs(path).max(1)
    assert (np.abs(path[:, -1] - path[:, 0]) < 2e-9 * scale.max()).all(), "the path does not close"
    path, support = path[:, :-1], support[:, :-1]
    rms = np.sqrt(2 * np.mean((path - path.mean(1, keepdims=True)) ** 2, 1))
    assert motion.rms == pytest.approx(rms, abs=1e-8 * rms.max())
    assert motion.mean == pytest.approx(path.mean(1), abs=1e-8 * scale.max())
    # By equidistant samples: extremes within their curvature between two of them.
    assert motion.maximum == pytest.approx(path.max(1), abs=1e-3 * scale.max())
    force = support.reshape(-1, 2, support.shape[1])
    largest = np.abs(force).max()
    # Means of equidistant samples of a force whose slope jumps: 1/720**2.
    assert motion.bearing_force_mean == pytest.approx(force.mean(2), abs=2e-6 * largest)
    assert motion.bearing_force_rms == pytest.approx(force.std(2), abs=2e-6 * largest)
    assert motion.bearing_force_minimum == pytest.approx(force.min(2), abs=1e-3 * largest)
    assert motion.bearing_force_maximum == pytest.approx(force.max(2), abs=1e-3 * largest)
    left = list(multipliers)
    for multiplier in motion.multipliers:
        nearest = min(left, key=lambda other: abs(other - multiplier))
        assert abs(nearest - multiplier) < 1e-7 * max(1, abs(multiplier))
        left.remove(nearest)
    assert not left


def random_train(seed):
    """A tree of three or four gears, some on bearings, some of these with clearance."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 5))
    names = [f"g{place}" for place in range(count)]
    radii, places, meshes = [0.04], [np.zeros(2)], []
    for place in range(1, count):
        before = int(rng.integers(max(0, place - 2), place))
        radii.append(float(rng.uniform(0.04, 0.08)))
        distance = (radii[before] + radii[place]) / np.cos(np.radians(rng.uniform(18, 25)))
        angle = rng.uniform(0, 2 * np.pi)
        places.append(places[before] + distance * np.array([np.cos(angle), np.sin(angle)]))
        meshes.append(gt.Mesh(between=(names[before], names[place]), driving_radius=radii[before], driven_radius=radii[place],
                              stiffness=float(rng.uniform(1e8, 3e8)), damping=float(rng.uniform(2e3, 5e3)),
                              half_backlash=float(rng.choice([0.0, 2e-5])), stiffness_cos=[float(rng.uniform(0.05, 0.3))],
                              order=1, error_cos=[float(rng.uniform(0, 4e-6))]))
    bodies = [gt.Body(name=name, inertia=float(rng.uniform(2e-3, 2e-2)), torque=90.0 if place == 0 else None,
                      balances=place == count - 1, position=places[place].tolist()) for place, name in enumerate(names)]
    # An idle gear has a load, or its place in the gap is arbitrary.
    bodies = [body if place in (0, count - 1) else replace(body, torque=-8.0) for place, body in enumerate(bodies)]
    carried = rng.permutation(count)[:int(rng.integers(1, count + 1))]
    bearings = [gt.Bearing(body=names[place], mass=float(rng.uniform(1.5, 6)), stiffness=rng.uniform(1e8, 4e8, 2).tolist(),
                           damping=rng.uniform(2e3, 5e3, 2).tolist(), half_clearance=float(rng.choice([0.0, 5e-6])))
                for place in carried]
    if seed % 3 == 2:
        bearings = [replace(bearing, flats=8, stiffness=bearing.stiffness[:1] * 2, damping=bearing.damping[:1] * 2)
                    if bearing.half_clearance else bearing for bearing in bearings]
    return gt.Train(characteristic_length=LENGTH, characteristic_frequency=RATE, bodies=bodies, meshes=meshes, bearings=bearings)
