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
  s->settled = s->t + settling;
  s->keep_at = s->t;
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

/* Whether n has moved too far within change_after to be the same soil's; variance to be added to each state in `more`. */
static int soil_has_changed(softsoil_t *s, double more[SOFTSOIL_N_X]) {
  const double every = s->options.change_after / SOFTSOIL_PAST;
  int changed = 0;
  if (s->n_past == SOFTSOIL_PAST && s->t > s->settled + CLOCK_SLACK) {
    for (int i = 0; i < SOFTSOIL_N_SOIL; ++i) {
      const int at = softsoil_soil[i];
      /* The ring is full: the next place to write holds the oldest. */
      if (fabs(s->x[at] - s->past[s->next_past][i]) > s->options.change_sigmas * s->std[at]) {
        more[at] += s->options.change_std * s->options.change_std;
        changed = 1;
      }
    }
    if (changed) forget_soil(s, s->options.change_after);
  }
  if (s->t > s->keep_at - CLOCK_SLACK) {
    for (int i = 0; i < SOFTSOIL_N_SOIL; ++i) s->past[s->next_past][i] = s->x[softsoil_soil[i]];
    s->next_past = (s->next_past + 1) % SOFTSOIL_PAST;
    s->n_past += s->n_past < SOFTSOIL_PAST;
    s->keep_at = (s->keep_at > s->t - every ? s->keep_at : s->t - every) + every;
  }
  return changed;
}

#endif
