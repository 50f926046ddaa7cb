/* The arithmetic: every operation rounds once, c + a*b rounds twice, nothing is fused or reordered.
 * */
#ifndef ORBSOC_REAL_H
#define ORBSOC_REAL_H

#include <float.h>
#include <math.h>

#include "orbsoc_flight.h"

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif
#if defined(__FAST_MATH__)
#error "fast-math changes bits: compile without it"
#endif
#if !defined(FLT_EVAL_METHOD) || FLT_EVAL_METHOD != 0
#error "FLT_EVAL_METHOD must be 0 (on 32-bit x86: -msse2 -mfpmath=sse)"
#endif

#if ORBSOC_FP == 64
#define ORBSOC_SQRT(x) sqrt(x)
#else
#define ORBSOC_SQRT(x) sqrtf(x)
#endif

/* A function that is worth a copy at each call: its sizes are constants there. */
#if defined(__GNUC__)
#define ORBSOC_INLINE static inline __attribute__((always_inline))
#else
#define ORBSOC_INLINE static inline
#endif

/* A function that is not: it is called often and its time does not count. */
#if defined(__GNUC__)
#define ORBSOC_SHARED static __attribute__((noinline))
#else
#define ORBSOC_SHARED static
#endif

/* A literal or an input, rounded once. */
static inline orbsoc_real real(double value) { return (orbsoc_real)value; }

/* The magnitude: of NaN, too, without a branch on it. */
static inline orbsoc_real magnitude(orbsoc_real x) {
#if ORBSOC_FP == 64
  return fabs(x);
#else
  return fabsf(x);
#endif
}

/* The larger; NaN in b is dropped. */
static inline orbsoc_real larger(orbsoc_real a, orbsoc_real b) { return (a < b) ? b : a; }

/* The smaller; NaN in b is dropped. */
static inline orbsoc_real smaller(orbsoc_real a, orbsoc_real b) { return (b < a) ? b : a; }

#endif
