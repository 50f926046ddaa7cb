/* The core's own counters. */
#ifndef COUNTERS_H
#define COUNTERS_H

#include <stdint.h>

typedef struct {
  uint64_t cycles, instructions;
} counters;

static inline counters now(void) {
  counters here;
  __asm__ volatile("csrr %0, minstret" : "=r"(here.instructions)::"memory");
  __asm__ volatile("csrr %0, mcycle" : "=r"(here.cycles)::"memory");
  return here;
}

/* What was spent since then, on top of a sum. */
static inline void add(counters *sum, counters since) {
  const counters here = now();
  sum->cycles += here.cycles - since.cycles;
  sum->instructions += here.instructions - since.instructions;
}

/* What the link took, and waits for the engine: within a stage of the method, and no part of it. */
extern counters elsewhere;

/* With EVENTS, a line "event KIND NUMBER BEGIN END" a part, after the solve. Kinds: s stage, w launch to end on the PL, and the
 * first letters of the link's: l load, p put, g get, b publish. */
#ifdef EVENTS
void note_event(char kind, uint32_t number, counters since);
#else
static inline void note_event(char kind, uint32_t number, counters since) { (void)kind, (void)number, (void)since; }
#endif

/* Lines of the parts on the PL and of the link; nothing in a program without a PL. */
void print_device(void) __attribute__((weak));

#endif
