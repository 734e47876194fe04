#!/usr/bin/env python3
"""The adapters: unusual and rejected inputs, messages, and a user's own reader.

Needs KINEGRAPH_APPS (build/apps) and KINEGRAPH_SOURCE; without h5py, pandas or SciPy
it prints SKIPPED.
"""

import io
import json
import os
import pathlib
import pickle
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

APPS = pathlib.Path(os.environ["KINEGRAPH_APPS"])
SOURCE = pathlib.Path(os.environ["KINEGRAPH_SOURCE"])
ADAPTERS = SOURCE / "python" / "kinegraph" / "adapters"
sys.path[:0] = [str(ADAPTERS), str(SOURCE / "tests" / "adapters")]
sys.dont_write_bytecode = True

try:
    import h5py
    import numpy as np
    import samples
except ImportError as error:
    print(f"SKIPPED: needs {error.name}")
    sys.exit(0)

import arrays
import common
import pickles


def text(data):
    return b"X" + struct.pack("<I", len(data)) + data


class Adapters(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def run_adapter(self, *arguments, **settings):
        return subprocess.run(
            [APPS / "kinegraph-adapters", *map(str, arguments)],
            capture_output=True, env=dict(os.environ, **settings), timeout=120,
        )  # fmt: skip

    def refused(self, *arguments, code=2, **settings):
        """Runs the adapter, which must fail with one line; returns this line."""
        done = self.run_adapter(*arguments, **settings)
        said = done.stderr.decode()
        self.assertEqual(done.returncode, code, said)
        self.assertEqual(said.count("\n"), 1, said)
        return said

    def lines(self, *arguments, **settings):
        done = self.run_adapter(*arguments, **settings)
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        return [json.loads(line) for line in done.stdout.splitlines()]

    def convert(self, *arguments, **settings):
        return subprocess.run(
            [APPS / "kinegraph-convert", *map(str, arguments)], text=True,
            capture_output=True, env=dict(os.environ, **settings), timeout=120,
        )  # fmt: skip


class Text(unittest.TestCase):
    def test_numbers_read_back_bit_for_bit(self):
        random = np.random.default_rng(1)
        people = np.concatenate(
            [
                np.stack([random.uniform(16, 9999, (300, 5)),
                          random.uniform(16, 40, (300, 5)),
                          random.uniform(0, 1, (300, 5))], axis=2),
                # Powers of two, whole numbers, floats, and unusual values.
                np.stack([2.0 ** random.integers(-3, 16, (300, 5)),
                          np.float32(random.uniform(-5, 5000, (300, 5))),
                          random.choice([0, 1e-9, 0.5, 1, 1.5, 70], (300, 5))], axis=2),
            ]
        )  # fmt: skip
        people[random.uniform(size=people.shape[:2]) < 0.2] = np.nan
        for person, line in zip(people, arrays._people(people)):
            found = json.loads(line)["joints"]
            expected = [p if p[0] == p[0] else None for p in person.tolist()]
            self.assertEqual(found, expected)


class Pickles(unittest.TestCase):
    def refused(self, content):
        with self.assertRaises(common.Refusal) as caught:
            pickles.load(content, "f")
        return str(caught.exception)

    def test_values_and_arrays(self):
        values = {"a": [1, -2, 2.5, None, True, ("x",)], "big": -129,
                  "columns": np.asfortranarray(np.arange(6, dtype="f4").reshape(2, 3)),
                  "share": np.float64(0.5), "big_endian": np.arange(3, dtype=">i4")}  # fmt: skip
        for protocol in range(2, 6):
            found = pickles.load(pickle.dumps(values, protocol), "f")
            for key in ("a", "big", "share"):
                self.assertEqual(found[key], values[key])
            for key in ("columns", "big_endian"):
                self.assertEqual(found[key].value.tolist(), values[key].tolist())

    def test_nothing_is_executed(self):
        marker = pathlib.Path(tempfile.gettempdir()) / f"executed_{os.getpid()}"

        class Attack:
            def __reduce__(self):
                return os.system, (f"touch {marker}",)

        for protocol in range(6):
            self.assertIn("system", self.refused(pickle.dumps(Attack(), protocol)))
        two = b"\x80\x02"
        for content, said in (
            (two + b"c__builtin__\neval\nU\x011\x85R.", "eval"),
            (b"\x80\x04\x8c\x05posix\x8c\x06system\x93\x8c\x02ls\x85R.", "'posix.system'"),
            (two + b"cos\nsystem\n)\x81.", "'os.system'"),
            (two + b"\x82\x01.", ""),  # an extension
            (two + b"Pname\n.", "outside of the file"),
            (two + b"}}\x85b.", ""),
            (two + b"c_codecs\nencode\n" + text(b"a") + text(b"zlib") + b"\x86R.", "latin1"),
            (two + b"cnumpy.core.numeric\n_frombuffer\n(U\x01acnumpy\ndtype\nU\x02O8\x85R"
             b"K\x01\x85U\x01CtR.", "numbers"),
        ):  # fmt: skip
            self.assertIn(said, self.refused(content))
        self.assertFalse(marker.exists())

    def test_broken_pickles_give_a_message(self):
        whole = pickle.dumps(samples.opencap_camera(), 2)
        for length in range(len(whole)):
            self.assertNotEqual(self.refused(whole[:length]), "")
        for at in range(0, len(whole), 3):
            try:
                pickles.load(whole[:at] + bytes([whole[at] ^ 0xFF]) + whole[at + 1 :], "f")
            except common.Refusal:
                pass


class Files(Adapters):
    def memory_of(self, path):
        """Peak memory [kB] of the adapter when it refuses a file."""
        script = (
            "import resource, subprocess, sys\n"
            "done = subprocess.run(sys.argv[1:], capture_output=True)\n"
            "assert done.returncode == 2, done\n"
            "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)\n"
        )
        done = subprocess.run(
            [sys.executable, "-c", script, APPS / "kinegraph-adapters", path],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        return int(done.stdout)

    def test_pickles_that_grow_are_refused_in_little_memory(self):
        # A text that is stored once and referenced often; many arrays of the same
        # bytes; a huge index into the memo.
        n, m = 900_000, 150_000
        text_often = b"\x80\x04(" + text(b"a" * n) + b"q\0" + b"h\0" * 1000 + b"l."
        array = (
            b"\x80\x04cnumpy.core.numeric\n_frombuffer\nq\x000B" + struct.pack("<I", m)
            + b"a" * m + b"q\x010cnumpy\ndtype\n" + text(b"u1") + b"\x85Rq\x020J"
            + struct.pack("<I", m) + b"\x85q\x030" + text(b"C") + b"q\x040"
            + b"h\0(h\1h\2h\3h\4tR0" * 1000 + b"N."
        )  # fmt: skip
        memo = b"\x80\x04]r\xff\xff\xff\x7f."
        for content in (text_often, array, memo):
            path = self.folder / "cameraIntrinsicsExtrinsics.pickle"
            path.write_bytes(content)
            self.refused(path)
            self.assertLess(self.memory_of(path), 100_000)

    def test_hdf5_with_declared_sizes_beyond_the_file_is_refused(self):
        def write(name, **sets):
            path = self.folder / name
            with h5py.File(path, "w") as file:
                file["node_names"] = np.array([b"n%d" % i for i in range(17)])
                for key, (shape, options) in sets.items():
                    file.create_dataset(key, shape=shape, dtype="f8", **options)
            return path

        empty = write("a.h5", tracks=((100_000_000, 1, 17, 2), {}))
        self.assertIn("tracks: has 3400000000 entries, but only 0", self.refused(empty))
        chunks = dict(chunks=(1, 1, 1, 1 << 20), compression="gzip")
        packed = write("b.h5", tracks=((1, 2, 17, 1 << 20), chunks))
        with h5py.File(packed, "a") as file:
            file["tracks"][0, 0, 0] = 1.0
        self.assertIn("too few for a recording", self.refused(packed))
        outside = write("c.h5")
        (self.folder / "numbers").write_bytes(bytes(1000))
        with h5py.File(outside, "a") as file:
            file.create_dataset("tracks", (1, 2, 17, 3), "f8",
                                external=[(self.folder / "numbers", 0, 816)])  # fmt: skip
        self.assertIn("is not a data set in this file", self.refused(outside))

    def test_caliscope_is_read_without_tomllib(self):
        python = self.folder / "python"
        python.mkdir()
        (python / "tomllib.py").write_text("raise ModuleNotFoundError(name=__name__)\n")
        settings = {"PYTHONPATH": str(python)}
        poses = self.folder / "s/recordings/walk/POSE"
        poses.mkdir(parents=True)
        table = poses / "xy_POSE.csv"
        table.write_text(
            "sync_index,port,frame_index,frame_time,point_id,img_loc_x,img_loc_y\n"
            "6,0,5,1000.0,0,100,200\n6,1,6,1000.0,0,300,400\n7,0,6,1000.1,0,101,201\n"
        )
        alone = self.lines("--format=caliscope", table, **settings)
        self.assertEqual(alone[0]["views"], ["cam_0", "cam_1"])
        (self.folder / "s/camera_array.toml").write_text("")
        (python / "tomli.py").write_text(
            "def loads(text):\n"
            "    return {'cameras': {'0': {'ignore': True}, '1': {'rotation': []}}}\n"
        )
        session = self.lines("--format=caliscope", self.folder / "s", **settings)
        self.assertEqual(session[0]["views"], ["cam_1"])
        table.rename(poses / "xy.csv")
        again = self.lines("--format=caliscope", self.folder / "s", **settings)
        self.assertEqual(again[0]["views"], ["cam_1"])

    def test_sleap_errors_name_the_fault(self):
        samples.write_sleap(self.folder / "a.h5", 0, own_order=False)
        path = self.folder / "a.h5"
        with h5py.File(path, "a") as file:
            file["edge_inds"][0, 1] = 127777777777
        self.assertIn("edge_inds: found 127777777777, expected 0 .. 2", self.refused(path))
        with h5py.File(path, "a") as file:
            file["tracks"].attrs["dims"] = '["frame", "track", "node", "node"]'
        self.assertIn("each of frame, track, node and xy once", self.refused(path))
        whole = path.read_bytes()
        cut = self.folder / "cut.h5"
        for length in range(100, len(whole), len(whole) // 5):
            cut.write_bytes(whole[:length])
            self.assertIn("cut.h5", self.refused("--format=sleap", cut))

    def test_sleap_edges_become_bones(self):
        path = self.folder / "a.h5"
        samples.write_sleap(path, 0, own_order=True)
        for edges, expected in (([[2, 0], [0, 1]], [[2, 0], [0, 1]]),
                                ([[2, 0, 1], [0, 1, 2]], [[2, 0], [0, 1], [1, 2]])):  # fmt: skip
            with h5py.File(path, "a") as file:
                del file["edge_inds"]
                file["edge_inds"] = np.array(edges)
            self.assertEqual(self.lines(path)[0]["skeleton"]["bones"], expected)

    def test_sleap_frames_begin_at_the_first_frame(self):
        path = self.folder / "a.h5"
        samples.write_sleap(path, 0, own_order=True)
        frames = [line["frame"] for line in self.lines("--first_frame=100", path)[1:]]
        self.assertEqual(frames, list(range(100, 100 + samples.FRAMES)))

    def test_sleap_instances_corrected_by_hand_have_confidence_one(self):
        path = self.folder / "a.h5"
        samples.write_sleap(path, 0, own_order=False)
        before = self.lines(path)
        with h5py.File(path, "a") as file:
            file["point_scores"][2, 0] = np.nan
        after = self.lines(path)
        person = after[1 + 2]["views"]["a"][0]["joints"]
        was = before[1 + 2]["views"]["a"][0]["joints"]
        self.assertEqual(person, [[x, y, 1] for x, y, _ in was])
        self.assertEqual(after[:3] + after[4:], before[:3] + before[4:])

    def test_acinoset_scene_is_read_and_errors_name_the_camera(self):
        camera = {
            "k": [[1200, 0, 640], [0, 1201, 360], [0, 0, 1]],
            "d": [[0.04], [0.05], [-0.04], [0.01]],
            "r": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
            "t": [[0.5], [-1.5], [2]],
        }
        scene = {"camera_resolution": [1280, 720], "cameras": [camera, camera]}
        path = self.folder / "2_cam_scene.json"
        path.write_text(json.dumps(scene))
        read = json.loads(self.run_adapter(path).stdout)["cameras"]
        self.assertEqual([one["name"] for one in read], ["cam1", "cam2"])
        self.assertEqual(read[0]["distortion"], [0.04, 0.05, -0.04, 0.01])
        self.assertEqual(read[1]["cam_from_world"], {"R": camera["r"], "t": [0.5, -1.5, 2]})
        for key, bad in (("k", [[1]]), ("d", [1, 2]), ("t", [[1], [2], ["3"]]), ("r", None)):
            broken = dict(scene, cameras=[camera, dict(camera, **{key: bad})])
            path.write_text(json.dumps(broken))
            self.assertIn(f"camera 1: {key}: expected", self.refused(path))
        path.write_text(json.dumps(dict(scene, cameras=3)))
        self.assertIn("cameras: expected a list", self.refused(path))

    def test_a_dangling_link_is_ignored(self):
        samples.write_sleap(self.folder / "s/top/take.analysis.h5", 0, True)
        (self.folder / "s/top/take.mp4").symlink_to("/nowhere")
        self.assertEqual(self.lines(self.folder / "s")[0]["views"], ["top"])

    def test_tum_file_with_too_many_empty_cells_is_refused(self):
        tracks = self.folder / "far.jsonl"
        joints = [[0.0, 0.0, 1.0]] * 14
        with open(tracks, "w") as file:
            file.write(json.dumps({
                "kinegraph": 1, "units": {"length": "m", "time": "s"}, "frame_rate": 25,
                "skeleton": {"name": "own", "joints": [f"j{j}" for j in range(14)],
                             "bones": []}}) + "\n")  # fmt: skip
            for frame, number in ((0, 0), (900000, 300)):
                file.write(json.dumps({"frame": frame, "time": frame / 25, "people": [
                    {"id": number, "joints": joints, "status": ["observed"] * 14}
                ]}) + "\n")  # fmt: skip
        done = self.convert(f"--in={tracks}", "--to=tum", f"--out={self.folder / 'far.mat'}")
        self.assertEqual(done.returncode, 2)
        self.assertIn("would have 15.2 GB", done.stderr)

    def test_sleap_names_stored_after_the_numbers_are_found(self):
        # As in SLEAP's long files: the names lie beyond the first 64 KiB, so a reader that
        # examines only the head of a file would miss them.
        path = self.folder / "a.h5"
        with h5py.File(path, "w") as file:
            file["tracks"] = np.ones((1, 2, 3, 3000))
            for i in range(12):
                file[f"other_{i}"] = np.ones(10)
            file["node_names"] = np.array([b"a", b"b", b"c"])
        self.assertGreater(path.read_bytes().find(b"node_names"), 1 << 16)
        self.assertEqual(len(self.lines(path)), 3001)

    def test_a_sleap_session_has_one_folder_per_camera(self):
        for camera in ("top", "back", "mid"):
            samples.write_sleap(self.folder / f"s/{camera}/minimal.analysis.h5", 0, True)
            (self.folder / f"s/{camera}/other.h5").write_text("no HDF5")
        (self.folder / "s/points3d.h5").write_bytes(b"\x89HDF of another program")
        self.assertEqual(self.lines(self.folder / "s")[0]["views"], ["back", "mid", "top"])
        samples.write_sleap(self.folder / "s/mid/second.analysis.h5", 0, True)
        self.assertIn("mid: contains 2 analyses", self.refused(self.folder / "s"))

    def test_deeplabcut_individuals_may_lack_unique_bodyparts(self):
        columns = samples.pd.MultiIndex.from_tuples(
            [
                ("net", who, part, coord)
                for who, part in (("a", "nose"), ("single", "ball"))
                for coord in ("x", "y", "likelihood")
            ],
            names=["scorer", "individuals", "bodyparts", "coords"],
        )
        values = np.array([[100, 200, 0.5, 300, 400, 0.25]])
        table = samples.pd.DataFrame(values, columns=columns)
        path = self.folder / "u.h5"
        table.to_hdf(path, key="df_with_missing", format="table", mode="w")
        self.assertEqual(
            self.lines(path)[1]["views"]["u"],
            [
                {"joints": [[100, 200, 0.5], None]},
                {"joints": [None, [300, 400, 0.25]]},
            ],
        )

    def test_pickled_column_names_are_not_executed(self):
        path = self.folder / "a.h5"
        samples.write_deeplabcut(path, 0, [None])
        with h5py.File(path, "a") as file:
            attributes = file["df_with_missing/table"].attrs
            attributes["values_block_0_kind"] = np.bytes_(b"cos\nsystem\n(S'ls'\ntR.")
        self.assertIn("'os.system'", self.refused(path))
        with h5py.File(path, "a") as file:
            attributes = file["df_with_missing/table"].attrs
            attributes["values_block_0_kind"] = np.bytes_(pickle.dumps([("a", "b", "x")], 0))
        self.assertIn("has 9 numbers per frame, but 1 column names", self.refused(path))

    def test_a_mat_file_that_unpacks_to_800_mb_is_refused(self):
        from scipy.io import savemat

        path = self.folder / "z.mat"
        savemat(path, {"actor3D": np.zeros((10000, 10000))}, do_compression=True)
        self.assertIn("than its size justifies", self.refused(path))

    def test_tracks_are_written_and_read_back(self):
        header = {"kinegraph": 1, "skeleton": {"name": "x", "bones": [],
                  "joints": [f"j{j}" for j in range(14)]}, "frame_rate": None}  # fmt: skip
        joints = [[0.1 * j, 1 / (j + 1), -j] for j in range(13)] + [None]
        person = {"id": 1, "joints": joints, "status": ["observed"] * 13 + ["missing"]}
        lines = [header, {"frame": 2, "time": 0, "people": [person]}]
        content = b"".join(json.dumps(line).encode() + b"\n" for line in lines)
        done = subprocess.run([APPS / "kinegraph-adapters", "--write=tum"], input=content,
                              capture_output=True, check=True)  # fmt: skip
        path = self.folder / "a.mat"
        path.write_bytes(done.stdout)
        found = self.lines(path)
        self.assertEqual([len(line["people"]) for line in found[1:]], [0, 0, 1])
        self.assertEqual(found[3]["people"], [person])


class Interface(Adapters):
    def test_a_missing_library_gives_one_line(self):
        samples.write_sleap(self.folder / "a.h5", 0, True)
        broken = self.folder / "modules"
        broken.mkdir()
        (broken / "h5py.py").write_text("raise ModuleNotFoundError(name='h5py')\n")
        said = self.convert(f"--in={self.folder}/a.h5", "--to=kinegraph",
                            f"--out={self.folder}/o.jsonl", PYTHONPATH=str(broken))  # fmt: skip
        self.assertEqual(said.returncode, 2)
        self.assertIn("apt-get install python3-h5py", said.stderr)
        self.assertEqual(said.stderr.count("\n"), 1)
        self.assertFalse((self.folder / "o.jsonl").exists())

    def reader(self, content, name="reader"):
        path = self.folder / name
        path.write_text(content)
        path.chmod(0o755)
        return path

    def test_the_example_reader_in_the_docs_works(self):
        page = (SOURCE / "docs/adapters.md").read_text()
        script = re.search(r"```python my_reader.py\n(.*?)```", page, re.DOTALL)[1]
        code = [line for line in script.splitlines() if line.strip()]
        self.assertLessEqual(len(code), 22, "20 lines, shebang and docstring")
        reader = self.reader(script, "my_reader.py")
        table = self.folder / "walk.tab"
        table.write_text(
            "frame;camera;joint;x;y;score\n"
            + "".join(
                f"{f};cam{c};{joint};{100 + 10 * c + f + j};{200 + j};0.{j + 1}\n"
                for f in (3, 4)
                for c in (1, 2)
                for j, joint in enumerate(["LeftHip", "right_hip", "wing"])
            )
        )
        out = self.folder / "o.jsonl"
        command = (f"--in={table}", "--to=kinegraph", f"--out={out}")
        self.assertEqual(self.convert(*command).returncode, 2, "no adapter reads it")
        own = self.folder / "own"
        own.mkdir()
        shutil.copy(reader, own)
        for flags, settings in (((f"--adapter={reader}",), {}),
                                ((), {"KINEGRAPH_ADAPTERS": str(own)}),
                                ((), {"KINEGRAPH_ADAPTERS": os.path.relpath(own)})):  # fmt: skip
            done = self.convert(*command, *flags, **settings)
            self.assertEqual(done.returncode, 0, done.stderr)
            header, *frames = map(json.loads, out.read_text().splitlines())
            self.assertEqual(header["skeleton"]["joints"], ["l_hip", "r_hip", "wing"])
            self.assertEqual(header["views"], ["cam1", "cam2"])
            self.assertEqual([frame["frame"] for frame in frames], [3, 4])
            self.assertEqual(
                frames[1]["views"]["cam2"],
                [{"joints": [[124, 200, 0.1], [125, 201, 0.2], [126, 202, 0.3]]}],
            )
            out.unlink()

    def test_inputs_are_not_overwritten(self):
        reader = self.reader("#!/bin/sh\n[ $1 = --recognise ] && echo tracks && exit\n"
                             "cat $0.tracks\n")  # fmt: skip
        pathlib.Path(f"{reader}.tracks").write_text(
            '{"kinegraph":1,"units":{"length":"m","time":"s"},"frame_rate":25,'
            '"skeleton":{"name":"own","joints":["a"],"bones":[]}}\n'
        )
        session = self.folder / "session"
        # Deeper than the four levels of folders in which input files are recorded
        # (NoteInputs).
        (session / "a/b/c/d/e/f").mkdir(parents=True)
        folders = (".", "a", "z", "a/b", "a/b/c", "a/b/c/d")
        inputs = [session / folder / "m.csv" for folder in folders]
        for path in inputs:
            path.parent.mkdir(exist_ok=True)
            path.write_text("x")
        for path in inputs:
            done = self.convert(f"--adapter={reader}", f"--in={session}", "--to=csv",
                                f"--out={path}")  # fmt: skip
            self.assertEqual(done.returncode, 2, path)
            self.assertIn("is an input of this command", done.stderr)
            self.assertEqual(path.read_text(), "x")

    def test_no_file_starts_a_program(self):
        marker = self.folder / "started"
        program = self.reader(f"#!/bin/sh\ntouch {marker}\n")
        config = self.folder / "c.toml"
        config.write_text(f'adapter = "{program}"\n[detections]\nadapter = "{program}"\n')
        for key in (f"detections.adapter={program}", f"detections.format={program}"):
            done = self.convert(f"--in={self.folder}/c.toml", "--to=kinegraph", f"--set={key}",
                                f"--out={self.folder}/o")  # fmt: skip
            self.assertEqual(done.returncode, 2, done.stderr)
        beside = self.folder / "data"
        beside.mkdir()
        shutil.copy(program, beside / "kinegraph-adapters")
        (beside / "x.bin").write_bytes(b"?")
        (beside / "h5py.py").write_text(f"open({str(marker)!r}, 'w')\n")
        samples.write_sleap(beside / "a.h5", 0, True)
        for name in ("x.bin", "a.h5"):  # from the folder of the recording
            subprocess.run([APPS / "kinegraph-convert", f"--in={name}", "--to=kinegraph",
                            "--out=o"], cwd=beside, capture_output=True)  # fmt: skip
        self.assertFalse(marker.exists())

    def test_failing_adapters_are_reported(self):
        path = self.folder / "a.xyz"
        path.write_text("?")
        ask = 'if [ "$1" = --recognise ]; then echo detections; exit; fi\n'
        head = json.dumps({"kinegraph_detections": 1, "skeleton": "coco17", "views": ["a"]})
        for body, said in (
            ("echo first >&2; echo the last line >&2; exit 3", "a.xyz: the last line"),
            (f"echo '{head}'; kill -SEGV $$", "was ended by signal 11"),
            (f"echo '{head}'; echo '{{\"frame\": 1, \"vi'; exit 1", "ended with code 1"),
            (f"echo '{head}'; echo nonsense; sleep 1", "line 2: is not valid JSON"),
            ("true", "is empty, expected a header"),
            ("echo '{}'", "kinegraph_detections: is missing"),
        ):
            program = self.reader("#!/bin/sh\n" + ask + body + "\n")
            done = self.convert(f"--in={path}", "--to=kinegraph", f"--adapter={program}",
                                f"--out={self.folder}/o.jsonl")  # fmt: skip
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
            self.assertIn(said, done.stderr)
            self.assertFalse((self.folder / "o.jsonl").exists())

    def test_packages_that_are_installed_are_not_listed(self):
        samples.write_sleap(self.folder / "a.h5", 0, True)
        (self.folder / "b.txt").write_text("?")
        there = self.run_adapter("--packages", self.folder / "a.h5", self.folder / "b.txt")
        self.assertEqual((there.returncode, there.stdout), (0, b""))
        usage = self.run_adapter("--nonsense", "a")
        self.assertEqual(usage.returncode, 2)


if __name__ == "__main__":
    unittest.main()
