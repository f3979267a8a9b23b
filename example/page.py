"""A page for a browser: the train of figure 3 with its period doublings, time integration, attractors and a stability map.

`python example/page.py results` writes results/page.html; `python example/page.py results docs` also takes a picture of it,
docs/page.png, which needs Chromium and Selenium.
"""

import shutil
import sys
import time
from io import BytesIO
from pathlib import Path

import geartrain as gt

train = gt.read_case(Path(__file__).parents[1] / "namelists" / "fig03.nml").train
analyses = {
    "response": {"start": 0.2, "stop": 2.6, "harmonics": 10, "period_doublings": 1},
    "integration": {"start": 0.4, "stop": 2.4, "points": 101, "direction": "both", "stability": True},
    "attractors": {"frequency": 1.6, "starts": 60},
    "stability_map": {
        "start": 0.2, "stop": 2.6, "points": 121, "parameter_start": 0.0, "parameter_stop": 0.5, "parameter_points": 41,
    },
}


def take_picture(page, picture):
    """A picture of the page as a browser shows it."""
    from PIL import Image
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    for flag in ("headless=new", "no-sandbox", "disable-gpu", "hide-scrollbars", "window-size=1400,1520"):
        options.add_argument(f"--{flag}")
    with webdriver.Chrome(options, webdriver.ChromeService(shutil.which("chromedriver"))) as driver:
        driver.get(page.resolve().as_uri())
        while not driver.execute_script("return document.getElementById('point')?.dataset.drawn === 'yes'"):
            time.sleep(0.1)
        time.sleep(0.5)  # for what fades in
        shown = Image.open(BytesIO(driver.get_screenshot_as_png()))
    shown.convert("P", palette=Image.Palette.ADAPTIVE, colors=64).save(picture, optimize=True)


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    case = folder / "page.nml"
    case.write_text(train.namelist(modes=True, **analyses))
    page = folder / "page.html"
    print(gt.read_case(case).run().page(page), page)
    if len(sys.argv) > 2:
        take_picture(page, Path(sys.argv[2]) / "page.png")
