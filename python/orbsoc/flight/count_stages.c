/* Solves of data sets in a file between marks, for count_instructions.c: a mark is a seek to a place that no file has.
 *
 *   count_stages stages FILE     each set stage by stage, from cold and from near the solution, and each stage once more where
 *                                its branches on data take the longer way
 *   count_stages spared FILE     the same, but once more without what no decision needs
 *   count_stages worst FILE      the first set by one attempt of WORST_ITERATIONS iterations with every refinement step
 *   count_stages solves FILE     each set by orbsoc_solve, and by orbsoc_solve_from near its solution
 *
 * The file holds, for each data set, p, a, g, c, b and h as doubles. After a solve stands its outcome on standard output:
 * iterations, refinement steps, attempts. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "kernels.h"
#include "method.h"
#include "pattern.h"

#define MARK 0x4f530000L
enum { BEGIN = 100, CONCLUDE, RESTART, POINT, SOLVE, SOLVE_FROM, NOTHING, WORST, AFTER = 1000 };
#define WORST_ITERATIONS 5

static orbsoc_arena arena, saved, before;
static orbsoc_solver solver, kept;
static double data[ORBSOC_NNZ_P + ORBSOC_NNZ_A + ORBSOC_NNZ_G + ORBSOC_N + ORBSOC_ROWS + ORBSOC_M];
static uint32_t random = 1;
static int spared;
static double point[ORBSOC_N + ORBSOC_ROWS + 2 * ORBSOC_M + 1];

static void mark(long number) { (void)lseek(0, MARK + number, SEEK_SET); }

/* Have every branch on data take the way that copies, or tests more. */
static void make_expensive(orbsoc_stage stage) {
  orbsoc_real *const *b = solver.buffer;
  for (int r = 0; r < 2; r++) {
    b[ORBSOC_MULTI_REFINEMENT][r * REFINEMENT_WORDS + ERROR_NORM] = (orbsoc_real)INFINITY;
  }
  b[ORBSOC_REFINEMENT][ERROR_NORM] = (orbsoc_real)INFINITY;
  b[ORBSOC_REFINEMENT_ACTIVE][0] = 1;
  if (stage == STAGE_STATISTICS) {
    b[ORBSOC_CONTROL][WORD_BEST] = (orbsoc_real)INFINITY;
    b[ORBSOC_CONTROL][WORD_PRIMAL_RADIUS] = -1;
    b[ORBSOC_CONTROL][WORD_DUAL_RADIUS] = -1;
    b[ORBSOC_HOMOGENIZER][KAPPA] = 2000 * b[ORBSOC_HOMOGENIZER][TAU];
  }
}

static orbsoc_outcome run(orbsoc_stage stage) {
  saved = arena;
  kept = solver;
  if (spared != 0) {
    solver.buffer[ORBSOC_CONTROL][WORD_NEEDS_RESIDUAL] = 0;
  } else {
    make_expensive(stage);
  }
  mark((long)stage);
  (void)orbsoc_run(&solver, stage, spared == 0);
  mark(AFTER);
  arena = saved;
  solver = kept;
  mark((long)stage);
  const orbsoc_outcome outcome = orbsoc_run(&solver, stage, 1);
  mark(AFTER);
  return outcome;
}

static int follow(const orbsoc_list *list) {
  for (size_t k = 0; k < list->count; k++) {
    orbsoc_outcome outcome = run((orbsoc_stage)list->steps[k].until);
    while (outcome == ORBSOC_REPEAT) {
      (void)run((orbsoc_stage)list->steps[k].stage);
      outcome = run((orbsoc_stage)list->steps[k].until);
    }
    if (outcome == ORBSOC_DONE) {
      return 1;
    }
    if (list->steps[k].stage != list->steps[k].until) {
      before = arena;
      (void)run((orbsoc_stage)list->steps[k].stage);
      arena = before;
    }
  }
  return 0;
}

static void conclude(void) {
  mark(CONCLUDE);
  orbsoc_conclude(&solver);
  mark(AFTER);
}

/* The end of an attempt that stalled, with certificates to judge, and an outcome before it. */
static void make_end_expensive(void) {
  orbsoc_real *words = solver.buffer[ORBSOC_CONTROL];
  solver.stop = STOP_STALLED;
  solver.settings.tol = 1e-300;
  solver.settings.tol_inaccurate = 1e-299;
  solver.settings.max_restarts = 9;
  words[WORD_PRIMAL_RADIUS] = 1;
  words[WORD_DUAL_RADIUS] = 1;
  solver.has_earlier = 1;
  solver.earlier = solver.solution;
  solver.earlier.status = ORBSOC_NUMERICAL_LIMIT;
  solver.attempt = ATTEMPT_COLD;
}

static void conclude_expensively(void) {
  saved = arena;
  kept = solver;
  make_end_expensive();
  conclude();
  mark(RESTART);
  (void)orbsoc_begin_again(&solver);
  mark(AFTER);
  arena = saved;
  solver = kept;
}

static void solve(orbsoc_attempt attempt, const orbsoc_list *list) {
  mark(BEGIN);
  orbsoc_begin(&solver, attempt);
  mark(AFTER);
  int ended = follow(list);
  while (ended == 0) {
    ended = follow(&orbsoc_iteration);
  }
  (void)follow(&orbsoc_closing);
  conclude();
  conclude_expensively();
}

/* The solution, each number moved by up to a thousandth. */
static const double *take_point(void) {
  const orbsoc_solution *found = &solver.solution;
  double *to = point;
  memcpy(to, found->x, sizeof(double) * ORBSOC_N);
  memcpy(to + ORBSOC_N, found->y, sizeof(double) * ORBSOC_ROWS);
  memcpy(to + ORBSOC_N + ORBSOC_ROWS, found->z, sizeof(double) * ORBSOC_M);
  to += ORBSOC_N + ORBSOC_ROWS + ORBSOC_M;
  for (size_t i = 0; i < ORBSOC_M; i++) {
    to[i] = (found->s[i] - found->s[i] == 0.0) ? found->s[i] : 1.0;
  }
  for (size_t i = 0; i < sizeof point / sizeof point[0]; i++) {
    random = random * 1664525u + 1013904223u;
    point[i] *= 1.0 + 1e-3 * ((double)(random >> 8) / 8388608.0 - 1.0);
  }
  return point;
}

static void stages(void) {
  solve(ATTEMPT_COLD, &orbsoc_startup);
  const double *x = take_point(), *y = x + ORBSOC_N, *z = y + ORBSOC_ROWS, *s = z + ORBSOC_M;
  mark(POINT);
  const int useful = orbsoc_load_point(&solver, x, y, z, s);
  mark(AFTER);
  if (useful != 0) {
    solve(ATTEMPT_WARM, &orbsoc_warm_startup);
  }
  mark(NOTHING);
  mark(AFTER);
}

static void tell(void) {
  const orbsoc_solution *found = &solver.solution;
  printf("%u %u %u %s\n", (unsigned)found->iterations, (unsigned)found->refinements,
         (unsigned)found->attempts, orbsoc_status_name(found->status));
}

static void solves(void) {
  mark(SOLVE);
  (void)orbsoc_solve(&solver);
  mark(AFTER);
  tell();
  const double *x = take_point(), *y = x + ORBSOC_N, *z = y + ORBSOC_ROWS, *s = z + ORBSOC_M;
  mark(SOLVE_FROM);
  (void)orbsoc_solve_from(&solver, x, y, z, s);
  mark(AFTER);
  tell();
}

/* Every step of a list, every repeated one as often as it may be, whatever the stages decide. */
static void follow_all(const orbsoc_list *list) {
  for (size_t k = 0; k < list->count; k++) {
    const orbsoc_stage stage = (orbsoc_stage)list->steps[k].stage;
    const orbsoc_stage until = (orbsoc_stage)list->steps[k].until;
    (void)orbsoc_run(&solver, until, 1);
    for (uint32_t r = 0; r < solver.settings.refinement_max && stage != until; r++) {
      make_expensive(stage);
      (void)orbsoc_run(&solver, stage, 1);
      (void)orbsoc_run(&solver, until, 1);
    }
  }
}

static void worst(void) {
  (void)orbsoc_solve(&solver);
  mark(WORST);
  orbsoc_begin(&solver, ATTEMPT_COLD);
  follow_all(&orbsoc_startup);
  for (int k = 0; k < WORST_ITERATIONS; k++) {
    solver.buffer[ORBSOC_CONTROL][WORD_BEST] = (orbsoc_real)INFINITY;
    follow_all(&orbsoc_iteration);
  }
  (void)orbsoc_run(&solver, STAGE_STATISTICS, 1);
  follow_all(&orbsoc_closing);
  make_end_expensive();
  orbsoc_conclude(&solver);
  (void)orbsoc_begin_again(&solver);
  mark(AFTER);
}

int main(int count, char **names) {
  FILE *file = (count == 3) ? fopen(names[2], "rb") : NULL;
  if (file == NULL ||
      orbsoc_open(&solver, &orbsoc_tables, &orbsoc_defaults, arena.work, ORBSOC_WORK_WORDS,
                  arena.numbers, ORBSOC_NUMBER_WORDS) != ORBSOC_OK) {
    return 1;
  }
  while (fread(data, sizeof data, 1, file) == 1u) {
    const double *at = data;
    (void)orbsoc_set_p(&solver, at);
    (void)orbsoc_set_a(&solver, at += ORBSOC_NNZ_P);
    (void)orbsoc_set_g(&solver, at += ORBSOC_NNZ_A);
    (void)orbsoc_set_c(&solver, at += ORBSOC_NNZ_G);
    (void)orbsoc_set_b(&solver, at += ORBSOC_N);
    (void)orbsoc_set_h(&solver, at += ORBSOC_ROWS);
    spared = names[1][1] == 'p';
    if (names[1][1] == 't' || spared != 0) {
      stages();
    } else if (names[1][0] == 'w') {
      worst();
    } else {
      solves();
    }
  }
  return 0;
}
