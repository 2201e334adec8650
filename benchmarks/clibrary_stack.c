/* Bytes of stack that the library's calls need: a drive of its own model in a thread whose stack was painted before, once with the
 * filter alone, once with the horizon beside it, once with the look at the vehicle too (where the library has it). */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "softsoil.h"
#include "softsoil_horizon.h"
#ifdef LOOK
#include "softsoil_vehicle.h"
static softsoil_vehicle_t look;
#endif

#define STACK ((size_t)4 << 20)
#define PAINT 0xA5

static softsoil_t s;
static softsoil_horizon_t h;
static softsoil_options_t o;
static double x[SOFTSOIL_N_X], m[SOFTSOIL_N_M + 1], u[SOFTSOIL_N_U], y[SOFTSOIL_N_Y];

static void *drive(void *asked) {
  const int parts = *(const int *)asked;
  softsoil_defaults(&o);
  softsoil_init(&s, &o, NULL, NULL, 0.0);
  softsoil_horizon_init(&h, NULL, 0.0);
#ifdef LOOK
  softsoil_vehicle_init(&look);
#endif
  memcpy(x, s.x, sizeof x);
  for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = 15.4;
  u[SOFTSOIL_U_a_x] = u[SOFTSOIL_U_steer] = u[SOFTSOIL_U_steer_rate] = 0.0;
  if (parts) softsoil_history(o.p, x, u, m);
  for (int k = 0; k < 1500; ++k) {
    const double t = (k + 1) * SOFTSOIL_STEP;
    u[SOFTSOIL_U_steer] = 0.3 * sin(0.03 * k);
    u[SOFTSOIL_U_steer_rate] = 0.3 * 0.03 / SOFTSOIL_STEP * cos(0.03 * k);
    if (parts) {
      softsoil_step(o.p, SOFTSOIL_STEP, x, m, u);
      for (int i = 0; i < SOFTSOIL_N_Y; ++i) y[i] = x[i] + 0.02 * sin(1.7 * k + i);
      softsoil_predict(&s, u, SOFTSOIL_STEP);
      softsoil_update(&s, y, NULL, t);
    }
    if (parts > 1) {
      softsoil_horizon_push(&h, u, y, NULL, t);
      softsoil_horizon_update(&h);
#ifdef LOOK
      if (parts > 2) softsoil_vehicle_update(&look, &h);
#endif
      softsoil_horizon_correct(&h, &s);
    }
  }
  return NULL;
}

/* Bytes of the painted stack that a drive has written to; it grows downwards on every processor that this runs on. */
static size_t used(int parts) {
  unsigned char *stack = NULL;
  pthread_attr_t own;
  pthread_t thread;
  if (posix_memalign((void **)&stack, 4096, STACK)) exit(1);
  memset(stack, PAINT, STACK);
  pthread_attr_init(&own);
  if (pthread_attr_setstack(&own, stack, STACK) || pthread_create(&thread, &own, drive, &parts)) exit(1);
  pthread_join(thread, NULL);
  size_t free_bytes = 0;
  while (free_bytes < STACK && stack[free_bytes] == PAINT) ++free_bytes;
  free(stack);
  return STACK - free_bytes;
}

int main(void) {
  const size_t none = used(0), filter = used(1), horizon = used(2);
  printf("filter %lu\nhorizon %lu\n", (unsigned long)(filter - none), (unsigned long)(horizon - none));
  if (h.windows < 2) return 1; /* no window was linearised: nothing was measured */
#ifdef LOOK
  printf("vehicle %lu\n", (unsigned long)(used(3) - none));
#endif
  return 0;
}
