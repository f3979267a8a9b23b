"""Trains of gear pairs and couplings with dry friction by equations of their own, from event to event."""

from dataclasses import replace
from itertools import product

import numpy as np
from coupling_model import LENGTH, RATE, middle_of, random_coupling
from scipy.linalg import expm
from scipy.optimize import brentq

import geartrain as gt

__all__ = ["Events", "random_train"]


class Events:
    """I theta'' = T - B' (F + R) from event to event by matrix exponentials, in rotations; R is dry friction.

    Between events the equations are linear with constant coefficients: the torque's cosine and sine are two states more.
    """

    def __init__(self, train, omega):
        self.train, self.omega = train, omega
        names = [body.name for body in train.bodies]
        self.bodies = len(names)
        self.inverse = np.diag([1 / body.inertia for body in train.bodies])
        self.joints = (*train.meshes, *train.couplings)
        rows = np.zeros((len(self.joints), self.bodies))
        for row, joint in zip(rows, self.joints):
            mesh = isinstance(joint, gt.Mesh)
            row[names.index(joint.between[0])] = joint.driving_radius if mesh else 1.0
            row[names.index(joint.between[1])] = -(joint.driven_radius if mesh else 1.0)
        self.rows = rows
        rigid = np.linalg.svd(rows)[2][-1]
        balancing = next(place for place, body in enumerate(train.bodies) if body.balances)
        self.torque = np.array([body.torque or 0.0 for body in train.bodies])
        self.torque[balancing] = -(rigid @ self.torque - rigid[balancing] * self.torque[balancing]) / rigid[balancing]
        self.cosine = np.array([(body.torque_cos or [0.0])[0] for body in train.bodies])
        self.middle = np.array([0.0 if isinstance(joint, gt.Mesh) else middle_of(joint) for joint in self.joints])
        self.unit = np.array([LENGTH if isinstance(joint, gt.Mesh) else LENGTH / 1e-3 for joint in self.joints])
        self.limit = np.array([0.0 if isinstance(joint, gt.Mesh) else joint.friction_torque for joint in self.joints])
        self.rubbing = np.flatnonzero(self.limit)
        self.corners, self.slopes, self.offsets = [], [], []
        for joint in self.joints:
            if isinstance(joint, gt.Mesh):
                b, k = joint.half_backlash, joint.stiffness
                corners, slopes, offsets = np.array([-b, b]), np.array([k, 0.0, k]), np.array([k * b, 0.0, -k * b])
            else:
                x, y = np.asarray(joint.angle, float), np.asarray(joint.torque, float)
                slopes = np.diff(y) / np.diff(x)
                corners, offsets = x[1:-1], y[:-1] - slopes * x[:-1]
            self.corners.append(corners), self.slopes.append(slopes), self.offsets.append(offsets)
        self.kept = {}

    def matrix(self, regions, modes):
        """The equations in constant regions and modes (1, -1, 0 sticks): z' = A z, z = rotations, rates, cos, sin, 1."""
        if (regions, modes) in self.kept:
            return self.kept[regions, modes]
        n = self.bodies
        stiffness = np.array([slope[region] for slope, region in zip(self.slopes, regions)])
        offset = np.array([given[region] for given, region in zip(self.offsets, regions)])
        damping = np.array([joint.damping for joint in self.joints])
        constant = offset.copy()
        for joint, mode in zip(self.rubbing, modes):
            constant[joint] += mode * self.limit[joint]
        free = np.zeros((n, 2 * n + 3))
        free[:, :n] = -self.inverse @ self.rows.T @ (stiffness[:, None] * self.rows)
        free[:, n:2 * n] = -self.inverse @ self.rows.T @ (damping[:, None] * self.rows)
        free[:, 2 * n] = self.inverse @ self.cosine
        free[:, -1] = self.inverse @ (self.torque - self.rows.T @ constant)
        stuck = self.rows[[joint for joint, mode in zip(self.rubbing, modes) if mode == 0]]
        reaction = np.zeros((0, 2 * n + 3))
        if len(stuck):
            reaction = np.linalg.solve(stuck @ self.inverse @ stuck.T, stuck @ free)
            free = free - self.inverse @ stuck.T @ reaction
        a = np.zeros((2 * n + 3, 2 * n + 3))
        a[:n, n:2 * n] = np.eye(n)
        a[n:2 * n] = free
        a[2 * n, 2 * n + 1], a[2 * n + 1, 2 * n] = -self.omega, self.omega
        self.kept[regions, modes] = a, reaction, expm(a * self.step)
        return self.kept[regions, modes]

    def watched(self, regions, modes):
        """Functions of z that are positive until an event, as rows, and what each event is."""
        n = self.bodies
        _, reaction, _ = self.matrix(regions, modes)
        rows, what, stuck = [], [], 0
        held = {joint for joint, mode in zip(self.rubbing, modes) if mode == 0}
        for joint, (corners, region) in enumerate(zip(self.corners, regions)):
            if joint in held:  # it may stick at a corner, and moves to neither side
                continue
            for side, place in ((1, region - 1), (-1, region)):
                if 0 <= place < len(corners):
                    row = np.zeros(2 * n + 3)
                    row[:n], row[-1] = side * self.rows[joint], -side * corners[place]
                    rows.append(row), what.append(("wall", joint, -side))
        for place, (joint, mode) in enumerate(zip(self.rubbing, modes)):
            if mode == 0:
                for side in (1, -1):
                    row = -side * reaction[stuck]
                    row[-1] += self.limit[joint]
                    rows.append(row), what.append(("limit", place, side))
                stuck += 1
            else:
                row = np.zeros(2 * n + 3)
                row[n:2 * n] = mode * self.rows[joint]
                rows.append(row), what.append(("still", place, mode))
        return np.array(rows), what

    def decide(self, z, regions, modes, still):
        """The modes of couplings without velocity that contradict nothing, by trying all."""
        n = self.bodies
        for tried in product((0, 1, -1), repeat=len(still)):
            new = list(modes)
            for place, mode in zip(still, tried):
                new[place] = mode
            a, reaction, _ = self.matrix(regions, tuple(new))
            force = reaction @ z
            held = [joint for joint, mode in zip(self.rubbing, new) if mode == 0]
            if any(abs(value) > self.limit[joint] for value, joint in zip(force, held)):
                continue
            rate = self.rows @ (a @ z)[n:2 * n]
            if all(mode == 0 or mode * rate[self.rubbing[place]] > 0 for place, mode in zip(still, tried)):
                return tuple(new)
        raise AssertionError("no modes without contradiction")

    def first_event(self, z, left, regions, modes, known):
        """The first event within a time: when, its function, and what it is; None without."""
        a, _, whole = self.matrix(regions, modes)
        rows, what = self.watched(regions, modes)
        ends = {1.0: (whole if left == self.step else expm(a * left)) @ z}
        if (rows @ ends[1.0]).min() < 1e-6 * np.abs(rows @ z).max():
            ends[0.5] = expm(a * left / 2) @ z
        first = None
        for row, event in zip(rows, what):
            end = next((share for share in sorted(ends) if row @ ends[share] < 0), None)
            if end is None:
                continue
            begin, value = 0.0, row @ z
            if event == known:  # it is 0 at the beginning, and grows
                begin = 0.1 * end * left
                value = row @ expm(a * begin) @ z
            at = 0.0
            if value > 0:
                at = end * left
                if distance(at, row, a, z) < 0:  # as before, but for rounding
                    at = brentq(distance, begin, at, args=(row, a, z), xtol=1e-18, rtol=1e-15)
            if first is None or at < first[0]:
                first = at, row, event
        return first

    def fly(self, motion, samples):
        """Over a period: displacements as results count them, energy that couplings lose, multipliers, whether any stuck."""
        n, omega = self.bodies, self.omega
        path = motion.trajectory(motion.period)
        p, v = path.displacement[0] * self.unit + self.middle, path.velocity[0] * self.unit * RATE
        self.step = 2 * np.pi * motion.period / omega / samples
        inverse = np.linalg.pinv(self.rows)
        z, phi = np.concatenate([inverse @ p, inverse @ v, [1.0, 0.0, 1.0]]), np.eye(2 * n + 3)
        regions = tuple(int(np.searchsorted(corners, value)) for corners, value in zip(self.corners, p))
        speed = v[self.rubbing]
        modes = tuple(int(np.sign(value)) if abs(value) > 1e-9 * np.abs(v).max() else 0 for value in speed)
        modes = self.decide(z, regions, modes, [place for place, mode in enumerate(modes) if mode == 0])
        # A tangent with a velocity of what sticks stops at once.
        held = self.rows[[joint for joint, mode in zip(self.rubbing, modes) if mode == 0]]
        impulse = self.inverse @ held.T @ np.linalg.solve(held @ self.inverse @ held.T, held)
        phi[n:2 * n, n:2 * n] -= impulse
        displacement, rates = (np.empty((samples + 1, len(self.rows))) for _ in range(2))
        rubbed, stuck = np.zeros(len(self.joints)), False
        for k in range(samples + 1):
            displacement[k], rates[k] = (self.rows @ z[:n] - self.middle) / self.unit, self.rows @ z[n:2 * n]
            left, known = self.step if k < samples else 0.0, None
            while left > 0:
                stuck |= 0 in modes
                first = self.first_event(z, left, regions, modes, known)
                a, _, whole = self.matrix(regions, modes)
                at = left if first is None else first[0]
                here = whole if at == self.step else expm(a * at)
                for joint, mode in zip(self.rubbing, modes):
                    rubbed[joint] += mode * self.limit[joint] * (self.rows[joint] @ (here @ z - z)[:n])
                z, phi, left = here @ z, here @ phi, left - at
                if first is None:
                    break
                _, row, (kind, place, side) = first
                old = a
                if kind == "wall":
                    regions = tuple(region + side if joint == place else region for joint, region in enumerate(regions))
                    known = ("wall", place, -side)
                    continue
                if kind == "limit":
                    modes = tuple(side if i == place else mode for i, mode in enumerate(modes))
                else:
                    modes = self.decide(z, regions, modes, [i for i, mode in enumerate(modes) if mode == 0 or i == place])
                known = ("still", place, modes[place])
                new = self.matrix(regions, modes)[0]
                phi = phi + np.outer((new - old) @ z, row @ phi) / (row @ old @ z)
                held = self.rows[[joint for joint, mode in zip(self.rubbing, modes) if mode == 0]]
                z[n:2 * n] -= np.linalg.pinv(held) @ held @ z[n:2 * n]  # rounding
        tree = []
        for place in range(len(self.rows)):
            if np.linalg.matrix_rank(self.rows[[*tree, place]]) > len(tree):
                tree.append(place)
        out = self.rows[tree] / self.unit[tree, None]
        into = np.linalg.pinv(out)
        still = np.zeros_like(into)
        end = phi[:2 * n, :2 * n] @ np.block([[into, still], [still, into * RATE]])
        change = np.block([[out @ end[:n]], [out @ end[n:] / RATE]])
        damping = np.array([joint.damping for joint in self.joints])
        loss = rubbed + damping * (rates[:-1] ** 2).mean(axis=0) * self.step * samples
        return displacement, loss[len(self.train.meshes):] / motion.period, np.linalg.eigvals(change), stuck


def distance(t, row, a, z):
    """A function of z after a time."""
    return row @ expm(a * t) @ z


def random_train(seed):
    """A tree of gear pairs and couplings with friction as the dice fall."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 6))
    names = [f"b{place}" for place in range(count)]
    bodies = [gt.Body(name=names[0], inertia=0.03, torque=float(rng.uniform(15, 40)), torque_cos=[float(rng.uniform(10, 40))]),
              *(gt.Body(name=name, inertia=float(rng.uniform(0.004, 0.02)), balances=name == names[-1]) for name in names[1:])]
    meshes, couplings = [], []
    for place in range(1, count):
        ends = (names[int(rng.integers(max(0, place - 2), place))], names[place])
        if place > 1 and rng.uniform() < 0.4:
            meshes.append(gt.Mesh(between=ends, driving_radius=0.03, driven_radius=float(rng.uniform(0.03, 0.06)),
                                  stiffness=float(rng.uniform(0.5e7, 2e7)), damping=float(rng.uniform(500, 1500)),
                                  half_backlash=20e-6))
        else:
            friction = float(rng.uniform(0.5, 5.0)) if place == 1 or rng.uniform() < 0.7 else 0.0
            couplings.append(replace(random_coupling(rng, ends, False), friction_torque=friction))
    return gt.Train(characteristic_length=LENGTH, characteristic_frequency=RATE, bodies=bodies, meshes=meshes, couplings=couplings)
