"""The table of the paper's figures and the command that draws them."""

import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT

from curves import Curve, compute, natural_frequencies
from figures import FIGURES, main
from paper_cases import case_texts, paper_case

TEXTS = case_texts()


def test_every_case_is_drawn():
    drawn = {curve.case for figure in FIGURES.values() for curve in figure.curves}
    assert drawn == set(TEXTS)
    assert list(FIGURES) == list(range(3, 14))


@pytest.mark.parametrize("name", TEXTS)
def test_case_reads(name):
    case = paper_case(name)
    assert case.output == f"{name}.h5"
    assert case.response is not None or case.modes


def test_natural_frequencies_are_smooth(tmp_path):
    stiffness, frequency = natural_frequencies(tmp_path)
    steps = np.diff(np.log(frequency), axis=0) / np.diff(np.log(stiffness))[:, np.newaxis]
    assert steps.min() > -1e-3 and steps.max() < 0.51  # between constant and the root of the stiffness
    assert np.abs(np.diff(steps, axis=0)).max() < 0.05
    # At 1e8 N m/rad, the train of the other figures; its highest mode has crossed the input and output shafts' modes.
    place = np.argmin(np.abs(stiffness - 1e8))
    np.testing.assert_allclose(frequency[place], [0.957059, 1.866211, 6.680664, 6.681010, 15.920627], rtol=1e-6)
    assert (frequency[0, 4] < frequency[0, 2]) and (frequency[-1, 4] > frequency[-1, 3])


def test_a_sub_harmonic_branch_ends_where_it_meets_period_1():
    train = paper_case("fig12").train
    branch = train.response(start=0.2, stop=4.6, harmonics=8, subharmonic=2, seed=train.integrate(frequency=3.7))
    assert branch.complete and branch.ended.count("met the branch of half its period") == 2
    for frequency in (2.4, 3.0, 3.6):
        rms = np.sort([motion.rms[0] for motion in branch.at(frequency)])
        assert len(rms) >= 1 and (np.diff(rms) > 1e-6).all()  # each motion once, not again a period of the fundamental later


def test_integration_stays_on_stable_motions(tmp_path):
    drawn = compute(Curve("fig07_010", ""), tmp_path)
    assert len(drawn.marks) == drawn.tried > 45
    assert drawn.difference < 1e-4
    assert (tmp_path / "fig07_010.h5").exists()


def test_command_draws(tmp_path, capsys):
    assert main(["5", "--results", str(tmp_path)]) == 0
    assert (tmp_path / "fig05.png").stat().st_size > 10_000
    assert "fig05.png" in capsys.readouterr().out


def test_command_refuses(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["14"])
    assert "must be 3 to 13" in capsys.readouterr().err
    (tmp_path / "file").touch()
    assert main(["5", "--results", str(tmp_path / "file")]) == 4


def test_figure_3_wants_a_folder(tmp_path):
    program = [sys.executable, ROOT / "example" / "paper" / "figure3.py"]
    assert subprocess.run(program, check=False, capture_output=True).returncode == 2
    assert subprocess.run([*program, tmp_path], check=False, capture_output=True).returncode == 4
