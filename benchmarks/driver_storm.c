/* Drives with everything that can go wrong, through the generated driver: driver_storm [ticks] [seed].
 *
 * The vehicle is the library's own model; measurements, times, tasks and settings are missing, absurd or not finite now and then.
 * The promise after every tick: a known status, a command that is finite, steering inside what a steering can do, and a plan that
 * is followed again after four periods of good measurements. With -DFUZZ the same calls come from a fuzzer's bytes (libFuzzer). */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "softsoil_driver.h"

#define NZ SOFTSOIL_NMPC_NZ
#define POINTS 400
#define GOOD 160 /* ticks in a row after which the driver drives again */

static double path_x[POINTS], path_y[POINTS], path_s[POINTS], path_psi[POINTS];
static const softsoil_nmpc_path_t path = {POINTS, path_x, path_y, path_s, path_psi};
static const double obstacles[][5] = {{40.0, 3.5, 1.0, 0.0, 0.0}, {70.0, 6.0, 1.0, 0.0, -0.2}, {120.0, -4.0, 0.8, 0.3, 0.0}};

/* Where chance comes from: a seed, or a fuzzer's bytes until they end. */
typedef struct {
  uint64_t seed;
  const uint8_t *at;
  size_t left;
} chance_t;

static double uniform(chance_t *c) {
  if (c->left > 0) {
    --c->left;
    return (double)*c->at++ / 256.0;
  }
  c->seed ^= c->seed << 13;
  c->seed ^= c->seed >> 7;
  c->seed ^= c->seed << 17;
  return (double)(c->seed >> 11) / 9007199254740992.0;
}

static double normal(chance_t *c) { return sqrt(-2.0 * log(uniform(c) + 1e-12)) * cos(6.283185307179586 * uniform(c)); }

static double absurd(chance_t *c) {
  static const double values[] = {1e300, -1e300, 1e9, -1e9, 5e-324, -0.0, 1e20, -4e4, 1e308, 0.0, 1e5, -7.0};
  const double kind = uniform(c);
  if (kind < 0.4) return (double)NAN;
  if (kind < 0.5) return kind < 0.45 ? HUGE_VAL : -HUGE_VAL;
  return values[(int)(uniform(c) * 12.0) % 12];
}

static int finite_command(const softsoil_driver_command_t *c) {
  const double values[] = {c->steer, c->steer_rate, c->speed, c->a_x, c->a_asked, c->n, c->n_std, c->n_used, c->slip, c->resistance,
                           c->along, c->left};
  for (size_t i = 0; i < sizeof values / sizeof values[0]; ++i)
    if (!isfinite(values[i])) return 0;
  for (int i = 0; i < NZ; ++i)
    if (!isfinite(c->z[i])) return 0;
  return 1;
}

/* 0 where a promise is broken, said on stderr. */
static int promise(unsigned long k, int status, const softsoil_driver_command_t *c) {
  if (status < 0 || status >= SOFTSOIL_NMPC_STATUS_COUNT) return fprintf(stderr, "tick %lu: status %d\n", k, status), 0;
  if (status >= SOFTSOIL_NMPC_BAD_ARGUMENT) return 1;
  if (!finite_command(c)) return fprintf(stderr, "tick %lu: a command that is not finite\n", k), 0;
  if (fabs(c->steer) > 1.61 || fabs(c->a_x) > 20.0) return fprintf(stderr, "tick %lu: %g rad, %g m/s^2\n", k, c->steer, c->a_x), 0;
  if (c->status < 0 || c->status >= SOFTSOIL_NMPC_STATUS_COUNT || c->filter_status < 0 || c->filter_status >= SOFTSOIL_STATUS_COUNT)
    return fprintf(stderr, "tick %lu: statuses %d, %d\n", k, c->status, c->filter_status), 0;
  return 1;
}

static void weave(void) {
  for (int k = 0; k < POINTS; ++k) {
    path_x[k] = 0.5 * k;
    path_y[k] = 1.2 * sin(0.25 * path_x[k]);
  }
  softsoil_nmpc_path(&path);
}

/* The vehicle: state, histories and parameters of the library's model. */
typedef struct {
  double x[SOFTSOIL_N_X], m[SOFTSOIL_N_M + 1], p[SOFTSOIL_N_P], steer;
} vehicle_t;

static void place(vehicle_t *v, chance_t *chance) {
  static softsoil_t fresh;
  softsoil_options_t options;
  double u[SOFTSOIL_N_U];
  softsoil_defaults(&options);
  softsoil_init(&fresh, &options, NULL, NULL, 0.0);
  memcpy(v->x, fresh.x, sizeof v->x);
  memcpy(v->p, options.p, sizeof v->p);
  memcpy(u, fresh.u, sizeof u);
  v->x[SOFTSOIL_X_u] = 4.0 + 3.0 * uniform(chance);
  v->x[SOFTSOIL_X_y] = 0.3 * normal(chance);
  v->steer = 0.0;
  softsoil_history(v->p, v->x, u, v->m);
}

static void move(vehicle_t *v, const softsoil_driver_command_t *command, double dt) {
  double z[NZ] = {0.0}, w[SOFTSOIL_NMPC_NW], u[SOFTSOIL_N_U], s[SOFTSOIL_NMPC_NS] = {0.0};
  z[SOFTSOIL_NMPC_Z_u] = v->x[SOFTSOIL_X_u];
  z[SOFTSOIL_NMPC_Z_v] = v->x[SOFTSOIL_X_v];
  z[SOFTSOIL_NMPC_Z_omega_z] = v->x[SOFTSOIL_X_omega_z];
  const double most = 0.02, turn = command->steer - v->steer;
  z[SOFTSOIL_NMPC_Z_steer] = v->steer += turn > most ? most : turn < -most ? -most : turn;
  w[SOFTSOIL_NMPC_W_steer_rate] = 0.0;
  w[SOFTSOIL_NMPC_W_a_x] = command->a_asked > 3.0 ? 3.0 : command->a_asked < -5.0 ? -5.0 : command->a_asked;
  softsoil_nmpc_inputs(z, w, s, u);
  softsoil_step(v->p, dt, v->x, v->m, u);
}

/* One storm; 0 where a promise was broken. */
static int storm(chance_t *chance, unsigned long ticks, uint64_t *counts) {
  static softsoil_driver_t d;
  static vehicle_t v;
  softsoil_driver_settings_t settings;
  softsoil_driver_task_t task;
  softsoil_driver_command_t command;
  double measured[SOFTSOIL_DRIVER_MEASUREMENTS], t = 0.0;
  unsigned long good = 0;
  int fresh = 1, declared = 1;
  memset(&command, 0, sizeof command);
  for (unsigned long k = 0; k < ticks; ++k) {
    if (fresh) {
      memset(&task, 0, sizeof task);
      task.path = path;
      task.speed = 5.0 + uniform(chance);
      task.obstacles = uniform(chance) < 0.5 ? obstacles : NULL;
      task.obstacle_count = task.obstacles ? sizeof obstacles / sizeof obstacles[0] : 0;
      task.n0 = 0.6;
      task.learn = uniform(chance) < 0.8;
      place(&v, chance);
      softsoil_driver_defaults(&settings);
      declared = uniform(chance) < 0.7;
      if (!declared) {
        double *numbers[] = {&settings.n_std, &settings.slip_share, &settings.speed_gain, &settings.resistance_share,
                             &settings.most_resistance, &settings.caution, &settings.settled, &settings.most, &settings.standing,
                             &settings.stands, &task.n0, &task.speed, &task.start[0], &task.start[3], &settings.filter.gate,
                             &settings.filter.q_std[0], &settings.filter.r_std[0], &settings.nmpc.patience};
        task.known = uniform(chance) < 0.5;
        if (uniform(chance) < 0.5) *numbers[(size_t)(uniform(chance) * (double)(sizeof numbers / sizeof numbers[0]))] = absurd(chance);
        settings.plan_every = (int32_t)(uniform(chance) * 12.0) - 2;
        settings.update_every = (int32_t)(uniform(chance) * 6.0) - 1;
      }
      const int begun = softsoil_driver_init(&d, &settings, &task);
      if (begun != SOFTSOIL_NMPC_OK && begun != SOFTSOIL_NMPC_BAD_ARGUMENT) return fprintf(stderr, "start: %d\n", begun), 0;
      if (begun != SOFTSOIL_NMPC_OK && declared) return fprintf(stderr, "a plain start was refused\n"), 0;
      if (begun != SOFTSOIL_NMPC_OK) continue;
      memset(&command, 0, sizeof command);
      fresh = 0;
      good = 0;
      t = uniform(chance) < 0.5 ? 0.0 : 1e5 * uniform(chance);
    }
    const int rough = uniform(chance) < 0.15;
    for (int i = 0; i < SOFTSOIL_DRIVER_MEASUREMENTS; ++i) measured[i] = (double)NAN;
    for (int i = 0; i < 6; ++i) measured[i] = v.x[i] + 0.02 * normal(chance);
    if (uniform(chance) < 0.5) measured[SOFTSOIL_DRIVER_steer] = v.steer;
    if (uniform(chance) < 0.5)
      for (int i = 0; i < 4; ++i) measured[SOFTSOIL_DRIVER_omega_fl + i] = v.x[SOFTSOIL_X_u] / 0.32;
    if (rough) measured[(size_t)(uniform(chance) * SOFTSOIL_DRIVER_MEASUREMENTS) % SOFTSOIL_DRIVER_MEASUREMENTS] = absurd(chance);
    if (rough && uniform(chance) < 0.05)
      for (int i = 0; i < 6; ++i) measured[i] = absurd(chance);
    double when = t;
    if (rough && uniform(chance) < 0.02) when = absurd(chance);
    const int status = softsoil_driver_tick(rough && uniform(chance) < 0.01 ? NULL : &d, when, measured, &command);
    if (!promise(k, status, &command)) return 0;
    ++counts[status < SOFTSOIL_NMPC_BAD_ARGUMENT ? command.status : status];
    good = rough || when != t ? 0 : good + 1;
    if (good > GOOD && declared && command.lost) return fprintf(stderr, "tick %lu: lost after %lu good ones\n", k, good), 0;
    t = when > t && when < 1e12 && status == SOFTSOIL_NMPC_OK ? when : t;
    t += d.settings.tick;
    move(&v, &command, d.settings.tick);
    fresh = command.finished || command.stopped || uniform(chance) < 0.001 || t > 1e9;
    for (int i = 0; i < SOFTSOIL_N_X; ++i) fresh = fresh || !(fabs(v.x[i]) < 400.0);
    fresh = fresh || !(v.x[SOFTSOIL_X_u] > 2.0); /* slower, a step of the model is unstable */
  }
  return 1;
}

#ifdef FUZZ
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  uint64_t counts[SOFTSOIL_NMPC_STATUS_COUNT] = {0};
  chance_t chance = {0x9e3779b97f4a7c15ull, data, size};
  weave();
  if (!storm(&chance, 1 + size / 8, counts)) abort();
  return 0;
}
#else
int main(int argc, char **argv) {
  uint64_t counts[SOFTSOIL_NMPC_STATUS_COUNT] = {0};
  const unsigned long ticks = argc > 1 ? strtoul(argv[1], NULL, 10) : 20000;
  chance_t chance = {0x9e3779b97f4a7c15ull ^ (argc > 2 ? strtoull(argv[2], NULL, 10) * 0xd1342543de82ef95ull : 0), NULL, 0};
  weave();
  if (!storm(&chance, ticks, counts)) return 1;
  printf("%lu ticks, nothing broke; status of the last plan, or of the call:\n", ticks);
  for (int i = 0; i < SOFTSOIL_NMPC_STATUS_COUNT; ++i)
    if (counts[i]) printf("%10lu x %s\n", (unsigned long)counts[i], softsoil_nmpc_status_text(i));
  return 0;
}
#endif
