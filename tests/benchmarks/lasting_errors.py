#!/usr/bin/python3
"""Detector's errors of which a part stays for the whole take.

    tests/benchmarks/lasting_errors.py COMMANDS OUT [--json=FILE] [--seeds=S,..]

The takes of slow_motion.py, six seconds in motion, with other noise: 3 px, a
fifth of whose variance is constant by joint and view. Printed alike.
"""
from slow_motion import CLIPS, score_rows

NOISES = {
    "the rest white": "noise.white_share=0.8;noise.static_share=0.2",
    "half of it lasts 0.1 s": "noise.white_share=0.3;noise.static_share=0.2",
}
RATES = [25, 60, 240]


def cells():
  for rate in RATES:
    for noise, keys in NOISES.items():
      yield ({"rate_hz": rate, "noise": noise}, CLIPS,
             f"noise.sigma=3;{keys};scene.frame_rate={rate};scene.duration=6")


if __name__ == "__main__":
  score_rows(__doc__.splitlines()[0], "421,422", cells())
