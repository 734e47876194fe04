#!/usr/bin/python3
"""Slow motion in heavy noise, and a person who holds a pose before it.

    tests/benchmarks/slow_motion.py COMMANDS OUT [--json=FILE] [--seeds=S,..]

COMMANDS holds kinegraph-synthesize, -track and -evaluate. Clips of data/motion
before five cameras 8 m away and a modelled detector; solved by sweeps, with the
window as it comes and with configs/offline.toml. MPJPE in mm, and how many of
the observed joints are inside their 95 % ellipsoids. The rule that is judged
here (solvers/noise/person_noise.h) was chosen on seed 301.
"""
import argparse
import json
import math
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("KINEGRAPH_DATA", ROOT / "../shared/data"))

NOISES = {
    "4 px white": "noise.sigma=4;noise.white_share=1",
    "4 px, nine tenths of it last 0.1 s": "noise.sigma=4;noise.white_share=0.1",
    "1.5 px white": "noise.sigma=1.5;noise.white_share=1",
}
RATES = [25, 100]
CAMERAS = ("scene.cameras.count=5;scene.cameras.radius=8;"
           "scene.cameras.focal=800;scene.cameras.height=2")
CLIPS = ["walk", "dance", "hop"]
# Name of the part: clips, keys, and whether rows are of each clip alone.
PARTS = {
    "moving": (CLIPS, "scene.duration=6"),
    "after 10 s of rest": (["dance"], "motion.hold=[10];scene.duration=16"),
}
WAYS = {
    "window": ["--mode=graph", "--set=graph.solver=sweeps"],
    "offline": [f"--config={ROOT}/configs/offline.toml",
                "--set=graph.solver=sweeps"],
}


class Takes:
  """Makes takes and scores what is tracked of them."""

  def __init__(self, commands, out, cameras):
    self.cameras = cameras
    self.commands = pathlib.Path(commands)
    self.out = pathlib.Path(out)
    self.out.mkdir(parents=True, exist_ok=True)

  def run(self, command, *flags):
    subprocess.run([self.commands / f"kinegraph-{command}", *flags], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

  def take(self, name, clip, keys, seed):
    folder = self.out / name
    self.run("synthesize",
             f"--config={ROOT}/configs/synthetic/motion.toml",
             f"--motion={DATA}/motion/{clip}_30hz.jsonl", f"--out={folder}",
             f"--set=scene.seed={seed};noise.seed={seed};{self.cameras};{keys}")
    return folder

  def score(self, folder, flags):
    tracks, report = folder / "tracks.jsonl", folder / "score.json"
    self.run("track", f"--cameras={folder}/cameras.json",
             f"--detections={folder}/detections.jsonl", f"--out={tracks}",
             *flags)
    self.run("evaluate", "--protocol=mpjpe", f"--tracks={tracks}",
             f"--ground_truth={folder}/truth.jsonl", f"--json={report}")
    result = json.loads(report.read_text())["result"]
    inside = result["covariances"]["observed"]["inside_95"]
    return {"mm": 1e3 * result["raw_m"], "inside": inside["count"],
            "observed": inside["total"]}


def summary(scores):
  """Geometric mean of MPJPE over takes, joints counted together."""
  inside = sum(score["inside"] for score in scores)
  observed = sum(score["observed"] for score in scores)
  return {"mm": math.exp(sum(math.log(s["mm"]) for s in scores) / len(scores)),
          "inside_percent": 100 * inside / observed,
          "least_inside_percent":
              min(100 * s["inside"] / s["observed"] for s in scores),
          "observed": observed, "takes": len(scores)}


def score_rows(description, default_seeds, cells, ways=None, cameras=CAMERAS):
  """Reads the command line, prints and writes a row per cell.

  A cell is (what tells its row from others, clips, keys): its takes are made
  of each clip with each seed, and every way of tracking (name: flags) is scored
  on them.
  """
  parser = argparse.ArgumentParser(description=description)
  parser.add_argument("commands")
  parser.add_argument("out")
  parser.add_argument("--json")
  parser.add_argument("--seeds", default=default_seeds,
                      help="of scene and noise")
  args = parser.parse_args()
  ways = ways or WAYS
  takes = Takes(args.commands, args.out, cameras)
  rows = []
  for labels, clips, keys in cells:
    scores = {way: [] for way in ways}
    for clip in clips:
      for seed in args.seeds.split(","):
        name = "_".join(str(part) for part in (*labels.values(), clip, seed))
        folder = takes.take("".join(c if c.isalnum() else "_" for c in name),
                            clip, keys, seed)
        for way, flags in ways.items():
          scores[way].append(takes.score(folder, flags))
    row = {way: summary(scores[way]) for way in ways}
    rows.append({**labels, **row})
    print(" | ".join([str(label) for label in labels.values()] + [
        f"{row[way]['mm']:.2f} mm, {row[way]['inside_percent']:.1f} %"
        for way in ways]), flush=True)
  if args.json:
    pathlib.Path(args.json).write_text(json.dumps(rows, indent=1) + "\n")


def cells():
  for part, (clips, part_keys) in PARTS.items():
    for rate in RATES:
      for noise, noise_keys in NOISES.items():
        yield ({"part": part, "rate_hz": rate, "noise": noise}, clips,
               f"{part_keys};{noise_keys};scene.frame_rate={rate}")


if __name__ == "__main__":
  score_rows(__doc__.splitlines()[0], "401,402", cells())
