/* Line search: the largest step that stays in the cone. */
#include "kernels.h"
#include "reduce.h"

/* Reciprocal of the largest a with lambda + a delta in K, zero when every step stays inside.
 * Branch-free, and without the quadratic formula, whose discriminant cancels: per cone it is max(0,
 * |rho1| - rho0). */
orbsoc_real orbsoc_inverse_step(pattern_t pattern, const orbsoc_scaling *at,
                                const orbsoc_real *delta, orbsoc_real *rho) {
  orbsoc_real inverse = max_negative_product(pattern->l, delta, at->lambda_inverse);
  size_t row = pattern->l;
  for (size_t k = 0; k < pattern->cones; k++) {
    const size_t dim = pattern->cone_dims[k];
    const orbsoc_real *lambda = &at->lambda[row], *d = &delta[row];
    const orbsoc_real *scalars = &at->cone[k * CONE_SCALARS];
    const orbsoc_real root_inverse = scalars[LAMBDA_ROOT_INV];
    const orbsoc_real product =
        (scalars[GAMMA] * d[0]) - root_inverse * dot(dim - 1, &lambda[1], &d[1]);
    const orbsoc_real factor = ((product + d[0]) * scalars[INV_ONE_PLUS_GAMMA]) * root_inverse;
    for (size_t i = 1; i < dim; i++) { rho[i - 1] = d[i] - factor * lambda[i]; }
    inverse = larger(inverse, (norm2(dim - 1, rho) - product) * root_inverse);
    row += dim;
  }
  return inverse;
}
