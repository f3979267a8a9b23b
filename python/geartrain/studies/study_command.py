"""``geartrain-study FOLDER``: computes the points of a study that are not there yet, without a coordinator."""

from __future__ import annotations

import argparse
import re
import signal
import sys
from collections.abc import Sequence

from .._core.parser import Parser, exit_status
from ..errors import plain
from .study import read_study, run_plan
from .study_failures import failures_of, words_of
from .study_store import Store
from .study_worker import STOPS

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit status: 0 no point of the part failed; 1 some did; 2 bad arguments; 3 ended early; 4 the file system failed.

    A part leaves to other processes what they have begun; the whole waits for them.
    """
    told = _parser().parse_args(arguments)
    for number in STOPS:
        signal.signal(number, signal.default_int_handler)  # so that what is done is written before a limit of the cluster kills
    return exit_status(lambda: _tell(told.folder) if told.status else _compute(told))


def _tell(folder: str) -> int:
    explanation = read_study(folder).explain()
    print(plain(str(explanation), lines=True))
    return 1 if explanation.failed else 0


def _compute(told: argparse.Namespace) -> int:
    store = Store(told.folder)
    plan = store.plan()
    number, parts = told.part
    if parts == 1:
        store.mend()
    blocks = range(number - 1, plan.blocks, parts)
    if told.retry:
        print(f"{len(failures_of(plan, store, blocks))} points that failed are computed again", flush=True)
    workers = told.workers or (1 if parts > 1 else 0)
    there = run_plan(plan, store, blocks, workers=workers, retry=told.retry, patient=parts == 1)
    failures = failures_of(plan, store, blocks)
    if failures:
        print(plain(words_of(plan, failures), lines=True))
    failed = f", {there.failed} of them failed" if there.failed else ""
    print(plain(f"{there.there} of {len(plan.distinct)} points are in {told.folder}{failed}"))
    return 1 if failures else 0


def _parser() -> Parser:
    parser = Parser(prog="geartrain-study", description="Compute the points of a study that are not there yet.")
    parser.add_argument("folder", help="folder of a study, as Study.run or Study.prepare has written it")
    told = "every 64th batch, from the 7th: a task of an array job"
    parser.add_argument("--part", type=_part, default=(1, 1), metavar="7/64", help=told)
    parser.add_argument("--workers", type=int, default=0, help="processes; all cores unless told, one of a --part")
    parser.add_argument("--status", action="store_true", help="tell how far it is, and compute nothing")
    parser.add_argument("--retry", action="store_true", help="compute points that failed again")
    return parser


def _part(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise argparse.ArgumentTypeError(f"{text!r}: must be as 7/64, the first number from 1 to the second")
    return int(found[1]), int(found[2])


if __name__ == "__main__":
    sys.exit(main())
