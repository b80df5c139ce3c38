"""Logs as other programs write them: ULog by hand from its specification, the others by their own libraries."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

RATE = 200.0
"""Hz, of the gyro."""
IMU = """std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
"""
WRENCH = """std_msgs/Header header
geometry_msgs/Wrench wrench
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""
EPOCH = 1_760_000_000
"""s since 1970 at which the ROS logs begin."""


def motion(rows: int, rate: float = RATE, phase: float = 0.0) -> np.ndarray:
    """Return a slow motion about three axes, shape (rows, 3), of size 1."""
    time = np.arange(rows) / rate
    return np.column_stack([np.sin(2 * np.pi * hertz * time + phase) for hertz in (0.11, 0.23, 0.31)])


def gyro(rows: int = 400) -> np.ndarray:
    """Return body rates, shape (rows, 3), rad/s."""
    return 0.3 * motion(rows)


def torque(rows: int = 100) -> np.ndarray:
    """Return torques at 50 Hz, shape (rows, 3), N m."""
    return 0.01 * motion(rows, 50.0, 1.0)


class ULogWriter:
    """Writes ULog after docs.px4.io, "ULog File Format"."""

    def __init__(self, path: Path, formats: Mapping[str, str]) -> None:
        """Begin a log.

        Args:
            path: of the file.
            formats: fields of each type of message, such as "uint64_t timestamp;float[3] xyz".
        """
        self._file = path.open("wb")
        self._file.write(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000))
        self._message("B", bytes(40))
        for name, fields in formats.items():
            self._message("F", f"{name}:{fields};".encode())

    def add(self, number: int, name: str, instance: int = 0) -> None:
        """Announce a topic."""
        self._message("A", struct.pack("<BH", instance, number) + name.encode())

    def data(self, number: int, packed: bytes) -> None:
        """Write a message of a topic."""
        self._message("D", struct.pack("<H", number) + packed)

    def dropout(self, milliseconds: int) -> None:
        """Say that messages were lost."""
        self._message("O", struct.pack("<H", milliseconds))

    def close(self) -> None:
        """End the log."""
        self._file.close()

    def _message(self, kind: str, content: bytes) -> None:
        self._file.write(struct.pack("<HB", len(content), ord(kind)) + content)


FORMATS = {
    "vehicle_angular_velocity": "uint64_t timestamp;uint64_t timestamp_sample;float[3] xyz",
    "thrusters": "uint64_t timestamp;double[3] torque;uint8_t armed",
    "sensor_gyro": "uint64_t timestamp;float x;float y;float z",
}
ULOG_MAP = {
    "schema": 1,
    "channels": {
        "body_rate": {
            "topic": "vehicle_angular_velocity",
            "fields": ["xyz[0]", "xyz[1]", "xyz[2]"],
            "unit": "rad/s",
            "time_field": "timestamp_sample",
        },
        "applied_torque": {"topic": "thrusters", "fields": [f"torque[{n}]" for n in range(3)], "unit": "N*m"},
    },
}


def write_ulog(path: Path, rows: int = 400) -> Path:
    """Write a log of PX4's kind: gyro at 200 Hz, torques at 50 Hz, armed in its second quarter; us since boot."""
    log = ULogWriter(path, FORMATS)
    for number, name in enumerate(FORMATS):
        log.add(number, name)
    log.add(9, "sensor_gyro", 1)
    rates, torques = gyro(rows).astype(np.float32), torque(-(-rows // 4))
    for row in range(rows):
        time = 5_000_000 + 5000 * row
        log.data(0, struct.pack("<QQ3f", time + 300, time, *rates[row]))
        log.data(2, struct.pack("<Q3f", time, *rates[row]))
        log.data(9, struct.pack("<Q3f", time, *rates[row]))
        if row % 4 == 0:
            log.data(1, struct.pack("<Q3dB", time + 100, *torques[row // 4], rows <= 4 * row < 2 * rows))
    log.close()
    return path


JSON_MAP = {
    "schema": 1,
    "channels": {
        "body_rate": {
            "topic": "/imu",
            "fields": [f"rate.{axis}" for axis in "xyz"],
            "unit": "rad/s",
            "time_field": "stamp",
        },
        "applied_torque": {
            "topic": "/torque",
            "fields": ["t[0]", "t[1]", "t[2]"],
            "unit": "N*m",
            "time_field": "us",
            "time_unit": "us",
        },
    },
}


def write_json_mcap(
    path: Path,
    rows: int = 400,
    compression: str = "ZSTD",
    chunk: int = 20_000,
    clock: str = "us",
    torque_topic: str = "/torque",
    silent: str = "",
    late_values: int = 0,
) -> Path:
    """Write MCAP with JSON messages: gyro at 200 Hz with stamps in two parts, torques at 50 Hz with a clock in us.

    The topic `silent` is there without a message; so many of the gyro's first messages have no values.
    """
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType[compression], chunk_size=chunk)
        writer.start()
        schema = writer.register_schema("imu", "jsonschema", b"{}")
        imu = writer.register_channel("/imu", "json", schema)
        thrusters = writer.register_channel(torque_topic, "json", schema)
        if silent:
            writer.register_channel(silent, "json", schema)
        rates, torques = gyro(rows).tolist(), torque(-(-rows // 4)).tolist()
        for row, rate in enumerate(rates):
            time = EPOCH * 10**9 + 5_000_000 * row
            stamp = {"sec": time // 10**9, "nsec": time % 10**9}
            read = {"rate": None if row < late_values else dict(zip("xyz", rate, strict=True))}
            _send(writer, imu, time, {"stamp": stamp, **read, "mode": "auto"})
            if row % 4 == 0:
                _send(writer, thrusters, time, {clock: time // 1000, "t": torques[row // 4]})
        writer.finish()
    return path


def _send(writer, channel, time, content):
    writer.add_message(channel, time, json.dumps(content).encode(), time)


ROS_MAP = {
    "schema": 1,
    "channels": {
        "body_rate": {
            "topic": "/imu",
            "fields": [f"angular_velocity.{axis}" for axis in "xyz"],
            "unit": "rad/s",
            "time_field": "header.stamp",
        },
        "applied_torque": {
            "topic": "/wrench",
            "fields": [f"wrench.torque.{axis}" for axis in "xyz"],
            "unit": "N*m",
            "time_field": "header.stamp",
        },
    },
}


def ros_messages(rows: int) -> Iterable[tuple[str, int, dict]]:
    """Yield topic, time and content of ROS messages: gyro at 200 Hz, wrenches at 50 Hz."""
    rates, torques = gyro(rows).tolist(), torque(-(-rows // 4)).tolist()
    for row, rate in enumerate(rates):
        time = EPOCH * 10**9 + 5_000_000 * row
        header = {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": "imu"}
        content = {"angular_velocity": _vector(rate), "linear_acceleration": _vector([0.0, 0.0, 9.8])}
        yield "/imu", time + 1000, {"header": header, **content}
        if row % 4 == 0:
            wrench = {"force": _vector([0.0, 0.0, 0.0]), "torque": _vector(torques[row // 4])}
            yield "/wrench", time + 2000, {"header": header, "wrench": wrench}


def write_ros_mcap(path: Path, rows: int = 400, chunk: int = 2**20) -> Path:
    """Write MCAP with ROS 2 messages, by mcap-ros2-support."""
    from mcap_ros2.writer import Writer

    covariance = [0.0] * 9
    more = {
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
        "orientation_covariance": covariance,
        "angular_velocity_covariance": covariance,
        "linear_acceleration_covariance": covariance,
    }
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=chunk)
        schemas = {
            "/imu": writer.register_msgdef("sensor_msgs/msg/Imu", IMU),
            "/wrench": writer.register_msgdef("geometry_msgs/msg/WrenchStamped", WRENCH),
        }
        for topic, time, content in ros_messages(rows):
            message = {**content, **(more if topic == "/imu" else {})}
            writer.write_message(topic, schemas[topic], message, log_time=time, publish_time=time)
        writer.finish()
    return path


def write_bag(path: Path, rows: int = 400) -> Path:
    """Write a ROS bag by rosbags: a .bag file of ROS 1, or of ROS 2 the folder of any other name."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    first = path.suffix == ".bag"
    store = get_typestore(Stores.ROS1_NOETIC if first else Stores.ROS2_HUMBLE)
    with Writer1(path) if first else Writer2(path, version=9) as writer:
        kinds = {"/imu": "sensor_msgs/msg/Imu", "/wrench": "geometry_msgs/msg/WrenchStamped"}
        connections = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}
        for topic, time, content in ros_messages(rows):
            message = _ros(store, kinds[topic], content, first)
            pack = store.serialize_ros1 if first else store.serialize_cdr
            writer.write(connections[topic], time, pack(message, kinds[topic]))
    return path


def _ros(store, kind, content, first):
    types = store.types
    header = {"seq": 0} if first else {}
    stamp = types["builtin_interfaces/msg/Time"](**content["header"]["stamp"])
    header = types["std_msgs/msg/Header"](**header, stamp=stamp, frame_id="imu")
    vector = types["geometry_msgs/msg/Vector3"]
    if kind.endswith("WrenchStamped"):
        parts = {name: vector(**content["wrench"][name]) for name in ("force", "torque")}
        return types[kind](header=header, wrench=types["geometry_msgs/msg/Wrench"](**parts))
    return types[kind](
        header=header,
        orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=np.zeros(9),
        angular_velocity=vector(**content["angular_velocity"]),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector(**content["linear_acceleration"]),
        linear_acceleration_covariance=np.zeros(9),
    )


PROTOBUF_MAP = {
    "schema": 1,
    "channels": {
        "body_rate": {
            "topic": "/imu",
            "fields": ["rate.x", "rate.y", "rate.z"],
            "unit": "rad/s",
            "time_field": "stamp",
        },
        "applied_torque": {
            "topic": "/imu",
            "fields": ["torque[0]", "torque[1]", "torque[2]"],
            "unit": "N*m",
            "time_field": "stamp",
        },
    },
}


def write_protobuf_mcap(path: Path, rows: int = 400, chunk: int = 2**20) -> Path:
    """Write MCAP with protobuf messages, by mcap-protobuf-support: gyro and torque in one message at 200 Hz."""
    from mcap_protobuf.writer import Writer

    message = _protobuf_class()
    rates, torques = gyro(rows).tolist(), 0.01 * motion(rows, RATE, 1.0)
    with path.open("wb") as file, Writer(file, chunk_size=chunk) as writer:
        for row, rate in enumerate(rates):
            time = EPOCH * 10**9 + 5_000_000 * row
            content = message(torque=torques[row].tolist())
            content.stamp.seconds, content.stamp.nanos = time // 10**9, time % 10**9
            content.rate.x, content.rate.y, content.rate.z = rate
            writer.write_message("/imu", content, log_time=time, publish_time=time)
    return path


def _protobuf_class():
    from google.protobuf import descriptor_pb2, message_factory, timestamp_pb2
    from google.protobuf.descriptor_pool import DescriptorPool

    pool = DescriptorPool()
    pool.AddSerializedFile(timestamp_pb2.DESCRIPTOR.serialized_pb)
    file = descriptor_pb2.FileDescriptorProto(name="imu.proto", package="bench", syntax="proto3")
    file.dependency.append("google/protobuf/timestamp.proto")
    kinds = descriptor_pb2.FieldDescriptorProto
    vector = file.message_type.add(name="Vector")
    for number, axis in enumerate("xyz", start=1):
        vector.field.add(name=axis, number=number, type=kinds.TYPE_DOUBLE, label=kinds.LABEL_OPTIONAL)
    imu = file.message_type.add(name="Imu")
    nested = {"type": kinds.TYPE_MESSAGE, "label": kinds.LABEL_OPTIONAL}
    imu.field.add(name="stamp", number=1, type_name=".google.protobuf.Timestamp", **nested)
    imu.field.add(name="rate", number=2, type_name=".bench.Vector", **nested)
    imu.field.add(name="torque", number=3, type=kinds.TYPE_DOUBLE, label=kinds.LABEL_REPEATED)
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName("bench.Imu"))


def _vector(values: Sequence[float]) -> dict[str, float]:
    return dict(zip("xyz", values, strict=True))
