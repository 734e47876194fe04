#!python
"""Runs a command from the package's folder without importing the package."""

import importlib.util
import os
import sys

folder = importlib.util.find_spec("kinegraph").submodule_search_locations[0]
program = os.path.join(folder, "bin", "kinegraph")
# Adapters run in this Python, in which the user has installed their libraries.
os.environ.setdefault("KINEGRAPH_PYTHON", sys.executable)
os.execv(program, [program, *sys.argv[1:]])
