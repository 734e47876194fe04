#!/usr/bin/env python3
"""Scores recordings made by others: research/takes.py [NAME ...] prints the table
"Recordings of others" of docs/results.md; research/remake calls it.

Every recording is tracked with the configuration that `init` writes and scored by
the measure in its row (SHOWN). "held out": a camera's detections are compared with
the projected tracks of the other cameras and with plain triangulation (DLT) from the
same views, for each camera in turn or for the one that is named. The measures are
computed by KINEGRAPH_DATA/takes (evaluate_take.py, field_lib.py), independently of
this project. Needs numpy, scipy and h5py.
"""
import json
import lzma
import os
import re
import resource
import subprocess
import sys
import tempfile

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
DATA = os.environ.get("KINEGRAPH_DATA", os.path.join(ROOT, "../shared/data"))
TAKES = os.path.join(DATA, "takes")
DRIVER = os.path.join(ROOT, "kinegraph")
BUILD = os.environ.get("KINEGRAPH_BUILD", os.path.join(ROOT, "build"))
sys.dont_write_bytecode = True
sys.path.insert(0, TAKES)
import field_lib  # noqa: E402

# In the mean, a larger error counts as this, and so does a point without an estimate.
MISSING_PX = 30.0


def build():
    subprocess.run([DRIVER, "build"], check=True, stdout=subprocess.DEVNULL)


def program(command):
    """Path of a program. It is run directly, because ./kinegraph would add the time for
    checking the build."""
    return os.path.join(BUILD, "apps", "kinegraph-" + command)


def kinegraph(command, *words):
    """Runs a command; returns its processor time [s]."""
    def spent():
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        return children.ru_utime + children.ru_stime
    before = spent()
    subprocess.run([program(command), *words], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    return spent() - before


def track(out, name, cameras, detections, *more):
    """Tracks with the configuration of `init`. Returns poses by frame and identity, the
    number of identities, processor time [ms per person and frame], and the arguments
    for tracking again."""
    words = ["--cameras=" + os.path.join(TAKES, cameras), "--detections=" + detections]
    config = f"{out}/{name}.toml"
    kinegraph("init", *words, *more, "--out=" + config)
    path = f"{out}/{name}.jsonl"
    seconds = kinegraph("track", "--threads=1", *words, "--config=" + config, "--out=" + path)
    tracks = field_lib.tracks(path)[1]
    poses = sum(len(people) for people in tracks.values())
    people = len({i for frame in tracks.values() for i in frame})
    return tracks, people, f"{1e3 * seconds / poses:.1f}", [*words, "--config=" + config]


def three(errors):
    return "{:.1f} / {:.1f} / {:.1f}".format(*field_lib.three(errors, MISSING_PX))


def left_out(out, cameras, detections, matches, confidence, words):
    plain, ours = [], []
    for v, camera in enumerate(cameras):
        path = f"{out}/without.jsonl"
        kinegraph("track", *words, "--without_cameras=" + camera.name, "--out=" + path)
        errors = field_lib.held_out(cameras, detections, matches, v,
                                    field_lib.tracks(path)[1], confidence, MISSING_PX)
        plain.append(errors[0])
        ours.append(errors[1])
    return three(np.concatenate(ours)), three(np.concatenate(plain))


def pizza(out, first, last):
    calibration = "pizza/calibration.json"
    path = f"{out}/detections.jsonl"
    cameras = field_lib.panoptic(os.path.join(TAKES, calibration))
    seen = [{} for _ in cameras]
    with lzma.open(os.path.join(TAKES, "pizza/detections.jsonl.xz"), "rt") as packed, \
            open(path, "w", encoding="utf-8") as file:
        for line in packed:
            frame = json.loads(line)
            if "views" in frame and "frame" in frame:
                if not first <= frame["frame"] < last:
                    continue
                for v, camera in enumerate(cameras):
                    seen[v][frame["frame"]] = [
                        np.array([[0, 0, 0] if j is None else j for j in person["joints"]], float)
                        for person in frame["views"].get(camera.name, [])]
            file.write(line)
    tracks, people, cost, words = track(out, "pizza", calibration, path, "--frame_rate=29.97")
    matches = (np.load(os.path.join(TAKES, "pizza/matches.npy")) if first == 0 else
               field_lib.make_matches(cameras, seen, tracks, range(first, last)))
    ours, plain = left_out(out, cameras, seen, matches, 0.3, words)
    return ["held out, px", ours, plain, "", str(people), cost]


def cheetah(out):
    with open(os.path.join(TAKES, "cheetah_acinoset/scene_sba.json"), encoding="utf-8") as file:
        cameras = [field_lib.Cam(f"cam{v + 1}", c["k"], c["d"], c["r"], c["t"], None, True)
                   for v, c in enumerate(json.load(file)["cameras"])]
    folder = os.path.join(TAKES, "cheetah_acinoset/dlc")
    seen = []
    for camera in cameras:
        with open(f"{folder}/{camera.name}.csv", encoding="utf-8") as file:
            rows = [line.split(",") for line in file if line[0].isdigit()]
        seen.append({int(row[0]): [np.array([float(x or 0) for x in row[1:]]).reshape(-1, 3)]
                     for row in rows})
    matches = np.array([[frame, 0] + [0] * len(cameras) for frame in seen[0]])
    _, people, cost, words = track(out, "cheetah", "cheetah_acinoset/calibration.toml", folder,
                                   "--frame_rate=90")
    ours, plain = left_out(out, cameras, seen, matches, 0.6, words)
    return ["held out, px", ours, plain, "", str(people), cost]


def crowd(out, name):
    """Scores people tracked as boxes (joints: top and bottom) by the boxes' centres."""
    detections = os.path.join(TAKES, f"crowd_cmc/{name}.jsonl")
    tracks, people, cost, _ = track(out, name, "crowd_cmc/cameras.json", detections)

    def centres(frames):
        return {frame: {i: np.nanmean(pose, 0) for i, pose in people.items()
                        if np.isfinite(pose[:, 0]).any()} for frame, people in frames.items()}
    truth = centres(field_lib.tracks(os.path.join(TAKES, f"crowd_cmc/gt_{name}.jsonl"))[1])
    peer = centres(field_lib.tracks(os.path.join(TAKES, f"crowd_cmc/peer_{name}.jsonl"))[1])
    scores = [field_lib.identity(truth, found, 0.5) for found in (centres(tracks), peer)]
    return ["IDF1 within 0.5 m, %", f"{scores[0]['idf1']:.1f}", "", f"{scores[1]['idf1']:.1f}",
            f"{people} of {scores[0]['people']}", cost]


def by_take(out, name, label, measure):
    """Runs the commands that evaluate_take.py --how prints; returns the cells of a row:
    `measure`, and the figures in the lines that begin with `label`."""
    environment = {**os.environ, "KG": DRIVER, "OUT": out, "PYTHONDONTWRITEBYTECODE": "1"}
    script = os.path.join(TAKES, "evaluate_take.py")
    commands = subprocess.run([script, name, "--how"], check=True, stdout=subprocess.PIPE,
                              text=True).stdout
    printed = subprocess.run(["bash", "-c", commands], check=True, cwd=TAKES, env=environment,
                             stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
    figures = {}
    for line in printed.splitlines():
        if line.startswith(label):
            for who, figure in re.findall(r"(tracks|DLT|peer) +([\d.]+ / [\d.]+)", line):
                figures.setdefault(who, figure)
    return [measure, *(figures.get(who, "") for who in ("tracks", "DLT", "peer")), "", ""]


# Name, source, function that scores it.
SHOWN = [
    ("pizza, frames 0 to 599", "Panoptic, OpenPose: five people at a table, five HD cameras",
     lambda out: pizza(out, 0, 600)),
    ("pizza, frames 600 to 1199", "as above", lambda out: pizza(out, 600, 1200)),
    ("JulesFlick2", "AcinoSet, DeepLabCut: a running cheetah, six fisheye cameras", cheetah),
    ("CMC1", "Ong et al.: boxes of three people, four cameras, 4 Hz; peer: MS-GLMB",
     lambda out: crowd(out, "cmc1")),
    ("CMC2", "Ong et al.: boxes of ten people, four cameras, 4 Hz; peer: MS-GLMB",
     lambda out: crowd(out, "cmc2")),
    ("caliscope_human", "Caliscope, MediaPipe: a sitting person, four webcams",
     lambda out: by_take(out, "caliscope_human", "px at all", "held out, px")),
    ("caliscope_board", "Caliscope: a board, four webcams; peer: Caliscope",
     lambda out: by_take(out, "caliscope_board", "mm off a rigid board", "off a rigid board, mm")),
    ("mouse_dannce", "DANNCE: labels of a mouse with added noise, six cameras",
     lambda out: by_take(out, "mouse_dannce", "mm to the truth", "to the labels, mm")),
    ("mouse_sleap", "sleap-anipose: a mouse, four cameras",
     lambda out: by_take(out, "mouse_sleap", "px at side", "held out, px")),
    ("fly_eks", "EKS: legs of a fly, three cameras",
     lambda out: by_take(out, "fly_eks", "px at all", "held out, px")),
    ("fly_deepfly3d", "DeepFly3D: a fly, seven cameras; peer: DeepFly3D",
     lambda out: by_take(out, "fly_deepfly3d", "px in the views", "in the views, px")),
    ("StaticTrial", "Pose2Sim: a standing person, four cameras; peer: Pose2Sim",
     lambda out: by_take(out, "pose2sim_static/S00_P00_T00_StaticTrial", "px in the views",
                         "in the views, px")),
]
HEAD = ["recording", "source", "measure", "kinegraph", "DLT", "peer", "identities",
        "ms per person-frame"]


def table(names=()):
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    for name, source, score in SHOWN:
        if not names or name.split(",")[0] in names:
            with tempfile.TemporaryDirectory() as out:
                lines.append("| " + " | ".join([name, source, *score(out)]) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    build()
    print(table(sys.argv[1:]))
