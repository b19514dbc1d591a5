"""A fit's covariance carried through to the loads, and filed with the table."""

from __future__ import annotations

import json

import numpy as np
import pytest

import propmap
from propmap.loads import LOADS
from propmap.model.airfoil import SectionCovariance, SectionUncertainty
from propmap.table import build_table
from propmap.table.verification import load_deviations

COVARIANCE = SectionCovariance(("c_l1", "c_d"), np.array([[0.04, -0.01], [-0.01, 0.09]]))


def test_deviations_are_those_of_the_bands(rotor: propmap.Rotor) -> None:
    points = np.full(3, 600.0), np.array([8.0, 10.0, 12.0]), np.array([1.2, 1.4, 1.5])
    law = rotor.model.airfoil.with_parameters(uncertainty=SectionUncertainty(COVARIANCE, 0.0, 0.0))
    told = propmap.Rotor(rotor.model.with_airfoil(law)).loads(*points).std_by_source["parameters"]
    expected = np.stack([getattr(told, name) for name in LOADS], axis=-1)
    found = load_deviations(rotor, COVARIANCE, *points)
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-12)


@pytest.mark.slow
def test_the_table_tells_what_the_parameters_cost(rotor: propmap.Rotor) -> None:
    names = (*COVARIANCE.names, "alpha_0")
    matrix = np.full((3, 3), np.inf)
    matrix[:2, :2] = COVARIANCE.matrix
    model = rotor.model
    law = model.airfoil.with_parameters(
        uncertainty=SectionUncertainty(SectionCovariance(names, matrix), 0.002, 0.001)
    )
    uncertain = propmap.Rotor(model.with_airfoil(law))
    table = build_table(
        uncertain,
        omega=(400.0, 440.0),
        speed=(14.0, 16.0),
        beta=(1.3, 1.5),
        tolerance=0.05,
        certificate_points=512,
    )
    info = json.loads(json.dumps(table.info, allow_nan=False))
    assert info["airfoil_covariance"]["names"] == list(names)
    assert info["airfoil_covariance"]["matrix"][0] == [0.04, -0.01, None]
    told = info["parameter_uncertainty"]
    assert told["parameters"] == ["c_l1", "c_d"]
    assert told["not_counted"] == ["alpha_0"]
    middle = load_deviations(rotor, COVARIANCE, *np.array([[420.0], [15.0], [1.4]]))
    share = float(middle[0, 0]) / float(rotor.loads(420.0, 0.0, 0.0).thrust)
    assert told["median"]["thrust"] == pytest.approx(share, rel=0.1)
    assert told["median"]["thrust"] < told["percentile_95"]["thrust"]


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.eye(3), "has shape"),
        (np.array([[1.0, 2.0], [2.0, 1.0]]), "negative variance"),
        (np.diag([1.0, np.nan]), "variance of .* is nan"),
    ],
)
def test_what_is_no_covariance(matrix: np.ndarray, message: str) -> None:
    with pytest.raises(propmap.InputError, match=message) as error:
        SectionCovariance(("c_l1", "c_d"), matrix)
    assert "\n" not in str(error.value)
