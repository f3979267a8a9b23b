"""Trains with couplings, random ones too, and equations of their own by SciPy: what the tests of couplings and friction share."""

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

import geartrain as gt

LENGTH, RATE = 10e-6, 1000.0  # characteristic_length, characteristic_frequency
PER_TWIST = 1e-3 / LENGTH  # displacement over characteristic_length per radian


def torque_of(coupling, twist):
    """The polygon of a coupling at a twist, which goes on beyond its ends."""
    x, y = np.asarray(coupling.angle, float), np.asarray(coupling.torque, float)
    part = np.clip(np.searchsorted(x, twist) - 1, 0, len(x) - 2)
    slope = np.diff(y) / np.diff(x)
    return y[part] + slope[part] * (twist - x[part])


def middle_of(coupling):
    """Angle from which the displacement of a result is counted."""
    x, y = np.asarray(coupling.angle, float), np.asarray(coupling.torque, float)
    flat = np.flatnonzero((y[1:] == 0) & (y[:-1] == 0))
    if len(flat):
        return (x[flat[0]] + x[flat[-1] + 1]) / 2
    return float(np.interp(0.0, y, x))


def rotor(load, **coupling):
    """A rotor on a coupling to a housing."""
    return gt.Train(
        characteristic_length=LENGTH, characteristic_frequency=RATE,
        bodies=[gt.Body(name="rotor", inertia=0.02, torque=load), gt.Body(name="housing", held=True)],
        couplings=[gt.Coupling(between=("rotor", "housing"), **coupling)],
    )


class Equations:
    """Rotations of all bodies as they are: I theta'' = T - B' F, and its tangents, by SciPy."""

    def __init__(self, train):
        self.train, names = train, [body.name for body in train.bodies]
        self.inertia = np.array([body.inertia for body in train.bodies])
        self.torque = np.array([body.torque or 0.0 for body in train.bodies])
        self.cosine = np.array([(body.torque_cos or [0.0])[0] for body in train.bodies])
        self.rows = []
        for joint in (*train.meshes, *train.couplings):
            row = np.zeros(len(names))
            mesh = isinstance(joint, gt.Mesh)
            row[names.index(joint.between[0])] = joint.driving_radius if mesh else 1.0
            row[names.index(joint.between[1])] = -(joint.driven_radius if mesh else 1.0)
            self.rows.append(row)
        self.rows = np.array(self.rows)
        rigid = np.linalg.svd(self.rows)[2][-1]
        balancing = next(place for place, body in enumerate(train.bodies) if body.balances)
        self.torque[balancing] = 0.0
        self.torque[balancing] = -(rigid @ self.torque) / rigid[balancing]
        self.middle = np.array([middle_of(joint) if isinstance(joint, gt.Coupling) else 0.0
                                for joint in (*train.meshes, *train.couplings)])
        # What results count as one.
        self.unit = np.array([LENGTH] * len(train.meshes) + [LENGTH / 1e-3] * len(train.couplings))

    def force(self, phase, p, v):
        """Force or torque of each joint, and its derivatives by p and v."""
        force, slope, damping = np.zeros_like(p), np.zeros_like(p), np.zeros_like(p)
        for place, joint in enumerate((*self.train.meshes, *self.train.couplings)):
            if isinstance(joint, gt.Mesh):
                side = np.sign(p[place]) if abs(p[place]) > joint.half_backlash else 0.0
                slope[place] = abs(side) * joint.stiffness * (1 + joint.stiffness_cos[0] * np.cos(phase))
                force[place] = slope[place] * (p[place] - side * joint.half_backlash)
            else:
                force[place] = torque_of(joint, p[place])
                x, y = np.asarray(joint.angle, float), np.asarray(joint.torque, float)
                part = np.clip(np.searchsorted(x, p[place]) - 1, 0, len(x) - 2)
                slope[place] = (y[part + 1] - y[part]) / (x[part + 1] - x[part])
            damping[place] = joint.damping
            force[place] += joint.damping * v[place]
        return force, slope, damping

    def derivative(self, t, z, omega):
        bodies = len(self.inertia)
        z = z.reshape(2 * bodies, -1)
        theta, rate = z[:bodies, 0], z[bodies:, 0]
        force, slope, damping = self.force(omega * t, self.rows @ theta, self.rows @ rate)
        result = np.empty_like(z)
        result[:bodies] = z[bodies:]
        result[bodies:, 0] = (self.torque + self.cosine * np.cos(omega * t) - self.rows.T @ force) / self.inertia
        result[bodies:, 1:] = -(self.rows.T @ (slope[:, None] * (self.rows @ z[:bodies, 1:])
                                               + damping[:, None] * (self.rows @ z[bodies:, 1:]))) / self.inertia[:, None]
        return result.ravel()

    def fly(self, motion, samples):
        """Displacements over a period from that of the motion at time 0, as results count them, and the map of small changes."""
        omega = motion.frequency * RATE
        period = 2 * np.pi * motion.period / omega
        path = motion.trajectory(motion.period)
        displacement, velocity = path.displacement[0] * self.unit + self.middle, path.velocity[0] * self.unit * RATE
        inverse = np.linalg.pinv(self.rows)
        tree = []
        for place in range(len(self.rows)):
            if np.linalg.matrix_rank(self.rows[[*tree, place]]) > len(tree):
                tree.append(place)
        assert np.abs(self.rows @ inverse @ displacement - displacement).max() < 1e-9 * np.abs(displacement).max()
        into = np.linalg.pinv(self.rows[tree] / self.unit[tree, None])
        still = np.zeros_like(into)
        start = np.column_stack([np.concatenate([inverse @ displacement, inverse @ velocity]),
                                 np.block([[into, still], [still, into * RATE]])])
        # Pieces: the error of a step counts from its own beginning, and kinks are met by ever smaller steps.
        found = solve_ivp(self.derivative, (0, period), start.ravel(), "DOP853", np.linspace(0, period, samples + 1), rtol=2e-13,
                          atol=1e-15, args=(omega,), max_step=period / 200)
        bodies = len(self.inertia)
        end = found.y[:, -1].reshape(2 * bodies, -1)[:, 1:]
        out = self.rows[tree] / self.unit[tree, None]
        change = np.block([[out @ end[:bodies]], [out @ end[bodies:] / RATE]])
        theta = found.y.reshape(2 * bodies, -1, samples + 1)[:bodies, 0]
        return (self.rows @ theta - self.middle[:, None]) / self.unit[:, None], np.linalg.eigvals(change)


def random_coupling(rng, between, centred):
    """Up to five stages, with or without play, softer or harder outwards as the dice fall."""
    stages = rng.integers(1, 6)
    x = np.cumsum(rng.uniform(0.003, 0.01, stages + 1))
    y = np.cumsum(np.concatenate([[0.0], rng.uniform(4.0, 40.0, stages)]))
    rest = rng.integers(0, stages)
    y -= y[rest] + rng.uniform(0, 1) * (y[rest + 1] - y[rest])
    if stages > 2 and rng.uniform() < 0.6:  # a play amid the stages
        rest = rng.integers(1, stages - 1)
        y[rest + 1:] -= y[rest + 1] - y[rest]
        y -= y[rest]
        y[rest:rest + 2] = 0.0
    coupling = gt.Coupling(between=between, angle=x.tolist(), torque=y.tolist(), damping=float(rng.uniform(0.3, 1.0)))
    shift = middle_of(coupling) if centred else x[rest] - 0.003
    return replace(coupling, angle=(x - shift).tolist())


def random_train(seed):
    """A tree of gear pairs and couplings as the dice fall; in every third train two couplings side by side."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 6))
    names = [f"b{place}" for place in range(count)]
    bodies = [gt.Body(name=names[0], inertia=0.03, torque=float(rng.uniform(15, 40)), torque_cos=[float(rng.uniform(5, 30))]),
              *(gt.Body(name=name, inertia=float(rng.uniform(0.004, 0.02)), balances=name == names[-1]) for name in names[1:])]
    meshes, couplings = [], []
    loop = seed % 3 == 0
    for place in range(1, count):
        ends = (names[int(rng.integers(max(0, place - 2), place))], names[place])
        if place > 1 and rng.uniform() < 0.5:
            meshes.append(gt.Mesh(between=ends, driving_radius=0.03, driven_radius=float(rng.uniform(0.03, 0.06)),
                                  stiffness=float(rng.uniform(0.5e7, 2e7)), damping=float(rng.uniform(500, 1500)),
                                  half_backlash=20e-6, stiffness_cos=[float(rng.uniform(0.05, 0.25))]))
        else:
            couplings.append(random_coupling(rng, ends, loop))
            if loop and place == 1:
                couplings.append(random_coupling(rng, ends, loop))
    return gt.Train(characteristic_length=LENGTH, characteristic_frequency=RATE, bodies=bodies, meshes=meshes, couplings=couplings)
