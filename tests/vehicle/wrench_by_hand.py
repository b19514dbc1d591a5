"""Force and moment on a whole vehicle, summed with loops and scalars over ``Rotor.wrench``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.optimize import brentq

import propmap
from propmap.vehicle.vehicle import Mount, Vehicle
from propmap.vehicle.wakes import frame_of as own_frame
from propmap.vehicle.wakes import seen_wake


def frame_of(axis: np.ndarray) -> np.ndarray:
    """Rows x, y, z of a right-handed frame whose z is the axis."""
    x = np.cross([0.0, 1.0, 0.0], axis)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis])


def one_rotor(
    rotor: propmap.Rotor, mount: Mount, omega: float, hub: np.ndarray, added: float = 0.0
) -> tuple[np.ndarray, np.ndarray, Any, Any]:
    """Force and moment at the hub, thrust and torque."""
    if mount.drag is not None:
        rotor = rotor.with_model(rotor.model.with_mount(mount.drag))
    frame = frame_of(np.array(mount.axis))
    seen = frame @ hub + [0.0, 0.0, added]
    wrench, loads = rotor.wrench(omega, seen, mount.spin), rotor.loads_at_velocity(omega, seen)
    return frame.T @ wrench.force, frame.T @ wrench.moment, loads.thrust, loads.torque


def seen_at(wake: tuple[Any, float], away: np.ndarray) -> np.ndarray:
    """Velocity that a wake carried ``away`` (n, 3), in its rotor's frame, induces at a rotor."""
    spline, bearing = wake
    skew = np.arctan2(np.hypot(away[:, 0], away[:, 1]), -away[:, 2])
    found: np.ndarray = spline.ev(skew, (np.arctan2(away[:, 1], away[:, 0]) - bearing) % math.tau)
    return found


def added_flows(
    rotor: propmap.Rotor, vehicle: Vehicle, omegas: np.ndarray, hubs: list[np.ndarray]
) -> list[float]:
    """What the wakes add at each rotor, pair by pair."""
    radius, rho = vehicle.propeller.radius, vehicle.air.density
    assert vehicle.wakes is not None
    gains, found = vehicle.wakes, []
    for target in vehicle.mounts:
        total = 0.0
        for source, omega, hub in zip(vehicle.mounts, omegas, hubs, strict=True):
            if source is target:
                continue
            frame = frame_of(np.array(source.axis))
            x, y, z = frame @ hub
            across = math.hypot(x, y)
            thrust = float(rotor.attached_thrust(omega, z, across)[0])

            def excess(v: float, t: float = thrust, at: tuple[float, float] = (across, z)) -> float:
                return 2.0 * rho * math.pi * radius**2 * v * math.hypot(at[0], at[1] + v) - t

            inflow = brentq(excess, 0.0, 60.0, xtol=1e-13)
            wake = seen_wake(source, target, radius)
            towards = own_frame(source.axis) @ (-hub - gains.share * inflow * frame[2])
            seen = float(seen_at(wake, towards[None])[0])
            apart = np.subtract(target.position, source.position)
            beside = apart - (apart @ frame[2]) * frame[2]
            cosine = hub @ beside / np.linalg.norm(beside)
            along = cosine**2 / (across**2 + 0.25)
            share = min(max(-seen / 0.005, 0.0), 1.0)
            rising = seen * (3.0 * share**2 - 2.0 * share**3)
            upwash = (gains.ahead * along + gains.beside * (1.0 - along)) * rising
            total += (
                2.0 * inflow * (gains.downwash * (seen - rising) + 0.5 * math.tanh(2.0 * upwash))
            )
        found.append(total)
    return found


def by_hand(
    rotor: propmap.Rotor,
    vehicle: Vehicle,
    omegas: np.ndarray,
    velocity: np.ndarray,
    rates: np.ndarray,
    wind: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Force and moment of the air on a vehicle, and the shafts' power.

    Its momentum has one solution for the wakes in level flight and climb alone.
    """
    through = velocity - wind
    hubs = [through + np.cross(rates, mount.position) for mount in vehicle.mounts]
    added = [0.0] * len(hubs)
    if vehicle.wakes is not None:
        added = added_flows(rotor, vehicle, omegas, hubs)
    force, moment, power = np.zeros(3), np.zeros(3), 0.0
    for mount, omega, hub, more in zip(vehicle.mounts, omegas, hubs, added, strict=True):
        push, turn, _, torque = one_rotor(rotor, mount, omega, hub, more)
        force += push
        moment += turn + np.cross(mount.position, push)
        power += torque * omega
    pressure = 0.5 * vehicle.air.density
    for k in range(3):
        force[k] -= pressure * vehicle.body.drag_area[k] * abs(through[k]) * through[k]
    for k in range(2):
        force[2] -= pressure * vehicle.body.download_area[k] * through[k] ** 2
    force[2] -= pressure * vehicle.body.plate_area * math.hypot(*through) * through[2]
    angle, speed2 = math.atan2(-through[2], through[0]), through[0] ** 2 + through[2] ** 2
    lift = vehicle.body.lift_area * math.sin(angle) * math.cos(angle)
    if vehicle.wing is not None:
        wing = vehicle.wing
        a = (angle + wing.incidence + math.pi) % (2.0 * math.pi) - math.pi
        # The stall blend of eq. (3) with M = 50.
        up, down = math.exp(-50.0 * (a - wing.alpha_0)), math.exp(50.0 * (a + wing.alpha_0))
        sigma = (1.0 + up + down) / ((1.0 + up) * (1.0 + down))
        slope = (1.0 - sigma) * wing.c_l1 * a + sigma * wing.c_l2 * math.sin(a) * math.cos(a)
        lift += wing.area * slope
    across = np.array([-through[2], 0.0, through[0]])
    return force + pressure * lift * math.sqrt(speed2) * across, moment, power
