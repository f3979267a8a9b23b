"""Bearings: lines of action by tangents of base circles, modal superposition, rigid limits, images, and SciPy's own equations."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq

import geartrain as gt

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


# Lines of action


def tangent(driving, driven, radii, sense, internal):
    """Direction in which the driving gear pushes: along the common tangent of the base circles, away from where it unwinds.

    The flank of an external gear pushes outwards from the point at which the tangent touches its base circle. Of the two tangents
    the one counts whose force resists the driving gear: the arm of the force and its direction are a right angle in the sense of
    rotation.
    """
    driving, driven = np.asarray(driving), np.asarray(driven)
    apart = driven - driving
    distance = np.hypot(*apart)
    # The arm m, a unit vector from either axis: m . apart = r_a + r_b of an inner tangent, r_a - r_b of an outer one.
    base = radii[0] - radii[1] if internal else radii[0] + radii[1]
    for turn in (1, -1):
        angle = np.arctan2(apart[1], apart[0]) + turn * np.arccos(base / distance)
        arm = np.array([np.cos(angle), np.sin(angle)])
        begin, end = driving + radii[0] * arm, driven + (radii[1] if internal else -radii[1]) * arm
        line = end - begin
        if internal:  # outwards from the pinion: driven towards its own contact, or pushed by the ring against it
            line = -line
        line /= np.hypot(*line)
        if np.sign(arm[0] * line[1] - arm[1] * line[0]) == sense:
            return line
    raise AssertionError


@pytest.mark.parametrize("speed_of", ["pinion", "wheel"])
@pytest.mark.parametrize("internal, radii", [(False, (0.05, 0.1)), (True, (0.03, 0.1)), (True, (0.1, 0.03))])
@pytest.mark.parametrize("angle", [0.0, 40.0, 90.0, 200.0, 305.0])
def test_lines_of_action(angle, internal, radii, speed_of):
    distance = (abs(radii[1] - radii[0]) if internal else sum(radii)) / np.cos(np.radians(21.0))
    places = [[0.02, -0.03], [0.02 + distance * np.cos(np.radians(angle)), -0.03 + distance * np.sin(np.radians(angle))]]
    train = pair(driving_radius=radii[0], driven_radius=radii[1], internal=internal, places=places, speed_of=speed_of)
    sense = 1 if speed_of == "pinion" or internal else -1  # the body of speed_of turns from x to y
    line = tangent(*places, radii, sense, internal)
    found = np.radians(train.explain()["mesh 1"]["line_of_action"])
    assert np.hypot(np.cos(found) - line[0], np.sin(found) - line[1]) < 1e-14 / np.tan(np.radians(21.0))
    # The mesh pushes the bearings against one another along this line.
    force = 90.0 / radii[0] * line
    assert train.explain()["bearing 1"]["mean_force"] == pytest.approx(-force, rel=1e-13, abs=1e-9)
    assert train.explain()["bearing 2"]["mean_force"] == pytest.approx(force, rel=1e-13, abs=1e-9)


def test_drawing():
    """The distance by the drawing gives the working pressure angle."""
    drawn = {"teeth": [20, 40], "normal_module": 3e-3, "pressure_angle": 20.0, "face_width": 0.02, "driving_radius": None,
             "driven_radius": None}
    train = pair(**drawn, places=([0.0, 0.0], [0.09, 0.0]))
    assert train.explain()["mesh 1"]["line_of_action"] == pytest.approx(90.0 - 20.0, abs=1e-12)
    with pytest.raises(gt.InputError, match=r"axes 0\.091 m apart by their positions, 0\.09 m by the drawing"):
        pair(**drawn, places=([0.0, 0.0], [0.091, 0.0]))


# Linear trains


def matrices(train, angle):
    """Mass and stiffness of a pair in absolute coordinates: two rotations, x and y of the pinion, x and y of the wheel."""
    mesh, (one, other) = train.meshes[0], train.bearings
    along = np.array([np.cos(angle), np.sin(angle)])
    row = np.concatenate([[mesh.driving_radius, -mesh.driven_radius], along, -along])
    mass = np.diag([body.inertia for body in train.bodies] + [one.mass] * 2 + [other.mass] * 2)
    stiffness = mesh.stiffness * np.outer(row, row) + np.diag([0.0, 0.0, *one.stiffness, *other.stiffness])
    return mass, stiffness, row


def test_modal_superposition():
    """Damping in proportion to stiffness: every mode is an oscillator of its own. A mesh without backlash, errors of two orders."""
    share = 4e-6  # s
    soft = {"stiffness": np.array([2e7, 1.2e7])}, {"stiffness": np.array([3e7, 2e7])}
    train = pair(line_of_action=65.0, damping=share * 2.5e8, error_cos=[4e-6, 1e-6], error_sin=[0.0, 2e-6],
                 **{name: {**given, "damping": share * given["stiffness"]} for name, given in zip(("pinion", "wheel"), soft)})
    mass, stiffness, row = matrices(train, np.radians(65.0))
    square, shape = eigh(stiffness, mass)
    square[0] = 0.0  # the pair turns as one
    omega = np.sqrt(square)
    assert train.natural_frequencies() == pytest.approx(omega[1:] / RATE, rel=1e-11)
    branch = train.response(start=0.4, stop=1.9, stability=False)
    k = train.meshes[0].stiffness
    for point in range(0, len(branch.frequency), max(1, len(branch.frequency) // 20)):
        amplitude, force = [], []
        for order, error in ((1, 4e-6), (2, 1e-6 - 2e-6j)):
            rate = order * branch.frequency[point] * RATE
            modal = -(shape.T @ row) * k * (1 + 1j * rate * share) * error / (square - rate**2 + 1j * rate * share * square)
            q = shape @ modal
            amplitude.append([row @ q + error, *q[2:]])
            force.append((1 + 1j * rate * share) * np.diag(stiffness - k * np.outer(row, row))[2:] * q[2:])
        wanted = np.sqrt(np.sum(np.abs(amplitude) ** 2, axis=0)) / LENGTH
        assert branch.rms[point] == pytest.approx(wanted, rel=1e-12)
        wanted = np.sqrt(np.sum(np.abs(force) ** 2, axis=0) / 2).reshape(2, 2)
        assert branch.bearing_force_rms[point] == pytest.approx(wanted, rel=1e-11)


def test_modes():
    """Natural frequencies, shapes and damping of a pair, by its matrices."""
    train = pair()
    angle = np.radians(train.explain()["mesh 1"]["line_of_action"])
    mass, stiffness, row = matrices(train, angle)
    square, shape = eigh(stiffness, mass)
    modes = train.modes()
    assert modes.natural_frequency == pytest.approx(np.sqrt(square[1:]) / RATE, rel=1e-11)
    assert list(modes.element) == ["mesh 1", "bearing 1 x", "bearing 1 y", "bearing 2 x", "bearing 2 y"]
    for mode in range(5):
        q = shape[:, mode + 1]
        elements = np.array([row @ q, *q[2:]])
        largest = elements[np.abs(elements).argmax()]
        assert modes.shape[mode] == pytest.approx(elements / largest, abs=1e-9)
        assert modes.rotation[mode] == pytest.approx(q[:2] / np.abs(q[:2]).max() * np.sign(largest), abs=1e-9)


# Limits and images


@pytest.mark.full
def test_rigid_bearings():
    """Bearings of 1e14 N/m leave the torsional train: a force moves them by 1e-6 of the deflection of the mesh."""
    stiff = {"stiffness": [1e14, 1e14], "damping": [1e3, 1e3]}
    given = {"half_backlash": 2e-5, "stiffness_cos": [0.3], "damping": 2000.0}
    train = pair(pinion=stiff, wheel=stiff, **given)
    plain = replace(train, bearings=[])
    frequencies = train.natural_frequencies()
    assert frequencies[0] == pytest.approx(plain.natural_frequencies()[0], rel=5e-6)
    assert frequencies[1] > 100 * frequencies[0]
    point = plain.natural_frequencies()[0] * 0.9
    settings = {"harmonics": 12, "stability": False}
    found = train.response(start=point, stop=point * 1.001, **settings)
    wanted = plain.response(start=point, stop=point * 1.001, **settings)
    assert wanted.separation_fraction[0, 0] > 0
    assert found.rms[0, 0] == pytest.approx(wanted.rms[0, 0], rel=2e-5)
    assert np.abs(found.rms[0, 1:]).max() < 1e-5 * wanted.rms[0, 0]


CLEARANCE = {"half_backlash": 2e-5, "stiffness_cos": [0.2], "stiffness_sin": [0.05], "pinion": {"half_clearance": 8e-6}}


def forces(motion):
    return np.stack([motion.bearing_force_mean, motion.bearing_force_rms, motion.bearing_force_minimum,
                     motion.bearing_force_maximum])


def test_quarter_turn():
    """A plane turned by a right angle: x becomes y, y becomes -x."""
    original = pair(**CLEARANCE)
    swapped = {name: {"stiffness": list(reversed(values)), "damping": list(reversed(damping))}
               for name, values, damping in (("pinion", [2.0e8, 1.5e8], [500.0, 600.0]), ("wheel", [3.0e8, 2.5e8], [800.0, 900.0]))}
    swapped["pinion"]["half_clearance"] = 8e-6
    image = pair(**{**CLEARANCE, **swapped}, places=([0.0, 0.0], [-0.095, 0.13]))
    one, other = (train.response(start=0.7, stop=0.7001, harmonics=10).at(0.7)[0] for train in (original, image))
    assert other.rms[[0, 2, 1, 4, 3]] == pytest.approx(one.rms, rel=1e-12)
    mean, rms, low, high = forces(one)
    wanted = np.stack([np.stack([-mean[:, 1], mean[:, 0]], 1), rms[:, ::-1], np.stack([-high[:, 1], low[:, 0]], 1),
                       np.stack([-low[:, 1], high[:, 0]], 1)])
    assert forces(other) == pytest.approx(wanted, rel=1e-11)


def test_mirror_image():
    """In a mirror the pinion turns the other way, hence the wheel from x to y: y changes its sign."""
    original = pair(**CLEARANCE, speed_of="pinion")
    image = pair(**CLEARANCE, speed_of="wheel", places=([0.0, 0.0], [0.13, -0.095]))
    one, other = (train.response(start=0.7, stop=0.7001, harmonics=10).at(0.7)[0] for train in (original, image))
    assert other.rms == pytest.approx(one.rms, rel=1e-12)
    mean, rms, low, high = forces(one)
    wanted = np.stack([mean * [1, -1], rms, np.stack([low[:, 0], -high[:, 1]], 1), np.stack([high[:, 0], -low[:, 1]], 1)])
    assert forces(other) == pytest.approx(wanted, rel=1e-11)


@pytest.mark.parametrize("angle", [17.0, 123.0])
def test_turned_plane(angle):
    """Equal stiffness in x and y, no clearance: any turn of the plane changes nothing but the directions of the forces."""
    round_bearings = {name: {"stiffness": [k, k], "damping": [500.0, 500.0]} for name, k in (("pinion", 2e8), ("wheel", 3e8))}
    gap = {"half_backlash": 2e-5, "stiffness_cos": [0.2], **round_bearings}
    one = pair(**gap, line_of_action=30.0).response(start=0.7, stop=0.7001, harmonics=10).at(0.7)[0]
    other = pair(**gap, line_of_action=30.0 + angle).response(start=0.7, stop=0.7001, harmonics=10).at(0.7)[0]
    assert other.rms[0] == pytest.approx(one.rms[0], rel=1e-12)
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[cosine, sine], [-sine, cosine]])
    assert other.bearing_force_mean == pytest.approx(one.bearing_force_mean @ turn, rel=1e-12)


def test_play_under_load():
    """At rest the body bears on a flat in x and a flat in y: along the mean force it has come further than in a circle."""
    train = pair(pinion={"half_clearance": 8e-6})
    told = train.explain()["bearing 1"]
    force, stiffness = told["mean_force"], np.array(train.bearings[0].stiffness)
    along = force / np.hypot(*force)
    rest = train.integrate(frequency=0.5).mean[1:3] * LENGTH
    elastic = along @ (force / stiffness)
    assert rest @ along - elastic == pytest.approx(told["loaded_clearance"], rel=1e-8)
    assert 8e-6 < told["loaded_clearance"] < 8e-6 * np.sqrt(2)
    assert "loaded_clearance" not in train.explain()["bearing 2"]


def test_no_more_unknowns():
    """A bearing elsewhere leaves the other bodies two coordinates fewer; without a bearing a train is as before."""
    train = pair(**CLEARANCE)
    assert len(train.integrate(frequency=0.9).state) == 2 * (1 + 4)
    assert len(replace(train, bearings=train.bearings[:1]).integrate(frequency=0.9).state) == 2 * (1 + 2)
    assert len(replace(train, bearings=[]).integrate(frequency=0.9).state) == 2
    assert not hasattr(replace(train, bearings=[]).response(start=0.9, stop=0.91), "bearing_force_mean")


# Other equations


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


@pytest.mark.full
def test_scipy():
    """Teeth that separate, in bearings with clearance that bear on both sides: by shooting, and by equations of their own."""
    train = pair(half_backlash=2e-5, stiffness_cos=[0.25], error_cos=[3e-6], pinion={"half_clearance": 8e-6},
                 wheel={"half_clearance": 3e-6})
    apart = 0.0
    for frequency in (0.55, 0.75):
        motion = train.integrate(frequency=frequency).refine()
        assert motion.stable
        apart = max(apart, motion.separation_fraction.max())
        compare(train, motion)
    assert apart > 0.02


ROUND = {"stiffness": [2e8, 2e8], "damping": [600.0, 600.0], "half_clearance": 8e-6}


@pytest.mark.full
def test_flats():
    """Twelve and eight flats: six springs round the pinion, four round the wheel, by shooting and by equations of their own."""
    train = pair(half_backlash=2e-5, stiffness_cos=[0.25], pinion={**ROUND, "flats": 12}, wheel={**ROUND, "flats": 8})
    assert train.mesh_elements[5:] == ("bearing 1 30", "bearing 1 60", "bearing 1 120", "bearing 1 150", "bearing 2 45",
                                       "bearing 2 135")
    assert train.mesh_labels[5:7] == ("pinion bearing 30", "pinion bearing 60")
    motion = train.integrate(frequency=0.6).refine()
    compare(train, motion)
    force = motion.bearing_force
    assert force.mean(0) == pytest.approx(motion.bearing_force_mean, rel=1e-4, abs=1.0)
    assert len(motion.state) == 2 * (1 + 4)


@pytest.mark.parametrize("flats", [8, 12, 16, 24])
def test_round_clearance(flats):
    """At rest in a ring of springs without number, F = 2 k/pi (r a - c sin a) with cos(a) = c/r, from which flats are off.

    The springs are a trapezoidal rule in the angle, of a function with a kink: the error falls with the square of their number.
    """
    clearance, stiffness = 8e-6, 2e8
    train = pair(pinion={**ROUND, "flats": flats})
    told = train.explain()["bearing 1"]
    assert told["corner_clearance"] == pytest.approx(clearance / np.cos(np.pi / flats), rel=1e-12)
    force = np.hypot(*told["mean_force"])
    assert told["mean_force"] == pytest.approx(pair().explain()["bearing 1"]["mean_force"], rel=1e-9)

    def ring(r):
        angle = np.arccos(clearance / r)
        return 2 * stiffness / np.pi * (r * angle - clearance * np.sin(angle)) - force

    wanted = brentq(ring, clearance, 10 * clearance + force / stiffness)
    rest = train.integrate(frequency=0.5).mean[1:3] * LENGTH
    assert np.hypot(*rest) == pytest.approx(wanted, rel=2.0 / flats**2)
    assert rest / np.hypot(*rest) == pytest.approx(told["mean_force"] / force, abs=4.0 / flats**2)


def test_parameters_of_flats():
    """The clearance moves all springs of a ring; a stiffness is that of both directions, and no parameter of its own."""
    def moved(**given):
        train = pair(stiffness_cos=[0.25], pinion={**ROUND, "flats": 12, **given})
        return train.response(start=0.6, stop=0.601, harmonics=12).at(0.6)[0]

    motion, change = moved(), 1e-9
    found = motion.gradient("mean", ["bearing 1 half_clearance", "bearing 1 mass"])
    wanted = (moved(half_clearance=8e-6 + change).mean - moved(half_clearance=8e-6 - change).mean) / (2 * change)
    assert np.abs(wanted[1:3]).min() > 0.3 / LENGTH
    assert found[:, 0] == pytest.approx(wanted, rel=1e-4, abs=1e-4 / LENGTH)
    with pytest.raises(gt.InputError, match="with more than four flats it is the same in x and y"):
        motion.gradient("mean", ["bearing 1 stiffness 1"])


def test_turned_flats():
    """A plane turned by the angle between two flats changes nothing but the directions of the forces."""
    given = {"half_backlash": 2e-5, "stiffness_cos": [0.2]}
    supports = {"pinion": {**ROUND, "flats": 8}, "wheel": {**ROUND, "half_clearance": 0.0}}
    one, other = (pair(**given, **supports, line_of_action=line).response(start=0.7, stop=0.7001, harmonics=10).at(0.7)[0]
                  for line in (30.0, 75.0))
    assert other.rms[0] == pytest.approx(one.rms[0], rel=1e-9)
    turn = np.sqrt(0.5) * np.array([[1.0, 1.0], [-1.0, 1.0]])
    assert other.bearing_force_mean == pytest.approx(one.bearing_force_mean @ turn, rel=1e-9)


@pytest.mark.full
def test_balance():
    """Harmonic balance against shooting, with the forces of the bearings."""
    train = pair(half_backlash=2e-5, stiffness_cos=[0.25], pinion={"half_clearance": 8e-6})
    branch = train.response(start=0.4, stop=0.9, harmonics=0, tolerance=1e-5)
    for point in branch.at(0.6):
        exact = point.refine()
        assert point.rms == pytest.approx(exact.rms, rel=1e-4)
        largest = np.abs(exact.bearing_force_maximum).max()
        assert forces(point) == pytest.approx(forces(exact), abs=2e-4 * largest)
    time = branch.at(0.6)[0].bearing_force
    assert time.shape[1:] == (2, 2)
    assert time.mean(0) == pytest.approx(branch.at(0.6)[0].bearing_force_mean, rel=1e-3, abs=1.0)


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


@pytest.mark.full
def test_random_trains(times):
    compared = 0
    for seed in range(times(30)):
        train = random_train(seed)
        motion = train.integrate(frequency=float(np.random.default_rng(seed).uniform(0.3, 0.9)))
        if motion.period != 1 or motion.floating:
            continue
        compare(train, motion.refine())
        compared += 1
    assert compared > times(30) // 2


# Results and input


def test_fields(tmp_path):
    """Forces of bearings in the file, in both libraries' arrays, in Datasets; a run-up has them along time."""
    train = pair(**CLEARANCE)
    case = tmp_path / "case.nml"
    case.write_text(train.namelist(response={"start": 0.6, "stop": 0.65}, integration={"start": 0.6, "stop": 0.6, "points": 1},
                                   run_up={"start": 0.5, "stop": 0.55, "duration": 0.05}))
    results = gt.read_case(case).run()
    branch, motion = results.response, results.integration[0]
    assert branch.bearing_force_mean.shape == (len(branch.frequency), 2, 2)
    assert motion.bearing_force_rms.shape == (2, 2)
    assert dict(branch.to_dataset().bearing_force_maximum.sizes) == {"point": len(branch.frequency), "bearing": 2, "axis": 2}
    path = tmp_path / "case.h5"
    results.write(path)
    again = gt.read_results(path)
    assert (again.response.bearing_force_rms == branch.bearing_force_rms).all()
    assert (again.integration[0].bearing_force_minimum == motion.bearing_force_minimum).all()
    assert results.run_up.bearing_force.shape == (len(results.run_up.time), 2, 2)
    assert train.mesh_labels[1:] == ("pinion bearing x", "pinion bearing y", "wheel bearing x", "wheel bearing y")
    assert "bearing 1" in str(results)


@pytest.mark.full
def test_parameters():
    """A number of a bearing is a parameter as any other: derivatives by differences, a branch over it."""
    train = pair(**CLEARANCE)
    motion = train.response(start=0.6, stop=0.601, harmonics=16).at(0.6)[0]
    names = ["bearing 1 stiffness 1", "bearing 2 mass", "bearing 1 half_clearance", "bearing 2 damping 2"]
    found = motion.gradient("rms", names)
    gradient = train.frequency_gradient(names[:2])
    for place, name in enumerate(names):
        number, variable = int(name.split()[1]) - 1, name.split()[2]
        value = getattr(train.bearings[number], variable)
        sides = []
        for sign in (1, -1):
            new = np.array(value, float)
            item = int(name.split()[3]) - 1 if name.count(" ") == 3 else ...
            change = 1e-4 * np.array(new)[item]
            new[item] += sign * change
            bearings = list(train.bearings)
            bearings[number] = replace(bearings[number], **{variable: new.tolist()})
            side = replace(train, bearings=bearings)
            sides.append((side.response(start=0.6, stop=0.601, harmonics=16).at(0.6)[0].rms, side.natural_frequencies()))
        wanted = (sides[0][0] - sides[1][0]) / (2 * change)
        # The pinion keeps to one side of its clearance, which then only moves it: the derivative is rounding.
        rounding = 1e-9 * np.abs(sides[0][0]).max() / (change * 1e4)
        assert found[:, place] == pytest.approx(wanted, rel=1e-4, abs=1e-5 * np.abs(wanted).max() + rounding)
        if place < 2:
            assert gradient[:, place] == pytest.approx((sides[0][1] - sides[1][1]) / (2 * change), rel=1e-5, abs=1e-20)
    branch = train.continuation(parameter="bearing 1 half_clearance", start=8e-6, stop=4e-6, frequency=0.6)
    assert branch.complete


WRONG = {
    "unknown body": (lambda train: {"bearings": [replace(train.bearings[0], body="pinnion")]},
                     r"body = 'pinnion': is the name of no &body \(did you mean 'pinion'\?\)"),
    "twice": (lambda train: {"bearings": [train.bearings[0], train.bearings[0]]}, "is on &bearing 1 already"),
    "no mass": (lambda train: {"bearings": [replace(train.bearings[0], mass=None)]}, "&bearing 1: lacks mass"),
    "no stiffness": (lambda train: {"bearings": [replace(train.bearings[0], stiffness=None)]}, "&bearing 1: lacks stiffness"),
    "one stiffness": (lambda train: {"bearings": [replace(train.bearings[0], stiffness=[1e8])]}, r"stiffness = .*2"),
    "no position": (lambda train: {"bodies": [replace(body, position=None) for body in train.bodies]},
                    "&mesh 1: lacks line_of_action .* or position of 'pinion' and 'wheel'"),
    "one position": (lambda train: {"bodies": [train.bodies[0], replace(train.bodies[1], position=[0.15])]}, "position = .*2"),
    "too near": (lambda train: {"bodies": [train.bodies[0], replace(train.bodies[1], position=[0.14, 0.0])]}, "are too near"),
    "too far": (lambda train: {"bodies": [train.bodies[0], replace(train.bodies[1], position=[150.0, 60.0])]}, "are too far apart"),
    "back flanks": (lambda train: {"bodies": [replace(train.bodies[0], torque=-90.0), train.bodies[1]]},
                    "bears the mean load on its back flanks, .* name the body that drives first"),
    "no bearing": (lambda train: {"bearings": [], "meshes": [replace(train.meshes[0], line_of_action=20.0)]},
                   "line_of_action = 20.0: has no effect"),
    "number of flats": (lambda train: {"bearings": [replace(train.bearings[0], flats=10)]},
                        "flats = 10: must be 4, 8, 12, 16 or 24"),
    "no clearance": (lambda train: {"bearings": [replace(train.bearings[0], flats=8, stiffness=[1e8, 1e8], damping=None)]},
                     "flats = 8: has no effect without half_clearance"),
    "unequal stiffness": (lambda train: {"bearings": [replace(train.bearings[0], flats=8, half_clearance=1e-6)]},
                          "flats = 8: needs equal stiffness, and equal damping, in the directions x and y"),
    "held": (lambda train: {"bodies": [replace(train.bodies[0], stiffness_to_ground=1e5),
                                       replace(train.bodies[1], held=True, balances=None, inertia=None)]}, "'wheel': is held"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_bad_input(wrong):
    change, message = WRONG[wrong]
    with pytest.raises(gt.InputError, match=message):
        train = pair()
        replace(train, **change(train))


def test_carrier():
    """A mesh that is carried round has no line of action that stands still."""
    bodies = [gt.Body(name="sun", inertia=1e-3, torque=10.0), gt.Body(name="planet", inertia=1e-3), gt.Body(name="ring", held=True),
              gt.Body(name="arm", inertia=1e-2, balances=True)]
    meshes = [gt.Mesh(between=("sun", "planet"), carrier="arm", driving_radius=0.02, driven_radius=0.02, stiffness=1e8),
              gt.Mesh(between=("planet", "ring"), carrier="arm", internal=True, driving_radius=0.02, driven_radius=0.06,
                      stiffness=1e8)]
    for body in ("sun", "planet", "arm"):
        with pytest.raises(gt.InputError, match=re.escape("carries the line of action round with it") + "|is the carrier|is on no"):
            gt.Train(characteristic_length=LENGTH, characteristic_frequency=RATE, bodies=bodies, meshes=meshes,
                     bearings=[gt.Bearing(body=body, mass=1.0, stiffness=[1e8, 1e8])])
