/* Vectors of three numbers. */
#ifndef ORBSOC_VECTORS_H
#define ORBSOC_VECTORS_H

#include <math.h>

#include "real.h"

static inline double dot(const double *a, const double *b) {
  return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]);
}

static inline double norm(const double *a) { return sqrt(dot(a, a)); }

static inline void cross(const double *a, const double *b, double *out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

/* The Laplace vector v x (r x v) - r/|r| of a state; it points to the perigee. */
static inline void laplace_vector(const double *state, double *out) {
  const double *r = state, *v = &state[3];
  const double square = dot(v, v), radial = dot(r, v), radius = norm(r);
  for (size_t i = 0; i < 3u; i++) { out[i] = square * r[i] - radial * v[i] - r[i] / radius; }
}

#endif
