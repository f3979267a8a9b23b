"""``geartrain-page RESULTS.h5``: a results file as a page for a browser."""

from __future__ import annotations

import sys
import warnings
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from .._core.parser import Parser, exit_status, refuse_other_file
from ..case import read_results
from ..errors import DrawingWarning, plain
from .page import page

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 written; 2 bad arguments, or nothing to show; 4 a file cannot be read or written."""
    return exit_status(lambda: _page(_parser().parse_args(arguments)))


def _page(told: Namespace) -> int:
    output = Path(told.output) if told.output else Path(told.results).with_suffix(".html")
    paths = [told.results, *([told.compare] if told.compare else [])]
    refuse_other_file(output)
    names = ("", "") if told.compare is None else _names(*paths)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DrawingWarning)  # the page has them
        results = [read_results(path) for path in paths]
        made = page(results[0], output, compare=results[1] if told.compare else None, names=names)
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
