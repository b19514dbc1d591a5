// The blade: chord and twist between the measured stations, and what they make of a radius.
#pragma once

#include <vector>

#include "section.hpp"

namespace propmap {

// Chord and twist by monotone cubics (PCHIP) through the measured stations.
struct BladeShape {
    std::vector<double> station;  // radii, rising [m]
    // Per interval: start, width, and the cubics of chord [m] and twist [rad] in the share of the width.
    struct Interval {
        double start, width, chord[4], twist[4];
    };
    std::vector<Interval> intervals;
    double root = 0.0;  // radius at which the blade begins [m]
    double tip = 0.0;   // R [m]
    int blades = 2;     // N_b

    const Interval& at(double radius) const {
        std::size_t low = 0, high = intervals.size() - 1;
        while (low < high) {
            const std::size_t middle = (low + high + 1) / 2;
            (radius >= intervals[middle].start ? low : high) = radius >= intervals[middle].start ? middle : middle - 1;
        }
        return intervals[low];
    }
};

// Slopes at the knots of the monotone piecewise cubic through (x, y).
// Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984, doi 10.1137/0905021; ends as SciPy has them.
inline std::vector<double> pchip_slopes(const std::vector<double>& x, const std::vector<double>& y) {
    const std::size_t n = x.size();
    std::vector<double> slope(n), h(n - 1), d(n - 1);
    for (std::size_t k = 0; k + 1 < n; ++k) h[k] = x[k + 1] - x[k], d[k] = (y[k + 1] - y[k]) / h[k];
    for (std::size_t k = 1; k + 1 < n; ++k) {
        const double w1 = 2.0 * h[k] + h[k - 1], w2 = h[k] + 2.0 * h[k - 1];
        slope[k] = d[k - 1] * d[k] > 0.0 ? (w1 + w2) / (w1 / d[k - 1] + w2 / d[k]) : 0.0;
    }
    const auto end = [](double h0, double h1, double d0, double d1) {
        double s = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
        if (s * d0 <= 0.0) return 0.0;
        return d0 * d1 < 0.0 && std::fabs(s) > 3.0 * std::fabs(d0) ? 3.0 * d0 : s;
    };
    slope[0] = end(h[0], h[1], d[0], d[1]);
    slope[n - 1] = end(h[n - 2], h[n - 3], d[n - 2], d[n - 3]);
    return slope;
}

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

inline BladeShape make_blade(const std::vector<double>& station, const std::vector<double>& chord,
                             const std::vector<double>& twist, int blades, double root) {
    return {station, pchip_intervals(station, chord, twist), root, station.back(), blades};
}

// The blade continued from its first station inwards to a hub of this radius [m]: the chord line keeps
// the geometric pitch of the first station; the chord goes on with its mean slope over a tenth of the
// radius, no wider than at the first station and no narrower than half of it.
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

// What loads depend on of the blade's shape beside its measured stations, for derivatives.
template <class S> struct BladeChange {
    S chord_scale;   // common relative change of the chord [-]
    S twist_offset;  // common offset of the twist [rad]
    S untwist;       // what the tip's twist loses at a tip speed of 100 m/s [rad]
};

// By how much the twist is less than at rest [rad].  The centrifugal force on its mass turns a section to
// the disk plane: the tip by an angle that grows with the square of its speed, the blade within by
// s (2 - s), s = y/R.  Houbolt & Brooks, NACA Report 1346, 1958.
template <class U, class R, class W> auto untwisting(const U& tip_angle, double tip, const R& radius, const W& omega) {
    const auto share = radius * (1.0 / tip);
    const auto speed = omega * (tip / 100.0);
    return tip_angle * (speed * speed) * share * (2.0 - share);
}

// The blade at a radius per lane.
template <class T> struct Station {
    T radius;              // y [m]
    T chord;               // c [m]
    T sine, cosine;        // of the angle of the zero-lift line to the disk plane
    T drag_sine, drag_cosine;  // of that of the line of least drag
    T reynolds_per_speed;  // rho c / mu [s/m]
    T inverse_root;        // its power -1/2
};

}  // namespace propmap
