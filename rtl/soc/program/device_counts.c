/* As counts.c, for what the device does: around the functions that the driver hands to the library, words by DMA where they can.
 *   load RUNS CYCLES INSTRUCTIONS, put …, get …, publish …          the link
 *   segment NUMBER RUNS CYCLES INSTRUCTIONS BUSY     from a launch to its end; BUSY: clocks of the engine in which it was busy
 *   launch RUNS CYCLES INSTRUCTIONS, interrupt …     of which, writing the registers of a launch, and the handler at its end
 * The end of a launch comes by interrupt. LIMIT: clocks of the PL that one may take, where it is not the program's own.
 */
#include <stdio.h>

#include "counters.h"
#include "dma.h"
#include "interrupts.h"
#include "method.h"

#define SEGMENTS 64
#define ENGINE_CLOCKS (*(volatile uint64_t *)0x11000028)
#define PL (*(volatile uint64_t *)0x11000030)
#define RESETTING 1u
#define RESET_READS 1000
/* Looks of 1000 rounds at whether an interrupt came, about 4000 clocks each, that a launch may take. */
#ifndef PATIENCE
#define PATIENCE ORBSOC_PL_PATIENCE
#endif

enum { LOAD, PUT, GET, PUBLISH, LAUNCH, LINKS };
static const char *const names[LINKS] = {"load", "put", "get", "publish", "launch"};

static orbsoc_device driver;
static uint64_t runs[LINKS], launches[SEGMENTS], busy[SEGMENTS];
static counters spent[LINKS], waited[SEGMENTS];

/* `moved`: the buffer of a transfer. */
static uint32_t done(int link, uint32_t moved, counters since, uint32_t code) {
  add(&spent[link], since);
  runs[link] += 1;
  if (link != LAUNCH) {
    add(&elsewhere, since);
    note_event("lpgb"[link], moved, since);
  }
  return code;
}

static uint32_t restart(void *context, uint32_t reload) {
  const counters since = now();
  orbsoc_pl_device *device = (orbsoc_pl_device *)context;
  if (reload == 0) return done(LOAD, 0, since, driver.restart(context, reload));
  /* Whatever has become of the PL: its reset, and its ports joined again. */
  PL = 1;
  for (int reads = 0; reads < RESET_READS && (PL & RESETTING) != 0; ++reads) {
  }
  interrupts_begin(device);
  return done(LOAD, 0, since, dma_load(device));
}

static uint32_t put(void *context, uint32_t buffer, const orbsoc_real *words) {
  const counters since = now();
  orbsoc_pl_device *device = (orbsoc_pl_device *)context;
  return done(PUT, buffer, since,
              dma_moves(device, buffer) ? dma_put(device, buffer, words) : driver.put(context, buffer, words));
}

static uint32_t get(void *context, uint32_t buffer, orbsoc_real *words) {
  const counters since = now();
  orbsoc_pl_device *device = (orbsoc_pl_device *)context;
  return done(GET, buffer, since,
              dma_moves(device, buffer) ? dma_get(device, buffer, words) : driver.get(context, buffer, words));
}

static uint32_t publish(void *context, uint32_t segment) {
  const counters since = now();
  return done(PUBLISH, 0, since, driver.publish(context, segment));
}

static uint32_t launch(void *context, uint32_t segment) {
  launched.segment = segment;
  launched.busy_before = ENGINE_CLOCKS;
  launched.launched_at = now();
  return done(LAUNCH, 0, launched.launched_at, driver.launch(context, segment));
}

/* After each look the handler is rehearsed: caches come to hold what it needs beside what waiting needs. */
static uint32_t wait(void *context) {
  orbsoc_pl_device *device = (orbsoc_pl_device *)context;
  orbsoc_pl_error found = orbsoc_pl_await(&device->pl, device->polls);
  if (found == ORBSOC_PL_LOST_INTERRUPT) found = orbsoc_pl_await(&device->pl, device->polls); /* it was on its way */
  const uint32_t code = found == ORBSOC_PL_LAUNCH_TIMEOUT ? ORBSOC_DEVICE_RUNS : (uint32_t)found;
  if (code == ORBSOC_DEVICE_RUNS) {
    interrupts_rehearse();
  } else {
    add(&waited[launched.segment], launched.launched_at);
    add(&elsewhere, launched.launched_at);
    launches[launched.segment] += 1;
    note_event('w', launched.segment, launched.launched_at);
    busy[launched.segment] += ENGINE_CLOCKS - launched.busy_before;
  }
  return code;
}

orbsoc_error __real_orbsoc_attach(orbsoc_solver *solver, const orbsoc_partition *partition, const orbsoc_device *device);
orbsoc_error __wrap_orbsoc_attach(orbsoc_solver *solver, const orbsoc_partition *partition, const orbsoc_device *device) {
  driver = *device;
#ifdef LIMIT
  ((orbsoc_pl_device *)device->context)->limit = LIMIT;
#endif
  const orbsoc_device around = {device->context, PATIENCE, restart, put, get, publish, launch, wait, device->stop};
  return __real_orbsoc_attach(solver, partition, &around);
}

static void print_part(const char *name, uint64_t count, const counters *sum) {
  printf("%s %llu %llu %llu", name, (unsigned long long)count, (unsigned long long)sum->cycles,
         (unsigned long long)sum->instructions);
}

void print_device(void) {
  for (int k = 0; k < LINKS; ++k)
    if (runs[k]) {
      print_part(names[k], runs[k], &spent[k]);
      printf("\n");
    }
  print_part("interrupt", launched.taken, &launched.spent);
  printf("\n");
  for (int k = 0; k < SEGMENTS; ++k)
    if (launches[k]) {
      printf("segment %d", k);
      print_part("", launches[k], &waited[k]);
      printf(" %llu\n", (unsigned long long)busy[k]);
    }
}
