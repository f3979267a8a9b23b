"""Trains whose period has more than 500 cycles of a mesh: what works over whole periods is refused before it begins unless insisted
on, branches without multipliers go through everything that takes a branch, and a long run says how long it takes."""

import re
import signal
import subprocess
import time
from dataclasses import replace

import h5py
import numpy as np
import pytest
from conftest import ROOT, assert_equal_files, reducer, run, single_pair

import geartrain as gt
from geartrain._core.watch import quiet

#: Cycles of the mesh in a period.
CYCLES = 521
#: A range with two period doublings, and a Lambda in it.
RANGE = {"start": 1.8 / CYCLES, "stop": 2.2 / CYCLES, "harmonics": 0, "tolerance": 1e-2}
AT = 2.1 / CYCLES
TOLD = f"the period is {CYCLES} mesh cycles"

CASE = f"""
&train
   input_torque = 0.4, torque_cos = 1e-3, prime_mover_inertia = 0.0, load_inertia = 0.0
   characteristic_length = 1.0, characteristic_frequency = 1.0
/
&shaft rigid = .true. /
&mesh
   driving_radius = 1.0, driven_radius = 1.0, driving_inertia = 2.0, driven_inertia = 2.0, stiffness = 1.0
   damping_ratio = 0.01, half_backlash = 1.0, stiffness_cos = 0.1, order = {CYCLES}
/
&shaft rigid = .true. /
"""


@pytest.fixture(scope="module")
def train():
    """A pair whose torque goes round once in 521 cycles of the mesh."""
    return replace(single_pair(0.4, 0.01, stiffness_cos=[0.1], order=CYCLES), torque_cos=[1e-3])


@pytest.fixture(scope="module")
def branch(train):
    return train.response(**RANGE)


@pytest.fixture(scope="module")
def whole(train):
    """The same branch with its multipliers."""
    return train.response(**RANGE, multipliers=True)


def write(folder, analyses):
    path = folder / "case.nml"
    path.write_text(CASE + analyses)
    return path


@pytest.mark.parametrize("call", [
    lambda train: train.attractors(AT),
    lambda train: train.basins(AT),
    lambda train: train.bifurcation_diagram(start=AT, stop=1.1 * AT),
    lambda train: train.stability_map(start=AT, stop=1.1 * AT, parameter_start=0.1, parameter_stop=0.2, linear=True),
    lambda train: train.lyapunov_spectrum(AT),
])
def test_analyses_of_whole_periods_are_refused(train, call):
    begun = time.monotonic()
    with pytest.raises(gt.InputError, match=rf"{TOLD}, .*use &integration, .* or insist with long_period = True"):
        call(train)
    assert time.monotonic() - begun < 1.0


def test_a_search_for_all_motions_is_refused(train):
    with pytest.raises(gt.InputError, match=f"motions: .*{TOLD}"):
        train.motions(AT)


@pytest.mark.parametrize("asked", [{"refine": True}, {"period_doublings": 1}, {"branch_points": True}])
def test_what_a_response_does_by_multipliers_is_refused_without_them(train, asked):
    name = next(iter(asked))
    with pytest.raises(gt.InputError, match=rf"{name} = .*{TOLD}.* insist with stability = True and multipliers = True"):
        train.response(**RANGE, **asked)


def test_all_of_it_can_be_insisted_on(train, whole):
    found = train.attractors(AT, starts=2, max_periods=20, long_period=True)
    assert len(found) == 1 and found.unsettled == 0.0
    assert train.lyapunov_spectrum(AT, transient=2, periods=10, long_period=True).kind == "periodic"
    chart = train.stability_map(start=AT, stop=1.1 * AT, points=2, parameter_start=0.1, parameter_stop=0.2, parameter_points=2,
                                linear=True, long_period=True)
    assert chart.complete
    assert whole.audit(points=2).ok
    assert whole.special_points[0].exact().kind == "period doubling"
    assert np.isfinite(whole.at(AT)[0].refine().rms).all()


def test_a_doubling_of_a_long_period_is_not_passed_over(train):
    """Of 260 cycles: the branch of twice the period has no multipliers, which would show its own doublings."""
    short = train.with_values({"mesh 1 order": 260})
    asked = {"start": 1.8 / 260, "stop": 2.2 / 260, "harmonics": 0, "tolerance": 1e-2}
    with pytest.raises(gt.InputError, match=r"period_doublings = 2: .* the period is 520 mesh cycles"):
        short.response(**asked, period_doublings=2)
    assert short.response(**asked, period_doublings=1).multipliers is not None


def test_a_stability_change_says_what_it_lacks(train, branch, whole):
    change = branch.special_points[0]
    assert change.kind == "stability change" and branch.multipliers is None
    for call in (change.exact, lambda: change.gradient(["mesh 1 damping_ratio"])):
        with pytest.raises(gt.InputError, match=r"a stability change is where the growth rate passes 0 .* multipliers = True"):
            call()
    with pytest.raises(gt.InputError, match=f"locus: {TOLD}.*for motions of up to 32 mesh cycles:") as told:
        train.locus(change, parameter="input_torque", start=0.3, stop=0.5)
    assert "&stability_map" not in str(told.value)
    with pytest.raises(gt.InputError, match="a stability change, not a period doubling"):
        branch.period_doubled(change)
    assert change.frequency == pytest.approx(whole.special_points[0].frequency, rel=1e-6)
    assert whole.special_points[0].kind == "period doubling"


def test_a_branch_without_multipliers_refuses_to_be_solved_for_anew(branch):
    words = f"{TOLD}: take a .*response with stability = True and multipliers = True"
    for call in (branch.refine, branch.audit, branch.at(AT)[0].refine):
        with pytest.raises(gt.InputError, match=words):
            call()


def test_motions_of_such_a_branch_know_their_stability(branch, whole):
    for frequency in (AT, np.mean([special.frequency for special in branch.special_points])):
        (motion,), (known,) = branch.at(frequency), whole.at(frequency)
        assert motion.multipliers is None and known.multipliers is not None
        assert motion.stable is known.stable and motion.undecided is known.undecided
    assert replace(branch, others=branch.others).at(AT)[0].stable  # as a branch of one's own
    assert branch.train.response(**RANGE, seed=branch.at(AT)[0]).complete


def test_growth_rates_of_refined_points_follow_their_multipliers():
    """Of a short period, at a coarse balance, whose multipliers refinement moves."""
    coarse = single_pair(0.4, 0.05, stiffness_cos=[0.3]).response(start=0.7, stop=0.9, harmonics=2)
    found = coarse.refine()
    rates = np.log(np.abs(found.multipliers).max(axis=1)) * found.frequency / (2 * np.pi)
    done = ~np.isnan(found.correction)
    assert done.any() and found.growth_rate[done] == pytest.approx(rates[done], rel=1e-9, abs=1e-12)


def test_everything_that_takes_a_branch_takes_it(branch, whole, tmp_path):
    pytest.importorskip("xarray")
    assert (branch.stable == whole.stable).all()
    data = branch.to_dataset()
    assert "multipliers" not in data and "state" not in data.dims and (data.growth_rate.values < 0).sum() == branch.stable.sum()
    assert [jump.cause for jump in branch.jumps] == ["stability change", "stability change"]
    assert len(branch.peaks(1)) == len(whole.peaks(1))
    assert branch.plot() is not None
    page = tmp_path / "page.html"
    gt.page(branch).write(page)
    assert page.stat().st_size > 1000


def test_a_run_is_written_read_resumed_and_reported(executable, tmp_path):
    pytest.importorskip("h5py")
    asked = f"&response from = {RANGE['start']}, to = {RANGE['stop']}, harmonics = 0, tolerance = 1e-2, max_points = 100000"
    case = write(tmp_path, f"&modes /\n{asked}, step = 5e-4 /\n")
    done = run(executable, case, "--output", tmp_path / "whole.h5")
    assert done.returncode == 0 and "stability change" in done.stdout, done
    read = gt.read_results(tmp_path / "whole.h5").response
    assert read.multipliers is None and read.stable.any() and not read.stable.all() and read.at(AT)[0].stable
    partial = tmp_path / "other.h5.partial"
    work = subprocess.Popen([executable, case, "--output", tmp_path / "other.h5"], stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)
    try:
        while not partial.exists():
            assert work.poll() is None, "too short for a checkpoint"
            time.sleep(0.01)
    finally:
        work.send_signal(signal.SIGINT)
        work.wait()
    with h5py.File(partial) as file:
        assert 0 < len(file["response/point"]) < len(read)
    done = run(executable, case, "--output", tmp_path / "other.h5", "--resume")
    assert done.returncode == 0, done
    assert_equal_files(tmp_path / "whole.h5", tmp_path / "other.h5")


def test_the_map_that_a_refused_locus_names_is_computed(executable, tmp_path, train):
    """Of 67 mesh cycles: too many for a curve of special points, few enough for a map."""
    response = "&response from = 0.02, to = 0.04, harmonics = 0 /\n"
    case = write(tmp_path, response + "&locus near = 0.03, parameter = 'input_torque', from = 0.3, to = 0.5 /\n")
    case.write_text(re.sub(r"order += \d+", "order = 67", case.read_text()))
    done = run(executable, "--check", case, cwd=tmp_path)
    assert done.returncode == 2
    assert "the period is 67 mesh cycles. A curve of special points is followed for motions of up to 32" in done.stderr
    assert "or &stability_map over the parameter" in done.stderr
    chart = train.with_values({"mesh 1 order": 67}).stability_map(
        start=0.02, stop=0.021, points=2, parameter="input_torque", parameter_start=0.3, parameter_stop=0.5, parameter_points=2,
        harmonics=0, tolerance=1e-2)
    assert chart.complete and (chart.motions > 0).all()


@pytest.mark.parametrize(("analyses", "line", "group"), [
    (f"&attractors frequency = {AT} /\n", 12, "&attractors"),
    (f"&response from = {AT}, to = {2 * AT}, harmonics = 0,\n refine = .true. /\n", 13, "&response"),
    (f"&response from = {AT}, to = {2 * AT}, harmonics = 0 /\n&locus near = {1.5 * AT}, parameter = 'input_torque',\n"
     "from = 0.3, to = 0.5 /\n", 13, "&locus"),
])
def test_a_case_file_is_refused_by_line_and_group(executable, tmp_path, analyses, line, group):
    case = write(tmp_path, analyses)
    done = run(executable, case, cwd=tmp_path)
    assert done.returncode == 2 and done.stdout == "", done
    assert re.search(rf"case\.nml:{line}:\d+: error: .*{TOLD}", done.stderr), done
    assert group in done.stderr, done
    assert not list(tmp_path.glob("*.h5*"))


def test_an_audit_is_refused_before_the_response(executable, tmp_path):
    done = run(executable, "--audit", write(tmp_path, f"&response from = {AT}, to = {2 * AT}, harmonics = 0 /\n"))
    assert done.returncode == 2 and f"audit: solves anew over whole periods, and {TOLD}" in done.stderr, done


def test_the_period_is_told_in_turns():
    """A torque of the motor's revolution meets the second stage's teeth: 71 turns of the motor."""
    train = reducer()
    motor = replace(train.bodies[0], revolution_torque_cos=[1.0])
    with pytest.raises(gt.InputError, match="the period is 71 turns of motor, 1633 mesh cycles, and"):
        replace(train, bodies=[motor, *train.bodies[1:]]).attractors(1000.0)


SLOW = "&modes /\n&response from = 0.2, to = 2.6, step = 0.00002, max_points = 10000000 /\n"


def first_lines(executable, case, seconds, want):
    """What a run with redirected output has written of ``want`` before it is ended after ``seconds``; the seconds it took."""
    files = [case.with_name(name) for name in ("out.txt", "err.txt")]
    begun = time.monotonic()
    with files[0].open("w") as out, files[1].open("w") as err:
        work = subprocess.Popen([executable, case, "--output", case.with_name("out.h5")], stdout=out, stderr=err)
        try:
            while time.monotonic() - begun < seconds and work.poll() is None:
                told = "".join(file.read_text() for file in files)
                if re.search(want, told):
                    return told, time.monotonic() - begun
                time.sleep(0.05)
        finally:
            work.kill()
            work.wait()
    return "".join(file.read_text() for file in files), time.monotonic() - begun


def paper_case(folder, analyses):
    path = folder / "slow.nml"
    path.write_text((ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0] + analyses)
    return path


@pytest.mark.full
@pytest.mark.parametrize(("analyses", "words"), [
    (SLOW, r"response: about [\d.]+ (s|min|h) expected: "
           r"(verdicts take \d+ % of the time: stability = \.false\. takes about .*|a point takes .*)"),
    pytest.param("&integration from = 0.2, to = 2.6, points = 100000, direction = 'both' /\n",
                 r"integration: about \d+ (s|min|h) expected: 200000 points of .*", marks=pytest.mark.nightly),
    pytest.param("&attractors frequency = 0.6, starts = 100000 /\n",
                 r"attractors: about \d+ (s|min|h) expected: 100000 points of .*", marks=pytest.mark.nightly),
    ("&run_up from = 0.2, to = 2.6, duration = 300.0, samples = 1 /\n", r"run up: about \d+ (s|min|h) expected"),
    ("&stability_map from = 0.4, to = 1.6, points = 1000, parameter_from = 0.01, parameter_to = 0.1, parameter_points = 10000 /\n",
     r"stability map: about \d+ (s|min|h) expected: 10000 rows of .*"),
])
def test_a_long_run_says_how_long_it_takes(executable, tmp_path, analyses, words):
    told, _ = first_lines(executable, paper_case(tmp_path, analyses), 15.0, words)
    assert re.search(words, told), told
    assert told.count(" expected") == 1


def test_a_short_run_forecasts_nothing(executable, tmp_path):
    done = run(executable, paper_case(tmp_path, "&response from = 0.2, to = 2.6 /\n"), cwd=tmp_path)
    assert done.returncode == 0 and done.stderr == "", done


def test_natural_frequencies_come_at_once(executable, tmp_path):
    """Before the first start of a search, which takes longer."""
    case = write(tmp_path, f"&modes /\n&attractors frequency = {AT}, starts = 100000, long_period = .true. /\n")
    told, seconds = first_lines(executable, case, 20.0, "natural frequencies")
    assert "natural frequencies" in told and seconds < 2.0, told


def test_python_shows_the_forecast(train, monkeypatch, capsys):
    """Above the bar, once."""
    pytest.importorskip("tqdm")
    from geartrain._core import watch as _watch

    written = []

    class Bar:
        disable, n = False, 0

        def write(self, text, file):
            written.append(text)

        def set_postfix_str(self, text):
            pass

        def close(self):
            pass

    monkeypatch.setattr(_watch, "progress_bar", lambda *_: Bar())
    monkeypatch.setattr(_watch, "_PATIENCE", 0.0)
    sentence = "response: about 3 min expected"

    def work(progress):
        progress[4 : 4 + len(sentence)] = list(map(ord, sentence))
        progress[3] = len(sentence)
        time.sleep(0.3)
        return len(progress)

    assert _watch.watched(work, "response") == len(quiet())
    assert written == [sentence]
