// The hybrid inflow v_i(y) of an annulus: the largest root of eq. (11), element thrust (5) = momentum thrust (10).
//
// docs/root-search.md explains the search with pictures, in the terms and the order of this file.  The terms:
// - Residual g(v_i): (5) minus (10).  It is negative for all v_i above the largest root.
// - Top: the local maximum of g near stall.  Shoulder: if there is none, the inflow near stall at which g is flattest.
// - Hump: the top or, if there is none, the shoulder.  Height of the hump: the residual there.
// - Attached branch: the inflows above the hump.  Stalled branch: the inflows below the hump.  At negative angles of
//   attack, both branches keep these names, although flow is stalled above the hump.
//   If the height is positive, the largest root is above the hump; if it is negative, below the hump.
// - Fold: a radius at which the height is zero.  At a fold with a top, the largest root jumps from one branch to the
//   other.  At a fold with a shoulder, this root varies most steeply along the blade.
//
// Each lane of a `Lanes` belongs to one radius, or to one trial inflow at one radius.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "inflow.hpp"

namespace propmap {

// --- The residual --------------------------------------------------------------------------------------------------

// Equation (11) at one operating point.
template <class R> struct Annuli {
    const R& rotor;
    Flow<double> flow;
    Azimuths psi;   // over which (5) is averaged
    Azimuths few;   // fewer azimuths, for evaluations far from a root
    bool windmill;  // whether the windmill branch of momentum theory applies, see wake.hpp

    Station<Lanes> station(Lanes radius) const { return station_at(rotor, flow.omega, radius); }

    // The residual per meter of radius, divided by the density [m^3/s^2], with its derivative by the inflow.
    Dual<Lanes, 1> residual(const Station<Lanes>& at, Lanes inflow, const Azimuths& over) const {
        const Dual<Lanes, 1> v{inflow, {broadcast(1.0)}};
        return annulus_thrust(rotor, at, flow, v, over) -
               wake_thrust(rotor, at.radius, flow, windmill, v);  // Eq. (11)
    }
    Dual<Lanes, 1> residual(const Station<Lanes>& at, Lanes inflow) const { return residual(at, inflow, psi); }

    // Root mean square of U_T over azimuth [m/s].  In this file, the mean angle of attack is computed with this U_T.
    Lanes rms_speed(const Station<Lanes>& at) const {
        const Lanes turning = flow.omega * at.radius;
        return square_root(turning * turning + (0.5 * flow.v_inplane * flow.v_inplane + 1e-18));
    }
    // Stall angle [rad] for U = Omega y, at positive (side = 1) or negative (side = -1) angles of attack.
    Lanes stall_angle(const Station<Lanes>& at, double side) const {
        return each_lane([&](int k) {
            return value(rotor.law.stall_angle(at.reynolds_per_speed[k] * flow.omega * at.radius[k], side));
        });
    }
    // Whether the slope of the residual changes quickly (g bends) near stall only.  Lift of some laws also bends
    // in deep stall.  In descent with tip or hub loss, Prandtl's factor peaks at 1 and bends g at v_i = -V cos(beta).
    bool bends_near_stall_only() const {
        return rotor.law.plain_stall && rotor.law.stall_delay == 0.0 &&
               !(flow.v_axial < 0.0 && (rotor.tip_loss || rotor.hub_radius > 0.0));
    }
    // Spacing of samples near stall, relative to that for the paper's M = 50: a sharper stall needs closer samples.
    double stall_scale() const { return std::min(rotor.law.stall_width() / 0.02, 1.0); }
};

template <class R> Lanes speed_scale(const Annuli<R>& of, const Station<Lanes>& at) {  // typical speed of the air [m/s]
    return of.rms_speed(at) + std::fabs(of.flow.v_axial);
}

// Angle of attack relative to zero lift [rad] at the velocity (U_T, U_P).
inline Lanes angle_at(const Station<Lanes>& at, Lanes u_t, Lanes u_p) {
    const Lanes per = 1.0 / square_root(u_t * u_t + u_p * u_p + 1e-30);
    return radians(at.line - Angle<Lanes>{u_p * per, u_t * per, {}});
}

// Inflow at which the mean angle of attack is `angle` [rad]; NaN if the flow would be almost parallel to the axis.
template <class R> Lanes inflow_at_angle(const Annuli<R>& of, const Station<Lanes>& at, Lanes angle) {
    const auto phi = at.line - angle_from(angle);
    return phi.cosine > 0.05 ? of.rms_speed(at) * phi.sine / phi.cosine - of.flow.v_axial : broadcast(std::nan(""));
}

// --- Attached flow -------------------------------------------------------------------------------------------------

// First guess of v_i [m/s]: the root of (11) in attached flow without drag: v W = k (U_T^2 theta - U_T U_P).  W is the
// square root in (10), k = N_b c_l1 c/(8 pi y), with the Reynolds factor on c_l1.  Do four Newton steps from above the root.
template <class R> Lanes attached_guess(const Annuli<R>& of, const Station<Lanes>& at) {
    const auto& f = of.flow;
    const Lanes speed = of.rms_speed(at);
    const double slope = of.rotor.blade->blades * value(of.rotor.law.attached_slope()) / (8.0 * pi);
    const Lanes k = slope * at.lift_growth * at.chord / at.radius;
    const Lanes lift = k * speed * speed * at.line.sine, loss = k * f.omega * at.radius * at.line.cosine;
    Lanes v = square_root(maximum(lift, 0.0)) + 1.5 * std::max(-f.v_axial, 0.0);
    for (int step = 0; step < 4; ++step) {
        const Lanes u = f.v_axial + v;
        const Lanes w = square_root(speed_squared(f.v_inplane, u));
        v = v + (lift - loss * u - v * w) / (loss + maximum(w + v * u / w, 1e-3 * w));
    }
    return v;
}

// Return the lanes whose root v is in attached flow at all azimuths and therefore is the largest root.
// If v >= 0, (5) decreases and (10) increases with v_i above v.  If v < 0, lift is negative.  From v to v_i = 0, (5)
// decreases and (10) increases, because no element stalls in this range.  Above v_i = 0, (5) is negative and (10) positive.
template <class R> Mask surely_largest(const Annuli<R>& of, const Station<Lanes>& at, Lanes v) {
    const auto& f = of.flow;
    const double margin = 3.0 * std::max(of.rotor.law.stall_width(), 0.02);  // [rad]: three widths of stall
    const Lanes turning = f.omega * at.radius;
    const Lanes slow = turning - f.v_inplane, fast = turning + f.v_inplane;  // U_T at psi = -pi/2 and pi/2
    const Lanes u = f.v_axial + v;
    const Lanes most = of.stall_angle(at, 1.0) - margin, least = of.stall_angle(at, -1.0) + margin;
    const Lanes one = angle_at(at, fast, u), other = angle_at(at, slow, u);
    const Lanes later = angle_at(at, slow, f.v_axial + maximum(v, 0.0));
    Mask sure = (slow > 0.0) & (maximum(one, other) < most) & (minimum(minimum(one, other), later) > least);
    const Mask climb = f.v_axial + Lanes{} >= 0.0;
    // On the windmill branch (10) increases with v_i for both directions of the flow through the disk.
    const Mask rises = of.windmill && of.bends_near_stall_only() ? v >= 0.0 : u >= 0.0;
    sure &= (v >= 0.0) ? rises : (climb & (f.v_axial + 2.0 * v > 0.0));
    return sure;
}

// --- Samples of the residual ---------------------------------------------------------------------------------------

struct Sample {
    double inflow;           // v_i [m/s]
    double residual, slope;  // g and dg/dv_i
};

// A sample whose residual is to be computed, at the radius in this lane of a station.
struct Request {
    int lane;
    Sample* sample;  // contains the inflow, receives the residual
};
template <class R>
void evaluate(const Annuli<R>& of, const Station<Lanes>& at, std::span<const Request> asked, const Azimuths& over) {
    for (std::size_t first = 0; first < asked.size(); first += width) {
        Lanes inflow;
        Mask lane;  // for each lane of `packed`: the lane of `at` that it contains
        for (int k = 0; k < width; ++k) {
            const Request& one = asked[std::min(first + k, asked.size() - 1)];
            inflow[k] = one.sample->inflow, lane[k] = one.lane;
        }
#ifdef __clang__
        const auto pick = [&](Lanes x) { return each_lane([&](int k) { return x[lane[k]]; }); };
#else
        const auto pick = [&](Lanes x) { return __builtin_shuffle(x, lane); };
#endif
        const auto turned = [&](const Angle<Lanes>& a) { return Angle<Lanes>{pick(a.sine), pick(a.cosine), {}}; };
        const Station<Lanes> packed{pick(at.radius), pick(at.chord), turned(at.line), turned(at.drag_line), pick(at.reynolds_per_speed),
                                    pick(at.inverse_root), pick(at.lift_growth), pick(at.drag_growth)};
        const auto g = of.residual(packed, inflow, over);
        for (int k = 0; k < width && first + k < asked.size(); ++k)
            asked[first + k].sample->residual = g.v[k], asked[first + k].sample->slope = g.d[0][k];
    }
}

// The cubic between two values with slopes, for t = 0 (first) to 1 (second).  Its derivative is a + b t + c t^2.
struct Cubic {
    double start, a, b, c;

    // `slope` and `next_slope` are derivatives with respect to t.
    Cubic(double value, double slope, double next_value, double next_slope) {
        const double rise = next_value - value;
        start = value, a = slope;
        c = 3.0 * (a + next_slope - 2.0 * rise), b = next_slope - a - c;
    }
    // The residual from a sample to the next one, which has a smaller inflow.
    Cubic(const Sample& from, const Sample& to)
        : Cubic(from.residual, -from.slope * (from.inflow - to.inflow), to.residual, -to.slope * (from.inflow - to.inflow)) {}

    double at(double t) const { return start + t * (a + t * (0.5 * b + t * c / 3.0)); }
    double root() const {  // where a negative value at t = 0 becomes positive
        double from = 0.0, to = 1.0;
        for (int step = 0; step < 12; ++step) (at(0.5 * (from + to)) < 0.0 ? from : to) = 0.5 * (from + to);
        return 0.5 * (from + to);
    }
    double slope(double t) const { return a + (b + c * t) * t; }

    // Write the extremes between t = 0 and 1 to `t` in increasing order, and return their number.
    int extremes(double (&t)[2]) const {
        int count = 0;
        const double square = b * b - 4.0 * a * c;
        if (square <= 0.0) return 0;
        const double q = -0.5 * (b + std::copysign(std::sqrt(square), b));
        for (double place : {c != 0.0 ? q / c : -1.0, q != 0.0 ? a / q : -1.0})
            if (place > 0.0 && place < 1.0) t[count++] = place;
        if (count == 2 && t[0] > t[1]) std::swap(t[0], t[1]);
        return count;
    }
};

// --- Scan: the largest root from samples over all inflows ----------------------------------------------------------

// The result of a scan at one radius.
struct Scan {
    int roots = 0;     // number of sign changes
    double low = 0.0, high = 0.0;  // bracket of the largest root [m/s], if there is one
    double guess = 0.0;  // estimate of this root from the cubic in the bracket [m/s]
};

struct Samples {
    static constexpr int most = 400;  // capacity
    int count = 0;
    std::array<Sample, most> at;
    std::array<Request, most> asked;

    // Evaluate the samples from number `first` on, at one radius, and sort all samples by decreasing inflow.
    template <class R>
    void evaluate_from(int first, const Annuli<R>& of, const Station<Lanes>& station, const Azimuths& over) {
        for (int k = first; k < count; ++k) asked[k] = {0, &at[k]};
        evaluate(of, station, {&asked[first], std::size_t(count - first)}, over);
        std::sort(at.begin(), at.begin() + count, [](const Sample& a, const Sample& b) { return a.inflow > b.inflow; });
    }
};

// The factor on the offsets of samples from the stall angle, at most 1.  It is larger in forward flight: some azimuths
// stall before others, so the annulus stalls over a wider range of mean angles.
template <class R> Lanes stall_spread(const Annuli<R>& of, const Station<Lanes>& at, Lanes stall) {
    const Lanes rise = absolute((at.line - angle_from(stall)).sine);  // sin(phi) at stall
    return minimum(of.stall_scale() + 5.0 * rise * of.flow.v_inplane / (of.flow.omega * at.radius + 1e-12), 1.0);
}

// Choose the first inflows of a scan.  Inflow angles are equally spaced, and closer around both stall angles, where the
// residual bends most.  Further inflows are zero, -V cos(beta), the turning points of (10), and far inflows, beyond which
// there is no root.
template <class R> void first_inflows(const Annuli<R>& of, const Station<Lanes>& at, double speed, Samples& samples) {
    const auto& f = of.flow;
    const double whole = speed + std::fabs(f.v_axial), line = radians(at.line)[0];
    samples.count = 0;
    const auto add = [&](double v) { samples.at[samples.count++].inflow = v; };
    const auto add_angle = [&](double phi) { if (std::fabs(phi) < 1.45) add(speed * std::tan(phi) - f.v_axial); };
    for (int k = -7; k <= 7; ++k) add_angle(0.2 * k);
    for (double side : {1.0, -1.0}) {
        const double stall = of.stall_angle(at, side)[0];
        const double spread = stall_spread(of, at, broadcast(stall))[0];
        for (double offset : {-0.2, -0.15, -0.11, -0.08, -0.055, -0.03, -0.01, 0.01, 0.03, 0.055, 0.09, 0.14})
            add_angle(line - (stall + side * spread * offset));
    }
    const auto turn = turning_points(f.v_axial, f.v_inplane);
    for (double v : {0.0, -f.v_axial, turn.first, turn.second}) add(v);  // no air passes the disk at v_i = -V cos(beta)
    for (double far : {10.0 * speed, 1e4 * whole}) add(far - f.v_axial), add(-far - f.v_axial);
    const auto at_end = samples.at.begin() + samples.count;
    std::sort(samples.at.begin(), at_end, [](const Sample& a, const Sample& b) { return a.inflow > b.inflow; });
    samples.count = int(std::unique(samples.at.begin(), at_end, [&](const Sample& a, const Sample& b) {
        return a.inflow - b.inflow < 1e-6 * speed;
    }) - samples.at.begin());
}

// Whether two more roots may hide between two samples.  Between residuals of opposite signs, any extreme of the cubic
// may hide roots.  Between residuals of the same sign, an extreme of the other sign or close to zero may hide roots.
inline bool may_hide_roots(const Sample& from, const Sample& to) {
    const Cubic cubic(from, to);
    const double g0 = from.residual, g1 = to.residual, end = cubic.slope(1.0);
    double t[2];
    const int extremes = cubic.extremes(t);
    const bool opposed = cubic.a * end < 0.0;
    if ((g0 < 0.0) != (g1 < 0.0)) return extremes > 0 || opposed;
    constexpr double close_to_zero = 0.7;  // of the smaller residual
    for (int e = 0; e < extremes; ++e) {
        const double there = cubic.at(t[e]);
        if ((there < 0.0) != (g0 < 0.0) || std::fabs(there) < close_to_zero * std::min(std::fabs(g0), std::fabs(g1))) return true;
    }
    // The residual may have a sharper extreme than the cubic.  The tangents at both samples bound this extreme.
    const double met = (g1 - g0 - end) / (cubic.a - end);
    return opposed && ((g0 + cubic.a * met) < 0.0) != (g0 < 0.0) && met > 0.0 && met < 1.0;
}

// Scan the residual over all inflows at one radius.  Every change of sign encloses a root.  Intervals that may
// hide two more roots receive more samples, in up to `rounds` rounds.
template <class R> Scan scan(const Annuli<R>& of, double radius, const Azimuths& over, Samples& samples) {
    const Station<Lanes> at = of.station(broadcast(radius));
    const double v_axial = std::fabs(of.flow.v_axial), speed = std::max(of.rms_speed(at)[0], 0.1 * v_axial + 1e-9);
    first_inflows(of, at, speed, samples);
    samples.evaluate_from(0, of, at, over);
    constexpr int rounds = 8, between = 4;  // new samples in each interval
    const double shortest = 1e-7 * (speed + v_axial);
    for (int round = 0; round < rounds; ++round) {
        const int before = samples.count;
        for (int k = 0; k + 1 < before && samples.count + between <= Samples::most; ++k) {
            const Sample &from = samples.at[k], &to = samples.at[k + 1];
            const double gap = from.inflow - to.inflow;
            if (gap < shortest || !may_hide_roots(from, to)) continue;
            for (int j = 1; j <= between; ++j) samples.at[samples.count++].inflow = from.inflow - gap * j / (between + 1.0);
        }
        if (samples.count == before) break;
        samples.evaluate_from(before, of, at, over);
    }
    Scan result;
    for (int k = 0; k + 1 < samples.count; ++k) {
        const Sample &high = samples.at[k], &low = samples.at[k + 1];
        if ((high.residual < 0.0) == (low.residual < 0.0) || ++result.roots > 1) continue;
        result.high = high.inflow, result.low = low.inflow;
        result.guess = high.inflow - Cubic(high, low).root() * (high.inflow - low.inflow);
    }
    return result;
}

// Find the roots between `low` and `high` by Newton's method from v, with bisection where a step leaves the bracket.
// Return NaN where the method does not converge.
template <class R>
Lanes polished_roots(const Annuli<R>& of, const Station<Lanes>& at, Lanes low, Lanes high, Lanes v) {
    const Lanes scale = speed_scale(of, at) + 1e-12;
    Mask open = v == v;
    for (int k = 0; k < 120 && any(open); ++k) {
        const auto g = of.residual(at, v);
        const Mask below = g.v >= 0.0;
        low = below ? v : low;
        high = below ? high : v;
        const Lanes newton = v - g.v / g.d[0];
        const Mask inside = (g.d[0] < 0.0) & (newton >= low) & (newton <= high);
        const Lanes next = inside ? newton : 0.5 * (low + high);
        const Mask ends = (absolute(next - v) <= 1e-10 * scale) & inside;
        const Mask narrow = (high - low) <= 1e-14 * scale;
        v = open ? next : v;
        open = open & ~(ends | narrow | (g.v == 0.0));
    }
    return open ? broadcast(std::nan("")) : v;
}

// --- Humps ---------------------------------------------------------------------------------------------------------

// The hump at one radius.  If a hump changes from a top to a shoulder along the blade, its height stays continuous.
struct Hump {
    double radius;         // [m]
    double height, slope;  // the residual at the hump [m^3/s^2], and its derivative with respect to the radius
    double share;          // |height| over the momentum thrust
    double inflow;         // v_i at the hump [m/s]
    double past_stall;     // mean angle of attack at the hump minus the stall angle [rad]; nearly constant along the blade
    double below;          // like `past_stall`, at the first sample below the hump with a positive residual; NaN without one
    double root;           // like `past_stall`, at the largest root, interpolated; NaN if no samples enclose this root
    bool top;              // the hump is a top, not a shoulder
    bool clear;            // there is no other maximum between the hump and the sample of `below`
    bool single_root;      // the residual decreases with v_i at all samples, so (11) has one root
    bool three_roots;      // the residual is positive at the hump and negative at a sample below
};

// A top or shoulder of the residual, interpolated between samples.
struct Peak {
    double inflow = std::nan(""), height = std::nan("");
    bool top = false;
    bool known() const { return inflow == inflow; }
};

// Find the top that decides on which branch the largest root is.  Among tops of positive height, it has the largest inflow.
// Without such a top, it is the highest top, and without any top the shoulder.  (If the function always returned the top of
// largest inflow, the search missed attached intervals near the tip, and thrust erred by 0.9 % of static thrust.)
inline Peak deciding_peak(std::span<const Sample> samples) {
    Peak best;
    double flattest = INFINITY;
    for (std::size_t k = 0; k + 1 < samples.size() && !(best.top && best.height > 0.0); ++k) {
        const double gap = samples[k].inflow - samples[k + 1].inflow;
        const Cubic cubic(samples[k], samples[k + 1]);
        // The cubic has a maximum if its derivative is positive at t = 0 and its smallest derivative is negative.
        double t = cubic.c > 0.0 ? std::clamp(-0.5 * cubic.b / cubic.c, 0.0, 1.0) : cubic.b + cubic.c > 0.0 ? 0.0 : 1.0;
        const double least = cubic.slope(t);
        const bool top = cubic.a > 0.0 && least < 0.0;
        if (top) {
            const double root = std::sqrt(std::max(cubic.b * cubic.b - 4.0 * cubic.a * cubic.c, 0.0));
            t = std::min(2.0 * cubic.a / std::max(root - cubic.b, 1e-300), 1.0);
        }
        const double height = cubic.at(t);
        if (top ? best.top && height <= best.height : best.top || !(least / gap < flattest)) continue;
        best = {samples[k].inflow - t * gap, height, top};
        if (!top) flattest = least / gap;
    }
    return best;
}

// Spacing of the three samples that refine a peak [rad].  A peak that moves by more than `refined_within` times this
// spacing is refined again, up to three times in all.  (With one refinement, the loads changed at 14 of 5,000 random
// points, at one of them by 0.24 % of the static load.)
inline constexpr double refined_by = 0.012, refined_within = 0.9;

// Refine the peaks in the lanes `open`, from three samples around each peak.  Lanes whose peak moves too far remain open.
template <class R>
void refine_peaks(const Annuli<R>& of, const Station<Lanes>& at, const Azimuths& over, std::array<bool, width>& open,
                  Peak (&peak)[width]) {
    if (std::find(open.begin(), open.end(), true) == open.end()) return;
    const Lanes reach = refined_by * of.stall_scale() * of.rms_speed(at);
    Sample samples[width][3];
    std::array<Request, 3 * width> asked;
    std::size_t count = 0;
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < width; ++k) {
            samples[k][j].inflow = peak[k].inflow + (1.0 - j) * reach[k];
            if (open[k]) asked[count++] = {k, &samples[k][j]};
        }
    evaluate(of, at, {asked.data(), count}, over);
    for (int k = 0; k < width; ++k) {
        if (!open[k]) continue;
        const Peak found = deciding_peak(samples[k]);
        open[k] = found.known() && std::fabs(found.inflow - peak[k].inflow) > refined_within * reach[k];
        if (found.known()) peak[k] = found;
    }
}

// Offsets from the stall angle [rad], at which the residual is sampled to find a hump.  `stall_spread` multiplies them.
inline constexpr double near_offsets[] = {-0.2, -0.14, -0.095, -0.06, -0.03, -0.005, 0.025, 0.06, 0.1, 0.15};
// Further offsets in deep stall.  `past_offsets` are for a stalled blade; without them, the search scans more nodes.
// `bent_offsets` are for any blade whose residual may bend again; with fewer, thrust erred by 4 % of static thrust.
inline constexpr double past_offsets[] = {0.25, 0.45, 0.85}, bent_offsets[] = {0.2, 0.27, 0.35, 0.43, 0.52, 0.62, 0.73, 0.85};

// Samples of the residual at one radius per lane, in order of decreasing inflow.
struct LaneSamples {
    static constexpr int most = 20;
    int count[width] = {};
    Sample at[width][most];

    std::span<const Sample> of(int lane) const { return {at[lane], std::size_t(count[lane])}; }

    // Add samples at the angles `stall + factor * offset` in the lanes `wanted`.
    template <class R>
    void add(const Annuli<R>& of, const Station<Lanes>& station, const std::array<bool, width>& wanted, Lanes stall,
             std::span<const double> offsets, Lanes factor) {
        std::array<Request, width * most> asked;
        std::size_t n = 0;
        for (double offset : offsets) {
            const Lanes v = inflow_at_angle(of, station, stall + offset * factor);
            for (int k = 0; k < width; ++k) {
                if (!wanted[k] || std::isnan(v[k])) continue;
                Sample& sample = at[k][count[k]++];
                sample.inflow = v[k], asked[n++] = {k, &sample};
            }
        }
        evaluate(of, station, {asked.data(), n}, of.few);
    }
};

// Set the members of `hump` that describe the root and the residual below the peak; `hump.root` and `hump.below` are inflows
// here, not angles.
inline void look_below(std::span<const Sample> samples, const Peak& peak, Hump& hump) {
    bool falls = true, rising = false;
    hump.below = hump.root = std::nan(""), hump.clear = true, hump.three_roots = false;
    const auto positive = std::find_if(samples.begin(), samples.end(), [](const Sample& s) { return s.residual >= 0.0; });
    if (positive > samples.begin() && positive != samples.end()) {
        const Sample& before = *(positive - 1);
        hump.root = before.inflow - Cubic(before, *positive).root() * (before.inflow - positive->inflow);
    }
    for (const Sample& s : samples) {
        falls &= s.slope < 0.0;
        if (!(s.inflow < peak.inflow)) continue;
        hump.three_roots |= s.residual < 0.0;
        const bool found = hump.below == hump.below;
        if (!found && rising && s.slope > 0.0) hump.clear = false;
        rising |= s.slope < 0.0;
        if (!found && s.residual > 0.0) hump.below = s.inflow;
    }
    hump.single_root = falls;
    // Below a shoulder there is no maximum if, at all samples, the residual increases as v_i decreases.
    if (!peak.top) hump.clear = falls;
}

// Find the humps at the radii in the first `radii` lanes, at positive (side = 1) or negative (side = -1) stall angles.
template <class R> void humps_at(const Annuli<R>& of, Lanes radius, int radii, double side, Hump (&found)[width]) {
    const Dual<Lanes, 1> moved{radius, {broadcast(1.0)}};
    const Station<Dual<Lanes, 1>> moving = station_at(of.rotor, of.flow.omega, moved);
    const Station<Lanes> at = {radius, moving.chord.v, {moving.line.sine, moving.line.cosine, {}},
                               {moving.drag_line.sine, moving.drag_line.cosine, {}}, moving.reynolds_per_speed.v,
                               moving.inverse_root.v, moving.lift_growth.v, moving.drag_growth.v};
    const Lanes stall = of.stall_angle(at, side);
    LaneSamples samples;
    Peak peak[width];
    std::array<bool, width> used{}, stalled{}, far{}, close{};
    for (int k = 0; k < radii; ++k) used[k] = true;
    samples.add(of, at, used, stall, near_offsets, stall_spread(of, at, stall));
    if (!of.bends_near_stall_only()) samples.add(of, at, used, stall, bent_offsets, broadcast(1.0));
    for (int k = 0; k < radii; ++k) {
        peak[k] = deciding_peak(samples.of(k));
        stalled[k] = of.bends_near_stall_only() && peak[k].known() && !(peak[k].top && peak[k].height > 0.0);
    }
    samples.add(of, at, stalled, stall, past_offsets, broadcast(1.0));
    for (int k = 0; k < radii; ++k) look_below(samples.of(k), peak[k], found[k]);

    // Refine the peak, over all azimuths if the height is small.
    const auto inflow = [&] { return each_lane([&](int k) { return peak[k].inflow; }); };
    const Lanes wake = absolute(wake_thrust(of.rotor, radius, of.flow, of.windmill, inflow()));
    constexpr double small = 0.2;  // of the momentum thrust
    for (int k = 0; k < radii; ++k)
        (std::fabs(peak[k].height) < small * wake[k] ? close : far)[k] = peak[k].known();
    const std::array<bool, width> precise = close;
    for (int round = 0; round < 3; ++round) refine_peaks(of, at, of.few, far, peak), refine_peaks(of, at, of.psi, close, peak);

    // At a top, dg/dv_i = 0.  The height therefore varies along the blade like the residual at constant v_i.
    const Lanes v = inflow();
    const auto height_over = [&](const Azimuths& psi) {
        return annulus_thrust(of.rotor, moving, of.flow, v, psi) - wake_thrust(of.rotor, moved, of.flow, of.windmill, v);
    };
    const auto any_of = [&](bool wanted) { return std::count(precise.begin(), precise.begin() + radii, wanted) > 0; };
    const Dual<Lanes, 1> few = any_of(false) ? height_over(of.few) : Dual<Lanes, 1>{};
    const Dual<Lanes, 1> all = any_of(true) ? height_over(of.psi) : Dual<Lanes, 1>{};
    const auto past_stall = [&](Lanes inflow) { return angle_at(at, of.rms_speed(at), of.flow.v_axial + inflow) - stall; };
    const Lanes past = past_stall(v), below = past_stall(each_lane([&](int k) { return found[k].below; }));
    const Lanes root = past_stall(each_lane([&](int k) { return found[k].root; }));
    for (int k = 0; k < radii; ++k) {
        Hump& hump = found[k];
        const Dual<Lanes, 1>& height = precise[k] ? all : few;
        hump.radius = radius[k], hump.inflow = v[k], hump.top = peak[k].top;
        hump.height = peak[k].known() ? height.v[k] : std::nan(""), hump.slope = height.d[0][k];
        hump.share = std::fabs(hump.height) / wake[k];
        hump.past_stall = past[k], hump.below = below[k], hump.root = root[k];
        hump.three_roots &= hump.top && hump.height > 0.0;
    }
}

// --- Folds ---------------------------------------------------------------------------------------------------------

// A fold, or another radius at which panels meet.
struct Edge {
    enum class Kind {
        fixed,     // no fold
        top,       // the fold of a top: the residual and its derivative with respect to v_i are zero
        shoulder,  // the fold of a shoulder: the residual and its second difference over v_i are zero
        angle      // in place of a fold that was not found: the residual is zero at the stall angle
    };
    double radius;        // [m]
    Kind kind = Kind::fixed;
    double inflow = 0.0;  // v_i at a fold [m/s]
};

// Spacing of the three inflows for the differences at a fold, relative to the speed of the air.
template <class R> double fold_spacing(const Annuli<R>& of, bool top) { return top ? 2e-4 : 0.004 * of.stall_scale(); }

// Solve for the fold between the humps `low` and `high` by Newton's method, from the radius y and the inflow v.  One
// evaluation is sufficient for all derivatives: three lanes differ in v, the fourth in y.
template <class R>
std::optional<Edge> newton_fold(const Annuli<R>& of, const Hump& low, const Hump& high, double y, double v, bool top, bool all_azimuths) {
    static_assert(width >= 4);
    for (int step = 0; step < (top ? 20 : 12); ++step) {
        const double speed = std::hypot(of.flow.omega * y, of.flow.v_inplane) + std::fabs(of.flow.v_axial);
        const double wide = fold_spacing(of, top) * speed, farthest = 0.02 * speed, aside = 1e-6 * y;
        const Lanes radius = each_lane([&](int k) { return k == 3 ? y - aside : y; });
        const Lanes inflow = each_lane([&](int k) { return v + (k == 0 ? wide : k == 2 ? -wide : 0.0); });
        const auto g = of.residual(of.station(radius), inflow, all_azimuths ? of.psi : of.few);
        const double s0 = g.d[0][0], s1 = g.d[0][1], s2 = g.d[0][2];
        const double bend = (s0 - s2) / (2.0 * wide), turn = s0 - 2.0 * s1 + s2;
        // If the curvature has the wrong sign, step uphill (to a top) or to the flatter side (to a shoulder).
        const double curved = top ? bend : turn, missed = top ? s1 : g.v[0] - 2.0 * g.v[1] + g.v[2];
        const double uphill = top ? (s1 > 0.0 ? 1.0 : -1.0) : (s0 > s2 ? 1.0 : -1.0);
        const double dv = std::clamp(curved < 0.0 ? -missed / curved : 2.0 * wide * uphill, -farthest, farthest);
        const double along = (g.v[1] - g.v[3]) / aside;
        const double here = g.v[1] + dv * (s1 + 0.5 * dv * bend);  // residual after the step dv, to second order
        const double dy = along != 0.0 ? -here / along : 0.0;
        y += dy, v += dv;
        if (!(y > low.radius && y < high.radius)) return {};
        if (all_azimuths && std::fabs(dy) < 1e-9 * y && std::fabs(dv) < 1e-6 * speed) {
            if (!(curved < 0.0 && (top || s1 < 0.0))) return {};
            return Edge{y, top ? Edge::Kind::top : Edge::Kind::shoulder, v};
        }
        // Few azimuths are sufficient until the steps are short.
        all_azimuths |= std::fabs(dy) < 2e-3 * y && std::fabs(dv) < 3e-3 * speed;
    }
    return {};
}

// Whether this fold belongs to `above`, the hump with a positive height.  Newton's method may converge to another hump.
// (Without this test, loads changed at 9 of 10,000 random points, by up to 3e-4 of the static load.)
template <class R> bool same_hump(const Annuli<R>& of, const Edge& fold, const Hump& above, double side) {
    const auto at = of.station(broadcast(fold.radius));
    const Lanes angle = angle_at(at, of.rms_speed(at), broadcast(of.flow.v_axial + fold.inflow));
    return !above.top || std::fabs(angle[0] - of.stall_angle(at, side)[0] - above.past_stall) <= 0.03;
}

// Shorten the interval between humps with heights of opposite signs.  Compute humps at four radii, at the fractions
// `share` - `spread` to `share` + `spread` of the interval.
template <class R> void narrow(const Annuli<R>& of, Hump& low, Hump& high, double share, double spread, double side) {
    constexpr int looks = 4;
    Hump inside[width];
    const double gap = high.radius - low.radius, from = low.radius;
    const Lanes radius = each_lane([&](int lane) {
        const int k = std::min(lane, looks - 1);
        const double place = share + spread * (2.0 * k / (looks - 1.0) - 1.0);
        return from + std::clamp(place, 0.01 * (k + 1), 1.0 - 0.01 * (looks - k)) * gap;
    });
    humps_at(of, radius, looks, side, inside);
    for (int k = 0; k < looks; ++k) {
        const Hump& hump = inside[k];
        if (std::isnan(hump.height) || hump.radius <= low.radius || hump.radius >= high.radius) continue;
        if ((hump.height < 0.0) == (low.height < 0.0)) low = hump;
        else return void(high = hump);
    }
}

// Solve for the radius at which the residual at the stall angle is zero, by Newton's method from the middle of an
// interval.  Return NaN if the method does not converge close to the interval.
template <class R> double radius_at_stall_angle(const Annuli<R>& of, double first, double last, double side) {
    const double gap = last - first;
    double y = 0.5 * (first + last), step = gap;
    for (int k = 0; k < 10 && std::fabs(step) > 1e-7 * y; ++k) {
        const double aside = 1e-6 * y;
        const auto at = of.station(each_lane([&](int lane) { return lane == 0 ? y : y - aside; }));
        const Lanes g = of.residual(at, inflow_at_angle(of, at, of.stall_angle(at, side))).v;
        step = std::clamp(g[0] * aside / (g[0] - g[1]), -0.5 * gap, 0.5 * gap);
        y -= step;
        if (!(y > first - gap && y < last + gap)) return std::nan("");
    }
    return std::fabs(step) <= 1e-7 * y ? y : std::nan("");
}

// Find the fold between two humps with heights of opposite signs.  If Newton's method fails, narrow the interval.
template <class R> Edge fold_between(const Annuli<R>& of, Hump low, Hump high, double side) {
    const double first = low.radius, last = high.radius;
    const auto nearer = [&]() -> const Hump& { return std::fabs(low.height) < std::fabs(high.height) ? low : high; };
    const auto share = [&] { return std::clamp(low.height / (low.height - high.height), 0.02, 0.98); };
    const auto between = [&](double a, double b) { return a + share() * (b - a); };
    for (int narrowing = 0; narrowing < 12; ++narrowing) {
        const bool top = nearer().top;
        if (!top && narrowing > 0) break;
        const double y = between(low.radius, high.radius), v = between(low.inflow, high.inflow);
        const auto fold = newton_fold(of, low, high, y, v, top, narrowing > 0);
        if (fold && (narrowing >= 6 || same_hump(of, *fold, low.height > 0.0 ? low : high, side))) return *fold;
        // In climb, never narrow between shoulders: at 20,000 random oblique points, there was no top between them.
        if (!low.top && !high.top && of.flow.v_axial >= 0.0) break;
        // Interpolation predicts the fold well, so the first two intervals are narrow.  (With a spread of 0.25 in all steps,
        // loads changed at 3 of 10,000 points by 2e-4.)
        narrow(of, low, high, share(), narrowing < 2 ? 0.05 : 0.25, side);
        if (high.radius - low.radius < 1e-9 * high.radius) break;
    }
    if (nearer().top) return {nearer().radius, Edge::Kind::top, nearer().inflow};
    return {radius_at_stall_angle(of, first, last, side), Edge::Kind::angle};
}

}  // namespace propmap
