/* Rows from sensors of different rates: samples kept by time, interpolated where a row is due. */
#include "softsoil_rows.h"

#include <math.h>
#include <string.h>

#define MAGIC 0x50F7A0B5u
#define TURN 6.283185307179586
#define SAMPLES SOFTSOIL_ROWS_SAMPLES

static const double most_gap = 0.25;       /* s, between samples that a line connects, and of an input that is held */
static const double together = 0.5;  /* s, of what a first state is made of */
static const double longest = 1.0, pause = 5.0, farthest = 1000000000000.0; /* s */
static const double slope_over = 0.06;   /* s to either side, of a speed whose slope stands for the accelerometer */
static const int input_of[4] = {SOFTSOIL_U_omega_fl, SOFTSOIL_U_omega_fr, SOFTSOIL_U_omega_rl, SOFTSOIL_U_omega_rr};
static const int measured_by[SOFTSOIL_N_Y] = {SOFTSOIL_SENSOR_x, SOFTSOIL_SENSOR_y, SOFTSOIL_SENSOR_psi, SOFTSOIL_SENSOR_u, SOFTSOIL_SENSOR_v, SOFTSOIL_SENSOR_omega_z}; /* sensor of each measurement */

int softsoil_rows_init(softsoil_rows_t *r, double dt, double delay) {
  if (!r) return SOFTSOIL_NULL_POINTER;
  if (!(dt > 0.0 && dt <= 0.1) || !(delay >= 0.0 && delay <= longest)) return SOFTSOIL_BAD_ARGUMENT;
  memset(r, 0, sizeof *r);
  r->magic = MAGIC;
  r->dt = dt;
  r->delay = delay;
  r->next = r->asked = (double)NAN;
  return SOFTSOIL_OK;
}

/* The clock was set back, or nothing was asked for for long: what is known is of another time. */
static void begin_anew(softsoil_rows_t *r) {
  memset(r->count, 0, sizeof r->count);
  r->next = r->asked = (double)NAN;
  ++r->restarts;
}

int softsoil_rows_put(softsoil_rows_t *r, int sensor, double t, double value) {
  if (!r) return SOFTSOIL_NULL_POINTER;
  if (r->magic != MAGIC) return SOFTSOIL_NOT_INITIALISED;
  if (sensor < 0 || sensor >= SOFTSOIL_SENSORS) return SOFTSOIL_BAD_ARGUMENT;
  if (!(fabs(t) < farthest) || !isfinite(value) || t > r->asked + pause) {
    ++r->refused[sensor];
    return SOFTSOIL_MEASUREMENT_NOT_FINITE;
  }
  if (isnan(r->next)) r->next = t;
  if (t < r->next - most_gap) {
    ++r->late[sensor];
    return SOFTSOIL_MEASUREMENT_LATE;
  }
  double *times = r->t[sensor], *values = r->value[sensor];
  int at = r->count[sensor];
  while (at > 0 && times[at - 1] > t) --at;
  if (at > 0 && times[at - 1] == t) { /* said again */
    values[at - 1] = value;
    return SOFTSOIL_OK;
  }
  /* What a row still needs has to fit: of a fast sensor with a long delay, samples are thinned. */
  const double apart = (r->delay + 2.0 * together + most_gap) / (SAMPLES - 2);
  if (at == r->count[sensor] && at > SAMPLES / 2 && t - times[at - 1] < apart) return SOFTSOIL_OK;
  if (r->count[sensor] == SAMPLES) { /* the oldest goes */
    if (at == 0) {
      ++r->late[sensor];
      return SOFTSOIL_MEASUREMENT_LATE;
    }
    memmove(times, times + 1, (size_t)(at - 1) * sizeof *times);
    memmove(values, values + 1, (size_t)(at - 1) * sizeof *values);
    --at;
  } else {
    memmove(times + at + 1, times + at, (size_t)(r->count[sensor] - at) * sizeof *times);
    memmove(values + at + 1, values + at, (size_t)(r->count[sensor] - at) * sizeof *values);
    ++r->count[sensor];
  }
  times[at] = t;
  values[at] = value;
  if (t > r->next - 0.5 * r->dt) return SOFTSOIL_OK;
  ++r->late[sensor]; /* its own row has been made; between samples it still counts */
  return SOFTSOIL_MEASUREMENT_LATE;
}

/* On the line from sample i to sample k of a sensor, at time t. */
static double on_line(const softsoil_rows_t *r, int sensor, int i, int k, double t) {
  const double *times = r->t[sensor], turned = r->value[sensor][k] - r->value[sensor][i];
  const double change = sensor == SOFTSOIL_SENSOR_psi ? turned - TURN * floor(turned / TURN + 0.5) : turned;
  return r->value[sensor][i] + change * (t - times[i]) / (times[k] - times[i]);
}

/* A sensor's value at time t, on the line between its neighbours, or the last one, up to `old` s; NaN without. */
static double value_at(const softsoil_rows_t *r, int sensor, double t, double old) {
  const double *times = r->t[sensor];
  int after = r->count[sensor];
  while (after > 0 && times[after - 1] > t) --after;
  if (after == 0) return (double)NAN;
  if (after < r->count[sensor] && times[after] - times[after - 1] <= most_gap) return on_line(r, sensor, after - 1, after, t);
  return t - times[after - 1] <= old ? r->value[sensor][after - 1] : (double)NAN;
}

/* The measurement whose row is that of time t, moved there; NaN where none is. */
static double nearest(const softsoil_rows_t *r, int sensor, double t) {
  const double *times = r->t[sensor];
  int best = -1;
  for (int i = r->count[sensor] - 1; i >= 0 && times[i] > t - 0.5 * r->dt; --i)
    if (times[i] <= t + 0.5 * r->dt && (best < 0 || fabs(times[i] - t) < fabs(times[best] - t))) best = i;
  if (best < 0) return (double)NAN;
  const int other = times[best] <= t ? best + 1 : best - 1;
  if (other < 0 || other == r->count[sensor] || fabs(times[other] - times[best]) > most_gap) return r->value[sensor][best];
  return on_line(r, sensor, best, other, t);
}

static double slope(const softsoil_rows_t *r, int sensor, double t, double over) {
  return (value_at(r, sensor, t + over, most_gap) - value_at(r, sensor, t - over, most_gap)) / (2.0 * over);
}

/* Samples that no row needs any more. */
static void forget(softsoil_rows_t *r) {
  for (int s = 0; s < SOFTSOIL_SENSORS; ++s) {
    int gone = 0;
    while (gone + 1 < r->count[s] && r->t[s][gone + 1] < r->next - 2.0 * together) ++gone;
    r->count[s] -= gone;
    memmove(r->t[s], r->t[s] + gone, (size_t)r->count[s] * sizeof r->t[s][0]);
    memmove(r->value[s], r->value[s] + gone, (size_t)r->count[s] * sizeof r->value[s][0]);
  }
}

int softsoil_rows_next(softsoil_rows_t *r, double now, const softsoil_t *filter, double *t, double u[SOFTSOIL_N_U],
                       double y[SOFTSOIL_N_Y]) {
  if (!r || !t || !u || !y || r->magic != MAGIC || !(fabs(now) < farthest)) return 0;
  if (now < r->asked - pause || now > r->next + r->delay + pause || r->next > now + pause) begin_anew(r);
  r->asked = now;
  if (!(now >= r->next + r->delay)) return 0;
  const double at = *t = r->next;
  for (int i = 0; i < SOFTSOIL_N_Y; ++i) y[i] = nearest(r, measured_by[i], at);
  double v = value_at(r, SOFTSOIL_SENSOR_v, at, most_gap), turns = value_at(r, SOFTSOIL_SENSOR_omega_z, at, most_gap);
  if (!isfinite(v)) v = filter ? filter->x[SOFTSOIL_X_v] : 0.0;
  if (!isfinite(turns)) turns = filter ? filter->x[SOFTSOIL_X_omega_z] : 0.0;
  u[SOFTSOIL_U_steer] = value_at(r, SOFTSOIL_SENSOR_steer, at, most_gap);
  u[SOFTSOIL_U_steer_rate] = slope(r, SOFTSOIL_SENSOR_steer, at, r->dt);
  const double reads = value_at(r, SOFTSOIL_SENSOR_a_x_imu, at, most_gap); /* NaN of one that is absent, or silent */
  u[SOFTSOIL_U_a_x] = isfinite(reads) ? reads + v * turns : slope(r, SOFTSOIL_SENSOR_u, at, slope_over);
  for (int i = 0; i < 4; ++i) u[input_of[i]] = value_at(r, SOFTSOIL_SENSOR_omega_fl + i, at, most_gap);
  r->next += r->dt;
  forget(r);
  return 1;
}

int softsoil_rows_around(const softsoil_rows_t *r, double t, double y[SOFTSOIL_N_Y]) {
  int there = 0;
  if (!r || !y || r->magic != MAGIC) return 0;
  for (int i = 0; i < SOFTSOIL_N_Y; ++i) {
    y[i] = value_at(r, measured_by[i], t, together);
    there += isfinite(y[i]) != 0;
  }
  return there;
}

size_t softsoil_rows_size(void) { return sizeof(softsoil_rows_t); }
