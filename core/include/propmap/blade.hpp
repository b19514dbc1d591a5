// The blade: chord and twist at the measured stations and in between.
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

}  // namespace propmap
