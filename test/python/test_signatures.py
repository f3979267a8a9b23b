"""The keywords of calls: the program's variables with its defaults, in signatures, in help and for type checkers."""

import inspect
import subprocess
import sys

import pytest

import geartrain as gt
from geartrain.variables import VARIABLES

CALLS = {
    "response": gt.Train.response, "integration": gt.Train.sweep, "attractors": gt.Train.attractors,
    "stability_map": gt.Train.stability_map, "run_up": gt.Train.run_up, "shaft": gt.Shaft, "mesh": gt.Mesh, "train": gt.Train,
}
ENDS = {"start": 0.2, "stop": 0.3}


@pytest.mark.parametrize("group", CALLS)
def test_every_variable_is_a_keyword_and_explained(group):
    call = CALLS[group]
    parameters = inspect.signature(call).parameters
    for name, variable in VARIABLES[group].items():
        assert name in parameters
        assert (parameters[name].default is inspect.Parameter.empty) == (variable.required and not inspect.isclass(call))
        if name not in ("frequency", "follow"):  # of attractors, which has words of its own for them
            assert f"{name} : " in call.__doc__ and variable.meaning[:40] in call.__doc__
    assert "**" not in call.__doc__


def test_defaults_are_the_programs(train, tmp_path):
    rows = {"parameter_start": 0.1, "parameter_stop": 0.2}
    given = {
        "response": ENDS, "integration": ENDS, "attractors": {"frequency": 0.6}, "stability_map": {**ENDS, **rows},
        "run_up": {**ENDS, "duration": 0.1},
    }
    path = tmp_path / "case.nml"
    path.write_text(train.namelist(**given))
    case = gt.read_case(path)
    for group, settings in given.items():
        resolved = getattr(case, group)
        assert resolved == {**{name: variable.default for name, variable in VARIABLES[group].items()}, **settings}
    signature = inspect.signature(gt.Train.integrate)
    assert signature.parameters["stability"].default is True
    assert signature.parameters["max_periods"].default == VARIABLES["integration"]["max_periods"].default


def test_a_misspelt_keyword_is_told(train):
    with pytest.raises(TypeError, match=r"response\(\) got an unexpected keyword argument 'harmonic'; did you mean 'harmonics'\?"):
        train.response(**ENDS, harmonic=6)
    with pytest.raises(TypeError, match=r"Mesh\(\) got .* 'helixangle'; did you mean 'helix_angle'\?"):
        gt.Mesh(helixangle=15)
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'colour'$"):
        gt.Shaft(colour="red")
    with pytest.raises(TypeError, match=r"response\(\) missing a required argument: 'stop'"):
        train.response(start=0.2)
    with pytest.raises(gt.InputError, match="&response: there is no harmonic: must be one of start, stop, parameter"):
        train.namelist(response={**ENDS, "harmonic": 6})
    with pytest.raises(TypeError, match="unexpected keyword argument 'respons'"):
        train.namelist(respons=ENDS)


def test_from_and_to_are_start_and_stop_wherever_they_are_named(train, tmp_path):
    names, keywords = {"from": 0.2, "to": 0.3}, {"start": 0.2, "stop": 0.3}
    rows = {"parameter_from": 0.1, "parameter_to": 0.2}
    text = train.namelist(response=names, stability_map={**keywords, **rows})
    path = tmp_path / "case.nml"
    cases = []
    for words in (text, text.replace("from =", "start =").replace("to =", "stop =")):
        path.write_text(words)
        cases.append(gt.read_case(path))
    assert cases[0].text == cases[1].text and "start =" not in cases[1].text
    assert train.namelist(response=keywords) == train.namelist(response=names)
    assert train.response(**names).ended == train.response(**keywords).ended == "reached Lambda = 0.3"
    with pytest.raises(TypeError, match="by its name and by its keyword"):
        train.response(**names, start=0.2)
    with pytest.raises(gt.InputError, match="start is given twice, also as from"):
        train.namelist(response={**names, "start": 0.2})


SCRIPT = """
import numpy as np
import geartrain as gt

shaft, mesh = gt.Shaft(rigid=True), gt.Mesh(driving_radius=0.05, stiffness_cos=np.array([0.3]), error_sin=[1e-6])
train = gt.Train(input_torque=150.0, shafts=[shaft, shaft], meshes=[mesh])
branch: gt.Branch = train.response(start=0.2, stop=2.6, harmonics=6, control="local")
train.integrate(0.9, start=branch.at(0.9)[0], max_periods=100).refine().plot()
train.attractors(frequency=0.9, follow=branch, starts=20)
train.stability_map(start=0.2, stop=2.6, parameter_start=0.0, parameter_stop=0.3, linear=True)
"""
FAULTS = {
    "train.response(start=0.2, stop=2.6, harmonic=6)": '"harmonic"',
    "train.response(start=0.2)": '"stop"',
    "train.response(start=0.2, stop=2.6, harmonics=6.5)": '"harmonics"',
    "train.response(start=0.2, stop=2.6, control='globl')": '"control"',
    "train.integrate(0.9, points=3)": '"points"',
    "gt.Mesh(half_backlsh=1e-6)": '"half_backlsh"',
    "gt.Train(shafts=[mesh])": "Shaft",
    "train.namelist(respons={})": '"respons"',
}


@pytest.mark.full
def test_type_checkers_see_the_keywords(tmp_path):
    pytest.importorskip("mypy")
    script = tmp_path / "script.py"
    script.write_text("\n".join([SCRIPT, *FAULTS]) + "\n")
    # Types of other packages take most of the time, and say nothing of keywords.
    others = "".join(f"[mypy-{name}.*]\nfollow_imports = skip\n" for name in ("matplotlib", "pandas", "scipy", "xarray"))
    (tmp_path / "mypy.ini").write_text(f"[mypy]\n{others}")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", script]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    first = SCRIPT.count("\n") + 2
    errors = [line for line in done.stdout.splitlines() if ": error: " in line]
    assert len(errors) == len(FAULTS), done.stdout
    for number, (error, word) in enumerate(zip(errors, FAULTS.values()), first):
        assert error.startswith(f"script.py:{number}: error: ") and word in error, error


def test_a_misspelt_keyword_of_a_picture_is_told(branch):
    with pytest.raises(TypeError, match=r"plot\(\) got an unexpected keyword argument 'meshs'; did you mean 'mesh'\?"):
        branch.plot(meshs=1)
    with pytest.raises(TypeError, match="'colour'; did you mean 'color'"):
        branch.at(0.4)[0].phase_plane(colour="red")
    with pytest.raises(TypeError, match=r"unexpected keyword argument 'qwertz'$"):
        branch.plot(qwertz=1)
    branch.plot(c="red", lw=1)


def test_a_part_tells_its_signature_to_every_python():
    # Python 3.10 asks `__new__`, which all parts share, where a class says nothing itself.
    assert list(gt.Mesh.__signature__.parameters) == list(inspect.signature(gt.Mesh.__init__).parameters)[1:]
