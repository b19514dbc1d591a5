// Fields over the disk at one operating point: inflow, angle of attack and loads.
#pragma once

#include "rotor.hpp"

namespace propmap {

// Fields at S radii [m] and P azimuths [rad].  Arrays (S, P) are stored row by row.
struct DiskField {
    std::vector<double> inflow;                  // v_i, mean over azimuth [m/s], (S)
    std::vector<double> thrust, drag, torque;    // per radius [N/m], [N/m], [N], (S)
    std::vector<double> local_inflow;            // with harmonics [m/s], (S, P)
    std::vector<double> alpha;                   // angle of attack from the chord line [rad]
    std::vector<double> past_stall;              // angle of attack minus stall angle [rad]; positive where stalled
    std::vector<double> u_tangential, u_normal;  // eqs. (1) and (2) [m/s]
    std::vector<double> normal_force;            // along the axis, per radius of one blade [N/m]
};

// Compute the fields at 1 to `most_nodes` radii [m], at the operating point whose solution is `s`.
template <template <class> class LawOf>
DiskField disk_field(const RotorSolver<LawOf>& solver, Solution& s, const std::vector<double>& radii,
                     const std::vector<double>& psi) {
    const auto& rotor = solver.rotor();
    const bool around = solver.has_harmonics(s);
    const auto& f = s.flow;
    if (f.v_inplane > 0.0) s.psi = azimuths(128);
    Disk disk;
    single_panel(disk, rotor.root(), rotor.tip(), int(radii.size()));
    disk.nodes = int(radii.size()), disk.groups = (disk.nodes + width - 1) / width;
    disk.at.resize(disk.groups), disk.inflow.resize(disk.groups);
    for (int g = 0; g < disk.groups; ++g)
        disk.at[g] = station_at(rotor, f.omega, each_lane([&](int k) {
            return radii[std::min<std::size_t>(g * width + k, radii.size() - 1)];
        }));
    solve_nodes(solver.annuli(s), disk, {});
    const double ring = vortex_ring::weight(f), ring_inflow = vortex_ring::inflow(f);
    DiskField field;
    for (int g = 0; g < disk.groups; ++g) {
        const auto& at = disk.at[g];
        const Lanes v = (1.0 - ring) * disk.inflow[g] + ring * ring_inflow;
        auto loads = around ? loads_of(rotor, at, turn_forces(rotor, at, f, v, s.psi, s.harmonics))
                            : loads_of(rotor, at, turn_forces(rotor, at, f, v, s.psi));
        if (rotor.radial_friction && f.v_inplane > 0.0) {
            const auto more = radial_friction(rotor, at, f, v, s.psi);
            loads.drag += more.drag, loads.torque += more.torque;
        }
        for (int k = 0; k < width && g * width + k < disk.nodes; ++k) {
            field.inflow.push_back(v[k] + s.harmonics.mean);
            field.thrust.push_back(rotor.density * loads.thrust[k]);
            field.drag.push_back(rotor.density * loads.drag[k]);
            field.torque.push_back(rotor.density * loads.torque[k]);
            const double y = at.radius[k], reynolds = at.reynolds_per_speed[k];
            const double zero_lift = value(rotor.law.zero_lift_angle_at(reynolds * f.omega * y));
            for (double azimuth : psi) {
                const double sine = std::sin(azimuth), share = y / rotor.tip();
                const double local = v[k] + s.harmonics.mean + share * (s.harmonics.lateral * sine +
                                                                        s.harmonics.longitudinal * std::cos(azimuth));
                const double u_t = f.omega * y + f.v_inplane * sine, u_p = f.v_axial + local;
                const double line_sine = at.line.sine[k], line_cosine = at.line.cosine[k];
                const double angle = std::atan2(line_sine * u_t - line_cosine * u_p, line_cosine * u_t + line_sine * u_p);
                const double side = angle < 0.0 ? -1.0 : 1.0;
                const double stall = value(rotor.law.stall_angle(reynolds * std::hypot(u_t, u_p), side));
                field.local_inflow.push_back(local);
                field.alpha.push_back(std::remainder(angle + zero_lift, 2.0 * pi));
                field.past_stall.push_back(side * (angle - stall));
                field.u_tangential.push_back(u_t), field.u_normal.push_back(u_p);
                const auto force = element_forces(rotor, at, f, broadcast(local), sine).normal;
                field.normal_force.push_back(rotor.density * force[k]);
            }
        }
    }
    return field;
}

// Thrust [N] of fully attached blades without drag: a fast first estimate.
template <class R> double attached_thrust(const R& rotor, const Flow<double>& flow) {
    const Annuli<R> of{rotor, flow, azimuths(1), azimuths(1), false};
    const int count = 12;
    double total = 0.0, before = 0.0;
    for (int first = 0; first < count; first += width) {
        const Lanes y = each_lane([&](int k) {
            return rotor.root() + (rotor.tip() - rotor.root()) * std::min(first + k, count - 1) / (count - 1.0);
        });
        const auto at = of.station(y);
        const Lanes dt = momentum_thrust(y, flow, attached_guess(of, at));
        for (int k = 0; k < width && first + k < count; ++k) {
            if (first + k > 0) total += 0.5 * (before + dt[k]);
            before = dt[k];
        }
    }
    return rotor.density * total * (rotor.tip() - rotor.root()) / (count - 1.0);
}

}  // namespace propmap
