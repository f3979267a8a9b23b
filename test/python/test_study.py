"""Studies: the same numbers as calls one by one, whatever computes them; what a folder holds, and what it lacks."""

import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import h5py
import numpy as np
import pandas as pd
import pytest
import xarray as xr
from conftest import paper_train, reducer, single_pair
from tqdm import tqdm

import geartrain as gt
from geartrain._core import watch
from geartrain.studies import study as study_module
from geartrain.studies import study_progress
from geartrain.studies.jump_identity import identify
from geartrain.studies.study_command import main
from geartrain.studies.study_store import Store
from geartrain.studies.study_worker import compute_batch

RANGE = {"start": 0.4, "stop": 1.2}
KEEP = ["peaks", "jumps", "special_points", "largest dynamic_factor", "first jump up", "rms"]


def pair_study(space=None, keep=KEEP, **analysis):
    """Of a train that takes a few milliseconds."""
    space = space or gt.Space({"input_torque": [0.3, 0.4, 0.5], "mesh 1 damping_ratio": [0.04, 0.05]})
    return gt.Study(single_pair(0.4, stiffness_cos=[0.3]), space, keep=keep, **(analysis or {"response": RANGE}))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return pair_study().run(tmp_path_factory.mktemp("whole"))


def computed(folder):
    """Keys of all records in a folder."""
    store = Store(folder)
    return [key for path in store.paths() for key in store.read(path).keys.tolist()]


def test_every_point_is_what_the_calls_give(whole):
    assert whole.sizes["input_torque"] == 3 and (whole.status == "done").all() and (whole.ended == "reached Lambda = 1.2").all()
    for torque in (0.3, 0.4, 0.5):
        for ratio in (0.04, 0.05):
            branch = single_pair(torque, damping_ratio=ratio, stiffness_cos=[0.3]).response(**RANGE)
            point = whole.sel({"input_torque": torque, "mesh 1 damping_ratio": ratio})
            number = len(branch)
            np.testing.assert_array_equal(point.frequency[:number], branch.frequency)
            np.testing.assert_array_equal(point.rms[:number], branch.rms)
            assert point.frequency[number:].isnull().all()
            peaks, jumps = branch.peaks(), branch.jumps
            for name in ("frequency", "rms", "mesh_force_maximum", "dynamic_factor"):
                np.testing.assert_array_equal(point[f"peak_{name}"].dropna("peak"), [getattr(peak, name) for peak in peaks])
            there = point.jump_frequency.notnull()
            np.testing.assert_array_equal(np.sort(point.jump_frequency[there]), [jump.frequency for jump in jumps])
            assert sorted(point.jump_kind.values[there.values]) == sorted(jump.kind for jump in jumps)
            specials = [special.frequency for special in branch.special_points]
            np.testing.assert_array_equal(point.special_point_frequency.dropna("special_point"), specials)
            assert point["largest dynamic_factor"] == branch.dynamic_factor[branch.stable].max()
            assert point["first jump up"] == min(jump.frequency for jump in jumps if jump.kind == "jump up")


def test_everything_has_its_unit(whole, tmp_path):
    assert whole.rms.attrs["units"] == "1" and "rms of the paper" in whole.rms.attrs["description"]
    assert whole.input_torque.attrs == {
        "units": "N m", "description": "Mean torque at the driving end of a chain",
    }
    assert whole.peak_mesh_force_maximum.attrs["units"] == "N"
    assert whole.attrs["analysis"] == "response" and "stiffness_cos" in whole.attrs["case"]
    whole.to_netcdf(tmp_path / "study.nc", engine="h5netcdf")
    xr.testing.assert_identical(xr.open_dataset(tmp_path / "study.nc", engine="h5netcdf").load().rms, whole.rms)


class Backwards(Executor):
    """Runs what is submitted when the first result is asked for, the last first."""

    def __init__(self):
        self.waiting = []

    def submit(self, call, *arguments):
        future = Future()
        self.waiting.append((future, call, arguments))
        if len(self.waiting) == 6:
            for future, call, arguments in reversed(self.waiting):
                future.set_result(call(*arguments))
        return self.waiting[-1][0]


@pytest.mark.parametrize("executor", ["threads", "processes", "backwards", "batches of another size", "our own pool"])
def test_the_same_bits_from_any_executor(executor, whole, tmp_path, monkeypatch):
    study = pair_study()
    if executor == "threads":
        with ThreadPoolExecutor(3) as pool:
            found = study.run(tmp_path, pool)
    elif executor == "processes":
        with ProcessPoolExecutor(2, get_context("spawn")) as pool:
            found = study.run(tmp_path, pool)
    elif executor == "our own pool":
        monkeypatch.setattr("geartrain.studies.study._SMALL", 0.0)
        monkeypatch.setattr("geartrain.studies.study.cores", lambda: 2)
        found = study.run(tmp_path)
    else:
        monkeypatch.setattr("geartrain.studies.study.cores", lambda: 6 if executor == "backwards" else 1)
        monkeypatch.setattr("geartrain.studies.study._SPREAD", 1)
        found = study.run(tmp_path, Backwards() if executor == "backwards" else None)
    assert found.equals(whole) and found.identical(whole)
    assert len(computed(tmp_path)) == len(set(computed(tmp_path))) == 6


def test_what_is_there_is_not_computed_again(tmp_path):
    study = pair_study(gt.Space({"input_torque": [0.3, 0.4]}), ["largest rms"])
    first = study.run(tmp_path)
    files = Store(tmp_path).paths()
    assert study.run(tmp_path).identical(first) and Store(tmp_path).paths() == files
    wider = pair_study(gt.Space({"input_torque": [0.2, 0.3, 0.4]}), ["largest rms"])
    assert wider.explain(tmp_path).done == 2
    assert wider.run(tmp_path)["largest rms"][1:].values.tolist() == first["largest rms"].values.tolist()
    assert len(computed(tmp_path)) == 3
    other = pair_study(gt.Space({"input_torque": [0.3, 0.4]}), ["smallest rms"])
    assert other.explain(tmp_path).done == 0


def test_a_key_is_of_what_is_computed():
    train = single_pair(0.4, stiffness_cos=[0.3])

    def key(values, train=train, keep=("rms",), relative=False, **settings):
        study = gt.Study(train, gt.Space(values, relative=relative), keep=keep, response={**RANGE, **settings})
        return study._plan.keys[0]

    known = key({"input_torque": [0.2]})
    assert known == key({"input_torque": [0.5]}, relative=True)
    assert known == key({"input_torque": [0.2]}, harmonics=6)
    assert known == key({"mesh 1 phase": [0.0]}, train=single_pair(0.2, stiffness_cos=[0.3]))
    assert known == key({"input_torque": [0.2]}, train=gt.Train(**{**vars_of(train), "title": "another"}))
    assert len({known, key({"input_torque": [0.2]}, keep=["mean"]), key({"input_torque": [0.2]}, harmonics=7),
                key({"input_torque": [np.nextafter(0.2, 1)]}), key({"load_inertia": [0.2]})}) == 5


def vars_of(train):
    return {name: value for name, value in vars(train).items() if not name.startswith("_")}


def test_duplicates_are_computed_once(tmp_path):
    study = pair_study(gt.Space(sample={"input_torque": [0.3, 0.4, 0.3, 0.3]}), ["largest rms"])
    told = study.explain()
    assert (told.points, told.duplicates) == (4, 2) and "4 points, 2 of them duplicates" in str(told)
    found = study.run(tmp_path)["largest rms"].values
    assert found[0] == found[2] == found[3] != found[1] and len(computed(tmp_path)) == 2


def test_explained_before_anything_runs(tmp_path):
    told = pair_study().explain(tmp_path / "runs")
    assert (told.points, told.done, told.failed, told.problem) == (6, 0, 0, "") and told.seconds > 0
    assert "input_torque: 3 values from 0.3 to 0.5" in str(told) and not (tmp_path / "runs").exists()
    study = gt.Study(single_pair(0.4), gt.Space({"input_torque": [0.3]}), response={"start": -1.0, "stop": 1.0}, keep=["rms"])
    assert "start = -1.0: must be > 0" in study.explain().problem


def test_a_failed_point_is_a_status_and_a_message(tmp_path):
    study = pair_study(gt.Space({"mesh 1 half_backlash": [1.0, -1.0]}), ["largest rms", "jumps"])
    with pytest.warns(UserWarning, match="1 of 2 points failed, the first with InputError: &mesh 1"):
        found = study.run(tmp_path)
    assert found.status.values.tolist() == ["done", "failed"] and found["largest rms"].isnull().values.tolist() == [False, True]
    assert found.message[1] == "InputError: &mesh 1: half_backlash = -1.0: must be >= 0 m"
    assert study.explain(tmp_path).failed == 1
    with pytest.warns(UserWarning, match="points failed"):
        study.run(tmp_path)
    assert len(computed(tmp_path)) == 2
    with pytest.warns(UserWarning, match="points failed"):
        assert study.run(tmp_path, retry=True).identical(found)
    assert len(computed(tmp_path)) == 2
    with pytest.warns(UserWarning, match="2 of 2 points failed"):
        every = pair_study(gt.Space({"mesh 1 half_backlash": [-1.0, -2.0]}), ["jumps"]).run(tmp_path / "none")
    assert (every.status == "failed").all()


@pytest.mark.parametrize("point", [(2, 1, 0), (3, 0), (-1, 0), 6, -1, 1.5, "first", True, None, (0, 0.5)])
def test_a_point_that_is_not_there_is_told(point):
    with pytest.raises(gt.InputError, match="must be a number from 0 to 5, or 2 places, 0 to 2 of input_torque, 0 to 1 of mesh"):
        pair_study().branch(point)


def test_failures_are_told_by_their_kind(tmp_path, capsys):
    """By `run`, `explain` and the command: how many, the first point with its values, and why."""
    values = {"mesh 1 half_backlash": [1.0, -1.0, 1.1, -2.0], "mesh 1 damping_ratio": [0.05, 0.05, -1.0, 0.05]}
    study = pair_study(gt.Space(sample=values), ["largest rms"])
    with pytest.warns(UserWarning, match=r"3 of 4 points failed, .* at point 1 \(mesh 1 half_backlash = -1, mesh 1 .*explain"):
        study.run(tmp_path)
    lines = ["failed: 2 points, the first point 1 (mesh 1 half_backlash = -1, mesh 1 damping_ratio = 0.05): InputError: &mesh 1: "
             "half_backlash = -1.0: must be >= 0 m",
             "failed: point 2 (mesh 1 half_backlash = 1.1, mesh 1 damping_ratio = -1): InputError: &mesh 1: damping_ratio = -1.0: "
             "must be >= 0"]
    assert str(study.explain()).splitlines()[-2:] == lines
    for arguments in ([], ["--status"], ["--retry"]):
        assert main([str(tmp_path), *arguments]) == 1
        said = capsys.readouterr().out.splitlines()
        assert [line for line in said if line.startswith("failed")] == lines
        assert ("3 points that failed are computed again" in said) == (arguments == ["--retry"])


def test_the_status_of_a_part_is_that_of_its_points(tmp_path, capsys):
    study = pair_study(gt.Space(sample={"mesh 1 half_backlash": [1.0, -1.0]}), ["largest rms"])
    study.prepare(tmp_path, parts=2)
    assert [main([str(tmp_path), "--part", part]) for part in ("2/2", "1/2")] == [1, 0]
    assert [main([str(tmp_path), "--retry", "--part", part]) for part in ("1/2", "2/2")] == [0, 1]


def test_a_part_of_a_study_is_a_dataset_as_well(tmp_path, whole):
    study = pair_study()
    study.prepare(tmp_path, parts=6)
    plan = Store(tmp_path).plan()
    assert plan.blocks == 6
    compute_batch(str(tmp_path), plan.digest, 4)
    found = study.dataset(tmp_path)
    assert (found.status == "done").sum() == 1 and (found.status == "missing").sum() == 5
    there = found.isel({"input_torque": 2, "mesh 1 damping_ratio": 0})
    assert there["largest dynamic_factor"] == whole.isel({"input_torque": 2, "mesh 1 damping_ratio": 0})["largest dynamic_factor"]


def test_whole_branches_are_files_on_demand(tmp_path):
    study = pair_study(gt.Space({"input_torque": [0.3, 0.4], "mesh 1 damping_ratio": [0.04, 0.05]}), ["largest rms"])
    study.run(tmp_path)
    branch = study.branch((1, 0))
    path, = (tmp_path / "branches").iterdir()
    with h5py.File(path) as file:
        assert "response" in file
    again = gt.read_study(tmp_path).branch(2)
    np.testing.assert_array_equal(again.coefficients, branch.coefficients)
    assert again.train.meshes[0].damping_ratio == 0.04 and again.at(0.8)[0].rms.size == 1
    with pytest.raises(gt.InputError, match="from 0 to 3"):
        study.branch(4)


@pytest.mark.parametrize(("analysis", "keep", "dimensions"), [
    ({"modes": {}}, ["natural_frequency", "shape"], ("mode", "element")),
    ({"integrate": {"frequency": 0.8}}, ["rms", "period", "largest dynamic_factor"], ("mesh",)),
    ({"sweep": {"start": 0.5, "stop": 0.8, "points": 3}}, ["rms"], ("point", "mesh")),
    ({"attractors": {"frequency": 0.8, "starts": 4}}, ["rms", "share"], ("motion", "mesh")),
    ({"run_up": {"start": 0.5, "stop": 0.6, "duration": 20.0}}, ["mesh_force_maximum"], ("window", "mesh")),
    ({"stability_map": {"start": 0.5, "stop": 1.0, "points": 3, "parameter_start": 0.1, "parameter_stop": 0.2,
                        "parameter_points": 2}}, ["stable_motions"], ("parameter", "frequency")),
])
def test_any_analysis(analysis, keep, dimensions, tmp_path):
    space = gt.Space({"input_torque": [0.3, 0.4]})
    study = pair_study(space, keep, **analysis)
    found = study.run(tmp_path)
    (call, settings), = analysis.items()
    assert (found.status == "done").all(), found.message.values
    assert {*dimensions} <= {*found.dims}
    expected = getattr(single_pair(0.3, stiffness_cos=[0.3]), call)(**settings).to_dataset()
    for name in keep[:2]:
        mine = found[name][0].values
        theirs = expected[name].values
        np.testing.assert_array_equal(mine[tuple(slice(length) for length in theirs.shape)], theirs)


def test_keywords_of_the_analysis_are_parameters(tmp_path):
    space = gt.Space({"integrate frequency": [0.7, 0.8], "input_torque": [0.3, 0.4]})
    found = pair_study(space, ["rms"], integrate={"frequency": 0.5}).run(tmp_path)
    pair = single_pair(0.4, stiffness_cos=[0.3])
    assert found.rms.sel({"integrate frequency": 0.8, "input_torque": 0.4}) == pair.integrate(frequency=0.8).rms[0]
    harmonics = pair_study(gt.Space({"response harmonics": [3, 6]}), ["largest rms"]).run(tmp_path / "harmonics")
    expected = [pair.response(**RANGE, harmonics=number) for number in (3, 6)]
    assert harmonics["largest rms"].values.tolist() == [branch.rms[branch.stable].max() for branch in expected]


def test_a_train_from_the_drawing_has_speeds(tmp_path):
    study = gt.Study(reducer(), gt.Space({"motor torque": [60.0, 90.0]}), keep=["jumps", "peaks", "speed"],
                     response={"start": 1450, "stop": 1500, "unit": "rpm", "harmonics": 0, "tolerance": 0.1})
    found = study.run(tmp_path)
    assert found.speed.attrs["units"] == "rpm" and found.speed.max() <= 1500.001
    assert list(found.mesh_label.values) == ["pinion 1 - wheel 1", "pinion 2 - wheel 2"]


@pytest.mark.parametrize(("arguments", "told"), [
    ({"keep": ["dynamic_facto"], "response": RANGE}, 'did you mean "dynamic_factor"'),
    ({"keep": ["largest dynamic_facto"], "response": RANGE}, 'did you mean "dynamic_factor"'),
    ({"keep": ["jumps"], "modes": {}}, "results of modes have none"),
    ({"keep": [], "response": RANGE}, "must be a list of names"),
    ({"keep": ["rms"]}, "must be one call"),
    ({"keep": ["rms"], "respons": RANGE}, "a train has no such call"),
    ({"keep": ["rms"], "response": {"start": 0.2}}, "missing a required argument"),
    ({"keep": ["rms"], "attractors": {"frequency": 0.2, "follow": single_pair(0.4)}}, "a study takes numbers"),
])
def test_what_is_no_study_is_told(arguments, told):
    with pytest.raises(gt.InputError, match=told):
        gt.Study(single_pair(0.4), gt.Space({"input_torque": [1.0]}), **arguments)


def test_an_executor_is_one(tmp_path):
    with pytest.raises(gt.InputError, match="executor = 4: must be None"):
        pair_study().run(tmp_path / "never", executor=4)
    assert not any(tmp_path.iterdir())


def test_the_csv_of_a_user(tmp_path):
    generator = np.random.default_rng(1)
    ranges = {"input_torque": (0.2, 0.5), "mesh 1 damping_ratio": (0.03, 0.1)}
    table = pd.DataFrame({name: generator.uniform(*ends, 500) for name, ends in ranges.items()})
    table.to_csv(tmp_path / "samples.csv", index=False)
    train = single_pair(0.4, stiffness_cos=[0.3])
    study = gt.Study(train, gt.Space(sample=pd.read_csv(tmp_path / "samples.csv")), modes={}, keep=["damping_ratio"])
    found = study.run(tmp_path / "runs")
    np.testing.assert_allclose(found.damping_ratio[:, 0], table["mesh 1 damping_ratio"], rtol=1e-12)
    assert found.to_dataframe().index.nlevels == 2


def test_jumps_keep_their_identity_over_a_known_family():
    """Two families that cross in Lambda, alike in all but their rms; a third that is there on one side alone."""
    generator = np.random.default_rng(0)
    parameters = generator.uniform(-1, 1, (400, 3))
    one, other = 1 + 0.1 * parameters[:, 0], 1 - 0.1 * parameters[:, 0]
    third = np.where(parameters[:, 1] > 0, 2.0 + 0.1 * parameters[:, 2], np.nan)
    frequency = np.stack([one, other, third], axis=1)
    size = np.array([1.0, 3.0, 1.0])
    order = np.argsort(frequency, axis=1)
    found = identify(parameters, np.take_along_axis(frequency, order, 1), np.full((400, 3), "rising"), np.full((400, 3), "fold"),
                     size[order][:, :, np.newaxis] * np.ones(2))
    assert found.total == 3
    expected = np.where(np.isnan(np.take_along_axis(frequency, order, 1)), -1, order)
    renamed = {(int(a), int(b)) for a, b in zip(found.number.ravel(), expected.ravel(), strict=True)}
    assert len(renamed) == 4 and (-1, -1) in renamed
    assert found.followed[found.number != expected.max()].mean() > 0.6


def test_jumps_of_a_train_that_varies_keep_their_places(tmp_path):
    names = [f"mesh {number} {what}" for number in (1, 2) for what in ("stiffness", "damping_ratio")]
    sample = np.random.default_rng(0).uniform(0.98, 1.02, (12, 4))
    study = gt.Study(paper_train(), gt.Space(sample=sample, names=names, relative=True), keep=["jumps"],
                     response={"start": 1.3, "stop": 1.7})
    found = study.run(tmp_path)
    branch = paper_train().response(start=1.3, stop=1.7)
    assert found.sizes["jump"] == len(branch.jumps) and found.jump_followed.all() and found.jump_frequency.notnull().all()
    np.testing.assert_allclose(found.jump_frequency.mean("sample"), [jump.frequency for jump in branch.jumps], rtol=0.01)
    for place, jump in enumerate(branch.jumps):
        assert {*found.jump_direction.values[:, place]} == {jump.direction}


def test_a_train_that_takes_long_itself_holds_up_no_study(tmp_path, monkeypatch, capfd):
    # The range of the train itself takes minutes, those of the points take milliseconds.
    monkeypatch.setattr(study_module, "_LONGEST_TRIAL", 0.3)
    train, space = paper_train(), gt.Space({"response stop": [0.21, 0.22]})
    study = gt.Study(train, space, response={"start": 0.2, "stop": 2.6, "step": 1e-5, "max_points": 10**6}, keep=["largest rms"])
    begun = time.monotonic()
    told = study.explain(tmp_path)
    assert time.monotonic() - begun < 5.0
    assert told.seconds is None and told.problem == "" and "the train itself takes longer than" in str(told)
    monkeypatch.setattr(watch, "progress_bar", lambda *_: None)
    monkeypatch.setattr(study_progress, "progress_bar", lambda *_: tqdm(total=2, disable=False))
    assert (study.run(tmp_path, ThreadPoolExecutor(1)).status == "done").all()
    assert "expected: unknown, since the train itself takes longer" in capfd.readouterr().err
