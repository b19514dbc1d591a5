// Lift and drag of a blade section, eqs. (3) and (4), at any angle of attack and Reynolds number.
//
// A section law is a struct of numbers.  `coefficients` and the functions whose names end in `_at` are its
// aerodynamics.  The search for the inflow uses `stall_angle`, `stall_width` (range of angles over which lift drops, in
// rad), `attached_slope` and `plain_stall`.  `kind` is the name of the law.  `each_number` visits the numbers with
// respect to which loads can be differentiated.  `read_fixed` and `copy_fixed` then set all other members.  To add a
// law, write such a struct and list it in laws.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "velocities.hpp"

namespace propmap {

// The flow at a section.
template <class A, class B, class C, class D, class E> struct SectionFlow {
    Angle<A> alpha;           // angle of attack from zero lift
    Angle<A> drag_alpha;      // angle of attack from least drag
    B speed;                  // U [m/s]
    C reynolds;               // rho U c / mu [-]
    D inverse_root_reynolds;  // Re^(-1/2) [-]
    E lift_growth;            // factors on attached lift and drag, from the Reynolds number of the rotation alone [-]
    E drag_growth;
};

template <class L, class D> struct Coefficients {
    L lift;  // C_L [-]
    D drag;  // C_D [-]
};

// The paper's law with two more terms: a zero-lift angle that grows with ln(Re), and an angle of least drag that
// differs from it.  `S` is double, or a dual number if loads are differentiated.
template <class S> struct BlendedLaw {
    S c_l1;             // slope of attached lift [1/rad]
    S c_l2;             // amplitude of separated lift [-]
    S c_d;              // amplitude of pressure drag [-]
    S alpha_0;          // angle of attack at stall [rad]
    S zero_lift_angle;  // [rad]; eqs. (3) and (4) use alpha minus this angle
    S c_d0;             // constant drag [-]
    S c_p;              // skin friction constant [-]
    S sharpness;        // M of the stall blend [1/rad]
    S reynolds_camber;  // growth of the zero-lift angle with ln(Re) [rad]
    S drag_angle;       // angle of least pressure drag minus zero_lift_angle [rad]
    double attached;    // 1 for eq. (3); 0 for the simplified lift of footnote 1, whose c_l is c_l2
    double plate;       // 0.44 for the separated lift of a plate, 0 for that of the paper
    S far;              // exp(-2 M alpha_0), for stall at negative angles
    double most = 40.0; // limit of the exponents in the stall blend [-]; beyond it the blend is constant

    static constexpr bool plain_stall = true;  // lift bends sharply near stall only
    static constexpr const char* kind = "blended";
    template <class Visit> void each_number(Visit visit) {
        visit("c_l1", c_l1), visit("c_l2", c_l2), visit("c_d", c_d), visit("alpha_0", alpha_0);
        visit("zero_lift_angle", zero_lift_angle), visit("c_d0", c_d0), visit("c_p", c_p);
        visit("sharpness", sharpness);
        visit("reynolds_camber", reynolds_camber), visit("drag_angle", drag_angle);
    }
    template <class Source> void read_fixed(const Source& from) { attached = from.number("attached"), plate = from.number("plate"), complete(); }
    template <class Law> void copy_fixed(const Law& from) { attached = from.attached, plate = from.plate, complete(); }
    void complete() { far = power_of_two(maximum(-2.0 * log2_e * sharpness * alpha_0, 0.0 * alpha_0 - 100.0)); }

    static constexpr double log2_e = 1.44269504088896340736;

    // `reynolds` is the Reynolds number of the rotation alone, so the angle is known before the inflow.
    template <class R> auto zero_lift_angle_at(const R& reynolds) const {
        if constexpr (!IsDual<S> && !IsDual<R>)
            if (reynolds_camber == 0.0) return zero_lift_angle + 0.0 * reynolds;
        return zero_lift_angle + reynolds_camber * log_reynolds(reynolds);
    }
    template <class R> auto least_drag_angle_at(const R&) const { return zero_lift_angle + drag_angle; }
    template <class R> double lift_growth_at(const R&) const { return 1.0; }
    template <class R> double drag_growth_at(const R&) const { return 1.0; }
    template <class R> static auto log_reynolds(const R& reynolds) {  // constant outside the range of identified propellers
        const auto within = minimum(maximum(reynolds, broadcast_like(value(reynolds), 1e4)),
                                    broadcast_like(value(reynolds), 1.2e5));
        return logarithm(within * (1.0 / 5e4));
    }

    // `growing` selects the factors of `GrowingLaw` on lift and drag.
    template <bool growing = false, class F> auto coefficients(const F& flow) const {
        const auto angle = radians(flow.alpha);
        const auto& [sine, cosine, change] = flow.alpha;
        const auto separated = c_l2 * separated_share(change, sine, cosine);
        const auto share = attached_share(angle);
        const auto pressure = c_d * square(propmap::sine(flow.drag_alpha));
        const auto friction = (2.0 * 1.02) * c_p * flow.inverse_root_reynolds;
        const auto both = [](const auto& lift, const auto& drag) {
            return Coefficients<decltype(lift + 0.0), decltype(drag + 0.0)>{lift, drag};
        };
        if constexpr (growing)
            return both(separated + share * (c_l1 * flow.lift_growth * angle - separated),
                        (1.0 + share * (flow.drag_growth - 1.0)) * (pressure + c_d0) + friction);
        else
            return both(separated + share * (c_l1 * angle - separated),  // Eq. (3)
                        pressure + friction + c_d0);                     // Eq. (4)
    }

    // Separated lift divided by c_l2: sin(a) cos(a) in eq. (3).  For a plate it is divided by 0.56 + 0.44 |sin(a)|
    // (Hoerner, Fluid-Dynamic Drag, 1965, p. 3-16), which gives more lift just past stall.
    template <class C, class V> auto separated_share(const C& change, const V& sine, const V& cosine) const {
        const V lift = sine * cosine, slope = cosine * cosine - sine * sine;
        if (plate == 0.0) return chain(change, lift, slope);
        const V per = 1.0 / (1.0 - plate + plate * absolute(sine));
        return chain(change, lift * per, (slope - plate * absolute(sine) * cosine * cosine * per) * per);
    }

    // 1 - sigma, the attached share of the flow.
    // The paper writes sigma = (1 + A + B)/((1 + A)(1 + B)), A = exp(-M (a - a0)), B = exp(M (a + a0)), which
    // overflows.  sigma is even in a.  For a >= 0, 1 - sigma = x/((1 + x)(x + e)) with x = 1/A and e = exp(-2 M a0): a
    // single exponential, whose argument is limited.
    template <class A> auto attached_share(const A& angle) const {
        const auto exponent = sharpness * (absolute(angle) - alpha_0);
        const auto limit = broadcast_like(value(exponent), most);
        const auto x = power_of_two(log2_e * maximum(minimum(value(exponent), limit), -limit));
        const auto per = 1.0 / ((1.0 + x) * (x + value(far)));
        const auto share = attached * x * per;
        return chain(exponent, far, share, share * (value(far) - x * x) * per, -share * per * (1.0 + x));
    }

    S stall_angle(double, double side) const { return side * alpha_0; }
    double stall_width() const { return 1.0 / value(sharpness); }
    auto attached_slope() const { return attached * c_l1; }
};

// The law above, with powers of the Reynolds number as factors on attached lift and drag.  It is a separate law because
// factors of 1 would change how the compiler rounds the terms of the paper.
template <class S> struct GrowingLaw : BlendedLaw<S> {
    S reynolds_lift;  // power of Re in the slope of attached lift [-]
    S reynolds_drag;  // power of Re in the pressure drag and constant drag of attached flow [-]

    static constexpr const char* kind = "growing";
    template <class Visit> void each_number(Visit visit) {
        BlendedLaw<S>::each_number(visit);
        visit("reynolds_lift", reynolds_lift), visit("reynolds_drag", reynolds_drag);
    }

    // Factors on attached lift and drag, from the Reynolds number of the rotation alone.
    template <class R> auto lift_growth_at(const R& reynolds) const { return growth(reynolds_lift, reynolds); }
    template <class R> auto drag_growth_at(const R& reynolds) const { return growth(reynolds_drag, reynolds); }
    template <class R> static auto growth(const S& power, const R& reynolds) {
        return power_of_two(BlendedLaw<S>::log2_e * power * BlendedLaw<S>::log_reynolds(reynolds));
    }

    template <class F> auto coefficients(const F& flow) const { return BlendedLaw<S>::template coefficients<true>(flow); }
};

// The numbers of a tabulated law (`SectionTable.core_law` in Python).  For each interval of angles and each Reynolds
// number, the table contains cubics of C_L, dC_L/d ln(Re), C_D and dC_D/d ln(Re), lowest power first.
struct SectionTable {
    std::vector<double> knots;   // angles from zero lift [rad], rising from -pi to pi
    std::vector<int> first;      // for each of many equal steps around the circle: the interval at its start
    std::vector<double> rows;    // 16 numbers per Reynolds number and interval
    std::vector<double> log_re;  // rising
    std::vector<double> stall_up, stall_down;  // stall angles at each Reynolds number [rad]
    double attached_slope;                     // of lift over angle [1/rad]
    // Stall width, assumed for every table [rad].  A smaller width requires more azimuths and a stricter limit on the
    // error (rotor.hpp).
    double stall_width = 0.014;
};

// C_L and C_D from a table, by monotone cubics in the angle and in ln(Re).  Outside the table, the nearest Re is used.
template <class S> struct TabulatedLaw {
    std::shared_ptr<const SectionTable> table;
    S zero_lift_angle;  // [rad]

    static constexpr bool plain_stall = false;
    static constexpr const char* kind = "tabulated";
    template <class Visit> void each_number(Visit visit) { visit("zero_lift_angle", zero_lift_angle); }
    template <class Source> void read_fixed(const Source& from) {
        const auto knots = from.numbers("knots", 2, true), log_re = from.numbers("log_re", 1, true);
        const std::size_t intervals = knots.size() - 1, rows = log_re.size();
        const auto first = from.numbers("first", 1, true);
        for (double k : first) from.check(k >= 0.0 && k < double(intervals), "the array first has an interval that does not exist");
        table = std::make_shared<SectionTable>(SectionTable{
            knots, {first.begin(), first.end()}, from.numbers("rows", 16 * rows * intervals), log_re,
            from.numbers("stall_up", rows), from.numbers("stall_down", rows), from.number("attached_slope")});
    }
    template <class Law> void copy_fixed(const Law& from) { table = from.table; }

    template <class R> auto zero_lift_angle_at(const R&) const { return zero_lift_angle; }
    template <class R> auto least_drag_angle_at(const R&) const { return zero_lift_angle; }
    template <class R> double lift_growth_at(const R&) const { return 1.0; }
    template <class R> double drag_growth_at(const R&) const { return 1.0; }

    int interval(double angle) const {  // the interval that contains this angle
        const int count = int(table->first.size()), intervals = int(table->knots.size()) - 1;
        const double step = (angle + pi) * (count / (2.0 * pi));
        int k = table->first[step >= 0.0 ? std::min(int(std::min(step, count - 1.0)), count - 1) : 0];
        while (k < intervals - 1 && angle >= table->knots[k + 1]) ++k;
        return k;
    }

    // A place among the Reynolds numbers of the table: index `row` of the one below, and fraction of the interval in ln(Re).
    // A coefficient is the sum of `count` table values with the weights `at`.  With the weights `slope`, the sum is its
    // derivative with respect to ln(Re).  The values are coefficient and derivative at `row`, then at the next number.
    struct Place {
        std::size_t row;
        int count;
        double fraction, at[4], slope[4];
    };
    Place place_of(double log_re) const {
        const auto& x = table->log_re;
        const std::size_t next = std::upper_bound(x.begin(), x.end(), log_re) - x.begin();
        if (next == 0 || next == x.size()) return {next == 0 ? 0 : next - 1, 1, 0.0, {std::isnan(log_re) ? log_re : 1.0}, {}};
        const double span = x[next] - x[next - 1], t = (log_re - x[next - 1]) / span, u = 1.0 - t, bump = 6.0 * t * u / span;
        return {next - 1, 4, t, {u * u * (1.0 + 2.0 * t), span * t * u * u, t * t * (1.0 + 2.0 * u), -span * t * t * u},
                {-bump, u * (1.0 - 3.0 * t), bump, t * (1.0 - 3.0 * u)}};
    }

    // C_L (which = 0) or C_D (which = 8), and its derivatives with respect to the angle and ln(Re), in interval k of
    // angles.  `along` is the angle [rad] past the start of the interval.
    std::array<double, 3> look_up(int which, int k, double along, const Place& place) const {
        const std::size_t intervals = table->knots.size() - 1;
        double value = 0.0, by_angle = 0.0, by_log_re = 0.0;
        for (int j = 0; j < place.count; ++j) {
            const double* c = &table->rows[16 * ((place.row + j / 2) * intervals + k) + which + 4 * (j % 2)];
            const double there = c[0] + along * (c[1] + along * (c[2] + along * c[3]));
            value += place.at[j] * there, by_log_re += place.slope[j] * there;
            by_angle += place.at[j] * (c[1] + along * (2.0 * c[2] + along * 3.0 * c[3]));
        }
        return {value, by_angle, by_log_re};
    }

    template <class F> auto coefficients(const F& flow) const {
        const auto angle = radians(flow.alpha);
        const auto log_re = logarithm(flow.reynolds);
        Lanes lift[3], drag[3];
        for (int k = 0; k < width; ++k) {
            const double a = value(angle)[k];
            const int at = interval(a);
            const auto place = place_of(value(log_re)[k]);
            const auto l = look_up(0, at, a - table->knots[at], place), d = look_up(8, at, a - table->knots[at], place);
            for (int j = 0; j < 3; ++j) lift[j][k] = l[j], drag[j][k] = d[j];
        }
        const auto c_l = chain(angle, log_re, lift[0], lift[1], lift[2]), c_d = chain(angle, log_re, drag[0], drag[1], drag[2]);
        return Coefficients<decltype(c_l + 0.0), decltype(c_d + 0.0)>{c_l, c_d};
    }

    double stall_angle(double reynolds, double side) const {
        const auto& at = side > 0.0 ? table->stall_up : table->stall_down;
        const auto place = place_of(std::log(reynolds));
        return place.count == 1 ? at[place.row] : at[place.row] + place.fraction * (at[place.row + 1] - at[place.row]);
    }
    double stall_width() const { return table->stall_width; }
    double attached_slope() const { return table->attached_slope; }
};

// Corrections to the lift of a law.
struct LiftCorrections {
    double stall_delay = 0.0;     // factor of (c/y)^2 [-]; 0 for none
    double speed_of_sound = 0.0;  // [m/s]; 0 for incompressible flow
};

// A section law with corrections of its lift.
template <class Law> struct CorrectedLaw : Law, LiftCorrections {
    template <class F, class R, class C>
    auto corrected(const F& flow, const R& radius, const C& chord) const {
        auto c = Law::coefficients(flow);
        using Lift = decltype(c.lift + this->attached_slope() * radians(flow.alpha) * chord / radius *
                                           flow.speed * flow.lift_growth);
        Coefficients<Lift, decltype(c.drag)> r{c.lift - Lift{}, c.drag};
        if (stall_delay > 0.0) r.lift = delayed(r.lift, flow, radius, chord);
        if (speed_of_sound > 0.0) r.lift = r.lift * mach_factor(flow.speed * (1.0 / speed_of_sound));
        return r;
    }

    // Stall delay: Snel, Houwink, Bosschers, ECN-C--93-052, 1994.  Where the chord is large compared with the radius,
    // rotation restores a share min(k (c/y)^2, 1) of the lift lost in stall, with k = `stall_delay`.  The effect fades
    // out between angles of attack of 30 and 60 deg.
    template <class L, class F, class R, class C>
    auto delayed(const L& lift, const F& flow, const R& radius, const C& chord) const {
        const double from = pi / 6.0, span = pi / 6.0;
        const auto angle = radians(flow.alpha);
        const auto zero = 0.0 * angle;
        const auto past = minimum(maximum(absolute(angle) - from, zero), zero + span);
        const auto weight = 0.5 + 0.5 * sine_cosine(past * (pi / span)).cosine;
        const auto ratio = chord / radius;
        const auto wanted = stall_delay * ratio * ratio;
        const auto share = minimum(wanted, 0.0 * wanted + 1.0);
        return lift + share * weight * (this->attached_slope() * flow.lift_growth * angle - lift);
    }

    // Prandtl-Glauert factor 1/sqrt(1 - M^2) (Glauert, Proc. R. Soc. A 118, 1928).  Above M = 0.6, M^2 levels off
    // smoothly at 0.49, since shocks end the validity of the rule.
    template <class M> static auto mach_factor(const M& mach) {
        const double first = 0.36, last = 2.0 * 0.49 - first;
        const auto square = mach * mach;
        const auto inside = minimum(square, 0.0 * square + last);
        const auto past = maximum(inside - first, 0.0 * inside);
        return 1.0 / square_root(1.0 - (inside - past * past * (0.5 / (last - first))));
    }
};

}  // namespace propmap
