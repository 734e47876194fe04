"""SLEAP's analysis HDF5, one file per view: `tracks` (x, y of each node of each track in
each frame, NaN if missing), `point_scores`, `node_names` and `edge_inds` or `edge_names`.
The attribute `dims` lists the axes in order; the default is track, xy, node, frame. Frames
count from `first_frame`, by default 0. In a session of sleap-anipose a view is a folder
with one such file."""

from __future__ import annotations

import json
import pathlib

from common import Refusal, files_in, folders_in, header
from hdf5 import as_text, mentions, opened

KIND = "detections"
PACKAGES = ["h5py"]
AXES = ["frame", "track", "node", "xy"]


def is_analysis(path):
    return mentions(path, [b"node_names", b"tracks"])


def analyses_in(folder):
    return [path for path in files_in(folder, ".h5") if is_analysis(path)]


def session_files(path):
    found = []
    for folder in folders_in(path):
        analyses = analyses_in(folder)
        if len(analyses) > 1:
            raise Refusal(
                folder, "", f"contains {len(analyses)} analyses, expected one per camera"
            )
        found += [(folder.name, analysis) for analysis in analyses]
    return found


def recognise(path):
    if not path.is_dir():
        return is_analysis(path)
    return bool(analyses_in(path) or session_files(path))


def view_files(path):
    if not path.is_dir():
        return [(path.stem, path)]
    files = [(file.stem, file) for file in files_in(path, ".h5")]
    if not analyses_in(path):
        files = session_files(path)
    if not files:
        raise Refusal(path, "", "contains no SLEAP analysis")
    return files


def axes_of(sets):
    dims = as_text(sets.attribute("tracks", "dims"))
    if not dims:
        return ["track", "xy", "node", "frame"]
    try:
        axes = json.loads(dims)
    except ValueError:
        axes = None
    if not isinstance(axes, list) or sorted(map(str, axes)) != sorted(AXES):
        sets.fail("tracks.dims", "expected each of frame, track, node and xy once")
    return axes


def in_order(sets, name, axes, wanted):
    array = sets.numbers(name)
    if array.ndim != len(axes):
        sets.fail(name, f"has {array.ndim} axes, expected {len(axes)}")
    return array.transpose([axes.index(axis) for axis in wanted])


def edges_of(sets, nodes):
    """Pairs of nodes: from `edge_inds`, [edges, 2] or [2, edges] (MATLAB's order), else
    from `edge_names`."""
    name = "edge_inds" if sets.has("edge_inds") else "edge_names"
    if not sets.has(name):
        return []
    if name == "edge_inds":
        ends = sets.numbers(name)
        if ends.ndim == 2 and ends.shape[1] != 2:
            ends = ends.T
        ends = ends.ravel().tolist()
    else:
        found = sets.set(name)
        names = [as_text(text) for text in found[()].ravel().tolist()]
        for n in names:
            if n not in nodes:
                sets.fail(name, f"found '{n}', expected a name of node_names")
        ends = [nodes.index(n) for n in names]
    for end in ends:
        if not (0 <= end < len(nodes) and end == int(end)):
            sets.fail(name, f"found {end:.0f}, expected 0 .. {len(nodes) - 1}")
    return [[int(a), int(b)] for a, b in zip(ends[::2], ends[1::2])]


def read_view(path):
    """Labels, bones, and an array [frame, track, node, 3] of x, y [px] and score."""
    import numpy as np

    with opened(path) as sets:
        axes = axes_of(sets)
        points = in_order(sets, "tracks", axes, AXES)
        if points.shape[3] != 2:
            sets.fail(
                "tracks",
                f"found an axis 'xy' of length {points.shape[3]}, expected axes frame, "
                "track, node and xy with length 2",
            )
        labels = sets.texts("node_names")
        bones = edges_of(sets, labels)
        if points.shape[2] != len(labels):
            sets.fail(
                "tracks",
                f"has {points.shape[2]} nodes, expected the {len(labels)} of 'node_names'",
            )
        scores = np.ones(points.shape[:3])
        if sets.has("point_scores"):
            less = [axis for axis in axes if axis != "xy"]
            scores = in_order(sets, "point_scores", less, AXES[:3])
            if scores.shape != points.shape[:3]:
                sets.fail("point_scores", "has another shape than 'tracks'")
            # Instances corrected by hand have no scores.
            by_hand = np.isnan(scores) & np.isfinite(points).all(axis=3)
            scores = np.where(by_hand, 1.0, scores)
        if points.size == 0:  # no people: ignore the number of frames
            points, scores = points[:0], scores[:0]
        return labels, bones, np.concatenate([points, scores[..., None]], axis=3)


def read(path, options):
    from arrays import array_lines

    files = view_files(path)
    arrays = []
    for _, file in files:
        labels, bones, array = read_view(file)
        if not arrays:
            skeleton = {"joints": labels, "bones": bones}
        elif labels != skeleton["joints"]:
            check_labels(file, labels, skeleton["joints"])
        arrays.append(array)
    views = [name for name, _ in files]
    yield header(views, skeleton, frames=max(map(len, arrays)))
    yield from array_lines(views, arrays, options.first_frame)


def check_labels(path, found, expected):
    if len(found) != len(expected):
        raise Refusal(path, "", f"found {len(found)} joints, expected {len(expected)}")
    for j, (one, other) in enumerate(zip(found, expected)):
        if one != other:
            raise Refusal(
                path, "", f"joint {j} is '{one}', expected '{other}' as in the first file"
            )
