"""Turns a camera of a calibration on the spot: turn_camera.py FILE INDEX DEG."""
import json
import math
import pathlib
import sys

path, index, degrees = pathlib.Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
calibration = json.loads(path.read_text())
pose = calibration["cameras"][index]["cam_from_world"]
c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
for rows in (pose["R"], pose["t"]):  # about the camera's vertical axis
    x, z = rows[0], rows[2]
    if isinstance(x, list):
        rows[0] = [c * a + s * b for a, b in zip(x, z)]
        rows[2] = [c * b - s * a for a, b in zip(x, z)]
    else:
        rows[0], rows[2] = c * x + s * z, c * z - s * x
path.write_text(json.dumps(calibration))
