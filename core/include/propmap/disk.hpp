// The inflow over the whole disk: radial panels that meet where stall begins or ends, v_i at their nodes.
#pragma once

#include "annulus.hpp"

namespace propmap {

inline constexpr int most_nodes = 1100;
inline constexpr int most_edges = 12;

// Nodes and weights of Gauss and Legendre on [-1, 1], and the last polynomials there.
struct GaussRule {
    static constexpr int tail = 4;  // polynomials of highest degree, whose coefficients tell the error
    std::vector<double> node, weight;
    std::vector<double> last;  // (2 k + 1) P_k at the nodes for the highest k, (tail, n)

    explicit GaussRule(int n) : node(n), weight(n), last(std::size_t(tail) * n) {
        for (int i = 0; i < n; ++i) {
            double x = std::cos(pi * (n - 1 - i + 0.75) / (n + 0.5)), slope = 1.0;
            for (int step = 0; step < 100; ++step) {
                double before = 1.0, here = x;
                for (int k = 1; k < n; ++k) {
                    const double next = ((2 * k + 1) * x * here - k * before) / (k + 1);
                    before = here, here = next;
                }
                slope = n * (x * here - before) / (x * x - 1.0);
                const double change = here / slope;
                x -= change;
                if (std::fabs(change) < 1e-15) break;
            }
            node[i] = x, weight[i] = 2.0 / ((1.0 - x * x) * slope * slope);
            double before = 1.0, here = x;
            for (int k = 1; k < n; ++k) {
                if (k >= n - tail) last[std::size_t(k - (n - tail)) * n + i] = (2 * k + 1) * here;
                const double next = ((2 * k + 1) * x * here - k * before) / (k + 1);
                before = here, here = next;
            }
        }
    }
};

// Rules by their number of nodes, made when first asked for.
const GaussRule& gauss_rule(int nodes);

// A panel's node in share of the panel, and its weight.  The radius is crowded towards the outer edge, or, of
// several panels, half-way towards both: at a fold the inflow varies like a square root of the distance, and
// so does the chord at the tip.
struct PanelNode {
    double place, weight;
};
inline PanelNode panel_node(const GaussRule& rule, int k, bool both) {
    const double t = 0.5 * (rule.node[k] + 1.0), w = 0.5 * rule.weight[k];
    if (!both) return {t * (2.0 - t), w * 2.0 * (1.0 - t)};
    return {0.5 * (t * t * (3.0 - 2.0 * t) + t), w * (0.5 * (6.0 * t * (1.0 - t)) + 0.5)};
}

// Panels along the blade, and the inflow at their nodes.
struct Disk {
    int panels = 1;
    std::array<double, most_edges + 2> edge;   // rising [m], root and tip included
    std::array<Fold, most_edges + 2> fold;     // that an edge follows, where `moves`
    std::array<bool, most_edges + 2> moves{};
    std::array<int, most_edges + 1> count;     // nodes of each panel
    int nodes = 0;
    std::vector<double> inflow;                // v_i at the nodes [m/s], NaN where not found
    bool several = false;                      // whether (11) has several roots somewhere
    bool attached = true;                      // whether no node is near stall
};

// The nodes' radii and weights [m], in lanes; those beyond the last repeat it with no weight.  With `S` dual
// they move with the edges.
template <class T> struct NodeLanes {
    T radius, weight;
};
template <class S> auto node_lanes(const Disk& disk, const std::array<S, most_edges + 2>& edge, int group) {
    using T = decltype(Lanes{} * edge[0]);
    NodeLanes<T> r{};
    int panel = 0, first = 0;
    for (int k = 0; k < width; ++k) {
        const int node = std::min(group * width + k, disk.nodes - 1);
        while (node >= first + disk.count[panel]) first += disk.count[panel++];
        const auto n = panel_node(gauss_rule(disk.count[panel]), node - first, disk.panels > 1);
        const S span = edge[panel + 1] - edge[panel];
        const S y = edge[panel] + span * n.place;
        const S w = span * (group * width + k < disk.nodes ? n.weight : 0.0);
        if constexpr (IsDual<S>) {
            r.radius.v[k] = y.v, r.weight.v[k] = w.v;
            for (int d = 0; d < directions_of<S>; ++d) r.radius.d[d][k] = y.d[d], r.weight.d[d][k] = w.d[d];
        } else {
            r.radius[k] = y, r.weight[k] = w;
        }
    }
    return r;
}
inline int groups_of(const Disk& disk) { return (disk.nodes + width - 1) / width; }

// Whether (11) has more than one root below a largest one in attached flow: past stall the residual, positive
// below a single root, is negative then.  Where a blade without azimuths is far from that, it is not looked at.
template <class R> bool several_roots(const Annuli<R>& of, const Station<Lanes>& at, Lanes inflow) {
    const Lanes speed = of.rms_speed(at);
    const Lanes margin = 1e-4 * (of.flow.omega * at.radius + of.flow.v_inplane);
    const double none = 0.0;
    const Azimuths mean{1, &none, &none};
    Mask found{};
    for (double off : {0.0, 0.04, 0.1, 0.2}) {
        const Lanes angle = each_lane([&](int k) {
            return of.stall_angle(at.reynolds_per_speed[k], at.radius[k], 1.0) + off * of.stall_scale();
        });
        const auto stall = sine_cosine(angle);
        const Lanes rise = at.sine * stall.cosine - at.cosine * stall.sine;
        const Lanes run = at.cosine * stall.cosine + at.sine * stall.sine;
        const Lanes v = speed * rise / maximum(run, 0.05) - of.flow.v_axial;
        const Mask below = (v < inflow - margin) & (run > 0.05);
        if (!any(below)) continue;
        const Lanes wake = absolute(wake_thrust(of.rotor, at.radius, of.flow, of.windmill, v));
        if (of.psi.count > 1 && !any(below & (of.residual(at, v, mean).v < 0.5 * wake))) continue;
        found |= below & (of.residual(at, v).v < 0.0);
    }
    return any(found);
}

// Find the inflow at the nodes of the disk's panels.  With `attached_only` give up where some node is near stall.
template <class R> bool solve_nodes(const Annuli<R>& of, Disk& disk, bool attached_only) {
    disk.nodes = 0;
    for (int p = 0; p < disk.panels; ++p) disk.nodes += disk.count[p];
    disk.inflow.resize(std::size_t(groups_of(disk)) * width);
    disk.attached = true;
    std::array<int, most_nodes + width> open;
    int left = 0;
    for (int g = 0; g < groups_of(disk); ++g) {
        const auto nodes = node_lanes(disk, disk.edge, g);
        const auto at = of.station(nodes.radius);
        AttachedRoots roots{};
        if (!of.windmill) roots = attached_roots(of, at);
        for (int k = 0; k < width; ++k) {
            const int node = g * width + k;
            disk.inflow[node] = roots.inflow[k];
            if (!roots.sure[k] && node < disk.nodes) open[left++] = node;
        }
        if (left && attached_only) return disk.attached = false;
        if (!disk.several && !any(~roots.sure) && g % 3 == 0) disk.several = several_roots(of, at, roots.inflow);
    }
    disk.attached = left == 0;
    Samples samples;
    for (int first = 0; first < left; first += width) {
        Lanes radius, low, high, guess;
        for (int k = 0; k < width; ++k) {
            const int node = open[std::min(first + k, left - 1)];
            if (first + k < left) {
                radius[k] = node_lanes(disk, disk.edge, node / width).radius[node % width];
                const Scan found = scan(of, radius[k], samples);
                low[k] = found.low, high[k] = found.high;
                guess[k] = found.found ? found.guess : std::nan("");
                disk.several |= found.roots > 1;
            } else {
                radius[k] = radius[k - 1], low[k] = low[k - 1], high[k] = high[k - 1], guess[k] = guess[k - 1];
            }
        }
        const Lanes v = polished_roots(of, of.station(radius), low, high, guess);
        for (int k = 0; k < width && first + k < left; ++k) disk.inflow[open[first + k]] = v[k];
    }
    return disk.attached;
}

// Look along the blade for folds: radii at which the hump's height passes zero.  Between two radii the height
// is a cubic, as its slope is known; where that turns towards zero, two folds may hide, and one looks closer.
template <class R> int find_folds(const Annuli<R>& of, std::array<Fold, most_edges>& folds, bool& several) {
    const double root = of.rotor.root(), tip = of.rotor.tip(), span = tip - root;
    const auto& f = of.flow;
    // The sign of the angle of attack without inflow tells at which stall to look.
    const double out = root + 0.6 * span;
    const auto beside = of.station(broadcast(out));
    const double side = beside.sine[0] * f.omega * out - beside.cosine[0] * f.v_axial < 0.0 ? -1.0 : 1.0;
    std::vector<Hump> seen;
    const int even = 20;
    for (int k = 0; k < even; ++k) seen.push_back(hump_at(of, root + span * (1.0 - 1e-6) * k / (even - 1.0), side));
    for (int round = 0; round < 6; ++round) {
        std::vector<Hump> finer;
        bool changed = false;
        for (std::size_t k = 0; k < seen.size(); ++k) {
            finer.push_back(seen[k]);
            if (k + 1 == seen.size()) break;
            const Hump &a = seen[k], &b = seen[k + 1];
            const double width_ = b.radius - a.radius;
            if (!std::isfinite(a.height + b.height) || width_ < 1e-5 * tip) continue;
            Samples s;  // of the height over minus the radius
            s.append(-a.radius, a.height, -a.slope), s.append(-b.radius, b.height, -b.slope);
            const Cubic cubic(s, 0);
            double t[2];
            const int extremes = cubic.extremes(t);
            const bool crosses = (a.height < 0.0) != (b.height < 0.0);
            for (int e = extremes - 1; e >= 0; --e) {
                const double there = cubic.at(t[e]), nearest = std::min(std::fabs(a.height), std::fabs(b.height));
                if (!crosses && (there < 0.0) == (a.height < 0.0) && std::fabs(there) > 0.5 * nearest) continue;
                if (t[e] < 0.02 || t[e] > 0.98) continue;
                finer.push_back(hump_at(of, a.radius + t[e] * width_, side));
                changed = true;
                break;
            }
        }
        std::sort(finer.begin(), finer.end(), [](const Hump& a, const Hump& b) { return a.radius < b.radius; });
        seen.swap(finer);
        if (!changed) break;
    }
    int count = 0;
    for (std::size_t k = 0; k < seen.size(); ++k) {
        several |= seen[k].folded;
        if (k + 1 == seen.size() || count == most_edges) continue;
        const Hump &a = seen[k], &b = seen[k + 1];
        if (!std::isfinite(a.height + b.height) || (a.height < 0.0) == (b.height < 0.0)) continue;
        folds[count] = fold_between(of, a, b, side);
        if (folds[count].radius > root && folds[count].radius < tip) several |= folds[count].top, ++count;
    }
    return count;
}

// Panels that meet at the folds: at least three, with edges of their own where there are fewer folds.
template <class R> void follow_stall(const Annuli<R>& of, Disk& disk, int nodes) {
    std::array<Fold, most_edges> folds;
    const int found = find_folds(of, folds, disk.several);
    const double root = of.rotor.root(), span = of.rotor.tip() - root;
    struct Edge {
        double radius;
        int fold;
    };
    std::vector<Edge> edges;
    for (int k = 0; k < found; ++k) edges.push_back({folds[k].radius, k});
    for (int k = found; k < 2; ++k) edges.push_back({root + span * (k == 0 ? 0.25 : 0.6), -1});
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.radius < b.radius; });
    disk.panels = int(edges.size()) + 1;
    disk.edge[0] = root, disk.edge[disk.panels] = of.rotor.tip();
    disk.moves.fill(false);
    for (int k = 0; k + 1 < disk.panels; ++k) {
        disk.edge[k + 1] = edges[k].radius;
        disk.moves[k + 1] = edges[k].fold >= 0;
        if (edges[k].fold >= 0) disk.fold[k + 1] = folds[edges[k].fold];
    }
    if (disk.panels == 3) {
        disk.count[0] = nodes / 4, disk.count[1] = 3 * nodes / 8;
        disk.count[2] = nodes - disk.count[0] - disk.count[1];
    } else {
        for (int p = 0; p < disk.panels; ++p) disk.count[p] = nodes / disk.panels + 2;
    }
}

inline void single_panel(Disk& disk, double root, double tip, int nodes) {
    disk.panels = 1;
    disk.edge[0] = root, disk.edge[1] = tip;
    disk.moves.fill(false);
    disk.count[0] = nodes;
}

}  // namespace propmap
