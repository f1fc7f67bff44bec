"""Arrays as text that a page can hold, and short enough."""

import base64
import zlib

import numpy as np


def rounded(values):
    """Numbers as float32 with 16 significant bits: off by 8e-6 at most, and half as long packed."""
    values = np.asarray(values, dtype=np.float64)
    with np.errstate(over="ignore"):
        bits = np.ascontiguousarray(values, dtype=np.float32).view(np.uint32)
    finite = np.isfinite(values)
    bits = np.where(finite, (bits + np.uint32(0x80)) & np.uint32(0xFFFFFF00), bits)
    return bits.astype(np.uint32).view(np.float32)


class Pack:
    """Arrays by name, behind one another. In each the first bytes of all numbers come first, then
    their second bytes, and so on: neighbours are alike, and deflate finds it."""

    def __init__(self):
        self.index = {}  # name -> [kind, first number's place in bytes, how many numbers]
        self._parts, self._length = [], 0

    def add_reals(self, name, values):
        self._add(name, "f", rounded(values))

    def add_numbers(self, name, values):
        self._add(name, "u", np.ascontiguousarray(values, dtype="<u4"))

    def _add(self, name, kind, array):
        flat = array.astype(array.dtype.newbyteorder("<")).reshape(-1)
        part = np.ascontiguousarray(flat.view(np.uint8).reshape(-1, 4).T).tobytes()
        self.index[name] = [kind, self._length, int(flat.size)]
        self._parts.append(part)
        self._length += len(part)

    def text(self):
        """All of it, deflated, in base64."""
        return base64.b64encode(zlib.compress(b"".join(self._parts), 7)).decode("ascii")
