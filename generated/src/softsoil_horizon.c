/* The moving horizon: samples in, windows reduced to quadratics of the soil's parameters, their sum minimised. */
#include <math.h>
#include <string.h>

#include "softsoil_model.h"

#define K SOFTSOIL_HORIZON_N
#define NS SOFTSOIL_HORIZON_STATES
/* What a window is asked: the parameters and, where jobs are free for them, the share by which the yaw inertia is larger, and the
 * shares by which the lateral forces of the axles are: of each, or of both alike. */
#define Q SOFTSOIL_HORIZON_ASKED
#define ASKS_INERTIA 1
#define FORCES 2
#define QI (K + ASKS_INERTIA)
#define D (NS + Q)
#define CARRIED SOFTSOIL_HORIZON_CARRIED
#define OTHERS (CARRIED - SOFTSOIL_N_M) /* states carried */
#define CELLS SOFTSOIL_HORIZON_CELLS
#define ROWS SOFTSOIL_HORIZON_ROWS
#define WINDOWS SOFTSOIL_HORIZON_WINDOWS
#define KEPT SOFTSOIL_HORIZON_KEPT
#define LONGEST_WINDOW 105 /* samples */
#define MAGIC SOFTSOIL_HORIZON_MAGIC

typedef softsoil_horizon_window_t window_t;

/* Numbers of the horizon, as HorizonRules of the Python class. */
static const double stride = 0.5, window_length = 1.0, run_in = 2.5, linearised_again = 10.0;
static const double forgetting = 60.0, longest = 120.0, common_error = 0.02;
static const double flat_error = 0.02, law_error = 0.01; /* of any n, in common_error too; of an axle's force */
static const double stale = 0.1, change = 4.0, least_change = 0.12;
static const double fastest = 1.5, slowest = 0.5, settling = 0.1, smoothing = 0.25;
static const double bridged = 2.0, held = 0.25;
static const double slowest_step = 0.0135, fine_step = 0.0125, longest_step = 0.015;
static const double huber = 3.0, ridge = 1e-06, least_curvature = 1e-09;
static const double trimmed = 4.0;
enum { RECENTS = 3 };
static const int recents[RECENTS] = {4, 8, 16};
static const double state_step[NS] = {0.0001, 0.0001, 1e-05, 0.0001, 0.0001, 1e-05};
static const double free_step = 5e-06, inertia_step = 1e-3, force_step = 1e-3;
static const double to_front = 1.546, to_rear = 1.175, gyration_2 = 1.340752940152; /* m, m, m^2: inertia over mass */
/* The parameters: their states, scales, bounds, and which of them are a soil's. */
static const int at_state[K] = {SOFTSOIL_X_n};
static const int is_soil[K] = {1};
static const double scale[K] = {0.1}, lowest[K] = {0.2}, highest[K] = {1.6};
/* Column of each initial state's job, and of each parameter's. */
static const int state_column[NS] = {8, 9, 10, 1, 2, 3};
static const int free_column[K] = {4};
enum { INERTIA_COLUMN = 5, FORCE_COLUMN = INERTIA_COLUMN + ASKS_INERTIA };
enum { ACTIVE = 8, PASSIVE = 3 };
static const int other_state[SOFTSOIL_SOME(OTHERS)] = {0};
static const double nominal[SOFTSOIL_N_X] = {0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.5};
static const double u_limit[SOFTSOIL_N_U] = {1.6, 1000.0, 200.0, 1000.0, 1000.0, 1000.0, 1000.0};
static const double y_limit[SOFTSOIL_N_Y] = {100000000.0, 100000000.0, 100000.0, 150.0, 150.0, 50.0};
static const int32_t y_wraps[SOFTSOIL_N_Y] = {0, 0, 1, 0, 0, 0};
/* Limits of the verdict, as VerdictRules. */
static const double most_std = 0.05, most_law_std = 0.04, same = 0.1, bound = 0.02, axles = 0.13, axles_sigmas = 2.5;
static const double most_unexplained[2] = {0.1, 0.022}, least_motion = 0.2;
static const double unexplained_sigmas = 2.0;
static const double most_inertia = 0.12, inertia_sigmas = 3.0, most_inertia_std = 0.2;
static const double stated_inertia = 0.0; /* by which an identified one may be off by its own error */
static const double most_parts = 0.1, most_parts_sigmas = 2.5;
enum { SPLITS = 3, LEAST_PART = 4 };
static const double splits[SPLITS] = {0.3333333333333, 0.5, 0.6666666666667};
/* v and omega_z: by which a model is judged. */
static const int judged[2] = {SOFTSOIL_Y_v, SOFTSOIL_Y_omega_z};

const char *softsoil_verdict_text(int verdict) {
  switch (verdict) {
    case SOFTSOIL_VERDICT_NOT_EXCITED:
      return "the windows do not determine n, or a small error of the forces, or a load, may make it wrong: steer more, to and fro, at several speeds, longer";
    case SOFTSOIL_VERDICT_IDENTIFIED:
      return "the windows determine n, and the model leaves no more than a right one does";
    case SOFTSOIL_VERDICT_DEPENDS_ON_FIRST_GUESS:
      return "n depends on its initial guess: drive on";
    case SOFTSOIL_VERDICT_AT_BOUND:
      return "n is at a bound of its range: check soil and vehicle";
    case SOFTSOIL_VERDICT_AXLES_DISAGREE:
      return "front and rear axle disagree on n";
    case SOFTSOIL_VERDICT_INCONSISTENT:
      return "the windows contradict the model, the vehicle's numbers or one soil: check vehicle, soil and sensors";
    case SOFTSOIL_VERDICT_NO_SOIL:
      return "there is no soft soil";
    default:
      return "not a verdict of this library";
  }
}

size_t softsoil_horizon_size(void) { return sizeof(softsoil_horizon_t); }

static int count(softsoil_horizon_t *h, int status) {
  if (h->counts[status] < UINT32_MAX) ++h->counts[status];
  return status;
}

static int graver(int a, int b) { return a > b ? a : b; }

static softsoil_horizon_row_t *row_at(softsoil_horizon_t *h, int64_t row) { return &h->row[row % ROWS]; }

static window_t *window_at(softsoil_horizon_t *h, int64_t i) { return &h->window[i % WINDOWS]; }

static int64_t oldest_row(const softsoil_horizon_t *h) {
  return h->rows - ROWS > h->first_row ? h->rows - ROWS : h->first_row;
}

static double wrapped(double angle) { return angle - 6.283185307179586 * floor(angle / 6.283185307179586 + 0.5); }

static double between(double low, double value, double high) { return value < low ? low : value > high ? high : value; }

static double larger(double a, double b) { return a > b ? a : b; }

/* To the nearest whole number, halves to the even one. */
static int32_t nearest(double value) {
  const double low = floor(value), part = value - low;
  const int32_t whole = (int32_t)low;
  return part > 0.5 || (!(part < 0.5) && whole % 2) ? whole + 1 : whole;
}

int softsoil_invert(int n, const double *a, double *inverse, double *work) {
  double *l = work, *half = work + n * n;
  memset(work, 0, 2u * (size_t)(n * n) * sizeof *work);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) {
      double sum = a[i * n + j];
      for (int k = 0; k < j; ++k) sum -= l[i * n + k] * l[j * n + k];
      if (i == j) {
        if (!(sum > 0.0) || !isfinite(sum)) return 0;
        l[i * n + i] = sqrt(sum);
      } else {
        l[i * n + j] = sum / l[j * n + j];
      }
    }
  for (int i = 0; i < n; ++i) {
    half[i * n + i] = 1.0 / l[i * n + i];
    for (int j = 0; j < i; ++j) {
      double sum = 0.0;
      for (int k = j; k < i; ++k) sum += l[i * n + k] * half[k * n + j];
      half[i * n + j] = -sum / l[i * n + i];
    }
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      double sum = 0.0;
      for (int k = i > j ? i : j; k < n; ++k) sum += half[k * n + i] * half[k * n + j];
      inverse[i * n + j] = sum;
    }
  return 1;
}

/* The same of at most 6 x 6. */
static int invert(int n, const double *a, double *inverse) {
  double work[2 * 6 * 6];
  return softsoil_invert(n, a, inverse, work);
}

int softsoil_horizon_defaults(softsoil_horizon_options_t *options) {
  static const softsoil_horizon_options_t declared = {
      {692200.0, 13200.0, 4140.0, 0.2269, 0.01, 200000000.0, 30000.0, 0.7038, 0.528, 0.0, -0.2, 0.934, 1.0, 0.901, -0.145, 0.965, 0.953, 0.095, 23.0}, {0.05, 0.05, 0.003, 0.05, 0.05, 0.005}, {0.03, 0.03, 0.012, 0.02, 0.015, 0.024}, {0.5}, {0.3}, SOFTSOIL_STEP, 2.0, 1};
  if (!options) return SOFTSOIL_NULL_POINTER;
  *options = declared;
  return SOFTSOIL_OK;
}

static int options_are_good(const softsoil_horizon_options_t *o) {
  int good = o->dt >= SOFTSOIL_HORIZON_MIN_DT && o->dt <= SOFTSOIL_HORIZON_MAX_DT && o->start_up >= 0.0 && o->start_up < 1e6;
  for (int i = 0; i < SOFTSOIL_N_P; ++i) good = good && isfinite(o->p[i]);
  for (int i = 0; i < SOFTSOIL_N_Y; ++i)
    good = good && o->r_std[i] >= 0.0 && o->model_error[i] >= 0.0 && isfinite(o->model_error[i]) &&
           o->r_std[i] + o->model_error[i] > 1e-9;
  for (int k = 0; k < K; ++k)
    good = good && o->guess[k] >= lowest[k] && o->guess[k] <= highest[k] && o->guess_std[k] > 1e-9 && o->guess_std[k] < 1e9;
  return good && !SOFTSOIL_MEASURES_FORCES;
}

int softsoil_horizon_init(softsoil_horizon_t *h, const softsoil_horizon_options_t *options, double t) {
  static const double first_u[SOFTSOIL_N_U] = {0.0, 0.0, 0.0, 15.0, 15.0, 15.0, 15.0};
  softsoil_horizon_options_t chosen;
  if (!h) return SOFTSOIL_NULL_POINTER;
  softsoil_horizon_defaults(&chosen);
  if (options) chosen = *options;
  memset(h, 0, sizeof *h);
  if (!options_are_good(&chosen)) return SOFTSOIL_BAD_ARGUMENT;
  if (!isfinite(t)) return SOFTSOIL_TIME_NOT_FINITE;
  h->options = chosen;
  h->clock = t - chosen.dt;
  h->heard = t;
  h->doubt = -HUGE_VAL;
  h->t = h->changed_at = t;
  for (int i = 0; i < SOFTSOIL_N_U; ++i) h->inputs[i] = first_u[i];
  for (int i = 0; i < SOFTSOIL_N_Y; ++i) h->good_row[i] = -1;
  for (int k = 0; k < K; ++k) {
    h->n[k] = h->free_n[k] = h->centre[k] = chosen.guess[k];
    h->std[k] = chosen.guess_std[k];
    h->information_std[k] = 1e9;
  }
  for (int i = 0; i < 2; ++i) h->noise[i] = chosen.r_std[judged[i]] * chosen.r_std[judged[i]];
  h->unexplained_std[0] = h->unexplained_std[1] = 1e9;
  h->inertia_std = 1e9;
  h->verdict = SOFTSOIL_VERDICT_NOT_EXCITED;
  h->steps = nearest(window_length / chosen.dt) > 2 ? nearest(window_length / chosen.dt) : 2;
  h->apart = nearest(stride / chosen.dt) > 1 ? nearest(stride / chosen.dt) : 1;
  h->before = nearest(run_in / chosen.dt);
  h->after = nearest(settling / chosen.dt);
  h->bridged = nearest(bridged / chosen.dt);
  h->again = nearest(linearised_again / chosen.dt);
  h->half = nearest(smoothing / chosen.dt / 2.0) > 2 ? nearest(smoothing / chosen.dt / 2.0) : 2;
  h->fractions = chosen.dt > slowest_step ? 2 * (int32_t)ceil(chosen.dt / fine_step / 2.0 - 1e-9) : 1;
  const double part = chosen.dt / h->fractions;
  h->substeps = part > longest_step ? (int32_t)ceil(part / longest_step - 1e-9) : 1;
  h->next_row = (int64_t)ceil(chosen.start_up / chosen.dt - 1e-6);
  const double share = stride < window_length ? stride / window_length : 1.0;
  for (int i = 0; i < WINDOWS; ++i) h->weights[i] = i * stride > longest ? 0.0 : share * exp(-i * stride / forgetting);
  h->magic = MAGIC;
  return SOFTSOIL_OK;
}

/* A new row, with the last good inputs and nothing measured. */
static softsoil_horizon_row_t *new_row(softsoil_horizon_t *h) {
  softsoil_horizon_row_t *row = row_at(h, h->rows);
  memset(row, 0, sizeof *row);
  memcpy(row->u, h->inputs, sizeof row->u);
  for (int i = 0; i < SOFTSOIL_N_Y; ++i) row->y[i] = h->good_row[i] >= h->first_row ? h->good[i] : 0.0;
  ++h->rows;
  h->clock += h->options.dt;
  return row;
}

/* A measurement taken in; rows without it before are filled: in between by a straight line, at first by itself. */
static void fill(softsoil_horizon_t *h, int i, double value) {
  const int64_t row = h->rows - 1, last = h->good_row[i];
  const int known = last >= h->first_row;
  if (known && y_wraps[i]) value += 6.283185307179586 * floor((h->good[i] - value) / 6.283185307179586 + 0.5);
  const double slope = known ? (value - h->good[i]) / (double)(row - last) : 0.0;
  int64_t from = known ? last + 1 : h->first_row;
  if (from < row - ROWS + 1) from = row - ROWS + 1;
  for (int64_t k = from; k < row; ++k) row_at(h, k)->y[i] = known ? h->good[i] + slope * (double)(k - last) : value;
  row_at(h, row)->y[i] = value;
  row_at(h, row)->seen[i] = 1;
  h->good[i] = value;
  h->good_row[i] = row;
}

/* Noise of v and omega_z from third differences, their motion, and the lateral specific force, over about the forgetting time. */
static void watch(softsoil_horizon_t *h) {
  const double most = forgetting / h->options.dt;
  const softsoil_horizon_row_t *now = row_at(h, h->rows - 1);
  if (now->blocked) return;
  for (int j = 0; j < 2; ++j) {
    const int i = judged[j];
    if (!now->seen[i]) continue;
    const double share = 1.0 / (h->noise_count[j] < most ? h->noise_count[j] + 1.0 : most);
    h->square[j] += share * (now->y[i] * now->y[i] - h->square[j]);
    h->noise_count[j] += 1.0;
    double *own = h->own[j]; /* the three samples before, newest first: a channel may be slower than the rows */
    const double third = now->y[i] - 3.0 * own[0] + 3.0 * own[1] - own[2];
    if (h->own_count[j] >= 3.0 && fabs(third) < trimmed * sqrt(20.0 * h->noise[j]) + 1e-12)
      h->noise[j] += larger(share, 0.002) * (third * third / 20.0 - h->noise[j]);
    own[2] = own[1];
    own[1] = own[0];
    own[0] = now->y[i];
    h->own_count[j] += 1.0;
  }
  if (now->seen[SOFTSOIL_Y_u] && now->seen[SOFTSOIL_Y_omega_z]) {
    const double a_y = now->y[SOFTSOIL_Y_u] * now->y[SOFTSOIL_Y_omega_z];
    h->force_count += h->force_count < most ? 1.0 : 0.0;
    h->force += (a_y * a_y - h->force) / h->force_count;
  }
}

int softsoil_horizon_push(softsoil_horizon_t *h, const double u[SOFTSOIL_N_U], const double y[SOFTSOIL_N_Y],
                          const unsigned char valid[SOFTSOIL_N_Y], double t) {
  if (!h || !u || !y) return SOFTSOIL_NULL_POINTER;
  if (h->magic != MAGIC) return SOFTSOIL_NOT_INITIALISED;
  if (!isfinite(t)) return count(h, SOFTSOIL_TIME_NOT_FINITE);
  const double since = (t - h->clock) / h->options.dt;
  if (!(since >= 0.5)) {
    /* Late. A clock that was set back, or one stamp too far ahead: so are all that follow, and after a second it is believed. */
    const double step = t - h->doubt;
    h->doubted = step > 0.0 && step <= 1.0 + h->options.dt ? h->doubted + step : 0.0;
    h->doubt = t;
    if (!(h->doubted > 1.0)) return count(h, SOFTSOIL_MEASUREMENT_LATE);
  }
  int status = SOFTSOIL_OK, any = 0;
  h->doubted = 0.0;
  h->doubt = -HUGE_VAL;
  if (!(since >= 0.5) || (t - h->clock) > 1.0 + h->options.dt) {
    h->clock = t - h->options.dt;
    h->first_row = h->next_row = h->rows;
    h->continued = 0;
    if (h->heard > t) h->heard = t;
  } else {
    const unsigned char unknown = t - h->clock > held;
    for (int k = (int)floor(since + 0.5); k > 1; --k) new_row(h)->blocked = unknown;
  }
  for (int i = 0; i < SOFTSOIL_N_U; ++i) {
    if (!isfinite(u[i])) {
      status = graver(status, count(h, SOFTSOIL_INPUT_NOT_FINITE));
    } else if (fabs(u[i]) > u_limit[i]) {
      status = graver(status, count(h, SOFTSOIL_INPUT_OUT_OF_RANGE));
    } else {
      h->inputs[i] = u[i];
    }
  }
  if (status == SOFTSOIL_OK) h->heard = t;
  softsoil_horizon_row_t *row = new_row(h);
  row->blocked = t - h->heard > held;
  for (int i = 0; i < SOFTSOIL_N_Y; ++i) {
    if (valid && !valid[i]) continue;
    if (!isfinite(y[i])) {
      status = graver(status, count(h, SOFTSOIL_MEASUREMENT_NOT_FINITE));
    } else if (fabs(y[i]) > y_limit[i]) {
      status = graver(status, count(h, SOFTSOIL_MEASUREMENT_OUT_OF_RANGE));
    } else {
      fill(h, i, y[i]);
      any = 1;
    }
  }
  if (!any) status = graver(status, count(h, SOFTSOIL_NO_MEASUREMENT));
  if (row->seen[SOFTSOIL_Y_u] && row->y[SOFTSOIL_Y_u] < slowest) {
    row->blocked = 1;
    status = graver(status, count(h, row->y[SOFTSOIL_Y_u] < -slowest ? SOFTSOIL_NEGATIVE_SPEED : SOFTSOIL_STANDSTILL));
  }
  row->blocked = row->blocked || fabs(row->u[SOFTSOIL_U_steer_rate]) > fastest;
  watch(h);
  return status;
}

void softsoil_horizon_inputs(const softsoil_horizon_t *h, int64_t row, double share, double u[SOFTSOIL_N_U]) {
  const softsoil_horizon_row_t *here = &h->row[row % ROWS], *next = &h->row[(row + 1 < h->rows ? row + 1 : row) % ROWS];
  for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = here->u[i] + share * (next->u[i] - here->u[i]);
}

/* From one row to the next; inputs that are held for a step that is not short would lag. */
static void onwards(const softsoil_horizon_t *h, int active, int passive, int64_t row, softsoil_jobs_t *x, softsoil_jobs_t *m) {
  double u[SOFTSOIL_N_U];
  for (int k = 0; k < h->fractions; ++k) {
    softsoil_horizon_inputs(h, row, (double)k / h->fractions, u);
    softsoil_model_step_jobs(active, passive, u, h->options.p, h->options.dt / h->fractions, h->substeps, x, m);
  }
}

/* Whether a window is complete; windows run across no steering faster than any actuator and no standstill. */
static int complete(softsoil_horizon_t *h) {
  const int64_t oldest = oldest_row(h);
  if (h->next_row < oldest + (h->first_row < oldest ? h->half : 0)) {
    h->next_row = oldest + h->half;
    h->continued = 0;
  }
  while (h->next_row + h->steps + h->after < h->rows) {
    const int64_t end = h->next_row + h->steps;
    int64_t last = -1;
    const int64_t first = h->next_row - h->after > oldest ? h->next_row - h->after : oldest;
    for (int64_t k = first; k <= end + h->after; ++k)
      if (row_at(h, k)->blocked) last = k + h->after < end ? k + h->after : end;
    if (last < 0) return 1;
    h->next_row = last + 1;
  }
  return 0;
}

void softsoil_horizon_states(const softsoil_horizon_t *h, int64_t row, double x[NS]) {
  const softsoil_horizon_row_t *here = &h->row[row % ROWS];
  if (here->estimated) {
    memcpy(x, here->path, sizeof here->path);
    return;
  }
  const int64_t oldest = oldest_row(h), newest = h->rows - 1;
  int64_t half = h->half;
  if (2 * half > newest - oldest) half = (newest - oldest) / 2;
  int64_t centre = row;
  if (centre < oldest + half) centre = oldest + half;
  if (centre > newest - half) centre = newest - half;
  double s_0 = 0.0, s_2 = 0.0, s_4 = 0.0, sums[3][NS] = {{0.0}};
  for (int64_t k = -half; k <= half; ++k) {
    const double s = (double)k;
    s_0 += 1.0;
    s_2 += s * s;
    s_4 += s * s * s * s;
    for (int i = 0; i < NS; ++i) {
      const double y = h->row[(centre + k) % ROWS].y[i] - here->y[i];
      sums[0][i] += y;
      sums[1][i] += s * y;
      sums[2][i] += s * s * y;
    }
  }
  const double d = (double)(row - centre), below = s_0 * s_4 - s_2 * s_2;
  for (int i = 0; i < NS; ++i) {
    x[i] = here->y[i];
    if (!(below > 0.0)) continue;
    x[i] += (s_4 * sums[0][i] - s_2 * sums[2][i]) / below + sums[1][i] / s_2 * d +
            (s_0 * sums[2][i] - s_2 * sums[0][i]) / below * d * d;
  }
}

/* Steps by which parameters enter the derivatives, away from their upper bounds. */
static void free_steps(const softsoil_horizon_t *h, double *step) {
  for (int k = 0; k < K; ++k) step[k] = free_step * scale[k] * (h->n[k] + free_step * scale[k] > highest[k] ? -1.0 : 1.0);
}

/* Motion and parameters in a column of jobs. */
static void put(softsoil_jobs_t *x, int column, const double *states, const double *n) {
  for (int i = 0; i < NS; ++i) x[i][column] = states[i];
  for (int k = 0; k < K; ++k) x[at_state[k]][column] = n[k];
}

/* What is carried, in a column of jobs. */
static void put_carried(softsoil_jobs_t *x, softsoil_jobs_t *m, int column, const double *carried) {
  for (int i = 0; i < OTHERS; ++i) x[other_state[i]][column] = carried[i];
  for (int c = 0; c < SOFTSOIL_N_M; ++c) m[c][column] = carried[OTHERS + c];
}

static void get_carried(const softsoil_jobs_t *x, const softsoil_jobs_t *m, int column, double *carried) {
  for (int i = 0; i < OTHERS; ++i) carried[i] = x[other_state[i]][column];
  for (int c = 0; c < SOFTSOIL_N_M; ++c) carried[OTHERS + c] = m[c][column];
}

/* What is carried at first: other states as declared, histories as at a standing start. */
static void first_carried(const softsoil_horizon_t *h, int64_t row, const double *states, const double *n, double *carried) {
  double first[SOFTSOIL_N_X];
  memcpy(first, nominal, sizeof first);
  memcpy(first, states, NS * sizeof *states);
  for (int k = 0; k < K; ++k) first[at_state[k]] = n[k];
  for (int i = 0; i < OTHERS; ++i) carried[i] = nominal[other_state[i]];
  if (SOFTSOIL_N_M > 0) softsoil_model_start(first, h->row[row % ROWS].u, h->options.p, carried + OTHERS);
}

/* What is carried at the start of window i, moved to the present estimate by its derivatives. */
static void recall(const softsoil_horizon_t *h, int64_t i, double (*m)[CELLS]) {
  const int slot = (int)(i % KEPT);
  memcpy(m, h->m[slot], sizeof h->m[slot]);
  for (int k = 0; k < K; ++k) {
    const double away = between(-scale[k], h->n[k] - h->carried[slot][k], scale[k]) / h->steps_at[slot][k];
    for (int c = 0; c < CARRIED; ++c) {
      const double more = away * (h->m[slot][1 + k][c] - h->m[slot][0][c]);
      for (int j = 0; j <= K; ++j) m[j][c] += more;
    }
  }
}

/* Rows between the end of a window and the start of the next: histories run along what the model predicts there, from x and m at
 * the end, led to the state at the start in a straight line; unless that has no finite value. */
static void bridge(softsoil_horizon_t *h, int64_t end, int64_t to, softsoil_jobs_t *x, softsoil_jobs_t *m) {
  softsoil_jobs_t ahead[SOFTSOIL_N_X], memory[SOFTSOIL_CELLS];
  double start[NS];
  int sound = 1;
  memcpy(ahead, x, sizeof ahead);
  memcpy(memory, m, sizeof memory);
  for (int64_t row = end; row < to && sound; ++row) {
    onwards(h, 1, 0, row, ahead, memory);
    for (int i = 0; i < NS; ++i) {
      sound = sound && isfinite(ahead[i][0]);
      if (row + 1 < to) row_at(h, row + 1)->path[i] = ahead[i][0];
    }
  }
  if (!sound) return;
  softsoil_horizon_states(h, to, start);
  for (int64_t row = end + 1; row < to; ++row) {
    softsoil_horizon_row_t *here = row_at(h, row);
    for (int i = 0; i < NS; ++i) here->path[i] += (start[i] - ahead[i][0]) * ((double)(row - end) / (double)(to - end));
    here->estimated = 1;
  }
}

/* What is carried at the start of window i, for the estimate and each parameter moved: continued from the window before. */
static int carry(softsoil_horizon_t *h, int64_t i, int64_t to) {
  const int slot = (int)(i % KEPT);
  double n[1 + K][K], states[NS], start[1 + K][CELLS];
  softsoil_jobs_t x[SOFTSOIL_N_X], m[SOFTSOIL_CELLS];
  int status = SOFTSOIL_OK;
  for (int j = 0; j <= K; ++j) memcpy(n[j], h->n, sizeof n[j]);
  free_steps(h, h->steps_at[slot]);
  for (int k = 0; k < K; ++k) n[1 + k][k] += h->steps_at[slot][k];
  if (CARRIED == 0) return status;
  const int64_t oldest = oldest_row(h);
  int64_t from = to - h->before > oldest ? to - h->before : oldest;
  int whole = h->continued;
  if (whole) {
    from = window_at(h, i - 1)->row;
    whole = from >= oldest;
  }
  int64_t end = to;
  if (whole) {
    recall(h, i - 1, start);
    end = from + h->steps;
  } else {
    from = to - h->before > oldest ? to - h->before : oldest;
  }
  for (int tries = 0; tries < 2; ++tries) {
    memset(m, 0, sizeof m);
    memset(x, 0, sizeof x);
    softsoil_horizon_states(h, from, states);
    for (int j = 0; j < SOFTSOIL_PASSIVE_AT; ++j) {
      const int set = j <= K ? j : 0;
      put(x, j, states, n[set]);
      if (!whole && j <= K) first_carried(h, from, states, n[j], start[j]);
      put_carried(x, m, j, start[set]);
    }
    for (int64_t row = from; row < to; ++row) {
      if (row == end && to - end <= h->bridged) bridge(h, end, to, x, m);
      onwards(h, 1 + K, 0, row, x, m);
      softsoil_horizon_states(h, row + 1, states);
      for (int j = 0; j < SOFTSOIL_PASSIVE_AT; ++j) put(x, j, states, n[j <= K ? j : 0]);
    }
    int sound = 1;
    for (int j = 0; j <= K; ++j) {
      get_carried((const softsoil_jobs_t *)x, (const softsoil_jobs_t *)m, j, h->m[slot][j]);
      for (int c = 0; c < CARRIED; ++c) sound = sound && fabs(h->m[slot][j][c]) < 1e30;
    }
    if (sound) break;
    /* No finite value: that of a standing start in its place. */
    status = SOFTSOIL_NUMERICAL;
    from = end = to;
    whole = 0;
  }
  return status;
}

/* Sums over a window: the robust normal equations, and those of v and omega_z alone, unweighted. */
typedef struct {
  double normal[D][D], lean[D], cost;
  double own[2][NS][NS], own_lean[2][NS], own_square[2], own_count[2];
} sums_t;

static void add(sums_t *s, int channel, double z, const double *slope) {
  const double size = fabs(z), weight = size > huber ? huber / size : 1.0;
  for (int i = 0; i < D; ++i) {
    const double weighted = weight * slope[i];
    s->lean[i] += weighted * z;
    for (int j = 0; j <= i; ++j) s->normal[i][j] += weighted * slope[j];
  }
  s->cost += size > huber ? huber * (2.0 * size - huber) : z * z;
  for (int c = 0; c < 2; ++c) {
    if (judged[c] != channel) continue;
    for (int i = 0; i < NS; ++i) {
      s->own_lean[c][i] += slope[i] * z;
      for (int j = 0; j <= i; ++j) s->own[c][i][j] += slope[i] * slope[j];
    }
    s->own_square[c] += z * z;
    s->own_count[c] += 1.0;
  }
}

/* States along a window, and their derivatives by the initial ones. */
typedef struct {
  double state[NS], by_state[NS][NS];
} path_t;

/* More of the lateral force of an axle, that which balances a step's changes of v and omega_z from `state`, in its job. */
static void push_axles(const double *state, double dt, softsoil_jobs_t *x) {
  const double faster = x[SOFTSOIL_X_v][0] - state[SOFTSOIL_X_v] + state[SOFTSOIL_X_u] * state[SOFTSOIL_X_omega_z] * dt;
  const double turned = (x[SOFTSOIL_X_omega_z][0] - state[SOFTSOIL_X_omega_z]) * gyration_2, base = to_front + to_rear;
  const double front = (faster * to_rear + turned) / base, rear = (faster * to_front - turned) / base;
  for (int j = 0; j < FORCES; ++j) {
    const double f = FORCES == 1 || j == 0 ? front : 0.0, r = FORCES == 1 || j == 1 ? rear : 0.0;
    x[SOFTSOIL_X_v][FORCE_COLUMN + j] += force_step * (f + r);
    x[SOFTSOIL_X_omega_z][FORCE_COLUMN + j] += force_step * (to_front * f - to_rear * r) / gyration_2;
  }
}

/* The window's residuals and derivatives along the model; 0 where it has no usable answer. */
static int run(softsoil_horizon_t *h, const window_t *w, const double (*start)[CELLS], sums_t *sums, path_t *path) {
  const softsoil_horizon_options_t *o = &h->options;
  softsoil_jobs_t x[SOFTSOIL_N_X], m[SOFTSOIL_CELLS], y[SOFTSOIL_N_Y];
  double step[K], n[K], state[NS], slope[D];
  free_steps(h, step);
  memset(sums, 0, sizeof *sums);
  memset(x, 0, sizeof x);
  memset(m, 0, sizeof m);
  memset(y, 0, sizeof y);
  for (int j = 0; j < SOFTSOIL_JOB_ROW; ++j) {
    put(x, j, w->state, h->n);
    put_carried(x, m, j, start[0]);
  }
  for (int i = 0; i < NS; ++i) {
    memcpy(state, w->state, sizeof state);
    state[i] += state_step[i];
    put(x, state_column[i], state, h->n);
  }
  for (int k = 0; k < K; ++k) {
    memcpy(n, h->n, sizeof n);
    n[k] += step[k];
    put(x, free_column[k], w->state, n);
    put_carried(x, m, free_column[k], start[1 + k]);
  }
  memcpy(state, w->state, sizeof state);
  for (int s = 0; s <= h->steps; ++s) {
    const softsoil_horizon_row_t *row = row_at(h, w->row + s);
    softsoil_model_measure_jobs(ACTIVE, PASSIVE, row->u, o->p, (const softsoil_jobs_t *)x, y);
    for (int i = 0; i < NS; ++i) {
      path[s].state[i] = x[i][0];
      for (int j = 0; j < NS; ++j) path[s].by_state[i][j] = (x[i][state_column[j]] - x[i][0]) / state_step[j];
    }
    for (int c = 0; c < SOFTSOIL_N_Y; ++c) {
      const double at = y[c][0], sigma = sqrt(o->r_std[c] * o->r_std[c] + o->model_error[c] * o->model_error[c]);
      int sound = fabs(at) < 1e12;
      for (int i = 0; i < NS; ++i) {
        slope[i] = (y[c][state_column[i]] - at) / sigma / state_step[i];
        sound = sound && fabs(slope[i]) < 1e12;
      }
      for (int k = 0; k < K; ++k) {
        slope[NS + k] = (y[c][free_column[k]] - at) / sigma / step[k];
        sound = sound && fabs(slope[NS + k]) < 1e12;
      }
      for (int k = K; k < Q; ++k) {
        slope[NS + k] = (y[c][INERTIA_COLUMN + k - K] - at) / sigma / (k < QI ? inertia_step : force_step);
        sound = sound && fabs(slope[NS + k]) < 1e12;
      }
      if (!sound) return 0;
      const double error = at - row->y[c];
      if (row->seen[c] && isfinite(sigma)) add(sums, c, (y_wraps[c] ? wrapped(error) : error) / sigma, slope);
    }
    if (s < h->steps) onwards(h, ACTIVE, PASSIVE, w->row + s, x, m);
    /* With an inertia larger by a share, the yaw rate changes less by that share. */
    if (ASKS_INERTIA) x[SOFTSOIL_X_omega_z][INERTIA_COLUMN] -= inertia_step * (x[SOFTSOIL_X_omega_z][0] - state[SOFTSOIL_X_omega_z]);
    push_axles(state, o->dt, x);
    for (int i = 0; i < NS; ++i) state[i] = x[i][0];
  }
  return 1;
}

/* Variance that the window leaves of v and omega_z per degree of freedom, its initial state at its best. */
static void judge_window(const softsoil_horizon_t *h, const sums_t *s, const double *inverse, const double *move, window_t *w) {
  for (int c = 0; c < 2; ++c) {
    const softsoil_horizon_options_t *o = &h->options;
    const double sigma_2 = o->r_std[judged[c]] * o->r_std[judged[c]] + o->model_error[judged[c]] * o->model_error[judged[c]];
    double square = s->own_square[c], leverage = 0.0;
    for (int i = 0; i < NS; ++i) {
      square += 2.0 * move[i] * s->own_lean[c][i];
      for (int j = 0; j < NS; ++j) {
        const double own = i > j ? s->own[c][i][j] : s->own[c][j][i];
        square += move[i] * own * move[j];
        leverage += inverse[i * NS + j] * own;
      }
    }
    w->excess[c] = s->own_count[c] > 0.0 ? larger(square, 0.0) * sigma_2 / larger(s->own_count[c] - leverage, 1.0) : (double)NAN;
  }
}

/* A window reduced to a quadratic at the present estimate; one without a usable answer says nothing. */
static int linearise(softsoil_horizon_t *h, int64_t i, const double (*start)[CELLS]) {
  window_t *w = window_at(h, i);
  path_t path[LONGEST_WINDOW + 1];
  double a[NS * NS], inverse[NS * NS], solved[NS][Q], move[NS];
  sums_t s;
  memcpy(w->at, h->n, sizeof w->at);
  memset(w->gradient, 0, sizeof w->gradient);
  memset(w->hessian, 0, sizeof w->hessian);
  w->cost = 0.0;
  w->excess[0] = w->excess[1] = (double)NAN;
  if (!run(h, w, start, &s, path)) return SOFTSOIL_NUMERICAL;
  for (int r = 0; r < NS; ++r)
    for (int c = 0; c < NS; ++c) a[r * NS + c] = (r > c ? s.normal[r][c] : s.normal[c][r]) + (r == c ? ridge : 0.0);
  if (!invert(NS, a, inverse)) return SOFTSOIL_NUMERICAL;
  for (int r = 0; r < NS; ++r) {
    move[r] = 0.0;
    for (int k = 0; k < Q; ++k) solved[r][k] = 0.0;
    for (int c = 0; c < NS; ++c) {
      move[r] -= inverse[r * NS + c] * s.lean[c];
      for (int k = 0; k < Q; ++k) solved[r][k] += inverse[r * NS + c] * s.normal[NS + k][c];
    }
  }
  for (int k = 0; k < Q; ++k) {
    w->gradient[k] = s.lean[NS + k];
    for (int r = 0; r < NS; ++r) w->gradient[k] -= solved[r][k] * s.lean[r];
    for (int l = 0; l < Q; ++l) {
      w->hessian[k][l] = k > l ? s.normal[NS + k][NS + l] : s.normal[NS + l][NS + k];
      for (int r = 0; r < NS; ++r) w->hessian[k][l] -= s.normal[NS + k][r] * solved[r][l];
    }
  }
  w->cost = s.cost / ((h->steps + 1) * SOFTSOIL_N_Y);
  judge_window(h, &s, inverse, move, w);
  for (int r = 0; r < NS; ++r) w->state[r] += move[r];
  for (int k = 0; k <= h->steps; ++k) {
    softsoil_horizon_row_t *row = row_at(h, w->row + k);
    for (int r = 0; r < NS; ++r) {
      row->path[r] = path[k].state[r];
      for (int c = 0; c < NS; ++c) row->path[r] += path[k].by_state[r][c] * move[c];
    }
    row->estimated = 1;
  }
  return SOFTSOIL_OK;
}

/* Quadratics of the windows from `from` to before `to`, weighted by their age at the newest. */
typedef struct {
  double n[K], hessian[K * K], weight;
} minimum_t;

static double weight_of(const softsoil_horizon_t *h, int64_t i, int even) {
  const int64_t age = even ? 0 : h->taken - 1 - i;
  return age < WINDOWS ? h->weights[age] : 0.0;
}

static int64_t first_counted(const softsoil_horizon_t *h) {
  return h->since > h->taken - WINDOWS ? h->since : h->taken - WINDOWS;
}

/* Their minimum, with the initial guess or without, weighted by age or evenly; 0 where there is none. */
static int minimise(softsoil_horizon_t *h, int64_t from, int64_t to, int guess, int even, minimum_t *out) {
  double lean[K] = {0.0}, firm[K * K], inverse[K * K];
  memset(out, 0, sizeof *out);
  for (int64_t i = from; i < to; ++i) {
    const window_t *w = window_at(h, i);
    const double weight = weight_of(h, i, even);
    out->weight += weight;
    for (int k = 0; k < K; ++k) {
      lean[k] -= weight * w->gradient[k];
      for (int l = 0; l < K; ++l) {
        out->hessian[k * K + l] += weight * w->hessian[k][l];
        lean[k] += weight * w->hessian[k][l] * w->at[l];
      }
    }
  }
  for (int k = 0; k < K && guess; ++k) {
    const double sure = 1.0 / (h->options.guess_std[k] * h->options.guess_std[k]);
    out->hessian[k * K + k] += sure;
    lean[k] += sure * h->centre[k];
  }
  memcpy(firm, out->hessian, sizeof firm);
  for (int k = 0; k < K; ++k) firm[k * K + k] += least_curvature;
  if (!invert(K, firm, inverse)) return 0;
  for (int k = 0; k < K; ++k)
    for (int l = 0; l < K; ++l) out->n[k] += inverse[k * K + l] * lean[l];
  return 1;
}

/* Scatter of the windows' scores at n, weighted. */
static void scatter(softsoil_horizon_t *h, const double *n, int64_t from, int64_t to, int even, double *out) {
  memset(out, 0, K * K * sizeof *out);
  for (int64_t i = from; i < to; ++i) {
    const window_t *w = window_at(h, i);
    const double weight = weight_of(h, i, even);
    double score[K];
    for (int k = 0; k < K; ++k) {
      score[k] = w->gradient[k];
      for (int l = 0; l < K; ++l) score[k] += w->hessian[k][l] * (n[l] - w->at[l]);
    }
    for (int k = 0; k < K; ++k)
      for (int l = 0; l < K; ++l) out[k * K + l] += weight * score[k] * score[l];
  }
}

/* The diagonal of A S A. */
static double sandwich(const double *a, const double *s, int k) {
  double sum = 0.0;
  for (int l = 0; l < K; ++l)
    for (int m = 0; m < K; ++m) sum += a[k * K + l] * s[l * K + m] * a[m * K + k];
  return sum;
}

static void estimate(softsoil_horizon_t *h) {
  minimum_t found;
  if (!minimise(h, first_counted(h), h->taken, 1, 0, &found)) return;
  for (int k = 0; k < K; ++k)
    if (isfinite(found.n[k])) h->n[k] = between(lowest[k], found.n[k], highest[k]);
}

/* Whether the newest `recent` windows contradict the older ones beyond their scatter; these then count no more. */
static int changed_within(softsoil_horizon_t *h, int recent) {
  const int64_t from = first_counted(h), middle = h->taken - recent;
  double per_window[K * K], inverse[2][K * K];
  minimum_t part[2];
  int found = 0;
  if (h->taken - h->since < recent + 2 * recents[0]) return 0;
  if (!minimise(h, middle, h->taken, 0, 0, &part[0]) || !minimise(h, from, middle, 0, 0, &part[1])) return 0;
  scatter(h, part[1].n, from, middle, 0, per_window);
  const double share = h->weights[0], old = part[1].weight / share;
  for (int j = 0; j < 2; ++j) {
    for (int k = 0; k < K * K; ++k) part[j].hessian[k] /= share;
    for (int k = 0; k < K; ++k) part[j].hessian[k * K + k] += least_curvature;
    if (!invert(K, part[j].hessian, inverse[j])) return 0;
  }
  for (int k = 0; k < K * K; ++k) per_window[k] /= share * larger(old, 1.0);
  for (int k = 0; k < K; ++k) {
    const double counts[2] = {(double)recent, old};
    double spread = 0.0;
    for (int j = 0; j < 2; ++j)
      spread += larger(sandwich(inverse[j], per_window, k) * counts[j], inverse[j][k * K + k]) / share;
    const double moved = fabs(part[0].n[k] - part[1].n[k]);
    found = found || (is_soil[k] && moved > change * sqrt(spread) && moved > least_change * part[1].n[k]);
  }
  if (!found) return 0;
  /* Windows that overlap the border hold both soils: they are dropped with the older ones. */
  const int whole = recent - nearest(window_length / stride);
  h->since = h->taken - (whole > 1 ? whole : 1);
  for (int k = 0; k < K; ++k)
    if (is_soil[k]) h->centre[k] = between(lowest[k], part[0].n[k], highest[k]);
  ++h->changes;
  h->changed_at = window_at(h, h->since)->t;
  return 1;
}

/* Standard deviations of the parameters by errors of the axles' forces: curvature (K, K) is inverted in `inverse`. */
static void by_law(softsoil_horizon_t *h, const double *inverse) {
  double square[K] = {0.0};
  for (int j = 0; j < FORCES; ++j) {
    double crossed[K] = {0.0};
    for (int64_t i = first_counted(h); i < h->taken; ++i)
      for (int k = 0; k < K; ++k) crossed[k] += weight_of(h, i, 0) * window_at(h, i)->hessian[k][QI + j];
    for (int k = 0; k < K; ++k) {
      double moved = 0.0;
      for (int l = 0; l < K; ++l) moved -= inverse[k * K + l] * crossed[l];
      square[k] += is_soil[k] ? law_error * moved * law_error * moved : 0.0;
    }
  }
  for (int k = 0; k < K; ++k) h->law_std[k] = isfinite(square[k]) ? sqrt(square[k]) : 1e9;
}

/* Standard deviations: sandwich of the scores, at least that of noise, and the errors common to all windows. */
static void deviations(softsoil_horizon_t *h) {
  const int64_t from = first_counted(h);
  double inverse[K * K], scores[K * K];
  minimum_t found;
  scatter(h, h->n, from, h->taken, 0, scores);
  for (int guess = 0; guess < 2; ++guess) {
    const int good = minimise(h, from, h->taken, guess, 0, &found);
    for (int k = 0; k < K && !guess; ++k) found.hessian[k * K + k] += least_curvature;
    if (!good || !invert(K, found.hessian, inverse)) continue;
    if (!guess) by_law(h, inverse);
    for (int k = 0; k < K; ++k) {
      const double common = common_error * h->n[k], flat = flat_error * h->n[k], law = h->law_std[k];
      const double shared = guess && is_soil[k] ? common * common + larger(law * law - flat * flat, 0.0) : 0.0;
      const double variance = larger(sandwich(inverse, scores, k), inverse[k * K + k]) + shared;
      if (isfinite(variance)) (guess ? h->std : h->information_std)[k] = sqrt(larger(variance, 0.0));
      if (!guess && isfinite(found.n[k])) h->free_n[k] = between(lowest[k], found.n[k], highest[k]);
    }
  }
}

/* Share of the variance of v or omega_z that the windows of this soil leave beyond sensor noise, and its standard error. */
static void unexplained(softsoil_horizon_t *h, int c) {
  double sorted[WINDOWS], sum = 0.0, square = 0.0;
  int many = 0;
  for (int64_t i = first_counted(h); i < h->taken; ++i) {
    const double value = window_at(h, i)->excess[c];
    if (!isfinite(value)) continue;
    int j = many++;
    for (; j > 0 && sorted[j - 1] > value; --j) sorted[j] = sorted[j - 1];
    sorted[j] = value;
    sum += value;
    square += value * value;
  }
  h->unexplained[c] = 0.0;
  h->unexplained_std[c] = 1e9;
  if (many == 0) return;
  const double left = 0.5 * (sorted[many / 2] + sorted[(many - 1) / 2]), mean = sum / many;
  const double spread = sqrt(larger(square / many - mean * mean, 0.0));
  const double most = forgetting / h->options.dt;
  const double samples = h->noise_count[c] < most ? h->noise_count[c] : most;
  const double noise_error = h->noise[c] * sqrt(4.6 / larger(samples, 1.0)), of_mean = 1.25 * spread / sqrt((double)many);
  const double error = larger(sqrt(of_mean * of_mean + noise_error * noise_error), 1e-15);
  const double motion = larger(h->square[c] - h->noise[c], 0.0) + 1e-12;
  h->unexplained[c] = (left - h->noise[c]) / motion;
  h->unexplained_std[c] = error / motion;
}

/* One step of the parameters and of the yaw inertia at the estimate: by which share the windows would have it larger. */
static void ask_inertia(softsoil_horizon_t *h) {
  double total[QI * QI] = {0.0}, inverse[QI * QI], lean[QI] = {0.0}, step[QI] = {0.0}, square[QI * QI] = {0.0}, score[QI];
  h->inertia = 0.0;
  h->inertia_std = 1e9;
  if (!ASKS_INERTIA) return;
  for (int pass = 0; pass < 2; ++pass) {
    for (int64_t i = first_counted(h); i < h->taken; ++i) {
      const window_t *w = window_at(h, i);
      const double weight = weight_of(h, i, 0);
      for (int k = 0; k < QI; ++k) {
        score[k] = w->gradient[k];
        for (int l = 0; l < K; ++l) score[k] += w->hessian[k][l] * (h->n[l] - w->at[l]);
        for (int l = 0; l < QI && pass; ++l) score[k] += w->hessian[k][l] * step[l];
      }
      for (int k = 0; k < QI; ++k) {
        lean[k] += pass ? 0.0 : weight * score[k];
        for (int l = 0; l < QI; ++l)
          (pass ? square : total)[k * QI + l] += weight * (pass ? score[k] * score[l] : w->hessian[k][l]);
      }
    }
    if (pass) break;
    for (int k = 0; k < QI; ++k) total[k * QI + k] += least_curvature;
    if (!invert(QI, total, inverse)) return;
    for (int k = 0; k < QI; ++k)
      for (int l = 0; l < QI; ++l) step[k] -= inverse[k * QI + l] * lean[l];
  }
  double spread = 0.0;
  for (int l = 0; l < QI; ++l)
    for (int m = 0; m < QI; ++m) spread += inverse[(QI - 1) * QI + l] * square[l * QI + m] * inverse[m * QI + QI - 1];
  const double variance = larger(spread, inverse[QI * QI - 1]);
  if (!isfinite(step[QI - 1]) || !isfinite(variance)) return;
  h->inertia = step[QI - 1];
  h->inertia_std = sqrt(variance);
}

/* n of the earlier and of the later windows where these differ most, and by how many standard deviations. */
static void compare_parts(softsoil_horizon_t *h) {
  const int64_t from = first_counted(h), count = h->taken - from;
  h->parts[0] = h->parts[1] = h->n[0];
  h->parts_sigmas = 0.0;
  for (int s = 0; s < SPLITS; ++s) {
    const int64_t cut = from + nearest(splits[s] * (double)count), ends[3] = {from, cut, h->taken};
    double inverse[K * K], scores[K * K], variance[K] = {0.0};
    minimum_t part[2];
    int good = cut - from >= LEAST_PART && h->taken - cut >= LEAST_PART;
    for (int j = 0; j < 2 && good; ++j) {
      good = minimise(h, ends[j], ends[j + 1], 0, 1, &part[j]);
      if (!good) break;
      scatter(h, part[j].n, ends[j], ends[j + 1], 1, scores);
      for (int k = 0; k < K; ++k) part[j].hessian[k * K + k] += least_curvature;
      good = invert(K, part[j].hessian, inverse);
      for (int k = 0; k < K && good; ++k) variance[k] += larger(sandwich(inverse, scores, k), inverse[k * K + k]);
    }
    for (int k = 0; k < K && good; ++k) {
      const double sigmas = fabs(part[1].n[k] - part[0].n[k]) / sqrt(variance[k]);
      if (!is_soil[k] || !(sigmas > h->parts_sigmas) || !isfinite(sigmas)) continue;
      h->parts[0] = part[0].n[k];
      h->parts[1] = part[1].n[k];
      h->parts_sigmas = sigmas;
    }
  }
}

int softsoil_horizon_verdict(const softsoil_horizon_t *h) {
  if (h->windows < 2 * recents[0] || !(h->motion >= least_motion)) return SOFTSOIL_VERDICT_NOT_EXCITED;
  for (int c = 0; c < 2; ++c)
    if (h->unexplained[c] - unexplained_sigmas * h->unexplained_std[c] > most_unexplained[c] * most_unexplained[c])
      return SOFTSOIL_VERDICT_INCONSISTENT;
  const double sure = inertia_sigmas * h->inertia_std, far = sqrt(sure * sure + stated_inertia * stated_inertia);
  if (h->inertia_std <= most_inertia_std && fabs(h->inertia) >= larger(most_inertia, far)) return SOFTSOIL_VERDICT_INCONSISTENT;
  if (h->vehicle > SOFTSOIL_VEHICLE_SAME) return SOFTSOIL_VERDICT_INCONSISTENT;
  for (int k = 0; k < K; ++k)
    if (is_soil[k] && !(h->information_std[k] <= most_std * h->n[k] && h->law_std[k] <= most_law_std * h->n[k]))
      return SOFTSOIL_VERDICT_NOT_EXCITED;
  if (h->vehicle == SOFTSOIL_VEHICLE_UNKNOWN || (h->vehicle == SOFTSOIL_VEHICLE_NOT_LOOKED_AT && h->options.look))
    return SOFTSOIL_VERDICT_NOT_EXCITED;
  for (int k = 0; k < K; ++k)
    if (is_soil[k] && (h->n[k] < lowest[k] + bound || h->n[k] > highest[k] - bound)) return SOFTSOIL_VERDICT_AT_BOUND;
  for (int k = 0; k < K; ++k)
    if (is_soil[k] && fabs(h->free_n[k] - h->n[k]) > same * h->n[k]) return SOFTSOIL_VERDICT_DEPENDS_ON_FIRST_GUESS;
  for (int k = 0; k + 1 < K; ++k) {
    if (!is_soil[k] || !is_soil[k + 1]) continue;
    const double apart = fabs(h->n[k] - h->n[k + 1]), spread = sqrt(h->std[k] * h->std[k] + h->std[k + 1] * h->std[k + 1]);
    if (apart > axles_sigmas * spread && apart > 0.5 * axles * (h->n[k] + h->n[k + 1])) return SOFTSOIL_VERDICT_AXLES_DISAGREE;
  }
  if (h->parts_sigmas > most_parts_sigmas)
    for (int k = 0; k < K; ++k)
      if (is_soil[k] && fabs(h->parts[1] - h->parts[0]) > most_parts * h->n[k]) return SOFTSOIL_VERDICT_INCONSISTENT;
  return SOFTSOIL_VERDICT_IDENTIFIED;
}

/* Of the windows that started lately and were linearised far from the estimate, the one whose quadratic that touches most,
 * or -1. */
static int64_t stale_window(softsoil_horizon_t *h) {
  const int64_t newest = window_at(h, h->taken - 1)->row;
  int64_t found = -1, i = h->taken - KEPT > h->since ? h->taken - KEPT : h->since;
  double most = -1.0;
  for (; i < h->taken; ++i) {
    const window_t *w = window_at(h, i);
    double weight = 0.0;
    int far = 0;
    if (w->row < newest - h->again || w->row <= h->rows - ROWS) continue;
    for (int k = 0; k < K; ++k) {
      far = far || fabs(w->at[k] - h->n[k]) / scale[k] > stale;
      for (int l = 0; l < K; ++l) weight += (w->at[k] - h->n[k]) * w->hessian[k][l] * (w->at[l] - h->n[l]);
    }
    if (far && weight > most) {
      most = weight;
      found = i;
    }
  }
  return found;
}

int softsoil_horizon_update(softsoil_horizon_t *h) {
  double start[1 + K][CELLS];
  if (!h) return SOFTSOIL_NULL_POINTER;
  if (h->magic != MAGIC) return SOFTSOIL_NOT_INITIALISED;
  h->updated = 0;
  if (!complete(h)) return SOFTSOIL_OK;
  const int64_t i = h->taken;
  int status = carry(h, i, h->next_row);
  const int slot = (int)(i % KEPT);
  memcpy(h->carried[slot], h->n, sizeof h->n);
  window_t *w = window_at(h, i);
  w->row = h->next_row;
  w->t = h->clock - (double)(h->rows - 1 - w->row) * h->options.dt;
  softsoil_horizon_states(h, w->row, w->state);
  h->next_row += h->apart;
  h->continued = 1;
  ++h->taken;
  status = graver(status, linearise(h, i, (const double (*)[CELLS])h->m[slot]));
  estimate(h);
  const int64_t again = stale_window(h);
  if (again >= 0) {
    recall(h, again, start);
    status = graver(status, linearise(h, again, (const double (*)[CELLS])start));
    estimate(h);
  }
  for (int r = 0; r < RECENTS; ++r)
    if (changed_within(h, recents[r])) {
      estimate(h);
      break;
    }
  deviations(h);
  h->t = h->clock - (double)(h->rows - 1 - w->row - h->steps) * h->options.dt;
  h->cost = w->cost;
  h->windows = (int32_t)(h->taken - first_counted(h));
  h->motion = sqrt(h->force);
  for (int c = 0; c < 2; ++c) unexplained(h, c);
  ask_inertia(h);
  compare_parts(h);
  h->verdict = softsoil_horizon_verdict(h);
  h->updated = 1;
  if (status) count(h, status);
  return status;
}

int softsoil_horizon_correct(const softsoil_horizon_t *h, softsoil_t *s) {
  int moved = 0;
  if (!h || !s || h->magic != MAGIC || s->magic != 0x1597a17eu || h->verdict != SOFTSOIL_VERDICT_IDENTIFIED) return 0;
  for (int k = 0; k < K; ++k) {
    const int at = at_state[k];
    const double away = h->n[k] - s->x[at];
    int own = 0;
    while (softsoil_order[own] != at) ++own;
    double variance = 0.0;
    for (int j = 0; j <= own; ++j) variance += s->root[own][j] * s->root[own][j];
    if (!(away * away > variance) || !(variance > 0.0)) continue;
    for (int i = 0; i < SOFTSOIL_N_X; ++i) {
      double shared = 0.0;
      if (i == own) continue;
      for (int j = 0; j <= own && j <= i; ++j) shared += s->root[i][j] * s->root[own][j];
      /* Only motion moves with it: the other parameters have estimates of their own. */
      if (softsoil_order[i] < NS && softsoil_order[i] > SOFTSOIL_X_psi) s->x[softsoil_order[i]] += shared / variance * away;
    }
    s->x[at] = h->n[k];
    /* The filter adds an error common to all drives to its own: its root is to hold the rest. */
    const double common = s->options.common_error * h->n[k];
    const double factor = sqrt(larger(h->std[k] * h->std[k] - common * common, 0.01 * h->std[k] * h->std[k]) / variance);
    for (int j = 0; j <= own; ++j) s->root[own][j] *= factor;
    s->std[at] = h->std[k];
    moved = 1;
  }
  return moved;
}
