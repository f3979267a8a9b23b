"""Every public call with nonsense for each of its arguments: what it raises is an error that it documents, and no other.

The calls are found by the names that the package exports and by the attributes of results; a new one is tested once it is there.
"""

import inspect
import re
import unicodedata

import matplotlib.pyplot as plt
import numpy as np
import pytest
from conftest import paper_train, reducer

import geartrain as gt

pytestmark = [pytest.mark.full, pytest.mark.filterwarnings("ignore")]

NONSENSE = {
    "None": None, "'x'": "x", "''": "", "[]": [], "{}": {}, "object()": object(), "10**400": 10**400, "nan": float("nan"),
    "inf": float("inf"), "-1": -1, "array": np.array([1.0, 2.0]), "surrogate": "\udc80", "NUL": "a\0b", "ESC": "\x1b[2J",
    "len": len, "bytes": b"x", "list": [1], "mapping": {"x": 1}, "0-d": np.array(0.5), "train": paper_train(),
}
ENDS = {"start": 0.5, "stop": 0.52}
#: Arguments of calls: small, so that nonsense that is no nonsense for a call takes little time.
SMALL = {
    **ENDS, "frequency": 0.51, "mesh": 1, "points": 2, "parameter_points": 2, "parameter_start": 0.01, "parameter_stop": 0.02,
    "duration": 0.02, "starts": 2, "seeds": 2, "harmonics": 4, "max_periods": 20, "values": {"input_torque": 100.0},
    "parameters": "input_torque", "near": 0.459, "period": 1,
}
#: Names in arguments that are mappings.
MAPPINGS = dict.fromkeys(("values", "product", "distributions"), ("input_torque", "mesh 1 stiffness_cos", "mesh 1 stiffness_cos 1"))
SETTINGS = {"points", "parameter_points", "starts", "seeds", "harmonics", "max_periods", "period"}
#: Methods of Python's own types, and what opens a browser.
OTHERS = {*dir(list), *dir(dict), "show"}
DOCUMENTED = (gt.InputError, gt.SolverError, OSError)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """An object of each class, and the arguments that calls need beside those of `SMALL`."""
    train = paper_train()
    branch = train.response(start=0.4, stop=0.6, harmonics=4)
    folder = tmp_path_factory.mktemp("nonsense")
    (folder / "case.nml").write_text(train.namelist(response={**ENDS, "harmonics": 4}))
    case = gt.read_case(folder / "case.nml")
    space = gt.Space({"input_torque": [100.0, 150.0]})
    study = gt.Study(train, space, keep=["rms"], response={**ENDS, "harmonics": 4})
    grid = {"displacement_start": -1.0, "displacement_stop": 1.0, "velocity_start": -1.0, "velocity_stop": 1.0}
    rows = {"parameter_start": 0.01, "parameter_stop": 0.02, "parameter_points": 2}
    objects = [
        train, branch, branch.at(0.51)[0], train.sweep(**ENDS, points=2), train.modes(), case, case.run(), space, study,
        train.attractors(frequency=0.51, starts=2), train.basins(0.51, points=(2, 2), **grid), train.explain(),
        train.bifurcation_diagram(**ENDS, points=2), train.stability_map(**ENDS, points=2, **rows), gt.Page("<html>"),
        train.run_up(**ENDS, duration=0.02), reducer().campbell(start=0.1, stop=1.0), branch.special_points[0], branch.peaks(),
        train.lyapunov_spectrum(0.51, periods=20), branch.audit(points=1),
    ]
    given = {
        "page": {"results": branch}, "read_case": {"path": folder / "case.nml"}, "read_results": {"path": folder / "x"},
        "Study": {"train": train, "space": space, "keep": ["rms"], "response": {**ENDS, "harmonics": 4}},
        "Train": {name: getattr(train, name) for name in ("input_torque", "load_inertia", "shafts", "meshes")},
        "Body": {"name": "a", "inertia": 1.0}, "Train.locus": {"special": branch.special_points[0]}, "Page": {"html": "<html>"},
        "Train.lyapunov_spectrum": {"periods": 20}, "Train.basins": {"points": (2, 2), **grid}, "Branch.audit": {"points": 1},
        "Study.run": {"folder": folder / "study"}, "Study.prepare": {"folder": folder / "study"},
    }
    return objects, given


def calls_of(objects):
    """Public calls by their names."""
    for name in gt.__all__:
        public = getattr(gt, name)
        is_result = inspect.isclass(public) and name not in ("Train", "Body", "Mesh", "Shaft", "Space", "Study", "Page")
        if callable(public) and not is_result:
            yield name, public
    for item in objects:
        for name, method in inspect.getmembers(item):
            if not name.startswith("_") and inspect.ismethod(method) and name not in OTHERS:
                yield f"{type(item).__name__}.{name}", method


def attempts_of(name, call, given):
    """What to call with, by what messages call the attempt: a nonsense for each argument."""
    parameters = inspect.signature(call).parameters.values()
    for one in parameters:
        within = [(f"{key}: {word}", {key: value}) for key in MAPPINGS.get(one.name, ()) for word, value in NONSENSE.items()]
        for word, nonsense in [*NONSENSE.items(), *within]:
            named = {
                other.name: SMALL[other.name] for other in parameters
                if other.name in SMALL and (other.default is other.empty or other.name in SETTINGS)
            } | given.get(name, {})
            listed = []
            if one.kind in (one.VAR_POSITIONAL, one.POSITIONAL_ONLY):
                listed = [nonsense]
            elif one.kind is one.VAR_KEYWORD:
                named["color" if "plot" in name else "response"] = nonsense
            else:
                named[one.name] = nonsense
            yield f"{name}({one.name} = {word})", listed, named


def is_documented(error):
    """An error of the package, or one of a signature; with a message that a terminal shows as it is."""
    if any(unicodedata.category(character) in ("Cc", "Cs") for character in str(error).replace("\n", "")):
        return False
    return isinstance(error, DOCUMENTED) or (isinstance(error, TypeError) and bool(re.search(r"\) .*argument", str(error))))


def test_every_call_refuses_nonsense_in_words(found, tmp_path, monkeypatch, times):
    """By day every nineteenth attempt of twenty for each argument, which is another kind of nonsense for the next one."""
    monkeypatch.chdir(tmp_path)
    every = 19 if times(19) < 19 else 1
    objects, given = found
    wrong, count, names = [], 0, set()
    for name, call in calls_of(objects):
        for attempt, listed, named in attempts_of(name, call, given):
            count += 1
            if count % every:
                continue
            try:
                call(*listed, **named)
            except Exception as error:  # noqa: BLE001
                if not is_documented(error):
                    wrong.append(f"{attempt}: {type(error).__name__}: {error}"[:200])
            names.add(name)
            plt.close("all")
    assert not wrong, "\n".join(wrong)
    classes = {name.partition(".")[0] for name in names}
    assert count > 4000 and {"Train", "Branch", "Motion", "RunUp", "Study", "Space", "page", "read_results"} <= classes


@pytest.mark.parametrize(("call", "told"), [
    (lambda train, branch: gt.Space(distributions=[1]), r"distributions = \[1\]: must be a mapping"),
    (lambda train, branch: gt.page(train), r"results = .*: must be gt.Results"),
    (lambda train, branch: train.campbell(start=0.1, stop=10**400), "stop = 10+.*: must be a number"),
    (lambda train, branch: gt.Study("x", gt.Space({"input_torque": [1.0]}), keep=["rms"], response=ENDS), "train = 'x': must be"),
    (lambda train, branch: branch.peaks(mesh=np.array([1, 2])), r"mesh = array\(\[1, 2\]\): must be"),
    (lambda train, branch: branch.separation_ranges(np.array([1, 2])), r"mesh = array\(\[1, 2\]\): must be"),
    (lambda train, branch: branch.at(0.5)[0].phase_plane(np.array([1, 2])), r"mesh = array\(\[1, 2\]\): must be"),
    (lambda train, branch: branch.at(0.5)[0].plot(periods=np.array([1, 2])), r"periods = array\(\[1, 2\]\): must be"),
    (lambda train, branch: train.with_values({"input_torque": 10**400}), "train input_torque: .*10+.*: must be of type real"),
    (lambda train, branch: gt.read_case("a\0b"), r"path = 'a\\x00b': must be the path"),
    (lambda train, branch: gt.read_results("x\0"), "path = .*: must be"),
    (lambda train, branch: gt.Page("").write("a\0b"), r"path = 'a\\x00b': must be the path"),
])
def test_the_argument_is_named(train, branch, call, told):
    with pytest.raises(gt.InputError, match=told):
        call(train, branch)
