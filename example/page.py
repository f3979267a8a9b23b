"""A page for a browser: the train of figure 3 with its period doublings, time integration, attractors and a stability map.

`python example/page.py results` writes results/page.html; `python example/page.py results docs` also takes its picture, docs/page.png,
which needs Chromium.
"""

import subprocess
import sys
from pathlib import Path

import geartrain as gt

train = gt.read_case(Path(__file__).parents[1] / "namelists" / "fig03.nml").train
analyses = {
    "response": {"start": 0.2, "stop": 2.6, "harmonics": 10, "period_doublings": 1},
    "integration": {"start": 0.4, "stop": 2.4, "points": 101, "direction": "both", "stability": True},
    "attractors": {"frequency": 1.6, "starts": 60},
    "stability_map": {"start": 0.2, "stop": 2.6, "points": 121, "parameter_start": 0.0, "parameter_stop": 0.5, "parameter_points": 41},
}

if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    case = folder / "page.nml"
    case.write_text(train.namelist(modes=True, **analyses))
    page = folder / "page.html"
    print(gt.read_case(case).run().page(page), page)
    if len(sys.argv) > 2:
        # Time in the page goes on at once until the pictures are drawn.
        flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--window-size=1400,1230"]
        flags.append("--virtual-time-budget=20000")
        picture = f"--screenshot={Path(sys.argv[2]).resolve() / 'page.png'}"
        subprocess.run(["chromium", *flags, picture, page.resolve().as_uri()], check=True, capture_output=True)
