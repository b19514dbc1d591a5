// The blade: chord and twist at the measured stations and in between.
#pragma once

#include "section.hpp"

namespace propmap {

// Chord and twist by monotone cubics (PCHIP) through the measured stations.
struct BladeShape {
    std::vector<double> station;  // radii in increasing order [m]
    // Between two stations: start, width, and cubics of chord [m] and twist [rad] over the fraction of the width.
    struct Interval { double start, width, chord[4], twist[4]; };
    std::vector<Interval> intervals;
    double root = 0.0;  // radius at which the blade begins [m]
    double tip = 0.0;   // R [m]
    int blades = 2;     // N_b

    const Interval& at(double radius) const {  // the interval that contains the radius, by bisection
        std::size_t low = 0, high = intervals.size() - 1;
        while (low < high) {
            const std::size_t middle = (low + high + 1) / 2;
            (radius >= intervals[middle].start ? low : high) = radius >= intervals[middle].start ? middle : middle - 1;
        }
        return intervals[low];
    }
};

// Make the cubics of all intervals, through chord and twist at the stations.
inline std::vector<BladeShape::Interval> pchip_intervals(const std::vector<double>& station,
                                                         const std::vector<double>& chord,
                                                         const std::vector<double>& twist) {
    std::vector<BladeShape::Interval> found(station.size() - 1);
    const std::vector<double> slopes[2] = {pchip_slopes(station, chord), pchip_slopes(station, twist)};
    for (std::size_t k = 0; k < found.size(); ++k) {
        const double h = station[k + 1] - station[k];
        found[k].start = station[k], found[k].width = h;
        for (int which = 0; which < 2; ++which) {
            const std::vector<double>& y = which ? twist : chord;
            const double m0 = slopes[which][k] * h, m1 = slopes[which][k + 1] * h, rise = y[k + 1] - y[k];
            double* c = which ? found[k].twist : found[k].chord;
            c[0] = y[k], c[1] = m0, c[2] = 3.0 * rise - 2.0 * m0 - m1, c[3] = m0 + m1 - 2.0 * rise;
        }
    }
    return found;
}

// Make a blade from stations [m], chord [m], twist [rad], number of blades and root radius [m].
inline BladeShape make_blade(const std::vector<double>& station, const std::vector<double>& chord,
                             const std::vector<double>& twist, int blades, double root) {
    return {station, pchip_intervals(station, chord, twist), root, station.back(), blades};
}

// Extend the blade inwards from its first station to a hub of this radius [m].  The chord line keeps its geometric
// pitch, y tan(theta).  The chord continues with its mean slope over the first 0.1 R of the blade, limited to 0.5 to 1
// times the first chord.
inline BladeShape continued_to(const BladeShape& blade, double hub) {
    const auto shape = [&](double y, bool of_twist) {
        const auto& i = blade.at(y);
        const double t = (y - i.start) / i.width;
        const double* c = of_twist ? i.twist : i.chord;
        return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
    };
    const double first = blade.station.front(), further = std::min(first + 0.1 * blade.tip, blade.tip);
    const double widest = shape(first, false), twist = shape(first, true);
    const double taper = (shape(further, false) - widest) / (further - first);
    const int count = 12;
    std::vector<double> y(count + 1), c(count + 1), theta(count + 1);
    for (int k = 0; k <= count; ++k) {
        y[k] = k == count ? first : hub + k * ((first - hub) / count);
        c[k] = std::clamp(widest + taper * (y[k] - first), 0.5 * widest, widest);
        theta[k] = std::atan2(first * std::sin(twist), y[k] * std::cos(twist));
    }
    BladeShape longer = blade;
    longer.root = hub;
    longer.station.insert(longer.station.begin(), y.begin(), y.end() - 1);
    const auto inner = pchip_intervals(y, c, theta);
    longer.intervals.insert(longer.intervals.begin(), inner.begin(), inner.end());
    return longer;
}

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

}  // namespace propmap
