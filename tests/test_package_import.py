"""The package imports without its heavy parts."""

from __future__ import annotations

import subprocess
import sys

import pytest

import propmap

HEAVY = ("jax", "scipy", "matplotlib", "xarray", "pandas", "pydantic", "numpy.ma")


def _modules_after(code: str) -> set[str]:
    """What a process has loaded that has run the ``code``."""
    code += "\nimport sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].split())


def test_import_brings_numpy_alone() -> None:
    loaded = {name for name in _modules_after("import propmap") if name.startswith("propmap")}
    assert loaded == {"propmap"}


def test_loads_take_neither_jax_nor_scipy_nor_matplotlib() -> None:
    loaded = _modules_after(
        "import propmap\n"
        "propmap.Rotor(propmap.catalogue_model('APC 8x6E')).loads(600.0, 5.0, [0.1, 0.2])"
    )
    assert not loaded & {*HEAVY, "typer", "rich", "concurrent.futures", "importlib.resources"}


def test_every_public_name_is_found() -> None:
    assert {*propmap.__all__} <= {*dir(propmap)}
    for name in propmap.__all__:
        assert getattr(propmap, name).__name__ == name


def test_a_command_loads_no_other() -> None:
    point = ["--rpm", "6000", "--speed", "10", "--beta", "60"]
    loaded = _modules_after(
        f"from propmap.cli import main; assert main(['predict', 'APC 8x6E', *{point}]) == 0"
    )
    assert not loaded & {*HEAVY, "msgspec", "propmap.cli.fit", "propmap.cli.trim", "propmap.fit"}


def test_the_explorer_draws_without_scipy_and_matplotlib() -> None:
    pytest.importorskip("dash")
    loaded = _modules_after(
        "from propmap.explore.app import Application, Session, Shelf\n"
        "from propmap.explore.views import VIEWS\n"
        "Application(Session(), VIEWS, Shelf())"
    )
    assert "propmap.explore.views.disk" in loaded and not loaded & {"scipy", "matplotlib"}
