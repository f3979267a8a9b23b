"""What a newcomer tries first: a case to begin with, ``python -m geartrain``, completion by the shell, a misspelt option."""

import shutil
import subprocess
import sys

import pytest
from conftest import ROOT, run

import geartrain as gt


def test_a_new_case_runs(executable, tmp_path):
    """It shows what the program is for: a jump, and teeth that part."""
    done = run(executable, "--new", "first.nml", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "") and "geartrain first.nml" in done.stdout
    assert run(executable, "--check", "first.nml", cwd=tmp_path).stdout == "first.nml: no problems: 2 shafts, 1 mesh\n"
    done = run(executable, "first.nml", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "") and "jump down" in done.stdout and "loses contact" in done.stdout
    assert gt.read_results(tmp_path / "first.h5").response.ended.startswith("reached 2500 rpm")


def test_a_new_case_explains_every_line_and_its_own_name(executable, tmp_path):
    run(executable, "--new", "first.nml", cwd=tmp_path)
    lines = (tmp_path / "first.nml").read_text().splitlines()
    assert "first.nml" in lines[3] and "FILE" not in "".join(lines)
    bare = [line for line in lines if "=" in line.split("!")[0] and "!" not in line]
    assert not bare
    named = {word.strip(",.") for line in lines for word in line.split() if word.startswith("namelists/")}
    assert len(named) == 3 and all((ROOT / name).exists() for name in named)


def test_a_new_case_overwrites_nothing(executable, tmp_path):
    (tmp_path / "mine.nml").write_text("mine")
    done = run(executable, "--new", "mine.nml", cwd=tmp_path)
    assert done.returncode == 2 and "overwrites nothing" in done.stderr and (tmp_path / "mine.nml").read_text() == "mine"
    done = run(executable, "--new", "nowhere/mine.nml", cwd=tmp_path)
    assert done.returncode == 4 and "nowhere/mine.nml" in done.stderr
    assert run(executable, "--new", cwd=tmp_path).returncode == 2
    assert "two.nml is one too many" in run(executable, "--new", "one.nml", "two.nml", cwd=tmp_path).stderr
    assert [path.name for path in tmp_path.iterdir()] == ["mine.nml"]


def test_a_misspelt_option_is_told(executable, tmp_path):
    done = run(executable, "--chek", "case.nml", cwd=tmp_path)
    assert done.returncode == 2 and "unknown option --chek (did you mean --check?)" in done.stderr
    done = run(executable, "--from-rexs", "a.rexs", "--pitch-errors", "mesh 1 driving", "a.txt")
    assert done.returncode == 2 and "--pitch-errors is an option of geartrain-rexs" in done.stderr
    assert "needs bash, zsh or fish" in run(executable, "--completion", "tcsh", cwd=tmp_path).stderr


COMPLETING = {
    "bash": """compopt() { :; }  # only while a key is pressed
source <(geartrain --completion bash)
complete() { COMP_WORDS=("$@"); COMP_CWORD=$(($#-1)); _geartrain; echo "$* -> ${COMPREPLY[*]}"; }
complete geartrain --ch; complete geartrain --check ''; complete geartrain --completion z; complete geartrain -o ''
""",
    "zsh": """compdef() { :; }
source <(geartrain --completion zsh)
_arguments() { print -rl -- "$@"; }
_geartrain
""",
    "fish": """geartrain --completion fish | source
complete -C 'geartrain --ch'
complete -C 'geartrain --completion z'
complete -C 'geartrain --check ca'
""",
}
EXPECTED = {
    "bash": ["--ch -> --check", "--check  -> case.nml", "--completion z -> zsh", "-o  -> case.h5"],
    "zsh": ["--check[say what is wrong", "*:case:_files -g"],
    "fish": ["--check\t", "zsh\t", "case.nml"],
}


@pytest.mark.parametrize("shell", COMPLETING)
def test_shells_complete(shell, executable, tmp_path):
    if shutil.which(shell) is None:
        pytest.skip(f"no {shell}")
    for name in ("case.nml", "case.h5", "notes.txt"):
        (tmp_path / name).touch()
    (tmp_path / "script").write_text(COMPLETING[shell])
    path = f"{executable.parent}:/usr/bin:/bin"
    done = subprocess.run([shell, "script"], cwd=tmp_path, env={"PATH": path, "HOME": str(tmp_path)}, capture_output=True,
                          text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    for words in EXPECTED[shell]:
        assert words in done.stdout, done.stdout


def test_the_package_tells_what_there_is(executable, tmp_path):
    told = run(sys.executable, "-m", "geartrain", cwd=tmp_path, env={"PATH": "/usr/bin:/bin"})
    assert told.returncode == 0 and told.stdout.startswith(f"geartrain {gt.__version__}:") and "geartrain-study" in told.stdout
    handed = run(sys.executable, "-m", "geartrain", "--chek", cwd=tmp_path, env={"PATH": f"{executable.parent}"})
    assert handed.returncode == 2 and "did you mean --check?" in handed.stderr


@pytest.mark.parametrize("call, meant", [
    (lambda train, branch: gt.Mesh(stifness=1.0), "stiffness"),
    (lambda train, branch: train.response(start=0.5, stop=0.6, harmonic=3), "harmonics"),
    (lambda train, branch: train.motions(frequenc=0.5), "frequency"),
    (lambda train, branch: train.campbell(strt=0.5, stop=0.6), "start"),
    (lambda train, branch: branch.at(0.6, units="Hz"), "unit"),
    (lambda train, branch: branch.audit(point=3), "points"),
    (lambda train, branch: branch.at(0.6)[0].waveform(sample=3), "samples"),
    (lambda train, branch: branch.peaks(meshes=1), "mesh"),
    (lambda train, branch: gt.read_case(paht="case.nml"), "path"),
])
def test_a_misspelt_keyword_is_told(call, meant, train, branch):
    with pytest.raises(TypeError, match=rf"unexpected keyword argument '\w+'; did you mean '{meant}'\?"):
        call(train, branch)
