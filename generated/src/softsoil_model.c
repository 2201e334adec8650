/* The model at many points, single steps, rollouts and the force of one wheel; the equations are in softsoil_kernels.h. */
#include "softsoil_model.h"

#include "softsoil_lanes.h"

#include "softsoil_kernels.h"

#define GROUPS(n) (((n) + SOFTSOIL_LANES - 1) / SOFTSOIL_LANES)
#define PAIRS (SOFTSOIL_CALLS * SOFTSOIL_ACTIVE_POINTS)
#define PAIR_ROW (GROUPS(PAIRS) * SOFTSOIL_LANES + SOFTSOIL_LANES)

typedef void law_t(const ssv *arguments, const double *p, ssv *outputs);

/* The last group may reach past the last of the pairs by more than the surplus that was written: it repeats the last ones. */
static int first_of_group(int g, int pairs) {
  const int at = g * SOFTSOIL_LANES;
  return at + SOFTSOIL_LANES > pairs && pairs >= SOFTSOIL_LANES ? pairs - SOFTSOIL_LANES : at;
}

/* One law at `wheels` wheels from `first` on. */
static void forces_of(int first, int wheels, law_t *one, law_t *side_by_side, const double (*arguments)[PAIR_ROW],
                      const double *p, double (*found)[PAIR_ROW]) {
  const int from = first * SOFTSOIL_ACTIVE_POINTS, pairs = wheels * SOFTSOIL_ACTIVE_POINTS;
  for (int g = 0, side; g < GROUPS(pairs); g += side) {
    ssv argument[SOFTSOIL_SIDE * SOFTSOIL_SOME(SOFTSOIL_ARGUMENTS)], force[SOFTSOIL_SIDE * SOFTSOIL_SOME(SOFTSOIL_OUTPUTS)];
    side = g + SOFTSOIL_SIDE <= GROUPS(pairs) ? SOFTSOIL_SIDE : 1;
    for (int k = 0; k < side; ++k)
      for (int a = 0; a < SOFTSOIL_ARGUMENTS; ++a)
        argument[k * SOFTSOIL_ARGUMENTS + a] = ssv_load(&arguments[a][from + first_of_group(g + k, pairs)]);
    (side == SOFTSOIL_SIDE ? side_by_side : one)(argument, p, force);
    for (int k = 0; k < side; ++k)
      for (int o = 0; o < SOFTSOIL_OUTPUTS; ++o)
        ssv_store(&found[o][from + first_of_group(g + k, pairs)], force[k * SOFTSOIL_OUTPUTS + o]);
  }
}

/* Arguments of all wheels in one row after the other: the law then runs over pairs of wheel and point, no lane idle but
 * the last. A group's surplus lanes land where the next wheel's first group overwrites them, or behind the last. */
void softsoil_model_forces(const softsoil_points_t *x, const double *u, const double *p, softsoil_forces_t *out) {
  double arguments[SOFTSOIL_SOME(SOFTSOIL_ARGUMENTS)][PAIR_ROW];
  double found[SOFTSOIL_SOME(SOFTSOIL_OUTPUTS)][PAIR_ROW];
  ssv before[GROUPS(SOFTSOIL_ACTIVE_POINTS)][SOFTSOIL_SOME(SOFTSOIL_CALLS * SOFTSOIL_ARGUMENTS)];
  for (int g = 0; g < GROUPS(SOFTSOIL_ACTIVE_POINTS); ++g) {
    ssv point[SOFTSOIL_N_X];
    for (int i = 0; i < SOFTSOIL_N_X; ++i) point[i] = ssv_load(&x[i][g * SOFTSOIL_LANES]);
    kernel_before(point, u, p, before[g]);
  }
  for (int call = 0; call < SOFTSOIL_CALLS; ++call)
    for (int a = 0; a < SOFTSOIL_ARGUMENTS; ++a)
      for (int g = 0; g < GROUPS(SOFTSOIL_ACTIVE_POINTS); ++g)
        ssv_store(&arguments[a][call * SOFTSOIL_ACTIVE_POINTS + g * SOFTSOIL_LANES],
                  before[g][call * SOFTSOIL_ARGUMENTS + a]);
#define RUN(first, wheels, scalar, one, side) forces_of(first, wheels, one, side, (const double (*)[PAIR_ROW])arguments, p, found);
  SOFTSOIL_LAWS(RUN)
#undef RUN
  for (int call = 0; call < SOFTSOIL_CALLS; ++call)
    for (int o = 0; o < SOFTSOIL_OUTPUTS; ++o) {
      double *row = out->f[call * SOFTSOIL_OUTPUTS + o];
      const double *from = &found[o][call * SOFTSOIL_ACTIVE_POINTS];
      for (int k = 0; k < SOFTSOIL_ROW; ++k) row[k] = from[k < SOFTSOIL_ACTIVE_POINTS ? k : 0];
    }
}

static void gather(const softsoil_points_t *rows, int count, int g, ssv *out) {
  for (int i = 0; i < count; ++i) out[i] = ssv_load(&rows[i][g * SOFTSOIL_LANES]);
}

static void scatter(const ssv *in, int count, int g, softsoil_points_t *rows) {
  for (int i = 0; i < count; ++i) ssv_store(&rows[i][g * SOFTSOIL_LANES], in[i]);
}

void softsoil_model_rates(const softsoil_points_t *x, const double *u, const double *p, const softsoil_forces_t *forces,
                          softsoil_points_t *rates) {
  for (int g = 0; g < GROUPS(SOFTSOIL_POINTS); ++g) {
    ssv point[SOFTSOIL_N_X], rate[SOFTSOIL_N_X], force[SOFTSOIL_SOME(SOFTSOIL_FORCES)];
    gather(x, SOFTSOIL_N_X, g, point);
    gather(forces->f, SOFTSOIL_FORCES, g, force);
    kernel_after(point, u, p, force, rate);
    scatter(rate, SOFTSOIL_N_X, g, rates);
  }
}

void softsoil_model_measure(const softsoil_points_t *x, const double *u, const double *p,
                            const softsoil_forces_t *forces, softsoil_points_t *y) {
  for (int g = 0; g < GROUPS(SOFTSOIL_POINTS); ++g) {
    ssv point[SOFTSOIL_N_X], seen[SOFTSOIL_N_Y], force[SOFTSOIL_SOME(SOFTSOIL_FORCES)];
    gather(x, SOFTSOIL_N_X, g, point);
    for (int i = 0; i < SOFTSOIL_FORCES; ++i)
      force[i] = forces ? ssv_load(&forces->f[i][g * SOFTSOIL_LANES]) : ssv_all(0.0);
    kernel_measure(point, u, p, force, seen);
    scatter(seen, SOFTSOIL_N_Y, g, y);
  }
}

void softsoil_model_read(const double *x, const double *u_external, const double *p, const double *m, double *u) {
  for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = u_external[i];
  scalar_read(x, u_external, p, m, u + SOFTSOIL_N_U);
}

void softsoil_model_advance(const double *x, const double *u, const double *p, double *m, double dt,
                            const softsoil_forces_t *forces) {
  double centre[SOFTSOIL_SOME(SOFTSOIL_FORCES)], next[SOFTSOIL_CELLS];
  for (int i = 0; i < SOFTSOIL_FORCES; ++i) centre[i] = forces->f[i][0];
  scalar_advance(x, u, p, m, &dt, centre, next);
  for (int i = 0; i < SOFTSOIL_N_M; ++i) m[i] = next[i];
}

/* All wheels at one state, without vectors. */
static void scalar_forces(const double *x, const double *u, const double *p, double *force) {
  double arguments[SOFTSOIL_SOME(SOFTSOIL_CALLS * SOFTSOIL_ARGUMENTS)];
  scalar_before(x, u, p, arguments);
#define RUN(first, wheels, scalar, one, side) \
  for (int call = first; call < first + wheels; ++call) \
    scalar(arguments + call * SOFTSOIL_ARGUMENTS, p, force + call * SOFTSOIL_OUTPUTS);
  SOFTSOIL_LAWS(RUN)
#undef RUN
}

void softsoil_model_start(const double *x, const double *u_external, const double *p, double *m) {
  static const double nominal[SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  double u[SOFTSOIL_N_U + SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)], force[SOFTSOIL_SOME(SOFTSOIL_FORCES)];
  for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = u_external[i];
  for (int i = 0; i < SOFTSOIL_N_PROVIDED; ++i) u[SOFTSOIL_N_U + i] = nominal[i];
  scalar_forces(x, u, p, force);
  scalar_start(x, u, p, force, m);
}

int softsoil_force(const double soil[8], const double contact[9], double force[6]) {
  if (!soil || !contact || !force) return SOFTSOIL_NULL_POINTER;
  for (int i = 0; i < 8; ++i)
    if (!isfinite(soil[i])) return SOFTSOIL_BAD_ARGUMENT;
  for (int i = 0; i < 9; ++i)
    if (!isfinite(contact[i])) return SOFTSOIL_BAD_ARGUMENT;
  scalar_force(soil, contact, force);
  for (int i = 0; i < 6; ++i)
    if (!isfinite(force[i])) return SOFTSOIL_NUMERICAL;
  return SOFTSOIL_OK;
}

static int bad_step(double dt) {
  if (!isfinite(dt)) return SOFTSOIL_DT_NOT_FINITE;
  if (dt < 0.0) return SOFTSOIL_DT_NEGATIVE;
  if (!(dt > 0.0)) return SOFTSOIL_DT_ZERO;
  return dt > SOFTSOIL_MAX_STEP ? SOFTSOIL_DT_TOO_LONG : SOFTSOIL_OK;
}

int softsoil_history(const double p[SOFTSOIL_N_P], const double x[SOFTSOIL_N_X], const double u[SOFTSOIL_N_U],
                     double *m) {
  if (!p || !x || !u || (SOFTSOIL_N_M > 0 && !m)) return SOFTSOIL_NULL_POINTER;
  for (int i = 0; i < SOFTSOIL_N_X; ++i)
    if (!isfinite(x[i])) return SOFTSOIL_BAD_ARGUMENT;
  for (int i = 0; i < SOFTSOIL_N_U; ++i)
    if (!isfinite(u[i])) return SOFTSOIL_BAD_ARGUMENT;
  if (SOFTSOIL_N_M > 0) softsoil_model_start(x, u, p, m);
  return SOFTSOIL_OK;
}

int softsoil_step(const double p[SOFTSOIL_N_P], double dt, double x[SOFTSOIL_N_X], double *m, const double u[SOFTSOIL_N_U]) {
  double full[SOFTSOIL_N_U + SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)], force[SOFTSOIL_SOME(SOFTSOIL_FORCES)];
  double rate[SOFTSOIL_N_X], next[SOFTSOIL_CELLS];
  if (!p || !x || !u || (SOFTSOIL_N_M > 0 && !m)) return SOFTSOIL_NULL_POINTER;
  const int bad = bad_step(dt);
  if (bad) return bad;
  softsoil_model_read(x, u, p, m, full);
  scalar_forces(x, full, p, force);
  scalar_after(x, full, p, force, rate);
  if (SOFTSOIL_N_M > 0) scalar_advance(x, full, p, m, &dt, force, next);
  for (int i = 0; i < SOFTSOIL_N_X; ++i)
    if (!isfinite(rate[i])) return SOFTSOIL_NUMERICAL;
  for (int i = 0; i < SOFTSOIL_N_X; ++i) x[i] += dt * rate[i];
  for (int i = 0; i < SOFTSOIL_N_M; ++i) m[i] = next[i];
  return SOFTSOIL_OK;
}

/* One law at `wheels` wheels from `first` on, each at one vector of points. */
static inline void lanes_of(int first, int wheels, law_t *one, law_t *side_by_side, const ssv *arguments, const double *p,
                            ssv *force) {
  int call = first;
  for (; call + SOFTSOIL_SIDE <= first + wheels; call += SOFTSOIL_SIDE)
    side_by_side(arguments + call * SOFTSOIL_ARGUMENTS, p, force + call * SOFTSOIL_OUTPUTS);
  for (; call < first + wheels; ++call)
    one(arguments + call * SOFTSOIL_ARGUMENTS, p, force + call * SOFTSOIL_OUTPUTS);
}

int softsoil_rollout(const double p[SOFTSOIL_N_P], double dt, size_t count, size_t steps, const double *x0,
                     const double *m0, const double *u, double *x) {
  if (!p || !x0 || !u || !x) return SOFTSOIL_NULL_POINTER;
  const int bad = bad_step(dt);
  if (bad) return bad;
  if (count == 0 || steps == 0) return SOFTSOIL_BAD_ARGUMENT;
  int status = SOFTSOIL_OK;
  const ssv step_length = ssv_all(dt);
  for (size_t from = 0; from < count; from += SOFTSOIL_LANES) {
    const size_t width = count - from < SOFTSOIL_LANES ? count - from : SOFTSOIL_LANES;
    double lane[SOFTSOIL_LANES];
    ssv state[SOFTSOIL_N_X], full[SOFTSOIL_N_U + SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)], cells[2][SOFTSOIL_CELLS];
    ssv arguments[SOFTSOIL_SOME(SOFTSOIL_CALLS * SOFTSOIL_ARGUMENTS)], force[SOFTSOIL_SOME(SOFTSOIL_FORCES)];
    ssv rate[SOFTSOIL_N_X];
    for (int i = 0; i < SOFTSOIL_N_X; ++i) {
      for (size_t l = 0; l < SOFTSOIL_LANES; ++l) lane[l] = x0[(size_t)i * count + from + (l < width ? l : width - 1)];
      state[i] = ssv_load(lane);
    }
    if (SOFTSOIL_N_M > 0) {
      double first[SOFTSOIL_LANES][SOFTSOIL_CELLS];
      for (size_t l = 0; l < SOFTSOIL_LANES; ++l) {
        const size_t c = from + (l < width ? l : width - 1);
        double x_c[SOFTSOIL_N_X], u_c[SOFTSOIL_N_U];
        for (int i = 0; i < SOFTSOIL_N_X; ++i) x_c[i] = x0[(size_t)i * count + c];
        for (int i = 0; i < SOFTSOIL_N_U; ++i) u_c[i] = u[(size_t)i * count + c];
        if (m0) {
          memcpy(first[l], m0, sizeof first[l]);
        } else {
          softsoil_model_start(x_c, u_c, p, first[l]);
        }
      }
      for (int i = 0; i < SOFTSOIL_N_M; ++i) {
        for (size_t l = 0; l < SOFTSOIL_LANES; ++l) lane[l] = first[l][i];
        cells[0][i] = ssv_load(lane);
      }
    }
    for (size_t k = 0; k < steps; ++k) {
      for (int i = 0; i < SOFTSOIL_N_U; ++i) {
        const double *row = u + (k * SOFTSOIL_N_U + (size_t)i) * count + from;
        if (width == SOFTSOIL_LANES) {
          full[i] = ssv_load(row);
        } else {
          for (size_t l = 0; l < SOFTSOIL_LANES; ++l) lane[l] = row[l < width ? l : width - 1];
          full[i] = ssv_load(lane);
        }
      }
      lanes_read(state, full, p, cells[k % 2], full + SOFTSOIL_N_U);
      lanes_before(state, full, p, arguments);
#define RUN(first, wheels, scalar, one, side) lanes_of(first, wheels, one, side, arguments, p, force);
      SOFTSOIL_LAWS(RUN)
#undef RUN
      lanes_after(state, full, p, force, rate);
      lanes_advance(state, full, p, cells[k % 2], &dt, force, cells[(k + 1) % 2]);
      for (int i = 0; i < SOFTSOIL_N_X; ++i) {
        double *row = x + (k * SOFTSOIL_N_X + (size_t)i) * count + from;
        state[i] = state[i] + step_length * rate[i];
        if (width == SOFTSOIL_LANES) {
          ssv_store(row, state[i]);
        } else {
          ssv_store(lane, state[i]);
          for (size_t l = 0; l < width; ++l) row[l] = lane[l];
        }
      }
    }
    for (int i = 0; i < SOFTSOIL_N_X; ++i) {
      ssv_store(lane, state[i]);
      for (size_t l = 0; l < width; ++l)
        if (!isfinite(lane[l])) status = SOFTSOIL_NUMERICAL;
    }
  }
  return status;
}

/* Whether the vector from column `at` on holds a job. */
static int has_jobs(int at, int active, int passive) {
  return at < SOFTSOIL_PASSIVE_AT ? at < active : at < SOFTSOIL_PASSIVE_AT + passive;
}

void softsoil_model_step_jobs(int active, int passive, const double *u, const double *p, double dt, int substeps,
                              softsoil_jobs_t *x, softsoil_jobs_t *m) {
  double provided[SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)] = {0.0};
  double shared[SOFTSOIL_JOB_SUBSTEPS][SOFTSOIL_SOME(SOFTSOIL_FORCES)] = {{0.0}};
  const ssv length = ssv_all(dt / substeps);
  for (int at = 0; at < SOFTSOIL_JOB_ROW; at += SOFTSOIL_LANES) {
    const int own = at < SOFTSOIL_PASSIVE_AT;
    ssv state[SOFTSOIL_N_X], full[SOFTSOIL_N_U + SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)], cells[SOFTSOIL_CELLS];
    ssv arguments[SOFTSOIL_SOME(SOFTSOIL_CALLS * SOFTSOIL_ARGUMENTS)], force[SOFTSOIL_SOME(SOFTSOIL_FORCES)];
    ssv rate[SOFTSOIL_N_X], next[SOFTSOIL_CELLS];
    if (!has_jobs(at, active, passive)) continue;
    for (int i = 0; i < SOFTSOIL_N_X; ++i) state[i] = ssv_load(&x[i][at]);
    for (int i = 0; i < SOFTSOIL_N_U; ++i) full[i] = ssv_all(u[i]);
    if (own) {
      for (int i = 0; i < SOFTSOIL_N_M; ++i) cells[i] = ssv_load(&m[i][at]);
      lanes_read(state, full, p, cells, full + SOFTSOIL_N_U);
      for (int i = 0; i < SOFTSOIL_N_PROVIDED && at == 0; ++i) provided[i] = ssv_first(full[SOFTSOIL_N_U + i]);
    } else {
      for (int i = 0; i < SOFTSOIL_N_PROVIDED; ++i) full[SOFTSOIL_N_U + i] = ssv_all(provided[i]);
    }
    for (int k = 0; k < substeps; ++k) {
      if (own) {
        lanes_before(state, full, p, arguments);
#define RUN(first, wheels, scalar, one, side) lanes_of(first, wheels, one, side, arguments, p, force);
        SOFTSOIL_LAWS(RUN)
#undef RUN
        for (int i = 0; i < SOFTSOIL_FORCES && at == 0; ++i) shared[k][i] = ssv_first(force[i]);
      } else {
        for (int i = 0; i < SOFTSOIL_FORCES; ++i) force[i] = ssv_all(shared[k][i]);
      }
      lanes_after(state, full, p, force, rate);
      if (own && k == 0 && SOFTSOIL_N_M > 0) {
        lanes_advance(state, full, p, cells, &dt, force, next);
        for (int i = 0; i < SOFTSOIL_N_M; ++i) ssv_store(&m[i][at], next[i]);
      }
      for (int i = 0; i < SOFTSOIL_N_X; ++i) state[i] = state[i] + length * rate[i];
    }
    for (int i = 0; i < SOFTSOIL_N_X; ++i) ssv_store(&x[i][at], state[i]);
  }
}

void softsoil_model_measure_jobs(int active, int passive, const double *u, const double *p, const softsoil_jobs_t *x,
                                 softsoil_jobs_t *y) {
  double full[SOFTSOIL_N_U + SOFTSOIL_SOME(SOFTSOIL_N_PROVIDED)] = {0.0};
  for (int i = 0; i < SOFTSOIL_N_U; ++i) full[i] = u[i];
  for (int at = 0; at < SOFTSOIL_JOB_ROW; at += SOFTSOIL_LANES) {
    ssv state[SOFTSOIL_N_X], force[SOFTSOIL_SOME(SOFTSOIL_FORCES)], seen[SOFTSOIL_N_Y];
    if (!has_jobs(at, active, passive)) continue;
    for (int i = 0; i < SOFTSOIL_N_X; ++i) state[i] = ssv_load(&x[i][at]);
    for (int i = 0; i < SOFTSOIL_SOME(SOFTSOIL_FORCES); ++i) force[i] = ssv_all(0.0);
    kernel_measure(state, full, p, force, seen);
    for (int i = 0; i < SOFTSOIL_N_Y; ++i) ssv_store(&y[i][at], seen[i]);
  }
}
