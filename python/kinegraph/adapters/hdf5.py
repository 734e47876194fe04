"""Data sets of an HDF5 file, whose sizes are checked against the stored bytes."""

from __future__ import annotations

import contextlib
import mmap

from common import Refusal, begins_with, most_bytes


def is_hdf5(path):
    return begins_with(path, b"\x89HDF\r\n\x1a\n")


def mentions(path, names):
    """Whether an HDF5 file contains these names; does not require h5py."""
    if not is_hdf5(path):
        return False
    with open(path, "rb") as file:
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
            return all(content.find(name) >= 0 for name in names)


@contextlib.contextmanager
def opened(path):
    import h5py

    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise Refusal(path, "", "is not an HDF5 file, or is damaged") from error
    with file:
        try:
            yield Sets(path, file)
        except (OSError, RuntimeError, ValueError, TypeError, KeyError) as error:
            raise Refusal(path, "", f"is damaged: {str(error)[:200]}") from error


class Sets:
    """The data sets of an open file. Each is read as a whole."""

    def __init__(self, path, file):
        self.path = path
        self._file = file

    def has(self, name):
        return name in self._file

    def fail(self, name, message):
        raise Refusal(self.path, name, message)

    def set(self, name):
        """A data set stored in the file itself, of a size that its stored bytes allow
        (most_bytes)."""
        import h5py

        if name not in self._file:
            self.fail(name, "is missing")
        link = self._file.get(name, getlink=True)
        found = self._file[name] if not isinstance(link, h5py.ExternalLink) else None
        if not isinstance(found, h5py.Dataset) or found.external or found.is_virtual:
            self.fail(name, "is not a data set in this file")
        stored = min(found.id.get_storage_size(), self._file.id.get_filesize())
        held = found.size * found.dtype.itemsize
        if held > most_bytes(stored) or (found.size > 0 and stored == 0):
            self.fail(
                name,
                f"has {found.size} entries, but only {stored} bytes of data are "
                "stored, too few for a recording",
            )
        return found

    def numbers(self, name):
        found = self.set(name)
        if found.dtype.kind not in "fiu":
            self.fail(name, "expected numbers")
        return found[()].astype(float)

    def texts(self, name):
        found = self.set(name)
        if found.dtype.kind not in "SO" or found.ndim != 1 or found.size > 100_000:
            self.fail(name, "expected a list of at most 100,000 texts")
        return [as_text(text) for text in found[()].tolist()]

    def attribute(self, name, attribute):
        """A text attribute of a data set; empty if there is none."""
        value = self.set(name).attrs.get(attribute, "")
        if getattr(value, "size", 1) != 1:
            self.fail(f"{name}.{attribute}", "expected one text")
        return value.item() if hasattr(value, "item") else value


def as_text(text):
    return text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
