"""Reads a pose-3d table of Anipose with Python's csv module, prints JSON.

Finds joints as Anipose's tools do, by the columns NAME_error. The rotation and
the centre of each row restore positions.
"""

import csv
import json
import sys

with open(sys.argv[1], newline="") as file:
    rows = list(csv.DictReader(file))
joints = [name[: -len("_error")] for name in rows[0] if name.endswith("_error")]
frames = {}
for row in rows:
    m = [[float(row["M_%d%d" % (i, k)]) for k in range(3)] for i in range(3)]
    centre = [float(row["center_%d" % i]) for i in range(3)]
    poses = {}
    for joint in joints:
        cells = [row[joint + axis] for axis in ("_x", "_y", "_z")]
        if "" in cells:
            assert cells == ["", "", ""]
            continue
        turned = [float(cell) for cell in cells]
        # The rotation's inverse is its transpose.
        point = [
            sum(m[i][k] * turned[i] for i in range(3)) + centre[k] for k in range(3)
        ]
        poses[joint] = {"point": point, "ncams": int(row[joint + "_ncams"])}
    frames[row["fnum"]] = poses
json.dump({"joints": joints, "frames": frames}, sys.stdout)
