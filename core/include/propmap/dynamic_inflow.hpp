// Dynamic inflow of the whole disk by Pitt and Peters: the inflow lags behind the loads, because the air has mass.
//
// The state is the mean inflow v_0 over the disk and the gradients v_s and v_c of `Harmonics`.  Per density, T is the
// thrust, L the moment that lifts the advancing side, M the moment that lifts the rear; d marks deviations from the
// static solution.  The gains k_t, k_s, k_c are by_thrust, by_roll, by_rear of `HarmonicResponse`.  W is the mass-flow
// parameter as a secant, the ratio of the deviations d(v_0 U) and dv_0, where U is the air speed at the disk.
//
//     8/3 R^3    dv_0/dt = dT - 2 pi R^2 W dv_0
//     16/45 R^4  dv_s/dt = dL - dv_s / k_s
//     16/45 R^4  dv_c/dt = dM - (dv_c - k_t 2 pi R^2 W dv_0) / k_c
//
// Mean inflow in hover: Carpenter & Fridovich, NACA TN 3044, 1953.
// Pitt & Peters, Vertica 5(1), 1981; Peters & HaQuang, J. AHS 33(4), 1988.
#pragma once

#include "rotor.hpp"

namespace propmap {

struct Matrix {  // 3 by 3
    double m[3][3]{};

    Matrix operator*(const Matrix& o) const {
        Matrix r;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k) r.m[i][j] += m[i][k] * o.m[k][j];
        return r;
    }
    Matrix operator+(const Matrix& o) const {
        Matrix r = *this;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) r.m[i][j] += o.m[i][j];
        return r;
    }
    Matrix times(double by) const {
        Matrix r = *this;
        for (auto& row : r.m)
            for (double& x : row) x *= by;
        return r;
    }
    std::array<double, 3> operator*(const std::array<double, 3>& v) const {
        std::array<double, 3> r{};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) r[i] += m[i][j] * v[j];
        return r;
    }
    bool finite() const {
        for (const auto& row : m)
            for (double x : row)
                if (!std::isfinite(x)) return false;
        return true;
    }
    // Whether all eigenvalues have negative real parts, by the Routh-Hurwitz criterion.
    bool decays() const {
        const double a = -(m[0][0] + m[1][1] + m[2][2]);
        double b = 0.0;
        for (int i = 0; i < 3; ++i)
            for (int j = i + 1; j < 3; ++j) b += m[i][i] * m[j][j] - m[i][j] * m[j][i];
        const double c = -(m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]));
        return a > 0.0 && c > 0.0 && a * b > c;
    }
};

// The matrix exponential, by scaling and squaring of the Taylor series.
inline Matrix exponential(const Matrix& a) {
    double size = 0.25;
    for (const auto& row : a.m) size = std::max(size, std::fabs(row[0]) + std::fabs(row[1]) + std::fabs(row[2]));
    const int halvings = int(std::ceil(std::log2(size))) + 2;
    Matrix small = a.times(std::ldexp(1.0, -halvings)), one;
    one.m[0][0] = one.m[1][1] = one.m[2][2] = 1.0;
    Matrix term = one, found = one;
    for (int k = 1; k < 13; ++k) {  // 0.25^13 / 13! is 2e-18
        term = (term * small).times(1.0 / k);
        found = found + term;
    }
    for (int k = 0; k < halvings; ++k) found = found * found;
    return found;
}

using State = std::array<double, 3>;  // mean inflow, v_s and v_c [m/s]

// Direction of flight in the disk plane, and spin: 1 for a rotor that turns counter-clockwise.  The rear of the disk is
// opposite to the direction of flight; for spin = 1, the advancing side is to the right of this direction.
struct Heading {
    double x, y, spin;

    // Convert gradients along x and y of the rotor frame to v_s and v_c, and back.
    State along_flight(const double* s) const { return {s[0], spin * (s[1] * y - s[2] * x), -(s[1] * x + s[2] * y)}; }
    State in_rotor_frame(const State& s) const {
        return {s[0], spin * s[1] * y - s[2] * x, -spin * s[1] * x - s[2] * y};
    }
};

struct Motion {  // of the inflow, starting at a given state
    State steady;         // the static solution
    State rates;          // time derivatives of the given state [m/s^2]
    State later;          // the state after the time step
    Loads<double> loads;  // in the given state [N], [N m]
    Matrix linear;        // derivatives of the rates with respect to the state, at the static solution [1/s]
};

// Compute the motion from `state` over a step of `time` [s], at the operating point whose static solution is `s`.
template <template <class> class LawOf>
Motion inflow_motion(const RotorSolver<LawOf>& solver, const Solution& s, const State& state, double time) {
    const auto& rotor = solver.rotor();
    const double radius = rotor.tip(), density = rotor.density;
    // Loads in the static inflow (`there`), and with the mean inflow and gradients of the state (`here`).
    const Azimuths psi = s.psi.count < 8 ? azimuths(16) : s.psi;  // gradients need several azimuths
    const std::vector<Lanes> inflow = solver.blended_inflow(s);
    Loads<double> there, slopes[3] = {s.by[0], s.by[1], s.by[2]};
    if (psi.count == s.psi.count && solver.has_harmonics(s)) {
        there = solver.loads_with(s, psi, inflow, s.harmonics);
    } else {
        std::vector<double> unused(2 * most_nodes);
        solver.loads_and_slopes(s, psi, inflow, s.harmonics, there, slopes, unused.data());
    }
    Loads<double> here = solver.loads_with(s, psi, inflow, {state[0] - s.mean.inflow, state[1], state[2]});

    if (rotor.installed) there.drag = rotor.drag_factor * there.drag, here.drag = rotor.drag_factor * here.drag;

    Motion motion;
    motion.steady = {s.mean.inflow + s.harmonics.mean, s.harmonics.lateral, s.harmonics.longitudinal};
    for (int k = 0; k < Loads<double>::count; ++k)
        motion.loads.begin()[k] = s.result.loads.begin()[k] + density * (here.begin()[k] - there.begin()[k]);

    const auto gains = harmonic_response(rotor.inflow_shape, s.mean, radius);
    const double mass = 8.0 / 3.0 * std::pow(radius, 3), inertia = 16.0 / 45.0 * std::pow(radius, 4);
    // In edgewise flight with zero static inflow, v_c has no time constant: it follows the mean inflow immediately.
    const double slow = 1.0 / std::max(inertia * gains.by_rear, 1e-6);
    const double mobility[3] = {1.0 / mass, 1.0 / inertia, gains.by_rear * slow};
    State deviation;
    for (int k = 0; k < 3; ++k) deviation[k] = state[k] - motion.steady[k];

    // `secant` is W.  It is limited to at least half of the mass-flow parameter of the static solution: smaller values
    // belong to mean inflows that oppose or reverse the flow through the disk.
    const auto momentum = [&](double mean) {
        const double v0 = motion.steady[0], v1 = v0 + mean, a = s.flow.v_axial, p = s.flow.v_inplane;
        const double total = std::hypot(p, a + v1) + std::hypot(p, a + v0) + 1e-30;
        const double secant = 0.5 * total + 0.5 * (v0 + v1) * (2.0 * a + v0 + v1) / total;
        const double growth = 2.0 * pi * radius * radius * std::max(secant, 0.5 * s.mean.mass_flow());
        Matrix r;
        r.m[0][0] = -growth / mass, r.m[1][1] = -1.0 / (inertia * gains.by_roll);
        r.m[2][0] = slow * gains.by_thrust * growth, r.m[2][2] = -slow;
        return r;
    };
    const auto forces_of = [](const Loads<double>& l) { return State{l.thrust, l.roll_moment, -l.pitch_moment}; };
    Matrix blades;
    for (int j = 0; j < 3; ++j) {
        const State by = forces_of(slopes[j]);
        for (int i = 0; i < 3; ++i) blades.m[i][j] = by[i];
    }
    const State now = forces_of(here), before = forces_of(there);
    State forces, missing;
    for (int i = 0; i < 3; ++i) forces[i] = now[i] - before[i];
    const State linear = blades * deviation;
    double square = 0.0;
    for (int i = 0; i < 3; ++i) missing[i] = forces[i] - linear[i], square += deviation[i] * deviation[i];

    const Matrix own = momentum(deviation[0]);
    const State from_momentum = own * deviation;
    for (int i = 0; i < 3; ++i) motion.rates[i] = forces[i] * mobility[i] + from_momentum[i];
    motion.linear = momentum(0.0);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) motion.linear.m[i][j] += blades.m[i][j] * mobility[i];

    // The step writes the rates as a matrix times the deviation.  Of all matrices that give the present rates, it takes
    // the one closest to the matrix at the static solution.  Its exponential is exact for linear forces and stable for
    // any time.  If stalled blades drive the inflow away from the static solution, the momentum terms are used alone.
    Matrix whole = own;
    const double per = square > 0.0 ? 1.0 / square : 0.0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) whole.m[i][j] += (blades.m[i][j] + missing[i] * deviation[j] * per) * mobility[i];
    const bool known = whole.finite();
    if (!whole.decays()) whole = own;
    const State moved = known ? exponential(whole.times(time)) * deviation : State{NAN, NAN, NAN};
    for (int i = 0; i < 3; ++i) motion.later[i] = motion.steady[i] + moved[i];
    if (s.result.status == Status::not_converged) motion.steady = motion.rates = motion.later = {NAN, NAN, NAN};
    return motion;
}

}  // namespace propmap
