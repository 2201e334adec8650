/* Reads a log and prints the sinkage exponent with its verdict: example LOG.csv [seconds to skip].
 *
 * The log is a table with a header: t (s), the measurements x, y, psi, u, v, omega_z, and for the inputs
 * steer, a_x_imu and the wheel speeds; columns it does not know are passed over, empty cells and nan are missing values.
 * A row whose time stamp the filter refuses is not used and is counted. After PATIENCE of them in a row (a gap of more than a second,
 * a clock that was set) the motion starts again, and what is known of the soil is kept. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "softsoil.h"
#include "softsoil_horizon.h"
#include "softsoil_vehicle.h"

#define LINE 8192
#define COLUMNS 128
#define PATIENCE 5 /* refused rows in a row after which the clock is taken to be another */
#define PAUSE 2.0  /* s: the horizon's clock only goes forward; a clock that was set back is a pause of so long */

static const char *const input_names[SOFTSOIL_N_U] = {"steer", "steer_rate", "a_x", "omega_fl", "omega_fr", "omega_rl", "omega_rr"};
static const char *const measurement_names[SOFTSOIL_N_Y] = {"x", "y", "psi", "u", "v", "omega_z"};
static const char *const state_names[SOFTSOIL_N_X] = {"x", "y", "psi", "u", "v", "omega_z", "n"};
static const int soil_states[] = {SOFTSOIL_X_n};
static const char *const horizon_names[SOFTSOIL_HORIZON_N] = {"n"};
#define N_SOIL ((int)(sizeof soil_states / sizeof soil_states[0]))

/* One row of the log, by name of its column. */
typedef struct {
  char names[COLUMNS][64];
  int count;
  size_t rows, room;
  double *values; /* rows * count */
} table_t;

static int split(char *line, char **cells) {
  int n = 0;
  char *at = line;
  line[strcspn(line, "\r\n")] = '\0';
  while (n < COLUMNS) {
    cells[n++] = at;
    at = strchr(at, ',');
    if (!at) return n;
    *at++ = '\0';
  }
  return -1;
}

static int read_table(const char *path, table_t *table) {
  static char line[LINE];
  char *cells[COLUMNS];
  FILE *file = fopen(path, "r");
  if (!file) return 0;
  memset(table, 0, sizeof *table);
  if (fgets(line, LINE, file)) table->count = split(line, cells);
  for (int i = 0; i < table->count; ++i) snprintf(table->names[i], sizeof table->names[i], "%.63s", cells[i]);
  while (table->count > 0 && fgets(line, LINE, file)) {
    const int n = split(line, cells);
    if (n != table->count) continue;
    if (table->rows == table->room) {
      table->room = table->room ? 2 * table->room : 4096;
      double *more = (double *)realloc(table->values, table->room * (size_t)n * sizeof(double));
      if (!more) break;
      table->values = more;
    }
    for (int i = 0; i < n; ++i) {
      char *end = cells[i];
      const double value = strtod(cells[i], &end);
      table->values[table->rows * (size_t)n + (size_t)i] = end == cells[i] ? nan("") : value;
    }
    ++table->rows;
  }
  fclose(file);
  return table->rows > 0;
}

static double cell(const table_t *table, size_t row, const char *name) {
  for (int i = 0; i < table->count; ++i)
    if (strcmp(table->names[i], name) == 0) return table->values[row * (size_t)table->count + (size_t)i];
  return nan("");
}

/* Slope of a column over five rows, least squares: a straight line through two rows to each side. */
static double slope(const table_t *table, size_t row, const char *name) {
  const size_t first = row >= 2 ? row - 2 : 0, last = row + 2 < table->rows ? row + 2 : table->rows - 1;
  double t_mean = 0.0, y_mean = 0.0, ty = 0.0, tt = 0.0;
  const double n = (double)(last - first + 1);
  for (size_t k = first; k <= last; ++k) {
    t_mean += cell(table, k, "t") / n;
    y_mean += cell(table, k, name) / n;
  }
  for (size_t k = first; k <= last; ++k) {
    const double t = cell(table, k, "t") - t_mean;
    ty += t * (cell(table, k, name) - y_mean);
    tt += t * t;
  }
  return tt > 0.0 ? ty / tt : 0.0;
}

static double or_else(double value, double otherwise) { return isfinite(value) ? value : otherwise; }

/* An input at a row; where v or omega_z are missing those of the filter stand for them. */
static double input(const table_t *table, size_t row, const char *name, const softsoil_t *s) {
  if (strcmp(name, "steer_rate") == 0) return slope(table, row, "steer");
  if (strcmp(name, "a_x") == 0) {
    /* The accelerometer reads du/dt - v omega_z, the model wants du/dt; without one it is the slope of u. */
    const double v = or_else(cell(table, row, "v"), s->x[SOFTSOIL_X_v]), seen = cell(table, row, "a_x_imu");
    const double omega_z = or_else(cell(table, row, "omega_z"), s->x[SOFTSOIL_X_omega_z]);
    return isfinite(seen) ? seen + v * omega_z : or_else(slope(table, row, "u"), 0.0);
  }
  return cell(table, row, name);
}

/* The time between rows (s): mean of the intervals that are no gap and no step of the clock. */
static double sample_time(const table_t *table) {
  double dt = 0.0, least = 0.0, most = 1.0;
  for (int pass = 0; pass < 4; ++pass) {
    double sum = 0.0, count = 0.0;
    for (size_t row = 1; row < table->rows; ++row) {
      const double step = cell(table, row, "t") - cell(table, row - 1, "t");
      if (!(step > least && step < most)) continue;
      sum += step;
      count += 1.0;
    }
    dt = count > 0.0 ? sum / count : 0.0;
    least = 0.5 * dt;
    most = 2.0 * dt;
  }
  return dt;
}

/* The first row that is `skip` seconds or more after the first time stamp, and has one. */
static size_t first_row(const table_t *table, double skip) {
  size_t row = 0;
  while (row + 1 < table->rows && !isfinite(cell(table, row, "t"))) ++row;
  const double from = cell(table, row, "t") + skip;
  while (row + 1 < table->rows && !(cell(table, row, "t") >= from)) ++row;
  return row;
}

/* The first state at a row, and how well it is known: as its sensor says, or widely. Heading and speed that are not measured are
 * those of the way over the next half second. x0 and std0 hold the declared ones before. */
static void first_state(const table_t *table, size_t row, double x0[SOFTSOIL_N_X], double std0[SOFTSOIL_N_X]) {
  static const int states[] = {SOFTSOIL_X_x, SOFTSOIL_X_y, SOFTSOIL_X_psi, SOFTSOIL_X_u, SOFTSOIL_X_v, SOFTSOIL_X_omega_z};
  static const double unseen[] = {1.0, 1.0, 0.1, 1.0, 0.5, 0.2};
  size_t ahead = row;
  while (ahead + 1 < table->rows && !(cell(table, ahead, "t") > cell(table, row, "t") + 0.5)) ++ahead;
  const double dx = cell(table, ahead, "x") - cell(table, row, "x"), dy = cell(table, ahead, "y") - cell(table, row, "y");
  const double way = hypot(dx, dy), speed = way / (cell(table, ahead, "t") - cell(table, row, "t"));
  if (way > 0.3) x0[SOFTSOIL_X_psi] = atan2(dy, dx);
  if (way > 0.3 && isfinite(speed)) x0[SOFTSOIL_X_u] = speed;
  for (size_t i = 0; i < sizeof states / sizeof states[0]; ++i) {
    const double seen = cell(table, row, state_names[states[i]]);
    x0[states[i]] = or_else(seen, x0[states[i]]);
    if (!isfinite(seen)) std0[states[i]] = unseen[i];
  }
}

/* What became of the rows: not used for their time stamps, in all and in a row; how often the motion started again. */
typedef struct {
  unsigned long rows, refused, run, starts;
} tally_t;

/* One row: to its time with the inputs u of the row before, then its measurements y. Returns the status of what was refused, or of
 * the update; `began` says whether the motion starts again here. */
static int take(softsoil_t *s, tally_t *tally, const double *u, const double *y, double t, int *began) {
  int status = softsoil_predict(s, u, t - s->t); /* the filter's own time: a row that was left out is no lost time */
  if (status < SOFTSOIL_MEASUREMENT_LATE) status = softsoil_update(s, y, NULL, t);
  *began = 0;
  ++tally->rows;
  if (status < SOFTSOIL_MEASUREMENT_LATE) {
    tally->run = 0;
    return status;
  }
  ++tally->refused;
  if (status == SOFTSOIL_DT_ZERO || ++tally->run < PATIENCE) return status; /* one bad stamp, or the same row again */
  const int again = softsoil_restart(s, y, NULL, t);
  if (again >= SOFTSOIL_MEASUREMENT_LATE) return again; /* a stamp that is no number: wait for one */
  tally->run = 0;
  ++tally->starts;
  *began = 1;
  return again;
}

static void say(const softsoil_t *s) {
  printf("%9.3f", s->t);
  for (int i = 0; i < N_SOIL; ++i)
    printf("   %s %.4f +- %.4f", state_names[soil_states[i]], s->x[soil_states[i]], s->std[soil_states[i]]);
  printf("   consistency %.2f\n", s->consistency);
}

/* The moving horizon's estimate and verdict: use no n unless it says so. */
static void judge(const softsoil_horizon_t *h) {
  printf("horizon, %d windows:", (int)h->windows);
  for (int i = 0; i < SOFTSOIL_HORIZON_N; ++i) printf("   %s %.4f +- %.4f", horizon_names[i], h->n[i], h->std[i]);
  printf("\nverdict: %s\n", softsoil_verdict_text(h->verdict));
}

int main(int argc, char **argv) {
  static table_t table;
  static softsoil_t s;
  static softsoil_horizon_t h;
  static tally_t tally;
  double u[SOFTSOIL_N_U], y[SOFTSOIL_N_Y], x0[SOFTSOIL_N_X], std0[SOFTSOIL_N_X];
  softsoil_options_t options;
  softsoil_horizon_options_t about;
  static softsoil_vehicle_t look;
  softsoil_vehicle_init(&look);
  const double skip = argc > 2 ? strtod(argv[2], NULL) : 2.0;
  printf("sizeof(softsoil_t) = %lu bytes\n", (unsigned long)softsoil_size());
  if (argc < 2) {
    printf("usage: %s LOG.csv [seconds to skip]\n", argv[0]);
    return 2;
  }
  if (!read_table(argv[1], &table)) {
    fprintf(stderr, "expected a table with a header line, found none at %s\n", argv[1]);
    return 2;
  }
  const size_t first = first_row(&table, skip);
  softsoil_defaults(&options);
  softsoil_init(&s, &options, NULL, NULL, 0.0);
  memcpy(x0, s.x, sizeof x0);
  memcpy(std0, s.std, sizeof std0);
  first_state(&table, first, x0, std0);
  int status = softsoil_init(&s, &options, x0, std0, cell(&table, first, "t"));
  softsoil_horizon_defaults(&about);
  about.dt = sample_time(&table);
  about.start_up = 0.0; /* the start-up is skipped */
  if (status >= SOFTSOIL_MEASUREMENT_LATE || softsoil_horizon_init(&h, &about, s.t) >= SOFTSOIL_BAD_ARGUMENT) {
    fprintf(stderr, "expected a column t with samples every %g to %g s, found %g s\n", SOFTSOIL_HORIZON_MIN_DT,
            SOFTSOIL_HORIZON_MAX_DT, about.dt);
    return 2;
  }
  double said = s.t, ahead = 0.0; /* the horizon's clock before that of the log */
  for (size_t row = first; row < table.rows; ++row) {
    const double t = cell(&table, row, "t");
    int began = 0;
    for (int i = 0; i < SOFTSOIL_N_Y; ++i) y[i] = cell(&table, row, measurement_names[i]);
    if (row > first) {
      status = take(&s, &tally, u, y, t, &began);
      if (began) {
        printf("%9.3f   the motion starts again\n", t);
        if (t + ahead < h.clock + PAUSE) ahead = h.clock + PAUSE - t;
        said = t;
      }
    }
    for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = input(&table, row, input_names[i], &s); /* held until the next row */
    if (status >= SOFTSOIL_MEASUREMENT_LATE) continue;
    softsoil_horizon_push(&h, u, y, NULL, t + ahead);
    softsoil_horizon_update(&h);
    softsoil_vehicle_update(&look, &h);
    if (s.t >= said + 1.0) {
      said = s.t;
      say(&s);
    }
  }
  say(&s);
  judge(&h);
  if (look.windows == 0) printf("vehicle: not looked at yet\n");
  else printf("vehicle: load %+.1f +- %.1f %% of its mass, strain %.1f%s\n", 100 * look.load, 100 * look.load_std,
              look.strain, look.change == SOFTSOIL_VEHICLE_UNKNOWN ? ", a load would not show yet" : "");
  if (look.change == SOFTSOIL_VEHICLE_OTHER_STEERING)
    printf("steering: road wheels turn %+.1f +- %.1f %% farther than steer says\n", 100 * look.steering,
           100 * look.steering_std);
  for (int i = 1; i < SOFTSOIL_STATUS_COUNT; ++i)
    if (s.counts[i]) printf("%8lu x %s\n", (unsigned long)s.counts[i], softsoil_status_text(i));
  printf("%lu of %lu rows not used for their time stamps, the motion started again %lu times\n", tally.refused, tally.rows,
         tally.starts);
  free(table.values);
  if (2 * tally.refused <= tally.rows) return 0;
  fprintf(stderr, "expected time stamps that grow by %g s at most, found that most rows' do not\n", SOFTSOIL_MAX_DT);
  return 1;
}
