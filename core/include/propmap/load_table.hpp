// Loads from a table over the advance ratio J = V/(Omega R) and the angle beta of the velocity: C1 cubics between
// knots.  Loads over Omega^2 are linear in Omega^(-1/2), like the friction term of eq. (4), within the limits of Omega.
#pragma once

#include <array>

#include "element.hpp"

namespace propmap {

// In order of severity: if several apply, the last one is returned.
enum class TableStatus : unsigned char { ok, vortex_ring, unresolved, clamped, no_value, outside };

// One axis with n knots.  In each interval, the value is a weighted sum of the values at four knots: both ends, and the
// next knot on either side.  The weights are polynomials of the fraction of the interval.
struct TableAxis {
    std::vector<double> knots, polynomials;  // (n), (n - 1, 4, 4)

    struct Place {
        std::size_t interval;
        double at[4], slope[4];  // weights of the value and of its derivative
    };
    Place place_of(double x) const {
        Place p;
        p.interval = std::size_t(std::upper_bound(knots.begin() + 1, knots.end() - 1, x) - knots.begin()) - 1;
        const double width = knots[p.interval + 1] - knots[p.interval], t = (x - knots[p.interval]) / width;
        const double* c = &polynomials[16 * p.interval];
        for (int k = 0; k < 4; ++k, c += 4) {
            p.at[k] = c[0] + t * (c[1] + t * (c[2] + t * c[3]));
            p.slope[k] = (c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])) / width;
        }
        return p;
    }
};

struct LoadTable {
    static constexpr int count = Loads<double>::count;
    using Row = std::array<double, 2 * count>;  // loads over Omega^2, then slopes in Omega^(-1/2)

    struct Query {
        double omega, speed, beta;  // inside the envelope; omega is NaN for a point outside
        TableStatus status;         // ok, clamped or outside
    };
    struct Found {
        Loads<double> loads;
        double omega;  // at which the loads were looked up [rad/s]
        TableStatus status;
    };

    TableAxis advance, beta;
    std::vector<Row> values;         // at the lowest omega, (n + 2, m + 2), with ghost values on each side
    std::vector<TableStatus> cells;  // status between knots, (n - 1, m - 1)
    std::array<double, 3> low, high;  // limits of omega [rad/s], speed [m/s], beta [rad]
    double radius;                    // [m]

    static constexpr double slack = 1e-9;  // fraction of an axis by which rounding may move points outside

    // Bring a point into the envelope.  Replace beta outside 0 to pi by its mirror image inside, where loads are
    // the same.  Move variables to their limits if they are within `slack` of them, or if `clamp` is true.
    Query bounded(double omega, double speed, double angle, bool clamp) const {
        if (!(angle >= 0.0 && angle <= pi)) angle = std::fabs(std::remainder(angle, 2.0 * pi));
        const std::array<double, 3> given{omega, speed, angle};
        std::array<double, 3> held;
        bool within = true, known = true;
        for (int k = 0; k < 3; ++k) {
            held[k] = std::min(std::max(given[k], low[k]), high[k]);
            within = within && std::fabs(given[k] - held[k]) <= slack * (high[k] - low[k]);
            known = known && !std::isnan(given[k]);
        }
        if (within) return {held[0], held[1], held[2], TableStatus::ok};
        if (clamp && known) return {held[0], held[1], held[2], TableStatus::clamped};
        return {NAN, low[1], low[2], TableStatus::outside};
    }

    Found loads(double omega, double speed, double angle, bool clamp) const {  // NaN outside the envelope
        const Query at = bounded(omega, speed, angle, clamp);
        Found f{{}, at.omega, at.status};
        std::fill_n(f.loads.begin(), count, NAN);
        if (at.status == TableStatus::outside) return f;
        const double turning = std::fabs(at.omega);  // backward rotation has omega < 0
        const auto i = advance.place_of(at.speed / (turning * radius)), j = beta.place_of(at.beta);
        const Row row = sum(i.interval, j.interval, i.at, j.at);
        const double square = turning * turning, root = 1.0 / std::sqrt(turning) - 1.0 / std::sqrt(std::fabs(low[0]));
        for (int k = 0; k < count; ++k) f.loads.begin()[k] = square * (row[k] + root * row[count + k]);
        if (std::isnan(f.loads.thrust)) f.status = TableStatus::no_value;
        else if (at.status == TableStatus::ok) f.status = cells[i.interval * (beta.knots.size() - 1) + j.interval];
        return f;
    }

    // Values at J and beta, and their derivatives with respect to beta, J, and both.
    std::array<Row, 4> slopes(double at_advance, double angle) const {
        const auto i = advance.place_of(at_advance), j = beta.place_of(angle);
        const auto of = [&](const double* a, const double* b) { return sum(i.interval, j.interval, a, b); };
        return {of(i.at, j.at), of(i.at, j.slope), of(i.slope, j.at), of(i.slope, j.slope)};
    }

  private:
    Row sum(std::size_t i, std::size_t j, const double* across, const double* along) const {  // over 4 by 4 values
        Row total{};
        for (std::size_t a = 0; a < 4; ++a) {
            const Row* row = &values[(i + a) * (beta.knots.size() + 2) + j];
            for (std::size_t b = 0; b < 4; ++b) {
                const double weight = across[a] * along[b];
                for (std::size_t k = 0; k < total.size(); ++k) total[k] += weight * row[b][k];
            }
        }
        return total;
    }
};

}  // namespace propmap
