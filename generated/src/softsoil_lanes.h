/* Several points at once: the vector type `ssv` where the compiler has one, plain `double` elsewhere.
 *
 * SOFTSOIL_SCALAR chooses plain C99 everywhere. SOFTSOIL_LANES is the number of points in a vector: what a register of
 * the target holds. exp, log, sin and cos are branch-free polynomials, within a few units in the last place; with one lane
 * they are the C library's. */
#ifndef SOFTSOIL_LANES_H
#define SOFTSOIL_LANES_H

#include <math.h>
#include <string.h>

#if !defined(SOFTSOIL_SCALAR) && (defined(__GNUC__) || defined(__clang__))
#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define SOFTSOIL_LANES 8
#elif defined(__AVX__)
#define SOFTSOIL_LANES 4
#elif defined(__SSE2__) || (defined(__aarch64__) && defined(__ARM_NEON))
#define SOFTSOIL_LANES 2
#endif
#endif
#ifndef SOFTSOIL_LANES
#define SOFTSOIL_LANES 1
#endif

/* What C has no function for, as CasADi means it: truth is 1.0, false 0.0. */
static inline double ss_lt(double a, double b) { return a < b ? 1.0 : 0.0; }
static inline double ss_le(double a, double b) { return a <= b ? 1.0 : 0.0; }
static inline double ss_ne(double a, double b) { return (a < b || a > b) ? 1.0 : 0.0; }
static inline double ss_eq(double a, double b) { return (a <= b && a >= b) ? 1.0 : 0.0; }
static inline double ss_not(double a) { return (a < 0.0 || a > 0.0) ? 0.0 : 1.0; }
static inline double ss_and(double a, double b) { return (1.0 - ss_not(a)) * (1.0 - ss_not(b)); }
static inline double ss_or(double a, double b) { return 1.0 - ss_not(a) * ss_not(b); }
static inline double ss_sign(double a) { return ss_lt(0.0, a) - ss_lt(a, 0.0); }
static inline double ss_if_else_zero(double c, double a) { return (c < 0.0 || c > 0.0) ? a : 0.0; }
static inline double ss_fmin(double a, double b) { return a < b ? a : b; }
static inline double ss_fmax(double a, double b) { return a > b ? a : b; }

#if SOFTSOIL_LANES == 1

typedef double ssv;
#define ssv_all(a) (a)
#define ssv_load(p) (*(p))
#define ssv_store(p, a) (*(p) = (a))
#define ssv_first(a) (a)
#define ssv_div(a, b) ((a) / (b))
#define ssv_exp exp
#define ssv_log log
#define ssv_sqrt sqrt
#define ssv_fabs fabs
#define ssv_sin sin
#define ssv_cos cos
#define ssv_tan tan
#define ssv_asin asin
#define ssv_acos acos
#define ssv_atan atan
#define ssv_sinh sinh
#define ssv_cosh cosh
#define ssv_tanh tanh
#define ssv_asinh asinh
#define ssv_acosh acosh
#define ssv_atanh atanh
#define ssv_erf erf
#define ssv_floor floor
#define ssv_ceil ceil
#define ssv_log1p log1p
#define ssv_expm1 expm1
#define ssv_atan2 atan2
#define ssv_pow pow
#define ssv_fmod fmod
#define ssv_copysign copysign
#define ssv_hypot hypot
#define ssv_fmin ss_fmin
#define ssv_fmax ss_fmax
#define ssv_lt ss_lt
#define ssv_le ss_le
#define ssv_eq ss_eq
#define ssv_ne ss_ne
#define ssv_not ss_not
#define ssv_and ss_and
#define ssv_or ss_or
#define ssv_sign ss_sign
#define ssv_if_else_zero ss_if_else_zero

#else

#if defined(__SSE2__)
#include <immintrin.h>
#else
#include <arm_neon.h>
#endif

typedef double ssv __attribute__((vector_size(8 * SOFTSOIL_LANES)));
typedef long long ssv_bits __attribute__((vector_size(8 * SOFTSOIL_LANES)));
typedef unsigned long long ssv_words __attribute__((vector_size(8 * SOFTSOIL_LANES))); /* of sums and shifts that may wrap */

/* Compilers would call some of these, and every call puts away all vector registers. */
#define SSV_INLINE static inline __attribute__((always_inline))

SSV_INLINE ssv ssv_all(double a) {
#if SOFTSOIL_LANES == 8
  return (ssv)_mm512_set1_pd(a);
#elif SOFTSOIL_LANES == 4
  return (ssv)_mm256_set1_pd(a);
#elif defined(__SSE2__)
  return (ssv)_mm_set1_pd(a);
#else
  return (ssv)vdupq_n_f64(a);
#endif
}
SSV_INLINE ssv_bits ssv_all_bits(long long a) {
#if SOFTSOIL_LANES == 8
  return (ssv_bits)_mm512_set1_epi64(a);
#elif SOFTSOIL_LANES == 4
  return (ssv_bits)_mm256_set1_epi64x(a);
#elif defined(__SSE2__)
  return (ssv_bits)_mm_set1_epi64x(a);
#else
  return (ssv_bits)vdupq_n_s64(a);
#endif
}
static inline ssv ssv_load(const double *p) {
  ssv y;
  memcpy(&y, p, sizeof y);
  return y;
}
static inline void ssv_store(double *p, ssv a) { memcpy(p, &a, sizeof a); }
static inline double ssv_first(ssv a) { return a[0]; }
static inline ssv ssv_pick(ssv_bits where, ssv yes, ssv no) {
  return (ssv)((where & (ssv_bits)yes) | (~where & (ssv_bits)no));
}
static inline ssv ssv_fabs(ssv x) { return (ssv)((ssv_bits)x & ssv_all_bits(0x7fffffffffffffffLL)); }
/* a < b ? a : b and a > b ? a : b, NaN in either giving b: what the processor's own instructions do. */
SSV_INLINE ssv ssv_fmin(ssv a, ssv b) {
#if SOFTSOIL_LANES == 8
  return (ssv)_mm512_min_pd((__m512d)a, (__m512d)b);
#elif SOFTSOIL_LANES == 4
  return (ssv)_mm256_min_pd((__m256d)a, (__m256d)b);
#elif defined(__SSE2__)
  return (ssv)_mm_min_pd((__m128d)a, (__m128d)b);
#else
  return ssv_pick((ssv_bits)(a < b), a, b);
#endif
}
SSV_INLINE ssv ssv_fmax(ssv a, ssv b) {
#if SOFTSOIL_LANES == 8
  return (ssv)_mm512_max_pd((__m512d)a, (__m512d)b);
#elif SOFTSOIL_LANES == 4
  return (ssv)_mm256_max_pd((__m256d)a, (__m256d)b);
#elif defined(__SSE2__)
  return (ssv)_mm_max_pd((__m128d)a, (__m128d)b);
#else
  return ssv_pick((ssv_bits)(a > b), a, b);
#endif
}
static inline ssv ssv_truth(ssv_bits c) { return (ssv)(c & (ssv_bits)ssv_all(1.0)); }
static inline ssv_bits ssv_true(ssv a) { return (ssv_bits)(a < ssv_all(0.0)) | (ssv_bits)(a > ssv_all(0.0)); }
static inline ssv ssv_lt(ssv a, ssv b) { return ssv_truth((ssv_bits)(a < b)); }
static inline ssv ssv_le(ssv a, ssv b) { return ssv_truth((ssv_bits)(a <= b)); }
static inline ssv ssv_eq(ssv a, ssv b) { return ssv_truth((ssv_bits)(a <= b) & (ssv_bits)(a >= b)); }
static inline ssv ssv_ne(ssv a, ssv b) { return ssv_truth((ssv_bits)(a < b) | (ssv_bits)(a > b)); }
static inline ssv ssv_not(ssv a) { return ssv_truth(~ssv_true(a)); }
static inline ssv ssv_and(ssv a, ssv b) { return ssv_truth(ssv_true(a) & ssv_true(b)); }
static inline ssv ssv_or(ssv a, ssv b) { return ssv_truth(ssv_true(a) | ssv_true(b)); }
static inline ssv ssv_sign(ssv a) { return ssv_lt(ssv_all(0.0), a) - ssv_lt(a, ssv_all(0.0)); }
static inline ssv ssv_if_else_zero(ssv c, ssv a) { return (ssv)(ssv_true(c) & (ssv_bits)a); }

/* The widest registers have one slow divider; a reciprocal estimate and Newton steps on their multipliers, within two units
 * in the last place, take a quarter of its time. Where the divisor is zero or infinite the estimate stands. */
SSV_INLINE ssv ssv_div(ssv a, ssv b) {
#if SOFTSOIL_LANES == 8
  const __m512d below = (__m512d)b, guess = _mm512_rcp14_pd(below);
  const __m512d e = _mm512_fnmadd_pd(below, guess, _mm512_set1_pd(1.0));
  const __mmask8 usual = _mm512_cmp_pd_mask(e, e, _CMP_ORD_Q);
  const __m512d r = _mm512_mask3_fmadd_pd(guess, e, guess, usual);
  const __m512d q = _mm512_mul_pd((__m512d)a, r);
  return (ssv)_mm512_mask3_fmadd_pd(_mm512_fnmadd_pd(below, q, (__m512d)a), r, q, usual);
#else
  return a / b;
#endif
}

SSV_INLINE ssv ssv_sqrt(ssv x) {
#if SOFTSOIL_LANES == 8
  /* The tiny term keeps the root of zero zero, and is lost in the rounding of anything else. */
  const __m512d square = (__m512d)x, r = _mm512_rsqrt14_pd(_mm512_add_pd(square, _mm512_set1_pd(2.3e-308)));
  const __m512d y = _mm512_mul_pd(square, r), h = _mm512_mul_pd(_mm512_set1_pd(0.5), r);
  const __m512d e = _mm512_fnmadd_pd(y, h, _mm512_set1_pd(0.5));
  const __m512d y_1 = _mm512_fmadd_pd(y, e, y), h_1 = _mm512_fmadd_pd(h, e, h);
  return (ssv)_mm512_fmadd_pd(_mm512_fnmadd_pd(y_1, y_1, square), h_1, y_1);
#elif SOFTSOIL_LANES == 4
  return (ssv)_mm256_sqrt_pd((__m256d)x);
#elif defined(__SSE2__)
  return (ssv)_mm_sqrt_pd((__m128d)x);
#else
  return (ssv)vsqrtq_f64((float64x2_t)x);
#endif
}

/* 2^k e^r with |r| <= ln(2)/2; e^r by a polynomial of degree 11, even and odd powers apart; beyond +-708 the ends are kept. */
SSV_INLINE ssv ssv_exp(ssv x) {
  x = ssv_fmin(ssv_all(709.0), ssv_fmax(ssv_all(-708.0), x));
  /* The exponent's bias is in the constant, so that the shift alone makes 2^k. */
  const ssv t = x * 1.4426950408889634 + 6755399441056767.0, k = t - 6755399441056767.0;
  const ssv r = (x - k * 0.6931471803691238) - k * 1.9082149292705877e-10, z = r * r;
  ssv even = z * 2.7620088445409746e-07 + 2.4801521295954376e-05;
  ssv odd = z * 2.510038549551032e-08 + 2.7557268459997064e-06;
  even = even * z + 0.0013888888917213717;
  odd = odd * z + 0.00019841269863053618;
  even = even * z + 0.04166666666662413;
  odd = odd * z + 0.008333333333330062;
  even = even * z + 0.5;
  odd = odd * z + 0.16666666666666669;
  return (z * (odd * r + even) + (r + 1.0)) * (ssv)((ssv_words)t << 52);
}

/* e ln(2) + log(m), m in [sqrt(1/2), sqrt(2)), log(m) = 2 atanh((m - 1)/(m + 1)) by fdlibm's polynomial; NaN at and below
 * zero. */
SSV_INLINE ssv ssv_log(ssv x) {
  const ssv_words bits = (ssv_words)x, least = (ssv_words)ssv_all_bits(0x3fe6a09e667f3bcdLL);
  const ssv_words e = (ssv_words)((ssv_bits)(bits - least) >> 52);
  const ssv m = (ssv)(bits - (e << 52)), k = (ssv)(e + (ssv_words)ssv_all_bits(0x4338000000000000LL)) - 6755399441055744.0;
  const ssv f = m - 1.0, s = ssv_div(f, f + 2.0), z = s * s, w = z * z;
  ssv even = w * 1.479819860511658591e-01 + 1.818357216161805012e-01;
  ssv odd = w * 1.531383769920937332e-01 + 2.222219843214978396e-01;
  even = even * w + 2.857142874366239149e-01;
  odd = odd * w + 3.999999999940941908e-01;
  even = even * w + 6.666666666666735130e-01;
  const ssv y = k * 0.6931471803691238 + (2.0 * s + (s * z * (odd * z + even) + k * 1.9082149292705877e-10));
  return (ssv)((ssv_bits)y | ~(ssv_bits)(x > ssv_all(0.0)));
}

/* Reduced by multiples of pi/2 in three parts: good for |x| up to 1e5 rad, far more than a wrapped yaw angle. */
SSV_INLINE void ssv_sincos(ssv x, ssv *sine, ssv *cosine) {
  const ssv t = x * 0.6366197723675814 + 6755399441055744.0, k = t - 6755399441055744.0;
  ssv r = x - k * 1.57079632673412561417e+00;
  r = r - k * 6.07710050630396597660e-11;
  r = r - k * 2.02226624879595063154e-21;
  const ssv z = r * r;
  ssv s = z * 1.58969099521155010221e-10 - 2.50507602534068634195e-08;
  s = s * z + 2.75573137070700676789e-06;
  s = s * z - 1.98412698298579493134e-04;
  s = s * z + 8.33333333332248946124e-03;
  s = s * z - 1.66666666666666324348e-01;
  s = r + r * z * s;
  ssv c = z * -1.13596475577881948265e-11 + 2.08757232129817482790e-09;
  c = c * z - 2.75573143513906633035e-07;
  c = c * z + 2.48015872894767294178e-05;
  c = c * z - 1.38888888888741095749e-03;
  c = c * z + 4.16666666666666019037e-02;
  c = (1.0 - 0.5 * z) + z * z * c;
  const ssv_words quadrant = (ssv_words)t, one = (ssv_words)ssv_all_bits(1), two = one + one;
  const ssv_bits odd = (ssv_bits)(-(quadrant & one));
  const ssv_words sine_sign = (quadrant & two) << 62, cosine_sign = ((quadrant + one) & two) << 62;
  *sine = (ssv)((ssv_words)ssv_pick(odd, c, s) ^ sine_sign);
  *cosine = (ssv)((ssv_words)ssv_pick(odd, s, c) ^ cosine_sign);
}
static inline ssv ssv_sin(ssv x) {
  ssv s, c;
  ssv_sincos(x, &s, &c);
  return s;
}
static inline ssv ssv_cos(ssv x) {
  ssv s, c;
  ssv_sincos(x, &s, &c);
  return c;
}

/* The rest, one lane after the other. */
#define SSV_EACH(name)                                              \
  static inline ssv ssv_##name(ssv x) {                             \
    ssv y;                                                          \
    for (int l = 0; l < SOFTSOIL_LANES; ++l) y[l] = name(x[l]);     \
    return y;                                                       \
  }
#define SSV_EACH_TWO(name)                                          \
  static inline ssv ssv_##name(ssv a, ssv b) {                      \
    ssv y;                                                          \
    for (int l = 0; l < SOFTSOIL_LANES; ++l) y[l] = name(a[l], b[l]); \
    return y;                                                       \
  }
SSV_EACH(tan)
SSV_EACH(asin)
SSV_EACH(acos)
SSV_EACH(atan)
SSV_EACH(sinh)
SSV_EACH(cosh)
SSV_EACH(tanh)
SSV_EACH(asinh)
SSV_EACH(acosh)
SSV_EACH(atanh)
SSV_EACH(erf)
SSV_EACH(floor)
SSV_EACH(ceil)
SSV_EACH(log1p)
SSV_EACH(expm1)
SSV_EACH_TWO(atan2)
SSV_EACH_TWO(pow)
SSV_EACH_TWO(fmod)
SSV_EACH_TWO(copysign)
SSV_EACH_TWO(hypot)

#endif
#endif
