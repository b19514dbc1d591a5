// Stand-in for the part of gz-sim 8 that examples/gz uses: signatures as in its headers, one model, no physics.
#pragma once
#include <array>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#define gzerr std::cerr
#define GZ_ADD_PLUGIN(plugin, ...) using Plugin = plugin;

namespace gz::math {
class Vector3d {
  public:
    Vector3d() = default;
    Vector3d(double x, double y, double z) : v{x, y, z} {}
    double X() const { return v[0]; }
    double Y() const { return v[1]; }
    double Z() const { return v[2]; }
    Vector3d operator-(const Vector3d& o) const { return {v[0] - o.v[0], v[1] - o.v[1], v[2] - o.v[2]}; }
    Vector3d operator+(const Vector3d& o) const { return {v[0] + o.v[0], v[1] + o.v[1], v[2] + o.v[2]}; }

  private:
    std::array<double, 3> v{};
};

struct Quaterniond {
    std::array<std::array<double, 3>, 3> rows;  // a rotation matrix
    Vector3d RotateVector(const Vector3d& a) const {
        const auto row = [&](int k) { return rows[k][0] * a.X() + rows[k][1] * a.Y() + rows[k][2] * a.Z(); };
        return {row(0), row(1), row(2)};
    }
};

struct Pose3d {
    Quaterniond q;
    const Quaterniond& Rot() const { return q; }
};
}  // namespace gz::math

namespace sdf {
class Element {
  public:
    std::map<std::string, std::string> values;
    std::vector<std::shared_ptr<Element>> children;  // all named "rotor"
    const Element* parent = nullptr;

    template <class T> T Get(const std::string& key) const { return values.at(key); }
    template <class T> std::pair<T, bool> Get(const std::string& key, const T& otherwise) const {
        const auto found = values.find(key);
        return found == values.end() ? std::pair{otherwise, false} : std::pair{T(std::stod(found->second)), true};
    }
    std::shared_ptr<const Element> FindElement(const std::string& name) const { return next(name, 0); }
    std::shared_ptr<const Element> GetNextElement(const std::string& name) const {
        for (std::size_t k = 0; k < parent->children.size(); ++k)
            if (parent->children[k].get() == this) return parent->next(name, k + 1);
        return nullptr;
    }

  private:
    std::shared_ptr<const Element> next(const std::string& name, std::size_t k) const {
        return name == "rotor" && k < children.size() ? children[k] : nullptr;
    }
};
}  // namespace sdf

namespace gz::sim {
using Entity = std::uint64_t;
constexpr Entity kNullEntity = 0;
class EventManager {};

namespace components {
struct Wind {};
struct WorldLinearVelocity {
    math::Vector3d data;
    const math::Vector3d& Data() const { return data; }
};
}  // namespace components

struct State {  // of a link, or of a joint
    math::Pose3d pose;
    math::Vector3d velocity, force, torque;
    double turning = 0.0;
    bool observed = false;
};

class EntityComponentManager {
  public:
    std::map<std::string, Entity> names;
    std::map<Entity, State> states;
    std::optional<components::WorldLinearVelocity> wind;

    Entity EntityByComponents(const components::Wind&) const { return wind ? 1000 : kNullEntity; }
    template <class T> const T* Component(Entity) const { return wind ? &*wind : nullptr; }
    Entity named(const std::string& name) const { return names.count(name) ? names.at(name) : kNullEntity; }
};

class Model {
  public:
    explicit Model(Entity = kNullEntity) {}
    Entity LinkByName(const EntityComponentManager& ecm, const std::string& name) const { return ecm.named(name); }
    Entity JointByName(const EntityComponentManager& ecm, const std::string& name) const { return ecm.named(name); }
};

class Link {
  public:
    explicit Link(Entity entity = kNullEntity) : id(entity) {}
    bool Valid(const EntityComponentManager& ecm) const { return ecm.states.count(id) > 0; }
    void EnableVelocityChecks(EntityComponentManager& ecm, bool on = true) const { ecm.states.at(id).observed = on; }
    std::optional<math::Pose3d> WorldPose(const EntityComponentManager& ecm) const { return ecm.states.at(id).pose; }
    std::optional<math::Vector3d> WorldLinearVelocity(const EntityComponentManager& ecm) const {
        const State& own = ecm.states.at(id);
        return own.observed ? std::optional(own.velocity) : std::nullopt;
    }
    void AddWorldWrench(EntityComponentManager& ecm, const math::Vector3d& force, const math::Vector3d& torque) const {
        State& own = ecm.states.at(id);
        own.force = own.force + force, own.torque = own.torque + torque;
    }

  private:
    Entity id;
};

class Joint {
  public:
    explicit Joint(Entity entity = kNullEntity) : id(entity) {}
    bool Valid(const EntityComponentManager& ecm) const { return ecm.states.count(id) > 0; }
    void EnableVelocityCheck(EntityComponentManager& ecm, bool on = true) const { ecm.states.at(id).observed = on; }
    std::optional<std::vector<double>> Velocity(const EntityComponentManager& ecm) const {
        const State& own = ecm.states.at(id);
        return own.observed ? std::optional(std::vector{own.turning}) : std::nullopt;
    }

  private:
    Entity id;
};

struct UpdateInfo {
    std::chrono::steady_clock::duration dt{};
    bool paused = false;
};

class System {
  public:
    virtual ~System() = default;
};
class ISystemConfigure {
  public:
    virtual void Configure(const Entity&, const std::shared_ptr<const sdf::Element>&, EntityComponentManager&,
                           EventManager&) = 0;
};
class ISystemPreUpdate {
  public:
    virtual void PreUpdate(const UpdateInfo&, EntityComponentManager&) = 0;
};
}  // namespace gz::sim
