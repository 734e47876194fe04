#!/usr/bin/python3
"""Detectors whose confidences tell much, nothing, or are all alike.

    tests/benchmarks/confidences.py COMMANDS OUT [--json=FILE] [--seeds=S,..]

The takes of slow_motion.py, six seconds in motion, 3 px of noise; tracked with
graph.confidence_power as it comes, and with what the take tells of it.
"""
from slow_motion import CLIPS, WAYS, score_rows

CONFIDENCES = {
    "say nothing": "noise.confidence=0.5;noise.confidence_sigma=0.3",
    "fall with the square of the error":
        "noise.confidence=0.5;noise.noise_spread=0.5",
    "all alike": "noise.confidence=0.8",
}
NOISES = {
    "white": "noise.white_share=1",
    "nine tenths last 0.1 s": "noise.white_share=0.1",
}
BELIEVED = {
    f"{way}_believed": [flag.replace(
        "graph.solver=sweeps",
        "graph.solver=sweeps;graph.confidence_from=fixed") for flag in flags]
    for way, flags in WAYS.items()
}


def cells():
  for confidence, keys in CONFIDENCES.items():
    for noise, noise_keys in NOISES.items():
      yield ({"confidence": confidence, "noise": noise}, CLIPS,
             f"noise.sigma=3;{keys};{noise_keys};"
             "scene.frame_rate=30;scene.duration=6")


if __name__ == "__main__":
  score_rows(__doc__.splitlines()[0], "431,432", cells(),
             {**BELIEVED, **WAYS})
