"""Pages for a browser: what is in the file."""

import base64
import gzip
import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT, reducer
from test_table_loads import pair

import geartrain as gt
from geartrain._core import extras as _extras
from geartrain.pages.page_command import main
from geartrain.pages.page_force import force_laws, force_of
from geartrain.pages.page_pack import Block
from geartrain.results.motion_check import VALUES
from geartrain.variables import ANALYSES

pytest.importorskip("plotly")


def unpacked(html, name="data"):
    """The JSON of a block of a page, arrays in it, as Python reads them by the description of the format in _page_pack.py."""
    text = re.search(rf'<script type="text/plain" id="{name}">(.*?)</script>', html, re.DOTALL)[1]
    whole = gzip.decompress(base64.b64decode(text))
    length = int.from_bytes(whole[:4], "little")

    def array(place):
        count, kind = int(np.prod(place["shape"])), np.dtype(f"<{place['kind']}")
        begin = 4 + length + place["at"]
        rows = np.frombuffer(whole[begin:begin + count * kind.itemsize], np.uint8).reshape(kind.itemsize, count)
        return np.ascontiguousarray(rows.T).view(kind).reshape(place["shape"])

    def filled(told):
        if isinstance(told, dict):
            is_place = told.keys() == {"at", "kind", "shape"}
            return array(told) if is_place else {key: filled(value) for key, value in told.items()}
        return [filled(value) for value in told] if isinstance(told, list) else told

    return filled(json.loads(whole[4:4 + length]))


def test_is_one_small_file_that_fetches_nothing(page_path):
    html = page_path.read_text()
    assert len(html.encode()) < 6e6
    assert not re.findall(r'(?:src|href)="(?!data:,")', html)
    assert not re.findall(r"@import|url\(", html)


def test_holds_the_results(page_results, page_path):
    """Against the results themselves: Lambda to the last bit, what is listed to single precision, what is drawn to 1e-5."""
    told = unpacked(page_path.read_text())["files"][0]
    kinds = [series["kind"] for series in told["series"]]
    assert kinds == ["response", *["cascade"] * len(page_results.branches), "integration", "attractors"]
    for series, branch in zip(told["series"], [page_results.response, *page_results.branches]):
        np.testing.assert_array_equal(series["lambda"], branch.frequency)
        np.testing.assert_array_equal(series["stable"] == 1, branch.stable)
        np.testing.assert_allclose(series["values"]["mesh_force_maximum"], branch.mesh_force_maximum, rtol=1e-7)
        unseen = 2e-6 * np.abs(branch.coefficients).max(axis=-1, keepdims=True)
        assert (np.abs(series["coefficients"] - branch.coefficients) < 1e-5 * np.abs(branch.coefficients) + unseen).all()
        multipliers = series["multipliers"][..., 0] + 1j * series["multipliers"][..., 1]
        np.testing.assert_allclose(multipliers, branch.multipliers, rtol=1e-5, atol=1e-30)
    table = next(table for table in told["tables"] if table["name"] == "Jumps")
    jumps = [jump.frequency for jump in page_results.response.jumps]
    assert [row[table["headings"].index("Lambda")] for row in table["rows"]] == jumps
    names = [table["name"] for table in told["tables"]]
    table = told["tables"][names.index("Largest forces and torques, stable motions")]
    response, column = page_results.response, table["headings"].index("force or torque")
    largest = response.mesh_force_maximum[response.stable].max(axis=0)
    assert [row[column] for row in table["rows"][:2]] == largest.tolist()
    point = table["points"][2][1]
    motion = min(response.at(float(response.frequency[point])), key=lambda motion: np.abs(motion.rms - response.rms[point]).max())
    assert table["rows"][2][column] == pytest.approx(max(-motion.shaft_torque_minimum[0], motion.shaft_torque_maximum[0]), rel=1e-6)
    table = told["tables"][names.index("Without a stable motion")]
    np.testing.assert_array_equal(table["rows"], response.bands_without_stability)
    assert told["map"]["spectral_radius"].shape == page_results.stability_map.spectral_radius.shape
    np.testing.assert_array_equal(told["loci"][0]["values"], page_results.locus.parameter)


@pytest.mark.full
def test_says_which_rms_it_has(page_results, drawn_branch):
    """The paper's for a case in Lambda, the true rms for a train with a drawing; damping in per cent."""
    told = unpacked(page_results.page().html)["files"][0]
    assert told["first"] == "rms" and not told["drawn"]
    tables = {table["name"]: table for table in told["tables"]}
    assert "rms of the paper" in tables["Peaks"]["headings"]
    damping = [row[tables["Natural modes"]["headings"].index("damping, % of critical")] for row in tables["Natural modes"]["rows"]]
    np.testing.assert_allclose(damping, 100 * page_results.modes.damping_ratio)
    told = unpacked(drawn_branch.page().html)["files"][0]
    assert told["first"] == "mesh_force_maximum" and told["drawn"] and told["unit"] == "rpm"
    table = next(table for table in told["tables"] if table["name"] == "Special points")
    place = table["headings"].index("true rms [um], mesh 1")
    assert [row[place] for row in table["rows"]] == pytest.approx([one.rms[0] / np.sqrt(2) for one in drawn_branch.special_points])
    values = told["series"][0]["values"]
    np.testing.assert_allclose(values["peak_to_peak"], drawn_branch.maximum - drawn_branch.minimum, rtol=1e-6)


def test_numbers_that_are_not_finite_survive():
    block = Block()
    place = block.add([1.0, np.nan, np.inf, -np.inf], drawn=True)
    html = f'<script type="text/plain" id="data">{block.packed({"values": place, "plain": [np.nan, np.float64(2), None]})}</script>'
    told = unpacked(html)
    np.testing.assert_array_equal(told["values"], np.float32([1, np.nan, np.inf, -np.inf]))
    assert told["plain"] == [None, 2.0, None]


def _own_law(train):
    changed = [replace(train.meshes[0], back_stiffness=1.5e8, back_phase=0.7, damping_acts="contact", phase=0.3),
               replace(train.meshes[1], stiffness_cos=[0.2, 0.0, 0.05], stiffness_sin=[0.1], half_backlash=0.0)]
    return replace(train, meshes=changed)


@pytest.mark.parametrize("kind", ["paper", "changed", "reducer", "stages", "loads", "bearings"])
def test_force_law_is_that_of_the_program(kind, train):
    """At made-up motions that pass all regions, against `Motion.mesh_force`, 1e-9 of the largest force."""
    made = {"paper": lambda: train, "changed": lambda: _own_law(train), "reducer": reducer, "loads": pair,
            "stages": lambda: gt.read_case(ROOT / "namelists" / "front_wheel_drive.nml").train,
            "bearings": lambda: gt.read_case(ROOT / "namelists" / "bearings.nml").train}
    train = made[kind]()
    frequency = {"reducer": 1500.0, "stages": 1000.0}.get(kind, 0.8)
    laws = force_laws(train, frequency)
    half = np.array([np.abs(law["corners"]).max(initial=law["half"]) for law in laws]) + 0.1
    rng = np.random.default_rng(7)
    coefficients = np.zeros((len(laws), 13))
    coefficients[:, 1:3] = 2.0 * half[:, np.newaxis]
    coefficients += 0.3 * half[:, np.newaxis] * rng.standard_normal(coefficients.shape)
    nothing = np.zeros(len(laws))
    motion = gt.Motion(frequency=frequency, period=2, **dict.fromkeys(VALUES, nothing), coefficients=coefficients, train=train)
    known = motion.mesh_force
    angle = 2 * np.pi * np.arange(len(known)) / len(known)
    orders = np.arange(1, 7)
    cos, sin = np.cos(np.outer(angle, orders)), np.sin(np.outer(angle, orders))
    for mesh, law in enumerate(laws):
        a, b = coefficients[mesh, 1::2], coefficients[mesh, 2::2]
        p = coefficients[mesh, 0] + cos @ a + sin @ b
        v = (cos @ (orders * b) - sin @ (orders * a)) / 2
        assert set(np.searchsorted(law["corners"], p)) == set(range(len(law["damping"])))
        found = force_of(law, frequency, 2 * angle, p, v)
        np.testing.assert_allclose(found, known[:, mesh], atol=1e-9 * np.abs(known[:, mesh]).max())


def test_a_driveline_without_teeth_has_torques():
    """Clutch and lash alone: a page has no mesh forces and no teeth."""
    case = gt.read_case(ROOT / "namelists" / "front_wheel_drive.nml")
    told = unpacked(case.train.response(start=1200.0, stop=1150.0, harmonics=6).page().html)
    assert told["quantities"]["mesh_force_maximum"]["words"] == "largest coupling torque"
    assert told["quantities"]["mesh_force_maximum"]["unit"] == told["files"][0]["forceUnit"] == "N m"
    assert told["files"][0]["forces"] == "" and "teeth" not in json.dumps(told["quantities"])


def test_force_of_an_unknown_law_is_not_shown(branch):
    """Largest forces that the law does not give, as those of a law with more regions would be."""
    told = unpacked(replace(branch, mesh_force_maximum=branch.mesh_force_maximum * [1.0, 1.1]).page().html)["files"][0]
    assert told["laws"][0] is not None and told["laws"][1] is None
    assert told["forces"].startswith("The force of mesh 2 over time is not shown")


def test_a_large_page_has_fewer_waveforms(branch, monkeypatch):
    """The limit of its size stands in docs/page.md; here it is lowered, so that a small branch is too large."""
    told = unpacked(branch.page().html)["files"][0]["series"][0]
    assert told["every"] == 1
    monkeypatch.setattr("geartrain.pages.page._LARGE", len(branch.page().html) - 1000)
    fewer = unpacked(branch.page().html)["files"][0]["series"][0]
    assert fewer["every"] == 2
    np.testing.assert_array_equal(fewer["coefficients"], told["coefficients"][::2])
    np.testing.assert_array_equal(fewer["multipliers"], told["multipliers"][::2])
    np.testing.assert_array_equal(fewer["values"]["rms"], told["values"]["rms"])


def test_what_is_refused(branch, page_results, tmp_path, monkeypatch):
    with pytest.raises(gt.InputError, match=r"results = 3: must be gt\.Results, a gt\.Branch"):
        gt.page(3)
    with pytest.raises(gt.InputError, match="compare = 'x'"):
        gt.page(branch, compare="x")
    with pytest.raises(gt.InputError, match="branches: must be left out"):
        gt.page(branch, branches={})
    with pytest.raises(gt.InputError, match="nothing in these results"):
        parts = ("modes", "response", "integration", "attractors", "stability_map", "locus")
        gt.page(replace(page_results, **dict.fromkeys(parts), branches=[]))
    with pytest.raises(OSError):
        branch.page(tmp_path / "nowhere" / "page.html")

    def absent(name):
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(_extras, "import_module", absent)
    with pytest.raises(ModuleNotFoundError, match=re.escape("plotly, which is not installed: pip install 'geartrain[page]'")):
        branch.page()


def test_branch_over_a_parameter(over_backlash, branch, train):
    told = unpacked(over_backlash.page().html)["files"][0]
    np.testing.assert_array_equal(told["series"][0]["across"], over_backlash.parameter)
    # The gap of mesh 2 changes along the branch, and no one force law is that of all its points; mesh 1 keeps its own.
    assert told["laws"][0] is not None and told["laws"][1] is None and "mesh 2" in told["forces"]
    with pytest.raises(gt.InputError, match="compare: goes over frequency: must go over mesh 2 half_backlash"):
        over_backlash.page(compare=branch)
    # Over the torque both laws stay as they are, and the rms is largest at an end, which is a row of the table of peaks.
    over = train.continuation(parameter="input_torque", start=100.0, stop=200.0, frequency=0.7)
    told = unpacked(over.page().html)["files"][0]
    assert "input_torque [N m]" in told["tables"][0]["headings"] and None not in told["laws"]


def test_what_a_page_does_not_show_is_told(page_results):
    """An analysis that a page has no view for, as one that is new."""
    told = unpacked(page_results.page().html)["files"][0]
    assert told["notes"] == []
    beside = SimpleNamespace(**{**vars(page_results), "locus": None})
    modes = {"modes", "response", "integration", "attractors", "stability_map", "run_up", "locus"}
    assert {*ANALYSES} >= modes
    unknown = next(iter([name for name in ANALYSES if name not in modes]), None)
    if unknown is not None:
        setattr(beside, unknown, object())
        assert unpacked(gt.page(beside).html)["files"][0]["notes"] == [f"In the file, but not on this page: {unknown}"]


def test_train_of_rigid_shafts():
    """Nothing is told of rigid shafts in the numbers of a train, and its drawing calls them so."""
    train = gt.read_case(ROOT / "namelists" / "single_pair.nml").train
    assert any("rigid" in text.get_text() for text in train.plot().texts)
    told = unpacked(train.response(start=0.6, stop=0.9).page().html)["files"][0]
    assert told["laws"][0] is not None and told["schematic"].startswith("<?xml")


def test_planets_and_held_bodies():
    """What a set's report names is on its page too: reaction of the ring, shares of the planets, each with its names."""
    branch = gt.read_case(ROOT / "namelists" / "planetary.nml").train.response(start=1000.0, stop=1100.0, unit="rpm", harmonics=6)
    told = unpacked(branch.page().html)
    [file] = told["files"]
    [series] = file["series"]
    for name in ("load_share", "reaction_torque_maximum"):
        parts = file["parts"][told["quantities"][name]["along"]]
        assert parts == {"load_share": list(branch.train.planet_labels), "reaction_torque_maximum": ["ring"]}[name]
        np.testing.assert_allclose(series["values"][name], branch.arrays()[name], rtol=1e-7)


@pytest.fixture(scope="module")
def uneven():
    """The hybrid with planet 3 of the second of its two sets misplaced: short branch."""
    train = gt.read_case(ROOT / "namelists" / "hybrid.nml").train
    train = train.with_values({f"mesh {mesh} error_mean": 1e-7 for mesh in (11, 15)})
    return train.response(start=1000.0, stop=1050.0, unit="rpm", harmonics=4)


def test_load_sharing_and_reactions_in_tables(uneven, branch):
    """As the printed report: the reaction of the housing, and K_gamma with its planet for each set."""
    [file] = unpacked(uneven.page().html)["files"]
    tables = {table["name"]: table for table in file["tables"]}
    table = tables["Largest forces and torques, stable motions"]
    row = dict(zip(table["headings"], table["rows"][-1]))
    assert row["part"] == "reaction of housing" and row["unit"] == "N m"
    reaction = np.maximum(uneven.reaction_torque_maximum, -uneven.reaction_torque_minimum)[:, 0]
    assert row["force or torque"] == pytest.approx(reaction.max()) and table["points"][-1] == [0, int(reaction.argmax())]
    table = tables["Load sharing of planets, stable motions"]
    rows = [dict(zip(table["headings"], row)) for row in table["rows"]]
    assert [(row["set"], row["quantity"].split(":")[0], row["planet"]) for row in rows[::2]] == [
        ("split", "K_gamma", None), ("reduction", "K_gamma", 3)]
    assert rows[0]["value"] == pytest.approx(1.0, abs=5e-4)
    for row, share, (_, point) in zip(rows[2:], (uneven.load_share, uneven.load_share_maximum), table["points"][2:]):
        assert row["value"] == pytest.approx(4 * share[:, 4:].max()) and row["value"] > 1.1 and row["planet"] == 3
        assert row["speed [rpm]"] == pytest.approx(uneven.speed[point]) and share[point, 6] == share[:, 6].max()
    words = " ".join(uneven.report().split())
    assert re.search(rf"Planets of reduction: .*? at most {rows[2]['value']:.4g}, of planet 3 at", words)
    # A train without sets and without held bodies has neither.
    [file] = unpacked(branch.page().html)["files"]
    assert file["stages"] == [] and not any(table["name"].startswith("Load sharing") for table in file["tables"])
    assert not any("reaction" in str(row) for table in file["tables"] for row in table["rows"])


def test_stages_of_a_train(uneven):
    """A picture of each planetary set, with its own members; nothing in it from elsewhere."""
    [file] = unpacked(uneven.page().html)["files"]
    assert [stage["name"] for stage in file["stages"]] == ["split", "reduction"]
    for stage, members in zip(file["stages"], (("motor 1", "carrier", "1"), ("motor 2", "housing (held)", "3"))):
        root = ET.fromstring(stage["svg"])
        assert root.tag.endswith("}svg") and len(stage["svg"]) < 2e5
        links = [value for element in root.iter() for name, value in element.attrib.items() if name.endswith("href")]
        assert links and all(link.startswith("#") for link in links) and "url(" not in stage["svg"].replace("url(#", "")
        # Letters are paths; matplotlib notes the words beside them.
        words = [line.strip() for note in re.findall(r"<!--(.*?)-->", stage["svg"], re.DOTALL) for line in note.splitlines()]
        assert {stage["name"], *members} <= {*words} and "turns per turn of engine" in words


def test_command(page_results, branch, tmp_path, capsys):
    one, other = tmp_path / "one.h5", tmp_path / "other.h5"
    page_results.write(one)
    branch.write(other)
    assert main([str(one)]) == 0 and "one.html, " in capsys.readouterr().out
    assert main([str(one), "--compare", str(other), "-o", str(tmp_path / "both.html")]) == 0
    assert [file["name"] for file in unpacked((tmp_path / "both.html").read_text())["files"]] == ["one", "other"]
    assert main([str(tmp_path / "no.h5")]) == 4
    before = one.read_bytes()
    assert main([str(one), "-o", str(one)]) == 2 and one.read_bytes() == before
