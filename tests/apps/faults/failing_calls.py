#!/usr/bin/env python3
"""Lets the calls of every command that touch files fail, one run a call.

  tests/apps/faults/failing_calls.py [--memory] [build folder]
      [calls a command] [name]

Each command runs once to count its calls of open, read, write, fwrite, fsync,
rename, close, readdir, mmap and others, then again with the nth of them failing
(EIO), for all n or that many spread evenly. The result must be the old one or
the new one; exit code 0 only with the new one, else 1 or 2 and one line on
standard error; no partial file may be left, but where the very call that should
remove it failed. With a clock of the day that jumps by an hour, to and fro, each
command must give what it gives otherwise. A name runs the commands that begin
with it. Needs gcc.

With --memory allocations fail instead: once the nth alone, once the nth and all
that follow. Then exit code 1 and "out of memory" is what is right, or the whole
result where whoever asked can do without.
"""
import collections
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve()
ROOT = HERE.parents[3]
MEMORY = "--memory" in sys.argv
if MEMORY:
    sys.argv.remove("--memory")
BUILD = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build")
MOST = int(sys.argv[2]) if len(sys.argv) > 2 else 40
WANTED = sys.argv[3] if len(sys.argv) > 3 else ""
CLOCKS = {"runtime.json"}  # differ each time
# A batch that cannot ask git records an unknown commit.
COMMIT = re.compile(rb'(?<="commit": )"[^"]*"|(?<="commits": )\[[^]]*\]|'
                    rb'(?<=, commit )[^\n]*')


def program(name):
    return str(BUILD / "apps" / f"kinegraph-{name}")


def commands(scene):
    """Name: line, flag of the output, its name (a folder's without an end)."""
    truth = f"{scene}/truth.jsonl"
    take = [f"--cameras={scene}/cameras.json",
            f"--detections={scene}/detections.jsonl"]
    paper = f"--config={ROOT}/configs/synthetic/track_paper.toml"
    convert = [program("convert"), "--from=kinegraph", f"--in={truth}"]
    manifest = pathlib.Path(scene).parent / "manifest.toml"
    manifest.write_text(
        f'[[takes]]\nname = "a"\ncameras = "{scene}/cameras.json"\n'
        f'detections = "{scene}/detections.jsonl"\nframes = "0:5"\n'
        f'[[configurations]]\nname = "b"\n'
        f'config = "{ROOT}/configs/synthetic/track_paper.toml"\n')
    lines = {f"convert to {name}": (convert + [f"--to={name}"], "--out", out)
             for name, out in [("csv", "o.csv"), ("npz", "o.npz"),
                               ("tum", "o.mat"), ("c3d", "o.c3d"),
                               ("gltf", "o.glb"), ("trc", "folder")]}
    lines.update({
        "track": ([program("track"), *take, paper, "--frames=0:5"],
                  "--out", "o.jsonl"),
        "track, offline": (
            [program("track"), *take, f"--config={ROOT}/configs/offline.toml",
             "--frames=0:8"], "--out", "o.jsonl"),
        "evaluate": ([program("evaluate"), f"--tracks={truth}",
                      f"--ground_truth={truth}", "--protocol=mpjpe",
                      "--frames=0:3"], "--json", "o.json"),
        "report": ([program("report"), f"--tracks={truth}"], "--out", "o.html"),
        "kinematics": ([program("kinematics"), f"--tracks={truth}"], "--out",
                       "o.csv"),
        "init": ([program("init"), *take], "--out", "o.toml"),
        "doctor": ([program("doctor"), *take], "--out", "folder"),
        "synthesize": (
            [program("synthesize"), "--set=scene.duration=0.2",
             f"--config={ROOT}/configs/synthetic/demo.toml"], "--out",
            "folder"),
        "compare": (
            [program("compare"), *take, paper, "--noplots",
             "--strategies=raw_dlt,causal_gaussian"], "--out", "folder"),
        "batch": ([program("batch"), f"--manifest={manifest}"], "--out",
                  "folder"),
    })
    return {name: line for name, line in lines.items()
            if name.startswith(WANTED)}


def run(line, library, **variables):
    return subprocess.run(line, capture_output=True, text=True, timeout=300,
                          errors="replace",
                          env=dict(os.environ, LD_PRELOAD=library, **variables))


def content(path):
    """None; the bytes of a file; or those of a folder's files by name."""
    if path.is_file():
        return path.read_bytes()
    if not path.is_dir():
        return None
    return {str(e.relative_to(path)): COMMIT.sub(b"", e.read_bytes())
            for e in sorted(path.rglob("*"))
            if e.is_file() and e.name not in CLOCKS and "partial" not in e.name}


def is_part(found, whole):
    """Complete files of a folder that takes results one by one."""
    return isinstance(found, dict) and all(
        whole.get(name) == data or name.endswith(".failed.txt")
        for name, data in found.items())


def try_command(name, line, flag, file_name, library, folder):
    """Returns outcomes, and the wrong ones."""
    out = folder / file_name
    line = line + [f"{flag}={out}"]
    is_folder = file_name == "folder"
    # These put finished files into a folder one by one.
    by_file = name in ("batch", "doctor", "synthesize", "convert to trc")

    def clear():
        for entry in folder.iterdir():
            shutil.rmtree(entry) if entry.is_dir() else entry.unlink()

    clear()
    count = folder.parent / "count"
    kind = {"INJECT_CALL": "malloc"} if MEMORY else {}
    whole = run(line, library, INJECT_COUNT=str(count), **kind)
    if whole.returncode != 0:
        sys.exit(f"{name}: {whole.stderr}")
    calls = int(count.read_text())
    new = content(out)
    old = None if is_folder else b"old"
    outcomes, wrong = collections.Counter(), []
    clear()
    jumping = run(line, library, INJECT_CLOCK="1")
    if jumping.returncode != 0 or content(out) != new:
        wrong.append(("clock", jumping.returncode, jumping.stderr.strip()[:300]))
    tries = [(n, on) for n in range(1, calls + 1, max(1, calls // MOST))
             for on in ((False, True) if MEMORY else (False,))]
    for n, on in tries:
        clear()
        if not is_folder:
            out.write_bytes(b"old")
        log = folder.parent / "log"
        log.write_text("")
        if on:
            kind["INJECT_ON"] = "1"
        else:
            kind.pop("INJECT_ON", None)
        done = run(line, library, INJECT_AT=str(n), INJECT_LOG=str(log), **kind)
        found = content(out)
        state = ("new" if found == new else "old" if found in (old, {}) else
                 "parts" if by_file and is_part(found, new) else "neither")
        call = log.read_text()
        if call in ("unlink", "rmdir", "remove") and is_folder and found:
            # What could not be removed stays beside the result.
            more = found.keys() - new.keys()
            if {n: d for n, d in found.items() if n not in more} == new:
                state = "new"
        left = [str(e.relative_to(folder)) for e in folder.rglob("*")
                if "partial" in e.name]
        outcomes[f"exit {done.returncode}, {state}"] += 1
        # The tables of a batch tell which of its tasks have failed.
        told = "tasks failed" in done.stderr
        good = state == "new" if done.returncode == 0 else (
            done.returncode in ((1,) if MEMORY else (1, 2))
            and (state != "neither" or told) and one_error(done.stderr)
            and (not MEMORY or "memory" in done.stderr))
        if not good or (left and call not in ("unlink", "rmdir", "remove")):
            wrong.append((n, "on" if on else call, done.returncode, state, left,
                          done.stderr.strip()[:300]))
    print(f"{name}: {calls} calls, {sum(outcomes.values())} tried: "
          f"{dict(outcomes)}", flush=True)
    for one in wrong:
        print("  WRONG:", *one, flush=True)
    return sum(outcomes.values()), len(wrong)


def one_error(words):
    """One line; a run that goes on where one before was ended says so first."""
    lines = [line for line in words.splitlines() if "done before" not in line]
    # Notes of a result that is there may stand before memory's end.
    return len([one for one in lines if not MEMORY or "note: " not in one]) == 1


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
        tried = wrong = 0
        for name, command in commands(scene).items():
            more = try_command(name, *command, library, results)
            tried, wrong = tried + more[0], wrong + more[1]
    print(f"{tried} tried, {wrong} wrong outcomes")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
