"""The module against the commands: the same bits; bad input: the same line."""

import ast
import csv
import inspect
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import kinegraph as kg
import numpy as np
from kinegraph import _kinegraph

APPS = os.environ["KINEGRAPH_APPS"]
SOURCE = os.environ["KINEGRAPH_SOURCE"]
DEMO = os.path.join(SOURCE, "configs", "synthetic", "demo.toml")
WINDOW = os.path.join(SOURCE, "configs", "synthetic", "track_window.toml")
BATCH = os.path.join(SOURCE, "configs", "synthetic", "track_batch.toml")


def run(command, *flags):
    return subprocess.run(
        [os.path.join(APPS, "kinegraph-" + command), *flags],
        check=True,
        capture_output=True,
        text=True,
    )


class Module(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.take = os.path.join(cls.folder.name, "take")
        run(
            "synthesize",
            "--config=" + DEMO,
            "--set=scene.duration=4;scene.people=3",
            "--out=" + cls.take,
        )
        cls.cameras = kg.read_cameras(os.path.join(cls.take, "cameras.json"))
        cls.detections = kg.read_detections(
            os.path.join(cls.take, "detections.jsonl")
        )
        cls.truth = kg.read_tracks(os.path.join(cls.take, "truth.jsonl"))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def by_command(self, config=None, *flags):
        out = os.path.join(self.folder.name, "tracks.jsonl")
        if not any(flag.startswith("--cameras=") for flag in flags):
            flags += ("--cameras=" + os.path.join(self.take, "cameras.json"),)
        run(
            "track",
            "--detections=" + os.path.join(self.take, "detections.jsonl"),
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

    def test_so_it_does_without_a_configuration_and_with_the_modules_own(self):
        self.assert_same(
            kg.track(self.cameras, self.detections), self.by_command()
        )
        # A second pass, and who is who over the whole take.
        offline = kg.track(
            self.cameras, self.detections, config="offline.toml", threads=2
        )
        self.assert_same(offline, self.by_command("configs/offline.toml"))
        self.assertEqual(kg.config_path("nowhere.toml"), "nowhere.toml")
        self.assertEqual(kg.config_path(DEMO), DEMO)

    def test_cameras_are_refined_as_the_command_refines_them(self):
        # A principal point that is 12 px off is found.
        path = os.path.join(self.take, "shifted.json")
        with open(os.path.join(self.take, "cameras.json")) as file:
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
        tracks = kg.track(self.cameras, self.detections, config=WINDOW)
        path = os.path.join(self.folder.name, "own.jsonl")
        out = os.path.join(self.folder.name, "angles.csv")
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

    def test_files_are_written_as_convert_writes_them(self):
        for kind, value, write, formats in (
            ("cameras.json", self.cameras, kg.write_cameras, ("krt", "longcw")),
            (
                "detections.jsonl",
                self.detections,
                kg.write_detections,
                ("kinegraph",),
            ),
        ):
            for name in formats:
                own = os.path.join(self.folder.name, "own_" + name)
                out = os.path.join(self.folder.name, "convert_" + name)
                losses = write(own, value, format=name)
                self.assertIsInstance(losses, list)
                run(
                    "convert",
                    "--to=" + name,
                    "--in=" + os.path.join(self.take, kind),
                    "--out=" + out,
                )
                self.assert_same_bytes(own, out)
        self.assertEqual(
            kg.file_kind(os.path.join(self.take, "detections.jsonl")),
            "detections",
        )
        with self.assertRaisesRegex(kg.InputError, "format: found 'bvh'"):
            kg.write_cameras("out.bvh", self.cameras, format="bvh")
        with self.assertRaisesRegex(kg.InputError, "format: found 'smap'"):
            kg.write_detections("out", self.detections, format="smap")

    def assert_same_bytes(self, own, other):
        with open(own, "rb") as a, open(other, "rb") as b:
            self.assertEqual(a.read(), b.read(), own)

    def test_convert_gives_the_commands_bytes(self):
        truth = os.path.join(self.take, "truth.jsonl")
        for source, name, extension in (
            ("truth.jsonl", "csv", ".csv"),
            ("truth.jsonl", "npz", ".npz"),
            ("truth.jsonl", "c3d", ".c3d"),
            ("truth.jsonl", "poses", ".json"),
            ("cameras.json", "pose2sim", ".toml"),
            ("detections.jsonl", "kinegraph", ".jsonl"),
        ):
            given = os.path.join(self.take, source)
            own = os.path.join(self.folder.name, "own_" + name + extension)
            out = os.path.join(self.folder.name, "command_" + name + extension)
            losses = kg.convert(given, own, name)
            told = run(
                "convert", "--to=" + name, "--in=" + given, "--out=" + out
            ).stderr
            self.assertEqual(told.count("note: "), len(losses), told)
            self.assert_same_bytes(own, out)
        # The extension chooses.
        by_name = os.path.join(self.folder.name, "by_name.csv")
        kg.write_tracks(by_name, kg.read_tracks(truth))
        self.assert_same_bytes(
            by_name, os.path.join(self.folder.name, "own_csv.csv")
        )
        with self.assertRaisesRegex(kg.InputError, "--to: 'docx' is no format"):
            kg.convert(truth, "out.docx", "docx")
        with self.assertRaisesRegex(kg.InputError, "--to is missing"):
            kg.convert(truth, "out.docx")

    def test_paths_may_be_pathlibs_and_names_no_utf8(self):
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

    def test_convert_takes_the_commands_options(self):
        for source, extension, own_options, flags in (
            (
                "truth.jsonl",
                ".trc",
                {"person": 1, "markers": "opensim", "axes": "x,-z,y"},
                ["--person=1", "--markers=opensim", "--axes=x,-z,y"],
            ),
            (
                "cameras.json",
                ".json",
                {"to": "voxelpose", "from_": "kinegraph"},
                ["--to=voxelpose", "--from=kinegraph"],
            ),
            (
                "detections.jsonl",
                ".json",
                {
                    "to": "coco_views",
                    "image_size": (640, 480),
                    "set": {"detections.zero_confidence": "position"},
                },
                [
                    "--to=coco_views",
                    "--image_size=640,480",
                    "--set=detections.zero_confidence=position",
                ],
            ),
        ):
            given = os.path.join(self.take, source)
            own = os.path.join(self.folder.name, "new", "own" + extension)
            out = os.path.join(self.folder.name, "new", "command" + extension)
            kg.convert(given, own, **own_options)
            run("convert", "--in=" + given, "--out=" + out, *flags)
            if extension != ".trc":  # which names itself
                self.assert_same_bytes(own, out)
                continue
            with open(own, encoding="utf-8") as a:
                with open(out, encoding="utf-8") as b:
                    self.assertEqual(
                        a.read().replace("own.trc", "command.trc"), b.read()
                    )
        with self.assertRaisesRegex(kg.InputError, "--axes belongs to tracks"):
            kg.convert(
                os.path.join(self.take, "cameras.json"),
                os.path.join(self.folder.name, "no.json"),
                to="krt",
                axes="x,y,z",
            )

    def test_arrays_in_give_what_files_give(self):
        frames = [
            [self.detections.view(k, v) for v in range(len(self.cameras))]
            for k in range(len(self.detections))
        ]
        own = kg.Detections(
            frames,
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
        self.assert_same(
            kg.track(rig, own, config=WINDOW),
            kg.track(self.cameras, self.detections, config=WINDOW),
        )

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
            views = [
                self.detections.view(k, v) for v in range(len(self.cameras))
            ]
            done = session.process(number, views)
            before_the_end += len(done)
            positions.update(zip(done.frames, done.positions_m))
        rest = session.finish()
        positions.update(zip(rest.frames, rest.positions_m))
        self.assertGreater(before_the_end, len(self.detections) // 2)
        whole = kg.track(self.cameras, self.detections, config=WINDOW)
        self.assertEqual(sorted(positions), list(whole.frames))
        for number, expected in zip(whole.frames, whole.positions_m):
            # People absent from a part have no column there.
            np.testing.assert_array_equal(
                np.sort(positions[number][np.isfinite(positions[number])]),
                np.sort(expected[np.isfinite(expected)]),
            )

    def test_shapes_and_meaning(self):
        tracks = kg.track(self.cameras, self.detections, config=WINDOW)
        f, p, j = len(tracks), len(tracks.ids), len(tracks.skeleton.joints)
        self.assertEqual(tracks.positions_m.shape, (f, p, j, 3))
        self.assertEqual(tracks.covariance_m2.shape, (f, p, j, 3, 3))
        missing = tracks.status == kg.MISSING
        self.assertTrue(np.isnan(tracks.positions_m[missing]).all())
        self.assertTrue(np.isfinite(tracks.positions_m[~missing]).all())
        self.assertEqual(tracks.times_s[1] - tracks.times_s[0], 0.04)

    def test_every_strategy_smooths_the_frozen_matches(self):
        frozen = kg.Frozen(self.cameras, self.detections, config=WINDOW)
        for strategy in ("raw_dlt", "butterworth", "rts"):
            tracks = frozen.smooth(strategy)
            scores = kg.evaluate(tracks, self.truth)
            # The scene's noise is a few pixels at metres: centimetres.
            self.assertLess(scores["mpjpe_m"], 0.1, strategy)
        with self.assertRaisesRegex(kg.InputError, "strategy: found 'kalmann'"):
            frozen.smooth("kalmann")

    def test_evaluate(self):
        tracks = kg.track(self.cameras, self.detections, config=WINDOW)
        perfect = kg.evaluate(self.truth, self.truth)
        self.assertEqual(perfect["mpjpe_m"], 0.0)
        self.assertGreater(kg.evaluate(tracks, self.truth)["mpjpe_m"], 0.0)
        self.assertEqual(
            kg.evaluate(self.truth, self.truth, "identity")["idf1"], 1.0
        )
        with self.assertRaisesRegex(kg.InputError, "protocol: found 'pcp'"):
            kg.evaluate(tracks, self.truth, "pcp")

    def test_project(self):
        given = self.cameras[0]
        camera = kg.Camera("ideal", given.K, given.R, given.t)
        point = np.array([[0.1, -0.2, 1.0], camera.centre])
        px = camera.project(point)
        x = camera.K @ (camera.R @ point[0] + camera.t)
        np.testing.assert_allclose(px[0], x[:2] / x[2], rtol=0, atol=1e-9)
        self.assertTrue(np.isnan(px[1]).all())

    def test_bad_input_is_one_line(self):
        with self.assertRaisesRegex(kg.InputError, "nowhere.json"):
            kg.read_cameras("nowhere.json")
        with self.assertRaisesRegex(kg.InputError, "graph.lagg"):
            kg.track(self.cameras, self.detections, set={"graph.lagg": 1.0})
        with self.assertRaisesRegex(kg.InputError, r"\(people, 17, 3\)"):
            kg.Detections([[np.zeros((1, 5, 3))]], "coco17", ["cam0"], 25.0)
        with self.assertRaisesRegex(ValueError, "begin < end"):
            kg.track(self.cameras, self.detections, frames=[(5, 5)])

    def test_other_threads_run_and_progress_is_told(self):
        ticks = []
        seen = []
        stop = threading.Event()

        def tick():
            while not stop.wait(0.001):
                ticks.append(1)

        thread = threading.Thread(target=tick)
        thread.start()
        kg.track(
            self.cameras,
            self.detections,
            config=WINDOW,
            progress=lambda read, total: seen.append((read, total)),
        )
        stop.set()
        thread.join()
        self.assertGreater(len(ticks), 0)
        self.assertEqual(seen[-1], (len(self.detections),) * 2)

    def test_ctrl_c_stops_a_run(self):
        script = (
            "import signal, sys, kinegraph as kg\n"
            # Who is started in the background inherits that it is ignored.
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

    def test_ctrl_c_stops_the_batchs_solves(self):
        # A take that is long enough for its solves to last.
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
        # Without the question the whole rest would be solved first. Processor
        # time is shared: only the order is asserted.
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
