#!/usr/bin/env python3
"""Keeps what a step of tests/all.sh came to, in FOLDER/STEP.json.

  tests/parts/keep_step.py FOLDER STEP TITLE OUTCOME SECONDS

The last line of FOLDER/STEP.log is what the step says of itself.
"""
import json
import pathlib
import sys

from run_parts import commit

folder, step, title, outcome, seconds = sys.argv[1:]
words = (pathlib.Path(folder) / f"{step}.log").read_text(errors="replace")
lines = [line for line in words.splitlines() if line.strip()]
(pathlib.Path(folder) / f"{step}.json").write_text(json.dumps({
    "step": step, "title": title, "outcome": outcome, "seconds": int(seconds),
    "said": lines[-1].strip() if lines else "", "commit": commit()}) + "\n")
