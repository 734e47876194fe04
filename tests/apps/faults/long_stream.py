#!/usr/bin/env python3
"""Measures the memory of a day of live input, faster than real time.

  tests/apps/faults/long_stream.py [build folder] [hours] [folder]

Two people walk in a room of three cameras for two minutes at 30 Hz, each
leaving and returning under a new identity; then the room is empty for half an
hour; this repeats. The frames are piped into `track --detections=-` (default
window, graph.solver=sweeps), whose output frames are counted as they arrive.
Writes memory.csv (hours of the stream, output frames, resident memory in MB,
seconds). Fails if `track` fails, if a frame is missing or out of order, or if
the peak memory of the second half of the stream exceeds that of the first by
more than 4 MB.
"""
import pathlib
import shutil
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
BUILD = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build")
HOURS = float(sys.argv[2]) if len(sys.argv) > 2 else 24.0
FOLDER = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else "out/long_stream")
RATE_HZ = 30
BUSY_S = 120
EMPTY_S = 1800
# Identities are kept for ever. A leak of 10 B per frame would be 13 MB in half a
# day.
ALLOWED_GROWTH_MB = 4.0


def program(name):
    return str(BUILD / "apps" / f"kinegraph-{name}")


def synthesize(scene):
    subprocess.run(
        [program("synthesize"), f"--config={ROOT}/configs/synthetic/demo.toml",
         f"--set=scene.duration={BUSY_S};scene.frame_rate={RATE_HZ};"
         "scene.people=2;scene.motion.visitors=1.0;scene.cameras.count=3",
         f"--out={scene}"], check=True, capture_output=True)
    header, *frames = (scene / "detections.jsonl").read_text().splitlines()
    # The part of each line after frame number and time.
    rests = [frame[frame.index('"views"'):] for frame in frames]
    empty = '"views": {"cam0": [], "cam1": [], "cam2": []}}'
    return header, rests + [empty] * (EMPTY_S * RATE_HZ)


def resident_mb(process):
    for line in open(f"/proc/{process}/status"):
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return 0.0


def feed(stream, header, rests, count):
    stream.write(header + "\n")
    for begin in range(0, count, 1000):
        stream.write("".join(
            f'{{"frame": {n}, "time": {n / RATE_HZ:.9f}, '
            f"{rests[n % len(rests)]}\n"
            for n in range(begin, min(begin + 1000, count))))
    stream.close()


def number_of(line):
    begin = line.index('"frame": ') + 9
    return int(line[begin:line.index(",", begin)])


def run(header, rests, cameras):
    count = int(HOURS * 3600 * RATE_HZ)
    tracker = subprocess.Popen(
        [program("track"), f"--cameras={cameras}", "--detections=-",
         f"--config={ROOT}/configs/default.toml",
         "--set=graph.solver=sweeps", "--out=/dev/stdout"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=(FOLDER / "errors.txt").open("w"), text=True)
    threading.Thread(target=feed, daemon=True,
                     args=(tracker.stdin, header, rests, count)).start()
    start, rows, expected, people = time.monotonic(), [], 0, 0
    tracker.stdout.readline()
    with (FOLDER / "memory.csv").open("w", buffering=1) as table:
        table.write("hours,frames,resident_mb,seconds\n")
        for line in tracker.stdout:
            if number_of(line) != expected:
                sys.exit(f"frame {expected} is missing: {line[:80]}")
            expected += 1
            people += line.count('"id": ')
            if expected % (6 * 60 * RATE_HZ) == 0:
                rows.append((expected / RATE_HZ / 3600,
                             resident_mb(tracker.pid)))
                table.write(f"{rows[-1][0]:.2f},{expected},{rows[-1][1]:.1f},"
                            f"{time.monotonic() - start:.0f}\n")
    if tracker.wait() != 0 or expected != count:
        sys.exit(f"exit code {tracker.returncode}, {expected} of {count} frames")
    return rows, people


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    scene = FOLDER / "scene"
    shutil.rmtree(scene, ignore_errors=True)
    header, rests = synthesize(scene)
    rows, people = run(header, rests, scene / "cameras.json")
    half = len(rows) // 2
    first = max(mb for _, mb in rows[:half])
    second = max(mb for _, mb in rows[half:])
    print(f"{HOURS:g} h, {people} poses: at most {first:.1f} MB in the first "
          f"half, {second:.1f} MB in the second")
    sys.exit(second > first + ALLOWED_GROWTH_MB)


if __name__ == "__main__":
    main()
