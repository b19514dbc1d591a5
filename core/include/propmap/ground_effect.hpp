// The ground below a rotor and the ceiling above it: factors on its thrust.
#pragma once

#include "velocities.hpp"

namespace propmap {

// Thrust at the distance d from a surface divided by thrust far from it: 1 + gain exp(-d/reach)/(1 + (V/v_i)^2), where V
// is the speed in the disk plane and v_i the mean inflow far from the surface.
// The constants were fitted to static thrust at equal rotational speed, at 0.33 R and more (tools/ground_effect.py).  The
// image model of Cheeseman & Bennett (ARC R&M 3021, 1955), 1/(1 - (R/4h)^2), predicts 1.7 at 0.39 R from the ground; the
// measured factor is 1.27.  The dependence on V near the ground is that of Cheeseman & Bennett, and is assumed at a
// ceiling.  Callers reject distances below 0.3 R.
template <class S>
S surface_effect(double gain, double reach, const S& distance, const Flow<S>& flow, const S& mean_inflow) {
    if (value(distance) > 40.0 * reach) return S{} + 1.0;  // the exponential is below rounding
    const S inflow = square(mean_inflow), away = square(flow.v_inplane) + speed_floor * speed_floor;
    const S near = power_of_two(S(-1.44269504088896340736 / reach * distance));
    return 1.0 + gain * near * (inflow / (inflow + away));
}

template <class S> S ground_effect(double tip, const Flow<S>& flow, const S& mean_inflow) {
    return surface_effect(0.424, 0.686 * tip, flow.height, flow, mean_inflow);
}

template <class S> S ceiling_effect(double tip, const Flow<S>& flow, const S& mean_inflow) {
    return surface_effect(0.148, 1.61 * tip, flow.ceiling, flow, mean_inflow);
}

}  // namespace propmap
