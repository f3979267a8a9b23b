"""The parser of the commands."""

from __future__ import annotations

import argparse
from typing import NoReturn

from ..errors import plain

__all__ = ["Parser"]


class Parser(argparse.ArgumentParser):
    """A parser whose errors are escaped: an argument may contain anything."""

    def error(self, message: str) -> NoReturn:
        super().error(plain(message))
