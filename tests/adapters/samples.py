"""Writes small files of formats that adapters read, with the libraries that usually
write them: samples.py FOLDER

In files of SLEAP and DeepLabCut, point n of animal t in frame f of view v is at
x = 1 + 100 v + 10 t + n + f / 8, y = 2 x (never at (0, 0), which means missing); its
score is 1 / (1 + n). Animal 1 is absent before frame 2, and node 1 of SLEAP's track 0
is missing in frame 3. In dlc_seeds/s1 every x is larger by 1 / 8.
"""

import json
import pathlib
import pickle
import sys

import h5py
import numpy as np
import pandas as pd
from scipy.io import savemat

NODES = ["snout", "left_ear", "tail_base"]
FRAMES = 5


def write_sleap(path, view, own_order):
    tracks = np.full((FRAMES, 2, 3, 2), np.nan)  # frame, track, node, xy
    scores = np.full((FRAMES, 2, 3), np.nan)
    for f in range(FRAMES):
        for t in range(2):
            for n in range(3):
                if (t == 1 and f < 2) or (f, t, n) == (3, 0, 1):
                    continue
                x = 1 + 100 * view + 10 * t + n + f / 8
                tracks[f, t, n] = x, 2 * x
                scores[f, t, n] = 1 / (1 + n)
    path.parent.mkdir(parents=True, exist_ok=True)
    with h5py.File(path, "w") as file:
        if own_order:  # as SLEAP's own export: track, xy, node, frame
            file["tracks"] = tracks.transpose(1, 3, 2, 0)
            file["point_scores"] = scores.transpose(1, 2, 0)
        else:  # as sleap-io writes it on request
            file.create_dataset("tracks", data=tracks, compression="gzip")
            file["tracks"].attrs["dims"] = json.dumps(["frame", "track", "node", "xy"])
            file["point_scores"] = scores
        file["node_names"] = np.array(NODES, dtype="S")
        file["track_names"] = np.array(["track_0", "track_1"], dtype="S")
        file["edge_inds"] = np.array([[0, 1], [0, 2]])
        file["track_occupancy"] = np.ones((FRAMES, 2), dtype="uint8")


def write_deeplabcut(path, view, individuals, shift_px=0.0):
    columns, numbers = [], []
    for t, individual in enumerate(individuals):
        for n, part in enumerate(NODES):
            x = 1 + 100 * view + 10 * t + n + np.arange(FRAMES) / 8
            likelihood = np.full(FRAMES, 1 / (1 + n))
            for coord, values in zip(
                ["x", "y", "likelihood"], (x + shift_px, 2 * x, likelihood)
            ):
                if t == 1:
                    values = np.where(np.arange(FRAMES) < 2, np.nan, values)
                who = [] if individual is None else [individual]
                columns.append(("DLC_net", *who, part, coord))
                numbers.append(values)
    levels = ["scorer", "individuals", "bodyparts", "coords"]
    if individuals == [None]:
        levels.remove("individuals")
    frame = pd.DataFrame(
        np.array(numbers).T, columns=pd.MultiIndex.from_tuples(columns, names=levels)
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    frame.to_hdf(path, key="df_with_missing", format="table", mode="w")


def opencap_camera():
    """A camera rotated by 90 degrees about z; the translation is in mm."""
    return {
        "intrinsicMat": np.array([[1300.5, 0, 640.25], [0, 1301.5, 360.75], [0, 0, 1]]),
        "distortion": np.array([[0.1, -0.2, 0.001, -0.002, 0.05]]),
        "imageSize": np.array([[720.0], [1280.0]]),
        "rotation": np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]),
        "translation": np.array([[100.3], [-200.7], [3000.1]]),
        "rotation_EulerAngles": np.array([[0.0], [0], [1.5]]),
    }


def write_opencap(path, protocol):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(pickle.dumps(opencap_camera(), protocol))


def write_freemocap(path, points, dtype=float):
    numbers = np.arange(2 * FRAMES * points * 2, dtype=dtype) / 8 + 1
    numbers = numbers.reshape(2, FRAMES, points, 2)
    numbers[0, 1, 0] = np.nan
    numbers[1, 2] = np.nan
    np.save(path, numbers)


def write_actors(path, compressed):
    actors = np.empty((1, 2), dtype=object)
    for a in range(2):
        frames = np.empty((FRAMES, 1), dtype=object)
        for f in range(FRAMES):
            frames[f, 0] = np.zeros((0, 0))
            if (f + a) % 2 == 0:
                frames[f, 0] = a + 0.1 * np.arange(42).reshape(14, 3) + f / 3
        frames[2 + a, 0][3] = np.nan  # one joint is missing
        actors[0, a] = frames
    savemat(path, {"actor3D": actors, "other": np.arange(3)}, do_compression=compressed)


def main(folder):
    for v in range(2):
        write_sleap(folder / f"sleap/cam{v}.h5", v, own_order=v == 0)
        write_sleap(folder / f"session/cam{v}/take.analysis.h5", v, own_order=v == 0)
        write_deeplabcut(folder / f"dlc_one/cam{v}.h5", v, [None])
        write_deeplabcut(folder / f"dlc_two/cam{v}.h5", v, ["a", "b"])
        for d in range(2):  # two detectors, the second with a small offset
            write_deeplabcut(folder / f"dlc_seeds/s{d}/cam{v}.h5", v, [None], 0.125 * d)
        write_opencap(
            folder / f"opencap/Videos/Cam{v}/cameraIntrinsicsExtrinsics.pickle", 2 + 3 * v
        )
    write_opencap(folder / "left.pickle", 4)
    for points in (17, 25, 33, 543):
        write_freemocap(folder / f"pixels_{points}.npy", points)
    write_freemocap(folder / "pixels_float.npy", 33, np.float32)
    write_actors(folder / "actorsGT.mat", compressed=True)
    write_actors(folder / "actors_plain.mat", compressed=False)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
