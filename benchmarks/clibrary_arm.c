/* A drive of the library's own model and the filter on it; prints the estimate after STEPS steps, all digits. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "softsoil.h"

int main(int argc, char **argv) {
  static softsoil_t s;
  const int steps = argc > 1 ? atoi(argv[1]) : 200;
  double x[SOFTSOIL_N_X], m[SOFTSOIL_N_M + 1], u[SOFTSOIL_N_U], y[SOFTSOIL_N_Y];
  softsoil_options_t o;
  softsoil_defaults(&o);
  if (softsoil_init(&s, &o, NULL, NULL, 0.0)) return 1;
  for (int i = 0; i < SOFTSOIL_N_X; ++i) x[i] = s.x[i] + (i == SOFTSOIL_X_u ? 1.0 : 0.0);
  for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = 18.2;
  u[SOFTSOIL_U_a_x] = 0.0;
  u[SOFTSOIL_U_steer] = u[SOFTSOIL_U_steer_rate] = 0.0;
  softsoil_history(o.p, x, u, m);
  for (int k = 0; k < steps; ++k) {
    u[SOFTSOIL_U_steer] = 0.3 * sin(0.03 * k);
    u[SOFTSOIL_U_steer_rate] = 0.3 * 0.03 / SOFTSOIL_STEP * cos(0.03 * k);
    if (softsoil_step(o.p, SOFTSOIL_STEP, x, m, u)) return 1;
    for (int i = 0; i < SOFTSOIL_N_Y; ++i) y[i] = x[i] + 0.02 * sin(1.7 * k + i); /* no random numbers: the same everywhere */
    if (softsoil_predict(&s, u, SOFTSOIL_STEP) > SOFTSOIL_NUMERICAL) return 1;
    if (softsoil_update(&s, y, NULL, s.t) > SOFTSOIL_NUMERICAL) return 1;
  }
  for (int i = 0; i < SOFTSOIL_N_X; ++i) printf("%.17g %.17g\n", s.x[i], s.std[i]);
  return 0;
}
