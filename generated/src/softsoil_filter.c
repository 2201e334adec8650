/* The filter: a square-root unscented Kalman filter.
 *
 * The covariance is P = L L', and only L is kept. Both steps put weighted deviations of the sigma points and the noise
 * into the rows of a matrix A, P = A'A, and triangularise A by Householder reflections: whatever the numbers, P is
 * symmetric and positive, for ever. The update is Joseph's form over sigma points: deviations dx - K dy and K sqrt(R). */
#include <math.h>
#include <string.h>

#include "softsoil_model.h"
#include "softsoil_policy.h"

#define N SOFTSOIL_N_X
#define NY SOFTSOIL_N_Y
/* Rows of matrices end in zeros, so that whole vectors fit. */
#define WIDE ((N + 7) / 8 * 8)
#define WIDE_Y ((NY + 7) / 8 * 8)
#define MAGIC 0x1597a17eu
#define WINDOW 80 /* updates over which consistency is a mean */

/* Weights of the unscented transform (paper, eqs. (lambda)-(Wi)). */
static const double spread = 7.0; /* L + lambda */
static const double mean_centre = 0.0, mean_other = 0.07142857142857;
static const double root_centre = 1.414213562373, root_other = 0.2672612419124; /* roots of the covariance weights */

static const double lower[N] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, 0.2};
static const double upper[N] = {HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL, 1.6};
static const int32_t is_soil[N] = {0, 0, 0, 0, 0, 0, 1}; /* held at standstill */
static const double held_inputs = 0.25; /* s: for so long an input may be missing */
static const int32_t y_driven[NY] = {0, 0, 0, 0, 1, 1}; /* moved by the soil's forces first of all */
static const int32_t y_wraps[NY] = {0, 0, 1, 0, 0, 0};
static const double u_limit[SOFTSOIL_N_U] = {1.6, 1000.0, 200.0, 1000.0, 1000.0, 1000.0, 1000.0}; /* beyond reason */
static const double y_limit[NY] = {100000000.0, 100000000.0, 100000.0, 150.0, 150.0, 50.0};

const char *softsoil_status_text(int status) {
  switch (status) {
    case SOFTSOIL_OK:
      return "done";
    case SOFTSOIL_STANDSTILL:
      return "the vehicle stands, crawls or reverses: the soil's parameters are held";
    case SOFTSOIL_NO_MEASUREMENT:
      return "no measurement could be used: the estimate is the prediction";
    case SOFTSOIL_MEASUREMENT_REPEATED:
      return "a measurement with a time stamp that it had before, or an older one, was left out";
    case SOFTSOIL_MEASUREMENT_GATED:
      return "a measurement too far from its prediction was left out";
    case SOFTSOIL_MEASUREMENT_OUT_OF_RANGE:
      return "a measurement beyond reason was left out";
    case SOFTSOIL_MEASUREMENT_NOT_FINITE:
      return "a measurement that is not a finite number was left out";
    case SOFTSOIL_NEGATIVE_SPEED:
      return "the measured speed is negative: the model does not reverse, the soil's parameters are held";
    case SOFTSOIL_INPUT_OUT_OF_RANGE:
      return "an input beyond reason was replaced by its last good value";
    case SOFTSOIL_INPUT_NOT_FINITE:
      return "an input that is not a finite number was replaced by its last good value";
    case SOFTSOIL_GATE_REOPENED:
      return "a measurement was outside the gate for so long that it is believed: its state was put where it is";
    case SOFTSOIL_SOIL_KEPT:
      return "a jump of n is revoked: the seconds after it do not bear it out, what was known of n before counts again";
    case SOFTSOIL_SOIL_CHANGED:
      return "innovations say that n has jumped, the soil is another one: n was put there and made uncertain";
    case SOFTSOIL_DRIFT:
      return "corrections go to one side for longer than a right model's do: see drift and drift_channel";
    case SOFTSOIL_INCONSISTENT:
      return "measurements are further from their predictions than noise explains: wrong soil, vehicle or noise";
    case SOFTSOIL_NUMERICAL:
      return "the model had no finite answer: the last estimate was kept";
    case SOFTSOIL_MEASUREMENT_LATE:
      return "the measurement is older than one step and was not used";
    case SOFTSOIL_MEASUREMENT_EARLY:
      return "the measurement is later than the estimate by more than one step: predict first";
    case SOFTSOIL_TIME_NOT_FINITE:
      return "the time stamp is not a finite number: nothing was done";
    case SOFTSOIL_DT_ZERO:
      return "the time step is zero: nothing was done";
    case SOFTSOIL_DT_NEGATIVE:
      return "the time step is negative: nothing was done";
    case SOFTSOIL_DT_NOT_FINITE:
      return "the time step is not a finite number: nothing was done";
    case SOFTSOIL_DT_TOO_LONG:
      return "the time step is longer than the library takes: nothing was done";
    case SOFTSOIL_BAD_ARGUMENT:
      return "an argument is not a finite number or out of its range: nothing was done";
    case SOFTSOIL_NOT_INITIALISED:
      return "the init function of this structure has not been called, or that of another version was";
    case SOFTSOIL_NULL_POINTER:
      return "a pointer is null: nothing was done";
    default:
      return "not a status of this library";
  }
}

size_t softsoil_size(void) { return sizeof(softsoil_t); }

static int count(softsoil_t *s, int status) {
  if (s->counts[status] < UINT32_MAX) ++s->counts[status];
  return status;
}

static int graver(int a, int b) { return a > b ? a : b; }

static double wrapped(double angle) {
  if (angle > -3.14159265358979 && angle <= 3.14159265358979) return angle;
  return angle - 6.283185307179586 * floor(angle / 6.283185307179586 + 0.5);
}

static double clipped(double value, int i) {
  return value < lower[i] ? lower[i] : value > upper[i] ? upper[i] : value;
}

/* A (rows x N) to upper triangular, L = its transpose: L L' = A'A, the diagonal not negative. */
static void triangularise(double (*a)[WIDE], int rows, double (*root)[N]) {
  for (int k = 0; k < N; ++k) {
    /* Column k times all columns, below the diagonal; even and odd rows apart, so that no sum waits for the one before. */
    double w[WIDE] = {0.0}, other[WIDE] = {0.0};
    int r = k + 1;
    for (; r + 1 < rows; r += 2) {
      const double even = a[r][k], odd = a[r + 1][k];
      for (int c = 0; c < WIDE; ++c) w[c] += even * a[r][c];
      for (int c = 0; c < WIDE; ++c) other[c] += odd * a[r + 1][c];
    }
    for (; r < rows; ++r) {
      const double last = a[r][k];
      for (int c = 0; c < WIDE; ++c) w[c] += last * a[r][c];
    }
    for (int c = 0; c < WIDE; ++c) w[c] += other[c];
    const double below = w[k];
    if (!(below > 0.0)) continue;
    const double pivot = a[k][k], length = sqrt(pivot * pivot + below);
    const double v = pivot < 0.0 ? pivot - length : pivot + length;
    const double beta = 1.0 / (length * fabs(v));
    for (int c = 0; c < WIDE; ++c) {
      w[c] = beta * (w[c] + v * a[k][c]);
      a[k][c] -= v * w[c];
    }
    /* Column k below the diagonal is zero from here on, and not read again: it may hold anything. */
    w[k] = 0.0;
    for (r = k + 1; r < rows; ++r) {
      const double factor = a[r][k];
      for (int c = 0; c < WIDE; ++c) a[r][c] -= factor * w[c];
    }
  }
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j) root[i][j] = j > i ? 0.0 : a[j][j] < 0.0 ? -a[j][i] : a[j][i];
}

/* Standard deviations from the factor; rows above their ceiling are scaled down, which keeps correlations. */
static void settle(softsoil_t *s) {
  for (int i = 0; i < N; ++i) {
    double sum = 0.0;
    for (int j = 0; j <= i; ++j) sum += s->root[i][j] * s->root[i][j];
    const int at = softsoil_order[i];
    const double most = s->options.max_std[at];
    s->std[at] = sqrt(sum);
    if (s->std[at] > most) {
      const double scale = most / s->std[at];
      for (int j = 0; j <= i; ++j) s->root[i][j] *= scale;
      s->std[at] = most;
    }
    if (is_soil[at]) {
      const double common = s->options.common_error * s->x[at];
      s->std[at] = sqrt(s->std[at] * s->std[at] + common * common);
    }
  }
}

static void stay_finite(softsoil_t *s) {
  for (int i = 0; i < N; ++i)
    if (fabs(s->x[i]) > 1e9) s->x[i] = s->x[i] > 0.0 ? 1e9 : -1e9;
}

/* Sigma points (paper, eq. (sigma_pts)), inside the bounds where `inside`. Columns: centre, active pairs, other pairs. */
static void sigma_points(const softsoil_t *s, int inside, softsoil_points_t *x) {
  const double step = sqrt(spread);
  for (int i = 0; i < N; ++i) {
    const int at = softsoil_order[i];
    const double centre = s->x[at];
    for (int k = 0; k < SOFTSOIL_ROW; ++k) x[at][k] = centre;
    for (int j = 0; j <= i; ++j) {
      const double away = step * s->root[i][j];
      x[at][1 + 2 * j] = inside ? clipped(centre + away, at) : centre + away;
      x[at][2 + 2 * j] = inside ? clipped(centre - away, at) : centre - away;
    }
  }
}

static double mean_of(const double *row) {
  double sum = 0.0, other = 0.0;
  for (int k = 1; k + 1 < SOFTSOIL_POINTS; k += 2) {
    sum += row[k];
    other += row[k + 1];
  }
  return mean_centre * row[0] + mean_other * (sum + other);
}

int softsoil_defaults(softsoil_options_t *options) {
  static const softsoil_options_t declared = {
      {692200.0, 13200.0, 4140.0, 0.2269, 0.01, 200000000.0, 30000.0, 0.7038, 0.528, 0.0, -0.2, 0.934, 1.0, 0.901, -0.145, 0.965, 0.953, 0.095, 23.0}, {0.02, 0.02, 0.002, 0.04, 0.015, 0.05, 0.003}, {0.05, 0.05, 0.003, 0.05, 0.05, 0.005}, 6.0, 0.5, {1000.0, 1000.0, 2.0, 20.0, 20.0, 5.0, 1.0},
      12, 2, {0.0, 0.0, 0.0, 0.0, 0.015, 0.024}, {0.0, 0.0, 0.0, 0.0, 2.0, 3.0, 0.0}, 1.5,
      0.6, 0.02, 5.0, 2.6, 0.2, 0.03};
  if (!options) return SOFTSOIL_NULL_POINTER;
  *options = declared;
  return SOFTSOIL_OK;
}

static int positive(const double *values, int n, double least) {
  for (int i = 0; i < n; ++i)
    if (!isfinite(values[i]) || !(values[i] >= least) || values[i] > 1e9) return 0;
  return 1;
}

static int options_are_good(const softsoil_options_t *o) {
  for (int i = 0; i < SOFTSOIL_N_P; ++i)
    if (!isfinite(o->p[i])) return 0;
  return positive(o->q_std, N, 0.0) && positive(o->r_std, NY, 1e-9) && positive(o->max_std, N, 1e-9) && o->gate > 0.0 &&
         o->standstill_speed >= 0.0 && isfinite(o->standstill_speed) && o->gate_patience >= 0 &&
         o->gate_patience_rates >= 0 && positive(o->miss_std, NY, 0.0) && positive(o->kick_std, N, 0.0) && o->fastest > 0.0 &&
         positive(&o->run_in, 1, 0.0) && positive(&o->common_error, 1, 0.0) && positive(&o->change_after, 1, 1e-3) &&
         o->change_sigmas > 0.0 && positive(&o->change_std, 1, 0.0) && positive(&o->change_error, 1, 0.0);
}

int softsoil_init(softsoil_t *s, const softsoil_options_t *options, const double x0[SOFTSOIL_N_X],
                  const double std0[SOFTSOIL_N_X], double t) {
  static const double first[N] = {0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.5}, first_std[N] = {0.05, 0.05, 0.003, 0.05, 0.05, 0.005, 0.3};
  static const double first_u[SOFTSOIL_N_U] = {0.0, 0.0, 0.0, 15.0, 15.0, 15.0, 15.0};
  softsoil_options_t chosen;
  if (!s) return SOFTSOIL_NULL_POINTER;
  softsoil_defaults(&chosen);
  if (options) chosen = *options;
  memset(s, 0, sizeof *s);
  if (!options_are_good(&chosen)) return SOFTSOIL_BAD_ARGUMENT;
  if (!isfinite(t)) return SOFTSOIL_TIME_NOT_FINITE;
  s->options = chosen;
  s->t = t;
  s->last_dt = SOFTSOIL_STEP;
  s->consistency = s->soil_consistency = 1.0;
  for (int i = 0; i < N; ++i) {
    const double at = x0 ? x0[i] : first[i], std = std0 ? std0[i] : first_std[i];
    if (!isfinite(at) || fabs(at) > 1e9 || !isfinite(std) || !(std > 0.0) || std > 1e9) return SOFTSOIL_BAD_ARGUMENT;
    s->x[i] = clipped(at, i);
    s->std[i] = std;
  }
  s->x[SOFTSOIL_X_psi] = wrapped(s->x[SOFTSOIL_X_psi]);
  for (int i = 0; i < N; ++i) s->root[i][i] = s->std[softsoil_order[i]];
  for (int i = 0; i < SOFTSOIL_N_U; ++i) s->u[i] = s->u_full[i] = first_u[i];
  for (int i = 0; i < NY; ++i) s->t_y[i] = -HUGE_VAL;
  /* Twice the time: the first seconds are convergence from the first guess, not a change. */
  forget_soil(s, 2.0 * s->options.change_after);
  s->run_in_to = t + s->options.run_in;
  forget_drift(s);
  settle(s);
  s->magic = MAGIC;
  return SOFTSOIL_OK;
}

/* Inputs that can be used, in place of those that cannot; a status. */
static int take_inputs(softsoil_t *s, const double *u) {
  int status = SOFTSOIL_OK;
  for (int i = 0; i < SOFTSOIL_N_U; ++i) {
    if (!isfinite(u[i])) {
      status = graver(status, count(s, SOFTSOIL_INPUT_NOT_FINITE));
    } else if (fabs(u[i]) > u_limit[i]) {
      status = graver(status, count(s, SOFTSOIL_INPUT_OUT_OF_RANGE));
    } else {
      s->u[i] = u[i];
    }
  }
  return status;
}

/* Whether the road wheels steer faster than an actuator, or inputs are unknown: no step of the model. */
static int kicked(const softsoil_t *s) {
  return fabs(s->u[SOFTSOIL_U_steer_rate]) > s->options.fastest || s->missing > held_inputs + CLOCK_SLACK;
}

/* Noise of the process over dt, into the rows of A from `row` on; more of it while histories or a kick of the steering are none
 * of the model's. The soil rests where it is held. */
static int add_noise(const softsoil_t *s, double dt, int hold, double (*a)[WIDE], int row) {
  const int kicks = !hold && (s->t < s->run_in_to - CLOCK_SLACK || kicked(s));
  for (int i = 0; i < N; ++i) {
    const int at = softsoil_order[i];
    if (hold && is_soil[at]) continue;
    const double still = s->options.q_std[at], kick = kicks ? s->options.kick_std[at] : 0.0;
    for (int j = 0; j < WIDE; ++j) a[row][j] = 0.0;
    a[row++][i] = sqrt((still * still + kick * kick) * dt);
  }
  return row;
}

/* Variances of states that jumped (`fresh`: in place of what was known of them) or opened (beside it). */
static void open_states(softsoil_t *s, const double more[N], int fresh) {
  double a[2 * N][WIDE] = {{0.0}};
  int rows = N;
  for (int i = 0; i < N; ++i) {
    const double variance = more[softsoil_order[i]];
    for (int j = 0; j < N; ++j) a[j][i] = fresh && variance > 0.0 ? 0.0 : s->root[i][j];
    if (variance > 0.0) a[rows++][i] = sqrt(variance);
  }
  triangularise(a, rows, s->root);
  settle(s);
}

/* What was known of the soil state `at` counts again: a measurement of it, with this variance. */
static void know_again(softsoil_t *s, int at, double value, double variance) {
  double a[N + 1][WIDE] = {{0.0}}, gain[N], own[N] = {0.0}, known = variance;
  for (int i = 0; i < N; ++i)
    if (softsoil_order[i] == at) memcpy(own, s->root[i], sizeof own);
  for (int k = 0; k < N; ++k) known += own[k] * own[k];
  const double away = value - s->x[at];
  for (int i = 0; i < N; ++i) {
    double sum = 0.0;
    for (int k = 0; k <= i; ++k) sum += s->root[i][k] * own[k];
    gain[i] = sum / known;
    for (int k = 0; k < N; ++k) a[k][i] = s->root[i][k] - gain[i] * own[k];
    a[N][i] = gain[i] * sqrt(variance);
    s->x[softsoil_order[i]] = clipped(s->x[softsoil_order[i]] + gain[i] * away, softsoil_order[i]);
  }
  triangularise(a, N + 1, s->root);
  s->x[SOFTSOIL_X_psi] = wrapped(s->x[SOFTSOIL_X_psi]);
}

/* What was known of n before a jump counts again, which the seconds after it did not bear out. */
static void take_back(softsoil_t *s, const double again[SOFTSOIL_N_SOIL]) {
  for (int i = 0; i < SOFTSOIL_N_SOIL; ++i) {
    double more[N] = {0.0};
    if (!(again[i] > 0.0)) continue;
    more[softsoil_soil[i]] = s->options.change_error * s->options.change_error;
    open_states(s, more, 0);
    know_again(s, softsoil_soil[i], s->trial_n[i], again[i]);
  }
  settle(s);
}

/* Nothing is NaN, infinite, or so large that its square might be. n is a multiple of 8. */
static int all_moderate(const double *values, int n) {
  double others[8] = {0.0};
  for (int i = 0; i < n; i += 8)
    for (int j = 0; j < 8; ++j) others[j] += fabs(values[i + j]) < 1e100 ? 0.0 : 1.0;
  return !(((others[0] + others[1]) + (others[2] + others[3])) + ((others[4] + others[5]) + (others[6] + others[7])) > 0.0);
}

/* The vehicle stands, crawls or reverses: the soil is held and no force is evaluated. Where the wheels turn it rolls as a kinematic
 * bicycle: v and omega_z go to those of wheels that do not slip, u follows the commanded acceleration; else the place is held and
 * the velocities go to zero. */
static void stand(softsoil_t *s, double dt) {
  static const double l_f = 1.546, l_r = 1.175, lock = 0.47;
  double a[2 * N][WIDE] = {{0.0}}, d[N], *x = s->x;
  const double keep = exp(-dt / 0.1), asked = s->u[SOFTSOIL_U_steer];
  const double steer = asked < -lock ? -lock : asked > lock ? lock : asked;
  const double sine = sin(x[SOFTSOIL_X_psi]), cosine = cos(x[SOFTSOIL_X_psi]);
  const double v_axle = x[SOFTSOIL_X_v] + l_f * x[SOFTSOIL_X_omega_z];
  const double ahead = x[SOFTSOIL_X_u] * cosine - v_axle * sine, left = x[SOFTSOIL_X_u] * sine + v_axle * cosine;
  int turning = 0;
  turning = turning || fabs(s->u[SOFTSOIL_U_omega_fl]) > 0.5;
  turning = turning || fabs(s->u[SOFTSOIL_U_omega_fr]) > 0.5;
  turning = turning || fabs(s->u[SOFTSOIL_U_omega_rl]) > 0.5;
  turning = turning || fabs(s->u[SOFTSOIL_U_omega_rr]) > 0.5;
  const double own = turning ? 1.0 : keep, go = turning ? dt : 0.0;
  const double to_turn = turning ? (1.0 - keep) * tan(steer) / (l_f + l_r) : 0.0, to_v = l_r * to_turn;
  /* Deviations go as the states' derivatives say. */
  for (int j = 0; j < N; ++j) {
    for (int i = 0; i < N; ++i) d[softsoil_order[i]] = s->root[i][j];
    const double d_axle = d[SOFTSOIL_X_v] + l_f * d[SOFTSOIL_X_omega_z], d_u = d[SOFTSOIL_X_u];
    d[SOFTSOIL_X_x] += go * (d_u * cosine - d_axle * sine - left * d[SOFTSOIL_X_psi]);
    d[SOFTSOIL_X_y] += go * (d_u * sine + d_axle * cosine + ahead * d[SOFTSOIL_X_psi]);
    d[SOFTSOIL_X_psi] += go * d[SOFTSOIL_X_omega_z];
    d[SOFTSOIL_X_v] = keep * d[SOFTSOIL_X_v] + to_v * d_u;
    d[SOFTSOIL_X_omega_z] = keep * d[SOFTSOIL_X_omega_z] + to_turn * d_u;
    d[SOFTSOIL_X_u] = own * d_u;
    for (int i = 0; i < N; ++i) a[j][i] = d[softsoil_order[i]];
  }
  x[SOFTSOIL_X_x] += go * ahead;
  x[SOFTSOIL_X_y] += go * left;
  x[SOFTSOIL_X_psi] += go * x[SOFTSOIL_X_omega_z];
  x[SOFTSOIL_X_v] = keep * x[SOFTSOIL_X_v] + to_v * x[SOFTSOIL_X_u];
  x[SOFTSOIL_X_omega_z] = keep * x[SOFTSOIL_X_omega_z] + to_turn * x[SOFTSOIL_X_u];
  x[SOFTSOIL_X_u] = own * x[SOFTSOIL_X_u] + go * s->u[SOFTSOIL_U_a_x];
  if (SOFTSOIL_N_M == 0) memcpy(s->u_full, s->u, sizeof s->u);
  triangularise(a, add_noise(s, dt, 1, a, N), s->root);
}

/* One step of the model for all sigma points. 0 where the model has no usable answer; the filter is then unchanged. */
static int move(softsoil_t *s, double dt) {
  static const double ceiling[N] = {1000.0, 1000.0, 2.0, 20.0, 20.0, 5.0, 1.0};
  softsoil_points_t x[N], inside[N], rates[N];
  softsoil_forces_t forces;
  double a[SOFTSOIL_POINTS + N][WIDE] = {{0.0}}, mean[WIDE] = {0.0};
  /* Forces are evaluated inside the bounds, what they do is added to the points as they are: n loses no variance at a bound. */
  sigma_points(s, 0, x);
  for (int i = 0; i < N; ++i)
    for (int k = 0; k < SOFTSOIL_ROW; ++k) inside[i][k] = clipped(x[i][k], i);
  if (SOFTSOIL_N_M > 0) {
    softsoil_model_read(s->x, s->u, s->options.p, s->m, s->u_full);
  } else {
    memcpy(s->u_full, s->u, sizeof s->u);
  }
  softsoil_model_forces((const softsoil_points_t *)inside, s->u_full, s->options.p, &forces);
  softsoil_model_rates((const softsoil_points_t *)inside, s->u_full, s->options.p, &forces, rates);
  for (int i = 0; i < N; ++i) {
    const int at = softsoil_order[i];
    for (int k = 0; k < SOFTSOIL_ROW; ++k) x[at][k] += dt * rates[at][k];
    mean[i] = mean_of(x[at]);
    a[0][i] = root_centre * (x[at][0] - mean[i]);
    for (int k = 1; k < SOFTSOIL_POINTS; ++k) a[k][i] = root_other * (x[at][k] - mean[i]);
  }
  if (!all_moderate(&a[0][0], SOFTSOIL_POINTS * WIDE) || !all_moderate(mean, WIDE)) return 0;
  /* No vehicle leaps so far in a step: the equations diverge. */
  for (int i = 0; i < N; ++i)
    if (fabs(mean[i] - s->x[softsoil_order[i]]) > 10.0 * ceiling[softsoil_order[i]]) return 0;
  if (SOFTSOIL_N_M > 0) softsoil_model_advance(s->x, s->u_full, s->options.p, s->m, dt, &forces);
  for (int i = 0; i < N; ++i) s->x[softsoil_order[i]] = clipped(mean[i], softsoil_order[i]);
  triangularise(a, add_noise(s, dt, 0, a, SOFTSOIL_POINTS), s->root);
  return 1;
}

static int check_dt(double dt) {
  if (!isfinite(dt)) return SOFTSOIL_DT_NOT_FINITE;
  if (dt < 0.0) return SOFTSOIL_DT_NEGATIVE;
  if (!(dt > 0.0)) return SOFTSOIL_DT_ZERO;
  return dt > SOFTSOIL_MAX_DT ? SOFTSOIL_DT_TOO_LONG : SOFTSOIL_OK;
}

int softsoil_predict(softsoil_t *s, const double u[SOFTSOIL_N_U], double dt) {
  if (!s || !u) return SOFTSOIL_NULL_POINTER;
  if (s->magic != MAGIC) return SOFTSOIL_NOT_INITIALISED;
  const int bad = check_dt(dt);
  if (bad) return count(s, bad);
  int status = take_inputs(s, u);
  s->missing = status == SOFTSOIL_OK ? 0.0 : s->missing + dt;
  if (!s->started) {
    if (SOFTSOIL_N_M > 0) softsoil_model_start(s->x, s->u, s->options.p, s->m);
    s->started = 1;
  }
  const double parts = ceil(dt / SOFTSOIL_MAX_STEP - CLOCK_SLACK);
  const int steps = parts > 1.0 ? (int)parts : 1;
  s->flags = 0;
  for (int k = 0; k < steps; ++k) {
    s->standstill = s->reversing || s->x[SOFTSOIL_X_u] < s->options.standstill_speed;
    if (s->standstill) {
      stand(s, dt / steps);
      status = graver(status, count(s, SOFTSOIL_STANDSTILL));
    } else if (!move(s, dt / steps)) {
      stand(s, dt / steps);
      status = graver(status, count(s, SOFTSOIL_NUMERICAL));
    }
    stay_finite(s);
    settle(s);
  }
  if (s->standstill) {
    s->flags |= SOFTSOIL_FLAG_STANDING;
    wait_standing(s, dt);
  }
  s->x[SOFTSOIL_X_psi] = wrapped(s->x[SOFTSOIL_X_psi]);
  s->t += dt;
  if (s->missing > held_inputs + CLOCK_SLACK) wait_for_drift(s);
  s->last_dt = dt;
  ++s->predictions;
  return status;
}

/* Which measurements may be used, and what is wrong with the others. */
static int screen(softsoil_t *s, const double *y, const unsigned char *valid, double t, int32_t *use) {
  int status = SOFTSOIL_OK, some = 0;
  for (int i = 0; i < NY; ++i) {
    int found = SOFTSOIL_OK;
    use[i] = 0;
    if (valid && !valid[i]) continue;
    if (!isfinite(y[i])) {
      found = SOFTSOIL_MEASUREMENT_NOT_FINITE;
    } else if (fabs(y[i]) > y_limit[i]) {
      found = SOFTSOIL_MEASUREMENT_OUT_OF_RANGE;
    } else if (t <= s->t_y[i]) {
      found = SOFTSOIL_MEASUREMENT_REPEATED;
    } else if (i == SOFTSOIL_Y_u && y[i] < -s->options.standstill_speed) {
      found = SOFTSOIL_NEGATIVE_SPEED;
    }
    if (i == SOFTSOIL_Y_u && (found == SOFTSOIL_OK || found == SOFTSOIL_NEGATIVE_SPEED))
      s->reversing = found == SOFTSOIL_NEGATIVE_SPEED;
    if (found) status = graver(status, count(s, found));
    use[i] = found == SOFTSOIL_OK || found == SOFTSOIL_NEGATIVE_SPEED;
    some |= use[i];
  }
  if (!some) status = graver(status, count(s, SOFTSOIL_NO_MEASUREMENT));
  return status;
}

/* What the sigma points predict of the measurements. */
typedef struct {
  double dx[SOFTSOIL_POINTS][WIDE]; /* weighted deviations, states in the library's order */
  double dy[SOFTSOIL_POINTS][WIDE_Y];
  double s[NY][WIDE_Y]; /* innovation covariance */
} softsoil_prediction_t;

/* Of a measurement about what a right model says of it: the sensor's noise and what the model misses. */
static double output_variance(const softsoil_t *s, int i) {
  return s->options.r_std[i] * s->options.r_std[i] + s->options.miss_std[i] * s->options.miss_std[i];
}

static int predict_measurement(softsoil_t *s, const double *y, softsoil_prediction_t *out) {
  softsoil_points_t x[N], seen[NY];
  memset(out, 0, sizeof *out);
  sigma_points(s, SOFTSOIL_MEASURES_FORCES, x);
  const softsoil_forces_t *known = NULL;
#if SOFTSOIL_MEASURES_FORCES
  softsoil_forces_t forces;
  softsoil_model_forces((const softsoil_points_t *)x, s->u_full, s->options.p, &forces);
  known = &forces;
#endif
  softsoil_model_measure((const softsoil_points_t *)x, s->u_full, s->options.p, known, seen);
  for (int i = 0; i < N; ++i) {
    const double *row = x[softsoil_order[i]], mean = mean_of(row);
    out->dx[0][i] = root_centre * (row[0] - mean);
    for (int k = 1; k < SOFTSOIL_POINTS; ++k) out->dx[k][i] = root_other * (row[k] - mean);
  }
  for (int i = 0; i < NY; ++i) {
    const double mean = mean_of(seen[i]), away = y[i] - mean;
    s->innovation[i] = y_wraps[i] ? wrapped(away) : away;
    out->dy[0][i] = root_centre * (seen[i][0] - mean);
    for (int k = 1; k < SOFTSOIL_POINTS; ++k) out->dy[k][i] = root_other * (seen[i][k] - mean);
  }
  for (int i = 0; i < NY; ++i) {
    double row[WIDE_Y] = {0.0};
    for (int k = 0; k < SOFTSOIL_POINTS; ++k) {
      const double dy = out->dy[k][i];
      for (int j = 0; j < WIDE_Y; ++j) row[j] += dy * out->dy[k][j];
    }
    memcpy(out->s[i], row, sizeof row);
    out->s[i][i] += output_variance(s, i);
    s->innovation_std[i] = sqrt(out->s[i][i]);
  }
  return all_moderate(&out->s[0][0], NY * WIDE_Y) && all_moderate(&out->dx[0][0], SOFTSOIL_POINTS * WIDE);
}

/* Each measurement against the gate. One that has been outside it for as long as the patience lasts is believed: its state is
 * to move by `away` to where it is, with the variance `fresh` (returns 1). */
static int gate(softsoil_t *s, int32_t *use, double away[N], double fresh[N], int *status) {
  int jumped = 0;
  for (int i = 0; i < NY; ++i) {
    if (!use[i]) continue;
    if (fabs(s->innovation[i]) <= s->options.gate * s->innovation_std[i]) {
      s->gated_run[i] = 0;
      continue;
    }
    use[i] = 0;
    s->flags |= SOFTSOIL_FLAG_GATED;
    *status = graver(*status, count(s, SOFTSOIL_MEASUREMENT_GATED));
    if (!is_a_jump(s, i)) continue;
    s->flags |= SOFTSOIL_FLAG_JUMPED;
    *status = graver(*status, count(s, SOFTSOIL_GATE_REOPENED));
    if (softsoil_measured[i] < 0) continue;
    away[softsoil_measured[i]] = s->innovation[i];
    fresh[softsoil_measured[i]] = output_variance(s, i);
    jumped = 1;
  }
  return jumped;
}

/* Gain, estimate and factor from the measurements in use; the soil is not touched where `hold`. */
static void correct(softsoil_t *s, const softsoil_prediction_t *z, const int32_t *use, int hold) {
  double chol[NY][NY], gain[NY][WIDE] = {{0.0}}, a[SOFTSOIL_POINTS + NY][WIDE], scaled[NY], step[WIDE] = {0.0};
  int at[NY], n = 0;
  for (int i = 0; i < NY; ++i)
    if (use[i]) at[n++] = i;
  s->nis = 0.0;
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) {
      double sum = z->s[at[i]][at[j]];
      for (int k = 0; k < j; ++k) sum -= chol[i][k] * chol[j][k];
      /* S >= R > 0: only rounding can take a pivot below its measurement noise. */
      const double least = 1e-14 * z->s[at[j]][at[j]];
      chol[i][j] = i > j ? sum / chol[j][j] : sqrt(sum > least ? sum : least);
    }
    double sum = s->innovation[at[j]];
    for (int k = 0; k < j; ++k) sum -= chol[j][k] * scaled[k];
    scaled[j] = sum / chol[j][j];
    s->nis += scaled[j] * scaled[j];
  }
  /* K S = P_xy, column after column of S's factor, all states side by side. */
  for (int i = 0; i < n; ++i) {
    double row[WIDE] = {0.0};
    for (int k = 0; k < SOFTSOIL_POINTS; ++k) {
      const double dy = z->dy[k][at[i]];
      for (int j = 0; j < WIDE; ++j) row[j] += z->dx[k][j] * dy;
    }
    memcpy(gain[i], row, sizeof row);
  }
  for (int i = 0; i < n; ++i) {
    const double inverse = 1.0 / chol[i][i];
    for (int k = 0; k < i; ++k)
      for (int j = 0; j < WIDE; ++j) gain[i][j] -= gain[k][j] * chol[i][k];
    for (int j = 0; j < WIDE; ++j) gain[i][j] *= inverse;
  }
  for (int i = n - 1; i >= 0; --i) {
    const double inverse = 1.0 / chol[i][i];
    for (int k = i + 1; k < n; ++k)
      for (int j = 0; j < WIDE; ++j) gain[i][j] -= gain[k][j] * chol[k][i];
    for (int j = 0; j < WIDE; ++j) gain[i][j] *= inverse;
  }
  for (int j = 0; hold && j < N; ++j)
    for (int i = 0; i < n && is_soil[softsoil_order[j]]; ++i) gain[i][j] = 0.0;
  for (int k = 0; k < SOFTSOIL_POINTS; ++k) {
    double row[WIDE];
    memcpy(row, z->dx[k], sizeof row);
    for (int i = 0; i < n; ++i) {
      const double dy = z->dy[k][at[i]];
      for (int j = 0; j < WIDE; ++j) row[j] -= gain[i][j] * dy;
    }
    memcpy(a[k], row, sizeof row);
  }
  for (int i = 0; i < n; ++i) {
    const double r = sqrt(output_variance(s, at[i]));
    for (int j = 0; j < WIDE; ++j) {
      a[SOFTSOIL_POINTS + i][j] = gain[i][j] * r;
      step[j] += gain[i][j] * s->innovation[at[i]];
    }
  }
  for (int j = 0; j < N; ++j) {
    const int state = softsoil_order[j];
    s->x[state] = clipped(s->x[state] + step[j], state);
  }
  triangularise(a, SOFTSOIL_POINTS + n, s->root);
  s->dof = n;
}

/* Running means of the normalised innovations: over all measurements, and over those that tell of the soil. */
static void watch(softsoil_t *s) {
  double sum = 0.0;
  int driven = 0;
  s->since += s->since < WINDOW;
  s->consistency += (s->nis / s->dof - s->consistency) / s->since;
  for (int i = 0; i < NY; ++i) {
    if (!s->used[i] || !y_driven[i]) continue;
    const double ratio = s->innovation[i] / s->innovation_std[i];
    sum += ratio * ratio;
    ++driven;
  }
  if (driven > 0) s->soil_consistency += (sum / driven - s->soil_consistency) / s->since;
}

static int check_time(const softsoil_t *s, double t) {
  if (!isfinite(t)) return SOFTSOIL_TIME_NOT_FINITE;
  /* Clocks that count in steps differ by rounding. */
  const double slack = 1e-6 + 1e-12 * fabs(t);
  if (t < s->t - s->last_dt - slack) return SOFTSOIL_MEASUREMENT_LATE;
  return t > s->t + s->last_dt + slack ? SOFTSOIL_MEASUREMENT_EARLY : SOFTSOIL_OK;
}

int softsoil_update(softsoil_t *s, const double y[SOFTSOIL_N_Y], const unsigned char valid[SOFTSOIL_N_Y], double t) {
  softsoil_prediction_t z;
  int32_t use[NY];
  double safe[NY], before[N], away[N] = {0.0}, more[N] = {0.0};
  double score[SOFTSOIL_N_SOIL] = {0.0}, information[SOFTSOIL_N_SOIL] = {0.0}, again[SOFTSOIL_N_SOIL];
  int32_t some = 0;
  if (!s || !y) return SOFTSOIL_NULL_POINTER;
  if (s->magic != MAGIC) return SOFTSOIL_NOT_INITIALISED;
  const int bad = check_time(s, t);
  if (bad) return count(s, bad);
  int status = screen(s, y, valid, t, use);
  s->dof = 0;
  s->nis = 0.0;
  for (int i = 0; i < NY; ++i) {
    s->used[i] = 0;
    s->innovation[i] = 0.0;
    safe[i] = use[i] ? y[i] : 0.0;
    some |= use[i];
  }
  const int hold = s->standstill || s->reversing;
  s->flags = hold ? SOFTSOIL_FLAG_STANDING : 0;
  if (!some) return status;
  if (!predict_measurement(s, safe, &z)) return graver(status, count(s, SOFTSOIL_NUMERICAL));
  const int jumped = gate(s, use, away, more, &status);
  memcpy(before, s->x, sizeof before);
  if (!hold && !kicked(s)) evidence_of_soil(s, softsoil_order, use, score, information);
  correct(s, &z, use, hold);
  /* What is corrected while the steering kicks is no drift: velocities follow their sensors. */
  if (s->dof > 0 && !hold && !kicked(s) && drifts(s, before)) {
    s->flags |= SOFTSOIL_FLAG_DRIFT;
    status = graver(status, count(s, SOFTSOIL_DRIFT));
  }
  for (int i = 0; jumped && i < N; ++i) s->x[i] = clipped(s->x[i] + away[i], i);
  stay_finite(s);
  s->x[SOFTSOIL_X_psi] = wrapped(s->x[SOFTSOIL_X_psi]);
  settle(s);
  if (jumped) open_states(s, more, 1);
  if (s->dof > 0 && !hold) {
    memset(more, 0, sizeof more);
    if (jump_is_revoked(s, softsoil_order, again)) {
      take_back(s, again);
      s->flags |= SOFTSOIL_FLAG_SOIL_KEPT;
      status = graver(status, count(s, SOFTSOIL_SOIL_KEPT));
    } else if (soil_has_changed(s, softsoil_order, score, information, lower, upper, more)) {
      open_states(s, more, 0);
      s->flags |= SOFTSOIL_FLAG_SOIL_CHANGED;
      status = graver(status, count(s, SOFTSOIL_SOIL_CHANGED));
    }
  }
  for (int i = 0; i < NY; ++i) {
    s->used[i] = use[i];
    if (use[i]) s->t_y[i] = t;
    if (!use[i]) s->innovation[i] = 0.0;
  }
  if (s->dof > 0) {
    watch(s);
    if (s->since == WINDOW && (s->consistency > 1.3 || s->soil_consistency > 1.35))
      status = graver(status, count(s, SOFTSOIL_INCONSISTENT));
  }
  ++s->updates;
  return status;
}

int softsoil_restart(softsoil_t *s, const double y[SOFTSOIL_N_Y], const unsigned char valid[SOFTSOIL_N_Y], double t) {
  static const double first_std[N] = {1.0, 1.0, 0.1, 1.0, 0.5, 0.2, 0.3}; /* of what is not measured */
  int32_t use[NY];
  if (!s || !y) return SOFTSOIL_NULL_POINTER;
  if (s->magic != MAGIC) return SOFTSOIL_NOT_INITIALISED;
  if (!isfinite(t)) return count(s, SOFTSOIL_TIME_NOT_FINITE);
  for (int i = 0; i < NY; ++i) s->t_y[i] = -HUGE_VAL;
  const int status = screen(s, y, valid, t, use);
  for (int i = 0; i < N; ++i) {
    const int at = softsoil_order[i];
    double std = 0.0;
    for (int j = 0; j <= i; ++j) std += s->root[i][j] * s->root[i][j];
    std = sqrt(std); /* of n without the common error */
    if (!is_soil[at]) std = s->options.max_std[at] < first_std[at] ? s->options.max_std[at] : first_std[at];
    for (int k = 0; k < NY; ++k)
      if (use[k] && softsoil_measured[k] == at) {
        s->x[at] = clipped(y[k], at);
        std = s->options.r_std[k];
      }
    for (int j = 0; j < N; ++j) s->root[i][j] = i == j ? std : 0.0;
  }
  for (int i = 0; i < NY; ++i) {
    if (use[i]) s->t_y[i] = t;
    s->gated_run[i] = 0;
  }
  s->x[SOFTSOIL_X_psi] = wrapped(s->x[SOFTSOIL_X_psi]);
  s->t = t;
  s->missing = 0.0;
  s->started = 0;
  s->since = 0;
  forget_soil(s, s->options.change_after);
  memset(s->trial_variance, 0, sizeof s->trial_variance); /* what was known before a jump is of another clock */
  s->flags = 0;
  s->run_in_to = t + s->options.run_in;
  forget_drift(s);
  s->consistency = s->soil_consistency = 1.0;
  settle(s);
  return status;
}

int softsoil_replay(softsoil_t *s, size_t rows, const double *t, const double *u, const double *y, size_t every, double *x,
                    double *std, double *nis, int32_t *dof) {
  if (!s || !t || !u || !y) return SOFTSOIL_NULL_POINTER;
  if (s->magic != MAGIC) return SOFTSOIL_NOT_INITIALISED;
  if (rows == 0 || every == 0) return SOFTSOIL_BAD_ARGUMENT;
  int status = SOFTSOIL_OK;
  double kept[NY]; /* what rows without an update measured counts at the next one */
  for (int i = 0; i < NY; ++i) kept[i] = NAN;
  for (size_t k = 0; k < rows; ++k) {
    if (k > 0) status = graver(status, softsoil_predict(s, u + (k - 1) * SOFTSOIL_N_U, t[k] - s->t));
    for (int i = 0; k > 0 && i < NY; ++i)
      if (isfinite(y[k * NY + (size_t)i])) kept[i] = y[k * NY + (size_t)i];
    if (k > 0 && k % every == 0) {
      status = graver(status, softsoil_update(s, kept, NULL, t[k]));
      for (int i = 0; i < NY; ++i) kept[i] = NAN;
    } else {
      s->dof = 0;
    }
    if (x) memcpy(x + k * N, s->x, sizeof s->x);
    if (std) memcpy(std + k * N, s->std, sizeof s->std);
    if (nis) nis[k] = s->dof > 0 ? s->nis : 0.0;
    if (dof) dof[k] = s->dof;
  }
  return status;
}

int softsoil_covariance(const softsoil_t *s, double *covariance) {
  if (!s || !covariance) return SOFTSOIL_NULL_POINTER;
  if (s->magic != MAGIC) return SOFTSOIL_NOT_INITIALISED;
  for (int i = 0; i < N; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (int k = 0; k <= j; ++k) sum += s->root[i][k] * s->root[j][k];
      covariance[softsoil_order[i] * N + softsoil_order[j]] = sum;
      covariance[softsoil_order[j] * N + softsoil_order[i]] = sum;
    }
  return SOFTSOIL_OK;
}
