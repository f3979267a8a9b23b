"""A train as a functional mock-up unit, run by FMPy, against the simulator that it was made of."""

import sys

import numpy as np
import pytest

import geartrain as gt

fmpy = pytest.importorskip("fmpy")
validation = pytest.importorskip("fmpy.validation")
pytest.importorskip("pythonfmu")


def run(unit, torque, steps=20, step=1e-3, **more):
    """Results at the ends of equal steps; torques by their variables, constant over the run."""
    names = list(torque)
    held = np.array([(time, *torque.values()) for time in (0.0, 1.0)], dtype=[("time", float), *((name, float) for name in names)])
    return fmpy.simulate_fmu(str(unit), stop_time=steps * step, output_interval=step, input=held if names else None, **more)


@pytest.fixture(scope="module")
def reducer():
    return gt.read_case("namelists/reducer.nml").train


def variables(unit):
    return {variable.name: variable for variable in fmpy.read_model_description(str(unit)).modelVariables}


def test_unit_gives_the_numbers_of_the_simulator(reducer, tmp_path):
    unit = reducer.write_fmu(tmp_path / "2 stages.fmu", 1500.0, unit="rpm")
    assert validation.validate_fmu(str(unit)) == []
    found = run(unit, {"motor.torque": 40.0, "load.torque": -1000.0}, output=None)
    simulator = reducer.simulator(1500.0, unit="rpm")
    for row in found:
        assert row["speed"] == pytest.approx(simulator.speed, rel=1e-12)
        for name in simulator.names:
            what = "torque" if name.startswith("shaft") else "force" if name.startswith("mesh") else "speed"
            # Steps of the program differ from 1 ms by rounding of its clock; a mesh of 1e9 N/m and 1e4 rad/s feels 1e-17 s.
            assert row[f"{name.replace(' ', '_')}.{what}"] == pytest.approx(simulator.value(name), rel=1e-8), (name, row["time"])
        simulator.advance(1e-3, {"motor": 40.0, "load": -1000.0})
    assert found["speed"][-1] < found["speed"][0] - 10


def test_variables_have_units_and_starts(reducer, tmp_path):
    unit = reducer.write_fmu(tmp_path / "reducer.fmu", 1500.0, unit="rpm", inputs=["motor"], outputs=["mesh 2", "load"])
    known = variables(unit)
    assert {name: variable.unit for name, variable in known.items()} == {
        "initial_speed": "rev/min", "motor.torque": "N.m", "speed": "rev/min", "mesh_2.force": "N", "load.speed": "rad/s"}
    assert float(known["initial_speed"].start) == pytest.approx(1500.0, rel=1e-14)
    assert float(known["motor.torque"].start) == 90.0


def test_initial_speed_is_a_parameter(reducer, tmp_path):
    unit = reducer.write_fmu(tmp_path / "reducer.fmu", 1500.0, unit="rpm", outputs=["mesh 1"])
    found = run(unit, {}, start_values={"initial_speed": 900.0})
    simulator = reducer.simulator(900.0, unit="rpm").advance(0.02)
    assert found["speed"][-1] == pytest.approx(900.0, rel=1e-12)
    assert found["mesh_1.force"][-1] == pytest.approx(simulator.value("mesh 1"), rel=1e-8)


def test_begins_with_a_motion(reducer, tmp_path):
    motion = reducer.integrate(1500.0, unit="rpm")
    unit = reducer.write_fmu(tmp_path / "reducer.fmu", start=motion, outputs=["mesh 1"])
    found = run(unit, {})
    simulator = reducer.simulator(start=motion)
    assert found["mesh_1.force"][0] == pytest.approx(simulator.value("mesh 1"), rel=1e-12)
    assert found["mesh_1.force"][-1] == pytest.approx(simulator.advance(0.02).value("mesh 1"), rel=1e-8)


@pytest.mark.filterwarnings("ignore:.*line load:UserWarning")
@pytest.mark.parametrize("case", ["planetary", "bearings", "driveline"])
def test_planets_bearings_and_couplings(case, tmp_path):
    train = gt.read_case(f"namelists/{case}.nml").train
    speed = 1000.0
    unit = train.write_fmu(tmp_path / f"{case}.fmu", speed, unit="rpm")
    assert validation.validate_fmu(str(unit)) == []
    found, simulator = run(unit, {}, steps=5, output=None), train.simulator(speed, unit="rpm").advance(5e-3)
    values = [simulator.speed, *(simulator.value(name) for name in simulator.names)]
    told = np.array(found[-1].tolist()[1:])
    np.testing.assert_allclose(told, values, rtol=1e-8, atol=1e-8 * np.abs(values).max())


@pytest.mark.parametrize("given, words", [({"motor.torque": float("nan")}, "motor = nan: must be a number"),
                                          ({"initial_speed": -3.0}, "initial_speed: frequency = -3.0: must be a number >= 0")])
def test_what_stops_a_step_is_printed(reducer, tmp_path, given, words, capfd):
    unit = reducer.write_fmu(tmp_path / "reducer.fmu", 1500.0, unit="rpm", outputs=["mesh 1"])
    torque = {name: value for name, value in given.items() if name.endswith("torque")}
    found = run(unit, torque, start_values={name: value for name, value in given.items() if name not in torque})
    assert found["time"][-1] == 0.0
    assert words in capfd.readouterr().err


def test_bad_input(reducer, tmp_path):
    for given, what in [({"inputs": ["moter"]}, "inputs"), ({"outputs": "mesh 1"}, "outputs"), ({"outputs": ["mesh 9"]}, "mesh 9")]:
        with pytest.raises(gt.InputError, match=what):
            reducer.write_fmu(tmp_path / "a.fmu", 1.0, **given)
    with pytest.raises(gt.InputError, match=r"ends in \.fmu"):
        reducer.write_fmu(tmp_path / "a.zip", 1.0)
    with pytest.raises(OSError, match="no such folder"):
        reducer.write_fmu(tmp_path / "nowhere" / "a.fmu", 1.0)
    assert list(tmp_path.iterdir()) == []


def test_names_of_bodies_stay_apart(tmp_path):
    text = {"driving_radius": 0.1, "driven_radius": 0.2, "teeth": (20, 40), "stiffness": 1e8, "damping": 1e3}
    train = gt.Train(characteristic_length=1e-4, characteristic_frequency=1e4,
                     bodies=[gt.Body(name="a b", inertia=0.02, torque=60.0), gt.Body(name="a-b", inertia=0.3, balances=True)],
                     meshes=[gt.Mesh(between=["a b", "a-b"], **text)])
    with pytest.raises(gt.InputError, match=r"a_b\.torque: rename a body"):
        train.write_fmu(tmp_path / "a.fmu", 1.0)
    assert list(tmp_path.iterdir()) == []


def test_leaves_no_trace_in_the_interpreter(reducer, tmp_path):
    paths, modules = list(sys.path), set(sys.modules)
    reducer.write_fmu(tmp_path / "numpy.fmu", 1.0)
    assert sys.path == paths
    assert not [name for name in set(sys.modules) - modules if "numpy" in name and "unit" in name]
    assert "numpy_fmu" not in sys.modules and sys.modules["numpy"] is np
