"""OpenCap's cameraIntrinsicsExtrinsics.pickle, one per camera in Videos/CAMERA of a
session's folder: a dictionary of NumPy arrays intrinsicMat (3x3 px), distortion
(OpenCV's five), imageSize (height, width), rotation (3x3) and translation (mm),
x_cam = R X + t. The world frame is the calibration board's. A camera has the name of
its folder; one in a file of another name has the name of the file."""

from __future__ import annotations

import json

import pickles
from common import Refusal, begins_with, folders_in

KIND = "cameras"
PACKAGES = ["numpy"]
FILE = "cameraIntrinsicsExtrinsics.pickle"
MOST_BYTES = 1 << 20
READ = ["intrinsicMat", "distortion", "imageSize", "rotation", "translation",
        "rotation_EulerAngles"]  # fmt: skip


def find(path):
    """The pickles of a session's folder, its folder Videos, or one camera's folder;
    a file itself."""
    if not path.is_dir():
        return [path]
    if (path / FILE).is_file():
        return [path / FILE]
    for parent in (path / "Videos", path):
        if parent.is_dir():
            files = [folder / FILE for folder in folders_in(parent)]
            files = [file for file in files if file.is_file()]
            if files:
                return files
    return []


def recognise(path):
    if path.is_dir():
        return bool(find(path))
    return any(begins_with(path, bytes([0x80, version])) for version in range(2, 6))


def name_of(file):
    folder = file.absolute().parent.name
    return folder if file.name == FILE and folder else file.stem


def numbers(file, value, key, shape):
    """The numbers of an array as rows, or flat without a shape or for a single column."""
    array = getattr(value, "value", value)
    array = array.tolist() if hasattr(array, "tolist") else array
    flat = [n for row in array for n in (row if isinstance(row, list) else [row])]
    if shape and len(flat) != shape[0] * shape[1]:
        raise Refusal(file, key, f"expected {shape[0]} x {shape[1]} numbers")
    if not all(isinstance(n, (int, float)) for n in flat):
        raise Refusal(file, key, "expected numbers")
    flat = [float(n) for n in flat]
    if not shape or shape[1] == 1:
        return flat
    return [flat[i : i + shape[1]] for i in range(0, len(flat), shape[1])]


def camera_of(file):
    if file.stat().st_size > MOST_BYTES:
        raise Refusal(file, "", f"is larger than {MOST_BYTES >> 20} MiB")
    content = file.read_bytes()
    if not recognise(file):
        raise Refusal(file, "", "is not a Python pickle of protocol 2 to 5")
    values = pickles.load(content, file)
    if not isinstance(values, dict) or not all(isinstance(k, str) for k in values):
        raise Refusal(file, "", "expected a dictionary of a camera's arrays")
    if "rotation" not in values:
        raise Refusal(
            file, "", "has no rotation: cameraIntrinsics.pickle contains only the "
            f"intrinsics, expected {FILE}"
        )  # fmt: skip

    def of(key, *shape):
        if key not in values:
            raise Refusal(file, key, "is missing")
        try:
            return numbers(file, values[key], key, shape)
        except TypeError as error:
            raise Refusal(file, key, "expected numbers") from error

    height, width = (min(max(side, 0.0), 1e9) for side in of("imageSize", 2, 1))
    camera = {
        "name": name_of(file),
        "image_size": [int(width), int(height)],
        "K": of("intrinsicMat", 3, 3),
        "distortion": of("distortion") if "distortion" in values else [],
        "cam_from_world": {"R": of("rotation", 3, 3), "t": of("translation", 3, 1)},
    }
    # Unknown keys are passed on: kinegraph rejects those that may be lens or pose.
    camera.update({key: None for key in values if key not in READ})
    return camera


def read(path, options):
    cameras = [camera_of(file) for file in find(path)]
    units = {"length": "mm"}
    text = {"kinegraph_cameras": 1, "units": units, "cameras": cameras}
    yield json.dumps(text).encode() + b"\n"
