"""Loads of a model at any operating point."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from propmap import bands, results
from propmap.errors import InputError
from propmap.loads import DRAG_FACTOR, GEOMETRY, LOADS, MOUNT_AREA
from propmap.model.corrections import Installed, name_of
from propmap.model.model import Model
from propmap.operating_points import (
    FAR,
    FlowPoints,
    Further,
    along_and_across,
    broadcast,
    rates_of,
    resolved,
    split_velocity,
)
from propmap.tasks import cores
from propmap.typing import CoreRotor, Floats

ACCURACIES = ("standard", "fine")

_STATUSES = np.asarray(results.STATUSES)

RADII_TOGETHER = 1000  # radii at which the core gives fields over the disk in one call, at most


def include_folder() -> Path:
    """Find the folder of the core's C++ headers."""
    from propmap.core import HEADERS

    return HEADERS


def core_corrections(model: Model) -> dict[str, Any]:
    """Write the corrections of a ``model`` as the core takes them: numbers by name."""
    found: dict[str, Any] = {}
    for value in model.applied:
        found |= value.core_numbers(name_of(value), model)
    return found


class Rotor:
    """Loads of a model at any operating point: the face of the package.

    Parameters
    ----------
    model : Model
        Propeller, section law, air and corrections.
    accuracy : str
        "standard" (0.1 % of static thrust and torque) or "fine" (0.01 %, slower).

    Raises
    ------
    InputError
        For arguments of another kind.
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
        """A rotor of another ``model`` with the accuracy of this one."""
        return Rotor(model, accuracy=self.accuracy)

    @functools.cached_property
    def _core(self) -> CoreRotor:
        """The model in the compiled core."""
        from propmap import core

        p, air = self.model.propeller, self.model.air
        blade: dict[str, Any] = {"blades": int(p.blades), "root": float(p.root)}
        for name in ("station", "chord", "twist"):
            blade[name] = np.ascontiguousarray(getattr(p, name), np.float64)
        medium = {"density": float(air.density), "viscosity": float(air.viscosity)}
        law = self.model.airfoil.core_law()
        fine = self.accuracy == "fine"
        return core.Rotor(blade, law, medium, core_corrections(self.model), fine)

    def loads(
        self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike, **further: Unpack[Further]
    ) -> results.Loads:
        """Loads at operating points.

        Parameters
        ----------
        omega, speed : array_like
            Rotational speed [rad/s] and V [m/s], >= 0; all three broadcast.
        beta : array_like
            Angle of the velocity to the axis [rad]: 0 axial climb, pi/2 edgewise flight, pi axial
            descent; beta and 2 pi - beta are mirror images with the same loads.
        **further
            ``height`` of the disk above level ground [m], R/2 or more, or None far from it.  Thrust
            is multiplied by 1/(1 - (R/4h)^2/(1 + (V sin(beta)/v_i)^2)) (Cheeseman & Bennett, ARC
            R&M 3021, 1955), v_i being the mean inflow; the other loads stay.

        Raises
        ------
        InputError
            For negative or non-finite values, unequal shapes and heights below R/2.
        """
        return self._loads(self._allowed(resolved(omega, speed, beta, **further)))

    def loads_at_velocity(
        self, omega: ArrayLike, velocity: ArrayLike, **further: Unpack[Further]
    ) -> results.Loads:
        """Loads for a velocity vector in the rotor frame.

        Parameters
        ----------
        omega : array_like, shape (...)
            Rotational speed [rad/s], >= 0.
        velocity : array_like, shape (..., 3)
            Velocity of the hub through the air, z along the thrust [m/s]; broadcast over the
            leading axes.
        **further
            ``height``, as in ``loads``.
        """
        points, _ = split_velocity(omega, velocity, **further)
        return self._loads(self._allowed(points))

    def wrench(
        self, omega: ArrayLike, velocity: ArrayLike, spin: str = "ccw", **further: Unpack[Further]
    ) -> results.Wrench:
        """Force and moment on the vehicle, as vectors in the rotor frame.

        The frame is right-handed with z along the thrust.

        Parameters
        ----------
        omega, velocity : array_like
            As in ``loads_at_velocity``.
        spin : str
            "ccw" or "cw", seen from above with the thrust up.
        **further
            ``height``, as in ``loads``.
        """
        sign = results.spin_sign(spin)
        points, direction = split_velocity(omega, velocity, **further)
        loads, _ = self._core.loads(self._allowed(points).rows, cores())
        return results.hub_wrench(loads, direction, sign)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names that ``gradients`` takes.

        The section law's constants; "drag_factor" [-] and "mount_area" [m^2], where the model says
        how the rotor is installed; "chord_scale" [-], a common relative change of the chord,
        "twist_offset" [rad], a common change of the twist, and "untwist" [rad], what the twist of
        the tip loses at a tip speed of 100 m/s; "omega" [rad/s], "v_axial" and "v_inplane" [m/s],
        "height" [m].
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
        """Loads and their derivatives by section constants, blade, mount and flow.

        They follow from the implicit function theorem at the inflow found.  The flow is given by
        the components of the velocity, as the derivative by beta does not exist at rest.

        Parameters
        ----------
        names : iterable of str
            P of ``parameters``.
        omega, v_axial, v_inplane : array_like, shape (...)
            Rotational speed [rad/s], >= 0, V cos(beta) and V sin(beta) [m/s], the latter >= 0; all
            three broadcast.
        **further
            ``height``, as in ``loads``.

        Returns
        -------
        LoadGradients
            ``loads`` (L, ...) in the order of ``propmap.loads.LOADS`` [N], [N m], NaN where no
            inflow was found, and ``slopes`` (L, P, ...) per unit of each parameter.

        Raises
        ------
        InputError
            For an unknown name, and for values that ``loads`` refuses.
        """
        return self.gradients_at(names, along_and_across(omega, v_axial, v_inplane, **further))

    def gradients_at(self, names: Iterable[str], points: FlowPoints) -> results.LoadGradients:
        """``gradients`` by ``names`` at ``points`` that are checked and of one shape."""
        wanted = list(names)
        unknown = [name for name in wanted if name not in self.parameters]
        if unknown:
            found = f"loads have no derivative by {unknown[0]!r}"
            raise InputError(found, f"give some of {', '.join(self.parameters)}")
        points = self._allowed(points)
        shape = points.omega.shape
        loads, slopes = self._core.gradients(wanted, points.rows, cores())
        return results.LoadGradients(
            loads.reshape(len(LOADS), *shape), slopes.reshape(len(LOADS), len(wanted), *shape)
        )

    def attached_thrust(
        self,
        omega: ArrayLike,
        v_axial: ArrayLike,
        v_inplane: ArrayLike,
        others: Sequence[Model] = (),
    ) -> tuple[Floats, Floats]:
        """Thrust of blades that are nowhere stalled, by small angles: a good guess, at once.

        Each annulus has its Glauert inflow (10) for the lift of small angles of attack, without
        drag, tip loss or stall.  Outside of descent it gives the inflow of ordinary flight within
        one per cent; in descent, where momentum theory has several solutions or none, it takes the
        largest.

        Parameters
        ----------
        omega, v_axial, v_inplane : array_like, shape (...)
            As for ``gradients``.
        others : sequence of P Model
            This one with slightly different section constants or untwist.

        Returns
        -------
        thrust : ndarray, shape (...)
            [N].
        more : ndarray, shape (P, ...)
            By how much those of ``others`` are more [N].

        Raises
        ------
        InputError
            For values that ``loads`` refuses.
        """
        points = along_and_across(omega, v_axial, v_inplane)
        shape, rows = points.omega.shape, points.rows
        thrust = self._core.attached_thrust(rows)
        more = [self.with_model(one)._core.attached_thrust(rows) - thrust for one in others]
        return thrust.reshape(shape), np.reshape(more, (len(others), *shape))

    def hover_inflow(self, omega: ArrayLike) -> Floats:
        """Static inflow v_i0 [m/s] of eq. (12) at ``omega`` [rad/s], from own static thrust."""
        w = rates_of("omega", omega)
        return self._core.hover_inflow(np.ascontiguousarray(w.ravel()), cores()).reshape(w.shape)

    def inflow(
        self,
        omega: float,
        speed: float,
        beta: float,
        *,
        radius: ArrayLike | None = None,
        azimuth: ArrayLike | None = None,
    ) -> results.Inflow:
        """The inflow v_i(y), the angle of attack and the loads along the blade.

        What a wing behind the rotor sees is v_i (the paper's footnote 3).

        Parameters
        ----------
        omega, speed, beta : float
            One operating point, as in ``loads``.
        radius : array_like, optional
            Stations inside the blade [m]; by default 60 from root to tip.
        azimuth : array_like, optional
            psi [rad]; by default every 5 degrees of a full turn.
        """
        rows = resolved(omega, speed, beta, one=True).rows
        root, tip = self.model.span
        y = broadcast(radius=np.linspace(root, tip, 60) if radius is None else radius)[0].ravel()
        turn = np.linspace(0.0, 2.0 * np.pi, 73)
        psi = broadcast(azimuth=turn if azimuth is None else azimuth)[0].ravel()
        if (y < root).any() or (y > tip).any():
            raise InputError(f"radius must lie between {root:g} and {tip:g} m")
        starts = range(0, max(y.size, 1), RADII_TOGETHER)
        parts = [y[k : k + RADII_TOGETHER] for k in starts]
        # The core takes one radius at least.
        fields = [self._core.disk_field(rows, list(part) or [tip], list(psi)) for part in parts]
        sums = {name: f"{name}_per_radius" for name in ("thrust", "drag", "torque")}
        joined = {name: np.concatenate([field[name] for field in fields]) for name in fields[0]}
        found = {sums.get(name, name): values[: y.size] for name, values in joined.items()}
        stalled, reverse = found["past_stall"] > 0.0, found["u_tangential"] < 0.0
        return results.Inflow(radius=y, azimuth=psi, stalled=stalled, reverse=reverse, **found)

    def explain(self, omega: float, speed: float, beta: float) -> results.SearchReport:
        """How the inflow equation (11) was solved at one operating point, station by station.

        The place to look where a status is "not_converged": ``print(rotor.explain(...))`` names
        the station and the residual that is left.

        Parameters
        ----------
        omega, speed, beta : float
            The operating point, as in ``loads``.

        Raises
        ------
        InputError
            For arrays, and for values that ``loads`` refuses.
        """
        found = self._core.solution(resolved(omega, speed, beta, one=True).rows)
        return results.SearchReport(
            radius=found["radius"],
            inflow=found["inflow"],
            residual=found["residual"],
            found=np.isfinite(found["inflow"]),
            edges=found["edge"],
            azimuths=found["azimuths"],
            tip=self.model.span[1],
        )

    def _allowed(self, points: FlowPoints) -> FlowPoints:
        """Refuse ``points`` so near the ground that nothing is known of it."""
        least = 0.5 * self.model.span[1]
        if points.height is not FAR and (points.height < least).any():
            raise InputError(
                f"height is {points.height.min():g} m, less than half the radius, {least:g} m",
                "give the height of the disk [m], or none: closer to the ground nothing is known",
            )
        return points

    def _loads(self, points: FlowPoints) -> results.Loads:
        shape, rows = points.omega.shape, points.rows
        loads, found = self._core.loads(rows, cores())
        if not self._has_deviations:
            return self._as_loads(loads, found, rows[0], shape)
        at = functools.partial(self._deviations, FlowPoints(*rows), loads, shape)
        return self._as_loads(loads, found, rows[0], shape, at)

    @functools.cached_property
    def _has_deviations(self) -> bool:
        return self.model.uncertainty is not None

    def _deviations(
        self, at: FlowPoints, loads: Floats, shape: tuple[int, ...]
    ) -> dict[str, results.LoadValues]:
        """``Loads.std_by_source`` of loads (L, N) at N points, as arrays of this ``shape``; NaN
        where loads or their derivatives were not found."""
        found = bands.deviations(
            self.model, at, loads, lambda names: self.gradients_at(names, at).slopes
        )
        values = {}
        for source, rows in found.items():
            lost = np.where(np.isnan(loads), np.nan, rows)
            by_name = dict(zip(LOADS, (row.reshape(shape) for row in lost), strict=True))
            values[source] = results.LoadValues(
                **by_name, power=by_name["torque"] * at.omega.reshape(shape)
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
        """Make ``Loads`` of loads (L, N) and the core's other results of each point (5, N)."""
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
