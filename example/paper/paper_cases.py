"""The paper's cases as case files: ``python example/paper/paper_cases.py FOLDER`` writes all of them.

Figures 3 and 10 to 13 have files of their own in ``namelists``. The others are figure 3's train with one value changed: the list
``CHANGES`` holds these values.
"""

from __future__ import annotations

import re
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import geartrain as gt

__all__ = ["CHANGES", "case_texts", "chain", "main", "paper_case", "write_cases"]

NAMELISTS = Path(__file__).resolve().parents[2] / "namelists"

#: Name, end of the title, group whose value is not that of figure 3 ("mesh": of both meshes), the value, harmonics of the response
#: (0: natural frequencies alone).
CHANGES = (
    ("fig04_k3_2e4", ", k3 = 2.0e4 N m/rad", "shaft 2", "stiffness = 2.0e4", 6),
    ("fig04_k3_5e5", ", k3 = 5.0e5 N m/rad", "shaft 2", "stiffness = 5.0e5", 6),
    ("fig04_k3_1e6", ", k3 = 1.0e6 N m/rad", "shaft 2", "stiffness = 1.0e6", 6),
    ("fig04_k3_1e8", ", k3 = 1.0e8 N m/rad", "shaft 2", "stiffness = 1.0e8", 6),
    ("fig05", "", "", "", 0),
    ("fig06_050", ", 50 N m", "train", "input_torque = 50.0", 6),
    ("fig06_100", ", 100 N m", "train", "input_torque = 100.0", 6),
    ("fig06_150", ", 150 N m", "train", "input_torque = 150.0", 6),
    ("fig07_010", ", kappa = 0.1", "mesh", "stiffness_cos = 0.1", 6),
    ("fig07_020", ", kappa = 0.2", "mesh", "stiffness_cos = 0.2", 6),
    ("fig07_030", ", kappa = 0.3", "mesh", "stiffness_cos = 0.3", 6),
    ("fig07_042", ", kappa = 0.42", "mesh", "stiffness_cos = 0.42", 6),
    ("fig08_printed", " as printed", "mesh", "stiffness_cos = 0.42, 0.0, -0.141, 0.0, -0.085", 12),
    ("fig08_rectangular", ", rectangular wave", "mesh", "stiffness_cos = 0.42, 0.0, -0.141, 0.0, 0.084", 12),
    ("fig09_001", ", zeta_m = 0.01", "mesh", "damping_ratio = 0.01", 12),
    ("fig09_003", ", zeta_m = 0.03", "mesh", "damping_ratio = 0.03", 6),
    ("fig09_005", ", zeta_m = 0.05", "mesh", "damping_ratio = 0.05", 6),
)


def case_texts() -> dict[str, str]:
    """Text of each case file of the paper.

    Returns
    -------
    dict
        By name, in the order of the figures.
    """
    texts = {path.stem: path.read_text(encoding="utf-8") for path in NAMELISTS.glob("fig*.nml")}
    train = "&train" + texts["fig03"].split("&train")[1].split("&modes")[0]
    for name, title, group, value, harmonics in CHANGES:
        figure = f"figure {int(name[3:5])}{title}"
        analyses = f"&response     from = 0.2, to = 2.6, harmonics = {harmonics} /" if harmonics else "&modes /"
        changed = train.replace("figure 3", figure)
        if group:
            variable = value.split(" = ")[0]
            kind, _, number = group.partition(" ")
            parts = changed.split(f"&{kind}")
            for place in [int(number)] if number else range(1, len(parts)):
                parts[place] = re.sub(rf"\b{variable}\s*= [-\d.e]+", value, parts[place], count=1)
            changed = f"&{kind}".join(parts)
        texts[name] = f"! {figure.capitalize()}.\n\n{changed}{analyses}\n&output       file = '{name}.h5' /\n"
    return dict(sorted(texts.items()))


def write_cases(folder: Path) -> Path:
    """Write all case files of the paper.

    Parameters
    ----------
    folder : path
        Made where it is not there.

    Returns
    -------
    path
        The folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in case_texts().items():
        (folder / f"{name}.nml").write_text(text, encoding="utf-8")
    return folder


def paper_case(name: str) -> gt.Case:
    """Read a case of the paper, or another one of ``namelists``.

    Parameters
    ----------
    name : str
        Of a case file, without its ending.

    Returns
    -------
    geartrain.Case
    """
    path = NAMELISTS / f"{name}.nml"
    if path.exists():
        return gt.read_case(path)
    with tempfile.TemporaryDirectory() as folder:
        return gt.read_case(write_cases(Path(folder)) / path.name)


def chain(shafts: int) -> gt.Train:
    """A train of that many shafts: figure 3's pairs by turns, the second one turned round so that no torque grows."""
    figure3 = paper_case("fig03").train
    down, after = figure3.meshes
    up = replace(
        after, driving_radius=after.driven_radius, driven_radius=after.driving_radius,
        driving_inertia=after.driven_inertia, driven_inertia=after.driving_inertia,
    )  # fmt: skip
    first, middle, last = figure3.shafts
    return replace(
        figure3, title=f"chain of {shafts} shafts", shafts=[first, *[middle] * (shafts - 2), last],
        meshes=[(down, up)[number % 2] for number in range(shafts - 1)],
    )  # fmt: skip


def main(arguments: list[str]) -> int:
    """Run the module as a program; the exit status."""
    if len(arguments) != 1:
        print("usage: python example/paper/paper_cases.py FOLDER", file=sys.stderr)
        return 2
    print(f"{len(case_texts())} cases in {write_cases(Path(arguments[0]))}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
