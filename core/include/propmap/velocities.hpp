// Velocity of the air at a blade section, eqs. (1) and (2), and the azimuths over which loads are averaged.
#pragma once

#include "dual.hpp"

namespace propmap {

// An operating point.  `S` is double, or a dual number if loads are differentiated.
template <class S> struct Flow {
    S omega;      // Omega [rad/s], >= 0
    S v_axial;    // V cos(beta) [m/s], positive in climb
    S v_inplane;  // V sin(beta) [m/s], >= 0
    S v_hover{};  // static inflow (12) at the same Omega [m/s]; used if v_axial < 0
    S height = S{} + INFINITY;   // of the disk above the ground [m]
    S ceiling = S{} + INFINITY;  // distance of a ceiling above the disk [m]

    // The variables that users set, with names, in the order of the rows of operating points (`Points`, bind.cpp).
    static constexpr int variables = 5;
    template <class Visit> void each_variable(Visit visit) {
        visit("omega", omega), visit("v_axial", v_axial), visit("v_inplane", v_inplane), visit("height", height);
        visit("ceiling", ceiling);
    }
};

// Speed [m/s] added in quadrature to every speed in a denominator.  A section at rest in the air then has finite
// derivatives, and no load changes by more than rounding.
inline constexpr double speed_floor = 1e-9;

template <class A, class B> auto speed_squared(const A& a, const B& b) {  // a^2 + b^2
    return square(a) + square(b) + speed_floor * speed_floor;
}

// Share of the area from `root` to `tip` [m] in reverse flow: within the circle y = -V sin(beta) sin(psi)/Omega.
inline double reverse_flow_share(const Flow<double>& flow, double root, double tip) {
    const double diameter = std::min(flow.v_inplane / std::max(flow.omega, 1e-12), 1e4 * tip);
    if (diameter <= root) return 0.0;
    const auto within = [&](double radius) {
        const double angle = std::acos(std::min(radius / std::max(diameter, 1e-12), 1.0));
        return radius * radius * angle +
               0.5 * diameter * diameter * (0.5 * pi - angle - std::sin(angle) * std::cos(angle));
    };
    return (within(tip) - within(root)) / (pi * (tip * tip - root * root));
}

// Equally spaced azimuths: the mean over them, the periodic trapezoidal rule, converges spectrally.  They are
// symmetric, psi and pi - psi, so that the rear half of the disk is enough if the inflow does not vary around it.
struct Azimuths {
    int count = 1;                  // on the rear half; 1 in axial flow, where all azimuths are alike
    const double* sine = nullptr;   // sin(psi), 1 on the advancing side
    const double* cosine = nullptr; // cos(psi) >= 0; psi = 0 is the rear
};

}  // namespace propmap
