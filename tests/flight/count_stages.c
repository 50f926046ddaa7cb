/* Solves of data sets in a file, stage by stage between two marks, for scripts/count_instructions.c: a mark is a seek to
 * a place that no file has. The file holds, for each data set, p, a, g, c, b and h as doubles. */
#include <stdio.h>
#include <unistd.h>

#include "kernels.h"
#include "method.h"
#include "pattern.h"

#define MARK 0x4f530000L
#define AFTER 1000L

static orbsoc_arena arena;
static orbsoc_solver solver;
static double data[ORBSOC_NNZ_P + ORBSOC_NNZ_A + ORBSOC_NNZ_G + ORBSOC_N + ORBSOC_ROWS + ORBSOC_M];

static orbsoc_outcome run(orbsoc_stage stage) {
  (void)lseek(0, MARK + (long)stage, SEEK_SET);
  const orbsoc_outcome outcome = orbsoc_run(&solver, stage, 1);
  (void)lseek(0, MARK + AFTER, SEEK_SET);
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
  }
  return 0;
}

int main(int count, char **names) {
  FILE *file = (count == 2) ? fopen(names[1], "rb") : NULL;
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
    orbsoc_begin(&solver, ATTEMPT_COLD);
    int ended = follow(&orbsoc_startup);
    while (ended == 0) {
      ended = follow(&orbsoc_iteration);
    }
    (void)follow(&orbsoc_closing);
  }
  return 0;
}
