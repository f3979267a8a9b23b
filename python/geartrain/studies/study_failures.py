"""The points of a study that failed, and why, in words."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import NamedTuple

from .study_plan import Plan
from .study_store import DONE, Store

__all__ = ["Failure", "failures_of", "words_of"]

_KINDS = 5  # of failures that are told one by one
_LONGEST = 300  # characters of a message


class Failure(NamedTuple):
    """A point that failed, or was set aside.

    Attributes
    ----------
    point : int
        Its number, from 0; of several with the same key the first.
    message : str
        Why.
    """

    point: int
    message: str


def failures_of(plan: Plan, store: Store, blocks: Collection[int] | None = None) -> list[Failure]:
    """Those of the plan that are in the folder, by their numbers; of some batches, or of all unless told."""
    points = plan.distinct.tolist() if blocks is None else [point for block in blocks for point in plan.block(block)]
    statuses = store.statuses()
    failed = {key: point for point in points if statuses.get(key := plan.key(point), DONE) != DONE}
    messages = store.messages(failed) if failed else {}
    return sorted(Failure(point, messages.get(key, "")) for key, point in failed.items())


def words_of(plan: Plan, failures: Collection[Failure]) -> str:
    """A line for each kind of failure, with how many there are and its first point; kinds differ in more than numbers."""
    kinds: dict[str, list[Failure]] = {}
    for failure in failures:
        kinds.setdefault(re.sub(r"[-+]?\d[\d.]*(?:e[-+]?\d+)?", "0", failure.message, flags=re.IGNORECASE), []).append(failure)
    lines = []
    for own in list(kinds.values())[:_KINDS]:
        first = own[0]
        message = first.message if len(first.message) <= _LONGEST else first.message[: _LONGEST - 3] + "..."
        many = f"{len(own)} points, the first " if len(own) > 1 else ""
        lines.append(f"failed: {many}{plan.told(first.point)}: " + message.replace("\n", "; "))
    if len(kinds) > _KINDS:
        rest = sum(len(own) for own in list(kinds.values())[_KINDS:])
        lines.append(f"failed: {rest} more for other reasons: the Dataset has the message of each")
    return "\n".join(lines)
