// The hybrid inflow v_i(y) of an annulus: the largest root of eq. (11), element thrust (5) = momentum thrust (10).
//
// The residual g(v_i) is (5) minus (10).  It is negative for all v_i above the largest root.
// - Top: the local maximum of g near stall.
// - Shoulder: if g has no maximum near stall, its flattest point there, at which -dg/dv_i is smallest.
// - Hump: the top or, if there is none, the shoulder.  Its height is the value of g at this point.
// - Branches: the attached branch has larger v_i than the top, the stalled branch has smaller v_i.  At negative angles
//   of attack the names are kept, although flow is stalled above the top.  If the height is positive, the largest root
//   is above the top, and two more roots may follow.  If the height is negative, the largest root is below the top.
// - Fold: a radius at which the height is zero.  At a fold with a top, the largest root jumps from one branch to the
//   other.  At a fold with a shoulder, it varies most steeply along the blade.
//
// Three methods find the largest root, the cheapest one first: Newton's method in attached flow, with a proof that no
// root is larger (`surely_largest`); Newton's method on the branch predicted from humps at neighboring radii (`Outlook`
// in disk.hpp); and a scan of g over all inflows (`scan`).  Each lane of `Lanes` is a radius, or an inflow at a radius.
#pragma once

#include <array>

#include "inflow.hpp"

namespace propmap {

// Equation (11) at one operating point.
template <class R> struct Annuli {
    const R& rotor;
    Flow<double> flow;
    Azimuths psi;   // over which (5) is averaged
    Azimuths few;   // a smaller set, for evaluations far from a root
    bool windmill;  // whether the windmill branch of momentum theory applies, see wake.hpp

    Station<Lanes> station(Lanes radius) const { return station_at(rotor, flow.omega, radius); }

    // The residual per radius and density [m^3/s^2], with its derivative with respect to the inflow.
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
    double stall_angle(double reynolds_per_speed, double radius, double side) const {  // [rad], for U = Omega y
        return value(rotor.law.stall_angle(reynolds_per_speed * flow.omega * radius, side));
    }
    // Whether a few samples determine the residual between them.  They do not if lift bends again in deep stall, nor in
    // descent with tip or hub loss: Prandtl's factor peaks at 1 where no air passes the disk.
    bool plain() const {
        return rotor.law.plain_stall && rotor.law.stall_delay == 0.0 &&
               !(flow.v_axial < 0.0 && (rotor.tip_loss || rotor.hub_radius > 0.0));
    }
    // Spacing of samples near stall, relative to that for the paper's M = 50: a sharper stall needs closer samples.
    double stall_scale() const { return std::min(rotor.law.stall_width() / 0.02, 1.0); }
};

// Angle of attack from zero lift [rad] at the velocity (U_T, U_P).
inline Lanes angle_at(const Station<Lanes>& at, Lanes u_t, Lanes u_p) {
    const Lanes per = inverse_square_root(u_t * u_t + u_p * u_p + 1e-30);
    return radians(at.line - Angle<Lanes>{u_p * per, u_t * per, {}});
}

// First guess of the inflow [m/s], for attached flow without drag: v W = k (U_T^2 theta - U_T U_P), where W is the
// square root in (10) and k = N_b c_l1 c/(8 pi y), with the Reynolds factor on c_l1.  Four Newton steps start above the solution.
template <class R> Lanes attached_guess(const Annuli<R>& of, const Station<Lanes>& at) {
    const auto& f = of.flow;
    const Lanes speed = of.rms_speed(at);
    const double slope = of.rotor.blade->blades * value(of.rotor.law.attached_slope()) / (8.0 * pi);
    const Lanes k = slope * at.lift_growth * at.chord / at.radius;
    const Lanes lift = k * speed * speed * at.line.sine, loss = k * f.omega * at.radius * at.line.cosine;
    Lanes v = square_root(maximum(lift, 0.0)) + 1.5 * std::max(-f.v_axial, 0.0);
    for (int step = 0; step < 4; ++step) {
        const Lanes u = f.v_axial + v;
        const Lanes square = speed_squared(f.v_inplane, u), per = inverse_square_root(square), w = square * per;
        v = v + (lift - loss * u - v * w) / (loss + maximum(w + v * u * per, 1e-3 * w));
    }
    return v;
}

// Return the lanes whose root v is in attached flow at all azimuths, so that no root lies above it.
// If v >= 0, (5) decreases and (10) increases with v_i above v.  If v < 0, lift is negative; (5) still decreases and (10)
// still increases up to v_i = 0, if no element stalls in between.  Above v_i = 0, the two thrusts have opposite signs.
template <class R> Mask surely_largest(const Annuli<R>& of, const Station<Lanes>& at, Lanes v) {
    const auto& f = of.flow;
    const double margin = 3.0 * std::max(of.rotor.law.stall_width(), 0.02);  // [rad]: three widths of stall
    const Lanes turning = f.omega * at.radius;
    const Lanes slow = turning - f.v_inplane, fast = turning + f.v_inplane;  // U_T at psi = -pi/2 and pi/2
    const Lanes u = f.v_axial + v;
    Lanes most, least;
    for (int k = 0; k < width; ++k) {
        most[k] = of.stall_angle(at.reynolds_per_speed[k], at.radius[k], 1.0) - margin;
        least[k] = of.stall_angle(at.reynolds_per_speed[k], at.radius[k], -1.0) + margin;
    }
    const Lanes one = angle_at(at, fast, u), other = angle_at(at, slow, u);
    const Lanes later = angle_at(at, slow, f.v_axial + maximum(v, 0.0));
    Mask sure = (slow > 0.0) & (maximum(one, other) < most) & (minimum(minimum(one, other), later) > least);
    const Mask climb = f.v_axial + Lanes{} >= 0.0;
    // On the windmill branch (10) increases with v_i for both directions of the flow through the disk.
    const Mask rises = of.windmill && of.plain() ? v >= 0.0 : u >= 0.0;
    sure &= (v >= 0.0) ? rises : (climb & (f.v_axial + 2.0 * v > 0.0));
    return sure;
}

// The cubic between two samples, for t = 0 (first sample) to 1 (second sample).  Its derivative is a + b t + c t^2.
template <class T> struct Cubic {
    T start, a, b, c;

    // From values and derivatives with respect to v_i at two inflows, of which the second is smaller by `run`.
    Cubic(T run, T value, T slope, T next_value, T next_slope) {
        const T rise = next_value - value, end = -next_slope * run;
        start = value, a = -slope * run;
        c = 3.0 * (a + end - 2.0 * rise), b = end - a - c;
    }
    T at(T t) const { return start + t * (a + t * (0.5 * b + t * c / 3.0)); }

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

// Samples of the residual at one radius, in order of decreasing v_i.
struct Samples {
    static constexpr int most = 400;  // capacity
    int count = 0;
    std::array<double, most> inflow, value, slope;

    void append(double v, double g, double s) {
        inflow[count] = v, value[count] = g, slope[count] = s;
        ++count;
    }
    // The cubic between samples k and k + 1.
    Cubic<double> cubic(int k) const {
        return {inflow[k] - inflow[k + 1], value[k], slope[k], value[k + 1], slope[k + 1]};
    }
};

// The result of a scan at one radius.
struct Scan {
    bool found = false;
    double low, high;  // bracket of the largest root [m/s]
    double guess;      // estimate of this root from the cubic in the bracket [m/s]
    int roots = 0;     // number of sign changes
};

// Scan the residual over all inflows at one radius.  Every change of sign is a root.  Intervals that may hide two more
// roots are sampled again.  Of the angles near stall, where the residual bends most, only every `every`-th is sampled.
template <class R> Scan scan(const Annuli<R>& of, double radius, const Azimuths& over, Samples& samples, int every) {
    const auto& f = of.flow;
    const Station<Lanes> at = of.station(broadcast(radius));
    const double speed = std::max(of.rms_speed(at)[0], 0.1 * std::fabs(f.v_axial) + 1e-9);
    const double line = radians(at.line)[0];
    std::array<double, 96> grid;
    int count = 0;
    // Up to 45 inflows: equally spaced inflow angles, closer ones around both stall angles, and lastly up to six special inflows.
    std::array<double, 48> angle;
    int angles = 0;
    const auto add_angle = [&](double phi) { if (std::fabs(phi) < 1.45) angle[angles++] = phi; };
    for (int k = -7; k <= 7; ++k) add_angle(0.2 * k);
    for (double side : {1.0, -1.0}) {
        const double stall = of.stall_angle(at.reynolds_per_speed[0], radius, side);
        constexpr double offsets[] = {-0.2, -0.15, -0.11, -0.08, -0.055, -0.03, -0.01, 0.01, 0.03, 0.055, 0.09, 0.14};
        for (std::size_t k = 0; k < std::size(offsets); k += every)
            add_angle(line - (stall + side * of.stall_scale() * offsets[k]));
    }
    for (int k = 0; k < angles; k += width) {
        const auto phi = sine_cosine(each_lane([&](int j) { return angle[std::min(k + j, angles - 1)]; }));
        const Lanes v = speed * phi.sine / phi.cosine - f.v_axial;
        for (int j = 0; j < width && k + j < angles; ++j) grid[count++] = v[j];
    }
    grid[count++] = 0.0;
    grid[count++] = -f.v_axial;  // no air passes the disk
    if (f.v_axial < 0.0) {
        const auto turn = turning_points(f.v_axial, f.v_inplane);
        grid[count++] = turn.first, grid[count++] = turn.second;
    }
    grid[count++] = 10.0 * speed - f.v_axial;
    grid[count++] = -10.0 * speed - f.v_axial;
    std::sort(grid.begin(), grid.begin() + count, std::greater<>());
    const double apart = 1e-6 * speed;
    count = int(std::unique(grid.begin(), grid.begin() + count,
                            [&](double a, double b) { return std::fabs(a - b) < apart; }) - grid.begin());

    samples.count = 0;
    const auto evaluate = [&](const double* v, int n, Samples& into) {
        for (int k = 0; k < n; k += width) {
            const Lanes x = each_lane([&](int j) { return v[std::min(k + j, n - 1)]; });
            const auto g = of.residual(at, x, over);
            for (int j = 0; j < width && k + j < n; ++j) into.append(x[j], g.v[j], g.d[0][j]);
        }
    };
    evaluate(grid.data(), count, samples);
    // Move both ends outwards until the first value is negative and the last one positive: then no root is outside.
    const double whole = speed + std::fabs(f.v_axial);
    for (double more = 100.0; more < 1e7; more *= 10.0) {
        const bool high = samples.value[0] < 0.0, low = samples.value[count - 1] > 0.0;
        if (high && low) break;
        const double v[2] = {high ? grid[0] : more * whole - f.v_axial, low ? grid[count - 1] : -more * whole - f.v_axial};
        Samples ends;
        evaluate(v, 2, ends);
        const auto replace = [&](int k, int end) {
            samples.inflow[k] = ends.inflow[end], samples.value[k] = ends.value[end], samples.slope[k] = ends.slope[end];
        };
        replace(0, 0), replace(count - 1, 1);
    }

    // Sample again where two more roots may hide: between samples of opposite signs if the cubic has an extreme, and
    // between samples of the same sign if the cubic has an extreme of the opposite sign or close to zero.
    constexpr int between = 4;
    for (int round = 0; round < 8; ++round) {
        std::array<double, Samples::most> asked;
        int more = 0;
        for (int k = 0; k + 1 < samples.count; ++k) {
            const double run = samples.inflow[k] - samples.inflow[k + 1];
            if (run < 1e-7 * whole || samples.count + more + between > Samples::most) continue;  // too short, or no capacity
            const Cubic<double> cubic = samples.cubic(k);
            const double g0 = samples.value[k], g1 = samples.value[k + 1];
            double t[2];
            const int extremes = cubic.extremes(t);
            const bool crosses = (g0 < 0.0) != (g1 < 0.0);  // one root at least
            const bool opposed = cubic.a * (cubic.a + cubic.b + cubic.c) < 0.0;  // opposite slopes: an extreme
            bool hides = crosses && (extremes > 0 || opposed);
            for (int e = 0; e < extremes && !crosses; ++e) {
                const double there = cubic.at(t[e]), nearest = std::min(std::fabs(g0), std::fabs(g1));
                const bool beyond = (there < 0.0) != (g0 < 0.0);
                hides |= beyond || std::fabs(there) < 0.7 * nearest;
            }
            // An extreme may be sharper than that of the cubic.  The tangents at both samples bound it.
            if (!crosses && opposed) {
                const double end = cubic.a + cubic.b + cubic.c, met = (g1 - g0 - end) / (cubic.a - end);
                hides |= ((g0 + cubic.a * met) < 0.0) != (g0 < 0.0) && met > 0.0 && met < 1.0;
            }
            if (!hides) continue;
            for (int j = 1; j <= between; ++j) asked[more++] = samples.inflow[k] - run * j / (between + 1.0);
        }
        if (more == 0) break;
        const Samples before = samples;
        Samples fresh;
        evaluate(asked.data(), more, fresh);
        samples.count = 0;
        for (int k = 0, j = 0; k < before.count || j < fresh.count;) {
            const bool old = j == fresh.count || (k < before.count && before.inflow[k] > fresh.inflow[j]);
            if (old) samples.append(before.inflow[k], before.value[k], before.slope[k]), ++k;
            else samples.append(fresh.inflow[j], fresh.value[j], fresh.slope[j]), ++j;
        }
    }

    Scan result;
    for (int k = 0; k + 1 < samples.count; ++k) {
        if ((samples.value[k] < 0.0) == (samples.value[k + 1] < 0.0)) continue;
        ++result.roots;
        if (result.found) continue;
        result.found = true;
        result.high = samples.inflow[k], result.low = samples.inflow[k + 1];
        // Bisect the cubic, which is far cheaper than an evaluation of the residual.
        const Cubic<double> cubic = samples.cubic(k);
        double low = 0.0, high = 1.0;
        for (int step = 0; step < 30; ++step) {
            const double middle = 0.5 * (low + high);
            (cubic.at(middle) < 0.0 ? low : high) = middle;
        }
        result.guess = result.high - 0.5 * (low + high) * (result.high - result.low);
    }
    return result;
}

// Find the roots between `low` and `high` by Newton's method from v, with bisection where a step leaves the bracket.
// Return NaN where the method does not converge.
template <class R>
Lanes polished_roots(const Annuli<R>& of, const Station<Lanes>& at, Lanes low, Lanes high, Lanes v) {
    const Lanes scale = of.rms_speed(at) + std::fabs(of.flow.v_axial) + 1e-12;
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

// The hump at one radius.  If a hump changes from a top to a shoulder along the blade, its height stays continuous.
struct Hump {
    double radius;  // [m]
    double height;  // the residual at the hump [m^3/s^2]
    double inflow;  // v_i at the hump [m/s]
    double past;    // mean angle of attack at the hump minus the stall angle [rad]; nearly constant along the blade
    double slope;   // derivative of the height with respect to the radius
    double below;   // `past` at the first sample below the hump with a positive residual [rad]; NaN if there is none
    bool clear;     // there is no other maximum between the hump and the sample of `below`
    bool falls;     // the residual decreases with v_i at all samples, so (11) has one root
    bool top;       // the hump is a top, not a shoulder
    bool folded;    // (11) has three roots at this radius
    bool near;      // |height| is below 0.3 of the momentum thrust
    bool touching;  // |height| is below 0.04 of it: the sign may change between two measured stations of the blade
};

// Compute the residuals in the lanes `asked`, at `count` inflows per lane.  They are packed into full vectors, because
// half of all calls ask for a single lane.
template <class R, std::size_t N>
void residuals(const Annuli<R>& of, const Station<Lanes>& at, Mask asked, const std::array<Lanes, N>& v, int count,
               const Azimuths& over, std::array<Dual<Lanes, 1>, N>& found) {
    std::array<int, width> lanes;
    int n = 0;
    for (int k = 0; k < width; ++k)
        if (asked[k]) lanes[n++] = k;
    const int all = n * count;
    if (all > (count - 1) * width) {
        for (int j = 0; j < count; ++j) {
            const auto g = of.residual(at, v[j], over);
            found[j].v = asked ? g.v : found[j].v, found[j].d[0] = asked ? g.d[0] : found[j].d[0];
        }
        return;
    }
    const auto from = std::bit_cast<std::array<Lanes, sizeof(at) / sizeof(Lanes)>>(at);
    for (int first = 0; first < all; first += width) {
        auto packed = from;
        Lanes inflow;
        for (int k = 0; k < width; ++k) {
            const int task = std::min(first + k, all - 1), lane = lanes[task % n];
            inflow[k] = v[task / n][lane];
            for (std::size_t f = 0; f < from.size(); ++f) packed[f][k] = from[f][lane];
        }
        const auto g = of.residual(std::bit_cast<Station<Lanes>>(packed), inflow, over);
        for (int k = 0; k < width && first + k < all; ++k) {
            const int task = first + k, lane = lanes[task % n];
            found[task / n].v[lane] = g.v[k], found[task / n].d[0][lane] = g.d[0][k];
        }
    }
}

// Samples of the residual at one radius per lane, in order of decreasing v_i.  Missing samples are NaN.
struct LaneSamples {
    static constexpr std::size_t most = 24;
    int count = 0;
    std::array<Lanes, most> inflow;
    std::array<Dual<Lanes, 1>, most> residual;  // with its derivative with respect to v_i
};

// Find the maximum that decides on which branch the largest root is: the first one above zero or, if there is none, the
// highest one.  (Without this rule, attached intervals near the tip were missed, an error of 0.9 % of static thrust.)
// Return the lanes that have a maximum.  In all other lanes, `inflow` and `height` are those of the shoulder.
inline Mask deciding_top(const LaneSamples& s, Lanes& inflow, Lanes& height) {
    const Lanes none = broadcast(-INFINITY), one = broadcast(1.0);
    const auto clamped = [&](Lanes t) { return minimum(maximum(t, 0.0), one); };
    Lanes gentlest = -none, highest = none;
    for (int k = 0; k + 1 < s.count; ++k) {
        const Lanes run = s.inflow[k] - s.inflow[k + 1];
        const auto &above = s.residual[k], &below = s.residual[k + 1];
        const Cubic<Lanes> cubic(run, above.v, above.d[0], below.v, below.d[0]);
        // `lowest` is the t of the smallest derivative.  If the derivative changes from positive at t = 0 to negative
        // at `lowest`, there is a maximum in between.
        Lanes lowest = cubic.b + cubic.c > 0.0 ? Lanes{} : one;
        lowest = cubic.c > 0.0 ? clamped(-0.5 * cubic.b / cubic.c) : lowest;
        const Lanes least = cubic.a + (cubic.b + cubic.c * lowest) * lowest;
        const Mask falls = (cubic.a > 0.0) & (least < 0.0);
        const Lanes root = square_root(maximum(cubic.b * cubic.b - 4.0 * cubic.a * cubic.c, 0.0));
        lowest = falls ? clamped(2.0 * cubic.a / maximum(root - cubic.b, 1e-300)) : lowest;
        const Lanes here = cubic.at(lowest), steep = least / run;
        const Mask better = (highest <= 0.0) & ((falls & (here > highest)) | (~falls & (highest == none) & (steep < gentlest)));
        gentlest = better ? steep : gentlest;
        inflow = better ? s.inflow[k] - lowest * run : inflow, height = better ? here : height;
        highest = better & falls ? here : highest;
    }
    return highest > none;
}

// Return the lanes among `asked` in which the top near this inflow has a negative height, averaged over all azimuths.
template <class R> Mask top_below_zero(const Annuli<R>& of, const Station<Lanes>& at, Mask asked, Lanes top) {
    if (!any(asked)) return asked;
    const Lanes reach = 0.012 * of.stall_scale() * of.rms_speed(at);
    LaneSamples s;
    s.count = 3, s.inflow = {top + reach, top, top - reach};
    residuals(of, at, asked, s.inflow, s.count, of.psi, s.residual);
    Lanes inflow = top, height{};
    deciding_top(s, inflow, height);
    return asked & (height < 0.0) & (absolute(inflow - top) < 0.9 * reach);
}

// Stall angle [rad] in each lane, at positive (side = 1) or negative (side = -1) angles of attack.
template <class R> Lanes stall_angles(const Annuli<R>& of, const Station<Lanes>& at, double side) {
    return each_lane([&](int k) { return of.stall_angle(at.reynolds_per_speed[k], at.radius[k], side); });
}

// Inflow at which the mean angle of attack is `angle` [rad]; NaN if the flow would be almost parallel to the axis.
template <class R> Lanes inflow_at_angle(const Annuli<R>& of, const Station<Lanes>& at, Lanes speed, Lanes angle) {
    const auto phi = at.line - angle_from(angle);
    return phi.cosine > 0.05 ? speed * phi.sine / phi.cosine - of.flow.v_axial : broadcast(std::nan(""));
}
// Inflow at which the mean angle of attack is the stall angle plus `off` [rad] times `stall_scale`.
template <class R>
Lanes inflow_past_stall(const Annuli<R>& of, const Station<Lanes>& at, Lanes speed, Lanes stall, double off) {
    return inflow_at_angle(of, at, speed, stall + off * of.stall_scale());
}

// Factor, at most 1, on the offsets from the stall angle at which `humps_at` samples.  It is larger in forward flight:
// some azimuths stall before others, so the annulus stalls over a wider range of mean angles.
template <class R> Lanes stall_spread(const Annuli<R>& of, const Station<Lanes>& at, Lanes stall) {
    const Lanes rise = absolute((at.line - angle_from(stall)).sine);  // sin(phi) at stall
    return minimum(of.stall_scale() + 5.0 * rise * of.flow.v_inplane / (of.flow.omega * at.radius + 1e-12), 1.0);
}

// Find the humps at the radii in the first `radii` lanes, at positive (side = 1) or negative (side = -1) stall angles.
template <class R> void humps_at(const Annuli<R>& of, Lanes radius, int radii, double side, Hump (&found)[width]) {
    const Dual<Lanes, 1> moved{radius, {broadcast(1.0)}};
    const Station<Dual<Lanes, 1>> moving = station_at(of.rotor, of.flow.omega, moved);
    const Station<Lanes> at = {radius, moving.chord.v, {moving.line.sine, moving.line.cosine, {}},
                               {moving.drag_line.sine, moving.drag_line.cosine, {}}, moving.reynolds_per_speed.v,
                               moving.inverse_root.v, moving.lift_growth.v, moving.drag_growth.v};
    const Lanes speed = of.rms_speed(at), stall = stall_angles(of, at, side), unknown = broadcast(std::nan(""));
    const Mask asked = each_lane([](int k) { return k; }) < double(radii);
    LaneSamples s;
    const auto sample = [&](Mask lanes, std::initializer_list<double> offsets, Lanes times) {
        std::array<Lanes, LaneSamples::most> v{};
        std::array<Dual<Lanes, 1>, LaneSamples::most> g;
        int count = 0;
        for (double off : offsets) {
            const Lanes there = inflow_at_angle(of, at, speed, stall + off * times);
            v[count] = lanes ? there : unknown, g[count] = {unknown, {unknown}};
            ++count;
        }
        residuals(of, at, lanes, v, count, of.few, g);
        for (int j = 0; j < count; ++j, ++s.count) s.inflow[s.count] = v[j], s.residual[s.count] = g[j];
    };
    // Offsets from the stall angle [rad].  If lift may bend again in deep stall, the bends decide which root is found:
    // with fewer samples there, thrust erred by 4 % of static thrust.
    sample(asked, {-0.2, -0.14, -0.095, -0.06, -0.03, -0.005, 0.025, 0.06, 0.1, 0.15}, stall_spread(of, at, stall));
    const Lanes whole = broadcast(1.0);
    if (!of.plain()) sample(asked, {0.2, 0.27, 0.35, 0.43, 0.52, 0.62, 0.73, 0.85}, whole);
    Lanes inflow = unknown, top_height = unknown, below = unknown, depth = broadcast(INFINITY);
    Mask top = deciding_top(s, inflow, top_height);
    // Without a top above zero, the blade is stalled: sample deep stall, where `below` lies.
    const Mask known = inflow == inflow, deeper = known & ~(top & (top_height > 0.0));
    if (of.plain()) sample(deeper, {0.25, 0.45, 0.85}, whole);
    Mask falls = known, clear = known, rising{};
    for (int j = 0; j < s.count; ++j) {
        const Mask taken = s.inflow[j] == s.inflow[j], past = s.inflow[j] < inflow, not_yet = past & (below != below);
        const Lanes value = s.residual[j].v, slope = s.residual[j].d[0];
        falls &= (slope < 0.0) | ~taken;
        depth = past ? minimum(depth, value) : depth;
        clear &= ~(not_yet & rising & (slope > 0.0));
        rising |= past & (slope < 0.0);
        below = not_yet & (value > 0.0) ? s.inflow[j] : below;
    }
    // Below a shoulder there is no maximum if the residual increases as v_i decreases, at all samples.
    clear = top ? clear : falls;
    // Refine the hump with closer samples, over all azimuths if its height is small.
    const Lanes wake = absolute(wake_thrust(of.rotor, radius, of.flow, of.windmill, inflow));
    const Mask small = absolute(top_height) < 0.2 * wake;
    const Lanes reach = 0.012 * of.stall_scale() * speed;
    Mask open = known;
    for (int round = 0; round < 3 && any(open); ++round) {
        s.count = 3;
        for (int j = 0; j < 3; ++j) s.inflow[j] = inflow + (1.0 - j) * reach;
        residuals(of, at, open & ~small, s.inflow, 3, of.few, s.residual);
        residuals(of, at, open & small, s.inflow, 3, of.psi, s.residual);
        Lanes now = inflow;
        const Mask there = deciding_top(s, now, top_height);
        top = open ? there : top;
        now = open ? now : inflow;
        open &= absolute(now - inflow) > 0.9 * reach;
        inflow = now;
    }
    // At a top, dg/dv_i = 0.  The height therefore varies along the blade like the residual at constant v_i.
    const auto over = [&](const Azimuths& psi) {
        return annulus_thrust(of.rotor, moving, of.flow, inflow, psi) -
               wake_thrust(of.rotor, moved, of.flow, of.windmill, inflow);
    };
    const bool same = of.few.count == of.psi.count;
    Dual<Lanes, 1> height = over(any(known & ~small) || same ? of.few : of.psi);
    if (any(known & ~small) && any(small) && !same) {
        const Dual<Lanes, 1> over_all = over(of.psi);
        height.v = small ? over_all.v : height.v, height.d[0] = small ? over_all.d[0] : height.d[0];
    }
    const Lanes past = angle_at(at, speed, of.flow.v_axial + inflow) - stall;
    below = angle_at(at, speed, of.flow.v_axial + below) - stall;
    const Mask near = absolute(height.v) < 0.3 * wake, touching = absolute(height.v) < 0.04 * wake;
    const Mask folded = top & (height.v > 0.0) & (depth < 0.0);
    for (int k = 0; k < width; ++k)
        found[k] = {radius[k], known[k] ? height.v[k] : std::nan(""), inflow[k], past[k], height.d[0][k], below[k], clear[k] != 0,
                    falls[k] != 0, top[k] != 0, folded[k] != 0, near[k] != 0, touching[k] != 0};
}

// A radius at which the largest root jumps from one branch to the other, or varies most steeply with the radius.
struct Fold {
    enum class Kind {
        top,       // a jump: the residual and its derivative with respect to v_i are zero
        shoulder,  // steepest variation: the residual and its second difference over v_i are zero
        angle      // neither was found: the residual is zero at the inflow that gives the stall angle
    };
    double radius;  // [m], NaN for none
    double inflow;  // v_i at this radius [m/s]
    Kind kind;
    double side;    // 1 for stall at positive angles of attack, -1 at negative angles
};

// The residual at the inflow for which the mean angle of attack is the stall angle.
template <class R, class St, class F>
auto residual_at_stall(const R& rotor, const St& at, const F& flow, const Azimuths& psi, bool windmill, double side) {
    const auto turning = flow.omega * at.radius;
    const auto speed = square_root(turning * turning + 0.5 * (flow.v_inplane * flow.v_inplane));
    const double reynolds = value(at.reynolds_per_speed)[0] * value(flow.omega) * value(at.radius)[0];
    const auto phi = at.line - angle_from(broadcast(0.0) + rotor.law.stall_angle(reynolds, side));
    const auto inflow = speed * sine(phi) / cosine(phi) - flow.v_axial;
    return annulus_thrust(rotor, at, flow, inflow, psi) - wake_thrust(rotor, at.radius, flow, windmill, inflow);
}

// Spacing [m/s] of the three inflows between which `fold_between` computes differences.
template <class R, class F, class Y> auto fold_width(const Annuli<R>& of, const F& flow, const Y& radius, bool top) {
    const auto turning = flow.omega * radius;
    const auto speed = square_root(turning * turning + flow.v_inplane * flow.v_inplane) + absolute(flow.v_axial);
    return (top ? 2e-4 : 0.004 * of.stall_scale()) * speed;
}

// Find the fold between two radii whose humps have heights of opposite signs.
// Newton's method solves for the radius y and the inflow v.  At a top, the residual and dg/dv are zero; at a
// shoulder, the residual and its second difference over v.  One evaluation gives all derivatives: three lanes differ
// in v, the fourth in y.  If a step leaves the interval, humps at four radii inside it give a shorter interval.  If no
// fold is found, the result has `Kind::angle`.
template <class R> Fold fold_between(const Annuli<R>& of, Hump low, Hump high, double side) {
    const double first = low.radius, last = high.radius;
    for (int narrowing = 0; narrowing < 12; ++narrowing) {
        const double gap = high.radius - low.radius;
        const Hump& near = std::fabs(low.height) < std::fabs(high.height) ? low : high;
        const double share = std::clamp(low.height / (low.height - high.height), 0.02, 0.98);
        double y = low.radius + share * gap, v = low.inflow + share * (high.inflow - low.inflow);
        const bool top = near.top;
        if (!top && narrowing > 0) break;
        const double speed = fold_width(of, of.flow, y, true) / 2e-4;
        bool near_enough = narrowing > 0;
        for (int step = 0; step < (top ? 20 : 12); ++step) {
            const double wide = fold_width(of, of.flow, y, top), aside = 1e-6 * y;
            static_assert(width >= 4);
            const Lanes radius = each_lane([&](int k) { return k == 3 ? y - aside : y; });
            const Lanes inflow = each_lane([&](int k) { return v + (k == 0 ? wide : k == 2 ? -wide : 0.0); });
            const auto g = of.residual(of.station(radius), inflow, near_enough ? of.psi : of.few);
            const double s0 = g.d[0][0], s1 = g.d[0][1], s2 = g.d[0][2];
            const double bend = (s0 - s2) / (2.0 * wide), turn = s0 - 2.0 * s1 + s2;
            // If the curvature has the wrong sign, step uphill (to a top) or to the flatter side (to a shoulder).
            const double curved = top ? bend : turn, missed = top ? s1 : g.v[0] - 2.0 * g.v[1] + g.v[2];
            const double uphill = top ? (s1 > 0.0 ? 1.0 : -1.0) : (s0 > s2 ? 1.0 : -1.0);
            double dv = curved < 0.0 ? -missed / curved : 2.0 * wide * uphill;
            dv = std::clamp(dv, -0.02 * speed, 0.02 * speed);
            const double along = (g.v[1] - g.v[3]) / aside;
            // Residual after the step dv, to second order.
            const double here = g.v[1] + dv * (s1 + 0.5 * dv * bend);
            const double dy = along != 0.0 ? -here / along : 0.0;
            y += dy, v += dv;
            if (!(y > low.radius && y < high.radius)) break;
            // Few azimuths are sufficient until the steps are short.
            if (!near_enough) {
                near_enough = std::fabs(dy) < 2e-3 * y && std::fabs(dv) < 3e-3 * speed;
                continue;
            }
            if (std::fabs(dy) < 1e-9 * y && std::fabs(dv) < 1e-6 * speed) {
                // Newton's method may converge to another hump, at another angle of attack: then narrow the interval.
                const Hump& above = low.height > 0.0 ? low : high;
                const auto at = of.station(broadcast(y));
                const Lanes past = angle_at(at, of.rms_speed(at), broadcast(of.flow.v_axial + v)) - stall_angles(of, at, side);
                if (above.top && std::fabs(past[0] - above.past) > 0.03 && narrowing < 6) break;
                if (curved < 0.0 && (top || s1 < 0.0)) return {y, v, top ? Fold::Kind::top : Fold::Kind::shoulder, side};
                break;
            }
        }
        // At 20,000 random oblique points in climb, there was no top between two shoulders.
        if (!low.top && !high.top && of.flow.v_axial >= 0.0) break;
        Hump inside[width];
        const double spread = narrowing < 2 ? 0.05 : 0.25;
        constexpr int looks = 4;
        const Lanes radius = each_lane([&](int lane) {
            const int k = std::min(lane, looks - 1);
            const double from = share + spread * (2.0 * k / (looks - 1.0) - 1.0);
            return low.radius + std::clamp(from, 0.01 * (k + 1), 1.0 - 0.01 * (looks - k)) * gap;
        });
        humps_at(of, radius, looks, side, inside);
        for (int k = 0; k < looks; ++k) {
            const Hump& h = inside[k];
            if (std::isnan(h.height) || h.radius <= low.radius || h.radius >= high.radius) continue;
            if ((h.height < 0.0) == (low.height < 0.0)) low = h;
            else { high = h; break; }
        }
        if (high.radius - low.radius < 1e-9 * high.radius) break;
    }
    const Hump& near = std::fabs(low.height) < std::fabs(high.height) ? low : high;
    if (near.top) return {near.radius, near.inflow, Fold::Kind::top, side};
    // No fold at a top or shoulder was found: solve for the radius at which the residual at the stall angle is zero.
    double y = 0.5 * (first + last), step = last - first;
    // Newton's method converges quadratically: after a step of 1e-7 y, the next step would be about 1e-14 y.
    for (int k = 0; k < 20 && std::fabs(step) > 1e-7 * y; ++k) {
        const Dual<Lanes, 1> moved{broadcast(y), {broadcast(1.0)}};
        const auto at = station_at(of.rotor, of.flow.omega, moved);
        const auto g = residual_at_stall(of.rotor, at, of.flow, of.psi, of.windmill, side);
        step = std::clamp(g.v[0] / g.d[0][0], -0.5 * (last - first), 0.5 * (last - first));
        y -= step;
        if (!(y > first - (last - first) && y < last + (last - first))) return {std::nan(""), 0.0, Fold::Kind::angle, side};
    }
    if (!(std::fabs(step) <= 1e-7 * y)) y = std::nan("");
    return {y, 0.0, Fold::Kind::angle, side};
}

}  // namespace propmap
