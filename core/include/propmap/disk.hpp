// The inflow v_i over the disk, at the nodes of one or more panels along the blade.
//
// A node is a radius at which (11) is solved.  A panel is a part of the blade with its own Gauss-Legendre nodes.
// The hump is the maximum (top) of the residual of (11) near stall or, if there is none, its flattest point (shoulder);
// its height is the residual there.  A fold is a radius at which the height is zero.  The inflow jumps there, or varies
// steeply: stall begins or ends.  Panels that follow stall meet at folds.  annulus.hpp has the exact definitions.
#pragma once

#include <map>
#include <mutex>

#include "annulus.hpp"

namespace propmap {

inline constexpr int most_nodes = 1100;  // the largest number in `Accuracy` (rotor.hpp), 960, and two more per panel
inline constexpr int most_edges = 12;  // largest number of folds at which panels meet
inline constexpr int run = 4;  // consecutive nodes marked near stall together; unlike `width`, the same on all processors
static_assert(width % run == 0);

// Nodes and weights of one panel, relative to its length, and the Legendre polynomials that estimate the error.
//
// The nodes are Gauss-Legendre nodes t, mapped to be dense near the tip of a single panel or, less strongly, near both
// edges of each of several panels (`both`).  The reason: inflow near a fold and chord near the tip vary as the square
// root of the distance.
struct PanelRule {
    static constexpr int tail = 4;  // number of last Legendre coefficients, whose size indicates the error
    std::vector<double> place, weight;
    std::vector<double> last;  // (2 k + 1) P_k at the nodes for the `tail` highest k, (tail, n)

    explicit PanelRule(int key) : PanelRule(key / 2, key % 2 == 1) {}  // key = 2 n + both
    PanelRule(int n, bool both) : place(n), weight(n), last(std::size_t(tail) * n) {
        for (int i = 0; i < n; ++i) {
            double x = std::cos(pi * (n - 1 - i + 0.75) / (n + 0.5)), slope = 1.0;
            const auto legendre = [&](double& before, double& here, auto&& each) {
                before = 1.0, here = x;
                for (int k = 1; k < n; ++k) {
                    each(k, here);
                    const double next = ((2 * k + 1) * x * here - k * before) / (k + 1);
                    before = here, here = next;
                }
            };
            double before, here;
            for (int step = 0; step < 100; ++step) {
                legendre(before, here, [](int, double) {});
                slope = n * (x * here - before) / (x * x - 1.0);
                x -= here / slope;
                if (std::fabs(here / slope) < 1e-15) break;
            }
            legendre(before, here, [&](int k, double p) {
                if (k >= n - tail) last[std::size_t(k - (n - tail)) * n + i] = (2 * k + 1) * p;
            });
            const double t = 0.5 * (x + 1.0), w = 1.0 / ((1.0 - x * x) * slope * slope);
            place[i] = both ? 0.5 * (t * t * (3.0 - 2.0 * t) + t) : t * (2.0 - t);
            weight[i] = w * (both ? 0.5 * (6.0 * t * (1.0 - t)) + 0.5 : 2.0 * (1.0 - t));
        }
    }
};

// Azimuth nodes: count / 2 on the rear half of the disk, or a single one for count = 1.
struct AzimuthRule {
    std::vector<double> sine, cosine;
    explicit AzimuthRule(int count) {
        const int half = std::max(count / 2, 1);
        for (int k = 0; k < half; ++k) {
            const double psi = pi * ((k + 0.5) / half - 0.5);
            sine.push_back(count == 1 ? 0.0 : std::sin(psi));
            cosine.push_back(count == 1 ? 1.0 : std::cos(psi));
        }
    }
};

// Return the rule that is constructed from this number.  It is constructed on first use and stored.
template <class Rule> const Rule& rule_of(int number) {
    static std::mutex guard;
    static std::map<int, Rule> rules;
    thread_local std::array<const Rule*, 2400> known{};
    if (known[number]) return *known[number];
    const std::lock_guard lock(guard);
    return *(known[number] = &rules.try_emplace(number, number).first->second);
}
inline const PanelRule& panel_rule(int nodes, bool both) { return rule_of<PanelRule>(2 * nodes + both); }
inline Azimuths azimuths(int count) {
    const AzimuthRule& rule = rule_of<AzimuthRule>(count);
    return {int(rule.sine.size()), rule.sine.data(), rule.cosine.data()};
}

// The panels along the blade, and the inflow at their nodes.  A group is `width` consecutive nodes, one per lane.
struct Disk {
    int panels = 1;
    std::array<double, most_edges + 2> edge;    // of the panels, from root to tip [m]
    std::array<Fold, most_edges + 2> fold;      // the fold at which edge k lies, if moves[k]
    std::array<bool, most_edges + 2> moves{};
    std::array<int, most_edges + 1> count;      // number of nodes of each panel
    int nodes = 0, groups = 0;
    std::vector<Station<Lanes>> at;  // the blade at the nodes; lanes after the last node repeat it
    std::vector<Lanes> weight;       // of the nodes [m]; zero after the last node
    std::vector<Lanes> inflow;       // v_i [m/s]; NaN where it was not found
    std::vector<Mask> ended;         // nodes at which Newton's method converged
    bool several = false;            // whether (11) has several roots at some node

    double radius(int node) const { return at[node / width].radius[node % width]; }
    int runs() const { return (nodes + run - 1) / run; }

    // Lanes of a group in which `several_roots` is evaluated: those of every third run of nodes.
    static Mask every_third_run(int group) {
        Mask chosen{};
        for (int k = 0; k < width; ++k) chosen[k] = -((group * width + k) / run % 3 == 0);
        return chosen;
    }

    // Call `each(node, panel, rule, k)` for all nodes; lanes after the last node repeat its panel and k.
    template <class F> void for_each_node(F each) const {
        int node = 0, panel = 0, k = 0;
        for (; node < groups * width; ++node) {
            each(node, panel, panel_rule(count[panel], panels > 1), k);
            if (k + 1 < count[panel]) ++k;
            else if (panel + 1 < panels) ++panel, k = 0;
        }
    }
};

// Compute radii and weights of all nodes, and the shape of the blade there.
template <class R> void place_nodes(const R& rotor, double omega, Disk& disk) {
    disk.nodes = 0;
    for (int p = 0; p < disk.panels; ++p) disk.nodes += disk.count[p];
    disk.groups = (disk.nodes + width - 1) / width;
    disk.at.resize(disk.groups), disk.weight.resize(disk.groups), disk.inflow.resize(disk.groups);
    Lanes radius{};
    disk.for_each_node([&](int node, int panel, const PanelRule& rule, int k) {
        const double span = disk.edge[panel + 1] - disk.edge[panel];
        radius[node % width] = disk.edge[panel] + span * rule.place[k];
        disk.weight[node / width][node % width] = node < disk.nodes ? span * rule.weight[k] : 0.0;
        if (node % width == width - 1) disk.at[node / width] = station_at(rotor, omega, radius);
    });
}

// Radii and weights of the nodes, with derivatives, because nodes move with the edges of panels.
template <class S> struct MovingNodes {
    using T = decltype(Lanes{} * S{});
    std::vector<T> radius, weight;

    MovingNodes(const Disk& disk, const std::array<S, most_edges + 2>& edge) : radius(disk.groups), weight(disk.groups) {
        disk.for_each_node([&](int node, int panel, const PanelRule& rule, int k) {
            const S span = edge[panel + 1] - edge[panel];
            const S y = edge[panel] + span * rule.place[k], w = span * (node < disk.nodes ? rule.weight[k] : 0.0);
            T &r = radius[node / width], &wide = weight[node / width];
            const int lane = node % width;
            r.v[lane] = y.v, wide.v[lane] = w.v;
            for (int d = 0; d < directions_of<S>; ++d) r.d[d][lane] = y.d[d], wide.d[d][lane] = w.d[d];
        });
    }
};

// `inflow` is a root of (11) in attached flow.  Return whether any of these lanes has smaller roots: then its residual
// past stall is negative.  To save time, the residual for sin(psi) = 0 alone is tested first.
template <class R> bool several_roots(const Annuli<R>& of, const Station<Lanes>& at, Lanes inflow, Mask lanes) {
    if (!any(lanes)) return false;
    const Lanes speed = of.rms_speed(at), stall = stall_angles(of, at, 1.0);
    const Lanes margin = 1e-4 * (of.flow.omega * at.radius + of.flow.v_inplane);
    const double none = 0.0;
    const Azimuths mean{1, &none, &none};
    Mask found{};
    for (double off : {0.0, 0.04, 0.1, 0.2}) {
        const Lanes v = inflow_past_stall(of, at, speed, stall, off);
        Mask below = lanes & (v < inflow - margin);
        if (!any(below)) continue;
        const Lanes asked = below ? v : inflow;
        const Lanes wake = absolute(wake_thrust(of.rotor, at.radius, of.flow, of.windmill, asked));
        if (of.psi.count > 1) below &= of.residual(at, asked, mean).v < 0.5 * wake;
        if (any(below)) found |= below & (of.residual(at, asked).v < 0.0);
    }
    return any(found);
}

inline constexpr double close_enough = 3e-6;  // last Newton step, relative to the speed; the next one would be 1e-11

template <class R> Lanes speed_scale(const Annuli<R>& of, const Station<Lanes>& at) {  // typical speed of the air [m/s]
    return of.rms_speed(at) + std::fabs(of.flow.v_axial);
}

// Improve the inflow at all nodes by at most `most` Newton steps.  A node has converged if its step is at most `close`
// times the speed and the residual decreases with v_i.  Each step is computed for all groups before the next step, so
// that the processor can overlap the groups.
template <class R> void newton(const Annuli<R>& of, Disk& disk, const Azimuths& over, double close, int most) {
    disk.ended.assign(disk.groups, Mask{});
    bool open = true;
    for (int k = 0; k < most && open; ++k) {
        open = false;
        for (int g = 0; g < disk.groups; ++g) {
            Mask& ended = disk.ended[g];
            if (!any(~ended)) continue;
            Lanes& v = disk.inflow[g];
            const auto r = of.residual(disk.at[g], v, over);
            const Mask falls = r.d[0] < 0.0;
            const Lanes scale = speed_scale(of, disk.at[g]), far = 0.3 * scale;
            Lanes step = falls ? r.v / r.d[0] : far;
            step = step > far ? far : (step < -far ? -far : step);
            v = ended ? v : v - step;
            ended |= falls & (absolute(step) <= close * scale);
            open |= any(~ended);
        }
    }
}

// Solve (11) at all nodes by Newton's method from attached flow, first over few azimuths.  If nodes are near stall,
// return false and mark their runs in `near_stall`.
template <class R> bool solve_attached(const Annuli<R>& of, Disk& disk, std::vector<bool>& near_stall) {
    near_stall.assign(disk.runs(), false);
    const auto all_sure = [&](const Azimuths& over, double close, int most) {
        newton(of, disk, over, close, most);
        bool all = true;
        for (int g = 0; g < disk.groups; ++g) {
            const Mask sure = disk.ended[g] & surely_largest(of, disk.at[g], disk.inflow[g]);
            if (!any(~sure)) continue;
            for (int k = 0; k < width && g * width + k < disk.nodes; ++k)
                if (!sure[k]) near_stall[(g * width + k) / run] = true, all = false;
        }
        return all;
    };
    for (int g = 0; g < disk.groups; ++g) disk.inflow[g] = attached_guess(of, disk.at[g]);
    if (!all_sure(of.few, 3e-3, 5) || !all_sure(of.psi, close_enough, 6)) return false;
    for (int g = 0; g < disk.groups && !disk.several; ++g)
        disk.several = several_roots(of, disk.at[g], disk.inflow[g], Disk::every_third_run(g));
    return true;
}

// The folds along the blade, at which the height of the hump changes sign, and all humps computed in the search.
struct Folds {
    double side = 1.0;  // 1 if the blade stalls at positive angles of attack, -1 at negative angles
    int count = 0;
    std::array<Fold, most_edges> fold;
    std::vector<Hump> seen;  // in order of increasing radius
};
// Search for folds in the runs near stall; in all other runs, flow is attached.  Between two radii, the height of the
// hump is interpolated by a cubic from values and derivatives.  If the cubic has an extreme near zero, two folds may
// hide there, and the hump at a radius in between is computed, too.
template <class R>
void find_folds(const Annuli<R>& of, const Disk& disk, const std::vector<bool>& near_stall, bool follow, Folds& folds,
                bool& several) {
    const double root = of.rotor.root(), tip = of.rotor.tip();
    const auto& f = of.flow;
    // The stall angle is assumed to have the sign of the angle of attack without inflow at 60 % of the blade's length.
    const double out = root + 0.6 * (tip - root);
    const auto beside = of.station(broadcast(out));
    const double side = beside.line.sine[0] * f.omega * out - beside.line.cosine[0] * f.v_axial < 0.0 ? -1.0 : 1.0;
    auto& seen = folds.seen;
    seen.clear(), folds.count = 0, folds.side = side;
    const auto look = [&](Lanes radius, int count) {
        Hump found[width];
        humps_at(of, radius, count, side, found);
        for (int k = 0; k < count; ++k)
            if (!std::isnan(found[k].height)) seen.push_back(found[k]);
    };
    const auto look_at = [&](const double* radius, int count) {
        for (int k = 0; k < count; k += width)
            look(each_lane([&](int j) { return radius[std::min(k + j, count - 1)]; }), std::min(width, count - k));
    };
    const auto sort = [&] {
        std::sort(seen.begin(), seen.end(), [](const Hump& a, const Hump& b) { return a.radius < b.radius; });
    };
    // Because derivatives are known, every second node is sufficient; every fourth, if panels do not follow stall.
    const int every = follow ? 2 : 4;
    std::array<double, most_nodes + 2> places;
    int near = 0, chosen = 0;
    const auto add_run = [&](int k) {
        // A fold may lie between an end of the blade and the node next to it.
        const double inset = 1e-5 * (tip - root);
        if (k == 0) places[near++] = root + inset;
        for (int node = k * run; node < std::min((k + 1) * run, disk.nodes); ++node) places[near++] = disk.radius(node);
        if (k + 1 == disk.runs()) places[near++] = tip - inset;
    };
    const auto look_at_places = [&] {
        chosen = 0;
        for (int k = 0; k < near; ++k)
            if (near <= 8 || k % every == 0 || k == near - 1) places[chosen++] = places[k];
        look_at(places.data(), chosen);
        near = 0;
        sort();
    };
    for (int k = 0; k < disk.runs(); ++k)
        if (near_stall[k]) add_run(k);
    look_at_places();
    // Add a neighboring run, unless the nearest height is large and positive and stays above half of it up to the run.
    for (int k = 0; k < disk.runs(); ++k) {
        const bool within = k > 0 && near_stall[k - 1], without = k + 1 < disk.runs() && near_stall[k + 1];
        if (near_stall[k] || !(within || without)) continue;
        const double y = disk.radius(std::min(k * run + run / 2, disk.nodes - 1));
        const auto closest = std::min_element(seen.begin(), seen.end(), [&](const Hump& a, const Hump& b) {
            return std::fabs(a.radius - y) < std::fabs(b.radius - y);
        });
        const bool far = closest != seen.end() && closest->height > 0.0 && !closest->near &&
                         closest->height + closest->slope * (y - closest->radius) > 0.5 * closest->height;
        if (!far) add_run(k);
    }
    if (near > 0) look_at_places();
    for (int round = 0; round < 6; ++round) {
        std::vector<double> closer;
        for (std::size_t k = 0; k + 1 < seen.size(); ++k) {
            const Hump &a = seen[k], &b = seen[k + 1];
            const double gap = b.radius - a.radius;
            if (gap < 1e-5 * tip || gap > 0.2 * tip) continue;
            const Cubic<double> cubic(gap, a.height, -a.slope, b.height, -b.slope);  // its argument must decrease: -radius
            double t[2];
            const bool crosses = (a.height < 0.0) != (b.height < 0.0);
            const double nearest = std::min(std::fabs(a.height), std::fabs(b.height));
            double place = 0.0;
            // Two folds may hide at an extreme of opposite sign or near zero.  Between small heights far apart, any may hide two.
            for (int e = cubic.extremes(t) - 1; e >= 0 && place == 0.0; --e) {
                const double there = cubic.at(t[e]);
                const bool far = gap < 0.02 * tip || !a.near || !b.near;
                if (!crosses && (there < 0.0) == (a.height < 0.0) && std::fabs(there) > 0.7 * nearest && far) continue;
                const double least = crosses ? 0.02 : 1e-6 * tip / gap;
                if (t[e] > least && t[e] < 1.0 - least) place = t[e];
            }
            // A top and a shoulder may be different humps: the height then jumps somewhere between the two radii.
            const double steepest = std::max(std::fabs(a.slope), std::fabs(b.slope));
            if (!crosses && a.top != b.top && gap > 0.004 * tip && nearest < steepest * gap) place = 0.5;
            // A height close to zero may change sign between stations: one missed interval cost 2.6 % of static thrust.
            if (place == 0.0 && (a.touching || b.touching) && gap > 0.012 * tip) place = 0.5;
            if (place > 0.0) closer.push_back(a.radius + place * gap);
        }
        if (closer.empty()) break;
        look_at(closer.data(), int(closer.size()));
        sort();
    }
    for (std::size_t k = 0; k < seen.size(); ++k) {
        several |= seen[k].folded;
        if (!follow || k + 1 == seen.size() || folds.count == most_edges) continue;
        if ((seen[k].height < 0.0) == (seen[k + 1].height < 0.0)) continue;
        const Fold found = fold_between(of, seen[k], seen[k + 1], side);
        if (!(found.radius > root && found.radius < tip)) continue;
        // Two folds of Kind::angle at the same radius are one fold.
        if (folds.count > 0 && found.kind == Fold::Kind::angle) {
            const Fold& before = folds.fold[folds.count - 1];
            if (before.kind == Fold::Kind::angle && std::fabs(found.radius - before.radius) < 1e-6 * tip) continue;
        }
        several |= found.kind == Fold::Kind::top;
        folds.fold[folds.count++] = found;
    }
}

// Make panels that meet at the folds.  There are at least three panels; fixed edges replace missing folds.
inline void make_panels(const Folds& folds, double root, double tip, int nodes, Disk& disk) {
    struct Edge {
        double radius;
        int fold;
    };
    std::array<Edge, most_edges + 2> edges;
    int count = 0;
    for (; count < folds.count; ++count) edges[count] = {folds.fold[count].radius, count};
    for (; count < 2; ++count) edges[count] = {root + (tip - root) * (count == 0 ? 0.25 : 0.6), -1};
    std::sort(edges.begin(), edges.begin() + count, [](const Edge& a, const Edge& b) { return a.radius < b.radius; });
    disk.panels = count + 1;
    disk.edge[0] = root, disk.edge[disk.panels] = tip;
    disk.moves.fill(false);
    for (int k = 0; k < count; ++k) {
        disk.edge[k + 1] = edges[k].radius;
        disk.moves[k + 1] = edges[k].fold >= 0;
        if (edges[k].fold >= 0) disk.fold[k + 1] = folds.fold[edges[k].fold];
    }
    // Three panels share nodes by length, at least `least` each.  With 12 nodes in a long inner panel, errors reached 0.13 %.
    constexpr int least = 8;
    int left = nodes;
    for (int p = disk.panels - 1; p >= 0; --p) {
        const double share = (disk.edge[p + 1] - disk.edge[p]) / (tip - root);
        disk.count[p] = disk.panels > 3 ? nodes / disk.panels + 2
                        : p > 0         ? least + int((nodes - 3 * least) * share + 0.5)
                                        : left;
        left -= disk.count[p];
    }
}

// A single panel from root to tip.
inline void single_panel(Disk& disk, double root, double tip, int nodes) {
    disk.panels = 1;
    disk.edge[0] = root, disk.edge[1] = tip;
    disk.moves.fill(false);
    disk.count[0] = nodes;
}

// Forecast of the largest root at the radius in each lane, from the nearest humps on both sides.
struct Outlook {
    Mask known{};    // whether there are humps nearby; if not, nothing else is known
    Mask single{};   // both humps are shoulders and the residual decreases with v_i: (11) has one root
    Mask clear{};    // neither hump has another maximum below it before the residual is positive again
    Mask attached{}, stalled{};  // the root is above the hump, or below it; both are false if either is possible
    Lanes top, below;  // v_i of the hump, and a smaller v_i at which the residual is positive; NaN if unknown
};
template <class R>
Outlook outlook(const Annuli<R>& of, const Folds& folds, bool follow, const Station<Lanes>& at, Lanes speed) {
    Outlook o{};
    const auto& seen = folds.seen;
    const double tip = of.rotor.tip(), reach = 0.12 * tip;
    if (seen.empty() || !any((at.radius >= seen.front().radius - reach) & (at.radius <= seen.back().radius + reach))) return o;
    Lanes past, below;
    for (int k = 0; k < width; ++k) {
        const double y = at.radius[k];
        past[k] = below[k] = std::nan("");
        auto after = std::lower_bound(seen.begin(), seen.end(), y, [](const Hump& h, double x) { return h.radius < x; });
        const Hump& a = after == seen.begin() ? *after : *(after - 1);
        const Hump& b = after == seen.end() ? a : *after;
        if (std::min(std::fabs(y - a.radius), std::fabs(b.radius - y)) > reach) continue;
        // A hump on the far side of a fold does not predict the branch on this side.
        bool within = true, without = true;
        for (int f = 0; follow && f < folds.count; ++f) {
            const double jump = folds.fold[f].radius;
            if (folds.fold[f].kind == Fold::Kind::angle) continue;
            within &= !((a.radius < jump) == (jump < y)), without &= !((y < jump) == (jump < b.radius));
        }
        const double share = b.radius > a.radius ? (y - a.radius) / (b.radius - a.radius) : 0.0;
        past[k] = a.past + share * (b.past - a.past);
        below[k] = a.below > b.below || std::isnan(a.below) ? a.below : b.below;
        o.known[k] = -1;
        o.single[k] = -(!a.top && !b.top && a.falls && b.falls);
        o.clear[k] = -(a.clear && b.clear);
        o.attached[k] = -((within || without) && (a.height > 0.0 || !within) && (b.height > 0.0 || !without));
        o.stalled[k] = -((within || without) && (a.height < 0.0 || !within) && (b.height < 0.0 || !without));
    }
    const Lanes stall = stall_angles(of, at, folds.side);
    o.top = inflow_at_angle(of, at, speed, stall + past), o.below = inflow_at_angle(of, at, speed, stall + below);
    o.known &= o.top == o.top;
    if (!of.plain()) o.single = o.clear = Mask{};
    // Near the hub, hub loss removes momentum thrust and humps vary quickly.  Forecasts there led to a smaller root.
    if (const double hub = of.rotor.hub_radius; hub > 0.0) o.known &= at.radius > 1.5 * hub;
    // Deep in reverse flow, stall covers most azimuths, and the stall angle does not predict the roots.
    o.known &= of.flow.v_inplane < 1.4 * (of.flow.omega * at.radius);
    return o;
}

// Find the inflow at all nodes.  Newton's method starts on the branch that `Outlook` predicts.  Its root is accepted if
// it is in attached flow or on this branch.  At all other nodes, a scan finds the root.
template <class R> void solve_nodes(const Annuli<R>& of, Disk& disk, const Folds* folds, bool follow) {
    std::array<int, most_nodes + width> open;
    int left = 0;
    const auto turn = turning_points(of.flow.v_axial, of.flow.v_inplane);
    // Above this inflow, (10) increases with v_i.
    const double rises = of.windmill || turn.second <= turn.first ? -INFINITY : turn.second;
    std::array<Outlook, most_nodes / width + 1> outlooks;
    for (int g = 0; g < disk.groups; ++g) {
        const auto& at = disk.at[g];
        Lanes& v = disk.inflow[g];
        v = attached_guess(of, at);
        if (!folds) continue;
        const Lanes speed = of.rms_speed(at);
        const Outlook& o = outlooks[g] = outlook(of, *folds, follow, at, speed);
        // For stall at negative angles of attack, flow is stalled above the top.
        if (folds->side > 0.0) {
            v = o.stalled & (o.below == o.below) ? o.below : v;
        } else if (any(o.attached & o.known)) {
            const Lanes guess = inflow_past_stall(of, at, speed, stall_angles(of, at, -1.0), -0.1);
            v = o.attached & o.known & (guess == guess) ? guess : v;
        }
    }
    newton(of, disk, of.few, 3e-3, 4);
    newton(of, disk, of.psi, close_enough, 6);
    for (int g = 0; g < disk.groups; ++g) {
        const auto& at = disk.at[g];
        const Lanes v = disk.inflow[g];
        const Mask sure = disk.ended[g] & surely_largest(of, at, v);
        Mask found = sure;
        if (folds) {
            const Outlook& o = outlooks[g];
            const Lanes near = 0.003 * speed_scale(of, at);
            const Mask above = v > o.top + near, about = v > o.top - near;
            Mask stalled = o.stalled;
            const Mask beneath = o.clear & (v < o.top + near) & (folds->side < 0.0 ? v == v : v > o.below - near);
            const Mask settled = above | o.single | (o.attached & about), open = disk.ended[g] & o.known & (v >= rises);
            // If the neighboring heights have opposite signs and no fold lies between, compute the top at the node.
            if (folds->side > 0.0) stalled |= top_below_zero(of, at, open & beneath & ~(found | settled | o.stalled | o.attached), o.top);
            found |= open & (settled | (stalled & beneath));
        }
        if (!disk.several && !of.windmill) disk.several = several_roots(of, at, v, sure & Disk::every_third_run(g));
        if (!any(~found)) continue;
        for (int k = 0; k < width; ++k)
            if (!found[k] && g * width + k < disk.nodes) open[left++] = g * width + k;
    }
    Samples samples;
    for (int first = 0; first < left; first += width) {
        const int count = std::min(width, left - first);
        const Lanes radius = each_lane([&](int k) { return disk.radius(open[first + std::min(k, count - 1)]); });
        const auto at = of.station(radius);
        Lanes low{}, high{}, guess{};
        const auto look = [&](int k, const Azimuths& over, int every) {
            const Scan found = scan(of, radius[k], over, samples, every);
            low[k] = found.low, high[k] = found.high;
            guess[k] = found.found ? found.guess : std::nan("");
            return found.roots;
        };
        // In climb, deep in reverse flow, stall covers most azimuths.  A scan with few azimuths and half of the angles
        // near stall is sufficient if it finds one root and all azimuths confirm the bracket of this root.
        Mask agreed{};
        for (int k = 0; k < count && of.flow.v_axial >= 0.0 && of.few.count < of.psi.count; ++k)
            agreed[k] = -(of.flow.v_inplane > of.flow.omega * radius[k] && look(k, of.few, 2) == 1);
        if (any(agreed)) agreed &= (of.residual(at, high).v < 0.0) & (of.residual(at, low).v >= 0.0);
        for (int k = 0; k < width; ++k) {
            if (k >= count) low[k] = low[k - 1], high[k] = high[k - 1], guess[k] = guess[k - 1];
            else if (!agreed[k]) disk.several |= look(k, of.psi, 1) > 1;
        }
        const Lanes v = polished_roots(of, at, low, high, guess);
        for (int k = 0; k < count; ++k)
            disk.inflow[open[first + k] / width][open[first + k] % width] = v[k];
    }
    // Lanes after the last node repeat its inflow.
    const Lanes& last = disk.inflow[(disk.nodes - 1) / width];
    const double v = last[(disk.nodes - 1) % width];
    for (int node = disk.nodes; node < disk.groups * width; ++node) disk.inflow[node / width][node % width] = v;
}

}  // namespace propmap
