// Velocity of the air at a blade section, eqs. (1) and (2), and the azimuths over which loads are averaged.
#pragma once

#include "dual.hpp"

namespace propmap {

// An operating point.  `S` is double, or a dual number where loads are differentiated.
template <class S> struct Flow {
    S omega;      // Omega [rad/s], >= 0
    S v_axial;    // V cos(beta) [m/s], positive in climb
    S v_inplane;  // V sin(beta) [m/s], >= 0
    S v_hover{};  // static inflow (12) at the same Omega [m/s]; used where v_axial < 0
    S height = S{} + INFINITY;  // of the disk above the ground [m]

    // What a user gives, by name, in the order of arrays of operating points.
    static constexpr int variables = 4;
    template <class Visit> void each_variable(Visit visit) {
        visit("omega", omega), visit("v_axial", v_axial), visit("v_inplane", v_inplane), visit("height", height);
    }
};

// Speed [m/s] added in quadrature to every speed that is divided by: a section that stands still in the
// air has finite derivatives then, and no load changes by more than a rounding error.
inline constexpr double speed_floor = 1e-9;

template <class A, class B> auto speed_squared(const A& a, const B& b) {
    return square(a) + square(b) + speed_floor * speed_floor;
}

// Share of the annulus between `root` and `tip` [m] inside the reverse-flow circle y = -V sin(beta) sin(psi)/Omega, which
// passes through the hub.
inline double reverse_flow_share(const Flow<double>& flow, double root, double tip) {
    if (flow.v_inplane == 0.0) return 0.0;
    const double diameter = std::min(flow.v_inplane / std::max(flow.omega, 1e-12), 1e4 * tip);
    const auto within = [&](double radius) {
        const double angle = std::acos(std::min(radius / std::max(diameter, 1e-12), 1.0));
        return radius * radius * angle +
               0.5 * diameter * diameter * (0.5 * pi - angle - std::sin(angle) * std::cos(angle));
    };
    return (within(tip) - within(root)) / (pi * (tip * tip - root * root));
}

// Equally spaced azimuths: the mean over them, the periodic trapezoidal rule, converges spectrally.
// Nodes lie symmetrically about the advancing and the retreating side, psi and pi - psi, so that those
// of the front of the disk are enough where the inflow does not vary around it.
struct Azimuths {
    int count = 1;                  // of the front half; 1 in axial flow, where every azimuth is alike
    const double* sine = nullptr;   // sin(psi), 1 on the advancing side
    const double* cosine = nullptr; // cos(psi) >= 0, towards the rear
};

}  // namespace propmap
