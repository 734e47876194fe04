"""Pickles of numbers, texts, lists, dictionaries and NumPy arrays. A pickle is a
program: only the functions below are available to it, so that no code outside this
file runs. Arrays are views of bytes that the pickle contains."""

from __future__ import annotations

import io
import pickle

from common import Refusal

NUMBERS = "biuf"  # kinds of dtypes


class Dtype:
    """numpy.dtype("f8"); its pickled state has the byte order."""

    def __init__(self, name, *_):
        import numpy as np

        self.dtype = np.dtype(str(name))

    def __setstate__(self, state):
        order = state[1]
        if order in ("<", ">"):
            self.dtype = self.dtype.newbyteorder(order)


class Array:
    """An array, empty until its state is set."""

    def __init__(self, *_):
        self.value = None

    def __setstate__(self, state):
        _, shape, dtype, by_columns, content = state
        self.value = array_of(content, dtype, shape, "F" if by_columns else "C")


def array_of(content, dtype, shape, order):
    import numpy as np

    if not isinstance(dtype, Dtype) or dtype.dtype.kind not in NUMBERS:
        raise pickle.UnpicklingError("contains an array of values that are not numbers")
    content = content.encode("latin1") if isinstance(content, str) else content
    return np.frombuffer(content, dtype.dtype).reshape(shape, order=order)


def from_buffer(content, dtype, shape, order):
    array = Array()
    array.value = array_of(content, dtype, shape, order)
    return array


def scalar(dtype, content):
    return array_of(content, dtype, (1,), "C")[0].item()


def latin1(text, encoding="latin1"):
    """Bytes that Python 3 stores as a text for Python 2."""
    if encoding != "latin1":
        raise pickle.UnpicklingError("contains an encoded text, expected latin1")
    return text.encode("latin1")


ALLOWED = {
    ("numpy", "dtype"): Dtype,
    ("numpy", "ndarray"): Array,
    ("_codecs", "encode"): latin1,
}
for core in ("numpy.core", "numpy._core"):  # before and since NumPy 2
    ALLOWED[f"{core}.multiarray", "_reconstruct"] = Array
    ALLOWED[f"{core}.multiarray", "scalar"] = scalar
    ALLOWED[f"{core}.numeric", "_frombuffer"] = from_buffer


class Unpickler(pickle.Unpickler):
    def find_class(self, module, name):
        try:
            return ALLOWED[module, name]
        except KeyError:
            raise pickle.UnpicklingError(
                f"calls '{module}.{name}', which a pickle of numbers and NumPy arrays "
                "does not need; the call is not executed"
            ) from None

    def persistent_load(self, pid):
        raise pickle.UnpicklingError("refers to something outside of the file")


def load(content, path, place="pickle"):
    """The value of a pickle. Arrays are Array objects: see their `value`."""
    try:
        return Unpickler(io.BytesIO(content), encoding="latin1").load()
    except MemoryError as error:
        raise Refusal(path, place, "requires more memory than its size justifies") from error
    except Exception as error:  # a damaged pickle may raise anything
        raise Refusal(path, place, str(error) or "ends too early") from error
