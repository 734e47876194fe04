"""FreeMoCap's 2D points, one .npy for the whole recording
(..._2dData_numCams_numFrames_numTrackedPoints_pixelXY.npy): [cameras, frames, points,
2] of one person in pixels, NaN where a point was not found; a third number, a depth in
older files, is ignored. Views are cam_0, cam_1, ... in the order of the array. With
MediaPipe's hands and face the first 33 points are the body."""

from __future__ import annotations

import re

from common import Refusal, begins_with, header

KIND = "detections"
PACKAGES = ["numpy"]
EXPECTED = "expected the shape [cameras, frames, points, 2]"
# Built-in skeletons by number of points; MediaPipe's also with hands (21 points each),
# and with hands and a face, without and with irises.
SKELETONS = {
    17: "coco17",
    18: "coco18",
    25: "body25",
    26: "halpe26",
    33: "mediapipe33",
    75: "mediapipe33",
    133: "wholebody133",
    543: "mediapipe33",
    553: "mediapipe33",
}


def recognise(path):
    if path.is_dir() or not begins_with(path, b"\x93NUMPY"):
        return False
    with open(path, "rb") as file:
        shape = re.search(rb"'shape': \(([^)]*)\)", file.read(1 << 16))
    return shape is not None and shape[1].count(b",") == 3


def read(path, options):
    import numpy as np

    from arrays import array_lines

    try:
        array = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, OSError, EOFError) as error:
        raise Refusal(
            path, "", "is truncated, or is not an array; " + EXPECTED
        ) from error
    if array.ndim != 4:
        raise Refusal(path, "", f"has {array.ndim} dimensions, expected 4")
    if array.dtype.kind not in "fiu" or array.size == 0 or array.shape[3] not in (2, 3):
        raise Refusal(path, "", EXPECTED)
    views, frames, points, _ = array.shape
    joints = options.joints
    if joints is None:
        skeleton = SKELETONS.get(points)
        if skeleton is None:
            known = ", ".join(f"{n} ({s})" for n, s in SKELETONS.items())
            raise Refusal(
                path, "points", f"found {points} joints, expected {known}; "
                "set detections.skeleton for other skeletons"
            )  # fmt: skip
        joints = 33 if skeleton == "mediapipe33" else points
    elif joints > points:
        raise Refusal(
            path, "", f"has {points} points, expected {joints} or more, as in "
            "detections.skeleton"
        )
    else:
        skeleton = {"joints": [f"point_{j}" for j in range(joints)]}
    names = [f"cam_{v}" for v in range(views)]
    yield header(names, skeleton, frames=frames)
    found = np.ones((views, frames, 1, joints, 3))
    found[:, :, 0, :, :2] = array[:, :, :joints, :2]
    yield from array_lines(names, list(found), options.first_frame)
