"""Whether two executables list the same of every branch: folds, changes of stability, branch points, onsets, jumps, peaks, ranges.

    python benchmarks/same_lists.py OLD NEW [--trains 200] [--folder FOLDER] [--harmonics N]

The cases are those in ``namelists``, the paper's cases and random trains (``test/python/random_trains.py``). The program prints
each item that only one executable lists, each difference above 1e-8, and the number of points of all branches. A third run of OLD
with a tenth of the step decides which executable is right: "fine has it" or "fine lacks it" is its answer.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "test" / "python"), str(ROOT / "example" / "paper")]

import random_trains  # noqa: E402

from paper_cases import case_texts  # noqa: E402

#: Groups of a branch, the fields that tell what an item is, the fields compared, and the field by which items are paired.
LISTS = {
    "special_points": (("kind",), ("frequency", "rms"), "frequency"),
    "onsets": (("kind", "mesh"), ("frequency", "rms"), "frequency"),
    "jumps": (("kind", "direction", "cause"), ("frequency", "rms_before"), "frequency"),
    "peaks": (("mesh",), ("frequency", "rms"), "frequency"),
    "separation_ranges": (("mesh", "stable"), ("from", "to"), "from"),
    "back_collision_ranges": (("mesh", "stable"), ("from", "to"), "from"),
    "bands_without_stability": ((), ("from", "to"), "from"),
}
#: Relative difference up to which numbers are equal, and up to which items are one.
EQUAL, SAME = 1e-8, 3e-3


def response_only(text: str, step: float | None = None) -> str | None:
    """A case with its response alone."""
    found = re.search(r"&response(.*?)(?<=[\s,'\"])/", text, re.S)
    if not found:
        return None
    others = "modes|integration|attractors|stability_map|output|run_up|locus|motions|basins|lyapunov"
    text = re.sub(rf"^&({others})\b.*?/\s*?$", "", text, flags=re.S | re.M)
    if step:
        text = re.sub(r"step\s*=\s*[\d.e-]+\s*,?", "", text).replace("&response", f"&response step = {step},")
    return text


def random_case(seed: int, most: int | None = None) -> str:
    """A random train over a range about a natural frequency, with 3 to 8 harmonics of its fastest mesh or with `most`."""
    rng = np.random.default_rng(seed)
    train = random_trains.random_train(rng)
    order = max(mesh.order or 1 for mesh in train.meshes) if all(mesh.order for mesh in train.meshes) else 1
    natural = float(rng.choice(train.modes().natural_frequency)) / order
    low, high = natural * rng.uniform(0.35, 0.8), natural * rng.uniform(1.1, 1.4)
    harmonics = most or int(rng.integers(3, 9)) * order
    return train.namelist(response={"start": low, "stop": high, "harmonics": harmonics, "max_points": 3000})


def run(executable: str, texts: dict[str, str], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / f"{name}.nml").write_text(text, encoding="utf-8")
    todo = [f"{name}.nml" for name in texts if not (folder / f"{name}.h5").exists()]
    if todo:
        subprocess.run([os.path.abspath(executable), *todo], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def lists_of(path: Path) -> dict[str, list[dict[str, object]]] | None:
    if not path.exists():
        return None
    result: dict[str, list[dict[str, object]]] = {}
    with h5py.File(path) as file:
        for home in file:
            if not (home == "response" or home.startswith("branch")):
                continue
            for name, (kinds, fields, key) in LISTS.items():
                rows = result.setdefault(f"{home}/{name}", [])
                group = file[home].get(name)
                if group is None:
                    continue
                free = "parameter" if "parameter" in group else "frequency"
                for i in range(len(group[free if key == "frequency" else key])):
                    row = {kind: _plain(group[kind][i]) for kind in kinds if kind in group}
                    row |= {field: np.atleast_1d(group[free if field == "frequency" else field][i]) for field in fields}
                    rows.append(row)
            result[f"{home}/points"] = [{"points": len(file[home]["segment"]) if "segment" in file[home] else 0}]
    return result


def _plain(value: object) -> object:
    return value.decode() if isinstance(value, bytes) else getattr(value, "item", lambda: value)()


def pairs(old: list, new: list, name: str):
    """Pairs of items, and what is left of either list."""
    kinds, fields, key = LISTS[name]
    fits = [(max(float(np.max(np.abs(item[f] - other[f]) / (np.max(np.abs(item[f])) + 1e-300))) for f in fields), i, k)
            for i, item in enumerate(old) for k, other in enumerate(new)
            if all(item.get(kind) == other.get(kind) for kind in kinds)]
    compared = [key] if key == "frequency" else fields
    both, taken = [], (set(), set())
    # The nearest two first: of three points close together that one list lacks two of, the right one is paired.
    for off, i, k in sorted(fits):
        if off >= (SAME if name != "peaks" else 0.05):
            break
        if i in taken[0] or k in taken[1]:
            continue
        taken[0].add(i)
        taken[1].add(k)
        size = max(float(np.max(np.abs(old[i][f] - new[k][f]) / np.max(np.abs(old[i][f])))) for f in compared)
        both.append((size, old[i], new[k]))
    rest, left = ([item for i, item in enumerate(items) if i not in used] for items, used in zip((old, new), taken))
    return both, rest, left


def words(item: dict[str, object]) -> str:
    return ", ".join(f"{k} {np.round(v, 9) if isinstance(v, np.ndarray) else v}" for k, v in item.items())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--trains", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--folder", type=Path, default=None)
    parser.add_argument("--fine", type=float, default=0.005)
    parser.add_argument("--harmonics", type=int, default=None, help="of the random trains")
    chosen = parser.parse_args()
    folder = chosen.folder or Path(tempfile.mkdtemp())
    texts = {path.stem: path.read_text(encoding="utf-8") for path in sorted((ROOT / "namelists").glob("*.nml"))} | case_texts()
    texts = {name: cut for name, text in texts.items() if (cut := response_only(text))}
    kept = folder / "cases"
    kept.mkdir(parents=True, exist_ok=True)
    for seed in range(chosen.first, chosen.first + chosen.trains):
        path = kept / f"random_{seed:03}.nml"
        if not path.exists():
            path.write_text(random_case(seed, chosen.harmonics), encoding="utf-8")
        texts[path.stem] = path.read_text(encoding="utf-8")
    run(chosen.old, texts, folder / "old")
    run(chosen.new, texts, folder / "new")
    differ: dict[str, list[tuple[str, str, dict]]] = {}
    largest: dict[str, tuple[float, str]] = {}
    points = np.zeros(2, int)
    numbers: dict[str, np.ndarray] = {}
    for case in texts:
        old, new = (lists_of(folder / which / f"{case}.h5") for which in ("old", "new"))
        if old is None or new is None:
            print(f"{case}: no results of {'both' if old is new else 'old' if old is None else 'new'}")
            continue
        for home in sorted({*old, *new}):
            name = home.split("/")[1]
            a, b = old.get(home, []), new.get(home, [])
            if name == "points":
                points += [sum(row["points"] for row in rows) for rows in (a, b)]
                continue
            both, only_old, only_new = pairs(a, b, name)
            numbers[name] = numbers.get(name, np.zeros(3, int)) + np.array([len(both), len(only_old), len(only_new)])
            differ.setdefault(case, []).extend(("old", home, item) for item in only_old)
            differ[case].extend(("new", home, item) for item in only_new)
            for size, item, _ in both:
                if size > largest.get(name, (0.0, ""))[0]:
                    largest[name] = size, f"{case}: {words(item)}"
                if size > EQUAL and name != "peaks":
                    differ[case].append((f"both, {size:.0e}", home, item))
    fine = {case: response_only(texts[case], chosen.fine) for case, items in differ.items() if items}
    fine = {case: text.replace("max_points = 3000", "max_points = 30000") for case, text in fine.items() if text}
    run(chosen.old, fine, folder / "fine")
    for case, items in differ.items():
        judge = lists_of(folder / "fine" / f"{case}.h5") if items else None
        for where, home, item in items:
            there = "unknown"
            if judge is not None:
                both, _, _ = pairs([item], judge.get(home, []), home.split("/")[1])
                there = f"has it, {both[0][0]:.0e}" if both else "lacks it"
            print(f"{case} {home}: {where}; fine {there}: {words(item)}")
    print(f"points: {points[0]} old, {points[1]} new")
    for name, (both, only_old, only_new) in numbers.items():
        print(f"{name}: {both} in both, {only_old} in old only, {only_new} in new only; largest difference "
              f"{largest.get(name, (0.0, ''))[0]:.1e} {largest.get(name, (0.0, ''))[1]}")


if __name__ == "__main__":
    main()
