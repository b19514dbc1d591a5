from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

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


def asked(application: Application, output: str, inputs: list[Any], state: list[Any]) -> Any:
    """What the server answers to a callback of the page."""
    (key,) = [key for key in application.dash.callback_map if output in key and "@" not in key]
    outputs = [
        dict(zip(("id", "property"), part.rsplit(".", 1), strict=True))
        for part in key.strip(".").split("...")
    ]
    body = {
        "output": key,
        "outputs": outputs if len(outputs) > 1 else outputs[0],
        "inputs": inputs,
        "state": state,
        "changedPropIds": [f"{one['id']}.{one['property']}" for one in inputs],
    }
    client = application.dash.server.test_client()
    where = {"headers": LOCAL, "content_type": "application/json"}
    return client.post(UPDATE(application), data=json.dumps(body), **where)


LOCAL = {"Host": "127.0.0.1:8765"}


def UPDATE(application: Application) -> str:  # noqa: N802 - reads as a constant of the application
    """The address of callbacks."""
    rules = application.dash.server.url_map.iter_rules()
    return next(r.rule for r in rules if r.rule.startswith("/_dash-update-component"))
