/* Query a table in C: loads at a velocity, and the rotational speed for a thrust. */
#include "apc_8x6e.h"
#include <stdio.h>

int main(void)
{
    const double omega = 628.0; /* rad/s */
    const apc_8x6e_loads_t loads = apc_8x6e_loads_at_velocity(omega, 6.0, 0.0, 1.0);
    const apc_8x6e_inverse_t needed = apc_8x6e_omega_for(APC_8X6E_THRUST, 2.5, 8.0, 1.5);

    if (loads.status != APC_8X6E_OK) {
        return 1;
    }
    printf("thrust %.3f N, drag %.3f N, torque %.4f N m\n", loads.thrust, loads.drag, loads.torque);
    printf("2.5 N at 8 m/s: %.1f rad/s\n", needed.omega);
    return 0;
}
