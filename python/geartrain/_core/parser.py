"""What the commands share: their parser, what they end with, and what they may not write over."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from ..errors import InputError, Interrupted, SolverError, plain

__all__ = ["Parser", "exit_status", "refuse_other_file"]


class Parser(argparse.ArgumentParser):
    """A parser whose errors are escaped: an argument may contain anything."""

    def error(self, message: str) -> NoReturn:
        super().error(plain(message))


def exit_status(work: Callable[[], int]) -> int:
    """What a command ends with.

    `work`'s own status; or that of its error, which is told on standard error: 2 for bad arguments, a bad file or a package that is
    missing, 3 for what ended early, 4 where the file system failed.
    """
    told: BaseException
    try:
        return work()
    except (InputError, ModuleNotFoundError) as error:
        told, status = error, 2
    except (Interrupted, SolverError) as error:
        told, status = error, 3
    except OSError as error:
        told, status = error, 4
    print(plain(str(told), lines=True), file=sys.stderr)
    return status


def refuse_other_file(output: Path) -> None:
    """InputError where a command would replace a file that is neither a page nor a report."""
    if output.is_file():
        with output.open("rb") as file:
            begin = file.read(14).lower()
        if not begin.startswith((b"<!doctype html", b"%pdf-")):
            raise InputError(f"{output}: is neither a page nor a report, and would be replaced: give another name by -o")
