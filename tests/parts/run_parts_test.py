"""What run_parts.py keeps of programs that pass, fail, and die."""
import json
import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parent / "run_parts.py"
# Stands in for a program of GoogleTest with five tests, one of them switched
# off; CASE says what comes of them.
PROGRAM = """#!/usr/bin/env python3
import json, os, sys, time
if "--gtest_list_tests" in sys.argv:
    print("Fall.\\n  Down\\n  Up  # GetParam() = 1\\n  DISABLED_Not\\nDISABLED_Off.\\n"
          "  Not\\nRise.\\n  Far\\n  Near")
    sys.exit()
index, total = (int(os.environ["GTEST_" + name])
                for name in ("SHARD_INDEX", "TOTAL_SHARDS"))
case = CASE
while time.process_time() < 0.1:
    pass
if case == "dies" and index == 1:
    os.abort()
tests = []
for at, name in enumerate(["Down", "Up", "Far", "Near"]):
    mine = at % total == index
    test = {"name": name, "status": "RUN" if mine else "NOTRUN",
            "result": "COMPLETED" if mine else "SUPPRESSED"}
    if mine and name == "Up" and case != "dies":
        test["result"] = "SKIPPED"
    if mine and name == "Far" and case == "fails":
        test["failures"] = [{"failure": "too far"}]
    tests.append(test)
path = next(a for a in sys.argv if a.startswith("--gtest_output=json:"))
with open(path.split(":", 1)[1], "w") as file:
    json.dump({"testsuites": [{"name": "Fall", "testsuite": tests}]}, file)
sys.exit(case == "leaks" or case == "fails" and index == 0)
"""


class RunPartsTest(unittest.TestCase):
    def run_of(self, *cases):
        """The exit code, and what was kept of each case."""
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            programs = []
            for case in cases:
                programs.append(folder / f"test_{case}")
                programs[-1].write_text(PROGRAM.replace("CASE", repr(case)))
                programs[-1].chmod(0o755)
            done = subprocess.run([SCRIPT, folder / "out", "2", *programs],
                                  capture_output=True, text=True)
            return done.returncode, [
                json.loads((folder / "out" / f"{program.name}.json").read_text())
                for program in programs]

    def test_all_parts_are_counted_together(self):
        code, (kept,) = self.run_of("passes")
        self.assertEqual(code, 0)
        self.assertEqual([kept[key] for key in ("program", "tests", "passed",
                                                "skipped", "failed")],
                         ["test_passes", 4, 3, 1, []])
        # Two parts of 0.1 s each, rounded to a tenth.
        self.assertGreaterEqual(kept["processor_s"], 0.2)

    def test_the_next_program_runs_after_one_that_fails(self):
        code, (fails, passes) = self.run_of("fails", "passes")
        self.assertEqual(code, 1)
        self.assertEqual((fails["passed"], fails["failed"]), (2, ["Fall.Far"]))
        self.assertEqual(passes["passed"], 3)

    def test_a_part_that_dies_counts_as_nothing_passed(self):
        code, (kept,) = self.run_of("dies")
        self.assertEqual(code, 1)
        self.assertEqual((kept["tests"], kept["passed"]), (4, 2))
        self.assertRegex(kept["failed"][0], "part 1 ended with -?[0-9]+")

    def test_a_leak_found_at_the_end_fails(self):
        code, (kept,) = self.run_of("leaks")
        self.assertEqual(code, 1)
        self.assertEqual(kept["passed"], 3)
        self.assertEqual(kept["failed"],
                         ["part 0 ended with 1", "part 1 ended with 1"])


if __name__ == "__main__":
    unittest.main()
