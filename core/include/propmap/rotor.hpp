// Loads of a rotor at any operating point, eqs. (13) to (15), with a status.
//
// Eq. (11) is solved at nodes, the quadrature radii of one or more panels along the blade.  Panels follow stall if they
// meet at folds, the radii at which stall begins or ends (disk.hpp).  Harmonics describe how inflow varies with azimuth.
#pragma once

#include "disk.hpp"
#include "ground_effect.hpp"

namespace propmap {

// Advance ratios.  Above `follow_below` (climb) and `follow_descent_below` (descent), the radius of stall varies over
// azimuth, and panels do not follow it.  Above `reversed_above`, `solve_attached` is not tried, because its proof fails in
// reverse flow.
inline constexpr double follow_below = 0.24, follow_descent_below = 0.45, reversed_above = 0.3;

// Above this speed [m/s], loads are NaN, because rounding of squared speeds removes all smaller terms.
inline constexpr double fastest_flow = 1e6;

// Statuses by increasing severity; if several apply, the solver returns the last.  The Python package sets `reversed`.
enum class Status : unsigned char { ok, multiple_roots, windmill, coarse, reversed, vortex_ring, not_converged };

struct Result {  // at an operating point
    Loads<double> loads;  // [N], [N m]
    Status status = Status::ok;
    int roots = 1;        // number of roots of (11): 1, or 3 if some node has several
    double ring = 0.0;    // weight of the vortex-ring inflow in the blended inflow, 0 to 1
    double mean_inflow = 0.0;  // over the area of the disk [m/s]
    double blade_drag = 0.0;  // drag [N] of the bare blades, without `drag_factor` and mount
};

// Limit of the last Newton step of the harmonics, relative to tip speed plus air speed.  The loads are corrected for this
// step to first order; the error, of second order, is at most 3e-8 of the static loads.  A steady state of dynamic
// inflow needs a smaller limit, because a simulation ends closer to the solution.
inline constexpr double harmonics_close = 2e-5, harmonics_steady = 1e-7;

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
    std::vector<bool> near_stall;  // for each block of nodes (disk.hpp): whether it contains a node near stall
    Azimuths psi;  // over which (5) to (7) are averaged
    bool windmill = false;  // whether (11) has the windmill branch
    Harmonics<double> harmonics{};
    DiskFlow<double> mean;
    double thrust_tail = 0.0, torque_tail = 0.0;  // size of the last Legendre coefficients, see `tail`
    Result result;
};

// Solver for the loads of a rotor at any operating point, with a given accuracy.
template <template <class> class LawOf> class RotorSolver {
  public:
    using Modeled = Rotor<double, LawOf>;

    RotorSolver(Modeled rotor, const Accuracy& accuracy) : rotor_(std::move(rotor)), accuracy_(accuracy) {
        // Tails are compared with static loads, stored divided by Omega^2.  A blade that stalls in hover has small static
        // loads.  Mean coefficients are therefore assumed to be at least 0.1 (lift) and 0.01 (force against the rotation).
        const double omega = 100.0 / rotor_.tip();
        Solution at_rest;
        at_rest.flow = {omega, 0.0, 0.0};
        at_rest.psi = azimuths(1);
        start_at(at_rest, 24);
        solve_nodes(annuli(at_rest), at_rest.disk, {});
        find_loads(at_rest);
        double force = 0.0;
        for (int g = 0; g < at_rest.disk.groups; ++g)
            force += sum(at_rest.disk.weight[g] * at_rest.disk.at[g].chord * square(at_rest.disk.at[g].radius));
        force *= 0.5 * rotor_.density * rotor_.blade->blades;
        const auto& loads = at_rest.result.loads;
        static_thrust_ = std::fmax(std::fabs(loads.thrust) / (omega * omega), 0.1 * force);
        static_torque_ = std::fmax(std::fabs(loads.torque) / (omega * omega), 0.01 * force * rotor_.tip());
    }

    const Modeled& rotor() const { return rotor_; }

    // Set the flow (including the static inflow in descent), the branch of momentum theory and the azimuths.
    void prepare(const Flow<double>& at, Solution& s) const {
        s.flow = at;
        const auto hover = [&](double omega) { return hover_inflow(omega); };
        s.flow.v_hover = at.v_axial < 0.0 ? static_inflow_.at(at.omega, rotor_.tip(), hover) : 0.0;
        s.result = Result{};
        s.harmonics = {};
        s.windmill = vortex_ring::windmill(s.flow);
        s.psi = azimuths(at.v_inplane == 0.0 ? 1 : accuracy_.azimuths_at(advance_ratio(at), sharpness(), 0));
    }
    double advance_ratio(const Flow<double>& at) const {  // V sin(beta)/(Omega R)
        return at.v_inplane == 0.0 ? 0.0 : at.v_inplane / (at.omega * rotor_.tip());
    }
    // Sharpness of stall, relative to the paper's; at least 1.
    double sharpness() const { return std::max(0.02 / rotor_.law.stall_width(), 1.0); }

    // Solve an operating point.
    void solve(const Flow<double>& at, Solution& s) const {
        const double fastest = std::max({at.omega * rotor_.tip(), std::fabs(at.v_axial), at.v_inplane});
        if (!(fastest < fastest_flow) || at.omega < 0.0 || at.v_inplane < 0.0) return set_inflow(at, std::nan(""), s);
        if (fastest <= speed_floor) return set_inflow(at, 0.0, s);
        prepare(at, s);
        const double advance = advance_ratio(at), sharper = sharpness();
        const bool follow = advance <= (at.v_axial < 0.0 ? follow_descent_below : follow_below);
        if (!attached_at(s, accuracy_.free)) solve_stalled(s, follow, follow ? accuracy_.stalled : accuracy_.fast);
        find_loads(s);
        // A sharper stall needs lower limits.  So does the windmill branch, because the kink of its momentum thrust causes a
        // small tail only.  (The error was 0.105 % of the static load at 2 of 200,000 descents with `kinked` = 1,
        // and exceeded 0.1 % at 2 of 50,000 descents with `kinked` = 1.5 and a sharper stall.)
        const double stricter = sharper * sharper;
        const double kinked = !s.windmill ? 1.0 : sharper > 1.0 && rotor_.law.plain_stall ? 3.0 : 1.5;
        double limit = accuracy_.largest_tail / (stricter * kinked);
        for (std::size_t times = 0; times < accuracy_.finer.size() && tail_share(s) > limit; ++times) {
            s.psi = azimuths(at.v_inplane == 0.0 ? 1 : accuracy_.azimuths_at(advance, sharper, int(times) + 1));
            start_at(s, accuracy_.free);
            solve_stalled(s, true, accuracy_.finer[times].nodes);
            find_loads(s);
            limit = accuracy_.finer[times].largest_tail / stricter;
        }
        set_status(s, tail_share(s) > accuracy_.finer.back().largest_tail / stricter);
    }

    // Set this inflow [m/s] at all nodes: zero for a rotor at rest in still air, NaN if the flow is too fast.
    void set_inflow(const Flow<double>& at, double inflow, Solution& s) const {
        s.flow = at, s.flow.v_hover = 0.0;
        s.result = Result{};
        s.harmonics = {};
        s.psi = azimuths(1);
        single_panel(s.disk, rotor_.root(), rotor_.tip(), accuracy_.free);
        place_nodes(rotor_, 0.0, s.disk);
        std::fill(s.disk.inflow.begin(), s.disk.inflow.end(), broadcast(inflow));
        s.disk.several = s.windmill = false;
        // A very small axial flow defines the direction of the wake of a rotor at rest.
        s.mean = {at.omega, inflow + 1e3 * speed_floor, 0.0, inflow};
        s.result.loads.thrust = inflow;
        set_status(s, false);
    }

    // Solve an operating point at `count` nodes of a single panel, whether the blade stalls or not.
    void solve_at_nodes(const Flow<double>& at, int count, Solution& s) const {
        prepare(at, s);
        if (!attached_at(s, count)) solve_stalled(s, false, count);
        find_loads(s, harmonics_steady);
        set_status(s, false);
    }

    // Place the nodes of a single panel.
    void start_at(Solution& s, int count) const {
        single_panel(s.disk, rotor_.root(), rotor_.tip(), count);
        place_nodes(rotor_, s.flow.omega, s.disk);
        s.near_stall.assign(s.disk.blocks(), true);
        s.disk.several = false;
    }

    // Solve (11) at the nodes of a single panel, and return whether flow is attached there.
    bool attached_at(Solution& s, int count) const {
        start_at(s, count);
        return advance_ratio(s.flow) <= reversed_above && solve_attached(annuli(s), s.disk, s.near_stall);
    }

    // Solve (11) if the blade may stall, at `count` nodes of panels that `follow` stall or of a single panel.
    void solve_stalled(Solution& s, bool follow, int count) const {
        const auto of = annuli(s);
        find_folds(of, s.disk, s.near_stall, follow, s.folds);
        if (follow) make_panels(s.folds, rotor_.root(), rotor_.tip(), count, s.disk);
        else single_panel(s.disk, rotor_.root(), rotor_.tip(), count);
        place_nodes(rotor_, s.flow.omega, s.disk);
        solve_nodes(of, s.disk, s.folds);
    }

    // The larger of the tails of thrust and torque, relative to the static load at Omega or V/R, whichever is larger.
    double tail_share(const Solution& s) const {
        const auto& f = s.flow;
        const double wind = (f.v_axial * f.v_axial + f.v_inplane * f.v_inplane) / (rotor_.tip() * rotor_.tip());
        const double square = std::max(f.omega * f.omega, wind);
        return std::max(s.thrust_tail / static_thrust_, s.torque_tail / static_torque_) / square;
    }

    // Static inflow v_i0 [m/s], eq. (12).
    double hover_inflow(double omega) const {
        thread_local Solution still;
        solve({omega, 0.0, 0.0}, still);
        return static_inflow(still.result.loads.thrust / rotor_.density, rotor_.tip());
    }

    // Eq. (11) at this point.  `few` contains a quarter of the azimuths, but at least 6, or 8 for a sharper stall.
    Annuli<Modeled> annuli(const Solution& s) const {
        const int least = sharpness() > 1.0 ? 8 : 6;
        const Azimuths few = s.psi.count > 4 ? azimuths(std::max(least, 2 * (s.psi.count / 4))) : s.psi;
        return {rotor_, s.flow, s.psi, few, s.windmill};
    }

    bool has_harmonics(const Solution& s) const {  // whether the inflow varies around the disk
        return rotor_.inflow_shape != InflowShape::uniform && s.flow.v_inplane > 0.0;
    }

    // Compute loads per density, derivatives of the loads with respect to the harmonics, and the integrand for `tail`.
    void loads_and_slopes(const Solution& s, const Azimuths& psi, const std::vector<Lanes>& inflow, const Harmonics<double>& h,
                          Loads<double>& loads, Loads<double> (&by)[3], double* integrand) const {
        loads = {}, by[0] = {}, by[1] = {}, by[2] = {};
        for (int g = 0; g < s.disk.groups; ++g) {
            const auto& at = s.disk.at[g];
            const Lanes& weight = s.disk.weight[g];
            const auto turn = turn_slopes(rotor_, at, s.flow, inflow[g], psi, h);
            const Lanes share = weight * (at.radius * (1.0 / rotor_.tip()));
            const auto here = loads_of(rotor_, at, turn.forces);
            loads.add(here, weight);
            by[0].add(loads_of(rotor_, at, turn.by_mean), weight);
            by[1].add(loads_of(rotor_, at, turn.by_sine), share);
            by[2].add(loads_of(rotor_, at, turn.by_cosine), share);
            keep_integrand(s, g, weight, here, integrand);
        }
    }

    // Compute the loads of a disk whose inflow is known, and the harmonics of this inflow.
    void find_loads(Solution& s, double close = harmonics_close) const {
        thread_local std::vector<Lanes> inflow;
        thread_local std::vector<double> integrand(2 * most_nodes);
        const bool around = has_harmonics(s);
        blend(s, inflow);
        const auto total = around ? find_harmonics(s, inflow, s.result.ring, close, integrand.data()) : Loads<double>{};
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
            if (!around) {
                const auto per_radius = loads_of(rotor_, at, turn_forces(rotor_, at, s.flow, inflow[g], s.psi));
                total.add(per_radius, weight);
                keep_integrand(s, g, weight, per_radius, integrand);
            }
            if (rotor_.radial_friction && s.flow.v_inplane > 0.0)
                total.add(radial_friction(rotor_, at, s.flow, inflow[g], s.psi), weight);
        }
        s.result.blade_drag = rotor_.density * total.drag;
        complete_loads(rotor_, s.flow, s.mean.inflow, total);
        s.result.loads = total;
        s.thrust_tail = rotor_.density * tail(s, integrand);
        s.torque_tail = rotor_.density * tail(s, integrand + most_nodes);
    }

    // Solve for the harmonics and the loads, which depend on each other.  Newton's method starts from zero harmonics, first
    // over few azimuths.  Usually it needs one more step, over all azimuths.  `close` is the limit of the last step.
    Loads<double> find_harmonics(Solution& s, const std::vector<Lanes>& inflow, double ring, double close,
                                 double* integrand) const {
        const auto response = harmonic_response(rotor_.inflow_shape, s.mean, rotor_.tip()).faded(1.0 - ring);
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
        double without = 0.0;
        for (int step = 0; step < 4 && size > 1e-3; ++step) {
            loads_and_slopes(s, step == 0 && ring > 0.0 ? s.psi : few, inflow, h, loads, by, integrand);
            if (step == 0) without = loads.thrust;
            step_to(without);
        }
        // By (11), the blades' thrust without harmonics equals the momentum thrust, except within the vortex ring.
        if (!(ring > 0.0)) {
            without = 0.0;
            for (int g = 0; g < s.disk.groups; ++g)
                without += sum(s.disk.weight[g] * wake_thrust(rotor_, s.disk.at[g].radius, s.flow, s.windmill, s.disk.inflow[g]));
        }
        size = INFINITY;
        for (int step = 0; step < 40 && size > close; ++step) {
            loads_and_slopes(s, s.psi, inflow, h, loads, by, integrand);
            step_to(without);
            if (!std::isfinite(size)) break;
        }
        s.harmonics = h;
        if (!(size <= close))
            for (int k = 0; k < Loads<double>::count; ++k) loads.begin()[k] = std::nan("");
        return loads;
    }

    Modeled rotor_;
    Accuracy accuracy_;
    double static_thrust_ = 1.0, static_torque_ = 1.0;
    StaticInflow static_inflow_;
};

}  // namespace propmap
