"""Shared by the adapters: errors, limits, and kinegraph's JSON Lines."""

from __future__ import annotations

import json
import os
import pathlib
import re

MAX_FRAME = 1 << 50


class Refusal(Exception):
    """An error in one line: the file, the place in it, what is wrong."""

    def __init__(self, path, place, message):
        parts = [str(path), place, message]
        super().__init__(": ".join(part for part in parts if part))


class Options:
    """Options of the user, as kinegraph passes them; None: not set."""

    def __init__(self, joints=None, first_frame=0, frame_rate=None):
        self.joints = joints
        self.first_frame = first_frame
        self.frame_rate = frame_rate


def most_bytes(stored):
    """Limit for the size in memory [bytes] of `stored` bytes of a file. Deflate's ratio is
    at most 1032, for constant data. A file with space for 250 people but only one person
    in it reaches a ratio of 256; the constant term permits small files of constant data."""
    return (32 << 20) + 256 * stored


def natural(name):
    """Key for natural order: cam2 before cam10."""
    parts = re.split(r"(\d+)", str(name))
    return [(0, int(p), "") if p.isdigit() else (1, 0, p) for p in parts if p], str(name)


def folders_in(folder):
    """Folders in a folder in natural order, without hidden ones."""
    with os.scandir(folder) as entries:
        found = [entry.path for entry in entries if entry.is_dir() and entry.name[0] != "."]
    return sorted(map(pathlib.Path, found), key=lambda path: natural(path.name))


def files_in(folder, suffix):
    """Files in a folder in natural order, without hidden ones."""
    with os.scandir(folder) as entries:
        found = [
            entry.path
            for entry in entries
            if entry.name.endswith(suffix) and entry.name[0] != "." and entry.is_file()
        ]
    return sorted(map(pathlib.Path, found), key=lambda path: natural(path.stem))


def begins_with(path, beginning):
    if not os.path.isfile(path):
        return False
    with open(path, "rb") as file:
        return file.read(len(beginning)) == beginning


def line(value):
    """A line of JSON; NaN and infinity become null."""
    text = json.dumps(value, separators=(",", ":"))
    if "NaN" in text or "Infinity" in text:
        text = json.dumps(_plain(value), separators=(",", ":"), allow_nan=False)
    return text.encode() + b"\n"


def _plain(value):
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    is_json = not isinstance(value, float) or abs(value) < float("inf")
    return value if is_json else None


def header(views, skeleton, frame_rate=None, frames=None):
    """First line of detections. skeleton: name of a built-in skeleton, or
    {"joints": labels in any spelling, "bones": pairs of indices, optional}. frames:
    number of frames; None: unknown."""
    return line(
        {
            "kinegraph_detections": 1,
            "skeleton": skeleton,
            "frame_rate": frame_rate,
            "views": list(views),
            "frames": frames,
        }
    )
