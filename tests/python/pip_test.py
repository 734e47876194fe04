"""pip install into a virtual environment; the module from there must give the
same tracks as the command."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import tempfile

SOURCE = os.environ["KINEGRAPH_SOURCE"]
TRACK = """
import sys, kinegraph as kg
assert kg.__file__.startswith(sys.prefix), kg.__file__
cameras = kg.read_cameras(sys.argv[1] + "/cameras.json")
take = kg.read_detections(sys.argv[1] + "/detections.jsonl")
kg.write_tracks(sys.argv[2], kg.track(cameras, take))
"""


def run(*command, **more):
    done = subprocess.run(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more
    )
    if done.returncode != 0:
        sys.exit(" ".join(map(str, command)) + "\n" + done.stdout)


def main():
    for needed in ("pip", "venv", "ensurepip", "setuptools", "wheel", "numpy"):
        if importlib.util.find_spec(needed) is None:
            print(f"SKIPPED: python3-{needed} is not installed")
            return
    apps = pathlib.Path(os.environ["KINEGRAPH_APPS"])
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(
            sys.executable, "-m", "venv", "--system-site-packages", folder / "venv"
        )
        python = folder / "venv" / "bin" / "python"
        clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        run(
            python, "-m", "pip", "install", "--no-build-isolation", "--no-index",
            "--no-deps", "--disable-pip-version-check", SOURCE,
            env=clean, cwd=folder,
        )
        run(
            apps / "kinegraph-synthesize",
            f"--config={SOURCE}/configs/synthetic/demo.toml",
            "--set=scene.duration=2;scene.people=2",
            f"--out={folder}/take",
        )
        run(
            python, "-c", TRACK, folder / "take", folder / "module.jsonl",
            env=clean, cwd=folder,
        )
        run(
            apps / "kinegraph-track",
            f"--cameras={folder}/take/cameras.json",
            f"--detections={folder}/take/detections.jsonl",
            "--set=output.observations=false",
            f"--out={folder}/command.jsonl",
        )
        frames = []
        for result in ("module.jsonl", "command.jsonl"):
            lines = (folder / result).read_text(encoding="utf-8").splitlines()
            frames.append(lines[1:])
        assert len(frames[0]) > 10, "too few frames"
        assert frames[0] == frames[1], "results differ from the command's"


main()
