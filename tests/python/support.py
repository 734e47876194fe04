"""Shared by the tests: runs the commands built with the module."""

import os
import subprocess

SOURCE = os.environ["KINEGRAPH_SOURCE"]
APPS = os.environ["KINEGRAPH_APPS"]
CONFIGS = os.path.join(SOURCE, "configs", "synthetic")
DEMO = os.path.join(CONFIGS, "demo.toml")


def run(command, *flags):
    return subprocess.run(
        [os.path.join(APPS, "kinegraph-" + command), *flags],
        check=True,
        capture_output=True,
        text=True,
    )


def synthesize(out, *settings):
    """Writes the demo's scene to a new folder; settings such as "scene.people=3"."""
    run("synthesize", "--config=" + DEMO, "--set=" + ";".join(settings), "--out=" + out)
