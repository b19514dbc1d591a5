// Inflow that varies around the disk: first harmonics, added to the annulus inflow of eq. (11).
//
// The paper averages each annulus over azimuth: a rolling moment then induces no inflow, and the computed moment is a
// quarter too large.  The harmonics depend linearly on the thrust and the moments of the whole disk.
#pragma once

#include "wake.hpp"

namespace propmap {

// Mean flow through the disk.
template <class S> struct DiskFlow {
    S omega, v_axial, v_inplane;
    S inflow;  // v_i averaged over the area of the disk [m/s]

    // Glauert's resultant speed W of the air at the disk [m/s].
    S speed() const { return square_root(speed_squared(v_inplane, v_axial + inflow)); }

    // The smaller of v_i and the upward flow -V cos(beta) of a descent [m/s], at least 0.  If both are equal, no air passes
    // the disk.  `along` then assumes that the wake leaves along the axis at this speed.
    S recirculation() const {
        const S none = 0.0 * inflow;
        return maximum(minimum(S(-v_axial), inflow), none);
    }

    // Mass-flow parameter of Peters and HaQuang [m/s], d(v_i W)/dv_i: 2 v_i in hover, W in fast flight.  It has a lower
    // limit: it would vanish where a braking rotor reverses the flow, and momentum theory does not hold there.
    S mass_flow() const {
        const S w = speed(), through = v_axial + inflow;
        const S least = maximum(S(0.5 * w), recirculation());
        return maximum(S(w + inflow * through / w), least);
    }

    // Speed along the axis that carries the wake away [m/s].  A wake above the disk is treated like one below.
    S along() const { return maximum(absolute(S(v_axial + inflow)), recirculation()); }
    S skew_cosine() const { return along() / square_root(speed_squared(v_inplane, along())); }  // cos(chi)
    // tan(chi/2) of the wake's skew chi: 0 in axial flow, 1 edgewise.
    S half_skew_tangent() const { return v_inplane / (square_root(speed_squared(v_inplane, along())) + along()); }
};

// Loads per density that drive the harmonics: thrust, rolling moment, and the moment that lifts the rear.
template <class S> struct DiskMoments { S thrust{}, roll{}, rear{}; };

// The harmonics (v_0 mean, v_s lateral, v_c longitudinal) as a linear function of the loads per density.
template <class S> struct HarmonicResponse {
    S mean_by_thrust;                          // v_0 per change of thrust, 1/(2 pi R^2 V_m) [s/m^3], V_m: mass_flow()
    S lateral, longitudinal;                   // v_s and v_c without loads [m/s]
    S by_thrust, by_roll, by_rear;             // v_c per thrust, v_s per roll, v_c per moment that lifts the rear

    Harmonics<S> harmonics(const DiskMoments<S>& m, const S& thrust_without) const {
        return {mean_by_thrust * (m.thrust - thrust_without), lateral + by_roll * m.roll,
                longitudinal + by_thrust * m.thrust + by_rear * m.rear};
    }
    HarmonicResponse faded(const S& share) const {  // multiplied by `share`: harmonics fade out within the vortex ring
        return {mean_by_thrust * share, lateral * share, longitudinal * share, by_thrust * share, by_roll * share, by_rear * share};
    }
};

// The response of this shape, for a disk of radius `tip` [m].
template <class S> HarmonicResponse<S> harmonic_response(InflowShape shape, const DiskFlow<S>& flow, double tip) {
    const S none = 0.0 * flow.inflow;
    const S per_load = 1.0 / ((pi * tip * tip) * flow.mass_flow());
    HarmonicResponse<S> r{0.5 * per_load, none, none, none, none, none};
    switch (shape) {
        case InflowShape::uniform: break;
        case InflowShape::pitt_peters: {
            // Pitt & Peters, Vertica 5(1), 1981; Peters & HaQuang, J. AHS 33(4), 1988.  For loads divided by
            // rho A (Omega R)^2 (moments also by R), and velocities by Omega R: lambda_s = 4/(1 + cos chi) C_roll/V_m,
            // lambda_c = 15 pi/64 tan(chi/2) C_T/V_m + 4 cos chi/(1 + cos chi) C_rear/V_m.
            const S cosine = flow.skew_cosine();
            r.by_roll = 4.0 * per_load / (tip * (1.0 + cosine));
            r.by_rear = cosine * r.by_roll;
            r.by_thrust = (15.0 * pi / 64.0) * flow.half_skew_tangent() * per_load;
            break;
        }
        case InflowShape::pitt_peters_gradient:  // the gradient due to thrust, without the moments
            r.longitudinal = (15.0 * pi / 32.0) * flow.half_skew_tangent() * flow.inflow;
            break;
        case InflowShape::coleman:  // Coleman, Feingold, Stempin, NACA ARR L5E10, 1945
            r.longitudinal = flow.half_skew_tangent() * flow.inflow;
            break;
        case InflowShape::white_blake:  // White & Blake, 35th Annual Forum of the AHS, 1979
            r.longitudinal = 1.41421356237309505 * flow.v_inplane / flow.speed() * flow.inflow;
            break;
        case InflowShape::drees: {
            // Drees, J. Helicopter Association of Great Britain 3(2), 1949.  Divided by the mean inflow,
            // v_c = 4/3 (1 - cos chi - 1.8 mu^2)/sin chi and v_s = -2 mu, with mu = V sin(beta)/(Omega R), at most 0.5.
            const S slow = maximum(S(flow.omega * tip), S(2.0 * flow.v_inplane)) + speed_floor;
            const S square = flow.v_inplane * flow.speed() / (slow * slow);  // mu^2 / sin chi
            r.longitudinal = (4.0 / 3.0) * (flow.half_skew_tangent() - 1.8 * square) * flow.inflow;
            r.lateral = -2.0 * flow.v_inplane / slow * flow.inflow;
            break;
        }
    }
    return r;
}

// Newton step of the harmonics toward harmonics = response(loads), by Cramer's rule.  `wanted` is the right-hand side
// minus the left-hand side, `by` the derivatives of the loads with respect to the harmonics.
template <class S>
Harmonics<S> harmonics_step(const HarmonicResponse<double>& r, const Loads<double> (&by)[3], const S (&wanted)[3]) {
    double m[3][3];
    for (int k = 0; k < 3; ++k) {
        m[0][k] = (k == 0) - r.mean_by_thrust * by[k].thrust;
        m[1][k] = (k == 1) - r.by_roll * by[k].roll_moment;
        m[2][k] = (k == 2) - r.by_thrust * by[k].thrust + r.by_rear * by[k].pitch_moment;
    }
    const auto minor = [&](int i, int j) {
        const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
        return m[a][c] * m[b][d] - m[a][d] * m[b][c];
    };
    double determinant = 0.0;
    for (int j = 0; j < 3; ++j) determinant += m[0][j] * minor(0, j);
    const double per = 1.0 / (determinant == 0.0 ? 1e-30 : determinant);
    const auto solved = [&](int j) {
        return S(per * (minor(0, j) * wanted[0] + minor(1, j) * wanted[1] + minor(2, j) * wanted[2]));
    };
    return {solved(0), solved(1), solved(2)};
}

}  // namespace propmap
