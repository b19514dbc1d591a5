// Fields over the disk at one operating point: inflow, angle of attack and loads.
#pragma once

#include "rotor.hpp"

namespace propmap {

// Compute the fields over the disk at 1 to `most_nodes` radii [m] and azimuths `psi` [rad], from the solution `s`.  Each
// radius has 4 numbers in `mean`: v_i, mean over azimuth [m/s], and thrust, drag and torque per radius [N/m], [N/m], [N].
// Each azimuth has 6 numbers in `local`: v_i with harmonics [m/s]; angle of attack from the chord line, and angle past the
// stall angle, positive in stall of either sign [rad]; (1) and (2) [m/s]; and the axial force per radius of one blade [N/m].
template <template <class> class LawOf>
void disk_field(const RotorSolver<LawOf>& solver, Solution& s, const std::vector<double>& radii, const std::vector<double>& psi,
                double* mean, double* local) {
    const auto& rotor = solver.rotor();
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
        auto loads = loads_of(rotor, at, turn_forces(rotor, at, f, v, s.psi, s.harmonics));
        if (rotor.radial_friction && f.v_inplane > 0.0) {
            const auto more = radial_friction(rotor, at, f, v, s.psi);
            loads.drag += more.drag, loads.torque += more.torque;
        }
        const int lanes = std::min(width, disk.nodes - g * width);
        for (int k = 0; k < lanes; ++k)
            for (const Lanes& x : {Lanes(v + s.harmonics.mean), rotor.density * loads.thrust, rotor.density * loads.drag,
                                   rotor.density * loads.torque})
                *mean++ = x[k];
        const Lanes turning = f.omega * at.radius, share = at.radius / rotor.tip();
        const Lanes zero_lift = rotor.law.zero_lift_angle_at(at.reynolds_per_speed * turning) + Lanes{};
        for (std::size_t p = 0; p < psi.size(); ++p) {
            const double sine = std::sin(psi[p]);
            const double around_disk = s.harmonics.lateral * sine + s.harmonics.longitudinal * std::cos(psi[p]);
            const Lanes inflow = v + s.harmonics.mean + share * around_disk;
            const auto e = element_flow(at, f, inflow, sine);
            const Lanes angle = radians(e.section.alpha), normal = rotor.density * forces_in(rotor, at, e).normal;
            for (int k = 0; k < lanes; ++k) {
                const double side = angle[k] < 0.0 ? -1.0 : 1.0;
                const double stall = value(rotor.law.stall_angle(e.section.reynolds[k], side));
                const double found[] = {inflow[k], std::remainder(angle[k] + zero_lift[k], 2.0 * pi), side * (angle[k] - stall),
                                        e.u_t[k], e.u_p[k], normal[k]};
                std::copy_n(found, 6, local + 6 * (k * psi.size() + p));
            }
        }
        local += 6 * lanes * psi.size();
    }
}

// Thrust [N] of fully attached blades without drag: a fast first estimate.
template <class R> double attached_thrust(const R& rotor, const Flow<double>& flow) {
    const Annuli<R> of{rotor, flow, azimuths(1), azimuths(1), false};
    const int count = 12;
    double total = 0.0;
    for (int first = 0; first < count; first += width) {
        const Lanes y = each_lane([&](int k) {
            return rotor.root() + (rotor.tip() - rotor.root()) * std::min(first + k, count - 1) / (count - 1.0);
        });
        const Lanes dt = momentum_thrust(y, flow, attached_guess(of, of.station(y)));
        for (int k = 0; k < width && first + k < count; ++k) total += (first + k == 0 || first + k == count - 1 ? 0.5 : 1.0) * dt[k];
    }
    return rotor.density * total * (rotor.tip() - rotor.root()) / (count - 1.0);
}

}  // namespace propmap
