// Fields over the disk at one operating point: inflow, angle of attack and loads.
#pragma once

#include "rotor.hpp"

namespace propmap {

// Compute the fields over the disk at 1 to `most_nodes` radii [m] and azimuths `psi` [rad], from the solution `s`.  Each radius
// has 4 numbers in `mean`: v_i, mean over azimuth [m/s], and thrust, drag and torque per radius [N/m], [N/m], [N].  Each
// azimuth there has 6 numbers in `local`: v_i with harmonics [m/s]; the angle of attack from the chord line, and the same
// minus the stall angle [rad]; (1) and (2) [m/s]; and the axial force per radius of one blade [N/m].
template <template <class> class LawOf>
void disk_field(const RotorSolver<LawOf>& solver, Solution& s, const std::vector<double>& radii, const std::vector<double>& psi,
                double* mean, double* local) {
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
            *mean++ = v[k] + s.harmonics.mean;
            for (const Lanes& load : {loads.thrust, loads.drag, loads.torque}) *mean++ = rotor.density * load[k];
            const double y = at.radius[k], reynolds = at.reynolds_per_speed[k];
            const double zero_lift = value(rotor.law.zero_lift_angle_at(reynolds * f.omega * y));
            for (double azimuth : psi) {
                const double sine = std::sin(azimuth), share = y / rotor.tip();
                const double inflow = v[k] + s.harmonics.mean + share * (s.harmonics.lateral * sine +
                                                                         s.harmonics.longitudinal * std::cos(azimuth));
                const double u_t = f.omega * y + f.v_inplane * sine, u_p = f.v_axial + inflow;
                const double line_sine = at.line.sine[k], line_cosine = at.line.cosine[k];
                const double angle = std::atan2(line_sine * u_t - line_cosine * u_p, line_cosine * u_t + line_sine * u_p);
                const double side = angle < 0.0 ? -1.0 : 1.0;
                const double stall = value(rotor.law.stall_angle(reynolds * std::hypot(u_t, u_p), side));
                const auto force = element_forces(rotor, at, f, broadcast(inflow), sine).normal;
                for (double x : {inflow, std::remainder(angle + zero_lift, 2.0 * pi), side * (angle - stall), u_t, u_p, rotor.density * force[k]})
                    *local++ = x;
            }
        }
    }
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
