"""Files that are replaced: never what the program has not written, never by a part, and nothing of a killed writer stays."""

import contextlib
import fcntl
import signal
import subprocess
import sys
import time

import h5py
import pytest
from conftest import run, write_case

import geartrain as gt
from geartrain.pages import page_command
from geartrain.reports import report_command

QUICK = "&response from = 0.4, to = 0.42 /\n"
#: A temporary file as a killed writer leaves it.
LEFT = "{}.0123456789ABCDEF.tmp"
KILLED = """
import os, signal, sys
import geartrain as gt
from geartrain.pages import page_command
from geartrain.reports import report_command
html = gt.Page("<html>" + "new" * 20_000_000)
print("begin", flush=True)
html.write(sys.argv[1])
"""


def names(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("content", [b"print('precious')\n", b"", b"\x89HDF\r\n\x1a\n" + bytes(600)])
def test_what_is_no_results_file_is_not_replaced(executable, tmp_path, content):
    """Be it named in &output, by --output or in a call; told before anything is computed."""
    case, precious = write_case(tmp_path, QUICK), tmp_path / "precious.py"
    results = gt.read_case(case).run()
    named = write_case(tmp_path, QUICK + "&output file = 'precious.py' /\n", "named.nml")
    precious.write_bytes(content)
    for arguments in ((case, "-o", precious), (named,), (case, "-o", precious, "--resume")):
        done = run(executable, *arguments, cwd=tmp_path)
        assert done.returncode == 4 and "precious.py: error: cannot be written: there is a file that is no results" in done.stderr
        assert "MODES" not in done.stdout and "Response" not in done.stdout
    with pytest.raises(OSError, match="no results file of geartrain"):
        results.write(precious)
    assert precious.read_bytes() == content and names(tmp_path) == ["case.nml", "named.nml", "precious.py"]
    precious.unlink()
    for _ in range(2):  # the second time it is a results file
        assert run(executable, case, "-o", precious).returncode == 0
        results.write(precious)
    assert h5py.is_hdf5(precious)


@pytest.mark.parametrize("command", [page_command.main, report_command.main])
@pytest.mark.parametrize("content", [b"print('precious')\n", b"", b"\x89HDF\r\n\x1a\n" + bytes(600)])
def test_what_is_no_page_is_not_replaced(executable, tmp_path, capsys, command, content):
    """By the commands that make pages and reports; the second time it is one."""
    case, precious = write_case(tmp_path, QUICK), tmp_path / "precious.html"
    assert run(executable, case, "-o", tmp_path / "a.h5").returncode == 0
    precious.write_bytes(content)
    arguments = [str(tmp_path / "a.h5"), "-o", str(precious)]
    assert command(arguments) == 2 and "precious.html: is neither a page nor a report" in capsys.readouterr().err
    assert precious.read_bytes() == content
    precious.unlink()
    assert command(arguments) == command(arguments) == 0


def test_what_killed_writers_left_is_removed(executable, tmp_path):
    """By a run that completes or resumes, and by the next page; what is still being written, and files of other names stay."""
    case, output, page = write_case(tmp_path, QUICK), tmp_path / "out.h5", tmp_path / "page.html"
    held = tmp_path / LEFT.replace("0", "F").format("out.h5")
    others = ["out.h5.0123.tmp", "other.h5.0123456789ABCDEF.tmp", "out.h5.0123456789ABCDEF.tmp.txt", held.name]
    for name in others:
        (tmp_path / name).write_text("stays")
    with held.open() as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        for call, paths in (
            (lambda: run(executable, case, "-o", output), ("out.h5", "out.h5.partial")),
            (lambda: run(executable, case, "-o", output, "--resume"), ("out.h5", "out.h5.partial")),
            (lambda: gt.read_results(output).write(output), ("out.h5",)), (lambda: gt.Page("<html>").write(page), ("page.html",)),
        ):
            for path in paths:
                (tmp_path / LEFT.format(path)).write_text("left")
            call()
            assert not [name for path in paths for name in names(tmp_path) if name == LEFT.format(path)]
    assert {*names(tmp_path)} == {"case.nml", "out.h5", "page.html", *others}


@pytest.mark.full
def test_a_killed_page_is_the_old_one_or_the_new_one(tmp_path):
    path = tmp_path / "page.html"
    for wait in (0.0, 0.005, 0.01, 0.02, 0.04, 0.08):
        path.write_text("old")
        work = subprocess.Popen([sys.executable, "-c", KILLED, path], stdout=subprocess.PIPE)
        assert work.stdout.readline() == b"begin\n"
        time.sleep(wait)
        work.send_signal(signal.SIGKILL)
        work.communicate()
        text = path.read_text()
        assert text == "old" or (text.startswith("<html>new") and len(text) == 60_000_006)
    gt.Page("<html>").write(path)
    assert names(tmp_path) == ["page.html"]


def test_what_a_killed_study_left_is_removed(train, tmp_path):
    """By the next run of the study; a file whose writer lives stays."""
    space = gt.Space({"input_torque": [100.0]})
    study = gt.Study(train, space, keep=["rms"], response={"start": 0.5, "stop": 0.51, "harmonics": 3})
    study.run(tmp_path, progress=False)
    left, held = ([tmp_path / folder / f"{word}.tmp" for folder in ("batches", "plans", "branches")] for word in ("left", "held"))
    for path in (*left, *held):
        path.write_bytes(b"part of a file")
    with contextlib.ExitStack() as stack:
        for path in held:
            fcntl.flock(stack.enter_context(path.open("rb")), fcntl.LOCK_EX)
        study.run(tmp_path, progress=False)
        assert not any(path.exists() for path in left) and all(path.exists() for path in held)
    study.run(tmp_path, progress=False)
    assert not [*tmp_path.glob("*/*.tmp")]
