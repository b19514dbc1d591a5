// Loads by brute force, for tools/dense_descents.py: strips of equal width, each with a scan of eq. (11).
//
// The equations are taken from the core (stations, forces of elements and wake, vortex ring, harmonics from loads).
// Searches, panels, forecasts and stopping rules of the core are not used.  Lanes are trial inflows at one radius.
#include <cstdint>

#include "propmap/laws.hpp"
#include "propmap/rotor.hpp"

using namespace propmap;

namespace {

using Blades = Rotor<double, GrowingLaw>;

// Fineness of the solution.
struct Look {
    std::int64_t strips;       // of equal width, along the blade; forces are computed at the middle
    double step;               // between trial inflows, as an inflow angle [rad]
    std::int64_t azimuths[3];  // over a full turn, at advance ratios below 0.25, below 0.5, and above

    int azimuths_at(double advance) const { return int(azimuths[advance < 0.25 ? 0 : advance < 0.5 ? 1 : 2]); }
};

// The largest |C_L| at any angle of attack.
double largest_lift(const GrowingLaw<double>& law) {
    const Lanes growth = maximum(law.lift_growth_at(broadcast(0.0)), law.lift_growth_at(broadcast(1e9)));
    double most = 0.0;
    for (int k = -2000; k <= 2000; ++k) {
        const auto angle = angle_from(broadcast(k * pi / 2000.0));
        const SectionFlow flow{angle, angle, broadcast(0.0), broadcast(1e5), broadcast(0.0), growth, growth};
        most = std::max(most, std::fabs(law.coefficients(flow).lift[0]));
    }
    return most;
}

struct Annulus {
    const Blades& rotor;
    const Flow<double>& flow;
    Azimuths psi;
    bool windmill;
    double radius;
    Station<Lanes> at;

    Annulus(const Blades& of, const Flow<double>& flow, const Azimuths& psi, bool windmill, double y)
        : rotor(of), flow(flow), psi(psi), windmill(windmill), radius(y), at(station_at(of, flow.omega, broadcast(y))) {}

    // Eq. (11): thrust of the blades minus momentum thrust.
    Lanes residual(Lanes inflow) const {
        return annulus_thrust(rotor, at, flow, inflow, psi) - wake_thrust(rotor, at.radius, flow, windmill, inflow);
    }

    // The largest root v_i [m/s]; NaN if none is found.
    //
    // Samples go down from large v_i, where the residual is negative, to the first one at which it is positive.  At a
    // maximum among negative samples the search is closer, since two roots may lie between two samples.
    double largest_root(double step, double lift) const {
        const double turning = flow.omega * radius, side = flow.v_inplane, down = flow.v_axial;
        const double speed = std::sqrt(turning * turning + 0.5 * side * side + 0.1 * down * down + 1e-18);
        // Upper limit of the root: with U_P = w > 0 drag adds no thrust, so (5) is at most N_b/2 c C_L ((Omega y + V)^2
        // + w^2).  In descent (10) is at least 4 pi y w^2.
        const double s = rotor.blade->blades * at.chord[0] * lift / (8.0 * pi * radius);
        double angle = 1.55;
        if (down <= 0.0 && s < 0.9)
            angle = std::min(std::atan(std::sqrt(s / (1.0 - s)) * (turning + side) / speed) + 2.0 * step, angle);
        const double lowest = -1.55;
        const auto inflow_at = [&](double a) { return speed * std::tan(a) - down; };
        double before[2] = {NAN, NAN}, v_before[2] = {NAN, NAN};  // the last two samples
        while (angle > lowest) {
            const Lanes v = each_lane([&](int k) { return inflow_at(std::max(angle - k * step, lowest)); });
            const Lanes g = residual(v);
            for (int k = 0; k < width; ++k) {
                if (before[1] < 0.0 && g[k] >= 0.0) return between(v[k], v_before[1]);
                if (before[0] < before[1] && before[1] < 0.0 && g[k] < before[1]) {
                    const double hidden = about_maximum(v[k], v_before[0]);
                    if (!std::isnan(hidden)) return hidden;
                }
                if (std::isnan(before[1]) && g[k] >= 0.0) return NAN;  // no upper limit: the blades' thrust is larger
                before[0] = before[1], v_before[0] = v_before[1];
                before[1] = g[k], v_before[1] = v[k];
            }
            angle -= width * step;
        }
        return NAN;
    }

    // A root at a maximum between `low` and `high` that is positive between the samples; NaN if there is none.
    double about_maximum(double low, double high) const {
        for (int round = 0; round < 3; ++round) {
            const double gap = (high - low) / (width + 1);
            const Lanes v = each_lane([&](int k) { return high - (k + 1) * gap; });
            const Lanes g = residual(v);
            int best = 0;
            for (int k = 0; k < width; ++k) {
                if (g[k] >= 0.0) return between(v[k], v[k] + gap);
                if (g[k] > g[best]) best = k;
            }
            const double middle = v[best];
            low = middle - gap, high = middle + gap;
        }
        return NAN;
    }

    // The root between `low`, where the residual is positive, and `high`, by division into width + 1 intervals.
    double between(double low, double high) const {
        const double close = 1e-8 * (flow.omega * radius + flow.v_inplane + std::fabs(flow.v_axial));
        for (int round = 0; round < 20 && high - low > close; ++round) {
            const double gap = (high - low) / (width + 1);
            const Lanes v = each_lane([&](int k) { return high - (k + 1) * gap; });
            const Lanes g = residual(v);
            int k = 0;
            while (k < width && g[k] < 0.0) ++k;
            const double top = high;
            if (k < width) low = top - (k + 1) * gap;
            high = top - k * gap;
        }
        return 0.5 * (low + high);
    }
};

// Loads per density of strips with known inflow.
struct Strips {
    const Blades& rotor;
    Flow<double> flow;
    Azimuths psi;
    double wide;
    std::vector<Station<Lanes>> at;
    std::vector<Lanes> inflow, weight;

    template <class PerRadius> Loads<double> total(PerRadius per_radius) const {
        Loads<double> loads{};
        for (std::size_t g = 0; g < at.size(); ++g) {
            const Loads<Lanes> part = per_radius(at[g], inflow[g]);
            for (int k = 0; k < Loads<double>::count; ++k) loads.begin()[k] += sum(weight[g] * part.begin()[k]);
        }
        return loads;
    }
    Loads<double> without_harmonics() const {
        return total([&](const auto& s, Lanes v) { return loads_of(rotor, s, turn_forces(rotor, s, flow, v, psi)); });
    }
    Loads<double> with(const Harmonics<double>& h) const {
        return total([&](const auto& s, Lanes v) { return loads_of(rotor, s, turn_forces(rotor, s, flow, v, psi, h)); });
    }
};

// Solve for harmonics and loads that depend on each other, by Newton's method with derivatives by differences.
Loads<double> with_harmonics(const Strips& strips, const HarmonicResponse<double>& response, double speed) {
    const double without = strips.without_harmonics().thrust;
    double x[3] = {}, slope[3][3];
    const auto missed = [&](const double (&h)[3], Loads<double>& loads, double (&f)[3]) {
        loads = strips.with({h[0], h[1], h[2]});
        const auto asked = response.harmonics({loads.thrust, loads.roll_moment, -loads.pitch_moment}, without);
        f[0] = asked.mean - h[0], f[1] = asked.lateral - h[1], f[2] = asked.longitudinal - h[2];
    };
    Loads<double> loads, unused;
    double f[3], aside[3];
    missed(x, loads, f);
    for (int step = 0; step < 60; ++step) {
        for (int j = 0; j < 3 && step % 4 == 0; ++j) {
            double moved[3] = {x[0], x[1], x[2]};
            const double by = 1e-5 * speed;
            moved[j] += by;
            missed(moved, unused, aside);
            for (int i = 0; i < 3; ++i) slope[i][j] = (aside[i] - f[i]) / by;
        }
        // Gauss-Jordan elimination, three by three.
        double m[3][4], size = 0.0;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 4; ++j) m[i][j] = j < 3 ? slope[i][j] : -f[i];
        for (int p = 0; p < 3; ++p) {
            int best = p;
            for (int i = p; i < 3; ++i)
                if (std::fabs(m[i][p]) > std::fabs(m[best][p])) best = i;
            std::swap(m[p], m[best]);
            for (int i = 0; i < 3; ++i) {
                const double by = m[i][p] / m[p][p];
                for (int j = 0; j < 4 && i != p; ++j) m[i][j] -= by * m[p][j];
            }
        }
        for (int i = 0; i < 3; ++i) size = std::max(size, std::fabs(m[i][3] / m[i][i]) / speed);
        const double share = std::min(1.0, 0.05 / std::max(size, 1e-30));
        for (int i = 0; i < 3; ++i) x[i] += share * m[i][3] / m[i][i];
        missed(x, loads, f);
        if (size < 1e-7) return loads;
    }
    return {NAN, NAN, NAN, NAN, NAN, NAN};
}

struct Solver {
    const Blades& rotor;
    Look look;
    double lift;

    Loads<double> loads(const Flow<double>& given) const {
        Flow<double> flow = given;
        if (flow.v_axial < 0.0)
            flow.v_hover = static_inflow(loads({flow.omega, 0.0, 0.0}).thrust / rotor.density, rotor.tip());
        const bool windmill = vortex_ring::windmill(flow), axial = flow.v_inplane == 0.0;
        const double ring = vortex_ring::weight(flow), ring_inflow = vortex_ring::inflow(flow);
        const Azimuths psi = azimuths(axial ? 1 : look.azimuths_at(flow.v_inplane / (flow.omega * rotor.tip())));
        const int count = int(look.strips);
        Strips strips{rotor, flow, psi, (rotor.tip() - rotor.root()) / count, {}, {}, {}};
        double area = 0.0, through = 0.0;
        for (int first = 0; first < count; first += width) {
            const Lanes y = each_lane([&](int k) { return rotor.root() + (std::min(first + k, count - 1) + 0.5) * strips.wide; });
            const Lanes weight = each_lane([&](int k) { return first + k < count ? strips.wide : 0.0; });
            Lanes v{};
            for (int k = 0; k < width && first + k < count && ring < 1.0; ++k)
                v[k] = Annulus(rotor, flow, psi, windmill, y[k]).largest_root(look.step, lift);
            for (int k = count - first; k < width && k > 0; ++k) v[k] = v[k - 1];
            v = (1.0 - ring) * v + ring * ring_inflow;
            strips.at.push_back(station_at(rotor, flow.omega, y));
            strips.inflow.push_back(v), strips.weight.push_back(weight);
            area += sum(weight * y), through += sum(weight * y * v);
        }
        const double mean = through / area;
        Loads<double> total;
        if (rotor.inflow_shape != InflowShape::uniform && !axial) {
            const DiskFlow<double> disk{flow.omega, flow.v_axial, flow.v_inplane, mean};
            auto response = harmonic_response(rotor.inflow_shape, disk, rotor.tip());
            for (double* part : {&response.mean_by_thrust, &response.lateral, &response.longitudinal, &response.by_thrust,
                                 &response.by_roll, &response.by_rear})
                *part *= 1.0 - ring;
            total = with_harmonics(strips, response, flow.omega * rotor.tip() + disk.speed());
        } else {
            total = strips.without_harmonics();
        }
        if (rotor.radial_friction && !axial) {
            const auto more = strips.total([&](const auto& s, Lanes v) { return radial_friction(rotor, s, flow, v, psi); });
            for (int k = 0; k < Loads<double>::count; ++k) total.begin()[k] += more.begin()[k];
        }
        complete_loads(rotor, flow, mean, total);
        return total;
    }
};

}  // namespace

// Six loads per point of a model, whose `numbers` are in the order of tools/dense_descents.py.  `points` are `count`
// rows of omega, v_axial and v_inplane.
extern "C" void dense_loads(const double* numbers, std::int64_t interval_count, const BladeShape::Interval* intervals,
                            const std::int64_t* look, double step, std::int64_t count, const double* points, double* loads) {
    const double* next = numbers;
    const auto number = [&] { return *next++; };
    BladeShape blade{{intervals, intervals + interval_count}, number(), number(), 0};
    blade.blades = int(number());
    Blades rotor;
    rotor.blade = &blade;
    rotor.density = number(), rotor.viscosity = number();
    rotor.inflow_shape = number() != 0.0 ? InflowShape::pitt_peters : InflowShape::uniform;
    rotor.radial_friction = number() != 0.0, rotor.installed = number() != 0.0;
    rotor.drag_factor = number(), rotor.mount_area = number(), rotor.mount_wake = number();
    rotor.law.attached = number(), rotor.law.plate = number();
    rotor.law.each_number([&](const char*, double& value) { value = number(); });
    rotor.law.complete();
    const Solver solver{rotor, {look[0], step, {look[1], look[2], look[3]}}, largest_lift(rotor.law)};
    for (std::int64_t k = 0; k < count; ++k) {
        const auto found = solver.loads({points[3 * k], points[3 * k + 1], points[3 * k + 2]});
        std::copy(found.begin(), found.begin() + Loads<double>::count, loads + Loads<double>::count * k);
    }
}
