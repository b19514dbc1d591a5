"""Flight logs of ROS: bags of ROS 1 (.bag) and ROS 2 (folder, .db3, .mcap)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats
from propmap.vehicle.log_map import LogMap
from propmap.vehicle.logs.recording import Recording, Signal

TYPES = {
    "odometry": "nav_msgs/msg/Odometry",
    "pose": "geometry_msgs/msg/PoseStamped",
    "velocity": "geometry_msgs/msg/TwistStamped",
    "imu": "sensor_msgs/msg/Imu",
}
"""Message type per role of a topic."""

ROTOR_FIELDS = {
    "std_msgs/msg/Float64MultiArray": "data",
    "std_msgs/msg/Float32MultiArray": "data",
    "sensor_msgs/msg/JointState": "velocity",
    "mav_msgs/msg/Actuators": "angular_velocities",
    "actuator_msgs/msg/Actuators": "velocity",
}
"""Field with the rotor speeds; of another type, its only field that is an array of numbers."""

Extract = Callable[[Any], list[float]]


def read_rosbag(path: Path, log: LogMap) -> Recording:
    """A bag whose topics ``[log.topics]`` names.

    ``odometry`` (nav_msgs/Odometry), or ``pose`` (geometry_msgs/PoseStamped) and ``velocity``
    (geometry_msgs/TwistStamped); ``rotor_speed`` (an array of numbers, see ``ROTOR_FIELDS``);
    optional ``imu`` (sensor_msgs/Imu) for rates and specific force, else the rates are those
    of the odometry or twist and the specific force is not known.
    Times are those of the headers; of a message without one, when it was recorded.
    Raises ``InputError``.
    """
    where = str(path)
    topics = log.topics
    if "rotor_speed" not in topics or not (
        "odometry" in topics or {"pose", "velocity"} <= {*topics}
    ):
        raise InputError(
            "bags need topics: odometry, or pose and velocity; and rotor_speed",
            'add [log.topics] with odometry = "/...", imu = "/...", rotor_speed = "/..."',
            log.where,
        )
    read = _messages(path, where, log)
    odometry = "odometry" in topics
    velocity_in = (log.velocity_in or "body") if odometry else log.stated("velocity_in")
    twist_role = "odometry" if odometry else "velocity"
    if "imu" not in topics and velocity_in == "world":
        raise InputError(
            "the twist is in the world frame, and no topic gives rates about body axes",
            'add imu = "/..." to [log.topics]',
            log.where,
        )

    def signal(name: str, role: str, extract: Extract) -> Signal:
        time, messages = read[role]
        rows = [extract(message) for message in messages]
        return Signal(f"{name} (topic {topics[role]})", time, np.array(rows, dtype=np.float64))

    def twist(message: Any) -> Any:
        return message.twist.twist if odometry else message.twist

    def orientation(message: Any) -> list[float]:
        pose = message.pose.pose if odometry else message.pose
        q = pose.orientation
        return [q.w, q.x, q.y, q.z]

    imu = "imu" in topics
    factor = log.rotor_factor(log.stated("rotor_unit"))
    return Recording(
        source=where,
        body_frame=log.body_frame or "flu",
        world_frame=log.world_frame or "enu",
        velocity_in=velocity_in,
        attitude=signal("attitude", "odometry" if odometry else "pose", orientation),
        velocity=signal("velocity", twist_role, lambda m: _xyz(twist(m).linear)),
        rates=(
            signal("rates", "imu", lambda m: _xyz(m.angular_velocity))
            if imu
            else signal("rates", twist_role, lambda m: _xyz(twist(m).angular))
        ),
        rotor_speed=_rotor_speed(
            *read["rotor_speed"], factor, f"rotor speed (topic {topics['rotor_speed']})", where
        ),
        specific_force=(
            signal("specific force", "imu", lambda m: _xyz(m.linear_acceleration)) if imu else None
        ),
    )


def _xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def _messages(path: Path, where: str, log: LogMap) -> dict[str, tuple[Floats, list[Any]]]:
    """Times [s] and messages of the topics named, by role."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    try:
        # Old bags of ROS 2 do not hold the definitions of their messages.
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            return {
                role: _topic(bag, role, topic, where, log) for role, topic in log.topics.items()
            }
    except InputError:
        raise
    # Damaged bytes make SQLite, MCAP and YAML parsers fail in ways that rosbags does not list.
    except Exception as error:
        raise InputError(
            f"not a bag that can be read: {error or type(error).__name__}",
            "give a ROS 1 .bag, a ROS 2 folder with metadata.yaml, or an .mcap file",
            where,
        ) from None


def _topic(bag: Any, role: str, topic: str, where: str, log: LogMap) -> tuple[Floats, list[Any]]:
    connections = [c for c in bag.connections if c.topic == topic]
    if not connections:
        present = ", ".join(sorted(f"{c.topic} ({_short(c.msgtype)})" for c in bag.connections))
        raise InputError(
            f"no topic {topic}; the bag has {present or 'none'}",
            f"correct {role} in [log.topics] of {log.file}",
            where,
        )
    wanted, found = TYPES.get(role), connections[0].msgtype
    if wanted not in (None, found):
        raise InputError(
            f"topic {topic} is of type {_short(found)}, expected {_short(str(wanted))}",
            f"name a topic of that type as {role} in [log.topics]",
            where,
        )
    times, messages = [], []
    for connection, recorded, data in bag.messages(connections):
        message = bag.deserialize(data, connection.msgtype)
        times.append(_stamp(message) or recorded * 1e-9)
        messages.append(message)
    return np.array(times, dtype=np.float64), messages


def _stamp(message: Any) -> float:
    """Time of the header [s]; 0 where there is none."""
    header = getattr(message, "header", None)
    return header.stamp.sec + header.stamp.nanosec * 1e-9 if header is not None else 0.0


def _rotor_speed(time: Floats, messages: list[Any], factor: float, name: str, where: str) -> Signal:
    """Rotor speeds [rad/s]; ``factor`` is their unit in the log."""
    if not messages:
        return Signal(name, time, np.empty((0, 0)))
    field = _rotor_field(messages[0], name, where)
    rows = [np.asarray(getattr(message, field), dtype=np.float64).ravel() for message in messages]
    lengths = sorted({row.size for row in rows})
    if len(lengths) > 1:
        raise InputError(
            f"messages of {name} have from {lengths[0]} to {lengths[-1]} values",
            "record one value per rotor in every message",
            where,
        )
    return Signal(name, time, np.stack(rows) * factor)


def _rotor_field(message: Any, name: str, where: str) -> str:
    kind: str = message.__msgtype__
    if kind in ROTOR_FIELDS:
        return ROTOR_FIELDS[kind]
    arrays = [
        field
        for field in message.__dataclass_fields__
        if isinstance(getattr(message, field), np.ndarray)
    ]
    if len(arrays) != 1:
        listed = ", ".join(_short(known) for known in ROTOR_FIELDS)
        raise InputError(
            f"{name} is of type {_short(kind)} with {len(arrays)} arrays of numbers, expected 1",
            f"record the speeds as one of {listed}",
            where,
        )
    return arrays[0]


def _short(kind: str) -> str:
    """The name of a message type as it is written in ROS 1 and in speech."""
    return kind.replace("/msg/", "/")
