// Loads of a rotor by propmap's core alone: an operating point per line of the standard input, its loads per line.
#include "apc_8x6e.hpp"

#include <cstdio>

int main() {
    const auto solver = make_apc_8x6e();
    propmap::Solution solution;  // keeps its memory from point to point; one per thread
    double omega, v_axial, v_inplane;
    while (std::scanf("%lf %lf %lf", &omega, &v_axial, &v_inplane) == 3) {
        solver.solve({omega, v_axial, v_inplane}, solution);
        const auto& result = solution.result;
        for (const double* load = result.loads.begin(); load != result.loads.begin() + result.loads.count; ++load)
            std::printf("%.17g ", *load);
        std::printf("%d\n", int(result.status));
    }
}
