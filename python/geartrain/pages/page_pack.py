"""Numbers packed for a page: one compressed block of JSON and arrays, which the page unpacks."""

from __future__ import annotations

import base64
import json
import math
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Block", "plain"]

#: Bits of the fraction of a single-precision number that are cut where it is only drawn: an error of 1e-5, relative.
_CUT = 7
#: Bytes that are compressed at once, which takes a tenth of a second at most.
_PIECE = 1 << 16


class Block:
    """Arrays one after the other; what stands for each in the JSON is where it is.

    The bytes of an array are sorted by their place in its numbers, the first of each, then the second: alike ones side by side
    compress better.
    """

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0

    def add(self, values: ArrayLike | None, kind: str = "f4", *, drawn: bool = False) -> dict[str, Any] | None:
        """Where the values will be; None where there are none.

        Parameters
        ----------
        values : array_like or None
        kind : {'f4', 'f8', 'i4', 'u1'}
            In which they are kept.
        drawn : bool
            Whether they are only drawn, so that five digits will do.
        """
        if values is None:
            return None
        array = np.ascontiguousarray(values, f"<{kind}")
        if drawn:
            array = _rounded(array)
        size = array.dtype.itemsize
        part = np.frombuffer(array.tobytes(), np.uint8).reshape(-1, size).T.tobytes()
        found = {"at": self._length, "kind": kind, "shape": list(array.shape)}
        self._parts.append(part)
        self._length += len(part)
        return found

    def packed(self, told: Any) -> str:
        """The JSON and the arrays, compressed, as text: length of the JSON in four bytes, the JSON, the arrays."""
        head = json.dumps(plain(told), separators=(",", ":"), allow_nan=False).encode()
        whole = b"".join([len(head).to_bytes(4, "little"), head, *self._parts])
        return base64.b64encode(_compressed(whole)).decode()


def _compressed(whole: bytes) -> bytes:
    """The bytes as a gzip file, compressed piece by piece: Python obeys Ctrl-C between two pieces."""
    work = zlib.compressobj(9, zlib.DEFLATED, zlib.MAX_WBITS | 16)
    pieces = [work.compress(whole[first:first + _PIECE]) for first in range(0, len(whole), _PIECE)]
    return b"".join([*pieces, work.flush()])


def _rounded(array: NDArray[Any]) -> NDArray[Any]:
    """Single-precision numbers rounded to fewer bits."""
    bits = array.view("<u4")
    half, mask = np.uint32(1 << (_CUT - 1)), np.uint32(0xFFFFFFFF << _CUT & 0xFFFFFFFF)
    rounded: NDArray[Any] = np.where(np.isfinite(array), (bits + half) & mask, bits).astype("<u4").view("<f4")
    return rounded


def plain(told: Any) -> Any:
    """What JSON can tell: numbers that are not finite are null, arrays lists."""
    if isinstance(told, dict):
        return {str(name): plain(value) for name, value in told.items()}
    if isinstance(told, (list, tuple)):
        return [plain(value) for value in told]
    if isinstance(told, np.ndarray):
        return plain(told.tolist())
    if isinstance(told, (bool, np.bool_)):
        return bool(told)
    if isinstance(told, (int, np.integer)):
        return int(told)
    if isinstance(told, (float, np.floating)):
        return float(told) if math.isfinite(told) else None
    return told if told is None else str(told)
