"""kinegraph: the 3D motion of people from the 2D poses that cameras see.

    import kinegraph as kg

    cameras = kg.read_cameras("calibration.json")
    detections = kg.read_detections("openpose/")
    tracks = kg.track(cameras, detections)
    tracks.positions_m      # (frames, people, joints, 3), metres
    tracks.covariance_m2    # (frames, people, joints, 3, 3)

Lengths are metres, images pixels, times seconds. Bad input raises InputError or
OptionError (both are ValueErrors) with one line that names file, line or key.
Everything is computed by the library that the commands use, so results are the
same to the last bit.
"""

from . import _kinegraph
from ._kinegraph import (
    INFERRED,
    MISSING,
    OBSERVED,
    Camera,
    Detections,
    InputError,
    OptionError,
    Skeleton,
    Tracks,
    read_cameras,
    read_detections,
    read_tracks,
    skeleton_names,
    strategies,
    write_cameras,
    write_tracks,
)

__all__ = [
    "INFERRED",
    "MISSING",
    "OBSERVED",
    "Camera",
    "Detections",
    "Frozen",
    "InputError",
    "OptionError",
    "Session",
    "Skeleton",
    "Tracks",
    "evaluate",
    "read_cameras",
    "read_detections",
    "read_tracks",
    "skeleton_names",
    "smooth",
    "strategies",
    "track",
    "write_cameras",
    "write_tracks",
]


def _assignments(settings):
    """{"graph.lag_s": 0.2} as the commands' --set takes it."""
    if not settings:
        return ""
    if isinstance(settings, str):
        return settings
    return ";".join(f"{key}={_value(value)}" for key, value in settings.items())


def _value(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)


def track(
    cameras,
    detections,
    config=None,
    set=None,
    mode=None,
    frames=(),
    without_cameras=(),
    threads=1,
    progress=None,
):
    """Tracks everybody in a take.

    cameras: list of Camera. detections: Detections. config: path of a TOML file;
    without one every key has its default and the mode is graph. set: keys to
    change, {"graph.lag_s": 0.2} or "key=value;key=value". mode: "paper" or
    "graph", wins over the file. frames: [(begin, end), ...], end excluded;
    none: all. without_cameras: names to leave out. threads: the result is the
    same for any number. progress: called as progress(frames_read, of).

    Returns Tracks. Other Python threads run meanwhile; Ctrl-C stops it.
    """
    return _kinegraph.track(
        list(cameras),
        detections,
        str(config or ""),
        _assignments(set),
        mode or "",
        list(frames),
        list(without_cameras),
        threads,
        progress,
    )


class Session(_kinegraph.Session):
    """A run that is fed frame by frame, as a live program does.

    cameras: list of Camera. skeleton: name of the detections' skeleton. views:
    a name a view, as its camera. config, set, mode: as track() takes them.
    """

    def __init__(
        self,
        cameras,
        skeleton,
        views,
        frame_rate_hz,
        config=None,
        set=None,
        mode=None,
    ):
        super().__init__(
            list(cameras),
            skeleton,
            list(views),
            frame_rate_hz,
            str(config or ""),
            _assignments(set),
            mode or "",
        )


class Frozen(_kinegraph.Frozen):
    """A tracked take whose matches are kept, to compare smoothers on them."""

    def __init__(self, cameras, detections, config=None, set=None):
        super().__init__(
            list(cameras), detections, str(config or ""), _assignments(set)
        )


def smooth(cameras, detections, strategy, config=None, set=None):
    """Tracks a take and smooths its matches by one of strategies()."""
    return Frozen(cameras, detections, config, set).smooth(strategy)


def evaluate(tracks, truth, protocol="mpjpe"):
    """Scores tracks against a ground truth (both Tracks); a dict.

    "mpjpe": mean joint error [m] with and without each joint's constant offset.
    "identity": MOTA, IDF1 and the counts behind them.
    """
    if protocol == "mpjpe":
        return _kinegraph._mpjpe(tracks, truth)
    if protocol == "identity":
        return _kinegraph._identity(tracks, truth)
    raise InputError(
        f"protocol: found '{protocol}', expected one of mpjpe identity"
    )
