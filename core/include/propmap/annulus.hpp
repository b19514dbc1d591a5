// The hybrid inflow v_i(y) of an annulus: the largest root of eq. (11), blade-element thrust (5) = momentum
// thrust (10).
//
// The residual, (5) minus (10), is negative above all roots.  Most annuli have one root, in attached flow.
// About stall the residual has a maximum, the hump: where its top is above zero (11) has three roots, of which
// the largest, on the attached branch, is taken; where it is below, the one root is stalled.  So a root that
// Newton's method finds in attached flow is the one wanted, if the residual can be shown to fall from there
// on; and one that it finds above the hump, or below a hump that is below zero, if that is how humps at radii
// near by say it should be.  Anywhere else the whole range of inflows is scanned.
#pragma once

#include <array>

#include "inflow.hpp"

namespace propmap {

// Equation (11) at one operating point.
template <class R> struct Annuli {
    const R& rotor;
    Flow<double> flow;
    Azimuths psi;
    Azimuths few;   // some of them, for steps from afar
    bool windmill;  // whether the windmill branch of momentum theory holds

    Station<Lanes> station(Lanes radius) const { return station_at(rotor, flow.omega, radius); }

    // Blade-element thrust minus momentum thrust per radius and density, with its slope by the inflow.
    Dual<Lanes, 1> residual(const Station<Lanes>& at, Lanes inflow, const Azimuths& over) const {
        const Dual<Lanes, 1> v{inflow, {broadcast(1.0)}};
        return annulus_thrust(rotor, at, flow, v, over) -
               wake_thrust(rotor, at.radius, flow, windmill, v);  // Eq. (11)
    }
    Dual<Lanes, 1> residual(const Station<Lanes>& at, Lanes inflow) const { return residual(at, inflow, psi); }

    // U_T [m/s], root mean square over azimuth.
    Lanes rms_speed(const Station<Lanes>& at) const {
        const Lanes turning = flow.omega * at.radius;
        return square_root(turning * turning + (0.5 * flow.v_inplane * flow.v_inplane + 1e-18));
    }
    double stall_angle(double reynolds_per_speed, double radius, double side) const {
        return value(rotor.law.stall_angle(reynolds_per_speed * flow.omega * radius, side));
    }
    // Whether some samples tell how the residual goes between them: not where lift has further bends in deep stall, or
    // the tip's loss in descent, where it is greatest with the air standing still at the disk.
    bool plain() const {
        return rotor.law.plain_stall && rotor.law.stall_delay == 0.0 &&
               !(flow.v_axial < 0.0 && (rotor.tip_loss || rotor.hub_radius > 0.0));
    }
    // Stall sharper than the paper's is looked for in proportionally finer steps.
    double stall_scale() const { return std::min(rotor.law.stall_width() / 0.02, 1.0); }
};

// The angle of attack from zero lift [rad] at a tangential velocity.
inline Lanes angle_at(const Station<Lanes>& at, Lanes u_t, Lanes u_p) {
    const Lanes per = inverse_square_root(u_t * u_t + u_p * u_p + 1e-30);
    return radians(at.line - Angle<Lanes>{u_p * per, u_t * per, {}});
}

// An inflow of attached flow without drag [m/s]: v W = k (U_T^2 theta - U_T u), a few steps down to its root.
template <class R> Lanes attached_guess(const Annuli<R>& of, const Station<Lanes>& at) {
    const auto& f = of.flow;
    const Lanes speed = of.rms_speed(at);
    const Lanes k = (of.rotor.blade->blades * value(of.rotor.law.attached_slope()) / (8.0 * pi)) * at.chord / at.radius;
    const Lanes lift = k * speed * speed * at.line.sine, loss = k * f.omega * at.radius * at.line.cosine;
    Lanes v = square_root(maximum(lift, 0.0)) + 1.5 * std::max(-f.v_axial, 0.0);
    for (int step = 0; step < 4; ++step) {
        const Lanes u = f.v_axial + v;
        const Lanes square = speed_squared(f.v_inplane, u), per = inverse_square_root(square), w = square * per;
        v = v + (lift - loss * u - v * w) / (loss + maximum(w + v * u * per, 1e-3 * w));
    }
    return v;
}

// Whether a root v is in attached flow at all azimuths, so that there is none above.
//
// Above it the blades' thrust falls with v_i and the momentum's rises, where the lift is positive.  With negative
// lift both hold up to v_i = 0, if no element stalls until there; from there on the two have opposite signs.
template <class R> Mask surely_largest(const Annuli<R>& of, const Station<Lanes>& at, Lanes v) {
    const auto& f = of.flow;
    const double margin = 3.0 * std::max(of.rotor.law.stall_width(), 0.02);
    const Lanes turning = f.omega * at.radius;
    const Lanes slow = turning - f.v_inplane, fast = turning + f.v_inplane;
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
    // On the windmill branch the wake's thrust rises with v_i wherever the air goes.
    const Mask rises = of.windmill && of.plain() ? v >= 0.0 : u >= 0.0;
    sure &= (v >= 0.0) ? rises : (climb & (f.v_axial + 2.0 * v > 0.0));
    return sure;
}

// The cubic between two samples, in t from 0 at the first to 1 at the second: its derivative is a + b t + c t^2.
template <class T> struct Cubic {
    T start, a, b, c;

    // From values and slopes by v_i at two v_i, `run` apart and falling.
    Cubic(T run, T value, T slope, T next_value, T next_slope) {
        const T rise = next_value - value, end = -next_slope * run;
        start = value, a = -slope * run;
        c = 3.0 * (a + end - 2.0 * rise), b = end - a - c;
    }
    T at(T t) const { return start + t * (a + t * (0.5 * b + t * c / 3.0)); }

    // Places of its extremes inside, how many.
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

// Samples of the residual over v_i at one radius, v_i falling.
struct Samples {
    static constexpr int most = 400;
    int count = 0;
    std::array<double, most> inflow, value, slope;

    void append(double v, double g, double s) {
        inflow[count] = v, value[count] = g, slope[count] = s;
        ++count;
    }
    // Between sample k and the next.
    Cubic<double> cubic(int k) const {
        return {inflow[k] - inflow[k + 1], value[k], slope[k], value[k + 1], slope[k + 1]};
    }
};

// What a scan of the residual at one radius found.
struct Scan {
    bool found = false;
    double low, high;  // v_i about the largest root [m/s]
    double guess;
    int roots = 0;
};

// Scan the residual over all inflows at one radius; about stall, where it bends most, only at one of `every` so many
// places.
template <class R> Scan scan(const Annuli<R>& of, double radius, const Azimuths& over, Samples& samples, int every) {
    const auto& f = of.flow;
    const Station<Lanes> at = of.station(broadcast(radius));
    const double speed = std::max(of.rms_speed(at)[0], 0.1 * std::fabs(f.v_axial) + 1e-9);
    const double line = radians(at.line)[0];
    std::array<double, 96> grid;
    int count = 0;
    // Places are chosen by the angle of the flow.
    std::array<double, 48> angle;
    int angles = 0;
    const auto add_angle = [&](double phi) {
        if (std::fabs(phi) < 1.45) angle[angles++] = phi;
    };
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
    grid[count++] = -f.v_axial;  // the air at the disk stands still
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
    // Above all roots the residual is negative, below all it is positive.
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

    // Where a cubic between two samples turns towards zero, roots may hide: look closer there.
    constexpr int between = 4;
    for (int round = 0; round < 8; ++round) {
        std::array<double, Samples::most> asked;
        int more = 0;
        for (int k = 0; k + 1 < samples.count; ++k) {
            const double run = samples.inflow[k] - samples.inflow[k + 1];
            if (run < 1e-7 * whole || samples.count + more + between > Samples::most) continue;
            const Cubic<double> cubic = samples.cubic(k);
            const double g0 = samples.value[k], g1 = samples.value[k + 1];
            double t[2];
            const int extremes = cubic.extremes(t);
            const bool crosses = (g0 < 0.0) != (g1 < 0.0);
            const bool opposed = cubic.a * (cubic.a + cubic.b + cubic.c) < 0.0;
            bool hides = crosses && (extremes > 0 || opposed);
            for (int e = 0; e < extremes && !crosses; ++e) {
                const double there = cubic.at(t[e]), nearest = std::min(std::fabs(g0), std::fabs(g1));
                const bool beyond = (there < 0.0) != (g0 < 0.0);
                hides |= beyond || std::fabs(there) < 0.7 * nearest;
            }
            // A peak sharper than the cubic's reaches no further than where the tangents at both ends meet.
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
        // The cubic's zero by bisection: cheap beside an evaluation.
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

// Roots between `low` and `high` by Newton's method, held between the two: NaN where it does not converge.
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

// The hump of the residual at a radius: the local maximum about stall that decides on the largest root, or else the
// shoulder, where the residual comes closest to having one.  Where one becomes the other they are one point.
struct Hump {
    double radius;
    double height;  // the residual there
    double inflow;  // v_i there [m/s]
    double past;    // the mean angle of attack there, from that of stall [rad]: it hardly varies along the blade
    double slope;   // of the height along the blade
    double below;   // an angle, like `past`, at which the residual is positive again at a smaller v_i; NaN for none
    bool clear;     // whether it has no other maximum until there
    bool falls;     // whether it falls with v_i everywhere
    bool top;       // whether it is a maximum
    bool folded;    // whether (11) has three roots here
    bool near;      // whether the height is small, and whether it is so small that the blade's shape between two
    bool touching;  // stations may take it through zero
};

// Residuals at a few of the lanes, each at as many inflows, packed so that none are idle.
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

// Samples of the residual at a radius per lane, v_i falling; NaN where a lane has none.
struct LaneSamples {
    static constexpr std::size_t most = 24;
    int count = 0;
    std::array<Lanes, most> inflow;
    std::array<Dual<Lanes, 1>, most> residual;  // with its slope by v_i
};

// The maximum in samples that decides on the largest root, the first one above zero or else the highest; where there is
// none, the shoulder.  Returns where there is one.
inline Mask deciding_top(const LaneSamples& s, Lanes& inflow, Lanes& height) {
    const Lanes none = broadcast(-INFINITY), one = broadcast(1.0);
    const auto clamped = [&](Lanes t) { return minimum(maximum(t, 0.0), one); };
    Lanes gentlest = -none, highest = none;
    for (int k = 0; k + 1 < s.count; ++k) {
        const Lanes run = s.inflow[k] - s.inflow[k + 1];
        const auto &above = s.residual[k], &below = s.residual[k + 1];
        const Cubic<Lanes> cubic(run, above.v, above.d[0], below.v, below.d[0]);
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

// Where the residual's top near this inflow, in lanes asked for, is found below zero.
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

template <class R> Lanes stall_angles(const Annuli<R>& of, const Station<Lanes>& at, double side) {
    return each_lane([&](int k) { return of.stall_angle(at.reynolds_per_speed[k], at.radius[k], side); });
}

// Inflows at which the mean angle of attack is this one; NaN where none gives it.
template <class R> Lanes inflow_at_angle(const Annuli<R>& of, const Station<Lanes>& at, Lanes speed, Lanes angle) {
    const auto phi = at.line - angle_from(angle);
    return phi.cosine > 0.05 ? speed * phi.sine / phi.cosine - of.flow.v_axial : broadcast(std::nan(""));
}
template <class R>
Lanes inflow_past_stall(const Annuli<R>& of, const Station<Lanes>& at, Lanes speed, Lanes stall, double off) {
    return inflow_at_angle(of, at, speed, stall + off * of.stall_scale());
}

// Over how wide a range of mean angles an annulus stalls, as a share of the paper's: in forward flight some azimuths
// stall before others.
template <class R> Lanes stall_spread(const Annuli<R>& of, const Station<Lanes>& at, Lanes stall) {
    const Lanes rise = absolute((at.line - angle_from(stall)).sine);  // sin(phi) at stall
    return minimum(of.stall_scale() + 5.0 * rise * of.flow.v_inplane / (of.flow.omega * at.radius + 1e-12), 1.0);
}

// The humps about the stall at positive (side = 1) or negative angles, at a radius per lane, in the first of them.
template <class R> void humps_at(const Annuli<R>& of, Lanes radius, int radii, double side, Hump (&found)[width]) {
    const Dual<Lanes, 1> moved{radius, {broadcast(1.0)}};
    const Station<Dual<Lanes, 1>> moving = station_at(of.rotor, of.flow.omega, moved);
    const Station<Lanes> at = {radius, moving.chord.v, {moving.line.sine, moving.line.cosine, {}},
                               {moving.drag_line.sine, moving.drag_line.cosine, {}}, moving.reynolds_per_speed.v,
                               moving.inverse_root.v};
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
    sample(asked, {-0.2, -0.14, -0.095, -0.06, -0.03, -0.005, 0.025, 0.06, 0.1, 0.15}, stall_spread(of, at, stall));
    const Lanes whole = broadcast(1.0);
    if (!of.plain()) sample(asked, {0.2, 0.27, 0.35, 0.43, 0.52, 0.62, 0.73, 0.85}, whole);
    Lanes inflow = unknown, top_height = unknown, below = unknown, depth = broadcast(INFINITY);
    Mask top = deciding_top(s, inflow, top_height);
    // Where flow stalls, see how the residual goes on.
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
    // What follows a shoulder rises.
    clear = top ? clear : falls;
    // More closely, and over all azimuths where the height is small.
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
    // At the top the residual's slope by v_i is zero: along the blade the height changes as the residual does.
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

// A radius at which the largest root jumps from one branch to another, or rises steeply.
struct Fold {
    enum class Kind {
        top,       // a jump: the residual and its slope by v_i vanish
        shoulder,  // the steepest rise: the residual and its second difference vanish
        angle      // neither is found: the residual vanishes where the mean angle of attack is that of stall
    };
    double radius;  // [m], NaN for none
    double inflow;  // v_i there [m/s]
    Kind kind;
    double side;    // 1 for stall at positive angles, -1 at negative ones
};

// The residual at the inflow with which the mean angle of attack is that of stall.
template <class R, class St, class F>
auto residual_at_stall(const R& rotor, const St& at, const F& flow, const Azimuths& psi, bool windmill, double side) {
    const auto turning = flow.omega * at.radius;
    const auto speed = square_root(turning * turning + 0.5 * (flow.v_inplane * flow.v_inplane));
    const double reynolds = value(at.reynolds_per_speed)[0] * value(flow.omega) * value(at.radius)[0];
    const auto phi = at.line - angle_from(broadcast(0.0) + rotor.law.stall_angle(reynolds, side));
    const auto inflow = speed * sine(phi) / cosine(phi) - flow.v_axial;
    return annulus_thrust(rotor, at, flow, inflow, psi) - wake_thrust(rotor, at.radius, flow, windmill, inflow);
}

// Spacing [m/s] of the three inflows from whose residuals the second derivative at a radius is taken.
template <class R, class F, class Y> auto fold_width(const Annuli<R>& of, const F& flow, const Y& radius, bool top) {
    const auto turning = flow.omega * radius;
    const auto speed = square_root(turning * turning + flow.v_inplane * flow.v_inplane) + absolute(flow.v_axial);
    return (top ? 2e-4 : 0.004 * of.stall_scale()) * speed;
}

// Solve for the fold between two radii whose humps have heights of opposite signs.
//
// At a fold the residual and its slope vanish; where the hump is a shoulder, the residual and its second derivative.
// Newton's steps towards either take one evaluation in four lanes; where they leave the interval, it is narrowed by
// the humps of radii within.
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
            // Far from the top, or the shoulder, go where the residual is flatter.
            const double curved = top ? bend : turn, missed = top ? s1 : g.v[0] - 2.0 * g.v[1] + g.v[2];
            const double uphill = top ? (s1 > 0.0 ? 1.0 : -1.0) : (s0 > s2 ? 1.0 : -1.0);
            double dv = curved < 0.0 ? -missed / curved : 2.0 * wide * uphill;
            dv = std::clamp(dv, -0.02 * speed, 0.02 * speed);
            const double along = (g.v[1] - g.v[3]) / aside;
            // The residual where the step by v ends, to second order.
            const double here = g.v[1] + dv * (s1 + 0.5 * dv * bend);
            const double dy = along != 0.0 ? -here / along : 0.0;
            y += dy, v += dv;
            if (!(y > low.radius && y < high.radius)) break;
            // A few azimuths do from afar.
            if (!near_enough) {
                near_enough = std::fabs(dy) < 2e-3 * y && std::fabs(dv) < 3e-3 * speed;
                continue;
            }
            if (std::fabs(dy) < 1e-9 * y && std::fabs(dv) < 1e-6 * speed) {
                // It must be that of the hump which is above zero: Newton's steps may end at another one's.
                const Hump& above = low.height > 0.0 ? low : high;
                const auto at = of.station(broadcast(y));
                const Lanes past = angle_at(at, of.rms_speed(at), broadcast(of.flow.v_axial + v)) - stall_angles(of, at, side);
                if (above.top && std::fabs(past[0] - above.past) > 0.03 && narrowing < 6) break;
                if (curved < 0.0 && (top || s1 < 0.0)) return {y, v, top ? Fold::Kind::top : Fold::Kind::shoulder, side};
                break;
            }
        }
        // In climb no top was ever found between two shoulders.
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
    // The residual is nowhere flat.
    double y = 0.5 * (first + last), step = last - first;
    // Newton's steps: after one of 1e-7 the next would be 1e-14.
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
