// Quadrature over the disk: numbers of nodes, and nodes and weights of panels and azimuths.
#pragma once

#include <map>
#include <mutex>
#include <vector>

#include "velocities.hpp"

namespace propmap {

// Numbers of nodes, and limits of the error estimate `tail`, determined with random section laws (docs/theory.md).
struct Accuracy {
    struct Share {
        double advance;  // up to this V sin(beta)/(Omega R)
        int azimuths;    // over a full turn
    };
    std::vector<Share> azimuths;
    int free, stalled, fast;  // radial nodes: without stall, with panels that follow stall, with a single panel in stall
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
    // The number of azimuths, proportional to the sharpness of stall.  `times` counts the evaluations before this
    // one.  From times = 2 on, each evaluation uses the next larger number in `counts`.
    int azimuths_at(double advance, double sharper, int times) const {
        std::size_t k = 0;
        while (k + 1 < azimuths.size() && advance > azimuths[k].advance) ++k;
        const int wanted = int(std::ceil(azimuths[k].azimuths * sharper - 1e-6));
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

// Nodes and weights of one panel, relative to its length, and the Legendre polynomials that estimate the error.
//
// Gauss-Legendre nodes t are mapped, because inflow near a fold and chord near the tip vary as the square root of the
// distance.  On a single panel, the mapped nodes are dense near the tip.  On each of several panels (`both`), they are
// dense near both edges, less strongly.
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

// Return the rule with this number.  The rule is constructed on first use and stored.
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

}  // namespace propmap
