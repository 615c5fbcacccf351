"""The library that reads and writes ROS 2 bags, imported when it is used."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import Any

from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

from codesign.ground.errors import RunError

INSTALL = "pip install 'hwsw-codesign[ros2]'"

_BUILTIN = "builtin_interfaces/msg"
OCCUPANCY_GRID = "nav_msgs/msg/OccupancyGrid"
ODOMETRY = "nav_msgs/msg/Odometry"
PATH = "nav_msgs/msg/Path"
TF_MESSAGE = "tf2_msgs/msg/TFMessage"
LASER_SCAN = "sensor_msgs/msg/LaserScan"
POSE_STAMPED = "geometry_msgs/msg/PoseStamped"
TWIST = "geometry_msgs/msg/Twist"
TWIST_STAMPED = "geometry_msgs/msg/TwistStamped"
LOG = "rcl_interfaces/msg/Log"


def load(name: str) -> Any:
    """A module of the library.

    Raises:
        RunError: it cannot be imported.
    """
    try:
        return import_module(f"rosbags.{name}")
    except ImportError as missing:
        what = f"ROS 2 bags need the package rosbags, which cannot be imported: {missing}"
        raise RunError(what, hint=INSTALL) from None


@cache
def typestore() -> Any:
    """The message types of ROS 2 Jazzy. Those that are used here are the same in every release of ROS 2."""
    types = load("typesys")
    return types.get_typestore(types.Stores.ROS2_JAZZY)


class Types:
    """The classes of ROS messages that are written."""

    def __init__(self) -> None:
        types: Any = typestore().types
        self.time = types[f"{_BUILTIN}/Time"]
        self.header = types["std_msgs/msg/Header"]
        self.point = types["geometry_msgs/msg/Point"]
        self.vector = types["geometry_msgs/msg/Vector3"]
        self.quaternion = types["geometry_msgs/msg/Quaternion"]
        self.pose = types["geometry_msgs/msg/Pose"]
        self.pose_stamped = types[POSE_STAMPED]
        self.pose_with_covariance = types["geometry_msgs/msg/PoseWithCovariance"]
        self.twist = types[TWIST]
        self.twist_with_covariance = types["geometry_msgs/msg/TwistWithCovariance"]
        self.transform = types["geometry_msgs/msg/Transform"]
        self.transform_stamped = types["geometry_msgs/msg/TransformStamped"]
        self.tf = types[TF_MESSAGE]
        self.odometry = types[ODOMETRY]
        self.map_meta_data = types["nav_msgs/msg/MapMetaData"]
        self.occupancy_grid = types[OCCUPANCY_GRID]
        self.path = types[PATH]
        self.laser_scan = types[LASER_SCAN]
        self.log = types[LOG]


MAX_CHUNK_BYTES = 2**30
"""The largest chunk of messages that is unpacked."""


def bound_decompression() -> None:
    """Let the library unpack no more of a chunk than it declares, and at most ``MAX_CHUNK_BYTES``.

    A small file could otherwise fill the memory.
    """
    storage, too_large = load("rosbag2.storage_mcap"), load("rosbag2.errors").ReaderError

    def bounded(make: Any) -> Any:
        def unpack(data: bytes, size: int) -> bytes:
            if size > MAX_CHUNK_BYTES:
                raise too_large(f"a chunk of {size:,} bytes, more than {MAX_CHUNK_BYTES:,}")
            unpacked: bytes = make().decompress(data, max_length=size + 1)
            return unpacked

        return unpack

    unpackers: Any = vars(storage)
    unpackers["DECOMPRESSORS"].update(
        lz4=bounded(LZ4FrameDecompressor), zstd=bounded(unpackers["zstd"].ZstdDecompressor)
    )
