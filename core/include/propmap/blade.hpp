// A rotor in air: chord and twist of its blades at any radius, its section law, and the corrections that are switched on.
#pragma once

#include "section.hpp"

namespace propmap {

// Chord and twist by monotone cubics through the measured stations (`blade_intervals` in Python).
struct BladeShape {
    // From one station to the next: start [m], and cubics of chord [m] and twist [rad], lowest power first, over the
    // distance from the start.
    struct Interval { double start, chord[4], twist[4]; };
    std::vector<Interval> intervals;  // in increasing order
    double root;                      // radius at which the blade begins [m]
    double tip;                       // R [m]
    int blades;                       // N_b

    const Interval& at(double radius) const {  // the interval that contains the radius, by bisection
        std::size_t low = 0, high = intervals.size() - 1;
        while (low < high) {
            const std::size_t middle = (low + high + 1) / 2;
            (radius >= intervals[middle].start ? low : high) = radius >= intervals[middle].start ? middle : middle - 1;
        }
        return intervals[low];
    }
};

// Changes of the blade's shape, with respect to which loads can be differentiated.
template <class S> struct BladeChange {
    S chord_scale;   // common relative change of the chord [-]
    S twist_offset;  // common offset of the twist [rad]
    S untwist;       // loss of twist of the tip at a tip speed of 100 m/s [rad]
};

// Loss of twist in rotation [rad] (Houbolt & Brooks, NACA Report 1346, 1958).  Centrifugal force turns the tip toward
// the disk plane by an angle proportional to its speed squared, and the section at y = s R by s (2 - s) times this angle.
template <class U, class R, class W> auto untwisting(const U& tip_angle, double tip, const R& radius, const W& omega) {
    const auto share = radius * (1.0 / tip);
    const auto speed = omega * (tip / 100.0);
    return tip_angle * (speed * speed) * share * (2.0 - share);
}

// The blade at one radius per lane.
template <class T> struct Station {
    T radius;              // y [m]
    T chord;               // c [m]
    Angle<T> line;         // angle of the zero-lift line to the disk plane
    Angle<T> drag_line;    // angle of the line of least drag to the disk plane
    T reynolds_per_speed;  // rho c / mu [s/m]
    T inverse_root;        // (rho c / mu)^(-1/2)
    T lift_growth;         // factors on attached lift and drag, see section.hpp
    T drag_growth;
};

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
        chord_slope[k] = c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
        twist_slope[k] = w[1] + t * (2.0 * w[2] + t * 3.0 * w[3]);
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
