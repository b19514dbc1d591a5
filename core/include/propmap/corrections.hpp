// A rotor in air: blade, section law, and the corrections to the paper's model that are switched on.
#pragma once

#include "blade.hpp"

namespace propmap {

// Variation of the inflow around the disk; see inflow.hpp.
enum class InflowShape { uniform, pitt_peters, pitt_peters_gradient, coleman, white_blake, drees };

// Blade, air and corrections, with respect to which loads are not differentiated.
struct RotorSettings {
    const BladeShape* blade = nullptr;
    double density = 1.225;        // rho [kg/m^3]
    double viscosity = 1.983e-5;   // mu [Pa s]
    bool tip_loss = false;         // Prandtl's loss at the tip
    double hub_radius = 0.0;       // radius for Prandtl's loss at the hub [m]; 0 for none
    InflowShape inflow_shape = InflowShape::uniform;  // see inflow.hpp
    bool installed = false;        // on a mount, which changes the rotor drag
    double mount_wake = 1.0;       // inflow at the mount divided by the inflow at the disk [-]
    bool radial_friction = false;

    double tip() const { return blade->tip; }
    double root() const { return blade->root; }
};

// All that loads depend on, except the operating point.  `S` is double, or a dual number if loads are differentiated.
template <class S, template <class> class LawOf> struct Rotor : RotorSettings {
    BladeChange<S> change{};
    CorrectedLaw<LawOf<S>> law{};
    S drag_factor{};               // on the drag of the blades, if installed [-]
    S mount_area{};                // drag coefficient times area of the mount [m^2]
};

// The blade at these radii, of a rotor that turns at omega.
template <class R, class W, class T> [[gnu::flatten]] auto station_at(const R& rotor, const W& omega, const T& radius) {
    Lanes chord, twist, chord_slope, twist_slope;
    for (int k = 0; k < width; ++k) {
        const auto& i = rotor.blade->at(value(radius)[k]);
        const double t = value(radius)[k] - i.start;
        const double *c = i.chord, *w = i.twist;
        chord[k] = c[0] + t * (c[1] + t * (c[2] + t * c[3]));
        twist[k] = w[0] + t * (w[1] + t * (w[2] + t * w[3]));
        if constexpr (IsDual<T>) {
            chord_slope[k] = c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
            twist_slope[k] = w[1] + t * (2.0 * w[2] + t * 3.0 * w[3]);
        }
    }
    const auto& change = rotor.change;
    const auto wide = chain(radius, chord, chord_slope) * (1.0 + change.chord_scale);
    const auto line = chain(radius, twist, twist_slope) + change.twist_offset -
                      untwisting(change.untwist, rotor.tip(), radius, omega);
    const auto per_speed = wide * (rotor.density / rotor.viscosity);
    // At a pointed tip Re is zero and C_D infinite, but C_D times the chord is zero: limit Re from below.
    const auto per_root = 1.0 / square_root(maximum(per_speed, 0.0 * per_speed + 1e-30));
    const auto reynolds = per_speed * (omega * radius);
    const auto lift_line = line - rotor.law.zero_lift_angle_at(reynolds);
    const auto drag_line = line - rotor.law.least_drag_angle_at(reynolds);
    using A = decltype(lift_line + drag_line + wide + radius);
    const A none{};
    return Station<A>{radius + none,    wide + none, angle_from(lift_line + none), angle_from(drag_line + none),
                      per_speed + none, per_root + none,
                      rotor.law.lift_growth_at(reynolds) + none, rotor.law.drag_growth_at(reynolds) + none};
}

}  // namespace propmap
