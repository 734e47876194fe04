#!/usr/bin/env python3
"""Lets the calls of a command that touch files fail, one run a call.

  tests/apps/faults/failing_calls.py [build folder] [calls a command]

Each command runs once to count its calls of open, read, write, fwrite, fsync,
rename and others, then again with the nth of them failing (EIO), for all n or
that many spread evenly. The result must be the old file or the new one; exit
code 0 only with the new one, else 1 or 2 and one line on standard error; no
partial file may be left. Needs gcc.
"""
import collections
import os
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve()
ROOT = HERE.parents[3]
BUILD = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build")
MOST = int(sys.argv[2]) if len(sys.argv) > 2 else 40


def program(name):
    return str(BUILD / "apps" / f"kinegraph-{name}")


def commands(scene):
    truth = f"{scene}/truth.jsonl"
    convert = [program("convert"), "--from=kinegraph", f"--in={truth}"]
    return {
        "convert to CSV": (convert + ["--to=csv"], "--out", "o.csv"),
        "convert to NPZ": (convert + ["--to=npz"], "--out", "o.npz"),
        "convert to .mat": (convert + ["--to=tum"], "--out", "o.mat"),
        "track": ([program("track"), f"--cameras={scene}/cameras.json",
                   f"--detections={scene}/detections.jsonl",
                   f"--config={ROOT}/configs/synthetic/track_paper.toml",
                   "--frames=0:5"], "--out", "o.jsonl"),
        "evaluate": ([program("evaluate"), f"--tracks={truth}",
                      f"--ground_truth={truth}", "--protocol=mpjpe",
                      "--frames=0:3"], "--json", "o.json"),
    }


def run(line, library, **variables):
    return subprocess.run(line, capture_output=True, text=True, timeout=120,
                          env=dict(os.environ, LD_PRELOAD=library, **variables))


def try_command(name, line, flag, file_name, library, folder):
    """Returns the number of wrong outcomes."""
    out = folder / file_name
    line = line + [f"{flag}={out}"]

    def clear():
        for entry in folder.iterdir():
            entry.unlink()

    clear()
    count = folder.parent / "count"
    whole = run(line, library, INJECT_COUNT=str(count))
    if whole.returncode != 0:
        sys.exit(f"{name}: {whole.stderr}")
    calls = int(count.read_text())
    new = out.read_bytes()
    outcomes = collections.Counter()
    wrong = []
    for n in range(1, calls + 1, max(1, calls // MOST)):
        clear()
        out.write_bytes(b"old")
        log = folder.parent / "log"
        log.write_text("")
        done = run(line, library, INJECT_AT=str(n), INJECT_LOG=str(log))
        now = out.read_bytes() if out.exists() else None
        state = "new" if now == new else "old" if now == b"old" else "neither"
        left = [e.name for e in folder.iterdir() if "partial" in e.name]
        outcomes[f"exit {done.returncode}, {state} file"] += 1
        good = state == "new" if done.returncode == 0 else (
            done.returncode in (1, 2) and state != "neither"
            and done.stderr.count("\n") == 1)
        if not good or left:
            wrong.append((n, log.read_text(), done.returncode, state, left,
                          done.stderr.strip()))
    print(f"{name}: {calls} calls, {sum(outcomes.values())} tried: "
          f"{dict(outcomes)}", flush=True)
    for one in wrong:
        print("  WRONG:", *one)
    return len(wrong)


def main():
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        library = str(folder / "failing_calls.so")
        subprocess.run(["gcc", "-shared", "-fPIC", "-w", "-o", library,
                        str(HERE.with_suffix(".c")), "-ldl"], check=True)
        scene = str(folder / "scene")
        subprocess.run([program("synthesize"), "--set=scene.duration=1",
                        f"--config={ROOT}/configs/synthetic/demo.toml",
                        f"--out={scene}"], check=True, capture_output=True)
        results = folder / "results"
        results.mkdir()
        wrong = sum(try_command(name, *command, library, results)
                    for name, command in commands(scene).items())
    print(f"{wrong} wrong outcomes")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
