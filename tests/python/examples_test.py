"""The example scripts, run as a user would, and their output."""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ET

from support import SOURCE, run, synthesize


def example(name, *arguments):
    return subprocess.run(
        [sys.executable, os.path.join(SOURCE, "examples", name), *arguments],
        check=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ).stdout


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.take = os.path.join(cls.folder.name, "take")
        synthesize(cls.take, "scene.duration=6", "scene.people=3")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def in_take(self, name):
        return os.path.join(self.take, name)

    def assert_picture(self, path):
        with open(path, "rb") as file:
            content = file.read()
        self.assertEqual(content[:8], b"\x89PNG\r\n\x1a\n", path)
        # A plot without data, of the examples' size, has about 3 kB.
        self.assertGreater(len(content), 8000, path)

    def test_every_example_is_run_here(self):
        names = os.listdir(os.path.join(SOURCE, "examples"))
        here = {name for name in names if name.endswith(".py")}
        self.assertEqual(
            here, {"track_and_plot.py", "joint_angles.py", "smoothers.py"}
        )

    def test_track_and_angles_write_pictures_and_coverage(self):
        out = os.path.join(self.folder.name, "out")
        text = example(
            "track_and_plot.py",
            self.in_take("cameras.json"),
            self.in_take("detections.jsonl"),
            out,
        )
        self.assertIn("frames, 3 people", text)
        for picture in ("paths.png", "joint.png"):
            self.assert_picture(os.path.join(out, picture))
        angles = os.path.join(out, "angles.png")
        text = example(
            "joint_angles.py",
            os.path.join(out, "tracks.jsonl"),
            angles,
            self.in_take("truth.jsonl"),
        )
        self.assert_picture(angles)
        last = text.splitlines()[-1].split()
        self.assertEqual(last[0], "all")
        # The nominal coverage is 95 %. The covariances ignore that bones connect
        # joints, which widens the intervals: the demo's coverage is 97.6 %. Errors
        # of a few people are correlated over seconds, so the coverage of a short
        # recording may be lower.
        self.assertGreater(float(last[1]), 90.0, text)

    def test_angles_without_covariances_have_no_intervals(self):
        truth = self.in_take("truth.jsonl")
        out = os.path.join(self.folder.name, "plain.png")
        text = example("joint_angles.py", truth, out, truth)
        rows = [line.split() for line in text.splitlines()]
        self.assertIn(["r_knee_flexion", "0.00", "-"], [row[:3] for row in rows])
        self.assertEqual(rows[-1], ["all", "-", "0"])

    def test_angles_without_a_common_time_are_refused(self):
        truth = self.in_take("truth.jsonl")
        late = self.in_take("late.jsonl")
        with open(truth, encoding="utf-8") as file:
            lines = [json.loads(line) for line in file]
        for frame in lines[1:]:
            frame["frame"] += 5000
            frame["time"] += 200.0
        with open(late, "w", encoding="utf-8") as file:
            file.writelines(json.dumps(line) + "\n" for line in lines)
        out = os.path.join(self.folder.name, "late.png")
        with self.assertRaises(subprocess.CalledProcessError) as failure:
            example("joint_angles.py", truth, out, late)
        self.assertIn("no tracked person", failure.exception.stderr)

    def test_smoothers_batch_is_better_than_raw_dlt(self):
        out = os.path.join(self.folder.name, "smoothers.png")
        text = example("smoothers.py", self.take, out)
        self.assert_picture(out)
        errors = {
            line.split()[0]: float(line.split()[1])
            for line in text.splitlines()
            if line.endswith(" mm")
        }
        self.assertLess(errors["batch"], errors["raw_dlt"])


class OpenSim(unittest.TestCase):
    """Checks the files only: OpenSim is not available to run them."""

    def setup_of(self, skeleton, folder):
        take = os.path.join(folder, "take")
        synthesize(
            take,
            "scene.duration=1",
            "scene.people=1",
            "scene.motion.visitors=0",
            "scene.skeleton=" + skeleton,
        )
        trc = os.path.join(folder, "person.trc")
        truth = os.path.join(take, "truth.jsonl")
        run("convert", "--to=trc", "--markers=opensim", "--in=" + truth, "--out=" + trc)
        out = os.path.join(folder, "opensim")
        example("opensim/make_setup.py", trc, "model.osim", out)
        with open(trc, encoding="utf-8") as file:
            names = file.read().splitlines()[3].split()[2:]
        trees = {
            name: ET.parse(os.path.join(out, name + ".xml")).getroot()
            for name in ("markers", "scale", "ik")
        }
        return names, trees, trc

    def test_files_fit_the_trc_and_each_other(self):
        # Feet add a heel and two toes per side, and BODY_25 a neck.
        for skeleton, count in (("coco17", 13), ("body25", 20)):
            with tempfile.TemporaryDirectory() as folder:
                names, trees, trc = self.setup_of(skeleton, folder)
            markers = [m.get("name") for m in trees["markers"].iter("Marker")]
            self.assertEqual(len(markers), count)
            self.assertLessEqual(set(markers), set(names))
            tasks = [t.get("name") for t in trees["ik"].iter("IKMarkerTask")]
            self.assertEqual(tasks, markers)
            frames = {f.text for f in trees["markers"].iter("socket_parent_frame")}
            self.assertIn("/bodyset/femur_l", frames)
            pairs = [p.text.split() for p in trees["scale"].iter("markers")]
            self.assertEqual(len(pairs), 12 if count == 13 else 14)
            for pair in pairs:
                self.assertEqual(len(pair), 2)
                self.assertLessEqual(set(pair), set(markers))
            for name in ("scale", "ik"):
                self.assertEqual(trees[name].find(".//marker_file").text, trc)
                span = trees[name].find(".//time_range").text.split()
                self.assertEqual([float(t) for t in span], [0.0, 0.96])


if __name__ == "__main__":
    if importlib.util.find_spec("matplotlib") is None:
        print("SKIPPED: python3-matplotlib is not installed")
    else:
        unittest.main()
