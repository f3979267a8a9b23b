"""The second opinion: `Branch.audit`, and `geartrain --audit` over every case of the paper."""

import pickle

import numpy as np
import pytest
from conftest import ROOT, paper_train, reducer, run, single_pair

import geartrain as gt
from paper_cases import CHANGES, case_texts, paper_case

pytestmark = pytest.mark.full

TEXTS = {path.stem: path.read_text() for path in (ROOT / "namelists").glob("*.nml")} | case_texts()
# An audit shoots over whole periods: none of the thousands of cycles of hunting teeth.
CASES = sorted(name for name, text in TEXTS.items() if "&response" in text and name != "wind_turbine")
# Those with grazing contacts next to changes of stability: a verdict that looks decided is wrong here first.
GRAZING = ["fig07_042", "fig08_rectangular", "fig09_001"]
# Audited by night: cases that differ from figure 3 by a number, cases of a long period, and cases like one that is audited by day.
BY_NIGHT = {name for name, *_ in CHANGES} - {GRAZING[2]} | {*GRAZING[:2], "fig10", "fig11", "fig12"}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.nightly if name in BY_NIGHT else ()) for name in CASES])
def test_every_case_is_as_shooting_says(executable, tmp_path, name):
    path = tmp_path / f"{name}.nml"
    path.write_text(TEXTS[name])
    done = run(executable, "--audit", path, cwd=tmp_path)
    assert done.returncode == 0, done.stdout
    # A slow machine expects a long audit.
    assert all("s expected" in line for line in done.stderr.splitlines()), done.stderr
    lines = [line for line in done.stdout.splitlines() if " as estimated" in line]
    assert lines and all("stability is wrong at 0 points; " in line for line in lines)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", [GRAZING[1], *(pytest.param(name, marks=pytest.mark.nightly) for name in GRAZING[::2])])
def test_every_point_is_as_shooting_says(name):
    response = paper_case(name).run().response
    found = response.audit(points=len(response.frequency))
    assert found.ok, found
    # Not by calling all of it undecided; the length of a branch begins anew where it comes back from above the amplitude limit.
    length = response.others["arclength"]
    weights = [np.gradient(part) for part in np.split(length, np.flatnonzero(np.diff(length) < 0) + 1)]
    assert np.average(response.undecided, weights=np.concatenate(weights)) < 0.15


def test_several_cases_and_what_cannot_be_audited(executable, tmp_path):
    (tmp_path / "bad.nml").write_text("&train /")
    without = tmp_path.parent / f"{tmp_path.name}-fig05.nml"
    without.write_text(TEXTS["fig05"])
    names = [str(ROOT / "namelists" / "single_pair.nml"), str(without)]
    done = run(executable, "--audit", *names, "bad.nml", cwd=tmp_path)
    assert done.returncode == 2
    assert f"{names[1]}: error: nothing to audit: add &response" in done.stderr
    assert any(line.startswith("bad.nml:") for line in done.stderr.splitlines())
    assert done.stdout.startswith(f"{names[0]}:\nResponse\n") and "Errors of 20 of 20 points are as estimated" in done.stdout
    for option in ("--resume", "--check", "--output=x.h5"):
        done = run(executable, "--audit", names[0], option, cwd=tmp_path)
        assert done.returncode == 2 and done.stderr.startswith("geartrain: error: ")
    assert [path.name for path in tmp_path.iterdir()] == ["bad.nml"]


def test_exit_status_3_where_something_is_wrong(executable, tmp_path):
    # The paper's own way of coefficients stalls at grazing contacts and lists folds that do not exist.
    text = (ROOT / "namelists" / "fig03.nml").read_text()
    train = text.split("&response", 1)[0]
    (tmp_path / "case.nml").write_text(f"{train}&response coefficients = 'sampled', harmonics = 6, from = 0.3, to = 1.0 /\n")
    done = run(executable, "--audit", "case.nml", cwd=tmp_path)
    assert done.returncode == 3 and "no fold found near it" in done.stdout


def test_the_call(branch):
    found = branch.audit(points=12, random_seed=3)
    assert found.ok and len(found) == 12 + len(branch.special_points) == found.points + found.special_points
    assert repr(found) == f"<Audit: {str(found).splitlines()[-1]}>"
    points = found.point[:12]
    assert np.array_equal(found.frequency[:12], branch.frequency[points])
    assert np.array_equal(found.error_estimate[:12], branch.error_estimate[points])
    refined = branch.refine()
    assert np.allclose(found.error[:12], refined.correction[points], rtol=1e-6)
    folds = [kind == "fold" for kind in found.kind]
    assert np.all(np.abs(found.exact_frequency - found.frequency)[folds] < 3e-4) and np.isnan(found.exact_frequency[:12]).all()
    assert list(found.kind[12:]) == [special.kind for special in branch.special_points]
    assert str(pickle.loads(pickle.dumps(found))) == str(found)
    assert str(branch.audit(points=12, random_seed=3)) == str(found)


def test_speeds_of_an_audit(branch, drawn_branch):
    """In rpm where the speed is known, in Hz always; the table is in the unit of the branch."""
    found = branch.audit(points=2)
    assert found.unit == "Lambda" and found.speed is None and found.exact_speed is None
    np.testing.assert_allclose(found.fundamental_frequency, found.frequency * 9870 / (2 * np.pi))
    found = drawn_branch.audit(points=2)
    assert found.unit == "rpm" == str(found).split()[0] and found.ok
    np.testing.assert_allclose(found.speed, found.frequency)
    np.testing.assert_allclose(found.exact_speed, found.exact_frequency)
    np.testing.assert_allclose(found.fundamental_frequency, found.speed / 60 * 23 / 71)
    hertz = reducer().response(start=9.0, stop=9.02, unit="Hz", harmonics=0, tolerance=1e-3, max_points=3).audit(points=1)
    first = float(str(hertz).splitlines()[1].split()[0])
    assert hertz.unit == "Hz" and first == pytest.approx(hertz.fundamental_frequency[0], abs=1e-6)


@pytest.mark.parametrize("wrong", [{"points": -1}, {"points": 1.5}, {"points": True}, {"points": 10**12}, {"random_seed": "a"}])
def test_bad_input(branch, wrong):
    with pytest.raises(gt.InputError, match=next(iter(wrong))):
        branch.audit(**wrong)


def test_an_unstable_motion_of_a_high_order_is_that_of_order_1():
    """Its multipliers are those of order 1 to the power of the order: at 1e13 shooting over the whole period loses all digits."""
    order = 50  # at Lambda/order the pair moves as that of order 1 does at Lambda
    branch = single_pair(0.4, stiffness_cos=[0.3], order=order).response(start=0.3 / order, stop=1.6 / order, harmonics=12 * order)
    found = branch.audit(points=12)
    assert found.ok and found.as_estimated >= 11, found
    unstable = np.flatnonzero(~branch.stable & ~branch.undecided)
    assert len(unstable) > 3 and abs(branch.multipliers[unstable, 0]).max() > 1e12
    plain = single_pair(0.4, stiffness_cos=[0.3]).response(start=0.3, stop=1.6, harmonics=12)
    for i in unstable:
        motion = min(branch.at(float(branch.frequency[i])), key=lambda motion: abs(motion.rms[0] - branch.rms[i, 0])).refine()
        same = [known.refine() for known in plain.at(order * float(branch.frequency[i]))]
        known = min(same, key=lambda known: abs(known.rms[0] - motion.rms[0]))
        assert motion.rms == pytest.approx(known.rms, rel=1e-11) and motion.frequency == branch.frequency[i]
        assert abs(motion.multipliers[0]) == pytest.approx(abs(known.multipliers[0]) ** order, rel=1e-6)
        # Only harmonics of the teeth, and as large as those of order 1.
        amplitude = np.hypot(motion.coefficients[0, 1::2], motion.coefficients[0, 2::2])
        assert not amplitude[np.arange(1, len(amplitude) + 1) % order != 0].any()
        assert amplitude[order - 1] == pytest.approx(np.hypot(*known.coefficients[0, 1:3]), rel=1e-10)


def test_what_nothing_excites_is_its_mean():
    """The alternating part of such a motion is rounding, over which no error can be told."""
    branch = paper_train().with_values({"mesh * stiffness_cos 1": 0.0}).response(start=0.3, stop=0.303, harmonics=4)
    assert np.all(branch.rms < 1e-12)
    audit = branch.audit(points=3)
    assert audit.ok and not any(audit.finding), audit


def test_neglected_harmonics_act_on_each_other():
    """Two stages at one percent: beats of the tooth frequencies, which excite each other, are neglected."""
    train = gt.read_case(ROOT / "namelists" / "reducer.nml").train
    found = train.response(start=1640.0, stop=1700.0, unit="rpm", harmonics=0, tolerance=1e-2).audit(points=16)
    assert found.ok and found.as_estimated == found.points == 16
    assert found.kind.count("fold") == found.confirmed == 2
