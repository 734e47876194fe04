"""kinegraph: 3D motion of people from 2D poses in several cameras.

    import kinegraph as kg

    cameras = kg.read_cameras("calibration.json")
    detections = kg.read_detections("openpose/")
    tracks = kg.track(cameras, detections)
    tracks.positions_m      # (frames, people, joints, 3), metres
    tracks.covariance_m2    # (frames, people, joints, 3, 3)

Lengths are metres, images pixels, times seconds. Bad input raises InputError or
OptionError (both are ValueErrors) with one line that names file, line or key.
The commands use the same library, so their results are identical bit for bit.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Union

# A wheel's own libraries must take precedence over libraries that another module
# loaded globally (RTLD_GLOBAL, as PyTorch loads its OpenMP and BLAS).
_usual_flags = sys.getdlopenflags()
if os.path.isdir(os.path.join(os.path.dirname(__file__), "..", "kinegraph.libs")):
    sys.setdlopenflags(_usual_flags | os.RTLD_DEEPBIND)

from . import _kinegraph

sys.setdlopenflags(_usual_flags)

from ._kinegraph import (
    INFERRED,
    MISSING,
    OBSERVED,
    Camera,
    Detections,
    InputError,
    Kinematics,
    OptionError,
    Skeleton,
    Tracks,
    file_kind,
    kinematics,
    read_cameras,
    read_detections,
    read_tracks,
    skeleton_names,
    strategies,
    write_cameras,
    write_detections,
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
    "Kinematics",
    "OptionError",
    "Session",
    "Skeleton",
    "Tracks",
    "config_path",
    "convert",
    "evaluate",
    "file_kind",
    "kinematics",
    "read_cameras",
    "read_detections",
    "read_tracks",
    "skeleton_names",
    "smooth",
    "strategies",
    "track",
    "write_cameras",
    "write_detections",
    "write_tracks",
]

# A file, or the name of one of the configurations in the module.
Config = Union[str, "os.PathLike[str]", None]
# Keys to change, {"graph.lag_s": 0.2} or "key=value;key=value".
Settings = Union[str, Mapping[str, Any], None]

_FOLDER = os.path.dirname(os.path.abspath(__file__))
_CONFIGS = os.path.join(_FOLDER, "configs")
if sys.executable:
    # Adapters run in this interpreter, for which the user installed their libraries.
    _kinegraph._set_adapters([sys.executable, os.path.join(_FOLDER, "adapters")])


def config_path(config: Config = None) -> str:
    """The file of a configuration, resolved as the commands do.

    An existing file is returned as it is, and so is a name that is not found;
    "configs/offline.toml" and "offline.toml" are in the module. None:
    default.toml, which `kinegraph track` uses without --config.
    """
    if config is None:
        config = "default.toml"
    config = os.fspath(config)
    if not config or os.path.isabs(config) or os.path.isfile(config):
        return config
    name = config[len("configs/") :] if config.startswith("configs/") else config
    own = os.path.join(_CONFIGS, name)
    return own if os.path.isfile(own) else config


def _assignments(settings: Settings) -> str:
    """{"graph.lag_s": 0.2} in the syntax of the commands' --set."""
    if not settings:
        return ""
    if isinstance(settings, str):
        return settings
    return ";".join(f"{key}={_value(value)}" for key, value in settings.items())


def _value(value: Any) -> str:
    if hasattr(value, "tolist"):  # NumPy's numbers and arrays
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        words = [repr(str(v)) if isinstance(v, str) else _value(v) for v in value]
        return "[" + ", ".join(words) + "]"
    return repr(value) if isinstance(value, float) else str(value)


def track(
    cameras: Iterable[Camera],
    detections: Detections,
    config: Config = None,
    set: Settings = None,
    mode: str | None = None,
    frames: Iterable[tuple[int, int]] = (),
    without_cameras: Iterable[str] = (),
    threads: int = 1,
    progress: Callable[[int, int], object] | None = None,
) -> Tracks:
    """Tracks all people in a recording.

    cameras: list of Camera. detections: Detections. config: a TOML file, or the
    name of a configuration in the module such as "offline.toml"; default.toml if
    omitted, as for `kinegraph track` (config_path). set: keys to change,
    {"graph.lag_s": 0.2} or "key=value;key=value". mode: "paper" or "graph",
    overrides the configuration's mode. frames: [(begin, end), ...], end excluded;
    empty: all. without_cameras: names of cameras to omit. threads: number of
    threads, which does not change the result. progress: called every 16 frames and
    after the last as progress(frames_read, total), in which a frame counts once per
    pass.

    Returns Tracks. Releases the interpreter's lock; Ctrl-C stops the run, also
    while the batch is solved.
    """
    return _kinegraph.track(
        list(cameras),
        detections,
        config_path(config),
        _assignments(set),
        mode or "",
        list(frames),
        list(without_cameras),
        threads,
        progress,
    )


class Session(_kinegraph.Session):
    """Tracks people in frames as they arrive, for live programs.

    cameras: list of Camera. skeleton: name of the detections' skeleton. views:
    for each view the name of its camera. frame_rate_hz: of the frames [Hz].
    config, set, mode: as for track().

        session = kg.Session(cameras, "coco17", ["cam0", "cam1"], 25.0)
        for k, views in enumerate(frames):   # per view an array (people, 17, 3)
            use(session.process(k, views))   # Tracks of frames now final
        use(session.finish())
    """

    def __init__(
        self,
        cameras: Iterable[Camera],
        skeleton: str,
        views: Sequence[str],
        frame_rate_hz: float,
        config: Config = None,
        set: Settings = None,
        mode: str | None = None,
    ) -> None:
        super().__init__(
            list(cameras),
            skeleton,
            list(views),
            frame_rate_hz,
            config_path(config),
            _assignments(set),
            mode or "",
        )


class Frozen(_kinegraph.Frozen):
    """A tracked recording with fixed matches, on which smoothers can be compared.

    cameras, detections, config, set: as for track(), but with a single pass,
    identities are not linked, and cameras.ground is ignored.
    tracks: the result of the run itself.
    smooth(strategy): Tracks of the same matches.
    """

    def __init__(
        self,
        cameras: Iterable[Camera],
        detections: Detections,
        config: Config = None,
        set: Settings = None,
    ) -> None:
        super().__init__(
            list(cameras), detections, config_path(config), _assignments(set)
        )


def smooth(
    cameras: Iterable[Camera],
    detections: Detections,
    strategy: str,
    config: Config = None,
    set: Settings = None,
) -> Tracks:
    """Smooths the matches of a recording (Frozen) by one of strategies()."""
    return Frozen(cameras, detections, config, set).smooth(strategy)


def convert(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    to: str = "",
    skeleton: str = "",
    frame_rate_hz: float = 0.0,
    image_size: tuple[int, int] | None = None,
    from_: str = "auto",
    unit: str = "",
    axes: str = "",
    markers: str = "ours",
    person: str | int = "",
    set: Settings = None,
) -> list[str]:
    """Converts a calibration, detections or tracks, as `kinegraph convert` does.

    The source's format is recognised by its content, or specified by from_. to:
    name of a format (`kinegraph convert --formats` lists them); if omitted, a
    format of tracks is chosen by the target's extension, such as ".c3d".
    skeleton, frame_rate_hz [Hz], image_size (width, height) [px], unit ("m",
    "cm", "mm"): needed if the source does not specify them. axes: the world axes
    that become X, Y and Z of the file, "x,-z,y". markers: "ours", "pose2sim" or
    "opensim". person: identity or name of the only person to write. set: keys for
    reading, {"detections.zero_confidence": "position"}. Creates the folders of
    the target. Returns a list of what the target's format cannot store.
    """
    return _kinegraph._convert(
        os.fspath(source),
        os.fspath(target),
        to,
        from_,
        skeleton,
        frame_rate_hz,
        ",".join(str(side) for side in image_size) if image_size else "",
        unit,
        axes,
        markers,
        str(person),
        _assignments(set),
    )


def evaluate(
    tracks: Tracks, truth: Tracks, protocol: str = "mpjpe"
) -> dict[str, Any]:
    """Scores tracks against a ground truth (both Tracks); returns a dict.

    Frames are paired as the command `evaluate` does: by time or, unless both
    have times and a rate, by number. Notes on the pairing, or that no person is
    found, are UserWarnings; InputError if few people are found and most would be
    with other axes or another unit of the truth. "identity" compares the centres
    of people if one of the two has a single joint and the other lacks it.

    "mpjpe": "mpjpe_m" and "bias_removed_m", the mean joint error [m] with and
    without each joint's constant offset; "joints_m", the former by joint;
    "found", the share of true person-frames with a counterpart.
    "identity": "mota" and "idf1" (1: perfect) and the counts "switches",
    "fragments", "misses", "false_positives", "true_people" and "identities".
    """
    if protocol == "mpjpe":
        return _kinegraph._mpjpe(tracks, truth)
    if protocol == "identity":
        return _kinegraph._identity(tracks, truth)
    raise InputError(
        f"protocol: found '{protocol}', expected one of mpjpe identity"
    )
