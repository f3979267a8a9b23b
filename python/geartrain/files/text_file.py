"""Text of files that other programs write, in whatever encoding."""

from __future__ import annotations

import codecs
import os

from ..errors import InputError

__all__ = ["decoded", "read_bytes"]

_MARKS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}


def read_bytes(path: str | os.PathLike[str], largest: int) -> bytes:
    """The bytes of a file, at most ``largest``."""
    with open(path, "rb") as stream:
        data = stream.read(largest + 1)
    if len(data) > largest:
        raise InputError(f"{os.fspath(path)}: error: has more than {largest >> 20} MB")
    return data


def decoded(name: str, data: bytes) -> str:
    """Bytes as text: UTF-8, UTF-16 by its mark, else Windows-1252; what is none is refused with its line."""
    marked = next((encoding for mark, encoding in _MARKS.items() if data.startswith(mark)), None)
    for encoding in [marked] if marked else ["utf-8", "cp1252"]:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError as error:
            line = data[:error.start].count(b"\n") + 1
            continue
        if "\0" not in text:
            return text
        line = text[:text.index("\0")].count("\n") + 1
        break
    raise InputError(f"{name}:{line}: error: no text in UTF-8, UTF-16 or Windows-1252")
