"""The catalogue's files are written as they are read, and others are refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from propmap import catalogue
from propmap.catalogue.expected import GEOMETRIES, bundled_population, parse_populations
from propmap.errors import InputError
from tools.catalogue.files import as_csv, as_toml, parse_identified

FILE = Path(catalogue.__file__).with_name("identified") / "uiuc.csv"


def test_the_file_is_small_and_reads_back_the_same() -> None:
    text = FILE.read_text(encoding="utf-8")
    assert len(text) < 200_000
    assert as_csv(parse_identified(text, "here")) == text


def test_other_files_are_refused() -> None:
    with pytest.raises(InputError, match="the columns are not those"):
        parse_identified("a,b\n1,2\n", "here")
    lines = FILE.read_text(encoding="utf-8").splitlines()[:2]
    bad = "\n".join([lines[0], lines[1].replace(",2,", ",two,", 1)])
    with pytest.raises(InputError, match="line 2"):
        parse_identified(bad, "here")


def test_populations_are_read_back_as_they_are_written() -> None:
    text = as_toml({name: bundled_population(name) for name in GEOMETRIES})
    assert as_toml(parse_populations(text)) == text
