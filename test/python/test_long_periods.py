"""Gearboxes of three stages and with idle gears: integration and run-ups settle by the time constants of the train, take their
figures from a window, and say what a longer one would change."""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT, assert_equal_files, run
from gearboxes import REFERENCE_TURBINE, TRANSAXLE, TRUCK, WIND_TURBINE, Chain, train_of, truck, wind_turbine
from test_many_cycles import stages

import geartrain as gt

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")

#: Figures of a motion, and the names of what they are uncertain by.
FIGURES = {
    **{name: f"{name}_uncertainty" for name in ("rms", "mean", "minimum", "maximum")},
    "mesh_force_maximum": "force_uncertainty",
    **{f"shaft_torque_{name}": f"torque_{short}_uncertainty"
       for name, short in (("mean", "mean"), ("minimum", "min"), ("maximum", "max"))},
}


@pytest.fixture(scope="module")
def turbine():
    return wind_turbine()


def test_a_sweep_is_a_matter_of_seconds(executable, tmp_path):
    """Two speeds, of which one meets a natural frequency: settled, with uncertainties, the same from the executable and back."""
    case = tmp_path / "turbine.nml"
    case.write_text(WIND_TURBINE.format(torque=322e3) + "&integration from = 1400.0, to = 1500.0, points = 2, unit = 'rpm' /\n")
    done = run(executable, case, "--output", tmp_path / "a.h5")
    told = " ".join(done.stdout.split())
    assert "1400 to 1500 rpm, 2 motions" in told and "all 2 motions settled" in told, done
    assert "Figures of a window of time: 2 stationary" in told and "a window ten times as long would change" in told, done
    begun = time.process_time()
    results = gt.read_case(case).run()
    assert time.process_time() - begun < 20
    results.write(tmp_path / "b.h5")
    assert_equal_files(tmp_path / "a.h5", tmp_path / "b.h5")
    for motion, back in zip(results.integration, gt.read_results(tmp_path / "a.h5").integration, strict=True):
        assert motion.kind == "stationary" and motion.period == 0 and 0.2 < motion.window < 1 and 0 <= motion.ringing < 1e-3
        assert back.window == motion.window and back.ringing == motion.ringing
        for uncertainty in FIGURES.values():
            assert (getattr(motion, uncertainty) > 0).all()
            np.testing.assert_array_equal(getattr(back, uncertainty), getattr(motion, uncertainty))
        assert (motion.rms_uncertainty < 0.02 * motion.rms).all()
        assert motion.time[-1] < motion.window * 2 * np.pi / motion.frequency < motion.time[-1] * 1.001
        order, amplitude = motion.spectrum()
        strongest = order[amplitude[:, 2].argmax()]
        assert min(abs(strongest - n * 7216) for n in (1, 2, 3)) < 1 / motion.window or strongest < 7216
    data = results.integration.to_dataset()
    assert data.rms_uncertainty.dims == ("point", "mesh") and data.torque_min_uncertainty.dims == ("point", "shaft")


def test_a_window_of_a_short_period_has_the_figures_of_the_period(train):
    """Whole cycles of the one mesh frequency: the figures of the steady motion, as far as it has settled."""
    exact, found = train.integrate(0.9), train.integrate(0.9, window=60)
    assert exact.period == 1 and found.period == 0 and found.window == 60 and found.kind == "stationary"
    for figure, uncertainty in FIGURES.items():
        # The extremes are those of samples.
        allowed = getattr(found, uncertainty) + 1e-4 * abs(getattr(exact, figure)).max()
        assert (abs(getattr(found, figure) - getattr(exact, figure)) <= allowed).all(), figure


def test_a_slow_mode_is_taken_out(turbine):
    """The rotor turned against the generator by 30 % of the twist at rest rings for minutes; the figures are those without it."""
    steady = turbine.integrate(1400.0, unit="rpm")
    state = steady.state.copy()
    state[0] += 1100.0  # um along the base circle of its wheel, where the twist at rest is 3658
    ringing = turbine.run_up(start=1400.0, stop=1400.0, unit="rpm", duration=0.5, seed=list(state), max_periods=0)
    assert ringing.mesh_force_maximum.max(axis=0)[0] > 1.02 * steady.mesh_force_maximum[0]
    found = turbine.integrate(1400.0, unit="rpm", start=list(state))
    assert found.kind == "stationary" and found.ringing < 1e-3
    for figure, uncertainty in FIGURES.items():
        assert (abs(getattr(found, figure) - getattr(steady, figure)) <= getattr(steady, uncertainty)).all(), figure


def test_a_run_up_begins_with_the_steady_motion(turbine):
    """Its first second at constant speed is within the window's extremes; a ramp begins so as well."""
    steady = turbine.integrate(1400.0, unit="rpm")
    held = turbine.run_up(start=1400.0, stop=1400.0, unit="rpm", duration=1.0)
    assert held.complete and held.start_period == 0 and held.ended == "reached Lambda = 1400"
    assert 1 < held.start_settling < 20 and 0 <= held.start_ringing < 1e-3
    high, low = held.mesh_force_maximum.max(axis=0), held.mesh_force_minimum.min(axis=0)
    swing = steady.mesh_force_maximum - held.mesh_force.mean(axis=0)
    assert (high <= steady.mesh_force_maximum + steady.force_uncertainty + 0.02 * swing).all()
    assert (high >= steady.mesh_force_maximum - 0.2 * swing).all() and (low < high).all()
    ramp = turbine.run_up(start=1100.0, stop=1200.0, unit="rpm", duration=1.0)
    assert ramp.complete and "steady" not in ramp.ended and ramp.start_ringing < 1e-3


def test_what_has_not_settled_says_so(turbine):
    """A hundredth of the common period is 5 cycles of the slowest mesh: the slow mode goes by unread."""
    train = stages((23, 101), (19, 107), (17, 61))
    found = train.integrate(1000.0, unit="rpm", max_periods=1, window=20)
    assert found.window == pytest.approx(20 / train.explain()["mesh 3"]["order"])  # of the slowest mesh
    harder = wind_turbine().run_up(start=1400.0, stop=1410.0, unit="rpm", duration=0.1, max_periods=1)
    assert 5.6 < harder.start_settling < 1.25 * 5.7
    slow = gt.Train(**{**{name: getattr(turbine, name) for name in ("title", "speed_of")},
                       "bodies": [gt.Body(name="rotor", inertia=1e9, torque=322e3), *turbine.bodies[1:-1],
                                  gt.Body(name="generator", inertia=24e3, balances=True)],
                       "shafts": turbine.shafts, "meshes": turbine.meshes})
    found = slow.run_up(start=1400.0, stop=1410.0, unit="rpm", duration=0.1)
    assert np.isnan(found.start_ringing) and "whether the motion was steady" in found.ended and "too slow to be read" in found.ended
    motion = slow.integrate(1400.0, unit="rpm", window=20)
    assert motion.kind == "still settling" and np.isnan(motion.ringing)


def test_idle_gears_rattle(executable, tmp_path):
    """Chaos, with its exponent, within seconds; the extremes of idle meshes lie within the gap and what the teeth give."""
    case = tmp_path / "truck.nml"
    case.write_text(TRUCK + "&integration from = 1000.0, to = 1800.0, points = 3, unit = 'rpm' /\n")
    begun = time.monotonic()
    done = run(executable, case, "--output", tmp_path / "a.h5")
    assert time.monotonic() - begun < 60  # some 2 s of processor time
    told = " ".join(done.stdout.split())
    assert "3 of 3 motions did not settle on a period, 3 chaotic" in told and "of a window of time: 3 chaotic" in told, done
    idle = [number for number, name in enumerate(gt.read_case(case).train.mesh_labels, 1) if "gear 1" in name or "gear 3" in name]
    assert f"Without a mean force, and rattling: meshes {', '.join(map(str, idle))}." in told and len(idle) == 4, done
    for motion in gt.read_results(tmp_path / "a.h5").integration:
        idle = np.isnan(motion.dynamic_factor)
        assert list(np.flatnonzero(idle)) == [2, 3, 6, 7]
        assert motion.kind == "chaotic" and motion.lyapunov_exponent > motion.lyapunov_error > 0
        assert (motion.separation_fraction[idle] > 0.9).all() and (motion.force_uncertainty[idle] > 0).all()


def test_a_run_up_with_idle_gears():
    found = truck().run_up(start=1000.0, stop=1100.0, unit="rpm", duration=0.3)
    assert found.complete and found.start_settling > 0
    assert (found.start_ringing < 1e-3) == ("steady" not in found.ended)


def difference(found, exact):
    return abs(found - exact).max(axis=0) / np.ptp(exact, axis=0)


@pytest.mark.parametrize(("torque", "speed"), [
    pytest.param(322e3, 1500.0, marks=pytest.mark.nightly), pytest.param(3e4, 1500.0, marks=pytest.mark.full),
])
def test_a_window_against_scipy(torque, speed):
    """Rms, extremes and forces over a window, from the same state; at light load teeth separate."""
    train = wind_turbine(torque)
    found = train.integrate(speed, unit="rpm", window=6)
    assert ((found.separation_fraction > 0).any()) == (torque < 1e5)
    displacement, force, twist = Chain(train, speed).fly_motion(found)
    assert (difference(found.displacement, displacement) < 1e-3).all()
    assert (difference(found.mesh_force, force) < 1e-3).all()
    assert (difference(found.shaft_torque, twist) < 1e-3).all()
    scale = np.ptp(displacement, axis=0)
    rms = np.sqrt(2) * displacement.std(axis=0)
    np.testing.assert_allclose(found.rms, rms, rtol=1e-3)
    assert (abs(found.minimum - displacement.min(axis=0)) < 1e-3 * scale).all()
    assert (abs(found.maximum - displacement.max(axis=0)) < 1e-3 * scale).all()
    np.testing.assert_allclose(found.mesh_force_maximum, force.max(axis=0), rtol=1e-3)
    np.testing.assert_allclose(found.shaft_torque_maximum, twist.max(axis=0), rtol=1e-3)


@pytest.mark.full
def test_a_short_ramp_against_scipy(turbine):
    found = turbine.run_up(start=1400.0, stop=1450.0, unit="rpm", duration=0.1, samples=16 * 7216)
    begin = turbine.run_up(start=1400.0, stop=1450.0, unit="rpm", duration=0.1, samples=16 * 7216, max_periods=1)
    assert begin.start_ringing == found.start_ringing
    steady = turbine.integrate(1400.0, unit="rpm", window=6)
    found = turbine.run_up(start=1400.0, stop=1450.0, unit="rpm", duration=0.1, samples=16 * 7216, seed=steady, max_periods=0)
    chain = Chain(turbine, 1400.0, rate=500.0)
    displacement, force, twist = chain.fly(steady.state, found.time)
    assert (difference(found.displacement, displacement) < 1e-3).all()
    assert (difference(found.mesh_force, force) < 1e-3).all()
    assert (difference(found.shaft_torque, twist) < 1e-3).all()


def cases(full):
    """Trains and speeds, and how many cycles of the slowest mesh their windows have."""
    yield from ((wind_turbine(), speed, 100 if full else 40) for speed in (np.linspace(1100.0, 1900.0, 9) if full else (1500.0,)))
    if full:
        yield from ((wind_turbine(3e4), speed, 100) for speed in (1200.0, 1500.0))
        yield from ((stages((23, 101), (19, 107), (17, 61)), speed, 100) for speed in (800.0, 1000.0, 1500.0))
        yield from ((truck(), speed, 100) for speed in (1000.0, 1400.0, 1800.0))


@pytest.mark.full
@pytest.mark.parametrize("full", [False, pytest.param(True, marks=pytest.mark.nightly)])
def test_the_uncertainty_covers_a_longer_window(full):
    """Of all figures, all meshes and shafts, 95 of 100 differ by less in a window ten times as long."""
    covered = []
    for train, speed, cycles in cases(full):
        short = train.integrate(speed, unit="rpm", window=cycles)
        long = train.integrate(speed, unit="rpm", window=10 * cycles)
        for figure, uncertainty in FIGURES.items():
            scale = 1e-9 * abs(getattr(long, figure)).max()
            covered += list(abs(getattr(short, figure) - getattr(long, figure)) <= getattr(short, uncertainty) + scale)
    assert np.mean(covered) >= 0.95, (np.sum(covered), len(covered))


CHILD = """
import os, signal, sys, threading, time
sys.path.insert(0, {folder!r})
import geartrain as gt, warnings
from gearboxes import wind_turbine
warnings.simplefilter("ignore")
signal.signal(signal.SIGINT, signal.default_int_handler)
train = wind_turbine()
sent = []
def interrupt():
    time.sleep({wait})
    sent.append(time.process_time())
    os.kill(os.getpid(), signal.SIGINT)
threading.Thread(target=interrupt).start()
try:
    train.{call}
except gt.Interrupted as stop:
    print(time.process_time() - sent[0], stop)
"""


@pytest.mark.full
@pytest.mark.parametrize(("call", "wait"), [
    ("sweep(start=1400.0, stop=1800.0, points=1000, unit='rpm')", 0.3), ("integrate(1400.0, window=1000)", 0.8),
    ("run_up(start=1400.0, stop=1410.0, duration=500.0, samples=1000)", 0.2),
    pytest.param("sweep(start=1400.0, stop=1800.0, points=1000)", 1.0, marks=pytest.mark.nightly),
    pytest.param("run_up(start=1400.0, stop=1410.0, duration=500.0, samples=1000)", 2.0, marks=pytest.mark.nightly),
])
def test_interrupted_at_once(call, wait):
    """Within 0.3 s of processor time, which other work on the machine does not make longer."""
    code = CHILD.format(call=call, wait=wait, folder=str(Path(__file__).parent))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert float(done.stdout.split()[0]) < 0.3 and "stopped by Ctrl-C" in done.stdout, done


@pytest.mark.nightly
def test_in_contact_with_many_harmonics():
    """2279 cycles, some 500 harmonics at 1e-3, and no teeth part."""
    train = stages((20, 43), (19, 53), (17, 61), error_cos=3e-6)
    train = gt.Train(speed_of="motor", bodies=train.bodies, shafts=train.shafts, meshes=train.meshes)
    branch = train.response(start=1650.0, stop=1660.0, unit="rpm", harmonics=0, tolerance=1e-3)
    assert branch.complete and branch.error_estimate.max() <= 1e-3 and (branch.separation_fraction == 0).all()
    [motion], window = branch.at(1655.0, unit="rpm"), train.integrate(1655.0, unit="rpm", window=500)
    assert (abs(motion.rms - window.rms) <= 1e-3 * window.rms + window.rms_uncertainty).all()


@pytest.mark.nightly
def test_teeth_that_part_in_a_long_period_end_early():
    """The wind turbine at a tenth of its load: teeth part at 1034 rpm."""
    branch = wind_turbine(3e4).response(start=1000.0, stop=1100.0, unit="rpm", harmonics=0, tolerance=1e-3)
    apart = (branch.separation_fraction > 0).any(axis=1)
    assert apart.any() and (branch.error_estimate[~apart] <= 1e-3).all()
    assert not branch.complete and "teeth part in mesh cycles that all differ" in branch.ended and "&integration" in branch.ended


@pytest.mark.full
@pytest.mark.parametrize("speed", [1669.0, 1690.0])
def test_a_seed_brings_its_harmonics(speed):
    """Two stages where teeth part: a motion of two hundred harmonics begins a finer branch, which refines to it."""
    train = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    branch = train.response(start=1640.0, stop=1700.0, unit="rpm", harmonics=0, tolerance=1e-3)
    seeds = [motion for motion in branch.at(speed, unit="rpm") if (motion.separation_fraction > 0).any()]
    assert seeds
    for seed in seeds:
        found = train.response(start=speed, stop=speed + 1.0, unit="rpm", harmonics=0, tolerance=1e-4, max_points=2, seed=seed)
        finer = min(found.at(speed, unit="rpm"), key=lambda motion: abs(motion.rms - seed.rms).max())
        exact = seed.refine().rms
        assert (abs(seed.rms - exact) <= 1e-3 * exact).all() and (abs(finer.rms - exact) <= 1e-4 * exact).all()


@pytest.mark.full
def test_windows_keep_to_the_motion_they_begin_with():
    """Three motions at 1668 to 1673 rpm: settling before phase 0, of a state of phase 0, leaves no stable one, nor does a sweep."""
    train = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    branch = train.response(start=1660.0, stop=1680.0, unit="rpm", harmonics=0, tolerance=1e-3)
    stable = [motion for motion in branch.at(1672.0, unit="rpm") if motion.stable]
    assert len(stable) == 2
    for motion in stable:
        window = train.integrate(1672.0, unit="rpm", start=motion, window=100)
        # From a state, at another speed.
        later = train.integrate(1672.2, unit="rpm", start=window, window=100)
        assert window.kind == later.kind == "stationary" and window.period == later.period == 0
        assert (abs(window.rms - motion.rms) <= 1e-3 * motion.rms + window.rms_uncertainty).all()
        assert (abs(later.rms - motion.rms) <= 0.02 * motion.rms).all()
    up, down = (train.sweep(start=1668.0, stop=1676.0, points=3, unit="rpm", direction=way, window=100) for way in ("up", "down"))
    # At 1668, 1672 and 1676 rpm.
    assert [motion.rms[0] > 6 for motion in (*up, *down)] == [False, False, True, True, True, True]


@pytest.mark.full
def test_a_response_begins_where_teeth_part():
    """Three stages, a period of 6499 cycles: Newton's method begins at what the flow from rest settles on."""
    train = stages((27, 97), (18, 67), (19, 60), error_cos=3e-6)
    train = gt.Train(speed_of="motor", bodies=train.bodies, shafts=train.shafts, meshes=train.meshes)
    settings = {"unit": "rpm", "harmonics": 0, "tolerance": 1e-2}
    [motion] = train.response(start=2400.0, stop=2401.0, max_points=2, **settings).at(2400.0, unit="rpm")
    window = train.integrate(2400.0, unit="rpm")
    assert window.separation_fraction[0] > 0.3 and motion.error_estimate < 0.1
    assert (abs(motion.rms - window.rms) <= motion.error_estimate * motion.rms + window.rms_uncertainty).all()


@pytest.mark.nightly
def test_both_ends_lead_to_motions_out_of_reach():
    """The high-speed stage of a 5 MW gearbox parts at 970 to 985 rpm: what one end misses does not end the trace from the other."""
    branch = train_of(REFERENCE_TURBINE).response(start=950.0, stop=1000.0, unit="rpm", harmonics=0, tolerance=1e-3)
    assert branch.ended.count("teeth part in mesh cycles that all differ") == 2 and not branch.complete
    apart = (branch.separation_fraction > 0).any(axis=1)
    assert (branch.error_estimate[~apart] <= 1e-3).all() and branch.estimate_doubtful[apart].all()
    for low, high in ((950.0, 965.0), (990.0, 1000.0)):
        assert np.diff(np.sort(branch.speed[~apart & (branch.speed >= low) & (branch.speed <= high)])).max() < 1.0
        assert branch.speed.min() == 950.0 and branch.speed.max() == 1000.0


@pytest.mark.full
def test_the_balance_agrees_with_windows(turbine, times):
    """Two methods that share neither period nor harmonics: the response to 1e-3, and its verdicts, against settled motions."""
    settings = {"unit": "rpm", "harmonics": 0, "tolerance": 1e-3}
    speeds = np.random.default_rng(3).uniform(1105, 1895, times(40))
    branch = turbine.response(start=1100, stop=1900, **settings) if len(speeds) == 40 else None
    within = []
    for speed in speeds:
        branch = branch if len(speeds) == 40 else turbine.response(start=speed, stop=speed + 1, max_points=2, **settings)
        [motion], window = branch.at(speed, unit="rpm"), turbine.integrate(speed, unit="rpm")
        assert motion.stable and window.kind == "stationary"
        for name in ("rms", "mesh_force_maximum"):
            np.testing.assert_allclose(getattr(motion, name), getattr(window, name), rtol=1e-3)
        # The extremes of the whole period are beyond those of a window.
        within += [abs(getattr(motion, name) - getattr(window, name)) <= getattr(window, FIGURES[name])
                   for name in ("minimum", "maximum")]
    assert np.mean(within) >= 0.95


@pytest.mark.full
@pytest.mark.parametrize(("text", "speeds"), [
    pytest.param(REFERENCE_TURBINE, (1000.0,), marks=pytest.mark.nightly), (TRANSAXLE, (900.0, 2500.0, 4000.0))])
def test_published_gearboxes(text, speeds):
    """Balance and integration agree to the error estimates of the meshes, within a factor of 3, and the window's uncertainty."""
    train = train_of(text)
    for speed in speeds:
        branch = train.response(start=speed, stop=speed + 1, unit="rpm", harmonics=0, tolerance=1e-3, max_points=2)
        balanced, integrated = branch.at(speed, unit="rpm")[0], train.integrate(speed, unit="rpm")
        assert balanced.stable and integrated.kind in ("periodic", "stationary"), speed
        estimate = branch.to_dataset().mesh_error_estimate.max("point").values
        for figure, uncertainty in FIGURES.items():
            value, other = getattr(balanced, figure), getattr(integrated, figure)
            window = getattr(integrated, uncertainty) if integrated.kind == "stationary" else 0
            error = 3 * (estimate if len(value) == len(estimate) else estimate.max())
            assert (abs(value - other) <= error * abs(other) + window).all(), (speed, figure, value, other)
