"""Ceres against the sweeps: time of a whole run, and how far the results are
apart where both observe a joint.

    python3 solver_difference.py NAME=ARGUMENTS... > FILE.json

ARGUMENTS are those of `kinegraph track` but for --out and --set; what goes to
--set may stand before them, each key with a semicolon behind it. Seconds are of
processor time.
"""
import json
import math
import os
import resource
import shlex
import subprocess
import sys


def processor_seconds():
  usage = resource.getrusage(resource.RUSAGE_CHILDREN)
  return usage.ru_utime + usage.ru_stime


def track(arguments, settings, solver, out):
  before = processor_seconds()
  subprocess.run(
      ["./kinegraph", "track", *arguments, f"--out={out}",
       f"--set={settings}graph.solver={solver}"],
      check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
  return processor_seconds() - before


def observed(path):
  """Positions by frame, person and joint."""
  positions = {}
  with open(path) as file:
    next(file)
    for line in file:
      frame = json.loads(line)
      for person in frame["people"]:
        for joint, status in enumerate(person["status"]):
          if status == "observed":
            positions[frame["frame"], person["id"], joint] = (
                person["joints"][joint])
  return positions


def compare(name, text):
  settings, _, rest = text.partition(" ")
  if not settings.endswith(";"):
    settings, rest = "", text
  arguments = shlex.split(rest)
  files = {solver: f"{name}_{solver}.jsonl" for solver in ("ceres", "sweeps")}
  seconds = {solver: track(arguments, settings, solver, out)
             for solver, out in files.items()}
  a, b = observed(files["ceres"]), observed(files["sweeps"])
  apart_mm = [1e3 * math.dist(a[key], b[key]) for key in a.keys() & b.keys()]
  for out in files.values():
    os.remove(out)
  return {"seconds": seconds, "joints": len(apart_mm),
          "within_percent": 100 * sum(x < 0.1 for x in apart_mm)
                            / len(apart_mm),
          "largest_mm": max(apart_mm)}


def main():
  rows = dict(argument.split("=", 1) for argument in sys.argv[1:])
  print(json.dumps({name: compare(name, text) for name, text in rows.items()}))


main()
