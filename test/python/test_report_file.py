"""Reports as documents, and the dynamic factor of ISO 6336-1 that stands beside the computed one."""

import re
from dataclasses import replace
from html.parser import HTMLParser
from math import pi, sin
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT, reducer

import geartrain as gt
from geartrain.reports.at_peaks import sidebands
from geartrain.reports.document import Document
from geartrain.reports.kv import Pair, dynamic_factor
from geartrain.reports.report_command import main
from geartrain.reports.report_file import _pair, document_of

pytestmark = pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")


@pytest.fixture(scope="module", name="results")
def _results():
    case = gt.read_case(ROOT / "namelists" / "planetary.nml")
    return replace(case, response=None, text=case.train.namelist(
        modes=True, response={"start": 4700.0, "stop": 4720.0, "unit": "rpm", "harmonics": 3})).run()


class Reader(HTMLParser):
    """Headings, cells and pictures of a page; tags that are not closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.headings, self.cells, self.pictures = [], [], [], 0
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "img":
            self.pictures += dict(attrs)["src"].startswith("data:image/png;base64,")
        elif tag != "meta":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("h1", "h2"):
            self.headings.append(data)
        if self.open and self.open[-1] in ("td", "th"):
            self.cells.append(data)


@pytest.mark.full  # draws four pictures
def test_a_report_as_html(results, tmp_path):
    text = results.report(tmp_path / "a.html")
    assert text == results.report()  # the path changes nothing of it
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    read = Reader(page)
    assert read.open == [] and read.pictures == 4 and "http" not in page
    assert read.headings == ["planetary reducer", "Result", "Response", "Torques of shafts", "Dynamic factors",
                             "Load sharing of planets", "Modes", "Resonances", "Shafts", "Quality", "Train", "What is not modelled"]
    assert "held" in read.cells and "mesh 1 to 3" in read.cells
    factors = results.response.dynamic_factor.max(axis=0)
    assert f"{factors[0]:.4g}" in read.cells and f"{factors[3]:.4g}" in read.cells
    assert f"{results.response.train.explain()['mesh 1']['contact_ratio']:.6g}" in read.cells


@pytest.mark.full
def test_a_report_as_pdf(results, tmp_path):
    results.write(tmp_path / "a.h5")
    assert main([str(tmp_path / "a.h5")]) == 0
    data = (tmp_path / "a.pdf").read_bytes()
    assert data.startswith(b"%PDF-") and len(re.findall(rb"/Type /Page\b", data)) >= 3
    assert main([str(tmp_path / "a.h5"), "-o", str(tmp_path / "b.pdf")]) == 0
    assert (tmp_path / "b.pdf").read_bytes() == data  # no date


def test_what_is_no_report(results, tmp_path, capsys):
    for wrong in ("a.txt", "a", "a.h5"):
        with pytest.raises(gt.InputError, match=r"must end in \.pdf or \.html"):
            results.report(tmp_path / wrong)
    assert main([str(tmp_path / "none.h5")]) == 4 and "none.h5" in capsys.readouterr().err
    page = tmp_path / "a.html"  # of a name that a report may have
    replace(results, response=None).write(page)
    data = page.read_bytes()
    assert main([str(page), "-o", str(page)]) == 2 and "is neither a page nor a report" in capsys.readouterr().err
    assert page.read_bytes() == data
    with pytest.raises(OSError, match="nowhere"):
        replace(results, response=None).report(tmp_path / "nowhere" / "a.html")


def test_a_report_without_response(results, tmp_path):
    replace(results, response=None).report(tmp_path / "a.html")
    read = Reader((tmp_path / "a.html").read_text(encoding="utf-8"))
    assert "Response" not in read.headings and read.headings[-1] == "What is not modelled" and "Train" in read.headings
    # In the section on the train, after the train itself.
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    places = [page.index(words) for words in ("<h2>Train</h2>", 'alt="the train"', 'alt="planetary set stage 1"', "<th>body</th>")]
    assert places == sorted(places) and page.count("<img") == read.pictures == 2


# K_v of ISO 6336-1:2006, method B.

PAIR = Pair(teeth=20, radii=(0.05, 0.1), inertias=(0.002, 0.03), width=0.04, contact_ratio=1.6, single=1.4e10, mesh=2e10,
            line_load=2e5, base_pitch=0.0, profile=0.0)


def at(pair, ratio):
    return dynamic_factor(pair, ratio * pair.resonance)[0]


def test_ranges_of_the_resonance_ratio():
    """By the tables of the standard, without deviations: C_v3 = 0.23, C_v4 = 0.90, C_v7 by its sine."""
    above = 0.125 * sin(pi * (1.6 - 2)) + 0.875
    assert [at(PAIR, ratio) for ratio in (0.5, 0.85, 1.0, 1.15, 1.325, 1.5, 3.0)] == pytest.approx(
        [1.115, 1.1955, 1.9, 1.9, (1.9 + above) / 2, above, above], rel=1e-12)
    errors = replace(PAIR, base_pitch=5e-6, profile=5e-6)  # B_p = B_f = 1.4e10 5e-6/2e5 = 0.35
    assert at(errors, 0.5) == pytest.approx(1 + 0.5 * (0.32 * 0.35 + 0.34 * 0.35 + 0.23))
    assert at(errors, 2.0) == pytest.approx(0.47 * 0.35 + 0.47 * 0.35 + above)
    pitch = replace(PAIR, base_pitch=5e-6)
    assert at(pitch, 0.5) == pytest.approx(1 + 0.5 * (0.32 * 0.35 + 0.23))
    assert (at(pitch, 1.0), at(pitch, 2.0)) == pytest.approx((1.9 + 0.32 * 0.35, 0.47 * 0.35 + above))
    helical = replace(errors, contact_ratio=2.6)
    assert at(helical, 0.5) == pytest.approx(1 + 0.5 * (0.32 * 0.35 + 0.57 / 2.3 * 0.35 + 0.096 / 1.04))
    assert at(helical, 1.0) == pytest.approx(1 + 0.32 * 0.35 + 0.57 / 2.3 * 0.35 + (0.57 - 0.13) / 1.16)
    assert at(helical, 2.0) == pytest.approx(0.47 * 0.35 + 0.12 / 0.86 * 0.35 + 1.0)
    assert at(replace(PAIR, line_load=2.5e4), 0.7) == pytest.approx(1.9)  # from 0.5 + 0.35 sqrt(25/100) = 0.675 on


def test_the_resonance_is_that_of_the_pair_alone():
    """The natural frequency of two gears and their mesh, at the tooth frequency."""
    train = reducer()
    pair = _pair(train, train.explain(), 0)
    told = train.explain()
    alone = gt.Train(
        bodies=[gt.Body(name="a", inertia=told["pinion 1"]["inertia"], torque=1.0),
                gt.Body(name="b", inertia=told["wheel 1"]["inertia"], balances=True)],
        meshes=[gt.Mesh(between=("a", "b"), teeth=[23, 71], normal_module=2.5e-3, helix_angle=15.0, face_width=0.04,
                        stiffness=told["mesh 1"]["stiffness"])])
    assert pair.resonance * 23 / 60 == pytest.approx(float(alone.natural_frequencies(unit="Hz")[0]), rel=1e-12)
    errors = np.zeros(71)
    errors[3:] = 8e-6
    errors[9] = -4e-6  # differs by 12 um from both neighbours
    measured = _pair(train.with_values({"mesh 1 driven_pitch_error": errors}), told, 0)
    assert (measured.base_pitch, measured.profile) == pytest.approx((12e-6, 3e-6))
    assert pair.base_pitch == pair.profile == 3e-6 and np.isclose(pair.line_load, told["mesh 1"]["line_load"])


def table_under(page, heading):
    """Rows of the table that follows a heading."""
    part = page[page.index(f"<h2>{heading}"):]
    return [re.findall(r"<t[dh]>(.*?)</t[dh]>", row) for row in re.findall(r"<tr>(.*?)</tr>", part[:part.index("</table>")])]


@pytest.mark.full  # draws pictures of two responses
def test_sensitivities_and_sidebands(tmp_path):
    """Sensitivities against other trains; the orders of the pinion of the pages."""
    case = gt.read_case(ROOT / "namelists" / "pitch_errors.nml").train
    mesh = replace(case.meshes[0], driven_runout=None, driven_runout_phase=None, error_cos=None)
    sound = replace(case, meshes=[replace(mesh, driving_pitch_error=None)])
    asked = {"start": 6500.0, "stop": 7200.0, "unit": "rpm"}
    branch = sound.response(**asked, harmonics=3)
    text = branch.report(tmp_path / "a.html")
    assert text == branch.report()
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    rows = {row[0]: [float(cell) for cell in row[1:]] for row in table_under(page, "Sensitivities")[1:]}
    assert "Orders and sidebands" not in page
    # Against the same motion of two other trains each; the table has three decimals.
    first = max(branch.peaks(), key=lambda peak: peak.dynamic_factor)
    for name, own in (("motor torque", 90.0), ("mesh 1 stiffness", sound.explain()["mesh 1"]["stiffness"])):
        force = [sound.with_values({name: own * factor}).response(
            start=0.999 * first.speed, stop=1.001 * first.speed, unit="rpm", harmonics=3).at(first.speed, unit="rpm")[0]
            .mesh_force_maximum[0] for factor in (1.001, 0.999)]
        assert rows[name][0] == pytest.approx((force[0] - force[1]) / 0.002 / first.mesh_force_maximum, abs=2e-3)

    train = sound.with_values({"mesh 1 driving_pitch_error": mesh.driving_pitch_error})
    sweep = train.sweep(start=3400.0, stop=3500.0, points=2, unit="rpm")
    motion = max(sweep, key=lambda one: one.mesh_force_maximum[0])
    made = document_of(SimpleNamespace(response=None, modes=None, run_up=None, integration=sweep), "")
    rows = next(rows for kind, rows in made.blocks if kind == "table" and "what it comes from" in rows[0])
    names = {row[1]: float(row[2]) for row in rows[1:]}
    _check_sidebands(made, motion)
    # Without a peak in the range, and without a motion at a speed.
    branch = train.response(start=3000.0, stop=3050.0, unit="rpm", harmonics=0)
    assert not branch.peaks()
    made = document_of(SimpleNamespace(response=branch, modes=None, run_up=None, integration=None), "")
    _check_sidebands(made, branch.at(branch.frequency[branch.mesh_force_maximum[:, 0].argmax()])[0])
    assert any("as no mesh with errors has a peak within the range, 30" in text for kind, text in made.blocks if kind == "sentence")
    made = document_of(SimpleNamespace(response=None, modes=train.modes(), run_up=None, integration=None), "")
    assert any("orders take a motion at a speed" in text for kind, text in made.blocks if kind == "sentence")
    orders = motion.orders(least=1e-4)
    for name, amplitude in names.items():
        assert amplitude == pytest.approx(float(orders.amplitude[list(orders.owner.values).index(name), 0]), rel=1e-3)
    assert {"mesh 1", "1 x mesh 1 - 1 x pinion"} <= names.keys() and any(name.endswith("pinion") for name in names)


def _check_sidebands(made, motion):
    """The table against the lines of the spectrum: the pinion turns once in an order."""
    rows = next(rows for kind, rows in made.blocks if kind == "table" and rows[0][0] == "sidebands of")
    assert rows[0][3:] == ["-3", "-2", "-1", "0", "+1", "+2", "+3"] and [row[0] for row in rows[1:]] == [
        f"{times} x mesh 1" for times in (1, 2, 3)] * 2
    teeth = motion.train.meshes[0].teeth[0]
    for place, row in enumerate(rows[1:]):
        what, times = ("displacement", "mesh_force")[place // 3], place % 3 + 1
        lines = dict(zip(*(values.tolist() for values in motion.spectrum(what)), strict=True))
        assert row[1] == "pinion" and row[2] == ("um", "N")[place // 3] and float(row[6]) > 0
        for far, cell in zip(range(-3, 4), row[3:], strict=True):
            assert float(cell or 0.0) == pytest.approx(lines.get(times * teeth + far, [0.0])[0], rel=5e-3)


def test_whole_lists_as_values():
    train = gt.read_case(ROOT / "namelists" / "pitch_errors.nml").train
    changed = train.with_values({"mesh 1 driving_pitch_error": np.arange(20) * 1e-7, "motor torque": 80.0})
    assert changed.meshes[0].driving_pitch_error == pytest.approx(np.arange(20) * 1e-7) and changed.bodies[0].torque == 80.0
    for values, words in (({"motor torque": [1.0, 2.0]}, "one value"),
                          ({"mesh 1 driving_pitch_error": ["a"]}, "one value"),
                          ({"mesh 1 driving_pitch_error": [0.0] * 3}, "each of the 20")):
        with pytest.raises(gt.InputError, match=words):
            train.with_values(values)


@pytest.mark.parametrize(("stable", "undecided", "words", "speed"), [
    ([True, True], [False, False], "the highest peak of mesh 1,", 6700.0),
    ([False, True], [True, False], "the highest peak of mesh 1 (stability undecided),", 6700.0),
    ([False, True], [False, False], "the highest stable peak of mesh 1,", 6900.0),
    ([False, False], [False, False], "no mesh with errors has a stable peak", 6700.0),
])
def test_the_highest_peak_is_that_of_the_table(stable, undecided, words, speed):
    """Undecided peaks stay, as in the table of resonances; where a higher one is unstable, the words say stable."""
    train = gt.read_case(ROOT / "namelists" / "pitch_errors.nml").train
    motions = {at: train.integrate(at, unit="rpm") for at in (6700.0, 6900.0)}
    peaks = [SimpleNamespace(frequency=one.frequency, speed=one.speed, mesh=1, rms=one.rms[0], stable=is_stable, undecided=open_,
                             dynamic_factor=factor, mesh_force_maximum=one.mesh_force_maximum[0])
             for one, is_stable, open_, factor in zip(motions.values(), stable, undecided, (2.0, 1.5), strict=True)]
    branch = SimpleNamespace(frequency=np.array([one.frequency for one in peaks]), parameter=None, peaks=lambda: peaks,
                             at=lambda frequency: [one for one in motions.values() if one.frequency == frequency],
                             stable=np.array(stable), rms=np.array([[one.rms] for one in peaks]),
                             mesh_force_maximum=np.array([[2.0], [1.0]]))
    made = Document("")
    sidebands(made, SimpleNamespace(response=branch, integration=None), train)
    where = next(text for kind, text in made.blocks if kind == "sentence" and "of the force of the mesh itself" in text)
    assert words in where and f"{speed:g} rpm" in where
