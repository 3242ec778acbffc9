"""ROS 1 and 2 bags: fixes, the vehicle's own positions and depths, found by the types of their topics.

Topics may be named, `--map gps=TOPIC odometry=TOPIC depth=TOPIC`. Axes are east, north, up (REP 103), or north, east,
down where the frame is called so, or the vehicle's height is above 0 under water. Types: sensor_msgs, nav_msgs,
geometry_msgs and gps_common of docs.ros.org.
"""

import math
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from missionplan.arrays import Array
from missionplan.errors import InputError, Problem, shown
from missionplan.importers.geodesy import origin_of, plane_positions
from missionplan.importers.importer import Importer, ReadOptions, Samples, SourceLog, needed_module
from missionplan.importers.mapping import PASCALS_A_METRE
from missionplan.importers.track import Positions, Series, Track, columns_of, fixes, positions, series

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader

_TYPES = {
    "gps": ("sensor_msgs/msg/NavSatFix", "gps_common/msg/GPSFix", "gps_msgs/msg/GPSFix"),
    "odometry": ("nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseWithCovarianceStamped",
                 "geometry_msgs/msg/PoseStamped"),
    "depth": ("std_msgs/msg/Float64", "std_msgs/msg/Float32", "sensor_msgs/msg/FluidPressure"),
}  # fmt: skip
"""Of each quantity, in the order in which they are preferred."""
_COLUMNS = {
    "gps": ("t", "lat", "lon", "accuracy", "valid", "arrived"),
    "odometry": ("t", "x", "y", "z", "yaw", "pitch", "ned"),
    "depth": ("t", "depth", "stamped"),
}
_DELAY = 10.0
"""Time between a fix and its record that is no delay [s]."""
_SECOND_FORMAT = (".db3", ".mcap")
_DOWNWARDS = re.compile(r"(?<![a-z])ned(?![a-z])")
"""In the name of a frame: a word, unlike that in `aligned`."""


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file is a bag of ROS 1, or one of a bag's of ROS 2."""
    return path.suffix in (".bag", *_SECOND_FORMAT) or head.startswith((b"#ROSBAG V", b"\x89MCAP"))


def read(files: Sequence[Path], options: ReadOptions, log: SourceLog) -> Track:
    """Read bags as one track.

    Raises InputError with the list, when several topics have a quantity and none is named, or the named one is not
    there.
    """
    library = needed_module("rosbags.highlevel", "rosbag", "rosbag")
    described = {path for path in files if path.suffix in _SECOND_FORMAT and (path.parent / "metadata.yaml").exists()}
    bags = {path: path.parent if path in described else path for path in sorted(files)}  # one may have several files
    topics: dict[str, dict[str, str]] = defaultdict(dict)
    for bag in dict.fromkeys(bags.values()):
        with SourceLog().reading(bag, library.AnyReaderError), _opened(library, bag) as reader:  # told when it is read
            for connection in reader.connections:
                topics[connection.topic][connection.msgtype] = ""
    kinds = {topic: next(iter(types)) for topic, types in topics.items()}
    chosen = {quantity: _topic(quantity, kinds, options) for quantity in _TYPES} if kinds else {}
    fixed, deep, lines = Samples(_COLUMNS["gps"]), Samples(_COLUMNS["depth"]), list[Samples]()
    done: set[Path] = set()
    for path in log.each(list(bags)):
        with log.reading(path, library.AnyReaderError):
            if bags[path] not in done:
                done.add(bags[path])
                lines.append(Samples(_COLUMNS["odometry"]))
                _add(library, bags[path], chosen, {"gps": fixed, "odometry": lines[-1], "depth": deep})
    return _track(files, options, chosen, fixed, deep, [line for line in lines if len(line)])


@contextmanager
def _opened(library: ModuleType, bag: Path) -> Iterator["AnyReader"]:
    typesys = needed_module("rosbags.typesys", "rosbag", "rosbag")
    with library.AnyReader([bag], default_typestore=typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)) as reader:
        yield reader


def _topic(quantity: str, kinds: Mapping[str, str], options: ReadOptions) -> str:
    """Return the topic of a quantity: as named, else the only one of its type, of the vehicle that was chosen.

    Topics of one type in several bags, or of several vehicles in one, are no one track.
    """
    named = options.names.get(quantity)
    fitting = {topic: _TYPES[quantity].index(kind) for topic, kind in kinds.items() if kind in _TYPES[quantity]}
    if named is not None:
        if named.name in fitting:
            return named.name
        listed = ", ".join(sorted(fitting)) or f"none of {', '.join(_TYPES[quantity])}"
        raise InputError([Problem(f"no topic {shown(named.name)}; there is {listed}", key="map")])
    if quantity == "depth":
        fitting = {topic: rank for topic, rank in fitting.items() if "depth" in topic.lower()}
    if options.vehicle:
        fitting = {topic: rank for topic, rank in fitting.items() if options.vehicle in topic.split("/")}
    best = [topic for topic, rank in sorted(fitting.items()) if rank == min(fitting.values())]
    if len(best) > 1:
        raise _several(quantity, best)
    if not best and quantity != "depth":
        message = f"no topic of {_TYPES[quantity][0]}; its topics are {', '.join(sorted(kinds)[:20])}"
        raise InputError([Problem(message, key="vehicle" if options.vehicle else "map")])
    return best[0] if best else ""


def _several(quantity: str, topics: Sequence[str]) -> InputError:
    """Return the error of a quantity that several topics hold."""
    spaces = sorted({topic.split("/")[1] for topic in topics if topic.count("/") > 1})
    hint = f"name one with --map {quantity}={topics[0]}"
    hint += f", or a vehicle with --vehicle {spaces[0]}" if len(spaces) > 1 else ""
    return InputError([Problem(f"several topics of {quantity}: {', '.join(topics)}", key="map", hint=hint)])


def _add(library: ModuleType, bag: Path, chosen: Mapping[str, str], samples: Mapping[str, Samples]) -> None:
    """Add the messages of one bag, read one after the other."""
    quantities = {topic: quantity for quantity, topic in chosen.items() if topic}
    with _opened(library, bag) as reader:
        wanted = [connection for connection in reader.connections if connection.topic in quantities]
        if not wanted:
            raise ValueError(f"none of the topics {', '.join(quantities)}")
        for connection, logged, raw in reader.messages(connections=wanted):
            message: Any = reader.deserialize(raw, connection.msgtype)  # as its definition says
            quantity = quantities[connection.topic]
            samples[quantity].add(*_VALUES[quantity](message, 1e-9 * logged))


def _fix(message: Any, logged: float) -> tuple[float, ...]:
    covariance = np.asarray(message.position_covariance, dtype=float)
    is_stated = message.position_covariance_type > 0 and covariance[0] > 0.0
    valid = message.status.status >= 0
    accuracy = math.sqrt(covariance[0] + covariance[4]) if is_stated and valid else math.nan
    return _time(message, logged), message.latitude, message.longitude, accuracy, float(valid), logged


def _odometry(message: Any, logged: float) -> tuple[float, ...]:
    pose = message.pose.pose if hasattr(message.pose, "pose") else message.pose
    place, q = pose.position, pose.orientation
    yaw = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y**2 + q.z**2))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (q.w * q.y - q.z * q.x))))
    return (
        _time(message, logged),
        place.x,
        place.y,
        place.z,
        yaw,
        pitch,
        float(_DOWNWARDS.search(message.header.frame_id.lower()) is not None),
    )


def _depth(message: Any, logged: float) -> tuple[float, ...]:
    if hasattr(message, "fluid_pressure"):
        return _time(message, logged), message.fluid_pressure / PASCALS_A_METRE, 1.0
    return logged, float(message.data), 0.0


_VALUES = {"gps": _fix, "odometry": _odometry, "depth": _depth}


def _time(message: Any, logged: float) -> float:
    """Time of a message's header; that of its arrival where the header has none [s]."""
    stamp = message.header.stamp
    return stamp.sec + 1e-9 * stamp.nanosec if stamp.sec else logged


def _track(
    files: Sequence[Path], options: ReadOptions, chosen: Mapping[str, str], fixed: Samples, deep: Samples,
    lines: Sequence[Samples],
) -> Track:  # fmt: skip
    """Make the track; each bag's positions count from where its odometry began."""
    gps_fixes = fixes(fixed["t"], fixed["lat"], fixed["lon"], accuracy=fixed["accuracy"], valid=fixed["valid"])

    def joined(name: str) -> Array:
        return np.concatenate([line[name] for line in lines]) if lines else np.empty(0)

    t, z = joined("t"), joined("z")
    is_down = bool(np.any(joined("ned"))) or _is_downwards(z)
    origin = origin_of(options.names.get("origin"))
    east, north = ("y", "x") if is_down else ("x", "y")
    parts = [plane_positions(line["t"], line[east], line[north], gps_fixes, origin) for line in lines]
    turned = np.degrees(joined("yaw")) if is_down else 90.0 - np.degrees(joined("yaw"))
    own_depth = series(t, z if is_down else -z) if np.any(z) else Series()
    off, late = _late(fixed)
    deep_t = deep["t"] - off * (deep["stamped"] == 0.0)
    notices = [f"{quantity} from the topic {topic}" for quantity, topic in chosen.items() if topic]
    return Track(
        name=files[0].stem,
        format="rosbag",
        fixes=gps_fixes,
        reckoned=positions(**columns_of(Positions, parts)),
        reckoning=f"the vehicle's own ({chosen.get('odometry', 'no odometry')})",
        depth=series(deep_t, deep["depth"]) if len(deep) else own_depth,
        pitch=series(t, np.degrees(joined("pitch"))),
        heading=series(t, turned % 360.0),
        heading_from="true",
        notices=(
            *notices,
            f"axes are taken as {'north, east, down' if is_down else 'east, north, up'}",
            *late,
        ),
    )


def _late(fixed: Samples) -> tuple[float, list[str]]:
    """By how much messages are recorded after their stamps, where that is no delay [s], and what is said of it."""
    off = float(np.median(fixed["arrived"] - fixed["t"])) if len(fixed) else 0.0
    if abs(off) <= _DELAY:
        return 0.0, []
    way = "before" if off > 0.0 else "after"
    return off, [f"stamps count as times, which are {abs(off):.0f} s {way} the record of their messages"]


def _is_downwards(z: Array) -> bool:
    """Whether heights are depths: a vehicle that dives goes farther below the surface than above it."""
    return len(z) > 0 and float(np.quantile(z, 0.95)) > 2.0 * max(-float(np.quantile(z, 0.05)), 1.0)


IMPORTERS = (Importer("rosbag", "ROS 1 and 2 bags (rosbags), topics by --map", recognises, read, is_choosing=True),)
