"""Points of a curve at which two conditions meet, by the trains beside them alone: their branches, exact points and multipliers."""

import numpy as np
import pytest
from conftest import equal_stages, equal_wheels, paper_train, unlike_pairs
from test_lyapunov import soft_train

import geartrain as gt
from paper_cases import paper_case

pytestmark = pytest.mark.full


def nearest(branch, kind, frequency):
    """The exact special point of a kind nearest to a frequency."""
    of_kind = [special for special in branch.special_points if special.kind == kind]
    return min(of_kind, key=lambda special: abs(special.frequency - frequency)).exact()


def of_name(locus, kind, frequency):
    return next(point for point in locus.special_points if point.kind == kind and abs(point.frequency - frequency) < 1e-3)


def beside(train, point, kind, **response):
    """The exact special point of the train with the value of a point of a curve: it is at the Lambda of that point."""
    other = train.with_values({"stiffness_variation": point.parameter})
    found = nearest(other.response(**response), kind, point.frequency)
    assert found.frequency == pytest.approx(point.frequency, abs=1e-9)
    return found


def distance(multipliers, value):
    return np.sort(abs(multipliers - value))


def test_isola_centre():
    # Figure 9's island (test_exact.py): its width goes to 0 as the square root of the distance from the centre.
    train = paper_train().with_values({"mesh * damping_ratio": 0.01})
    state = [0.01254298, -2.27472542, -0.08825069, -6.79887307, -0.10168407,
             0.11287488, 2.11040707, 0.0276462, -1.9129191, 0.30859615]
    island = train.response(start=0.7, stop=0.9, seed=train.integrate(frequency=0.85, start=state), harmonics=12)
    locus = train.locus(nearest(island, "fold", 0.744), parameter="mesh * damping_ratio", start=0.01, stop=0.03)
    centre = of_name(locus, "isola centre", 0.8466)
    at = abs(locus.parameter - centre.parameter).argmin()
    squares, values = [], centre.parameter - np.array([4e-5, 1e-5])
    for value in values:
        other = train.with_values({"mesh * damping_ratio": value})
        seed = other.integrate(frequency=centre.frequency, start=locus.initial_state[at])
        branch = other.response(start=0.8, stop=0.9, seed=seed, harmonics=24)
        folds = [special.exact().frequency for special in branch.special_points if special.kind == "fold"]
        squares.append(np.ptp(folds) ** 2)
    zero = values[1] + (values[1] - values[0]) * squares[1] / (squares[0] - squares[1])
    assert zero == pytest.approx(centre.parameter, abs=1e-7)


def test_fold_flip():
    train = paper_case("fig07_042").train
    fold = nearest(train.response(start=0.2, stop=0.8, harmonics=12), "fold", 0.5656)
    locus = train.locus(fold, parameter="stiffness_variation", start=0.3, stop=0.55)
    point = of_name(locus, "fold-flip", 0.54579)
    for kind in ("fold", "period doubling"):
        found = beside(train, point, kind, start=0.2, stop=0.8, harmonics=12)
        assert distance(found.multipliers, 1)[0] < 1e-8
        assert distance(found.multipliers, -1)[0] < 1e-8


def test_one_to_one_resonance():
    train = paper_train()
    fold = nearest(train.response(start=0.2, stop=1.0, harmonics=12), "fold", 0.73187)
    locus = train.locus(fold, parameter="stiffness_variation", start=0.28, stop=0.35)
    point = of_name(locus, "1:1 resonance", 0.75592)
    found = beside(train, point, "fold", start=0.2, stop=1.0, harmonics=12)
    # Two of one eigenvector, which the root of an error parts.
    assert distance(found.multipliers, 1)[1] < 1e-5


def test_generalized_doubling():
    train = paper_train()
    doubling = nearest(train.response(start=1.7, stop=1.9), "period doubling", 1.7492)
    locus = train.locus(doubling, parameter="mesh 1 damping_ratio", start=0.05, stop=0.1)
    point = of_name(locus, "generalized doubling", 1.77417)
    for change in (-1e-4, 1e-4):
        other = train.with_values({"mesh 1 damping_ratio": point.parameter + change})
        found = nearest(other.response(start=1.7, stop=1.9), "period doubling", point.frequency)
        assert found.criticality == ("supercritical" if change < 0 else "subcritical")


def test_neimark_sacker_and_one_to_four_resonance():
    train = soft_train()
    special = nearest(train.response(start=2.29, stop=2.33), "neimark-sacker", 2.31)
    locus = train.locus(special, parameter="shaft 2 stiffness", start=2e5, stop=2e6)
    point = of_name(locus, "1:4 resonance", 2.27781)
    other = train.with_values({"shaft 2 stiffness": point.parameter})
    found = nearest(other.response(start=point.frequency - 0.02, stop=point.frequency + 0.02), "neimark-sacker", point.frequency)
    assert found.frequency == pytest.approx(point.frequency, abs=1e-9)
    assert distance(found.multipliers, 1j)[0] < 1e-8


@pytest.mark.nightly
def test_one_to_three_resonance():
    def neimark_sacker(train, frequency):
        response = train.response(start=0.2, stop=2.6, harmonics=12, period_doublings=2)
        return min((special for branch in response.branches if branch.subharmonic == 4 for special in branch.special_points
                    if special.kind == "neimark-sacker"), key=lambda special: abs(special.frequency - frequency)).exact()

    train = paper_train()
    locus = train.locus(neimark_sacker(train, 1.47262), parameter="stiffness_variation", start=0.255, stop=0.305)
    point = of_name(locus, "1:3 resonance", 1.4954)
    found = neimark_sacker(train.with_values({"stiffness_variation": point.parameter}), point.frequency)
    assert found.frequency == pytest.approx(point.frequency, abs=1e-10)
    assert np.sort(np.angle(found.critical)) == pytest.approx([-2 * np.pi / 3, 2 * np.pi / 3], abs=1e-7)


@pytest.mark.nightly
def test_one_to_two_resonance():
    numbers = ((0.00165, 0.028, 386e6, 0.0284, 34.5e-6, 0.343), (0.00149, 0.02, 183e6, 0.0622, 32.7e-6, 0.154),
               (0.00209, 0.0468, 225e6, 0.0601, 57.4e-6, 0.322))
    train = gt.Train(
        input_torque=121.0, prime_mover_inertia=2.3e-7, load_inertia=2.3e-7, characteristic_length=30e-6,
        characteristic_frequency=9870.0,
        shafts=[gt.Shaft(stiffness=stiffness, damping_ratio=0.01) for stiffness in (1e3, 8.61e6, 6.48e6, 1e3)],
        meshes=[gt.Mesh(driving_radius=0.05, driven_radius=0.1, driving_inertia=driving, driven_inertia=driven, stiffness=stiffness,
                        damping_ratio=damping, half_backlash=gap, stiffness_cos=[kappa])
                for driving, driven, stiffness, damping, gap, kappa in numbers],
    )
    doubling = nearest(train.response(start=1.18, stop=1.38, harmonics=24), "period doubling", 1.2562)
    locus = train.locus(doubling, parameter="stiffness_variation", start=0.154, stop=0.57)
    point = of_name(locus, "1:2 resonance", 1.279)
    found = beside(train, point, "period doubling", start=1.18, stop=1.38, harmonics=24)
    # Two of one eigenvector, which the root of an error parts.
    assert distance(found.multipliers, -1)[1] < 1e-5 < distance(found.multipliers, -1)[2]


def test_a_neimark_sacker_curve_ends_where_its_pair_becomes_real():
    """In the 1:1 resonance of the fold's curve, and does not go on along motions whose pair is real with the product 1."""
    train = unlike_pairs()
    branch = train.response(start=0.8, stop=1.3, harmonics=20)
    torus = train.locus(nearest(branch, "neimark-sacker", 1.037027), parameter="one torque", start=-150.0, stop=400.0)
    fold = train.locus(nearest(branch, "fold", 1.03883), parameter="one torque", start=100.0, stop=140.0)
    assert torus.ended == "a 1:1 resonance" and {point.kind for point in torus.special_points} == {"1:1 resonance"}
    point = of_name(fold, "1:1 resonance", 1.03849)
    assert of_name(torus, "1:1 resonance", 1.03849).parameter == pytest.approx(point.parameter, abs=1e-6)
    for multipliers in torus.multipliers[1:-1]:
        pair = multipliers[multipliers.imag > 0]
        assert np.abs(np.abs(pair) - 1).min() < 1e-6


def test_a_fold_goes_on_beyond_grazings(times):
    """Where mesh 2 comes to the wall at the less deep of its minima: the curve has a corner, and goes on with two events more."""
    train = paper_train()

    def fold_at(value, expected):
        other = train.with_values({"stiffness_variation": value})
        return other, nearest(other.response(start=0.36, stop=0.5, harmonics=24), "fold", expected)

    _, fold = fold_at(0.3, 0.462118423)
    locus = train.locus(fold, parameter="stiffness_variation", start=0.2, stop=0.48)
    kinds = ["cusp", "grazing on a fold", "grazing on a fold"]
    assert locus.complete and sorted(point.kind for point in locus.special_points) == kinds
    first, second = sorted((point for point in locus.special_points if point.kind != "cusp"), key=lambda point: point.parameter)
    # The parameter at which the minimum of the exact motion at the fold is the half backlash, by a parabola through three trains.
    for grazing, beside in ((first, (0.325, 0.326, 0.327)), (second, (0.4738, 0.4741, 0.4743))):
        over_the_wall, frequencies = [], []
        for value in beside:
            _, exact = fold_at(value, grazing.frequency)
            wave = exact.motion.waveform(1 << 14)[1][:, 1]
            least = np.flatnonzero((wave < np.roll(wave, 1)) & (wave < np.roll(wave, -1)))
            one = least[np.argmin(abs(wave[least] - 1))]
            before, at, after = wave[one - 1], wave[one], wave[(one + 1) % len(wave)]
            over_the_wall.append(at - (before - after) ** 2 / (8 * (before - 2 * at + after)) - 1)
            frequencies.append(exact.frequency)
        assert np.polyval(np.polyfit(over_the_wall, beside, 2), 0) == pytest.approx(grazing.parameter, abs=1e-7)
        assert np.polyval(np.polyfit(over_the_wall, frequencies, 2), 0) == pytest.approx(grazing.frequency, abs=1e-7)
    # Beyond the first: folds of other trains, whose curves are the same one.
    cusp = next(point for point in locus.special_points if point.kind == "cusp")
    beyond = slice(first.point + 2, None) if cusp.point < first.point else slice(first.point - 1, None, -1)
    for value in (0.34, 0.4, 0.45)[:times(3)]:
        expected = np.interp(value, locus.parameter[beyond], locus.frequency[beyond])
        other, found = fold_at(value, expected)
        assert found.frequency == pytest.approx(expected, abs=2e-4)
        again = other.locus(found, parameter="stiffness_variation", start=0.2, stop=0.48)
        assert again.frequency[[0, -1]].min() == pytest.approx(locus.frequency[[0, -1]].min(), abs=1e-9)
        assert again.complete
        assert again.frequency[[0, -1]].max() == pytest.approx(locus.frequency[[0, -1]].max(), abs=1e-9)


@pytest.mark.nightly
def test_a_fold_of_period_2_ends_where_its_motions_become_those_of_period_1():
    """At the generalized doubling of the period doubling's own curve; beyond are the same motions half a period later."""
    response = paper_case("fig07_042").train.response(
        start=0.3, stop=1.0, harmonics=12, period_doublings=1)
    doubling = nearest(response, "period doubling", 0.846318)
    locus = response.train.locus(doubling, parameter="stiffness_variation", start=0.3, stop=0.5)
    point = of_name(locus, "generalized doubling", 0.854313)
    branch = next(branch for branch in response.branches if branch.subharmonic == 2 and any(
        special.kind == "fold" and abs(special.frequency - 0.75247) < 1e-4 for special in branch.special_points))
    locus = response.train.locus(nearest(branch, "fold", 0.75247), parameter="stiffness_variation", start=0.3, stop=0.5)
    assert "a generalized doubling" in locus.ended
    met = of_name(locus, "generalized doubling", 0.854313)
    assert (met.frequency, met.parameter) == pytest.approx((point.frequency, point.parameter), abs=1e-7)

    def change_after_half(point):
        train = response.train.with_values({"stiffness_variation": locus.parameter[point]})
        half = train.integrate(locus.frequency[point], start=locus.initial_state[point], max_periods=1, stability=False)
        return abs(locus.initial_state[point] - half.state).max()

    last = abs(locus.parameter - met.parameter).argmin()
    assert change_after_half(last) < 0.1 * change_after_half(len(locus) // 2)


@pytest.mark.nightly
def test_a_curve_of_branch_points_goes_on_where_newton_goes_astray():
    """In a long step to what is no orbit: of stages that are mirror images neither torque nor shaft breaks the symmetry.

    Without errors a branch point stays where it is over the torque.
    """
    mesh = dict(driving_radius=1.0, driven_radius=1.0, stiffness=1.3933760886091309, damping_ratio=0.01861234792942396,
                half_backlash=1.0, stiffness_cos=0.20607421185024558)
    inertias = (2.585323838427506, 2.244358458882325)
    meshes = [gt.Mesh(driving_inertia=one, driven_inertia=other, **mesh) for one, other in (inertias, inertias[::-1])]
    train = gt.Train(input_torque=0.21757680318455336, prime_mover_inertia=0.0, load_inertia=0.0, characteristic_length=1.0,
                     characteristic_frequency=1.0, meshes=meshes,
                     shafts=[gt.Shaft(rigid=True), gt.Shaft(stiffness=0.3963367526887096, damping=0.0), gt.Shaft(rigid=True)])
    branch = train.response(start=0.3, stop=0.45, harmonics=11)
    (point,) = [special for special in branch.special_points
                if special.kind == "branch point" and abs(special.frequency - 0.36336) < 2e-4]
    for start in (0.05, 0.1, 0.12):
        locus = train.locus(point, parameter="input_torque", start=start, stop=1.0)
        assert locus.complete and np.abs(locus.frequency - 0.363362903542).max() < 1e-10
    assert train.locus(point, parameter="shaft 2 stiffness", start=0.2, stop=4.0).closed


def test_a_branch_points_curve_ends_where_the_symmetry_does():
    """Over the torque both of two equal stages stay equal; over the damping of one of them they do not."""
    train = equal_stages(0.3)
    branch_point = nearest(train.response(start=0.7, stop=1.1, harmonics=12), "branch point", 0.914328)
    torque = train.locus(branch_point, parameter="input_torque", start=60.0, stop=140.0)
    assert torque.complete and len(torque) > 10
    damping = train.locus(branch_point, parameter="mesh 1 damping_ratio", start=0.04, stop=0.06)
    assert len(damping) == 1 and not damping.complete
    assert damping.ended == "the parameter breaks the symmetry, at Lambda = 0.914328"


def branch_point_of_period_2(stiffness_variation):
    branch = equal_wheels(stiffness_variation).response(start=1.2, stop=2.4, harmonics=20, period_doublings=1).branches[0]
    return nearest(branch, "branch point", 2.1)


def branch_point_in_opposite_phase(stiffness_variation):
    branch = equal_wheels(stiffness_variation, phase=np.pi).response(start=0.3, stop=1.3, harmonics=20)
    return nearest(branch, "branch point", 0.75)


def branch_point_beside_a_fold(stiffness_variation):
    """A fold is 5e-7 below it at 0.5."""
    branch = equal_wheels(stiffness_variation, phase=np.pi).response(start=0.6, stop=1.0, harmonics=20)
    return nearest(branch, "branch point", 0.693)


@pytest.mark.parametrize(
    ("find", "first", "stop", "symmetric"),
    [(branch_point_of_period_2, 0.3, 0.36, 1e-9), (branch_point_in_opposite_phase, 0.5, 0.6, 1e-9),
     (branch_point_beside_a_fold, 0.5, 0.51, 1e-7)])
def test_curves_of_branch_points_whose_symmetry_comes_with_a_shift(find, first, stop, symmetric):
    """Each wheel does what the other does half a period later; at the other end is the branch point of the train there."""
    begin, end = find(first), find(stop)
    for exact in (begin, end):
        one, other = exact.motion.waveform(512)[1].T
        np.testing.assert_allclose(np.roll(one, 256), other, atol=symmetric)
        assert distance(exact.multipliers, 1)[0] < 1e-9
    train = begin.motion.train
    locus = train.locus(begin, parameter="stiffness_variation", start=first, stop=stop)
    assert locus.complete and len(locus) > 5
    assert locus.frequency[-1] == pytest.approx(end.frequency, abs=1e-10)
    broken = train.locus(begin, parameter="mesh 1 damping_ratio", start=0.035, stop=0.045)
    assert len(broken) == 1 and broken.ended.startswith("the parameter breaks the symmetry")


def test_what_a_curve_cannot_begin_with():
    train = unlike_pairs()
    fold = nearest(train.response(start=0.8, stop=1.3, harmonics=20), "fold", 1.03883)
    with pytest.raises(gt.InputError, match=r"mesh \* damping_ratio.* more than one value"):
        train.locus(fold, parameter="mesh * damping_ratio", start=0.03, stop=0.06)
    with pytest.raises(gt.InputError, match="is of another train"):
        train.with_values({"one torque": 119.5}).locus(fold, parameter="one torque", start=100.0, stop=140.0)
    with pytest.raises(gt.InputError, match="must differ from the other end"):
        train.locus(fold, parameter="one torque", start=120.0, stop=120.0)
