// Rotors on a frame: the flow at their hubs, their force and moment on the vehicle, and the forces of body and wing.
//
// Vectors are in the frame of the vehicle (x forward, y left, z up), unless stated otherwise.
#pragma once

#include "load_table.hpp"

namespace propmap {

using Vector3 = std::array<double, 3>;

inline double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vector3 cross(const Vector3& a, const Vector3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vector3 add(const Vector3& a, double times, const Vector3& b) {  // a + times b
    return {a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]};
}

struct Wrench {
    Vector3 force{}, moment{};  // [N], [N m]
};

// The flow at a hub that moves through the air.
struct HubFlow {
    double axial = 0.0, inplane = 0.0;  // V cos(beta), V sin(beta) >= 0 [m/s]
    Vector3 ahead{};                    // unit vector along the in-plane velocity; zero without in-plane velocity
};

// `axis` is the unit vector along the thrust; `velocity` is that of the hub through the air [m/s].
inline HubFlow hub_flow(const Vector3& axis, const Vector3& velocity) {
    HubFlow flow{dot(velocity, axis), 0.0, {}};
    const Vector3 across = add(velocity, -flow.axial, axis);
    const double size = std::sqrt(dot(across, across));
    if (size < 1e-12) return flow;
    flow.inplane = size, flow.ahead = {across[0] / size, across[1] / size, across[2] / size};
    return flow;
}

// Force and moment on the vehicle, about the hub.  `spin` is 1 for counter-clockwise as seen from above, -1 for
// clockwise.  If the spin is 1, the advancing side is on the right; lift there rolls the vehicle about -`ahead`.
inline Wrench hub_wrench(const Vector3& axis, double spin, const Vector3& ahead, const Loads<double>& of) {
    const Vector3 left = cross(axis, ahead);
    Wrench w;
    for (int k = 0; k < 3; ++k) {
        w.force[k] = of.thrust * axis[k] - of.drag * ahead[k] + spin * of.side_force * left[k];
        w.moment[k] = -spin * (of.torque * axis[k] + of.roll_moment * ahead[k]) - of.pitch_moment * left[k];
    }
    return w;
}

// Body and wing, section III.A and footnote 4 of the paper.  Areas are in m^2; see `Body` and `Wing` in Python.
struct Airframe {
    double density;  // of the air [kg/m^3]
    Vector3 drag_area{};
    double lift_area = 0.0, plate_area = 0.0, download_area[2]{};
    double wing_area = 0.0, incidence = 0.0, span = 0.0;  // for span 0, induced drag is omitted
    BlendedLaw<double> wing{};                            // eq. (3)

    // Lift acts across the flow, in the plane of symmetry: (-v_z, 0, v_x) is its direction times V.
    Vector3 body_force(const Vector3& v) const {  // at velocity v through the air [N]
        const double angle = std::atan2(-v[2], v[0]), pressure = 0.5 * density;
        const double lift = pressure * lift_area * std::sin(angle) * std::cos(angle) * std::hypot(v[0], v[2]);
        const double down = pressure * (download_area[0] * v[0] * v[0] + download_area[1] * v[1] * v[1]);
        const double plate = pressure * plate_area * std::sqrt(dot(v, v)) * v[2];
        Vector3 force{-lift * v[2], 0.0, lift * v[0] - down - plate};
        for (int k = 0; k < 3; ++k) force[k] -= pressure * drag_area[k] * std::fabs(v[k]) * v[k];
        return force;
    }

    Vector3 wing_force(const Vector3& v) const {  // at velocity v through the air [N]
        if (wing_area == 0.0) return {};
        const Lanes angle = broadcast(std::remainder(std::atan2(-v[2], v[0]) + incidence, 2.0 * pi));
        const auto alpha = angle_from(angle);
        const Lanes one = broadcast(1.0);
        const double lift = wing_area * wing.coefficients(SectionFlow{alpha, alpha, one, one, one, one, one}).lift[0];
        // Prandtl's induced drag D = L^2/(pi q b^2), of an elliptic distribution of lift.
        const double induced = span > 0.0 ? lift * lift / (pi * span * span) : 0.0;
        const double scale = 0.5 * density * std::hypot(v[0], v[2]);
        return {scale * (-lift * v[2] - induced * v[0]), 0.0, scale * (lift * v[0] - induced * v[2])};
    }
};

struct Mount {
    Vector3 position, axis;  // hub relative to the center of mass [m]; unit vector along the thrust
    double spin;             // 1 for counter-clockwise, -1 for clockwise
};

// Add the force of a rotor, and its moment about the center of mass; `ahead` is the direction of the in-plane velocity.
inline void add_rotor(Wrench& all, const Mount& on, const Vector3& ahead, const Loads<double>& of) {
    const Wrench one = hub_wrench(on.axis, on.spin, ahead, of);
    all.force = add(all.force, 1.0, one.force);
    all.moment = add(add(all.moment, 1.0, one.moment), 1.0, cross(on.position, one.force));
}

// Moment of the spinning rotors on the vehicle: their angular momentum turns with the vehicle and changes with their
// speed.  A rotor has the moment of inertia `heavy` [kg m^2], the speed `omega` [rad/s] and its rate `change` [rad/s^2].
inline Vector3 spin_moment(const std::vector<Mount>& mounts, double heavy, const double* omega, const double* change,
                           const Vector3& rates) {
    Vector3 momentum{}, by_speed{};
    for (std::size_t k = 0; k < mounts.size(); ++k) {
        momentum = add(momentum, heavy * mounts[k].spin * omega[k], mounts[k].axis);
        by_speed = add(by_speed, heavy * mounts[k].spin * change[k], mounts[k].axis);
    }
    return add(add({}, -1.0, cross(rates, momentum)), -1.0, by_speed);
}

// A unit quaternion (w, x, y, z).
struct Attitude {
    double w;
    Vector3 v;

    Vector3 turned(const Vector3& x, double way) const {  // from the vehicle to the world for way = 1, and back for -1
        const Vector3 twice = add({}, 2.0 * way, cross(v, x));
        return add(add(x, w, twice), way, cross(v, twice));
    }
};

}  // namespace propmap
