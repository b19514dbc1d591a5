"""The ranking of propellers, checked by flying its first and its last by hand."""

from __future__ import annotations

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
from propmap.vehicle.powertrain import Powertrain
from tests.workers_elsewhere import Elsewhere

from .conftest import quadcopter

INCH = 0.0254
RECOMMENDED = propmap.model_corrections("recommended")


@pytest.fixture(scope="module")
def candidates() -> list[Candidate]:
    """All of 9 to 10 in, and one that is too small."""
    return [
        *catalogue_candidates((9.0 * INCH, 10.0 * INCH)),
        catalogue_candidates((0.0, 2.5 * INCH))[0],
    ]


@pytest.mark.slow
def test_the_best_come_first(candidates: list[Candidate]) -> None:
    """Scores are those of the full model, each on its own, without what the ranking shares."""
    ranking = Ranking(quadcopter(), Task("cruise", 12.0), RECOMMENDED)
    # As on a cluster: by workers to whom all is sent, in any order.
    found = ranking.judged(candidates, workers=Elsewhere())
    feasible = [one for one in found if one.feasible]
    scores = [one.score for one in feasible]
    assert len(scores) >= 40 and scores == sorted(scores)
    assert not found[-1].feasible and math.isnan(found[-1].score)
    assert found[-1].why_not.startswith("hover: beyond") and "%" in found[-1].why_not
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

    front = pareto(found)
    assert front.size >= 1
    for k in front:
        better = [one for one in feasible if one.hover_power < found[k].hover_power]
        assert all(one.top_speed <= found[k].top_speed for one in better)

    first = ranking.with_deviations(found[:5])
    assert all(0.0 < one.deviation < 0.3 * one.score for one in first)
    assert math.isnan(found[5].deviation)
    # Neighbors are not separated, the first and the last of these are more than they.
    assert beats(first[0], first[1]) < 0.95
    assert beats(first[0], first[1]) < beats(first[0], first[-1])


def invented(score: float, deviation: float) -> Judged:
    nothing = Candidate("x", propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    return Judged(nothing, score, deviation, 1.0, 1.0, 1.0, 1.0, 2.0, 20.0, "", "")


def test_the_probability_of_beating() -> None:
    """The normal distribution of the difference of both scores."""
    a, b = invented(100.0, 3.0), invented(105.0, 4.0)
    assert beats(a, b) == pytest.approx(NormalDist().cdf(5.0 / 5.0))
    assert beats(a, invented(100.0, 4.0)) == pytest.approx(0.5)
    assert math.isnan(beats(a, invented(105.0, math.nan)))


def test_candidates() -> None:
    assert len(catalogue_candidates()) == 143
    tens = catalogue_candidates((9.9 * INCH, 10.1 * INCH), 2)
    assert tens and all(abs(one.propeller.diameter - 10.0 * INCH) < 0.1 * INCH for one in tens)
    with pytest.raises(InputError, match="no propeller of the catalogue"):
        catalogue_candidates((1.0, 2.0))
    own = file_candidate("apc-8x6e")
    assert own.covariance is not None and own.verdict != "section law as given"
    # Constants vary by their covariance.
    names = own.covariance.names
    steps = np.array(
        [[getattr(v.airfoil, n) - getattr(own.airfoil, n) for n in names] for v in own.varied()]
    )
    assert steps.T @ steps == pytest.approx(own.covariance.matrix, abs=1e-6)
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
    one = file_candidate("uiuc-apcsf-10x4.7")
    vehicle = quadcopter()
    close = tuple(
        replace(m, position=(0.5 * m.position[0], 0.5 * m.position[1], 0.0)) for m in vehicle.mounts
    )
    ranking = Ranking(replace(vehicle, mounts=close), Task("hover", 10.0), RECOMMENDED)
    found = ranking.judge(one)
    assert not found.feasible and "overlap" in found.why_not


def test_a_ranking_without_a_motor_has_no_margin() -> None:
    vehicle = replace(quadcopter(), powertrain=Powertrain())
    some = [file_candidate(name) for name in ("apc-8x6e", "uiuc-apcsf-10x4.7")]
    found = Ranking(vehicle, Task("cruise", 10.0), RECOMMENDED).judged(some)
    assert [one.feasible for one in found] == [True, True]
    assert found[0].candidate is some[1] and found[0].score < found[1].score
    for one in found:
        assert math.isnan(one.thrust_margin) and math.isnan(one.top_speed)
    assert pareto(found).size == 0
    (fast, _) = Ranking(vehicle, Task("fast"), RECOMMENDED).judged(some)
    assert not fast.feasible and fast.why_not == "no top speed was found"
    # With a largest rotor speed, the margin is known, and too small.
    slow = Ranking(vehicle, Task("cruise", 10.0), RECOMMENDED, maximum_rotor_speed=700.0)
    assert slow.judge(some[0]).why_not.startswith("thrust margin in hover is 1.")


def test_bad_tasks() -> None:
    legs = Mission(np.array([1.0]), np.array([0.0]), np.array([1.0]))
    for task, told in (
        (("loiter", 10.0), "choose from hover"),
        (("cruise",), "cruise has no speed"),
        (("fast", 10.0, None, 1.5, "time"), "cannot be ranked by time"),
        (("cruise", 0.0), "above 0"),
        (("mission", 10.0), "give a mission"),
        (("hover", 10.0, legs), "give a mission"),
    ):
        with pytest.raises(InputError, match=told):
            Task(*task)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="thrust must carry the weight"):
        Task("hover", 10.0, thrust_margin=0.9)
