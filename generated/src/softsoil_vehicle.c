/* Whether the vehicle is the one that was identified: windows of the horizon, differentiated by its numbers, a load, and the
 * steering's scale. */
#include "softsoil_vehicle.h"

#include <math.h>
#include <string.h>

#include "softsoil_lanes.h"
#include "softsoil_model.h"

#include "softsoil_vehicle_kernels.h"

#define K SOFTSOIL_HORIZON_N
#define NS SOFTSOIL_HORIZON_STATES
#define OTHERS (SOFTSOIL_HORIZON_CARRIED - SOFTSOIL_N_M) /* states carried */
#define NUMBERS SOFTSOIL_VEHICLE_NUMBERS
#define Q SOFTSOIL_VEHICLE_ASKED
#define D SOFTSOIL_VEHICLE_COLUMNS
#define LOAD (Q - 2)
#define SCALE (Q - 1) /* of the steering */
#define LARGEST (Q > NS ? Q : NS) /* matrix */
#define N_P 33
#define CALLS 4
#define ARGUMENTS 11
#define OUTPUTS 7
#define SUBSTEPS 2 /* inside one of the horizon's: those in which the numbers were identified */
#define MAGIC 0x9d059637u

/* Parameters of the model with the vehicle's numbers among them: where the horizon has each, -1 for none, and as declared. */
static const int shared[N_P] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, -1, -1, 13, -1, 14, 15, 16, 17, 18, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
static const double declared[N_P] = {692200.0, 13200.0, 4140.0, 0.2269, 0.01, 200000000.0, 30000.0, 0.7038, 0.528, 0.0, -0.2, 0.934, 1.0, 0.0, 2.1768, 0.901, 1.0, -0.145, 0.965, 0.953, 0.095, 23.0, 1848.0, 1.194, 1.227, 0.3309, 0.0464, -0.0195, 0.0096, 0.633, 0.0148, 0.34, 0.66};
/* The numbers, the load and the steering's scale: their parameters, units (standard deviations; the mass; the declared scale), and
 * steps of the differences in these. */
static const int at_parameter[NUMBERS + 2] = {22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 21, 7, 8, 15, 11, 17, 18, 19, 20, 13, 16};
static const double unit[NUMBERS + 2] = {51.5, 0.0081, 0.0079, 0.00026, 0.007, 0.0027, 0.0015, 0.072, 0.00065, 0.038, 0.046, 12.5, 0.031, 0.012, 0.044, 0.047, 0.0098, 0.037, 0.021, 0.0063, 1378.33, 1.0}, step_of[NUMBERS + 2] = {2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 2.5e-06, 5e-07, 5e-07};
/* What is known of the numbers together: inverse of their covariance, in their units; of a load, as a share of the mass,
 * and of the scale. */
static const double known[NUMBERS][NUMBERS] = {{1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}};
static const double known_load = 1.0, known_scale = 25.0, declared_load_std = 0.0;
static const double most_strain = 3.5, least_load = 0.08, load_sigmas = 2.5, load_seen = 0.06;
static const double least_steering = 0.04, steering_sigmas = 2.5;
static const double lightest = -0.4, heaviest = 1.0; /* loads that are believed, shares of the mass */
static const double best_sensor[SOFTSOIL_N_Y] = {0.05, 0.05, 0.003, 0.05, 0.05, 0.005};

static const double stride = 0.5, window_length = 1.0, forgetting = 60.0, huber = 3.0, ridge = 1e-06;
static const double least_curvature = 1e-09, most_std = 0.05;
static const double state_step[NS] = {0.0001, 0.0001, 1e-05, 0.0001, 0.0001, 1e-05};
static const double free_step = 5e-06;
static const int at_state[K] = {SOFTSOIL_X_n}, is_soil[K] = {1};
static const double scale[K] = {0.1}, highest[K] = {1.6};
static const int other_state[SOFTSOIL_SOME(OTHERS)] = {0};
static const int32_t y_wraps[SOFTSOIL_N_Y] = {0, 0, 1, 0, 0, 0};

size_t softsoil_vehicle_size(void) { return sizeof(softsoil_vehicle_t); }

int softsoil_vehicle_init(softsoil_vehicle_t *v) {
  if (!v) return SOFTSOIL_NULL_POINTER;
  memset(v, 0, sizeof *v);
  v->next = -1;
  v->change = SOFTSOIL_VEHICLE_UNKNOWN;
  v->load_std = v->steering_std = 1e9;
  v->magic = MAGIC;
  return SOFTSOIL_OK;
}

static double larger(double a, double b) { return a > b ? a : b; }

static int invert(int n, const double *a, double *inverse) {
  double work[2 * LARGEST * LARGEST];
  return softsoil_invert(n, a, inverse, work);
}

/* States x and histories m one sample of dt later, in so many Euler steps, with the vehicle's numbers in p. */
static void advance(const double *u, const double *p, double dt, int substeps, double *x, double *m) {
  double full[SOFTSOIL_N_U + SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)], next[SOFTSOIL_CELLS], rate[SOFTSOIL_N_X];
  double arguments[SOFTSOIL_SOME(CALLS * ARGUMENTS)], force[SOFTSOIL_SOME(CALLS * OUTPUTS)];
  memcpy(full, u, SOFTSOIL_N_U * sizeof *u);
  own_read(x, u, p, m, full + SOFTSOIL_N_U);
  for (int k = 0; k < substeps; ++k) {
    own_before(x, full, p, arguments);
#define RUN(first, wheels, law) \
  for (int call = first; call < first + wheels; ++call) law(arguments + call * ARGUMENTS, p, force + call * OUTPUTS);
    SOFTSOIL_OWN_LAWS(RUN)
#undef RUN
    own_after(x, full, p, force, rate);
    if (k == 0) own_advance(x, full, p, m, &dt, force, next);
    for (int i = 0; i < SOFTSOIL_N_X; ++i) x[i] += dt / substeps * rate[i];
  }
  for (int i = 0; i < SOFTSOIL_N_M; ++i) m[i] = next[i];
}

static void put(double *x, const double *states, const double *n) {
  memcpy(x, states, NS * sizeof *states);
  for (int k = 0; k < K; ++k) x[at_state[k]] = n[k];
}

static void put_carried(double *x, double *m, const double *carried) {
  for (int i = 0; i < OTHERS; ++i) x[other_state[i]] = carried[i];
  for (int c = 0; c < SOFTSOIL_N_M; ++c) m[c] = carried[OTHERS + c];
}

static const softsoil_horizon_row_t *row_at(const softsoil_horizon_t *h, int64_t row) {
  return &h->row[row % SOFTSOIL_HORIZON_ROWS];
}

/* States x and histories m from one row of the horizon to the next, in its steps. */
static void onwards(const softsoil_horizon_t *h, int64_t row, const double *p, double *x, double *m) {
  double u[SOFTSOIL_N_U];
  for (int k = 0; k < h->fractions; ++k) {
    softsoil_horizon_inputs(h, row, (double)k / h->fractions, u);
    advance(u, p, h->options.dt / h->fractions, SUBSTEPS * h->substeps, x, m);
  }
}

static const softsoil_horizon_window_t *window_at(const softsoil_horizon_t *h, int64_t i) {
  return &h->window[i % SOFTSOIL_HORIZON_WINDOWS];
}

/* Standard deviation that residuals of a measurement are taken in: no sensor is better than the filter believes one to be. */
static double sigma_of(const softsoil_horizon_options_t *o, int c) {
  const double noise = larger(o->r_std[c], best_sensor[c]);
  return sqrt(noise * noise + o->model_error[c] * o->model_error[c]);
}

/* Choose the horizon's newest window, and where its histories are run from: two windows before, where these follow each other. */
static int begin(softsoil_vehicle_t *v, const softsoil_horizon_t *h) {
  const int64_t i = h->taken - 1, oldest = h->rows - SOFTSOIL_HORIZON_ROWS;
  int64_t first = i;
  if (h->taken < v->taken || h->changes != v->changes) {
    softsoil_vehicle_init(v);
    v->changes = h->changes;
  }
  if (i < h->since || i < v->taken || h->steps + 1 > SOFTSOIL_VEHICLE_SAMPLES) return 0;
  for (int k = 0; k < K; ++k)
    if (is_soil[k] && !(h->information_std[k] <= most_std * h->n[k])) return 0;
  while (first > h->since && first > i - 2 && first > 0 && window_at(h, first)->row - window_at(h, first - 1)->row == h->apart)
    --first;
  v->row = window_at(h, i)->row;
  v->from = window_at(h, first)->row;
  if (v->from < oldest || i - first >= SOFTSOIL_HORIZON_KEPT) return 0;
  v->taken = i + 1;
  v->steps = h->steps;
  v->next = 0;
  memcpy(v->n, h->n, sizeof v->n);
  memcpy(v->state, window_at(h, i)->state, sizeof v->state);
  memcpy(v->memory[0], h->m[first % SOFTSOIL_HORIZON_KEPT][0], sizeof v->memory[0]);
  return 1;
}

/* The window with its initial states, parameters, numbers, load and scale as declared (0), or one of them moved (1 to D); 0 where the
 * model has no usable answer. */
static int run(softsoil_vehicle_t *v, const softsoil_horizon_t *h, int column) {
  const softsoil_horizon_options_t *o = &h->options;
  const int own = column - 1 - NS - K, soil = column - 1 - NS, state = column - 1;
  double p[N_P], n[K], x[SOFTSOIL_N_X], m[SOFTSOIL_CELLS], y[SOFTSOIL_N_Y], start[NS], moved = 1.0;
  double full[SOFTSOIL_N_U + SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)] = {0.0};
  const double no_force[SOFTSOIL_SOME(CALLS * OUTPUTS)] = {0.0};
  for (int i = 0; i < N_P; ++i) p[i] = shared[i] >= 0 ? o->p[shared[i]] : declared[i];
  memcpy(n, v->n, sizeof n);
  memcpy(start, v->state, sizeof start);
  if (own >= 0) {
    moved = step_of[own];
    p[at_parameter[own]] += moved * unit[own];
  } else if (soil >= 0) {
    moved = free_step * scale[soil] * (n[soil] + free_step * scale[soil] > highest[soil] ? -1.0 : 1.0);
    n[soil] += moved;
  } else if (state >= 0) {
    moved = state_step[state];
    start[state] += moved;
  }
  if (column > 0 && soil < 0) {
    put_carried(x, m, v->memory[1]);
  } else {
    double states[NS];
    put_carried(x, m, v->memory[0]);
    for (int64_t row = v->from; row < v->row; ++row) {
      softsoil_horizon_states(h, row, states);
      put(x, states, n);
      onwards(h, row, p, x, m);
    }
    for (int i = 0; i < OTHERS && column == 0; ++i) v->memory[1][i] = x[other_state[i]];
    for (int c = 0; c < SOFTSOIL_N_M && column == 0; ++c) v->memory[1][OTHERS + c] = m[c];
  }
  put(x, start, n);
  for (int s = 0; s <= v->steps; ++s) {
    const softsoil_horizon_row_t *row = row_at(h, v->row + s);
    memcpy(full, row->u, sizeof row->u);
    own_measure(x, full, p, no_force, y);
    for (int c = 0; c < SOFTSOIL_N_Y; ++c) {
      const double sigma = sigma_of(o, c);
      if (!(fabs(y[c]) < 1e12)) return 0;
      if (column > 0) {
        v->slope[column - 1][s][c] = isfinite(sigma) ? (y[c] - v->at[s][c]) / sigma / moved : 0.0;
        continue;
      }
      double error = y[c] - row->y[c];
      if (y_wraps[c]) error -= 6.283185307179586 * floor(error / 6.283185307179586 + 0.5);
      v->at[s][c] = y[c];
      v->residual[s][c] = row->seen[c] && isfinite(sigma) ? error / sigma : 0.0;
      v->weight[s][c] = !row->seen[c] ? 0.0 : fabs(v->residual[s][c]) > huber ? huber / fabs(v->residual[s][c]) : 1.0;
    }
    if (s < v->steps) onwards(h, v->row + s, p, x, m);
  }
  return 1;
}

/* The window's quadratic in what is asked, its initial state eliminated, added to those before it, which count less. */
static int take(softsoil_vehicle_t *v, double dt) {
  double normal[D][D] = {{0.0}}, lean[D] = {0.0}, a[NS * NS], inverse[NS * NS], solved[NS][Q], one[Q][Q], own[Q];
  for (int s = 0; s <= v->steps; ++s)
    for (int c = 0; c < SOFTSOIL_N_Y; ++c) {
      if (!(v->weight[s][c] > 0.0)) continue;
      for (int i = 0; i < D; ++i) {
        const double weighted = v->weight[s][c] * v->slope[i][s][c];
        lean[i] += weighted * v->residual[s][c];
        for (int j = 0; j <= i; ++j) normal[i][j] += weighted * v->slope[j][s][c];
      }
    }
  for (int r = 0; r < NS; ++r)
    for (int c = 0; c < NS; ++c) a[r * NS + c] = (r > c ? normal[r][c] : normal[c][r]) + (r == c ? ridge : 0.0);
  if (!invert(NS, a, inverse)) return 0;
  for (int r = 0; r < NS; ++r)
    for (int k = 0; k < Q; ++k) {
      solved[r][k] = 0.0;
      for (int c = 0; c < NS; ++c) solved[r][k] += inverse[r * NS + c] * normal[NS + k][c];
    }
  for (int k = 0; k < Q; ++k) {
    own[k] = lean[NS + k];
    for (int r = 0; r < NS; ++r) own[k] -= solved[r][k] * lean[r];
    for (int l = 0; l < Q; ++l) {
      one[k][l] = k > l ? normal[NS + k][NS + l] : normal[NS + l][NS + k];
      for (int r = 0; r < NS; ++r) one[k][l] -= normal[NS + k][r] * solved[r][l];
      if (!isfinite(one[k][l])) return 0;
    }
    if (!isfinite(own[k])) return 0;
  }
  const double elapsed = v->windows ? (double)(v->row - v->before) * dt : stride;
  const double keep = v->windows ? exp(-elapsed / forgetting) : 0.0, share = elapsed < window_length ? elapsed / window_length : 1.0;
  for (int k = 0; k < Q; ++k) {
    v->lean[k] = keep * v->lean[k] - share * own[k];
    for (int l = 0; l < Q; ++l) {
      v->information[k][l] = keep * v->information[k][l] + share * one[k][l];
      if (l < K) v->lean[k] += share * one[k][l] * v->n[l];
    }
  }
  v->before = v->row;
  ++v->windows;
  return 1;
}

/* Strain of the numbers without a load, the load with the numbers free within their joint error, and the steering's scale beside
 * it: a wrong mass hides one of them behind the other. */
static void judge(softsoil_vehicle_t *v) {
  /* Not on the stack: gcc 12 aligns such arrays there to 16 bytes and stores to them as if to 32. */
  double *a = v->work[0], *inverse = v->work[1], *marginal = v->work[2], step[Q], soil[K * K], soil_inverse[K * K];
  double square = 0.0, expected = NUMBERS, load = 0.0, load_variance = 0.0;
  for (int beside = 0; beside < 3; ++beside) {
    const int size = Q - 2 + beside;
    for (int k = 0; k < size; ++k)
      for (int l = 0; l < size; ++l) {
        const int r = k - K, c = l - K;
        a[k * size + l] = v->information[k][l] + (k == l && k < K ? least_curvature : 0.0);
        if (r >= 0 && c >= 0 && r < NUMBERS && c < NUMBERS) a[k * size + l] += known[r][c];
        if (k == LOAD && l == LOAD) a[k * size + l] += known_load;
        if (k == SCALE && l == SCALE) a[k * size + l] += known_scale;
      }
    if (!invert(size, a, inverse)) return;
    for (int k = 0; k < size; ++k) {
      step[k] = 0.0;
      for (int l = 0; l < size; ++l) step[k] += inverse[k * size + l] * v->lean[l];
    }
    if (beside == 1) {
      load = step[LOAD];
      load_variance = inverse[LOAD * size + LOAD];
    }
    if (beside) continue;
    for (int r = 0; r < NUMBERS; ++r)
      for (int c = 0; c < NUMBERS; ++c) square += step[K + r] * known[r][c] * step[K + c];
  }
  const double turned = step[SCALE], turned_variance = inverse[SCALE * Q + SCALE];
  for (int k = 0; k < K; ++k)
    for (int l = 0; l < K; ++l) soil[k * K + l] = v->information[k][l] + (k == l ? least_curvature : 0.0);
  if (!invert(K, soil, soil_inverse)) return;
  for (int r = 0; r < NUMBERS; ++r)
    for (int c = 0; c < NUMBERS; ++c) {
      double sum = v->information[K + r][K + c] + known[r][c];
      for (int k = 0; k < K; ++k)
        for (int l = 0; l < K; ++l) sum -= v->information[K + r][k] * soil_inverse[k * K + l] * v->information[l][K + c];
      marginal[r * NUMBERS + c] = sum;
    }
  if (!invert(NUMBERS, marginal, inverse)) return;
  for (int r = 0; r < NUMBERS; ++r)
    for (int c = 0; c < NUMBERS; ++c) expected -= inverse[r * NUMBERS + c] * known[c][r];
  const double strain = square / larger(expected, 1.0);
  if (!isfinite(strain) || !isfinite(load) || !(load_variance >= 0.0) || !isfinite(turned) || !(turned_variance >= 0.0)) return;
  v->strain = strain;
  v->load = load;
  v->load_std = sqrt(load_variance + declared_load_std * declared_load_std);
  v->steering = turned;
  v->steering_std = sqrt(turned_variance);
  const int other = fabs(v->load) > larger(least_load, load_sigmas * v->load_std), a_load = v->load > lightest && v->load < heaviest;
  const int turns = fabs(turned) > larger(least_steering, steering_sigmas * v->steering_std);
  v->change = other && a_load                    ? SOFTSOIL_VEHICLE_OTHER_MASS
              : turns                            ? SOFTSOIL_VEHICLE_OTHER_STEERING
              : other || strain > most_strain    ? SOFTSOIL_VEHICLE_STRAINED
              : sqrt(load_variance) <= load_seen ? SOFTSOIL_VEHICLE_SAME
                                                 : SOFTSOIL_VEHICLE_UNKNOWN;
}

int softsoil_vehicle_update(softsoil_vehicle_t *v, softsoil_horizon_t *h) {
  int taken = 0;
  if (!v || !h) return SOFTSOIL_NULL_POINTER;
  if (v->magic != MAGIC || h->magic != SOFTSOIL_HORIZON_MAGIC) return SOFTSOIL_NOT_INITIALISED;
  if (v->next >= 0 && (h->taken < v->taken || h->changes != v->changes || v->from < h->rows - SOFTSOIL_HORIZON_ROWS)) v->next = -1;
  if (v->next >= 0 || begin(v, h)) {
    if (!run(v, h, v->next)) {
      v->next = -1;
    } else if (++v->next > D) {
      v->next = -1;
      taken = take(v, h->options.dt);
      if (taken) judge(v);
    }
  }
  if (h->vehicle != v->change) {
    h->vehicle = v->change;
    h->verdict = softsoil_horizon_verdict(h);
  }
  return taken;
}
