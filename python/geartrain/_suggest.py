"""A misspelt keyword of a public call is told with the name that was probably meant."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from types import FunctionType
from typing import Any

from ._variable import refuse_unknown

__all__ = ["suggest_names"]


def suggest_names(module: dict[str, Any]) -> None:
    """Make the public calls of a module, and the public methods of its classes, tell a misspelt keyword.

    Not those that pass keywords on: they, or what takes the keywords, tell.
    """
    for name in module["__all__"]:
        public = module[name]
        if isinstance(public, FunctionType):
            module[name] = _told(public)
        elif isinstance(public, type):
            for owner in public.__mro__:
                if owner.__module__.startswith("geartrain."):
                    _tell_methods(owner)


def _tell_methods(owner: type) -> None:
    for name, method in list(vars(owner).items()):
        if isinstance(method, FunctionType) and not name.startswith("_"):
            setattr(owner, name, _told(method))


def _told(call: FunctionType) -> Callable[..., Any]:
    parameters = inspect.signature(call).parameters.values()
    names = [item.name for item in parameters if item.kind in (item.POSITIONAL_OR_KEYWORD, item.KEYWORD_ONLY)]
    if hasattr(call, "__wrapped__") or any(item.kind is item.VAR_KEYWORD for item in parameters):
        return call

    @functools.wraps(call)
    def told(*given: Any, **named: Any) -> Any:
        refuse_unknown(call.__qualname__, named, names)
        return call(*given, **named)

    return told
