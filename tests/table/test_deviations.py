"""Standard deviations in a table: those of the model, kept in its file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray

import propmap
from propmap.loads import LOADS
from propmap.model.airfoil import SectionCovariance, SectionUncertainty
from propmap.table import LoadTable
from propmap.table.build import deviation_coefficients

from .conftest import invented_content, random_points


def _uncertain(rotor: propmap.Rotor) -> propmap.Rotor:
    law = rotor.model.airfoil
    assert isinstance(law, propmap.Airfoil)
    known = SectionUncertainty(SectionCovariance(("c_l1",), np.array([[0.09]])), 0.003, 0.002)
    return propmap.Rotor(rotor.model.with_airfoil(law.with_parameters(uncertainty=known)))


def _invented() -> LoadTable:
    content = invented_content()
    return LoadTable(replace(content, deviations=0.1 * np.abs(content.coefficients)))


@pytest.mark.slow
def test_they_are_the_model_s(rotor: propmap.Rotor, table: LoadTable) -> None:
    uncertain = _uncertain(rotor)
    coefficients = deviation_coefficients(uncertain, table.content)
    told = LoadTable(replace(table.content, deviations=coefficients))
    points = random_points(told, 200)
    loads = uncertain.loads(*points)
    sure = np.isin(loads.status, ("ok", "multiple_roots"))
    found = told.std(*points)
    for name in LOADS:
        want, got = getattr(loads.std, name)[sure], getattr(found, name)[sure]
        # Side force and pitching moment are zero in the paper's model.
        assert np.sqrt(np.mean((got - want) ** 2)) <= 0.05 * np.sqrt(np.mean(want**2)), name


def test_what_is_filed_comes_back(tmp_path: Path) -> None:
    table = _invented()
    points = random_points(table, 50)
    table.save(tmp_path / "x.npz")
    here, there = table.std(*points), LoadTable.load(tmp_path / "x.npz").std(*points)
    for name in (*LOADS, "power"):
        np.testing.assert_allclose(getattr(there, name), getattr(here, name), rtol=1e-6)
        assert (getattr(here, name) >= 0.0).all()
    np.testing.assert_allclose(here.power, here.torque * points[0])
    table.to_netcdf(tmp_path / "x.nc")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["x.nc", "x.npz"]
    with xarray.open_dataset(tmp_path / "x.nc", engine="h5netcdf") as found:
        np.testing.assert_array_equal(found["advance"], table.content.advance)
        for k, name in enumerate(LOADS):
            np.testing.assert_array_equal(found[name], table.content.coefficients[:, k])
            assert found[name].attrs["units"] == "1"
        assert found["thrust_std"].shape == table.content.coefficients[:, 0].shape
        assert found.attrs["propeller_name"] == "invented"


def test_a_share_of_the_loads_stays_that_share_between_the_knots() -> None:
    """Loads that are smooth, and deviations that are a tenth of them."""
    table = _invented()
    points = random_points(table, 300, seed=2)
    loads, found = table.loads(*points), table.std(*points)
    np.testing.assert_allclose(found.torque, 0.1 * np.abs(loads.torque), rtol=0.02, atol=1e-6)


def test_where_there_are_none() -> None:
    table = _invented()
    assert np.isnan(table.std(5000.0, 1.0, 0.3).thrust)
    assert np.isnan(table.std(np.nan, 1.0, 0.3).thrust)
    assert table.std(300.0, np.zeros((2, 3)), -0.3).roll_moment.shape == (2, 3)
    content = invented_content()
    with pytest.raises(propmap.InputError, match="has no standard deviations"):
        LoadTable(content).std(500.0, 1.0, 0.2)
    with pytest.raises(propmap.InputError, match="negative"):
        replace(content, deviations=content.coefficients - 1.0)
