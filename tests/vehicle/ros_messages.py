"""Messages of ROS 1 and ROS 2, for the bags that the tests write."""

from __future__ import annotations

from typing import Any

import numpy as np

from propmap.typing import Floats


class Messages:
    """Messages of one version of ROS."""

    def __init__(self, store: Any, ros1: bool) -> None:
        self.types, self.ros1 = store.types, ros1

    def new(self, kind: str, **fields: Any) -> Any:
        return self.types[kind](**fields)

    def header(self, stamp: int) -> Any:
        seconds, rest = divmod(stamp, 10**9)
        time = self.new("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
        sequence = {"seq": 0} if self.ros1 else {}
        return self.new("std_msgs/msg/Header", stamp=time, frame_id="", **sequence)

    def vector(self, values: Floats, kind: str = "geometry_msgs/msg/Vector3") -> Any:
        return self.new(kind, **dict(zip("xyz", map(float, values), strict=True)))

    def quaternion(self, values: Floats) -> Any:
        w, x, y, z = map(float, values)
        return self.new("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)

    def pose(self, quaternion: Floats) -> Any:
        position = self.vector(np.zeros(3), "geometry_msgs/msg/Point")
        orientation = self.quaternion(quaternion)
        return self.new("geometry_msgs/msg/Pose", position=position, orientation=orientation)

    def twist(self, linear: Floats, angular: Floats) -> Any:
        return self.new(
            "geometry_msgs/msg/Twist", linear=self.vector(linear), angular=self.vector(angular)
        )

    def odometry(self, stamp: int, pose: Any, twist: Any) -> Any:
        covariance = np.zeros(36)
        with_pose, with_twist = (f"geometry_msgs/msg/{k}WithCovariance" for k in ("Pose", "Twist"))
        return self.new(
            "nav_msgs/msg/Odometry",
            header=self.header(stamp),
            child_frame_id="",
            pose=self.new(with_pose, pose=pose, covariance=covariance),
            twist=self.new(with_twist, twist=twist, covariance=covariance),
        )

    def imu(self, stamp: int, rates: Floats, force: Floats) -> Any:
        return self.new(
            "sensor_msgs/msg/Imu",
            header=self.header(stamp),
            orientation=self.quaternion(np.array([1.0, 0.0, 0.0, 0.0])),
            orientation_covariance=np.zeros(9),
            angular_velocity=self.vector(rates),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=self.vector(force),
            linear_acceleration_covariance=np.zeros(9),
        )

    def rotors(self, kind: str, stamp: int, speeds: Floats) -> Any:
        if kind == "sensor_msgs/msg/JointState":
            names = [f"rotor_{k}" for k in range(1, speeds.size + 1)]
            empty = np.zeros(0)
            return self.new(
                kind,
                header=self.header(stamp),
                name=names,
                position=empty,
                velocity=speeds,
                effort=empty,
            )
        layout = self.new("std_msgs/msg/MultiArrayLayout", dim=[], data_offset=0)
        if "Int32" in kind:
            speeds = np.round(speeds).astype(np.int32)
        return self.new(kind, layout=layout, data=speeds)
