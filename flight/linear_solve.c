/* Linear solve: permuted substitution through L, D, L' and the refinement residual, for one right-
 * hand side or for two side by side. Subtractions into any one entry keep the order of the plain
 * loops. */
#include "kernels.h"
#include "reduce.h"

/* Bounds beyond this, in scaled data, count as this in the starting point of a quadratic cost. */
#define START_BOUND 100.0

/* Where a node's tables and columns begin. */
typedef struct {
  size_t first, panel, row, gather;
} place_t;

static size_t rows_of(const orbsoc_node *node) {
  return ((node->kind == ORBSOC_LEAVES) ? (size_t)node->width : 1u) *
         ((size_t)node->leading - node->diagonal);
}

static size_t panel_of(const orbsoc_node *node) {
  return (node->kind == ORBSOC_CONDENSED) ? 0u : (size_t)node->width * node->leading;
}

static size_t gathered(const orbsoc_node *node) {
  return (node->kind == ORBSOC_CONDENSED) ? 1u + node->leading - node->diagonal : 0u;
}

/* What the unknowns of a panel contribute to the rows below it. */
ORBSOC_INLINE void forward_below(size_t width, size_t leading, size_t size,
                                 const orbsoc_real *restrict l, const orbsoc_index *rows,
                                 size_t sides, const orbsoc_real *own, orbsoc_real *below) {
  for (size_t i = size; i < leading; i++) {
    orbsoc_real *entry = &below[(size_t)rows[i - size] * sides];
    orbsoc_real sum[2];
    for (size_t r = 0; r < sides; r++) { sum[r] = entry[r]; }
    for (size_t j = 0; j < width; j++) {
      for (size_t r = 0; r < sides; r++) {
        sum[r] = sum[r] - l[j * leading + i] * own[j * sides + r];
      }
    }
    for (size_t r = 0; r < sides; r++) { entry[r] = sum[r]; }
  }
}

/* L of a node: its own unknowns, then what they contribute to the rows below. */
ORBSOC_INLINE void forward_panel(const orbsoc_node *node, const orbsoc_real *restrict l,
                                 const orbsoc_index *rows, size_t sides, orbsoc_real *own,
                                 orbsoc_real *below) {
  const size_t leading = node->leading, size = node->diagonal, width = node->width;
  for (size_t j = 0; j < width; j++) {
    const size_t end = j - j % size + size;
    for (size_t i = j + 1; i < end; i++) {
      for (size_t r = 0; r < sides; r++) {
        own[i * sides + r] -= l[j * leading + i % size] * own[j * sides + r];
      }
    }
  }
  switch (width) {
    case 1:
      forward_below(1, leading, size, l, rows, sides, own, below);
      break;
    case 2:
      forward_below(2, leading, size, l, rows, sides, own, below);
      break;
    default:
      forward_below(width, leading, size, l, rows, sides, own, below);
      break;
  }
}

/* L of leaves: each column has rows of its own. */
static inline void forward_leaves(const orbsoc_node *node, const orbsoc_real *l,
                                  const orbsoc_index *rows, size_t sides, const orbsoc_real *own,
                                  orbsoc_real *below) {
  for (size_t j = 0; j < node->width; j++) {
    for (size_t i = 1; i < node->leading; i++) {
      orbsoc_real *entry = &below[(size_t)*rows * sides];
      for (size_t r = 0; r < sides; r++) { entry[r] = entry[r] - l[i] * own[j * sides + r]; }
      rows++;
    }
    l += node->leading;
  }
}

/* L of condensed columns: sums over whole rows of the matrix. */
static inline void forward_condensed(const orbsoc_system *system, const orbsoc_node *node,
                                     const place_t *at, size_t sides, const orbsoc_real *own,
                                     orbsoc_real *work, orbsoc_real *below) {
  const orbsoc_index *from = &system->pattern->gather_from[at->gather + 1];
  const orbsoc_index *rows = &system->pattern->row[at->row];
  const size_t width = node->width;
  for (size_t k = 0; k < width; k++) {
    for (size_t r = 0; r < sides; r++) {
      work[r * width + k] = own[k * sides + r] * system->pivot_inverse[at->first + k];
    }
  }
  for (size_t i = 0; i < rows_of(node); i++) {
    orbsoc_real *entry = &below[(size_t)rows[i] * sides];
    for (size_t r = 0; r < sides; r++) {
      entry[r] = entry[r] - dot(width, &system->values[from[i]], &work[r * width]);
    }
  }
}

/* `columns` columns of L' of a panel from column j on: rows below from the last one up, then the
 * columns after them in the block, from the last one down. */
ORBSOC_INLINE void backward_columns(const orbsoc_node *node, const orbsoc_real *restrict l,
                                    const orbsoc_index *rows, size_t j, size_t columns,
                                    size_t sides, const orbsoc_real *below, orbsoc_real *own) {
  const size_t leading = node->leading, size = node->diagonal, first = j - j % size;
  const orbsoc_real *column = &l[j * leading];
  orbsoc_real sum[8];
  for (size_t c = 0; c < columns * sides; c++) { sum[c] = own[j * sides + c]; }
  for (size_t i = leading; i-- > size;) {
    const orbsoc_real *by = &below[(size_t)rows[i - size] * sides];
    for (size_t c = 0; c < columns; c++) {
      for (size_t r = 0; r < sides; r++) {
        sum[c * sides + r] = sum[c * sides + r] - column[c * leading + i] * by[r];
      }
    }
  }
  for (size_t i = size; i-- > j + columns - first;) {
    const orbsoc_real *by = &own[(first + i) * sides];
    for (size_t c = 0; c < columns; c++) {
      for (size_t r = 0; r < sides; r++) {
        sum[c * sides + r] = sum[c * sides + r] - column[c * leading + i] * by[r];
      }
    }
  }
  for (size_t i = columns; i-- > 1u;) {
    for (size_t c = 0; c < i && size > 1u; c++) {
      for (size_t r = 0; r < sides; r++) {
        sum[c * sides + r] =
            sum[c * sides + r] - column[c * leading + j - first + i] * sum[i * sides + r];
      }
    }
  }
  for (size_t c = 0; c < columns * sides; c++) { own[j * sides + c] = sum[c]; }
}

/* L' of a panel, groups of four columns of a block from the last ones up. */
ORBSOC_INLINE void backward_panel(const orbsoc_node *node, const orbsoc_real *l,
                                  const orbsoc_index *rows, size_t sides, const orbsoc_real *below,
                                  orbsoc_real *own) {
  const size_t chain = (node->diagonal == 1u) ? (size_t)node->width : node->diagonal;
  for (size_t end = node->width; end > 0u; end -= chain) {
    size_t k = chain;
    for (; k >= 4u; k -= 4) {
      backward_columns(node, l, rows, end - chain + k - 4, 4, sides, below, own);
    }
    if (k == 3u) {
      backward_columns(node, l, rows, end - chain, 3, sides, below, own);
    } else if (k == 2u) {
      backward_columns(node, l, rows, end - chain, 2, sides, below, own);
    } else if (k == 1u) {
      backward_columns(node, l, rows, end - chain, 1, sides, below, own);
    }
  }
}

static inline void backward_leaves(const orbsoc_node *node, const orbsoc_real *l,
                                   const orbsoc_index *rows, size_t sides,
                                   const orbsoc_real *below, orbsoc_real *own) {
  const size_t count = (size_t)node->leading - 1;
  for (size_t j = 0; j < node->width; j++) {
    for (size_t i = count; i-- > 0u;) {
      const orbsoc_real *by = &below[(size_t)rows[j * count + i] * sides];
      for (size_t r = 0; r < sides; r++) {
        own[j * sides + r] = own[j * sides + r] - l[j * node->leading + 1 + i] * by[r];
      }
    }
  }
}

static inline void backward_condensed(const orbsoc_system *system, const orbsoc_node *node,
                                      const place_t *at, size_t sides, const orbsoc_real *below,
                                      orbsoc_real *work, orbsoc_real *own) {
  const orbsoc_index *from = &system->pattern->gather_from[at->gather + 1];
  const orbsoc_index *rows = &system->pattern->row[at->row];
  const size_t width = node->width;
  for (size_t k = 0; k < width * sides; k++) { work[k] = 0; }
  for (size_t i = 0; i < rows_of(node); i++) {
    const orbsoc_real *restrict row = &system->values[from[i]];
    for (size_t r = 0; r < sides; r++) {
      const orbsoc_real by = below[(size_t)rows[i] * sides + r];
      orbsoc_real *restrict to = &work[r * width];
      for (size_t k = 0; k < width; k++) { to[k] = to[k] - row[k] * by; }
    }
  }
  for (size_t k = 0; k < width; k++) {
    for (size_t r = 0; r < sides; r++) {
      own[k * sides + r] += system->pivot_inverse[at->first + k] * work[r * width + k];
    }
  }
}

/* x <- (LDL')^-1 x, in permuted order. `work` has `sides` words a column of the widest condensed
 * node. */
ORBSOC_INLINE void substitute(const orbsoc_system *system, size_t sides, orbsoc_real *work,
                              orbsoc_real *x) {
  pattern_t pattern = system->pattern;
  place_t at = {0, 0, 0, 0};
  for (size_t k = 0; k < pattern->nodes; k++) {
    const orbsoc_node *node = &pattern->node[k];
    orbsoc_real *own = &x[at.first * sides], *below = &x[(at.first + node->width) * sides];
    if (node->kind == ORBSOC_CONDENSED) {
      forward_condensed(system, node, &at, sides, own, work, below);
    } else if (node->kind == ORBSOC_LEAVES) {
      forward_leaves(node, &system->l[at.panel], &pattern->row[at.row], sides, own, below);
    } else {
      forward_panel(node, &system->l[at.panel], &pattern->row[at.row], sides, own, below);
    }
    at.first += node->width;
    at.panel += panel_of(node);
    at.row += rows_of(node);
    at.gather += gathered(node);
  }
  for (size_t k = 0; k < pattern->dim; k++) {
    for (size_t r = 0; r < sides; r++) {
      x[k * sides + r] = x[k * sides + r] * system->pivot_inverse[k];
    }
  }
  for (size_t k = pattern->nodes; k-- > 0u;) {
    const orbsoc_node *node = &pattern->node[k];
    at.first -= node->width;
    at.panel -= panel_of(node);
    at.row -= rows_of(node);
    at.gather -= gathered(node);
    orbsoc_real *own = &x[at.first * sides], *below = &x[(at.first + node->width) * sides];
    if (node->kind == ORBSOC_CONDENSED) {
      backward_condensed(system, node, &at, sides, below, work, own);
    } else if (node->kind == ORBSOC_LEAVES) {
      backward_leaves(node, &system->l[at.panel], &pattern->row[at.row], sides, below, own);
    } else {
      backward_panel(node, &system->l[at.panel], &pattern->row[at.row], sides, below, own);
    }
  }
}

/* error = rhs - K x with the unregularised matrix. An entry of the error takes its row's products
 * in the order of their columns, the diagonal first; those of a dense column are one sum. */
ORBSOC_INLINE void residual(const orbsoc_system *system, size_t sides, const orbsoc_real *rhs,
                            const orbsoc_real *x, orbsoc_real *restrict error) {
  pattern_t pattern = system->pattern;
  const orbsoc_index *dense = pattern->contiguous_columns;
  size_t block = 0;
  for (size_t k = 0; k < pattern->dim * sides; k++) { error[k] = rhs[k]; }
  for (size_t j = 0; j < pattern->dim; j++) {
    const size_t begin = pattern->kkt.begins[j], above = pattern->kkt.begins[j + 1] - begin - 1;
    const orbsoc_index *rows = &pattern->kkt.rows[begin];
    const orbsoc_real *column = &system->values[begin];
    orbsoc_real sum[2];
    block += (block < pattern->contiguous && j >= dense[block + 1]) ? 2u : 0u;
    const int whole = block < pattern->contiguous && j >= dense[block];
    for (size_t r = 0; r < sides; r++) {
      sum[r] = error[j * sides + r] - column[above] * x[j * sides + r];
    }
    if (whole != 0) {
      const size_t first = rows[0] * sides;
      for (size_t r = 0; r < sides; r++) {
        sum[r] = sum[r] - dot_strided(above, column, &x[first + r], sides);
      }
      for (size_t k = 0; k < above; k++) {
        for (size_t r = 0; r < sides; r++) {
          const orbsoc_real by = x[j * sides + r];
          error[first + k * sides + r] = error[first + k * sides + r] - column[k] * by;
        }
      }
    }
    for (size_t k = 0; k < above && whole == 0; k++) {
      const size_t i = rows[k] * sides;
      for (size_t r = 0; r < sides; r++) {
        sum[r] = sum[r] - column[k] * x[i + r];
        error[i + r] = error[i + r] - column[k] * x[j * sides + r];
      }
    }
    for (size_t r = 0; r < sides; r++) { error[j * sides + r] = sum[r]; }
  }
}

static orbsoc_real error_norm(size_t dim, const orbsoc_real *error, size_t sides) {
  return max_abs_strided(dim, error, sides) + non_finite_strided(dim, error, sides);
}

static void substitute_sides(const orbsoc_system *system, size_t sides, orbsoc_real *work,
                             orbsoc_real *x) {
  if (sides == 1u) {
    substitute(system, 1, work, x);
  } else {
    substitute(system, 2, work, x);
  }
}

static void residual_sides(const orbsoc_system *system, size_t sides, const orbsoc_real *rhs,
                           const orbsoc_real *x, orbsoc_real *error) {
  if (sides == 1u) {
    residual(system, 1, rhs, x, error);
  } else {
    residual(system, 2, rhs, x, error);
  }
}

void orbsoc_linear_solve(const orbsoc_system *system, size_t sides, const orbsoc_real *rhs,
                         orbsoc_real *x) {
  for (size_t k = 0; k < system->pattern->dim * sides; k++) { x[k] = rhs[k]; }
  substitute_sides(system, sides, system->scratch, x);
}

/* The residual's norm, and what it may be: a fraction of the right-hand side, or `tolerance`. */
void orbsoc_measure(const orbsoc_system *system, size_t sides, const orbsoc_real *rhs,
                    orbsoc_real relative, orbsoc_real tolerance, const orbsoc_real *x,
                    orbsoc_real *error, orbsoc_real *state) {
  const size_t dim = system->pattern->dim;
  residual_sides(system, sides, rhs, x, error);
  for (size_t r = 0; r < sides; r++) {
    orbsoc_real *own = &state[r * REFINEMENT_WORDS];
    own[ERROR_NORM] = error_norm(dim, &error[r], sides);
    own[ALLOWED] = larger(tolerance, relative * max_abs_strided(dim, &rhs[r], sides));
    own[WORTHWHILE] = own[ERROR_NORM];
  }
}

/* One refinement step. Of each right-hand side, the new solution and error replace the old where
 * their norm is smaller, and not where it is not a number: a branch on data around a copy. */
void orbsoc_refine(const orbsoc_system *system, size_t sides, const orbsoc_real *rhs,
                   orbsoc_real active, orbsoc_real *x, orbsoc_real *error, orbsoc_real *state) {
  const size_t dim = system->pattern->dim, count = dim * sides;
  orbsoc_real *candidate = system->scratch, *found = &candidate[count], *work = &found[count];
  for (size_t k = 0; k < count; k++) { candidate[k] = error[k]; }
  substitute_sides(system, sides, work, candidate);
  for (size_t k = 0; k < count; k++) { candidate[k] = x[k] + candidate[k]; }
  residual_sides(system, sides, rhs, candidate, found);
  for (size_t r = 0; r < sides; r++) {
    orbsoc_real *own = &state[r * REFINEMENT_WORDS];
    const orbsoc_real old = own[ERROR_NORM], norm = error_norm(dim, &found[r], sides);
    const int better = norm < old && 0 < active;
    for (size_t k = r; k < count && better; k += sides) {
      x[k] = candidate[k];
      error[k] = found[k];
    }
    own[ERROR_NORM] = better ? norm : old;
    own[WORTHWHILE] = real(0.25) * old;
  }
}

/* ---- right-hand sides in permuted order, and solutions back in natural order ---- */

/* h of a nonnegative row as a starting point takes it: a bound far away must not attract x. */
static orbsoc_real bounded(orbsoc_real h) { return smaller(h, real(START_BOUND)); }

/* With a linear cost, x and s come from (0, b, h) and y and z from (-c, 0, 0); with a quadratic one
 * all of them come from (-c, b, h), where the nonnegative rows are bounded. The starting point
 * needs no accuracy. */
void orbsoc_start_rhs(pattern_t pattern, const orbsoc_real *q, orbsoc_real *rhs,
                      orbsoc_real *tolerance) {
  const size_t n = pattern->n, rows = n + pattern->p, all = unknowns_of(pattern);
  tolerance[0] = real(1e-6) * max_abs(all, q);
  for (size_t k = 0; k < 2u * pattern->dim; k++) { rhs[k] = 0; }
  for (size_t i = 0; i < all; i++) {
    orbsoc_real *to = &rhs[2u * (size_t)pattern->position[i]];
    const orbsoc_real entry = (i < n) ? -q[i] : q[i];
    if (pattern->nnz_p > 0u) {
      to[0] = (i >= rows && i < rows + pattern->l) ? bounded(entry) : entry;
      to[1] = to[0];
    } else {
      to[0] = (i < n) ? 0 : entry;
      to[1] = (i < n) ? entry : 0;
    }
  }
}

/* x, s = -z of one solution, and y, z of the other; s with what orbsoc_start_rhs left out of h. */
void orbsoc_start_point(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *solution,
                        orbsoc_real *point, orbsoc_real *slack) {
  const size_t n = pattern->n, rows = n + pattern->p, all = unknowns_of(pattern);
  for (size_t i = 0; i < all; i++) {
    point[i] = solution[2u * (size_t)pattern->position[i] + ((i < n) ? 0u : 1u)];
  }
  for (size_t i = 0; i < pattern->m; i++) {
    slack[i] = -solution[2u * (size_t)pattern->position[rows + i]];
    if (pattern->nnz_p > 0u && i < pattern->l) {
      slack[i] = slack[i] + (q[rows + i] - bounded(q[rows + i]));
    }
  }
}

/* (-c, b, h - 2 s): from a central pair to the equations of the data. */
void orbsoc_newton_start_rhs(pattern_t pattern, const orbsoc_real *q, const orbsoc_real *slack,
                             orbsoc_real *rhs) {
  const size_t n = pattern->n, rows = n + pattern->p, all = unknowns_of(pattern);
  for (size_t k = 0; k < pattern->dim; k++) { rhs[k] = 0; }
  for (size_t i = 0; i < all; i++) { rhs[pattern->position[i]] = (i < n) ? -q[i] : q[i]; }
  for (size_t i = 0; i < pattern->m; i++) {
    orbsoc_real *entry = &rhs[pattern->position[rows + i]];
    *entry = *entry - (slack[i] + slack[i]);
  }
}

/* The first `count` unknowns in natural order from one side of the permuted solutions. */
void orbsoc_unload(pattern_t pattern, size_t count, const orbsoc_real *permuted, size_t sides,
                   size_t side, orbsoc_real *natural) {
  for (size_t i = 0; i < count; i++) { natural[i] = permuted[pattern->position[i] * sides + side]; }
}
