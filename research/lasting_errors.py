#!/usr/bin/env python3
"""A detector's errors that last for a whole recording, with published cameras.

  kinegraph convert --in=CALIBRATION --to=kinegraph --out=cameras.json
  kinegraph convert --in=DETECTIONS --out=poses.jsonl
  kinegraph track --cameras=cameras.json --detections=poses.jsonl \\
    --set=output.observations=true --out=tracks.jsonl
  PYTHONPATH=build/python research/lasting_errors.py cameras.json poses.jsonl \\
    tracks.jsonl

Every joint with matched detections in three or more views is triangulated robustly.
The median residual of a person's joint in a view is its lasting offset [mm at the
joint's depth]. Prints the number of offsets, their root mean square per axis, and
shares of the mean square that are common to pairs of offsets in one view: the mean
product of the two offsets, divided by the mean square. The first share, of a person's
joints, is kCommonShare of solvers/cameras/bundle.cc, which neglects the others.
"""
import json
import sys

import kinegraph as kg
import numpy as np

LEAST_CONFIDENCE = 0.4
LEAST_FRAMES = 10
MOST_FRAMES = 300
SIGMA_M = 0.02  # scale of the loss: a residual of twice this has half the weight


def lines(path):
    with open(path, encoding="utf-8") as file:
        return [json.loads(line) for line in file]


def cameras_of(path):
    with open(path, encoding="utf-8") as file:
        cameras = json.load(file)["cameras"]
    return [
        kg.Camera(
            c["name"], K=np.array(c["K"]), R=np.array(c["cam_from_world"]["R"]),
            t=np.array(c["cam_from_world"]["t"]), distortion=c.get("distortion", []),
        )
        for c in cameras
    ]


def observations(views, detections, tracks):
    """Positions [n, 3] and rows (position, person, joint, view, x, y)."""
    frames = {line["frame"]: line["views"] for line in detections[1:]}
    positions, rows = [], []
    people = tracks[1:]
    for line in people[:: max(1, len(people) // MOST_FRAMES)]:
        seen = frames.get(line["frame"])
        for person in line["people"] if seen else ():
            for joint, position in enumerate(person["joints"]):
                found = []
                for view, name in enumerate(views):
                    index = person["matches"].get(name)
                    at = seen[name][index]["joints"][joint] if index is not None else None
                    if at is not None and at[2] >= LEAST_CONFIDENCE:
                        found.append((len(positions), person["id"], joint, view, *at[:2]))
                if position is not None and len(found) >= 3:
                    positions.append(position)
                    rows += found
    return np.array(positions), np.array(rows)


def residuals(cameras, points, rows):
    """Residuals [m at the depth of the joint] and Jacobians by its position."""
    out = np.zeros((len(rows), 2))
    jacobians = np.zeros((len(rows), 2, 3))
    for view, camera in enumerate(cameras):
        of_view = rows[:, 3] == view
        at = points[rows[of_view, 0].astype(int)]
        px_per_m = camera.K[0, 0] / (at @ camera.R.T + camera.t)[:, 2, None]
        projected = camera.project(at)
        out[of_view] = (rows[of_view, 4:6] - projected) / px_per_m
        for axis in range(3):
            step = 1e-4 * np.eye(3)[axis]
            moved = camera.project(at + step) - projected
            jacobians[of_view, :, axis] = moved / px_per_m / 1e-4
    return out, jacobians


def triangulate(cameras, points, rows):
    index = rows[:, 0].astype(int)
    for _ in range(8):
        r, J = residuals(cameras, points, rows)
        weight = 1.0 / (1.0 + (r**2).sum(1) / (2.0 * SIGMA_M) ** 2)
        H = np.tile(1e-9 * np.eye(3), (len(points), 1, 1))
        g = np.zeros((len(points), 3))
        np.add.at(H, index, weight[:, None, None] * np.einsum("nai,naj->nij", J, J))
        np.add.at(g, index, weight[:, None] * np.einsum("nai,na->ni", J, r))
        points = points + np.linalg.solve(H, g[:, :, None])[:, :, 0]
    return points


def main(cameras_path, detections_path, tracks_path):
    cameras = cameras_of(cameras_path)
    detections = lines(detections_path)
    names = list(detections[1]["views"])
    if len(names) != len(cameras):
        sys.exit(f"{detections_path}: {len(names)} views, {len(cameras)} cameras")
    points, rows = observations(names, detections, lines(tracks_path))
    r, _ = residuals(cameras, triangulate(cameras, points, rows), rows)
    keys, of_key = np.unique(rows[:, 1:4], axis=0, return_inverse=True)
    found = []  # (person, joint, view, x, y) [mm]
    for key, of in enumerate(keys):
        errors = r[of_key.ravel() == key]
        if len(errors) >= LEAST_FRAMES:
            found.append((*of, *(1e3 * np.median(errors, 0))))
    person, joint, view, x, y = np.array(found).T
    variance = 0.5 * np.mean(x**2 + y**2)
    products = 0.5 * (np.outer(x, x) + np.outer(y, y)) / variance
    same_view = view[:, None] == view
    same_person = person[:, None] == person
    same_joint = joint[:, None] == joint

    def share(pairs):
        return f"{products[pairs].mean():.2f}" if pairs.any() else "-"

    print(
        f"{len(found)} offsets, {variance**0.5:.1f} mm per axis, common share "
        f"{share(same_view & same_person & ~same_joint)} of a person's joints, "
        f"{share(same_view & ~same_person & same_joint)} of a joint of different "
        f"people, {share(same_view & ~same_person & ~same_joint)} of different joints "
        f"of different people"
    )


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
