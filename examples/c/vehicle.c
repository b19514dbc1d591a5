/* Aerodynamic force and moment on a quadrotor in a gust from the left. */
#include "quad.h"
#include <stdio.h>

int main(void)
{
    const double omega[QUAD_ROTORS] = {600.0, 610.0, 610.0, 600.0}; /* rad/s */
    const double velocity[3] = {6.0, 0.0, 1.0}, rates[3] = {0.0, 0.1, 0.0}; /* m/s, rad/s */
    const double wind[3] = {0.0, -1.5, 0.0}; /* m/s, velocity of the air in the vehicle frame */
    const quad_wrench_t found = quad_wrench(omega, velocity, rates, wind);

    if (found.status != APC_8X6E_OK) {
        return 1;
    }
    printf("force %.3f %.3f %.3f N\n", found.force[0], found.force[1], found.force[2]);
    printf("moment %.4f %.4f %.4f N m\n", found.moment[0], found.moment[1], found.moment[2]);
    printf("power %.1f W\n", found.power);
    return 0;
}
