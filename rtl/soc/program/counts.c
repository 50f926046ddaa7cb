/* Cycles of a solve, stage by stage, by the core's own counters. The linker puts these functions around the flight library's
 * (--wrap), which is not changed by it. A line a part, after the solve:
 *   stage NUMBER RUNS CYCLES INSTRUCTIONS      run on the core, NUMBER as in method.h; without words to and fro and waits
 *   solve CYCLES INSTRUCTIONS
 * What reading the counters costs is in the figures of the stages: about ten cycles a run. */
#include <stdint.h>
#include <stdio.h>

#include "counters.h"
#include "method.h"

#define STAGES 64

static uint64_t runs[STAGES];
static counters spent[STAGES];
counters elsewhere;

#ifdef EVENTS
static struct {
  uint64_t begin, end;
  uint32_t number;
  char kind;
} events[16384];
static uint32_t noted;

void note_event(char kind, uint32_t number, counters since) {
  if (noted == sizeof events / sizeof events[0]) return;
  events[noted].begin = since.cycles;
  events[noted].end = now().cycles;
  events[noted].number = number;
  events[noted].kind = kind;
  noted += 1;
}

static void print_events(void) {
  for (uint32_t k = 0; k < noted; ++k)
    printf("event %c %u %llu %llu\n", events[k].kind, (unsigned)events[k].number, (unsigned long long)events[k].begin,
           (unsigned long long)events[k].end);
}
#else
static void print_events(void) {}
#endif

static void print(const counters *sum) {
  printf("%llu %llu\n", (unsigned long long)sum->cycles, (unsigned long long)sum->instructions);
}

orbsoc_outcome __real_orbsoc_run(orbsoc_solver *solver, orbsoc_stage stage, int whole);
orbsoc_outcome __wrap_orbsoc_run(orbsoc_solver *solver, orbsoc_stage stage, int whole) {
  const counters before = elsewhere, since = now();
  const orbsoc_outcome outcome = __real_orbsoc_run(solver, stage, whole);
  add(&spent[stage], since);
  spent[stage].cycles -= elsewhere.cycles - before.cycles;
  spent[stage].instructions -= elsewhere.instructions - before.instructions;
  runs[stage] += 1;
  note_event('s', (uint32_t)stage, since);
  return outcome;
}

orbsoc_error __real_orbsoc_solve(orbsoc_solver *solver);
orbsoc_error __wrap_orbsoc_solve(orbsoc_solver *solver) {
  counters all = {0, 0};
  const counters since = now();
  const orbsoc_error error = __real_orbsoc_solve(solver);
  add(&all, since);
  for (int stage = 0; stage < STAGES; ++stage) {
    if (runs[stage] == 0) continue;
    printf("stage %d %llu ", stage, (unsigned long long)runs[stage]);
    print(&spent[stage]);
  }
  if (print_device) print_device();
  printf("solve ");
  print(&all);
  print_events();
  return error;
}
