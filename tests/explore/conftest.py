from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from propmap.explore.session import Given, Session, Shelf, read_upload

if TYPE_CHECKING:
    from propmap.explore.app import Application

collect_ignore_glob = [] if importlib.util.find_spec("dash") else ["test_*.py"]
"""Without the extra explore there is nothing to test."""

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def shelf() -> Shelf:
    return Shelf()


@pytest.fixture(scope="module")
def application(shelf: Shelf) -> Application:
    """The application, guarded as the command guards it."""
    from propmap.explore.app import Application, guard, names_of
    from propmap.explore.views import VIEWS

    found = Application(Session(), VIEWS, shelf)
    guard(found.dash.server, names_of("127.0.0.1"))
    return found


def with_file(session: Session, shelf: Shelf, name: str, data: bytes) -> Session:
    given: Given = read_upload(name, data)
    return session.with_file(given, shelf.put(given))
