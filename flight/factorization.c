/* Matrix factorization: numeric LDL' on the symbolic factorization of set-up, right-looking over
 * supernodes.
 *
 * With y = L D the column before its division, every entry receives l_ij <- k_ij - sum_k l_ik y_jk
 * in ascending k; then the pivot is regularised and the column divided by it. */
#include "kernels.h"
#include "reduce.h"

/* A pivot of the wrong sign is the rounding error of the terms that cancelled: it becomes this many
 * times as large, or the replacement, whichever is more. */
#define REPLACEMENT_FACTOR 5.0
#define ROWS 8u
#define COLUMNS 4u

typedef struct {
  pattern_t pattern;
  const orbsoc_real *values;
  const orbsoc_real *regularization;
  orbsoc_real *l;
  orbsoc_real *y; /* columns of one panel before their division; then a row to scatter */
  orbsoc_real *pivot_inverse;
} factor_t;

/* Where a node's tables begin. */
typedef struct {
  size_t first;      /* column */
  size_t panel;      /* entry of L */
  size_t row;        /* of row[] */
  size_t scatter;    /* of scatter_to[] */
  size_t gather;     /* of gather_from[] */
  size_t update;     /* of update[] */
  size_t relative;   /* of relative_row[] */
} panel_place_t;

/* The pivot with static and dynamic regularisation, by its known sign. Selections by data, no other
 * work. */
static orbsoc_real regularized(orbsoc_real pivot, uint8_t positive, const orbsoc_real *by) {
  const orbsoc_real enlarged = real(-REPLACEMENT_FACTOR) * pivot;
  if (positive != 0u) {
    const orbsoc_real shifted = pivot + by[SHIFT_UP];
    return (shifted < by[FLOOR]) ? larger(enlarged, by[REPLACEMENT]) : shifted;
  }
  const orbsoc_real shifted = pivot - by[SHIFT_DOWN];
  return (-by[FLOOR] < shifted) ? smaller(enlarged, -by[REPLACEMENT]) : shifted;
}

/* `rows` rows of subtract, which stay in registers while the columns go by. */
ORBSOC_INLINE void subtract_tile(size_t rows, size_t columns, const orbsoc_real *restrict l,
                                 const orbsoc_real *restrict y, size_t stride,
                                 orbsoc_real *restrict out) {
  orbsoc_real sum[ROWS];
  for (size_t v = 0; v < rows; v++) { sum[v] = out[v]; }
  for (size_t k = 0; k < columns; k++) {
    const orbsoc_real by = y[k * stride];
    for (size_t v = 0; v < rows; v++) { sum[v] = sum[v] - l[k * stride + v] * by; }
  }
  for (size_t v = 0; v < rows; v++) { out[v] = sum[v]; }
}

/* out_i <- out_i - sum_k l_k[i] y_k, the k in order; columns of l and entries of y are `stride`
 * apart. */
static void subtract(size_t count, size_t columns, const orbsoc_real *restrict l,
                     const orbsoc_real *restrict y, size_t stride, orbsoc_real *restrict out) {
  size_t i = 0;
  for (; i + ROWS <= count; i += ROWS) {
    subtract_tile(ROWS, columns, &l[i], y, stride, &out[i]);
  }
  if (i + ROWS / 2u <= count) {
    subtract_tile(ROWS / 2u, columns, &l[i], y, stride, &out[i]);
    i += ROWS / 2u;
  }
  for (; i < count; i++) { subtract_tile(1, columns, &l[i], y, stride, &out[i]); }
}

/* Rows lo.. of a panel, whose entries are at `to` in each of COLUMNS columns that begin at
 * `target`: a tile of ROWS rows stays in registers while the columns of the panel go by. */
static size_t subtract_tiles(size_t count, size_t columns, const orbsoc_real *restrict l,
                             const orbsoc_real *restrict y, size_t stride, const orbsoc_index *to,
                             orbsoc_real *const target[COLUMNS]) {
  size_t i = 0;
  for (; i + ROWS <= count; i += ROWS) {
    orbsoc_real sum[COLUMNS][ROWS];
    for (size_t c = 0; c < COLUMNS; c++) {
      for (size_t v = 0; v < ROWS; v++) { sum[c][v] = target[c][to[i + v]]; }
    }
    for (size_t k = 0; k < columns; k++) {
      const orbsoc_real *a = &l[k * stride + i], *by = &y[k * stride];
      for (size_t c = 0; c < COLUMNS; c++) {
        for (size_t v = 0; v < ROWS; v++) { sum[c][v] = sum[c][v] - a[v] * by[c]; }
      }
    }
    for (size_t c = 0; c < COLUMNS; c++) {
      for (size_t v = 0; v < ROWS; v++) { target[c][to[i + v]] = sum[c][v]; }
    }
  }
  return i;
}

/* The same of one row, in the first `count` of the columns. */
static void subtract_rows(size_t count, size_t columns, const orbsoc_real *restrict l,
                          const orbsoc_real *restrict y, size_t stride, size_t to,
                          orbsoc_real *const *target) {
  for (size_t c = 0; c < count; c++) {
    orbsoc_real sum = target[c][to];
    for (size_t k = 0; k < columns; k++) { sum = sum - l[k * stride] * y[k * stride + c]; }
    target[c][to] = sum;
  }
}

/* A column as it is into y, and divided by its pivot. */
static void divide(size_t count, orbsoc_real inverse, orbsoc_real *restrict column,
                   orbsoc_real *restrict y) {
  for (size_t i = 0; i < count; i++) {
    y[i] = column[i];
    column[i] = y[i] * inverse;
  }
}

/* The node's own columns, one diagonal block after the other. */
static void factor_columns(const factor_t *f, const orbsoc_node *node, const panel_place_t *at) {
  const size_t leading = node->leading, size = node->diagonal;
  orbsoc_real *panel = &f->l[at->panel];
  for (size_t j = 0; j < node->width; j++) {
    const size_t own = j % size, block = (j - own) * leading, rest = leading - own - 1;
    orbsoc_real *column = &panel[j * leading + own], *y = &f->y[j * leading + own];
    subtract(rest + 1, own, &panel[block + own], &f->y[block + own], leading, column);
    const orbsoc_real inverse =
        1 / regularized(column[0], f->pattern->positive[at->first + j], f->regularization);
    f->pivot_inverse[at->first + j] = inverse;
    divide(rest, inverse, &column[1], &y[1]);
  }
}

/* Subtract a small node's contribution at its scatter indices, counted from the end of its panel.
 * */
static void contribute_scattered(const factor_t *f, const orbsoc_node *node,
                                 const panel_place_t *at) {
  const size_t leading = node->leading, rows = leading - node->diagonal, width = node->width;
  const orbsoc_index *scatter = &f->pattern->scatter_to[at->scatter];
  const orbsoc_real *l = &f->l[at->panel + node->diagonal], *y = &f->y[node->diagonal];
  orbsoc_real *target = &f->l[at->panel + width * leading];
  const size_t lists = (node->kind == ORBSOC_LEAVES) ? width : 1;
  const size_t columns = (node->kind == ORBSOC_LEAVES) ? 1 : width;
  for (size_t list = 0; list < lists; list++) {
    for (size_t j = 0; j < rows; j++) {
      for (size_t i = j; i < rows; i++) {
        orbsoc_real *entry = &target[scatter[i - j]];
        orbsoc_real sum = *entry;
        for (size_t k = 0; k < columns; k++) {
          sum = sum - l[k * leading + i] * y[k * leading + j];
        }
        *entry = sum;
      }
      scatter += rows - j;
    }
    l += leading;
    y += leading;
  }
}

/* Where column `column` begins among the entries of L: its node's panel is `panel`. */
static size_t first_column_of(pattern_t pattern, size_t target, size_t *panel, size_t from,
                              size_t from_panel, size_t first) {
  size_t at = first, entries = from_panel;
  for (size_t k = from; k < target; k++) {
    const orbsoc_node *node = &pattern->node[k];
    at += node->width;
    entries += (node->kind == ORBSOC_CONDENSED) ? 0 : (size_t)node->width * node->leading;
  }
  *panel = entries;
  return at;
}

/* Subtract a finished node's contribution from the panels of later ones, each column through `row`.
 * */
static void contribute_blocks(const factor_t *f, size_t k, const panel_place_t *at) {
  const orbsoc_node *node = &f->pattern->node[k];
  const size_t leading = node->leading, diagonal = node->diagonal, width = node->width;
  const orbsoc_index *rows = &f->pattern->row[at->row];
  const orbsoc_index *relative = &f->pattern->relative_row[at->relative];
  const orbsoc_real *l = &f->l[at->panel];
  orbsoc_real *work = &f->y[width * leading];
  size_t from = k, panel = at->panel, first = at->first;
  for (size_t u = 0; u < node->updates; u++) {
    const orbsoc_update *update = &f->pattern->update[at->update + u];
    first = first_column_of(f->pattern, update->target, &panel, from, panel, first);
    from = update->target;
    const size_t stride = f->pattern->node[from].leading;
    orbsoc_real *target = &f->l[panel];
    const size_t next = at->first + width;
    size_t c = update->lo;
    for (; c + COLUMNS <= update->hi; c += COLUMNS) {
      orbsoc_real *columns[COLUMNS];
      for (size_t v = 0; v < COLUMNS; v++) {
        columns[v] = &target[(next + rows[c + v - diagonal] - first) * stride];
        /* The triangle on the diagonal, row by row. */
        subtract_rows(v + 1, width, &l[c + v], &f->y[c], leading, relative[c + v - update->lo],
                      columns);
      }
      const size_t below = c + COLUMNS;
      const orbsoc_index *to = &relative[below - update->lo];
      const size_t count = leading - below;
      size_t i = subtract_tiles(count, width, &l[below], &f->y[c], leading, to, columns);
      for (; i < count; i++) {
        subtract_rows(COLUMNS, width, &l[below + i], &f->y[c], leading, to[i], columns);
      }
    }
    for (; c < update->hi; c++) {
      const orbsoc_index *to = &relative[c - update->lo];
      orbsoc_real *column = &target[(next + rows[c - diagonal] - first) * stride];
      const size_t count = leading - c;
      for (size_t i = 0; i < count; i++) { work[i] = column[to[i]]; }
      subtract(count, width, &l[c], &f->y[c], leading, work);
      for (size_t i = 0; i < count; i++) { column[to[i]] = work[i]; }
    }
    relative = &relative[leading - update->lo];
  }
}

/* The Schur complement of condensed columns, whose entries of L D are the matrix's own: each
 * product of two rows, divided by the pivots, at its scatter index. */
static void factor_condensed(const factor_t *f, const orbsoc_node *node, const panel_place_t *at) {
  const size_t width = node->width, rows = (size_t)node->leading - node->diagonal;
  const orbsoc_index *from = &f->pattern->gather_from[at->gather];
  const orbsoc_index *scatter = &f->pattern->scatter_to[at->scatter];
  const orbsoc_real *diagonal = &f->values[from[0]];
  orbsoc_real *inverse = &f->pivot_inverse[at->first], *target = &f->l[at->panel];
  for (size_t k = 0; k < width; k++) {
    inverse[k] =
        1 / regularized(diagonal[k], f->pattern->positive[at->first + k], f->regularization);
  }
  for (size_t j = 0; j < rows; j++) {
    const orbsoc_real *column = &f->values[from[1 + j]];
    for (size_t k = 0; k < width; k++) { f->y[k] = column[k] * inverse[k]; }
    for (size_t i = j; i < rows; i++) {
      orbsoc_real *entry = &target[scatter[i - j]];
      *entry = *entry - dot(width, &f->values[from[1 + i]], f->y);
    }
    scatter += rows - j;
  }
}

/* The matrix's entries in their places of the factor, the rest zero. */
static void load(pattern_t pattern, const orbsoc_real *values, orbsoc_real *l) {
  const orbsoc_index *to = pattern->entry_target;
  for (size_t k = 0; k < pattern->panel_entries; k++) { l[k] = 0; }
  for (size_t r = 0; r < pattern->runs; r++) {
    const orbsoc_real *from = &values[pattern->run_value[r]];
    for (size_t k = 0; k < pattern->run_length[r]; k++) { l[to[k]] = from[k]; }
    to = &to[pattern->run_length[r]];
  }
}

void orbsoc_factorize(pattern_t pattern, const orbsoc_real *values,
                      const orbsoc_real *regularization, orbsoc_real *l,
                      orbsoc_real *pivot_inverse, orbsoc_real *y) {
  const factor_t f = {pattern, values, regularization, l, y, pivot_inverse};
  panel_place_t at = {0, 0, 0, 0, 0, 0, 0};
  load(pattern, values, l);
  for (size_t k = 0; k < pattern->nodes; k++) {
    const orbsoc_node *node = &pattern->node[k];
    const size_t rows = (size_t)node->leading - node->diagonal;
    const size_t lists = (node->kind == ORBSOC_LEAVES) ? node->width : 1u;
    if (node->kind == ORBSOC_CONDENSED) {
      factor_condensed(&f, node, &at);
      at.gather += 1 + rows;
    } else {
      factor_columns(&f, node, &at);
      if (node->scattered != 0u) {
        contribute_scattered(&f, node, &at);
      } else {
        contribute_blocks(&f, k, &at);
      }
      at.panel += (size_t)node->width * node->leading;
    }
    if (node->scattered != 0u) {
      at.scatter += lists * (rows * (rows + 1) / 2);
    }
    for (size_t u = 0; u < node->updates; u++) {
      at.relative += (size_t)node->leading - pattern->update[at.update + u].lo;
    }
    at.update += node->updates;
    at.row += lists * rows;
    at.first += node->width;
  }
}
