"""Everything in a recording, a line each: attributes; data sets with type, shape, how they are
stored, and a hash of their contents.

usage: describe.py FILE
"""

import hashlib
import sys

import h5py
import numpy


def attribute(value):
    if isinstance(value, bytes):
        return value.decode()
    if isinstance(value, str):
        return value
    value = numpy.asarray(value)
    return f"{value.dtype} {value.tolist()}"


def contents(data):
    """Hashed: the bytes of numbers, the characters of texts."""
    if h5py.check_string_dtype(data.dtype):
        texts = data.asstr()[()]
        texts = [texts] if isinstance(texts, str) else list(texts)
        return "text", "\0".join(texts).encode()
    return data.dtype.str, numpy.ascontiguousarray(data[()]).tobytes()


def describe(name, item):
    attributes = "".join(f" {key}={attribute(item.attrs[key])}" for key in sorted(item.attrs))
    if isinstance(item, h5py.Group):
        print(f"{name}/{attributes}")
        return
    kind, raw = contents(item)
    stored = f"{item.compression or 'plain'}{'+shuffle' if item.shuffle else ''}"
    hash_of = hashlib.sha256(raw).hexdigest()[:16]
    print(f"{name} {kind} {list(item.shape)} {stored} {hash_of}{attributes}")


with h5py.File(sys.argv[1], "r") as file:
    describe("", file)
    file.visititems(describe)
