"""Every variable of the contract given wrongly, in a file and in a call: the variables come from `geartrain --reference`,
so that a new one is tested as soon as it is in the table."""

import re
import subprocess
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from conftest import paper_train

import geartrain as gt

#: What a message must say to be of help: what is expected, or what to do.
CURE = (
    r"must |did you mean|there are |belongs to|leave out|takes one value|has no value|given twice|empty value|more than"
    r"|takes 2 names|joined in its order"
    r"|lacks |not closed|expected \"=\"|give the whole list|values are separated by commas"
)
GIVEN = {
    "body": {"name": "'x'", "inertia": "1.0"},
    "bearing": {"body": "'x'"},
    "train": {"input_torque": "150.0", "prime_mover_inertia": "2.3e-7", "load_inertia": "2.3e-7",
              "characteristic_length": "3e-5", "characteristic_frequency": "9870.0"},
    "shaft": {"stiffness": "1e3"},
    "mesh": {"driving_radius": "0.05", "driven_radius": "0.1", "driving_inertia": "0.0023", "driven_inertia": "0.037",
             "stiffness": "2.5e8", "stiffness_cos": "0.3"},
    "response": {"from": "0.2", "to": "2.6"},
    "integration": {"from": "0.2", "to": "2.6"},
    "attractors": {"frequency": "0.6"},
    "basins": {"frequency": "0.6"},
    "bifurcation_diagram": {"from": "0.2", "to": "2.6"},
    "stability_map": {"from": "0.2", "to": "2.6", "parameter_from": "0.01", "parameter_to": "0.1"},
    "run_up": {"from": "0.2", "to": "2.6", "duration": "0.1"},
    "locus": {"near": "0.46", "parameter": "'input_torque'", "from": "100.0", "to": "200.0"},
    "output": {},
}
WORDS = {f"{begin}{end}": f"{begin}{word}" for begin in ("", "parameter_", "displacement_", "velocity_")
         for end, word in (("from", "start"), ("to", "stop"))}


class Variable(NamedTuple):
    group: str
    name: str
    kind: str
    required: bool
    allowed: str

    @property
    def has_least(self):
        return ">" in self.allowed or " to " in self.allowed


@pytest.fixture(scope="module")
def whole_table(executable):
    text = subprocess.run([executable, "--reference"], check=True, capture_output=True, text=True).stdout
    variables = []
    for line in text.splitlines():
        if heading := re.match(r"## `&(\w+)`", line):
            group = heading[1]
        elif row := re.match(r"\| `(\w+)` \|", line):
            cells = [cell.strip() for cell in line.split("|")[1:-1]]
            variables.append(Variable(group, row[1], cells[1].partition(" [")[0], cells[2] == "required", cells[3]))
    kinds = {variable.kind for variable in variables}
    assert len(variables) > 50 and kinds == {"real", "integer", "logical", "text", "reals", "names"}
    return variables


@pytest.fixture(scope="module")
def table(whole_table):
    # The trains here have no planetary sets: these have a test of their own.
    return [variable for variable in whole_table if variable.group != "planetary"]


def case_text(table, fault=None, assignment="", without=""):
    """A whole case, one assignment a line; `assignment` takes the place of the faulty variable's own."""
    groups = dict.fromkeys(variable.group for variable in table)
    lines = []
    model = ("train", "body", "shaft", "mesh", "coupling", "bearing")
    order = ["train", "shaft", "mesh", "shaft", *(group for group in groups if group not in model)]
    if fault is not None and fault.group in ("body", "coupling", "bearing"):
        order[1:1] = dict.fromkeys(["body", fault.group])  # else a chain
    for number, group in enumerate(order):
        given = {v.name: GIVEN.get(group, {}).get(v.name, "1.0") for v in table if v.group == group and v.required}
        given.update(GIVEN.get(group, {}))
        faulty = fault is not None and fault.group == group and number != order.index("mesh") + 1
        if faulty or group == without:
            given.pop(fault.name if faulty else "", None)
        lines.append(f"&{group}")
        lines.extend(f"   {name} = {value}" for name, value in given.items())
        if faulty:
            lines.extend(f"   {line}" for line in assignment.splitlines())
        lines.append("/")
    return "\n".join(lines) + "\n"


def faults(variable):
    """Namelist assignments of the variable that must be refused."""
    name, kind = variable.name, variable.kind
    wrong_types = {
        "real": ["'abc'", "abc", ".true.", "1.0.0", "0x10", "1,5"],
        "reals": ["'abc'", "0.1 x", ".true."],
        "integer": ["'3'", "1.5", "x", "99999999999"],
        "logical": ["3", "'yes'", "maybe"],
        "text": ["5", "bare", ".true."],
        "names": ["5", "bare", ".true.", "'a'", "''"],
    }
    values = list(wrong_types[kind])
    if kind in ("real", "reals", "integer"):
        values += ["NaN", "Inf", "-Infinity", "1e999"]
    if kind in ("real", "integer") and variable.has_least:
        values.append("-7.0" if kind == "real" else "-7")
    if kind == "text" and variable.allowed:
        values.append("'nonsense'")
    if kind == "text":
        values += [f"'{chr(7)}'", "'not closed"]
    values.append({"reals": "1001*1.0", "text": "'a' 'b'", "names": "'a', 'b', 'c'"}.get(kind, "1, 2"))
    lines = [f"{name} = {value}" for value in values]
    good = {"real": "1.0", "reals": "0.1", "integer": "1", "logical": ".true.", "text": "'x'", "names": "'a', 'b'"}[kind]
    lines += [f"{name} =", f"{name} = , {good}", f"{name} {good}", f"{name}(1) = {good}", f"{name}%x = {good}"]
    lines += [f"{name} = {good}\n{name} = {good}", f"{name[:-1]}q{name[-1]}q = {good}", f"{name} = = {good}"]
    return lines


def test_every_variable_given_wrongly(table, tmp_path, times):
    """By day every third fault: others of the next variable."""
    path = tmp_path / "case.nml"
    path.write_text(case_text(table))
    gt.read_case(path)
    count, every = 0, 3 if times(3) < 3 else 1
    for variable in table:
        for assignment in faults(variable):
            count += 1
            if count % every:
                continue
            text = case_text(table, variable, assignment)
            path.write_text(text)
            with pytest.raises(gt.InputError) as caught:
                gt.read_case(path)
            messages = str(caught.value).splitlines()
            faulty = [n for n, line in enumerate(text.splitlines(), 1) if line.strip() in assignment.splitlines()]
            begins = tuple(f"{path}:{line}:" for line in faulty)
            told = [message for message in messages if message.startswith(begins)]
            assert told, (assignment, messages)
            assert all(": error: " in message for message in messages)
            assert all(re.search(CURE, message) for message in told), (assignment, told)
            assert any(variable.name in message or variable.name[:-1] + "q" in message for message in told), (assignment, told)
    assert count > 10 * len(table)


PLANETARY = {"name": "'s'", "sun": "'sun'", "ring": "'ring'", "carrier": "'arm'", "teeth": "27, 36, 99", "planets": "3",
             "normal_module": "2.5e-3", "face_width": "0.03"}


def planetary_text(fault, assignment):
    """A case with a planetary set, in which `assignment` takes the place of the faulty variable's own."""
    given = [f"   {name} = {value}" for name, value in PLANETARY.items() if fault is None or name != fault.name]
    return "\n".join([
        "&train", "/", "&body name = 'sun', inertia = 1e-3, torque = 100.0 /", "&body name = 'ring', held = .true. /",
        "&body name = 'arm', inertia = 0.1, balances = .true. /", "&planetary", *given,
        *(f"   {line}" for line in assignment.splitlines()), "/", "&modes /", ""])


def test_every_variable_of_a_planetary_set_given_wrongly(whole_table, tmp_path):
    path = tmp_path / "case.nml"
    path.write_text(planetary_text(None, ""))
    gt.read_case(path)
    variables = [variable for variable in whole_table if variable.group == "planetary"]
    count = 0
    for variable in variables:
        wrong = faults(variable)
        if variable.kind == "reals":  # of three gears, of two kinds of meshes, of the planets: none has 40 values
            wrong.append(f"{variable.name} = 40*-1e30")
        for assignment in wrong:
            text = planetary_text(variable, assignment)
            path.write_text(text)
            with pytest.raises(gt.InputError) as caught:
                gt.read_case(path)
            count += 1
            faulty = [n for n, line in enumerate(text.splitlines(), 1) if line.strip() in assignment.splitlines()]
            told = [message for message in str(caught.value).splitlines()
                    if message.startswith(tuple(f"{path}:{line}:" for line in faulty))]
            assert told, (assignment, str(caught.value))
            assert any(re.search(CURE, message) for message in told), (assignment, told)  # 'x' is no body besides
            assert any(variable.name in message or variable.name[:-1] + "q" in message for message in told), (assignment, told)
    assert count > 12 * len(variables)


@pytest.mark.parametrize("extreme", [1e300, 1e-300, 1e200, 1e-200, -1e300])
def test_every_number_beyond_all_scales(table, tmp_path, extreme):
    """Products of such numbers are none. A next to vanishing amplitude in a list is one of 0."""
    path = tmp_path / "case.nml"
    count = 0
    for variable in table:
        if variable.kind not in ("real", "reals"):
            continue
        path.write_text(case_text(table, variable, f"{variable.name} = {extreme}"))
        if variable.kind == "reals" and abs(extreme) < 1:
            # One body is too few; errors of gears need teeth.
            if variable.group != "body" and variable.name.endswith(("_cos", "_sin")) and not variable.name.startswith("driv"):
                gt.read_case(path)
            continue
        with pytest.raises(gt.InputError) as caught:
            gt.read_case(path)
        name = f"{variable.name}( harmonic 1| value 1)?"
        told = rf"&{variable.group}.*: {name} = {re.escape(str(extreme))}: must .*of a magnitude from"
        assert re.search(told, str(caught.value)), caught.value
        count += 1
    assert count > 25


def test_next_to_vanishing_amplitudes_are_none():
    """Homogeneity at its end: amplitudes of 1e-200 give the motion of those of 0."""
    meshes = [replace(mesh, error_cos=[1e-200], stiffness_sin=[1e-300]) for mesh in paper_train().meshes]
    tiny, none = paper_train(meshes=meshes, torque_cos=[1e-300]), paper_train()
    settings = {"start": 0.4, "stop": 0.41, "harmonics": 6}
    assert tiny.response(**settings).rms[0] == pytest.approx(none.response(**settings).rms[0], rel=1e-12)
    assert tiny.integrate(0.4).rms == pytest.approx(none.integrate(0.4).rms, rel=1e-9)


def test_a_stability_map_of_trains_that_cannot_be_computed():
    ends = {"start": 1.7, "stop": 2.1, "points": 3, "parameter_points": 2}
    with pytest.raises(gt.InputError, match=r"parameter = 'mesh_damping_ratio': .* = 1\.0e6: "
                                            r"&mesh 1: damping_ratio = 1\.0e6: must be smaller"):
        paper_train().stability_map(**ends, parameter="mesh_damping_ratio", parameter_start=0.1, parameter_stop=1e6)


def test_what_is_required_is_missed(table, tmp_path):
    path = tmp_path / "case.nml"
    for variable in table:
        if variable.required:
            path.write_text(case_text(table, variable))
            place = rf"{re.escape(str(path))}:\d+:\d+"
            with pytest.raises(gt.InputError, match=rf"{place}: error: &{variable.group}.*lacks {variable.name}"):
                gt.read_case(path)


def test_every_group_given_wrongly(table, tmp_path):
    path = tmp_path / "case.nml"
    whole = case_text(table)

    def refused(text, message):
        path.write_text(text)
        with pytest.raises(gt.InputError, match=message):
            gt.read_case(path)

    for group in {variable.group for variable in table} - {"body", "coupling", "bearing"}:  # there is none in a chain
        begin = whole.index(f"&{group}\n")
        end = whole.index("\n/\n", begin) if f"&{group}\n/\n" not in whole else begin + len(group) + 1
        refused(whole[:end] + "\n" + whole[end + 2:], f"&{group}.*has no closing /")
        refused(whole.replace(f"&{group}\n", f"&{group}q\n"), f"unknown group &{group}q")
        if group not in ("shaft", "mesh"):
            block = whole[begin:end + 3]
            refused(whole + block, f"&{group}: stands twice; the first is on line")
        if group in ("train", "shaft", "mesh"):
            refused(whole[:begin] + whole[end + 2:], "&(train|shaft|mesh)")
            block = whole[begin:end + 3]
            refused(whole[:begin] + whole[end + 3:] + block, "train|must|stands|follows")
    for group in ("shaft", "mesh"):
        both = case_text(table, Variable(group, "damping", "real", False, ""), "damping = 1.0\n   damping_ratio = 0.1")
        refused(both, "is given together with damping_ratio: leave out one of the two")


def test_all_problems_in_one_go_and_no_output_touched(table, executable, tmp_path):
    """One wrong value for each variable of a group, in all groups: as many messages, sorted by line."""
    lines = []
    analyses = ("response", "integration", "attractors", "stability_map", "run_up", "locus")
    for group in ("train", "shaft", "mesh", "shaft", *analyses, "output"):
        lines.append(f"&{group}")
        for variable in table:
            if variable.group == group:
                lines.append(f"   {variable.name} = {'5' if variable.kind == 'text' else 'x'}")
        lines.append("/")
    case, output = tmp_path / "bad.nml", tmp_path / "bad.h5"
    case.write_text("\n".join(lines))
    output.write_bytes(b"precious")
    before = output.stat()
    done = subprocess.run([executable, case, "--output", output], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and done.stdout == ""
    numbers = [int(re.match(rf"{re.escape(str(case))}:(\d+):", line)[1]) for line in done.stderr.splitlines()]
    wrong = [n for n, line in enumerate(lines, 1) if line.startswith("   ")]
    assert numbers == sorted(numbers) and set(wrong) <= set(numbers)
    assert output.read_bytes() == b"precious" and output.stat().st_mtime_ns == before.st_mtime_ns
    assert sorted(file.name for file in tmp_path.iterdir()) == ["bad.h5", "bad.nml"]


def call(group, name, value):
    """A Python call with one keyword given so."""
    name = WORDS.get(name, name)
    train = paper_train()
    if group == "train":
        return paper_train(**{name: value})
    if group in ("shaft", "mesh"):
        parts = list(getattr(train, group + ("es" if group == "mesh" else "s")))
        kind = type(parts[0])
        fields = {key: getattr(parts[0], key) for key in kind.__dataclass_fields__}
        parts[0] = kind(**{**fields, name: value})
        return paper_train(**{"meshes" if group == "mesh" else "shafts": parts})
    if group == "coupling":
        return gt.Train(characteristic_length=3e-5, characteristic_frequency=9870.0, bodies=[gt.Body(name="x", inertia=1.0)],
                        couplings=[gt.Coupling(**{name: value})]).natural_frequencies()
    if group == "bearing":
        return gt.Train(characteristic_length=3e-5, characteristic_frequency=9870.0, bodies=[gt.Body(name="x", inertia=1.0)],
                        bearings=[gt.Bearing(**{"body": "x", "mass": 1.0, name: value})]).natural_frequencies()
    if group == "body":
        body = gt.Body(**{"name": "x", "inertia": 1.0, name: value})
        return gt.Train(characteristic_length=3e-5, characteristic_frequency=9870.0, bodies=[body]).natural_frequencies()
    if group == "response":
        return train.response(**{"start": 0.2, "stop": 0.3, name: value})
    if group == "integration":
        return train.sweep(**{"start": 0.2, "stop": 0.3, "points": 2, name: value})
    if group == "stability_map":
        given = {"start": 0.2, "stop": 0.3, "points": 2, "parameter_start": 0.01, "parameter_stop": 0.1, "parameter_points": 2}
        return train.stability_map(**{**given, name: value})
    if group == "run_up":
        return train.run_up(**{"start": 0.2, "stop": 0.3, "duration": 0.1, name: value})
    if group == "bifurcation_diagram":
        return train.bifurcation_diagram(**{"start": 0.2, "stop": 0.3, "points": 2, name: value})
    if group == "basins":
        return train.basins(**{"frequency": 0.6, "starts": 1, name: value})
    return train.attractors(**{"frequency": 0.6, "starts": 1, name: value})


def test_every_keyword_given_wrongly(table, times):
    """By day every third wrong value: others of the next keyword."""
    count, every = 0, 3 if times(3) < 3 else 1
    wrong = {
        "real": ["x", [1.0, 2.0], np.ones(1), float("nan"), float("inf"), True, 1j, {}],
        "reals": ["x", [0.1, "x"], [[0.1, 0.2]], np.ones((2, 2)), [float("nan")], np.array([np.inf]), {1: 2}, 0.1j, b"a",
                  np.array(0.1)],
        "integer": ["3", 1.5, [3], float("nan"), True, 10**12],
        "logical": ["yes", 3, [True], 0.0],
        "text": [5, b"x", ["x"], "a\nb", "\x07"],
    }
    for variable in table:
        # What &attractors calls follow is a branch in a call; the points of &basins are a pair.
        apart = (("attractors", "follow"), ("basins", "displacement_points"), ("basins", "velocity_points"))
        if variable.group == "output" or (variable.group, variable.name) in apart:
            continue
        # Names that are no pair of texts are tried in case files, whose messages are the same. A locus takes a special point.
        if variable.kind == "names" or variable.group == "locus":
            continue
        values = wrong[variable.kind] + ([-7] if variable.has_least else [])
        for value in values:
            count += 1
            if count % every:
                continue
            with pytest.raises(gt.InputError) as caught:
                call(variable.group, variable.name, value)
            keyword = WORDS.get(variable.name, variable.name)
            told = rf"^&{variable.group}[ 0-9]*: {keyword}( (harmonic|value) \d+)? = .*must "
            assert re.search(told, str(caught.value), re.MULTILINE)
            assert not re.search(r"\b(from|to) = |\b(from|to)\b\"|\.(true|false)\.", str(caught.value))
        with pytest.raises(TypeError):
            call(variable.group, variable.name + "q", 1)


def test_all_problems_of_a_call_in_one_go():
    """Wrong types and wrong values, of the train, of its parts and of the settings, in one message."""
    shafts = [gt.Shaft(stiffness="stiff"), gt.Shaft(stiffness=-1.0), gt.Shaft(rigid="yes")]
    meshes = [gt.Mesh(driving_radius=[0.05], driven_radius=-0.1, stiffness=float("nan"), order=1.5)]
    with pytest.raises(gt.InputError) as caught:
        paper_train(input_torque="x", load_inertia=-1.0, torque_cos=[[1.0]], shafts=shafts, meshes=meshes)
    told = str(caught.value).splitlines()
    for begin in (
        "&train: input_torque = 'x': must be a number", "&train: torque_cos = ", "&train: load_inertia = -1.0: must be >= 0",
        "&shaft 1: stiffness = 'stiff': must be a number", "&shaft 2: stiffness = -1.0: must be > 0",
        "&shaft 3: rigid = 'yes': must be True or False", "&mesh 1: driving_radius = [0.05]: must be a number",
        "&mesh 1: order = 1.5: must be a whole number", "&mesh 1: driven_radius = -0.1: must be > 0",
        "&mesh 1: stiffness = nan: must be a finite number",
        "&shaft 3: follows &shaft 2: a &mesh must",
    ):
        assert sum(line.startswith(begin) for line in told) == 1, (begin, told)
    # What was given, though wrongly, is not said to be lacking.
    assert not re.search("lacks (input_torque|driving_radius)|&shaft 1: lacks", str(caught.value))
    with pytest.raises(gt.InputError) as caught:
        paper_train().response(start="x", stop="y", harmonics=1.5, step=0.0, stability=3)
    assert len(str(caught.value).splitlines()) == 5


def test_messages_have_the_words_of_the_call():
    """The keyword is `start`, as `from` is a word of Python; a case file's messages say `from`."""
    train = paper_train()
    ends = {"start": 0.5, "stop": 0.5}
    rows = {"parameter_start": 0.1, "parameter_stop": 0.1}
    slow = ("at a slower speed there are some 10000 vibrations or more of the slowest mesh in a cycle of the teeth of mesh 1, too "
            "many to be followed; begin there: a slower train follows its loads and errors without vibration")
    rigid = gt.Shaft(rigid=True, stiffness=1.0)
    for work, *told in (
        (lambda: train.response(start=-1, stop=2.0), "&response: start = -1.0: must be > 0"),
        (lambda: train.response(start="x", stop=0),
         "&response: start = 'x': must be a number", "&response: stop = 0.0: must be > 0"),
        (lambda: train.response(start=None, stop=2.0), "&response: lacks start"),
        (lambda: train.response(start=1e-9, stop=2.0), f"&response: start = 1.0e-9: must be >= 0.0001: {slow}"),
        (lambda: train.response(**ends), '&response: stop = 0.5: must differ from "start": a branch needs a range'),
        (lambda: train.response(start=0.5, stop=0.6, period_doublings=1, stability=False),
         "&response: period_doublings = 1: needs stability = True: the multipliers tell where a period doubles"),
        (lambda: train.response(start=0.5, stop=0.6, period_doublings=1, subharmonic=2, harmonics=6),
         "&response: period_doublings = 1: must be 0 where subharmonic > 1: from rest the motion is one of period 1, whose "
         "doublings are followed with subharmonic = 1"),
        (lambda: train.sweep(**ends), '&integration: points = 121: must be 1 where "start" and "stop" are equal'),
        (lambda: train.stability_map(**ends, **rows), '&stability_map: stop = 0.5: must differ from "start"',
         '&stability_map: parameter_points = 200: must be 1 where "parameter_start" and "parameter_stop" are equal, and only '
         "there"),
        (lambda: train.integrate(-1), "&integration: frequency = -1.0: must be > 0"),
        (lambda: train.integrate(float("nan")), "&integration: frequency = nan: must be a finite number"),
        (lambda: train.integrate(0, tolerance="x"),
         "&integration: tolerance = 'x': must be a number", "&integration: frequency = 0.0: must be > 0"),
        (lambda: paper_train(shafts=[rigid, *train.shafts[1:]]),
         "&shaft 1: stiffness = 1.0: contradicts rigid = True: leave out one of the two"),
    ):
        with pytest.raises(gt.InputError) as caught:
            work()
        assert str(caught.value).splitlines() == told


def test_one_frequency_in_the_trains_own_units():
    """Only the frequency given is held against the slowest allowed, 1e-4 of the train's own."""
    train = paper_train(characteristic_frequency=9870e-5)
    assert train.integrate(0.4e5).rms == pytest.approx(paper_train().integrate(0.4).rms, rel=1e-8)
    with pytest.raises(gt.InputError, match=r"^&integration: frequency = 1\.0: must be >= 10\.0: "):
        train.integrate(1.0)


def test_what_would_fill_the_memory_is_refused(executable, tmp_path):
    """No Fortran error stop that takes the interpreter along."""
    train = paper_train()
    for call in (
        lambda: train.sweep(start=0.2, stop=0.3, points=2_000_000_000),
        lambda: train.attractors(frequency=0.6, starts=2_000_000_000),
        lambda: train.response(start=0.2, stop=0.3, max_points=2_000_000_000),
        lambda: train.stability_map(start=0.2, stop=0.3, parameter_start=0.1, parameter_stop=0.2, points=20_000),
    ):
        with pytest.raises(gt.InputError, match="and <= "):
            call()
    case = tmp_path / "case.nml"
    case.write_text(train.namelist(attractors={"frequency": 0.6}).replace("frequency = 0.6", "frequency = 0.6 starts = 2000000000"))
    done = subprocess.run([executable, case], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "starts = 2000000000: must be >= 1 and <= " in done.stderr


def test_nothing_to_compute_writes_nothing(executable, tmp_path):
    """Results must not be replaced by a file of nothing."""
    case, output = tmp_path / "case.nml", tmp_path / "case.h5"
    case.write_text(paper_train().namelist())
    output.write_bytes(b"precious")
    done = subprocess.run([executable, case, "--output", output], capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "nothing to compute" in done.stderr and "add &modes" in done.stderr
    assert output.read_bytes() == b"precious"


@pytest.mark.parametrize(("content", "message"), [
    (b"", "there is no &train group"),
    (b"\x89HDF\r\n\x1a\n\x00\x00", "binary file"),
    (b"\x7fELF" + bytes(1000), "binary file"),
    (bytes(range(1, 256)) * 100, "text outside of a group"),
    (b"&train title = 'Zahnr\xe4der' /", "one line of UTF-8 text"),
    (b"&a/ " * 400_000, "more than 10000 groups"),
    (b"&train\n" + b"x=1\n" * 400_000 + b"/", "more than 100 variables: is a closing / missing?"),
    (b"&train title='" + b"x" * 9_000_000, "the quote is not closed on its line"),
    (b"&" + b"x" * 9_000_000, "unknown group"),
])
def test_files_of_junk(content, message, tmp_path):
    path = tmp_path / "junk.nml"
    path.write_bytes(content)
    with pytest.raises(gt.InputError, match=message):
        gt.read_case(path)


@pytest.mark.parametrize(("character", "told"), [
    ("\u00a0", 'found "\u00a0" (U+00A0)'), ("\u00e4", 'found "\u00e4" (U+00E4)'), ("\u2028", "(U+2028)"),
    ("\U0001f469", 'found "\U0001f469" (U+1F469)'), ("\ufeff", "(U+FEFF)"), ("?", 'found "?"'),
])
def test_messages_show_whole_characters(executable, table, tmp_path, character, told):
    """Standard error is UTF-8, whichever character stands where none must."""
    path = tmp_path / "case.nml"
    path.write_text(case_text(table).replace("&train\n", f"&train\n{character}\n", 1), encoding="utf-8")
    done = subprocess.run([executable, "--check", path], capture_output=True, check=False)
    assert done.returncode == 2 and told in done.stderr.decode(), done
    with pytest.raises(gt.InputError, match=re.escape(told)):
        gt.read_case(path)


@pytest.mark.parametrize("line", [b"\xe4 = 1", b"\xa0", b"input_torque = \xe4", b"title = 'Zahnr\xe4der'", b"\xf0\x9f"])
def test_messages_about_files_that_are_not_utf_8_are(executable, table, tmp_path, line):
    path = tmp_path / "case.nml"
    path.write_bytes(case_text(table).encode().replace(b"&train\n", b"&train\n" + line + b"\n", 1))
    done = subprocess.run([executable, "--check", path], capture_output=True, check=False)
    assert done.returncode == 2 and "case.nml:2:" in done.stderr.decode(), done


def test_files_that_are_none(executable, tmp_path):
    huge = tmp_path / "huge.nml"
    with huge.open("wb") as file:
        file.truncate(100_000_000)
    for name, message in (("huge.nml", "at most 10 MB"), (".", "regular file|cannot be"), ("none.nml", "no such file")):
        done = subprocess.run([executable, name], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 2 and re.search(message, done.stderr), done.stderr
    pipe = subprocess.run([executable, "/dev/stdin"], input="&train /", capture_output=True, text=True, check=False)
    assert pipe.returncode == 2 and "must be a regular file" in pipe.stderr
    secret = tmp_path / "secret.nml"
    secret.write_text("&train /")
    secret.chmod(0)
    done = subprocess.run([executable, secret], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2  # for root, whom no mode keeps out, the train is incomplete
    assert sorted(file.name for file in tmp_path.iterdir()) == ["huge.nml", "secret.nml"]


def test_line_ends_marks_and_titles(table, tmp_path):
    path = tmp_path / "case.nml"
    title = "Zähne, 歯車, ⚙, it''s"
    text = case_text(table).replace("&train\n", f"&train\n   title = '{title}'\n", 1)
    expected = title.replace("''", "'")
    for content in (text, text.replace("\n", "\r\n"), "\ufeff" + text, "\ufeff" + text.replace("\n", "\r\n")):
        path.write_bytes(content.encode())
        assert gt.read_case(path).train.title == expected
