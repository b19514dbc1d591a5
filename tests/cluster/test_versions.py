"""Versions that differ, packages that are missing, schedulers without workers: one line each."""

from __future__ import annotations

import copy
from types import SimpleNamespace
from typing import Any

import pytest

from propmap.cluster import DaskWorkers, differences
from propmap.errors import InputError

SAME: dict[str, Any] = {
    "host": {"python": "3.12.3.final.0"},
    "packages": {"propmap": "0.1.0", "numpy": "2.4.6", "distributed": "2026.8.0"},
}
ADDRESS = "tcp://10.0.0.1:4000"


def found(who: str, package: str, version: str | None) -> dict[str, Any]:
    """As ``Client.get_versions``, with another version of a package somewhere."""
    other = copy.deepcopy(SAME)
    if package == "python":
        other["host"]["python"] = version
    else:
        other["packages"][package] = version
    told = {"client": SAME, "scheduler": SAME, "workers": {ADDRESS: SAME}}
    return told | ({"scheduler": other} if who == "scheduler" else {"workers": {ADDRESS: other}})


def test_the_same_everywhere_is_right_and_so_is_another_patch_of_python() -> None:
    assert not list(differences(found("worker", "numpy", "2.4.6")))
    assert not list(differences(found("worker", "python", "3.12.9.final.0")))


@pytest.mark.parametrize(
    ("who", "package", "version", "told"),
    [
        ("worker", "propmap", None, f"worker {ADDRESS} does not have propmap; install propmap"),
        ("worker", "propmap", "0.2.0", f"worker {ADDRESS} has propmap 0.2.0, the client has 0.1.0"),
        ("worker", "numpy", "2.3.0", "has numpy 2.3.0, the client has 2.4.6; install the"),
        ("worker", "python", "3.11.7.final.0", "has python 3.11, the client has 3.12"),
        ("scheduler", "propmap", None, "the scheduler does not have propmap"),
    ],
)
def test_differences_are_one_line(who: str, package: str, version: str | None, told: str) -> None:
    client: Any = SimpleNamespace(get_versions=lambda **_: found(who, package, version))
    with pytest.raises(InputError) as refused:
        DaskWorkers(client)
    assert told in str(refused.value) and "\n" not in str(refused.value)


def test_a_worker_that_does_not_answer_is_told() -> None:
    silent = found("worker", "numpy", "2.4.6") | {"workers": {ADDRESS: None}}
    message, _ = next(differences(silent))
    assert ADDRESS in message


def test_a_scheduler_without_workers_is_told() -> None:
    client: Any = SimpleNamespace(
        get_versions=lambda **_: {"client": SAME, "scheduler": SAME, "workers": {}},
        scheduler=SimpleNamespace(address="tcp://10.0.0.1:8786"),
    )
    with pytest.raises(
        InputError, match=r"no workers; start workers: dask worker tcp://10\.0\.0\.1:8786"
    ):
        DaskWorkers(client)
