/* Inflow as a state: thrust at every millisecond after a step of the rotational speed. */
#include "apc_8x6e.h"
#include <stdio.h>

int main(void)
{
    const double velocity[3] = {3.0, 0.0, 0.5}; /* m/s, z along the thrust */
    const double before = 520.0, after = 620.0; /* rad/s */
    const double x = velocity[0], y = velocity[1], z = velocity[2], dt = 1e-3;
    double inflow = apc_8x6e_inflow(before, x, y, z).steady;
    const apc_8x6e_inflow_t there = apc_8x6e_inflow(after, x, y, z);
    int k;

    if (there.status != APC_8X6E_OK) {
        return 1;
    }
    printf("time constant %.2f ms\n", 1e3 * there.time_constant);
    for (k = 0; k <= 15; ++k) {
        const apc_8x6e_wrench_t hub =
            apc_8x6e_wrench_in_inflow(inflow, after, x, y, z, APC_8X6E_CCW);
        printf("%2d ms: inflow %.3f m/s, thrust %.4f N\n", k, inflow, hub.force[2]);
        inflow = apc_8x6e_inflow_step(inflow, dt, after, x, y, z);
    }
    printf("steady: inflow %.3f m/s, thrust %.4f N\n", there.steady,
           apc_8x6e_wrench(after, x, y, z, APC_8X6E_CCW).force[2]);
    return 0;
}
