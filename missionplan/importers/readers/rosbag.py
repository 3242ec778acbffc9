"""ROS 1 and 2 bags: topics of NavSatFix and Odometry, named by `--map gps=TOPIC odometry=TOPIC` or found by type."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from missionplan.importers.geodesy import origin_of, plane_positions
from missionplan.importers.importer import Importer, ReadOptions, SourceLog, needed_module
from missionplan.importers.mapping import MappedName
from missionplan.importers.stores import Samples
from missionplan.importers.track import Series, Track, fixes, series

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import Connection

_TYPES = {"gps": "sensor_msgs/msg/NavSatFix", "odometry": "nav_msgs/msg/Odometry"}
_FIX = ("t", "lat", "lon", "accuracy", "valid")
_ODOMETRY = ("t", "x", "y", "z", "yaw", "pitch")
_SECOND_FORMAT = (".db3", ".mcap")


class _Stamp(Protocol):
    sec: int
    nanosec: int


class _Header(Protocol):
    stamp: _Stamp


class _Status(Protocol):
    status: int


class _NavSatFix(Protocol):
    header: _Header
    status: _Status
    latitude: float
    longitude: float
    position_covariance: Sequence[float]
    position_covariance_type: int


class _Vector(Protocol):
    x: float
    y: float
    z: float
    w: float


class _Pose(Protocol):
    position: _Vector
    orientation: _Vector


class _PoseWithCovariance(Protocol):
    pose: _Pose


class _Odometry(Protocol):
    header: _Header
    pose: _PoseWithCovariance


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a bag of ROS 1, or one of a bag's of ROS 2."""
    return path.suffix in (".bag", *_SECOND_FORMAT) or head.startswith(b"#ROSBAG V")


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read bags as one track."""
    library = needed_module("rosbags.highlevel", "rosbag", "rosbag")
    fixed, moving = Samples(_FIX), Samples(_ODOMETRY)
    topics: dict[str, str] = {}
    done: set[Path] = set()
    for path in log.each(sorted(files)):
        bag = path.parent if path.suffix in _SECOND_FORMAT else path
        with log.reading(path, library.AnyReaderError):
            if bag not in done:
                done.add(bag)
                topics |= _add(library, bag, options.names, fixed, moving)
    found = fixes(fixed["t"], fixed["lat"], fixed["lon"], accuracy=fixed["accuracy"], valid=fixed["valid"])
    origin = origin_of(options.names.get("origin"))
    t = moving["t"]
    return Track(
        name=files[0].stem,
        format="rosbag",
        fixes=found,
        reckoned=plane_positions(t, moving["x"], moving["y"], found, origin),
        reckoning=f"the vehicle's own ({topics.get('odometry', 'no odometry')})",
        depth=series(t, -moving["z"]) if np.any(moving["z"]) else Series(),
        pitch=series(t, np.degrees(moving["pitch"])),
        heading=series(t, (90.0 - np.degrees(moving["yaw"])) % 360.0),
        heading_from="true",
        notices=tuple(f"{each} from the topic {topic}" for each, topic in topics.items()),
    )


def _add(
    library: ModuleType, bag: Path, names: Mapping[str, MappedName], fixed: Samples, moving: Samples
) -> dict[str, str]:
    """Add the messages of one bag; returns the topics that were read."""
    typesys = needed_module("rosbags.typesys", "rosbag", "rosbag")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    reader: AnyReader
    with library.AnyReader([bag], default_typestore=store) as reader:
        chosen = {each: _topic(reader, each, names.get(each)) for each in _TYPES}
        wanted = [each for each in reader.connections if each.topic in chosen.values()]
        for connection, logged, raw in reader.messages(connections=wanted):
            message = cast(Any, reader.deserialize(raw, connection.msgtype))  # as its definition says
            if connection.topic == chosen["gps"]:
                fixed.add(*_fix(message, logged))
            else:
                moving.add(*_odometry(message, logged))
    return chosen


def _topic(reader: "AnyReader", quantity: str, named: MappedName | None) -> str:
    """Return the topic of a quantity: as named, else the one of its type with most messages.

    Raises
    ------
    ValueError
        When the bag has none.
    """
    fitting: list[Connection] = [each for each in reader.connections if each.msgtype == _TYPES[quantity]]
    if named is not None:
        if any(each.topic == named.name for each in fitting):
            return named.name
        topics = ", ".join(sorted(each.topic for each in fitting)) or "none"
        raise ValueError(f"no topic {named.name} of {_TYPES[quantity]}; it has {topics}")
    if not fitting:
        raise ValueError(f"no topic of {_TYPES[quantity]}; its topics are {', '.join(sorted(reader.topics)[:20])}")
    return max(fitting, key=lambda each: each.msgcount).topic


def _fix(message: _NavSatFix, logged: int) -> tuple[float, ...]:
    covariance = np.asarray(message.position_covariance, dtype=float)
    known = message.position_covariance_type > 0 and covariance[0] > 0.0
    valid = message.status.status >= 0
    accuracy = math.sqrt(covariance[0] + covariance[4]) if known and valid else math.nan
    return _time(message.header.stamp, logged), message.latitude, message.longitude, accuracy, float(valid)


def _odometry(message: _Odometry, logged: int) -> tuple[float, ...]:
    place, q = message.pose.pose.position, message.pose.pose.orientation
    yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y**2 + q.z**2))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (q.w * q.y - q.z * q.x))))
    return _time(message.header.stamp, logged), place.x, place.y, place.z, yaw, pitch


def _time(stamp: _Stamp, logged: int) -> float:
    """Time of a message's header; that of its arrival where the header has none [s]."""
    return stamp.sec + 1e-9 * stamp.nanosec if stamp.sec else 1e-9 * logged


IMPORTERS = (Importer("rosbag", "ROS 1 and 2 bags (rosbags), topics by --map", recognises, read),)
