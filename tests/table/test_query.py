"""Asking a table: scalars equal arrays, nothing plausible outside, the loads' symmetries."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

import propmap
from propmap.loads import LOADS
from propmap.table import LoadTable

from .conftest import flagged_content, random_points

FIELDS = (*LOADS, "power")


def test_importing_and_asking_needs_numpy_alone(invented: LoadTable, tmp_path: object) -> None:
    path = f"{tmp_path}/map.npz"
    invented.save(path)
    code = (
        "import sys; from propmap.table import LoadTable; "
        f"t = LoadTable.load({path!r}); t.loads(500.0, 3.0, 1.0); t.gradient(500.0, 3.0, 1.0); "
        "t.omega_for('thrust', 1.0, 3.0, 1.0); "
        "heavy = {'jax', 'jaxlib', 'scipy', 'xarray', 'matplotlib', 'typer', 'rich', 'h5py'}; "
        "print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_point_equals_its_place_in_an_array(invented: LoadTable) -> None:
    points = random_points(invented, 3000)
    together = invented.loads(*(p.reshape(3, 1000) for p in points))
    assert together.thrust.shape == together.status.shape == (3, 1000)
    for k in range(0, 3000, 97):
        alone = invented.loads(*(float(p[k]) for p in points))
        assert isinstance(alone.thrust, float)
        assert alone.status == "ok"
        for name in FIELDS:
            expected = getattr(together, name).ravel()[k]
            # The two sum in another order.
            assert getattr(alone, name) == pytest.approx(expected, rel=1e-13, abs=1e-16)


def test_knots_are_met_and_the_reynolds_term_is_linear_in_the_root(invented: LoadTable) -> None:
    content = invented.content
    speed = content.advance * 200.0 * content.radius
    found = invented.loads(200.0, speed[:, None], content.beta)
    square = content.scale[0] * 200.0**2
    np.testing.assert_allclose(found.thrust, square * content.coefficients[0, 0], rtol=1e-12)
    # Half-way between the ends in Omega^(-1/2), at rest.
    middle = (0.5 * (200.0**-0.5 + 1000.0**-0.5)) ** -2
    expected = content.scale[2] * middle**2 * content.coefficients[:, 2, 0, 0].mean()
    assert invented.loads(middle, 0.0, 0.0).torque == pytest.approx(expected, rel=1e-12)


def test_velocity_vectors_say_the_same(invented: LoadTable) -> None:
    omega, speed, beta = random_points(invented, 200)
    turn = np.linspace(0.0, 7.0, 200)
    inplane = speed * np.sin(beta)
    vector = np.stack([inplane * np.cos(turn), inplane * np.sin(turn), speed * np.cos(beta)], -1)
    polar, cartesian = invented.loads(omega, speed, beta), invented.loads_at_velocity(omega, vector)
    for name in FIELDS:
        np.testing.assert_allclose(getattr(cartesian, name), getattr(polar, name), 1e-9, 1e-12)
    # The sign of the angle and whole turns make no difference.
    turned = invented.loads(omega, speed, 4.0 * np.pi - beta)
    np.testing.assert_allclose(turned.thrust, polar.thrust, rtol=1e-9)
    one = invented.loads_at_velocity(float(omega[3]), vector[3])
    assert one.thrust == pytest.approx(polar.thrust[3], rel=1e-9)


OUTSIDE = [(199.0, 3.0, 1.0), (1001.0, 3.0, 1.0), (500.0, 9.0, 1.0)]
UNKNOWN = [(np.nan, 3.0, 1.0), (500.0, np.nan, 1.0), (500.0, 3.0, np.inf)]


@pytest.mark.parametrize("point", [*OUTSIDE, *UNKNOWN, (0, 0, 0)])
def test_outside_there_are_no_numbers(
    invented: LoadTable, point: tuple[float, float, float]
) -> None:
    arrays = np.array(point)[:, None]
    answers = [invented.loads(*point), invented.loads(*arrays)]
    if point in UNKNOWN:
        answers += [invented.loads(*point, clamp=True), invented.loads(*arrays, clamp=True)]
    for found in answers:
        assert np.all(np.asarray(found.status) == "outside")
        assert not np.any(found.inside)
        assert all(np.isnan(getattr(found, name)).all() for name in FIELDS)
    assert all(np.isnan(field).all() for field in invented.gradient(*point))


@pytest.mark.parametrize("point", OUTSIDE)
def test_clamping_is_told(invented: LoadTable, point: tuple[float, float, float]) -> None:
    box = invented.envelope.values()
    held = [min(max(x, low), high) for x, (low, high) in zip(point, box, strict=True)]
    expected = invented.loads(*held)
    for given in (point, np.array(point)[:, None]):
        found = invented.loads(*given, clamp=True)
        assert np.all(np.asarray(found.status) == "clamped")
        assert not np.any(found.inside)
        np.testing.assert_allclose(found.thrust, expected.thrust, rtol=1e-12)
    assert invented.loads(500.0, 3.0, 1.0, clamp=True).status == "ok"


def test_the_envelopes_ends_are_inside_whatever_the_rounding(invented: LoadTable) -> None:
    (w0, w1), (v0, v1), (b0, b1) = invented.envelope.values()
    for w in (w0 * (1 - 1e-14), w1 * (1 + 1e-14)):
        for v in (v0, v1 * (1 + 1e-14)):
            for b in (b0, b1):
                assert invented.loads(w, v, b).status == "ok"
                assert invented.loads([w], v, b).status[0] == "ok"


def test_flags_of_cells_reach_the_status() -> None:
    content = flagged_content()
    table = LoadTable(content)
    beta = content.beta[[0, 9, 14, 20]] + 0.01
    words = ["vortex_ring", "unresolved", "ok", "no_value"]
    assert table.loads(500.0, 7.0, beta).status.tolist() == words
    assert [table.loads(500.0, 7.0, float(b)).status for b in beta] == words
    assert np.isnan(table.loads(500.0, 7.0, float(beta[-1])).thrust)
    assert table.loads(500.0, 4.0, 0.5).status == "unresolved"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda t: t.loads("fast", 1.0, 1.0), "omega is 'fast'"),
        (lambda t: t.loads([1.0 + 1.0j], 1.0, 1.0), "omega is .*: give a real number"),
        (lambda t: t.omega_for("thrust", np.ma.masked, 1.0, 1.0), "value has masked points"),
        (lambda t: t.loads([1.0, 2.0], [1.0, 2.0, 3.0], 1.0), "cannot be broadcast"),
        (lambda t: t.loads_at_velocity(500.0, [1.0, 2.0]), "must be x, y, z"),
        (lambda t: t.omega_for("drag", 1.0, 1.0, 1.0), "must be one of thrust, torque, power"),
    ],
)
def test_bad_arguments_are_told(invented: LoadTable, call: object, message: str) -> None:
    with pytest.raises(propmap.InputError, match=message) as error:
        call(invented)  # type: ignore[operator]
    assert "\n" not in str(error.value)
