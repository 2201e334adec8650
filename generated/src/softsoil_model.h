/* Between the library's two halves; nothing here is for callers. */
#ifndef SOFTSOIL_MODEL_H
#define SOFTSOIL_MODEL_H

#include "softsoil_horizon.h"

#define SOFTSOIL_POINTS (2 * SOFTSOIL_N_X + 1)
/* Points per row: a multiple of the widest vector. */
#define SOFTSOIL_ROW (((SOFTSOIL_POINTS + 7) / 8) * 8)
/* States on which the force of some wheel depends; the first in softsoil_order. */
#define SOFTSOIL_ACTIVE 4
#define SOFTSOIL_ACTIVE_POINTS (2 * SOFTSOIL_ACTIVE + 1)
#define SOFTSOIL_CALLS 4
#define SOFTSOIL_ARGUMENTS 11
#define SOFTSOIL_OUTPUTS 7
#define SOFTSOIL_FORCES (SOFTSOIL_CALLS * SOFTSOIL_OUTPUTS)
#define SOFTSOIL_MEASURES_FORCES 0
#define SOFTSOIL_N_PROVIDED 14
/* Arrays in C have at least one entry. */
#define SOFTSOIL_SOME(n) ((n) > 0 ? (n) : 1)

#define SOFTSOIL_CELLS SOFTSOIL_SOME(SOFTSOIL_N_M)

/* The order of the factor's rows: active states first, so that the others share the centre's forces. */
static const int softsoil_order[SOFTSOIL_N_X] = {3, 4, 5, 6, 0, 1, 2};

/* Points are columns: 0 the centre, then the active pairs, then the rest. F: forces of all wheels at all points. */
typedef double softsoil_points_t[SOFTSOIL_ROW];
typedef struct {
  softsoil_points_t f[SOFTSOIL_SOME(SOFTSOIL_FORCES)];
} softsoil_forces_t;

void softsoil_model_forces(const softsoil_points_t *x, const double *u, const double *p, softsoil_forces_t *out);
void softsoil_model_rates(const softsoil_points_t *x, const double *u, const double *p, const softsoil_forces_t *forces,
                          softsoil_points_t *rates);
void softsoil_model_measure(const softsoil_points_t *x, const double *u, const double *p,
                            const softsoil_forces_t *forces, softsoil_points_t *y);
/* Histories: full input, the next cells (force at the centre in `forces`), the first cells. */
void softsoil_model_read(const double *x, const double *u_external, const double *p, const double *m, double *u);
void softsoil_model_advance(const double *x, const double *u, const double *p, double *m, double dt,
                            const softsoil_forces_t *forces);
void softsoil_model_start(const double *x, const double *u_external, const double *p, double *m);

/* Jobs: trajectories in step with one another under the same inputs. Columns 0 to `active` have wheels of their own; the
 * `passive` ones from SOFTSOIL_PASSIVE_AT on differ from column 0 in states that no wheel and no history depends on, and
 * share its forces. */
#define SOFTSOIL_JOBS (7 + 1)
#define SOFTSOIL_PASSIVE_AT ((SOFTSOIL_JOBS + 7) / 8 * 8)
#define SOFTSOIL_JOB_ROW (SOFTSOIL_PASSIVE_AT + 8)
#define SOFTSOIL_JOB_SUBSTEPS 8
typedef double softsoil_jobs_t[SOFTSOIL_JOB_ROW];
/* States x (N_X rows) and histories m (N_M rows) one sample of dt later, in so many Euler steps. */
void softsoil_model_step_jobs(int active, int passive, const double *u, const double *p, double dt, int substeps,
                              softsoil_jobs_t *x, softsoil_jobs_t *m);
/* Measurements y (N_Y rows) of states x, for models whose measurements are functions of the states. */
void softsoil_model_measure_jobs(int active, int passive, const double *u, const double *p, const softsoil_jobs_t *x,
                                 softsoil_jobs_t *y);

/* What the horizon shares with what runs beside it. */
#define SOFTSOIL_HORIZON_MAGIC 0x7e2c4f07u

/* States at a row that is kept: of the windows over it or beside it, else the record smoothed by a quadratic. */
void softsoil_horizon_states(const softsoil_horizon_t *h, int64_t row, double states[SOFTSOIL_HORIZON_STATES]);
/* Inputs a share of a step after a row, on a straight line to the next. */
void softsoil_horizon_inputs(const softsoil_horizon_t *h, int64_t row, double share, double u[SOFTSOIL_N_U]);
/* The inverse of a symmetric positive matrix (n x n), 0 where it is not positive; work: 2 n^2 numbers. */
int softsoil_invert(int n, const double *a, double *inverse, double *work);
/* The verdict on the estimate as it stands. */
int softsoil_horizon_verdict(const softsoil_horizon_t *h);

#endif
