"""A Drake system that applies aerodynamic force and moment to a body of a MultibodyPlant.

As a script, it prints the deceleration of a quadrotor from 10 m/s with the rotor speeds of hover.
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
    """Rotors that lag behind their commands, and the aerodynamic forces on the vehicle.

    Inputs are the plant's ``body_poses`` and ``body_spatial_velocities``, and the commanded rotor
    speeds ``command`` (k,) [rad/s].  Outputs are ``spatial_forces`` for the plant and the actual
    rotor speeds ``omega``.  The body's axes are x forward, y left, z up, and its origin is the
    vehicle's center of mass.
    """

    def __init__(self, forces, body, time_constant):
        super().__init__()
        if not time_constant > 0.0:
            raise ValueError(f"time_constant is {time_constant} s: give a positive number")
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

    def DoCalcTimeDerivatives(self, context, derivatives):  # noqa: N802, a name from Drake
        """Compute the rate of change of the rotor speeds, a first-order lag."""
        omega = context.get_continuous_state_vector().CopyToVector()
        rate = (self.command.Eval(context) - omega) / self.time_constant
        derivatives.get_mutable_vector().SetFromVector(rate)

    def spatial_forces(self, context, output):
        """Compute force and moment at the center of mass, in the world frame."""
        turned = self.poses.Eval(context)[self.body].rotation()
        motion = self.motions.Eval(context)[self.body]
        found = self.forces.wrench(
            context.get_continuous_state_vector().CopyToVector(),
            turned.inverse() @ motion.translational(),
            turned.inverse() @ motion.rotational(),
        )
        if not np.isfinite(found.force).all():
            raise ValueError(f"no loads at this operating point ({found.status})")
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = self.body
        applied.p_BoBq_B = np.zeros(3)
        applied.F_Bq_W = SpatialForce(tau=turned @ found.moment, f=turned @ found.force)
        output.set_value([applied])


def flying(forces, time_constant, gravity=9.80665):
    """Return a diagram of a vehicle as one free body, with the systems ``plant`` and ``rotors``.

    The input of the diagram is the rotor command.
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
    """Print half a second of flight from 10 m/s."""
    vehicle = propmap.read_vehicle(Path(__file__).parent.parent / "quadrotor.toml").vehicle
    rotor = propmap.Rotor(propmap.catalogue_model("APC 8x6E"))
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
