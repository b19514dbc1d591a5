// Compute loads with propmap's core: reads one operating point per line of standard input, prints its loads.
#include "apc_8x6e.hpp"

#include <cstdio>

int main() {
    const auto solver = make_apc_8x6e();
    propmap::Solution solution;  // reuses its memory for all points; one per thread
    double omega, v_axial, v_inplane;
    while (std::scanf("%lf %lf %lf", &omega, &v_axial, &v_inplane) == 3) {
        solver.solve({omega, v_axial, v_inplane}, solution);
        const auto& result = solution.result;
        for (const double* load = result.loads.begin(); load != result.loads.begin() + result.loads.count; ++load)
            std::printf("%.17g ", *load);
        std::printf("%d\n", int(result.status));
    }
}
