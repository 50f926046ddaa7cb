/* Every dot product, norm and sum. The association is fixed here, once: below 8 terms left to right, from there
 * on 8 accumulators (term k goes to accumulator k mod 8), folded as a balanced tree. */
#ifndef ORBSOC_REDUCE_H
#define ORBSOC_REDUCE_H

#include "real.h"

#define ORBSOC_WAYS 8u

static inline orbsoc_real orbsoc_add(orbsoc_real a, orbsoc_real b) { return a + b; }

/* Deviation: a macro in place of a function, for C has no generic ones. FIRST(k) is a term, NEXT(sum, k) adds
 * another, JOIN joins two accumulators, EMPTY is what no terms give. */
#define ORBSOC_REDUCE(count, EMPTY, FIRST, NEXT, JOIN)                                          \
  do {                                                                                          \
    orbsoc_real way[ORBSOC_WAYS];                                                               \
    size_t k = 0;                                                                               \
    if ((count) < ORBSOC_WAYS) {                                                                \
      orbsoc_real sum = (EMPTY);                                                                \
      if ((count) > 0u) {                                                                       \
        sum = FIRST(0u);                                                                        \
      }                                                                                         \
      for (k = 1; k < (count); k++) {                                                           \
        sum = NEXT(sum, k);                                                                     \
      }                                                                                         \
      return sum;                                                                               \
    }                                                                                           \
    for (size_t v = 0; v < ORBSOC_WAYS; v++) {                                                  \
      way[v] = FIRST(v);                                                                        \
    }                                                                                           \
    for (k = ORBSOC_WAYS; k + ORBSOC_WAYS <= (count); k += ORBSOC_WAYS) {                       \
      for (size_t v = 0; v < ORBSOC_WAYS; v++) {                                                \
        way[v] = NEXT(way[v], k + v);                                                           \
      }                                                                                         \
    }                                                                                           \
    for (size_t v = 0; k + v < (count); v++) {                                                  \
      way[v] = NEXT(way[v], k + v);                                                             \
    }                                                                                           \
    return JOIN(JOIN(JOIN(way[0], way[4]), JOIN(way[2], way[6])),                               \
                JOIN(JOIN(way[1], way[5]), JOIN(way[3], way[7])));                              \
  } while (0)

/* Sum of a_k x_k, the x a stride apart. */
static inline orbsoc_real dot_strided(size_t count, const orbsoc_real *a, const orbsoc_real *x,
                                      size_t stride) {
#define FIRST(k) (a[k] * x[(k) * stride])
#define NEXT(sum, k) ((sum) + a[k] * x[(k) * stride])
  ORBSOC_REDUCE(count, 0, FIRST, NEXT, orbsoc_add);
#undef FIRST
#undef NEXT
}

static inline orbsoc_real dot(size_t count, const orbsoc_real *a, const orbsoc_real *b) {
  return dot_strided(count, a, b, 1);
}

/* Sum of values_k x[index_k]. */
static inline orbsoc_real dot_indexed(size_t count, const orbsoc_real *values,
                                      const orbsoc_index *index, const orbsoc_real *x) {
#define FIRST(k) (values[k] * x[index[k]])
#define NEXT(sum, k) ((sum) + values[k] * x[index[k]])
  ORBSOC_REDUCE(count, 0, FIRST, NEXT, orbsoc_add);
#undef FIRST
#undef NEXT
}

static inline orbsoc_real norm2(size_t count, const orbsoc_real *x) {
  return ORBSOC_SQRT(dot(count, x, x));
}

/* max |x_k|, the x a stride apart; zero for no terms. */
static inline orbsoc_real max_abs_strided(size_t count, const orbsoc_real *x, size_t stride) {
#define FIRST(k) magnitude(x[(k) * stride])
#define NEXT(top, k) larger(top, magnitude(x[(k) * stride]))
  ORBSOC_REDUCE(count, 0, FIRST, NEXT, larger);
#undef FIRST
#undef NEXT
}

static inline orbsoc_real max_abs(size_t count, const orbsoc_real *x) {
  return max_abs_strided(count, x, 1);
}

/* The magnitude, or `otherwise` where it is not above the floor. */
static inline orbsoc_real abs_above(orbsoc_real x, orbsoc_real floor_, orbsoc_real otherwise) {
  return (floor_ < magnitude(x)) ? magnitude(x) : otherwise;
}

/* min |x_k| of the terms beyond a floor, and of `most`. */
static inline orbsoc_real min_abs_above(size_t count, const orbsoc_real *x, orbsoc_real floor_,
                                        orbsoc_real most) {
#define FIRST(k) abs_above(x[k], floor_, most)
#define NEXT(least, k) smaller(least, abs_above(x[k], floor_, most))
  ORBSOC_REDUCE(count, most, FIRST, NEXT, smaller);
#undef FIRST
#undef NEXT
}

/* max |weight_k x_k|. */
static inline orbsoc_real max_abs_weighted(size_t count, const orbsoc_real *weight,
                                           const orbsoc_real *x) {
#define FIRST(k) magnitude(weight[k] * x[k])
#define NEXT(top, k) larger(top, magnitude(weight[k] * x[k]))
  ORBSOC_REDUCE(count, 0, FIRST, NEXT, larger);
#undef FIRST
#undef NEXT
}

/* Sum of |x_k|. */
static inline orbsoc_real sum_abs(size_t count, const orbsoc_real *x) {
#define FIRST(k) magnitude(x[k])
#define NEXT(sum, k) ((sum) + magnitude(x[k]))
  ORBSOC_REDUCE(count, 0, FIRST, NEXT, orbsoc_add);
#undef FIRST
#undef NEXT
}

/* max -x_k y_k, with zero among the candidates. */
static inline orbsoc_real max_negative_product(size_t count, const orbsoc_real *x,
                                               const orbsoc_real *y) {
#define FIRST(k) larger(0, -(x[k] * y[k]))
#define NEXT(top, k) larger(top, -(x[k] * y[k]))
  ORBSOC_REDUCE(count, 0, FIRST, NEXT, larger);
#undef FIRST
#undef NEXT
}

/* Sum of 0 x_k, the x a stride apart: zero when every entry is finite, NaN otherwise. */
static inline orbsoc_real non_finite_strided(size_t count, const orbsoc_real *x, size_t stride) {
#define FIRST(k) (x[(k) * stride] * 0)
#define NEXT(sum, k) ((sum) + x[(k) * stride] * 0)
  ORBSOC_REDUCE(count, 0, FIRST, NEXT, orbsoc_add);
#undef FIRST
#undef NEXT
}

#endif
