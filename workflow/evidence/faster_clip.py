"""Somebody who runs, of a clip of somebody who walks.

    python3 faster_clip.py CLIP SPEED PACE > FASTER.jsonl

Writes the tracks file CLIP again, its motion PACE times as fast and carried
along its own way until the middle of the body moves at SPEED [m/s].
"""
import json
import sys


def middle(frame):
  joints = frame["people"][0]["joints"]
  return [sum(joint[axis] for joint in joints) / len(joints) for axis in (0, 1)]


clip, speed, pace = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
with open(clip) as file:
  header, *frames = [json.loads(line) for line in file]
begin, end = middle(frames[0]), middle(frames[-1])
way = [b - a for a, b in zip(begin, end)]
length = sum(along**2 for along in way)**0.5
header["frame_rate"] *= pace
print(json.dumps(header))
duration = (frames[-1]["time"] - frames[0]["time"]) / pace
for frame in frames:
  elapsed = (frame["time"] - frames[0]["time"]) / pace
  carried = (speed - length / duration) * elapsed
  frame["time"] = elapsed
  for person in frame["people"]:
    person["joints"] = [[x + carried * way[0] / length,
                         y + carried * way[1] / length, z]
                        for x, y, z in person["joints"]]
  print(json.dumps(frame))
