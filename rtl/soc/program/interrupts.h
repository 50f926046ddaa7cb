/* Interrupts of the board, for a program whose PL raises one at the end of a launch. */
#ifndef INTERRUPTS_H
#define INTERRUPTS_H

#include "counters.h"
#include "orbsoc_device.h"

/* A launch, and the interrupt at its end: one line of the cache, which is there at the interrupt because the launch has written it. */
typedef struct {
  counters launched_at;
  uint64_t busy_before; /* clocks of the engine */
  orbsoc_pl_device *device;
  counters spent; /* by the handler of the PL's interrupts */
  uint32_t taken; /* interrupts of the PL */
  uint32_t segment;
} launch_state;
extern launch_state launched;

/* Take the PL's interrupts and its bus errors for this device from now on. */
void interrupts_begin(orbsoc_pl_device *device);

/* Run the handler on a PL that is only memory: the next interrupt finds in the caches what it needs, however long ago the last was. */
void interrupts_rehearse(void);

#endif
