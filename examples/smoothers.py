# Compares smoothers on a recording, as a notebook script (cells of VS Code,
# Spyder and Jupytext): python3 smoothers.py FOLDER OUT.png
# FOLDER contains cameras.json, detections.jsonl and truth.jsonl, as written by
# `kinegraph synthesize --out=FOLDER`.

# %% The recording
import sys

import kinegraph as kg
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

folder, out = sys.argv[1:3]
cameras = kg.read_cameras(f"{folder}/cameras.json")
detections = kg.read_detections(f"{folder}/detections.jsonl")
truth = kg.read_tracks(f"{folder}/truth.jsonl")
print(detections, "by", cameras)

# %% Track once, and fix the matches
frozen = kg.Frozen(cameras, detections)

# %% The same matches, smoothed in several ways
wanted = ("raw_dlt", "butterworth", "rts", "window", "batch")
errors_mm = {}
for strategy in wanted:
    tracks = frozen.smooth(strategy)
    errors_mm[strategy] = 1e3 * kg.evaluate(tracks, truth)["mpjpe_m"]
    print(f"{strategy:12} {errors_mm[strategy]:6.1f} mm")

# %% Error, and one wrist
figure, (bars, lines) = plt.subplots(1, 2, figsize=(11, 4))
bars.bar(list(errors_mm), list(errors_mm.values()))
bars.set_ylabel("mean joint error, mm")
bars.tick_params(axis="x", rotation=30)
wrist = truth.skeleton.joints.index("l_wrist")
for strategy in ("raw_dlt", "batch"):
    tracks = frozen.smooth(strategy)
    lines.plot(
        tracks.times_s, tracks.positions_m[:, 0, wrist, 2], label=strategy
    )
lines.set(xlabel="time, s", ylabel="height of a left wrist, m")
lines.legend()
figure.tight_layout()
figure.savefig(out, dpi=120)

# %% Check
assert np.isfinite(list(errors_mm.values())).all()
