#!python
"""Starts the commands that lie inside of the package, without importing it."""

import importlib.util
import os
import sys

folder = importlib.util.find_spec("kinegraph").submodule_search_locations[0]
program = os.path.join(folder, "bin", "kinegraph")
# The adapters run in this Python, whose libraries its user has installed.
os.environ.setdefault("KINEGRAPH_PYTHON", sys.executable)
os.execv(program, [program, *sys.argv[1:]])
