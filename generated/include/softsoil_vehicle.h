/* Whether the vehicle is the one that is declared: its numbers, a load and the steering's scale, free in the windows of the moving
 * horizon.
 *
 * A load, a steering sensor of another scale, lower tyres or a bent link move these numbers together; n takes that up, and neither the filter nor the horizon
 * needs to show it. Here only where the vehicle's file states errors of its numbers. C99, no allocation. */
#ifndef SOFTSOIL_VEHICLE_H
#define SOFTSOIL_VEHICLE_H

#include "softsoil_horizon.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SOFTSOIL_VEHICLE_NUMBERS 20 /* whose errors the vehicle's file states */
#define SOFTSOIL_VEHICLE_ASKED (SOFTSOIL_HORIZON_N + SOFTSOIL_VEHICLE_NUMBERS + 2) /* and the soil's, a load, and the steering's scale */
#define SOFTSOIL_VEHICLE_COLUMNS (SOFTSOIL_HORIZON_STATES + SOFTSOIL_VEHICLE_ASKED) /* derivatives of a window */
#define SOFTSOIL_VEHICLE_SAMPLES 106 /* of a window, at most */

/* The caller owns it; sizeof(softsoil_vehicle_t) is all the memory there is. Read what you like, write nothing. */
typedef struct {
  uint32_t magic;
  int32_t change;  /* enum softsoil_vehicle_change; also in the horizon's `vehicle` */
  int32_t windows; /* taken in since the soil changed last */
  int32_t next;    /* derivative of the present window that is next, -1 where there is none */
  double strain;   /* squares by which the numbers would move, in their errors, over what is expected: 1 for this vehicle */
  double load;     /* share of the mass by which the vehicle is heavier than declared */
  double load_std; /* its standard deviation, with that of a declared load; 1e9 while nothing is known */
  double steering, steering_std; /* share by which the road wheels turn farther than `steer` says, a load free beside it */
  int64_t row, from, taken, before;
  int32_t changes, steps;
  double n[SOFTSOIL_HORIZON_N], state[SOFTSOIL_HORIZON_STATES];
  double memory[2][SOFTSOIL_HORIZON_CELLS];
  double at[SOFTSOIL_VEHICLE_SAMPLES][SOFTSOIL_N_Y], residual[SOFTSOIL_VEHICLE_SAMPLES][SOFTSOIL_N_Y];
  double weight[SOFTSOIL_VEHICLE_SAMPLES][SOFTSOIL_N_Y];
  double slope[SOFTSOIL_VEHICLE_COLUMNS][SOFTSOIL_VEHICLE_SAMPLES][SOFTSOIL_N_Y];
  double information[SOFTSOIL_VEHICLE_ASKED][SOFTSOIL_VEHICLE_ASKED], lean[SOFTSOIL_VEHICLE_ASKED];
  double work[3][SOFTSOIL_VEHICLE_ASKED * SOFTSOIL_VEHICLE_ASKED];
} softsoil_vehicle_t;

/* Start, with the horizon. */
int softsoil_vehicle_init(softsoil_vehicle_t *v);

/* The next part of the work: one derivative of one window, so that the time of a call is
 * bounded. Call it after softsoil_horizon_update, at every sample or ten times a second; windows that begin meanwhile are left
 * out. Sets `vehicle` of the horizon, whose verdict is "inconsistent" where the vehicle has changed, and at best "not excited"
 * where that is unknown. Returns 1 where a window has been taken in, else 0, or a status from SOFTSOIL_BAD_ARGUMENT on. */
int softsoil_vehicle_update(softsoil_vehicle_t *v, softsoil_horizon_t *h);

/* sizeof(softsoil_vehicle_t) in the library. */
size_t softsoil_vehicle_size(void);

#ifdef __cplusplus
}
#endif
#endif
