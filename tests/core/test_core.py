"""Results do not depend on threads or processes, and no call makes the compiled core fall."""

from __future__ import annotations

import multiprocessing
import pickle
import warnings
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS
from propmap.results import STATUSES
from propmap.tasks import on_cores

NAMES = ("zero_lift_angle", "chord_scale", "omega", "v_axial", "v_inplane", "untwist")


@cache
def rotor(which: str = "recommended") -> pm.Rotor:
    if which == "recommended":
        return pm.Rotor(pm.catalogue_model("APC 8x6E"))
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
    if which == "table":
        angle = np.linspace(-np.pi, np.pi, 73)
        lift, drag = np.sin(2.0 * angle)[None], 0.02 + np.sin(angle)[None] ** 2
        lift[:, [0, -1]] = 0.0
        return pm.Rotor(pm.Model(blade, pm.SectionTable(angle, np.array([1e5]), lift, drag)))
    return pm.Rotor(pm.Model(blade, law))


def points(count: int = 200) -> tuple[np.ndarray, ...]:
    random = np.random.default_rng(40)
    beta = random.uniform(0.0, np.pi, count)
    beta[::7], beta[1::7] = 0.0, np.pi
    return random.uniform(150.0, 900.0, count), random.uniform(0.0, 20.0, count), beta


def told(one: pm.Rotor, count: int = 64) -> bytes:
    """All results at the points, to the last bit."""
    omega, speed, beta = points(count)
    loads = one.loads(omega, speed, beta)
    along, across = speed * np.cos(beta), np.abs(speed * np.sin(beta))
    slopes = one.gradients(NAMES, omega, along, across)
    parts = [getattr(loads, name) for name in (*LOADS, "mean_inflow", "vortex_ring", "roots")]
    parts += [slopes.loads, slopes.slopes, one.hover_inflow(omega), loads.status.astype("S")]
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


def told_elsewhere(pickled: bytes) -> bytes:
    return told(pickle.loads(pickled))


@pytest.mark.parametrize("which", ["recommended", "table"])
def test_the_number_of_threads_changes_no_bit(which: str) -> None:
    found = []
    for threads in (1, 5):
        with on_cores(threads):
            found.append(told(rotor(which), 160))  # a thread for each 32 points
    assert found[0] == found[1]


@pytest.mark.parametrize("which", ["recommended", "table"])
def test_single_calls_have_the_bits_of_batches(which: str) -> None:
    one, (omega, speed, beta) = rotor(which), points()
    batch = one.loads(omega, speed, beta)
    slopes = one.gradients(NAMES, omega, speed, 0.3 * speed)
    for k in (*range(0, 14), 199):
        single = one.loads(omega[k], speed[k], beta[k])
        assert single.thrust.shape == ()
        for name in (*LOADS, "mean_inflow", "roots", "status"):
            assert getattr(single, name) == getattr(batch, name)[k], name
        alone = one.gradients(NAMES, omega[k], speed[k], 0.3 * speed[k])
        np.testing.assert_array_equal(alone.slopes, slopes.slopes[:, :, k])


def test_what_was_asked_before_changes_no_bit() -> None:
    one = rotor()
    inflow, still = pm.DynamicInflow(one), [0.0, 0.0, 0.0]

    def other(omega: float, velocity: list[float]) -> None:
        one.loads_at_velocity(omega, velocity)
        one.gradients(NAMES, omega, velocity[2], velocity[0])
        inflow.steady(omega, velocity)

    asked = {
        "loads at rest": lambda: one.loads(600.0, 0.0, 0.0).thrust,
        "oblique loads": lambda: one.loads(600.0, 9.0, 1.2).roll_moment,
        "derivatives": lambda: one.gradients(NAMES, 600.0, 2.0, 0.0).slopes,
        "steady inflow": lambda: inflow.steady(600.0, still),
        "rates": lambda: inflow.rates(np.ones(inflow.size), 600.0, [0.0, 0.0, 1.0]),
        "inflow in descent": lambda: inflow.steady(600.0, [0.0, 0.0, -14.0]),
    }
    with on_cores(1):
        for name, ask in asked.items():
            other(700.0, [5.0, 0.0, 2.0])
            before = ask()
            other(500.0, [12.0, 0.0, -4.0])
            np.testing.assert_array_equal(ask(), before, name)


def test_eight_threads_with_one_rotor_have_the_same_bits() -> None:
    want, fresh = told(rotor(), 40), pm.Rotor(rotor().model)
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda _: told(fresh, 40), range(16)))
    assert all(one == want for one in found)


def test_a_pickled_rotor_has_the_same_bits_in_another_process() -> None:
    want = told(rotor())  # the core has had threads before it forks
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of forks, by newer Pythons and by JAX
        with multiprocessing.get_context("fork").Pool(2) as pool:
            found = pool.map(told_elsewhere, [pickle.dumps(rotor())] * 3)
    assert all(one == want for one in found)
    assert repr(pickle.loads(pickle.dumps(rotor()))) == repr(rotor())


SPECIAL = np.array(
    [np.nan, np.inf, -np.inf, 0.0, -0.0, -1.0, 1e300, -1e300, 1e-300, 5e-324, 1.0, 600.0, 1e9]
)


def anything(random: np.random.Generator) -> Any:
    """A number or an array as a user may give it."""
    if random.random() < 0.4:
        return random.choice([0.0, 0.3, 2.0, 1e-300, 400.0])
    kind = random.integers(0, 12)
    shape = [(), (1,), (3,), (0,), (2, 3), (3, 1), (33,)][random.integers(0, 7)]
    scale = 10.0 ** random.uniform(-3.0, 3.0)
    values = np.where(
        random.random(shape) < 0.25,
        random.choice(SPECIAL, shape),
        scale * random.uniform(-0.2, 1.0, shape),
    )
    if random.random() < 0.5:
        values = np.abs(np.nan_to_num(values, posinf=1.0))
    match kind:
        case 0:
            return values.astype(np.float32)
        case 1:
            return np.nan_to_num(values, posinf=1.0).clip(-1e6, 1e6).astype(np.int64)
        case 2:
            return np.asfortranarray(values)
        case 3:
            return np.repeat(values.ravel(), 2)[::2].reshape(values.shape)
        case 4:
            return values[..., None].repeat(3, -1)[..., 1]
        case 5:
            return values.tolist()
        case 6:
            return [None, "fast", [1.0, [2.0]], object(), 1j, True, b"1", {}][random.integers(0, 8)]
        case 7:
            return values.astype(">f8")
        case 8:
            return values.astype(np.complex128) if random.random() < 0.3 else values.astype(object)
    return values


def check(found: pm.Loads) -> None:
    lost = found.status == "not_converged"
    assert set(np.unique(found.status)) <= set(STATUSES)
    for name in LOADS:
        assert (np.isnan(getattr(found, name)) == lost).all(), name


CALLS: dict[str, Callable[[pm.Rotor, Callable[[], Any]], Any]] = {
    "loads": lambda r, a: check(r.loads(a(), a(), a())),
    "at_velocity": lambda r, a: check(r.loads_at_velocity(a(), a())),
    "wrench": lambda r, a: r.wrench(a(), [a(), a(), a()]),
    "gradients": lambda r, a: r.gradients(NAMES[:3], a(), a(), a()),
    "hover": lambda r, a: r.hover_inflow(a()),
    "attached": lambda r, a: r.attached_thrust(a(), a(), a()),
    "explain": lambda r, a: r.explain(a(), a(), a()),
    "inflow": lambda r, a: r.inflow(a(), a(), a(), radius=a()),
    "azimuth": lambda r, a: r.inflow(500.0, 5.0, 1.0, azimuth=a()),
    "section": lambda r, a: r.model.airfoil.coefficients(a(), a()),
}


def answered(call: str) -> int:
    """How many of 100 calls, or 200, were answered; all others were refused in one line."""
    random, count, which = np.random.default_rng(9), 0, ("recommended", "paper", "table")
    # Hardly any radius at random lies on the blade.
    for k in range(200 if call == "inflow" else 100):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                CALLS[call](rotor(which[k % 3]), lambda: anything(random))
                count += 1
            except pm.InputError as refused:
                assert "\n" not in str(refused)
            except (TypeError, ValueError):
                if call != "section":  # which leaves it to NumPy
                    raise
    return count


@pytest.mark.parametrize("call", CALLS)
def test_any_call_gives_loads_or_a_refusal(call: str) -> None:
    """1100 calls in all: NaN, infinities, huge and tiny numbers, empty and odd arrays.

    In a process of its own, whose fall is that of one test.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as pool:
            assert pool.submit(answered, call).result() >= (1 if call == "inflow" else 5)


@pytest.mark.parametrize(("count", "psi"), [(0, None), (3, [0.3]), (1101, None)])
def test_fields_have_the_shape_that_is_asked_for(count: int, psi: list[float] | None) -> None:
    radius = np.linspace(0.03, 0.1, count)
    field = rotor().inflow(600.0, 5.0, 1.0, radius=radius, azimuth=psi)
    for name in ("inflow", "thrust_per_radius", "drag_per_radius", "torque_per_radius"):
        assert getattr(field, name).shape == (count,), name
    shape = (count, 73 if psi is None else 1)
    assert field.alpha.shape == field.local_inflow.shape == shape


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("value", [1e300, 1e100, 1e-20, 1e-300])
def test_huge_and_tiny_flows_have_loads_or_a_status(value: float) -> None:
    for which in ("recommended", "table"):
        one = rotor(which)
        for at in ((value, 0.0), (600.0, value), (value, value), (0.0, value)):
            for beta in (0.0, 1.0, np.pi):
                found = one.loads(*at, beta)
                lost = found.status == "not_converged"
                assert bool(np.isnan(found.thrust)) == bool(lost), (which, at, beta)
