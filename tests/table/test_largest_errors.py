"""The search for the largest errors, on a model whose errors are known and on the 8x6E."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.loads import LOADS
from propmap.table import STATUSES, LoadTable, build_table
from propmap.table.build import refine
from propmap.table.interpolation import UNRESOLVED_BIT, TableContent, points_at, positions_of
from propmap.table.verification import CachedModel, certify, compare, quasi_random

from .conftest import OffRotor, invented_content, random_points

RPM = np.pi / 30.0
PEAK, WIDTH = 0.02, 0.25
SPIKES = {"thrust": (23.6, 11.3, 0.5), "torque": (24.9, 29.7, 0.0)}
"""Where one load is off, in cells along both axes and as a share of the omegas there: at advance
ratios that few points of the envelope have."""


def _off(content: TableContent, omega: Any, advance: Any, beta: Any) -> dict[str, Any]:
    """Each load is off in a quarter of a cell; elsewhere by a thousandth of that."""
    position, found = positions_of(content, omega, advance, beta), {}
    for load, place in SPIKES.items():
        away = np.sum(((position - place) / (WIDTH, WIDTH, 2.0)) ** 2, axis=1)
        found[load] = PEAK * (0.001 + 0.999 * np.exp(-away))
    return found


@pytest.fixture(scope="module")
def spiked(invented: LoadTable) -> CachedModel:
    rotor: Any = OffRotor(invented, _off)
    return CachedModel(rotor, invented.content.omega)


def test_a_spike_between_samples_is_found(invented: LoadTable, spiked: CachedModel) -> None:
    points, seed = 4096, 1
    sampled = compare(invented, spiked, *quasi_random(invented, points, seed))
    before = spiked.evaluations
    told, _ = certify(invented, spiked, 0.005, points=points, seed=seed)
    assert not told.holds and told.search_points <= 8 * points
    assert spiked.evaluations - before == told.points + told.search_points
    for k, load in enumerate(LOADS):
        if load not in SPIKES:
            assert told.max_error[load] < 1e-9
            continue
        assert np.abs(sampled.errors[:, k]).max() < 0.5 * PEAK
        assert told.max_error[load] == pytest.approx(PEAK, rel=0.05)
        assert told.max_error[load] <= PEAK * (1.0 + 1e-9)
        omega, speed, beta = (
            np.array([places[load]]) for places in (told.max_omega, told.max_speed, told.max_beta)
        )
        advance = speed / (omega * invented.content.radius)
        found = positions_of(invented.content, omega, advance, beta)[0]
        np.testing.assert_allclose(found[:2], SPIKES[load][:2], atol=0.05)
        # What is stated is the error there.
        there = compare(invented, spiked, omega, speed, beta).errors[0, k]
        assert told.max_error[load] == pytest.approx(abs(there), rel=1e-12)


def test_errors_in_unresolved_cells_are_climbed_apart(
    invented: LoadTable, spiked: CachedModel
) -> None:
    """With the cell of the thrust's spike marked, what is left of it is largest at the cell's
    nearest edge, 0.3 of a cell away along beta."""
    content = invented.content
    cells = content.cells.copy()
    cells[23, 11] = UNRESOLVED_BIT
    table = LoadTable(replace(content, cells=cells))
    told, known = certify(table, spiked, 0.005, points=4096, seed=1)
    assert told.unresolved_max_error["thrust"] == pytest.approx(PEAK, rel=0.05)
    beside = PEAK * (0.001 + 0.999 * np.exp(-((0.3 / WIDTH) ** 2)))
    assert told.max_error["thrust"] == pytest.approx(beside, rel=0.05)
    assert told.max_error["torque"] == pytest.approx(PEAK, rel=0.05)
    assert (known.code != STATUSES.index("unresolved")).all()


def test_positions_and_points_are_inverse_and_stay_in_the_envelope() -> None:
    """The faces of the box too, and where only one omega has the advance ratio."""
    content = invented_content()
    omega, speed, beta = random_points(LoadTable(content), 5000, seed=3)
    advance = speed / (omega * content.radius)
    back = points_at(content, positions_of(content, omega, advance, beta))
    np.testing.assert_allclose(np.stack(back), np.stack([omega, speed, beta]), rtol=1e-9)
    ends = np.array([content.advance.size - 1.0, content.beta.size - 1.0, 1.0])
    corners = np.stack(np.meshgrid([0, 0.5, 1], [0, 0.5, 1], [0, 0.5, 1]), -1).reshape(-1, 3)
    omega, speed, beta = points_at(content, corners * ends)
    assert LoadTable(content).loads(omega, speed, beta).inside.all()
    last = corners[:, 0] == 1
    np.testing.assert_allclose(omega[last], content.omega[0])
    np.testing.assert_allclose(speed[last], content.speed[1])


def test_cells_in_which_the_certificate_fails_are_halved(
    rotor: propmap.Rotor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Knots placed for ten times the tolerance, and no jumps looked for: the certificate sees to
    it."""
    axes: list[int] = []

    def coarse(model: Any, advance: Any, beta: Any, tolerance: float) -> Any:
        axes.append(advance.knots.size * beta.knots.size)
        return refine(model, advance, beta, 10.0 * tolerance)

    monkeypatch.setattr("propmap.table.build.refine", coarse)
    monkeypatch.setattr("propmap.table.build.find_jumps", lambda content, *_: content)
    monkeypatch.setattr("propmap.table.build.FIRST_KNOTS", 4)
    table = build_table(
        rotor,
        omega=(420.0, 460.0),
        speed=(0.0, 12.0),
        beta=(0.0, 1.2),
        tolerance=0.005,
        certificate_points=1024,
    )
    assert len(axes) > 1 and axes == sorted(axes)
    assert table.certificate["holds"]
    assert table.certificate["unresolved_volume"] < 0.01
