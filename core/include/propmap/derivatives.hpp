// Derivatives of the loads of a rotor by forward mode, through eq. (11), the harmonics and the edges of the panels.
//
// The dual numbers in a rotor and a flow define the directions of differentiation.  The root of (11), the folds and the
// harmonics are differentiated by the implicit function theorem at the solution; no search is repeated.
#pragma once

#include "rotor.hpp"

namespace propmap {

// Derivatives in one pass, few enough for the registers.  With 8, a pass for 4 derivatives takes 1.7 times as long.
inline constexpr int together = 5;
using Slope = Dual<double, together>;
using LaneSlope = Dual<Lanes, together>;

inline Slope sum(const LaneSlope& x) {  // over lanes
    Slope total{sum(x.v), {}};
    for (int k = 0; k < together; ++k) total.d[k] = sum(x.d[k]);
    return total;
}

// Radii and weights of the nodes, with derivatives, because nodes move with the edges of panels.
struct MovingNodes {
    std::vector<LaneSlope> radius, weight;

    MovingNodes(const Disk& disk, const std::array<Slope, most_folds + 2>& edge) : radius(disk.groups), weight(disk.groups) {
        disk.for_each_node([&](int node, int panel, const PanelRule& rule, int k) {
            const Slope length = edge[panel + 1] - edge[panel];
            const Slope y = edge[panel] + length * rule.place[k], w = length * (node < disk.nodes ? rule.weight[k] : 0.0);
            LaneSlope &r = radius[node / width], &wide = weight[node / width];
            const int lane = node % width;
            r.v[lane] = y.v, wide.v[lane] = w.v;
            for (int d = 0; d < together; ++d) r.d[d][lane] = y.d[d], wide.d[d][lane] = w.d[d];
        });
    }
};

// The residual at the inflow for which the mean angle of attack is the stall angle.
template <class R, class Y, class F> auto residual_at_stall(const R& rotor, const Y& radius, const F& flow, const Solution& s) {
    const auto at = station_at(rotor, flow.omega, radius);
    const auto turning = flow.omega * at.radius;
    const auto speed = square_root(turning * turning + 0.5 * (flow.v_inplane * flow.v_inplane));
    const double reynolds = value(at.reynolds_per_speed)[0] * value(flow.omega) * value(at.radius)[0];
    const auto phi = at.line - angle_from(broadcast(0.0) + rotor.law.stall_angle(reynolds, s.folds.side));
    const auto inflow = speed * sine(phi) / cosine(phi) - flow.v_axial;
    return annulus_thrust(rotor, at, flow, inflow, s.psi) - wake_thrust(rotor, at.radius, flow, s.windmill, inflow);
}

// The radius of an edge with its derivatives.  At a fold, the residual g and a second value C stay zero.  C is dg/dv_i
// at a top, and the second difference of g over v_i at a shoulder.
template <template <class> class LawOf>
Slope moving_radius(const RotorSolver<LawOf>& solver, const Solution& s, const Rotor<Slope, LawOf>& rotor, const Flow<Slope>& flow,
                    const Edge& edge) {
    Slope radius{edge.radius, {}};
    if (edge.kind == Edge::Kind::fixed) return radius;
    const Lanes y = broadcast(edge.radius);
    const Dual<Lanes, 1> moved{y, {broadcast(1.0)}};
    if (edge.kind == Edge::Kind::angle) {
        const LaneSlope g = residual_at_stall(rotor, y, flow, s);
        const Dual<Lanes, 1> along = residual_at_stall(solver.rotor(), moved, s.flow, s);
        for (int d = 0; d < together; ++d) radius.d[d] = -g.d[d][0] / along.d[0][0];
        return radius;
    }
    const auto of = solver.annuli(s);
    const bool top = edge.kind == Edge::Kind::top;
    const Lanes apart = each_lane([](int k) { return k == 0 ? 1.0 : k == 2 ? -1.0 : 0.0; }) * fold_spacing(of, top);
    const auto inflow_at = [&](const auto& radius, const auto& flow) {
        const auto turning = flow.omega * radius;
        return edge.inflow + apart * (square_root(turning * turning + flow.v_inplane * flow.v_inplane) + absolute(flow.v_axial));
    };
    const auto residual = [&](const auto& rotor, const auto& radius, const auto& flow) {
        const auto v = inflow_at(radius, flow);
        return annulus_thrust(rotor, station_at(rotor, flow.omega, radius), flow, v, s.psi) -
               wake_thrust(rotor, radius, flow, s.windmill, v);
    };
    const LaneSlope g = residual(rotor, y, flow);
    const Dual<Lanes, 1> along = residual(solver.rotor(), moved, s.flow);
    const Lanes slope = of.residual(of.station(y), inflow_at(y, s.flow)).d[0];
    const auto difference = [](Lanes x) { return x[0] - 2.0 * x[1] + x[2]; };
    const double g_v = top ? 0.0 : slope[1], c_v = top ? 1.0 : difference(slope);
    const double g_y = along.d[0][1], c_y = top ? 0.0 : difference(along.d[0]);
    const double determinant = g_v * c_y - g_y * c_v;
    const double per = determinant != 0.0 ? 1.0 / determinant : 0.0;
    for (int d = 0; d < together; ++d) {
        const double g_p = g.d[d][1], c_p = top ? 0.0 : difference(g.d[d]);
        radius.d[d] = per * (g_p * c_v - g_v * c_p);
    }
    return radius;
}

// The inflow at moving nodes, blended with the vortex-ring inflow, and its mean over the disk.
struct MovingInflow {
    std::vector<LaneSlope> at;
    Slope mean;
};
template <template <class> class LawOf>
MovingInflow moving_inflow(const RotorSolver<LawOf>& solver, const Solution& s, const Rotor<Slope, LawOf>& rotor,
                           const Flow<Slope>& flow, const MovingNodes& nodes, const Azimuths& psi) {
    MovingInflow inflow;
    const auto of = solver.annuli(s);
    const Slope ring = vortex_ring::weight(flow), ring_inflow = vortex_ring::inflow(flow);
    Slope area{}, through{};
    for (int g = 0; g < s.disk.groups; ++g) {
        const Lanes v = s.disk.inflow[g];
        const auto at = station_at(rotor, flow.omega, nodes.radius[g]);
        const LaneSlope change = annulus_thrust(rotor, at, flow, v, psi) - wake_thrust(rotor, nodes.radius[g], flow, s.windmill, v);
        const Lanes slope = of.residual(s.disk.at[g], v).d[0];
        LaneSlope moved{v, {}};
        for (int d = 0; d < together; ++d) moved.d[d] = slope == 0.0 ? Lanes{} : -change.d[d] / slope;
        inflow.at.push_back(value(ring) > 0.0 ? LaneSlope(moved * (1.0 - ring) + ring * ring_inflow) : moved);
        const LaneSlope part = nodes.weight[g] * nodes.radius[g];
        area += sum(part), through += sum(LaneSlope(part * inflow.at[g]));
    }
    inflow.mean = through / area;
    return inflow;
}

// Add the effect of the harmonics' derivatives to the `loads` of the blades; `without` is the thrust without harmonics.
template <template <class> class LawOf>
void add_moving_harmonics(const RotorSolver<LawOf>& solver, const Solution& s, const Rotor<Slope, LawOf>& rotor,
                          const Flow<Slope>& flow, const MovingInflow& inflow, const Azimuths& psi, const Slope& without,
                          Loads<Slope>& loads) {
    std::vector<Lanes> values;
    for (const auto& v : inflow.at) values.push_back(v.v);
    std::vector<double> integrand(2 * most_nodes);
    Loads<double> unused, by[3];
    solver.loads_and_slopes(s, psi, values, s.harmonics, unused, by, integrand.data());
    const double tip = solver.rotor().tip();
    const DiskFlow<Slope> mean{flow.omega, flow.v_axial, flow.v_inplane, inflow.mean};
    const auto response = harmonic_response(rotor.inflow_shape, mean, tip).faded(Slope(1.0 - vortex_ring::weight(flow)));
    const auto h = response.harmonics({loads.thrust, loads.roll_moment, Slope(-loads.pitch_moment)}, without);
    Slope wanted[3] = {h.mean, h.lateral, h.longitudinal};
    for (Slope& w : wanted) w.v = 0.0;
    const auto now = harmonic_response(rotor.inflow_shape, s.mean, tip).faded(1.0 - s.result.ring);
    const auto step = harmonics_step<Slope>(now, by, wanted);
    const Slope steps[3] = {step.mean, step.lateral, step.longitudinal};
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < Loads<Slope>::count; ++k) loads.begin()[k] += by[j].begin()[k] * steps[j];
}

// Derivatives of the loads [N], [N m] at the operating point whose solution is `s`.  In descent they require the solution
// `at_rest` for the same Omega: the static inflow depends on the rotor and on Omega, but not on the velocity.
template <template <class> class LawOf>
Loads<Slope> load_slopes(const RotorSolver<LawOf>& solver, const Solution& s, const Solution& at_rest,
                         const Rotor<Slope, LawOf>& rotor, Flow<Slope> flow) {
    if (s.flow.v_axial < 0.0) {
        const Slope thrust = load_slopes(solver, at_rest, at_rest, rotor, Flow<Slope>{flow.omega, Slope{}, Slope{}}).thrust;
        flow.v_hover = static_inflow(Slope(thrust * (1.0 / rotor.density)), rotor.tip());
    }
    // Derivatives with respect to in-plane velocity contain the mean of sin^2(psi), which requires several azimuths.
    const Azimuths psi = s.psi.count > 1 ? s.psi : azimuths(8);
    std::array<Slope, most_folds + 2> edge;
    for (int k = 0; k <= s.disk.panels; ++k) edge[k] = moving_radius(solver, s, rotor, flow, s.disk.edge[k]);
    const MovingNodes nodes(s.disk, edge);
    const auto inflow = moving_inflow(solver, s, rotor, flow, nodes, psi);
    const bool around = rotor.inflow_shape != InflowShape::uniform;
    Loads<Slope> total{};
    Slope without{};
    for (int g = 0; g < s.disk.groups; ++g) {
        const auto at = station_at(rotor, flow.omega, nodes.radius[g]);
        if (around) {
            total.add(loads_of(rotor, at, turn_forces(rotor, at, flow, inflow.at[g], psi, s.harmonics)), nodes.weight[g]);
            without += sum(LaneSlope(nodes.weight[g] * annulus_thrust(rotor, at, flow, inflow.at[g], psi)));
        } else {
            total.add(loads_of(rotor, at, turn_forces(rotor, at, flow, inflow.at[g], psi)), nodes.weight[g]);
        }
        if (rotor.radial_friction) total.add(radial_friction(rotor, at, flow, inflow.at[g], psi), nodes.weight[g]);
    }
    if (around) add_moving_harmonics(solver, s, rotor, flow, inflow, psi, without, total);
    complete_loads(rotor, flow, inflow.mean, total);
    // In axial flow, in-plane forces and moments about in-plane axes change only with the in-plane velocity.
    for (int d = 0; d < together && s.flow.v_inplane == 0.0; ++d)
        if (flow.v_inplane.d[d] == 0.0)
            for (Slope* load : {&total.drag, &total.roll_moment, &total.side_force, &total.pitch_moment}) load->d[d] = 0.0;
    return total;
}

}  // namespace propmap
