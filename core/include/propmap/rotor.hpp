// Loads of a rotor at any operating point, eqs. (13) to (15), with derivatives and a status.
//
// Eq. (11) is solved at nodes, the quadrature radii of one or more panels along the blade.  Panels follow stall if they
// meet at folds, the radii at which stall begins or ends (disk.hpp).  Harmonics: inflow that varies around the disk.
#pragma once

#include "disk.hpp"
#include "ground_effect.hpp"

namespace propmap {

// Numbers of nodes, and limits of the error estimate `tail`, determined with random section laws (docs/theory.md).
struct Accuracy {
    struct Share {
        double advance;  // up to this V sin(beta)/(Omega R)
        int azimuths;    // over a full turn
    };
    std::vector<Share> azimuths;
    int free, stalled, fast;  // radial nodes: if the blade does not stall, if panels follow stall, if they do not
    double largest_tail;      // relative to the static load; a point with a larger tail is evaluated again
    struct Finer {
        int nodes;
        double largest_tail;
    };
    std::vector<Finer> finer;  // further evaluations, in this order, until the tail is small enough

    static constexpr int counts[] = {8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384};  // of azimuths

    static int place_of(int count) {
        return int(std::lower_bound(std::begin(counts), std::end(counts), count) - std::begin(counts));
    }
    // The number of azimuths, in proportion to the sharpness of stall.  `times` counts the evaluations before this
    // one.  From times = 2 on, each evaluation uses the next larger number in `counts`.
    int azimuths_at(double advance, double sharper, int times) const {
        std::size_t k = 0;
        while (k + 1 < azimuths.size() && advance > azimuths[k].advance) ++k;
        const int wanted = int(std::ceil(azimuths[k].azimuths * std::max(sharper, 1.0) - 1e-6));
        return counts[std::min(place_of(wanted) + std::max(times - 1, 0), int(std::size(counts)) - 1)];
    }
};

// Errors: 0.1 % of static thrust and torque for `standard`, 0.01 % for `fine`.  With a tail limit of 0.028 instead of
// 0.022, one of 20,000 descents of a blade of steep pitch erred by 0.13 %.
inline const Accuracy standard_accuracy{
    {{0.03, 8}, {0.06, 12}, {0.12, 16}, {0.18, 24}, {0.3, 32}, {0.5, 64}, {1.0, 96}, {INFINITY, 128}},
    24, 48, 64, 0.022, {{80, 0.022}, {240, 0.05}, {960, 0.09}}};
inline const Accuracy fine_accuracy{
    {{0.1, 32}, {0.15, 48}, {0.3, 96}, {0.5, 192}, {1.0, 256}, {INFINITY, 384}},
    96, 160, 160, 0.004, {{320, 0.004}, {960, 0.01}}};

// Advance ratios.  Above `follow_below` (climb) and `follow_descent_below` (descent), the radius of stall varies over
// azimuth, and panels do not follow it.  Above `reversed_above`, reverse flow needs as many nodes as stall, and
// `solve_attached` is not tried.
inline constexpr double follow_below = 0.24, follow_descent_below = 0.45, reversed_above = 0.3;

// Above this speed [m/s], loads are NaN, because rounding of squared speeds removes all smaller terms.
inline constexpr double fastest_flow = 1e6;

// In order of severity: if several apply, the last one is returned.  The Python package sets `reversed`.
enum class Status : unsigned char { ok, multiple_roots, windmill, coarse, reversed, vortex_ring, not_converged };

struct Result {  // at an operating point
    Loads<double> loads;  // [N], [N m]
    Status status = Status::ok;
    int roots = 1;        // number of roots of (11): 1, or 3 if some node has several
    double ring = 0.0;    // weight of the vortex-ring inflow in the inflow used, 0 to 1
    double mean_inflow = 0.0;  // over the area of the disk [m/s]
    double blade_drag = 0.0;  // drag [N] of the bare blades, without `drag_factor` and mount
};

// Longest last Newton step of the harmonics, relative to tip speed plus air speed.  The loads are corrected for this
// step to first order; the error, of second order, is at most 3e-8 of the static loads.
inline constexpr double harmonics_close = 2e-5;

// Sum over lanes.
inline double sum(Lanes x) {
    double total = 0.0;
    for (int k = 0; k < width; ++k) total += x[k];
    return total;
}
template <int N> Dual<double, N> sum(const Dual<Lanes, N>& x) {
    Dual<double, N> total{sum(x.v), {}};
    for (int k = 0; k < N; ++k) total.d[k] = sum(x.d[k]);
    return total;
}

// Convert the blades' loads per density to the rotor's loads [N], [N m]: apply mount, ground, ceiling and density.
template <class R, class S> void complete_loads(const R& rotor, const Flow<S>& flow, const S& mean_inflow, Loads<S>& loads) {
    if (rotor.installed) loads.drag = rotor.drag_factor * loads.drag + mount_drag(rotor, flow, mean_inflow);
    loads.thrust = loads.thrust * ground_effect(rotor.tip(), flow, mean_inflow);
    loads.thrust = loads.thrust * ceiling_effect(rotor.tip(), flow, mean_inflow);
    for (int k = 0; k < Loads<S>::count; ++k) loads.begin()[k] = loads.begin()[k] * rotor.density;
}

// The solution at an operating point, stored for derivatives and fields.
struct Solution {
    Flow<double> flow{};
    Disk disk;
    Folds folds;
    std::vector<bool> near_stall;  // for each run of nodes (disk.hpp): whether one is near stall
    Azimuths psi;  // over which (5) to (7) are averaged
    bool windmill = false;  // whether (11) has the windmill branch
    Harmonics<double> harmonics{};
    Loads<double> by[3];  // derivatives of loads per density with respect to the harmonics, if there are any
    DiskFlow<double> mean;
    Loads<double> blade_loads;  // per density, without mount, ground and ceiling
    double thrust_tail = 0.0, torque_tail = 0.0;  // size of the last Legendre coefficients, see `tail`
    Result result;
};

// Newton step of the harmonics toward harmonics = response(loads), by Cramer's rule.  `wanted` is the right-hand side
// minus the left-hand side, `by` the derivatives of the loads with respect to the harmonics.
template <class S>
Harmonics<S> harmonics_step(const HarmonicResponse<double>& r, const Loads<double> (&by)[3], const S (&wanted)[3]) {
    double m[3][3];
    for (int k = 0; k < 3; ++k) {
        m[0][k] = (k == 0) - r.mean_by_thrust * by[k].thrust;
        m[1][k] = (k == 1) - r.by_roll * by[k].roll_moment;
        m[2][k] = (k == 2) - r.by_thrust * by[k].thrust + r.by_rear * by[k].pitch_moment;
    }
    const auto minor = [&](int i, int j) {
        const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
        return m[a][c] * m[b][d] - m[a][d] * m[b][c];
    };
    double determinant = 0.0;
    for (int j = 0; j < 3; ++j) determinant += m[0][j] * minor(0, j);
    const double per = 1.0 / (determinant == 0.0 ? 1e-30 : determinant);
    const auto solved = [&](int j) {
        return S(per * (minor(0, j) * wanted[0] + minor(1, j) * wanted[1] + minor(2, j) * wanted[2]));
    };
    return {solved(0), solved(1), solved(2)};
}

// Solver for the loads of a rotor at any operating point, with a given accuracy.
template <template <class> class LawOf> class RotorSolver {
  public:
    using Plain = Rotor<double, LawOf>;

    RotorSolver(Plain rotor, const Accuracy& accuracy) : rotor_(std::move(rotor)), accuracy_(accuracy) {
        // Static loads over Omega^2, by which tails are divided.  They are small if the blade stalls at rest: mean
        // coefficients of at least 0.1 (lift) and 0.01 (force against the rotation) are assumed.
        const double omega = 100.0 / rotor_.tip();
        Solution at_rest;
        at_rest.flow = {omega, 0.0, 0.0};
        at_rest.psi = azimuths(1);
        single_panel(at_rest.disk, rotor_.root(), rotor_.tip(), 24);
        place_nodes(rotor_, omega, at_rest.disk);
        solve_nodes(annuli(at_rest), at_rest.disk, nullptr, false);
        find_loads(at_rest);
        double force = 0.0;
        const auto& y = rotor_.blade->station;
        const auto chord = [&](std::size_t k) {
            return k + 1 < y.size() ? rotor_.blade->intervals[k].chord[0]
                                    : [](const double* c) { return c[0] + c[1] + c[2] + c[3]; }(rotor_.blade->intervals.back().chord);
        };
        for (std::size_t k = 0; k + 1 < y.size(); ++k)
            force += 0.5 * (y[k + 1] - y[k]) * (chord(k) * y[k] * y[k] + chord(k + 1) * y[k + 1] * y[k + 1]);
        force *= 0.5 * rotor_.density * rotor_.blade->blades;
        const auto& loads = at_rest.result.loads;
        static_thrust_ = std::max(std::fabs(loads.thrust) / (omega * omega), 0.1 * force);
        static_torque_ = std::max(std::fabs(loads.torque) / (omega * omega), 0.01 * force * rotor_.tip());
        if (!(static_thrust_ > 0.0)) static_thrust_ = 0.1 * force;
        if (!(static_torque_ > 0.0)) static_torque_ = 0.01 * force * rotor_.tip();
    }

    const Plain& rotor() const { return rotor_; }

    // Set the flow, with the static inflow in descent, the branch of momentum theory and the azimuths.
    void prepare(const Flow<double>& at, Solution& s) const {
        s.flow = at;
        s.flow.v_hover = at.v_axial < 0.0 ? hover_inflow(at.omega) : 0.0;
        s.result = Result{};
        s.harmonics = {};
        s.windmill = vortex_ring::windmill(s.flow);
        s.psi = azimuths(at.v_inplane == 0.0 ? 1 : accuracy_.azimuths_at(advance_ratio(at), sharpness(), 0));
    }
    double advance_ratio(const Flow<double>& at) const {  // V sin(beta)/(Omega R)
        return at.v_inplane == 0.0 ? 0.0 : at.v_inplane / (at.omega * rotor_.tip());
    }
    double sharpness() const { return 0.02 / rotor_.law.stall_width(); }  // of stall, relative to the paper's

    // Solve an operating point.
    void solve(const Flow<double>& at, Solution& s) const {
        const double fastest = std::max({at.omega * rotor_.tip(), std::fabs(at.v_axial), at.v_inplane});
        const bool at_rest = fastest <= speed_floor;
        if (at_rest || !(fastest < fastest_flow)) {
            const double inflow = at_rest ? 0.0 : std::nan("");
            s.flow = at, s.flow.v_hover = 0.0;
            s.result = Result{};
            s.harmonics = {};
            s.psi = azimuths(1);
            single_panel(s.disk, rotor_.root(), rotor_.tip(), accuracy_.free);
            place_nodes(rotor_, 0.0, s.disk);
            std::fill(s.disk.inflow.begin(), s.disk.inflow.end(), broadcast(inflow));
            s.disk.several = s.windmill = false;
            // A trace of axial flow gives the wake of a rotor at rest a direction.
            s.mean = {at.omega, inflow + 1e3 * speed_floor, 0.0, inflow};
            s.result.loads.thrust = inflow;
            set_status(s, false);
            return;
        }
        prepare(at, s);
        const double advance = advance_ratio(at), sharper = sharpness();
        const bool axial = at.v_inplane == 0.0;
        const bool follow = advance <= (at.v_axial < 0.0 ? follow_descent_below : follow_below);
        if (!attached_at(s, accuracy_.free)) solve_stalled(s, follow ? accuracy_.stalled : 0);
        find_loads(s);
        const double squared = sharper > 1.0 + 1e-9 ? sharper * sharper : 1.0;  // a sharper stall needs lower limits
        double limit = accuracy_.largest_tail / squared;
        for (std::size_t times = 0; times < accuracy_.finer.size() && tail_share(s) > limit; ++times) {
            s.psi = azimuths(axial ? 1 : accuracy_.azimuths_at(advance, sharper, int(times) + 1));
            start_at(s, accuracy_.free);
            solve_stalled(s, accuracy_.finer[times].nodes);
            find_loads(s);
            const bool last = times + 1 == accuracy_.finer.size();
            limit = last ? accuracy_.finer[times].largest_tail : accuracy_.finer[times].largest_tail / squared;
        }
        const double last_limit = accuracy_.finer.back().largest_tail;
        set_status(s, tail_share(s) > last_limit);
    }

    // Solve an operating point at `count` nodes of a single panel, whether the blade stalls or not.
    void solve_at_nodes(const Flow<double>& at, int count, Solution& s) const {
        prepare(at, s);
        if (!attached_at(s, count)) {
            const auto of = annuli(s);
            find_folds(of, s.disk, s.near_stall, false, s.folds, s.disk.several);
            solve_nodes(of, s.disk, &s.folds, false);
        }
        find_loads(s);
        set_status(s, false);
    }

    // Place the nodes of a single panel.
    void start_at(Solution& s, int count) const {
        single_panel(s.disk, rotor_.root(), rotor_.tip(), count);
        place_nodes(rotor_, s.flow.omega, s.disk);
        s.near_stall.assign(s.disk.runs(), true);
        s.disk.several = false;
    }

    // Solve (11) at the nodes of a single panel, and return whether flow is attached there.
    bool attached_at(Solution& s, int count) const {
        start_at(s, count);
        if (advance_ratio(s.flow) <= reversed_above && solve_attached(annuli(s), s.disk, s.near_stall)) return true;
        s.disk.several = false;
        return false;
    }

    // Solve (11) if the blade may stall: on `following` nodes in panels that follow stall or, if it is 0, on one panel.
    void solve_stalled(Solution& s, int following) const {
        const auto of = annuli(s);
        find_folds(of, s.disk, s.near_stall, following > 0, s.folds, s.disk.several);
        if (following) make_panels(s.folds, rotor_.root(), rotor_.tip(), following, s.disk);
        else single_panel(s.disk, rotor_.root(), rotor_.tip(), accuracy_.fast);
        place_nodes(rotor_, s.flow.omega, s.disk);
        solve_nodes(of, s.disk, &s.folds, following > 0);
    }

    // The larger of the tails of thrust and torque, relative to the static load at Omega or, if larger, at V/R.
    double tail_share(const Solution& s) const {
        const auto& f = s.flow;
        const double wind = (f.v_axial * f.v_axial + f.v_inplane * f.v_inplane) / (rotor_.tip() * rotor_.tip());
        const double square = std::max(f.omega * f.omega, wind);
        return std::max(s.thrust_tail / static_thrust_, s.torque_tail / static_torque_) / square;
    }

    // Static inflow v_i0 [m/s], eq. (12).
    double hover_inflow(double omega) const {
        Solution still;
        solve({omega, 0.0, 0.0}, still);
        return static_inflow(still.result.loads.thrust / rotor_.density, rotor_.tip());
    }

    // Eq. (11) at this point.  The set `few` has a quarter of the azimuths, but at least 8.
    Annuli<Plain> annuli(const Solution& s) const {
        const Azimuths few = s.psi.count > 4 ? azimuths(std::max(8, 2 * (s.psi.count / 4))) : s.psi;
        return {rotor_, s.flow, s.psi, few, s.windmill};
    }

    // Derivatives of the loads [N], [N m] along the N directions that the dual numbers in `rotor` and `flow` define.
    template <int N>
    Loads<Dual<double, N>> slopes(const Solution& s, const Rotor<Dual<double, N>, LawOf>& rotor,
                                  Flow<Dual<double, N>> flow) const {
        using S = Dual<double, N>;
        using T = Dual<Lanes, N>;
        if (s.flow.v_axial < 0.0) {
            // The static inflow depends on the rotor and on Omega, but not on the velocity.
            Solution still;
            solve({s.flow.omega, 0.0, 0.0}, still);
            const S zero{};
            const auto at_rest = slopes<N>(still, rotor, Flow<S>{flow.omega, zero, zero});
            flow.v_hover = static_inflow(S(at_rest.thrust * (1.0 / rotor_.density)), rotor_.tip());
        }
        // Derivatives with respect to in-plane velocity contain the mean of sin^2(psi), which needs several azimuths.
        const Azimuths psi = s.psi.count > 1 ? s.psi : azimuths(8);
        const auto of = annuli(s);
        std::array<S, most_edges + 2> edge;
        for (int k = 0; k <= s.disk.panels; ++k) {
            edge[k] = S{s.disk.edge[k], {}};
            if (s.disk.moves[k]) follow_fold(of, s, rotor, flow, s.disk.fold[k], edge[k]);
        }
        // Derivatives of the inflow by the implicit function theorem.
        const int groups = s.disk.groups;
        std::vector<T> inflow(groups);
        const MovingNodes<S> nodes(s.disk, edge);
        const S ring = vortex_ring::weight(flow), ring_inflow = vortex_ring::inflow(flow);
        S area{}, through{};
        for (int g = 0; g < groups; ++g) {
            const Lanes v = s.disk.inflow[g];
            const auto at = station_at(rotor, flow.omega, nodes.radius[g]);
            const T change = annulus_thrust(rotor, at, flow, v, psi) -
                             wake_thrust(rotor, nodes.radius[g], flow, s.windmill, v);
            const Lanes slope = of.residual(s.disk.at[g], v).d[0];
            T moved{v, {}};
            for (int d = 0; d < N; ++d) moved.d[d] = slope == 0.0 ? Lanes{} : -change.d[d] / slope;
            inflow[g] = value(ring) > 0.0 ? T(moved * (1.0 - ring) + ring * ring_inflow) : moved;
            const T part = nodes.weight[g] * nodes.radius[g];
            area += sum(part), through += sum(T(part * inflow[g]));
        }
        const S mean_inflow = through / area;
        Loads<S> total{};
        Loads<double> unused, by[3];
        const bool around = rotor_.inflow_shape != InflowShape::uniform;
        if (around) {
            std::vector<Lanes> plain(groups);
            for (int g = 0; g < groups; ++g) plain[g] = inflow[g].v;
            std::vector<double> integrand(2 * most_nodes);
            loads_and_slopes(s, psi, plain, s.harmonics, unused, by, integrand.data());
        }
        S without{};
        for (int g = 0; g < groups; ++g) {
            const auto at = station_at(rotor, flow.omega, nodes.radius[g]);
            const auto add_up = [&](const auto& per_radius) {
                for (int k = 0; k < Loads<S>::count; ++k)
                    total.begin()[k] += sum(T(nodes.weight[g] * per_radius.begin()[k]));
            };
            if (around) {
                add_up(loads_of(rotor, at, turn_forces(rotor, at, flow, inflow[g], psi, s.harmonics)));
                without += sum(T(nodes.weight[g] * annulus_thrust(rotor, at, flow, inflow[g], psi)));
            } else {
                add_up(loads_of(rotor, at, turn_forces(rotor, at, flow, inflow[g], psi)));
            }
            if (rotor_.radial_friction) add_up(radial_friction(rotor, at, flow, inflow[g], psi));
        }
        if (around) {
            const DiskFlow<S> mean{flow.omega, flow.v_axial, flow.v_inplane, mean_inflow};
            auto response = faded(harmonic_response(rotor.inflow_shape, mean, rotor_.tip()), S(1.0 - ring));
            const auto h = response.harmonics({total.thrust, total.roll_moment, S(-total.pitch_moment)}, without);
            S wanted[3] = {h.mean, h.lateral, h.longitudinal};
            for (S& w : wanted) w.v = 0.0;
            const auto plain = faded(harmonic_response(rotor_.inflow_shape, s.mean, rotor_.tip()), 1.0 - s.result.ring);
            const auto step = harmonics_step<S>(plain, by, wanted);
            const S steps[3] = {step.mean, step.lateral, step.longitudinal};
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < Loads<S>::count; ++k) total.begin()[k] += by[j].begin()[k] * steps[j];
        }
        complete_loads(rotor, flow, mean_inflow, total);
        // In axial flow, in-plane forces and moments about in-plane axes change only with the in-plane velocity.
        for (int d = 0; d < N && s.flow.v_inplane == 0.0; ++d)
            if (flow.v_inplane.d[d] == 0.0)
                for (S* load : {&total.drag, &total.roll_moment, &total.side_force, &total.pitch_moment}) load->d[d] = 0.0;
        return total;
    }

    // Derivatives of the radius of a fold, by the implicit function theorem.  Two values stay zero there: the residual
    // g, and C, which is dg/dv_i at a top and the second difference of g over v_i at a shoulder.
    template <int N>
    void follow_fold(const Annuli<Plain>& of, const Solution& s, const Rotor<Dual<double, N>, LawOf>& rotor,
                     const Flow<Dual<double, N>>& flow, const Fold& fold, Dual<double, N>& radius) const {
        const Lanes y = broadcast(fold.radius);
        const Dual<Lanes, 1> moved{y, {broadcast(1.0)}};
        const auto at = station_at(rotor, flow.omega, y);
        const auto beside = station_at(rotor_, s.flow.omega, moved);
        if (fold.kind == Fold::Kind::angle) {
            const Dual<Lanes, N> g = residual_at_stall(rotor, at, flow, s.psi, s.windmill, fold.side);
            const Dual<Lanes, 1> along = residual_at_stall(rotor_, beside, s.flow, s.psi, s.windmill, fold.side);
            for (int d = 0; d < N; ++d) radius.d[d] = -g.d[d][0] / along.d[0][0];
            return;
        }
        const bool top = fold.kind == Fold::Kind::top;
        const auto wide = fold_width(of, flow, fold.radius, top);
        const Lanes apart = each_lane([](int k) { return k == 0 ? 1.0 : k == 2 ? -1.0 : 0.0; });
        const auto v = fold.inflow + apart * wide;
        const Dual<Lanes, N> g = annulus_thrust(rotor, at, flow, v, s.psi) - wake_thrust(rotor, y, flow, s.windmill, v);
        const auto wider = fold.inflow + apart * fold_width(of, s.flow, moved, top);
        const Dual<Lanes, 1> along = annulus_thrust(rotor_, beside, s.flow, wider, s.psi) -
                                     wake_thrust(rotor_, moved, s.flow, s.windmill, wider);
        const Lanes slope = of.residual(of.station(y), v.v).d[0];
        const auto difference = [](Lanes x) { return x[0] - 2.0 * x[1] + x[2]; };
        const double g_v = top ? 0.0 : slope[1], c_v = top ? 1.0 : difference(slope);
        const double g_y = along.d[0][1], c_y = top ? 0.0 : difference(along.d[0]);
        const double determinant = g_v * c_y - g_y * c_v;
        const double per = determinant != 0.0 ? 1.0 / determinant : 0.0;
        for (int d = 0; d < N; ++d) {
            const double g_p = g.d[d][1], c_p = top ? 0.0 : difference(g.d[d]);
            radius.d[d] = per * (g_p * c_v - g_v * c_p);
        }
    }

    bool has_harmonics(const Solution& s) const {  // whether the inflow varies around the disk
        return rotor_.inflow_shape != InflowShape::uniform && s.flow.v_inplane > 0.0;
    }

    // The response with its gains multiplied by `share`: harmonics fade out within the vortex ring.
    template <class S> static HarmonicResponse<S> faded(HarmonicResponse<S> r, const S& share) {
        for (S* part : {&r.mean_by_thrust, &r.lateral, &r.longitudinal, &r.by_thrust, &r.by_roll, &r.by_rear})
            *part = *part * share;
        return r;
    }

    // Loads per density with harmonics, their derivatives with respect to the harmonics, and the integrand for `tail`.
    void loads_and_slopes(const Solution& s, const Azimuths& psi, const std::vector<Lanes>& inflow, const Harmonics<double>& h,
                          Loads<double>& loads, Loads<double> (&by)[3], double* integrand) const {
        loads = {}, by[0] = {}, by[1] = {}, by[2] = {};
        for (int g = 0; g < s.disk.groups; ++g) {
            const auto& at = s.disk.at[g];
            const Lanes& weight = s.disk.weight[g];
            const auto turn = turn_slopes(rotor_, at, s.flow, inflow[g], psi, h);
            const Lanes share = weight * (at.radius * (1.0 / rotor_.tip()));
            const auto here = loads_of(rotor_, at, turn.forces);
            const auto add_up = [&](Loads<double>& into, const Loads<Lanes>& part, Lanes by) {
                for (int k = 0; k < Loads<double>::count; ++k) into.begin()[k] += sum(by * part.begin()[k]);
            };
            add_up(loads, here, weight);
            add_up(by[0], loads_of(rotor_, at, turn.by_mean), weight);
            add_up(by[1], loads_of(rotor_, at, turn.by_sine), share);
            add_up(by[2], loads_of(rotor_, at, turn.by_cosine), share);
            keep_integrand(s, g, weight, here, integrand);
        }
    }

    // Compute the loads of a disk whose inflow and harmonics are known.
    void find_loads_at(Solution& s, bool around) const {
        thread_local std::vector<Lanes> inflow;
        thread_local std::vector<double> integrand(2 * most_nodes);
        blend(s, inflow);
        Loads<double> total{};
        if (around) loads_and_slopes(s, s.psi, inflow, s.harmonics, total, s.by, integrand.data());
        add_loads(s, inflow, around, total, integrand.data());
    }

    void set_status(Solution& s, bool coarse) const {  // set the status and the number of roots
        Result& r = s.result;
        const auto& f = s.flow;
        r.roots = s.disk.several ? 3 : 1;
        const auto turn = turning_points(f.v_axial, f.v_inplane);
        const bool mirrored = s.windmill && r.mean_inflow > turn.first && turn.second > turn.first;
        r.status = Status::ok;
        if (r.roots > 1) r.status = Status::multiple_roots;
        if (f.v_axial < 0.0 && f.v_axial + 2.0 * r.mean_inflow <= 0.0) r.status = Status::windmill;
        if (coarse) r.status = Status::coarse;
        if (r.ring > 0.0 || mirrored) r.status = Status::vortex_ring;
        if (!std::isfinite(r.loads.thrust)) {
            r.status = Status::not_converged;
            for (int k = 0; k < Loads<double>::count; ++k) r.loads.begin()[k] = std::nan("");
        }
    }

  private:
    static void keep_integrand(const Solution& s, int g, Lanes weight, const Loads<Lanes>& per_radius, double* into) {
        for (int k = 0; k < width && g * width + k < s.disk.nodes; ++k) {
            into[g * width + k] = weight[k] * per_radius.thrust[k];
            into[most_nodes + g * width + k] = weight[k] * per_radius.torque[k];
        }
    }

    // The tail: the size of the last Legendre coefficients of the integrand on all panels.  It is an error estimate,
    // because these coefficients are large if a panel has a kink or step that the nodes do not resolve.
    double tail(const Solution& s, const double* values) const {
        double total = 0.0;
        int first = 0;
        for (int p = 0; p < s.disk.panels; ++p) {
            const int n = s.disk.count[p];
            const PanelRule& rule = panel_rule(n, s.disk.panels > 1);
            for (int j = 0; j < PanelRule::tail; ++j) {
                double c = 0.0;
                for (int k = 0; k < n; ++k) c += rule.last[std::size_t(j) * n + k] * values[first + k];
                total += c * c;
            }
            first += n;
        }
        return std::sqrt(total);
    }

    // Compute the loads of a disk whose inflow is known.
    void find_loads(Solution& s) const {
        thread_local std::vector<Lanes> inflow;
        thread_local std::vector<double> integrand(2 * most_nodes);
        blend(s, inflow);
        Loads<double> total{};
        if (has_harmonics(s)) total = find_harmonics(s, inflow, s.result.ring, integrand.data());
        add_loads(s, inflow, has_harmonics(s), total, integrand.data());
    }

    // Compute the inflow of the annuli, blended with the vortex-ring inflow [m/s], and the mean flow.
    void blend(Solution& s, std::vector<Lanes>& inflow) const {
        const int groups = s.disk.groups;
        inflow.resize(groups);
        const double ring = vortex_ring::weight(s.flow), ring_inflow = vortex_ring::inflow(s.flow);
        double area = 0.0, through = 0.0;
        for (int g = 0; g < groups; ++g) {
            const Lanes v = s.disk.inflow[g];
            inflow[g] = ring > 0.0 ? (1.0 - ring) * v + ring * ring_inflow : v;
            const Lanes part = s.disk.weight[g] * s.disk.at[g].radius;
            area += sum(part), through += sum(part * inflow[g]);
        }
        s.mean = {s.flow.omega, s.flow.v_axial, s.flow.v_inplane, through / area};
        s.result.ring = ring, s.result.mean_inflow = s.mean.inflow;
    }

    // Complete the loads.  `total` contains the loads with harmonics if the inflow varies around the disk.
    void add_loads(Solution& s, const std::vector<Lanes>& inflow, bool around, Loads<double> total, double* integrand) const {
        for (int g = 0; g < s.disk.groups; ++g) {
            if (around && !rotor_.radial_friction) break;
            const auto& at = s.disk.at[g];
            const Lanes& weight = s.disk.weight[g];
            const auto add_up = [&](const Loads<Lanes>& per_radius) {
                for (int k = 0; k < Loads<double>::count; ++k)
                    total.begin()[k] += sum(weight * per_radius.begin()[k]);
            };
            if (!around) {
                const auto per_radius = loads_of(rotor_, at, turn_forces(rotor_, at, s.flow, inflow[g], s.psi));
                add_up(per_radius);
                keep_integrand(s, g, weight, per_radius, integrand);
            }
            if (rotor_.radial_friction && s.flow.v_inplane > 0.0)
                add_up(radial_friction(rotor_, at, s.flow, inflow[g], s.psi));
        }
        s.blade_loads = total;
        s.result.blade_drag = rotor_.density * total.drag;
        complete_loads(rotor_, s.flow, s.mean.inflow, total);
        s.result.loads = total;
        s.thrust_tail = rotor_.density * tail(s, integrand);
        s.torque_tail = rotor_.density * tail(s, integrand + most_nodes);
    }

    // Solve for the harmonics and the loads, which depend on each other: three equations, Newton's method from zero,
    // first over few azimuths.  Usually the next step, over all azimuths, is the last one (see `harmonics_close`).
    Loads<double> find_harmonics(Solution& s, const std::vector<Lanes>& inflow, double ring, double* integrand) const {
        const auto response = faded(harmonic_response(rotor_.inflow_shape, s.mean, rotor_.tip()), 1.0 - ring);
        const double speed = s.flow.omega * rotor_.tip() + s.mean.speed();
        Loads<double> loads{}, by[3];
        Harmonics<double> h{};
        double size = INFINITY;
        const auto step_to = [&](double without) {
            const auto asked = response.harmonics({loads.thrust, loads.roll_moment, -loads.pitch_moment}, without);
            const double wanted[3] = {asked.mean - h.mean, asked.lateral - h.lateral,
                                      asked.longitudinal - h.longitudinal};
            const auto by_step = harmonics_step<double>(response, by, wanted);
            double change[3] = {by_step.mean, by_step.lateral, by_step.longitudinal};
            size = std::max({std::fabs(change[0]), std::fabs(change[1]), std::fabs(change[2])}) / speed;
            const double share = std::min(1.0, 0.05 / std::max(size, 1e-30));  // limit steps to 5 % of `speed`
            for (double& c : change) c *= share;
            h = {h.mean + change[0], h.lateral + change[1], h.longitudinal + change[2]};
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < Loads<double>::count; ++k) loads.begin()[k] += change[j] * by[j].begin()[k];
        };
        const Azimuths few = annuli(s).few;
        without_harmonics(s, ring > 0.0 ? s.psi : few, inflow, loads, by);
        double without = loads.thrust;
        step_to(without);
        for (int step = 0; step < 3 && size > 1e-3; ++step) {
            loads_and_slopes(s, few, inflow, h, loads, by, integrand);
            step_to(without);
        }
        // By (11), the blades' thrust without harmonics equals the momentum thrust, except within the vortex ring.
        if (!(ring > 0.0)) without = wake_thrust_of(s);
        size = INFINITY;
        for (int step = 0; step < 40 && size > harmonics_close; ++step) {
            loads_and_slopes(s, s.psi, inflow, h, loads, by, integrand);
            step_to(without);
            if (!std::isfinite(size)) break;
        }
        s.harmonics = h;
        std::copy(std::begin(by), std::end(by), s.by);
        if (!(size <= harmonics_close))
            for (int k = 0; k < Loads<double>::count; ++k) loads.begin()[k] = std::nan("");
        return loads;
    }

    double wake_thrust_of(const Solution& s) const {  // momentum thrust of the disk per density
        double total = 0.0;
        for (int g = 0; g < s.disk.groups; ++g)
            total += sum(s.disk.weight[g] * wake_thrust(rotor_, s.disk.at[g].radius, s.flow, s.windmill, s.disk.inflow[g]));
        return total;
    }

    // Loads per density without harmonics, and the derivatives that the first step needs.
    [[gnu::flatten]] void without_harmonics(const Solution& s, const Azimuths& psi, const std::vector<Lanes>& inflow, Loads<double>& loads,
                           Loads<double> (&by)[3]) const {
        loads = {}, by[0] = {}, by[1] = {}, by[2] = {};
        for (int g = 0; g < s.disk.groups; ++g) {
            const auto& at = s.disk.at[g];
            const Lanes& weight = s.disk.weight[g];
            Lanes mean{}, sine{}, slope{}, slope_sine{}, slope_square{};
            const auto flow_at = [&](int k) {
                return element_flow(at, s.flow, Dual<Lanes, 1>{inflow[g], {broadcast(1.0)}}, psi.sine[k]);
            };
            auto next = flow_at(0);
            for (int k = 0; k < psi.count; ++k) {
                const auto here = next;
                if (k + 1 < psi.count) next = flow_at(k + 1);
                const auto f = forces_in(rotor_, at, here).normal;
                const double x = psi.sine[k];
                mean += f.v, sine += f.v * x, slope += f.d[0], slope_sine += f.d[0] * x, slope_square += f.d[0] * (x * x);
            }
            const Lanes part = weight * (rotor_.blade->blades / double(psi.count));
            const Lanes arm = part * at.radius, share = at.radius * (1.0 / rotor_.tip());
            loads.thrust += sum(part * mean), loads.roll_moment += sum(arm * sine);
            by[0].thrust += sum(part * slope), by[0].roll_moment += sum(arm * slope_sine);
            by[1].thrust += sum(part * share * slope_sine), by[1].roll_moment += sum(arm * share * slope_square);
            by[2].pitch_moment -= sum(arm * share * (slope - slope_square));  // cos^2 = 1 - sin^2
        }
    }

    Plain rotor_;
    Accuracy accuracy_;
    double static_thrust_ = 1.0, static_torque_ = 1.0;
};

}  // namespace propmap
