"""Processor time and memory of `kinegraph track`, one run after the other.

    python3 long_take.py FOLDER NAME=ARGUMENTS... > FILE.json

FOLDER is a take of `kinegraph synthesize`.
"""
import json
import os
import shlex
import subprocess
import sys


def use(folder, arguments):
  command = ["./kinegraph", "track", f"--cameras={folder}/cameras.json",
             f"--detections={folder}/detections.jsonl", "--threads=1",
             "--out=long_take.jsonl", *shlex.split(arguments)]
  track = subprocess.Popen(command, stdout=subprocess.DEVNULL)
  _, status, usage = os.wait4(track.pid, 0)
  if status != 0:
    sys.exit(f"long_take: {shlex.join(command)} ended with status {status}")
  frames = poses = 0
  with open("long_take.jsonl") as file:
    next(file)
    for line in file:  # one at a time: a child's peak begins at our own size
      frames += 1
      poses += len(json.loads(line)["people"])
  seconds = usage.ru_utime + usage.ru_stime
  return {"seconds": seconds, "frames_per_second": frames / seconds,
          "megabytes": usage.ru_maxrss / 1024, "poses": poses}


def main():
  runs = dict(argument.split("=", 1) for argument in sys.argv[2:])
  print(json.dumps({name: use(sys.argv[1], arguments)
                    for name, arguments in runs.items()}))


main()
