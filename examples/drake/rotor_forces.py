"""A Drake system that puts the force and moment of the air on a body of a MultibodyPlant.

Run as a script, it prints how a quadrotor at 10 m/s slows down whose rotors turn as in hover.
"""

from pathlib import Path

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce, SpatialVelocity
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

import propmap


class RotorForces(LeafSystem):
    """Rotors that follow their commands with a delay, and what the air does to their vehicle.

    Inputs are the plant's ``body_poses`` and ``body_spatial_velocities`` and the ``command``, rotor
    speeds (k,) [rad/s]; outputs are ``spatial_forces`` for the plant and the rotors' ``omega``.
    The body's axes are x forward, y left, z up, its origin is the vehicle's centre of mass.
    """

    def __init__(self, forces, body, time_constant):
        super().__init__()
        self.forces, self.body, self.time_constant = forces, body, time_constant
        k = len(forces.vehicle.mounts)
        self.poses = self.DeclareAbstractInputPort("body_poses", Value[list[RigidTransform]]())
        self.motions = self.DeclareAbstractInputPort(
            "body_spatial_velocities", Value[list[SpatialVelocity]]()
        )
        self.command = self.DeclareVectorInputPort("command", k)
        omega = self.DeclareContinuousState(k)
        self.DeclareStateOutputPort("omega", omega)
        self.DeclareAbstractOutputPort(
            "spatial_forces",
            Value[list[ExternallyAppliedSpatialForce]],
            self.spatial_forces,
        )

    def DoCalcTimeDerivatives(self, context, derivatives):  # noqa: N802, a name of Drake's
        """Rotors of first order."""
        omega = context.get_continuous_state_vector().CopyToVector()
        rate = (self.command.Eval(context) - omega) / self.time_constant
        derivatives.get_mutable_vector().SetFromVector(rate)

    def spatial_forces(self, context, output):
        """Force and moment at the centre of mass, in the world's axes."""
        turned = self.poses.Eval(context)[self.body].rotation()
        motion = self.motions.Eval(context)[self.body]
        found = self.forces.wrench(
            context.get_continuous_state_vector().CopyToVector(),
            turned.inverse() @ motion.translational(),
            turned.inverse() @ motion.rotational(),
        )
        if not np.isfinite(found.force).all():
            raise ValueError(f"the loads are not known there ({found.status})")
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = self.body
        applied.p_BoBq_B = np.zeros(3)
        applied.F_Bq_W = SpatialForce(tau=turned @ found.moment, f=turned @ found.force)
        output.set_value([applied])


def flying(forces, time_constant, gravity=9.80665):
    """Diagram of a vehicle as one free body, with its ``plant`` and its ``rotors``.

    Its input is the rotors' command.
    """
    vehicle, builder = forces.vehicle, DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(time_step=0.0))
    plant.set_name("plant")
    turning = UnitInertia(*(np.array(vehicle.inertia) / vehicle.mass))
    body = plant.AddRigidBody("vehicle", SpatialInertia(vehicle.mass, np.zeros(3), turning))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -gravity])
    plant.Finalize()
    rotors = builder.AddSystem(RotorForces(forces, body.index(), time_constant))
    rotors.set_name("rotors")
    for name in ("body_poses", "body_spatial_velocities"):
        builder.Connect(plant.GetOutputPort(name), rotors.GetInputPort(name))
    builder.Connect(
        rotors.GetOutputPort("spatial_forces"), plant.get_applied_spatial_force_input_port()
    )
    builder.ExportInput(rotors.command, "command")
    return builder.Build()


def main():
    """Print half a second of flight that begins at 10 m/s."""
    vehicle = propmap.read_vehicle(Path(__file__).parent.parent / "quadrotor.toml").vehicle
    rotor = propmap.Rotor(propmap.known_model("APC 8x6E"))
    diagram = flying(propmap.VehicleForces(vehicle, rotor), time_constant=0.03)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    plant, rotors = (diagram.GetSubsystemByName(name) for name in ("plant", "rotors"))
    speeds = np.linspace(500.0, 900.0, 41)  # rad/s
    thrust = rotor.loads(speeds, 0.0, 0.0).thrust
    hover = np.full(4, np.interp(vehicle.mass * 9.80665 / 4.0, thrust, speeds))
    diagram.GetInputPort("command").FixValue(context, hover)
    rotors.GetMyMutableContextFromRoot(context).SetContinuousState(hover)
    there = plant.GetMyMutableContextFromRoot(context)
    plant.SetVelocities(there, [0.0, 0.0, 0.0, 10.0, 0.0, 0.0])
    for time in np.arange(1, 6) * 0.1:
        simulator.AdvanceTo(time)
        velocity, rates = plant.GetVelocities(there)[3:], plant.GetVelocities(there)[:3]
        print(f"{time:.1f} s: velocity {velocity.round(3)} m/s, turning {rates.round(3)} rad/s")


if __name__ == "__main__":
    main()
