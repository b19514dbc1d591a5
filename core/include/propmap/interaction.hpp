// Interaction of rotors: the axial velocity that the wake of each rotor adds at the other rotors of a vehicle.
//
// docs/theory.md, "Rotor wakes" and "Rotors above each other", describes the model.  Splines contain the velocity that a
// wake of unit circulation per length induces, averaged over the disk of another rotor (`vehicle/wakes.py`).
#pragma once

#include "vehicle.hpp"

namespace propmap {

// Upper limit of the inflow, divided by the hover inflow at the same thrust [-]: about the measured value in the vortex ring
// state, where momentum theory has no solution.
inline constexpr double largest_inflow = 2.0;
// Upwash divided by the circulation per length, above which the upwash gain applies in full [-].  Below this value, the gain
// changes smoothly to the gain of the downwash.
inline constexpr double full_upwash = 0.005;
// Upper limit of the upwash divided by the circulation per length, including the gain [-].  At this limit, the upwash equals
// the inflow of the source rotor.  It is the largest upwash outside the cylindrical wake and occurs at its surface.
inline constexpr double largest_upwash = 0.5;
inline constexpr double slow_flow = 0.5;  // in-plane velocity [m/s] above which the gains ahead and beside differ clearly
inline constexpr int inflow_steps = 40;   // largest number of Newton steps, which converge monotonically from above

// Uniform inflow v [m/s] of a disk by eq. (10), T = 2 rho A v sqrt(V_in^2 + (V_ax + v)^2), and its derivative by the
// thrust T [N]; `disk` is rho A [kg/m].  If descent has several solutions, v is the largest one, limited by
// `largest_inflow`.  Without thrust v is 0; it is NaN if an argument is NaN.
inline std::array<double, 2> glauert_inflow(double thrust, double axial, double inplane, double disk) {
    const double square = std::max(thrust, 0.0) / (2.0 * disk), hover = std::sqrt(square), most = largest_inflow * hover;
    double v = hover + 1.5 * std::max(-axial, 0.0) + 1e-9, speed, slope;
    for (int step = 0;; ++step) {
        speed = std::sqrt(inplane * inplane + (axial + v) * (axial + v) + 1e-12);
        slope = std::max(speed + v * (axial + v) / speed, 1e-6);
        const double next = std::max(v - (v * speed - square) / slope, 0.0);
        if (step == inflow_steps || !(std::fabs(next - v) > 1e-14 * v)) break;
        v = next;
    }
    // The derivative of the hover inflow is infinite at zero thrust, so a minimum thrust limits this derivative.
    const double by_thrust = v < most ? 1.0 / (2.0 * disk * slope) : most / std::max(2.0 * thrust, 1e-6);
    return {std::min(v, most), thrust > 0.0 ? by_thrust : 0.0};
}

struct WakeGains {  // see `Wakes` in Python; and rho A [kg/m]
    double ahead, beside, downwash, share, disk;
};

// Velocity [m/s] added at a rotor by the wake of another rotor, and its derivatives.
struct WakeEffect {
    double added = 0.0, by_thrust = 0.0, by_gain[4]{};  // by_gain: ahead, beside, downwash, share
};

// The rotors of a vehicle, and splines of their wakes over two angles: the skew from straight down, and the bearing.
struct Interaction {
    struct Pair {
        std::size_t spline;
        double bearing;   // of the target in the frame of the source [rad]; bearings in the spline are relative to it
        bool slipstream;  // whether the rotors are above each other: gains then do not apply
    };
    std::vector<std::array<Vector3, 3>> frames;  // of each rotor: two directions in the disk, and the axis
    std::vector<Pair> pairs;                     // (target, source)
    TableAxis skews, bearings;
    std::vector<double> coefficients;  // (spline, skew, bearing)

    // Call `each(target, source, effect)` for all pairs of rotors with this flow and thrust [N].  The velocity added by a
    // rotor with unknown thrust is NaN.
    template <class Each> void effects(const WakeGains& with, const HubFlow* flow, const double* thrust, Each each) const {
        for (std::size_t source = 0; source < frames.size(); ++source) {
            const HubFlow& at = flow[source];
            const auto [v, by_thrust] = glauert_inflow(thrust[source], at.axial, at.inplane, with.disk);
            // The air carries a wake against the velocity of the hub and down the rotor axis.
            double x = -at.inplane * dot(frames[source][0], at.ahead), y = -at.inplane * dot(frames[source][1], at.ahead);
            double z = -at.axial - with.share * v;
            if (std::fabs(x) < 1e-9 && std::fabs(y) < 1e-9 && std::fabs(z) < 1e-9) x = y = 0.0, z = -1.0;
            const double aside = std::hypot(x, y), size = aside * aside + z * z;
            const auto i = skews.place_of(std::atan2(aside, -z));
            const double bearing = std::atan2(y, x), straighter = -aside * v / size;
            for (std::size_t target = 0; target < frames.size(); ++target) {
                if (target == source) continue;
                WakeEffect e;
                if (const Pair& pair = pairs[target * frames.size() + source]; !std::isfinite(v + size)) e.added = std::nan("");
                else {
                    const double turns = (bearing - pair.bearing) / (2.0 * pi);
                    const auto j = bearings.place_of(2.0 * pi * (turns - std::floor(turns)));
                    const std::size_t rows = skews.knots.size() + 2, columns = bearings.knots.size() + 2;
                    const double* row = &coefficients[(pair.spline * rows + i.interval) * columns + j.interval];
                    double seen = 0.0, by_skew = 0.0;
                    for (int k = 0; k < 4; ++k, row += columns) {
                        const double there = j.at[0] * row[0] + j.at[1] * row[1] + j.at[2] * row[2] + j.at[3] * row[3];
                        seen += i.at[k] * there, by_skew += i.slope[k] * there;
                    }
                    // The weight of the gain ahead: 1 in flight direction, 0 to the side and at rest.
                    const double away = x * std::cos(pair.bearing) + y * std::sin(pair.bearing);
                    const double along = away * away / (at.inplane * at.inplane + slow_flow * slow_flow);
                    const double gain = with.beside + (with.ahead - with.beside) * along;
                    // The upwash part of the velocity, and its derivative; both are continuous.
                    const double part = std::clamp(-seen / full_upwash, 0.0, 1.0);
                    const double rising = seen * part * part * (3.0 - 2.0 * part), steep = part * part * (9.0 - 8.0 * part);
                    const double relative = std::tanh(gain * rising / largest_upwash), limited = 1.0 - relative * relative;
                    const double down = pair.slipstream ? 1.0 : with.downwash;
                    const double gained = down * (seen - rising) + largest_upwash * relative;
                    const double by_share = (down * (1.0 - steep) + limited * gain * steep) * by_skew * straighter;
                    // The velocity is 2 v K.  K, here `gained`, depends on the skew of the wake and thus on share times v.
                    e = {2.0 * v * gained, 2.0 * (gained + with.share * by_share) * by_thrust,
                         {2.0 * v * along * limited * rising, 2.0 * v * (1.0 - along) * limited * rising,
                          pair.slipstream ? 0.0 : 2.0 * v * (seen - rising), 2.0 * v * by_share}};
                }
                each(target, source, e);
            }
        }
    }
};

}  // namespace propmap
