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
from propmap import core
from propmap.loads import LOADS
from propmap.results import STATUSES
from propmap.tasks import on_cores
from propmap.vehicle.vehicle import Body
from propmap.vehicle.vehicle_forces import airframe

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


BLADE = {"intervals": np.full((4, 9), 0.1), "blades": 2, "root": 0.02, "tip": 0.1}
AIR = {"density": 1.2, "viscosity": 1.8e-5}
FRAME = airframe(Body(), None, 1.2)
AXIS = np.array([0.0, 1.0])
FLAT = np.zeros(16)
KNOTS = (AXIS, FLAT)
ALONE = (None, np.zeros(5))  # a free body without wakes
TABLE = (np.zeros((4, 4, 12)), np.zeros((1, 1), np.uint8), ((0.0, 1.0),) * 3, 0.1)


def law(kind: str = "paper") -> dict[str, Any]:
    return dict(rotor(kind).model.airfoil.core_law())


def with_one(given: dict[str, Any], name: str) -> Callable[[np.ndarray], dict[str, Any]]:
    return lambda array: given | {name: array}


def push(which: int) -> Callable[[np.ndarray], Any]:
    """A call of a free body with one rotor, whose argument ``which`` is another array."""
    mount = np.array([[0.1, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]])
    body = core.FreeBody(mount, FRAME, [rotor()._core], 0.0, np.zeros(3), False, *ALONE)
    state, codes = np.zeros(body.inflow_size), np.zeros((2, 1), np.uint8)
    one = np.ones(1)
    given = [np.eye(7)[3], np.zeros(6), np.zeros(3), one, one, np.zeros(6), codes, state]

    def call(array: np.ndarray) -> Any:
        arrays = [*given, state.copy()]
        arrays[which] = np.zeros((2, len(array)), np.uint8) if which == 6 else array
        return body.push(*arrays, 0.01, True)

    return call


def wakes(rotors: int = 1, values: tuple[int, int] = (4, 4)) -> Any:
    """Wakes with a single spline; each rotor has the same frame."""
    frames, pairs = np.tile(np.eye(3), (rotors, 1)), np.zeros((rotors**2, 3))
    return core.Wakes(frames, pairs, KNOTS, KNOTS, np.ones((1, *values)))


def flow_in_wakes(which: int) -> Callable[[np.ndarray], Any]:
    """A call for two samples of two rotors, whose argument ``which`` is another array."""
    given = [np.ones(5), np.ones(4), np.ones(4), np.ones((4, 3)), np.ones(4)]

    def call(array: np.ndarray) -> Any:
        other = np.resize(array, (len(array), *given[which].shape[1:]))
        return wakes(2).flow(*given[:which], other, *given[which + 1 :])

    return call


def table(*change: Any) -> Callable[[np.ndarray], Any]:
    def call(array: np.ndarray) -> Any:
        given: list[Any] = [KNOTS, KNOTS, *TABLE]
        for at, make in change:
            given[at] = make(array)
        return core.Table(*given)

    return call


def bound_calls() -> dict[str, tuple[int, Callable[[np.ndarray], Any]]]:
    """Calls of all functions of the core with one array that must have this length."""
    full, plate = core.Table(KNOTS, KNOTS, *TABLE), law("table")
    rows = points(3)
    mount = np.array([[0.1, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]])
    up, three = np.eye(3)[2:], np.zeros((3, 3))
    loads = np.zeros((6, 1, 3))
    one = rotor()._core
    calls: dict[str, tuple[int, Callable[[np.ndarray], Any]]] = {
        "reynolds": (3, lambda x: core.section_coefficients(law(), np.ones(3), x)),
        "points solution": (1, lambda x: one.solution(np.ones((5, len(x))))),
        "points field": (1, lambda x: one.disk_field(np.ones((5, len(x))), [0.05], [0.0])),
        "beta slopes": (3, lambda x: full.slopes(rows[0], x)),
        "spins": (1, lambda x: core.hub_wrenches(up, x, three, loads)),
        "downstream": (3, lambda x: core.hub_wrenches(up, np.ones(1), np.ones((len(x), 3)), loads)),
        "center": (3, lambda x: core.FreeBody(mount, FRAME, [one], 0.0, x, False, *ALONE)),
        "sources": (
            1,
            lambda x: core.FreeBody(mount, FRAME, [one] * len(x), 0.0, three[0], False, *ALONE),
        ),
        "gains of a free body": (
            5,
            lambda x: core.FreeBody(mount, FRAME, [one], 0.0, three[0], False, wakes(), x),
        ),
        "mounts": (
            1,
            lambda x: core.FreeBody(
                np.resize(mount, (len(x), 7)),
                FRAME,
                [one] * len(x),
                0.0,
                three[0],
                False,
                wakes(),
                np.ones(5),
            ),
        ),
        "polynomials": (16, table((0, lambda x: (AXIS, x)))),
        "values": (4, table((2, lambda x: np.zeros((4, len(x), 12))))),
        "values rows": (4, table((2, lambda x: np.zeros((len(x), 4, 12))))),
        "values loads": (12, table((2, lambda x: np.zeros((4, 4, len(x)))))),
        "cells": (1, table((3, lambda x: np.zeros((1, len(x)), np.uint8)))),
    }
    for k, (name, length) in {
        0: ("gains", 5),
        2: ("inplane", 4),
        3: ("downstream", 4),
        4: ("thrust", 4),
    }.items():
        calls[f"{name} of wakes"] = (length, flow_in_wakes(k))
    for name in ("rows", "stall_up", "stall_down"):
        given, good = with_one(plate, name), plate[name]
        calls[name] = (
            good.size,
            lambda x, of=given, good=good: core.section_coefficients(
                of(np.resize(good, len(x))), FLAT, FLAT
            ),
        )
    for name, size in (("drag_area", 3), ("download_area", 2)):
        given = with_one(FRAME, name)
        calls[name] = (size, lambda x, of=given: core.free_stream_forces(of(x), three))
    size = one.inflow_size
    lengths = {"pose": 7, "motion": 6, "wind": 3, "omega": 1, "change": 1, "forces": 6}
    lengths |= {"codes": 1, "inflow": size, "later": size}
    for k, (name, length) in enumerate(lengths.items()):
        calls[name] = (length, push(k))
    return calls


def test_arrays_of_another_length_are_refused_by_name() -> None:
    """Otherwise the core would read memory beyond the array."""
    for name, (length, call) in bound_calls().items():
        call(np.ones(length))
        for wrong in {0, length - 1, length + 1, 100_000} - {length}:
            with pytest.raises(pm.InputError, match=f"array {name.split()[0]} has the length"):
                call(np.ones(wrong))


def without_dynamics() -> Any:
    blade, coleman = pm.propeller("apc-8x6e"), (pm.correction("coleman"),)
    return pm.Rotor(pm.Model(blade, pm.airfoil("paper-apc"), corrections=coleman))._core


@pytest.mark.parametrize(
    "call",
    [
        lambda: core.Rotor({**BLADE, "intervals": np.ones((0, 9))}, law(), AIR, {}, False),
        *(
            lambda name=name: core.section_coefficients(
                {**law("table"), name: FLAT[:0]}, FLAT, FLAT
            )
            for name in ("knots", "log_re", "first")
        ),
        lambda: table((0, lambda _: (AXIS[:1], FLAT[:0])))(FLAT),
        lambda: core.hub_flows(np.zeros((0, 3)), np.zeros((2, 3))),
        lambda: core.hub_wrenches(np.zeros((0, 3)), FLAT[:0], FLAT[:0].reshape(0, 3), FLAT[:0]),
        lambda: rotor()._core.disk_field(np.ones((5, 1)), np.full(1101, 0.05), [0.0]),
        lambda: core.Table(KNOTS, KNOTS, *TABLE).loads(np.ones((2, 3)), False),
        lambda: core.Table(KNOTS, KNOTS, *TABLE).bounded(np.ones((4, 3))),
        lambda: core.Wakes(np.eye(3)[:2], FLAT[:0].reshape(0, 3), KNOTS, KNOTS, np.ones((1, 4, 4))),
        lambda: core.Wakes(np.eye(3), np.zeros((2, 3)), KNOTS, KNOTS, np.ones((1, 4, 4))),
        lambda: wakes(2).flow(np.ones(5), *np.ones((2, 3)), np.ones((3, 3)), np.ones(3)),
        lambda: wakes(values=(3, 4)),
        lambda: wakes(values=(4, 5)),
        lambda: without_dynamics().inflow_motion(..., ..., 600.0, np.zeros(3), np.ones(1), 1),
    ],
)
def test_arrays_too_short_or_too_long_are_refused(call: Callable[[], Any]) -> None:
    with pytest.raises((pm.InputError, TypeError), match=r"has the length|incompatible function"):
        call()


@pytest.mark.parametrize("interval", [-1.0, 72.0, np.nan])
def test_a_table_without_an_interval_of_its_index_is_refused(interval: float) -> None:
    first = np.append(law("table")["first"], interval)
    with pytest.raises(pm.InputError, match="interval that does not exist"):
        core.section_coefficients({**law("table"), "first": first}, FLAT, FLAT)


def test_empty_and_huge_arrays_have_results_of_their_size() -> None:
    one, inflow = rotor("paper")._core, pm.DynamicInflow(rotor("paper"))
    full = core.Table(KNOTS, KNOTS, *TABLE)
    for count in (0, 3_000):
        rows, vectors, ones = np.zeros((5, count)), np.zeros((count, 3)), np.ones(count)
        assert one.loads(rows, (), 1)[0].shape == (11, count)
        assert one.loads(rows, ["omega"], 1)[1].shape == (6, 1, count)
        assert one.attached_thrust(rows).shape == (count,)
        assert full.loads(np.ones((3, count)), False).shape == (8, count)
        assert full.bounded(np.ones((3, count))).shape == (3, count)
        assert full.slopes(ones, ones).shape == (count, 2, 2, 12)
        assert core.section_coefficients(law(), ones, ones).shape == (2, count)
        assert core.hub_flows(np.eye(3), vectors).shape == (5, count)
        assert core.free_stream_forces(FRAME, vectors)[1].shape == (count, 3)
        states = np.zeros((count, inflow.size))
        assert inflow.step(states, 0.01, 0.0 * ones, vectors).shape == states.shape
        field = one.disk_field(np.ones((5, 1)), ones[:1000] * 0.05, ones[:0])
        assert field[1].shape == (min(count, 1000), 0, 6)


@pytest.mark.parametrize("motion", [(-600.0, 1.0, 4.0), (-600.0, 0.0, 0.0), (600.0, 1.0, -4.0)])
def test_a_negative_omega_or_inplane_velocity_has_no_loads(motion: tuple[float, ...]) -> None:
    """C++ programs pass such points directly; Python mirrors them first."""
    found, _ = rotor()._core.loads(np.array([[*motion, np.inf, np.inf]]).T.copy(), (), 1)
    assert np.isnan(found[:6]).all() and found[6, 0] == len(STATUSES) - 1


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
