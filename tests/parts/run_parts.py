#!/usr/bin/env python3
"""Runs test programs in parts, side by side, and keeps what came of each.

  tests/parts/run_parts.py FOLDER JOBS PROGRAM...

FOLDER/NAME.json counts the tests of program NAME that passed, were skipped, or
failed, and says the processor time and the commit; it is replaced when all parts
of the program are through. FOLDER/parts/NAME.INDEX.json
is what GoogleTest wrote of one part, .log its words; of a part that ends before
it has written any, no test counts as passed. Programs that come after one that
fails are run, too. Exit code 1 where one failed.
"""
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
# More parts than run side by side, so that one long test keeps few others back.
TESTS_A_PART = 25
# A program that hangs is ended.
LIMIT_S = 3600


def git(*arguments):
    done = subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True,
                          text=True)
    return done.stdout.strip() if done.returncode == 0 else "unknown"


def commit():
    """Of the sources; what pages say does not matter here."""
    changed = git("status", "--porcelain", "--untracked-files=no", "--", "apps",
                  "core", "solvers", "configs", "tests")
    return git("log", "-1", "--format=%h", "--abbrev=7") + (
        " and changes" if changed else "")


def tests_of(program):
    """How many there are, those that are switched off left out."""
    listed = subprocess.run([program, "--gtest_list_tests"], check=True,
                            stdout=subprocess.PIPE, text=True).stdout
    suite_off, count = False, 0
    for line in listed.splitlines():
        if line.startswith("  "):
            count += not suite_off and not line.startswith("  DISABLED_")
        else:
            suite_off = line.startswith("DISABLED_")
    return count


def run(program, index, parts, folder):
    """Times, exit code, and GoogleTest's own record; None where it wrote none."""
    stem = f"{program.name}.{index}"
    record = folder / f"{stem}.json"
    record.unlink(missing_ok=True)
    environment = dict(os.environ, GTEST_SHARD_INDEX=str(index),
                       GTEST_TOTAL_SHARDS=str(parts))
    begin = time.monotonic()
    with open(folder / f"{stem}.log", "w") as log:
        child = subprocess.Popen(
            ["timeout", "--kill-after=60", str(LIMIT_S), program,
             "--gtest_brief=1", f"--gtest_output=json:{record}"],
            env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        # Unlike wait, it tells what this child and its own have used.
        _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    try:
        told = json.loads(record.read_text())
    except (OSError, ValueError):
        told = None
    return {"index": index, "exit_code": child.returncode,
            "seconds": time.monotonic() - begin,
            "processor_s": used.ru_utime + used.ru_stime, "told": told}


def summary(program, tests, parts, made_from):
    """What is kept of a program whose parts are through."""
    passed, skipped, failed = 0, 0, []
    for part in parts:
        if part["told"] is None:
            failed.append(f"part {part['index']} ended with {part['exit_code']}")
            continue
        before = len(failed)
        for suite in part["told"].get("testsuites", []):
            for test in suite["testsuite"]:
                if test.get("status") != "RUN":
                    continue
                if test.get("failures"):
                    failed.append(f"{suite['name']}.{test['name']}")
                elif test.get("result") == "SKIPPED":
                    skipped += 1
                else:
                    passed += 1
        if part["exit_code"] != 0 and len(failed) == before:
            # What a sanitizer says when all tests are through, of leaks.
            failed.append(f"part {part['index']} ended with {part['exit_code']}")
    return {"program": program.name, "tests": tests, "passed": passed,
            "skipped": skipped, "failed": failed,
            "seconds": round(sum(part["seconds"] for part in parts), 1),
            "processor_s": round(sum(part["processor_s"] for part in parts), 1),
            "commit": made_from}


def main():
    folder, jobs = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    programs = [pathlib.Path(name) for name in sys.argv[3:]]
    (folder / "parts").mkdir(parents=True, exist_ok=True)
    made_from = commit()
    through = True
    total = {"tests": 0, "passed": 0, "skipped": 0, "processor_s": 0.0}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        waited = []
        for program in programs:
            tests = tests_of(program)
            parts = max(1, -(-tests // TESTS_A_PART), min(jobs, tests))
            waited.append((program, tests, [
                pool.submit(run, program, index, parts, folder / "parts")
                for index in range(parts)]))
        for program, tests, futures in waited:
            kept = summary(program, tests, [one.result() for one in futures],
                           made_from)
            (folder / f"{program.name}.json").write_text(json.dumps(kept) + "\n")
            print("{program}: {passed} of {tests} passed, {skipped} skipped, "
                  "{processor_s} s of processor time".format(**kept), flush=True)
            for name in kept["failed"]:
                print(f"FAILED: {program.name} {name}: {folder}/parts", flush=True)
            through &= not kept["failed"]
            for key in total:
                total[key] += kept[key]
    print("in all: {passed} of {tests} tests passed, {skipped} skipped, "
          "{processor_s:.0f} s of processor time".format(**total))
    sys.exit(0 if through else 1)


if __name__ == "__main__":
    main()
