"""Arrays as the bytes of a file that ends with a checksum of all before it. Bytes that were changed are refused."""

from __future__ import annotations

import contextlib
import io
import zipfile
from collections.abc import Iterator, Mapping
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["DamagedError", "distrust", "seal", "unseal"]

_SIZE = 16  # bytes of the checksum


class DamagedError(ValueError):
    """The bytes were changed after `seal` wrote them, or hold something else than what is read."""


@contextlib.contextmanager
def distrust() -> Iterator[None]:
    """Within it any error is a `DamagedError`: a file from elsewhere may cause anything."""
    try:
        yield
    except DamagedError:
        raise
    except Exception as error:  # noqa: BLE001
        raise DamagedError(f"{type(error).__name__}: {error}") from None


def seal(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays by their names as bytes: an npz file and its checksum."""
    file = io.BytesIO()
    np.savez(file, **dict(arrays))  # type: ignore[arg-type]  # numpy has an option beside the names of arrays
    text = file.getvalue()
    return text + _checksum(text)


def unseal(text: bytes) -> dict[str, NDArray[Any]]:
    """The arrays of `seal`. No array can be larger than the bytes: nothing is unpacked."""
    whole, checksum = text[:-_SIZE], text[-_SIZE:]
    if not whole:
        raise DamagedError("no data left in file")
    if _checksum(whole) != checksum:
        raise DamagedError("checksum mismatch")
    with distrust():
        with zipfile.ZipFile(io.BytesIO(whole)) as file:
            if any(member.compress_type != zipfile.ZIP_STORED for member in file.infolist()):
                raise DamagedError("an array is compressed")
        with np.load(io.BytesIO(whole), allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}


def _checksum(text: bytes) -> bytes:
    return blake2b(text, digest_size=_SIZE, person=b"geartrain study").digest()
