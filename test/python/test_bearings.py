"""Bearings: lines of action by tangents of base circles, modal superposition, rigid limits, images, and SciPy's own equations."""

import re
from dataclasses import replace

import numpy as np
import pytest
from bearing_model import LENGTH, RATE, compare, pair, random_train
from scipy.linalg import eigh

import geartrain as gt

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


# Other equations (bearing_model.py)


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
