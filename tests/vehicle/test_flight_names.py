"""Names of flights, from those of their files."""

from __future__ import annotations

import pytest

from propmap.vehicle.log import flight_names


@pytest.mark.parametrize(
    ("files", "names"),
    [
        (("a/neurobem_20210218171908.csv", "neurobem_20210218172600.csv"), ("171908", "172600")),
        (("fly/hover_a.csv", "fly/hover_b.csv"), ("a", "b")),
        (("windy-3.ulg", "calm-3.ulg"), ("windy-3", "calm-3")),
        (("20210218171908.csv", "20210219171908.csv"), ("20210218-171908", "20210219-171908")),
        (("one/log.ulg", "two/log.ulg"), ("1", "2")),
        (("flight.csv",), ("flight",)),
    ],
)
def test_the_end_that_tells_them_apart(files: tuple[str, ...], names: tuple[str, ...]) -> None:
    assert flight_names(files) == names
