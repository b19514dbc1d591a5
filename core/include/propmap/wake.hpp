// Momentum theory: thrust of an annulus, eqs. (8) to (10), its windmill branch, and the vortex ring.
//
// The paper negates the right-hand side of (8) when the wake is above the disk, which is correct for a mass flow with a
// sign.  The mass flow of (10) has none, and the velocity of the air changes by 2 v_i against the thrust in either
// direction of the flow.  So nothing is negated here.
#pragma once

#include <atomic>

#include "element.hpp"

namespace propmap {

// Thrust of an annulus per radius and density [m^3/s^2], with Glauert's mass flow.
template <class Y, class F, class V> auto momentum_thrust(const Y& radius, const F& flow, const V& inflow) {
    const auto w = square_root(speed_squared(flow.v_inplane, flow.v_axial + inflow));
    return (4.0 * pi) * radius * inflow * w;  // Eq. (10)
}

// The two v_i [m/s] between which (10) falls; equal if it does not fall.  In descent within 19.5 deg of the axis, (10) rises
// up to the first turning point.  In axial flow, the far wake stands still there.  Momentum theory holds up to this point.
template <class S> struct TurningPoints { S first, second; };
template <class S> TurningPoints<S> turning_points(const S& v_axial, const S& v_inplane) {
    const S square = v_axial * v_axial - 8.0 * (v_inplane * v_inplane);
    const S none = 0.0 * square;
    const S root = value(square) > 0.0 ? S(square_root(square)) : none;
    return {0.25 * (v_axial - root) - v_axial, 0.25 * (v_axial + root) - v_axial};
}

// Eq. (10) made to rise with v_i everywhere, for the windmill branch.
// Up to the first turning point it is (10) unchanged.  Beyond, the falling part is mirrored upwards.  In axial flow the
// mirrored curve is a parabola: the value at the turning point plus 4 pi y (v_i - first)^2.  Like Buhl's empirical curve
// (NREL/TP-500-36834, 2005), it reaches C_T = 2 at v_i = |V cos(beta)|.  In oblique flow the mirrored curve is averaged
// with the parabola, whose weight falls from 1 in axial flow to 0 at 19.5 deg.  Without the parabola the curve would be
// flat at the second turning point, which would give (11) more roots.
template <class Y, class F, class V> auto windmill_thrust(const Y& radius, const F& flow, const V& inflow) {
    const auto [first, second] = turning_points(flow.v_axial, flow.v_inplane);
    const auto here = momentum_thrust(radius, flow, inflow);
    const auto at_first = momentum_thrust(radius, flow, first), at_second = momentum_thrust(radius, flow, second);
    const auto mirrored =
        select(value(inflow) <= value(second), 2.0 * at_first - here, here + 2.0 * (at_first - at_second));
    const auto past = inflow - first;
    const auto parabola = at_first + (4.0 * pi) * radius * past * past;
    const auto gap = second - first;
    const auto down = flow.v_axial * flow.v_axial + speed_floor * speed_floor;
    const auto axial = 4.0 * (gap * gap) / down;
    return select(value(inflow) <= value(first), here, axial * parabola + (1.0 - axial) * mirrored);
}

// Prandtl's factor on the momentum thrust for N_b blades, F = 2/pi arccos(exp(-f)), f = N_b (R - y)/(2 y sin(phi)) at
// the tip and N_b (y - r)/(2 r sin(phi)) at a hub of radius r.  With one inflow per annulus, tan(phi) =
// |U_P|/(Omega y).  Prandtl in Betz, Nachrichten Goettingen 1919; Glauert in Durand, Aerodynamic Theory IV, 1935.
template <class Y, class F, class V>
auto prandtl_factor(double blades, double inner, double outer, const Y& radius, const F& flow, const V& inflow) {
    // Clamp f sin(phi) to at least 5e-5.  Otherwise F goes to zero over the last 0.005 % of the blade.
    const auto y = radius + 0.0 * flow.omega;
    const auto apart = inner > 0.0 ? decltype(y - 1.0)(y * (1.0 / inner) - 1.0) : decltype(y - 1.0)(outer / y - 1.0);
    const auto reach = maximum(0.5 * blades * apart, 0.0 * apart + 5e-5);
    const auto u = flow.v_axial + inflow;
    const auto turning = flow.omega * radius;
    const auto w = square_root(speed_squared(u, turning));
    const auto size = absolute(u);
    const auto f = reach * w / maximum(size, 0.0 * size + 1e-9);
    const double most = 69.31471805599453;  // beyond it exp(-f) < 2^-100 is negligible
    const auto decay = power_of_two(minimum(f, 0.0 * f + most) * -1.44269504088896340736);
    return (2.0 / pi) * angle_of(decay, square_root((1.0 - decay) * (1.0 + decay)));
}

// Momentum thrust of annuli per radius and density [m^3/s^2]: eq. (10) with the corrections of the rotor.
template <class R, class Y, class F, class V>
[[gnu::flatten]] auto wake_thrust(const R& rotor, const Y& radius, const F& flow, bool windmill, const V& inflow) {
    auto thrust = momentum_thrust(radius, flow, inflow) + 0.0 * (flow.omega * inflow);
    if (windmill) thrust = windmill_thrust(radius, flow, inflow) + 0.0 * thrust;
    const double blades = rotor.blade->blades;
    if (rotor.tip_loss) thrust = thrust * prandtl_factor(blades, 0.0, rotor.tip(), radius, flow, inflow);
    if (rotor.hub_radius > 0.0) thrust = thrust * prandtl_factor(blades, rotor.hub_radius, 0.0, radius, flow, inflow);
    return thrust;
}

// Static inflow v_i0 [m/s] from the static thrust per density; zero if the thrust is not positive.
template <class S> S static_inflow(const S& thrust, double tip) {
    const S square = thrust * (1.0 / (2.0 * pi * tip * tip));
    return value(square) > 0.0 ? S(square_root(square)) : 0.0 * square;  // Eq. (12)
}

// The static inflow (12) of a rotor, interpolated: v_i0/Omega by a cubic in log2(Omega), from its values at fixed tip
// speeds, 32 per octave.  Each value is computed on first use.  (At 16 per octave, one of 100 random rotors erred by 8e-5.)
class StaticInflow {
  public:
    // v_i0 [m/s] at `omega`; `exact` is the function that is interpolated.
    template <class Exact> double at(double omega, double tip, Exact exact) const {
        const double place = per_octave * std::log2(std::clamp(omega * tip / slowest, 1.0, fastest / slowest));
        const int first = int(place);
        const double t = place - first;
        const double weight[] = {-t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
                                 -(t + 1.0) * t * (t - 2.0) / 2.0, (t + 1.0) * t * (t - 1.0) / 6.0};
        double ratio = 0.0;
        for (int k = 0; k < 4; ++k) {
            std::atomic<double>& known = ratios_[first + k];  // threads may compute it twice, with the same bits
            const double there = slowest / tip * std::exp2((first + k - 1.0) / per_octave);
            if (known == 0.0) known = exact(there) / there;
            ratio += weight[k] * known;
        }
        return std::max(ratio, 0.0) * omega;
    }

  private:
    static constexpr double slowest = 1e-3, fastest = 5e5;  // tip speeds [m/s]
    static constexpr int per_octave = 32, octaves = 29;
    // v_i0/Omega [m]; zero if it is not yet known.
    std::unique_ptr<std::atomic<double>[]> ratios_ = std::make_unique<std::atomic<double>[]>(per_octave * octaves + 4);
};

// The vortex ring: the region of descent in which a measured inflow, based on (12), replaces momentum theory.
// The paper uses (12) wherever V cos(beta) < 0 < V cos(beta) + v_i.  Loads would then jump at beta = 90 deg: in fast
// flight with a trace of descent, the in-plane flow carries the wake away and (10) holds.  So (12) is used in the
// region of Johnson, NASA/TP-2005-213477, table 4 (points D, N, X, E, M), in units of the static inflow v_h, with
// blended edges.  There, (12) is multiplied by Leishman's fit to the inflow measured in vertical descent, which is 1 in
// hover (Principles of Helicopter Aerodynamics, 2nd ed., section 2.13).  With (12) alone, thrust is a third too high.
namespace vortex_ring {

inline constexpr double onset = -0.2, full_from = -0.45, full_to = -1.5, gone = -2.0;  // V cos(beta)/v_h
inline constexpr double fade_from = 0.5, nose = 0.95;  // V sin(beta)/v_h
// At this V cos(beta)/v_h the windmill branch replaces (10).  Loads do not jump: up to `fade_from`, only the vortex-ring
// inflow is used here; above it, both thrusts are equal, because the angle to the axis exceeds 19.5 deg.
inline constexpr double windmill_below = -0.95;

template <class S> S rise(const S& t) {  // a smooth step from t = 0 to t = 1
    if (!(value(t) > 0.0)) return 0.0 * t;
    if (value(t) >= 1.0) return 0.0 * t + 1.0;
    return t * t * t * (10.0 + t * (6.0 * t - 15.0));
}

// Weight of the vortex-ring inflow in the inflow used [-], from 0 to 1.
template <class S> S weight(const Flow<S>& flow) {
    if (value(flow.v_axial) >= 0.0) return 0.0 * flow.v_axial;
    const S v_h = maximum(flow.v_hover, 0.0 * flow.v_hover + 1e-9);
    const S z = flow.v_axial / v_h, x = flow.v_inplane / v_h;
    const S entered = rise(S((onset - z) * (1.0 / (onset - full_from))));
    const S not_left = rise(S((z - gone) * (1.0 / (full_to - gone))));
    const S not_swept = 1.0 - rise(S((x - fade_from) * (1.0 / (nose - fade_from))));
    return entered * not_left * not_swept;
}

template <class S> S inflow(const Flow<S>& flow) {  // of the vortex ring [m/s]
    S z = flow.v_axial / maximum(flow.v_hover, 0.0 * flow.v_hover + 1e-9);
    if (value(z) < gone) z = 0.0 * z + gone;
    if (value(z) > 0.0) z = 0.0 * z;
    return flow.v_hover * (1.0 + z * (-1.125 + z * (-1.372 + z * (-1.718 + z * -0.655))));
}

template <class S> bool windmill(const Flow<S>& flow) {  // whether (11) has the windmill branch
    return value(flow.v_axial) < minimum(windmill_below * value(flow.v_hover), 0.0);
}

}  // namespace vortex_ring

// In-plane part of the drag of the mount in the slipstream [N per density]: 1/2 f V_in sqrt(V_in^2 + (V_ax + k v_i)^2),
// with `mount_area` f and `mount_wake` k.  The slipstream increases it.
template <class R, class S> S mount_drag(const R& rotor, const Flow<S>& flow, const S& mean_inflow) {
    const S through = flow.v_axial + rotor.mount_wake * mean_inflow;
    return 0.5 * rotor.mount_area * flow.v_inplane * square_root(speed_squared(flow.v_inplane, through));
}

}  // namespace propmap
