"""``geartrain-report RESULTS.h5 -o REPORT.pdf``: a results file as a report."""

from __future__ import annotations

import sys
import warnings
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path

from .._core.parser import Parser, exit_status, refuse_other_file
from ..case import read_results
from ..errors import DrawingWarning, plain

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 written; 2 bad arguments; 4 a file cannot be read or written."""
    return exit_status(lambda: _report(_parser().parse_args(arguments)))


def _report(told: Namespace) -> int:
    output = Path(told.output) if told.output else Path(told.results).with_suffix(".pdf")
    refuse_other_file(output)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DrawingWarning)  # the report has them
        read_results(told.results).report(output)
    print(plain(f"Written: {output}"))
    return 0


def _parser() -> Parser:
    parser = Parser(prog="geartrain-report", description="Make a report of a results file, as PDF or HTML.")
    parser.add_argument("results", metavar="RESULTS.h5", help="results file, as the executable or Python has written it")
    parser.add_argument("-o", "--output", metavar="REPORT.pdf", help="ends in .pdf or .html; beside the results file unless told")
    return parser


if __name__ == "__main__":
    sys.exit(main())
