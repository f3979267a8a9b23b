"""Forces and torques as measurements: universal files, MDF, rainflow counts, order cuts."""

import sys
import warnings
from dataclasses import replace
from math import pi

import numpy as np
import pytest

import geartrain as gt


@pytest.fixture(scope="module", name="motion")
def _motion(branch):
    return branch.at(0.9)[0]


@pytest.fixture(scope="module", name="ramp")
def _ramp(train):
    return train.run_up(start=0.4, stop=0.5, duration=0.05)


def test_universal_file(motion, tmp_path):
    pyuff = pytest.importorskip("pyuff")
    motion.to_uff(tmp_path / "a.uff", periods=2)
    motion.to_uff(tmp_path / "a.uff", periods=3)  # takes the place of the file
    units, *sets = pyuff.UFF(str(tmp_path / "a.uff")).read_sets()
    assert units["type"] == 164 and [one["id1"] for one in sets] == [
        "mesh force, mesh 1", "mesh force, mesh 2", "shaft torque, shaft 1", "shaft torque, shaft 2", "shaft torque, shaft 3"]
    path = motion.trajectory(3)
    for one, values in zip(sets, [*path.mesh_force.T, *path.shaft_torque.T], strict=True):
        # 12 digits stand in the file, of the step 8.
        assert np.allclose(one["data"], values, rtol=1e-11, atol=0) and len(values) == 768
        assert one["abscissa_inc"] == pytest.approx(1 / (256 * motion.fundamental_frequency), rel=6e-8)
    # Columns 44 to 56 have the step, which a reader by words finds as well.
    lines = [line for line in (tmp_path / "a.uff").read_text().splitlines() if line.startswith("         4       768         1")]
    assert len(lines) == 5 and {len(line) for line in lines} == {69} and {float(line.split()[4]) for line in lines} == {
        float(line[43:56]) for line in lines}
    assert [one["ordinate_axis_units_lab"].strip() for one in sets] == ["N", "N", "N m", "N m", "N m"]


@pytest.mark.full  # the package takes seconds to be imported
def test_mdf(ramp, motion, tmp_path):
    asammdf = pytest.importorskip("asammdf")
    ramp.to_mdf(tmp_path / "a.mf4")
    with asammdf.MDF(tmp_path / "a.mf4") as file:
        torque = file.get("shaft torque, shaft 2")
    assert np.array_equal(torque.samples, ramp.shaft_torque[:, 1]) and np.array_equal(torque.timestamps, ramp.time)
    assert torque.unit == "N m"
    with pytest.raises(gt.InputError, match="periods = 0"):
        motion.to_mdf(tmp_path / "a.mf4", periods=0)


def test_names_and_speed_of_a_train_with_teeth(reducer_train, tmp_path):
    pyuff = pytest.importorskip("pyuff")
    reducer_train.run_up(start=300, stop=310, unit="rpm", duration=0.05).to_uff(tmp_path / "a.uff")
    sets = pyuff.UFF(str(tmp_path / "a.uff")).read_sets()[1:]
    assert sets[0]["id1"] == "mesh force, mesh 1 (pinion 1 - wheel 1)" and sets[-1]["id1"] == "speed, speed"
    assert sets[-1]["data"][[0, -1]] == pytest.approx([300, 310])


@pytest.fixture(scope="module", name="reducer_train")
def _reducer_train():
    from conftest import reducer

    return reducer()


@pytest.mark.parametrize("package", ["pyuff", "asammdf"])
def test_a_folder_that_is_not_there(motion, tmp_path, package):
    pytest.importorskip(package)
    write = motion.to_uff if package == "pyuff" else motion.to_mdf
    with pytest.raises(OSError, match="No such file"):
        write(tmp_path / "none" / "a.mf4")
    assert not (tmp_path / "none").exists()


def test_the_ending_of_mdf(motion, tmp_path):
    with pytest.raises(gt.InputError, match=r"must end in \.mf4"):
        motion.to_mdf(tmp_path / "a.dat")


# Rainflow.

def counted(ramp, values):
    """A run-up whose second shaft has these torques."""
    time = np.linspace(0.0, 1.0, len(values))
    torque = np.zeros((len(values), 3))
    torque[:, 1] = values
    return replace(ramp, time=time, shaft_torque=torque, mesh_force=np.zeros((len(values), 2))).rainflow("shaft 2")


def test_the_example_of_the_standard(ramp):
    """ASTM E1049-85, figure 6."""
    pytest.importorskip("rainflow")
    cycles = counted(ramp, [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0])
    found = {}
    for size, number in zip(cycles.range, cycles.count, strict=True):
        found[size] = found.get(size, 0.0) + number
    assert found == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    assert (cycles.unit, cycles.duration, cycles.title) == ("N m", 1.0, "shaft torque, shaft 2")
    ranges, number = cycles.spectrum()
    assert ranges[0] == 9.0 and (number[0], number[-1]) == (0.5, 4.0)
    damage = 0.5 * 3**6 + 1.5 * 4**6 + 0.5 * 6**6 + 8**6 + 0.5 * 9**6
    assert cycles.damage_equivalent(6.0) == pytest.approx((damage / 4) ** (1 / 6), rel=1e-14)
    assert cycles.damage_equivalent(6.0, cycles=1e3) == pytest.approx((damage / 1e3) ** (1 / 6), rel=1e-14)
    assert cycles.damage_equivalent(900.0) == pytest.approx(9.0, rel=5e-3)  # the largest alone counts
    assert cycles.to_dataframe()["count"].sum() == 4.0


def test_a_motion_without_end(motion):
    """One period has whole cycles only, of which the largest is from the smallest to the largest torque."""
    pytest.importorskip("rainflow")
    one, many = motion.rainflow("shaft 2"), motion.rainflow("shaft 2", periods=20)
    # A sine through 1024 samples a period misses its extremes by 5e-6 of its amplitude, harmonics by more.
    assert one.range.max() == pytest.approx(motion.shaft_torque_maximum[1] - motion.shaft_torque_minimum[1], rel=1e-4)
    assert one.count.sum() == round(one.count.sum()) and many.count.sum() == pytest.approx(20 * one.count.sum(), rel=0.05)
    assert many.damage_equivalent(6.0) == pytest.approx(one.damage_equivalent(6.0), rel=0.01)
    assert one.duration == pytest.approx(1 / motion.fundamental_frequency, rel=1e-12)


def test_words_of_a_count(motion, ramp):
    pytest.importorskip("rainflow")
    with pytest.raises(gt.InputError, match=r"of = 'shaft 9': must be one of 'mesh 1', 'mesh 2', 'shaft 1', 'shaft 2', 'shaft 3'"):
        motion.rainflow("shaft 9")
    cycles = counted(ramp, [0.0, 0.0, 0.0])
    assert cycles.damage_equivalent(6.0) == 0.0 and "the largest 0 N m" in repr(cycles)
    for wrong in (0.0, -1.0, True, "x", float("inf")):
        with pytest.raises(gt.InputError, match="exponent"):
            cycles.damage_equivalent(wrong)


# Order cuts.

def test_order_cuts_of_a_known_ramp(ramp):
    """Orders 1 and 3 of known, growing amplitudes, and one that nobody asks for."""
    time = np.linspace(0.0, 4.0, 80001)
    hertz = np.linspace(20.0, 60.0, len(time))
    turns = time * 20.0 + (hertz[-1] - 20.0) * time**2 / (2 * time[-1])
    grows = 1.0 + time
    force = np.zeros((len(time), 2))
    force[:, 0] = 100.0 + 5.0 * np.cos(2 * pi * turns + 0.3) + grows * np.cos(6 * pi * turns - 0.5) + 7.0 * np.cos(14 * pi * turns)
    known = replace(ramp, time=time, fundamental_frequency=hertz, frequency=hertz / 100, mesh_force=force)
    cuts = known.order_cuts([1, 3])
    assert cuts.amplitude.dims == ("order", "mesh", "time") and cuts.amplitude.attrs["units"] == "N"
    at = cuts.time.values
    # A window of 4 turns: the second derivative of the phase and of the amplitude over it is what remains.
    assert np.allclose(cuts.amplitude.sel(order=1, mesh=1), 5.0, rtol=2e-3) and np.allclose(cuts.amplitude.sel(mesh=2), 0.0)
    assert np.allclose(cuts.amplitude.sel(order=3, mesh=1), 1.0 + at, rtol=5e-3)
    assert np.allclose(cuts.phase.sel(order=1, mesh=1), 0.3, atol=5e-3)
    assert np.allclose(cuts.phase.sel(order=3, mesh=1), -0.5, atol=1e-2)
    assert np.allclose(cuts.fundamental_frequency, np.interp(at, time, hertz))


@pytest.mark.parametrize(("seconds", "warned"), [(4.0, 0), (0.15, 1)])
def test_windows_separate_an_order_from_other_lines_of_the_train(ramp, reducer_train, seconds, warned):
    """Order 71 of mesh 1 stands beside 76, four times that of mesh 2, which nobody asks for."""
    time = np.linspace(0.0, seconds, round(20000 * seconds) + 1)
    hertz = np.linspace(9.0, 11.0, len(time))
    turns = time * 9.0 + time**2 / seconds
    force = np.zeros((len(time), 2))
    force[:, 0] = np.cos(2 * pi * 71 * turns) + 3.0 * np.cos(2 * pi * 76 * turns)
    known = replace(ramp, train=reducer_train, time=time, fundamental_frequency=hertz, frequency=hertz, speed=None,
                    mesh_force=force)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        cuts = known.order_cuts(["mesh 1"])
    said = [str(one.message) for one in caught]
    assert len(said) == warned and (np.allclose(cuts.amplitude.sel(mesh=1), 1.0, rtol=0.01) or warned)
    assert not warned or "a quarter of the ramp, do not separate order 71 from 76: a slower ramp does, or cycles = 0.8" in said[0]


def test_orders_have_their_names(reducer_train):
    ramp = reducer_train.run_up(start=300, stop=310, unit="rpm", duration=0.2)
    cuts = ramp.order_cuts(["mesh 1", "mesh 2"], what="shaft_torque", cycles=0.2)
    assert sorted(cuts.order_name.values) == ["mesh 1", "mesh 2"] and cuts.amplitude.attrs["units"] == "N m"
    assert list(cuts.shaft_label.values) == list(reducer_train.shaft_labels) and 300 < cuts.speed[0] < cuts.speed[-1] < 310


@pytest.mark.parametrize(("asked", "words"), [
    ({"orders": ["mesh 7"]}, "is no order of this train"), ({"orders": []}, "at least one"), ({"orders": [0]}, "above 0"),
    ({"orders": [1, 1e6]}, r"orders: 1e\+06: must be at most"),
    ({"what": "noise"}, "what = 'noise'"), ({"cycles": 1e9}, "cycles = "), ({"cycles": True}, "cycles = "),
])
def test_words_of_order_cuts(ramp, asked, words):
    with pytest.raises(gt.InputError, match=words):
        ramp.order_cuts(**asked)


@pytest.mark.parametrize("package", ["rainflow", "pyuff", "asammdf", "xarray"])
def test_a_package_that_is_missing(motion, ramp, monkeypatch, tmp_path, package):
    monkeypatch.setitem(sys.modules, package, None)
    calls = {"rainflow": lambda: motion.rainflow("shaft 2"), "pyuff": lambda: motion.to_uff(tmp_path / "a.uff"),
             "asammdf": lambda: motion.to_mdf(tmp_path / "a.mf4"), "xarray": lambda: ramp.order_cuts([1])}
    part = "data" if package == "xarray" else "measure"
    with pytest.raises(ModuleNotFoundError, match=rf"needs {package}, which is not installed: pip install 'geartrain\[{part}\]'"):
        calls[package]()
