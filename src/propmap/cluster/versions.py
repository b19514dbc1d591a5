"""Whether client, scheduler and workers have the same versions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from propmap.errors import InputError

if TYPE_CHECKING:
    from distributed import Client

SAME = ("propmap", "numpy", "python", "distributed")
"""What must be of one version everywhere: loads, or what is sent, depend on it."""


def check_versions(client: Client) -> None:
    """Raise ``InputError`` for no workers and for versions that differ.

    Parameters
    ----------
    client : distributed.Client
        Connected to the scheduler.
    """
    found: Any = client.get_versions(packages=list(SAME))
    if not found["workers"]:
        raise InputError(
            "the scheduler has no workers",
            f"start some: dask worker {client.scheduler.address}",
            str(client.scheduler.address),
        )
    for message in differences(found):
        raise InputError(*message)


def differences(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """What differs from the client's versions, and the remedy.

    Parameters
    ----------
    found : mapping
        As ``Client.get_versions`` gives it.
    """
    own = _versions(found["client"])
    others = {"the scheduler": found["scheduler"]}
    others |= {f"worker {address}": told for address, told in found["workers"].items()}
    for who, told in others.items():
        theirs = _versions(told)
        for package in SAME:
            if theirs.get(package) is None:
                remedy = f"install propmap {own['propmap']} with its extra cluster there"
                yield f"{who} does not have {package}", remedy
            elif theirs[package] != own[package]:
                yield (
                    f"{who} has {package} {theirs[package]}, the client {own[package]}",
                    "install the same version on both",
                )


def _versions(told: Any) -> dict[str, str | None]:
    if not isinstance(told, Mapping):
        return {}  # of a worker that did not answer
    # "3.12.3.final.0": what is sent depends on the first two numbers.
    python = ".".join(str(told["host"]["python"]).split(".")[:2])
    return {**told["packages"], "python": python}
