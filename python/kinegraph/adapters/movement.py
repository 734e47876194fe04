"""Tracks for the Python package `movement` and xarray: netCDF (classic, 64-bit
offsets) with the dimensions time, space, keypoints and individuals. Write only."""

from __future__ import annotations

import io
import json

KIND = "tracks"
PACKAGES = ["scipy"]
STATUS = {"observed": 2, "inferred": 1, "missing": 0}
MOST_BYTES = 0xFFFFFFFC  # of a variable


def recognise(path):
    return False


class Dataset:
    def __init__(self):
        from scipy.io import netcdf_file

        self.content = io.BytesIO()
        self.file = netcdf_file(self.content, "w", version=2)

    def add(self, name, dimensions, values, **attributes):
        if values.nbytes >= MOST_BYTES:
            raise ValueError(
                f"'{name}' would need more than 4 GB, the limit of netCDF's classic "
                "format; write fewer frames, or CSV"
            )
        kind = {"f": "d", "i": "b", "S": "c"}[values.dtype.kind]
        variable = self.file.createVariable(name, kind, dimensions)
        variable[:] = values
        for key, value in attributes.items():
            setattr(variable, key, value)

    def add_texts(self, name, texts):
        import numpy as np

        rows = np.array([text.encode() for text in texts])
        letters = rows.view("S1").reshape(len(rows), -1)
        self.file.createDimension(f"{name}_letters", letters.shape[1])
        self.add(name, (name, f"{name}_letters"), letters, _Encoding="utf-8")


def write(lines, out):
    import numpy as np

    header = json.loads(next(lines))
    frames = [json.loads(text) for text in lines]
    ids = sorted({p["id"] for frame in frames for p in frame["people"]})
    joints = header["skeleton"]["joints"]
    shape = (len(frames), len(joints), len(ids))
    position = np.full((shape[0], 3, *shape[1:]), np.nan)
    sigma = np.full_like(position, np.nan)
    confidence = np.full(shape, np.nan)
    status = np.zeros(shape, dtype=np.int8)
    for f, frame in enumerate(frames):
        for person in frame["people"]:
            i = ids.index(person["id"])
            status[f, :, i] = [STATUS[word] for word in person["status"]]
            for j, joint in enumerate(person["joints"]):
                if joint is None:
                    continue
                position[f, :, j, i] = joint
                covariance = person.get("covariance", [None] * len(joints))[j]
                if covariance is not None:
                    sigma[f, :, j, i] = np.sqrt([covariance[k] for k in (0, 3, 5)])
                    confidence[f, j, i] = person["within"][j]
    data = Dataset()
    file = data.file
    for name, length in (("time", len(frames)), ("space", 3), ("keypoints", len(joints)),
                         ("individuals", len(ids))):  # fmt: skip
        file.createDimension(name, length)
    rate = header["frame_rate"]
    numbers = np.array([float(frame["frame"]) for frame in frames])
    has_clock = rate is not None or any(frame["time"] for frame in frames)
    file.ds_type = "poses"
    file.source_software = "kinegraph"
    file.time_unit = "seconds" if has_clock else "frames"
    if rate is not None:
        file.fps = float(rate)
    times = np.array([float(frame["time"]) for frame in frames])
    data.add("time", ("time",), times if has_clock else numbers)
    data.add_texts("space", ["x", "y", "z"])
    data.add_texts("keypoints", joints)
    data.add_texts("individuals", header["titles"])
    data.add("frame", ("time",), numbers)
    data.add("identity", ("individuals",), np.array(ids, dtype=float))
    dense = ("time", "space", "keypoints", "individuals")
    a_joint = ("time", "keypoints", "individuals")
    beside = {"coordinates": "frame identity"}
    data.add("position", dense, position, units="m", **beside)
    data.add("confidence", a_joint, confidence,
             long_name="probability that the joint lies within 50 mm", **beside)  # fmt: skip
    data.add("status", a_joint, status,
             long_name="2 observed, 1 inferred, 0 missing", **beside)  # fmt: skip
    if any("covariance" in p for frame in frames for p in frame["people"]):
        data.add("position_sigma", dense, sigma, units="m",
                 long_name="standard deviation of the position", **beside)  # fmt: skip
    file.flush()
    out.write(data.content.getvalue())
