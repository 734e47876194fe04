#!/usr/bin/env python3
"""What bones do to Campus' PCP, over resampled noise.

    tests/benchmarks/campus_bones.py COMMANDS OUT [SEEDS] [SET] [LEVELS]

Campus has no detector's output, only noise modelled on its annotation
(data/campus/detections_modelled). A seed here shifts that noise in time: what
each camera made of a person in one annotated frame (offsets from the
annotation, joints and detections missed, exchanged, split) is put on the
person's annotation of another frame, the whole sequence turned by a number of
frames drawn for each camera and person; false people likewise. Offsets scale
with the person's height in the image. Joints of the face, which are not
annotated, follow the middle of the head.

Tracks each seed of each level by the batch with and without bones and prints
PCP (mean of actors, %, with its standard error) of both and the difference,
and their means. SET:
configuration keys for both. LEVELS: of clean,typical,hard, all by default.
Figures are of modelled noise.
"""
import json
import math
import os
import random
import subprocess
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
DATA = os.environ.get("KINEGRAPH_DATA", os.path.join(ROOT, "../shared/data"))
CAMPUS = os.path.join(DATA, "campus")
FIRST, LAST = 340, 760  # frames that have modelled detections
# The annotation's joint of each of COCO's, the face without one.
ANNOTATED = [None] * 5 + [9, 8, 10, 7, 11, 6, 3, 2, 4, 1, 5, 0]
HEAD = (12, 13)
BATCH = ("output.estimator=batch;tracking.backfill=true;"
         "tracking.second_pass=true")


def annotation():
    """{camera: {(frame, person): [(x, y)] px}}"""
    with open(os.path.join(CAMPUS, "annotation_2d.json")) as file:
        frames = json.load(file)["frames"]
    found = {}
    for image in frames.values():
        frame = round(image["timestamp"] * 25)
        camera = "cam" + image["camera"][-1]
        for pose in image["poses"]:
            found.setdefault(camera, {})[frame, pose["id"]] = pose["points_2d"]
    return found


def height(points):
    rows = [point[1] for point in points]
    return max(rows) - min(rows)


def base(points, joint):
    at = ANNOTATED[joint]
    if at is not None:
        return points[at]
    return [sum(points[i][axis] for i in HEAD) / 2 for axis in (0, 1)]


def moved(detection, source, target):
    """A detection's keypoints, taken from one annotated pose to another."""
    scale = height(target) / height(source)
    keypoints = []
    for joint in range(17):
        x, y, confidence = detection["keypoints"][3 * joint:3 * joint + 3]
        if confidence > 0:
            was, now = base(source, joint), base(target, joint)
            x = now[0] + scale * (x - was[0])
            y = now[1] + scale * (y - was[1])
        keypoints += [x, y, confidence]
    return keypoints


def resample(level, camera, poses, rng):
    """The detections of one camera, their noise turned in time."""
    folder = os.path.join(CAMPUS, "detections_modelled", level)
    with open(os.path.join(folder, camera + ".json")) as file:
        detections = json.load(file)
    with open(os.path.join(folder, "truth.json")) as file:
        truth = json.load(file)["cams"][camera]
    seen = {}
    for detection, (frame, person, _) in zip(detections, truth):
        seen.setdefault((frame, person), []).append(detection)
    result = []

    def add(frame, detection, keypoints):
        found = [i for i in range(17) if keypoints[3 * i + 2] > 0]
        xs = [keypoints[3 * i] for i in found]
        ys = [keypoints[3 * i + 1] for i in found]
        box = [min(xs), min(ys), max(xs) - min(xs), max(ys) - min(ys)]
        result.append({"image_id": frame, "category_id": 1,
                       "keypoints": keypoints, "score": detection["score"],
                       "bbox": box})

    for person in sorted({person for _, person in poses}):
        frames = [f for f in range(FIRST, LAST + 1) if (f, person) in poses]
        if not frames:
            continue
        turn = rng.randrange(len(frames))
        for i, frame in enumerate(frames):
            source = frames[(i + turn) % len(frames)]
            for detection in seen.get((source, person), []):
                add(frame, detection,
                    moved(detection, poses[source, person],
                          poses[frame, person]))
    frames = range(FIRST, LAST + 1)
    turn = rng.randrange(len(frames))
    for i, frame in enumerate(frames):
        for detection in seen.get((frames[(i + turn) % len(frames)], -1), []):
            add(frame, detection, detection["keypoints"])
    result.sort(key=lambda detection: detection["image_id"])
    return result


def pcp(commands, detections, out, keys):
    cameras = os.path.join(CAMPUS, "calibration.json")
    subprocess.run(
        [os.path.join(commands, "kinegraph-track"), "--cameras=" + cameras,
         "--detections=" + detections,
         "--config=" + os.path.join(ROOT, "configs/graph/campus.toml"),
         "--set=" + keys, "--out=" + out],
        check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    subprocess.run(
        [os.path.join(commands, "kinegraph-evaluate"), "--protocol=campus",
         "--ground_truth=" + os.path.join(CAMPUS, "annotation_3d.json"),
         "--tracks=" + out, "--json=" + out + ".pcp.json"],
        check=True, stdout=subprocess.DEVNULL)
    with open(out + ".pcp.json") as file:
        total = json.load(file)["result"]["mean_of_actors"]["total"]
    return total["percent"], total["interval"]["standard_error"]


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    commands, out = sys.argv[1:3]
    seeds = int(sys.argv[3]) if len(sys.argv) > 3 else 10
    extra = ";" + sys.argv[4] if len(sys.argv) > 4 else ""
    levels = sys.argv[5] if len(sys.argv) > 5 else "clean,typical,hard"
    poses = annotation()
    for level in levels.split(","):
        gains = []
        for seed in range(1, seeds + 1):
            folder = os.path.join(out, f"{level}_{seed}")
            os.makedirs(folder, exist_ok=True)
            rng = random.Random(f"{level} {seed}")
            for camera in sorted(poses):
                with open(os.path.join(folder, camera + ".json"), "w") as file:
                    json.dump(resample(level, camera, poses[camera], rng), file)
            scores = [
                pcp(commands, folder, f"{folder}.bones_{bones}.jsonl",
                    f"{BATCH};graph.bones={bones}{extra}")
                for bones in ("false", "true")
            ]
            (without, error_without), (bones, error_bones) = scores
            gains.append(bones - without)
            print(f"{level} {seed}: without {without:.2f} +- "
                  f"{error_without:.2f}, with bones {bones:.2f} +- "
                  f"{error_bones:.2f}, {gains[-1]:+.2f}", flush=True)
        mean = sum(gains) / seeds
        spread = math.sqrt(sum((g - mean)**2 for g in gains) /
                           max(1, seeds - 1) / seeds)
        print(f"{level}: bones {mean:+.2f} +- {spread:.2f} over {seeds} seeds, "
              f"least {min(gains):+.2f}", flush=True)


if __name__ == "__main__":
    main()
