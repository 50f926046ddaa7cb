/* The PL as the device of the flight library (flight/orbsoc_flight.h): its modules launched by the driver. C99.
 *
 *   static orbsoc_pl_device device;
 *   orbsoc_pl_attach(&solver, &device, &orbsoc_pl_program, 0xA0000000u, 0xB0000000u);
 *   orbsoc_solve(&solver);    solver.solution.place and .event say where it ran, and what went wrong there
 */
#ifndef ORBSOC_DEVICE_H
#define ORBSOC_DEVICE_H

#include "orbsoc.h"
#include "orbsoc_flight.h"

/* What an export with a partition generates. */
typedef struct {
  const orbsoc_partition *partition;
  const orbsoc_pl_image *image;
  const orbsoc_pl_attempt *cold, *warm; /* null pointers without resident control */
  const orbsoc_pl_buffer *buffers;      /* in the order of their flags */
  const uint8_t *flag;                  /* of each buffer by the flight library's number */
  uint32_t limit;                       /* the most clocks of the PL that a launch can be busy */
} orbsoc_pl_parts;

/* One PL with its program. `polls`, `patience` and `limit` may be changed before a solve: reads of STATUS between two questions of
 * the solver's clock, how many such rounds a launch may take, and how many clocks of the PL (0: any number). */
typedef struct {
  orbsoc_pl pl;
  const orbsoc_pl_parts *parts;
  uintptr_t registers, memories;
  uint32_t polls, limit;
} orbsoc_pl_device;

#define ORBSOC_PL_POLLS 1000u
#define ORBSOC_PL_PATIENCE 100000u

/* Have the PL at these addresses run the partition's modules. It is not touched before the first solve, which finds out what
 * engine is there and loads the program. */
orbsoc_error orbsoc_pl_attach(orbsoc_solver *solver, orbsoc_pl_device *device, const orbsoc_pl_parts *parts,
                              uintptr_t registers, uintptr_t memories);

/* What an event of a solution is, in a few words. */
const char *orbsoc_pl_event_name(uint32_t event);

#endif
