"""Loads measured on a bench or in a wind tunnel: files, and rows for fits."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.catalogue.lookup import measurement, measurement_names
from propmap.catalogue.lookup import propeller as named
from propmap.errors import InputError, located, quoted
from propmap.fit.least_squares import Evaluation, RowModel, Rows
from propmap.fit.parameters import (
    BODY,
    FIRST_GUESS,
    FLIGHT,
    INSTALLED,
    SECTION,
    SENSOR,
    WAKES,
    WING,
    Choice,
    constants_of,
    general,
)
from propmap.hover import HoverModel
from propmap.io.coefficients import Coefficients, looks_like_coefficients, read_coefficients
from propmap.io.csv import LOAD_COLUMNS, read_points
from propmap.loads import LOADS
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil
from propmap.model.corrections import BladeUntwist, Installed
from propmap.model.model import Model, Section
from propmap.model.plausibility import ACROSS, load_warnings, point_warnings
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM


@dataclass(frozen=True, eq=False)
class TunnelData:
    """Loads of one propeller at n operating points.

    Attributes
    ----------
    source : str
        Name of the data in reports.
    omega, speed, beta : ndarray, shape (n,)
        Rotational speed [rad/s], flight speed [m/s], angle to the axis [rad].
    loads : mapping of str to ndarray, shape (n,)
        Loads by the names of ``propmap.loads.LOADS`` [N], [N m]; NaN if not measured.
    remarks : tuple of str
        Notes on the interpretation of columns, and on values that are not measured loads.
    by_power : bool
        Whether the torque was computed from a power.
    """

    source: str
    omega: Floats
    speed: Floats
    beta: Floats
    loads: Mapping[str, Floats] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()
    by_power: bool = False

    def __len__(self) -> int:
        return int(self.omega.size)

    @property
    def folded_beta(self) -> Floats:
        """Angle beta in 0...pi [rad] (n,); beta and 2 pi - beta have the same loads."""
        return np.abs(np.remainder(self.beta + np.pi, 2.0 * np.pi) - np.pi)

    @property
    def flow(self) -> tuple[Floats, Floats, Floats]:
        """Rotational speed [rad/s], V cos(beta) and V sin(beta) >= 0 [m/s]; (n,) each."""
        across = np.abs(self.speed * np.sin(self.beta))
        return self.omega, self.speed * np.cos(self.beta), across

    @property
    def has_rotor_drag(self) -> bool:
        """Whether rotor drag was measured in oblique flow."""
        return "drag" in self.loads and bool(
            np.isfinite(self.loads["drag"][self.flow[2] > ACROSS]).any()
        )

    def picked(self, which: NDArray[Any]) -> TunnelData:
        """Return the rows ``which``, given as indices or as a mask."""
        loads = {name: values[which] for name, values in self.loads.items()}
        flow = self.omega[which], self.speed[which], self.beta[which]
        return TunnelData(self.source, *flow, loads)


def merged(parts: Sequence[TunnelData]) -> TunnelData:
    """Return the data of all ``parts`` as one set."""
    names = [name for name in LOADS if any(name in part.loads for part in parts)]

    def column(part: TunnelData, name: str) -> Floats:
        return part.loads.get(name, np.full(len(part), np.nan))

    loads = {n: np.concatenate([column(part, n) for part in parts]) for n in names}
    omega, speed, beta = (
        np.concatenate([getattr(p, axis) for p in parts]) for axis in ("omega", "speed", "beta")
    )
    source, power = ", ".join(p.source for p in parts), any(part.by_power for part in parts)
    return TunnelData(source, omega, speed, beta, loads, by_power=power)


def first_guess() -> Airfoil:
    """Return the section law with the constants x0 of (18)."""
    start: Any = {name: FIRST_GUESS[name] for name in SECTION}
    return Airfoil(**start)


def section_with(base: Section, values: Mapping[str, float]) -> Airfoil:
    """Return the section law ``base`` with the constants of ``SECTION`` in ``values``."""
    return constants_of(base).with_parameters(**{n: values[n] for n in SECTION if n in values})


def model_with(model: Model, values: Mapping[str, float]) -> Model:
    """Return the ``model`` with the parameters of ``ROTOR`` in ``values``."""
    model = model.with_airfoil(section_with(model.airfoil, values))
    if "untwist" in values:
        model = model.with_correction(BladeUntwist(values["untwist"]))
    if not INSTALLED.keys() & values.keys():
        return model
    own = model.correction_of(Installed) or Installed(1.0, 0.0)
    factor = values.get("drag_factor", own.factor)
    return model.with_mount(Installed(factor, values.get("mount_area", own.area_m2), own.wake))


def rotor_with(model: Model, values: Mapping[str, float], setting: str) -> Rotor:
    """Return the rotor of ``model_with`` with the accuracy ``setting``."""
    return Rotor(model_with(model, values), accuracy=setting)


def tunnel_rows(
    model: Model,
    data: TunnelData,
    choice: Choice,
    *,
    loads: Sequence[str] = (),
    weights: Mapping[str, float] | None = None,
    setting: str = "standard",
) -> Rows:
    """Return rows from loads measured on a bench or in a wind tunnel.

    Residuals are divided by rho Omega^2 R^4 (R^5 for moments), because measurement errors grow with
    rotational speed in proportion to this divisor.  The scale of a load is the root mean square of
    its measured coefficient, divided by its weight.  With a prior from other propellers, the square
    of the scale has a second term: the error of the load cell, which is constant in N or N m.  Both
    terms are equal at the highest rotational speed.  At lower speeds, the term of the load cell is
    larger.

    Parameters
    ----------
    model : Model
        Model with the propeller and the air of the test.  Its section law provides the constants
        that no fit varies.
    data : TunnelData
        Measured loads.
    choice : Choice
        Free parameters, fixed parameters and priors.
    loads : sequence of str
        Names of the loads to fit; by default all measured loads.
    weights : mapping of str to float, optional
        Factors on the residuals of loads (default: 1).
    setting : str
        Accuracy of the loads, as in ``Rotor``.

    Raises
    ------
    InputError
        For a load that was not measured, and for a free parameter without effect.
    """
    names, weights = tuple(loads) or tuple(n for n in LOADS if n in data.loads), weights or {}
    _check(data, choice, names, weights)
    axial, inplane = data.speed * np.cos(data.beta), data.speed * np.abs(np.sin(data.beta))
    inplane = np.where(inplane < 1e-12 * np.maximum(data.speed, 1.0), 0.0, inplane)
    measured = np.stack([data.loads[name] for name in names], axis=1)
    radius = model.propeller.radius
    force = np.maximum(model.air.density * data.omega**2 * radius**4, 1e-12)
    size = force[:, None] * [radius if LOADS[name].moment else 1.0 for name in names]
    typical = np.sqrt(np.nanmean((measured / size) ** 2, axis=0))
    for name, value in zip(names, np.ravel(typical), strict=True):
        if value == 0.0:
            fault = f"every value of {name} is zero"
            raise InputError(fault, "name only other loads with --loads", data.source)
    scale = typical * size
    if choice.expected is not None:
        scale = np.hypot(scale, scale.max(axis=0))
    columns = [list(LOADS).index(name) for name in names]

    def table(points: NDArray[np.intp]) -> RowModel:
        flow = data.omega[points], axial[points], inplane[points]

        def loads(values: Mapping[str, float], free: tuple[str, ...]) -> Evaluation:
            found = rotor_with(model, values, setting).gradients(free, *flow)
            return found.loads[columns].T, found.slopes[columns].transpose(2, 0, 1)

        return loads

    units = tuple(LOADS[name].unit for name in names)
    scale = scale / [weights.get(name, 1.0) for name in names]
    return Rows.of_points(names, units, measured, scale, data.speed, table)


def _check(
    data: TunnelData, choice: Choice, names: tuple[str, ...], weights: Mapping[str, float]
) -> None:
    useless = [n for n in choice.free if general(n) in BODY | WING | SENSOR | WAKES | FLIGHT]
    if useless:
        raise InputError(f"{useless[0]} has no effect in a tunnel test", "fit it to flights")
    for name in names:
        if name not in LOADS:
            raise InputError(f"{name!r} is not a load", f"choose from {', '.join(LOADS)}")
        if name not in data.loads or not np.isfinite(data.loads[name]).any():
            found = f"{data.source} has no {name}"
            raise InputError(found, f"fit {', '.join(data.loads) or 'other data'}")
        if names.count(name) > 1:
            raise InputError(f"{name} is named twice", "name it once, or give it a weight")
    for name, weight in weights.items():
        if name not in names:
            raise InputError(f"{name!r} has a weight but is not fitted", f"fit {', '.join(names)}")
        if not 0.0 < weight < np.inf:
            raise InputError(f"the weight of {name} is {weight:g}", "give a number above 0")
    for name in INSTALLED:
        if name in choice.free and "drag" not in names:
            raise InputError(f"{name} is free but drag is not fitted", "add drag to the loads")


def hover_rows(rotor: Rotor, data: TunnelData, rows: Rows) -> Floats:
    """Return the loads (M,) of the hover model of ``rotor`` for the ``rows`` of ``data``."""
    loads = HoverModel.from_rotor(rotor).loads(data.omega)
    return rows.picked(np.stack([loads[name] for name in rows.names], axis=1))


# --- DATA arguments of tunnel fits and checks: CSV files, UIUC files, catalogue names ------------


def sources(data: Sequence[str]) -> list[Path | str]:
    """Return files as paths and catalogue measurements as names; ``InputError`` for others."""
    known = measurement_names()
    found: list[Path | str] = []
    for item in data:
        if item.strip().lower() in known:
            found.append(item.strip().lower())
        elif Path(item).is_file():
            found.append(Path(item))
        else:
            fault = f"{quoted(item)} is neither a file nor a measurement of the catalogue"
            raise InputError(fault, f"give a path or one of {', '.join(known)}")
    return found


def read_tunnel(data: Sequence[str], propeller: Propeller, air: Air) -> TunnelData:
    """Return all ``data`` as one set, with the texts of ``data_warnings`` as remarks; propeller and
    air convert coefficients to loads."""
    parts = [_read(item, propeller, air) for item in sources(data)]
    remarks = (text for part in parts for text in data_warnings(part, propeller, air))
    return replace(merged(parts), remarks=tuple(remarks))


def data_warnings(data: TunnelData, propeller: Propeller, air: Air) -> list[str]:
    """Return notes on the interpretation of a file, and warnings of data that do not fit the
    propeller; raise an ``InputError`` for impossible loads or points."""
    points = data.omega, data.speed, data.beta
    with located(data.source):
        warnings = point_warnings(propeller, *points)
        warnings += load_warnings(propeller, air, *points, data.loads, by_power=data.by_power)
    return [f"{data.source}: {text}" for text in (*data.remarks, *warnings)]


def measured_in_catalogue(name: str, air: Air) -> TunnelData:
    """Return the catalogue measurement called ``name``, as loads in this ``air``."""
    m = measurement(name)
    # The catalogue contains loads at the density of the measurement.
    loads = {n: v * (air.density / m.air_density) for n, v in m.loads.items()}
    return TunnelData(name, m.omega, m.speed, m.beta, loads)


SAME_POWER = 0.03  # largest relative difference between electrical power and voltage times current


def measured_loads(path: Path, *, at_rest: bool = False) -> Callable[[Propeller, Air], TunnelData]:
    """Read the loads of a test; return a function of propeller and air that returns these loads,
    with coefficients converted to N or N m.  ``at_rest`` is an argument of ``read_points``."""
    if looks_like_coefficients(path):
        return functools.partial(_of_coefficients, path.name, read_coefficients(path))
    further = (*LOAD_COLUMNS, "power_W", "voltage_V", "current_A")
    points, columns, remarks = read_points(path, further, at_rest=at_rest)
    electrical = columns.pop("voltage_V", np.nan) * columns.pop("current_A", np.nan)
    power, omega = columns.pop("power_W", None), points.rpm * RPM
    if power is not None and np.mean(np.isclose(power, electrical, rtol=SAME_POWER)) > 0.5:
        remarks.append("power equals voltage times current: it is electrical and not used")
        power = None
    loads = {LOAD_COLUMNS[name]: values for name, values in columns.items()}
    if power is not None:
        remarks.append("power is assumed to be shaft power, not battery power")
        unknown = np.full_like(omega, np.nan)
        loads["torque"] = np.divide(power, omega, out=unknown, where=omega > 0.0)
    if not loads:
        known = ", ".join((*LOAD_COLUMNS, "power_W"))
        remedy = f"add one of {known}; power_W is shaft power"
        found = "; ".join(("there is no column with a load", *remarks))
        raise InputError(found, remedy, str(path))
    beta = np.radians(points.beta_deg)
    data = TunnelData(
        path.name, omega, points.speed_mps, beta, loads, tuple(remarks), by_power=power is not None
    )
    return lambda _propeller, _air: data


def _read(item: Path | str, propeller: Propeller, air: Air) -> TunnelData:
    if isinstance(item, str):
        found, own = measured_in_catalogue(item, air), named(measurement(item).propeller)
        both = [f"{one.blades} blades, R = {one.radius:.4f} m" for one in (own, propeller)]
        differ = own.blades != propeller.blades or abs(own.radius / propeller.radius - 1.0) > 0.02
        remark = f"the measured propeller has {both[0]}; {propeller.name} has {both[1]}"
        return replace(found, remarks=(remark,) if differ else ())
    return measured_loads(item)(propeller, air)


def _of_coefficients(name: str, c: Coefficients, propeller: Propeller, air: Air) -> TunnelData:
    turns, diameter = c.rpm / 60.0, 2.0 * propeller.radius
    force = air.density * turns**2 * diameter**4
    loads = {"thrust": c.thrust * force, "torque": c.power * force * diameter / (2.0 * np.pi)}
    flow = c.rpm * RPM, c.advance * turns * diameter, np.zeros_like(c.rpm)
    return TunnelData(name, *flow, loads, c.remarks)
