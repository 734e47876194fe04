#!/usr/bin/env python3
"""Runs whole commands on mutated files.

  tests/fuzz/commands.py [build folder] [runs] [first seed]

The inputs are a small scene, converted into the formats that kinegraph writes
and reads (as far as they can store it), and side files and configurations. Each
run copies one of these inputs, mutates one of its files (bytes, numbers,
slices, values that readers often mishandle) and passes it to a command that
reads it. A run fails if it is ended by a signal, takes more than 20 s of
processor time or 2 GiB of memory, has an exit code other than 0, 1 or 2, prints
an error line with exit code 0 or not exactly one with another exit code, leaves
a partial file, or has exit code 1 without "out of memory" (the exit code of bad
input is 2).
Inputs of failed runs are kept in BUILD/fuzz_commands. Prints counts by command;
exit code 1 if any run failed.
"""
import collections
import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = pathlib.Path(
    sys.argv[1] if len(sys.argv) > 1 else ROOT / "build").resolve()
RUNS = int(sys.argv[2]) if len(sys.argv) > 2 else 20000
FIRST = int(sys.argv[3]) if len(sys.argv) > 3 else 1
MOST_S, MOST_BYTES = 20, 2 << 30

CAMERAS = {"kinegraph": "c.json", "krt": "c.json", "voxelpose": "c.json",
           "longcw": "c.json", "panoptic": "c.json", "pose2sim": "c.toml",
           "tum": "c", "opencv": "c", "easymocap": "c", "colmap": "c"}
DETECTIONS = {"kinegraph": "d.jsonl", "openpose": "d", "coco": "d",
              "coco_views": "d.json", "mmpose": "d", "mediapipe": "d",
              "longcw": "d.json"}
TRACKS = {"kinegraph": "t.jsonl", "csv": "t.csv", "npz": "t.npz", "trc": "t",
          "c3d": "t.c3d", "bvh": "t", "longcw": "t.json", "4da": "t", "panoptic": "t", "tum": "t.mat"}
# Values that readers often mishandle.
HARD = [b"NaN", b"Infinity", b"-Infinity", b"null", b"1e400", b"-1", b"0",
        b"1e-320", b"2147483648", b"-2147483649", b"9223372036854775807",
        b"9223372036854775808", b"1e18", b"1e7", b'"""\\"""', b"'''", b"[" * 300,
        b'{"a":' * 300, b"a." * 300, b"{a.a=" * 200, b"- " * 300, b"\x00",
        b"\xe9", b"\xff\xff\xff\xff", b"\x7f", b"\\ud800", b"\xe2\x80\xa8",
        b"\xef\xbb\xbf", b"<script>", b"\r\n", b"\n", b",", b";", b'"', b"[]",
        b"{}", b"{},"*2000, b'"",' * 5000, b"[[a]]\n" * 500, b"&a [*a,*a]"]


def program(name):
    return str(BUILD / "apps" / f"kinegraph-{name}")


def make(folder):
    """The inputs: [(name, folder, file name, function from path to commands)]."""
    scene = folder / "scene"
    run = lambda *words: subprocess.run(words, check=True, capture_output=True)
    run(program("synthesize"), f"--config={ROOT}/configs/synthetic/demo.toml",
        "--set=scene.people=2;scene.duration=0.5;scene.cameras.count=3",
        f"--out={scene}")
    run(program("track"), f"--cameras={scene}/cameras.json",
        f"--detections={scene}/detections.jsonl", f"--out={folder}/own.jsonl",
        f"--config={ROOT}/configs/offline.toml")
    run(program("doctor"), f"--cameras={scene}/cameras.json",
        f"--detections={scene}/detections.jsonl", f"--out={folder}/doctor")
    cameras = f"--cameras={scene}/cameras.json"
    detections = f"--detections={scene}/detections.jsonl"
    inputs = []
    for kind, source, formats, use in (
            ("cameras", "cameras.json", CAMERAS, lambda p: [
                [program("convert"), "--to=kinegraph", f"--in={p}",
                 "--unit=m", "--image_size=1280,720", "--out=o.json"],
                [program("track"), f"--cameras={p}", detections,
                 "--mode=paper", "--out=o.jsonl"],
                [program("init"), f"--cameras={p}", detections,
                 "--out=o.toml"]]),
            ("detections", "detections.jsonl", DETECTIONS, lambda p: [
                [program("convert"), "--to=kinegraph", f"--in={p}",
                 "--frame_rate=25", "--out=o.jsonl"],
                [program("track"), cameras, f"--detections={p}",
                 "--mode=paper", "--set=input.frame_rate=25",
                 "--out=o.jsonl"],
                [program("doctor"), cameras, f"--detections={p}",
                 "--set=input.frame_rate=25", "--out=o"]]),
            ("tracks", "truth.jsonl", TRACKS, lambda p: [
                [program("convert"), f"--to={to}", f"--in={p}",
                 "--frame_rate=25", f"--out={out}"]
                for to, out in (("kinegraph", "o.jsonl"), ("csv", "o.csv"),
                                ("gltf", "o.glb"), ("c3d", "o.c3d"),
                                ("bvh", "o"), ("trc", "o"))] + [
                [program("report"), f"--tracks={p}", "--out=o.html"],
                [program("evaluate"), f"--tracks={p}", "--protocol=mpjpe",
                 f"--ground_truth={scene}/truth.jsonl", "--json=o.json"],
                [program("kinematics"), f"--tracks={p}", "--out=o.csv"]])):
        for name, file_name in formats.items():
            at = folder / kind / name / file_name
            at.parent.mkdir(parents=True)
            made = subprocess.run(
                [program("convert"), f"--to={name}", f"--in={scene}/{source}",
                 f"--out={at}"], capture_output=True)
            if made.returncode == 0:
                inputs.append((f"{kind} {name}", at.parent, file_name, use))
    # Side files of tracks, and configuration files.
    beside = folder / "beside"
    beside.mkdir()
    for entry in folder.glob("own*"):
        shutil.copy(entry, beside)
    shutil.copytree(folder / "doctor", beside / "doctor")
    (beside / "m.toml").write_text(
        f'[[takes]]\nname = "a"\ncameras = "{scene}/cameras.json"\n'
        f'detections = "{scene}/detections.jsonl"\n[[configurations]]\n'
        f'name = "b"\nconfig = "{ROOT}/configs/offline.toml"\n')
    shutil.copy(ROOT / "configs/synthetic/demo.toml", beside / "s.toml")
    shutil.copy(ROOT / "configs/offline.toml", beside / "k.toml")
    inputs.append(("beside", beside, "own.jsonl", lambda p: [
        [program("report"), f"--tracks={p}", "--out=o.html",
         f"--doctor={p.parent}/doctor", cameras, detections],
        [program("batch"), f"--manifest={p.parent}/m.toml", "--list",
         "--out=o"],
        [program("synthesize"), f"--config={p.parent}/s.toml",
         "--set=scene.duration=0.1", "--out=o"],
        [program("track"), cameras, detections, "--mode=paper",
         f"--config={p.parent}/k.toml", "--out=o.jsonl"],
        [program("track"), cameras, detections, "--mode=paper",
         f"--corrections={p.parent}/own.identity.jsonl", "--out=o.jsonl"]]))
    return inputs


def mutate(data, chance):
    data = bytearray(data)
    for _ in range(chance.choice((1, 1, 1, 2, 4, 16))):
        at = chance.randrange(len(data) + 1)
        far = min(len(data), at + chance.choice((1, 4, 20, 300)))
        way = chance.randrange(8)
        if way == 0 and at < len(data):
            data[at] = chance.randrange(256)
        elif way == 1:
            del data[at:far]
        elif way == 2:
            data[at:at] = data[at:far] * chance.choice((1, 2, 50))
        elif way in (3, 4):
            data[at:at] = chance.choice(HARD)
        elif way == 5:
            data[at:far] = chance.choice(HARD)
        elif way == 6:  # a digit becomes a hard number
            digits = [i for i in range(at, min(at + 200, len(data)))
                      if chr(data[i]).isdigit()]
            if digits:
                data[digits[0]:digits[0] + 1] = chance.choice(HARD[:14])
        elif chance.random() < 0.3:
            del data[at:]
    return bytes(data)


def limit():
    resource.setrlimit(resource.RLIMIT_CPU, (2 * MOST_S, 2 * MOST_S))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    # More than MOST_BYTES, because the stacks of threads count too.
    resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))


def try_once(seed, inputs, folder):
    """Returns program, input, exit code, command line, and the fault ("" if none)."""
    chance = random.Random(seed)
    name, source, file_name, use = chance.choice(inputs)
    work = folder / "work"
    shutil.rmtree(work, ignore_errors=True)
    shutil.copytree(source, work / "in")
    chosen = chance.choice(sorted(e for e in (work / "in").rglob("*")
                                  if e.is_file()))
    chosen.write_bytes(mutate(chosen.read_bytes(), chance))
    line = chance.choice(use(work / "in" / file_name))
    with open(work / "errors", "wb") as errors:
        process = subprocess.Popen(line, cwd=work, stdout=subprocess.DEVNULL,
                                   stderr=errors, preexec_fn=limit)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = 0
    words = (work / "errors").read_text(errors="replace")
    code = os.waitstatus_to_exitcode(status)
    error_lines = [one for one in words.splitlines() if ": error: " in one]
    wrong = ""
    if code not in (0, 1, 2):
        wrong = f"ended with {code}"
    elif usage.ru_utime + usage.ru_stime > MOST_S:
        wrong = f"{usage.ru_utime + usage.ru_stime:.1f} s"
    elif usage.ru_maxrss > MOST_BYTES >> 10:
        wrong = f"{usage.ru_maxrss >> 10} MiB"
    elif len(error_lines) != (code != 0):
        wrong = f"exit {code} with {len(error_lines)} error lines"
    elif code == 1 and "out of memory" not in words:
        wrong = "exit 1: " + words.strip()[-200:]
    elif list(work.glob("*partial*")):
        wrong = "a partial file is left"
    return pathlib.Path(line[0]).name, name, code, line, wrong


def main():
    outcomes, wrong = collections.Counter(), 0
    kept = BUILD / "fuzz_commands"
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        inputs = make(folder)
        for seed in range(FIRST, FIRST + RUNS):
            command, name, code, line, fault = try_once(seed, inputs, folder)
            outcomes[command, f"exit {code}"] += 1
            if (seed - FIRST) % 1000 == 999:
                print(f"{seed - FIRST + 1} runs, {wrong} wrong", flush=True)
            if not fault:
                continue
            wrong += 1
            print(f"seed {seed}, {name}, {' '.join(line)}: {fault}", flush=True)
            shutil.copytree(folder / "work", kept / str(seed),
                            dirs_exist_ok=True)
    for (command, code), count in sorted(outcomes.items()):
        print(f"{command}: {code}: {count}")
    print(f"{RUNS} runs, {wrong} wrong")
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
