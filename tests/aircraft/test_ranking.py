"""The ranking of propellers, checked by flying its first and its last by hand."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest

import propmap
from propmap.aircraft.mission import Mission
from propmap.aircraft.ranking import (
    Candidate,
    Judged,
    Ranking,
    Task,
    beats,
    catalogue_candidates,
    file_candidate,
    pareto,
)
from propmap.aircraft.trim import Aircraft
from propmap.catalogue.identified import identified
from propmap.errors import InputError
from tests.workers_elsewhere import Elsewhere

from .conftest import quadcopter

INCH = 0.0254
CLOSE = 5
"""The best, whose deviations are computed."""
RECOMMENDED = propmap.model_corrections("recommended")


@pytest.fixture(scope="module")
def candidates() -> list[Candidate]:
    """All of 9 to 10 in, and one that is too small."""
    return [
        *catalogue_candidates((9.0 * INCH, 10.0 * INCH)),
        catalogue_candidates((0.0, 2.5 * INCH))[0],
    ]


@pytest.fixture(scope="module")
def judged(candidates: list[Candidate]) -> list[Judged]:
    ranking = Ranking(quadcopter(), Task("cruise", 12.0), RECOMMENDED)
    # As on a cluster: by workers to whom all is sent, in any order.
    found = ranking.judged(candidates, workers=Elsewhere())
    return ranking.with_deviations(found[:CLOSE]) + found[CLOSE:]


@pytest.mark.slow
def test_the_best_come_first(judged: list[Judged]) -> None:
    feasible = [one for one in judged if one.feasible]
    scores = [one.score for one in feasible]
    assert len(scores) >= 40 and scores == sorted(scores)
    assert not judged[-1].feasible and math.isnan(judged[-1].score)
    assert judged[-1].why_not.startswith("hover: beyond") and "%" in judged[-1].why_not


@pytest.mark.slow
def test_the_first_three_and_the_last_by_hand(judged: list[Judged]) -> None:
    """By the full model, each on its own, without what the ranking shares."""
    feasible = [one for one in judged if one.feasible]
    for one in (*feasible[:3], feasible[-1]):
        blade = one.candidate.propeller
        known = identified(blade.name, blade.blades)
        assert known is not None
        vehicle = replace(quadcopter(), propeller=blade)
        model = propmap.Model(blade, known.airfoil, vehicle.air, RECOMMENDED)
        states = Aircraft(vehicle, propmap.Rotor(model)).steady([0.0, 12.0])
        assert one.score == pytest.approx(states.electrical_power[1] / 12.0, rel=1e-3)
        assert one.hover_power == pytest.approx(states.electrical_power[0], rel=1e-3)
        assert one.thrust_margin == pytest.approx(states.thrust_margin[0], rel=2e-3)


@pytest.mark.slow
def test_deviations_and_what_they_separate(judged: list[Judged]) -> None:
    first = judged[:CLOSE]
    for one in first:
        assert 0.0 < one.deviation < 0.3 * one.score
    assert math.isnan(judged[CLOSE].deviation)
    for better, worse in itertools.pairwise(first):
        gap = worse.score - better.score
        spread = math.hypot(better.deviation, worse.deviation)
        assert beats(better, worse) == pytest.approx(NormalDist().cdf(gap / spread))
    # Neighbors are not separated, the first and the last of these are more than they.
    assert beats(first[0], first[1]) < 0.95
    assert beats(first[0], first[1]) < beats(first[0], first[-1])


@pytest.mark.slow
def test_the_front_is_not_beaten(judged: list[Judged]) -> None:
    front = pareto(judged)
    assert front.size >= 1
    for k in front:
        for other in judged:
            if other.feasible:
                assert not (
                    other.hover_power < judged[k].hover_power
                    and other.top_speed > judged[k].top_speed
                )


def invented(score: float, deviation: float) -> Judged:
    nothing = Candidate("x", propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    return Judged(nothing, score, deviation, 1.0, 1.0, 1.0, 1.0, 2.0, 20.0, "", "")


def test_the_probability_of_beating() -> None:
    """Against a draw of both scores."""
    a, b = invented(100.0, 3.0), invented(105.0, 4.0)
    draw = np.random.default_rng(3)
    share = np.mean(
        100.0 + 3.0 * draw.standard_normal(200_000) < 105.0 + 4.0 * draw.standard_normal(200_000)
    )
    assert beats(a, b) == pytest.approx(share, abs=5e-3)
    assert beats(a, invented(100.0, 4.0)) == pytest.approx(0.5)
    assert math.isnan(beats(a, invented(105.0, math.nan)))


def test_constants_vary_by_their_covariance() -> None:
    one = catalogue_candidates((0.2539, 0.2541))[0]
    varied = one.varied()
    assert one.covariance is not None
    names = one.covariance.names
    steps = np.array(
        [[getattr(v.airfoil, n) - getattr(one.airfoil, n) for n in names] for v in varied]
    )
    assert steps.T @ steps == pytest.approx(one.covariance.matrix, abs=1e-6)


def test_candidates() -> None:
    assert len(catalogue_candidates()) == 143
    tens = catalogue_candidates((9.9 * INCH, 10.1 * INCH), 2)
    assert tens and all(abs(one.propeller.diameter - 10.0 * INCH) < 0.1 * INCH for one in tens)
    with pytest.raises(InputError, match="no propeller of the catalogue"):
        catalogue_candidates((1.0, 2.0))
    own = file_candidate("apc-8x6e")
    assert own.covariance is not None and own.verdict != "section law as given"
    given = file_candidate("apc-8x6e", propmap.airfoil("paper-apc"))
    assert given.covariance is None and given.varied() == []
    # What was never measured has the spread of its like.
    likely = file_candidate("HQ 10x5x3")
    assert likely.propeller.blades == 3 and likely.varied()


@pytest.mark.slow
def test_the_longest_flight_is_that_of_least_power(candidates: list[Candidate]) -> None:
    """At one voltage; and the way is time times speed."""
    some = [one for one in candidates if one.name.startswith("uiuc-apcsf")][:3]
    by = {
        measure: Ranking(quadcopter(), Task("cruise", 12.0, measure=measure), RECOMMENDED).judged(
            some
        )
        for measure in ("energy", "time", "range")
    }
    names = {measure: [one.candidate.name for one in found] for measure, found in by.items()}
    assert names["energy"] == names["time"] == names["range"]
    for lasts, reaches in zip(by["time"], by["range"], strict=True):
        assert lasts.score == pytest.approx(lasts.cruise_time)
        assert reaches.score == pytest.approx(12.0 * lasts.score)


def test_disks_that_overlap_do_not_fit() -> None:
    (one,) = [c for c in catalogue_candidates() if c.name == "uiuc-apcsf-10x4.7"]
    vehicle = quadcopter()
    close = tuple(
        replace(m, position=(0.5 * m.position[0], 0.5 * m.position[1], 0.0)) for m in vehicle.mounts
    )
    ranking = Ranking(replace(vehicle, mounts=close), Task("hover", 10.0), RECOMMENDED)
    found = ranking.judge(one)
    assert not found.feasible and "overlap" in found.why_not


def test_bad_tasks() -> None:
    legs = Mission(np.array([1.0]), np.array([0.0]), np.array([1.0]))
    for task, told in (
        (("loiter", 10.0), "choose from hover"),
        (("cruise",), "cruise has no speed"),
        (("fast", 10.0, None, 1.5, "time"), "not ranked by time"),
        (("cruise", 0.0), "above 0"),
        (("cruise", math.nan), "above 0"),
        (("mission", 10.0), "give a mission"),
        (("hover", 10.0, legs), "give a mission"),
    ):
        with pytest.raises(InputError, match=told):
            Task(*task)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="thrust must carry the weight"):
        Task("hover", 10.0, thrust_margin=0.9)
