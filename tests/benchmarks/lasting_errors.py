#!/usr/bin/python3
"""Detector's errors of which a part stays for the whole take.

    tests/benchmarks/lasting_errors.py COMMANDS OUT [--json=FILE] [--seeds=S,..]

The takes of slow_motion.py, six seconds in motion, with other noise: 3 px, a
fifth of whose variance is constant by joint and view. Printed alike.
"""
import argparse
import json
import pathlib

from slow_motion import CLIPS, WAYS, Takes, summary

NOISES = {
    "the rest white": "noise.white_share=0.8;noise.static_share=0.2",
    "half of it lasts 0.1 s": "noise.white_share=0.3;noise.static_share=0.2",
}
RATES = [25, 60, 240]


def main():
  parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
  parser.add_argument("commands")
  parser.add_argument("out")
  parser.add_argument("--json")
  parser.add_argument("--seeds", default="421,422", help="of scene and noise")
  args = parser.parse_args()
  takes = Takes(args.commands, args.out)
  rows = []
  for rate in RATES:
    for index, (noise, keys) in enumerate(NOISES.items()):
      scores = {way: [] for way in WAYS}
      for clip in CLIPS:
        for seed in args.seeds.split(","):
          folder = takes.take(
              f"{rate}_{index}_{clip}_{seed}", clip,
              f"noise.sigma=3;{keys};scene.frame_rate={rate};scene.duration=6",
              seed)
          for way in WAYS:
            scores[way].append(takes.score(folder, way))
      rows.append({"rate_hz": rate, "noise": noise,
                   **{way: summary(scores[way]) for way in WAYS}})
      print(" | ".join([str(rate), noise] + [
          f"{rows[-1][way]['mm']:.2f} mm, {rows[-1][way]['inside_percent']:.1f} %"
          for way in WAYS]), flush=True)
  if args.json:
    pathlib.Path(args.json).write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
  main()
