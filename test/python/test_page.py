"""Pages for a browser: what is in the file, and what Chromium shows of it."""

import base64
import gzip
import json
import re
import shutil
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT, reducer

import geartrain as gt
from geartrain import _extras
from geartrain._motion_check import VALUES
from geartrain._page_force import force_laws, force_of
from geartrain._page_pack import Block
from geartrain.page_command import main
from geartrain.variables import ANALYSES

pytest.importorskip("plotly")

#: Waveforms are kept with 16 bits of each coefficient, 1e-5 relative.
DRAWN = 1e-4


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


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Every kind of thing that a page shows, of the train of figure 3."""
    case = tmp_path_factory.mktemp("page") / "case.nml"
    case.write_text((ROOT / "namelists" / "fig03.nml").read_text().split("&modes")[0] + """
        &modes /
        &response from = 1.5, to = 2.3, period_doublings = 1 /
        &integration from = 1.6, to = 2.2, points = 7, direction = 'both', stability = .true. /
        &attractors frequency = 1.6, starts = 4 /
        &stability_map from = 1.6, to = 2.2, points = 13, parameter_from = 0.0, parameter_to = 0.4, parameter_points = 5 /
        &locus kind = 'period_doubling', near = 1.75, parameter = 'stiffness_variation', from = 0.2, to = 0.4 /
    """)
    return gt.read_case(case).run()


@pytest.fixture(scope="module")
def over(train):
    """A branch over a parameter of the train."""
    return train.continuation(parameter="mesh 2 half_backlash", start=10e-6, stop=40e-6, frequency=0.7)


@pytest.fixture(scope="module")
def path(results, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "page.html"
    results.page(path)
    return path


# ------------------------------------------------------------------------------------------------------ the file


def test_is_one_small_file_that_fetches_nothing(path):
    html = path.read_text()
    assert len(html.encode()) < 6e6
    assert not re.findall(r'(?:src|href)="(?!data:,")', html)
    assert not re.findall(r"@import|url\(", html)


def test_holds_the_results(results, path):
    """Against the results themselves: Lambda to the last bit, what is listed to single precision, what is drawn to 1e-5."""
    told = unpacked(path.read_text())["files"][0]
    kinds = [series["kind"] for series in told["series"]]
    assert kinds == ["response", *["cascade"] * len(results.branches), "integration", "attractors"]
    for series, branch in zip(told["series"], [results.response, *results.branches]):
        np.testing.assert_array_equal(series["lambda"], branch.frequency)
        np.testing.assert_array_equal(series["stable"] == 1, branch.stable)
        np.testing.assert_allclose(series["values"]["mesh_force_maximum"], branch.mesh_force_maximum, rtol=1e-7)
        unseen = 2e-6 * np.abs(branch.coefficients).max(axis=-1, keepdims=True)
        assert (np.abs(series["coefficients"] - branch.coefficients) < 1e-5 * np.abs(branch.coefficients) + unseen).all()
        multipliers = series["multipliers"][..., 0] + 1j * series["multipliers"][..., 1]
        np.testing.assert_allclose(multipliers, branch.multipliers, rtol=1e-5, atol=1e-30)
    table = next(table for table in told["tables"] if table["name"] == "Jumps")
    assert [row[table["headings"].index("Lambda")] for row in table["rows"]] == [jump.frequency for jump in results.response.jumps]
    names = [table["name"] for table in told["tables"]]
    table = told["tables"][names.index("Largest forces and torques, stable motions")]
    response, column = results.response, table["headings"].index("force or torque")
    largest = response.mesh_force_maximum[response.stable].max(axis=0)
    assert [row[column] for row in table["rows"][:2]] == largest.tolist()
    motion = response.at(float(response.frequency[table["points"][2][1]]))[0]
    assert table["rows"][2][column] == pytest.approx(max(-motion.shaft_torque_minimum[0], motion.shaft_torque_maximum[0]), rel=1e-6)
    table = told["tables"][names.index("Without a stable motion")]
    np.testing.assert_array_equal(table["rows"], response.bands_without_stability)
    assert told["map"]["spectral_radius"].shape == results.stability_map.spectral_radius.shape
    np.testing.assert_array_equal(told["loci"][0]["values"], results.locus.parameter)


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


@pytest.mark.parametrize("kind", ["paper", "changed", "reducer"])
def test_force_law_is_that_of_the_program(kind, train):
    """At made-up motions that pass both flanks, against `Motion.mesh_force`, 1e-9 of the largest force."""
    train = {"paper": lambda: train, "changed": lambda: _own_law(train), "reducer": reducer}[kind]()
    frequency = 1500.0 if kind == "reducer" else 0.8
    laws = force_laws(train, frequency)
    half = np.array([law["half"] for law in laws]) + 0.1
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
        assert p.min() < -law["half"] and p.max() > law["half"]
        found = force_of(law, frequency, 2 * angle, p, v)
        np.testing.assert_allclose(found, known[:, mesh], atol=1e-9 * np.abs(known[:, mesh]).max())


def test_force_of_an_unknown_law_is_not_shown(branch):
    """Largest forces that the law does not give, as those of a law with more regions would be."""
    told = unpacked(replace(branch, mesh_force_maximum=branch.mesh_force_maximum * [1.0, 1.1]).page().html)["files"][0]
    assert told["laws"][0] is not None and told["laws"][1] is None
    assert told["forces"].startswith("The force of mesh 2 over time is not shown")


def test_a_large_page_has_fewer_waveforms(branch, monkeypatch):
    """The limit of its size stands in docs/page.md; here it is lowered, so that a small branch is too large."""
    told = unpacked(branch.page().html)["files"][0]["series"][0]
    assert told["every"] == 1
    monkeypatch.setattr("geartrain._page._LARGE", len(branch.page().html) - 1000)
    fewer = unpacked(branch.page().html)["files"][0]["series"][0]
    assert fewer["every"] == 2
    np.testing.assert_array_equal(fewer["coefficients"], told["coefficients"][::2])
    np.testing.assert_array_equal(fewer["multipliers"], told["multipliers"][::2])
    np.testing.assert_array_equal(fewer["values"]["rms"], told["values"]["rms"])


def test_what_is_refused(branch, results, tmp_path, monkeypatch):
    with pytest.raises(gt.InputError, match=r"results = 3: must be gt\.Results, a gt\.Branch"):
        gt.page(3)
    with pytest.raises(gt.InputError, match="compare = 'x'"):
        gt.page(branch, compare="x")
    with pytest.raises(gt.InputError, match="branches: must be left out"):
        gt.page(branch, branches={})
    with pytest.raises(gt.InputError, match="nothing in these results"):
        parts = ("modes", "response", "integration", "attractors", "stability_map", "locus")
        gt.page(replace(results, **dict.fromkeys(parts), branches=[]))
    with pytest.raises(OSError):
        branch.page(tmp_path / "nowhere" / "page.html")

    def absent(name):
        raise ModuleNotFoundError(name=name)

    monkeypatch.setattr(_extras, "import_module", absent)
    with pytest.raises(ModuleNotFoundError, match=re.escape("plotly, which is not installed: pip install 'geartrain[page]'")):
        branch.page()


def test_branch_over_a_parameter(over, branch, train):
    told = unpacked(over.page().html)["files"][0]
    np.testing.assert_array_equal(told["series"][0]["across"], over.parameter)
    # The gap of mesh 2 changes along the branch, and no one force law is that of all its points; mesh 1 keeps its own.
    assert told["laws"][0] is not None and told["laws"][1] is None and "mesh 2" in told["forces"]
    with pytest.raises(gt.InputError, match="compare: goes over frequency: must go over mesh 2 half_backlash"):
        over.page(compare=branch)
    # Over the torque both laws stay as they are, and the rms is largest at an end, which is a row of the table of peaks.
    over = train.continuation(parameter="input_torque", start=100.0, stop=200.0, frequency=0.7)
    told = unpacked(over.page().html)["files"][0]
    assert "input_torque [N m]" in told["tables"][0]["headings"] and None not in told["laws"]


def test_what_a_page_does_not_show_is_told(results):
    """An analysis that a page has no view for, as one that is new."""
    told = unpacked(results.page().html)["files"][0]
    assert told["notes"] == []
    beside = SimpleNamespace(**{**vars(results), "locus": None})
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


def test_command(results, branch, tmp_path, capsys):
    one, other = tmp_path / "one.h5", tmp_path / "other.h5"
    results.write(one)
    branch.write(other)
    assert main([str(one)]) == 0 and "one.html, " in capsys.readouterr().out
    assert main([str(one), "--compare", str(other), "-o", str(tmp_path / "both.html")]) == 0
    assert [file["name"] for file in unpacked((tmp_path / "both.html").read_text())["files"]] == ["one", "other"]
    assert main([str(tmp_path / "no.h5")]) == 4
    before = one.read_bytes()
    assert main([str(one), "-o", str(one)]) == 2 and one.read_bytes() == before


# ------------------------------------------------------------------------------------------------------ in a browser


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    selenium = pytest.importorskip("selenium.webdriver")
    programs = [shutil.which("chromium"), shutil.which("chromedriver")]
    if not all(programs):
        pytest.skip("no chromium or no chromedriver, Debian's packages chromium and chromium-driver, which scripts/test installs")
    options = selenium.ChromeOptions()
    options.binary_location = programs[0]
    folder = tmp_path_factory.mktemp("chromium")
    for flag in ("headless=new", "no-sandbox", "disable-gpu", "no-first-run", "disable-background-networking",
                 "disable-component-update", "disable-sync", "window-size=1200,800", f"user-data-dir={folder}"):
        options.add_argument(f"--{flag}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = selenium.Chrome(options=options, service=selenium.ChromeService(programs[1]))
    yield driver
    driver.quit()


class Shown:
    """A page in the browser."""

    def __init__(self, browser, path, width=1200):
        self.browser = browser
        size = {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 600}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get_log("browser")
        browser.get(path.as_uri())
        self.until("document.documentElement.dataset.ready === 'yes' || !document.getElementById('problem').hidden")
        self.settle()

    def js(self, expression, *values):
        return self.browser.execute_script(f"return {expression}", *values)

    def until(self, expression):
        begun = time.monotonic()
        while not self.js(expression):
            assert time.monotonic() < begun + 30, expression
            time.sleep(0.02)

    def settle(self):
        """Until the pictures of the chosen motion are drawn."""
        if self.js("state.tab === 'response'"):
            self.until("byId('point').dataset.drawn === 'yes' && left === 0")

    def find(self, css):
        return self.browser.find_element("css selector", css)

    def click(self, css):
        self.find(css).click()
        self.settle()

    def press(self, css, *keys):
        from selenium.webdriver.common.keys import Keys

        self.find(css).send_keys(*(getattr(Keys, key) for key in keys))
        self.settle()

    def click_at(self, plot, x, y):
        """A click where a plot has these values."""
        from selenium.webdriver import ActionChains

        pixel = "((axis) => axis._offset + axis.l2p(arguments[2]))(byId(arguments[0])._fullLayout[arguments[1]])"
        place = [self.js(pixel, plot, *at) for at in (("xaxis", float(x)), ("yaxis", float(y)))]
        element = self.find(f"#{plot}")
        element.location_once_scrolled_into_view  # noqa: B018 (which scrolls)
        width, height = element.size["width"], element.size["height"]
        offset = [round(place[0] - width / 2), round(place[1] - height / 2)]
        # Hovering first, as a hand does: a plot takes a click for the point that it shows.
        ActionChains(self.browser, duration=0).move_to_element_with_offset(element, offset[0] + 3, offset[1]).pause(0.1).perform()
        ActionChains(self.browser, duration=0).move_to_element_with_offset(element, *offset).pause(0.1).click().perform()
        self.settle()

    def complaints(self):
        return [entry["message"] for entry in self.browser.get_log("browser")] + [self.find("#problem").text]


@pytest.fixture(scope="module")
def opened(browser, path):
    return Shown(browser, path)


@pytest.fixture
def shown(opened):
    """The page as it begins; loading it anew for every test costs a second each."""
    opened.js("(() => { Object.assign(state, { unit: null, quantity: 'rms', part: 'all', mesh: 0 }); state.off.clear();"
              "showFiles(data.files); openTab('response'); })()")
    opened.settle()
    yield opened
    assert opened.complaints() == [""]


def test_pictures_of_a_point_are_those_of_the_motion(shown, results):
    """Displacement, force, spectrum and multipliers as drawn, against the motion in Python."""
    for series, point, branch in ((0, 40, results.response), (1, 17, results.branches[0])):
        shown.js("choose(main.series[arguments[0]], arguments[1], 1)", series, point)
        shown.settle()
        values = {name: getattr(branch, name)[point] for name in (*VALUES, "frequency", "coefficients")}
        motion = gt.Motion(**values, period=branch.subharmonic, train=branch.train)
        samples = len(shown.js("Array.from(byId('wave').data[0].x)")) - 1  # the last one is the first again
        for plot, known in (("wave", motion.waveform(samples)[1]), ("force", motion._sample(samples)[2])):
            for mesh in (0, 1):
                time_, found = (np.array(shown.js(f"Array.from(byId('{plot}').data[{mesh}].{axis})")) for axis in "xy")
                np.testing.assert_allclose(time_, motion.period * np.arange(samples + 1) / samples, atol=1e-12)
                np.testing.assert_allclose(found[:-1], known[:, mesh], atol=DRAWN * np.abs(known[:, mesh]).max())
        height = shown.js("byId('spectrum').data[0].y.filter((_, i) => i % 3 === 1)")
        amplitude = motion.spectrum()[1]
        visible = (amplitude > 3e-3 * amplitude.max()).any(axis=1)
        np.testing.assert_allclose(height, amplitude[visible, 0], rtol=DRAWN, atol=DRAWN * amplitude.max())
        real = shown.js("byId('multipliers').data.flatMap((trace) => trace.x)")
        np.testing.assert_allclose(np.sort(real), np.sort(branch.multipliers[point].real), atol=DRAWN)
        facts = shown.find("#facts").text
        assert f"point {point + 1} of {len(branch)}" in facts and f"{motion.frequency:.7g}" in facts
        assert ("unstable" in facts) == (not branch.stable[point])


def test_a_click_chooses_the_point(shown, results):
    branch = results.response
    point = int(np.argmax(branch.rms[:, 0]))
    shown.click_at("curve", branch.frequency[point], branch.rms[point, 0])
    series, found = shown.js("[state.chosen.series.place, state.chosen.point]")
    assert series == 0 and abs(found - point) <= 2  # neighbours lie within a few pixels
    assert shown.js("document.activeElement.id") == "curve"
    sweep = results.integration
    shown.click_at("curve", sweep[2].frequency, sweep[2].rms[0])
    assert shown.js("state.chosen.series.kind") in ("integration", "response", "cascade")


def test_keys_move_along_the_branches(shown):
    shown.press("#curve", "HOME")
    assert shown.js("state.chosen.point") == 0
    shown.press("#curve", "ARROW_RIGHT", "ARROW_RIGHT", "ARROW_LEFT")
    assert shown.js("state.chosen.point") == 1
    shown.press("#curve", "END")
    assert shown.js("state.chosen.point === main.series[0].count - 1")
    at = shown.js("state.chosen.series.lambda[state.chosen.point]")
    shown.press("#curve", "ARROW_DOWN")
    assert shown.js("state.chosen.series.place") == 1
    nearest = "Math.min(...state.chosen.series.lambda.map((l) => Math.abs(l - arguments[0])))"
    assert shown.js("Math.abs(state.chosen.series.lambda[state.chosen.point] - arguments[0])", at) == shown.js(nearest, at)
    # By the tab key alone: the curves can be reached, and a ring is seen where the focus is.
    shown.js("byId('tab-response').focus()")
    for _ in range(25):
        shown.browser.switch_to.active_element.send_keys("\ue004")  # the tab key
        if shown.js("document.activeElement.id") == "curve":
            break
    else:
        pytest.fail("the curves are not reached")
    assert shown.js("getComputedStyle(byId('curve')).outlineStyle") == "solid"
    shown.press("#tab-response", "ARROW_RIGHT")
    assert shown.js("[state.tab, document.activeElement.id, byId('view-map').hidden, byId('view-response').hidden]") == [
        "map", "tab-map", False, True]


def test_switches_and_quantities(shown, results):
    kinds = "[...new Set(byId('curve').data.map((trace) => trace.meta.kind))].sort()"
    every = shown.js(kinds)
    assert {"response", "cascade", "integration", "attractors", "specials"} <= {*every}
    for kind in ("integration", "cascade", "attractors", "specials"):
        shown.click(f"#show-{kind}")
        assert kind not in shown.js(kinds)
        shown.click(f"#show-{kind}")
        assert shown.js(kinds) == every
    jumps = "byId('curve').layout.annotations.length + byId('curve').layout.shapes.filter((s) => s.line?.dash === 'dot').length"
    assert shown.js(jumps) >= len(results.response.jumps)
    shown.click("#show-jumps")
    assert shown.js(jumps) == 0
    dashes = "byId('curve').data.filter((t) => t.meta.kind === 'response').map((t) => `${t.meta.stable} ${t.line.dash}`)"
    assert {*shown.js(dashes)} == {"false 5px,3px", "true solid"}
    for quantity in ("mesh_force_maximum", "shaft_torque_maximum", "dynamic_factor"):
        shown.js("((s) => { s.value = arguments[0]; s.onchange(); })(document.querySelector('#view-response select'))", quantity)
        shown.settle()
        assert quantity.split("_")[0] in shown.js("byId('curve').layout.yaxis.title.text").replace("largest mesh force", "mesh")


def test_units(shown, results):
    stable = results.response.frequency[results.response.stable]
    first = "byId('curve').data.find((t) => t.meta.kind === 'response' && t.meta.stable).x[0]"
    assert shown.js(first) == pytest.approx(stable[0])
    shown.click('input[name="unit-response"][value="Hz"]')
    assert shown.js(first) == pytest.approx(stable[0] * 9870 / (2 * np.pi))
    assert shown.js("byId('curve').layout.xaxis.title.text") == "fundamental frequency  [Hz]"
    assert shown.js("byId('wave').layout.xaxis.title.text") == "time  [ms]"
    shown.click("#tab-map")
    assert shown.js("byId('chart').layout.xaxis.title.text") == "fundamental frequency  [Hz]"
    assert shown.js("byId('chart').data[0].x[0]") == pytest.approx(1.6 * 9870 / (2 * np.pi))


def test_tables_sort_and_lead_to_the_motion(shown, results):
    shown.click("#tab-tables")
    column = "[...document.querySelectorAll('#view-tables table')][0].querySelectorAll('tbody tr')"
    rms = shown.js("(() => { const heads = [...document.querySelectorAll('#view-tables table')[0].querySelectorAll('th button')];"
                   "const i = heads.findIndex((head) => head.textContent.startsWith('rms')); heads[i].click();"
                   f"return [...{column}].map((row) => Number(row.cells[i + 1].textContent)); }})()")
    assert rms == sorted(rms) and len(rms) >= len(results.response.peaks())
    assert shown.js("document.querySelector('th[aria-sort]').getAttribute('aria-sort')") == "ascending"
    shown.js("document.querySelector('th[aria-sort] button').click()")
    assert shown.js("document.querySelector('th[aria-sort]').getAttribute('aria-sort')") == "descending"
    highest = max(results.response.peaks(), key=lambda peak: peak.rms)
    shown.click("#view-tables tbody tr td button")
    assert shown.js("[state.tab, state.chosen.series.place]") == ["response", 0]
    assert shown.js("state.chosen.series.lambda[state.chosen.point]") == pytest.approx(highest.frequency, abs=0.02)


def test_map_tells_a_cell(shown, results):
    shown.click("#tab-map")
    chart = results.stability_map
    shown.click_at("chart", chart.frequency[6], chart.parameter[3])
    text = shown.find("#cell").text
    assert f"stiffness variation = {chart.parameter[3]:.6g}" in text
    assert f"{chart.motions[3, 6]} motions, {chart.stable_motions[3, 6]} of them stable" in text
    # The curve of the period doubling lies over the map, in its units.
    line = shown.js("byId('chart').data.filter((trace) => trace.type === 'scatter').map((trace) => [trace.x, trace.y])[0]")
    np.testing.assert_allclose(line, [results.locus.frequency, results.locus.parameter])


def test_two_files_and_a_narrow_screen(browser, branch, train, tmp_path, monkeypatch):
    other = train.with_values({"mesh 2 damping_ratio": 0.07}).response(start=0.4, stop=1.0)
    path = tmp_path / "both.html"
    monkeypatch.setattr("geartrain._page._LARGE", 0)
    monkeypatch.setattr("geartrain._page._SPARSE", 2)
    gt.page(branch, path, compare=other, names=("given", "more <b>damping</b>"))
    page = Shown(browser, path, width=400)
    assert page.js("byId('curve').data.filter((t) => t.meta.file === 1).length") >= 2
    assert "more <b>damping</b>" in page.find("#key").text
    page.js("choose(main.series[0], 5)")
    page.settle()
    assert "those of point 7, the nearest" in page.find("#force-note").text
    page.click("#show-compare")
    assert page.js("byId('curve').data.filter((t) => t.meta.file === 1).length") == 0
    for tab in ("response", "tables", "train"):
        page.click(f"#tab-{tab}")
        assert page.js("document.documentElement.scrollWidth") <= 400, tab
    image = page.js("[...document.querySelectorAll('img')].map((i) => [i.naturalWidth > 100, i.alt.length > 10])")
    assert image == [[True, True]] * 2
    assert page.complaints() == [""]


def test_a_parameter_in_the_browser(over, browser, tmp_path):
    over.page(tmp_path / "over.html")
    page = Shown(browser, tmp_path / "over.html")
    assert page.js("byId('curve').layout.xaxis.title.text") == "mesh 2 half backlash  [m]"
    assert page.js("byId('curve').data[0].x[0]") == pytest.approx(over.parameter[0])
    page.press("#curve", "END")
    facts = page.find("#facts").text
    assert "mesh 2 half backlash" in facts and "0.00004 m" in facts and "Λ = 0.7" in facts
    assert page.complaints() == [""]


def test_study(browser, train, tmp_path):
    space = gt.Space({"input_torque": [140.0, 150.0, 160.0], "mesh 2 damping_ratio": [0.05, 0.06]})
    study = gt.Study(train, space, response=dict(start=0.6, stop=0.8), keep=["largest dynamic_factor", "first jump up", "jumps"])
    with ThreadPoolExecutor(1) as executor:
        dataset = study.run(tmp_path / "study", executor, progress=False)
    path = tmp_path / "study.html"
    gt.page(dataset, path, branches={3: study.branch(3)})
    page = Shown(browser, path)
    names = ["input_torque", "mesh 2 damping_ratio", "largest dynamic_factor"]
    assert page.js("data.study.columns.slice(0, 3).map((c) => c.name)") == names
    factor = dataset["largest dynamic_factor"].values.ravel()
    np.testing.assert_allclose(page.js("Array.from(data.study.columns[2].values)"), factor)
    many = [name for name, values in dataset.data_vars.items() if "jump" in values.dims and values.sizes["jump"] > 12]
    assert page.js("data.study.leftOut") == many
    page.click_at("scatter", 150.0, factor[3])
    assert page.js("state.study") == 3
    facts = page.find("#study-facts").text
    assert f"{factor[3]:.6g}" in facts and "150 N m" in facts
    page.find("#study-facts button").click()
    page.settle()
    assert page.js("[state.tab, main.name]") == ["response", "point 3"]
    page.click("#tab-study")
    page.press("#parallel", "ARROW_RIGHT")
    assert page.js("state.study") == 4 and "not on the page" in page.find("#study-facts").text
    assert page.complaints() == [""]
    with pytest.raises(gt.InputError, match="branches: point 6: must be from 0 to 5"):
        gt.page(dataset, branches={6: study.branch(0)})
