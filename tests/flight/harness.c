/* The library for a test in Python: one solver in static memory, and its words. */
#include <string.h>

#include "kernels.h"
#include "method.h"
#include "pattern.h"

static orbsoc_arena arena;
static orbsoc_solver solver;

int harness_open(void) {
  return (int)orbsoc_open(&solver, &orbsoc_tables, &orbsoc_defaults, arena.work,
                          ORBSOC_WORK_WORDS, arena.numbers, ORBSOC_NUMBER_WORDS);
}

orbsoc_solver *harness_solver(void) { return &solver; }

int harness_run(int stage) { return (int)orbsoc_run(&solver, (orbsoc_stage)stage, 1); }

const orbsoc_real *harness_words(int buffer) { return solver.buffer[buffer]; }

void harness_numbers(double *out) {
  const orbsoc_solution *found = &solver.solution;
  const double values[] = {(double)found->status, (double)found->warm_start,
                           (double)found->iterations, (double)found->refinements,
                           (double)found->attempts, found->objective, found->dual_objective,
                           found->primal_residual, found->dual_residual, found->gap,
                           found->radius};
  memcpy(out, values, sizeof values);
  out += sizeof values / sizeof values[0];
  memcpy(out, found->x, sizeof(double) * ORBSOC_N);
  memcpy(out + ORBSOC_N, found->y, sizeof(double) * ORBSOC_ROWS);
  memcpy(out + ORBSOC_N + ORBSOC_ROWS, found->z, sizeof(double) * ORBSOC_M);
  memcpy(out + ORBSOC_N + ORBSOC_ROWS + ORBSOC_M, found->s, sizeof(double) * ORBSOC_M);
}

/* Open a solver on tables of which one number has one bit changed: what it says. Lists by number, as the test has
 * them. The number stands in a copy of its list. */
int harness_change(int list, int count, int at, int bit) {
  static orbsoc_index copy[1 << 16];
  static uint8_t bytes[1 << 16];
  orbsoc_pattern p = orbsoc_tables;
  const orbsoc_index **lists[] = {
      &p.cone_dims, &p.given_cone_dims, &p.cost.begins, &p.cost.rows, &p.equality.begins,
      &p.equality.rows, &p.conic.begins, &p.conic.rows, &p.given_conic.begins,
      &p.given_conic.rows, &p.row_origin, &p.g_origin, NULL, &p.kkt.begins, &p.kkt.rows,
      &p.contiguous_columns, &p.position, NULL, &p.from_p, &p.from_a, &p.from_g, &p.orthant,
      &p.soc, &p.row, &p.scatter_to, &p.gather_from, &p.relative_row, &p.run_value, &p.run_length,
      &p.entry_target};
  if (lists[list] == NULL) {
    const uint8_t **from = (list == 12) ? &p.absent : &p.positive;
    memcpy(bytes, *from, (list == 12) ? p.given_m : p.dim);
    bytes[at] = (uint8_t)(bytes[at] ^ (1u << bit));
    *from = bytes;
  } else {
    memcpy(copy, *lists[list], (size_t)count * sizeof copy[0]);
    copy[at] = (orbsoc_index)(copy[at] ^ (1u << bit));
    *lists[list] = copy;
  }
  return (int)orbsoc_open(&solver, &p, &orbsoc_defaults, arena.work, ORBSOC_WORK_WORDS,
                          arena.numbers, ORBSOC_NUMBER_WORDS);
}
