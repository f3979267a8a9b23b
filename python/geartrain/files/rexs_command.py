"""``geartrain-rexs GEARBOX.rexs > CASE.nml``: the case of a REXS file."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Sequence

from .._core.parser import Parser, exit_status
from ..errors import InputError, shown
from .rexs import case_of_rexs

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 printed; 2 bad arguments or a bad file; 4 the file cannot be read, or standard output not written."""
    return exit_status(lambda: _print_case(_parser().parse_args(arguments)))


def _print_case(told: Namespace) -> int:
    try:
        text = case_of_rexs(told.gearbox, load_case=told.load_case, pitch_errors=_tables(told.pitch_errors))
    except OSError as error:
        raise OSError(f"{error.filename or told.gearbox}: cannot be read: {error.strerror or error}") from error
    try:
        sys.stdout.buffer.write(text.encode())
        sys.stdout.flush()
    except OSError as error:
        raise OSError(f"standard output cannot be written: {error.strerror or error}") from error
    return 0


def _tables(pairs: list[list[str]]) -> dict[str, str]:
    """Files by gears, none of which may come twice."""
    gears = [gear for gear, _ in pairs]
    twice = [gear for gear in gears if gears.count(gear) > 1]
    if twice:
        raise InputError(f"geartrain-rexs: error: --pitch-errors {shown(twice[0])}: is given twice")
    return dict(pairs)


def _parser() -> Parser:
    parser = Parser(prog="geartrain-rexs", description="Print the case of a gearbox in a REXS file: every number with its "
                                                       "component, what was assumed and what is missing.")
    parser.add_argument("gearbox", metavar="GEARBOX.rexs", help="REXS 1.0 to 2.0: .rexs (XML), .rexsj (JSON), .rexsz (zip)")
    parser.add_argument("--load-case", type=int, metavar="N", help="of the load spectrum, from 1 on; unless told the "
                                                                   "loads beside it, or the case of the longest time")
    parser.add_argument("--pitch-errors", nargs=2, action="append", default=[], metavar=("GEAR", "TABLE.txt"),
                        help="measured pitch errors of a gear, 'mesh 1 driving' or the gear's own name; a line has the cumulative "
                             "error of a tooth on the reference circle, in um or the unit of a heading; may be given several times")
    return parser


if __name__ == "__main__":
    sys.exit(main())
