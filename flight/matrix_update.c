/* Matrix update: problem data and scaling blocks into the values of the KKT matrix. */
#include "kernels.h"
#include "reduce.h"

static void put(size_t count, const orbsoc_index *to, const orbsoc_real *from,
                orbsoc_real *values) {
  for (size_t k = 0; k < count; k++) { values[to[k]] = from[k]; }
}

/* P, A and G, scaled, into a zeroed matrix. */
void orbsoc_load_kkt(pattern_t pattern, const orbsoc_real *p, const orbsoc_real *a,
                     const orbsoc_real *g, orbsoc_real *values) {
  for (size_t k = 0; k < pattern->nnz_kkt; k++) { values[k] = 0; }
  put(pattern->nnz_p, pattern->from_p, p, values);
  put(pattern->nnz_a, pattern->from_a, a, values);
  put(pattern->nnz_g, pattern->from_g, g, values);
}

/* Entries of a cone's block: its upper triangle, or diagonal, v with its pivot, u with its pivot.
 * */
static size_t block_entries(size_t dim) {
  return (dim <= ORBSOC_DENSE_CONE) ? dim * (dim + 1) / 2 : 3 * dim + 1;
}

/* -W^2 = -I, for the starting point, and the regularisation before there is a point. */
void orbsoc_identity_blocks(pattern_t pattern, const orbsoc_real *parameters, orbsoc_real *values,
                            orbsoc_real *regularization) {
  const orbsoc_index *block = pattern->soc;
  orbsoc_first_regularization(parameters, regularization);
  for (size_t k = 0; k < pattern->l; k++) { values[pattern->orthant[k]] = -1; }
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    for (size_t i = 0; i < block_entries(dim); i++) { values[block[i]] = 0; }
    if (dim <= ORBSOC_DENSE_CONE) {
      for (size_t j = 0; j < dim; j++) { values[block[(j + 1) * (j + 2) / 2 - 1]] = -1; }
    } else {
      for (size_t i = 0; i < dim; i++) { values[block[i]] = -1; }
      values[block[2 * dim - 1]] = -1;
      values[block[3 * dim]] = 1;
    }
    block = &block[block_entries(dim)];
  }
}

/* -eta^2 (2 w w' - J), upper triangle column by column. */
static void dense_block(size_t dim, orbsoc_real eta_sq, const orbsoc_real *w,
                        const orbsoc_index *block, orbsoc_real *values) {
  const orbsoc_real minus_two_eta_sq = -(eta_sq + eta_sq);
  size_t next = 0;
  for (size_t j = 0; j < dim; j++) {
    const orbsoc_real column = minus_two_eta_sq * w[j];
    for (size_t i = 0; i < j; i++) {
      values[block[next]] = column * w[i];
      next++;
    }
    const orbsoc_real square = column * w[j];
    values[block[next]] = (j == 0) ? square + eta_sq : square - eta_sq;
    next++;
  }
}

/* -eta^2 (D + u u' - v v') as a bordered block whose two extra unknowns are scaled by u0. */
static void expanded_block(size_t dim, orbsoc_real eta_sq, const orbsoc_real *w,
                           const orbsoc_index *block, orbsoc_real *values) {
  const orbsoc_real head = w[0], minus = -eta_sq;
  const orbsoc_real omega = dot(dim - 1, &w[1], &w[1]) + head * head;
  const orbsoc_real inverse = 1 / omega;
  const orbsoc_real d = real(0.5) * inverse;
  const orbsoc_real pivot = eta_sq * (omega - d);
  const orbsoc_real by_v = minus * ORBSOC_SQRT(2 + inverse);
  const orbsoc_real by_u = minus * (head + head);
  const orbsoc_index *v = &block[dim], *u = &block[2 * dim];
  values[block[0]] = minus * d;
  values[v[dim - 1]] = -pivot;
  values[u[0]] = -pivot;
  values[u[dim]] = pivot;
  for (size_t i = 1; i < dim; i++) {
    values[block[i]] = minus;
    values[v[i - 1]] = by_v * w[i];
    values[u[i]] = by_u * w[i];
  }
}

/* -W^2: w^2 of each nonnegative row, eta^2 (2 w w' - J) of each second-order cone. */
void orbsoc_scaling_blocks(pattern_t pattern, const orbsoc_real *w, const orbsoc_real *cone,
                           orbsoc_real *values) {
  const orbsoc_index *block = pattern->soc;
  for (size_t k = 0; k < pattern->l; k++) { values[pattern->orthant[k]] = -(w[k] * w[k]); }
  w += pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    const orbsoc_real eta_sq = cone[k * CONE_SCALARS + ETA_SQ];
    if (dim <= ORBSOC_DENSE_CONE) {
      dense_block(dim, eta_sq, w, block, values);
    } else {
      expanded_block(dim, eta_sq, w, block, values);
    }
    w += dim;
    block = &block[block_entries(dim)];
  }
}
