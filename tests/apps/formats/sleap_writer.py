"""Writes two views as SLEAP's analysis HDF5 with h5py, in both axis orders.

Node n of track t in frame f of view v stands at x = 100 v + 10 t + n + f / 8,
y = 2 x; its score is 1 / (1 + n). Track 1 is there from frame 2 on only, and
node 1 of track 0 is missing in frame 3.
"""

import json
import sys

import h5py
import numpy as np

nodes = ["snout", "left_ear", "tail_base"]
for view in range(2):
    tracks = np.full((5, 2, 3, 2), np.nan)  # frame, track, node, xy
    scores = np.full((5, 2, 3), np.nan)
    for f in range(5):
        for t in range(2):
            for n in range(3):
                if (t == 1 and f < 2) or (f, t, n) == (3, 0, 1):
                    continue
                x = 1 + 100 * view + 10 * t + n + f / 8  # (0, 0) is no point
                tracks[f, t, n] = x, 2 * x
                scores[f, t, n] = 1 / (1 + n)
    with h5py.File("%s/cam%d.h5" % (sys.argv[1], view), "w") as file:
        if view == 0:  # as SLEAP's own export: track, xy, node, frame
            file["tracks"] = tracks.transpose(1, 3, 2, 0)
            file["point_scores"] = scores.transpose(1, 2, 0)
        else:  # as sleap-io writes it on request
            file.create_dataset("tracks", data=tracks, compression="gzip")
            file["tracks"].attrs["dims"] = json.dumps(["frame", "track", "node", "xy"])
            file["point_scores"] = scores
        file["node_names"] = np.array(nodes, dtype="S")
        file["track_names"] = np.array(["track_0", "track_1"], dtype="S")
        file["edge_inds"] = np.array([[0, 1], [0, 2]])
        file["track_occupancy"] = np.ones((5, 2), dtype="uint8")
