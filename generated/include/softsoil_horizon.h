/* The moving horizon: the soil's parameters from windows of measurements, and whether they may be used.
 *
 * Beside the filter, at 2 to 10 Hz. Every 0.5 s a window of 1.0 s whose initial state is unknown becomes a quadratic in
 * the parameters (the initial state eliminated); the estimate minimises their sum. The same algorithm as the Python class
 * MovingHorizon. C99, no allocation: one structure of fixed size that the caller owns. */
#ifndef SOFTSOIL_HORIZON_H
#define SOFTSOIL_HORIZON_H

#include "softsoil.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SOFTSOIL_HORIZON_N 1 /* parameters estimated */
#define SOFTSOIL_HORIZON_ASKED 4 /* and with them, where there is room, the yaw inertia and the axles' forces */
#define SOFTSOIL_HORIZON_ROWS 1245 /* samples kept */
#define SOFTSOIL_HORIZON_WINDOWS 241 /* windows that count */
#define SOFTSOIL_HORIZON_KEPT 24 /* newest windows that may be linearised again */
#define SOFTSOIL_HORIZON_STATES 6 /* x, y, psi, u, v, omega_z: unknown at the start of a window */
/* What runs along these, from window to window: states that nothing measures, as forces that build up, and histories. */
#define SOFTSOIL_HORIZON_CARRIED (SOFTSOIL_N_X - SOFTSOIL_HORIZON_STATES - SOFTSOIL_HORIZON_N + SOFTSOIL_N_M)
#define SOFTSOIL_HORIZON_CELLS (SOFTSOIL_HORIZON_CARRIED > 0 ? SOFTSOIL_HORIZON_CARRIED : 1)
#define SOFTSOIL_HORIZON_MIN_DT 0.0096 /* s, shortest sample interval */
#define SOFTSOIL_HORIZON_MAX_DT 0.1 /* s, longest */

enum softsoil_horizon_parameter {SOFTSOIL_HORIZON_n};

/* Whether the estimate may be used: any but SOFTSOIL_VERDICT_IDENTIFIED means: do not. */
enum softsoil_verdict {
  SOFTSOIL_VERDICT_NOT_EXCITED, /* the windows do not determine n, or a small error of the forces, or a load, may make it wrong: steer more, to and fro, at several speeds, longer */
  SOFTSOIL_VERDICT_IDENTIFIED, /* the windows determine n, and the model leaves no more than a right one does */
  SOFTSOIL_VERDICT_DEPENDS_ON_FIRST_GUESS, /* n depends on its initial guess: drive on */
  SOFTSOIL_VERDICT_AT_BOUND, /* n is at a bound of its range: check soil and vehicle */
  SOFTSOIL_VERDICT_AXLES_DISAGREE, /* front and rear axle disagree on n */
  SOFTSOIL_VERDICT_INCONSISTENT, /* the windows contradict the model, the vehicle's numbers or one soil: check vehicle, soil and sensors */
  SOFTSOIL_VERDICT_NO_SOIL, /* there is no soft soil */
  SOFTSOIL_VERDICT_COUNT
};

typedef struct {
  double p[SOFTSOIL_N_P];                   /* parameters that are not estimated */
  double r_std[SOFTSOIL_N_Y];               /* standard deviation of each measurement; HUGE_VAL: leave it out */
  double model_error[SOFTSOIL_N_Y];         /* what the equations miss of each within a window, added to it */
  double guess[SOFTSOIL_HORIZON_N];         /* initial guess */
  double guess_std[SOFTSOIL_HORIZON_N];     /* its standard deviation */
  double dt;                                /* s, between samples */
  double start_up;                          /* s after the first sample in which no window starts */
  int32_t look;                             /* 1: n is identified only while softsoil_vehicle_update finds the vehicle as it was
                                               (the default where the library has it); 0: without that */
} softsoil_horizon_options_t;

typedef struct {
  double y[SOFTSOIL_N_Y]; /* measurements, gaps filled */
  double u[SOFTSOIL_N_U];
  double path[SOFTSOIL_HORIZON_STATES]; /* states of the newest window over this sample */
  unsigned char seen[SOFTSOIL_N_Y], estimated, blocked;
} softsoil_horizon_row_t;

typedef struct {
  int64_t row; /* first sample */
  double t;    /* s, its time */
  double at[SOFTSOIL_HORIZON_N], gradient[SOFTSOIL_HORIZON_ASKED], hessian[SOFTSOIL_HORIZON_ASKED][SOFTSOIL_HORIZON_ASKED];
  double state[SOFTSOIL_HORIZON_STATES];
  double cost;      /* mean robust squared residual */
  double excess[2]; /* variance of the residual of v and omega_z per degree of freedom, NaN where not measured */
} softsoil_horizon_window_t;

/* What softsoil_vehicle_update says of the vehicle, where the library has it: nobody looks; a load that makes n wrong would not show
 * yet; the vehicle is as identified; the drive asks for numbers beyond their joint error; for another mass; for another scale of the
 * steering. */
enum softsoil_vehicle_change {
  SOFTSOIL_VEHICLE_NOT_LOOKED_AT,
  SOFTSOIL_VEHICLE_UNKNOWN,
  SOFTSOIL_VEHICLE_SAME,
  SOFTSOIL_VEHICLE_STRAINED,
  SOFTSOIL_VEHICLE_OTHER_MASS,
  SOFTSOIL_VEHICLE_OTHER_STEERING
};

/* The caller owns it; sizeof(softsoil_horizon_t) is all the memory there is. Read what you like, write nothing. */
typedef struct {
  uint32_t magic;
  uint32_t counts[SOFTSOIL_STATUS_COUNT]; /* how often each status has been met */
  int32_t verdict;                        /* enum softsoil_verdict */
  int32_t changes;                        /* how often the soil has changed */
  int32_t windows;                        /* that the estimate rests on */
  int32_t updated;                        /* whether the last call of softsoil_horizon_update took in a window: 1 or 0 */
  int32_t vehicle;                        /* enum softsoil_vehicle_change */
  double t;                               /* s, end of the newest window */
  double changed_at;                      /* s, start of the first window of the present soil */
  double n[SOFTSOIL_HORIZON_N];           /* estimate */
  double std[SOFTSOIL_HORIZON_N];         /* its standard deviation */
  double information_std[SOFTSOIL_HORIZON_N]; /* the same by noise and model error alone, without the initial guess */
  double law_std[SOFTSOIL_HORIZON_N];     /* the same by 1 % of an axle's lateral force; 0 where it is not asked for */
  double free_n[SOFTSOIL_HORIZON_N];      /* estimate without the initial guess */
  double unexplained[2];                  /* share of the variance of v and omega_z that the model leaves beyond noise */
  double unexplained_std[2];
  double inertia;                         /* share by which the windows would have the yaw inertia larger than declared */
  double inertia_std;                     /* its standard deviation; 1e9 where it is not asked for */
  double parts[2];                        /* n of an earlier and of the later part, where these differ most */
  double parts_sigmas;                    /* by how many standard deviations they differ */
  double motion;                          /* m/s^2, root mean square of u omega_z */
  double cost;                            /* of the newest window */
  softsoil_horizon_options_t options;
  double clock, heard, doubt, doubted, inputs[SOFTSOIL_N_U], centre[SOFTSOIL_HORIZON_N], weights[SOFTSOIL_HORIZON_WINDOWS];
  double noise[2], noise_count[2], square[2], own[2][3], own_count[2], force, force_count;
  double good[SOFTSOIL_N_Y];
  int64_t good_row[SOFTSOIL_N_Y], rows, first_row, next_row, taken, since;
  int32_t steps, apart, before, after, again, bridged, half, fractions, substeps, continued;
  softsoil_horizon_window_t window[SOFTSOIL_HORIZON_WINDOWS];
  double m[SOFTSOIL_HORIZON_KEPT][1 + SOFTSOIL_HORIZON_N][SOFTSOIL_HORIZON_CELLS];
  double carried[SOFTSOIL_HORIZON_KEPT][SOFTSOIL_HORIZON_N], steps_at[SOFTSOIL_HORIZON_KEPT][SOFTSOIL_HORIZON_N];
  softsoil_horizon_row_t row[SOFTSOIL_HORIZON_ROWS];
} softsoil_horizon_t;

/* The declared numbers. */
int softsoil_horizon_defaults(softsoil_horizon_options_t *options);

/* Start at time t (s), of the first sample; options NULL for the declared ones. */
int softsoil_horizon_init(softsoil_horizon_t *h, const softsoil_horizon_options_t *options, double t);

/* One sample: inputs u and measurements y at time t (s); cheap. valid: 0 for a measurement to leave out; NULL: all count; NaN is
 * left out too. Samples that are missing count as not measured, with the inputs held, as is an input that is not finite or beyond
 * reason; windows run across no more than 0.25 s of these, and after more than a second without any they start anew. */
int softsoil_horizon_push(softsoil_horizon_t *h, const double u[SOFTSOIL_N_U], const double y[SOFTSOIL_N_Y],
                          const unsigned char valid[SOFTSOIL_N_Y], double t);

/* Take in the next window where one is complete (h->updated), else nothing: at most one, so that the time of a call is bounded. */
int softsoil_horizon_update(softsoil_horizon_t *h);

/* Put the estimate in the place of the filter's where the verdict is "identified" and they differ by more than a standard
 * deviation of the filter; the filter's other states move by their covariance with it. Returns 1 where it did, else 0. */
int softsoil_horizon_correct(const softsoil_horizon_t *h, softsoil_t *s);

/* A plain sentence. */
const char *softsoil_verdict_text(int verdict);

/* sizeof(softsoil_horizon_t) in the library. */
size_t softsoil_horizon_size(void);

#ifdef __cplusplus
}
#endif
#endif
