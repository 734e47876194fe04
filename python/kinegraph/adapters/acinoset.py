"""AcinoSet's N_cam_scene.json (Joska et al. 2021): {"camera_resolution": [width, height],
"cameras": [{"k": 3x3 px, "d": 4 terms of OpenCV's fisheye model, "r": 3x3, "t": m}]},
x_cam = r X + t. Cameras have no names in the file: they become cam1, cam2, ..."""

from __future__ import annotations

import json

from common import Refusal, line

KIND = "cameras"
PACKAGES = []
MOST_BYTES = 16 << 20
KEY = "camera_resolution"
READ = ["k", "d", "r", "t"]


def recognise(path):
    if not path.is_file():
        return False
    with open(path, "rb") as file:
        head = file.read(1 << 12)
    return head.lstrip().startswith(b"{") and f'"{KEY}"'.encode() in head


def numbers(path, place, value, rows, columns):
    """Rows of numbers; a single column may be [[x], [y]] or [x, y]."""
    if columns == 1 and isinstance(value, list):
        value = [row if isinstance(row, list) else [row] for row in value]
    is_matrix = (
        isinstance(value, list)
        and len(value) == rows
        and all(isinstance(row, list) and len(row) == columns for row in value)
    )
    flat = [number for row in value for number in row] if is_matrix else [None]
    if not all(type(number) in (int, float) for number in flat):
        raise Refusal(path, place, f"expected {rows} x {columns} numbers")
    return flat if columns == 1 else value


def read(path, options):
    if path.stat().st_size > MOST_BYTES:
        raise Refusal(path, "", f"is larger than {MOST_BYTES >> 20} MiB")
    try:
        scene = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise Refusal(path, "", "is not valid JSON") from error
    listed = scene.get("cameras") if isinstance(scene, dict) else None
    if not isinstance(listed, list):
        raise Refusal(path, "cameras", "expected a list")
    cameras = []
    for i, camera in enumerate(listed):
        place = f"camera {i}"
        if not isinstance(camera, dict):
            raise Refusal(path, place, "expected an object")

        def of(key, rows, columns, camera=camera, place=place):
            return numbers(path, f"{place}: {key}", camera.get(key), rows, columns)

        cameras.append(
            {
                "name": f"cam{i + 1}",
                "image_size": numbers(path, KEY, scene.get(KEY), 2, 1),
                "model": "opencv_fisheye",
                "K": of("k", 3, 3),
                "distortion": of("d", 4, 1),
                "cam_from_world": {"R": of("r", 3, 3), "t": of("t", 3, 1)},
                # Unknown keys are passed on, so that kinegraph rejects them.
                **{key: None for key in camera if key not in READ},
            }
        )
    yield line({"kinegraph_cameras": 1, "units": {"length": "m"}, "cameras": cameras})
