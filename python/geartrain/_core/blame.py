"""Which argument of a call caused an error: one that is not of the kind that the signature of the call names."""

from __future__ import annotations

import builtins
import inspect
import os
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from numbers import Integral, Real
from typing import Any, Literal

import numpy as np

from ..errors import InputError, SolverError, shown

__all__ = ["blame", "is_documented"]

_MOST_ITEMS = 10_000  # of a list that are looked at


def is_documented(error: BaseException) -> bool:
    """Whether an error is one that calls document, or a warning that a filter makes an error."""
    return isinstance(error, (InputError, SolverError, OSError, MemoryError, ModuleNotFoundError, Warning))


def blame(call: Callable[..., Any], given: tuple[Any, ...], named: Mapping[str, Any], error: Exception) -> InputError | None:
    """The error that names the argument of the wrong kind; None where all are of their kinds: the fault is the program's.

    Parameters
    ----------
    call : callable
        With annotations.
    given, named : tuple, mapping
        Its arguments.
    error : Exception
        What it raised.
    """
    signature = inspect.signature(call)
    try:
        bound = signature.bind(*given, **named)
    except TypeError:
        return None
    for name, value in bound.arguments.items():
        parameter = signature.parameters[name]
        if parameter.kind is parameter.VAR_KEYWORD:
            if value and "unexpected keyword argument" not in str(error):
                # They go on to matplotlib, whose errors name what is wrong.
                return InputError(f"{', '.join(f'{key} = {shown(item)}' for key, item in value.items())}: {error}")
            continue
        hint = _evaluated(parameter.annotation, call)
        values = value if parameter.kind is parameter.VAR_POSITIONAL else (value,)
        wrong = [item for item in values if not _fits(item, hint)]
        if wrong:
            return InputError(f"{name} = {shown(wrong[0])}: must be {_words(hint)}")
    return None


class _Named(type):
    """A class that is known by its name alone, since it is imported for type checkers only."""


class _Names(dict[str, Any]):
    """The names in an annotation."""

    def __init__(self, known: Mapping[str, Any]) -> None:
        super().__init__()
        self._known = known

    def __missing__(self, name: str) -> Any:
        if name in self._known:
            return self._known[name]
        for module in (builtins, typing):
            if hasattr(module, name):
                return getattr(module, name)
        return _Named(name, (), {"__class_getitem__": classmethod(lambda cls, _: cls)})


def _evaluated(annotation: Any, call: Callable[..., Any]) -> Any:
    if annotation is inspect.Parameter.empty:
        return Any
    if not isinstance(annotation, str):
        return annotation
    home = inspect.unwrap(call)
    try:
        return eval(annotation, {"__builtins__": {}}, _Names(home.__globals__))  # an annotation of this package
    except (TypeError, SyntaxError, AttributeError):
        return Any


def _is_union(hint: Any) -> bool:
    return typing.get_origin(hint) in (typing.Union, types.UnionType)


def _fits(value: Any, hint: Any) -> bool:
    """Whether a value is of the kind that a hint names; of a hint that is not understood every value is."""
    origin, parts = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any or isinstance(hint, typing.TypeVar):
        return True
    if _is_numbers(hint):
        return _is_array(value) or (value is None and type(None) in parts)
    if _is_union(hint):
        return any(_fits(value, part) for part in parts)
    if origin is Literal:
        return isinstance(value, (str, int)) and value in parts
    if hint is None or hint is type(None):
        return value is None
    if hint in _KINDS:
        return _KINDS[hint][0](value)
    if isinstance(hint, _Named):
        return any(base.__name__ == hint.__name__ for base in type(value).__mro__)
    kind = origin or hint
    if kind is os.PathLike:
        return isinstance(value, os.PathLike) and _is_name(os.fspath(value))
    return not isinstance(kind, type) or _is_of(value, kind, parts)


def _is_of(value: Any, kind: Any, parts: tuple[Any, ...]) -> bool:
    """Whether a value is of a class, and its items of the kinds of `parts`."""
    if isinstance(value, (str, bytes)) and kind is not object:
        return False  # a sequence of characters is none of names or numbers
    if isinstance(value, np.ndarray) and issubclass(Sequence, kind) and kind is not object:
        value = value.tolist()  # which is no list where the array has no dimensions
    if not isinstance(value, kind):
        return False
    if issubclass(kind, Mapping) and len(parts) == 2:
        return all(_fits(key, parts[0]) and _fits(item, parts[1]) for key, item in value.items())
    if kind is tuple and parts and Ellipsis not in parts:
        return len(value) == len(parts) and all(map(_fits, value, parts))
    if issubclass(Sequence, kind) and parts and isinstance(value, Sequence):
        return all(_fits(item, parts[0]) for item in list(value)[:_MOST_ITEMS])
    return True


def _is_numbers(hint: Any) -> bool:
    """Whether a hint is that of numpy for anything that makes an array, with or without None."""
    return _is_union(hint) and any("_SupportsArray" in str(typing.get_origin(part)) for part in typing.get_args(hint))


def _is_array(value: Any) -> bool:
    try:
        return np.asarray(value).dtype.kind in "biufc"
    except (TypeError, ValueError, OverflowError):
        return False


def _is_name(value: Any) -> bool:
    """Whether a value is a string that can be the name of a file."""
    try:
        return isinstance(value, str) and b"\0" not in os.fsencode(value)
    except UnicodeEncodeError:
        return False


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, Real) and not isinstance(value, (bool, np.bool_)) and bool(np.isfinite(float(value)))
    except (OverflowError, TypeError, ValueError):
        return False


def _is_whole(value: Any) -> bool:
    return isinstance(value, Integral) and not isinstance(value, (bool, np.bool_)) and abs(int(value)) < 2**31


_KINDS: dict[Any, tuple[Callable[[Any], bool], str]] = {
    bool: (lambda value: isinstance(value, (bool, np.bool_)), "True or False"),
    int: (_is_whole, "a whole number below 2147483648"),
    float: (_is_number, "a number"),
    str: (_is_name, "a string"),
}


def _words(hint: Any) -> str:
    """What a hint asks for, in words."""
    origin, parts = typing.get_origin(hint), typing.get_args(hint)
    if _is_numbers(hint):
        return "numbers"
    if _is_union(hint):
        return " or ".join(dict.fromkeys(_words(part) for part in parts))
    if origin is Literal:
        return " or ".join(map(repr, parts))
    if hint is None or hint is type(None):
        return "None"
    if hint in _KINDS:
        return _KINDS[hint][1]
    kind = origin or hint
    if kind is os.PathLike:
        return "a path"
    if not isinstance(kind, type):
        return "something else"
    if issubclass(kind, Mapping):
        return "a mapping" + (f" from {_words(parts[0])} to {_words(parts[1])}" if len(parts) == 2 and Any not in parts else "")
    if kind is tuple and parts and Ellipsis not in parts:
        return f"a tuple of {', '.join(map(_words, parts))}"
    if issubclass(Sequence, kind):
        return f"a list, of each item {_words(parts[0])}" if parts and parts[0] is not Any else "a list"
    if kind.__module__.partition(".")[0] == "collections" and kind.__name__ == "Callable":
        return "a function"
    return f"a {kind.__name__}"
