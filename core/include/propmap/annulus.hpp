// The hybrid inflow v_i(y) of an annulus: the largest root of eq. (11), blade-element thrust (5) = momentum
// thrust (10).
//
// The residual, (5) minus (10), is negative above all roots.  Most annuli have one root, in attached flow.
// About stall the residual has a maximum, the hump: where its top is above zero (11) has three roots, of which
// the largest, on the attached branch, is taken; where it is below, the one root is stalled.  So a root that
// Newton's method finds in attached flow is the one wanted, if the residual can be shown to fall from there
// on; anywhere else the whole range of inflows is scanned.
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
        return rotor.law.stall_angle(reynolds_per_speed * flow.omega * radius, side);
    }
    // Stall sharper than the paper's is looked for in proportionally finer steps.
    double stall_scale() const { return std::min(rotor.law.stall_width() / 0.02, 1.0); }
};

// The angle of attack from zero lift [rad] at a tangential velocity.
inline Lanes angle_at(const Station<Lanes>& at, Lanes u_t, Lanes u_p) {
    const Lanes per = 1.0 / square_root(u_t * u_t + u_p * u_p + 1e-30);
    return angle_of((at.cosine * u_t + at.sine * u_p) * per, (at.sine * u_t - at.cosine * u_p) * per);
}

// An inflow of attached flow without drag [m/s]: v W = k (U_T^2 theta - U_T u), a few steps down to its root.
template <class R> Lanes attached_guess(const Annuli<R>& of, const Station<Lanes>& at) {
    const auto& f = of.flow;
    const Lanes speed = of.rms_speed(at);
    const Lanes k = (of.rotor.blade->blades * value(of.rotor.law.attached_slope()) / (8.0 * pi)) * at.chord / at.radius;
    const Lanes lift = k * speed * speed * at.sine, loss = k * f.omega * at.radius * at.cosine;
    Lanes v = square_root(maximum(lift, 0.0)) + 1.5 * std::max(-f.v_axial, 0.0);
    for (int step = 0; step < 4; ++step) {
        const Lanes u = f.v_axial + v;
        const Lanes w = square_root(speed_squared(f.v_inplane, u));
        v = v + (lift - loss * u - v * w) / (loss + maximum(w + v * u / w, 1e-3 * w));
    }
    return v;
}

struct AttachedRoots {
    Lanes inflow;
    Mask sure;  // whether it is the largest root
};

// Roots by Newton's method from attached flow, at all lanes at once.
template <class R> AttachedRoots attached_roots(const Annuli<R>& of, const Station<Lanes>& at) {
    const auto& f = of.flow;
    const Lanes scale = of.rms_speed(at) + std::fabs(f.v_axial);
    Lanes v = attached_guess(of, at), step = scale;
    const auto newton = [&](const Azimuths& over) {
        const auto g = of.residual(at, v, over);
        step = select(g.d[0] < 0.0, g.v / g.d[0], 0.3 * scale);
        step = maximum(minimum(step, 0.3 * scale), -0.3 * scale);
        v = v - step;
        return g.d[0] < 0.0;
    };
    if (of.few.count < of.psi.count)
        for (int k = 0; k < 4; ++k) {
            newton(of.few);
            if (!any(absolute(step) > 3e-3 * scale)) break;
        }
    Mask falls{};
    for (int k = 0; k < 6; ++k) {
        falls = newton(of.psi);
        if (!any(absolute(step) > 3e-6 * scale)) break;
    }
    // Above a root in attached flow with positive lift the blades' thrust falls with v_i and the momentum's
    // rises.  With negative lift the same holds up to v_i = 0, if no element stalls until there; from there on
    // one thrust is negative and the other is not.
    const double margin = 3.0 * std::max(of.rotor.law.stall_width(), 0.02);
    const Lanes turning = f.omega * at.radius;
    const Lanes slow = turning - f.v_inplane, fast = turning + f.v_inplane;
    const Lanes u = f.v_axial + v;
    Lanes most, least;
    for (int k = 0; k < width; ++k) {
        most[k] = of.stall_angle(at.reynolds_per_speed[k], at.radius[k], 1.0) - margin;
        least[k] = of.stall_angle(at.reynolds_per_speed[k], at.radius[k], -1.0) + margin;
    }
    const Lanes none{};
    const Mask up = f.v_axial + none >= 0.0;
    const Lanes one = angle_at(at, fast, u), other = angle_at(at, slow, u);
    const Lanes later = angle_at(at, slow, f.v_axial + maximum(v, 0.0));
    Mask sure = falls & (absolute(step) <= 3e-6 * scale) & (slow > 0.0);
    sure &= (maximum(one, other) < most) & (minimum(minimum(one, other), later) > least);
    sure &= (v >= 0.0) ? (u >= 0.0) : (up & (f.v_axial + 2.0 * v > 0.0));
    return {v, sure};
}

// Samples of the residual over v_i at one radius, v_i falling.
struct Samples {
    static constexpr int most = 400;
    int count = 0;
    std::array<double, most> inflow, value, slope;

    void append(double v, double g, double s) {
        inflow[count] = v, value[count] = g, slope[count] = s;
        ++count;
    }
};

// The cubic between two samples, in t from 0 at sample k to 1 at the next: its derivative is a + b t + c t^2.
struct Cubic {
    double start, a, b, c;

    Cubic(const Samples& s, int k) {
        const double run = s.inflow[k] - s.inflow[k + 1], rise = s.value[k + 1] - s.value[k];
        const double end = -s.slope[k + 1] * run;
        start = s.value[k], a = -s.slope[k] * run;
        c = 3.0 * (a + end - 2.0 * rise), b = end - a - c;
    }
    double at(double t) const { return start + t * (a + t * (0.5 * b + t * c / 3.0)); }

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

// What a scan of the residual at one radius found.
struct Scan {
    bool found = false;
    double low, high;  // v_i about the largest root [m/s]
    double guess;
    int roots = 0;
};

// Scan the residual over all inflows at one radius.
template <class R> Scan scan(const Annuli<R>& of, double radius, Samples& samples) {
    const auto& f = of.flow;
    const Station<Lanes> at = of.station(broadcast(radius));
    const double speed = std::max(of.rms_speed(at)[0], 0.1 * std::fabs(f.v_axial) + 1e-9);
    const double line = std::atan2(at.sine[0], at.cosine[0]);
    std::array<double, 96> grid;
    int count = 0;
    const auto add_angle = [&](double phi) {
        if (std::fabs(phi) < 1.45) grid[count++] = speed * std::tan(phi) - f.v_axial;
    };
    for (int k = -7; k <= 7; ++k) add_angle(0.2 * k);
    // About stall the residual bends most.
    for (double side : {1.0, -1.0}) {
        const double stall = of.stall_angle(at.reynolds_per_speed[0], radius, side);
        for (double off : {-0.2, -0.15, -0.11, -0.08, -0.055, -0.03, -0.01, 0.01, 0.03, 0.055, 0.09, 0.14})
            add_angle(line - (stall + side * of.stall_scale() * off));
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
            const auto g = of.residual(at, x);
            for (int j = 0; j < width && k + j < n; ++j) into.append(x[j], g.v[j], g.d[0][j]);
        }
    };
    // Above all roots the residual is negative, below all it is positive.
    const double whole = speed + std::fabs(f.v_axial);
    for (double more = 100.0; more < 1e7; more *= 10.0) {
        const double v[2] = {grid[0], grid[count - 1]};
        Samples ends;
        evaluate(v, 2, ends);
        const bool high = ends.value[0] < 0.0, low = ends.value[1] > 0.0;
        if (high && low) break;
        if (!high) grid[0] = more * whole - f.v_axial;
        if (!low) grid[count - 1] = -more * whole - f.v_axial;
    }
    evaluate(grid.data(), count, samples);

    // Where a cubic between two samples turns towards zero, roots may hide: look closer there.
    for (int round = 0; round < 8; ++round) {
        Samples finer;
        bool changed = false;
        for (int k = 0; k < samples.count; ++k) {
            finer.append(samples.inflow[k], samples.value[k], samples.slope[k]);
            if (k + 1 == samples.count) break;
            const double run = samples.inflow[k] - samples.inflow[k + 1];
            if (run < 1e-7 * whole || samples.count + finer.count > Samples::most - 3 * width) continue;
            const Cubic cubic(samples, k);
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
            if (!hides) continue;
            double v[width];
            for (int j = 0; j < width; ++j) v[j] = samples.inflow[k] - run * (j + 1.0) / (width + 1.0);
            evaluate(v, width, finer);
            changed = true;
        }
        samples = finer;
        if (!changed) break;
    }

    Scan result;
    for (int k = 0; k + 1 < samples.count; ++k) {
        if ((samples.value[k] < 0.0) == (samples.value[k + 1] < 0.0)) continue;
        ++result.roots;
        if (result.found) continue;
        result.found = true;
        result.high = samples.inflow[k], result.low = samples.inflow[k + 1];
        // The cubic's zero by bisection: cheap beside an evaluation.
        const Cubic cubic(samples, k);
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

// The hump of the residual at a radius: its local maximum about stall, at the largest v_i, or else the
// shoulder, where the residual comes closest to having one.  Where one becomes the other they are one point.
struct Hump {
    double radius;
    double height;  // the residual there
    double inflow;  // v_i there [m/s]
    double slope;   // of the height along the blade
    bool top;       // whether it is a maximum
    bool folded;    // whether (11) has three roots here
};

// The first maximum in samples of falling v_i, or else the shoulder.
inline bool first_top(const Samples& s, double& inflow, double& height) {
    double gentlest = INFINITY;
    for (int k = 0; k + 1 < s.count; ++k) {
        const Cubic cubic(s, k);
        const double run = s.inflow[k] - s.inflow[k + 1];
        double lowest = cubic.c > 0.0 ? std::clamp(-0.5 * cubic.b / cubic.c, 0.0, 1.0)
                                      : (cubic.b + cubic.c > 0.0 ? 0.0 : 1.0);
        const double least = cubic.a + (cubic.b + cubic.c * lowest) * lowest;
        const bool falls = cubic.a > 0.0 && least < 0.0;
        if (falls) {
            const double root = std::sqrt(std::max(cubic.b * cubic.b - 4.0 * cubic.a * cubic.c, 0.0));
            lowest = std::clamp(2.0 * cubic.a / std::max(root - cubic.b, 1e-300), 0.0, 1.0);
        }
        if (falls || least / run < gentlest) {
            gentlest = least / run;
            inflow = s.inflow[k] - lowest * run, height = cubic.at(lowest);
        }
        if (falls) return true;
    }
    return false;
}

// The hump about the stall at positive (side = 1) or negative angles.
template <class R> Hump hump_at(const Annuli<R>& of, double radius, double side) {
    const auto& f = of.flow;
    const Station<Lanes> at = of.station(broadcast(radius));
    const double speed = of.rms_speed(at)[0], line = std::atan2(at.sine[0], at.cosine[0]);
    const double stall = of.stall_angle(at.reynolds_per_speed[0], radius, side), scale = of.stall_scale();
    Samples s;
    const auto sample = [&](const double* v, int n) {
        s.count = 0;
        for (int k = 0; k < n; k += width) {
            const Lanes x = each_lane([&](int j) { return v[std::min(k + j, n - 1)]; });
            const auto g = of.residual(at, x);
            for (int j = 0; j < width && k + j < n; ++j) s.append(x[j], g.v[j], g.d[0][j]);
        }
    };
    double grid[16];
    int count = 0;
    for (double off : {-0.2, -0.15, -0.11, -0.08, -0.055, -0.03, -0.01, 0.01, 0.03, 0.055, 0.09, 0.14}) {
        const double phi = line - (stall + scale * off);
        if (std::fabs(phi) < 1.5) grid[count++] = speed * std::tan(phi) - f.v_axial;
    }
    Hump found{radius, std::nan(""), 0.0, 0.0, false, false};
    if (count < 3) return found;
    sample(grid, count);
    found.top = first_top(s, found.inflow, found.height);
    double depth = INFINITY;
    for (int k = 0; k < s.count; ++k)
        if (s.inflow[k] < found.inflow) depth = std::min(depth, s.value[k]);
    for (double half : {0.012 * scale, 0.002 * scale}) {
        double v[width];
        for (int j = 0; j < width; ++j) v[j] = found.inflow + half * speed * (1.0 - 2.0 * j / (width - 1.0));
        sample(v, width);
        found.top = first_top(s, found.inflow, found.height);
    }
    found.folded = found.top && found.height > 0.0 && depth < 0.0;
    // At the top the residual's slope by v_i is zero: along the blade the height changes as the residual does.
    const double step = 1e-6 * radius;
    const Lanes y = each_lane([&](int k) { return k == 0 ? radius : radius - step; });
    const auto g = of.residual(of.station(y), broadcast(found.inflow));
    found.slope = (g.v[0] - g.v[1]) / step;
    return found;
}

// A radius at which the largest root jumps from one branch to another, or rises most steeply.
struct Fold {
    double radius;
    double inflow;  // v_i at the hump's top there [m/s]
    bool top;
};

// Solve for the fold between two radii whose humps have heights of opposite signs.
template <class R> Fold fold_between(const Annuli<R>& of, Hump low, Hump high, double side) {
    Hump here = std::fabs(low.height) < std::fabs(high.height) ? low : high;
    for (int step = 0; step < 40; ++step) {
        const double gap = high.radius - low.radius;
        if (gap < 1e-11 * high.radius) break;
        double next = here.radius - here.height / here.slope;
        const double room = step < 4 ? 0.02 * gap : 0.0;
        if (!(next > low.radius + room && next < high.radius - room)) {
            const double share = low.height / (low.height - high.height);
            next = low.radius + std::clamp(share, 0.1, 0.9) * gap;
        }
        const bool close = std::fabs(next - here.radius) < 1e-9 * next;
        here = hump_at(of, next, side);
        if (!std::isfinite(here.height)) break;
        ((here.height < 0.0) == (low.height < 0.0) ? low : high) = here;
        if (close) break;
    }
    return {here.radius, here.inflow, here.top};
}

}  // namespace propmap
