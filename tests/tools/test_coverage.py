"""What the bands hold of measurements, and that their numbers are those of the campaigns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap import bands
from propmap.model.corrections import TYPICAL_FACTOR
from tools.coverage import axial_z_scores, campaigns, in_plane, shares_of, vehicles

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.exists(), reason="needs the reference data")
BAND = 1.959964


@needs_data
@pytest.mark.slow
def test_axial_bands_hold_runs_that_were_left_out() -> None:
    for name, scores in axial_z_scores(DATA).items():
        assert scores.size > 4000
        assert 0.92 <= np.mean(np.abs(scores) <= BAND) <= 0.98, name
        assert 0.7 <= np.sqrt(np.mean(scores**2)) <= 1.3, name


@needs_data
def test_oblique_bands_hold_two_tunnels() -> None:
    least = {"thrust": 0.88, "torque": 0.88, "drag": 0.88}
    least |= {"roll_moment": 0.84, "side_force": 0.80, "pitch_moment": 0.80}
    for one in campaigns(DATA):
        for name in one.measured:
            held = np.mean(np.abs(one.z_scores(name)) <= BAND)
            assert held >= least[name], (one.name, name, held)


@needs_data
def test_the_torque_of_the_second_tunnel_is_inside_at_every_point() -> None:
    _, second = campaigns(DATA)
    assert (np.abs(second.z_scores("torque")) <= BAND).all()


@needs_data
@pytest.mark.slow
def test_shares_are_those_that_the_campaigns_give() -> None:
    for name, share in shares_of(campaigns(DATA)).items():
        table = bands.OBLIQUE if name in bands.OBLIQUE else bands.INPLANE
        assert table[name] == pytest.approx(share, abs=0.02), name


@needs_data
def test_installed_drag_by_name() -> None:
    first, _ = campaigns(DATA)
    drag = first.loads().drag
    assert np.sqrt(np.mean((drag / first.measured["drag"] - 1.0) ** 2)) <= 0.10
    found = list(in_plane(DATA))
    assert len(found) == 20
    errors = np.array([one.installed.drag / one.measured - 1.0 for one in found])
    assert np.median(np.sqrt(np.mean(errors**2, axis=1))) <= 0.20
    # The factor lies between the two tunnels'.
    factors = [one.factor for one in found]
    assert np.mean(factors) < TYPICAL_FACTOR[0] < 2.8
    assert np.std(factors, ddof=1) < TYPICAL_FACTOR[1]


def test_whole_vehicles_have_more_than_bare_blades() -> None:
    for name, _, bare, installed, half in vehicles():
        assert 0.3 < bare < 0.75 < installed < bare + 3.0 * half, name
