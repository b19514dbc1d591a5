// The ground below a rotor: a factor on its thrust.
#pragma once

#include "velocities.hpp"

namespace propmap {

// Thrust at height h divided by thrust far from the ground: 1 + 0.31 exp(-(h/0.97 R)^2)/(1 + (V/v_i)^2), where V is the
// speed in the disk plane and v_i the mean inflow far from the ground.
// The constants fit static thrust at equal rotational speed from 0.33 R up (tools/ground_effect.py).  The image of the
// rotor in the ground, 1/(1 - (R/4h)^2) of Cheeseman & Bennett, ARC R&M 3021, 1955, gives 1.7 at 0.39 R, where 1.27 was
// measured.  The dependence on V is theirs.  Heights below 0.3 R were not measured; callers reject them.
template <class S> S ground_effect(double tip, const Flow<S>& flow, const S& mean_inflow) {
    if (value(flow.height) > 8.0 * tip) return S{} + 1.0;  // the exponential underflows
    const S inflow = square(mean_inflow), away = square(flow.v_inplane) + speed_floor * speed_floor;
    const S near = power_of_two(-1.44269504088896340736 * square(S(flow.height / (0.97 * tip))));
    return 1.0 + 0.31 * near * (inflow / (inflow + away));
}

}  // namespace propmap
