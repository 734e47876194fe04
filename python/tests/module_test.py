"""The module against the commands: the same bits; bad input: the same line."""

import os
import subprocess
import tempfile
import threading
import unittest

import kinegraph as kg
import numpy as np

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

    def by_command(self, config):
        out = os.path.join(self.folder.name, "tracks.jsonl")
        run(
            "track",
            "--cameras=" + os.path.join(self.take, "cameras.json"),
            "--detections=" + os.path.join(self.take, "detections.jsonl"),
            "--config=" + config,
            "--out=" + out,
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

    def test_an_exception_in_progress_stops_the_run(self):
        def refuse(read, total):
            raise KeyboardInterrupt

        with self.assertRaises(KeyboardInterrupt):
            kg.track(self.cameras, self.detections, progress=refuse)


if __name__ == "__main__":
    unittest.main()
