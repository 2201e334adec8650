/* Fuzz target for libFuzzer: bytes are calls of the library with any numbers in them.
 *
 *   clang -O1 -g -fsanitize=fuzzer,address,undefined -Igenerated/include benchmarks/clibrary_fuzz.c generated/src/ *.c -lm
 *
 * (`python benchmarks/clibrary_trust.py fuzz` builds and runs it.) The promise after every call, whatever came before: a
 * known status, an estimate that is finite and inside its bounds, standard deviations that are finite. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "softsoil.h"

typedef struct {
  const uint8_t *at;
  size_t left;
} bytes_t;

static unsigned byte(bytes_t *b) {
  if (b->left == 0) return 0;
  --b->left;
  return *b->at++;
}

/* A plain number in most cases, so that the calls get past the checks, and any bits at all in the others. */
static double number(bytes_t *b, double scale) {
  const unsigned kind = byte(b);
  if (kind < 200) return scale * ((double)kind - 100.0) / 100.0;
  uint64_t bits = 0;
  for (int i = 0; i < 8; ++i) bits = bits << 8 | byte(b);
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static void promise(const softsoil_t *s, int status) {
  if (status < 0 || status >= SOFTSOIL_STATUS_COUNT || !softsoil_status_text(status)) abort();
  for (int i = 0; i < SOFTSOIL_N_X; ++i)
    if (!isfinite(s->x[i]) || !isfinite(s->std[i]) || s->std[i] < 0.0 || fabs(s->x[i]) > 1.000001e9) abort();
  if (!(s->drift >= 0.0) || s->drift_channel < 0 || s->drift_channel >= SOFTSOIL_N_DRIFT || s->flags > 63) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes_t b = {data, size};
  softsoil_t s;
  softsoil_options_t o;
  double x[SOFTSOIL_N_X], std[SOFTSOIL_N_X], u[SOFTSOIL_N_U], y[SOFTSOIL_N_Y];
  unsigned char valid[SOFTSOIL_N_Y];
  softsoil_init(&s, NULL, NULL, NULL, 0.0);
  while (b.left > 0) {
    const unsigned call = byte(&b) % 8;
    int status = SOFTSOIL_OK;
    if (call <= 2) {
      for (int i = 0; i < SOFTSOIL_N_U; ++i) u[i] = number(&b, i < 3 ? 1.0 : 40.0);
      status = softsoil_predict(&s, u, call == 2 ? number(&b, 1.0) : 0.012);
    } else if (call <= 5) {
      for (int i = 0; i < SOFTSOIL_N_Y; ++i) {
        y[i] = s.x[i] + number(&b, 2.0);
        valid[i] = (unsigned char)(byte(&b) % 4 != 0);
      }
      const double t = call == 5 ? number(&b, 1.0) : s.t;
      status = byte(&b) % 32 ? softsoil_update(&s, y, valid, t) : softsoil_restart(&s, y, valid, t);
    } else {
      softsoil_defaults(&o);
      if (call == 7) {
        for (int i = 0; i < SOFTSOIL_N_Y; ++i) o.r_std[i] = number(&b, 2.0);
        for (int i = 0; i < SOFTSOIL_N_X; ++i) o.q_std[i] = number(&b, 1.0);
        for (int i = 0; i < SOFTSOIL_N_P; ++i) o.p[i] *= 1.0 + number(&b, 0.5);
        o.gate = number(&b, 10.0);
        o.standstill_speed = number(&b, 1.0);
        o.gate_patience = (int32_t)byte(&b) - 8;
        o.gate_patience_rates = (int32_t)byte(&b) % 8 - 1;
        for (int i = 0; i < SOFTSOIL_N_Y; ++i) o.miss_std[i] = number(&b, 1.0);
        for (int i = 0; i < SOFTSOIL_N_X; ++i) o.kick_std[i] = number(&b, 1.0);
        o.fastest = number(&b, 2.0);
        o.run_in = number(&b, 1.0);
        o.common_error = number(&b, 1.0);
        o.change_after = number(&b, 1.0);
        o.change_sigmas = number(&b, 2.0);
        o.change_std = number(&b, 1.0);
        o.change_error = number(&b, 1.0);
      }
      for (int i = 0; i < SOFTSOIL_N_X; ++i) {
        x[i] = number(&b, 10.0);
        std[i] = number(&b, 3.0);
      }
      softsoil_t fresh;
      status = softsoil_init(&fresh, &o, x, std, number(&b, 10.0));
      if (status == SOFTSOIL_OK) s = fresh;
    }
    promise(&s, status);
  }
  return 0;
}
