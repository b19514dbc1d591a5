// The ground below a rotor: a factor on its thrust.
#pragma once

#include "velocities.hpp"

namespace propmap {

// Thrust at height h divided by thrust far from the ground: 1/(1 - (R/4h)^2/(1 + (V/v_i)^2)), where V is the speed in
// the disk plane and v_i the mean inflow far from the ground.
// Cheeseman & Bennett, ARC R&M 3021, 1955, state the formula for equal power.  For fixed pitch it is used at equal
// rotational speed, as in measurements of multirotors (Sanchez-Cuevas, Heredia, Ollero, Int. J. Aerospace Engineering
// 1823056, 2017).  Heights below half a radius were not measured; callers reject them.
template <class S> S ground_effect(double tip, const Flow<S>& flow, const S& mean_inflow) {
    const S image = square(S(0.25 * tip / flow.height));
    const S inflow = square(mean_inflow), away = square(flow.v_inplane) + speed_floor * speed_floor;
    return 1.0 / (1.0 - image * (inflow / (inflow + away)));
}

}  // namespace propmap
