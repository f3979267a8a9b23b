"""How far a study is: a bar on a terminal or in a notebook."""

from __future__ import annotations

import sys
import time
from itertools import islice
from typing import Any

from .._core.watch import progress_bar
from .study_plan import Plan
from .study_store import DONE, Store

__all__ = ["Progress"]


class Progress:
    """Counts the points of a plan that are in the folder; use it in a ``with`` statement.

    Attributes
    ----------
    there, failed : int
    """

    def __init__(self, plan: Plan, store: Store, show: bool = True, note: str = "") -> None:
        self._plan, self._store = plan, store
        self.there = self.failed = self._counted = 0
        self.look()
        self._bar: Any = progress_bar("study", len(plan.distinct), time.monotonic(), "points") if show else None
        if self._bar is not None:
            self._bar.n = self._bar.initial = self.there
            if note and not self._bar.disable:
                self._bar.write(note, file=sys.stderr)

    def look(self) -> int:
        """Look into the folder; the points that are there."""
        statuses = self._store.statuses()
        known = self._plan.known
        new = [status for key, status in islice(statuses.items(), self._counted, None) if key in known]
        self._counted = len(statuses)
        self.there += len(new)
        self.failed += sum(status != DONE for status in new)
        return self.there

    def __call__(self) -> int:
        before = self.there
        there = self.look()
        if self._bar is not None and there != before:
            self._bar.update(there - before)
            if self.failed:
                self._bar.set_postfix_str(f"{self.failed} failed")
        return there

    def __enter__(self) -> Progress:  # noqa: PYI034 (typing.Self needs Python 3.11)
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
