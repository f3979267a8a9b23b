"""Couplings: closed forms, shafts and gear pairs that are the same, and equations of their own by SciPy."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from coupling_model import LENGTH, PER_TWIST, RATE, Equations, middle_of, random_train, rotor, torque_of
from scipy.integrate import quad

import geartrain as gt
from geartrain.plots.schematic import joints_of
from geartrain.results.motion import from_state

#: Softer, then harder towards higher torques, with a play that is not in the middle of the polygon.
STAGES = {"angle": [-0.03, -0.015, -0.004, 0.004, 0.012, 0.03], "torque": [-60.0, -40.0, 0.0, 0.0, 8.0, 60.0]}
#: Without play; the angle without torque lies within the polygon, not at a corner.
BENT = {"angle": [-0.02, -0.005, 0.01, 0.03], "torque": [-40.0, -20.0, 10.0, 120.0]}


def driveline(couplings=1, swing=25.0, **given):
    """An engine that turns unevenly, couplings, a gear pair, a vehicle."""
    names = ["engine", *(f"hub {number}" for number in range(1, couplings)), "pinion"]
    return gt.Train(
        characteristic_length=LENGTH, characteristic_frequency=RATE,
        bodies=[gt.Body(name="engine", inertia=0.1, torque=30.0, torque_cos=[swing]),
                *(gt.Body(name=name, inertia=0.004) for name in names[1:]), gt.Body(name="wheel", inertia=0.06, balances=True)],
        couplings=[gt.Coupling(between=ends, **given) for ends in pairwise(names)],
        meshes=[gt.Mesh(between=("pinion", "wheel"), driving_radius=0.03, driven_radius=0.08, stiffness=5e7, damping_ratio=0.1,
                        half_backlash=20e-6, stiffness_cos=[0.2])],
    )


# Closed forms


@pytest.mark.parametrize("torque", [-90.0, -50.0, -3.0, 4.0, 30.0, 75.0])
@pytest.mark.parametrize("law", [STAGES, BENT])
def test_rest(law, torque):
    coupling = gt.Coupling(between=("rotor", "housing"), damping=2.0, **law)
    motion = rotor(torque, damping=2.0, **law).integrate(frequency=0.3)
    twist = motion.mean[0] / PER_TWIST + middle_of(coupling)
    assert torque_of(coupling, twist) == pytest.approx(torque, rel=1e-9)
    assert motion.coupling_torque_mean[0] == pytest.approx(torque, rel=1e-9)
    assert motion.reaction_torque_mean[0] == pytest.approx(-torque, rel=1e-9)


@pytest.mark.parametrize("law", [STAGES, BENT])
def test_free_oscillation(law):
    """Without damping: the period from one extreme to the next and back by the energy."""
    train = rotor(5.0, **law)
    coupling, inertia = train.couplings[0], 0.02
    middle, far = middle_of(coupling), 0.028
    x = np.asarray(coupling.angle, float)

    def energy(twist):  # of the coupling and the torque
        corners = np.sort(np.concatenate([x[(x > min(0, twist)) & (x < max(0, twist))], [0.0, twist]]))
        area = np.trapezoid(torque_of(coupling, corners), corners) * np.sign(twist or 1.0)
        return area - 5.0 * twist

    top = energy(far)
    low, high = -1.0, 0.0
    for _ in range(200):
        back = (low + high) / 2
        low, high = (back, high) if energy(back) > top else (low, back)
    inner = [back, *x[(x > back) & (x < far)], far]
    half = 0.0

    def slowness(s, c, d):  # twist = c - d cos(s): the root at either end is none in s
        return d * np.sin(s) * np.sqrt(inertia / (2 * max(top - energy(c - d * np.cos(s)), 1e-300)))

    for a, b in pairwise(inner):
        half += quad(slowness, 0, np.pi, args=((a + b) / 2, (b - a) / 2), limit=400, epsabs=1e-13, epsrel=1e-11)[0]
    state = np.array([(far - middle) * PER_TWIST, 0.0])
    frequency = 2 * np.pi / (2 * half) / RATE
    motion = replace(from_state(state, 1, 2), frequency=frequency, train=train, coefficients=np.zeros((1, 1)), period=0)
    path = motion.trajectory(3)
    per_period = len(path.time) // 3
    error = np.abs(path.displacement[[per_period, 2 * per_period], 0] - state[0]) / state[0]
    assert error.max() < 1e-9


def test_like_a_shaft():
    values = {"stiffness": 3.0e3, "damping": 0.8}
    by_coupling = driveline(**values)
    by_shaft = replace(by_coupling, couplings=(), shafts=[gt.Shaft(between=("engine", "pinion"), **values)])
    assert by_coupling.natural_frequencies() == pytest.approx(by_shaft.natural_frequencies(), rel=1e-12)
    one, other = (train.integrate(frequency=0.31, harmonics=12) for train in (by_coupling, by_shaft))
    assert one.period == other.period == 1
    assert one.rms[0] == pytest.approx(other.rms[0], rel=1e-10)
    assert one.coupling_torque_maximum[0] == pytest.approx(other.shaft_torque_maximum[0], rel=1e-10)
    one, other = (train.response(start=0.30, stop=0.32, harmonics=12).at(0.31)[0] for train in (by_coupling, by_shaft))
    assert one.coefficients[0] == pytest.approx(other.coefficients[0], abs=1e-10 * abs(other.coefficients[0]).max())
    assert sorted(abs(one.multipliers)) == pytest.approx(sorted(abs(other.multipliers)), abs=1e-10)


def test_like_a_gear_pair():
    """A play is a backlash: of a gear pair of any radius, with its stiffness and damping along the line of action."""
    radius = 0.02
    by_coupling = driveline(stiffness=3.0e3, damping=0.8, half_play=0.004, damping_acts="contact")
    pair = gt.Mesh(between=("engine", "pinion"), driving_radius=radius, driven_radius=radius, internal=True,
                   stiffness=3.0e3 / radius**2, damping=0.8 / radius**2, half_backlash=0.004 * radius, damping_acts="contact")
    by_pair = replace(by_coupling, couplings=(), meshes=[*by_coupling.meshes, pair])
    one, other = (train.integrate(frequency=0.25, start=None) for train in (by_coupling, by_pair))
    assert one.period == other.period == 1
    assert one.rms * [1.0, radius / 1e-3] == pytest.approx(other.rms, rel=1e-9)
    assert one.mesh_force_maximum[1] == pytest.approx(radius * other.mesh_force_maximum[1], rel=1e-9)
    assert one.separation_fraction == pytest.approx(other.separation_fraction, abs=1e-9)
    assert np.sort_complex(one.multipliers) == pytest.approx(np.sort_complex(other.multipliers), abs=1e-8)


@pytest.mark.parametrize("acts", ["always", "contact"])
def test_energy_loss(acts):
    """What damping takes in a period: by the amplitude of a linear coupling; else the work of the torque that moves the rotor."""
    swing, damping, inertia = 30.0, 4.0, 0.02
    play = {"half_play": 0.004, "damping_acts": acts} if acts == "contact" else {}
    train = rotor(3.0, stiffness=4.0e3, damping=damping, **play)
    train = replace(train, bodies=[replace(train.bodies[0], torque_cos=[swing]), train.bodies[1]])
    # In the unit of the last one a vibration takes 1e-9.
    slow = replace(train, characteristic_frequency=1e-9 * RATE)
    motions = [train.integrate(frequency=0.2), *train.response(start=0.19, stop=0.21, harmonics=60).at(0.2),
               slow.integrate(frequency=0.2e9)]
    omega = 0.2 * RATE
    for motion, error in zip(motions, (1e-8, 1e-8, 1e-8), strict=True):
        if not play:
            twist = swing / abs(4.0e3 - inertia * omega**2 + 1j * omega * damping)
            assert motion.coupling_energy_loss[0] == pytest.approx(np.pi * damping * omega * twist**2, rel=1e-10)
        # Of the torque swing cos(omega t) only the sine of the twist, at order 1, takes up energy.
        work = np.pi * swing * motion.coefficients[0, 2] / PER_TWIST
        assert motion.coupling_energy_loss[0] == pytest.approx(work, rel=error)


def test_energy_loss_of_branches(tmp_path):
    branch = driveline(2, damping=0.5, **STAGES).response(start=0.2, stop=0.22, harmonics=12)
    assert branch.coupling_energy_loss.shape == (len(branch), 2)
    assert branch.to_dataset().coupling_energy_loss.dims == ("point", "coupling")
    motion = branch.at(0.21)[0]
    assert motion.refine().coupling_energy_loss == pytest.approx(motion.coupling_energy_loss, rel=0.01)
    branch.write(tmp_path / "loss.h5")
    assert (gt.read_results(tmp_path / "loss.h5").response.coupling_energy_loss == branch.coupling_energy_loss).all()


# Other equations


@pytest.mark.full
def test_random_networks(times):
    compared = 0
    for seed in range(times(200, 40)):
        train = random_train(seed)
        motion = train.integrate(frequency=0.2 + 0.03 * (seed % 11))
        if not motion.period or motion.period > 4:
            continue
        compared += 1
        equations = Equations(train)
        displacement, multipliers = equations.fly(motion, samples=4096)
        scale = np.abs(displacement).max(axis=1)
        assert np.abs(displacement[:, -1] - displacement[:, 0]).max() < 1e-7 * scale.max(), seed
        cycle = displacement[:, :-1]
        rms = np.sqrt(2 * ((cycle - cycle.mean(axis=1)[:, None]) ** 2).mean(axis=1))
        assert motion.rms == pytest.approx(rms, abs=1e-8 * scale.max()), seed
        assert abs(max(abs(multipliers)) - max(abs(motion.multipliers))) < 1e-7, seed
        path = motion.trajectory(1)
        for place, coupling in enumerate(train.couplings, len(train.meshes)):
            twist = path.displacement[:, place] * equations.unit[place] + equations.middle[place]
            rate = path.velocity[:, place] * equations.unit[place] * RATE
            torque = torque_of(coupling, twist) + coupling.damping * rate
            assert path.mesh_force[:, place] == pytest.approx(torque, abs=1e-9 * abs(torque).max()), seed
            assert motion.coupling_torque_maximum[place - len(train.meshes)] >= torque.max() - 1e-9 * abs(torque).max(), seed
    assert compared >= 0.6 * times(200, 40)


# Every analysis


def test_balance_and_shooting():
    """The balance with its own coefficients, its error estimate, its multipliers; the largest torque, at a corner or not."""
    train = driveline(2, swing=50.0, damping=0.5, **BENT)
    motions = train.response(start=0.3, stop=0.5, harmonics=30).at(0.4)
    assert len(motions) == 3
    for motion in motions:
        exact = motion.refine()
        # Corners are passed: the balance is not exact.
        assert 1e-8 < motion.error_estimate < 1e-3
        assert np.abs(motion.rms - exact.rms).max() < 3 * motion.error_estimate * exact.rms.max()
        assert max(abs(motion.multipliers)) == pytest.approx(max(abs(exact.multipliers)), rel=2e-3)
        assert motion.mesh_force_maximum[1:] == pytest.approx(motion.coupling_torque_maximum, rel=1e-12)
        assert motion.coupling_torque_maximum == pytest.approx(exact.coupling_torque_maximum, rel=1e-4)
        assert motion.coupling_torque_minimum == pytest.approx(exact.coupling_torque_minimum, rel=5e-4)
        assert exact.coupling_torque_maximum == pytest.approx(exact.coupling_torque.max(axis=0), rel=1e-3)


def test_stage_reached():
    """A stage reached is a contact onset: there the twist just comes to a corner, of the balance and of the exact motion."""
    train = driveline(swing=50.0, damping=0.5, **BENT)
    branch = train.response(start=0.35, stop=0.95, harmonics=24)
    onsets = [onset for onset in branch.onsets if onset.kind.startswith("stage")]
    assert {onset.kind for onset in onsets} == {"stage 1 reached", "stage 2 reached"} and {onset.mesh for onset in onsets} == {2}
    for onset in onsets:
        exact = onset.exact()
        assert exact.kind == onset.kind
        assert exact.frequency == pytest.approx(onset.frequency, rel=1e-4)
        twist = np.array([exact.motion.minimum[1], exact.motion.maximum[1]]) / PER_TWIST + middle_of(train.couplings[0])
        corners = np.asarray(BENT["angle"])[1:-1]
        assert np.abs(twist[:, None] - corners).min() < 1e-8


def test_parameters():
    train = driveline(swing=80.0, stiffness=3.0e3, damping=0.8, half_play=0.004)
    path = train.continuation(parameter="coupling 1 half_play", start=0.002, stop=0.006, frequency=0.48, harmonics=16)
    assert path.ended.startswith("reached") and path.parameter[-1] == pytest.approx(0.006)
    motion = train.response(start=0.47, stop=0.49, harmonics=20).at(0.48)[0]
    assert motion.separation_fraction[1] > 0.05
    names = ["coupling 1 stiffness", "coupling 1 half_play", "coupling * damping"]
    slopes = motion.gradient("rms", names)
    for place, (name, value) in enumerate(zip(names, (3.0e3, 0.004, 0.8))):
        step = 1e-3 * value
        sides = []
        for sign in (1, -1):
            other = replace(train, couplings=[replace(train.couplings[0], **{name.split()[-1]: value + sign * step})])
            sides.append(other.response(start=0.47, stop=0.49, harmonics=20).at(0.48)[0].rms)
        assert slopes[:, place] == pytest.approx((sides[0] - sides[1]) / (2 * step), rel=1e-4)
    by_corner = driveline(damping=0.8, **BENT)
    motion = by_corner.response(start=0.24, stop=0.26, harmonics=20).at(0.25)[0]
    assert np.isfinite(motion.gradient("rms", ["coupling 1 torque 4", "coupling 1 angle 3"])).all()


@pytest.mark.full
def test_loci():
    """The resonance's fold and the onset of play over numbers of a coupling: points of the branches of other trains."""
    train = driveline(swing=80.0, stiffness=3.0e3, damping=0.8, half_play=0.004)
    branch = train.response(start=0.3, stop=0.7, harmonics=24)
    fold = next(point for point in branch.special_points if point.kind == "fold")
    for name, value, other in (("half_play", 0.004, 0.0045), ("stiffness", 3.0e3, 3.1e3)):
        parameter = f"coupling 1 {name}"
        locus = train.locus(fold, parameter=parameter, start=value, stop=other)
        changed = replace(train, couplings=[replace(train.couplings[0], **{name: other})])
        folds = [point.exact().frequency for point in changed.response(start=0.3, stop=0.7, harmonics=24).special_points
                 if point.kind == "fold"]
        assert locus.parameter[-1] == pytest.approx(other, rel=1e-9)
        assert np.abs(np.array(folds) - locus.frequency[-1]).min() < 1e-8 * locus.frequency[-1]


def test_files_and_pictures(tmp_path):
    train = driveline(2, damping=0.5, **STAGES)
    branch = train.response(start=0.2, stop=0.22, harmonics=12)
    path = tmp_path / "couplings.h5"
    branch.write(path)
    read = gt.read_results(path)
    assert read.response.coupling_torque_maximum.shape == (len(branch), 2)
    assert (read.response.coupling_torque_maximum == branch.coupling_torque_maximum).all()
    assert [coupling.torque for coupling in read.response.train.couplings] == [tuple(STAGES["torque"])] * 2
    assert train.mesh_labels == ("pinion - wheel", "engine - hub 1", "hub 1 - pinion")
    assert train.explain()["coupling 1"]["mean_torque"] == pytest.approx(30.0)
    assert train.explain()["coupling 2"]["half_play"] == pytest.approx(0.004)
    assert "coupling 1" in str(train.explain())
    assert {joint.element for joint in joints_of(train)} >= {"coupling 1", "coupling 2"}
    run_up = train.run_up(start=0.2, stop=0.25, duration=1.0)
    assert run_up.coupling_torque.shape == (len(run_up.time), 2)
    assert run_up.coupling_torque == pytest.approx(run_up.mesh_force[:, 1:])


def test_gears_of_the_drawing():
    """Speeds pass through couplings; without gears Lambda is the speed in rpm."""
    train = gt.Train(
        bodies=[gt.Body(name="engine", inertia=0.1, torque=30.0, revolution_torque_cos=[0, 20.0]), gt.Body(name="pinion"),
                gt.Body(name="wheel", inertia=0.1, balances=True)],
        couplings=[gt.Coupling(between=("engine", "pinion"), damping=0.5, **STAGES)],
        meshes=[gt.Mesh(between=("pinion", "wheel"), teeth=(20, 40), normal_module=2e-3, face_width=0.02, damping_ratio=0.05,
                        backlash=50e-6)],
    )
    assert train.explain()["engine"]["turns"] == train.explain()["pinion"]["turns"] == 1
    alone = gt.Train(
        bodies=[gt.Body(name="engine", inertia=0.1, torque=30.0, revolution_torque_cos=[0, 20.0]),
                gt.Body(name="vehicle", inertia=0.4, balances=True)],
        couplings=[gt.Coupling(between=("engine", "vehicle"), damping=2.0, **STAGES)],
    )
    branch = alone.response(start=300.0, stop=320.0, unit="rpm", harmonics=16)
    assert branch.speed[0] == pytest.approx(300.0)
    assert branch.fundamental_frequency[0] == pytest.approx(5.0)  # a turn


# What is refused


@pytest.mark.parametrize("given, told", [
    ({}, "lacks stiffness (> 0 N m/rad) or angle and torque"),
    ({"stiffness": 100.0, **BENT}, "contradicts angle and torque"),
    ({"angle": [0.0, 1.0]}, "lacks torque"),
    ({"angle": [0.0, 1.0, 2.0], "torque": [-1.0, 1.0]}, "must be as many as angle"),
    ({"angle": [-1.0, 1.0, 0.5], "torque": [-1.0, 1.0, 2.0]}, "must be > 1.0, the angle before it"),
    ({"angle": [-1.0, 0.0, 1.0, 2.0], "torque": [-1.0, 2.0, 1.0, 3.0]}, "a load has several rests"),
    ({"angle": [-1.0, 0.0, 1.0, 2.0], "torque": [-1.0, 2.0, 2.0, 3.0]}, "only a play, of torque 0, has no slope"),
    ({"angle": [-1.0, 0.0, 1.0], "torque": [-1.0, 0.0, 0.0]}, "bears a load of either sign"),
])
def test_refusals(given, told):
    with pytest.raises(gt.InputError, match=re.escape(told)):
        rotor(5.0, **given)


def test_strained_loops_are_refused():
    between = ("engine", "pinion")
    with pytest.raises(gt.InputError, match="the coupling is part of a loop"):
        replace(driveline(stiffness=1e3), couplings=[gt.Coupling(between=between, stiffness=1e3),
                                                     gt.Coupling(between=between, angle=[0.01, 0.02], torque=[-1.0, 9.0])])


def test_a_chain_has_no_couplings():
    with pytest.raises(gt.InputError, match="there is no &body"):
        gt.Train(input_torque=1.0, prime_mover_inertia=1.0, load_inertia=1.0, shafts=[gt.Shaft(stiffness=1.0)] * 2,
                 couplings=[gt.Coupling(between=("a", "b"), stiffness=1.0)])


def test_stages_of_two_digits_are_reached():
    """Stages are numbered from the play to both sides; their names are whole, also where shooting finds them again."""
    angle = 1e-3 * np.arange(1, 15)
    torque = np.append(0.0, np.cumsum(1 + 0.01 * np.arange(13)))
    train = gt.Train(
        bodies=[gt.Body(name="a", inertia=0.01, torque=-3.5, torque_cos=[2.5]), gt.Body(name="b", inertia=0.05, balances=True)],
        couplings=[gt.Coupling(between=("a", "b"), angle=[*-angle[::-1], *angle], torque=[*-torque[::-1], *torque],
                               damping_ratio=0.06)],
        characteristic_length=1e-6, characteristic_frequency=300.0)
    branch = train.response(start=0.8, stop=1.1, harmonics=8)
    kinds = {onset.kind for onset in branch.onsets}
    # The largest and smallest twist, 1 um for 1 mrad, passed these corners.
    low, high = -branch.minimum.min(), branch.maximum.max()
    assert 13 < low and 12 < high
    assert {f"stage -{number} reached" for number in range(10, 14)} <= kinds
    assert {f"stage {number} reached" for number in range(2, 13)} <= kinds
    onset = next(onset for onset in branch.onsets if onset.kind == "stage -12 reached")
    exact = onset.exact()
    assert exact.kind == onset.kind and exact.motion.minimum[0] == pytest.approx(-12.0, rel=1e-8)
