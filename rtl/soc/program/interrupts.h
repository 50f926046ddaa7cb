/* Interrupts of the board, for a program whose PL raises one at the end of a launch. */
#ifndef INTERRUPTS_H
#define INTERRUPTS_H

#include "counters.h"
#include "orbsoc_device.h"

/* Interrupts of the PL taken, and what their handler cost. */
extern uint64_t interrupts_taken;
extern counters interrupts_spent;

/* Take the PL's interrupts and its bus errors for this device from now on. */
void interrupts_begin(orbsoc_pl_device *device);

#endif
