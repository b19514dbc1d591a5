"""Loads of a model at any operating point."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from propmap.bands import FlowPoints, load_deviations
from propmap.compilation import NO_THRIFT, Thrift
from propmap.engine.accuracy import FOR_DEVIATIONS
from propmap.engine.accuracy import accuracy as accuracy_setting
from propmap.engine.attached_thrust import attached_thrust
from propmap.engine.differences import load_differences
from propmap.engine.evaluation import Prepared, evaluate, prepare, tail_share
from propmap.engine.gradients import load_gradients
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.errors import InputError
from propmap.loads import FLOW, GEOMETRY, LOADS, MOUNT_AREA
from propmap.model.corrections import MountDrag
from propmap.model.model import Model
from propmap.operating_points import (
    along_and_across,
    broadcast,
    rates,
    resolved,
    reverse_flow_share,
    split_velocity,
)
from propmap.results import (
    Deviations,
    Inflow,
    LoadGradients,
    Loads,
    LoadValues,
    SearchReport,
    Wrench,
    hub_wrench,
    spin_sign,
    statuses,
)
from propmap.solve.rotor_loads import RotorLoads
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.physics.rotor import RotorArrays

PRECISIONS = ("float64", "float32")

PREPARED = ("arrays", "_prepared", "_differentiable")
"""Properties that a process computes for itself."""

MOST_STATIONS = 40
"""Stations that no blade of the catalogue has more of."""


class Rotor:
    """Loads of a model at any operating point: the face of the package.

    Parameters
    ----------
    model : Model
        Propeller, section law, air and corrections.
    accuracy : str
        "standard" (0.1 % of static thrust and torque) or "fine" (0.01 %, slower).
    compiled : bool
        Whether the first call waits some seconds for the compiler, so that all others take a
        hundredth of the time.  For a few points in a short process it is not worth it: NumPy then
        gives the same loads, but for rounding, in some hundredths of a second each.
    precision : str
        "float64"; or "float32" for large batches of loads in less time, with errors below 0.3 % of
        static thrust and torque where "standard" promises 0.1 %; compiled only.

    Raises
    ------
    InputError
        For arguments of another kind.
    """

    def __init__(
        self,
        model: Model,
        *,
        accuracy: str = "standard",
        compiled: bool = True,
        precision: str = "float64",
    ) -> None:
        if not isinstance(model, Model):
            raise InputError(
                f"model is {model!r}", "give a Model, from propmap.Model(propeller, airfoil)"
            )
        if precision not in PRECISIONS:
            raise InputError(
                f"precision is {precision!r}: it must be one of {', '.join(PRECISIONS)}"
            )
        if precision != PRECISIONS[0] and not (compiled and accuracy == "standard"):
            raise InputError(
                f"{precision} with accuracy {accuracy!r} and compiled={compiled}",
                "it serves compiled programs of accuracy 'standard' alone",
            )
        self.model, self.accuracy = model, accuracy
        self.compiled, self.precision = compiled, precision
        self._setting, self._uniform = accuracy_setting(accuracy), False
        self._stations = 0

    def __repr__(self) -> str:
        m = self.model
        return (
            f"Rotor({m.propeller.name}, {m.law_title}, rho={m.air.density} kg/m^3, "
            f"accuracy={self.accuracy})"
        )

    def __getstate__(self) -> dict[str, Any]:
        """What another process makes the rotor of; what is prepared for this one stays here."""
        return {key: value for key, value in vars(self).items() if key not in PREPARED}

    def for_all_sizes(self) -> Rotor:
        """This rotor, with one set of programs for batches of any size.

        A small batch takes as long as one of some hundred points, but less is compiled in all.
        """
        rotor = self.with_model(self.model)
        rotor._uniform = True
        return rotor

    def for_all_blades(self) -> Rotor:
        """This rotor, with one set of programs for any blade of up to ``MOST_STATIONS`` stations.

        The loads are the same; it is for a single blade that less is compiled without this.
        """
        return self.for_all_sizes()._with_stations(MOST_STATIONS)

    def _with_stations(self, count: int) -> Rotor:
        """This rotor, with programs that serve any blade of up to ``count`` stations."""
        rotor = self.with_model(self.model)
        rotor._stations = count
        return rotor

    def with_model(self, model: Model) -> Rotor:
        """A rotor of another ``model`` with the settings of this one."""
        rotor = Rotor(
            model,
            accuracy=self.accuracy,
            compiled=self.compiled,
            precision=self.precision,
        )
        rotor._uniform, rotor._stations = self._uniform, self._stations
        return rotor

    def loads(self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> Loads:
        """Loads at operating points.

        Parameters
        ----------
        omega, speed : array_like
            Rotational speed [rad/s] and V [m/s], >= 0; all three broadcast.
        beta : array_like
            Angle of the velocity to the axis [rad]: 0 axial climb, pi/2 edgewise flight, pi axial
            descent; beta and 2 pi - beta are mirror images with the same loads.

        Raises
        ------
        InputError
            For negative or non-finite values and unequal shapes.
        """
        return self._loads(*resolved(omega, speed, beta))

    def loads_at_velocity(self, omega: ArrayLike, velocity: ArrayLike) -> Loads:
        """Loads for a velocity vector in the rotor frame.

        Parameters
        ----------
        omega : array_like, shape (...)
            Rotational speed [rad/s], >= 0.
        velocity : array_like, shape (..., 3)
            Of the hub through the air, z along the thrust [m/s]; broadcast over the leading axes.
        """
        w, along, across, _ = split_velocity(omega, velocity)
        return self._loads(w, along, across)

    def wrench(self, omega: ArrayLike, velocity: ArrayLike, spin: str = "ccw") -> Wrench:
        """Force and moment on the vehicle, as vectors in the rotor frame.

        The frame is right-handed with z along the thrust.

        Parameters
        ----------
        omega, velocity : array_like
            As in ``loads_at_velocity``.
        spin : str
            "ccw" or "cw", seen from above with the thrust up.
        """
        sign = spin_sign(spin)
        w, along, across, direction = split_velocity(omega, velocity)
        return hub_wrench(self._loads(w, along, across), direction, sign)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names that ``gradients`` takes.

        The section law's constants; "mount_area" [m^2], where something is mounted in the
        slipstream; "chord_scale" [-], a common relative change of the chord, "twist_offset" [rad],
        a common change of the twist, and "untwist" [rad], what the twist of the tip loses at a tip
        speed of 100 m/s; "omega" [rad/s], "v_axial" and "v_inplane" [m/s].
        """
        law = getattr(self.model.airfoil, "parameters", None) or self.arrays.law.parameters
        mounted = () if self.model.correction_of(MountDrag) is None else (MOUNT_AREA,)
        return (*law, *mounted, *GEOMETRY, *FLOW)

    def gradients(
        self,
        names: Iterable[str],
        omega: ArrayLike,
        v_axial: ArrayLike,
        v_inplane: ArrayLike,
    ) -> LoadGradients:
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
        return self._gradients(names, omega, v_axial, v_inplane, NO_THRIFT)

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
            By how much those of ``others`` are more, to first order in that of their lift [N].

        Raises
        ------
        InputError
            For values that ``loads`` refuses.
        """
        flow = along_and_across(omega, v_axial, v_inplane)
        shape, flat = flow[0].shape, [a.ravel() for a in flow]
        there = [rotor_arrays(one) for one in others]
        thrust, more = attached_thrust(self.arrays, flat[0], flat[1], flat[2], there)
        return thrust.reshape(shape), more.reshape(-1, *shape)

    def hover_inflow(self, omega: ArrayLike) -> Floats:
        """Static inflow v_i0 [m/s] of eq. (12) at ``omega`` [rad/s], from own static thrust."""
        from propmap.engine.evaluation import static_inflow

        w = rates(omega)
        return static_inflow(self._prepared, self._setting, w.ravel()).reshape(w.shape)

    def inflow(
        self,
        omega: float,
        speed: float,
        beta: float,
        *,
        radius: ArrayLike | None = None,
        azimuth: ArrayLike | None = None,
    ) -> Inflow:
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
        from propmap.engine.disk_field import look_at_disk

        w, along, across = resolved(omega, speed, beta, one=True)
        root, tip = self.model.span
        y = np.linspace(root, tip, 60) if radius is None else np.ravel(radius)
        psi = np.linspace(0.0, 2.0 * np.pi, 73) if azimuth is None else np.ravel(azimuth)
        y, psi = broadcast(radius=y)[0], broadcast(azimuth=psi)[0]
        if (y < root).any() or (y > tip).any():
            raise InputError(f"radius must lie between {root:g} and {tip:g} m")
        still = self.hover_inflow(w) if along < 0.0 else np.zeros(())
        flow = (float(w), float(along), float(across), float(still))
        return look_at_disk(self.arrays, flow, y, psi, compiled=self.compiled)

    def explain(
        self, omega: float, speed: float, beta: float, *, max_steps: int | None = None
    ) -> SearchReport:
        """How the inflow equation (11) was solved at one operating point, station by station.

        The place to look where a status is "not_converged": ``print(rotor.explain(...))`` names
        the station, the steps taken and the residual that is left.

        Parameters
        ----------
        omega, speed, beta : float
            The operating point, as in ``loads``.
        max_steps : int, optional
            Steps after which the search is given up; by default as in ``loads``.

        Raises
        ------
        InputError
            For arrays, and for values that ``loads`` refuses.
        """
        from propmap.engine.programs import Flow
        from propmap.engine.search_report import search_report
        from propmap.solve.root import MAX_STEPS

        w, along, across = resolved(omega, speed, beta, one=True)
        still = self.hover_inflow(w)[None] if along < 0.0 else None
        flow = Flow(w[None], along[None], across[None], still)
        return search_report(self._prepared, self._setting, flow, max_steps or MAX_STEPS)

    @functools.cached_property
    def arrays(self) -> RotorArrays:
        """The model as arrays of NumPy float64, for ``propmap.solve.rotor_loads``."""
        from propmap.arrays.namespace import by_numpy
        from propmap.physics.geometry import with_stations

        found = rotor_arrays(self.model)
        with by_numpy():
            return found._replace(blade=with_stations(found.blade, self._stations))

    @functools.cached_property
    def _prepared(self) -> Prepared:
        double = self.precision == PRECISIONS[0]
        return prepare(self.arrays, compiled=self.compiled, uniform=self._uniform, double=double)

    @functools.cached_property
    def _differentiable(self) -> Prepared:
        """For derivatives, which only programs in float64 give."""
        if self.compiled and self.precision == PRECISIONS[0]:
            return self._prepared
        return prepare(self.arrays, uniform=self._uniform)

    @property
    def _programs(self) -> object:
        """What compiled programs depend on, beside the sizes that are the same for all."""
        import jax

        return jax.tree.structure(self.arrays)

    def _gradients(
        self,
        names: Iterable[str],
        omega: ArrayLike,
        v_axial: ArrayLike,
        v_inplane: ArrayLike,
        thrift: Thrift,
    ) -> LoadGradients:
        """``gradients`` in a way that saves compiling."""
        wanted = tuple(names)
        unknown = [name for name in wanted if name not in self.parameters]
        if unknown:
            raise InputError(
                f"loads have no derivative by {unknown[0]!r}",
                f"choose from {', '.join(self.parameters)}",
            )
        flow = along_and_across(omega, v_axial, v_inplane)
        shape, flat = flow[0].shape, [a.ravel() for a in flow]
        setting = FOR_DEVIATIONS if thrift.coarse else self._setting
        if flat[0].size <= thrift.few:
            found = load_differences(self._prepared, setting, wanted, thrift.scales, *flat)
        else:
            found = load_gradients(self._differentiable, setting, wanted, *flat, alike=thrift.alike)
        return LoadGradients(
            found.loads.reshape(-1, *shape), found.slopes.reshape(len(LOADS), len(wanted), *shape)
        )

    def _loads(self, omega: Floats, v_axial: Floats, v_inplane: Floats) -> Loads:
        shape = omega.shape
        flow = (omega.ravel(), v_axial.ravel(), v_inplane.ravel())
        flat = evaluate(self._prepared, self._setting, *flow)
        found: Any = RotorLoads.of_rows(row.reshape(shape) for row in flat.rows)
        # Derivatives are compiled in float64 alone.
        known = self.model.uncertainty is not None and self.precision == PRECISIONS[0]
        at = functools.partial(self._deviations, FlowPoints(*flow), np.stack(flat.loads), shape)
        return self._told(found, omega, v_axial, v_inplane, at if known else None)

    def _deviations(
        self, at: FlowPoints, loads: Floats, shape: tuple[int, ...]
    ) -> dict[str, LoadValues]:
        """``Loads.std_by_source`` of loads (L, N) at N points, as arrays of this ``shape``."""
        found = load_deviations(self, at, loads)
        values = {}
        for source, rows in found.items():
            lost = np.where(np.isnan(loads), np.nan, rows)
            by_name = dict(zip(LOADS, (row.reshape(shape) for row in lost), strict=True))
            values[source] = LoadValues(
                **by_name, power=by_name["torque"] * at.omega.reshape(shape)
            )
        return values

    def _told(
        self,
        found: Any,
        omega: Floats,
        v_axial: Floats,
        v_inplane: Floats,
        deviations: Deviations | None = None,
    ) -> Loads:
        """The ``RotorLoads`` that were ``found``, with a status."""
        tails = tail_share(self._prepared, omega, v_axial, v_inplane, found)
        coarse = tails > self._setting.finer[-1][1]
        reverse = reverse_flow_share(omega, v_inplane, *self.model.span)
        return Loads(
            **found.loads._asdict(),
            power=found.loads.torque * omega,
            status=statuses(found, v_axial, coarse),
            roots=found.roots,
            reverse_flow=reverse,
            vortex_ring=found.ring,
            mean_inflow=found.mean_inflow,
            deviations=deviations,
        )
