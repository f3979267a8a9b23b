"""Tables of a mesh cycle and of an engine's cycle: against their own discrete transform and the words that give the same train."""

from dataclasses import replace

import numpy as np
import pytest
from measured_engine import ANGLES, BORE, PRESSURE, ROD, STROKE, gas_torque

import geartrain as gt


def engine(table, teeth=(24, 36), **values):
    """A stiff train of an engine, a gear pair and a load."""
    bodies = [gt.Body(name="engine", inertia=0.05, torque_table=table, **values), gt.Body(name="pinion", inertia=1e-3),
              gt.Body(name="wheel", inertia=8e-3), gt.Body(name="load", inertia=0.4, balances=True)]
    shafts = [gt.Shaft(between=("engine", "pinion"), stiffness=4e3, damping_ratio=0.05),
              gt.Shaft(between=("wheel", "load"), stiffness=8e3, damping_ratio=0.05)]
    mesh = gt.Mesh(between=("pinion", "wheel"), teeth=teeth, driving_radius=0.036, driven_radius=0.036 * teeth[1] / teeth[0],
                   stiffness=2e8, damping_ratio=0.05)
    return gt.Train(bodies=bodies, shafts=shafts, meshes=[mesh])


TABLE = gas_torque()


def mesh_motion(train, speed):
    """The response at a speed, with all harmonics that matter by 1e-9."""
    branch = train.response(start=speed, stop=1.0001 * speed, unit="rpm", max_points=2, harmonics=0, tolerance=1e-9)
    return branch.at(branch.frequency[0])[0]


def mobility(train, omega):
    """Displacement of the mesh per torque on the engine, by the equations of the four bodies."""
    (one, two), mesh = train.shafts, train.meshes[0]
    inertia = np.array([float(body.inertia) for body in train.bodies])
    radii = np.array([0.0, mesh.driving_radius, -mesh.driven_radius, 0.0])
    rows = np.array([[1, -1, 0, 0], radii, [0, 0, 1, -1]])
    stiffness = np.array([one.stiffness, mesh.stiffness, two.stiffness])
    mass = np.array([1 / (1 / inertia[0] + 1 / inertia[1]), 1 / (radii[1] ** 2 / inertia[1] + radii[2] ** 2 / inertia[2]),
                     1 / (1 / inertia[2] + 1 / inertia[3])])
    damping = 2 * 0.05 * np.sqrt(stiffness * mass)
    dynamic = -(omega**2) * np.diag(inertia) + rows.T @ np.diag(stiffness + 1j * omega * damping) @ rows
    return radii @ np.linalg.solve(dynamic, [1, 0, 0, 0])


def test_orders_of_an_engine_against_the_transform_of_its_table():
    """Orders 0.5 to 8 of the revolution: the motion of a linear train over its mobility is the torque of the table, to rounding."""
    train = engine(TABLE, torque_revolutions=2)
    about = train.explain()
    assert about["mesh 1"]["order"] == 48 and about["engine"]["revolution_order"] == 2
    speed = 1500.0
    motion = mesh_motion(train, speed)
    found = (motion.coefficients[0][1::2] - 1j * motion.coefficients[0][2::2]) * 1e-6
    expected = np.fft.rfft(TABLE) * 2 / len(TABLE)
    for harmonic in range(1, 17):
        torque = found[harmonic - 1] / mobility(train, harmonic / 2 * speed * 2 * np.pi / 60)
        assert torque == pytest.approx(expected[harmonic], abs=1e-12 * np.abs(expected).max())
    assert train.explain()["mesh 1"]["mean_force"] == pytest.approx(TABLE.mean() / 0.036, rel=1e-12)


def test_torque_of_a_measured_pressure():
    """The indicated work of a cycle is that of the pressure over the volume: a mean torque of 24.4 N m, 6.13 bar."""
    crank, rod = STROKE / 2, ROD
    travel = crank * (1 - np.cos(ANGLES)) + rod - np.sqrt(rod**2 - (crank * np.sin(ANGLES)) ** 2)
    volume = np.pi / 4 * BORE**2 * np.append(travel, travel[0])
    pressure = np.append(PRESSURE, PRESSURE[0]) * 1e5
    work = ((pressure[1:] + pressure[:-1]) / 2 * np.diff(volume)).sum()
    assert TABLE.mean() * 4 * np.pi == pytest.approx(work, rel=2e-3)
    assert work / np.ptp(volume) == pytest.approx(6.13e5, rel=2e-3)


def test_a_table_of_one_revolution_is_its_harmonics():
    """With an even number of values the highest harmonic is a cosine of half the usual weight."""
    table = 20.0 + np.array([3.0, -1.0, 2.0, 0.5, -2.5, 4.0, 1.0, -3.0])
    spectrum = np.fft.rfft(table) / len(table)
    cosine, sine = 2 * spectrum.real[1:], -2 * spectrum.imag[1:]
    cosine[-1] /= 2
    one = mesh_motion(engine(table, torque=5.0, revolution_torque_cos=[1.0, 2.0]), 900.0)
    cosine[:2] += [1.0, 2.0]
    other = mesh_motion(engine(None, torque=25.0 + (table - 20).mean(), revolution_torque_cos=cosine,
                               revolution_torque_sin=sine), 900.0)
    assert one.coefficients == pytest.approx(other.coefficients, abs=1e-12 * np.abs(other.coefficients).max())


def test_harmonics_of_a_revolution_beside_a_table_of_two():
    one = engine(TABLE, torque_revolutions=2, revolution_torque_cos=[0.0, 3.0])
    other = engine(TABLE + 3.0 * np.cos(2 * ANGLES), torque_revolutions=2)
    first, second = mesh_motion(one, 1100.0), mesh_motion(other, 1100.0)
    assert first.coefficients == pytest.approx(second.coefficients, abs=1e-12 * np.abs(second.coefficients).max())


@pytest.mark.parametrize("values, words", [
    ({"torque_table": [1.0, 2.0, 3.0]}, "torque_table = 3 values: must be at least 4"),
    ({"torque_table": [], "torque_revolutions": 2}, "lacks torque_table"),
    ({"torque_revolutions": 3}, "torque_revolutions = 3: must be >= 1 and <= 2"),
    ({"torque_table": [1.0, 2.0, np.inf, 1.0]}, "torque_table value 3 = inf: must be a finite number"),
])
def test_wrong_tables_of_torque_are_refused(values, words):
    with pytest.raises(gt.InputError) as caught:
        engine(**{"table": values.pop("torque_table", TABLE), **values}).natural_frequencies()
    assert words in str(caught.value)


def test_a_table_where_its_mean_is_not_free_is_refused():
    train = engine(TABLE)
    bodies = [*train.bodies[:3], replace(train.bodies[3], torque_table=[1.0, 2.0, 3.0, 4.0])]
    with pytest.raises(gt.InputError, match=r"torque_table = with a mean of 2.5 N m: contradicts balances"):
        replace(train, bodies=bodies)
    bodies[3] = replace(bodies[3], torque_table=[-1.5, -0.5, 0.5, 1.5])
    assert replace(train, bodies=bodies).explain()["load"]["revolution_order"] == 2
    with pytest.raises(gt.InputError, match=r"torque_table = \.\.\.: must be left out unless every mesh has teeth"):
        replace(train, meshes=[replace(train.meshes[0], teeth=None)], characteristic_length=1e-6, characteristic_frequency=1.0)


def test_a_table_of_the_transmission_error_is_its_harmonics():
    table = 1e-6 * np.array([2.0, 3.0, -1.0, 0.5, 1.0])
    spectrum = np.fft.rfft(table) * 2 / len(table)
    train = engine(None, torque=50.0)
    mesh = train.meshes[0]
    one = replace(train, meshes=[replace(mesh, error_table=table, phase=0.3, stiffness_cos=[0.1])])
    about = one.explain()["mesh 1"]
    expected = spectrum[1:] * np.exp(-0.3j * np.arange(1, 3))
    assert about["error_cos"] - 1j * about["error_sin"] == pytest.approx(expected, abs=1e-20)
    assert about["error_mean"] == pytest.approx(table.mean(), rel=1e-14)
    other = replace(train, meshes=[replace(mesh, error_cos=spectrum.real[1:], error_sin=-spectrum.imag[1:], phase=0.3,
                                           stiffness_cos=[0.1])])
    first, second = mesh_motion(one, 800.0), mesh_motion(other, 800.0)
    assert first.coefficients == pytest.approx(second.coefficients, abs=1e-13 * np.abs(second.coefficients).max())
    # Harmonics that are varied take the place of the tables.
    varied = one.continuation(parameter="stiffness_variation", start=0.1, stop=0.11, frequency=800.0, unit="rpm", harmonics=0,
                              max_points=2)
    assert varied.rms[0] == pytest.approx(first.rms, rel=1e-3)


@pytest.mark.parametrize("values, words", [
    ({"error_table": [1e-6, 2e-6]}, "error_table = 2 values: must be at least 4"),
    ({"error_table": [1e-6, 2e-6, 0.0, 1e-6], "error_cos": [1e-6]}, "error_table = ...: contradicts error_cos, error_sin"),
    ({"error_table": [1e-6, 2e-6, 0.0, 2.0]}, "error_table value 4 = 2.0: must be >= -1 and <= 1 m"),
])
def test_wrong_tables_of_errors_are_refused(values, words):
    train = engine(TABLE)
    with pytest.raises(gt.InputError) as caught:
        replace(train, meshes=[replace(train.meshes[0], **values)])
    assert words in str(caught.value)


def test_sources_are_named():
    """Orders of errors and of a table of two revolutions have the names of their bodies."""
    train = engine(TABLE, torque_revolutions=2)
    train = replace(train, meshes=[replace(train.meshes[0], driving_runout=1e-6, driven_error_cos=[0.0, 1e-6])])
    names = {order.order: order.name for order in train.campbell(start=500.0, stop=900.0, unit="rpm").orders}
    assert names[3] == "0.5 x revolution of engine"
    assert names[6].startswith("revolution of pinion")
    assert names[8] == "2 x revolution of wheel"


def test_half_orders_belong_to_the_engine():
    """Also where the wheel turns half as often, and so has the order 0.5 of the engine."""
    orders = mesh_motion(engine(TABLE, torque_revolutions=2, teeth=(20, 40)), 1500.0).orders()
    owner = dict(zip(orders.per_revolution.values, orders.owner.values, strict=True))
    assert [owner[order] for order in (0.5, 1.0, 1.5, 2.0)] == ["0.5 x engine", "engine", "1.5 x engine", "2 x engine"]


def test_order_cuts_name_orders_as_the_table_of_orders_does():
    train = engine(TABLE, torque_revolutions=2, teeth=(20, 40))
    orders = mesh_motion(train, 1500.0).orders()
    ramp = train.run_up(start=1480.0, stop=1500.0, unit="rpm", duration=0.4)
    cuts = ramp.order_cuts(orders.order.values, what="mesh_force")
    assert cuts.order_name.values.tolist() == orders.owner.values.tolist() and "1.5 x engine" in orders.owner.values
    by_name = ramp.order_cuts(["1.5 x engine"], cycles=cuts.cycles)
    assert np.allclose(by_name.amplitude.values[0], cuts.amplitude.values[cuts.order_name.values.tolist().index("1.5 x engine")])
