"""A variable of a case: as a field of a part of the train, and as a keyword of a call that takes a group of variables."""

from __future__ import annotations

import contextlib
import functools
import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, fields
from difflib import get_close_matches
from itertools import islice
from textwrap import fill
from typing import Any, NamedTuple, TypeVar, cast

from numpy.typing import NDArray

__all__ = ["Part", "Series", "Variable", "refuse_unknown", "takes"]

Series = float | Sequence[float] | NDArray[Any]
Call = TypeVar("Call", bound=Callable[..., Any])

_MOST = 1000  # values of a list: what a case file may hold; one more is told as too many, an endless one as well


class Variable(NamedTuple):
    """A row of the table of variables."""

    #: In the case file; as a keyword it may have another name.
    name: str
    #: ``real``, ``integer``, ``logical``, ``text``; in the plural a list.
    kind: str
    type: str
    #: None where there is none.
    default: Any
    required: bool
    meaning: str


class _Signature:
    """That of ``__init__``: Python 3.10 would show that of `Part.__new__`, which tells nothing."""

    def __get__(self, _: Any, part: Any) -> inspect.Signature:
        return inspect.Signature(list(inspect.signature(part.__init__).parameters.values())[1:])


@dataclass(frozen=True, kw_only=True)
class Part:
    """What is given by the variables of a group, all of them optional here: Fortran tells what is lacking."""

    variables = dict[str, Variable]()  # noqa: RUF012 (with an annotation it would be a field)
    __signature__ = _Signature()

    def __init_subclass__(cls, variables: dict[str, Variable] | None = None) -> None:
        if variables is not None:
            cls.variables = variables
            cls.__doc__ = f"{cls.__doc__}\n\nParameters\n----------\n**variables"
        cls.__doc__ = _documented(cls.__doc__, cls.variables)

    def __new__(cls, *_: Any, **given: Any) -> Any:
        """Refuse unknown keywords in words of their own; else as any dataclass."""
        refuse_unknown(cls.__name__, given, [item.name for item in fields(cls)])
        return super().__new__(cls)

    def __repr__(self) -> str:
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        given = (f"{name}={value!r}" for name, value in values.items() if value is not None)
        return f"{type(self).__name__}({', '.join(given)})"

    def __post_init__(self) -> None:
        """Make tuples of the lists, however they were given, of no more values than show that there are too many."""
        for name, variable in self.variables.items():
            value = getattr(self, name)
            if not variable.kind.endswith("s") or value is None:
                continue
            if isinstance(value, (str, bytes, bytearray, Mapping, AbstractSet)):
                continue
            # An array without dimensions says that it can be iterated over, and cannot; the check tells.
            with contextlib.suppress(TypeError):
                object.__setattr__(self, name, tuple(islice(value, _MOST + 1)) if isinstance(value, Iterable) else (value,))


def refuse_unknown(call: str, given: Iterable[str], known: Sequence[str]) -> None:
    """Tell a keyword that a call does not have, with the nearest that it has."""
    for name in given:
        if name not in known:
            near = get_close_matches(name, known, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise TypeError(f"{call}() got an unexpected keyword argument {name!r}{hint}")


def takes(group: Mapping[str, Variable], keywords: type, **defaults: Any) -> Callable[[Call], Call]:
    """Give a call that ends in ``**settings`` the signature, the defaults and the documentation of a group of variables.

    Parameters
    ----------
    group : mapping of str to Variable
    keywords : type
        Typed dictionary of the variables that the call takes.
    **defaults
        Those that the call has in place of the group's.
    """
    variables = {name: group[name]._replace(default=defaults.get(name, group[name].default)) for name in keywords.__annotations__}
    words = {variable.name: name for name, variable in variables.items()}

    def decorate(call: Call) -> Call:
        own = [item for item in inspect.signature(call).parameters.values() if item.kind is not item.VAR_KEYWORD]
        first = sum(item.kind is not item.KEYWORD_ONLY for item in own)
        added = [
            inspect.Parameter(
                name,
                inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if variable.required else variable.default,
                annotation=variable.type,
            )
            for name, variable in variables.items()
        ]
        signature = inspect.signature(call).replace(parameters=[*own[:first], *added, *own[first:]])

        @functools.wraps(call)
        def checked(*given: Any, **settings: Any) -> Any:
            named = {words.get(name, name): value for name, value in settings.items()}
            if len(named) < len(settings):
                raise TypeError(f"{call.__name__}() got a variable by its name and by its keyword: {', '.join(settings)}")
            refuse_unknown(call.__name__, named, list(signature.parameters))
            try:
                bound = signature.bind(*given, **named)
            except TypeError as error:
                raise TypeError(f"{call.__name__}() {error}") from None
            bound.apply_defaults()
            return call(*bound.args, **bound.kwargs)

        checked.__signature__ = signature  # type: ignore[attr-defined]
        checked.__doc__ = _documented(call.__doc__, variables)
        return cast(Call, checked)

    return decorate


def _documented(text: str | None, variables: Mapping[str, Variable]) -> str:
    """The docstring with the variables in place of its parameter ``**settings`` or ``**variables``, and of what it says there."""

    def entries(found: re.Match[str]) -> str:
        indent = found[1]
        lines = []
        for name, variable in variables.items():
            default = "" if variable.required else ", optional" if variable.default is None else f", default {variable.default!r}"
            kind = variable.type.replace("Series", "float or sequence of float")
            lines.append(f"{indent}{name} : {kind}{default}")
            lines.append(fill(variable.meaning, 120, initial_indent=indent + "    ", subsequent_indent=indent + "    "))
        return "\n".join(lines)

    return re.sub(r"^( *)\*\*(?:settings|variables)$(?:\n\1 +.*)*", entries, text or "", flags=re.MULTILINE)
