"""Pictures of fits: units on every axis, the hover model dashed, measurements as points."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib.colors as colors
import numpy as np
import pytest
from matplotlib.figure import Figure

import propmap
from propmap.errors import InputError
from propmap.fit.tunnel import TunnelData
from propmap.hover import HoverModel
from propmap.report.fit_curves import level_flight, steady_parts, tunnel_fit
from propmap.report.html import HOVER, save
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog, in_vehicle_frame
from propmap.vehicle.vehicle import Mount, Vehicle

MASS = 0.7


def _log(speed: np.ndarray) -> FlightLog:
    """Straight flight of a vehicle with two rotors."""
    n = speed.size
    pitch = 0.006 * speed
    zero = np.zeros(n)
    up = in_vehicle_frame(zero, zero, zero + 1.0, pitch, zero)
    return FlightLog(
        source="a flight",
        time=np.arange(n) * 0.1,
        velocity=in_vehicle_frame(speed, zero, zero, pitch, zero),
        rates=np.zeros((n, 3)),
        up=up,
        specific_force=GRAVITY * up,
        rotor_speed=np.full((n, 2), 420.0),
    )


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    mounts = (Mount((0.0, 0.1, 0.0)), Mount((0.0, -0.1, 0.0), spin="cw"))
    return Vehicle("two rotors", MASS, propmap.propeller("apc-8x6e"), mounts)


@pytest.fixture(scope="module")
def rotor(vehicle: Vehicle) -> propmap.Rotor:
    model = propmap.Model(vehicle.propeller, propmap.airfoil("paper-apc"), vehicle.air)
    return propmap.Rotor(model)


def _has_units(figure: Figure) -> None:
    drawn = [ax for ax in figure.axes if ax.axison]
    assert all(ax.get_ylabel().endswith("]") for ax in drawn)
    assert drawn[-1].get_xlabel().endswith("]")


def _lines(ax: Any, *, dashed: bool) -> list[Any]:
    gray = colors.to_rgba(HOVER["color"])
    return [line for line in ax.lines if (colors.to_rgba(line.get_color()) == gray) == dashed]


def _points(ax: Any) -> list[Any]:
    return [line for line in ax.lines if line.get_linestyle() == "None"]


def test_level_flight(vehicle: Vehicle, rotor: propmap.Rotor, tmp_path: Path) -> None:
    # Given out of order: the curves run with rising speed.
    log = _log(np.array([16.0, 13.0, 14.5]))
    figure = level_flight(vehicle, log, rotor.model.airfoil)
    _has_units(figure)
    save(figure, tmp_path / "level.png")
    assert (tmp_path / "level.png").read_bytes().startswith(b"\x89PNG")
    thrust, drag, torque, error, pitch = figure.axes[:5]
    for ax in (thrust, drag, torque, error):
        (hover,) = _lines(ax, dashed=True)
        assert hover.is_dashed()
        assert hover.get_xdata() == pytest.approx([13.0, 14.5, 16.0])
    k = HoverModel.from_rotor(rotor, 420.0)
    assert _lines(thrust, dashed=True)[0].get_ydata() == pytest.approx(2.0 * k.thrust(420.0))
    assert _lines(torque, dashed=True)[0].get_ydata() == pytest.approx(2.0 * k.torque(420.0))
    loads = rotor.loads_at_velocity(420.0, log.velocity)
    assert torque.lines[1].get_ydata() == pytest.approx(2.0 * loads.torque[[1, 2, 0]])
    # An accelerometer reads the weight along the vertical, seen from the leaning vehicle.
    lean = 0.006 * np.array([13.0, 14.5, 16.0])
    weight = MASS * GRAVITY
    assert _points(thrust)[0].get_ydata() == pytest.approx(weight * np.cos(lean))
    assert _points(drag)[0].get_ydata() == pytest.approx(weight * np.sin(lean))
    assert _points(pitch)[0].get_ydata() == pytest.approx(np.degrees(lean))
    vertical = 2.0 * (loads.thrust * log.up[:, 2] - loads.drag * log.up[:, 0])
    assert error.lines[1].get_ydata() == pytest.approx(vertical[[1, 2, 0]] - weight)
    silent = replace(log, specific_force=np.full((3, 3), np.nan))
    legend = level_flight(vehicle, silent, rotor.model.airfoil).axes[5].get_legend()
    assert "measured: pitch angle" in [text.get_text() for text in legend.get_texts()]


def test_steady_parts() -> None:
    log = _log(np.concatenate([np.full(40, 3.0), np.linspace(3.0, 8.0, 20), np.full(40, 8.0)]))
    figure = steady_parts(log, [slice(0, 40), slice(60, 100)])
    _has_units(figure)
    speed, _, rotors = figure.axes
    for ax in figure.axes:
        spans = [patch.get_x() + np.array([0.0, patch.get_width()]) for patch in ax.patches]
        assert np.array(spans) == pytest.approx(np.array([[0.0, 3.9], [6.0, 9.9]]))
    means = [line.get_ydata()[0] for line in speed.lines if line not in _points(speed)]
    assert means == pytest.approx([3.0, 8.0])
    assert rotors.lines[0].get_ydata() == pytest.approx(420.0 * 30.0 / np.pi)
    assert "2 steady segments, 8 of 10 s" in figure.get_suptitle()


def test_tunnel_fit(rotor: propmap.Rotor) -> None:
    speed = np.array([13.0, 14.0, 15.0, 14.0])
    omega = np.array([420.0, 420.0, 420.0, 400.0])
    thrust = np.array([3.0, 3.1, np.nan, 2.5])
    data = TunnelData(
        "tunnel.csv", omega, speed, np.full(4, 1.4), {"thrust": thrust, "drag": 0.1 * thrust}
    )
    figure = tunnel_fit(data, rotor).figure()
    _has_units(figure)
    first, second = figure.axes[:2]
    assert second.get_ylabel() == "predicted rotor drag D [N]"
    (points,) = _points(first)
    found = rotor.loads(omega, speed, 1.4)
    keep = np.isfinite(thrust)
    assert points.get_xdata() == pytest.approx(thrust[keep])
    assert points.get_ydata() == pytest.approx(found.thrust[keep])
    # Two rotational speeds make two dashes of the thrust; of the drag the model says nothing.
    dashes = _lines(first, dashed=True)
    k = HoverModel.from_rotor(rotor)
    levels = sorted(float(line.get_ydata()[0]) for line in dashes)
    assert levels == pytest.approx([float(k.thrust(w)) for w in (400.0, 420.0)])
    assert [line.get_ydata()[0] for line in _lines(second, dashed=True)] == [0.0]
    with pytest.raises(InputError, match="no load to draw"):
        tunnel_fit(TunnelData("t.csv", omega, speed, speed, {"thrust": thrust * np.nan}), rotor)
