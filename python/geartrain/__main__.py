"""``python -m geartrain``: what there is. With arguments it is the executable ``geartrain``, where that is installed."""

from __future__ import annotations

import os
import shutil
import sys
import sysconfig
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import geartrain

from ._core.extras import OPTIONAL, cure

__all__ = ["main"]

_TOLD = """\
geartrain {version}: nonlinear torsional dynamics of gear trains

In Python
   import geartrain as gt
   gt.read_case("case.nml").run()     runs a case file
   gt.Train(...).response(...)        the same from Python; help(gt) begins with an example, help(gt.Train) tells all
   gt.read_results("case.h5")         what a run has written
   gt.read_rexs("gearbox.rexs")       a gearbox that another program has written

Commands
   geartrain --new case.nml           writes a commented case to begin with; geartrain --help tells the rest
                                      {executable}
   geartrain-page RESULTS.h5          makes a page for a browser of a results file
   geartrain-report RESULTS.h5 -o R.pdf  writes a report of a results file
   geartrain-rexs GEARBOX.rexs        prints a case of a gearbox that another program has written
   geartrain-study FOLDER             computes the points of a study that are not there yet
   python -m geartrain ...            is geartrain ...

Packages that some calls need
{packages}
Documentation: docs/ of the sources; scripts/site makes a site of it.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: that of the executable; 0 without arguments; 2 where there is no executable to take them."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    path = os.pathsep.join([sysconfig.get_path("scripts"), *_of_clone(), os.environ.get("PATH", os.defpath)])
    executable = shutil.which("geartrain", path=path)
    if words and executable is None:
        print("geartrain: error: there is no executable geartrain, neither on PATH nor in build/release of a clone; the sources "
              "build it: scripts/setup", file=sys.stderr)
        return 2
    if words and executable is not None:
        sys.stdout.flush()
        os.execv(executable, [executable, *words])
    print(_told(executable), end="")
    return 0


def _of_clone() -> list[str]:
    """Where a clone has the executable: beside its environment `.venv`, or the sources that this package is run from."""
    roots = [Path(sys.prefix).parent, Path(__file__).resolve().parents[2]]
    return [str(root / "build" / "release") for root in roots if (root / "fpm.toml").is_file()]


def _told(executable: str | None) -> str:
    found = f"found: {executable}" if executable else "not found; the sources build it: scripts/setup"
    packages = "".join(f"   {name:<12}{'there' if find_spec(name) else cure(name)}\n" for name in OPTIONAL)
    return _TOLD.format(version=geartrain.__version__, executable=found, packages=packages)


if __name__ == "__main__":
    sys.exit(main())
