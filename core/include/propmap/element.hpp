// Forces of a blade element, eqs. (1) to (7), and the loads of an annulus as their means over a turn.
#pragma once

#include "blade.hpp"

namespace propmap {

// Force per radius and density [m^3/s^2], along the thrust and against the rotation.
template <class T> struct Forces { T normal, tangential; };

// Velocity [m/s] of the air at a blade element, and the flow at its section.
template <class T, class P, class Section> struct ElementFlow {
    T u_t;
    P u_p;
    Section section;
};

// The flow at a blade element, at the azimuth with this sin(psi) and with the inflow v_i [m/s].
// The inflow angle is phi = atan2(U_P, U_T): sin(phi) = U_P/U, cos(phi) = U_T/U. This includes reverse flow, where the
// paper's arctan would give the force on the retreating root the wrong sign.
template <class St, class F, class V, class A>
auto element_flow(const St& at, const F& flow, const V& inflow, const A& sine_psi) {
    const auto u_t = flow.omega * at.radius + flow.v_inplane * sine_psi;  // Eq. (1)
    const auto u_p = flow.v_axial + inflow;                               // Eq. (2)
    const auto speed = square_root(speed_squared(value(u_t), value(u_p))), per_u = 1.0 / speed;
    const auto per_root = square_root(per_u);  // U^(-1/2)
    const auto sin_phi = value(u_p) * per_u, cos_phi = value(u_t) * per_u;
    // For derivatives: a change of velocity along the flow changes U, a change across the flow changes phi.
    const auto u = chain(u_t, u_p, speed, cos_phi, sin_phi);
    const auto turned = chain(u_t, u_p, 0.0 * per_u, -sin_phi * per_u, cos_phi * per_u);
    const Angle<std::remove_const_t<decltype(turned)>> phi{sin_phi, cos_phi, turned};
    const auto alpha = at.line - phi, drag_alpha = at.drag_line - phi;
    const auto reynolds = at.reynolds_per_speed * u;
    const auto root_re = at.inverse_root * chain(u, per_root, -0.5 * per_root * per_u);
    const SectionFlow section{alpha, drag_alpha, u, reynolds, root_re, at.lift_growth, at.drag_growth};
    return ElementFlow<std::remove_const_t<decltype(u_t)>, std::remove_const_t<decltype(u_p)>, std::remove_const_t<decltype(section)>>{u_t, u_p, section};
}

// Forces of a blade element in this flow.
template <class R, class St, class E> auto forces_in(const R& rotor, const St& at, const E& e) {
    const auto c = rotor.law.corrected(e.section, at.radius, at.chord);  // Eqs. (3)(4)
    // dL = 1/2 rho U^2 C_L c dy, dD = 1/2 rho U^2 C_D c dy
    const auto half = 0.5 * at.chord * e.section.speed;
    const auto normal = half * (c.lift * e.u_t - c.drag * e.u_p);      // dL cos(phi) - dD sin(phi)
    const auto tangential = half * (c.lift * e.u_p + c.drag * e.u_t);  // dL sin(phi) + dD cos(phi)
    return Forces<std::remove_const_t<decltype(normal)>>{normal, tangential};
}

// Forces of a blade element at the azimuth with this sin(psi).
template <class R, class St, class F, class V, class A>
auto element_forces(const R& rotor, const St& at, const F& flow, const V& inflow, const A& sine_psi) {
    return forces_in(rotor, at, element_flow(at, flow, inflow, sine_psi));
}

// Thrust of the blade elements per radius and density [m^3/s^2], eq. (5), with the same inflow at all azimuths.
// The flow at the next azimuth is computed before the forces at this azimuth.  The latency of the flow's
// square roots and divisions then overlaps with the computation of forces.  This saves up to a tenth of the time.
template <class R, class St, class F, class V>
[[gnu::flatten]] auto annulus_thrust(const R& rotor, const St& at, const F& flow, const V& inflow, const Azimuths& psi) {
    auto next = element_flow(at, flow, inflow, psi.sine[0]);
    decltype(forces_in(rotor, at, next).normal) total{};
    for (int k = 0; k < psi.count; ++k) {
        const auto here = next;
        if (k + 1 < psi.count) next = element_flow(at, flow, inflow, psi.sine[k + 1]);
        total += forces_in(rotor, at, here).normal;
    }
    return total * (rotor.blade->blades / double(psi.count));
}

// Variation of the inflow around the disk [m/s]: at azimuth psi it is v_i + mean + y/R (lateral sin(psi) + longitudinal
// cos(psi)), where v_i(y) is the annulus inflow of eq. (11).
template <class S> struct Harmonics { S mean{}, lateral{}, longitudinal{}; };

// Means over a turn of a force, and of its products with sin(psi) and cos(psi).
template <class T> struct Turn { T mean, sine, cosine; };
template <class T> struct TurnForces { Turn<T> normal, tangential; };

// Add the forces at the rear and at the front of the disk, given by their sum (even) and their difference (odd).
template <class T> void add(Turn<T>& sums, const T& even, const T& odd, double sine, double cosine) {
    sums.mean += even;
    sums.sine += even * sine;
    sums.cosine += odd * cosine;
}
template <class T> void scale(Turn<T>& sums, double by) {
    sums.mean = sums.mean * by, sums.sine = sums.sine * by, sums.cosine = sums.cosine * by;
}

// Forces averaged over a turn, where the inflow at psi and pi - psi is the same.
template <class R, class St, class F, class V>
[[gnu::flatten]] auto turn_forces(const R& rotor, const St& at, const F& flow, const V& inflow, const Azimuths& psi) {
    auto next = element_flow(at, flow, inflow, psi.sine[0]);
    TurnForces<decltype(forces_in(rotor, at, next).normal)> sums{};
    for (int k = 0; k < psi.count; ++k) {
        const auto here = next;
        if (k + 1 < psi.count) next = element_flow(at, flow, inflow, psi.sine[k + 1]);
        const auto f = forces_in(rotor, at, here);
        sums.normal.mean += f.normal, sums.normal.sine += f.normal * psi.sine[k];
        sums.tangential.mean += f.tangential, sums.tangential.sine += f.tangential * psi.sine[k];
    }
    scale(sums.normal, 1.0 / psi.count), scale(sums.tangential, 1.0 / psi.count);
    return sums;
}

// Forces averaged over a turn with harmonics of the inflow, which make the front and the rear of the disk differ.
template <class R, class St, class F, class V, class S>
[[gnu::flatten]] auto turn_forces(const R& rotor, const St& at, const F& flow, const V& inflow, const Azimuths& psi,
                 const Harmonics<S>& harmonics) {
    const auto share = at.radius * (1.0 / rotor.tip());
    const auto even = inflow + harmonics.mean;
    const auto lateral = share * harmonics.lateral, longitudinal = share * harmonics.longitudinal;
    const auto flow_at = [&](int k, double side) {
        return element_flow(at, flow, even + lateral * psi.sine[k] + longitudinal * (side * psi.cosine[k]), psi.sine[k]);
    };
    auto behind = flow_at(0, 1.0);
    using T = decltype(forces_in(rotor, at, behind).normal);
    TurnForces<T> sums{};
    for (int k = 0; k < psi.count; ++k) {
        const double sine = psi.sine[k], cosine = psi.cosine[k];
        const auto before = flow_at(k, -1.0);
        const auto rear = forces_in(rotor, at, behind);
        if (k + 1 < psi.count) behind = flow_at(k + 1, 1.0);
        const auto front = forces_in(rotor, at, before);
        add(sums.normal, T(rear.normal + front.normal), T(rear.normal - front.normal), sine, cosine);
        add(sums.tangential, T(rear.tangential + front.tangential), T(rear.tangential - front.tangential), sine, cosine);
    }
    const double per = 0.5 / psi.count;  // two halves, rear and front
    scale(sums.normal, per), scale(sums.tangential, per);
    return sums;
}

// Forces averaged over a turn with harmonics, and their derivatives with respect to added inflows of the shapes 1,
// sin(psi) and cos(psi).  The last two, times y/R, are the derivatives with respect to `lateral` and `longitudinal`.
struct TurnSlopes { TurnForces<Lanes> forces, by_mean, by_sine, by_cosine; };
template <class R, class St, class F>
[[gnu::flatten]] TurnSlopes turn_slopes(const R& rotor, const St& at, const F& flow, Lanes inflow, const Azimuths& psi,
                       const Harmonics<double>& harmonics) {
    const Lanes share = at.radius * (1.0 / rotor.tip());
    const Lanes even = inflow + harmonics.mean;
    const Lanes lateral = share * harmonics.lateral, longitudinal = share * harmonics.longitudinal;
    TurnSlopes sums{};
    Turn<Lanes> square_n{}, square_t{};  // derivatives times sin^2 and sin cos
    const auto flow_at = [&](int k, double side) {
        const Lanes v = even + lateral * psi.sine[k] + longitudinal * (side * psi.cosine[k]);
        return element_flow(at, flow, Dual<Lanes, 1>{v, {broadcast(1.0)}}, psi.sine[k]);
    };
    const bool symmetric = harmonics.longitudinal == 0.0;  // then the forces at the front are those at the rear
    auto behind = flow_at(0, 1.0), before = behind;
    for (int k = 0; k < psi.count; ++k) {
        const double sine = psi.sine[k], cosine = psi.cosine[k];
        if (!symmetric) before = flow_at(k, -1.0);
        const auto rear = forces_in(rotor, at, behind);
        if (k + 1 < psi.count) behind = flow_at(k + 1, 1.0);
        const auto front = symmetric ? rear : forces_in(rotor, at, before);
        const auto both = [&](const auto& r, const auto& f, Turn<Lanes>& force, Turn<Lanes>& slope, Turn<Lanes>& square) {
            add(force, Lanes(r.v + f.v), Lanes(r.v - f.v), sine, cosine);
            const Lanes even_slope = r.d[0] + f.d[0], odd_slope = r.d[0] - f.d[0];
            add(slope, even_slope, odd_slope, sine, cosine);
            square.sine += even_slope * (sine * sine);
            square.cosine += odd_slope * (sine * cosine);
        };
        both(rear.normal, front.normal, sums.forces.normal, sums.by_mean.normal, square_n);
        both(rear.tangential, front.tangential, sums.forces.tangential, sums.by_mean.tangential, square_t);
    }
    const double per = 0.5 / psi.count;  // two halves, rear and front
    const auto finish = [&](Turn<Lanes>& force, Turn<Lanes>& mean, Turn<Lanes>& sine, Turn<Lanes>& cosine,
                            Turn<Lanes>& square) {
        scale(force, per), scale(mean, per), scale(square, per);
        sine = {mean.sine, square.sine, square.cosine};
        cosine = {mean.cosine, square.cosine, mean.mean - square.sine};  // cos^2 = 1 - sin^2
    };
    finish(sums.forces.normal, sums.by_mean.normal, sums.by_sine.normal, sums.by_cosine.normal, square_n);
    finish(sums.forces.tangential, sums.by_mean.tangential, sums.by_sine.tangential, sums.by_cosine.tangential,
           square_t);
    return sums;
}

// Loads divided by density, unless a comment states units.  Multiplied by the density, loads of an annulus are in N/m
// and N, and loads of a rotor in N and N m.
template <class T> struct Loads {
    T thrust{}, drag{}, torque{};  // the other three loads are not in the paper
    T roll_moment{};   // about the in-plane velocity, positive where the advancing side is lifted
    T side_force{};    // in the disk plane across that velocity, positive toward the retreating side
    T pitch_moment{};  // about the axis across that velocity, positive where the front is lifted

    static constexpr int count = 6;
    T* begin() { return &thrust; }
    const T* begin() const { return &thrust; }
    // Add the loads per radius of annuli, with these weights [m].
    template <class P, class W> void add(const Loads<P>& per_radius, const W& weight) {
        for (int k = 0; k < count; ++k) begin()[k] += sum(weight * per_radius.begin()[k]);
    }
};

// Loads of annuli per radius and density, from the means over a turn.
template <class R, class St, class T> auto loads_of(const R& rotor, const St& at, const TurnForces<T>& turn) {
    const auto& [n, t] = turn;
    const double blades = rotor.blade->blades;
    const auto arm = blades * at.radius;
    const auto drag = blades * t.sine;
    using L = decltype(drag + arm * n.mean);
    return Loads<L>{blades * n.mean + L{},     // Eq. (5)
                    drag + L{},                // Eq. (6)
                    arm * t.mean + L{},        // Eq. (7)
                    arm * n.sine + L{}, blades * t.cosine + L{}, -(arm * n.cosine) + L{}};
}

// Change of the loads of an annulus due to skin friction along the blade, for a known inflow.
// In forward flight air also flows along the blade, with U_R = V sin(beta) cos(psi).  Lift and pressure drag do not
// change (independence principle: Jones, NACA TR 884, 1947).  Friction acts along the whole velocity W: the viscous
// drag 1/2 rho U C_v c (U_T, U_P) becomes 1/2 rho W C_v c (U_T, U_P, U_R).  C_v is the law's drag at zero lift, at the
// Reynolds number of U or W, respectively.  The axial part, less than a thousandth of the thrust, is omitted.
template <class R, class St, class F, class V>
[[gnu::flatten]] auto radial_friction(const R& rotor, const St& at, const F& flow, const V& inflow, const Azimuths& psi) {
    const auto viscous = [&](const auto& square) {
        const auto speed = square_root(square);
        const auto reynolds = at.reynolds_per_speed * speed;
        const auto root_re = at.inverse_root / square_root(speed);
        const std::remove_const_t<decltype(speed)> none{};
        const Angle<std::remove_const_t<decltype(none)>> zero{value(none), value(none) + 1.0, none};
        const SectionFlow section{zero, zero, speed, reynolds, root_re, at.lift_growth, at.drag_growth};
        return speed * rotor.law.coefficients(section).drag;
    };
    const auto term = [&](int k, auto& turning, auto& along) {
        const double sine = psi.sine[k], square_cosine = 1.0 - sine * sine;
        const auto u_t = flow.omega * at.radius + flow.v_inplane * sine;
        const auto square = speed_squared(u_t, flow.v_axial + inflow);
        const auto friction = viscous(square + flow.v_inplane * flow.v_inplane * square_cosine);
        turning = (friction - viscous(square)) * u_t;
        along = turning * sine + friction * (flow.v_inplane * square_cosine);
    };
    using T = decltype(element_forces(rotor, at, flow, inflow, 0.0).normal);
    T turning{}, along{}, more_turning{}, more_along{};
    for (int k = 0; k < psi.count; ++k) {
        term(k, turning, along);
        more_turning += turning, more_along += along;
    }
    TurnForces<T> sums{};
    const auto half = at.chord * (0.5 / psi.count);
    sums.tangential.mean = half * more_turning, sums.tangential.sine = half * more_along;
    return loads_of(rotor, at, sums);
}

}  // namespace propmap
