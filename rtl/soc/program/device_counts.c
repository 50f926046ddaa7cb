/* As counts.c, for what the device does: around the functions that the driver hands to the library, words by DMA where they can.
 *   load RUNS CYCLES, put …, get …, publish …          the link
 *   segment NUMBER RUNS CYCLES BUSY     from a launch to its end: core cycles, and clocks in which the engine was busy
 */
#include <stdio.h>

#include "counters.h"
#include "dma.h"
#include "method.h"

#define SEGMENTS 64
#define ENGINE_CLOCKS (*(volatile uint64_t *)0x11000028)

enum { LOAD, PUT, GET, PUBLISH, LINKS };
static const char *const names[LINKS] = {"load", "put", "get", "publish"};

static orbsoc_device driver;
static uint64_t runs[LINKS], launches[SEGMENTS], busy[SEGMENTS];
static counters spent[LINKS], waited[SEGMENTS], launched_at;
static uint64_t busy_before;
static uint32_t launched;

static uint32_t done(int link, counters since, uint32_t code) {
  add(&spent[link], since);
  runs[link] += 1;
  return code;
}

static uint32_t restart(void *context, uint32_t reload) {
  const counters since = now();
  return done(LOAD, since, reload ? dma_load((orbsoc_pl_device *)context) : driver.restart(context, reload));
}

static uint32_t put(void *context, uint32_t buffer, const orbsoc_real *words) {
  const counters since = now();
  orbsoc_pl_device *device = (orbsoc_pl_device *)context;
  return done(PUT, since, dma_moves(device, buffer) ? dma_put(device, buffer, words) : driver.put(context, buffer, words));
}

static uint32_t get(void *context, uint32_t buffer, orbsoc_real *words) {
  const counters since = now();
  orbsoc_pl_device *device = (orbsoc_pl_device *)context;
  return done(GET, since, dma_moves(device, buffer) ? dma_get(device, buffer, words) : driver.get(context, buffer, words));
}

static uint32_t publish(void *context, uint32_t segment) {
  const counters since = now();
  return done(PUBLISH, since, driver.publish(context, segment));
}

static uint32_t launch(void *context, uint32_t segment) {
  launched = segment;
  busy_before = ENGINE_CLOCKS;
  launched_at = now();
  return driver.launch(context, segment);
}

static uint32_t wait(void *context) {
  const uint32_t code = driver.wait(context);
  if (code != ORBSOC_DEVICE_RUNS) {
    add(&waited[launched], launched_at);
    launches[launched] += 1;
    busy[launched] += ENGINE_CLOCKS - busy_before;
  }
  return code;
}

orbsoc_error __real_orbsoc_attach(orbsoc_solver *solver, const orbsoc_partition *partition, const orbsoc_device *device);
orbsoc_error __wrap_orbsoc_attach(orbsoc_solver *solver, const orbsoc_partition *partition, const orbsoc_device *device) {
  driver = *device;
  const orbsoc_device around = {device->context, device->patience, restart, put, get, publish, launch, wait, device->stop};
  return __real_orbsoc_attach(solver, partition, &around);
}

void print_device(void) {
  for (int k = 0; k < LINKS; ++k)
    if (runs[k]) printf("%s %llu %llu\n", names[k], (unsigned long long)runs[k], (unsigned long long)spent[k].cycles);
  for (int k = 0; k < SEGMENTS; ++k)
    if (launches[k])
      printf("segment %d %llu %llu %llu\n", k, (unsigned long long)launches[k], (unsigned long long)waited[k].cycles,
             (unsigned long long)busy[k]);
}
