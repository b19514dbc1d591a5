"""Writers of flight logs in the formats that propmap reads, and the ``[log]`` tables for them.

They share no code with the readers.  The heading, which a ``FlightLog`` does not have, follows
from the yaw rate; the log has to be for still air.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from propmap.typing import Floats
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle

from .ros_messages import Messages

FLIP = np.diag([1.0, -1.0, -1.0])
"""FLU to FRD."""

NED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
"""ENU to NED."""

RPM = np.pi / 30.0
START = 1_700_000_000.0
"""[s] at which bags begin."""


def attitude(log: FlightLog) -> Rotation:
    """From the vehicle's axes (FLU) to east, north, up."""
    turn = np.sum(log.rates * log.up, axis=1)
    steps = 0.5 * (turn[1:] + turn[:-1]) * np.diff(log.time)
    yaw = 0.3 + np.concatenate([[0.0], np.cumsum(steps)])
    pitch = -np.arcsin(np.clip(log.up[:, 0], -1.0, 1.0))
    roll = np.arctan2(log.up[:, 1], log.up[:, 2])
    return Rotation.from_euler("ZYX", np.stack([yaw, pitch, roll], axis=1))


class InFrames:
    """The vectors of a log in the frames of a file."""

    def __init__(self, log: FlightLog, body_frame: str, world_frame: str) -> None:
        body = np.eye(3) if body_frame == "flu" else FLIP
        world = np.eye(3) if world_frame == "enu" else NED
        self.to_enu = attitude(log)
        self.rotation = Rotation.from_matrix(world @ self.to_enu.as_matrix() @ body.T)
        self.world_velocity = self.to_enu.apply(log.velocity) @ world.T
        self.body_velocity = log.velocity @ body.T
        self.rates = log.rates @ body.T
        self.specific_force = log.specific_force @ body.T

    @property
    def quaternion(self) -> Floats:
        """w, x, y, z; w > 0, so that the sign jumps."""
        return np.asarray(self.rotation.as_quat(canonical=True, scalar_first=True))


def _log_table(**texts: str) -> str:
    return "\n".join(["[log]", *(f'{key} = "{value}"' for key, value in texts.items()), ""])


def csv_columns(
    log: FlightLog,
    *,
    body_frame: str = "flu",
    world_frame: str = "enu",
    velocity_in: str = "body",
    rotor_unit: str = "rad/s",
    angles: bool = False,
) -> tuple[dict[str, Floats], str]:
    """The columns of a table of the log, by name, and the ``[log]`` table that names them."""
    seen = InFrames(log, body_frame, world_frame)
    velocity = seen.body_velocity if velocity_in == "body" else seen.world_velocity
    columns = {"time_s": log.time}
    columns |= dict(zip(("vx", "vy", "vz"), velocity.T, strict=True))
    columns |= dict(zip(("p", "q", "r"), seen.rates.T, strict=True))
    columns |= dict(zip(("ax", "ay", "az"), seen.specific_force.T, strict=True))
    if angles:
        turns = seen.rotation.as_euler("ZYX")[:, ::-1]
        columns |= dict(zip(("roll", "pitch", "yaw"), turns.T, strict=True))
        attitude_map = [f'{name} = "{name}"' for name in ("roll", "pitch", "yaw")]
    else:
        columns |= dict(zip(("qw", "qx", "qy", "qz"), seen.quaternion.T, strict=True))
        attitude_map = [f'{name} = "{name}"' for name in ("qw", "qx", "qy", "qz")]
    speeds = log.rotor_speed / (RPM if rotor_unit == "rpm" else 1.0)
    rotors = [f"rotor_{k}" for k in range(1, speeds.shape[1] + 1)]
    columns |= dict(zip(rotors, speeds.T, strict=True))
    table = _log_table(
        body_frame=body_frame,
        world_frame=world_frame,
        velocity_in=velocity_in,
        rotor_unit=rotor_unit,
    ) + "\n".join(
        [
            "[log.columns]",
            'time = "time_s"',
            'velocity = ["vx", "vy", "vz"]',
            'rates = ["p", "q", "r"]',
            'specific_force = ["ax", "ay", "az"]',
            f"rotor_speed = {rotors}",
            *attitude_map,
            "",
        ]
    )
    return columns, table


def write_csv(log: FlightLog, path: Path, **options: Any) -> str:
    """Write a CSV file; ``options`` as for ``csv_columns``.  Gives the ``[log]`` table."""
    columns, table = csv_columns(log, **options)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    return table


def write_bag(
    log: FlightLog,
    path: Path,
    vehicle: Vehicle,
    *,
    storage: str = "sqlite3",
    rotor_type: str = "std_msgs/msg/Float64MultiArray",
    odometry: bool = True,
    every: Mapping[str, int] | None = None,
) -> str:
    """Write a bag: ``storage`` "sqlite3" or "mcap" (ROS 2, a folder) or "ros1" (a .bag file).

    rotor_type : Float64MultiArray, Int32MultiArray or sensor_msgs/msg/JointState.
    odometry : else a pose and a twist in the world frame.  every : of a topic's messages, one of so
    many is recorded, by default each.
    """
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    assert len(vehicle.mounts) == log.rotor_speed.shape[1]
    ros1 = storage == "ros1"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    make = Messages(store, ros1)
    seen = InFrames(log, "flu", "enu")
    topics = {"/imu": "sensor_msgs/msg/Imu", "/rotor_speed": rotor_type}
    if odometry:
        topics["/odometry"] = "nav_msgs/msg/Odometry"
    else:
        topics["/pose"] = "geometry_msgs/msg/PoseStamped"
        topics["/twist"] = "geometry_msgs/msg/TwistStamped"
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    writer: Any = Writer1(path) if ros1 else Writer2(path, version=9, storage_plugin=plugin)
    serialize = store.serialize_ros1 if ros1 else store.serialize_cdr
    with writer:
        connections = {
            topic: writer.add_connection(topic, kind, typestore=store)
            for topic, kind in topics.items()
        }
        for i, time in enumerate(log.time.tolist()):
            stamp = round((START + time) * 1e9)
            pose = make.pose(seen.quaternion[i])
            messages = {
                "/imu": make.imu(stamp, seen.rates[i], seen.specific_force[i]),
                "/rotor_speed": make.rotors(rotor_type, stamp, log.rotor_speed[i]),
            }
            if odometry:
                twist = make.twist(seen.body_velocity[i], seen.rates[i])
                messages["/odometry"] = make.odometry(stamp, pose, twist)
            else:
                twist = make.twist(seen.world_velocity[i], np.zeros(3))
                messages["/pose"] = make.new(
                    "geometry_msgs/msg/PoseStamped", header=make.header(stamp), pose=pose
                )
                messages["/twist"] = make.new(
                    "geometry_msgs/msg/TwistStamped", header=make.header(stamp), twist=twist
                )
            for topic, message in messages.items():
                if i % (every or {}).get(topic, 1):
                    continue
                # What has no header is recorded without delay.
                delay = 0 if "Array" in topics[topic] else 2_000_000
                data = serialize(message, topics[topic])
                writer.write(connections[topic], stamp + delay, data)
    named = {"imu": "/imu", "rotor_speed": "/rotor_speed"}
    named |= {"odometry": "/odometry"} if odometry else {"pose": "/pose", "velocity": "/twist"}
    extra = {} if odometry else {"velocity_in": "world"}
    lines = [f'{role} = "{topic}"' for role, topic in named.items()]
    return _log_table(rotor_unit="rad/s", **extra) + "\n".join(["[log.topics]", *lines, ""])
