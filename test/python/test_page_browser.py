"""Pages for a browser: what Chromium shows of them."""

import shutil
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
from conftest import ROOT

import geartrain as gt
from geartrain.results.motion_check import VALUES

pytestmark = pytest.mark.full

pytest.importorskip("plotly")

#: Waveforms are kept with 16 bits of each coefficient, 1e-5 relative.
DRAWN = 1e-4


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


#: Chooses the quantity that the curves show.
CHOOSE = "((s) => { s.value = arguments[0]; s.onchange(); })(document.querySelector('#view-response select'))"


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
def opened(browser, page_path):
    return Shown(browser, page_path)


@pytest.fixture
def shown(opened):
    """The page as it begins; loading it anew for every test costs a second each."""
    opened.js("(() => { Object.assign(state, { unit: null, quantity: null, part: 'all', mesh: 0 }); state.off.clear();"
              "showFiles(data.files); openTab('response'); })()")
    opened.settle()
    yield opened
    assert opened.complaints() == [""]


def test_pictures_of_a_point_are_those_of_the_motion(shown, page_results):
    """Displacement, force, spectrum and multipliers as drawn, against the motion in Python."""
    for series, point, branch in ((0, 20, page_results.response), (1, 9, page_results.branches[0])):
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
        shown.js("((s) => { s.value = 'force'; s.onchange(); })(byId('spectrum-of'))")
        shown.settle()
        height = np.array(shown.js("byId('spectrum').data[0].y.filter((_, i) => i % 3 === 1)"))
        of_force = motion.spectrum("mesh_force")[1][:len(amplitude)]
        seen = (of_force > 3e-3 * of_force.max()).any(axis=1)
        # The samples of the page are more, and the corners of the force alias less.
        np.testing.assert_allclose(height, of_force[seen, 0], atol=1e-3 * of_force.max())
        shown.js("((s) => { s.value = 'p'; s.onchange(); })(byId('spectrum-of'))")
        shown.settle()
        real = shown.js("byId('multipliers').data.flatMap((trace) => trace.x)")
        np.testing.assert_allclose(np.sort(real), np.sort(branch.multipliers[point].real), atol=DRAWN)
        facts = shown.find("#facts").text
        assert f"point {point + 1} of {len(branch)}" in facts and f"{motion.frequency:.7g}" in facts
        assert ("unstable" in facts) == (not branch.stable[point])


def test_a_click_chooses_the_point(shown, page_results):
    branch = page_results.response
    point = int(np.argmax(branch.rms[:, 0]))
    shown.click_at("curve", branch.frequency[point], branch.rms[point, 0])
    series, found = shown.js("[state.chosen.series.place, state.chosen.point]")
    assert series == 0 and abs(found - point) <= 2  # neighbours lie within a few pixels
    assert shown.js("document.activeElement.id") == "curve"
    sweep = page_results.integration
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


def test_switches_and_quantities(shown, page_results):
    kinds = "[...new Set(byId('curve').data.map((trace) => trace.meta.kind))].sort()"
    every = shown.js(kinds)
    assert {"response", "cascade", "integration", "attractors", "specials"} <= {*every}
    for kind in ("integration", "cascade", "attractors", "specials"):
        shown.click(f"#show-{kind}")
        assert kind not in shown.js(kinds)
        shown.click(f"#show-{kind}")
        assert shown.js(kinds) == every
    jumps = "byId('curve').layout.annotations.length + byId('curve').layout.shapes.filter((s) => s.line?.dash === 'dot').length"
    assert shown.js(jumps) >= len(page_results.response.jumps)
    shown.click("#show-jumps")
    assert shown.js(jumps) == 0
    dashes = "byId('curve').data.filter((t) => t.meta.kind === 'response').map((t) => `${t.meta.stable} ${t.line.dash}`)"
    assert {*shown.js(dashes)} == {"false 5px,3px", "true solid"}
    for quantity, title in (("mesh_force_maximum", "largest mesh force  [N]"), ("shaft_torque_maximum", "[N m]"),
                            ("dynamic_factor", "dynamic factor<br>largest over mean mesh force")):
        shown.js(CHOOSE, quantity)
        shown.settle()
        assert shown.js("byId('curve').layout.yaxis.title.text") == title


def test_the_scale_is_that_of_the_stable_motions(shown, page_results):
    """In rms and in force: the stable motions of period 1 fill the picture; what is larger is told below it."""
    response, sweep = page_results.response, page_results.integration
    for name in ("rms", "mesh_force_maximum"):
        shown.js(CHOOSE, name)
        shown.settle()
        settled = np.concatenate([getattr(response, name)[response.stable], *(
            [getattr(motion, name)] for found in (sweep, page_results.attractors) for motion in found
            if motion.period == 1 and motion.stable is not False)])
        low, high = shown.js("byId('curve')._fullLayout.yaxis.range")
        assert low == 0 and settled.max() < high < 1.2 * settled.max()
        larger = max(getattr(branch, name)[branch.stable].max() for branch in page_results.branches if branch.stable.any())
        assert ("Beyond the scale" in shown.find("#beyond").text) == (larger > high or getattr(response, name).max() > high)


def test_unequal_shafts_have_panels(shown, page_results):
    shown.js(CHOOSE, "shaft_torque_maximum")
    shown.settle()
    torque = page_results.response.arrays()["shaft_torque_maximum"]
    swings = np.ptp(torque[page_results.response.stable], axis=0)
    assert swings.min() < 0.01 * swings.max()
    axes = shown.js("byId('curve').data.filter((t) => t.meta.kind === 'response').map((t) => [t.meta.column, t.yaxis])")
    assert {tuple(pair) for pair in axes} == {(0, "y3"), (1, "y4"), (2, "y")}
    for column, axis in ((0, "yaxis3"), (1, "yaxis4"), (2, "yaxis")):
        low, high = shown.js(f"byId('curve')._fullLayout.{axis}.range")
        own = torque[page_results.response.stable, column]
        assert low < own.min() and own.max() < high
    names = shown.js("byId('curve').layout.annotations.map((a) => a.text)")
    assert [*page_results.response.train.shaft_labels] == [name for name in names if name]
    # Plotly's own lines keep inside the element, which has grown.
    shown.js(CHOOSE, "rms")
    shown.settle()
    assert {axis for _, axis in shown.js(
        "byId('curve').data.filter((t) => t.meta.kind === 'response').map((t) => [t.meta.column, t.yaxis])")} == {"y"}


def test_units(shown, page_results):
    stable = page_results.response.frequency[page_results.response.stable]
    first = "byId('curve').data.find((t) => t.meta.kind === 'response' && t.meta.stable).x[0]"
    assert shown.js(first) == pytest.approx(stable[0])
    shown.click('input[name="unit-response"][value="Hz"]')
    assert shown.js(first) == pytest.approx(stable[0] * 9870 / (2 * np.pi))
    assert shown.js("byId('curve').layout.xaxis.title.text") == "fundamental frequency  [Hz]"
    assert shown.js("byId('wave').layout.xaxis.title.text") == "time  [ms]"
    shown.click("#tab-map")
    assert shown.js("byId('chart').layout.xaxis.title.text") == "fundamental frequency  [Hz]"
    assert shown.js("byId('chart').data[0].x[0]") == pytest.approx(1.6 * 9870 / (2 * np.pi))


def test_tables_sort_and_lead_to_the_motion(shown, page_results):
    shown.click("#tab-tables")
    column = "[...document.querySelectorAll('#view-tables table')][0].querySelectorAll('tbody tr')"
    rms = shown.js("(() => { const heads = [...document.querySelectorAll('#view-tables table')[0].querySelectorAll('th button')];"
                   "const i = heads.findIndex((head) => head.textContent.startsWith('rms')); heads[i].click();"
                   f"return [...{column}].map((row) => Number(row.cells[i + 1].textContent)); }})()")
    assert rms == sorted(rms) and len(rms) >= len(page_results.response.peaks())
    assert shown.js("document.querySelector('th[aria-sort]').getAttribute('aria-sort')") == "ascending"
    shown.js("document.querySelector('th[aria-sort] button').click()")
    assert shown.js("document.querySelector('th[aria-sort]').getAttribute('aria-sort')") == "descending"
    highest = max(page_results.response.peaks(), key=lambda peak: peak.rms)
    shown.click("#view-tables tbody tr td button")
    assert shown.js("[state.tab, state.chosen.series.place]") == ["response", 0]
    assert shown.js("state.chosen.series.lambda[state.chosen.point]") == pytest.approx(highest.frequency, abs=0.02)


def test_map_tells_a_cell(shown, page_results):
    shown.click("#tab-map")
    chart = page_results.stability_map
    shown.click_at("chart", chart.frequency[6], chart.parameter[3])
    text = shown.find("#cell").text
    assert f"stiffness variation = {chart.parameter[3]:.6g}" in text
    assert f"{chart.motions[3, 6]} motions, {chart.stable_motions[3, 6]} of them stable" in text
    # The curve of the period doubling lies over the map, in its units.
    line = shown.js("byId('chart').data.filter((trace) => trace.type === 'scatter').map((trace) => [trace.x, trace.y])[0]")
    np.testing.assert_allclose(line, [page_results.locus.frequency, page_results.locus.parameter])


@pytest.fixture(scope="module")
def drawn_page(drawn, tmp_path_factory):
    branch = drawn.response(start=1640, stop=1700, unit="rpm", harmonics=0, tolerance=1e-2)
    path = tmp_path_factory.mktemp("drawn") / "drawn.html"
    branch.page(path)
    return branch, path


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
@pytest.mark.parametrize("width", [1280, 390])
def test_a_train_with_a_drawing_opens_on_its_mesh_force_over_rpm(browser, drawn_page, width):
    """Ticks are plain numbers; the page is no wider than the screen."""
    branch, path = drawn_page
    page = Shown(browser, path, width=width)
    assert page.js("[state.quantity, state.unit]") == ["mesh_force_maximum", "rpm"]
    assert page.js("byId('curve').layout.yaxis.title.text") == "largest mesh force  [N]"
    assert page.js("byId('curve').layout.xaxis.title.text") == "speed of motor  [rpm]"
    first = page.js("Array.from(byId('curve').data[0].y).filter((y) => y !== null)")
    stable = branch.mesh_force_maximum[branch.stable, 0]
    assert min(first) == pytest.approx(stable.min(), rel=1e-3) and max(first) == pytest.approx(stable.max(), rel=1e-2)
    ticks = page.js("[...document.querySelectorAll('#curve .xtick text, #curve .ytick text')].map((text) => text.textContent)")
    assert len(ticks) > 5 and all(tick.replace("\u202f", "").isdigit() for tick in ticks), ticks
    top = page.js("byId('curve')._fullLayout.yaxis.range")[1]
    assert branch.mesh_force_maximum[branch.stable].max() < top
    facts = page.find("#facts").text
    assert "largest mesh force, N" in facts and "true rms" in facts and "rms of the paper" not in facts
    assert page.js("document.documentElement.scrollWidth") <= width
    assert page.complaints() == [""]


@pytest.mark.filterwarnings("ignore::geartrain.DrawingWarning")
def test_a_motion_of_a_window(browser, tmp_path):
    """Time and orders are those of the window that its coefficients stand for: the engine's order 2 is the largest line."""
    case = gt.read_case(ROOT / "namelists" / "rattle.nml")
    results = case.run()
    (motion,) = results.integration
    assert motion.window and not motion.period
    results.page(tmp_path / "window.html")
    page = Shown(browser, tmp_path / "window.html")
    x, y = (np.array(page.js(f"Array.from(byId('spectrum').data[1].{axis})"), float) for axis in "xy")
    assert x[np.nanargmax(y)] == pytest.approx(2.0, abs=0.1)
    assert np.nanmax(y) == pytest.approx(motion.spectrum()[1][:, 1].max(), rel=1e-3)
    # The loose wheels carry a hundredth of the load.
    assert {*page.js("byId('curve').data.map((t) => t.yaxis)")} == {"y", "y3", "y4"}
    assert page.complaints() == [""]


def test_two_files_and_a_narrow_screen(browser, branch, train, tmp_path, monkeypatch):
    other = train.with_values({"mesh 2 damping_ratio": 0.07}).response(start=0.4, stop=1.0)
    path = tmp_path / "both.html"
    monkeypatch.setattr("geartrain.pages.page._LARGE", 0)
    monkeypatch.setattr("geartrain.pages.page._SPARSE", 2)
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


@pytest.mark.parametrize("width", [1280, 390])
def test_pictures_of_planetary_sets(browser, tmp_path, width):
    """Below the drawing of the train one of each set, loaded, in full view or in a frame that scrolls."""
    train = gt.read_case(ROOT / "namelists" / "ravigneaux.nml").train
    train.response(start=1500.0, stop=1510.0, unit="rpm", harmonics=3).page(tmp_path / "sets.html")
    page = Shown(browser, tmp_path / "sets.html", width=width)
    page.click("#tab-train")
    page.until("[...document.querySelectorAll('#view-train img')].every((image) => image.complete)")
    images = page.js("[...document.querySelectorAll('#view-train img')].map((i) => [i.naturalWidth > 100, i.alt.split(':')[0]])")
    assert images == [[True, "The train"], [True, "short"], [True, "long"]]
    boxes = page.js("[...document.querySelectorAll('#view-train img')].map((i) => i.getBoundingClientRect().toJSON())")
    assert all(one["bottom"] <= other["top"] for one, other in pairwise(boxes))
    assert all(box["height"] > 250 for box in boxes) and page.js("document.documentElement.scrollWidth") <= width
    assert page.complaints() == [""]


def test_a_parameter_in_the_browser(over_backlash, browser, tmp_path):
    over_backlash.page(tmp_path / "over.html")
    page = Shown(browser, tmp_path / "over.html")
    assert page.js("byId('curve').layout.xaxis.title.text") == "mesh 2 half backlash  [m]"
    assert page.js("byId('curve').data[0].x[0]") == pytest.approx(over_backlash.parameter[0])
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
