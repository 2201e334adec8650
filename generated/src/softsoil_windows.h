/* What the horizon shares with what runs beside it; nothing here is for callers. */
#ifndef SOFTSOIL_WINDOWS_H
#define SOFTSOIL_WINDOWS_H

#include "softsoil_horizon.h"

#define SOFTSOIL_HORIZON_MAGIC 0x90c5cbfdu

/* States at a row that is kept: of the window over it, else the record smoothed by a quadratic. */
void softsoil_horizon_states(const softsoil_horizon_t *h, int64_t row, double states[SOFTSOIL_HORIZON_STATES]);
/* The inverse of a symmetric positive matrix (n x n), 0 where it is not positive; work: 2 n^2 numbers. */
int softsoil_invert(int n, const double *a, double *inverse, double *work);
/* The verdict on the estimate as it stands. */
int softsoil_horizon_verdict(const softsoil_horizon_t *h);

#endif
