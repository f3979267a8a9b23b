"""Arrays as the bytes of a file that ends with a checksum of all before it: what is not as it was written is refused."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["DamagedError", "seal", "unseal"]

_SIZE = 16  # bytes of the checksum


class DamagedError(ValueError):
    """The bytes are not those of `seal`, or do not hold what they should."""


def seal(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays by their names as bytes: an npz file and its checksum."""
    file = io.BytesIO()
    np.savez(file, **dict(arrays))  # type: ignore[arg-type]  # a keyword of its own is told beside the arrays
    text = file.getvalue()
    return text + _checksum(text)


def unseal(text: bytes) -> dict[str, NDArray[Any]]:
    """The arrays of `seal`. No array can be larger than the bytes: nothing is unpacked."""
    whole, checksum = text[:-_SIZE], text[-_SIZE:]
    if not whole:
        raise DamagedError("no data left in file")
    if _checksum(whole) != checksum:
        raise DamagedError("its checksum is another")
    try:
        with zipfile.ZipFile(io.BytesIO(whole)) as file:
            if any(member.compress_type != zipfile.ZIP_STORED for member in file.infolist()):
                raise DamagedError("it is packed")
        with np.load(io.BytesIO(whole), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}
    except Exception as error:  # noqa: BLE001 (of a file from elsewhere, anything)
        raise DamagedError(f"{type(error).__name__}: {error}") from None


def _checksum(text: bytes) -> bytes:
    return blake2b(text, digest_size=_SIZE, person=b"geartrain study").digest()
