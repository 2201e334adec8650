/* Reads a log and prints the sinkage exponent with its verdict: example LOG.csv [seconds to skip].
 *
 * The log is a table with a header: t (s), the measurements x, y, psi, u, v, omega_z, and for the inputs
 * steer, a_x_imu and the wheel speeds; columns it does not know are passed over, empty cells and nan are missing values. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "softsoil.h"
#include "softsoil_horizon.h"
#include "softsoil_vehicle.h"

#define LINE 8192
#define COLUMNS 128

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

static double input(const table_t *table, size_t row, const char *name) {
  if (strcmp(name, "steer_rate") == 0) return slope(table, row, "steer");
  /* The accelerometer reads du/dt - v omega_z, the model wants du/dt. */
  if (strcmp(name, "a_x") == 0) return cell(table, row, "a_x_imu") + cell(table, row, "v") * cell(table, row, "omega_z");
  return cell(table, row, name);
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
  size_t first = 0;
  while (first + 1 < table.rows && cell(&table, first, "t") < cell(&table, 0, "t") + skip) ++first;
  softsoil_defaults(&options);
  softsoil_init(&s, &options, NULL, NULL, 0.0);
  for (int i = 0; i < SOFTSOIL_N_X; ++i) {
    const double seen = cell(&table, first, state_names[i]);
    x0[i] = isfinite(seen) ? seen : s.x[i];
    std0[i] = s.std[i];
  }
  int status = softsoil_init(&s, &options, x0, std0, cell(&table, first, "t"));
  softsoil_horizon_defaults(&about);
  about.dt = (cell(&table, table.rows - 1, "t") - cell(&table, 0, "t")) / (double)(table.rows - 1);
  about.start_up = skip;
  if (softsoil_horizon_init(&h, &about, cell(&table, 0, "t")) >= SOFTSOIL_BAD_ARGUMENT) {
    fprintf(stderr, "expected samples every %g to %g s, found %g s\n", SOFTSOIL_HORIZON_MIN_DT, SOFTSOIL_HORIZON_MAX_DT, about.dt);
    return 2;
  }
  for (size_t row = 0; row < table.rows; ++row) {
    for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = input(&table, row, input_names[i]);
    for (int i = 0; i < SOFTSOIL_N_Y; ++i) y[i] = cell(&table, row, measurement_names[i]);
    softsoil_horizon_push(&h, u, y, NULL, cell(&table, row, "t"));
    softsoil_horizon_update(&h);
    softsoil_vehicle_update(&look, &h);
  }
  double said = s.t;
  for (size_t row = first; row + 1 < table.rows && status < SOFTSOIL_BAD_ARGUMENT; ++row) {
    const double t = cell(&table, row + 1, "t");
    for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = input(&table, row, input_names[i]);
    status = softsoil_predict(&s, u, t - s.t);
    for (int i = 0; i < SOFTSOIL_N_Y; ++i) y[i] = cell(&table, row + 1, measurement_names[i]);
    status = softsoil_update(&s, y, NULL, t);
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
  for (int i = 1; i < SOFTSOIL_STATUS_COUNT; ++i)
    if (s.counts[i]) printf("%8lu x %s\n", (unsigned long)s.counts[i], softsoil_status_text(i));
  free(table.values);
  return status >= SOFTSOIL_BAD_ARGUMENT ? 1 : 0;
}
