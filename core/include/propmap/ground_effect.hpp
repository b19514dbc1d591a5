// The ground below a rotor and the ceiling above it: factors on its thrust.
#pragma once

#include "velocities.hpp"

namespace propmap {

// Thrust at height h divided by thrust far from the ground: 1 + 0.31 exp(-(h/0.97 R)^2)/(1 + (V/v_i)^2), where V is the
// speed in the disk plane and v_i the mean inflow far from the ground.
// The constants were fitted to static thrust at equal rotational speed, at 0.33 R and more (tools/ground_effect.py).
// The image model of Cheeseman & Bennett (ARC R&M 3021, 1955), 1/(1 - (R/4h)^2), predicts 1.7 at 0.39 R; the measured
// factor is 1.27.  The dependence on V is that of Cheeseman & Bennett.  Callers reject heights below 0.3 R.
template <class S> S ground_effect(double tip, const Flow<S>& flow, const S& mean_inflow) {
    if (value(flow.height) > 8.0 * tip) return S{} + 1.0;  // the exponential underflows
    const S inflow = square(mean_inflow), away = square(flow.v_inplane) + speed_floor * speed_floor;
    const S near = power_of_two(-1.44269504088896340736 * square(S(flow.height / (0.97 * tip))));
    return 1.0 + 0.31 * near * (inflow / (inflow + away));
}

// Thrust at the distance c below a ceiling divided by thrust far from it: 1 + 0.185 exp(-c/1.39 R)/(1 + (V/v_i)^2), with
// constants from the same measurements.  The dependence on V is assumed to be that near the ground.
template <class S> S ceiling_effect(double tip, const Flow<S>& flow, const S& mean_inflow) {
    if (value(flow.ceiling) > 60.0 * tip) return S{} + 1.0;  // the exponential is below rounding
    const S inflow = square(mean_inflow), away = square(flow.v_inplane) + speed_floor * speed_floor;
    const S near = power_of_two(S(-1.44269504088896340736 / (1.39 * tip) * flow.ceiling));
    return 1.0 + 0.185 * near * (inflow / (inflow + away));
}

}  // namespace propmap
