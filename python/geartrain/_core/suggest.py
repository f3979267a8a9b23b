"""Errors of public calls in their arguments: a misspelt keyword, with the nearest name, and a value of a wrong kind."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import is_dataclass
from types import FunctionType
from typing import Any, cast

from .blame import blame, is_documented
from .variable import refuse_unknown

__all__ = ["suggest_names"]


def suggest_names(module: dict[str, Any]) -> None:
    """Make the public calls of a module, and the public methods of its classes, tell what is wrong with their arguments.

    A misspelt keyword is not told by calls that pass keywords on: they, or what takes the keywords, tell.
    """
    for name in module["__all__"]:
        public = module[name]
        if isinstance(public, FunctionType):
            module[name] = _told(public)
        elif isinstance(public, type) and not issubclass(public, BaseException):
            for owner in public.__mro__:
                if owner.__module__.startswith("geartrain."):
                    _tell_methods(owner)


def _tell_methods(owner: type) -> None:
    for name, method in list(vars(owner).items()):
        if isinstance(method, FunctionType) and (not name.startswith("_") or (name == "__init__" and not is_dataclass(owner))):
            setattr(owner, name, _told(method))
        elif isinstance(method, classmethod) and not name.startswith("_"):
            setattr(owner, name, classmethod(_told(cast(FunctionType, method.__func__))))


def _told(call: FunctionType) -> Callable[..., Any]:
    parameters = inspect.signature(call).parameters.values()
    names = [item.name for item in parameters if item.kind in (item.POSITIONAL_OR_KEYWORD, item.KEYWORD_ONLY)]
    passes_on = hasattr(call, "__wrapped__") or any(item.kind is item.VAR_KEYWORD for item in parameters)

    @functools.wraps(call)
    def told(*given: Any, **named: Any) -> Any:
        if not passes_on:
            refuse_unknown(call.__qualname__.removesuffix(".__init__"), named, names)
        try:
            return call(*given, **named)
        except Exception as error:
            wrong = None if is_documented(error) else blame(call, given, named, error)
            if wrong is None:
                raise
        raise wrong

    return told
