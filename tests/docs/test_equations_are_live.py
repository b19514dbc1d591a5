"""A function that `docs/equations.md` names is on the live path: broken, it changes a result.

Every Python function returns 1.07 times its numbers.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import sys
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import propmap as pm
from papers.gill_dandrea_2017 import reference, rotor_drag
from propmap import hover
from propmap.fit import comparison, fit, flight
from propmap.fit.parameters import BODY, FIRST_GUESS, SECTION, Choice
from propmap.vehicle import wakes
from propmap.vehicle.vehicle import SLIPSTREAMS, Wakes, Wing
from tests.docs.test_equations import functions, rows
from tests.fit import test_paper_equations as paper

FACTOR = 1.07

NAMED = sorted({pair for _, cell, _ in rows() for pair in functions(cell)})

OMEGA = np.array([600.0, 600.0, 500.0, 600.0, 600.0, 600.0])
SPEED = np.array([0.0, 2.0, 14.0, 5.0, 15.0, 16.0])
BETA = np.radians([0.0, 60.0, 80.0, 175.0, 172.0, 180.0])
"""Hover, slow climb with stall, fast oblique flight, vortex ring, windmill, axial descent."""


def broken(value: Any) -> Any:
    """A copy with every number in it wrong; of texts none is left."""
    if isinstance(value, (float, np.ndarray, np.floating)):
        return value * FACTOR if np.issubdtype(np.asarray(value).dtype, np.floating) else value
    if isinstance(value, tuple):
        make = getattr(value, "_make", tuple)
        return make(broken(part) for part in value)
    if isinstance(value, dict):
        return {name: broken(part) for name, part in value.items()}
    if isinstance(value, list):
        return []
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = [f.name for f in dataclasses.fields(value) if f.init]
        changed = {name: broken(getattr(value, name)) for name in names}
        return dataclasses.replace(value, **changed)
    return value


def breaking(function: Callable[..., Any]) -> Any:
    """Return the function with wrong numbers."""
    return functools.wraps(function)(lambda *given, **named: broken(function(*given, **named)))


def break_it(patch: pytest.MonkeyPatch, module: str, name: str) -> None:
    """Break a method in its class, or a function in every module that knows it."""
    *owner, last = name.split(".")
    if owner:
        kind = getattr(importlib.import_module(module), owner[0])
        found = vars(kind)[last]
        if isinstance(found, property):
            patch.setattr(kind, last, property(breaking(found.fget)))  # type: ignore[arg-type]
        elif isinstance(found, classmethod):
            patch.setattr(kind, last, classmethod(breaking(found.__func__)))
        else:
            patch.setattr(kind, last, breaking(found))
        return
    function = getattr(importlib.import_module(module), last)
    wrong, places = breaking(function), 0
    for key, one in list(sys.modules.items()):
        if key.split(".")[0] in ("propmap", "papers"):
            for attribute, value in list(vars(one).items()):
                if value is function:
                    patch.setattr(one, attribute, wrong)
                    places += 1
    assert places


def leaves(tree: Any) -> Iterator[np.ndarray]:
    """The arrays and numbers of nested tuples, lists, dictionaries and dataclasses."""
    if dataclasses.is_dataclass(tree) and not isinstance(tree, type):
        tree = [getattr(tree, field.name) for field in dataclasses.fields(tree)]
    if isinstance(tree, dict):
        tree = list(tree.values())
    if isinstance(tree, (tuple, list)):
        for part in tree:
            yield from leaves(part)
    elif tree is not None:
        yield np.ravel(np.asarray(tree))


def numbers(tree: Any) -> np.ndarray:
    kept = [a.astype(float) for a in leaves(tree) if np.issubdtype(a.dtype, np.number)]
    return np.nan_to_num(np.concatenate(kept), nan=-1.0)


def rotor() -> pm.Rotor:
    return pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")))


def loads() -> Any:
    found = rotor().loads(OMEGA, SPEED, BETA)
    return found.thrust, found.drag, found.torque, found.roll_moment


def plain_reference() -> Any:
    """Few steps of the plain reference: in climb, the vortex ring and windmill descent."""
    law = pm.airfoil("paper-apc")
    terms = {"zero_lift_angle": -0.05, "reynolds_camber": -0.02, "drag_angle": 0.07}
    terms |= {"reynolds_lift": 0.12, "reynolds_drag": -0.35}
    both = law.with_parameters(**terms), law.with_parameters(lift_law="simplified")
    corrections = pm.model_corrections("recommended")
    models = [pm.Model(pm.propeller("apc-8x6e"), one, corrections=corrections) for one in both]
    points = ((1.0, 4.0), (-6.0, 0.5), (-16.0, 2.0))
    return [reference.loads(one, 600.0, *flow, 6, 8) for one in models for flow in points]


def inflow() -> Any:
    found = rotor().inflow(600.0, 5.0, 1.0, radius=[0.05, 0.09], azimuth=[0.0, 2.0])
    return found.inflow, found.thrust_per_radius


def hover_model() -> Any:
    model = hover.HoverModel.from_rotor(rotor())
    return model.thrust(OMEGA), model.torque(OMEGA)


def fin() -> Any:
    blade = pm.propeller("apc-8x6e")
    return rotor_drag.side_force(blade, 2.0, 10.0, 0.1, 1.225, zero_lift_angle=-0.05)


def flights() -> Any:
    """Residuals of both balances, of a vehicle with a body and a wing."""
    wing = Wing(0.02, 0.1)
    vehicle = dataclasses.replace(paper.QUADROTOR, wing=wing)
    model = flight.ForceModel(vehicle, paper.flights(slice(None)), paper.LAW)
    values = paper.VALUES | dict.fromkeys(BODY, 0.01) | flight.wing_values(vehicle)
    found = []
    for make in (flight.level_rows, flight.balance_rows):
        made = make(model, paper.TWO)
        value, _ = made.model(values, paper.TWO.free)
        found.append((value - made.measured) / made.scale)
    return found


def whole_flights() -> Any:
    """Forces on a turning vehicle whose rotors are in each other's wakes, where its sensor is."""
    vehicle = dataclasses.replace(
        paper.QUADROTOR,
        wakes=Wakes(2.0, 1.0, 1.0, 0.8),
        sensor=(0.02, 0.01, 0.0),
        inertia=(4e-3, 5e-3, 8e-3),
        rotor_inertia=2e-5,
    )
    log = paper.flights(slice(None))
    turning = np.tile([0.3, -0.5, 0.8], (len(log), 1))
    log = dataclasses.replace(
        log, rates=turning, angular_acceleration=2.0 * turning, specific_force_rate=turning
    )
    model = flight.ForceModel(vehicle, log, paper.LAW)
    rows = flight.balance_rows(model, paper.TWO)
    mounts = tuple(
        dataclasses.replace(one, position=(0.2, 0.1, 0.1 * k))
        for k, one in enumerate(vehicle.mounts[:2])
    )
    coaxial = dataclasses.replace(vehicle, mounts=mounts, inertia=None, wakes=SLIPSTREAMS)
    rotor = pm.Rotor(pm.Model(coaxial.propeller, paper.LAW, coaxial.air))
    above = pm.VehicleForces(coaxial, rotor).wrench([600.0, 600.0], (2.0, 0.0, 1.0))
    return model.at(paper.VALUES, ()).loads, rows.measured, above.force


def all_flights() -> Any:
    return flights(), whole_flights()


def made_up_fit() -> Any:
    """A fit of a linear model, and what it says of a body that the data ask for."""
    random = np.random.default_rng(3)
    columns = dict(zip(("c_l1", "alpha_0", "lift_area"), random.normal(size=(3, 40)), strict=True))
    columns["lift_area"] = columns["lift_area"] * 100.0
    model = paper.linear_model(columns)
    start = FIRST_GUESS | {name: getattr(paper.LAW, name) for name in SECTION}
    value, _ = model(start | {"lift_area": 0.03}, ("c_l1",))
    data = paper.rows_of(model, np.asarray(value) + 0.05 * random.normal(size=40))
    found = fit.fit(data, paper.TWO, fit.Settings(starts=1, folds=0))
    verdict = comparison.body_terms_verdict(found, lambda _: data)
    return found.x, float(len(verdict)), Choice().first


PROBES: dict[str, Callable[[], Any]] = {
    "papers.gill_dandrea_2017.reference": plain_reference,
    "propmap.model": loads,
    "propmap.rotor": inflow,
    "propmap.hover": hover_model,
    "papers.gill_dandrea_2017.fin_analogy": fin,
    "propmap.vehicle": flights,
    "propmap.vehicle.wakes": all_flights,
    "propmap.fit.flight": all_flights,
    "propmap.fit.moments": all_flights,
    "propmap.fit": made_up_fit,
}
"""What must change, by the longest of these with which a module's name begins."""


def probe_of(module: str) -> Callable[[], Any]:
    return PROBES[max((key for key in PROBES if module.startswith(key)), key=len)]


@functools.cache
def unbroken(probe: Callable[[], Any]) -> np.ndarray:
    return numbers(probe())


def forget() -> None:
    """Clear the tables of the wakes' velocity, which would hide that their parts are broken."""
    for one in (wakes._table, wakes._slipstream_table, wakes.seen_wake, wakes.frame_of):
        one.cache_clear()
    wakes._above_each_other.cache_clear()


# What is broken may come out as a factor on the drag.
@pytest.mark.parametrize(("module", "name"), NAMED)
def test_what_comes_out_changes(module: str, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    probe = probe_of(module)
    right = unbroken(probe)
    assert np.isfinite(right).all()
    break_it(monkeypatch, module, name)
    if module == "propmap.vehicle.wakes":
        forget()
    wrong = numbers(probe())
    if module == "propmap.vehicle.wakes":
        forget()
    change = np.abs(wrong - right) / np.abs(right).max()
    assert change.max() > 1e-6, f"{module}.{name} is not on the live path"
