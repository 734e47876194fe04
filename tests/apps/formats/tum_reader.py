"""Reads TUM's actorsGT.mat with SciPy, prints each actor's poses as JSON."""

import json
import sys

from scipy.io import loadmat

actors = loadmat(sys.argv[1])["actor3D"]
assert actors.shape[0] == 1
json.dump(
    [
        [
            [None if point[0] != point[0] else point for point in pose.tolist()]
            for pose in actor[:, 0]
        ]
        for actor in actors[0]
    ],
    sys.stdout,
)
