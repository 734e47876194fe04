#!/usr/bin/python3
"""Ellipsoids with few and with many cameras.

    tests/benchmarks/few_cameras.py COMMANDS OUT [--json=FILE] [--seeds=S,..]

The takes of slow_motion.py, six seconds in motion, 5 m from two, three and
eight cameras. 3 px of noise that is white or lasts. Printed alike, and the
batch without bones.
"""
from slow_motion import CLIPS, ROOT, WAYS, score_rows

CAMERAS = ("scene.cameras.radius=5;scene.cameras.focal=1000;"
           "scene.cameras.height=1.6")
RINGS = {
    "2, 90 degrees apart": "scene.cameras.count=2;scene.cameras.arc=90",
    "2, 30 degrees apart": "scene.cameras.count=2;scene.cameras.arc=30",
    "3": "scene.cameras.count=3",
    "8": "scene.cameras.count=8",
}
NOISES = {
    "white": "noise.white_share=1",
    "nine tenths last 0.1 s": "noise.white_share=0.1",
    "half lasts 0.5 s": "noise.white_share=0.5;noise.correlation_time=0.5",
    "a fifth stays": "noise.white_share=0.8;noise.static_share=0.2",
}
RATES = [25, 100]
ALL_WAYS = {
    **WAYS,
    "without_bones": [f"--config={ROOT}/configs/offline.toml",
                      "--set=graph.solver=sweeps;graph.bones=false"],
}


def cells():
  for name, ring in RINGS.items():
    for noise, keys in NOISES.items():
      for rate in RATES:
        yield ({"cameras": name, "noise": noise, "rate_hz": rate}, CLIPS,
               f"{ring};noise.sigma=3;{keys};scene.frame_rate={rate};"
               "scene.duration=6")


if __name__ == "__main__":
  score_rows(__doc__.splitlines()[0], "511,512", cells(), ALL_WAYS, CAMERAS)
