"""The bundled loads, and the constants that were identified from them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap import catalogue
from propmap.catalogue.identified import LIFT_LAW, all_identified, identified
from propmap.catalogue.lookup import measurement, measurement_names
from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.air import Air
from tests.catalogue.test_nothing_is_doubted import doubts

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"
with_data = pytest.mark.skipif(not DATA.is_dir(), reason="the published data are not here")


@pytest.mark.parametrize("name", measurement_names())
def test_columns_belong_together(name: str) -> None:
    points = measurement(name)
    assert points.propeller in catalogue.names()
    assert points.kind in {"measured", "digitized", "fit"}
    assert points.citation and points.note and 0.9 < points.air_density < 1.4
    assert np.all(points.omega > 100.0) and np.all(points.omega < 1100.0)
    assert np.all(points.speed >= 0.0) and np.all(points.speed < 25.0)
    assert np.all(points.beta >= 0.0) and np.all(points.beta < 1.6)
    assert set(points.loads) <= set(LOADS)
    for column in points.loads.values():
        assert column.shape == points.omega.shape and np.isfinite(column).all()
    assert not points.loads["thrust"].flags.writeable
    flow, air = (points.omega, points.speed, points.beta), Air(density=points.air_density)
    assert doubts(catalogue.load(points.propeller), flow, dict(points.loads), air) == []


@with_data
def test_uiuc_coefficients_come_back() -> None:
    with (DATA / "uiuc" / "loads.csv").open(newline="") as stream:
        rows = [r for r in csv.DictReader(stream) if r["BladeName"] == "apce 8.0x6.0"]
    points = measurement("uiuc-8x6e")
    n, d = points.omega / (2.0 * np.pi), 0.2032
    published = {key: np.array([float(r[key]) for r in rows]) for key in ("N", "J", "CT", "CP")}
    power = points.loads["torque"] * points.omega
    returned = {
        "N": n * 60.0,
        "J": points.speed / (n * d),
        "CT": points.loads["thrust"] / (1.225 * n**2 * d**4),
        "CP": power / (1.225 * n**3 * d**5),
    }
    for key, values in returned.items():
        np.testing.assert_allclose(values, published[key], rtol=1e-6, atol=1e-9)
    assert np.any(points.speed == 0.0)


@with_data
@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("gill-dandrea-2019-8x6e", "apc_8x6e_published_polynomials.csv"),
        ("gill-dandrea-2019-8x6e-fit", "apc_8x6e_published_fit.csv"),
        ("davoudi-8x4.5mr-thrust", "apc_8x45mr_thrust.csv"),
    ],
)
def test_oblique_rows_come_back(name: str, file: str) -> None:
    with (DATA / "oblique" / file).open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    points = measurement(name)
    columns = {
        "rpm": points.omega * 60.0 / (2.0 * np.pi),
        "speed_mps": points.speed,
        "beta_deg": np.rad2deg(points.beta),
        **{LOADS[name].column: values for name, values in points.loads.items()},
    }
    for key in rows[0]:
        np.testing.assert_allclose(
            columns[key], [float(r[key]) for r in rows], rtol=1e-6, atol=1e-12
        )


def test_every_entry_has_a_blade_and_a_covariance_that_is_one() -> None:
    entries = all_identified()
    assert len({(one.propeller, one.blades) for one in entries}) == len(entries) > 130
    for one in entries:
        assert one.propeller in catalogue.names()
        assert np.linalg.eigvalsh(one.covariance).min() > 0.0, one.propeller
        assert 0.0 < one.thrust_rms < 0.02 and 0.0 < one.power_rms < 0.02
        assert one.rpm_low <= one.rpm_high and one.rows >= one.static_rows
        assert one.airfoil.lift_law == LIFT_LAW and one.verdict


def test_they_are_found_by_blade_and_number_of_blades() -> None:
    two, three = (identified("UIUC-DA4022-5x3.75", blades) for blades in (2, 3))
    assert two is not None and three is not None
    assert (two.blades, three.blades) == (2, 3) and two.constants[0] != three.constants[0]
    assert identified("uiuc-da4022-5x3.75", 7) is None and identified("none", 2) is None


def test_nine_propellers_in_ten_are_fitted_well() -> None:
    """What the section law with its two further terms is worth, over all propellers."""
    thrust, power = (
        np.array([getattr(one, name) for one in all_identified()])
        for name in ("thrust_rms", "power_rms")
    )
    assert np.median(thrust) <= 0.0026 and np.quantile(thrust, 0.9) <= 0.0048
    assert np.median(power) <= 0.0018 and np.quantile(power, 0.9) <= 0.0036


def test_the_8x6e_has_the_measured_loads() -> None:
    """With the paper's constants, thrust in axial flow is 40 % low."""
    measured = measurement("uiuc-8x6e")
    one = identified("apc-8x6e", 2)
    assert one is not None
    rotor = pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), one.airfoil))
    found = rotor.loads(measured.omega, measured.speed, measured.beta)
    for name, most in (("thrust", 0.06), ("torque", 0.05)):
        told = measured.loads[name]
        error = np.sqrt(np.mean((getattr(found, name) - told) ** 2) / np.mean(told**2))
        assert error < most, name


def test_names_and_what_was_not_measured() -> None:
    assert len(measurement_names()) == 4
    assert measurement("UIUC-8x6E").name == "uiuc-8x6e"
    with pytest.raises(InputError, match=r"choose one of .*uiuc-8x6e"):
        measurement("uiuc-8x6")
    assert set(measurement("uiuc-8x6e").loads) == {"thrust", "torque"}
    both = [measurement(f"gill-dandrea-2019-8x6e{end}") for end in ("", "-fit")]
    assert "pitch_moment" in both[0].loads and "roll_moment" in both[1].loads
    for field in ("omega", "speed", "beta"):
        np.testing.assert_array_equal(*(getattr(one, field) for one in both))
