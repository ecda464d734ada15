"""Columns of numbers as text for a page: bytes sorted by rank, deflated, in base64.

Bytes of one rank are alike in neighbouring samples, and deflate to a fraction of their size.
"""

import base64
import zlib

import numpy as np

#: kinds of columns: 32-bit and 64-bit floats, integers below 256
KINDS = {"f4": "<f4", "f8": "<f8", "u1": "u1"}
LEVEL = 6

#: place of a column: its kind, its first byte and its length
Place = tuple[str, int, int]


class Pack:
    """A block of columns in the making; `add` returns the place of each."""

    def __init__(self):
        self.parts: list[bytes] = []
        self.size = 0

    def add(self, values: np.ndarray, kind: str = "f4") -> Place:
        """Append a column; kind: of `KINDS`. Raises ValueError for a kind that there is not."""
        if kind not in KINDS:
            raise ValueError(f"kind must be one of {', '.join(KINDS)}, got {kind!r}")
        with np.errstate(
            over="ignore", under="ignore"
        ):  # a float beyond 32 bits is shown as infinite
            column = np.ascontiguousarray(np.ravel(values).astype(KINDS[kind]))
        span = kind, self.size, column.size
        ranks = column.view(np.uint8).reshape(-1, column.itemsize).T
        self.parts.append(ranks.tobytes())
        self.size += column.nbytes
        return span

    def text(self) -> str:
        """The block as it stands in a page."""
        return base64.b64encode(zlib.compress(b"".join(self.parts), LEVEL)).decode()


def unpacked(text: str, span: Place) -> np.ndarray:
    """A column of a block, as the page reads it."""
    kind, start, count = span
    size = np.dtype(KINDS[kind]).itemsize
    block = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8)
    ranks = block[start : start + count * size].reshape(size, count)
    return np.ascontiguousarray(ranks.T).view(KINDS[kind]).ravel()
