"""Plots joint angles with their intervals, and compares them with ground truth:

    python3 joint_angles.py TRACKS OUT.png [TRUTH]

Plots both knees of the first person. With a ground truth, prints for each angle
the RMS error and, if the tracks have covariances, the share of the 95 % intervals
that contain the true angle.
"""

import sys

import kinegraph as kg
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def plot(table, path):
    figure, axes = plt.subplots(figsize=(9, 3))
    mine = table.ids == table.ids.min()
    for side, colour in (("l", "tab:blue"), ("r", "tab:red")):
        name = f"{side}_knee_flexion"
        if f"{name}_low_deg" in table.columns:
            axes.fill_between(
                table.times_s[mine],
                table[f"{name}_low_deg"][mine],
                table[f"{name}_high_deg"][mine],
                color=colour,
                alpha=0.25,
            )
        axes.plot(
            table.times_s[mine], table[f"{name}_deg"][mine], colour, label=name
        )
    axes.set(xlabel="time, s", ylabel="degrees")
    axes.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=120)
    plt.close(figure)


def nearest_truth(table, truth):
    """For each row, the true row at the same time (or in the same frame, if times are
    missing) with the nearest centre of mass, if that is within 0.5 m; else -1."""
    instants = [np.round(1e3 * t.times_s) for t in (table, truth)]  # ms
    if not all(np.isfinite(times).all() for times in instants):
        instants = [table.frames, truth.frames]
    now, then = instants
    axes = ("com_x_m", "com_y_m", "com_z_m")
    here = np.stack([table[a] for a in axes], axis=1)
    there = np.stack([truth[a] for a in axes], axis=1)
    rows = np.full(len(table), -1)
    for instant in np.unique(now):
        candidates = np.flatnonzero(
            (then == instant) & np.isfinite(there[:, 0])
        )
        if candidates.size == 0:
            continue
        for k in np.flatnonzero((now == instant) & np.isfinite(here[:, 0])):
            gaps = np.linalg.norm(there[candidates] - here[k], axis=1)
            if gaps.min() < 0.5:
                rows[k] = candidates[gaps.argmin()]
    return rows


def compare(table, truth):
    rows = nearest_truth(table, truth)
    pairs = rows >= 0
    if not pairs.any():
        sys.exit("no tracked person is near a true one at any common time")
    contained = total = 0
    print(f"{'angle':22} {'RMS error, deg':>14} {'inside, %':>9} {'of':>6}")
    for name in table.angles:
        if name not in truth.angles:
            continue
        found = table[f"{name}_deg"][pairs]
        true = truth[f"{name}_deg"][rows[pairs]]
        error = np.mod(found - true + 180.0, 360.0) - 180.0
        known = np.isfinite(error)
        if not known.any():
            continue
        rms = np.sqrt(np.mean(error[known] ** 2))
        share = "-"
        if f"{name}_low_deg" in table.columns:
            inside = (table[f"{name}_low_deg"][pairs] <= found - error) & (
                found - error <= table[f"{name}_high_deg"][pairs]
            )
            share = f"{100.0 * inside[known].mean():.1f}"
            contained += inside[known].sum()
            total += known.sum()
        print(f"{name:22} {rms:14.2f} {share:>9} {known.sum():6}")
    share = f"{100.0 * contained / total:.1f}" if total else "-"
    print(f"{'all':22} {'':14} {share:>9} {total:6}")


def main(tracks_path, out, truth_path=None):
    table = kg.kinematics(kg.read_tracks(tracks_path))
    for note in table.notes:
        print("note:", note)
    plot(table, out)
    if truth_path is not None:
        compare(table, kg.kinematics(kg.read_tracks(truth_path)))


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
