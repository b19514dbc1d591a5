// A system of gz-sim that applies all six loads of each rotor, with dynamic inflow, to a model.
#include "apc_8x6e.hpp"  // propmap export apc-8x6e --to cpp -o .

#include <propmap/dynamic_inflow.hpp>
#include <propmap/vehicle.hpp>

#include <gz/common/Console.hh>
#include <gz/math/Pose3.hh>
#include <gz/math/Vector3.hh>
#include <gz/plugin/Register.hh>
#include <gz/sim/EntityComponentManager.hh>
#include <gz/sim/Joint.hh>
#include <gz/sim/Link.hh>
#include <gz/sim/Model.hh>
#include <gz/sim/System.hh>
#include <gz/sim/components/LinearVelocity.hh>
#include <gz/sim/components/Wind.hh>
#include <sdf/Element.hh>

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace propmap_gz {
namespace sim = gz::sim;
using gz::math::Vector3d;

inline propmap::Vector3 array_of(const Vector3d& v) { return {v.X(), v.Y(), v.Z()}; }
inline Vector3d vector_of(const propmap::Vector3& v) { return {v[0], v[1], v[2]}; }

struct Rotor {
    std::string name;
    sim::Joint joint;
    sim::Link link;
    double spin = 1.0;                 // 1 for ccw, -1 for cw
    std::vector<double> inflow{};      // state of the inflow, with gradients along x and y of the body [m/s]
};

class Rotors : public sim::System, public sim::ISystemConfigure, public sim::ISystemPreUpdate {
  public:
    void Configure(const sim::Entity& entity, const std::shared_ptr<const sdf::Element>& sdf,
                   sim::EntityComponentManager& ecm, sim::EventManager&) override {
        const sim::Model model(entity);
        body_ = sim::Link(model.LinkByName(ecm, sdf->Get<std::string>("bodyLink")));
        slowdown_ = sdf->Get<double>("rotorVelocitySlowdownSim", 10.0).first;
        bool found = body_.Valid(ecm);
        for (auto each = sdf->FindElement("rotor"); each; each = each->GetNextElement("rotor")) {
            const auto name = each->Get<std::string>("linkName"), turning = each->Get<std::string>("turningDirection");
            Rotor rotor{name, sim::Joint(model.JointByName(ecm, each->Get<std::string>("jointName"))),
                        sim::Link(model.LinkByName(ecm, name)), turning == "cw" ? -1.0 : 1.0};
            found = found && rotor.joint.Valid(ecm) && rotor.link.Valid(ecm) && (turning == "cw" || turning == "ccw");
            rotors_.push_back(std::move(rotor));
        }
        if (!found || rotors_.empty()) {
            gzerr << "propmap_rotors: check bodyLink, and jointName, linkName and turningDirection of each rotor.\n";
            rotors_.clear();
        }
        for (auto& rotor : rotors_) {
            rotor.inflow.assign(dynamics_.size(), 0.0);
            rotor.joint.EnableVelocityCheck(ecm);
            rotor.link.EnableVelocityChecks(ecm);
        }
    }

    void PreUpdate(const sim::UpdateInfo& info, sim::EntityComponentManager& ecm) override {
        const double step = std::chrono::duration<double>(info.dt).count();
        if (info.paused || step <= 0.0) return;
        const auto* wind = ecm.Component<sim::components::WorldLinearVelocity>(
            ecm.EntityByComponents(sim::components::Wind()));
        for (auto& rotor : rotors_) {
            const auto turning = rotor.joint.Velocity(ecm);
            const auto velocity = rotor.link.WorldLinearVelocity(ecm);
            if (!turning || turning->empty() || !velocity) continue;  // in the first step
            apply(rotor, std::fabs((*turning)[0]) * slowdown_, wind ? *velocity - wind->Data() : *velocity, step, ecm);
        }
    }

  private:
    // `through` is the velocity of the hub through the air in the frame of the world [m/s].
    void apply(Rotor& rotor, double omega, const Vector3d& through, double step, sim::EntityComponentManager& ecm) {
        using propmap::add, propmap::cross, propmap::dot, propmap::Vector3;
        // The state needs directions that do not turn with the rotor: those of the body.
        const auto body = body_.WorldPose(ecm)->Rot();
        const Vector3 axis = array_of(rotor.link.WorldPose(ecm)->Rot().RotateVector({0.0, 0.0, 1.0}));
        Vector3 x = array_of(body.RotateVector({1.0, 0.0, 0.0}));
        if (std::fabs(dot(x, axis)) > 0.9) x = array_of(body.RotateVector({0.0, 0.0, -1.0}));
        x = add(x, -dot(x, axis), axis);
        const double length = std::sqrt(dot(x, x));
        x = {x[0] / length, x[1] / length, x[2] / length};

        auto flow = propmap::hub_flow(axis, array_of(through));
        if (flow.inplane == 0.0) flow.ahead = x;
        const propmap::Heading heading{dot(flow.ahead, x), dot(flow.ahead, cross(axis, x)), rotor.spin};
        std::vector<double> later(rotor.inflow.size());
        const auto& now = dynamics_.move({omega, flow.axial, flow.inplane}, heading, rotor.inflow.data(), step, nullptr, later.data());
        const auto wrench = propmap::hub_wrench(axis, rotor.spin, flow.ahead, now.result.loads);
        if (!std::isfinite(dot(wrench.force, wrench.moment))) {
            gzerr << "propmap_rotors: no loads of " << rotor.name << " at " << omega << " rad/s.\n";
            rotor.inflow.assign(later.size(), 0.0);
            return;
        }
        rotor.inflow = later;
        rotor.link.AddWorldWrench(ecm, vector_of(wrench.force), Vector3d(0.0, 0.0, 0.0));
        // The joint does not transmit moments about its axis.
        body_.AddWorldWrench(ecm, Vector3d(0.0, 0.0, 0.0), vector_of(wrench.moment));
    }

    decltype(make_apc_8x6e()) solver_ = make_apc_8x6e();
    decltype(propmap::DynamicInflow(make_apc_8x6e())) dynamics_{solver_};
    sim::Link body_;
    double slowdown_ = 10.0;
    std::vector<Rotor> rotors_;
};
}  // namespace propmap_gz

GZ_ADD_PLUGIN(propmap_gz::Rotors, gz::sim::System, propmap_gz::Rotors::ISystemConfigure,
              propmap_gz::Rotors::ISystemPreUpdate)
