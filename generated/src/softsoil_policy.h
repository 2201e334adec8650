/* The filter's rules that need no linear algebra; `softsoil.estimator.terrain_filter` has the same. Nothing here is for callers. */
#ifndef SOFTSOIL_POLICY_H
#define SOFTSOIL_POLICY_H

#include <math.h>
#include <string.h>

#include "softsoil.h"

/* Clocks that count in steps differ by rounding. */
#define CLOCK_SLACK 1e-6

static const int32_t softsoil_soil[SOFTSOIL_N_SOIL] = {6}; /* states that are n */
/* State that each measurement is, or -1; whether it is one of the pose. */
static const int32_t softsoil_measured[SOFTSOIL_N_Y] = {0, 1, 2, 3, 4, 5};
static const int32_t softsoil_is_pose[SOFTSOIL_N_Y] = {1, 1, 1, 0, 0, 0};

/* A new drive, or the same soil after a restart: what is remembered of n is left behind, for `settling` seconds. */
static void forget_soil(softsoil_t *s, double settling) {
  s->n_past = s->next_past = 0;
  s->keep_at = s->t + settling;
}

/* A measurement outside the gate: whether it has been there, to the same side, for as long as the patience lasts. */
static int is_a_jump(softsoil_t *s, int i) {
  const int32_t patience = softsoil_is_pose[i] ? s->options.gate_patience : s->options.gate_patience_rates;
  const int32_t side = s->innovation[i] > 0.0 ? 1 : -1;
  int32_t *run = &s->gated_run[i];
  if (*run < 1000000 && *run > -1000000) *run = *run * side > 0 ? *run + side : side;
  if (patience <= 0 || *run * side < patience) return 0;
  *run = 0;
  return 1;
}

/* What an update's innovations say of n having jumped: score N and information M of each soil state, from the factor and the
 * innovations as they were before the correction. An n that is wrong by D moves the innovation of measurement i by H_i D,
 * H_i = P_in / P_nn, and what a right model always misses of a measurement is the same before a change and after. */
static void evidence_of_soil(const softsoil_t *s, const int order[SOFTSOIL_N_X], const int32_t *use,
                             double score[SOFTSOIL_N_SOIL], double information[SOFTSOIL_N_SOIL]) {
  int row[SOFTSOIL_N_X];
  for (int i = 0; i < SOFTSOIL_N_X; ++i) row[order[i]] = i;
  for (int j = 0; j < SOFTSOIL_N_SOIL; ++j) {
    const double *own = s->root[row[softsoil_soil[j]]];
    double known = 0.0;
    for (int k = 0; k < SOFTSOIL_N_X; ++k) known += own[k] * own[k];
    score[j] = information[j] = 0.0;
    for (int i = 0; i < SOFTSOIL_N_Y; ++i) {
      if (!use[i] || softsoil_measured[i] < 0 || !(known > 0.0)) continue;
      const double *other = s->root[row[softsoil_measured[i]]], miss = s->options.miss_std[i];
      const double variance = s->innovation_std[i] * s->innovation_std[i] - miss * miss;
      const double most = 2.0 * sqrt(variance), away = s->innovation[i];
      double share = 0.0;
      for (int k = 0; k < SOFTSOIL_N_X; ++k) share += own[k] * other[k];
      share /= known;
      score[j] += share * (away > most ? most : away < -most ? -most : away) / variance;
      information[j] += share * share / variance;
    }
  }
}

/* Variance of the soil state `at` without the common error, from the factor. */
static double soil_variance(const softsoil_t *s, const int order[SOFTSOIL_N_X], int at) {
  double sum = 0.0;
  for (int i = 0; i < SOFTSOIL_N_X; ++i)
    for (int k = 0; order[i] == at && k <= i; ++k) sum += s->root[i][k] * s->root[i][k];
  return sum;
}

/* The second look at a jump, as soon as what came after it determines n: whether no jump is likelier than one. `again` is then the
 * variance with which what was known of n before counts again, 0 where it does not. */
static int jump_is_revoked(softsoil_t *s, const int order[SOFTSOIL_N_X], double again[SOFTSOIL_N_SOIL]) {
  const double jump = s->options.change_std * s->options.change_std, error = s->options.change_error * s->options.change_error;
  int revoked = 0;
  for (int i = 0; i < SOFTSOIL_N_SOIL; ++i) {
    const int at = softsoil_soil[i];
    again[i] = 0.0;
    if (!(s->trial_variance[i] > 0.0)) continue;
    const double variance = soil_variance(s, order, at), walk = s->options.q_std[at] * s->options.q_std[at];
    if (!(variance <= 0.1111111111111 * jump)) continue;
    const double old = s->trial_variance[i] + walk * (s->t - s->trial_t), away = s->x[at] - s->trial_n[i];
    const double v = variance + old + error;
    s->trial_variance[i] = 0.0;
    if (!(away * away * jump < v * (v + jump) * log(1.0 + jump / v))) continue;
    again[i] = old;
    revoked = 1;
  }
  if (revoked) forget_soil(s, 0.0);
  return revoked;
}

/* Whether n has jumped: generalised likelihood ratio of a jump at each past time (Willsky and Jones, IEEE Trans. Automatic Control
 * 21, 1976) against none. Each n that has is put where it is said to be, and `more` is the variance to be added to it. */
static int soil_has_changed(softsoil_t *s, const int order[SOFTSOIL_N_X], const double score[SOFTSOIL_N_SOIL],
                            const double information[SOFTSOIL_N_SOIL], const double lower[SOFTSOIL_N_X],
                            const double upper[SOFTSOIL_N_X], double more[SOFTSOIL_N_X]) {
  const double every = s->options.change_after / SOFTSOIL_PAST, limit = s->options.change_sigmas * s->options.change_sigmas;
  const double jump = s->options.change_std * s->options.change_std, error = s->options.change_error * s->options.change_error;
  double old[SOFTSOIL_N_SOIL] = {0.0};
  int changed = 0;
  if (s->t > s->keep_at - CLOCK_SLACK) {
    for (int i = 0; i < SOFTSOIL_N_SOIL; ++i) s->past_score[i][s->next_past] = s->past_information[i][s->next_past] = 0.0;
    s->next_past = (s->next_past + 1) % SOFTSOIL_PAST;
    s->n_past += s->n_past < SOFTSOIL_PAST;
    s->keep_at = (s->keep_at > s->t - every ? s->keep_at : s->t - every) + every;
  }
  for (int i = 0; i < SOFTSOIL_N_SOIL; ++i) {
    const int at = softsoil_soil[i];
    double *n = s->past_score[i], *m = s->past_information[i], best = 0.0, away = 0.0;
    int jumped = 0;
    for (int k = 0; k < s->n_past; ++k) {
      n[k] += score[i];
      m[k] += information[i];
    }
    for (int k = 0; k < s->n_past; ++k) {
      const int age = (s->next_past - 1 - k + SOFTSOIL_PAST) % SOFTSOIL_PAST;
      const double spread = 1.0 + (error + jump) * m[k], least = (1.0 + error * m[k]) * spread, most = n[k] * n[k] * jump;
      if (age >= 5 && most > limit * least) jumped = 1;
      if (!(most > best * least)) continue;
      best = most / least;
      away = jump * n[k] / spread;
    }
    if (jumped) {
      const double moved = s->x[at] + away;
      old[i] = soil_variance(s, order, at);
      s->trial_n[i] = s->x[at];
      s->x[at] = moved < lower[at] ? lower[at] : moved > upper[at] ? upper[at] : moved;
      more[at] += jump;
      changed = 1;
    }
  }
  if (changed) {
    forget_soil(s, s->options.change_after);
    memcpy(s->trial_variance, old, sizeof old);
    s->trial_t = s->t;
  }
  return changed;
}

/* Corrections summed to both sides (Page's CUSUM, Biometrika 41, 1954), from the estimate `before` to that after an update, with
 * the allowance of a right model. */
static int drifts(softsoil_t *s, const double before[SOFTSOIL_N_X]) {
  static const double allowance[SOFTSOIL_N_DRIFT] = {0.0206, 0.0174, 0.0038, 0.12, 0.0269, 0.0317, 0.0227, 0.0222, 0.0181};
  static const double limit[SOFTSOIL_N_DRIFT] = {0.086, 0.105, 0.012, 0.152, 0.216, 0.094, 0.071, 0.074, 0.278};
  /* The measurement whose noise raises a limit where it is above the floor, or -1. */
  static const int32_t sensor[SOFTSOIL_N_DRIFT] = {0, 1, 2, 3, 4, 5, 5, 5, -1};
  static const double floor_std[SOFTSOIL_N_Y] = {0.05, 0.05, 0.003, 0.05, 0.05, 0.005};
  const double step = s->t - s->drift_t;
  double moved[SOFTSOIL_N_X], n = 0.0;
  s->drift_t = s->t;
  if (s->t < s->drift_from) return 0;
  for (int i = 0; i < SOFTSOIL_N_X; ++i) moved[i] = s->x[i] - before[i];
  for (int i = 0; i < SOFTSOIL_N_SOIL; ++i) n += moved[softsoil_soil[i]] / SOFTSOIL_N_SOIL;
  const double psi = before[SOFTSOIL_X_psi], c = cos(psi), d = sin(psi);
  const double turning = tanh(before[SOFTSOIL_X_u] * before[SOFTSOIL_X_omega_z] / 1.0);
  const double steering = tanh(s->u[SOFTSOIL_U_steer_rate] / 0.3);
  const double yaw = moved[SOFTSOIL_X_omega_z];
  const double sums[SOFTSOIL_N_DRIFT] = {moved[SOFTSOIL_X_x] * c + moved[SOFTSOIL_X_y] * d,
                                         moved[SOFTSOIL_X_y] * c - moved[SOFTSOIL_X_x] * d,
                                         moved[SOFTSOIL_X_psi], moved[SOFTSOIL_X_u], moved[SOFTSOIL_X_v],
                                         yaw, yaw * turning, yaw * steering, n};
  s->drift = 0.0;
  for (int i = 0; i < SOFTSOIL_N_DRIFT; ++i) {
    const int k = sensor[i];
    const double noise = k < 0 ? 1.0 : s->options.r_std[k] / floor_std[k];
    const double most = noise > 1.0 ? limit[i] * noise : limit[i];
    for (int side = 0; side < 2; ++side) {
      double sum = s->drift_sum[i][side] + (side ? -sums[i] : sums[i]) - allowance[i] * step;
      sum = sum > 0.0 ? sum : 0.0;
      sum = sum < 3.0 * most ? sum : 3.0 * most;
      s->drift_sum[i][side] = sum;
      if (sum / most > s->drift) {
        s->drift = sum / most;
        s->drift_channel = i;
      }
    }
  }
  return s->drift > 1.0;
}

/* Nothing is said of drift for a while. */
static void forget_drift(softsoil_t *s) {
  memset(s->drift_sum, 0, sizeof s->drift_sum);
  s->drift = 0.0;
  s->drift_channel = 0;
  s->drift_t = s->t;
  s->drift_from = s->t + 6.0;
}

/* Nothing is said of drift until the first corrections after unknown inputs have made up for them. */
static void wait_for_drift(softsoil_t *s) {
  const double t = s->t + 2.0;
  if (s->drift_from < t) s->drift_from = t;
}

/* Times in which nothing is said, or histories are wrong, are times of driving: they do not pass for a vehicle that stands. */
static void wait_standing(softsoil_t *s, double dt) {
  if (s->run_in_to > s->t) s->run_in_to += dt;
  if (s->keep_at > s->t) s->keep_at += dt;
  if (s->drift_from > s->t) s->drift_from += dt;
}

#endif
