/* Random driving with everything that can go wrong: clibrary_storm STEPS SEED. Exits 1 at the first broken promise.
 *
 * Inputs and measurements come from a vehicle that follows the library's own model with noise; then dropouts, outliers, NaN,
 * Inf, absurd numbers, zero, negative, endless and missing dt, repeated, backward and future time stamps, standstill,
 * reversing and restarts are thrown at the filter. Promised after every call: all finite, n inside its bounds, the
 * covariance symmetric and positive, and each thing left out counted under its status. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "softsoil.h"
#include "softsoil_horizon.h"
#if __has_include("softsoil_vehicle.h")
#include "softsoil_vehicle.h"
#define LOOKS
#endif

#define N SOFTSOIL_N_X
#define FAIL(...)                                          \
  do {                                                     \
    fprintf(stderr, "step %lu: ", (unsigned long)k);       \
    fprintf(stderr, __VA_ARGS__);                          \
    fprintf(stderr, "\n");                                 \
    return 1;                                              \
  } while (0)

static uint64_t seed;

static double uniform(void) {
  seed ^= seed << 13;
  seed ^= seed >> 7;
  seed ^= seed << 17;
  return (double)(seed >> 11) / 9007199254740992.0;
}

static double normal(void) { return sqrt(-2.0 * log(uniform() + 1e-300)) * cos(6.283185307179586 * uniform()); }

static double absurd(void) {
  static const double values[] = {1e300, -1e300, 1e9, -1e9, 5e-324, -0.0, 1e-300, 1e20, -4e4, 1e308};
  return values[(int)(uniform() * 10.0) % 10];
}

/* P from the factor must have a factor of its own, with room for rounding alone. */
static int covariance_is_good(const softsoil_t *s) {
  double p[N * N], l[N][N];
  if (softsoil_covariance(s, p)) return 0;
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j)
      if (!isfinite(p[i * N + j]) || p[i * N + j] < p[j * N + i] || p[i * N + j] > p[j * N + i]) return 0;
  for (int j = 0; j < N; ++j)
    for (int i = j; i < N; ++i) {
      double sum = p[i * N + j];
      for (int m = 0; m < j; ++m) sum -= l[i][m] * l[j][m];
      if (i == j && !(sum > -1e-9 * p[j * N + j])) return 0;
      if (i == j && !(p[j * N + j] > 0.0)) return 0;
      l[i][j] = i == j ? sqrt(sum > 1e-14 * p[j * N + j] ? sum : 1e-14 * p[j * N + j]) : sum / l[j][j];
    }
  return 1;
}

/* The horizon: everything that the verdict rests on is finite, and the parameters are inside their bounds. */
static int horizon_is_good(const softsoil_horizon_t *h) {
  for (int k = 0; k < SOFTSOIL_HORIZON_N; ++k)
    if (!(h->n[k] > -1e9 && h->n[k] < 1e9) || !(h->std[k] > 0.0) || !isfinite(h->std[k]) || !isfinite(h->information_std[k]) ||
        !isfinite(h->free_n[k]))
      return 0;
  for (int c = 0; c < 2; ++c)
    if (!isfinite(h->unexplained[c]) || !isfinite(h->unexplained_std[c])) return 0;
  return isfinite(h->t) && isfinite(h->motion) && isfinite(h->cost) && h->verdict >= 0 && h->verdict < SOFTSOIL_VERDICT_COUNT;
}

int main(int argc, char **argv) {
  const unsigned long steps = argc > 1 ? strtoul(argv[1], NULL, 10) : 20000;
  seed = 0x9e3779b97f4a7c15ull ^ (argc > 2 ? strtoull(argv[2], NULL, 10) * 0xd1342543de82ef95ull : 0);
  static softsoil_t s;
  static softsoil_horizon_t horizon;
#ifdef LOOKS
  static softsoil_vehicle_t look;
  unsigned long looked = 0;
  softsoil_vehicle_init(&look);
#endif
  unsigned long windows = 0, corrected = 0, verdicts[SOFTSOIL_VERDICT_COUNT] = {0};
  softsoil_options_t o;
  double x[N], m[SOFTSOIL_N_M + 1], u[SOFTSOIL_N_U], y[SOFTSOIL_N_Y], lower[N], upper[N];
  unsigned char valid[SOFTSOIL_N_Y];
  uint64_t total[SOFTSOIL_STATUS_COUNT] = {0};
  unsigned long starts = 1;
  softsoil_defaults(&o);
  if (softsoil_init(&s, &o, NULL, NULL, 0.0)) return 1;
  for (int i = 0; i < N; ++i) {
    lower[i] = i < 6 ? -1e9 : 0.2;
    upper[i] = i < 6 ? 1e9 : 1.6;
    x[i] = s.x[i];
  }
  if (softsoil_horizon_init(&horizon, NULL, 0.0)) return 1;
  double t = 0.0, speed = 6.0, turn = 1.0, dropout = 0.0;
  memset(u, 0, sizeof u);
  softsoil_history(o.p, x, u, m);
  for (unsigned long k = 0; k < steps; ++k) {
    /* The true vehicle: speeds from standstill to fast, a sine of steering. */
    const double dt = 0.002 + 0.02 * uniform() * uniform();
    if (uniform() < 1e-3) speed = uniform() < 0.2 ? 0.0 : 14.0 * uniform();
    if (uniform() < 1e-3) turn = 3.0 * uniform();
    t += dt;
    const double steer = 0.4 * sin(turn * t);
    const double a_x = speed > x[SOFTSOIL_X_u] ? 2.0 : x[SOFTSOIL_X_u] > 0.05 ? -2.0 : 0.0;
    for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = 3.03 * x[SOFTSOIL_X_u];
    u[SOFTSOIL_U_steer] = steer;
    u[SOFTSOIL_U_steer_rate] = 0.4 * turn * cos(turn * t);
    u[SOFTSOIL_U_a_x] = a_x;
    const int moved = softsoil_step(o.p, dt, x, m, u);
    if (moved != SOFTSOIL_OK && moved != SOFTSOIL_DT_TOO_LONG && moved != SOFTSOIL_NUMERICAL)
      FAIL("the model: %s", softsoil_status_text(moved));
    if (x[SOFTSOIL_X_u] < 0.0) x[SOFTSOIL_X_u] = 0.0;
    /* Steps this long can diverge at a crawl, and histories with them: the true vehicle then starts anew, straight. */
    if (moved == SOFTSOIL_NUMERICAL || fabs(x[SOFTSOIL_X_v]) > 20.0 || fabs(x[SOFTSOIL_X_omega_z]) > 10.0) {
      x[SOFTSOIL_X_v] = x[SOFTSOIL_X_omega_z] = 0.0;
      softsoil_history(o.p, x, u, m);
    }

    /* Inputs, spoiled. */
    uint32_t before[SOFTSOIL_STATUS_COUNT];
    memcpy(before, s.counts, sizeof before);
    unsigned not_finite = 0;
    double step = s.t < t ? t - s.t : dt;
    for (int i = 0; i < SOFTSOIL_N_U; ++i) {
      u[i] += 0.01 * normal();
      if (uniform() < 2e-3) u[i] = absurd();
      if (uniform() < 2e-3) u[i] = uniform() < 0.5 ? (double)NAN : (double)-INFINITY;
      not_finite += !isfinite(u[i]);
    }
    if (uniform() < 5e-3) {
      static const double steps_[] = {0.0, -0.012, (double)NAN, (double)INFINITY, 1e300, -1e300, 5e-324, 0.9};
      step = steps_[(int)(uniform() * 8.0) % 8];
    }
    int status = softsoil_predict(&s, uniform() < 1e-3 ? NULL : u, step);
    if (status < 0 || status >= SOFTSOIL_STATUS_COUNT) FAIL("status %d", status);
    const uint32_t counted = s.counts[SOFTSOIL_INPUT_NOT_FINITE] - before[SOFTSOIL_INPUT_NOT_FINITE];
    if (status < SOFTSOIL_MEASUREMENT_LATE && counted != not_finite)
      FAIL("%u inputs not finite, counted %lu", not_finite, (unsigned long)counted);
    if (status >= SOFTSOIL_MEASUREMENT_LATE && status < SOFTSOIL_NOT_INITIALISED && s.counts[status] != before[status] + 1)
      FAIL("'%s' was not counted", softsoil_status_text(status));

    /* Measurements, spoiled. */
    if (k % 2) {
      if (dropout <= 0.0 && uniform() < 1e-4) dropout = 20.0 * uniform();
      dropout -= 2.0 * dt;
      double at = s.t;
      const double choice = uniform();
      if (choice < 0.01) at += 0.1 * normal();
      if (choice < 0.002) at = uniform() < 0.5 ? (double)NAN : absurd();
      memcpy(before, s.counts, sizeof before);
      for (int i = 0; i < SOFTSOIL_N_Y; ++i) {
        y[i] = x[i] + s.options.r_std[i] * normal();
        if (uniform() < 5e-3) y[i] += 100.0 * normal();
        if (uniform() < 2e-3) y[i] = absurd();
        if (uniform() < 5e-3) y[i] = uniform() < 0.5 ? (double)NAN : (double)INFINITY;
        valid[i] = dropout <= 0.0 && uniform() > 0.05;
      }
      if (uniform() < 1e-3) y[SOFTSOIL_Y_u] = -3.0;
      unsigned now = 0;
      for (int i = 0; i < SOFTSOIL_N_Y; ++i) now += valid[i] && !isfinite(y[i]);
      status = softsoil_update(&s, y, valid, at);
      if (status < 0 || status >= SOFTSOIL_STATUS_COUNT) FAIL("status %d", status);
        if (status < SOFTSOIL_MEASUREMENT_LATE &&
          s.counts[SOFTSOIL_MEASUREMENT_NOT_FINITE] - before[SOFTSOIL_MEASUREMENT_NOT_FINITE] != now)
        FAIL("%u measurements not finite, counted otherwise", now);
      if (uniform() < 0.01) (void)softsoil_update(&s, y, valid, at); /* the same once more */
      if (uniform() < 2e-5) (void)softsoil_restart(&s, y, valid, s.t);
      if (uniform() < 2e-5) {
        for (int i = 0; i < SOFTSOIL_STATUS_COUNT; ++i) total[i] += s.counts[i];
        ++starts;
        if (softsoil_init(&s, &o, NULL, NULL, s.t)) FAIL("a new start was refused");
      }
    }
    /* The horizon on the same measurements: the last ones that were made, or none. */
    if (k % 2 == 0)
      for (int i = 0; i < SOFTSOIL_N_Y; ++i) valid[i] = 0;
    status = softsoil_horizon_push(&horizon, u, y, valid, uniform() < 1e-3 ? absurd() : t);
    if (status < 0 || status >= SOFTSOIL_STATUS_COUNT) FAIL("horizon: status %d", status);
    status = softsoil_horizon_update(&horizon);
    if (status < 0 || status >= SOFTSOIL_STATUS_COUNT) FAIL("horizon: status %d", status);
    if (!horizon_is_good(&horizon)) FAIL("the horizon is not finite");
#ifdef LOOKS
    status = softsoil_vehicle_update(&look, &horizon);
    if (status < 0 || status > 1) FAIL("look: status %d", status);
    looked += (unsigned long)status;
    if (!isfinite(look.strain) || !isfinite(look.load) || !(look.load_std >= 0.0)) FAIL("the look at the vehicle is not finite");
    if (horizon.vehicle != look.change) FAIL("the horizon has another word of the vehicle");
    if (look.change != SOFTSOIL_VEHICLE_SAME && horizon.verdict == SOFTSOIL_VERDICT_IDENTIFIED) FAIL("n of a changed vehicle is identified");
    if (uniform() < 2e-5 && softsoil_vehicle_init(&look)) FAIL("the look refused a new start");
#endif
    if (horizon.updated) {
      ++windows;
      ++verdicts[horizon.verdict];
      corrected += (unsigned long)softsoil_horizon_correct(&horizon, &s);
    }
    /* A time far ahead was believed: everything later is late until the drive begins anew. */
    if (horizon.clock > t + 10.0 && softsoil_horizon_init(&horizon, NULL, t)) FAIL("the horizon refused a new start");
    for (int i = 0; i < N; ++i)
      if (!(s.x[i] >= lower[i] && s.x[i] <= upper[i]) || !(s.std[i] > 0.0) || !(s.std[i] <= 1.0001 * o.max_std[i]))
        FAIL("state %d is %g with std %g", i, s.x[i], s.std[i]);
    if (fabs(s.x[SOFTSOIL_X_psi]) > 3.1416) FAIL("psi is %g", s.x[SOFTSOIL_X_psi]);
    if (!(s.drift >= 0.0) || s.drift_channel < 0 || s.drift_channel >= SOFTSOIL_N_DRIFT) FAIL("drift is %g", s.drift);
    if (!covariance_is_good(&s)) FAIL("the covariance is not positive");
  }
#ifdef LOOKS
  printf("look at the vehicle: %lu windows\n", looked);
#endif
  printf("horizon: %lu windows, %lu corrections of the filter, %lu times identified\n", windows, corrected,
         verdicts[SOFTSOIL_VERDICT_IDENTIFIED]);
  printf("%lu steps, %lu starts, nothing broke; what was met, and counted:\n", steps, starts);
  for (int i = 0; i < SOFTSOIL_STATUS_COUNT; ++i) {
    total[i] += s.counts[i];
    if (total[i]) printf("%10lu x %s\n", (unsigned long)total[i], softsoil_status_text(i));
  }
  return 0;
}
