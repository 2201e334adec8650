/* The controller under everything that can go wrong: controller_storm STEPS SEED. Exits 1 at the first broken promise.
 *
 * A vehicle that follows the plan with noise is driven along a weave among obstacles; states, parameters, references,
 * obstacles, periods, options and pointers that are not finite, absurd or missing are thrown at the controller. Promised after
 * every call: a known status, a plan that is finite, a command that is finite and inside its limits, and, with the declared
 * options, a plan that may be driven again after five good calls. With -DFUZZ the same calls come from a fuzzer's bytes (libFuzzer, clang). */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "softsoil_nmpc.h"

#define NZ SOFTSOIL_NMPC_NZ
#define NW SOFTSOIL_NMPC_NW
#define POINTS 400

static double path_x[POINTS], path_y[POINTS], path_s[POINTS], path_psi[POINTS];
static const softsoil_nmpc_path_t path = {POINTS, path_x, path_y, path_s, path_psi};

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
  if (kind < 0.2) return (double)NAN;
  if (kind < 0.4) return kind < 0.3 ? HUGE_VAL : -HUGE_VAL;
  return values[(int)(uniform(c) * 12.0) % 12];
}

static void spoil(chance_t *c, double *values, size_t n, double share) {
  if (uniform(c) < share) values[(size_t)(uniform(c) * (double)n) % n] = absurd(c);
}

/* 0 where a promise is broken, said on stderr. */
static int promise(const softsoil_nmpc_t *c, int status, const double *command) {
  if (status < 0 || status >= SOFTSOIL_NMPC_STATUS_COUNT || !softsoil_nmpc_status_text(status)) {
    fprintf(stderr, "status %d\n", status);
    return 0;
  }
  for (int k = 0; k <= SOFTSOIL_NMPC_N; ++k) {
    for (int i = 0; i < NZ; ++i)
      if (!isfinite(c->z[k][i])) return fprintf(stderr, "state %d of stage %d is %g\n", i, k, c->z[k][i]), 0;
    for (int i = 0; i < NW; ++i)
      if (!isfinite(c->w[k][i])) return fprintf(stderr, "input %d of stage %d is %g\n", i, k, c->w[k][i]), 0;
  }
  for (int i = 0; i < NW; ++i) {
    const double *limits = c->options.limits[SOFTSOIL_NMPC_NB - NW + i];
    if (!(command[i] >= limits[0] && command[i] <= limits[1])) return fprintf(stderr, "command %d is %g\n", i, command[i]), 0;
  }
  return 1;
}

static void weave(void) {
  for (int k = 0; k < POINTS; ++k) {
    path_x[k] = 0.5 * k;
    path_y[k] = 1.5 * sin(0.25 * path_x[k]);
  }
  softsoil_nmpc_path(&path);
}

/* One drive; 0 where a promise was broken. */
static int drive(chance_t *chance, unsigned long steps, uint64_t *counts) {
  static softsoil_nmpc_t c;
  static softsoil_nmpc_now_t now;
  softsoil_nmpc_options_t options;
  softsoil_nmpc_command_t command;
  double z[NZ] = {0.0}, at[NZ], first[NW] = {0.0}, along = -1.0;
  const double obstacles[][5] = {{40.0, 0.3, 1.0, 0.0, 0.0}, {70.0, 6.0, 1.0, 0.0, -0.2}, {120.0, -1.0, 0.8, 0.3, 0.0}};
  int good = 0, declared = 1;
  z[SOFTSOIL_NMPC_Z_u] = 6.0;
  if (softsoil_nmpc_init(&c, NULL, z)) return fprintf(stderr, "a plain start was refused\n"), 0;
  double nominal[SOFTSOIL_NMPC_NS];
  memcpy(nominal, c.s, sizeof nominal);
  for (unsigned long k = 0; k < steps; ++k) {
    memset(&now, 0, sizeof now);
    memcpy(now.s, nominal, sizeof now.s);
    memcpy(at, z, sizeof at);
    const double dice = uniform(chance), rough = dice < 0.7 ? 0.0 : 1.0;
    spoil(chance, at, NZ, 0.1 * rough);
    if (softsoil_nmpc_reference(&path, at, 6.0, &along, NULL, &now) != SOFTSOIL_NMPC_OK || !isfinite(along)) along = -1.0;
    softsoil_nmpc_watch(obstacles, 3, 0.048 * (double)k, at, &now);
    spoil(chance, now.s, SOFTSOIL_NMPC_NS, 0.1 * rough);
    spoil(chance, now.ref[0], 4 * (SOFTSOIL_NMPC_N + 1), 0.1 * rough);
    spoil(chance, now.obstacles[0][0], 3 * SOFTSOIL_NMPC_SOME(SOFTSOIL_NMPC_OBSTACLES) * (SOFTSOIL_NMPC_N + 1), 0.1 * rough);
    if (rough > 0.0 && uniform(chance) < 0.02) now.count = (int32_t)(uniform(chance) * 9.0) - 3;
    double seconds = 0.048;
    if (rough > 0.0) spoil(chance, &seconds, 1, 0.05);
    int status = softsoil_nmpc_prepare(&c, rough > 0.0 && uniform(chance) < 0.01 ? NULL : &now, seconds);
    if (!promise(&c, status, first)) return 0;
    status = softsoil_nmpc_step(rough > 0.0 && uniform(chance) < 0.01 ? NULL : &c, at, first);
    if (!promise(&c, status, first)) return 0;
    if (status < SOFTSOIL_NMPC_STATUS_COUNT) ++counts[status];
    /* After five good calls in a row the plan can be driven again. */
    good = rough > 0.0 ? 0 : good + 1;
    if (good > 5 && declared && !(status >= SOFTSOIL_NMPC_CONVERGED && status <= SOFTSOIL_NMPC_NOT_CLOSED))
      return fprintf(stderr, "step %lu: %s after good calls\n", k, softsoil_nmpc_status_text(status)), 0;
    double since = 0.012, steer = z[SOFTSOIL_NMPC_Z_steer];
    if (rough > 0.0) spoil(chance, &since, 1, 0.1);
    if (softsoil_nmpc_follow(&c, since, steer, 0.012, &command) == SOFTSOIL_NMPC_OK &&
        (!isfinite(command.steer) || !isfinite(command.speed) || !isfinite(command.a_x) || !isfinite(command.steer_rate)))
      return fprintf(stderr, "step %lu: a command that is not finite\n", k), 0;
    /* The vehicle: where the plan leads in a period, and noise; now and then somewhere else. */
    for (int i = 0; i < NZ; ++i) z[i] = c.z[0][i] + 0.75 * (c.z[1][i] - c.z[0][i]) + 0.01 * normal(chance);
    if (uniform(chance) < 0.002 || z[SOFTSOIL_NMPC_Z_x] > 180.0 || fabs(z[SOFTSOIL_NMPC_Z_y]) > 100.0 ||
        fabs(z[SOFTSOIL_NMPC_Z_psi]) > 1e3 ||
        !(z[SOFTSOIL_NMPC_Z_u] > 2.5)) { /* slower, a step of the model is unstable */
      memset(z, 0, sizeof z);
      z[SOFTSOIL_NMPC_Z_u] = 4.0 + 5.0 * uniform(chance);
      z[SOFTSOIL_NMPC_Z_psi] = normal(chance);
      along = -1.0;
      softsoil_nmpc_defaults(&options);
      declared = uniform(chance) < 0.5;
      if (!declared) {
        spoil(chance, options.limits[0], 2 * SOFTSOIL_NMPC_NB, 0.5);
        options.converge = (int32_t)(uniform(chance) * 3.0) - 1;
        options.most = (int32_t)(uniform(chance) * 20.0) - 2;
        options.slack = uniform(chance) < 0.2 ? absurd(chance) : options.slack;
      }
      const int begun = softsoil_nmpc_init(&c, &options, z);
      if (begun != SOFTSOIL_NMPC_OK && softsoil_nmpc_init(&c, NULL, z) != SOFTSOIL_NMPC_OK) return fprintf(stderr, "a new start was refused\n"), 0;
      if (begun != SOFTSOIL_NMPC_OK && begun != SOFTSOIL_NMPC_BAD_ARGUMENT) return fprintf(stderr, "start: %d\n", begun), 0;
      memset(first, 0, sizeof first);
      for (int i = 0; i < NW; ++i) {
        const double *limits = c.options.limits[SOFTSOIL_NMPC_NB - NW + i];
        first[i] = 0.5 * (limits[0] + limits[1]);
      }
      good = 0;
    }
  }
  return 1;
}

#ifdef FUZZ
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  uint64_t counts[SOFTSOIL_NMPC_STATUS_COUNT] = {0};
  chance_t chance = {0x9e3779b97f4a7c15ull, data, size};
  weave();
  if (!drive(&chance, 1 + size / 12, counts)) abort();
  return 0;
}
#else
int main(int argc, char **argv) {
  uint64_t counts[SOFTSOIL_NMPC_STATUS_COUNT] = {0};
  const unsigned long steps = argc > 1 ? strtoul(argv[1], NULL, 10) : 20000;
  chance_t chance = {0x9e3779b97f4a7c15ull ^ (argc > 2 ? strtoull(argv[2], NULL, 10) * 0xd1342543de82ef95ull : 0), NULL, 0};
  weave();
  if (!drive(&chance, steps, counts)) return 1;
  printf("%lu steps, nothing broke:\n", steps);
  for (int i = 0; i < SOFTSOIL_NMPC_STATUS_COUNT; ++i)
    if (counts[i]) printf("%10lu x %s\n", (unsigned long)counts[i], softsoil_nmpc_status_text(i));
  return 0;
}
#endif
