#!/usr/bin/env python3
"""Fuzzes every target, or those named, for a while and prints the findings.

  tests/fuzz/run.py [program] [seconds per target] [folder] [target ...]

`program` is fuzz_targets or fuzz_readers of the preset fuzz (default
build/fuzz/tests/fuzz/fuzz_targets). FOLDER/corpus/TARGET keeps the corpus, with
which a later run continues; findings go to FOLDER/found/TARGET, libFuzzer's
output to FOLDER/TARGET.log. As many targets run in parallel as there are cores.
Exit code 1 if anything was found.
"""
import concurrent.futures
import os
import pathlib
import re
import subprocess
import sys

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else (
    "build/fuzz/tests/fuzz/fuzz_targets")
# Limits of wall time, beyond which an input counts as a hang; 10 s for targets
# that are not listed. Scenes need a few seconds of processor time, and on a
# busy machine four times that in wall time.
LIMITS_S = {"scene": 60}
SECONDS = int(sys.argv[2]) if len(sys.argv) > 2 else 600
FOLDER = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else "out/fuzz")


def targets():
    """The names that the program lists."""
    listed = subprocess.run([PROGRAM, "-runs=0"], capture_output=True,
                            text=True,
                            env=dict(os.environ, KINEGRAPH_FUZZ_TARGET="list"))
    return listed.stdout.split()


def fuzz(target):
    """The number of inputs tried, and the files of findings."""
    corpus = FOLDER / "corpus" / target
    found = FOLDER / "found" / target
    # Temporary files; the input of a target that crashes remains here.
    work = (FOLDER / "work").resolve()
    for folder in (corpus, found, work):
        folder.mkdir(parents=True, exist_ok=True)
    log = FOLDER / f"{target}.log"
    with open(log, "w") as words:
        code = subprocess.run(
            [PROGRAM, str(corpus), f"-artifact_prefix={found}/",
             f"-max_total_time={SECONDS}", "-rss_limit_mb=2048",
             f"-timeout={LIMITS_S.get(target, 10)}", "-max_len=65536",
             "-print_final_stats=1", "-detect_leaks=0"],
            stdout=subprocess.DEVNULL, stderr=words,
            env=dict(os.environ, TMPDIR=str(work),
                     KINEGRAPH_FUZZ_TARGET=target,
                     KINEGRAPH_FUZZ_SEEDS=str(corpus),
                     GLOG_minloglevel="3")).returncode
    runs = re.findall(r"number_of_executed_units: (\d+)",
                      log.read_text(errors="replace"))
    # A finding ends the fuzzer.
    findings = sorted(map(str, found.iterdir())) if code else []
    if code and not findings:
        findings = [f"exit code {code}, {log}"]
    return int(runs[-1]) if runs else 0, findings


def main():
    wanted = sys.argv[4:] or targets()
    executions, findings = 0, []
    with concurrent.futures.ThreadPoolExecutor(
            len(os.sched_getaffinity(0))) as pool:
        for target, (tried, found) in zip(wanted, pool.map(fuzz, wanted)):
            print(f"{target}: {tried:,} inputs, {len(found)} findings",
                  flush=True)
            executions += tried
            findings += found
    for finding in findings:
        print("found:", finding)
    print(f"{executions:,} inputs over {len(wanted)} targets, "
          f"{len(findings)} findings")
    sys.exit(bool(findings))


if __name__ == "__main__":
    main()
