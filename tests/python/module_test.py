"""Compares the module with the commands: results are identical bit for bit; bad input
raises an error that names the cause."""

import ast
import copy
import csv
import inspect
import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

import kinegraph as kg
import numpy as np
from kinegraph import _kinegraph

from support import CONFIGS, DEMO, run, synthesize

WINDOW = os.path.join(CONFIGS, "track_window.toml")
BATCH = os.path.join(CONFIGS, "track_batch.toml")


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.take = os.path.join(cls.folder.name, "take")
        synthesize(cls.take, "scene.duration=4", "scene.people=3")
        cls.cameras = kg.read_cameras(os.path.join(cls.take, "cameras.json"))
        cls.detections = kg.read_detections(
            os.path.join(cls.take, "detections.jsonl")
        )
        cls.truth = kg.read_tracks(os.path.join(cls.take, "truth.jsonl"))

    def in_take(self, name):
        return os.path.join(self.take, name)

    def in_folder(self, name):
        return os.path.join(self.folder.name, name)

    def views_of(self, k):
        """The arrays of a frame, one per view."""
        return [self.detections.view(k, v) for v in range(len(self.cameras))]

    def window(self, **changes):
        return kg.track(self.cameras, self.detections, config=WINDOW, **changes)

    def by_command(self, config=None, *flags):
        out = self.in_folder("tracks.jsonl")
        if not any(flag.startswith("--cameras=") for flag in flags):
            flags += ("--cameras=" + self.in_take("cameras.json"),)
        run(
            "track",
            "--detections=" + self.in_take("detections.jsonl"),
            *(["--config=" + config] if config else []),
            "--out=" + out,
            *flags,
        )
        return kg.read_tracks(out)

    def assert_same(self, a, b):
        np.testing.assert_array_equal(a.frames, b.frames)
        np.testing.assert_array_equal(a.ids, b.ids)
        np.testing.assert_array_equal(a.status, b.status)
        np.testing.assert_array_equal(a.positions_m, b.positions_m)
        np.testing.assert_array_equal(a.covariance_m2, b.covariance_m2)

    def test_track_equals_the_command_to_the_last_bit(self):
        for config in (WINDOW, BATCH):
            tracks = kg.track(self.cameras, self.detections, config=config)
            self.assertGreater(np.isfinite(tracks.positions_m).sum(), 0)
            self.assert_same(tracks, self.by_command(config))

    def test_track_equals_the_command_by_default_and_with_packaged_configs(self):
        self.assert_same(
            kg.track(self.cameras, self.detections), self.by_command()
        )
        # A second pass, and identities linked over the whole recording.
        offline = kg.track(
            self.cameras, self.detections, config="offline.toml", threads=2
        )
        self.assert_same(offline, self.by_command("configs/offline.toml"))
        self.assertEqual(kg.config_path("nowhere.toml"), "nowhere.toml")
        self.assertEqual(kg.config_path(DEMO), DEMO)

    def test_cameras_are_refined_as_the_command_refines_them(self):
        # One principal point is 12 px off, and refinement changes it.
        path = os.path.join(self.take, "shifted.json")
        with open(self.in_take("cameras.json")) as file:
            stated = json.load(file)
        stated["cameras"][0]["K"][0][2] += 12.0
        with open(path, "w") as file:
            json.dump(stated, file)
        cameras = kg.read_cameras(path)
        refined = kg.track(
            cameras,
            self.detections,
            config=WINDOW,
            set={"cameras.refine": "shift"},
        )
        expected = self.by_command(
            WINDOW, "--set=cameras.refine=shift", "--cameras=" + path
        )
        self.assert_same(refined, expected)
        plain = kg.track(cameras, self.detections, config=WINDOW)
        self.assertFalse(
            np.array_equal(plain.positions_m, refined.positions_m, True)
        )

    def test_kinematics_equals_the_command_to_the_last_bit(self):
        tracks = self.window()
        path = self.in_folder("own.jsonl")
        out = self.in_folder("angles.csv")
        kg.write_tracks(path, tracks)
        run("kinematics", "--tracks=" + path, "--out=" + out)
        table = kg.kinematics(tracks)
        with open(out, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(table))
        self.assertEqual(list(rows[0])[3:], table.columns)
        for column in table.columns:
            found = [float(row[column] or "nan") for row in rows]
            np.testing.assert_array_equal(found, table[column], column)
        np.testing.assert_array_equal(
            [int(row["id"]) for row in rows], table.ids
        )
        np.testing.assert_array_equal(
            [float(row["time_s"]) for row in rows], table.times_s
        )
        self.assertIn("l_knee_flexion", table.angles)
        np.testing.assert_array_equal(table.up, [0.0, 0.0, 1.0])
        with self.assertRaises(KeyError):
            table["l_knee"]
        with self.assertRaisesRegex(kg.InputError, "^up: found 'w'"):
            kg.kinematics(tracks, up="w")

    def assert_as_convert(self, source, own, *flags):
        """`own` has the command's bytes, except for the name inside a TRC. Returns the
        number of notes that the command prints."""
        out = self.in_folder("new/command" + os.path.splitext(own)[1])
        done = run("convert", "--in=" + self.in_take(source), "--out=" + out, *flags)
        with open(own, "rb") as a, open(out, "rb") as b:
            name = os.path.basename(own).encode()
            self.assertEqual(a.read().replace(name, b"command.trc"), b.read(), own)
        return done.stderr.count("note: ")

    def test_files_are_written_as_convert_writes_them(self):
        for source, value, write, name in (
            ("cameras.json", self.cameras, kg.write_cameras, "krt"),
            ("cameras.json", self.cameras, kg.write_cameras, "longcw"),
            ("detections.jsonl", self.detections, kg.write_detections, "kinegraph"),
            ("truth.jsonl", self.truth, kg.write_tracks, "csv"),
        ):
            own = self.in_folder("own_" + name)
            self.assertIsInstance(write(own, value, format=name), list)
            self.assert_as_convert(source, own, "--to=" + name)
        own = self.in_folder("the_extension_chooses.csv")
        kg.write_tracks(own, self.truth)
        self.assert_as_convert("truth.jsonl", own)
        kind = kg.file_kind(self.in_take("detections.jsonl"))
        self.assertEqual(kind, "detections")
        with self.assertRaisesRegex(kg.InputError, "format: found 'bvh'"):
            kg.write_cameras("out.bvh", self.cameras, format="bvh")
        with self.assertRaisesRegex(kg.InputError, "format: found 'sleap'"):
            kg.write_detections("out", self.detections, format="sleap")

    def test_invalid_headers_and_frames_are_refused(self):
        frames = [[np.zeros((0, 17, 3))] * 2]
        for views, hz, first in (
            (["a", "a"], 25.0, 0),
            (["a", "b"], 1e300, 0),
            (["a", "b"], 25.0, 2**50 + 1),
            (["a", "b"], 1e6, 2**51),
        ):
            with self.assertRaises(kg.InputError, msg=(views, hz, first)):
                kg.Detections(frames, "coco17", views, hz, first)
        for cameras in (
            [self.cameras[0], self.cameras[0]],
            [kg.Camera("", np.eye(3), np.eye(3), np.zeros(3))],
        ):
            with self.assertRaises(kg.InputError):
                kg.write_cameras(self.in_folder("cameras.json"), cameras)

    def test_convert_gives_the_commands_bytes(self):
        zero = "detections.zero_confidence"
        for source, extension, options, flags in (
            ("truth.jsonl", ".csv", {"to": "csv"}, "--to=csv"),
            ("truth.jsonl", ".npz", {"to": "npz"}, "--to=npz"),
            ("truth.jsonl", ".c3d", {"to": "c3d"}, "--to=c3d"),
            ("truth.jsonl", ".txt", {"to": "4da"}, "--to=4da"),
            ("cameras.json", ".toml", {"to": "pose2sim"}, "--to=pose2sim"),
            ("detections.jsonl", ".jsonl", {"to": "kinegraph"}, "--to=kinegraph"),
            (
                "truth.jsonl",
                ".trc",
                {"person": 1, "markers": "opensim", "axes": "x,-z,y"},
                "--person=1 --markers=opensim --axes=x,-z,y",
            ),
            (
                "cameras.json",
                ".json",
                {"to": "voxelpose", "from_": "kinegraph"},
                "--to=voxelpose --from=kinegraph",
            ),
            (
                "detections.jsonl",
                ".json",
                {"to": "coco_views", "image_size": (640, 480), "set": {zero: "position"}},
                f"--to=coco_views --image_size=640,480 --set={zero}=position",
            ),
        ):
            own = self.in_folder("new/own" + extension)
            losses = kg.convert(self.in_take(source), own, **options)
            notes = self.assert_as_convert(source, own, *flags.split())
            self.assertEqual(notes, len(losses), flags)
        for error, source, options in (
            ("--to: 'docx' is not a format", "truth.jsonl", {"to": "docx"}),
            ("--to is missing", "truth.jsonl", {}),
            ("--axes applies to tracks", "cameras.json", {"to": "krt", "axes": "x,y,z"}),
        ):
            with self.assertRaisesRegex(kg.InputError, error):
                kg.convert(self.in_take(source), self.in_folder("out.docx"), **options)

    def test_paths_may_be_pathlib_and_names_not_utf8(self):
        folder = pathlib.Path(self.folder.name) / os.fsdecode(b"Ren\xe9")
        folder.mkdir()
        take = pathlib.Path(self.take)
        kg.write_cameras(
            folder / "c.json", kg.read_cameras(take / "cameras.json")
        )
        kg.write_tracks(folder / "t.csv", kg.read_tracks(take / "truth.jsonl"))
        kg.write_detections(
            folder / "d.jsonl", kg.read_detections(take / "detections.jsonl")
        )
        self.assertEqual(kg.file_kind(folder / "c.json"), "calibrations")
        self.assertEqual(kg.file_kind(folder / "d.jsonl"), "detections")
        self.assertEqual(kg.file_kind(folder / "t.csv"), "tracks")
        self.assertEqual(len(kg.read_cameras(folder / "c.json")), len(self.cameras))

    def test_arrays_give_the_same_as_files(self):
        own = kg.Detections(
            [self.views_of(k) for k in range(len(self.detections))],
            self.detections.skeleton.name,
            self.detections.views,
            self.detections.frame_rate_hz,
            first_frame=self.detections.frame_numbers()[0],
        )
        rig = [
            kg.Camera(
                c.name, c.K, c.R, c.t, c.distortion, c.model, c.image_size
            )
            for c in self.cameras
        ]
        self.assert_same(kg.track(rig, own, config=WINDOW), self.window())

    def test_session_gives_frames_as_they_become_final(self):
        session = kg.Session(
            self.cameras,
            self.detections.skeleton.name,
            self.detections.views,
            self.detections.frame_rate_hz,
            config=WINDOW,
        )
        positions = {}
        before_the_end = 0
        for k, number in enumerate(self.detections.frame_numbers()):
            done = session.process(number, self.views_of(k))
            before_the_end += len(done)
            positions.update(zip(done.frames, done.positions_m))
        rest = session.finish()
        positions.update(zip(rest.frames, rest.positions_m))
        self.assertGreater(before_the_end, len(self.detections) // 2)
        whole = self.window()
        self.assertEqual(sorted(positions), list(whole.frames))
        for number, expected in zip(whole.frames, whole.positions_m):
            # Tracks of a part have no column for people absent from it, so the
            # coordinates of all people are compared in sorted order.
            np.testing.assert_array_equal(
                np.sort(positions[number][np.isfinite(positions[number])]),
                np.sort(expected[np.isfinite(expected)]),
            )

    def test_arrays_of_tracks_have_documented_shapes(self):
        tracks = self.window()
        f, p, j = len(tracks), len(tracks.ids), len(tracks.skeleton.joints)
        self.assertEqual(tracks.positions_m.shape, (f, p, j, 3))
        self.assertEqual(tracks.covariance_m2.shape, (f, p, j, 3, 3))
        missing = tracks.status == kg.MISSING
        self.assertTrue(np.isnan(tracks.positions_m[missing]).all())
        self.assertTrue(np.isfinite(tracks.positions_m[~missing]).all())
        self.assertEqual(tracks.times_s[1] - tracks.times_s[0], 0.04)

    def test_strategies_smooth_the_frozen_matches(self):
        frozen = kg.Frozen(self.cameras, self.detections, config=WINDOW)
        for strategy in ("raw_dlt", "butterworth", "rts"):
            tracks = frozen.smooth(strategy)
            scores = kg.evaluate(tracks, self.truth)
            # Noise of a few pixels at a distance of metres gives centimetres.
            self.assertLess(scores["mpjpe_m"], 0.1, strategy)
        with self.assertRaisesRegex(kg.InputError, "strategy: found 'kalmann'"):
            frozen.smooth("kalmann")

    def test_evaluate_scores_the_truth_as_perfect(self):
        tracks = self.window()
        perfect = kg.evaluate(self.truth, self.truth)
        self.assertEqual(perfect["mpjpe_m"], 0.0)
        self.assertGreater(kg.evaluate(tracks, self.truth)["mpjpe_m"], 0.0)
        self.assertEqual(
            kg.evaluate(self.truth, self.truth, "identity")["idf1"], 1.0
        )
        with self.assertRaisesRegex(kg.InputError, "protocol: found 'pcp'"):
            kg.evaluate(tracks, self.truth, "pcp")

    def retimed(self, name, **changes):
        """The truth with changed frame numbers, times and axes, from a new file."""
        with open(self.in_take("truth.jsonl")) as lines:
            header, *frames = map(json.loads, lines)
        header["frame_rate"] *= changes.get("rate", 1)
        path = self.in_folder(name)
        with open(path, "w") as out:
            print(json.dumps(header), file=out)
            for k, frame in enumerate(frames):
                if k % changes.get("every", 1):
                    continue
                frame["frame"] = k // changes.get("every", 1)
                frame["time"] += changes.get("late_s", 0.0)
                for person in frame["people"]:
                    person["joints"] = [
                        p and [p[i] for i in changes.get("axes", (0, 1, 2))]
                        for p in person["joints"]
                    ]
                print(json.dumps(frame), file=out)
        return kg.read_tracks(path)

    def test_evaluate_pairs_by_time_and_warns(self):
        half = self.retimed("half.jsonl", every=2, rate=0.5)
        for tracks, truth in ((half, self.truth), (self.truth, half)):
            for protocol, key, right in (
                ("mpjpe", "mpjpe_m", 0.0),
                ("identity", "idf1", 1.0),
            ):
                with self.assertWarnsRegex(UserWarning, "paired by time"):
                    scores = kg.evaluate(tracks, truth, protocol)
                self.assertEqual(scores[key], right)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            self.assertEqual(kg.evaluate(self.truth, self.truth)["found"], 1.0)
        late = self.retimed("late.jsonl", every=2, rate=0.5, late_s=0.007)
        with self.assertRaisesRegex(kg.InputError, "Hz.*Hz.*not interpolated"):
            kg.evaluate(self.truth, late)

    def test_evaluate_compares_identities_by_centroids(self):
        path = self.in_folder("centroids.jsonl")
        skeleton = {"name": "c", "joints": ["centroid"], "bones": []}
        with open(self.in_take("truth.jsonl")) as lines, open(path, "w") as out:
            header, *frames = map(json.loads, lines)
            names = header["skeleton"]["joints"]
            hips = [names.index("l_hip"), names.index("r_hip")]
            print(json.dumps({**header, "skeleton": skeleton}), file=out)
            for frame in frames:
                for k, person in enumerate(frame["people"]):
                    middle = np.mean([person["joints"][h] for h in hips], 0)
                    frame["people"][k] = {
                        "id": person["id"],
                        "joints": [middle.tolist()],
                        "status": ["observed"],
                    }
                print(json.dumps(frame), file=out)
        centroids = kg.read_tracks(path)
        with self.assertWarnsRegex(UserWarning, "middle of the hips"):
            scores = kg.evaluate(self.truth, centroids, "identity")
        self.assertEqual(scores["idf1"], 1.0)
        with self.assertRaisesRegex(kg.InputError, "no joint in common"):
            kg.evaluate(self.truth, centroids)

    def test_evaluate_names_the_axes_of_a_rotated_truth(self):
        turned = self.retimed("turned.jsonl", axes=(1, 2, 0))
        for protocol in ("mpjpe", "identity"):
            with self.assertRaisesRegex(kg.InputError, "X, Y, Z as y,z,x"):
                kg.evaluate(self.truth, turned, protocol)

    def test_values_are_pickled_and_copied_to_the_last_bit(self):
        tracks = self.window(set={"output.observations": True})
        values = {
            "tracks": tracks,
            "truth": self.truth,
            "detections": self.detections,
            "skeleton": tracks.skeleton,
            "kinematics": kg.kinematics(tracks),
            "nothing": self.window(frames=[(0, 1)]),
        }
        for again in (
            lambda value: pickle.loads(pickle.dumps(value)),
            copy.deepcopy,
            copy.copy,
        ):
            for name, value in values.items():
                with self.subTest(name):
                    # Equal bytes of everything that a value holds.
                    self.assertEqual(
                        pickle.dumps(again(value)), pickle.dumps(value)
                    )
            same = again(tracks)
            np.testing.assert_array_equal(same.positions_m, tracks.positions_m)
            np.testing.assert_array_equal(
                same.covariance_m2, tracks.covariance_m2
            )
            paths = [self.in_folder(n) for n in ("one.jsonl", "two.jsonl")]
            for path, one in zip(paths, (tracks, same)):
                kg.write_tracks(path, one)
            self.assertEqual(*(pathlib.Path(p).read_bytes() for p in paths))
            for given in self.cameras:
                camera = again(given)
                self.assertEqual(camera.name, given.name)
                self.assertEqual(camera.model, given.model)
                self.assertEqual(camera.image_size, given.image_size)
                self.assertEqual(camera.distortion, given.distortion)
                for part in ("K", "R", "t"):
                    np.testing.assert_array_equal(
                        getattr(camera, part), getattr(given, part)
                    )
        with self.assertRaisesRegex(RuntimeError, "ends too early"):
            type(tracks).__setstate__(
                type(tracks).__new__(type(tracks)),
                tracks.__getstate__()[:-3],
            )

    def test_project_gives_nan_where_a_point_has_no_image(self):
        given = self.cameras[0]
        camera = kg.Camera("ideal", given.K, given.R, given.t)
        point = np.array([[0.1, -0.2, 1.0], camera.centre])
        px = camera.project(point)
        x = camera.K @ (camera.R @ point[0] + camera.t)
        np.testing.assert_allclose(px[0], x[:2] / x[2], rtol=0, atol=1e-9)
        self.assertTrue(np.isnan(px[1]).all())

    def test_settings_may_be_numpy_values_and_tuples(self):
        settings = {
            "a": np.bool_(True),
            "b": np.float64(0.2),
            "c": (1280, 720),
            "d": np.array([1.5, 2.0]),
            "e": ["cam0", "cam1"],
            "f": "shift",
        }
        self.assertEqual(
            kg._assignments(settings),
            "a=true;b=0.2;c=[1280, 720];d=[1.5, 2.0];e=['cam0', 'cam1'];f=shift",
        )

    def test_errors_name_the_file_or_key(self):
        with self.assertRaisesRegex(kg.InputError, "nowhere.json"):
            kg.read_cameras("nowhere.json")
        with self.assertRaisesRegex(kg.InputError, "graph.lagg"):
            kg.track(self.cameras, self.detections, set={"graph.lagg": 1.0})
        with self.assertRaisesRegex(kg.InputError, r"\(people, 17, 3\)"):
            kg.Detections([[np.zeros((1, 5, 3))]], "coco17", ["cam0"], 25.0)
        with self.assertRaisesRegex(ValueError, "begin < end"):
            kg.track(self.cameras, self.detections, frames=[(5, 5)])
        with self.assertRaisesRegex(kg.InputError, "after the previous range"):
            kg.track(self.cameras, self.detections, frames=[(50, 60), (0, 9)])

    def test_other_threads_run_and_progress_is_reported(self):
        ticks = []
        seen = []
        stop = threading.Event()

        def tick():
            while not stop.wait(0.001):
                ticks.append(1)

        thread = threading.Thread(target=tick)
        thread.start()
        self.window(progress=lambda read, total: seen.append((read, total)))
        stop.set()
        thread.join()
        self.assertGreater(len(ticks), 0)
        self.assertEqual(seen[-1], (len(self.detections),) * 2)

    def test_ctrl_c_stops_a_run(self):
        script = (
            "import signal, sys, kinegraph as kg\n"
            # A process started in the background inherits an ignored SIGINT.
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "cameras = kg.read_cameras(sys.argv[1] + '/cameras.json')\n"
            "take = kg.read_detections(sys.argv[1] + '/detections.jsonl')\n"
            "print('go', flush=True)\n"
            "try:\n"
            "    while True: kg.track(cameras, take)\n"
            "except KeyboardInterrupt:\n"
            "    sys.exit(42)\n"
        )
        child = subprocess.Popen(
            [sys.executable, "-c", script, self.take], stdout=subprocess.PIPE
        )
        self.addCleanup(child.stdout.close)
        child.stdout.readline()
        time.sleep(0.2)
        child.send_signal(signal.SIGINT)
        try:
            self.assertEqual(child.wait(timeout=60), 42)
        finally:
            child.kill()

    def test_ctrl_c_stops_the_solves_of_the_batch(self):
        # The recording twelve times, so that the solves take a measurable time.
        script = (
            "import os, signal, sys, threading, time, kinegraph as kg\n"
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "cameras = kg.read_cameras(sys.argv[1] + '/cameras.json')\n"
            "take = kg.read_detections(sys.argv[1] + '/detections.jsonl')\n"
            "views = range(len(take.views))\n"
            "one = [[take.view(k, v) for v in views] for k in range(len(take))]\n"
            "long = kg.Detections(one * 12, 'coco17', take.views, 25.0)\n"
            "read = []\n"
            "def progress(done, of):\n"
            "    if done == of and not read:\n"
            "        read.append(time.monotonic())\n"
            "        if sys.argv[2] == 'stop':\n"
            "            stop = lambda: os.kill(os.getpid(), signal.SIGINT)\n"
            "            threading.Timer(0.1, stop).start()\n"
            "try:\n"
            "    kg.track(cameras, long, sys.argv[3], progress=progress)\n"
            "    code = 0\n"
            "except KeyboardInterrupt:\n"
            "    code = 42\n"
            "print(time.monotonic() - read[0])\n"
            "sys.exit(code)\n"
        )
        seconds = {}
        for how, code in (("go", 0), ("stop", 42)):
            done = subprocess.run(
                [sys.executable, "-c", script, self.take, how, BATCH],
                stdout=subprocess.PIPE,
                timeout=300,
            )
            self.assertEqual(done.returncode, code)
            seconds[how] = float(done.stdout)
        # Without polling for the signal all solves would finish first. Other
        # programs share the processor, so only a ratio of times is asserted.
        self.assertLess(seconds["stop"], 0.8 * seconds["go"])

    def test_everything_public_is_documented_and_has_a_stub(self):
        with open(
            os.path.join(os.path.dirname(kg.__file__), "_kinegraph.pyi"),
            encoding="utf-8",
        ) as file:
            stub = ast.parse(file.read())
        stubs = {
            node.name: node
            for node in stub.body
            if isinstance(node, (ast.ClassDef, ast.FunctionDef))
        }
        native = {
            name: value
            for name, value in vars(_kinegraph).items()
            if inspect.isclass(value) or inspect.isroutine(value)
        }
        self.assertEqual(sorted(stubs), sorted(native))
        for name, value in native.items():
            if not inspect.isclass(value) or issubclass(value, Exception):
                continue
            members = {
                member
                for member in vars(value)
                if not member.startswith("_")
                or member in ("__len__", "__getitem__")
            }
            stubbed = {
                node.name
                for node in stubs[name].body
                if isinstance(node, ast.FunctionDef) and node.name != "__init__"
            }
            self.assertEqual(stubbed, members, name)
            for member in members:
                self.assertTrue(
                    inspect.getdoc(getattr(value, member)), f"{name}.{member}"
                )
        for name in kg.__all__:
            if name.isupper():
                continue
            text = inspect.getdoc(getattr(kg, name))
            self.assertTrue(text, name)

    def test_an_exception_in_progress_stops_the_run(self):
        def refuse(read, total):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            kg.track(self.cameras, self.detections, progress=refuse)


if __name__ == "__main__":
    unittest.main()
