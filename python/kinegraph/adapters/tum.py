"""TUM's actorsGT.mat of Campus and Shelf: a MATLAB file with the cell `actor3D`, 1 x
ACTORS; each entry a cell FRAMES x 1; each entry of that 14 x 3 doubles in metres, or
empty where the actor is not annotated. An actor's id is its index in the cell, a frame
is the index of its entry, both from zero."""

from __future__ import annotations

import io
import json

from common import Refusal, begins_with, line

KIND = "tracks"
PACKAGES = ["scipy"]
VARIABLE = "actor3D"
JOINTS = 14
# Limits of write(), above the official file's: a stray id must not fill the disk.
MOST_ACTORS, MOST_FRAMES = 1000, 1_000_000
MOST_BYTES = 1 << 32  # sizes in version 5 of the format have 32 bits


def recognise(path):
    return begins_with(path, b"MATLAB 5.0")


def entries(path, cell, place):
    if getattr(cell, "dtype", None) != object or cell.size == 0:
        raise Refusal(path, place, "is not a cell array, or is empty")
    return cell.ravel(order="F")


def pose_of(path, entry, place, joints):
    import numpy as np

    if entry.dtype != np.float64 or entry.shape != (joints, 3):
        raise Refusal(path, place, f"expected {joints} x 3 doubles or an empty entry")
    if np.isinf(entry).any():
        raise Refusal(path, place, "contains an infinite number")
    seen = np.isfinite(entry).all(axis=1)
    positions = [p if s else None for p, s in zip(entry.tolist(), seen.tolist())]
    return positions, ["observed" if s else "missing" for s in seen.tolist()]


def read(path, options):
    from scipy.io import loadmat

    try:
        content = loadmat(path, variable_names=[VARIABLE], mat_dtype=True)
    except MemoryError:
        raise
    except Exception as error:  # SciPy raises many types
        raise Refusal(path, "", f"is truncated or damaged: {error}") from error
    if VARIABLE not in content:
        raise Refusal(path, VARIABLE, "is missing or damaged")
    joints = options.joints or JOINTS
    names = {"joints": [f"joint_{j}" for j in range(joints)]}
    skeleton = "tum14" if joints == JOINTS else names
    actors = []
    for a, actor in enumerate(entries(path, content[VARIABLE], VARIABLE)):
        actors.append(entries(path, actor, f"{VARIABLE}{{{a + 1}}}"))
        if len(actors[a]) != len(actors[0]):
            raise Refusal(
                path, f"{VARIABLE}{{{a + 1}}}", f"found {len(actors[a])} frames, expected "
                f"{len(actors[0])} as for the first actor"
            )  # fmt: skip
    yield line({"kinegraph": 1, "skeleton": skeleton, "mode": "tum"})
    for f in range(len(actors[0])):
        people = []
        for a, actor in enumerate(actors):
            if getattr(actor[f], "size", 0) > 0:
                place = f"{VARIABLE}{{{a + 1}}}{{{f + 1}}}"
                positions, status = pose_of(path, actor[f], place, joints)
                people.append({"id": a, "joints": positions, "status": status})
        yield line({"frame": f, "people": people})


def write(lines, out):
    import numpy as np
    from scipy.io import savemat

    count = len(json.loads(next(lines))["skeleton"]["joints"])
    frames = {}
    for text in lines:
        frame = json.loads(text)
        people = {}
        for person in frame["people"]:
            people[person["id"]] = [p or [np.nan] * 3 for p in person["joints"]]
        frames[frame["frame"]] = people
    ids = {person for people in frames.values() for person in people}
    if not ids:
        raise ValueError("the tracks contain no people")
    last = max(frames)
    if max(ids) >= MOST_ACTORS or last >= MOST_FRAMES:
        raise ValueError(
            "ids and frame numbers become indices in actorsGT.mat: the largest id is "
            f"{max(ids)}, expected below {MOST_ACTORS}; the last frame is {last}, "
            f"expected below {MOST_FRAMES}"
        )
    # An empty cell takes 56 bytes: tag, flags, two dimensions, name and tag of the data.
    poses = sum(map(len, frames.values()))
    size = 56 * (last + 1) * (max(ids) + 1) + 8 * 3 * count * poses
    if size > MOST_BYTES:
        raise ValueError(
            f"actorsGT.mat would have {size / 1e9:.1f} GB, expected at most "
            f"{MOST_BYTES / 1e9:.1f} GB: it contains a cell for every id up to "
            f"{max(ids)} in every frame up to {last}"
        )
    nobody = np.zeros((count, 0))[:0]
    actors = np.empty((1, max(ids) + 1), dtype=object)
    for a in range(actors.shape[1]):
        actors[0, a] = np.empty((last + 1, 1), dtype=object)
        for f in range(last + 1):
            pose = frames.get(f, {}).get(a)
            actors[0, a][f, 0] = nobody if pose is None else np.array(pose, dtype=float)
    content = io.BytesIO()
    savemat(content, {VARIABLE: actors})
    # Without the date, so that the same tracks give the same bytes.
    text = b"MATLAB 5.0 MAT-file, by kinegraph".ljust(116)
    out.write(text + content.getvalue()[116:])
