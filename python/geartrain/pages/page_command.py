"""``geartrain-page RESULTS.h5``: a results file as a page for a browser."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from .._core.parser import Parser
from ..case import read_results
from ..errors import InputError, plain
from .page import page

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 written; 2 bad arguments, or nothing to show; 4 a file cannot be read or written."""
    told = _parser().parse_args(arguments)
    output = Path(told.output) if told.output else Path(told.results).with_suffix(".html")
    paths = [told.results, *([told.compare] if told.compare else [])]
    if any(output.exists() and output.samefile(path) for path in paths if Path(path).exists()):
        print(plain(f"{output}: is a results file: name the page by -o"), file=sys.stderr)
        return 2
    try:
        results = [read_results(path) for path in paths]
        names = ("", "") if told.compare is None else _names(*paths)
        made = page(results[0], output, compare=results[1] if told.compare else None, names=names)
    except (InputError, ModuleNotFoundError) as error:
        print(plain(str(error), lines=True), file=sys.stderr)
        return 2
    except OSError as error:
        print(plain(str(error), lines=True), file=sys.stderr)
        return 4
    print(plain(f"Written: {output}, {len(made.html.encode()) / 1e6:.2f} MB, for any browser"))
    if told.show:
        made.show()
    return 0


def _names(one: str, other: str) -> tuple[str, str]:
    """What two files are called: their names, or their paths where the names are the same."""
    names = Path(one).stem, Path(other).stem
    return names if names[0] != names[1] else (one, other)


def _parser() -> Parser:
    parser = Parser(prog="geartrain-page", description="Make a page for a browser of a results file.")
    parser.add_argument("results", metavar="RESULTS.h5", help="results file, as the executable or Python has written it")
    parser.add_argument("-o", "--output", metavar="PAGE.html", help="where to write the page; beside the file unless told")
    parser.add_argument("--compare", metavar="OTHER.h5", help="a second results file, laid over the first")
    parser.add_argument("--show", action="store_true", help="open it in the browser")
    return parser


if __name__ == "__main__":
    sys.exit(main())
