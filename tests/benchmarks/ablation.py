#!/usr/bin/python3
"""What each part of graph mode gives, over all data sets.

    tests/benchmarks/ablation.py COMMANDS OUT [--json=FILE] [--only="TAKE;.."]
      [--seeds=S,..]

COMMANDS holds kinegraph-track and others. configs/offline.toml (batch, bones,
linking, second pass; solved by sweeps) with one part after the other switched
off, and with those switched on that are off by default. Recorded motion of
data/motion with a modelled detector and synthetic scenes: MPJPE in mm; Shelf:
mean of min(error, 30) in px of the camera left out; Campus, modelled
detections: PCP in per cent, mean of actors. Seeds are not those that anything
was chosen on.
"""
import argparse
import json
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("KINEGRAPH_DATA", ROOT / "../shared/data"))

# What is switched, and by which keys.
PARTS = {
    "everything": "",
    "pixel noise and process noise fixed":
        "graph.pixel_noise_from=fixed;graph.process_noise_from=fixed",
    "process noise fixed": "graph.process_noise_from=fixed",
    "confidences believed": "graph.confidence_from=fixed",
    "no rival starts": "graph.rival_starts=false",
    "no bones": "graph.bones=false",
    "bones of fixed freedom": "graph.bone_sigma_from=fixed",
    "view bias learnt": "graph.view_bias=auto",
    "no second pass": "tracking.second_pass=false",
    "no linking": "identity.link=false",
}
SYNTHETIC = {
    "demo": ("demo", "scene.duration=10"),
    "hard": ("hard", "scene.duration=10"),
    "correlated 25 Hz": ("correlated_25hz", ""),
    "correlated 120 Hz": ("correlated_120hz", "scene.duration=5"),
}
CLIPS = ["walk_30hz", "dance_30hz", "hop_30hz"]
# Three people on one floor; what `motion.toml` states is clean.
RECORDED = {
    "recorded, 2 px white, 60 Hz":
        "scene.frame_rate=60;noise.sigma=2;noise.white_share=1",
    "recorded, 6 px that last, 25 Hz":
        "scene.frame_rate=25;noise.sigma=6;noise.white_share=0.1;"
        "noise.correlation_time=0.1;noise.outlier_rate=0.03;"
        "noise.missing_rate=0.1",
}
CAMPUS = ("input.frame_rate=25;cameras.image_size=[360, 288];"
          "cameras.ignore_distortion=true")


class Takes:
  """Makes takes and runs commands on them."""

  def __init__(self, commands, out, seeds):
    self.seeds = seeds
    self.commands = pathlib.Path(commands)
    self.out = pathlib.Path(out)
    self.out.mkdir(parents=True, exist_ok=True)

  def run(self, command, *flags):
    subprocess.run([self.commands / f"kinegraph-{command}", *flags], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

  def scene(self, config, keys, seed, *flags):
    folder = self.out / f"{config}_{hash_of(keys)}_{seed}"
    keys = f"scene.seed={seed};noise.seed={seed}" + (f";{keys}" if keys else "")
    if not folder.exists():
      self.run("synthesize", f"--config={ROOT}/configs/synthetic/{config}.toml",
               f"--set={keys}", f"--out={folder}", *flags)
    return folder

  def tracks(self, name, cameras, detections, keys):
    tracks = self.out / f"{name}.jsonl"
    self.run("track", f"--cameras={cameras}", f"--detections={detections}",
             f"--config={ROOT}/configs/offline.toml",
             f"--set={join('graph.solver=sweeps', keys)}", f"--out={tracks}")
    return tracks

  def result(self, name, *flags):
    report = self.out / f"{name}.json"
    self.run("evaluate", f"--json={report}", *flags)
    return json.loads(report.read_text())["result"]

  def mpjpe_mm(self, scene, name, keys):
    tracks = self.tracks(name, scene / "cameras.json",
                         scene / "detections.jsonl", keys)
    result = self.result(name, "--protocol=mpjpe", f"--tracks={tracks}",
                         f"--ground_truth={scene}/truth.jsonl")
    return 1e3 * result["raw_m"]

  def synthetic(self, config, scene_keys, keys, name, flags=()):
    return mean(self.mpjpe_mm(self.scene(config, scene_keys, seed, *flags),
                              f"{name}_{seed}", keys) for seed in self.seeds)

  def recorded(self, scene_keys, keys, name):
    clips = ",".join(f"{DATA}/motion/{clip}.jsonl" for clip in CLIPS)
    return self.synthetic("motion_crowd", scene_keys, keys, name,
                          (f"--motion={clips}",))

  def shelf_px(self, keys, name):
    result = self.result(
        name, "--protocol=held_out_camera",
        f"--cameras={DATA}/shelf/calibration.json",
        f"--detections={DATA}/shelf/detections/openpose",
        f"--config={ROOT}/configs/offline.toml",
        f"--set={join('input.frame_rate=25;graph.solver=sweeps', keys)}",
        f"--reference={DATA}/shelf/reference/paper_code_shelf_warm3.json",
        f"--held_out_set={DATA}/shelf/reference/held_out_set.json")
    return result["rows"][0]["mean_truncated_px"]["value"]

  def campus_percent(self, level, keys, name):
    tracks = self.tracks(name, DATA / "campus/calibration.json",
                         DATA / f"campus/detections_modelled/{level}",
                         join(CAMPUS, keys))
    result = self.result(name, "--protocol=campus", f"--tracks={tracks}",
                         f"--ground_truth={DATA}/campus/annotation_3d.json")
    return result["mean_of_actors"]["total"]["percent"]


def mean(values):
  values = list(values)
  return sum(values) / len(values)


def join(*keys):
  return ";".join(key for key in keys if key)


def hash_of(text):
  value = 0
  for letter in text:
    value = (31 * value + ord(letter)) % 1000003
  return value


def columns(takes):
  """Name of the take: its figure as a function of keys and a file's name."""
  every = {}
  for name, (config, scene_keys) in SYNTHETIC.items():
    every[name] = lambda keys, file, c=config, s=scene_keys: takes.synthetic(
        c, s, keys, file)
  for name, scene_keys in RECORDED.items():
    every[name] = lambda keys, file, s=scene_keys: takes.recorded(s, keys, file)
  every["Shelf, px"] = takes.shelf_px
  for level in ("typical", "hard"):
    every[f"Campus {level}, %"] = (
        lambda keys, file, l=level: takes.campus_percent(l, keys, file))
  return every


def main():
  parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
  parser.add_argument("commands")
  parser.add_argument("out")
  parser.add_argument("--json")
  parser.add_argument("--only", help="takes by the beginning of their names")
  parser.add_argument("--seeds", default="41,42", help="of what is synthesized")
  args = parser.parse_args()
  takes = Takes(args.commands, args.out, args.seeds.split(","))
  every = columns(takes)
  if args.only:
    wanted = tuple(args.only.split(";"))
    every = {name: of for name, of in every.items() if name.startswith(wanted)}
  table = {}
  for take, figure in every.items():
    for i, (part, keys) in enumerate(PARTS.items()):
      file = f"{hash_of(take)}_{i}"
      table.setdefault(part, {})[take] = figure(keys, file)
      print(f"{take} | {part} | {table[part][take]:.2f}", flush=True)
  if args.json:
    pathlib.Path(args.json).write_text(json.dumps(table, indent=1) + "\n")


if __name__ == "__main__":
  main()
