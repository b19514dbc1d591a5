"""The simulated scheduler against cases that can be reckoned by hand, and against its bounds."""

from __future__ import annotations

import pytest

from benchmarks.scheduler_simulation import TASKS, Costs, efficiency, least_wall, simulate

FREE = Costs(dispatch=0.0, gap=0.0)


def test_one_worker_does_one_task_after_the_other() -> None:
    assert simulate([1.0, 2.0, 3.0], 1, 1, FREE) == pytest.approx(6.0)
    costs = Costs(dispatch=0.1, gap=0.01)
    # The first waits for its dispatch; the others are there in time.
    assert simulate([1.0] * 5, 1, 1, costs) == pytest.approx(0.1 + 5 * 1.01)


def test_workers_share_cores() -> None:
    assert simulate([1.0] * 4, 2, 2, FREE) == pytest.approx(2.0)
    assert simulate([1.0] * 4, 4, 2, FREE) == pytest.approx(2.0)
    assert simulate([1.0] * 4, 4, 1, FREE) == pytest.approx(4.0)
    assert simulate([1.0] * 4, 1, 0.5, FREE) == pytest.approx(8.0)
    # Two tasks on one core: the short one ends at 2, when the long one has had 1 of its 3.
    assert simulate([1.0, 3.0], 2, 1, FREE) == pytest.approx(4.0)


def test_a_slow_dispatcher_is_the_limit() -> None:
    costs = Costs(dispatch=0.1, gap=0.0)
    # A hundred workers could do 100 tasks a second, but are handed 10.
    wall = simulate([1.0] * 2000, 100, 100, costs)
    assert wall == pytest.approx(2000 * 0.1, rel=0.02)
    assert efficiency(1.0, 100, costs) == pytest.approx(0.1, rel=0.05)


@pytest.mark.parametrize(("work", "workers"), [(400.0, 7), (40_000.0, 100), (40_000.0, 3000)])
def test_the_time_of_a_large_job_is_what_the_simulation_finds(work: float, workers: int) -> None:
    costs = Costs(dispatch=0.01, gap=0.002)
    wall, task = least_wall(work, workers, costs)
    simulated = {t: simulate([t] * round(work / t), workers, workers, costs) for t in TASKS}
    assert wall == pytest.approx(simulated[task], rel=0.1)
    assert simulated[task] == pytest.approx(min(simulated.values()), rel=0.1)
