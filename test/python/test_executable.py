"""The executable as a user types it: options, messages, exit statuses (3 and 4: test_results_file.py)."""

import contextlib
import os
import pty
import re
import subprocess
import time

import h5py
import pytest
from conftest import ROOT, run

import geartrain as gt

CASE = ROOT / "namelists" / "single_pair.nml"


def test_check_and_run(executable, tmp_path):
    done = run(executable, "--check", CASE, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "") and "no problems" in done.stdout
    assert not list(tmp_path.iterdir())
    done = run(executable, CASE, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert [path.suffix for path in tmp_path.iterdir()] == [".h5"]


def test_check_does_not_say_no_problems_beside_warnings(executable, tmp_path):
    done = run(executable, "--check", ROOT / "namelists" / "rattle.nml", cwd=tmp_path)
    assert done.returncode == 0 and "no errors, but warnings" in done.stdout and "warning: &mesh 2" in done.stderr


def test_natural_frequencies_are_told_while_the_run_goes_on(executable, tmp_path):
    """Into a file, once, on standard error; the whole reducer takes longer by far."""
    out, err = tmp_path / "out", tmp_path / "err"
    with out.open("wb") as to, err.open("wb") as errors:
        work = subprocess.Popen([executable, ROOT / "namelists" / "reducer.nml"], stdout=to, stderr=errors, cwd=tmp_path)
    try:
        began = time.monotonic()
        while "natural frequencies" not in err.read_text() and time.monotonic() - began < 20:
            time.sleep(0.02)
        assert work.poll() is None and err.read_text().splitlines()[0] == "natural frequencies: 97.16 317.7 647.2 5030 6578 Hz"
        assert out.read_text() == ""
    finally:
        work.kill()
        work.wait()


def test_template_runs_through_check(executable, tmp_path):
    (tmp_path / "case.nml").write_text(run(executable, "--template", cwd=tmp_path).stdout)
    assert run(executable, "--check", "case.nml", cwd=tmp_path).returncode == 0


def test_version_and_help(executable, tmp_path):
    assert run(executable, "--version", cwd=tmp_path).stdout == f"geartrain {gt.__version__}\n"
    assert "Exit status" in run(executable, "--help", cwd=tmp_path).stdout


@pytest.mark.nightly
def test_the_report_is_in_the_unit_asked_for(executable, tmp_path):
    """rpm where Lambda is the speed in rpm, though Lambda is asked for; Hz where asked for; um where lengths are in um."""
    train = (ROOT / "namelists" / "reducer.nml").read_text().split("&modes")[0]
    settings = "harmonics = 0, tolerance = 1e-3 /"
    (tmp_path / "speed.nml").write_text(
        f"{train}&modes /\n&response from = 1640.0, to = 1680.0, {settings}\n&run_up from = 1650.0, to = 1720.0, duration = 0.5 /\n"
        "&integration from = 1500.0, to = 1510.0, points = 2 /\n&attractors frequency = 1500.0, starts = 2 /\n")
    done = run(executable, "speed.nml", "--verbose", cwd=tmp_path)
    assert done.returncode == 0 and "Lambda" not in done.stdout
    told = " ".join(done.stdout.split())
    for words in ("mesh peak at rpm true rms [um] peak to peak [um]", "ended: from 1640 rpm: reached 1680 rpm",
                  "ended: reached 1720 rpm", "Attractors at 1500 rpm: ", "true rms [um] of each mesh", "Speeds are those of motor",
                  "loses contact at 1667.4 to 1680.0 rpm", "Jumps (true rms [um], mesh with the largest change)",
                  "damping_acts = 'contact' in &mesh"):
        assert words in told, words
    assert "the end of the range" not in told
    # Short of the jump at 1673 rpm: rms and force of either mesh are largest at the end.
    (tmp_path / "end.nml").write_text(f"{train}&response from = 1640.0, to = 1672.0, {settings}\n")
    done = run(executable, "end.nml", cwd=tmp_path)
    told = " ".join(done.stdout.split())
    assert told.count("at 1672.0 rpm, the end of the range") == 2
    assert "The largest force or vibration of meshes 1, 2 is at the end of the range; a larger one may lie beyond" in told
    (tmp_path / "hertz.nml").write_text(f"{train}&response from = 8.9, to = 9.06, unit = 'Hz', {settings}\n")
    done = run(executable, "hertz.nml", "--verbose", cwd=tmp_path)
    assert done.returncode == 0 and "Lambda" not in done.stdout and "rpm" not in done.stdout
    assert "folds at Hz" in done.stdout and "reached 9.06 Hz" in done.stdout
    folds = re.search("folds at Hz +(.*)", done.stdout).group(1).split()
    assert float(folds[0]) == pytest.approx(1667.404 / 60 * 23 / 71, abs=1e-4)
    done = run(executable, "--audit", "hertz.nml", cwd=tmp_path)
    assert done.returncode == 0 and re.search("^ +Hz  what", done.stdout, re.MULTILINE)


def test_progress_of_a_motion_that_does_not_settle(executable, tmp_path):
    """On a terminal, in the unit of the analysis, from the second second on."""
    train = (ROOT / "namelists" / "single_pair.nml").read_text().split("&modes")[0]
    train = train.replace("stiffness_cos   = 0.3", "stiffness_cos = 0.6")
    (tmp_path / "case.nml").write_text(
        f"{train}&integration from = 1.9, to = 1.9, points = 1, unit = 'Lambda', max_periods = 300000 /\n")
    try:
        leader, follower = pty.openpty()
    except OSError as error:
        pytest.skip(f"no terminal to be had here: {error}")
    with subprocess.Popen([executable, "case.nml"], cwd=tmp_path, stderr=follower, stdout=subprocess.DEVNULL) as process:
        os.close(follower)
        told = b""
        with contextlib.suppress(OSError):
            while (part := os.read(leader, 4096)) and told.count(b"settling: ") < 3:
                told += part
        process.kill()
    os.close(leader)
    assert re.search(rb"settling: \d+ periods, Lambda 1\.9000, 0 points done", told), told


def test_every_problem_at_once_and_nothing_written(executable, tmp_path):
    text = CASE.read_text().replace("half_backlash", "half_backslash", 1).replace("&train", "&train oops = 1", 1)
    (tmp_path / "bad.nml").write_text(text)
    done = run(executable, "bad.nml", "--output", "bad.h5", cwd=tmp_path)
    assert done.returncode == 2
    assert 'unknown variable "oops" in &train' in done.stderr
    assert 'unknown variable "half_backslash" in &mesh (did you mean "half_backlash"?)' in done.stderr
    assert not (tmp_path / "bad.h5").exists()


def test_several_cases(executable, tmp_path):
    text = CASE.read_text()
    for name in ("one", "two", "three"):
        (tmp_path / f"{name}.nml").write_text(text)
    (tmp_path / "bad.nml").write_text("&train /")
    (tmp_path / "same.nml").write_text(text + "&output file = 'one.h5' /\n")
    done = run(executable, "one.nml", "bad.nml", "two.nml", "same.nml", "three.nml", "none.nml", cwd=tmp_path)
    assert done.returncode == 2
    assert sorted(path.name for path in tmp_path.glob("*.h5")) == ["one.h5", "three.h5", "two.h5"]
    problems = done.stderr.splitlines()
    assert "none.nml: error: there is no such file" in problems
    assert "same.nml: error: its results would overwrite those of one.nml, one.h5: name another file in &output" in problems
    assert any(line.startswith("bad.nml:") for line in problems)
    # Each report in one piece under the name of its case, and equal but for names and times.
    pieces = re.split(r"^(\w+)\.nml:\n", done.stdout, flags=re.MULTILINE)[1:]
    reports = {name: re.sub(r"Time: .*|\w+\.h5", "", text) for name, text in zip(pieces[::2], pieces[1::2])}
    assert sorted(reports) == ["one", "three", "two"] and len(set(reports.values())) == 1
    alone = run(executable, "one.nml", "--output", "alone.h5", cwd=tmp_path)
    assert alone.returncode == 0
    with h5py.File(tmp_path / "alone.h5") as one, h5py.File(tmp_path / "two.h5") as two:
        for name in ("rms", "multipliers"):
            assert one["response"][name][()].tobytes() == two["response"][name][()].tobytes()


def test_a_case_given_twice_is_refused_before_anything_runs(executable, tmp_path):
    for name in ("one", "two"):
        (tmp_path / f"{name}.nml").write_text(CASE.read_text())
    for again in ("one.nml", "./one.nml", f"../{tmp_path.name}/one.nml"):
        done = run(executable, "one.nml", "two.nml", again, cwd=tmp_path)
        assert done.returncode == 2 and done.stdout == ""
        assert done.stderr == f"{again}: error: the case is given twice: give it once; nothing was run\n"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.nml", "two.nml"]


@pytest.mark.parametrize(
    "arguments", [(), ("--nonsense",), ("missing.nml",), (".",), (CASE, "--output"), (CASE, CASE, "--output", "x.h5")]
)
def test_bad_arguments(executable, tmp_path, arguments):
    done = run(executable, *arguments, cwd=tmp_path)
    assert done.returncode == 2 and done.stderr
    assert not list(tmp_path.iterdir())
