"""One version and one description, wherever a release states them."""

from __future__ import annotations

import json
import re
import tomllib

import propmap
from tests.docs.pages import ROOT


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def cited(key: str) -> str:
    """A value of ``CITATION.cff`` that stands on the line of its key."""
    found = re.search(rf'^{key}: "?(.*?)"?$', text_of("CITATION.cff"), re.MULTILINE)
    assert found, key
    return found[1]


def test_the_version_is_one() -> None:
    assert re.fullmatch(r"\d+\.\d+\.\d+(rc\d+)?", propmap.__version__)
    deposited = json.loads(text_of(".zenodo.json"))
    newest = re.search(r"^## (\S+)", text_of("CHANGELOG.md"), re.MULTILINE)
    assert newest
    stated = {newest[1], cited("version"), deposited["version"]}
    assert stated == {propmap.__version__}


def test_the_description_is_one() -> None:
    deposited = json.loads(text_of(".zenodo.json"))
    project = tomllib.loads(text_of("pyproject.toml"))["project"]
    assert deposited["title"] == cited("title")
    assert deposited["title"].lower().endswith(project["description"].lower())
    assert deposited["license"] == cited("license") == project["license"]
    people = [person["name"] for person in deposited["creators"]]
    assert people == [person["name"] for person in project["authors"]]
    for identifier in deposited["related_identifiers"]:
        assert f"doi: {identifier['identifier']}" in text_of("CITATION.cff")
