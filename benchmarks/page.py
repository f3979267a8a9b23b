"""How fluid a page of 10,000 points is: times between frames while the pointer hovers, the curves are dragged, a key is held.

`python benchmarks/page.py` needs Chromium and its driver, Debian's packages chromium and chromium-driver.
"""

import shutil
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from selenium import webdriver
from selenium.webdriver import ActionChains
from selenium.webdriver.common.keys import Keys

import geartrain as gt

POINTS, MOVES = 10_000, 60
FLAGS = ("headless=new", "no-sandbox", "disable-gpu", "no-first-run", "disable-background-networking", "window-size=1400,1000")
#: Collects the times between frames until it is told to stop.
WATCH = """window.times = []; window.watching = true;
(function next(last) {
  const now = performance.now();
  times.push(now - last);
  if (watching) requestAnimationFrame(() => next(now));
})(performance.now());"""


def finer(branch, points):
    """A branch with points put between its own, linearly: as many to draw as a long one has."""
    at = np.linspace(0, len(branch) - 1, points)
    below = np.minimum(at.astype(int), len(branch) - 2)

    def between(values):
        if values is None or values.dtype.kind in "bi":
            return None if values is None else values[np.rint(at).astype(int)]
        share = (at - below).reshape(-1, *[1] * (values.ndim - 1))
        return (1 - share) * values[below] + share * values[below + 1]

    arrays = branch.arrays()
    own = {name: between(values) for name, values in arrays.items() if name not in branch.others}
    others = {name: between(values) for name, values in branch.others.items()}
    return replace(branch, **own, others=others, special_points=[], branches=[])


def measured(driver, name, work):
    """The times between frames while something is done."""
    driver.execute_script(WATCH)
    work()
    times = np.array(driver.execute_script("watching = false; return times.slice(2)"))
    told = ", ".join(f"{share} % {np.percentile(times, share):.0f} ms" for share in (50, 95, 99))
    print(f"{name:22} {len(times):4} frames: {told}, longest {times.max():.0f} ms")


def main():
    train = gt.read_case(Path(__file__).parents[1] / "namelists" / "fig03.nml").train
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        print(finer(train.response(start=0.2, stop=2.6, harmonics=10), POINTS).page(path), f"{POINTS} points")
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for flag in (*FLAGS, f"user-data-dir={folder}/browser"):
            options.add_argument(f"--{flag}")
        driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
        begun = time.perf_counter()
        driver.get(path.as_uri())
        while not driver.execute_script("return document.documentElement.dataset.ready === 'yes'"):
            time.sleep(0.02)
        print(f"drawn after {time.perf_counter() - begun:.2f} s")
        time.sleep(1)
        curve = driver.find_element("id", "curve")
        middle = curve.find_element("css selector", ".nsewdrag")

        def hover():
            chain = ActionChains(driver, duration=20)
            for move in range(MOVES):
                chain.move_to_element_with_offset(middle, 8 * move - 250, 10 * (move % 7) - 30)
            chain.perform()

        def drag():
            driver.execute_script("Plotly.relayout('curve', {dragmode: 'pan'})")
            chain = ActionChains(driver, duration=20).move_to_element(middle).click_and_hold()
            for move in range(MOVES):
                chain.move_by_offset(4 if move < MOVES // 2 else -4, 2)
            chain.release().perform()

        def hold_key():
            for _ in range(MOVES):
                curve.send_keys(Keys.ARROW_RIGHT)

        measured(driver, "nothing", lambda: time.sleep(1))
        measured(driver, "hovering", hover)
        measured(driver, "dragging", drag)
        measured(driver, "along by the arrow key", hold_key)
        driver.quit()


if __name__ == "__main__":
    main()
