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
    newest = re.search(r"^## (\S+) \((\S+)\)", text_of("CHANGELOG.md"), re.MULTILINE)
    assert newest
    recipe = re.search(r'set version = "(.*)"', text_of("recipe/meta.yaml"))
    assert recipe
    stated = {newest[1], cited("version"), deposited["version"], recipe[1]}
    assert stated == {propmap.__version__}
    assert newest[2] == cited("date-released")


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


def test_the_recipe_requires_what_the_package_requires() -> None:
    project = tomllib.loads(text_of("pyproject.toml"))
    sections = dict(re.findall(r"^  (\w+):\n((?:    - .*\n)+)", text_of("recipe/meta.yaml"), re.M))

    def missing(section: str, wanted: list[str]) -> set[str]:
        listed = set(re.findall(r"- ([^#{\n]*[^#{\s])", sections[section]))
        return {re.sub("([>~]=)", r" \1", name) for name in wanted} ^ listed

    assert missing("run", project["project"]["dependencies"]) == {"python"}
    assert missing("host", project["build-system"]["requires"]) == {"python", "pip"}
    assert f"- propmap = {project['project']['scripts']['propmap']}\n" in text_of(
        "recipe/meta.yaml"
    )
    assert f"summary: {project['project']['description']}\n" in text_of("recipe/meta.yaml")
