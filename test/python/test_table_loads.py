"""Meshes whose stiffness grows with the load, `table_loads`: against SciPy on its own equations, of a polygon and of Hertz."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import geartrain as gt
from geartrain.variables import VARIABLES

LOADS = np.array([300.0, 700.0, 1400.0, 2400.0, 4000.0])
PHASE = 2 * np.pi * np.arange(8) / 8
GAP, RADII, INERTIAS, DAMPING, SPEED = 5e-6, (0.03, 0.05), (1e-3, 2e-3), 2000.0, 1000.0
MASS = 1 / (RADII[0] ** 2 / INERTIAS[0] + RADII[1] ** 2 / INERTIAS[1])


def hertz(phase):
    """Force over stretch to the power of 1.5 of a pair of bodies with curved surfaces [N/m^1.5]; the phase of the cycle."""
    return 1e12 * (1 + 0.25 * np.cos(phase) + 0.08 * np.sin(2 * phase))


def table(loads=LOADS):
    """Load over deflection, (load, instant)."""
    return np.array([load ** (1 / 3) * hertz(PHASE) ** (2 / 3) for load in loads])


def pair(torque=60.0, stiffness=None, **changes):
    stiffness = table() if stiffness is None else stiffness
    mesh = {"table_loads": LOADS, "damping": DAMPING, "half_backlash": GAP, **changes}
    return gt.Train(
        characteristic_length=1e-6, characteristic_frequency=SPEED,
        bodies=[gt.Body(name="a", inertia=INERTIAS[0], torque=torque), gt.Body(name="b", inertia=INERTIAS[1], balances=True)],
        meshes=[gt.Mesh(between=("a", "b"), driving_radius=RADII[0], driven_radius=RADII[1],
                        stiffness_table=[float(x) for x in np.ravel(stiffness)], **mesh)])


def corners():
    """Displacement beyond the gap at the corners, and forces there at the instants: powers of the deflection between the loads."""
    deflection = LOADS / table().T  # (instant, load)
    corner = np.array([0.0, *deflection.mean(axis=0)])
    force = np.zeros((len(PHASE), len(corner)))
    for place, known in enumerate(deflection):
        # Below the first load the force is proportional, and beyond the last one the power goes on, here 1.5 everywhere.
        force[place] = np.where(corner < known[0], LOADS[0] * corner / known[0], LOADS[0] * (corner / known[0]) ** 1.5)
    return corner, force


def polygon():
    """The elastic force by phase and stretch [m]."""
    corner, force = corners()
    terms = np.fft.rfft(force, axis=0) / len(PHASE)
    terms[1:-1] *= 2  # of an even number of instants the last one is once there
    orders = np.arange(len(terms))

    def elastic(phase, stretch):
        at = np.real(np.exp(1j * orders * phase) @ terms)
        beyond = (at[-1] - at[-2]) / (corner[-1] - corner[-2]) * max(0.0, stretch - corner[-1])
        return np.interp(stretch, corner, at) + beyond

    return elastic


def as_hertz(phase, stretch):
    return hertz(phase) * stretch**1.5


def integrated(elastic, torque, ratio, periods, start=1e-6, samples=1024):
    """Displacement and force over the last period of the pair, by SciPy."""
    load, omega = torque / RADII[0], ratio * SPEED
    whole = 2 * np.pi / omega

    def force(t, p, v):
        return np.sign(p) * elastic(omega * t, abs(p) - GAP) * (abs(p) > GAP) + DAMPING * v

    def rate(t, y):
        return [y[1], (load - force(t, *y)) / MASS]

    times = whole * (periods - 1 + np.arange(samples) / samples)
    found = solve_ivp(rate, (0, periods * whole), [GAP + start, 0.0], method="DOP853", rtol=1e-9, atol=[1e-16, 1e-9],
                      t_eval=times, max_step=whole / 40)
    return found.y[0], np.array([force(*row) for row in zip(times, *found.y)])


def both(train, ratio):
    """The motion on which time integration settles, and that of the harmonic balance at the same speed."""
    settled = train.integrate(ratio)
    found = train.response(start=1.02 * ratio, stop=0.999 * ratio, harmonics=40).at(ratio)
    return settled, min(found, key=lambda motion: abs(motion.rms[0] - settled.rms[0]))


def agrees(motion, p, force, rtol):
    assert motion.mean[0] * 1e-6 == pytest.approx(p.mean(), rel=rtol)
    assert motion.true_ac_rms[0] * 1e-6 == pytest.approx(p.std(), rel=20 * rtol)
    assert motion.mesh_force_maximum[0] == pytest.approx(force.max(), rel=20 * rtol)


@pytest.mark.parametrize(("torque", "ratio", "periods"), [
    pytest.param(60.0, 15.0, 40, id="stages"), pytest.param(20.0, 46.0, 110, id="parts", marks=pytest.mark.full)])
def test_the_polygon_against_scipy(torque, ratio, periods):
    """Several stages are passed in contact; or teeth part during a third of the cycle."""
    p, force = integrated(polygon(), torque, ratio, periods)
    settled, balanced = both(pair(torque), ratio)
    assert (settled.separation_fraction[0] > 0.05) == (torque < 30)
    # SciPy steps over corners with a tolerance of 1e-9; 1024 samples miss a maximum by some 1e-6.
    agrees(settled, p, force, 1e-7)
    # 40 harmonics leave some 40^-3 of the waveform where teeth part.
    agrees(balanced, p, force, 1e-5 if torque < 30 else 1e-6)


def test_hertzian_pairs_as_they_are():
    """The polygon is as far from the table as it says, and motions differ from those of the law of Hertz by less."""
    told = pair().explain()["mesh 1"]
    corner, force = corners()
    deflection = LOADS / table().T
    ours = [[np.interp(x, corner, at) for x in row[:-1]] for row, at in zip(deflection, force)]
    last = [at[-1] + (at[-1] - at[-2]) / (corner[-1] - corner[-2]) * (row[-1] - corner[-1]) if row[-1] > corner[-1]
            else np.interp(row[-1], corner, at) for row, at in zip(deflection, force)]
    error = np.abs(np.column_stack([ours, last]) / LOADS - 1).max()
    assert told["stage_error"] == pytest.approx(error, rel=1e-9)
    assert told["stage_wall"] == pytest.approx(corner[1:-1], rel=1e-12)
    p, exact = integrated(as_hertz, 60.0, 15.0, 40)
    settled = pair().integrate(15.0)
    assert settled.mean[0] * 1e-6 - GAP == pytest.approx(p.mean() - GAP, rel=error)
    assert settled.true_ac_rms[0] * 1e-6 == pytest.approx(p.std(), rel=error)
    assert settled.mesh_force_maximum[0] == pytest.approx(exact.max(), rel=error)
    # One load, in the middle of the range, is much further off.
    middle = pair(stiffness=table()[2], table_loads=None).integrate(15.0)
    assert abs(middle.true_ac_rms[0] * 1e-6 / p.std() - 1) > 2 * abs(settled.true_ac_rms[0] * 1e-6 / p.std() - 1)


def test_a_stiffness_that_does_not_depend_on_the_load():
    """The same table at every load is the table of a mesh without loads."""
    ours, theirs = pair(stiffness=np.tile(table()[1], len(LOADS))), pair(stiffness=table()[1], table_loads=None)
    for one, other in zip(both(ours, 15.0), both(theirs, 15.0)):
        assert np.allclose(one.coefficients, other.coefficients, rtol=0, atol=1e-8)
        assert one.mesh_force_maximum == pytest.approx(other.mesh_force_maximum, rel=1e-8)
    assert ours.natural_frequencies() == pytest.approx(theirs.natural_frequencies(), rel=1e-12)


def test_modes_are_those_of_the_load():
    """The stage in which the mean load rests is that of natural frequencies."""
    numbers = pair().explain()["mesh 1"]
    for torque, stage in ((6.0, None), (30.0, 2), (100.0, 4)):
        stiffness = numbers["stiffness"] if stage is None else numbers["stage_stiffness"][stage - 1]
        assert pair(torque).natural_frequencies(unit="Hz")[0] == pytest.approx(np.sqrt(stiffness / MASS) / (2 * np.pi), rel=1e-9)
    with pytest.raises(gt.InputError, match="mesh 1 has table_loads"):
        pair().state_space()


@pytest.mark.full
def test_gradient_and_multipliers():
    train = pair()
    motion = train.integrate(15.0).refine()
    # The determinant of the period map is that of the damping.
    assert np.prod(motion.multipliers).real == pytest.approx(np.exp(-DAMPING / MASS * 2 * np.pi / (15.0 * SPEED)), rel=1e-8)
    names = ["mesh 1 stiffness_table 20", "mesh 1 half_backlash", "mesh 1 damping"]
    found = motion.gradient("rms", names)[0]
    for name, slope in zip(names, found):
        value = {"half_backlash": GAP, "damping": DAMPING}.get(name.split()[2], float(table().ravel()[19]))
        above, below = (train.with_values({name: factor * value}).integrate(15.0).refine() for factor in (1.006, 0.994))
        difference = (above.rms - below.rms)[0] / (0.012 * value)
        # The step squared is 4e-5; the motion has harmonics up to where 1e-6 of it is left.
        assert slope == pytest.approx(difference, rel=5e-4, abs=1e-6 * motion.rms[0] / value)


@pytest.mark.parametrize(("changes", "words"), [
    ({"table_loads": [500.0]}, "table_loads = ...: must be two or more loads that ascend"),
    ({"table_loads": [500.0, 400.0]}, "table_loads = ...: must be two or more loads that ascend"),
    ({"table_loads": LOADS[:3]}, "40 values: must be equally many, 4 or more, for each of the 3 table_loads"),
    ({"stiffness": np.ones(15) * 1e8}, "15 values: must be equally many, 4 or more, for each of the 5 table_loads"),
    ({"stiffness": table() * np.array([1, 1, 1, 10, 1])[:, None]}, "at instant 1 of the cycle the change of load"),
    ({"half_backlash": 0.0}, "table_loads = ...: needs half_backlash or backlash > 0 m"),
    ({"stiffness_table": None}, "lacks stiffness_table"),
])
def test_refused(changes, words):
    with pytest.raises(gt.InputError) as caught:
        if "stiffness_table" in changes:
            gt.Train(**{**{name: getattr(pair(), name) for name in ("characteristic_length", "characteristic_frequency", "bodies")},
                        "meshes": [gt.Mesh(between=("a", "b"), driving_radius=0.03, driven_radius=0.05, damping=1.0,
                                           half_backlash=GAP, table_loads=LOADS)]})
        else:
            pair(**changes)
    assert words in str(caught.value), str(caught.value)
    with pytest.raises(gt.InputError, match="the variation of a mesh with table_loads is given at each load"):
        pair().continuation(parameter="stiffness_variation", start=0.1, stop=0.2, frequency=15.0)


def test_the_reference_says_what_the_loads_need():
    """What the error says of backlash stands beside the variable as well."""
    assert "half_backlash or backlash must be > 0" in VARIABLES["mesh"]["table_loads"].meaning
