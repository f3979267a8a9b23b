"""Run-ups: against SciPy, the same from the executable and from Python, drawn, stopped and gone on with."""

import pickle
import subprocess

import h5py
import matplotlib as mpl
import numpy as np
import pytest
import xarray
from conftest import assert_equal_files, run
from scipy.integrate import solve_ivp

import geartrain as gt
from case_studies import CASES

mpl.use("Agg")

RAMP = {"start": 0.4, "stop": 1.2, "duration": 0.2}


@pytest.fixture(scope="module")
def ramp(train):
    return train.run_up(**RAMP)


def test_shapes(train, ramp):
    samples, windows = len(ramp.time), len(ramp.window_time)
    assert ramp.complete and ramp.start_period == 1 and ramp.ended == "reached Lambda = 1.2"
    assert ramp.displacement.shape == ramp.mesh_force.shape == (samples, 2)
    assert ramp.shaft_torque.shape == (samples, 3)
    assert ramp.mesh_force_minimum.shape == ramp.mesh_force_maximum.shape == (windows, 2)
    assert ramp.shaft_torque_minimum.shape == ramp.shaft_torque_maximum.shape == (windows, 3)
    assert ramp.mesh_label == ("mesh 1", "mesh 2") and ramp.shaft_label == ("shaft 1", "shaft 2", "shaft 3")
    np.testing.assert_allclose(ramp.time, np.linspace(0, 0.2, samples), rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(ramp.frequency, np.linspace(0.4, 1.2, samples), rtol=1e-12)
    np.testing.assert_allclose(ramp.fundamental_frequency, ramp.frequency * train.characteristic_frequency / (2 * np.pi))
    assert windows == np.ceil(0.2 * 0.8 * train.characteristic_frequency / (2 * np.pi))
    assert "reached" in repr(ramp) and pickle.loads(pickle.dumps(ramp)).ended == ramp.ended


def test_extremes_hold_the_samples(ramp):
    turn = np.floor(ramp.time * (ramp.fundamental_frequency[0] + ramp.fundamental_frequency) / 2).astype(int)
    inside = np.minimum(turn, len(ramp.window_time) - 1)
    scale = 1e-9 * ramp.mesh_force.max()
    assert (ramp.mesh_force <= ramp.mesh_force_maximum[inside] + scale).all()
    assert (ramp.mesh_force >= ramp.mesh_force_minimum[inside] - scale).all()


@pytest.mark.parametrize("teeth", [(None, None), ([20, 40], [80, 160])])
def test_against_scipy(train, teeth):
    """Figure 3's train with transmission errors, up and down: angles of the six bodies by DOP853, a
    piece from contact event to contact event. With teeth the bodies turn and accelerate, and the load takes what remains."""
    meshes = [gt.Mesh(**{**{name: getattr(mesh, name) for name in mesh.variables if getattr(mesh, name) is not None},
                         "error_cos": [0.0, 1e-6], "error_sin": [2e-6], "order": order, **({"teeth": pair} if pair else {})})
              for mesh, order, pair in zip(train.meshes, (1, 2), teeth)]
    varied = gt.Train(**{name: getattr(train, name) for name in ("input_torque", "prime_mover_inertia", "load_inertia",
                                                               "characteristic_length", "characteristic_frequency")},
                      shafts=train.shafts, meshes=meshes)
    for start, stop in ((0.8, 1.3), (1.3, 0.8)):
        begin = varied.integrate(0.8).state.copy()
        begin[[6, 8]] += 0.7  # so that teeth separate soon
        duration = 4 * 2 * np.pi / (1.05 * train.characteristic_frequency)
        found = varied.run_up(start=start, stop=stop, duration=duration, samples=64, seed=begin, max_periods=0)
        exact = by_scipy(varied, start, stop, found.time, begin)
        separated = np.abs(exact["displacement"]) < 1
        assert separated.any() and not separated.all()
        np.testing.assert_allclose(found.displacement, exact["displacement"], atol=1e-8)
        np.testing.assert_allclose(found.mesh_force, exact["force"], atol=1e-7 * exact["force"].max())
        np.testing.assert_allclose(found.shaft_torque, exact["torque"], atol=1e-7 * exact["torque"].max())


def by_scipy(train, start, stop, time, state):
    """Displacements, forces and torques of a chain of two meshes, from the equations of motion of its six bodies."""
    first, second = train.meshes
    inertia = np.array([train.prime_mover_inertia, first.driving_inertia, first.driven_inertia, second.driving_inertia,
                        second.driven_inertia, train.load_inertia])
    # Twists of shafts and displacements of meshes by turns, as rows of radii.
    rows = np.zeros((5, 6))
    radii = [(1, 1), (first.driving_radius, first.driven_radius), (1, 1), (second.driving_radius, second.driven_radius), (1, 1)]
    for place, (a, b) in enumerate(radii):
        rows[place, place:place + 2] = a, -b
    stiffness = np.array([train.shafts[0].stiffness, first.stiffness, train.shafts[1].stiffness, second.stiffness,
                          train.shafts[2].stiffness])
    ratio = np.array([shaft.damping_ratio for shaft in train.shafts])
    ratio = np.array([ratio[0], first.damping_ratio, ratio[1], second.damping_ratio, ratio[2]])
    damping = 2 * ratio * np.sqrt(stiffness / (rows**2 / inertia).sum(axis=1))
    torque = np.zeros(6)
    torque[0] = train.input_torque
    torque[-1] = -train.input_torque * first.driven_radius / first.driving_radius * second.driven_radius / second.driving_radius
    static = np.zeros(5)
    static[0] = train.input_torque
    static[1] = static[0] / first.driving_radius
    static[2] = static[1] * first.driven_radius
    static[3] = static[2] / second.driving_radius
    static[4] = static[3] * second.driven_radius
    omega = start * train.characteristic_frequency
    acceleration = (stop - start) * train.characteristic_frequency / time[-1]
    half = first.half_backlash
    turns = np.zeros(6)
    if first.teeth is not None:
        turns[:] = 1 / np.array([20, 20, 40, 40, 80, 80])
        torque[-1] += acceleration * (inertia * turns**2).sum() / turns[-1]

    def phase(t):
        return omega * t + acceleration * t**2 / 2, omega + acceleration * t

    def error(mesh, t):
        angle, rate = phase(t)
        angle, rate = mesh.order * angle, mesh.order * rate
        value = sum(c * np.cos(h * angle) for h, c in enumerate(mesh.error_cos, 1)) + mesh.error_sin[0] * np.sin(angle)
        slope = mesh.error_sin[0] * np.cos(angle) - sum(h * c * np.sin(h * angle) for h, c in enumerate(mesh.error_cos, 1))
        return value, slope * rate

    def displacements(t, y):
        p, v = rows @ y[:6], rows @ y[6:]
        for place, mesh in ((1, first), (3, second)):
            value, slope = error(mesh, t)
            p[place] += value
            v[place] += slope
        return p, v

    def forces(t, y, contact):
        p, v = displacements(t, y)
        force = stiffness * p + damping * v
        for place, mesh in ((1, first), (3, second)):
            kappa = 1 + mesh.stiffness_cos[0] * np.cos(mesh.order * phase(t)[0])
            side = contact[place // 2]
            elastic = kappa * (p[place] - side * half) if side else 0.0
            force[place] = stiffness[place] * elastic + damping[place] * v[place]
        return force

    def contacts(p):
        return [int(p[place] > half) - int(p[place] < -half) for place in (1, 3)]

    # Angles and speeds that have the displacements and velocities of the state: the first body at rest at angle 0.
    p0, v0 = displacements(0.0, np.zeros(12))
    length, rate = train.characteristic_length, train.characteristic_frequency
    y = np.zeros(12)
    for place, (a, b) in enumerate(radii):
        scale = length if place % 2 else length / element_radius(place, first, second)
        moved = state[place] * scale - p0[place] + (0.0 if place % 2 else static[place] / stiffness[place])
        speed = state[5 + place] * scale * rate - v0[place]
        y[place + 1] = (a * y[place] - moved) / b
        y[6 + place + 1] = (a * y[6 + place] - speed) / b
    y[6:] += turns * omega
    table = {"displacement": np.zeros((len(time), 2)), "force": np.zeros((len(time), 2)), "torque": np.zeros((len(time), 3))}
    now, contact = 0.0, contacts(displacements(0.0, y)[0])
    while now < time[-1]:
        walls = []
        for number, place in enumerate((1, 3)):
            # The walls of the region, and the way in which they are passed.
            for wall, way in ((half, 1 if contact[number] == 0 else -1), (-half, -1 if contact[number] == 0 else 1)):
                if contact[number] * wall < 0:
                    continue

                def cross(t, y, place=place, wall=wall):
                    return displacements(t, y)[0][place] - wall
                cross.terminal, cross.direction = True, way
                walls.append((number, wall, way, cross))
        pieces = solve_ivp(
            lambda t, y: np.concatenate([y[6:], (torque - rows.T @ forces(t, y, contact)) / inertia]), (now, time[-1]), y,
            method="DOP853", rtol=1e-12, atol=1e-15, max_step=1e-5, events=[wall[-1] for wall in walls], dense_output=True,
        )
        end = pieces.t[-1]
        for place in np.flatnonzero((time >= now) & (time <= end)):
            at = pieces.sol(time[place])
            force = forces(time[place], at, contact)
            table["displacement"][place] = displacements(time[place], at)[0][[1, 3]] / length
            table["force"][place], table["torque"][place] = force[[1, 3]], force[[0, 2, 4]]
        y, now = pieces.y[:, -1], end
        if pieces.status == 1:
            number, wall, way, _ = next(wall for wall, met in zip(walls, pieces.t_events) if len(met))
            contact[number] = int(np.sign(wall)) if way * wall > 0 else 0
    return table


def element_radius(place, first, second):
    """The radius along which a shaft of the chain is measured in a state: of a driving gear on it, else of a driven gear."""
    return {0: first.driving_radius, 2: second.driving_radius, 4: second.driven_radius}[place]


def test_a_seed_is_as_a_start(train):
    motion = train.integrate(0.9)
    ramp = train.run_up(start=0.9, stop=0.9, duration=0.005, seed=motion, max_periods=0, samples=64)
    np.testing.assert_allclose(ramp.mesh_force_maximum[0], motion.mesh_force_maximum, rtol=1e-8)
    again = train.run_up(start=0.9, stop=0.9, duration=0.005, seed=list(motion.state), max_periods=0, samples=64)
    assert (again.displacement == ramp.displacement).all()
    with pytest.raises(gt.InputError, match="seed"):
        train.run_up(**RAMP, seed=[0.0])
    with pytest.raises(gt.InputError, match=r"seed = 'here': must be a gt\.Motion or"):
        train.run_up(**RAMP, seed="here")


def test_bad_input(train):
    with pytest.raises(gt.InputError, match=r"&run_up: duration = 1\.0e-5: must be >= .* s: a run-up takes one mean cycle"):
        train.run_up(start=0.4, stop=0.8, duration=1e-5)
    with pytest.raises(gt.InputError, match="unit = 'knots': must be 'Lambda', 'rpm' or 'Hz'"):
        train.run_up(**RAMP, unit="knots")
    with pytest.raises(gt.InputError, match=r"samples = 10000000: must be fewer: the run-up has .* and 100000000 at most"):
        train.run_up(**RAMP, samples=10**7)
    with pytest.raises(gt.InputError, match=r"duration = 1\.0e15: must be shorter"):
        train.run_up(start=0.4, stop=0.8, duration=1e15)
    with pytest.raises(gt.InputError, match="start"):
        train.run_up(start=1e-9, stop=0.8, duration=1.0)


def test_beyond_all_memory(train):
    code = (
        "import resource, sys, pickle\n"
        "import geartrain as gt\n"
        "train = pickle.loads(sys.stdin.buffer.read())\n"
        "resource.setrlimit(resource.RLIMIT_AS, (3 * 10**9, 3 * 10**9))\n"
        "try:\n    train.run_up(start=0.4, stop=0.8, duration=100.0, samples=500)\n"
        "except MemoryError as error:\n    print(error)\n"
    )
    import sys
    done = subprocess.run([sys.executable, "-c", code], input=pickle.dumps(train), capture_output=True, check=True, timeout=60)
    assert b"run up: no memory for 6.28" in done.stdout and b"take fewer samples or a shorter duration" in done.stdout, done


def test_case_file_executable_and_python_agree(executable, tmp_path, train, ramp):
    case = tmp_path / "run_up.nml"
    case.write_text(train.namelist(run_up=RAMP))
    assert "&run_up" in case.read_text()
    done = run(executable, case, "--output", tmp_path / "a.h5")
    assert done.returncode == 0 and "0.2 s, 252 cycles of the slowest mesh" in done.stdout, done
    read = gt.read_case(case)
    assert read.run_up["duration"] == 0.2
    results = read.run()
    assert (results.run_up.displacement == ramp.displacement).all()
    results.write(tmp_path / "b.h5")
    assert_equal_files(tmp_path / "a.h5", tmp_path / "b.h5")
    back = gt.read_results(tmp_path / "a.h5").run_up
    for name in ("time", "frequency", "mesh_force", "shaft_torque", "shaft_torque_maximum", "state"):
        np.testing.assert_array_equal(getattr(back, name), getattr(ramp, name))
    data = xarray.open_dataset(tmp_path / "a.h5", group="run_up")
    assert data.mesh_force.dims == ("time", "mesh") and data.shaft_torque_maximum.dims == ("window", "shaft")
    assert list(data.shaft_label.values) == ["shaft 1", "shaft 2", "shaft 3"] and data.frequency.dims == ("time",)
    mine = ramp.to_dataset()
    assert mine.mesh_force.dims == data.mesh_force.dims and {"frequency", "fundamental_frequency"} <= set(mine.coords)
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["run_up/shaft_torque"].attrs["units"] in ("N m", b"N m")


@pytest.mark.full
def test_terminal_tells_what_the_inertias_take(executable, tmp_path, train):
    """90 N m of the motor, less 0.02 kg m^2 times 3800 rpm in 0.3 s, at the pinion's shaft; and what is not known."""
    text = (CASES / "reducer.nml").read_text()
    case = tmp_path / "reducer.nml"
    case.write_text("\n".join(line for line in text.splitlines() if not line.startswith(("&modes", "&response", "&integration")))
                    .replace("duration = 5.0", "duration = 0.3"))
    done = run(executable, case, "--output", tmp_path / "a.h5")
    line = done.stdout.split("shaft 1 (motor - pinion 1), N m")[1].splitlines()[1]
    mean = float(line.split("mean ")[1].split(" ")[0])
    assert mean == pytest.approx(90 - 0.02 * 3800 * 2 * np.pi / 60 / 0.3, rel=5e-4)
    assert "at constant speed 90 N m (29.5 % less)" in line and "reversed" not in line
    case.write_text(case.read_text().replace("from = 200.0, to = 4000.0", "from = 4000.0, to = 200.0").replace("90.0", "-20.0"))
    done = run(executable, case, "--output", tmp_path / "b.h5")
    # From -20 to +6.5 N m: no share of the magnitude would say it.
    assert "at constant speed -20 N m, the load is reversed\n" in done.stdout, done
    case.write_text(train.namelist(run_up=RAMP))
    done = run(executable, case, "--output", tmp_path / "c.h5")
    assert "Without the acceleration of the inertias: not every mesh has teeth" in done.stdout, done


def test_hertz(train, ramp):
    hertz = train.characteristic_frequency / (2 * np.pi)
    other = train.run_up(start=0.4 * hertz, stop=1.2 * hertz, duration=0.2, unit="Hz")
    np.testing.assert_allclose(other.displacement[:2000], ramp.displacement[:2000], atol=1e-8)


@pytest.mark.parametrize("what", ["mesh_force", "shaft_torque", "displacement"])
@pytest.mark.parametrize("unit", ["Lambda", "Hz"])
def test_plots(ramp, what, unit):
    ax = ramp.plot(what, unit=unit)
    # The shafts at the ends hold their mean torque, and have panels of their own.
    panels = ax.figure.axes
    assert len(panels) == (3 if what == "shaft_torque" else 1) and unit in panels[-1].get_xlabel()
    if what != "shaft_torque":
        assert len(ax.get_legend().get_texts()) == ramp.displacement.shape[1]
    mpl.pyplot.close(ax.figure)
    ax = ramp.waterfall(what, 2, unit=unit, orders=[1, 2])
    assert unit in ax.get_xlabel() and "Hz" in ax.get_ylabel() and len(ax.lines) == 2
    mpl.pyplot.close(ax.figure)


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_a_range_is_that_of_the_slowest_excitation():
    """Order 2 of an engine, whose period has 6 windows: cycles of the mesh with order 11."""
    engine = gt.read_case(CASES / "rattle.nml").train
    ramp = engine.run_up(start=850.0, stop=1000.0, duration=2.5, unit="rpm")
    panels = ramp.plot().figure.axes  # the loose wheels carry a hundredth of the load
    speed = np.interp(ramp.window_time, ramp.time, ramp.speed)
    for column in range(3):
        outline = panels[column].collections[0].get_paths()[0].vertices
        for place, at in enumerate(speed):
            near = slice(max(0, place - 2), place + 4)
            drawn = outline[np.isclose(outline[:, 0], at, rtol=1e-12), 1]
            assert drawn.max() == ramp.mesh_force_maximum[near, column].max()
            assert drawn.min() == ramp.mesh_force_minimum[near, column].min()
    assert ramp.waterfall(highest=5000.0).get_ylim() == (0, 5000)
    _, lines, amplitude = ramp.spectra()
    seen = lines[(amplitude > 1e-3 * amplitude.max()).any(axis=0) & (lines <= lines[-1] / 4)]
    assert ramp.waterfall().get_ylim()[1] == pytest.approx(1.05 * seen.max())
    # A turn of the engine and the fundamental differ.
    lines = ramp.waterfall(orders=["2 x mesh 1", "engine"]).lines
    fundamental = np.interp(ramp.spectra()[0], ramp.time, ramp.fundamental_frequency)
    hertz = np.interp(ramp.spectra()[0], ramp.time, ramp.speed) / 60
    np.testing.assert_allclose(lines[0].get_ydata(), 2 * int(engine._outline["order"][0]) * fundamental)
    np.testing.assert_allclose(lines[1].get_ydata(), hertz)
    with pytest.raises(gt.InputError, match=r"orders: 'engin' is no order of this train \(did you mean 'engine'\?\)"):
        ramp.waterfall(orders=["engin"])


def test_what_cannot_be_drawn(ramp):
    with pytest.raises(gt.InputError, match="what = 'rms': must be"):
        ramp.plot("rms")
    with pytest.raises(gt.InputError, match="unit = 'knots': must be 'Lambda', 'rpm' or 'Hz'"):
        ramp.waterfall(unit="knots")
    with pytest.raises(gt.InputError, match="number = 3: must be 1 to 2"):
        ramp.waterfall(number=3)


def test_spectra_of_a_steady_motion_are_its_spectrum(train):
    """At constant speed the line of each order has the amplitude of the motion's force."""
    motion = train.integrate(0.9)
    ramp = train.run_up(start=0.9, stop=0.9, duration=200 * 2 * np.pi / (0.9 * train.characteristic_frequency), samples=64)
    _, frequency, amplitude = ramp.spectra("displacement", 2)
    expected = np.hypot(motion.coefficients[1, 1::2], motion.coefficients[1, 2::2])
    for order in (1, 2, 3):
        near = abs(frequency - order * ramp.fundamental_frequency[0]) < 0.3 * ramp.fundamental_frequency[0]
        assert amplitude[:, near].max() == pytest.approx(expected[order - 1], rel=0.1)


def test_spectra_follow_the_orders(train):
    """A coast-down through no jump: the strongest line is at the fundamental frequency or twice it throughout."""
    ramp = train.run_up(start=2.6, stop=2.2, duration=0.5)
    time, frequency, amplitude = ramp.spectra("displacement", 1)
    strongest = frequency[amplitude.argmax(axis=1)]
    np.testing.assert_allclose(strongest, np.interp(time, ramp.time, ramp.fundamental_frequency), rtol=0.02)


def test_no_motion_to_begin_with(train):
    """It begins with the state reached, and says so."""
    ramp = train.run_up(start=0.9, stop=0.95, duration=0.01, max_periods=2)
    assert ramp.complete and ramp.start_period == 0 and "no steady motion was found at Lambda = 0.9" in ramp.ended


@pytest.fixture
def planetary():
    """A planetary set whose ring is held: the text of its case, without analyses."""
    return (CASES / "planetary.nml").read_text("utf-8").split("&modes")[0]


def test_reaction_torques(tmp_path, planetary):
    """At nearly constant speed the windows have the extremes of the steady motion."""
    case = tmp_path / "planetary.nml"
    case.write_text(planetary + "&modes /\n")
    train = gt.read_case(case).train
    steady = train.integrate(3000.0, unit="rpm")
    ramp = train.run_up(start=3000.0, stop=3000.00001, unit="rpm", duration=0.02)
    assert ramp.held_label == ("ring",) and ramp.reaction_torque.shape == (len(ramp.time), 1)
    assert ramp.reaction_torque_maximum[1:-1] == pytest.approx(steady.reaction_torque_maximum[0], rel=1e-6)
    assert ramp.reaction_torque_minimum[1:-1] == pytest.approx(steady.reaction_torque_minimum[0], rel=1e-6)
    assert {"reaction_torque", "reaction_torque_maximum"} <= set(ramp.to_dataset().data_vars)


def test_checkpoints_before_the_first_sample(executable, tmp_path, planetary):
    """While a lightly damped train with a held body settles, its file is written without samples."""
    for old, new in (("torque = 300.0", "torque = 0.01"), ("ratio = 0.01", "ratio = 1e-4"), ("ratio = 0.05", "ratio = 1e-3")):
        assert old in planetary
        planetary = planetary.replace(old, new)
    case = tmp_path / "light.nml"
    case.write_text(planetary + "&run_up from = 3000, to = 3010, unit = 'rpm', duration = 0.02 /\n")
    said = run(executable, case.name, cwd=tmp_path)
    assert said.returncode == 0 and "without this checkpoint" not in said.stderr
