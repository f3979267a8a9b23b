"""Points of a study: products, samples, distributions; and what a parameter's name means."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from conftest import paper_train, reducer
from scipy import stats

import geartrain as gt


def points_of(space):
    return list(zip(*(column.tolist() for column in space.columns().values()), strict=True))


def train_at(train, parameters, **options):
    """The train of the first point, by what a study computes."""
    values = {name: [value] for name, value in parameters.items()}
    study = gt.Study(train, gt.Space(values, **options), modes={}, keep=["natural_frequency"])
    return study.branch(0).train


def test_products_have_the_last_parameter_the_fastest():
    space = gt.Space({"input_torque": [50, 100], "mesh 2 half_backlash": np.array([1e-6, 2e-6, 3e-6])})
    assert space.shape == (2, 3) and len(space) == 6
    assert points_of(space) == [(50, 1e-6), (50, 2e-6), (50, 3e-6), (100, 1e-6), (100, 2e-6), (100, 3e-6)]


def test_samples_come_in_any_form():
    rows = [(50.0, 1e-6), (100.0, 2e-6)]
    names = ["input_torque", "mesh 2 half_backlash"]
    for space in (
        gt.Space(sample=pd.DataFrame(rows, columns=names)),
        gt.Space(sample=dict(zip(names, zip(*rows, strict=True), strict=True))),
        gt.Space(sample=np.array(rows), names=names),
    ):
        assert space.parameters == tuple(names) and space.shape == (2,)
        assert points_of(space) == rows


def test_spaces_multiply():
    ends = gt.Space(sample={"load_inertia": [1.0, 2.0], "prime_mover_inertia": [3.0, 4.0]})
    space = gt.Space({"input_torque": [50.0, 100.0]}) * ends
    assert space.shape == (2, 2)
    assert points_of(space) == [(50, 1, 3), (50, 2, 4), (100, 1, 3), (100, 2, 4)]
    twice = gt.Space(sample={"input_torque": [1.0]}) * gt.Space(sample={"load_inertia": [2.0, 3.0]})
    assert [axis.name for axis in twice.axes] == ["sample", "sample 2"]


@pytest.mark.parametrize("method", ["random", "sobol", "latin hypercube"])
def test_distributions_are_those_of_scipy(method):
    known = {"input_torque": stats.norm(100, 5), "load_inertia": stats.uniform(1, 2)}
    space = gt.Space(distributions=known, samples=256, method=method, random_seed=3)
    assert points_of(space) == points_of(gt.Space(distributions=known, samples=256, method=method, random_seed=3))
    assert points_of(space) != points_of(gt.Space(distributions=known, samples=256, method=method, random_seed=4))
    for name, distribution in known.items():
        assert stats.kstest(space.columns()[name], distribution.cdf).pvalue > 0.01
    if method != "random":  # one point in each of 256 slices
        ranks = np.floor(stats.uniform(1, 2).cdf(space.columns()["load_inertia"]) * 256)
        assert len(set(ranks)) == 256


@pytest.mark.parametrize(("arguments", "told"), [
    ({}, "at least one parameter"),
    ({"product": {"input_torque": []}}, "must be a list of numbers"),
    ({"product": {"input_torque": [1.0, np.nan]}}, "value 1, counted from 0, is not finite"),
    ({"product": {"input_torque": stats.norm()}}, "give it in distributions"),
    ({"product": {3: [1.0]}}, "must be a name"),
    ({"sample": {"input_torque": [1.0], "load_inertia": [1.0, 2.0]}}, "different lengths"),
    ({"sample": np.ones((2, 3)), "names": ["input_torque"]}, r"\(2, 3\)"),
    ({"distributions": {"input_torque": stats.norm()}}, "samples = None"),
    ({"distributions": {"input_torque": 3.0}, "samples": 4}, "must be a distribution"),
    ({"distributions": {"input_torque": stats.norm()}, "samples": 4, "method": "halton"}, "'sobol'"),
    ({"product": {"input_torque": [1.0]}, "sample": {"input_torque": [1.0]}}, "given twice"),
])
def test_what_is_no_space_is_told(arguments, told):
    with pytest.raises(gt.InputError, match=told):
        gt.Space(**arguments)


def test_a_parameter_is_named_as_in_the_case():
    train = paper_train()
    first, second = train.meshes
    ends, middle = train.shafts[::2], train.shafts[1]
    for parameters, expected in (
        ({"input_torque": 90.0}, replace(train, input_torque=90.0)),
        ({"mesh 2 half_backlash": 1e-5}, replace(train, meshes=(first, replace(second, half_backlash=1e-5)))),
        ({"mesh * damping_ratio": 0.1}, replace(train, meshes=[replace(mesh, damping_ratio=0.1) for mesh in train.meshes])),
        ({"shaft 2 stiffness": 1e6}, replace(train, shafts=(ends[0], replace(middle, stiffness=1e6), ends[1]))),
        ({("mesh 1 damping_ratio", "mesh 2 damping_ratio"): 0.1},
         replace(train, meshes=[replace(mesh, damping_ratio=0.1) for mesh in train.meshes])),
        ({"mesh 1 stiffness_cos": 0.2}, replace(train, meshes=(replace(first, stiffness_cos=0.2), second))),
        ({"stiffness_variation": 0.2}, replace(train, meshes=[replace(mesh, stiffness_cos=0.2) for mesh in train.meshes])),
        ({"mesh 2 order": 2}, replace(train, meshes=(first, replace(second, order=2)))),
    ):
        assert train_at(train, parameters) == expected, parameters


def test_relative_values_multiply_the_trains_own():
    train = paper_train()
    found = train_at(train, {"mesh * stiffness": 0.9, "mesh 1 stiffness_cos": 1.1}, relative=True)
    assert [mesh.stiffness for mesh in found.meshes] == [0.9 * 2.5e8, 0.9 * 5e8]
    assert [mesh.stiffness_cos for mesh in found.meshes] == [(1.1 * 0.3,), (0.3,)]


def test_one_value_of_a_list():
    meshes = [replace(mesh, stiffness_cos=[0.3, 0.1], stiffness_sin=[0.2]) for mesh in paper_train().meshes]
    train = paper_train(meshes=meshes)
    assert train_at(train, {"mesh 1 stiffness_cos 2": 0.05}).meshes[0].stiffness_cos == (0.3, 0.05)
    # The amplitude of the first harmonic is that of its cosine and sine together.
    scaled = train_at(train, {"stiffness_variation": np.hypot(0.3, 0.2) / 2}).meshes[1]
    np.testing.assert_allclose([*scaled.stiffness_cos, *scaled.stiffness_sin], [0.15, 0.05, 0.1])
    assert train_at(train, {"mesh 1 stiffness_cos": 2.0}, relative=True).meshes[0].stiffness_cos == (0.6, 0.2)
    with pytest.raises(gt.InputError, match="has 2 values: say which"):
        train_at(train, {"mesh 1 stiffness_cos": 0.1})
    with pytest.raises(gt.InputError, match="has 2 values"):
        train_at(train, {"mesh 1 stiffness_cos 3": 0.1})
    with pytest.raises(gt.InputError, match="numbered from 1"):
        train_at(train, {"mesh 1 stiffness_cos 0": 0.1})
    with pytest.raises(gt.InputError, match="its values are named by their numbers, 1 to 2"):
        train.continuation(parameter="mesh 1 stiffness_cos 0", start=0.1, stop=0.3, frequency=0.8)


def test_bodies_go_by_their_names():
    train = reducer()
    assert train_at(train, {"motor inertia": 0.03}).bodies[0].inertia == 0.03
    assert train_at(train, {"load inertia": 2.0}).bodies[-1].inertia == 2.0
    assert train_at(train, {"wheel 1 inertia": 0.5}).bodies[2].inertia == 0.5


@pytest.mark.parametrize(("name", "told"), [
    ("mesh 2 half_baklash", 'did you mean "mesh 2 half_backlash"'),
    ("input_torqe", 'did you mean "input_torque"'),
    ("mesh 3 half_backlash", "the train has &mesh 1 to 2"), ("body 1 inertia", "the train has no &body"),
    ("response harmonic", 'did you mean "response harmonics"'),
    ("", "there is none of this name"),
    ("xyz", "it is a variable of &train"),
    ("mesh 1 stiffness 2", "is no list"),
])
def test_an_unknown_parameter_is_told(name, told):
    with pytest.raises(gt.InputError, match=told):
        gt.Study(paper_train(), gt.Space({name: [1.0]}), response={"start": 0.2, "stop": 0.3}, keep=["rms"])


@pytest.mark.parametrize(("arguments", "told"), [
    ({"product": {"mesh * damping_ratio": [0.1], "mesh 1 damping_ratio": [0.2]}}, "is set by another one as well"),
    ({"product": {"mesh 2 order": [1.5]}}, "must be of type integer"),
    ({"product": {"mesh 2 half_backlash": ["wide"]}}, "must be of type real"),
    ({"product": {"mesh 2 half_backlash": [1e-5, "20 um", 3e-5]}}, "value 1, counted from 0, '20 um': must be of type real"),
    ({"product": {"mesh 2 order": [1, 2, 2.5]}}, "value 2, counted from 0, 2.5: must be of type integer"),
    ({"product": {"mesh 2 stiffness_sin": [1.1]}, "relative": True}, "has no number of its own"),
])
def test_values_that_do_not_go_with_the_parameter_are_told(arguments, told):
    with pytest.raises(gt.InputError, match=told):
        gt.Study(paper_train(), gt.Space(**arguments), response={"start": 0.2, "stop": 0.3}, keep=["rms"])


@pytest.mark.parametrize(("sample", "told"), [
    (pd.DataFrame({"Unnamed: 0": [0, 1], "input_torque": [1.0, 2.0]}), "index=False"),
    (pd.DataFrame({"input_torque": []}), "has no rows"),
    (pd.DataFrame(), "has no columns"),
    (pd.DataFrame({"input_torque": [1.0, np.nan, 2.0, np.inf]}), "value 1, counted from 0, is not finite, nor are 1 more"),
    (pd.DataFrame({"input_torque": [1.0, None]}), "value 1"),
])
def test_a_rotten_table_is_told(sample, told):
    with pytest.raises(gt.InputError, match=told):
        gt.Space(sample=sample)


@pytest.mark.parametrize(("parameters", "told"), [
    ({"mesh 1 teeth": 23}, "say which, 'mesh 1 teeth 1'$"),
    ({"mesh 1 damping_ratio": [0.1, 0.2]}, "must be one value"),
    ({"mesh 1 damping_ratio": None}, "must be one value"),
    ({"mesh * damping_ratio": 0.1, "mesh 1 damping_ratio": 0.2}, "is set by another one as well"),
    ({("mesh 1 backlash", "mesh 1 backlash"): 1e-5}, "is set by another one as well"),
    ({"mesh 3 backlash": 1e-5}, "the train has &mesh 1 to 2"),
    ({3: 1.0}, "must be a name"),
    ({"shaft 1 diameter": 0.03, "shaft 1 stiffness": 1e5}, "shaft 1 diameter.*not in force"),
    ({"wheel 1 inertia": 0.1, "pinion 1 inertia": 0.01, "mesh 1 density": 7000.0}, "mesh 1 density.*not in force"),
    ([("input_torque", 1.0)], "must be a mapping"),
])
def test_values_that_a_train_cannot_take_are_told(parameters, told):
    with pytest.raises(gt.InputError, match=told):
        reducer().with_values(parameters)


def test_a_tuple_of_names_is_one_parameter():
    changed = reducer().with_values({("mesh 1 damping_ratio", "mesh 2 damping_ratio"): np.float64(0.03)})
    assert [mesh.damping_ratio for mesh in changed.meshes] == [0.03, 0.03]


@pytest.mark.parametrize("diameter", [[0.03, 0.04], [-1.0, 0.04]])
def test_columns_without_effect_are_told(diameter):
    """Also where the first point is not allowed."""
    space = gt.Space(sample={"shaft 1 diameter": diameter, "shaft 1 stiffness": [1e5, 2e5]})
    with pytest.raises(gt.InputError, match=r"shaft 1 diameter.*not in force"):
        gt.Study(reducer(), space, modes={}, keep=["natural_frequency"])
