"""Axes that rotor speeds command: the rank of usual layouts, and the names of dependent axes."""

from __future__ import annotations

import numpy as np
import pytest

from propmap.vehicle.allocation import Allocation

ARM, TORQUE = 0.25, 0.015  # distance of the hubs, torque over thrust [m]
UP = (0.0, 0.0, 1.0)


def ring(count: int, first: float = 0.0) -> np.ndarray:
    """Return hubs on a circle, the first at the angle ``first`` [deg] to the left of the nose."""
    angles = np.radians(first) + 2.0 * np.pi * np.arange(count) / count
    return ARM * np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1)


def turned(count: int, tilt: float, first: float = 0.0) -> np.ndarray:
    """Return thrust axes of ``ring`` that are tilted sideways in turn, by ``tilt`` [deg]."""
    arms = ring(count, first) / ARM
    sideways = np.cross(UP, arms) * np.where(np.arange(count) % 2, -1.0, 1.0)[:, None]
    return np.cos(np.radians(tilt)) * np.array(UP) + np.sin(np.radians(tilt)) * sideways


def allocation(places: np.ndarray, spins: str, axes: object = UP) -> Allocation:
    """Return the allocation of rotors with ``spins`` "+" (ccw) and "-"."""
    torque = TORQUE * np.array([1.0 if spin == "+" else -1.0 for spin in spins])
    return Allocation.of(places, np.broadcast_to(np.asarray(axes, float), places.shape), torque)


BELOW = np.array([0.0, 0.0, 0.05])
X = ring(4, 45.0)  # front left, rear left, rear right, front right
H = X * [1.4, 0.7, 1.0]
AHEAD = X[:, :1] > 0.0
WIDE_AHEAD = X * np.where(AHEAD, [1.0, 2.0, 1.0], 1.0)
WIDER_AHEAD = X * np.where(AHEAD, [1.0, 1.3, 1.0], 1.0)
OFFSET = np.array([0.02, 0.01, 0.0])  # of the hubs from the center of mass
PLANAR = {
    "quad x": (X, "+-+-"),
    "quad +": (ring(4), "+-+-"),
    "quad H": (H, "+-+-"),
    "wide ahead": (WIDE_AHEAD, "+-+-"),
    "hexa": (ring(6), "+-+-+-"),
    "octo": (ring(8, 22.5), "+-+-+-+-"),
    "X8": (np.vstack([X, X - BELOW]), "+-+--+-+"),
    "Y6": (np.vstack([ring(3, 60.0), ring(3, 60.0) - BELOW]), "+++---"),
}


@pytest.mark.parametrize("name", PLANAR)
def test_usual_layouts_command_thrust_and_all_moments(name: str) -> None:
    found = allocation(*PLANAR[name])
    assert sorted(found.commanded) == [0, 1, 2, 3] and found.notes == []
    assert np.linalg.matrix_rank(found.matrix) == 4
    # Yaw is the weakest, by about torque over arm.
    assert 0.8 < found.condition * TORQUE / np.linalg.norm(PLANAR[name][0], axis=1).max() < 1.2


def test_yaw_over_roll_of_a_quadrotor_is_torque_over_arm() -> None:
    side = ARM / np.sqrt(2.0)
    assert allocation(X, "+-+-").yaw_over_roll == pytest.approx(TORQUE / side)
    # With + arms, two of four rotors roll it, at the whole arm.
    assert allocation(ring(4), "+-+-").yaw_over_roll == pytest.approx(2.0 * TORQUE / ARM)


@pytest.mark.parametrize(
    ("places", "spins", "rank", "words"),
    [
        (X, "++--", 3, ["yaw without roll (0% of yaw is independent)"]),
        (X + OFFSET, "++--", 3, ["yaw without roll (0% of yaw is independent)"]),
        (X, "+--+", 3, ["yaw without pitch (0% of yaw is independent)"]),
        (X, "++++", 3, ["yaw without thrust (0% of yaw is independent)"]),
        (WIDER_AHEAD, "++--", 3, ["yaw without roll (13% of yaw"]),
        (ring(3, 60.0), "+++", 3, ["yaw without thrust (0% of yaw is independent)"]),
        (ring(2, 90.0), "+-", 2, ["pitch at all, nor yaw without roll (0% of yaw is independent)"]),
        (ring(1), "+", 1, ["roll at all", "pitch without thrust", "yaw without thrust"]),
        (0.0 * ring(1), "+", 1, ["roll at all", "pitch at all", "yaw without thrust"]),
    ],
)
def test_dependent_axes_are_named(
    places: np.ndarray, spins: str, rank: int, words: list[str]
) -> None:
    found = allocation(places, spins)
    assert len(found.commanded) == rank and np.isinf(found.condition)
    (note,) = found.notes
    assert all(word in note for word in words), note
    assert note.count("nor") == 4 - rank - 1


def test_tilted_rotors_command_by_thrust() -> None:
    """Sideways thrust turns the vehicle, even if the torques of the rotors cancel out of yaw."""
    hexa = allocation(ring(6), "+-+-+-", turned(6, 20.0))
    assert len(hexa.commanded) == np.linalg.matrix_rank(hexa.matrix) == 6
    edge = allocation(X, "++--", turned(4, 10.0, 45.0))
    assert sorted(edge.commanded) == [0, 1, 2, 3] and not edge.notes
    # A pusher adds the force along x to the four axes of the lifting rotors.
    pushed = np.vstack([X, [-0.3, 0.0, 0.0]])
    plane = allocation(pushed, "+-+-+", [*[UP] * 4, (1.0, 0.0, 0.0)])
    assert sorted(plane.commanded) == [0, 1, 2, 3, 4]


def test_a_tail_rotor_commands_yaw_by_thrust() -> None:
    places, axes = np.array([[0.0, 0.0, 0.1], [-1.0, 0.0, 0.0]]), [UP, (0.0, 1.0, 0.0)]
    found = allocation(places, "++", axes)
    assert sorted(found.commanded) == [0, 3]
    assert "roll at all, nor pitch without yaw" in found.notes[0]
    pulling = allocation(np.array([[0.2, 0.0, 0.0]]), "+", (1.0, 0.0, 0.0))
    lost = "roll without thrust (0% of roll is independent), nor pitch at all, nor yaw"
    assert lost in pulling.notes[0]
