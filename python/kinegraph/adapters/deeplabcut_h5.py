"""DeepLabCut's predictions as HDF5, one view: pandas' table "df_with_missing", whose
index is the frame and whose columns are named by scorer, individual (if several),
bodypart and coord. PyTables stores the names as a pickle; they are read here by h5py
and an unpickler that runs no code (pickles.py)."""

from __future__ import annotations

import pickles
from common import MAX_FRAME, files_in, folders_in, header, line
from hdf5 import mentions, opened

KIND = "detections"
PACKAGES = ["h5py"]
TABLE = "df_with_missing/table"


def recognise(path):
    if not path.is_dir():
        return mentions(path, [b"df_with_missing"])
    return any(
        mentions(file, [b"df_with_missing"])
        for folder in [path, *folders_in(path)]  # subfolders: one per detector
        for file in files_in(folder, ".h5")
    )


def column_names(sets):
    kind = sets.set(TABLE).attrs.get("values_block_0_kind", b"")
    kind = kind.encode("latin1") if isinstance(kind, str) else bytes(kind)
    names = pickles.load(kind, sets.path, TABLE)
    is_table = isinstance(names, list) and all(
        isinstance(column, tuple) and all(isinstance(n, str) for n in column)
        for column in names
    )
    if not is_table:
        sets.fail(
            TABLE, "expected column names as DeepLabCut writes them with pandas"
        )
    lengths = {len(column) for column in names}
    if lengths - {3, 4}:
        sets.fail(
            TABLE,
            f"found a column with {max(lengths - {3, 4})} names, expected scorer, "
            "individual (optional), bodypart and coord",
        )
    if len(lengths) == 2:
        sets.fail(TABLE, "some columns name an individual and some do not")
    return names


# Indices of the two columns that read() appends for what a table lacks: NaN as a
# position, 1 as a likelihood.
DEFAULTS = {"x": -2, "y": -2, "likelihood": -1}


def places_of(sets, names):
    """Labels, and for each individual and label the columns of x, y and likelihood."""
    labels, people = {}, {}
    for place, column in enumerate(names):
        person = people.setdefault(column[1] if len(column) == 4 else "", {})
        labels.setdefault(column[-2], None)
        person.setdefault(column[-2], {})[column[-1]] = place
    if not people:
        sets.fail(TABLE, "expected columns x and y")
    places = []
    for name, person in people.items():
        for label in labels:
            # Individuals lack the unique bodyparts, which belong to "single".
            may_lack = name and label not in person
            if not may_lack and not {"x", "y"} <= person.get(label, {}).keys():
                sets.fail(TABLE, f"bodypart '{label}': expected the coords x and y")
        places.append(
            [
                [person.get(label, {}).get(c, lacks) for c, lacks in DEFAULTS.items()]
                for label in labels
            ]
        )
    return list(labels), places


def read(path, options):
    import numpy as np

    with opened(path) as sets:
        if not sets.has(TABLE):
            sets.fail(
                "", "has no df_with_missing/table, expected predictions as written by "
                "DeepLabCut (pandas' format='table')"
            )  # fmt: skip
        table = sets.set(TABLE)
        if table.attrs.get("index_kind", b"") not in (b"integer", "integer"):
            sets.fail(
                TABLE, "has no frame numbers, expected DeepLabCut's predictions for a "
                "video (labels of images are read as CSV)"
            )  # fmt: skip
        fields = table.dtype.fields or {}
        for field in ("index", "values_block_0"):
            if field not in fields:
                sets.fail(TABLE, f"has no field {field}")
            if fields[field][0].base.kind not in "fiu":
                sets.fail(TABLE, f"field {field}: expected numbers")
        names = column_names(sets)
        rows = table[()]
        frames = rows["index"].astype(float)
        values = rows["values_block_0"].astype(float).reshape(len(rows), -1)
        if frames.ndim != 1:
            sets.fail(TABLE, "index: expected one number per frame")
        if values.shape[1] != len(names) and len(rows) > 0:
            sets.fail(
                TABLE,
                f"has {values.shape[1]} numbers per frame, but {len(names)} column names",
            )
        labels, places = places_of(sets, names)
        if not ((frames >= 0) & (frames <= MAX_FRAME)).all():
            sets.fail(TABLE, "found a frame below 0 or too large")
        order = np.argsort(frames, kind="stable").tolist()
    nothing, ones = np.full((len(rows), 1), np.nan), np.ones((len(rows), 1))
    values = np.concatenate([values, nothing, ones], axis=1)
    points = values[:, np.array(places, dtype=int)]  # [frame, individual, label, 3]
    view = path.stem
    yield header([view], {"joints": labels}, frames=len(rows))
    there = np.isfinite(points).all(axis=3)
    numbers = frames.astype(int).tolist()
    for r in order:
        # All individuals, seen or not: if a view has several detectors, kinegraph pairs
        # their individuals by index.
        people = [
            {"joints": [p if t else None for p, t in zip(person, is_there)]}
            for person, is_there in zip(points[r].tolist(), there[r].tolist())
        ]
        yield line({"frame": numbers[r], "views": {view: people}})
