"""Caliscope's points: xy_TRACKER.csv (or xy.csv), one table of the whole recording, one
row per point: sync_index, cam_id (port in older versions), keypoint_id (point_id),
img_loc_x, img_loc_y [px], and optionally object_id and frame_time [s]. If the table has
no times, those of timestamps.csv or frame_time_history.csv in the same folder are used.
Views are named by the number of the camera, cam_0, cam_1, ...; frame numbers are those
of sync_index, the same for synchronised images.

In a session's folder the only table of its recordings is read or, if these have none,
the only other table in the folder. Views of cameras that the session ignores or has not
calibrated are then omitted."""

from __future__ import annotations

import csv
import os
import re

from common import MAX_FRAME, Refusal, header, line

KIND = "detections"
PACKAGES = []
OLD_NAMES = {"port": "cam_id", "point_id": "keypoint_id"}
POINT = {"sync_index", "cam_id", "keypoint_id", "img_loc_x", "img_loc_y"}
TIME = {"sync_index", "cam_id", "frame_time"}
MEDIAPIPE = {"xy_POSE", "xy_HOLISTIC", "xy_SIMPLE_HOLISTIC"}
MEDIAPIPE_JOINTS = 33  # holistic's hands are numbered from 100 and 200, its face from 500


# ---- Finding the table ----


def is_table(path):
    return path.suffix == ".csv" and (path.stem == "xy" or path.stem.startswith("xy_"))


def tables_below(folder, depth):
    if depth == 0:
        return []
    inside = sorted(p for p in folder.iterdir() if p.name[0] != ".")
    tables = [path for path in inside if is_table(path)]
    for path in inside if not tables else []:
        if path.is_dir():
            tables += tables_below(path, depth - 1)
    return tables


def tables_of(path):
    """Tables of a session's recordings; if there are none, other tables in its folder."""
    if not path.is_dir():
        return [path]
    depth = 4  # SESSION/calibration/extrinsic/TRACKER
    recordings = path / "recordings"
    found = tables_below(recordings, depth) if recordings.is_dir() else []
    return found or tables_below(path, depth)


def table_of(path):
    tables = tables_of(path)
    if not tables:
        raise Refusal(path, "", "has no xy_TRACKER.csv")
    if len(tables) > 1:
        names = ", ".join(os.path.relpath(table, path) for table in tables)
        raise Refusal(
            path, "", f"contains several tables of points, pass one of them as detections: "
            f"{names}"
        )  # fmt: skip
    return tables[0]


def recognise(path):
    if path.is_dir():  # search sessions only: other folders may have a million files
        names = os.listdir(path)
        is_session = {"camera_array.toml", "config.toml"} & set(names) or any(
            is_table(path / name) for name in names
        )
        return bool(is_session) and bool(tables_of(path))
    with open(path, "rb") as file:
        first = file.read(1 << 12).decode("utf-8-sig", "replace").splitlines()[:1]
    return bool(first) and first[0].startswith("sync_index") and POINT <= set(
        places_of(next(csv.reader(first, delimiter=delimiter_of(first[0]))))
    )


def unused_cameras(session):
    """Cameras that a session ignores or has not calibrated."""
    for name in ("camera_array.toml", "config.toml"):
        path = session / name
        if not session.is_dir() or not path.is_file():
            continue
        try:
            import tomllib
        except ModuleNotFoundError:  # before Python 3.11
            import tomli as tomllib
        try:
            root = tomllib.loads(path.read_text(encoding="utf-8-sig"))
        except ValueError as error:
            raise Refusal(path, "", str(error)) from error
        is_array = isinstance(root.get("cameras"), dict)
        unused = set()
        for key, camera in (root["cameras"] if is_array else root).items():
            number = re.findall(r"\d+", key)
            is_camera = number and isinstance(camera, dict)
            if not is_camera or not (is_array or key.startswith("cam_")):
                continue
            placed = isinstance(camera.get("rotation"), list)
            if not placed or camera.get("ignore") is True:
                unused.add(int(number[-1]))
        return unused
    return set()


# ---- Rows ----


def delimiter_of(first_row):
    return max(",;\t", key=first_row.count)


def places_of(names):
    places = {}
    for place, name in enumerate(names):
        places.setdefault(name, place)
    for old, now in OLD_NAMES.items():
        if old in places:
            places.setdefault(now, places[old])
    return places


class Rows:
    """Rows of a table, checked; errors name the line."""

    def __init__(self, path):
        self.path = path
        self.cells = []
        self._number = 1
        text = path.read_text(encoding="utf-8-sig", errors="replace")
        self._delimiter = delimiter_of(text.partition("\n")[0])
        self._rows = csv.reader(text.splitlines(), delimiter=self._delimiter)
        self.names = next(self._rows, [])
        if not self.names:
            raise Refusal(path, "", "is empty")
        self._places = places_of(self.names)

    def has(self, columns):
        return columns <= self._places.keys()

    def __iter__(self):
        for self.cells in self._rows:
            self._number += 1
            if len(self.cells) == len(self.names):
                yield self
            elif self.cells:
                self.fail(
                    "", f"found {len(self.cells)} cells, expected {len(self.names)}"
                )

    def fail(self, column, message):
        place = f"line {self._number}" + (f": {column}" if column else "")
        raise Refusal(self.path, place, message)

    def _fail_cell(self, column, expected):
        place = self._places[column]
        found = self.cells[place]
        self.fail(self.names[place], f"found the text '{found}', expected {expected}")

    def number(self, column):
        text = self.cells[self._places[column]]
        if self._delimiter != ",":
            text = text.replace(",", ".")
        try:
            number = float(text)
        except ValueError:
            number = float("nan")
        if not abs(number) < float("inf"):
            self._fail_cell(column, "a number")
        return number

    def index(self, column):
        number = self.number(column)
        if not (0 <= number <= MAX_FRAME and number == int(number)):
            self._fail_cell(column, "a whole number from 0")
        return int(number)

    def time(self):
        """((frame, camera), time [s])."""
        seconds = self.number("frame_time")
        if not abs(seconds) <= 4.6e9:  # kMaxTime_s
            self.fail("frame_time", f"found {seconds}, expected seconds")
        return (self.index("sync_index"), self.index("cam_id")), seconds


def times_beside(table):
    for name in ("timestamps.csv", "frame_time_history.csv"):
        path = table.parent / name
        rows = Rows(path) if path.is_file() else None
        if rows is None or not rows.has(TIME):
            continue
        times = {}
        for row in rows:
            times.setdefault(*row.time())
        if times:
            return times
    return {}


def read_points(table, unused):
    """Positions [px] by frame, camera, person and point number; and times [s]."""
    rows = Rows(table)
    people, times = {}, {}
    if not rows.has(POINT):
        raise Refusal(
            table, "line 1", "expected columns sync_index, cam_id (or port), keypoint_id "
            "(or point_id), img_loc_x and img_loc_y"
        )  # fmt: skip
    has_objects, has_times = rows.has({"object_id"}), rows.has({"frame_time"})
    for row in rows:
        place = row.index("sync_index"), row.index("cam_id")
        person = row.index("object_id") if has_objects else 0
        number = row.index("keypoint_id")
        px = row.number("img_loc_x"), row.number("img_loc_y")
        if place[1] in unused:
            continue
        people.setdefault(place, {}).setdefault(person, {})[number] = px
        if has_times:
            times.setdefault(*row.time())
    if not people:
        raise Refusal(table, "", "has no points")
    return people, times or times_beside(table)


# ---- Lines ----


def upper_median(values):
    return sorted(values)[len(values) // 2]


def nanoseconds(seconds):
    """Rounds halves away from zero, as C++'s llround does."""
    scaled = seconds * 1e9
    whole = int(abs(scaled) + 0.5)
    return whole if scaled >= 0 else -whole


def text_of_ns(time):
    sign = "-" if time < 0 else ""
    return f"{sign}{abs(time) // 10**9}.{abs(time) % 10**9:09d}"


def frame_rate_of(times):
    """Frame rate of the median step [Hz], rounded to 0.01 Hz; None without times."""
    last, steps = {}, []
    for (sync, camera), time in sorted(times.items()):
        before = last.get(camera)
        if before and sync > before[0]:
            steps.append((time - before[1]) / (sync - before[0]))
        last[camera] = sync, time
    step = upper_median(steps) if steps else 0
    # Rounds halves up, as C++'s round does for positive numbers.
    return int(100 / step + 0.5) / 100 if step > 1e-6 else None


def times_of_frames(times, cameras, syncs, rate):
    """Maps each frame to its time, the median of its views' times, and to the time of each
    view [ns]: images of one index are only nearly simultaneous. Times are shifted so that
    the first frame with times, of index s, is at s / rate, or at 0 without a rate."""
    by_frame = {}
    for (sync, camera), time in sorted(times.items()):
        if camera in cameras and sync in syncs:
            by_frame.setdefault(sync, {})[camera] = time
    found, origin, last = {}, None, None
    for sync, of_views in sorted(by_frame.items()):
        middle = upper_median(of_views.values())
        if origin is None:
            start = nanoseconds(sync / rate) if rate else 0
            origin = middle - start / 1e9
        time = nanoseconds(middle - origin)
        # Times of frames have to ascend, whichever cameras saw them.
        last = time if last is None else max(time, last + 1)
        found[sync] = last, {c: nanoseconds(t - origin) for c, t in of_views.items()}
    return found


def read(path, options):
    table = table_of(path)
    people, times = read_points(table, unused_cameras(path))
    if options.joints is not None or table.stem in MEDIAPIPE:
        joints = options.joints or MEDIAPIPE_JOINTS
        places = {number: number for number in range(joints)}
        skeleton = "mediapipe33" if options.joints is None else {
            "joints": [f"point_{j}" for j in range(joints)]
        }  # fmt: skip
    else:
        numbers = sorted({n for seen in people.values() for p in seen.values() for n in p})
        places = {number: place for place, number in enumerate(numbers)}
        labels = [f"point_{number}" for number in numbers]
        skeleton = {"name": "caliscope", "joints": labels, "bones": []}
    cameras = sorted({camera for _, camera in people})
    names = {camera: f"cam_{camera}" for camera in cameras}
    rate = options.frame_rate or frame_rate_of(times)
    # Omits frames in which no point is one of the joints. Unless options.frame_rate is
    # given, frames with times and points of any kind are kept.
    syncs = sorted(
        {
            sync
            for (sync, _), seen in people.items()
            if any(n in places for points in seen.values() for n in points)
        }
    )
    of_frames = {}
    if options.frame_rate is None:
        all_syncs = {sync for sync, _ in people}
        of_frames = times_of_frames(times, set(cameras), all_syncs, rate)
        syncs = sorted(set(syncs) | set(of_frames))
    yield header(names.values(), skeleton, rate, len(syncs))
    for sync in syncs:
        views = {}
        for camera in cameras:
            views[names[camera]] = [
                {"joints": joints_of(points, places)}
                for points in people.get((sync, camera), {}).values()
            ]
        text = line({"frame": sync, "views": views})
        if sync in of_frames:
            time, of_views = of_frames[sync]
            own = ",".join(
                f'"{names[c]}":{text_of_ns(t)}' for c, t in of_views.items() if t != time
            )
            more = f',"time":{text_of_ns(time)},"capture_times":{{{own}}}}}\n'
            text = text.removesuffix(b"}\n") + more.encode()
        yield text


def joints_of(points, places):
    joints = [None] * len(places)
    for number, (x, y) in points.items():
        if number in places:
            joints[places[number]] = [x, y, 1.0]
    return joints
