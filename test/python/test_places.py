"""Where files and messages go: what is not this run's is left alone, and nothing that is told is lost without a word."""

import os
import random
import resource
import shutil
import subprocess
import time
from pathlib import Path

import h5py
import pytest
from conftest import assert_equal_files, run, write_case
from test_faults import QUICK, kill_at_checkpoint, names

MEANWHILE = "&response from = 0.2, to = 2.6, step = 0.001, max_points = 100000 /\n"


def test_the_checkpoint_of_another_run_is_left_alone(executable, tmp_path):
    case, output = write_case(tmp_path, QUICK), tmp_path / "out.h5"
    partial = tmp_path / "out.h5.partial"
    partial.write_bytes(b"of somebody else")
    done = run(executable, case, "--output", output)
    assert done.returncode == 2 and "out.h5.partial: error: a run that was killed" in done.stderr, done
    done = run(executable, case, "--output", output, "--resume")
    assert done.returncode == 4 and "cannot be resumed" in done.stderr
    assert partial.read_bytes() == b"of somebody else" and names(tmp_path) == ["case.nml", "out.h5.partial"]
    partial.unlink()
    partial.symlink_to(tmp_path / "nowhere")
    assert run(executable, case, "--output", output).returncode == 2
    assert partial.is_symlink()


@pytest.mark.parametrize("other", ["link", "file"])
def test_a_checkpoint_that_comes_meanwhile_is_left_alone(executable, tmp_path, other):
    """Another run's file at the place of this run's checkpoint, which this run then neither overwrites nor removes."""
    case, output = write_case(tmp_path, MEANWHILE), tmp_path / "out.h5"
    partial = tmp_path / "out.h5.partial"
    work = subprocess.Popen([executable, case, "--output", output], stdout=subprocess.DEVNULL)
    while not partial.exists():
        assert work.poll() is None
        time.sleep(0.01)
    new = tmp_path / "new"
    if other == "file":
        new.write_bytes(b"of somebody else" * 10)
    else:
        new.symlink_to("elsewhere")
    new.rename(partial)
    assert work.wait() == 0 and output.exists()
    if other == "file":
        assert partial.read_bytes() == b"of somebody else" * 10
    else:
        assert partial.is_symlink()
    assert not (tmp_path / "elsewhere").exists()


def test_a_case_is_not_taken_for_a_checkpoint(executable, tmp_path):
    case = write_case(tmp_path, QUICK).rename(tmp_path / "run.partial")
    text = case.read_bytes()
    done = run(executable, "run.partial", "--output", "run", cwd=tmp_path)
    assert done.returncode == 2 and "run.partial, where the results are kept meanwhile, is a case" in done.stderr, done
    (tmp_path / "other.nml").write_bytes(text + b"&output file = 'a.h5.partial' /\n")
    (tmp_path / "a.nml").write_bytes(text)
    done = run(executable, "a.nml", "other.nml", cwd=tmp_path)
    assert done.returncode == 2 and "other.nml: error: its results would overwrite those of a.nml" in done.stderr, done
    assert case.read_bytes() == text and names(tmp_path) == ["a.h5", "a.nml", "other.nml", "run.partial"]


def test_temporary_files_follow_no_link(executable, tmp_path):
    """Every name that one has ever had leads elsewhere; those to come cannot be foreseen."""
    case, output = write_case(tmp_path, QUICK), tmp_path / "out.h5"
    work = subprocess.Popen(["strace", "-f", "-e", "trace=openat,rename", executable, case, "--output", output],
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) if shutil.which("strace") else None
    if work is not None:
        _, calls = work.communicate(timeout=60)
        made = [line for line in calls.splitlines() if ".tmp" in line and "O_CREAT" in line]
        assert made and all("O_EXCL" in line for line in made), made
        assert len({line.split('"')[1] for line in made}) == len(made)
    output.unlink(missing_ok=True)
    for pid in range(os.getpid(), os.getpid() + 300):  # as they were named once
        (tmp_path / f"out.h5.{pid}.tmp").symlink_to("victim")
    assert run(executable, case, "--output", output).returncode == 0
    assert h5py.is_hdf5(output) and not (tmp_path / "victim").exists()


def test_a_link_at_the_target_is_replaced(executable, tmp_path):
    case, output = write_case(tmp_path, QUICK), tmp_path / "out.h5"
    output.symlink_to("victim")
    assert run(executable, case, "--output", output).returncode == 0
    assert not output.is_symlink() and not (tmp_path / "victim").exists()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full on this system")
def test_lost_standard_output_is_an_exit_status(executable, tmp_path):
    case = write_case(tmp_path, QUICK)
    output = tmp_path / "out.h5"
    for arguments in (["--template"], ["--version"], ["--help"], ["--reference"], ["--check", case],
                      [case, "--output", output]):
        with open("/dev/full", "w") as full:
            done = subprocess.run([executable, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert done.returncode == 4 and "standard output is lost" in done.stderr, (arguments, done)
        read, write = os.pipe()
        os.close(read)
        done = subprocess.run([executable, *arguments], stdout=write, stderr=subprocess.PIPE, text=True, check=False)
        os.close(write)
        assert done.returncode == 4 and "standard output is lost" in done.stderr, (arguments, done)
        done = run("bash", "-c", 'exec "$@" >&-', "bash", executable, *arguments)
        assert done.returncode == 4 and "standard output is lost" in done.stderr, (arguments, done)
        done = run("bash", "-c", 'exec "$@" 2>&-', "bash", executable, *arguments)
        assert done.returncode == 0 and done.stdout, (arguments, done)
    assert h5py.is_hdf5(output), "the results are not lost with what is told of them"


def test_a_vanished_reader_does_not_end_the_other_cases(executable, tmp_path):
    for name in ("one", "two", "three", "four"):
        write_case(tmp_path, QUICK).rename(tmp_path / f"{name}.nml")
    files = [f"{name}.nml" for name in ("one", "two", "three", "four")]
    done = run("bash", "-c", '"$@" | true; exit ${PIPESTATUS[0]}', "bash", executable, *files, cwd=tmp_path)
    assert done.returncode == 4 and len(list(tmp_path.glob("*.h5"))) == 4, done


def test_a_pipe_without_a_writer_is_told(executable, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    begin = time.monotonic()
    for arguments in (["pipe"], ["--check", "pipe"]):
        done = run(executable, *arguments, cwd=tmp_path, timeout=20)
        assert done.returncode == 2 and "must be a regular file" in done.stderr
    case = write_case(tmp_path, QUICK)
    os.mkfifo(tmp_path / "out.h5.partial")
    done = run(executable, case, "--output", "out.h5", "--resume", cwd=tmp_path, timeout=20)
    assert done.returncode == 4 and "cannot be resumed" in done.stderr
    assert time.monotonic() - begin < 10


def test_too_little_memory_is_told(executable, tmp_path):
    """OpenBLAS asks for ever for memory that it does not get."""
    case = write_case(tmp_path, QUICK)
    statuses = set()
    for kilobytes in (180_000, 200_000, 250_000, 300_000, 350_000, 400_000, 500_000, 700_000):
        limit = kilobytes * 1024
        done = run(executable, case, "--output", tmp_path / "out.h5", timeout=60,
                   preexec_fn=lambda limit=limit: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        statuses.add(done.returncode)
        told = done.returncode == 0 or "memory" in done.stderr or "shared libraries" in done.stderr
        assert told and done.returncode in (0, 4, 127), (kilobytes, done)
    assert {0, 4} <= statuses


def processor_time(process):
    """Seconds of processor time that a process has had: on a busy machine it gets on by these, not by the clock."""
    numbers = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(numbers[11]) + int(numbers[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.nightly
def test_frequent_kills_do_not_keep_a_run_from_its_end(executable, tmp_path):
    """A kill after every second or two of processor time: each resumed run gets on, as its first checkpoint comes after 0.3 s."""
    case = write_case(tmp_path, (
        "&response from = 0.4, to = 2.6, period_doublings = 1, refine = .true. /\n"
        "&integration from = 0.5, to = 1.0, points = 60 /\n&attractors frequency = 0.6, starts = 100 /\n"
        "&stability_map from = 0.4, to = 1.6, points = 10, parameter_from = 0.01, parameter_to = 0.1, parameter_points = 20 /\n"
    ))
    output, plain = tmp_path / "out.h5", tmp_path / "plain.h5"
    assert run(executable, case, "--output", plain).returncode in (0, 3)
    moments = random.Random(11)
    kills = 0
    while kills < 60:
        work = subprocess.Popen([executable, case, "--output", output, "--resume"], stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL)
        last = moments.uniform(1.0, 2.0)
        while work.poll() is None and processor_time(work.pid) < last:
            time.sleep(0.02)
        if work.poll() is not None:
            assert work.returncode in (0, 3)
            break
        work.kill()
        work.wait()
        kills += 1
    assert_equal_files(plain, output)
    assert kills > 0, "it was killed"


def test_resumed_run_owns_its_checkpoint(executable, tmp_path):
    case, output = write_case(tmp_path, MEANWHILE), tmp_path / "out.h5"
    partial = kill_at_checkpoint(executable, case, output)
    done = run(executable, case, "--output", output)
    assert done.returncode == 2 and partial.exists() and not output.exists()
    assert run(executable, case, "--output", output, "--resume").returncode == 0
    assert output.exists() and not partial.exists()
