"""The stubs under mypy: correct use of the module passes, wrong use fails."""

import importlib.util
import os
import subprocess
import sys
import tempfile

SOURCE = os.environ["KINEGRAPH_SOURCE"]
USE = """
import kinegraph as kg
import numpy as np
import pathlib

cameras: list[kg.Camera] = kg.read_cameras(pathlib.Path("cameras.json"))
take = kg.read_detections("detections.jsonl")
tracks: kg.Tracks = kg.track(cameras, take, set={"graph.lag_s": 0.2})
session = kg.Session(cameras, "coco17", ["cam0"], 25.0, config="offline.toml")
part: kg.Tracks = session.process(0, [np.zeros((1, 17, 3))])
table = kg.kinematics(tracks)
knee: float = table["l_knee_flexion_deg"].max()
up_z: float = 0.0 if table.up is None else table.up[2]
"""
# A wrong type, and an upward axis that may be unknown.
WRONG = USE + "\nkg.track(cameras, take, mode=3)\ntable.up[2]\n"


def mypy(text, folder):
    path = os.path.join(folder, "use.py")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--cache-dir", folder,
         # Separate programs, not part of the module.
         "--exclude", "/adapters/", path,
         os.path.join(SOURCE, "python", "kinegraph")],
        env={**os.environ, "MYPYPATH": os.path.join(SOURCE, "python")},
        stdout=subprocess.PIPE,
        text=True,
    )


if importlib.util.find_spec("mypy") is None:
    print("SKIPPED: mypy is not installed")
else:
    with tempfile.TemporaryDirectory() as folder:
        right = mypy(USE, folder)
        assert right.returncode == 0, right.stdout
        wrong = mypy(WRONG, folder)
        assert wrong.returncode == 1, wrong.stdout
        assert "arg-type" in wrong.stdout, wrong.stdout
        assert "not indexable" in wrong.stdout, wrong.stdout
