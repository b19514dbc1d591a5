"""Names, files and requests that are bad: a line on the page, and a server that goes on."""

from __future__ import annotations

import base64
import json
import random
import string
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import propmap
from propmap.errors import InputError
from propmap.explore.app import LIVE, Application, is_loopback
from propmap.explore.session import MOST_BYTES, Recipe, Session, Shelf, read_upload
from propmap.io.geometry import propeller_toml

from .conftest import with_file

LOCAL = {"Host": "127.0.0.1:8765"}
ROWS = b"rpm,speed_mps,beta_deg,thrust_N\n5000,0,0,1.5\n"

BAD_FILES = {
    "empty.csv": b"",
    "binary.csv": bytes(range(256)),
    "table.npz": b"PK\x03\x04 not a table",
    "vehicle.toml": b'schema = 1\nname = "x"\nmass = 1.0\npropeller = "/etc/passwd"\n[[rotors]]\n',
    "loads.csv": b"rpm,speed_mps,beta_deg,thrust_N\n5000,x,0,1\n",
    "blade.csv": b"radius_m,chord_m,twist_deg\n0.1,0.01,10\n",
    "../../etc/cron.d/x.toml": b"c_l1 = 'a'",
    "nul\x00.toml": b"c_l1 = 1",
    "one cell.csv": b"a" * 200_000,
    "one cell.pe0": b"a" * 200_000,
    "10,000 columns.csv": f"thrust_N,{','.join(map(str, range(10_000)))}\n1\n".encode(),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_a_bad_file_is_told_in_one_line(name: str) -> None:
    with pytest.raises(InputError) as error:
        read_upload(name, BAD_FILES[name])
    told = str(error.value)
    assert "\n" not in told and len(told) < 600
    assert "tmp" not in told and "root:" not in told
    with pytest.raises(InputError, match="expected at most 5"):
        read_upload(name, b"x" * (MOST_BYTES + 1))


def test_no_name_reads_a_file_of_the_server(application: Application) -> None:
    for query in ({"prop": "/etc/passwd"}, {"prop": "examples/blade.toml"}, {"law": "/etc/passwd"}):
        with pytest.raises(InputError):
            Session.of({"prop": "apc-8x6e", **query}, Session(), Shelf())
    page, _ = application.page("/compare", "?prop=apc-8x6e&a=/etc/passwd")
    assert "is not a propeller name" in str(page)


def test_one_tab_does_not_see_the_file_of_another(application: Application, shelf: Shelf) -> None:
    mine = with_file(Session(), shelf, "secret.csv", ROWS)
    query = "&".join(f"{key}={value}" for key, value in mine.query().items())
    assert "secret.csv" in str(application.page("/loads", f"?{query}")[0])
    assert "secret.csv" not in str(application.page("/loads", "?prop=apc-8x6e")[0])
    guessed, _ = application.page("/loads", "?prop=apc-8x6e&file-data=guess")
    assert "no longer stores a dropped file" in str(guessed)
    lost = "?prop=apc-8x6e&rpm=5000&file-data=lost"
    again = f"data:;base64,{base64.b64encode(ROWS).decode()}"
    for address in (
        application.uploaded(lost, again, "mine.csv")[0],
        application.chosen(lost, "apc-10x5e", "known", "")[0],
        application.removed(lost, "data"),
    ):
        assert "file-data=lost" not in address
        assert not application.page("/loads", address)[1].get("empty")


def test_the_copied_command_runs_no_line_of_a_file_and_replaces_no_file(tmp_path: Path) -> None:
    given = read_upload("-blade.toml", propeller_toml(propmap.propeller("apc-8x6e")).encode())
    given = replace(given, data=given.data + b"# END\nEND_OF_FILE\ntouch ran\n")
    command = Recipe(Session().with_file(given, "x")).shell()
    subprocess.run(["bash", "-c", command], cwd=tmp_path, check=True)
    assert [file.name for file in tmp_path.iterdir()] == ["blade.toml"]
    assert (tmp_path / "blade.toml").read_bytes() == given.data
    mine = Session().with_file(replace(given, path="blade.toml"), "x")
    assert Recipe(mine, blade=propmap.propeller("apc-8x6e")).prop == "new-blade.toml"


def test_foreign_names_are_refused(application: Application) -> None:
    client = application.dash.server.test_client()
    for host in ("evil.example:8765", "127.0.0.1.evil.example", ""):
        assert client.get("/", headers={"Host": host}).status_code == 403
    for host in ("127.0.0.1:8765", "localhost", "[::1]:8765"):
        assert client.get("/", headers={"Host": host}).status_code == 200
    assert all(map(is_loopback, ("127.0.0.1", "localhost", "::1", "127.3.2.1")))
    assert not any(map(is_loopback, ("0.0.0.0", "192.168.0.3", "example.org", "::")))


def callbacks(application: Application) -> str:
    """The address of callbacks."""
    rules = application.dash.server.url_map.iter_rules()
    return next(r.rule for r in rules if r.rule.startswith("/_dash-update-component"))


def test_a_large_request_is_refused_and_the_page_loads_nothing_from_elsewhere(
    application: Application,
) -> None:
    client = application.dash.server.test_client()
    large = b'"' + b"x" * 9_000_000 + b'"'
    where = {"headers": LOCAL, "content_type": "application/json"}
    assert client.post(callbacks(application), data=large, **where).status_code == 413
    text = client.get("/", headers=LOCAL).get_data(as_text=True)
    assert "https://" not in text and "http://" not in text


def test_an_upload_through_the_server(application: Application) -> None:
    def upload(content: str) -> tuple[Any, str]:
        return application.uploaded("?prop=apc-8x6e&rpm=5000", content, "mine.csv")

    address, trouble = upload(f"data:;base64,{base64.b64encode(ROWS).decode()}")
    assert "file-data=" in address and "rpm=5000" in address and not trouble
    for bad in ("", "no comma", "data:;base64,@@@", "data:;base64," + "A" * 8_000_000):
        assert upload(bad)[1]


@pytest.mark.slow
def test_500_malformed_callbacks_leave_it_answering(application: Application) -> None:
    """Rubbish, and well-formed callbacks with one part exchanged for rubbish."""
    rng = random.Random(30)
    client = application.dash.server.test_client()
    keys = list(application.dash.callback_map)

    def word() -> str:
        return "".join(rng.choice(string.printable) for _ in range(rng.randrange(12)))

    def rubbish(depth: int = 0) -> Any:
        some = [None, True, rng.randint(-(10**9), 10**9), 1e308, word(), "?prop=" + word()]
        if depth < 3:
            parts = [rubbish(depth + 1) for _ in range(rng.randrange(4))]
            some += [parts, {word(): part for part in parts}]
        return rng.choice(some)

    where = {"headers": LOCAL, "content_type": "application/json"}
    seen = set()
    for k in range(500):
        body: Any = rubbish()
        if k % 2:
            inputs = [{"id": rubbish(), "property": "value", "value": rubbish()}] * 2
            body = {"output": rng.choice(keys), "inputs": inputs, "changedPropIds": [word()]}
            body |= {name: rubbish() for name in ("outputs", "state")}
        data = json.dumps(body) if k % 5 else word()
        done = client.post(LIVE if k % 7 == 0 else callbacks(application), data=data, **where)
        seen.add(done.status_code)
        assert b"Traceback" not in done.get_data()
    assert seen & {400, 500}
    assert client.get("/", headers=LOCAL).status_code == 200
    assert "angle of attack" in str(application.page("/disk", "?prop=apc-8x6e&speed=5")[0])
