"""Special points and contact onsets of the exact motion, against closed forms and earlier findings by shooting."""

import numpy as np
import pytest
from conftest import equal_stages, paper_train, single_pair

import geartrain as gt

pytestmark = pytest.mark.full


@pytest.fixture(scope="module")
def branch():
    """The branch of the single pair with f = 0.4, kappa = 0.3, zeta = 0.05: in contact where it doubles."""
    return single_pair(0.4, stiffness_cos=[0.3]).response(start=0.5, stop=2.4)


def only(specials, kind, near):
    found = [special for special in specials if special.kind == kind and abs(special.frequency - near) < 1e-3]
    assert len(found) == 1
    return found[0]


def test_fold(branch):
    fold = only(branch.special_points, "fold", 0.8446).exact()
    # By integration with SciPy's DOP853 at 1e-12.
    assert fold.frequency == pytest.approx(0.844564142, abs=1e-9)
    assert fold.crossing == 1
    assert fold.critical == pytest.approx([1], abs=1e-7)
    assert fold.motion.minimum[0] < 1


def test_doubling(branch):
    doublings = [special.exact() for special in branch.special_points if special.kind == "period doubling"]
    # Zeros of Hill's determinant of Mathieu's equation with damping, 61 harmonics (test/hard_closed_forms.f90).
    assert [doubling.frequency for doubling in doublings] == pytest.approx([1.8831440170837, 2.1063923779291], abs=1e-10)
    assert [doubling.crossing for doubling in doublings] == [1, 1]
    assert doublings[0].critical == pytest.approx([-1], abs=1e-8)


def test_onset_of_separation(branch):
    onset = only(branch.onsets, "separation", 1.128).exact()
    assert onset.mesh == 1 and onset.motion.minimum[0] == pytest.approx(1, abs=1e-9)
    # Figure 3, found by shooting (test/validation_bifurcations.f90).
    paper = paper_train().response(start=1.0, stop=1.2)
    assert not any(onset.undecided for onset in paper.onsets)
    onset = only(paper.onsets, "separation", 1.1028).exact()
    assert onset.mesh == 2 and onset.frequency == pytest.approx(1.1027590, abs=1e-7)
    assert onset.motion.minimum[1] == pytest.approx(1, abs=1e-9)
    assert onset.crossing == 0


@pytest.mark.parametrize("near, criticality", [(0.6177, "supercritical"), (0.6573, "subcritical")])
def test_criticality(near, criticality):
    # The doubled motions by harmonic balance: supercritical where they are on the side on which the branch is unstable.
    train = paper_train().with_values({"mesh * damping_ratio": 0.01})
    branch = train.response(start=0.3, stop=1.0, harmonics=16)
    doubling = min((special for special in branch.special_points if special.kind == "period doubling"),
                   key=lambda special: abs(special.frequency - near))
    exact = doubling.exact()
    doubled = branch.period_doubled(doubling).frequency
    unstable_above = branch.stable[doubling.point]
    assert branch.frequency[doubling.point] < branch.frequency[doubling.point + 1]
    assert (criticality == "supercritical") == ((doubled[6] > doubled[0]) == unstable_above)
    assert exact.criticality == criticality


def test_fold_of_an_island():
    # Figure 9 with zeta = 0.01: a closed branch joined to no other; its motion at 0.85 by random starts, its fold with R = 48
    # (test/hard_branches.f90).
    train = paper_train().with_values({"mesh * damping_ratio": 0.01})
    state = [0.01254298, -2.27472542, -0.08825069, -6.79887307, -0.10168407,
             0.11287488, 2.11040707, 0.0276462, -1.9129191, 0.30859615]
    seed = train.integrate(frequency=0.85, start=state)
    island = train.response(start=0.7, stop=0.9, seed=seed, harmonics=12)
    fold = only(island.special_points, "fold", 0.7443).exact()
    assert fold.frequency == pytest.approx(0.74431157, abs=1e-8)
    assert fold.crossing == 1


def test_none_near(branch):
    fold = only(branch.special_points, "fold", 0.8446)
    with pytest.raises(ValueError, match="no branch"):
        gt.SpecialPoint(fold.kind, fold.frequency, fold.point, fold.rms).exact()


def test_branch_points_and_their_curve():
    def exact_ones(branch):
        return sorted((special.exact() for special in branch.special_points if special.kind == "branch point"),
                      key=lambda exact: exact.frequency)

    train = equal_stages(0.3)
    branch = train.response(start=0.7, stop=1.1, harmonics=12)
    low, high = exact_ones(branch)
    # Where the balance with 48 harmonics has them.
    fine = train.response(start=0.7, stop=1.1, harmonics=48)
    assert [low.frequency, high.frequency] == pytest.approx(
        sorted(special.frequency for special in fine.special_points if special.kind == "branch point"), abs=1e-7)
    for exact in (low, high):
        assert exact.crossing == 1 and exact.critical == pytest.approx([1], abs=1e-8)
        assert exact.motion.rms[0] == pytest.approx(exact.motion.rms[1], abs=1e-10)
    # One curve leads through both, and through those of another stiffness variation.
    locus = train.locus(high, parameter="stiffness_variation", start=0.15, stop=0.5)
    assert locus.complete
    for value, expected in ((0.3, [low, high]), (0.4, exact_ones(equal_stages(0.4).response(start=0.7, stop=1.1, harmonics=12)))):
        for exact in expected:
            at = abs(locus.frequency - exact.frequency) + abs(locus.parameter - value)
            near = np.argsort(at)[:6]
            near = near[np.argsort(locus.parameter[near])]
            # The polynomial through six points of the curve.
            fit = np.polynomial.Polynomial.fit(locus.parameter[near], locus.frequency[near], 5)
            assert fit(value) == pytest.approx(exact.frequency, abs=1e-6)


def test_criticality_of_neimark_sacker_points():
    # The sections of what the flow settles on beyond the point: a circle of a width like the square root of the distance, or an
    # attractor whose width does not go to 0.
    train = paper_train().with_values({"mesh * damping_ratio": 0.01})
    branch = train.response(start=0.4, stop=0.5, harmonics=12)
    exact = {"supercritical": only(branch.special_points, "neimark-sacker", 0.4441).exact(),
             "subcritical": only(branch.special_points, "neimark-sacker", 0.4503).exact()}
    widths = {}
    for criticality, point in exact.items():
        assert point.criticality == criticality
        outwards = 1 if criticality == "supercritical" else -1
        diagrams = (train.bifurcation_diagram(start=at, stop=at, points=1, direction="up", transient=20000, sections=300,
                                              seed=point.motion.state * 1.005)
                    for at in (point.frequency + outwards * 8e-5, point.frequency + outwards * 3.2e-4))
        widths[criticality] = [float(np.ptp(diagram.displacement[0, :, 0])) for diagram in diagrams]
    assert widths["supercritical"][1] / widths["supercritical"][0] == pytest.approx(2, rel=0.05)
    assert widths["subcritical"][0] > 0.1


def test_rms_of_special_points_is_that_there():
    branch = paper_train().response(start=0.2, stop=2.6, harmonics=12)
    for special in [*branch.special_points, *branch.onsets]:
        there = branch.at(special.frequency)
        # An onset is solved for up to a last step of 1e-5; at a fold two motions meet like the square root of the distance.
        allowed = 1e-2 if special.kind == "fold" else 2e-5
        assert min(abs(motion.rms - special.rms).max() for motion in there) < allowed, special


def test_an_onset_is_a_motion_like_any_other(branch):
    onset = only(branch.onsets, "separation", 1.128).exact()
    assert onset.motion.stable and not onset.motion.undecided


def chain(torque, shafts, *stages, **more):
    """A chain in units of 1 between rigid ends: radii, inertias, stiffness, damping ratio and harmonics of each stage."""
    names = ("driving_radius", "driven_radius", "driving_inertia", "driven_inertia", "stiffness", "damping_ratio")
    meshes = [gt.Mesh(half_backlash=1.0, **dict(zip(names, stage[:6])), **stage[6]) for stage in stages]
    elastic = [gt.Shaft(stiffness=stiffness, damping_ratio=ratio) for stiffness, ratio in shafts]
    return gt.Train(input_torque=torque, prime_mover_inertia=0.0, load_inertia=0.0, characteristic_length=1.0,
                    characteristic_frequency=1.0, meshes=meshes,
                    shafts=[gt.Shaft(rigid=True), *elastic, gt.Shaft(rigid=True)], **more)


def test_a_pair_that_becomes_real_is_no_neimark_sacker_point():
    """The product of the pair jumps by what it was with another multiplier; no multiplier is on the unit circle.

    The multipliers next to it by an integrator with fixed steps and events of its own: 1.45952, 1.45955, 0.867 in magnitude.
    """
    train = chain(
        0.24047971368849816, [(1.3787263233786535, 0.02505068859120331), (2.224306851498627, 0.0352357301382403)],
        (1.1122586737511968, 0.9430618517322054, 2.7208013569340777, 1.9874528269017717, 1.2986687826063896, 0.043107630465136264,
         {"stiffness_cos": 0.18300050587228298, "error_cos": 0.07995899956266511}),
        (1.0930422615672606, 0.9240245220800313, 1.657556226217975, 2.2828179472795753, 1.5038710775535833, 0.03949344684323212,
         {"stiffness_cos": 0.22718630392628553, "stiffness_sin": [-0.07214134640462676, 0.06891517321213689],
          "error_cos": 0.07649596778394568}),
        (1.0431315384275248, 1.1165586789485205, 1.4907655727771474, 2.607210431336666, 0.9724102526343334, 0.033643546081675066,
         {"stiffness_cos": 0.3844745927565174, "stiffness_sin": [-0.025947535844472944, -0.015234028751107603],
          "error_cos": 0.1551406145917018}))
    response = train.response(start=0.35, stop=2.6, harmonics=10, period_doublings=1, step=0.06)
    found = [special for twice in response.branches for special in twice.special_points if special.kind == "neimark-sacker"]
    exact = 0
    for special in found:
        try:
            multipliers = special.exact().multipliers
        except gt.SolverError:
            continue
        exact += 1
        assert np.abs(np.abs(multipliers[multipliers.imag > 0]) - 1).min() < 1e-7
    assert 0 < exact < len(found)


def test_no_criticality_where_the_motion_is_linear():
    """At both Neimark-Sacker points all meshes stay in contact: the equation is linear, and circles have any size."""
    train = chain(
        0.3246627293838012, [(1.198296484747053, 0.014074700118003047)],
        (0.839408451540966, 1.0362369615948168, 1.7644517317279524, 2.1144915380984877, 1.2606330312961405, 0.049996790217178164,
         {"stiffness_cos": 0.3850572993951389}),
        (0.8747114216970953, 1.1540162299344148, 1.8121880710420262, 1.2938245051795334, 1.2852537829320352, 0.028854248069792178,
         {"stiffness_cos": 0.18343006144462545}),
        torque_cos=0.07683833703301068)
    points = [special.exact() for special in train.response(start=1.72, stop=2.12, harmonics=10).special_points
              if special.kind == "neimark-sacker"]
    assert [point.frequency for point in points] == pytest.approx([1.818366663742, 1.920833177765], abs=1e-9)
    for point in points:
        assert point.motion.minimum.min() > 1.2 and point.criticality == "" and point.crossing == 2


def test_a_branch_point_at_which_lambda_turns():
    """A response that goes over to the branch that leaves there: the same point as from the symmetric one."""
    pair = chain(0.0, [], (1.0, 1.0, 2.9009273926518704, 1.2883192254392675, 1.3691896682823463, 0.022473258080419417,
                           {"error_cos": [0.8793918156743092, 0.0, 0.05]}), torque_cos=0.1873984219182649)
    pair = pair.with_values({"mesh 1 half_backlash": 0.2269979346917727})
    found = []
    for start, stop in ((0.55, 0.65), (0.5, 0.7)):
        branch = pair.response(start=start, stop=stop, harmonics=41)
        found += [special.exact() for special in branch.special_points if special.kind == "branch point"]
    assert [point.frequency for point in found] == pytest.approx(2 * [0.59520486013586], abs=1e-12)
    for point in found:
        assert np.abs(point.multipliers - 1).min() < 1e-7
