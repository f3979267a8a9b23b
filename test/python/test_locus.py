"""Curves of special points over frequency and a number of the train, against closed forms and one-parameter results."""


import numpy as np
import pytest
from conftest import paper_train, single_pair

import geartrain as gt


@pytest.fixture(scope="module")
def pair():
    return single_pair(0.4, stiffness_cos=[0.3])


@pytest.fixture(scope="module")
def branch(pair):
    return pair.response(start=0.5, stop=2.4)


def of_kind(branch, kind):
    return [special for special in branch.special_points if special.kind == kind]


def hill(frequency, kappa, zeta, terms=20):
    """Hill's determinant of x'' + 2 zeta x' + (1 + kappa cos Lambda t) x = 0 for the multiplier -1, over its diagonal: exponents
    of e^(i (n + 1/2) Lambda t)."""
    order = np.arange(-terms, terms) + 0.5
    diagonal = 1 - (order * frequency) ** 2 + 2j * zeta * order * frequency
    beside = np.ones(2 * terms - 1) * kappa / 2
    return np.linalg.det((np.diag(diagonal) + np.diag(beside, 1) + np.diag(beside, -1)) / np.abs(diagonal)[:, None]).real


def test_boundary_of_mathieu(pair, branch):
    locus = pair.locus(of_kind(branch, "period doubling")[0], parameter="stiffness_variation", start=0.1, stop=0.5)
    assert locus.complete and locus.kind == "period doubling"
    assert list(locus.parameter[[0, -1]]) == [0.5, 0.5]
    # Both edges of the band, which meet at its tip at the least kappa.
    assert locus.frequency.min() < 1.8 and locus.frequency.max() > 2.1
    off = [distance_from_boundary(*point, 0.05) for point in zip(locus.frequency, locus.parameter)]
    assert max(off) < 1e-10


def distance_from_boundary(frequency, kappa, zeta):
    """Distance in kappa from the boundary of Mathieu's equation: the derivative over it vanishes nowhere there."""
    here, above, below = (hill(frequency, kappa + change, zeta) for change in (0, 1e-6, -1e-6))
    return abs(here / (above - below)) * 2e-6


def test_ends_where_motions_are_linear(pair):
    # Beyond its last grazing the motion of period 2 loses no contact; on the boundary of Mathieu's equation it has any amplitude.
    branch = pair.response(start=0.5, stop=2.4, period_doublings=1)
    (fold,) = [special for twice in branch.branches for special in of_kind(twice, "fold")]
    locus = pair.locus(fold, parameter="stiffness_variation", start=0.03, stop=0.5)
    assert not locus.complete and "linear motions, of any amplitude, near Lambda = 2.01" in locus.ended
    end = max((0, -1), key=lambda point: locus.frequency[point])
    assert distance_from_boundary(locus.frequency[end], locus.parameter[end], 0.05) < 1e-7
    last = locus.special_points[end]
    assert last.kind == "grazing on a fold" and abs(last.frequency - locus.frequency[end]) < 1e-9
    # It zigzags nowhere.
    steps = np.diff(locus.frequency)
    assert np.count_nonzero(steps[1:] * steps[:-1] < 0) <= 3


@pytest.mark.parametrize("start, complete", [(-0.4, False), (0.0, True)])
def test_torque_to_nothing(pair, branch, start, complete):
    # Without errors all motions scale with the torque, so that the fold stays; at 0 the mesh floats in its gap.
    fold = of_kind(branch, "fold")[0]
    locus = pair.locus(fold, parameter="input_torque", start=start, stop=0.8)
    assert locus.complete == complete and "vanishes" in locus.ended
    assert 0 < locus.parameter.min() < 1e-3 and locus.parameter.max() == 0.8
    assert np.abs(locus.frequency - locus.frequency[0]).max() < 1e-10
    assert not locus.special_points


def test_damping_from_nothing(pair, branch):
    for special in of_kind(branch, "fold"):
        locus = pair.locus(special, parameter="mesh 1 damping_ratio", start=0.0, stop=0.1)
        assert locus.complete and locus.parameter.min() == 0.0


def square_wave(kappa, terms):
    """Cosine amplitudes of 1 + kappa, half a period, and 1 - kappa, of terms 1 to `terms`."""
    return [4 * kappa / np.pi * (-1) ** (order // 2) / order if order % 2 else 0.0 for order in range(1, terms + 1)]


def meissner(frequency, kappa, zeta):
    """1 + sum + product of the multipliers of x'' + 2 zeta x' + (1 +- kappa) x = 0: 0 where one is -1."""
    half, matrix = np.pi / frequency, np.eye(2)
    for stiffness in (1 + kappa, 1 - kappa):
        omega = np.sqrt(stiffness - zeta**2)
        cos, sin = np.cos(omega * half), np.sin(omega * half) / omega
        matrix = np.exp(-zeta * half) * np.array([[cos + zeta * sin, sin], [-stiffness * sin, cos - zeta * sin]]) @ matrix
    return 1 + np.trace(matrix) + np.linalg.det(matrix)


def test_boundary_of_meissner():
    def distance(terms):
        """Lambda along the boundary of a wave of so many terms, and in kappa how far the closed form is from it."""
        pair = single_pair(0.4, stiffness_cos=square_wave(0.25, terms))
        doubling = of_kind(pair.response(start=1.6, stop=2.4, harmonics=12), "period doubling")[0]
        locus = pair.locus(doubling, parameter="stiffness_variation", start=0.1, stop=0.5)
        assert locus.complete
        off = []
        for frequency, kappa in zip(locus.frequency, np.pi / 4 * locus.parameter):
            here, above, below = (meissner(frequency, kappa + change, 0.05) for change in (0, 1e-6, -1e-6))
            off.append(here / (above - below) * 2e-6)
        return locus.frequency, np.array(off)

    # The terms left out, 25, 27, ... and 49, 51, ..., act by the square of their amplitudes over that of their order: as the third
    # power of 24 and 48. What the finer boundary is off is an eighth of what the coarser one is.
    (coarse, off), (fine, rest) = distance(24), distance(48)
    rising = np.argsort(coarse)
    eighth = np.interp(fine, coarse[rising], off[rising]) / 8
    assert max(abs(rest)) < 2e-7
    assert max(abs(rest - eighth)) < 1e-8


def test_fold_over_torque(pair, branch):
    first, second = (special.exact() for special in of_kind(branch, "fold"))
    # Without back contact p - b scales with the torque, and so no fold moves.
    locus = pair.locus(first, parameter="input_torque", start=0.1, stop=0.8)
    assert locus.complete
    assert locus.frequency == pytest.approx(first.frequency, abs=1e-11)
    # The second one stays until p reaches -b.
    locus = pair.locus(second, parameter="input_torque", start=0.1, stop=0.8)
    before = locus.parameter < 0.4 * 2 / (1 - second.motion.minimum[0])
    assert locus.frequency[before] == pytest.approx(second.frequency, abs=1e-10)
    grazing = [point for point in locus.special_points if point.kind == "grazing on a fold"]
    assert [point.parameter for point in grazing] == pytest.approx([0.4 * 2 / (1 - second.motion.minimum[0])], abs=1e-6)
    # Beyond it the curve goes on with back contact, to the fold of another response.
    assert locus.complete
    other = pair.with_values({"input_torque": 0.8}).response(start=0.6, stop=1.0)
    found = [special.exact() for special in of_kind(other, "fold")]
    met = min(found, key=lambda special: abs(special.frequency - locus.frequency[-1]))
    assert met.frequency == pytest.approx(locus.frequency[-1], abs=1e-10) and met.motion.minimum[0] < -1


def test_fold_when_gap_and_torque_scale(branch):
    fold = of_kind(branch, "fold")[0].exact()
    scaled = single_pair(0.9, stiffness_cos=[0.3]).response(start=0.5, stop=1.2)
    assert of_kind(scaled, "fold")[0].exact().frequency == pytest.approx(fold.frequency, abs=1e-11)


@pytest.mark.parametrize("kind, parameter, value", [
    ("fold", "mesh 1 damping_ratio", 0.03), ("period doubling", "stiffness_variation", 0.4),
    ("separation", "stiffness_variation", 0.35),
])
def test_ends_equal_one_parameter_results(pair, branch, kind, parameter, value):
    special = (branch.onsets if kind == "separation" else of_kind(branch, kind))[0]
    own = {"mesh 1 damping_ratio": 0.05, "stiffness_variation": 0.3}[parameter]
    locus = pair.locus(special, parameter=parameter, start=own, stop=value)
    end = locus.frequency[-1]
    other = pair.with_values({parameter: value}).response(start=0.5, stop=2.4)
    found = [one.exact().frequency for one in (other.onsets if kind == "separation" else of_kind(other, kind))]
    assert locus.parameter[-1] == value
    assert min(abs(np.array(found) - end)) < 1e-9


def test_cusp(pair, branch):
    locus = pair.locus(of_kind(branch, "fold")[0], parameter="mesh 1 damping_ratio", start=0.03, stop=0.2)
    cusp, = (point for point in locus.special_points if point.kind == "cusp")
    # Two folds meet at the cusp, the most damping at which there are any.
    assert locus.parameter.max() <= cusp.parameter < locus.parameter.max() + 1e-4
    for change, folds in ((-2e-3, 2), (2e-3, 0)):
        other = pair.with_values({"mesh 1 damping_ratio": cusp.parameter + change}).response(start=0.5, stop=1.2)
        assert len(of_kind(other, "fold")) == folds


def test_refined_special_points(branch):
    refined = branch.refine()
    exact = [special.exact().frequency for special in branch.special_points]
    assert [special.frequency for special in refined.special_points] == pytest.approx(exact, abs=1e-12)
    change = [abs(place - special.frequency) for place, special in zip(exact, branch.special_points)]
    assert [special.correction for special in refined.special_points] == pytest.approx(change, abs=1e-12)
    assert all(special.correction is None for special in branch.special_points)


def test_refused(pair, branch):
    fold = of_kind(branch, "fold")[0]
    with pytest.raises(gt.InputError, match="must lie between"):
        pair.locus(fold, parameter="input_torque", start=0.5, stop=0.8)
    with pytest.raises(gt.InputError, match="did you mean"):
        pair.locus(fold, parameter="mesh 1 damping_ration", start=0.01, stop=0.1)
    with pytest.raises(gt.InputError, match="special"):
        pair.locus(0.84, parameter="input_torque", start=0.1, stop=0.8)


def test_case_file(tmp_path, pair, branch, monkeypatch):
    monkeypatch.chdir(tmp_path)
    response = {"start": 0.5, "stop": 1.2}
    locus = {"kind": "fold", "near": 0.84, "parameter": "mesh 1 damping_ratio", "start": 0.03, "stop": 0.2}
    (tmp_path / "case.nml").write_text(pair.namelist(response=response, locus=locus))
    results = gt.read_case("case.nml").run()
    own = pair.locus(of_kind(branch, "fold")[0], parameter="mesh 1 damping_ratio", start=0.03, stop=0.2)
    assert results.locus.frequency[[0, -1]] == pytest.approx(own.frequency[[0, -1]], abs=1e-9)
    results.write("case.h5")
    again = gt.read_results("case.h5").locus
    assert (again.frequency == results.locus.frequency).all() and again.special_points == results.locus.special_points
    with pytest.raises(gt.InputError, match="needs &response"):
        (tmp_path / "alone.nml").write_text(pair.namelist(locus=locus))
        gt.read_case("alone.nml")


def test_drawn_over_a_stability_map(pair, branch):
    chart = pair.stability_map(start=1.6, stop=2.4, points=9, parameter_start=0.1, parameter_stop=0.5, parameter_points=9)
    doubling = of_kind(branch, "period doubling")[0]
    locus = pair.locus(doubling, parameter="stiffness_variation", start=0.2, stop=0.4)
    ax = chart.plot(curves=[locus])
    line = next(line for line in ax.lines if line.get_label() == "period doubling")
    assert (line.get_xdata() == locus.frequency).all() and (line.get_ydata() == locus.parameter).all()
    assert (locus.plot().lines[0].get_ydata() == locus.frequency).all()
    other = pair.locus(doubling, parameter="mesh * damping_ratio", start=0.045, stop=0.055)
    with pytest.raises(gt.InputError, match="over 'mesh \\* damping_ratio'"):
        chart.plot(curves=[other])
    with pytest.raises(gt.InputError, match="across"):
        locus.plot(across="speed")


@pytest.mark.parametrize("frequency", [1e-6, 1e-3, 1e3, 1e6])
def test_curves_do_not_depend_on_the_characteristic_frequency(frequency):
    """Special points of the exact motion, and steps along a curve, are those of other units of Lambda and velocity."""
    found = []
    for unit in (1.0, frequency):
        train = paper_train(characteristic_frequency=9870.0 * unit)
        fold = train.response(start=0.5 / unit, stop=0.9 / unit).special_points[0]
        curve = train.locus(fold, parameter="stiffness_variation", start=0.28, stop=0.32)
        assert curve.complete
        found.append((fold.exact().frequency * unit, len(curve.parameter), curve.frequency[-1] * unit))
    assert found[1][0] == pytest.approx(found[0][0], rel=1e-10)
    assert found[1][1] == found[0][1]
    assert found[1][2] == pytest.approx(found[0][2], rel=1e-9)
