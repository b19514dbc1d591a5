"""The loads, derivatives and inflow of a rotor at any operating point."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from propmap import backward, bands, results
from propmap.errors import InputError
from propmap.loads import DRAG_FACTOR, GEOMETRY, LOADS, MOUNT_AREA
from propmap.model.airfoil import GROWING, GROWTHS
from propmap.model.corrections import Installed, name_of
from propmap.model.model import Model
from propmap.model.propeller import blade_intervals
from propmap.operating_points import (
    FAR,
    FlowPoints,
    Further,
    along_and_across,
    broadcast,
    numbers,
    resolved,
    split_velocity,
)
from propmap.tasks import cores
from propmap.typing import CoreRotor, Floats

ACCURACIES = ("standard", "fine")

_STATUSES = np.asarray(results.STATUSES)

RADII_TOGETHER = 1000  # largest number of radii for which the core computes fields in one call


def include_folder() -> Path:
    """Return the folder of the C++ headers of the core."""
    from propmap.core import HEADERS

    return HEADERS


def core_corrections(model: Model) -> dict[str, Any]:
    """Return the corrections of a ``model`` in the form that the core reads: numbers by name."""
    found: dict[str, Any] = {}
    for value in model.applied:
        found |= value.core_numbers(name_of(value), model)
    return found


NEAREST = 0.3  # smallest distance of the ground or a ceiling from the disk, over the radius


class Rotor:
    """Rotor that computes the loads of a model at any operating point.

    Parameters
    ----------
    model : Model
        Propeller, section law, air and corrections.
    accuracy : str
        "standard" (0.1 % of static thrust and torque) or "fine" (0.01 %, slower).

    Raises
    ------
    InputError
        For a ``model`` that is not a ``Model``, or an unknown ``accuracy``.
    """

    def __init__(self, model: Model, *, accuracy: str = "standard") -> None:
        if not isinstance(model, Model):
            found = f"model is {model!r}"
            raise InputError(found, "give a Model, from propmap.Model(propeller, airfoil)")
        if accuracy not in ACCURACIES:
            raise InputError(f"accuracy is {accuracy!r}: it must be one of {', '.join(ACCURACIES)}")
        self.model, self.accuracy = model, accuracy

    def __repr__(self) -> str:
        m = self.model
        return (
            f"Rotor({m.propeller.name}, {m.law_title}, rho={m.air.density} kg/m^3, "
            f"accuracy={self.accuracy})"
        )

    def __getstate__(self) -> dict[str, Any]:
        return {"model": self.model, "accuracy": self.accuracy}

    def with_model(self, model: Model) -> Rotor:
        """Return a rotor of another ``model`` with the same accuracy."""
        return Rotor(model, accuracy=self.accuracy)

    @functools.cached_property
    def _core(self) -> CoreRotor:
        """Rotor of the compiled core for this model."""
        return self._core_of(self.model.airfoil.core_law())

    @functools.cached_property
    def _core_of_growth(self) -> CoreRotor:
        """The rotor with a law that is differentiable by exponents of Re, also if they are zero."""
        return self._core_of({**self.model.airfoil.core_law(), "kind": GROWING})

    @functools.cached_property
    def _backward(self) -> tuple[CoreRotor, CoreRotor]:
        """Upside-down rotors of the core, for negative omega; see ``propmap.backward``."""
        law = self.model.airfoil.core_law()
        with_camber, without = backward.more_twist(self.model)
        return self._core_of(law, with_camber), self._core_of(law, without)

    def _core_of(self, law: dict[str, Any], more_twist: float = 0.0) -> CoreRotor:
        from propmap import core

        p, air = self.model.propeller, self.model.air
        root, tip = self.model.span
        intervals = blade_intervals(p, root, more_twist)
        blade = {"blades": p.blades, "root": root, "tip": tip, "intervals": intervals}
        medium = {"density": float(air.density), "viscosity": float(air.viscosity)}
        fine = self.accuracy == "fine"
        return core.Rotor(blade, law, medium, core_corrections(self.model), fine)

    def loads(
        self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike, **further: Unpack[Further]
    ) -> results.Loads:
        """Return the loads at operating points.

        Parameters
        ----------
        omega, speed : array_like
            Rotational speed [rad/s] and airspeed V >= 0 [m/s]; broadcast with ``beta``.  A negative
            omega describes a propeller that turns backward, not a propeller of the other spin.
        beta : array_like
            Angle between velocity and rotor axis [rad]: 0 axial climb, pi/2 edgewise flight, pi
            axial descent.  beta and 2 pi - beta are mirror images with the same loads.
        **further
            ``height`` is the distance of the disk above level ground.  ``ceiling`` is the distance
            of a level ceiling above the disk [m].  Both are at least 0.3 R; None if far away.  The
            ground multiplies the thrust by 1 + 0.424 exp(-h/0.686R)/(1 + (V sin(beta)/v_i)^2),
            where v_i is the mean inflow.  The factor of the ceiling is 1 + 0.148 exp(-c/1.61R)/(1 +
            (V sin(beta)/v_i)^2).  Both are fitted to static thrust (docs/theory.md).  The other
            loads do not change.

        Raises
        ------
        InputError
            For a negative airspeed, non-finite values, shapes that do not broadcast, and
            distances below 0.3 R.
        """
        return self._loads(self._allowed(resolved(omega, speed, beta, **further)))

    def loads_at_velocity(
        self, omega: ArrayLike, velocity: ArrayLike, **further: Unpack[Further]
    ) -> results.Loads:
        """Return the loads for a velocity vector in the rotor frame.

        Parameters
        ----------
        omega : array_like, shape (...)
            Rotational speed [rad/s], as in ``loads``.
        velocity : array_like, shape (..., 3)
            Velocity of the hub through the air, z along the thrust [m/s].  The leading axes
            broadcast with ``omega``.
        **further
            ``height`` and ``ceiling``, as in ``loads``.
        """
        points, _ = split_velocity(omega, velocity, **further)
        return self._loads(self._allowed(points))

    def wrench(
        self, omega: ArrayLike, velocity: ArrayLike, spin: str = "ccw", **further: Unpack[Further]
    ) -> results.Wrench:
        """Return force and moment on the vehicle, as vectors in the rotor frame.

        The rotor frame is right-handed with z along the thrust.

        Parameters
        ----------
        omega, velocity : array_like
            As in ``loads_at_velocity``.
        spin : str
            Direction of rotation, "ccw" or "cw", seen from above with the thrust up.
        **further
            ``height`` and ``ceiling``, as in ``loads``.
        """
        sign = np.array([results.spin_sign(spin)])
        points, direction = split_velocity(omega, velocity, **further)
        loads, _, _ = self._solved(self._allowed(points).rows)
        return results.hub_wrench(loads, direction, sign)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters that ``gradients`` accepts.

        - the constants of the section law;
        - "drag_factor" [-] and "mount_area" [m^2] of an installed rotor;
        - "chord_scale" [-], a relative change of the chord at all stations;
        - "twist_offset" [rad], a change of the twist at all stations;
        - "untwist" [rad], the decrease of the tip twist at a tip speed of 100 m/s;
        - "omega" [rad/s], "v_axial" and "v_inplane" [m/s], "height" and "ceiling" [m].
        """
        law = self.model.airfoil.parameters
        no_mount = self.model.correction_of(Installed) is None
        installed = () if no_mount else (DRAG_FACTOR, MOUNT_AREA)
        return (*law, *installed, *GEOMETRY, *FlowPoints._fields)

    def gradients(
        self,
        names: Iterable[str],
        omega: ArrayLike,
        v_axial: ArrayLike,
        v_inplane: ArrayLike,
        **further: Unpack[Further],
    ) -> results.LoadGradients:
        """Return the loads and their derivatives with respect to the named parameters.

        The derivatives follow from the implicit function theorem at the solved inflow.  The flow
        is given by velocity components, because derivatives with respect to beta do not exist at
        rest.

        Parameters
        ----------
        names : iterable of str
            P names from ``parameters``.
        omega, v_axial, v_inplane : array_like, shape (...)
            Rotational speed >= 0 [rad/s], V cos(beta) [m/s] and V sin(beta) >= 0 [m/s]; the three
            arrays broadcast.
        **further
            ``height`` and ``ceiling``, as in ``loads``.

        Returns
        -------
        LoadGradients
            ``loads`` (L, ...) in the order of ``propmap.loads.LOADS`` [N], [N m], NaN where no
            inflow was found, and ``slopes`` (L, P, ...) per unit of each parameter.

        Raises
        ------
        InputError
            For an unknown name, negative omega or v_inplane, and values that ``loads`` refuses.
        """
        return self.gradients_at(names, along_and_across(omega, v_axial, v_inplane, **further))

    def gradients_at(self, names: Iterable[str], points: FlowPoints) -> results.LoadGradients:
        """Return the result of ``gradients`` for ``names`` at checked and broadcast ``points``."""
        wanted = list(names)
        unknown = [name for name in wanted if name not in self.parameters]
        if unknown:
            found = f"loads have no derivative with respect to {unknown[0]!r}"
            raise InputError(found, f"give names from {', '.join(self.parameters)}")
        points = self._allowed(points)
        shape = points.omega.shape
        core = self._core if GROWTHS.isdisjoint(wanted) else self._core_of_growth
        found, slopes = core.loads(points.rows, wanted, cores())
        return results.LoadGradients(
            found[: len(LOADS)].reshape(len(LOADS), *shape),
            slopes.reshape(len(LOADS), len(wanted), *shape),
        )

    def attached_thrust(
        self,
        omega: ArrayLike,
        v_axial: ArrayLike,
        v_inplane: ArrayLike,
        others: Sequence[Model] = (),
    ) -> tuple[Floats, Floats]:
        """Return the thrust of fully attached blades: a fast initial estimate.

        The inflow of each annulus follows from Glauert's momentum theory, eq. (10) of the paper,
        and the lift at small angles of attack.  Drag, tip loss and stall are neglected.  For partly
        stalled blades this estimate is too large: in hover, the full solution has up to 40 % less
        thrust.  In descent, momentum theory has several solutions or none.  The search starts above
        the largest one.  Without a solution, the result is not reliable.

        Parameters
        ----------
        omega, v_axial, v_inplane : array_like, shape (...)
            As in ``gradients``.
        others : sequence of P Model
            Variants of the model with slightly different section constants or untwist.

        Returns
        -------
        thrust : ndarray, shape (...)
            Thrust of the model [N].
        more : ndarray, shape (P, ...)
            Thrust of each of ``others`` minus ``thrust`` [N].

        Raises
        ------
        InputError
            For negative omega or v_inplane, and for values that ``loads`` refuses.
        """
        points = along_and_across(omega, v_axial, v_inplane)
        shape, rows = points.omega.shape, points.rows
        thrust = self._core.attached_thrust(rows)
        more = [self.with_model(one)._core.attached_thrust(rows) - thrust for one in others]
        return thrust.reshape(shape), np.reshape(more, (len(others), *shape))

    def hover_inflow(self, omega: ArrayLike) -> Floats:
        """Return the static inflow v_i0 [m/s] of eq. (12) at ``omega`` [rad/s].

        The inflow is computed from the static thrust of this rotor.
        """
        thrust = self.loads(numbers("omega", omega, negative=False), 0.0, 0.0).thrust
        area = np.pi * self.model.span[1] ** 2
        return np.asarray(np.sqrt(np.maximum(thrust, 0.0) / (2.0 * self.model.air.density * area)))

    def inflow(
        self,
        omega: float,
        speed: float,
        beta: float,
        *,
        radius: ArrayLike | None = None,
        azimuth: ArrayLike | None = None,
    ) -> results.Inflow:
        """Return the inflow, the angle of attack and the loads over the disk.

        The inflow v_i also acts on a wing behind the rotor (footnote 3 of the paper).

        Parameters
        ----------
        omega, speed, beta : float
            One operating point, as in ``loads``.
        radius : array_like, optional
            Stations between root and tip [m]; by default 60.
        azimuth : array_like, optional
            Azimuth psi [rad]; by default every 5 degrees of a full turn.
        """
        rows = resolved(omega, speed, beta, one=True).rows
        root, tip = self.model.span
        y = broadcast(radius=np.linspace(root, tip, 60) if radius is None else radius)[0].ravel()
        turn = np.linspace(0.0, 2.0 * np.pi, 73)
        psi = broadcast(azimuth=turn if azimuth is None else azimuth)[0].ravel()
        if (y < root).any() or (y > tip).any():
            raise InputError(f"radius must lie between {root:g} and {tip:g} m")
        starts = range(0, max(y.size, 1), RADII_TOGETHER)
        parts = [self._core.disk_field(rows, y[k : k + RADII_TOGETHER], psi) for k in starts]
        means, local = (
            np.moveaxis(np.concatenate(each), -1, 0) for each in zip(*parts, strict=True)
        )
        names = (
            *("inflow", "thrust_per_radius", "drag_per_radius", "torque_per_radius"),
            *("local_inflow", "alpha", "past_stall", "u_tangential", "u_normal", "normal_force"),
        )
        found = dict(zip(names, (*means, *local), strict=True))
        stalled, reverse = found["past_stall"] > 0.0, found["u_tangential"] < 0.0
        return results.Inflow(radius=y, azimuth=psi, stalled=stalled, reverse=reverse, **found)

    def _allowed(self, points: FlowPoints) -> FlowPoints:
        """Return ``points``; raise ``InputError`` for distances below 0.3 R."""
        for name, values in (("height", points.height), ("ceiling", points.ceiling)):
            if values is not FAR and (values < (least := NEAREST * self.model.span[1])).any():
                raise InputError(
                    f"{name} is {values.min():g} m, less than 0.3 radii, {least:g} m",
                    "give a larger distance from the disk [m]; omit it if it is large",
                )
        return points

    def _loads(self, points: FlowPoints) -> results.Loads:
        shape, rows = points.omega.shape, points.rows
        loads, found, deviations = self._solved(rows)
        if not self._has_deviations:
            return self._as_loads(loads, found, rows[0], shape)
        at = functools.partial(self._deviations, FlowPoints(*rows), loads, shape, deviations)
        return self._as_loads(loads, found, rows[0], shape, at)

    def _solved(self, rows: Floats) -> tuple[Floats, Floats, Floats | None]:
        """Return loads (L, N), the other results of the core (5, N), and the additional standard
        deviations (L, N) of points with negative omega, or None without such points."""
        turns_back = rows[0] < 0.0
        if not turns_back.any():
            found, _ = self._core.loads(rows, (), cores())
            return found[: len(LOADS)], found[len(LOADS) :], None
        tip = self.model.span[1]
        back = backward.solve(self._backward, tip, rows[:, turns_back])
        every, _ = self._core.loads(np.where(turns_back, 0.0, rows), (), cores())
        loads, found = np.split(every, [len(LOADS)])
        deviations = np.zeros_like(loads)
        for whole, part in zip((loads, found, deviations), back, strict=True):
            whole[:, turns_back] = part
        return loads, found, deviations

    @functools.cached_property
    def _has_deviations(self) -> bool:
        return self.model.uncertainty is not None

    def _deviations(
        self, at: FlowPoints, loads: Floats, shape: tuple[int, ...], backward: Floats | None
    ) -> dict[str, results.LoadValues]:
        """Return ``Loads.std_by_source`` of loads (L, N) at N points, in arrays of ``shape``; NaN
        without loads or derivatives.  ``backward`` (L, N) contains the additional standard
        deviations of points with negative omega."""
        # For negative omega, use the derivatives of this rotor in the mirrored forward flow.
        turned = np.where(at.omega < 0.0, -1.0, 1.0)
        turned_at = at._replace(omega=turned * at.omega, v_axial=turned * at.v_axial)
        found = bands.deviations(
            self.model, turned_at, loads, lambda names: self.gradients_at(names, turned_at).slopes
        )
        if backward is not None:
            found["discrepancy"] = np.hypot(found["discrepancy"], backward)
        values = {}
        for source, rows in found.items():
            lost = np.where(np.isnan(loads), np.nan, rows)
            by_name = dict(zip(LOADS, (row.reshape(shape) for row in lost), strict=True))
            values[source] = results.LoadValues(
                **by_name, power=by_name["torque"] * np.abs(at.omega).reshape(shape)
            )
        return values

    def _as_loads(
        self,
        loads: Floats,
        found: Floats,
        omega: Floats,
        shape: tuple[int, ...],
        deviations: results.Deviations | None = None,
    ) -> results.Loads:
        """Return ``Loads`` from loads (L, N) and the other results of the core (5, N)."""
        by_name = {name: row.reshape(shape) for name, row in zip(LOADS, loads, strict=True)}
        status, roots, ring, mean_inflow, reverse = (row.reshape(shape) for row in found)
        return results.Loads(
            **by_name,
            power=by_name["torque"] * omega.reshape(shape),
            status=np.asarray(_STATUSES[status.astype(np.int64)]),
            roots=roots.astype(np.int64),
            reverse_flow=reverse,
            vortex_ring=ring,
            mean_inflow=mean_inflow,
            deviations=deviations,
        )
