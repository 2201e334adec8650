/* A drive of the library's own model by the generated driver; prints the last command and the vehicle after TICKS ticks, all digits. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "softsoil_driver.h"

#define POINTS 200

int main(int argc, char **argv) {
  static softsoil_driver_t d;
  static double path_x[POINTS], path_y[POINTS], path_s[POINTS], path_psi[POINTS];
  static const double obstacle[1][5] = {{12.0, 1.4, 0.5, 0.0, 0.0}};
  const int ticks = argc > 1 ? atoi(argv[1]) : 200;
  softsoil_driver_task_t task;
  softsoil_driver_command_t c;
  softsoil_options_t o;
  static softsoil_t first;
  double x[SOFTSOIL_N_X], m[SOFTSOIL_N_M + 1], u[SOFTSOIL_N_U], z[SOFTSOIL_NMPC_NZ] = {0.0}, w[SOFTSOIL_NMPC_NW] = {0.0};
  double measured[SOFTSOIL_DRIVER_MEASUREMENTS], s[SOFTSOIL_NMPC_NS] = {0.0};
  for (int k = 0; k < POINTS; ++k) {
    path_x[k] = 0.25 * k;
    path_y[k] = 0.8 * sin(0.3 * path_x[k]);
  }
  memset(&task, 0, sizeof task);
  task.path.n = POINTS;
  task.path.x = path_x;
  task.path.y = path_y;
  task.path.s = path_s;
  task.path.psi = path_psi;
  task.speed = 5.5;
  task.obstacles = obstacle;
  task.obstacle_count = 1;
  task.n0 = 0.6;
  task.learn = 1;
  softsoil_defaults(&o);
  if (softsoil_init(&first, &o, NULL, NULL, 0.0) || softsoil_nmpc_path(&task.path)) return 1;
  if (softsoil_driver_init(&d, NULL, &task)) return 1;
  memcpy(x, first.x, sizeof x);
  x[SOFTSOIL_X_u] = 5.0;
  softsoil_history(o.p, x, first.u, m);
  for (int k = 0; k < ticks; ++k) {
    for (int i = 0; i < SOFTSOIL_DRIVER_MEASUREMENTS; ++i) measured[i] = (double)NAN;
    for (int i = 0; i < 6; ++i) measured[i] = x[i] + 0.02 * sin(1.7 * k + i); /* no random numbers: the same everywhere */
    if (softsoil_driver_tick(&d, k * SOFTSOIL_STEP, measured, &c)) return 1;
    z[SOFTSOIL_NMPC_Z_u] = x[SOFTSOIL_X_u];
    z[SOFTSOIL_NMPC_Z_v] = x[SOFTSOIL_X_v];
    z[SOFTSOIL_NMPC_Z_omega_z] = x[SOFTSOIL_X_omega_z];
    z[SOFTSOIL_NMPC_Z_steer] = c.steer;
    w[SOFTSOIL_NMPC_W_a_x] = c.a_asked;
    softsoil_nmpc_inputs(z, w, s, u);
    if (softsoil_step(o.p, SOFTSOIL_STEP, x, m, u)) return 1;
  }
  printf("%.17g %.17g %.17g %.17g %.17g\n", c.steer, c.a_asked, c.n, c.n_std, c.along);
  for (int i = 0; i < 6; ++i) printf("%.17g\n", x[i]);
  return c.lost;
}
