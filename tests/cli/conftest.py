from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.cli import main

from .fit_inputs import QUICK, tunnel_table

RPM, SPEED, BETA = 4000.0, 14.0, 80.0
POINT = ["--rpm", "4000", "--speed", "14", "--beta", "80"]
ROTOR = ["apc-8x6e", "--airfoil", "paper-apc"]


@dataclass(frozen=True)
class Outcome:
    code: int
    out: str
    err: str


Run = Callable[..., Outcome]


def refused(done: Outcome, *words: str) -> None:
    assert (done.code, done.out) == (2, "")
    *_, last = done.err.splitlines()
    assert last.startswith("propmap: error: ")
    for word in words:
        assert word in last
    assert "Traceback" not in done.err


@pytest.fixture(autouse=True)
def _workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty folder."""
    monkeypatch.chdir(tmp_path)


def shorten_fits(patch: pytest.MonkeyPatch) -> None:
    """End fits after few steps, and without a search for failing assumptions."""
    patch.setattr("propmap.fit.least_squares.FINAL_EVALUATIONS", 8)
    patch.setattr("propmap.fit.comparison.POOR", np.inf)


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten fits in a test.

    Tests that patch the same names use the same ``monkeypatch``, which restores them in order.
    """
    shorten_fits(monkeypatch)


@pytest.fixture(scope="module")
def filters_once() -> Iterator[None]:
    """Filters for logs of one rate are designed once: that takes longer than to use them."""
    import scipy.signal

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scipy.signal, "butter", functools.cache(scipy.signal.butter))
        yield


@pytest.fixture(scope="module")
def pictures_as_they_fall() -> Iterator[None]:
    """Pictures are drawn without laying them out, which takes longer; ``tests/report`` does."""
    with pytest.MonkeyPatch.context() as patch:
        engine = "matplotlib.layout_engine.ConstrainedLayoutEngine.execute"
        patch.setattr(engine, lambda *_: None)
        yield


@pytest.fixture(scope="session")
def tunnel_csv(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fit") / "tunnel.csv"
    path.write_text(tunnel_table())
    return path


@pytest.fixture(scope="session")
def tunnel_fit(tunnel_csv: Path) -> Path:
    fit = tunnel_csv.with_name("tunnel_fit.toml")
    with pytest.MonkeyPatch.context() as patch:
        shorten_fits(patch)
        assert main(["fit", "tunnel", "apc-8x6e", str(tunnel_csv), *QUICK, "-o", str(fit)]) == 0
    return fit


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `propmap` in this process."""

    def call(*arguments: object) -> Outcome:
        code = main([str(argument) for argument in arguments])
        return Outcome(code, *capsys.readouterr())

    return call


@pytest.fixture(scope="session")
def rotor() -> propmap.Rotor:
    return propmap.Rotor(
        propmap.Model(
            propmap.propeller("apc-8x6e"),
            propmap.airfoil("paper-apc"),
            corrections=propmap.model_corrections("recommended"),
        )
    )
