// Monotone piecewise cubics (PCHIP), which interpolate blades and section tables.
#pragma once

#include <cmath>
#include <vector>

namespace propmap {

// Slopes at the knots of the monotone piecewise cubic through (x, y), with the end rule of SciPy.
// Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984, doi 10.1137/0905021.
inline std::vector<double> pchip_slopes(const std::vector<double>& x, const std::vector<double>& y) {
    const std::size_t n = x.size();
    std::vector<double> slope(n), h(n - 1), d(n - 1);
    for (std::size_t k = 0; k + 1 < n; ++k) h[k] = x[k + 1] - x[k], d[k] = (y[k + 1] - y[k]) / h[k];
    for (std::size_t k = 1; k + 1 < n; ++k) {
        const double w1 = 2.0 * h[k] + h[k - 1], w2 = h[k] + 2.0 * h[k - 1];
        slope[k] = d[k - 1] * d[k] > 0.0 ? (w1 + w2) / (w1 / d[k - 1] + w2 / d[k]) : 0.0;
    }
    const auto end = [](double h0, double h1, double d0, double d1) {
        double s = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
        if (s * d0 <= 0.0) return 0.0;
        return d0 * d1 < 0.0 && std::fabs(s) > 3.0 * std::fabs(d0) ? 3.0 * d0 : s;
    };
    slope[0] = end(h[0], h[1], d[0], d[1]);
    slope[n - 1] = end(h[n - 2], h[n - 3], d[n - 2], d[n - 3]);
    return slope;
}

}  // namespace propmap
