"""Building: the certificate holds on points never seen, gaps stay gaps, absurd wishes are told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.loads import LOADS, error_scales
from propmap.table import LoadTable, build_table
from propmap.table.verification import CachedModel
from propmap.units import RPM
from tests.workers_elsewhere import Elsewhere

from .conftest import BETA, OMEGA, SPEED, TOLERANCE, random_points


def _errors(
    table: LoadTable, rotor: propmap.Rotor, count: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Errors as shares of the static loads (n, 4), and statuses, on random points."""
    omega, speed, beta = random_points(table, count, seed)
    model, found = rotor.loads(omega, speed, beta), table.loads(omega, speed, beta)
    rates, where = np.unique(omega, return_inverse=True)
    still = rotor.loads(rates, 0.0, 0.0)
    rest = {name: getattr(still, name)[where] for name in LOADS}
    scales = error_scales(rest, rotor.model.propeller.radius)
    static = np.stack(list(scales.values()), -1)
    difference = [getattr(found, name) - getattr(model, name) for name in LOADS]
    return np.stack(difference, -1) / static, found.status


def test_the_certificate_holds_on_fresh_points(table: LoadTable, rotor: propmap.Rotor) -> None:
    assert table.certificate["holds"]
    errors, status = _errors(table, rotor, 3000, seed=6)
    sound = (status == "ok") | (status == "vortex_ring")
    assert sound.mean() > 0.95
    assert np.abs(errors[sound]).max() <= TOLERANCE
    rms = np.sqrt((errors[sound] ** 2).mean(axis=0))
    certified = [table.certificate["rms_error"][name] for name in LOADS]
    # Two samples of the same errors.
    np.testing.assert_allclose(rms, certified, rtol=0.5)


def test_the_vortex_ring_is_told(table: LoadTable, rotor: propmap.Rotor) -> None:
    omega, speed, beta = random_points(table, 2000, seed=7)
    model = rotor.loads(omega, speed, beta).status == "vortex_ring"
    found = table.loads(omega, speed, beta).status
    assert model.sum() > 100
    # Flags are of whole cells, whose corners may all miss the ring's border.
    assert np.isin(found[model], ["vortex_ring", "unresolved"]).mean() > 0.98
    assert not (found[beta < np.pi / 2 - 0.1] == "vortex_ring").any()


def test_the_source_of_the_loads_is_filed(table: LoadTable, rotor: propmap.Rotor) -> None:
    info = json.loads(json.dumps(table.info))
    assert info["propmap_version"] == propmap.__version__
    assert info["propeller"]["name"] == "apc-8x6e"
    assert len(info["propeller"]["geometry_sha256"]) == len(info["airfoil"]["sha256"]) == 64
    assert info["airfoil"]["c_l1"] == rotor.model.airfoil.c_l1
    assert info["model_sha256"] == rotor.model.fingerprint()
    assert info["air"] == {"density_kg_m3": 1.225, "viscosity_Pa_s": 1.983e-5}
    assert table.envelope == {"omega": OMEGA, "speed": SPEED, "beta": BETA}


def test_workers_evaluate_the_model_alike(
    rotor: propmap.Rotor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("propmap.table.verification.BATCH", 3)
    alone = propmap.Rotor(rotor.model)
    told: list[int] = []
    workers = Elsewhere()
    models = [
        CachedModel(alone, np.array(OMEGA), progress=lambda _, n: told.append(n), workers=some)
        for some in (None, workers)
    ]
    beta = np.linspace(0.0, np.pi, 4)
    here, there = (model.relative(0, np.array([0.0, 0.1]), beta) for model in models)
    np.testing.assert_array_equal(here[0], there[0])
    np.testing.assert_array_equal(here[1], there[1])
    assert workers.tasks == 4  # rest, and three batches
    assert models[0].evaluations == models[1].evaluations == told[-1] == 10


def test_left_out_and_lost_points_are_nan_and_counted(rotor: propmap.Rotor) -> None:
    table = build_table(
        rotor,
        omega=(600.0, 620.0),
        speed=(1.0, 4.0),
        beta=(2.4, np.pi),
        tolerance=0.05,
        leave_out_vortex_ring=True,
        certificate_points=512,
    )
    omega, speed, beta = random_points(table, 500, seed=8)
    ring = rotor.loads(omega, speed, beta).status == "vortex_ring"
    found = table.loads(omega, speed, beta)
    assert (found.status[ring] == "no_value").mean() > 0.97
    assert np.isnan(found.thrust[found.status == "no_value"]).all()
    assert table.certificate["no_value"] > 0
    assert table.info["vortex_ring"] == "left out"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tolerance": 0.5}, "tolerance is 0.5"),
        ({"tolerance": np.nan}, "tolerance is nan"),
        ({"omega": (0.0, 500.0)}, "advance ratio is infinite"),
        ({"omega": (500.0, 400.0)}, "give the smaller value first"),
        ({"speed": (-1.0, 5.0)}, "speed must not be negative"),
        ({"beta": (0.0, 4.0)}, "between 0 and 180 degrees"),
    ],
)
def test_absurd_wishes(rotor: propmap.Rotor, change: dict[str, object], message: str) -> None:
    wish = {"omega": OMEGA, "speed": SPEED, "beta": BETA, **change}
    with pytest.raises(propmap.InputError, match=message) as error:
        build_table(rotor, **wish)  # type: ignore[arg-type]
    assert "\n" not in str(error.value)
    section = rotor.model.airfoil.with_parameters(zero_lift_angle=0.5)
    with pytest.raises(propmap.InputError, match="are not positive"):
        CachedModel(propmap.Rotor(propmap.Model(rotor.model.propeller, section)), np.array(OMEGA))


def test_an_envelope_with_more_unresolved_than_allowed_is_refused(
    rotor: propmap.Rotor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As no envelope of this rotor has that many jumps, none at all are allowed to it."""
    monkeypatch.setattr("propmap.table.build.MOST_UNRESOLVED", -1.0)
    monkeypatch.setattr("propmap.table.build.check_between_speeds", lambda *_: None)
    told: list[int] = []
    with pytest.raises(propmap.InputError, match=r"not meet the tolerance of 0\.50%:"):
        build_table(
            rotor,
            omega=(430.0, 440.0),
            speed=(2.0, 2.1),
            beta=(0.5, 0.55),
            tolerance=0.005,
            certificate_points=256,
            progress=lambda _, done: told.append(done),
        )
    assert told == sorted(told) and told[0] > 0


@pytest.mark.slow
def test_the_whole_envelope_at_half_a_percent(rotor: propmap.Rotor, tmp_path: Path) -> None:
    """8x6E, 2000-10000 rpm, 0-20 m/s, 0-180 degrees: 20 000 points the builder never saw."""
    table = build_table(
        rotor,
        omega=(2000.0 * RPM, 10000.0 * RPM),
        speed=(0.0, 20.0),
        beta=(0.0, np.pi),
        tolerance=0.005,
    )
    table.save(tmp_path / "map.npz")
    assert (tmp_path / "map.npz").stat().st_size < 5e6
    assert table.info["model_evaluations"] < 500_000
    errors, status = _errors(table, rotor, 20_000, seed=9)
    assert not np.isnan(errors).any()
    assert np.abs(errors[status != "unresolved"]).max() <= 0.005
    # Where the model's loads jump; what is left of it is measured and told.
    assert (status == "unresolved").mean() < 0.015
    told = table.certificate
    assert told["unresolved_volume"] == pytest.approx((status == "unresolved").mean(), abs=0.002)
    assert np.abs(errors).max() <= 1.05 * max(told["unresolved_max_error"].values())


def test_what_two_rotor_speeds_cannot_tell_is_said_at_once() -> None:
    """With the nearest envelope and tolerance that can be had; its loads change with Re."""
    by_designation = propmap.Rotor(propmap.catalogue_model("10x4.5"))
    flight = {"speed": (0.0, 8.0), "beta": (0.0, np.radians(60.0))}
    evaluated: list[int] = []
    with pytest.raises(propmap.InputError) as error:
        build_table(
            by_designation,
            omega=(2000.0 * RPM, 9000.0 * RPM),
            tolerance=0.01,
            progress=lambda _, done: evaluated.append(done),
            **flight,
        )
    text = str(error.value)
    for words in ("from 2000 to 9000 rpm", "Reynolds number", "mostly at beta", "tolerance of 3."):
        assert words in text
    assert evaluated[-1] < 100_000
    least = float(text.partition("use ")[2].partition(":")[0])
    assert 2500.0 < least < 5000.0
    narrower = build_table(
        by_designation,
        omega=(least * RPM, 9000.0 * RPM),
        tolerance=0.01,
        certificate_points=1024,
        **flight,
    )
    assert narrower.certificate["unresolved_volume"] < 0.05
