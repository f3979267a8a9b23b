"""Lyapunov spectra, rotation numbers and bifurcation diagrams against closed forms and multipliers."""

from dataclasses import fields, replace

import numpy as np
import pytest
from conftest import equal_stages, equal_wheels, paper_train, single_pair
from random_trains import random_train

import geartrain as gt

pytestmark = pytest.mark.full


def soft_train():
    """Figure 4's with k3 = 5e5 N m/rad, where pairs of multipliers leave the unit circle near sums of natural frequencies."""
    return paper_train(shafts=[gt.Shaft(stiffness=stiffness, damping_ratio=0.01) for stiffness in (1e3, 5e5, 1e3)])


def linear(train):
    """The train without backlash at constant stiffness."""
    return replace(train, meshes=[replace(mesh, half_backlash=0.0, stiffness_cos=None) for mesh in train.meshes])


def exponents_of(motion):
    """ln|multiplier| over the period, largest first."""
    return np.sort(np.log(np.abs(motion.multipliers)))[::-1] * motion.frequency / (2 * np.pi * motion.period)


def test_a_linear_pair_has_the_real_parts_of_its_eigenvalues():
    """x'' + 0.1 x' + x = 0.4: both are -0.05."""
    found = linear(single_pair(0.4, stiffness_cos=[0.3])).lyapunov_spectrum(0.8, periods=1000)
    assert found.exponents == pytest.approx([-0.05, -0.05], rel=1e-10)
    assert found.exponents.sum() == pytest.approx(-0.1, rel=1e-12)
    assert found.kind == "periodic" and found.period == 1 and found.dimension == 0


def test_a_linear_train_has_those_of_its_multipliers():
    """Two modes lie next to each other: their tangents part slowly, and averages would have an error of 1e-4."""
    train = linear(paper_train())
    found = train.lyapunov_spectrum(0.9, periods=1000)
    exact = exponents_of(train.integrate(0.9))
    assert found.exponents == pytest.approx(exact, rel=1e-9)
    assert found.exponents.sum() == pytest.approx(exact.sum(), rel=1e-11)


@pytest.mark.parametrize("periods", [40, 1000])
@pytest.mark.parametrize(("frequency", "period"), [(0.7, 1), (1.92, 2)])
def test_a_periodic_motion_has_those_of_its_multipliers(frequency, period, periods):
    """The number of periods does not matter, since the exponents are no averages over them."""
    train = paper_train()
    found = train.lyapunov_spectrum(frequency, periods=periods, transient=1000)
    motion = train.integrate(frequency, start=found.state)
    assert found.period == motion.period == period
    assert found.exponents == pytest.approx(exponents_of(motion), rel=1e-7)
    assert (np.abs(found.exponents - exponents_of(motion)) < found.errors).all() and found.errors.max() < 1e-6


def test_a_transient_within_the_average_is_left_out():
    """From rest the flow stays with a chaotic saddle, of exponent 0.037, until period 2800."""
    train = soft_train()
    through, after = train.lyapunov_spectrum(2.49), train.lyapunov_spectrum(2.49, transient=4000)
    assert through.kind == after.kind == "chaotic"
    assert after.errors[0] < 2e-3 and through.errors[0] < 2e-3
    assert abs(through.exponents[0] - after.exponents[0]) < np.hypot(through.errors[0], after.errors[0])
    assert through.exponents.sum() == pytest.approx(after.exponents.sum(), rel=1e-9)


def test_chaos():
    """The sum is the mean of the divergence (Liouville), that of the linear train; the largest is `Train.integrate`'s."""
    train = soft_train()
    found = train.lyapunov_spectrum(2.49, transient=4000, periods=4000)
    assert found.kind == "chaotic" and 1 < found.dimension < 2
    assert found.exponents.sum() == pytest.approx(exponents_of(linear(train).integrate(2.49)).sum(), rel=1e-9)
    by_flow = train.integrate(2.49, max_periods=3000)
    assert by_flow.kind == "chaotic"
    assert abs(found.exponents[0] - by_flow.lyapunov_exponent) < found.errors[0] + by_flow.lyapunov_error


def test_the_rotation_number_begins_with_the_angle_of_the_multipliers():
    """A torus leaves the motion of period 1 at a Neimark-Sacker point; its rotation number goes to the angle over 2 pi there."""
    train = soft_train()
    response = train.response(start=2.29, stop=2.33)
    point = next(special for special in response.special_points if special.kind == "neimark-sacker")
    multipliers = response.at(point.frequency)[0].refine().multipliers
    angle = np.abs(np.angle(multipliers[np.abs(multipliers).argmax()])) / (2 * np.pi)
    diagram = train.bifurcation_diagram(start=2.309, stop=2.295, points=8, direction="down", transient=8000, sections=3000)
    assert set(diagram.kind) == {"quasi-periodic"}
    fit = np.polyfit(diagram.frequency - point.frequency, diagram.rotation_number, 2)
    assert fit[-1] == pytest.approx(angle, abs=5e-6)
    assert (np.abs(diagram.lyapunov_exponents[:, 0]) < 1e-4).all()


def test_the_rotation_number_is_the_line_of_the_sections():
    """The largest line of their Fourier transform, with Hann's window, made sharper by a search for its top: to 1e-8."""
    found = soft_train().lyapunov_spectrum(2.305, transient=8000, periods=4096)
    assert found.kind == "quasi-periodic"
    samples = np.arange(4096)
    for values in found.displacement.T:
        windowed = (values - values.mean()) * (1 - np.cos(2 * np.pi * samples / 4096))
        rate, step = np.abs(np.fft.rfft(windowed)).argmax() / 4096, 0.5 / 4096
        for _ in range(16):
            rates = rate + step * np.linspace(-1, 1, 5)
            heights = np.abs(np.exp(-2j * np.pi * rates[:, None] * samples) @ windowed)
            rate, step = rates[heights.argmax()], step / 2
        assert found.rotation_number == pytest.approx(rate, abs=1e-8)


@pytest.mark.nightly
def test_neighbouring_flights_part_at_the_largest_exponent():
    """Two flights, without tangents, brought back to a distance of 1e-7 every four periods."""
    train = soft_train()
    found = train.lyapunov_spectrum(2.49, transient=4000, periods=8000)
    state, apart = found.state, np.full(10, 1e-7 / np.sqrt(10))
    rates = []
    for _ in range(400):
        ends = [train.integrate(2.49, start=start, max_periods=4, stability=False).state for start in (state, state + apart)]
        distance = np.linalg.norm(ends[1] - ends[0])
        rates.append(np.log(distance / 1e-7) * 2.49 / (2 * np.pi * 4))
        state, apart = ends[0], (ends[1] - ends[0]) * 1e-7 / distance
    blocks = np.reshape(rates[80:], (20, -1)).mean(axis=1)
    error = 2 * blocks.std(ddof=1) / np.sqrt(20)
    assert abs(blocks.mean() - found.exponents[0]) < error + found.errors[0] and blocks.mean() > error


def test_attractors_without_a_period():
    """Two chaotic attractors at one speed, each with its share; the flow from the state of each stays on it."""
    train = soft_train()
    found = train.attractors(2.3, starts=8, max_periods=1000)
    assert found.unsettled + sum(motion.share for motion in found) == pytest.approx(1)
    assert [(motion.period, motion.kind) for motion in found] == [(0, "chaotic")] * 2
    for motion in found:
        later = train.lyapunov_spectrum(2.3, start=motion, transient=2000)
        assert later.kind == "chaotic"
        assert abs(later.exponents[0] - motion.lyapunov_exponent) < 2 * (later.errors[0] + motion.lyapunov_error)


def test_a_diagram_up_and_down(tmp_path):
    """Figure 3's jumps: what a sweep reaches at 0.6 depends on where it comes from; rows as `Train.sweep` finds them."""
    train = paper_train()
    diagram = train.bifurcation_diagram(start=0.4, stop=0.8, points=3, transient=200, sections=40)
    motions = train.sweep(start=0.4, stop=0.8, points=3, direction="both")
    assert diagram.direction == motions.direction
    assert diagram.frequency == pytest.approx(motions.frequency)
    assert diagram.final_state == pytest.approx(np.array([motion.state for motion in motions]), abs=1e-4)
    assert (diagram.period == 1).all()
    pytest.importorskip("matplotlib")
    assert len(diagram.plot(mesh=2).get_lines()) == 2
    with pytest.raises(gt.InputError, match="what = 'state'"):
        diagram.plot(what="state")
    text = train.namelist(bifurcation_diagram={"start": 0.4, "stop": 0.8, "points": 3, "transient": 200, "sections": 40})
    (tmp_path / "case.nml").write_text(text)
    results = gt.read_case(tmp_path / "case.nml").run()
    results.write(tmp_path / "case.h5")
    again = gt.read_results(tmp_path / "case.h5").bifurcation_diagram
    assert (again.displacement == diagram.displacement).all() and again.kind == diagram.kind
    assert diagram.to_dataset()["displacement"].dims == ("point", "section", "mesh")


def test_events_of_equal_stages_at_one_instant():
    # From a state that is the same for both stages but for rounding, both meet their walls together.
    train = equal_stages(0.3)
    branch = train.response(start=0.7, stop=1.1, harmonics=12)
    point = next(special for special in branch.special_points if special.kind == "neimark-sacker").exact()
    found = train.bifurcation_diagram(start=0.88, stop=0.88, points=1, direction="up", transient=3000, seed=point.motion)
    # The motion of the branch is stable there, and next to the Neimark-Sacker point, so it is come near to slowly.
    assert found.kind[0] == "still settling" and np.ptp(found.displacement[0, :, 0]) < 1e-2


def test_what_it_refuses():
    with pytest.raises(gt.InputError, match="periods = 5: must be"):
        paper_train().lyapunov_spectrum(0.7, periods=5)
    with pytest.raises(gt.InputError, match="start = 'x': must be"):
        paper_train().lyapunov_spectrum(0.7, start="x")
    with pytest.raises(gt.InputError, match="lyapunov_spectrum: periods = 0: must be"):
        paper_train().lyapunov_spectrum(0.7, periods=0)
    with pytest.raises(gt.InputError, match="points = 1: must be 2 or more"):
        paper_train().bifurcation_diagram(start=0.7, stop=0.8, points=1)
    with pytest.raises(gt.InputError, match="points"):
        paper_train().bifurcation_diagram(start=0.7, stop=0.7)


def test_rotation_number_of_a_torus_about_a_motion_of_period_2():
    """Its sections go to and fro between two curves, half a turn a period; on each curve they go round by the second frequency."""
    train = equal_wheels()
    doubled = train.response(start=1.2, stop=2.4, harmonics=20, period_doublings=1).branches[0]
    for near, beside in ((2.0946, -2e-3), (1.6139, 2e-3)):
        special = min((special for special in doubled.special_points if special.kind == "neimark-sacker"),
                      key=lambda special: abs(special.frequency - near)).exact()
        found = train.lyapunov_spectrum(special.frequency + beside, start=special.motion, periods=4000)
        assert found.kind == "quasi-periodic"
        # The angle of the pair is that of two periods.
        assert found.rotation_number == pytest.approx(abs(np.angle(special.multipliers[0])) / (4 * np.pi), abs=1e-3)
        # Independently, the highest line of every second section, between its neighbours.
        values = found.displacement[::2, 0]
        height = np.log(np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)))))
        k = 1 + height[1:-1].argmax()
        between = (height[k - 1] - height[k + 1]) / (2 * (height[k - 1] - 2 * height[k] + height[k + 1]))
        assert found.rotation_number == pytest.approx((k + between) / len(values) / 2, abs=1e-5)


def ringing(seed):
    """A random train of little damping, at times on springs to ground, a frequency, and how many periods are looked at."""
    rng = np.random.default_rng(seed)
    train = random_train(rng)
    while train.characteristic_frequency is None:
        train = random_train(rng)
    little = 10.0 ** rng.uniform(-3.0, -0.5)
    bodies = [{field.name: getattr(body, field.name) for field in fields(body)} for body in train.bodies]
    for body in bodies:
        if rng.random() < 0.2:
            rate = 10.0 ** rng.uniform(1.5, 4.0)
            body["stiffness_to_ground"] = body["inertia"] * rate**2
            body["damping_to_ground"] = 2 * 10.0 ** rng.uniform(-4.0, -2.0) * body["inertia"] * rate
    if any(body["stiffness_to_ground"] for body in bodies):
        bodies = [{**body, "balances": False} for body in bodies]
    train = replace(train, bodies=[gt.Body(**body) for body in bodies],
                    shafts=[replace(shaft, damping_ratio=shaft.damping_ratio * little) for shaft in train.shafts],
                    meshes=[replace(mesh, damping_ratio=mesh.damping_ratio * little) for mesh in train.meshes])
    return train, rng.uniform(0.3, 2.0), int(rng.integers(60, 400))


def kinds_of(seed):
    """Kinds of a flight and of one fifty times as long, where the exponent of the first may be 0; else None."""
    train, frequency, periods = ringing(seed)
    try:
        found = train.lyapunov_spectrum(frequency, transient=periods // 2, periods=periods)
        span = 2 * np.pi / frequency
        if found.period or abs(found.exponents[0]) > found.errors[0] or found.errors[0] * span > 2e-3:
            return None
        return found.kind, train.integrate(frequency, start=found.state, max_periods=50 * periods, stability=False).kind
    except (gt.InputError, gt.SolverError):
        return None


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
@pytest.mark.parametrize("seed", [11, 19, 115, 119, 120, 136, 201, 207, 211, 228, 285, 324])
def test_a_vibration_that_dies_out_is_no_torus(seed):
    """By its exponent alone each of these flights, which settle in the end, would be on a torus."""
    assert kinds_of(seed) == ("still settling", "periodic")


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_more_vibrations_that_die_out(request):
    """Beats longer than a flight hide that it dies out: one in ten at most."""
    first = 1000 * (1 + request.config.getoption("--seed"))
    settle = [kinds[0] for seed in range(first, first + 400) if (kinds := kinds_of(seed)) and kinds[1] == "periodic"]
    assert len(settle) >= 5 and settle.count("quasi-periodic") <= max(1, len(settle) / 10), settle


def test_tangents_that_grow_for_a_while_are_no_chaos():
    """From rest the flight comes to a torus. Two flights from there, 1e-7 apart, stay together; in chaos they would part."""
    train, frequency = soft_train(), 2.297
    assert train.integrate(frequency).kind == "quasi-periodic"
    state = train.lyapunov_spectrum(frequency, transient=4000, periods=100).state
    ends = [train.integrate(frequency, start=start, max_periods=1000, stability=False).state for start in (state, state + 1e-7)]
    assert np.abs(ends[1] - ends[0]).max() < 1000 * 1e-7


def test_a_vibration_that_grows_slowly_is_no_torus_yet():
    """Just beyond a Neimark-Sacker point the flight leaves the repelling motion of period 2 for a torus that is far off."""
    train = equal_wheels()
    doubled = train.response(start=1.2, stop=2.4, harmonics=20, period_doublings=1).branches[0]
    special = min((special for special in doubled.special_points if special.kind == "neimark-sacker"),
                  key=lambda special: abs(special.frequency - 1.6139)).exact()
    sizes, kinds = [], []
    for transient in (1300, 12000):
        found = train.lyapunov_spectrum(special.frequency + 3.5e-4, start=special.motion, transient=transient, periods=330)
        sizes.append([np.ptp(found.displacement[part:part + 110:2, 0]) for part in (0, 220)])
        kinds.append(found.kind)
    assert sizes[0][1] > 1.1 * sizes[0][0] and sizes[1][1] == pytest.approx(sizes[1][0], rel=0.03)
    assert kinds == ["still settling", "quasi-periodic"]
