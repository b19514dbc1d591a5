// Dynamic inflow: the inflow lags behind the loads, because the air has mass.
//
// The state contains the harmonics around the disk and the inflow v_j of eq. (11) at the nodes (fixed radii y_j).  It
// stores the harmonics in the rotor frame; `Heading` converts them to v_0, v_s and v_c of `Harmonics`.  T is the thrust,
// L the moment that lifts the advancing side, and M the moment that lifts the rear, all divided by the density.  h_0,
// h_s and h_c are the steady harmonics for these loads (`HarmonicResponse`).  The equations are
//
//     16/3 R y_j  dv_j/dt = residual of eq. (11) at y_j
//     8/3 R^3 k_0    dv_0/dt = h_0(T) - v_0
//     16/45 R^4 k_s  dv_s/dt = h_s(L) - v_s
//     16/45 R^4 k_c  dv_c/dt = h_c(T, M) - v_c
//
// The apparent masses of the annuli add up to 8/3 R^3, the apparent mass of a disk with uniform inflow (Carpenter &
// Fridovich, NACA TN 3044, 1953).  The gains k_0, k_s and k_c are `mean_by_thrust`, `by_roll` and `by_rear`.  With these
// gains, v_0, v_s and v_c have the time constants of Pitt & Peters, Vertica 5(1), 1981.  If all rates vanish, the state
// is a steady solution.
#pragma once

#include "rotor.hpp"

namespace propmap {

// Direction of flight in the disk plane (x, y), and spin: 1 for a rotor that turns counter-clockwise, -1 for clockwise.
// The rear of the disk is opposite to the direction of flight.  For spin = 1, the advancing side is to the right of the
// direction of flight.
struct Heading {
    double x, y, spin;

    // Convert the harmonics in the rotor frame (see `harmonics_first`) to v_0, v_s and v_c; `in_rotor_frame` inverts this.
    void along_flight(const double* s, double* to) const {
        to[0] = s[0], to[1] = spin * (s[1] * y - s[2] * x), to[2] = -(s[1] * x + s[2] * y);
    }
    void in_rotor_frame(const double* s, double* to) const {
        to[0] = s[0], to[1] = spin * s[1] * y - s[2] * x, to[2] = -spin * s[1] * x - s[2] * y;
    }
};

// A state begins with v_0 and the increases of inflow from hub to tip along x and y of the rotor frame.
inline constexpr int harmonics_first = 3;
inline constexpr double negligible = 1e-13;  // smaller harmonics, relative to tip speed plus flow speed, are set to zero

// Return the number of nodes: the smallest of 24, 48 and 96 that suffices, or 192 if none does.  A number suffices if
// the thrust differs by at most 0.2 % of the static thrust from the thrust with panels that follow stall.  The test
// points are in hover, climb, slow descent, edgewise and oblique flight.  Abrupt stall needs many nodes, because fixed
// nodes cannot represent a beginning of stall between two nodes.
template <template <class> class LawOf> int nodes_for(const RotorSolver<LawOf>& solver) {
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
    for (int count : {24, 48, 96})
        if (close(count)) return count;
    return 192;
}

// Dynamic inflow of a rotor, at a fixed number of nodes.
template <template <class> class LawOf> class DynamicInflow {
  public:
    explicit DynamicInflow(const RotorSolver<LawOf>& solver) : solver_(&solver), nodes_(nodes_for(solver)) {
        single_panel(disk_, solver.rotor().root(), solver.rotor().tip(), nodes_);
        place_nodes(solver.rotor(), 0.0, disk_);
    }

    int size() const { return harmonics_first + nodes_; }  // number of values in a state

    // Write the steady solution at an operating point to `state`: the largest root of (11) at each node.
    void steady(const Flow<double>& at, const Heading& heading, double* state) const {
        thread_local Solution s;
        solver_->solve_at_nodes(at, nodes_, s);
        const double along[3] = {s.harmonics.mean, s.harmonics.lateral, s.harmonics.longitudinal};
        heading.in_rotor_frame(along, state);
        for (int k = 0; k < nodes_; ++k) state[harmonics_first + k] = s.disk.inflow[k / width][k % width];
        if (s.result.status == Status::not_converged) std::fill_n(state, size(), std::nan(""));
    }

    // Return loads and status of a `state`, and write the `rates` [m/s^2] and the state `later` after a step of `time`
    // [s], unless these pointers are null.  The returned solution is valid until the next call in the same thread.
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
        s.harmonics = {h[0], h[1], h[2]};
        if (around && s.psi.count < 4) s.psi = azimuths(8);  // gradients need several azimuths

        // The step integrates the linearized equation of each annulus and each harmonic exactly.  If blades stall, or if the
        // inflow opposes the flow through the disk, the slope of the residual g may have either sign.  The step therefore
        // uses the larger of -dg/dv_i and 2 pi y W.  (W is Glauert's speed, and the momentum thrust (10) is 4 pi y W v_i.)
        const auto of = solver_->annuli(s);
        const Azimuths for_friction = s.psi.count > 4 ? azimuths(std::max(8, 2 * of.few.count)) : s.psi;
        const double ring = vortex_ring::weight(s.flow), ring_inflow = vortex_ring::inflow(s.flow);
        Loads<Lanes> sums{};  // over groups; the lanes are added at the end
        // For the decay of harmonics: dT/dv_0, and one slope for dL/dv_s and dM/dv_c (sin^2(psi) replaced by its mean, 1/2).
        Lanes by_mean{}, by_gradient{};
        Lanes thrust_without{}, area{}, through_area{};
        for (int g = 0; g < disk_.groups; ++g) {
            const auto station = station_at(rotor, at.omega, disk_.at[g].radius);
            const Lanes& weight = disk_.weight[g];
            Lanes v;
            for (int k = 0; k < width; ++k) v[k] = state[harmonics_first + std::min(g * width + k, nodes_ - 1)];
            const Dual<Lanes, 1> inflow{v, {broadcast(1.0)}};
            Loads<Dual<Lanes, 1>> uniform;
            if (around) uniform.thrust = annulus_thrust(rotor, station, s.flow, inflow, s.psi);
            else uniform = loads_of(rotor, station, turn_forces(rotor, station, s.flow, inflow, s.psi));
            const auto residual = uniform.thrust - wake_thrust(rotor, station.radius, s.flow, s.windmill, inflow);
            const Lanes least = 2.0 * pi * station.radius * square_root(speed_squared(at.v_inplane, at.v_axial + v));
            const Lanes slope = maximum(-residual.d[0], least), per_mass = 3.0 / (16.0 * radius * station.radius);
            const Lanes share = 1.0 - power_of_two(maximum(slope * per_mass * (-1.44269504088896340736 * time), broadcast(-100.0)));
            const Lanes most = 0.3 * speed_scale(of, station);
            Lanes step = residual.v / slope * share;
            step = step > most ? most : (step < -most ? -most : step);
            for (int k = 0; k < width && g * width + k < nodes_; ++k) {
                const int to = harmonics_first + g * width + k;
                if (rates) rates[to] = residual.v[k] * per_mass[k];
                if (later) later[to] = state[to] + step[k];
            }

            // Loads for the inflow blended with the vortex-ring inflow, with harmonics.
            const Lanes used = ring > 0.0 ? (1.0 - ring) * v + ring * ring_inflow : v;
            Loads<Lanes> loads;
            for (int k = 0; k < Loads<Lanes>::count; ++k) loads.begin()[k] = uniform.begin()[k].v;
            if (ring > 0.0) loads = loads_of(rotor, station, turn_forces(rotor, station, s.flow, used, s.psi));
            thrust_without += weight * loads.thrust;
            if (around) loads = loads_of(rotor, station, turn_forces(rotor, station, s.flow, used, s.psi, s.harmonics));
            const Loads<Lanes> friction = rotor.radial_friction && at.v_inplane > 0.0
                                              ? radial_friction(rotor, station, s.flow, used, for_friction) : Loads<Lanes>{};
            for (int k = 0; k < Loads<Lanes>::count; ++k)
                sums.begin()[k] += weight * (loads.begin()[k] + friction.begin()[k]);
            const Lanes part = weight * station.radius;
            area += part, through_area += part * used;
            by_mean += weight * uniform.thrust.d[0];
            by_gradient += 0.5 / radius * part * station.radius * uniform.thrust.d[0];
        }
        Loads<double> total;
        for (int k = 0; k < Loads<double>::count; ++k) total.begin()[k] = sum(sums.begin()[k]);
        s.mean = {at.omega, at.v_axial, at.v_inplane, sum(through_area) / sum(area)};
        s.result.ring = ring, s.result.mean_inflow = s.mean.inflow;
        s.result.loads = total;
        complete_loads(rotor, s.flow, s.mean.inflow, s.result.loads);
        solver_->set_status(s, false);

        // If stalled blades amplify a harmonic, the slope for its step excludes the contribution of the blades.
        const auto gains = harmonic_response(rotor.inflow_shape, s.mean, radius), response = gains.faded(1.0 - ring);
        const auto wanted = response.harmonics({total.thrust, total.roll_moment, -total.pitch_moment}, sum(thrust_without));
        const double target[3] = {wanted.mean, wanted.lateral, wanted.longitudinal};
        const double volume = radius * radius * radius, mass = 8.0 / 3.0 * volume, inertia = 16.0 / 45.0 * volume * radius;
        const double lag[3] = {mass * gains.mean_by_thrust, inertia * gains.by_roll, inertia * gains.by_rear};  // [s]
        const double slope = sum(by_gradient);
        const double by_itself[3] = {response.mean_by_thrust * sum(by_mean), response.by_roll * slope, response.by_rear * slope};
        const double least_harmonic = negligible * (at.omega * radius + s.mean.speed());
        double rate[3], next[3];
        for (int k = 0; k < 3; ++k) {
            // In edgewise flight without inflow, v_c has no time constant: it follows the loads immediately.
            const double per = 1.0 / std::max(lag[k], 1e-6), decay = 1.0 - std::min(by_itself[k], 0.0);
            const double missing = around ? target[k] - h[k] : 0.0;
            rate[k] = per * missing;
            next[k] = h[k] - missing / decay * std::expm1(-per * decay * time);
            if (std::fabs(next[k]) < least_harmonic) next[k] = 0.0;
        }
        if (rates) heading.in_rotor_frame(rate, rates);
        if (later) heading.in_rotor_frame(next, later);
        return s;
    }

  private:
    const RotorSolver<LawOf>* solver_;
    int nodes_;
    Disk disk_;  // the radii and weights of the nodes
};

}  // namespace propmap
