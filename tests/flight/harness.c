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
