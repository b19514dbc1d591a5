// The inflow v_i over the disk, at the nodes of one or more panels along the blade.
//
// A node is a radius at which (11) is solved.  A panel is a part of the blade with its own Gauss-Legendre nodes.  Panels
// "follow stall" if they meet at the folds, where the inflow jumps or varies steeply.  annulus.hpp defines hump, height
// and fold; docs/root-search.md explains the search.
#pragma once

#include "annulus.hpp"
#include "quadrature.hpp"

namespace propmap {

inline constexpr int most_nodes = 1100;  // exceeds the largest number in `Accuracy`, 960, plus two per panel
inline constexpr int most_folds = 12;    // largest number of folds at which panels meet
inline constexpr int block = 4;  // consecutive nodes, marked near stall together; unlike `width`, equal on all processors
static_assert(width == block || width == 2 * block);

// --- Panels and nodes ----------------------------------------------------------------------------------------------

// The panels along the blade, and the inflow at their nodes.  A group is `width` consecutive nodes, one per lane.
struct Disk {
    int panels = 1;
    std::array<Edge, most_folds + 2> edge;  // of the panels, from root to tip
    std::array<int, most_folds + 1> count;  // number of nodes of each panel
    int nodes = 0, groups = 0;
    std::vector<Station<Lanes>> at;  // the blade at the nodes; lanes after the last node repeat it
    std::vector<Lanes> weight;       // of the nodes [m]; zero after the last node
    std::vector<Lanes> inflow;       // v_i [m/s]; NaN where it was not found
    std::vector<Mask> ended;         // nodes at which Newton's method converged
    bool several = false;            // whether (11) has several roots at some node

    double radius(int node) const { return at[node / width].radius[node % width]; }
    int blocks() const { return (nodes + block - 1) / block; }

    // Whether `several_roots` tests this group.  To save time, it tests only every third pair of blocks, for each `width`.
    static bool counts_roots(int group) { return group * width / (2 * block) % 3 == 0; }

    // Call `each(node, panel, rule, k)` for node k of each panel.  Lanes after the last node repeat its panel and k.
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
        const double start = disk.edge[panel].radius, length = disk.edge[panel + 1].radius - start;
        radius[node % width] = start + length * rule.place[k];
        disk.weight[node / width][node % width] = node < disk.nodes ? length * rule.weight[k] : 0.0;
        if (node % width == width - 1) disk.at[node / width] = station_at(rotor, omega, radius);
    });
}

// A single panel from root to tip.
inline void single_panel(Disk& disk, double root, double tip, int nodes) {
    disk.panels = 1;
    disk.edge[0] = {root}, disk.edge[1] = {tip};
    disk.count[0] = nodes;
}

// The folds along the blade, at which the height of the hump changes its sign, and all humps computed in the search.
struct Folds {
    double side = 1.0;  // 1 if the blade stalls at positive angles of attack, -1 at negative angles
    int count = 0;
    std::array<Edge, most_folds> edge;  // folds, or edges that replace them
    std::vector<Hump> humps;            // in order of increasing radius
};

// Make panels that meet at the folds.  There are at least three panels; fixed edges replace missing folds.
inline void make_panels(const Folds& folds, double root, double tip, int nodes, Disk& disk) {
    constexpr double in_place[] = {0.25, 0.6};  // shares of the length, for edges that replace the first and second fold
    auto& edge = disk.edge;
    edge[0] = {root};
    std::copy_n(folds.edge.begin(), folds.count, edge.begin() + 1);
    int panels = folds.count + 1;
    for (; panels < 3; ++panels) edge[panels] = {root + (tip - root) * in_place[panels - 1]};
    edge[panels] = {tip};
    std::sort(edge.begin(), edge.begin() + panels, [](const Edge& a, const Edge& b) { return a.radius < b.radius; });
    disk.panels = panels;
    // If there are three panels, each has `least` nodes plus a share of the other nodes in proportion to its length.  (With
    // 12 nodes in a long inner panel, errors reached 0.13 %.)  If there are more panels, all have the same number of nodes.
    constexpr int least = 8;
    int left = nodes;
    for (int p = panels - 1; p >= 0; --p) {
        const double share = (edge[p + 1].radius - edge[p].radius) / (tip - root);
        disk.count[p] = panels > 3 ? nodes / panels + 2
                        : p > 0    ? least + int((nodes - 3 * least) * share + 0.5)
                                   : left;
        left -= disk.count[p];
    }
}

// --- Attached flow and Newton's method -----------------------------------------------------------------------------

// Return whether (11) has roots smaller than the attached root `inflow` in any of these lanes: whether the residual is
// negative at some angle past stall.  To save time, the residual for sin(psi) = 0 alone is tested first.
template <class R> bool several_roots(const Annuli<R>& of, const Station<Lanes>& at, Lanes inflow, Mask lanes) {
    if (!any(lanes)) return false;
    const Lanes stall = of.stall_angle(at, 1.0);
    const Lanes margin = 1e-4 * (of.flow.omega * at.radius + of.flow.v_inplane);
    const double none = 0.0;
    const Azimuths mean{1, &none, &none};
    Mask found{};
    for (double off : {0.0, 0.04, 0.1, 0.2}) {
        const Lanes v = inflow_at_angle(of, at, stall + off * of.stall_scale());
        Mask below = lanes & (v < inflow - margin);
        if (!any(below)) continue;
        const Lanes asked = below ? v : inflow;
        const Lanes wake = absolute(wake_thrust(of.rotor, at.radius, of.flow, of.windmill, asked));
        if (of.psi.count > 1) below &= of.residual(at, asked, mean).v < 0.5 * wake;
        if (any(below)) found |= below & (of.residual(at, asked).v < 0.0);
    }
    return any(found);
}

inline constexpr double close_enough = 3e-6;  // last Newton step, relative to `speed_scale`; the next one would be 1e-11

// Improve the inflow at all nodes by at most `most` Newton steps.  A node has converged if its step is at most `close`
// times `speed_scale` and the residual decreases with v_i.  Each step is computed for all groups before the next step, so
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
// return false and mark their blocks in `near_stall`.
template <class R> bool solve_attached(const Annuli<R>& of, Disk& disk, std::vector<bool>& near_stall) {
    near_stall.assign(disk.blocks(), false);
    const auto all_sure = [&](const Azimuths& over, double close, int most) {
        newton(of, disk, over, close, most);
        bool all = true;
        for (int g = 0; g < disk.groups; ++g) {
            const Mask sure = disk.ended[g] & surely_largest(of, disk.at[g], disk.inflow[g]);
            for (int k = 0; k < width && g * width + k < disk.nodes; ++k)
                if (!sure[k]) near_stall[(g * width + k) / block] = true, all = false;
        }
        return all;
    };
    for (int g = 0; g < disk.groups; ++g) disk.inflow[g] = attached_guess(of, disk.at[g]);
    if (!all_sure(of.few, 3e-3, 5) || !all_sure(of.psi, close_enough, 6)) return false;
    for (int g = 0; g < disk.groups && !disk.several; ++g)
        disk.several = Disk::counts_roots(g) && several_roots(of, disk.at[g], disk.inflow[g], ~Mask{});
    return true;
}

// --- The search for folds ------------------------------------------------------------------------------------------

// Compute the humps at these radii.
template <class R> void look_at(const Annuli<R>& of, const std::vector<double>& radii, Folds& folds) {
    Hump found[width];
    for (std::size_t first = 0; first < radii.size(); first += width) {
        const int count = int(std::min<std::size_t>(width, radii.size() - first));
        humps_at(of, each_lane([&](int k) { return radii[first + std::min(k, count - 1)]; }), count, folds.side, found);
        for (int k = 0; k < count; ++k)
            if (!std::isnan(found[k].height)) folds.humps.push_back(found[k]);
    }
    std::sort(folds.humps.begin(), folds.humps.end(), [](const Hump& a, const Hump& b) { return a.radius < b.radius; });
}

// Choose the radii of every `every`-th node of the blocks, and radii close to the ends of the blade.
inline void radii_in_blocks(const Disk& disk, const std::vector<bool>& blocks, int every, std::vector<double>& radii) {
    const double root = disk.edge[0].radius, tip = disk.edge[disk.panels].radius;
    const double inset = 1e-5 * (tip - root);  // a fold may lie between an end of the blade and the node next to it
    thread_local std::vector<double> all;
    all.clear(), radii.clear();
    for (int b = 0; b < disk.blocks(); ++b) {
        if (!blocks[b]) continue;
        if (b == 0) all.push_back(root + inset);
        for (int node = b * block; node < std::min((b + 1) * block, disk.nodes); ++node) all.push_back(disk.radius(node));
        if (b + 1 == disk.blocks()) all.push_back(tip - inset);
    }
    for (std::size_t k = 0; k < all.size(); ++k)
        if (all.size() <= 8 || k % every == 0 || k + 1 == all.size()) radii.push_back(all[k]);
}

// Shares of the momentum thrust.  Heights below `small_height` are small.  Next to a hump with a height below `touching_height`,
// more humps are computed: measured blades vary between their stations, so the height may change sign between two humps.
// (Without this limit, loads changed at 3 of 5,000 random points, at one by 0.8 % of the static load.)
inline constexpr double small_height = 0.3, touching_height = 0.04;

// Choose the blocks next to blocks near stall.  Exclude a block if the height of the nearest hump is positive and large, and
// if the linear extrapolation of this height to the block exceeds half of this height.
inline std::vector<bool> blocks_beside(const Disk& disk, const std::vector<bool>& near_stall, const std::vector<Hump>& humps) {
    std::vector<bool> chosen(disk.blocks());
    for (int b = 0; b < disk.blocks(); ++b) {
        if (near_stall[b] || !((b > 0 && near_stall[b - 1]) || (b + 1 < disk.blocks() && near_stall[b + 1]))) continue;
        const double y = disk.radius(std::min(b * block + block / 2, disk.nodes - 1));
        const auto nearest = std::min_element(humps.begin(), humps.end(), [&](const Hump& a, const Hump& b) {
            return std::fabs(a.radius - y) < std::fabs(b.radius - y);
        });
        const bool far = nearest != humps.end() && nearest->height > 0.0 && nearest->share >= small_height &&
                         nearest->height + nearest->slope * (y - nearest->radius) > 0.5 * nearest->height;
        chosen[b] = !far;
    }
    return chosen;
}

// Return where in the gap between two humps another hump is needed because folds may hide there, as a fraction of the gap;
// 0 if none is needed.  The height in between is interpolated by a cubic from values and derivatives.
inline double place_between(const Hump& a, const Hump& b, double tip) {
    const double gap = b.radius - a.radius;
    if (gap < 1e-5 * tip || gap > 0.2 * tip) return 0.0;
    const Cubic cubic(a.height, a.slope * gap, b.height, b.slope * gap);
    const bool crosses = (a.height < 0.0) != (b.height < 0.0);
    const double nearest = std::min(std::fabs(a.height), std::fabs(b.height));
    // An extreme may hide two folds if it is near zero, if its sign differs from the sign of one or both heights, or if
    // both heights are small and the humps are far apart.
    double t[2];
    for (int e = cubic.extremes(t) - 1; e >= 0; --e) {
        const double there = cubic.at(t[e]);
        const bool far = gap < 0.02 * tip || a.share >= small_height || b.share >= small_height;
        if (!crosses && (there < 0.0) == (a.height < 0.0) && std::fabs(there) > 0.7 * nearest && far) continue;
        const double least = crosses ? 0.02 : 1e-6 * tip / gap;
        if (t[e] > least && t[e] < 1.0 - least) return t[e];
    }
    // A top at one radius and a shoulder at the other may be unrelated.  The height then jumps between the radii, and its
    // change differs from the prediction of the slopes.  (Without this rule, loads changed at 2 of 5,000 points by 3e-4.)
    const double jump = b.height - a.height - 0.5 * gap * (a.slope + b.slope);
    if (!crosses && a.top != b.top && gap > 0.004 * tip && nearest < 4.0 * std::fabs(jump)) return 0.5;
    return (a.share < touching_height || b.share < touching_height) && gap > 0.012 * tip ? 0.5 : 0.0;
}

// Search for folds in the blocks near stall; in all other blocks, flow is attached.  If panels will not `follow` the
// folds, find only the humps.
template <class R>
void find_folds(const Annuli<R>& of, Disk& disk, const std::vector<bool>& near_stall, bool follow, Folds& folds) {
    const double root = of.rotor.root(), tip = of.rotor.tip();
    // Choose the sign of stall for which the ratio of the angle of attack without inflow to the stall angle is largest.
    double positive = 0.0, negative = 0.0;
    for (const auto& at : disk.at) {
        const Lanes angle = angle_at(at, of.flow.omega * at.radius, broadcast(of.flow.v_axial));
        const Lanes up = angle / of.stall_angle(at, 1.0), down = angle / of.stall_angle(at, -1.0);
        for (int k = 0; k < width; ++k) positive = std::max(positive, up[k]), negative = std::max(negative, down[k]);
    }
    folds.side = negative > positive ? -1.0 : 1.0;
    folds.humps.clear(), folds.count = 0;
    // Heights have derivatives, so every second node is sufficient, or every fourth if panels do not follow stall.
    const int every = follow ? 2 : 4;
    thread_local std::vector<double> radii;
    radii_in_blocks(disk, near_stall, every, radii), look_at(of, radii, folds);
    radii_in_blocks(disk, blocks_beside(disk, near_stall, folds.humps), every, radii), look_at(of, radii, folds);
    const auto& humps = folds.humps;
    for (int round = 0; round < 6; ++round) {
        radii.clear();
        for (std::size_t k = 0; k + 1 < humps.size(); ++k)
            if (const double place = place_between(humps[k], humps[k + 1], tip); place > 0.0)
                radii.push_back(humps[k].radius + place * (humps[k + 1].radius - humps[k].radius));
        if (radii.empty()) break;
        look_at(of, radii, folds);
    }
    for (const Hump& hump : humps) disk.several |= hump.three_roots;
    for (std::size_t k = 0; follow && k + 1 < humps.size() && folds.count < most_folds; ++k) {
        if ((humps[k].height < 0.0) == (humps[k + 1].height < 0.0)) continue;
        const Edge found = fold_between(of, humps[k], humps[k + 1], folds.side);
        if (!(found.radius > root && found.radius < tip)) continue;
        // Two edges at the same radius are one edge.
        if (folds.count > 0 && std::fabs(found.radius - folds.edge[folds.count - 1].radius) < 1e-6 * tip) continue;
        folds.edge[folds.count++] = found;
        disk.several |= found.kind == Edge::Kind::top;
    }
}

// --- The inflow at the nodes ---------------------------------------------------------------------------------------

// Forecast of the largest root at the radius in each lane, from the nearest humps on both sides.
struct Forecast {
    Mask known{};   // whether there are humps nearby; if not, nothing else is known
    Mask single{};  // both humps are shoulders and the residual decreases with v_i: (11) has one root
    Mask clear{};   // for both humps: g has no other maximum between the hump and `below`
    Mask attached{}, stalled{};  // the root is above the hump, or below it; both are false if either is possible
    Lanes hump, below;  // v_i of the hump, and a smaller v_i at which the residual is positive; NaN if unknown
    Lanes root;         // estimate of the largest root; NaN if unknown
};
template <class R> Forecast forecast(const Annuli<R>& of, const Folds& folds, const Station<Lanes>& at) {
    Forecast f{};
    // On the windmill branch, forecasts for laws with a sharper stall than those of the paper led to smaller roots.  (12 of
    // 100,000 random points with such laws erred by 0.14 to 2.9 % of the static load.)
    if (of.windmill && of.rotor.law.plain_stall && of.stall_scale() < 1.0) return f;
    const auto& humps = folds.humps;
    const double reach = 0.12 * of.rotor.tip();  // largest distance to the nearest hump
    if (humps.empty() || !any((at.radius >= humps.front().radius - reach) & (at.radius <= humps.back().radius + reach))) return f;
    Lanes past = broadcast(std::nan("")), below = past, root = past;
    auto after = humps.begin();
    for (int k = 0; k < width; ++k) {
        const double y = at.radius[k];  // increases with k
        while (after != humps.end() && after->radius < y) ++after;
        const Hump& a = after == humps.begin() ? *after : *(after - 1);
        const Hump& b = after == humps.end() ? a : *after;
        if (std::min(std::fabs(y - a.radius), std::fabs(b.radius - y)) > reach) continue;
        // A hump on the far side of a fold does not predict the branch on this side.
        bool inner = true, outer = true;
        for (int e = 0; e < folds.count; ++e) {
            const double fold = folds.edge[e].radius;
            if (folds.edge[e].kind == Edge::Kind::angle) continue;
            inner &= !((a.radius < fold) == (fold < y)), outer &= !((y < fold) == (fold < b.radius));
        }
        const double share = b.radius > a.radius ? (y - a.radius) / (b.radius - a.radius) : 0.0;
        past[k] = a.past_stall + share * (b.past_stall - a.past_stall);
        below[k] = a.below > b.below || std::isnan(a.below) ? a.below : b.below;
        f.known[k] = -1;
        f.single[k] = -(!a.top && !b.top && a.single_root && b.single_root);
        f.clear[k] = -(a.clear && b.clear);
        f.attached[k] = -((inner || outer) && (a.height > 0.0 || !inner) && (b.height > 0.0 || !outer));
        f.stalled[k] = -((inner || outer) && (a.height < 0.0 || !inner) && (b.height < 0.0 || !outer));
        if (f.attached[k] || f.stalled[k]) root[k] = !outer ? a.root : !inner ? b.root : a.root + share * (b.root - a.root);
    }
    const Lanes stall = of.stall_angle(at, folds.side);
    f.hump = inflow_at_angle(of, at, stall + past), f.below = inflow_at_angle(of, at, stall + below);
    // Interpolated roots are too inexact if the residual bends elsewhere than near stall, or if stall is sharper than the
    // paper's (3 of 20,000 points erred by up to 0.2 %).
    if (of.stall_scale() < 1.0 || !of.bends_near_stall_only()) root = broadcast(std::nan(""));
    f.root = inflow_at_angle(of, at, stall + root);
    f.known &= f.hump == f.hump;
    if (!of.bends_near_stall_only()) f.single = f.clear = Mask{};
    // Near the hub, hub loss removes momentum thrust and humps vary quickly.  Forecasts there led to smaller roots.
    if (const double hub = of.rotor.hub_radius; hub > 0.0) f.known &= at.radius > 1.5 * hub;
    // Deep in reverse flow, stall covers most azimuths.  At these radii, use only forecasts of a single root; on the
    // windmill branch, use none (there they caused errors of up to 0.4 % at 3 of 100,000 random points).
    f.known &= (of.windmill ? Mask{} : f.single) | (of.flow.v_inplane < 1.4 * (of.flow.omega * at.radius));
    return f;
}

// Return the lanes whose root v is on the branch of the forecast and therefore is the largest root.
template <class R> Mask as_forecast(const Annuli<R>& of, const Station<Lanes>& at, const Forecast& f, double side, Lanes v, Mask asked) {
    // Above this inflow, (10) increases with v_i.
    const auto turn = turning_points(of.flow.v_axial, of.flow.v_inplane);
    const double rises = of.windmill || turn.second <= turn.first ? -INFINITY : turn.second;
    const Lanes near = 0.003 * speed_scale(of, at);
    asked &= f.known & (v >= rises);
    const Mask settled = asked & ((v > f.hump + near) | f.single | (f.attached & (v > f.hump - near)));
    const Mask beneath = asked & f.clear & (v < f.hump + near) & (side < 0.0 ? v == v : v > f.below - near);
    return settled | (f.stalled & beneath);
}

// Scan at one radius.  If V sin(beta) > Omega y, stall covers most azimuths.  In climb, a scan over few azimuths is then
// sufficient, if it finds one root and all azimuths confirm the bracket of this root.
template <class R> Scan scan_node(const Annuli<R>& of, double radius, Samples& samples) {
    if (of.flow.v_axial >= 0.0 && of.flow.v_inplane > of.flow.omega * radius && of.few.count < of.psi.count) {
        const Scan found = scan(of, radius, of.few, samples);
        const auto g = of.residual(of.station(broadcast(radius)), each_lane([&](int k) { return k == 0 ? found.high : found.low; }));
        if (found.roots == 1 && g.v[0] < 0.0 && g.v[1] >= 0.0) return found;
    }
    return scan(of, radius, of.psi, samples);
}

// Find the largest root at these nodes by scans.
template <class R> void scan_nodes(const Annuli<R>& of, Disk& disk, std::span<const int> nodes) {
    thread_local Samples samples;
    for (std::size_t first = 0; first < nodes.size(); first += width) {
        const auto node = [&](int k) { return nodes[std::min(first + k, nodes.size() - 1)]; };
        const Lanes radius = each_lane([&](int k) { return disk.radius(node(k)); });
        Lanes low, high, guess;
        for (int k = 0; k < width; ++k) {
            if (first + k >= nodes.size()) { low[k] = low[k - 1], high[k] = high[k - 1], guess[k] = guess[k - 1]; continue; }
            const Scan found = scan_node(of, radius[k], samples);
            low[k] = found.low, high[k] = found.high, guess[k] = found.roots > 0 ? found.guess : std::nan("");
            disk.several |= found.roots > 1;
        }
        const Lanes v = polished_roots(of, of.station(radius), low, high, guess);
        for (int k = 0; k < width; ++k) disk.inflow[node(k) / width][node(k) % width] = v[k];
    }
}

// Find the inflow at all nodes.  Newton's method starts at the forecast of the root or, without forecast, in attached flow.
// Its root is accepted if it is in attached flow or on the branch of the forecast.  At all other nodes, a scan finds the
// root.  Without `folds`, there is no forecast.
template <class R> void solve_nodes(const Annuli<R>& of, Disk& disk, const Folds& folds) {
    thread_local std::array<Forecast, most_nodes / width + 1> forecasts;
    for (int g = 0; g < disk.groups; ++g) {
        forecasts[g] = forecast(of, folds, disk.at[g]);
        const Lanes root = forecasts[g].root;
        disk.inflow[g] = (forecasts[g].known & (root == root)) ? root : attached_guess(of, disk.at[g]);
    }
    newton(of, disk, of.few, 1e-3, 4);
    newton(of, disk, of.psi, close_enough, 6);
    std::array<int, most_nodes + width> open;
    int left = 0;
    for (int g = 0; g < disk.groups; ++g) {
        const auto& at = disk.at[g];
        const Lanes v = disk.inflow[g];
        const Mask sure = disk.ended[g] & surely_largest(of, at, v);
        const Mask found = sure | as_forecast(of, at, forecasts[g], folds.side, v, disk.ended[g] & ~sure);
        if (!of.windmill && Disk::counts_roots(g)) disk.several = disk.several || several_roots(of, at, v, sure);
        for (int k = 0; k < width; ++k)
            if (!found[k]) open[left++] = g * width + k;
    }
    scan_nodes(of, disk, {open.data(), std::size_t(left)});
}

}  // namespace propmap
