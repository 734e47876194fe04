"""Tracks and plots: python3 track_and_plot.py CAMERAS DETECTIONS OUT

Writes OUT/tracks.jsonl, OUT/paths.png (paths of all people from above) and
OUT/joint.png (height of the first person's left wrist with its 95 % band).
"""

import os
import sys

import kinegraph as kg
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def plot_paths(tracks, cameras, path):
    figure, axes = plt.subplots(figsize=(6, 6))
    left, right = (tracks.skeleton.joints.index(s + "_hip") for s in "lr")
    pelvis = tracks.positions_m[:, :, [left, right]].mean(axis=2)
    for p, person in enumerate(tracks.ids):
        axes.plot(pelvis[:, p, 0], pelvis[:, p, 1], label=f"person {person}")
    for camera in cameras:
        axes.plot(*camera.centre[:2], "k^")
        axes.annotate(camera.name, camera.centre[:2])
    axes.set(xlabel="x, m", ylabel="y, m", aspect="equal")
    axes.legend(loc="upper right")
    figure.savefig(path, dpi=120)
    plt.close(figure)


def plot_joint(tracks, joint, path):
    j = tracks.skeleton.joints.index(joint)
    height = tracks.positions_m[:, 0, j, 2]
    half = 1.96 * np.sqrt(tracks.covariance_m2[:, 0, j, 2, 2])
    figure, axes = plt.subplots(figsize=(9, 3))
    axes.fill_between(tracks.times_s, height - half, height + half, alpha=0.3)
    axes.plot(tracks.times_s, height)
    axes.set(xlabel="time, s", ylabel=f"height of {joint}, m")
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    plt.close(figure)


def main(cameras_path, detections_path, out):
    os.makedirs(out, exist_ok=True)
    cameras = kg.read_cameras(cameras_path)
    detections = kg.read_detections(detections_path)
    tracks = kg.track(cameras, detections)
    kg.write_tracks(os.path.join(out, "tracks.jsonl"), tracks)
    plot_paths(tracks, cameras, os.path.join(out, "paths.png"))
    plot_joint(tracks, "l_wrist", os.path.join(out, "joint.png"))
    observed = (tracks.status == kg.OBSERVED).sum()
    print(f"{len(tracks)} frames, {len(tracks.ids)} people, {observed} observed joints")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
