// Dynamic inflow: the inflow lags behind the loads, because the air has mass.
//
// The state contains the inflow v_j of eq. (11) at fixed radii y_j, the nodes, and the harmonics v_0, v_s and v_c
// around the disk.  T is the thrust, L the moment that lifts the advancing side, and M the moment that lifts the rear,
// all divided by the density.  h_0, h_s and h_c are the static harmonics for these loads (`HarmonicResponse`).  The
// equations are
//
//     16/3 R y_j  dv_j/dt = residual of eq. (11) at y_j
//     8/3 R^3 k_0    dv_0/dt = h_0(T) - v_0
//     16/45 R^4 k_s  dv_s/dt = h_s(L) - v_s
//     16/45 R^4 k_c  dv_c/dt = h_c(T, M) - v_c
//
// The apparent masses of the annuli add up to 8/3 R^3, the apparent mass of a disk with uniform inflow (Carpenter &
// Fridovich, NACA TN 3044, 1953).  The gains k_0, k_s and k_c are `mean_by_thrust`, `by_roll` and `by_rear`.  With these
// gains, v_0, v_s and v_c have the time constants of Pitt & Peters, Vertica 5(1), 1981.  If all rates vanish, the state
// is a static solution.
#pragma once

#include "rotor.hpp"

namespace propmap {

// Direction of flight in the disk plane (x, y), and spin: 1 for a rotor that turns counter-clockwise, -1 for clockwise.
// The rear of the disk is opposite to the direction of flight.  For spin = 1, the advancing side is to the right of the
// direction of flight.
struct Heading {
    double x, y, spin;

    // Convert v_0 and the gradients along x and y of the rotor frame to v_0, v_s and v_c; `in_rotor_frame` inverts this.
    void along_flight(const double* s, double* to) const {
        to[0] = s[0], to[1] = spin * (s[1] * y - s[2] * x), to[2] = -(s[1] * x + s[2] * y);
    }
    void in_rotor_frame(const double* s, double* to) const {
        to[0] = s[0], to[1] = spin * s[1] * y - s[2] * x, to[2] = -spin * s[1] * x - s[2] * y;
    }
};

inline constexpr int harmonics_first = 3;  // a state begins with v_0 and the gradients along x and y of the rotor frame
inline constexpr double negligible = 1e-13;  // harmonics below this share of the speed of the air are set to zero

// Return the smallest number of nodes with an accurate static thrust in climb, hover and slow descent, with and without
// in-plane flow.  The reference is the thrust with panels that follow stall; the difference is at most 0.2 % of the
// thrust at rest.  A fold between two nodes acts as if it were in the middle between these nodes.  Blades that stall
// abruptly therefore require many nodes.
template <template <class> class LawOf> int nodes_for(const RotorSolver<LawOf>& solver) {
    constexpr int counts[] = {24, 48, 96, 192};
    Solution exact, found;
    const double radius = solver.rotor().tip();
    const auto close = [&](int count) {
        for (double tip_speed : {40.0, 90.0}) {
            const double omega = tip_speed / radius;
            double at_rest = 0.0;
            for (double axial : {0.0, 0.02, 0.05, 0.1, 0.2, -0.01})
                for (double inplane : {0.0, 0.08, 0.2}) {
                    const Flow<double> at{omega, axial * tip_speed, inplane * tip_speed};
                    solver.solve(at, exact), solver.solve_at_nodes(at, count, found);
                    const double thrust = exact.result.loads.thrust;
                    if (axial == 0.0 && inplane == 0.0) at_rest = std::fabs(thrust);
                    if (std::fabs(found.result.loads.thrust - thrust) > 2e-3 * at_rest) return false;
                }
        }
        return true;
    };
    for (int count : counts)
        if (close(count)) return count;
    return counts[std::size(counts) - 1];
}

// Dynamic inflow of a rotor, at a fixed number of nodes.
template <template <class> class LawOf> class DynamicInflow {
  public:
    explicit DynamicInflow(const RotorSolver<LawOf>& solver) : DynamicInflow(solver, nodes_for(solver)) {}
    DynamicInflow(const RotorSolver<LawOf>& solver, int nodes) : solver_(&solver), nodes_(nodes) {}

    int size() const { return harmonics_first + nodes_; }  // of a state [m/s]

    // Write the static solution at an operating point to `state`: the largest root of (11) at each node.
    void steady(const Flow<double>& at, const Heading& heading, double* state) const {
        thread_local Solution s;
        solver_->solve_at_nodes(at, nodes_, s);
        const double along[3] = {s.harmonics.mean, s.harmonics.lateral, s.harmonics.longitudinal};
        heading.in_rotor_frame(along, state);
        const bool lost = s.result.status == Status::not_converged;
        for (int k = 0; k < size(); ++k) {
            if (k >= harmonics_first) state[k] = s.disk.inflow[(k - harmonics_first) / width][(k - harmonics_first) % width];
            if (lost) state[k] = std::nan("");
        }
    }

    // Return loads and status in a `state`, and write the `rates` [m/s^2] and the state `later` after a step of `time`
    // [s].  The returned solution is valid until the next call in the same thread.
    const Solution& move(const Flow<double>& at, const Heading& heading, const double* state, double time, double* rates,
                         double* later) const {
        thread_local Solution s;
        const auto& rotor = solver_->rotor();
        const double radius = rotor.tip();
        double h[3];
        heading.along_flight(state, h);
        const bool around = rotor.inflow_shape != InflowShape::uniform &&
                            (at.v_inplane > 0.0 || h[0] != 0.0 || h[1] != 0.0 || h[2] != 0.0);
        solver_->prepare(at, s);
        if (around && s.psi.count < 8) s.psi = azimuths(16);  // gradients need several azimuths
        s.disk.several = false;
        single_panel(s.disk, rotor.root(), radius, nodes_);
        place_nodes(rotor, at.omega, s.disk);
        const int groups = s.disk.groups;
        for (int k = 0; k < groups * width; ++k)
            s.disk.inflow[k / width][k % width] = state[harmonics_first + std::min(k, nodes_ - 1)];

        // Each annulus steps by the exponential of its linearized rate.  Stalled blades, or an inflow against the flow
        // through the disk, may have a slope of any sign.  The slope is therefore limited to at least half of the
        // mass-flow parameter in size.
        const auto of = solver_->annuli(s);
        const double ring = vortex_ring::weight(s.flow), ring_inflow = vortex_ring::inflow(s.flow);
        double thrust_without = 0.0;
        for (int g = 0; g < groups; ++g) {
            const auto& station = s.disk.at[g];
            const Lanes v = s.disk.inflow[g];
            const Dual<Lanes, 1> inflow{v, {broadcast(1.0)}};
            const auto thrust = annulus_thrust(rotor, station, s.flow, inflow, s.psi);
            const auto residual = thrust - wake_thrust(rotor, station.radius, s.flow, s.windmill, inflow);
            const Lanes in_ring = ring > 0.0 ? annulus_thrust(rotor, station, s.flow, (1.0 - ring) * v + ring * ring_inflow, s.psi) : thrust.v;
            thrust_without += sum(s.disk.weight[g] * in_ring);
            const Lanes through = s.flow.v_axial + v;
            const Lanes least = 2.0 * pi * station.radius * square_root(speed_squared(s.flow.v_inplane, through));
            const Lanes slope = maximum(-residual.d[0], least), per_mass = 3.0 / (16.0 * radius * station.radius);
            const Lanes share = 1.0 - power_of_two(maximum(slope * per_mass * (-1.44269504088896340736 * time), broadcast(-100.0)));
            const Lanes most = 0.3 * speed_scale(of, station);
            Lanes step = residual.v / slope * share;
            step = step > most ? most : (step < -most ? -most : step);
            for (int k = 0; k < width && g * width + k < nodes_; ++k) {
                const int to = harmonics_first + g * width + k;
                rates[to] = residual.v[k] * per_mass[k];
                later[to] = state[to] + step[k];
            }
        }

        // Compute the loads with the harmonics of the state, and the derivatives of the loads by the harmonics.
        s.harmonics = {h[0], h[1], h[2]};
        solver_->find_loads(s, around, false);
        solver_->set_status(s, false);
        double rate[3]{}, change[3]{};
        if (around) move_harmonics(s, thrust_without, time, rate, change);
        const double speed = at.omega * radius + s.mean.speed();
        double next[3];
        for (int k = 0; k < 3; ++k) {
            next[k] = h[k] + change[k];
            if (std::fabs(next[k]) < negligible * speed) next[k] = 0.0;
        }
        heading.in_rotor_frame(rate, rates);
        heading.in_rotor_frame(next, later);
        return s;
    }

  private:
    void move_harmonics(const Solution& s, double thrust_without, double time, double (&rate)[3], double (&change)[3]) const {
        const auto& rotor = solver_->rotor();
        const double radius = rotor.tip(), mass = 8.0 / 3.0 * std::pow(radius, 3), inertia = 16.0 / 45.0 * std::pow(radius, 4);
        const auto gains = harmonic_response(rotor.inflow_shape, s.mean, radius);
        const double h[3] = {s.harmonics.mean, s.harmonics.lateral, s.harmonics.longitudinal};
        // In edgewise flight without inflow, v_c has no time constant: it follows the loads immediately.
        const double per[3] = {1.0 / (mass * gains.mean_by_thrust), 1.0 / (inertia * gains.by_roll),
                               1.0 / std::max(inertia * gains.by_rear, 1e-6)};
        const auto response = solver_->faded(gains, 1.0 - s.result.ring);
        const auto& l = s.blade_loads;
        const auto wanted = response.harmonics({l.thrust, l.roll_moment, -l.pitch_moment}, thrust_without);
        const double target[3] = {wanted.mean, wanted.lateral, wanted.longitudinal};
        // Each harmonic steps by the exponential of its linearized rate.  If stalled blades amplify the harmonic, the
        // step omits the part of the blades in the slope.
        const double by_itself[3] = {response.mean_by_thrust * s.by[0].thrust, response.by_roll * s.by[1].roll_moment,
                                     response.by_thrust * s.by[2].thrust - response.by_rear * s.by[2].pitch_moment};
        for (int k = 0; k < 3; ++k) {
            const double decay = 1.0 - std::min(by_itself[k], 0.0);
            rate[k] = per[k] * (target[k] - h[k]);
            change[k] = (target[k] - h[k]) / decay * -std::expm1(-per[k] * decay * time);
        }
    }

    const RotorSolver<LawOf>* solver_;
    int nodes_;
};

}  // namespace propmap
