/* Bare-metal driver of the PL behind AXI (docs/driver.md). C11, freestanding: no allocation, no library, no clock.
 *
 * It is the PS of docs/ps-pl-protocol.md without its scheduler: names and rules are those of python/orbsoc/ps/driver.py.
 * Which stage comes next, and which buffers must move, is the caller's; under resident control the PL decides.
 *
 *   orbsoc_pl_open, orbsoc_pl_load              once
 *   orbsoc_pl_publish(segment 0)             the problem data are there
 *   orbsoc_pl_set_words                      buffers to the PL
 *   orbsoc_pl_launch_attempt, orbsoc_pl_poll    or orbsoc_pl_on_interrupt in the handler, and orbsoc_pl_await
 *   orbsoc_pl_get_words                      buffers back
 *
 * Map both ports as device memory. A burst that the PL refuses is an error on the bus, which a processor takes as an abort:
 * functions check addresses before, and do not access memories while a launch is out. orbsoc_pl_on_bus_error is for the rest.
 */
#ifndef ORBSOC_H
#define ORBSOC_H

#include <stddef.h>
#include <stdint.h>

#include "orbsoc_registers.h"

/* The only accesses to the PL: 32 bits, at a byte address. A test defines ORBSOC_EXTERNAL_ACCESS and links its own. */
#ifdef ORBSOC_EXTERNAL_ACCESS
uint32_t orbsoc_pl_read(uintptr_t address);
void orbsoc_pl_write(uintptr_t address, uint32_t value);
#else
static inline uint32_t orbsoc_pl_read(uintptr_t address) { return *(const volatile uint32_t *)address; }
static inline void orbsoc_pl_write(uintptr_t address, uint32_t value) { *(volatile uint32_t *)address = value; }
#endif

/* Where the PL finds on its bus what lies here: the lines of streamed microcode. A system that maps them elsewhere defines
 * ORBSOC_BUS_ADDRESS and links its own. */
#ifdef ORBSOC_BUS_ADDRESS
uint32_t orbsoc_pl_bus_address(const void *data);
#else
static inline uint32_t orbsoc_pl_bus_address(const void *data) { return (uint32_t)(uintptr_t)data; }
#endif

/* Accesses before it are done, those after it have not begun. */
static inline void orbsoc_pl_barrier(void) {
#if defined(__aarch64__) || (defined(__arm__) && __ARM_ARCH >= 7)
  __asm__ volatile("dsb sy" ::: "memory");
#else
  __asm__ volatile("" ::: "memory");
#endif
}

typedef enum {
  ORBSOC_PL_OK = 0,
  /* Faults of the PL, by their codes in STATUS: it stops until orbsoc_pl_reset, its interrupt line up. */
  ORBSOC_PL_LAUNCH_WHILE_BUSY = ORBSOC_FAULT_LAUNCH_WHILE_BUSY,
  ORBSOC_PL_UNACKNOWLEDGED_INTERRUPT = ORBSOC_FAULT_UNACKNOWLEDGED_INTERRUPT,
  ORBSOC_PL_SPURIOUS_ACKNOWLEDGE = ORBSOC_FAULT_SPURIOUS_ACKNOWLEDGE,
  ORBSOC_PL_WRITE_OUT_OF_ORDER = ORBSOC_FAULT_WRITE_OUT_OF_ORDER,
  ORBSOC_PL_WRONG_SEGMENT = ORBSOC_FAULT_WRONG_SEGMENT,
  ORBSOC_PL_WRONG_SEQUENCE = ORBSOC_FAULT_WRONG_SEQUENCE,
  ORBSOC_PL_READ_BEFORE_VALID = ORBSOC_FAULT_READ_BEFORE_VALID,
  ORBSOC_PL_INVALID_ACCESS = ORBSOC_FAULT_INVALID_ACCESS,
  ORBSOC_PL_CYCLE_LIMIT = ORBSOC_FAULT_CYCLE_LIMIT, /* a launch was busy for more clocks than orbsoc_pl_limit allows */
  ORBSOC_PL_PARITY = ORBSOC_FAULT_PARITY, /* a word of storage or a line of microcode that the PL read has a bit turned over */
  ORBSOC_PL_STREAM_ERROR = ORBSOC_FAULT_STREAM_ERROR, /* memory answered a read of streamed microcode with an error */
  /* What the driver finds. */
  ORBSOC_PL_LOST_INTERRUPT = 16, /* the segment finished, but its interrupt did not arrive within the budget */
  ORBSOC_PL_LAUNCH_TIMEOUT = 17, /* neither an interrupt nor the end within the budget */
  ORBSOC_PL_LOST_WRITE = 18,     /* a command was written, but STATUS does not show it carried out */
  ORBSOC_PL_WRONG_ENGINE = 19,   /* the image was made for another engine */
  ORBSOC_PL_OUT_OF_RANGE = 20,   /* an address, a number or a control program beyond what the engine has */
  ORBSOC_PL_NOT_AT_REST = 21,    /* a launch is out, or there is none to wait for */
  ORBSOC_PL_BUS_ERROR = 22,      /* orbsoc_pl_on_bus_error was called */
  ORBSOC_PL_WRONG_PROGRAM = 23   /* the memories do not hold what the image says */
} orbsoc_pl_error;

/* A stage as the registers know it; masks have a bit for each buffer. */
typedef struct {
  uint32_t module;
  uint32_t start; /* first line of its microcode */
  uint64_t reads, writes, stales;
} orbsoc_pl_segment;

/* Where an attempt begins, what its closing stages write, and what it may write at all. */
typedef struct {
  uint32_t entry;
  uint64_t closing, written;
} orbsoc_pl_attempt;

typedef struct {
  uint32_t word; /* ORBSOC_INSTRUCTION_… */
  uint32_t flag; /* storage address of the flag */
} orbsoc_pl_instruction;

/* A program for one engine. A line of microcode is ORBSOC_PIECES(code_width) words of 32 bits, low bits first.
 * Streamed microcode stays where it is: `microcode` begins at a multiple of ORBSOC_STREAM_ALIGN bytes, has the first port's part of
 * each line, then the second port's, each at such a multiple, and is in memory, not in a cache, before a launch. The digest is then
 * of the templates alone. */
typedef struct {
  uint32_t binary64, address_bits, code_width;
  const uint32_t *microcode;
  uint32_t lines;
  const uint32_t *templates;
  uint32_t template_count;
  const uint32_t *literal_addresses;
  const uint64_t *literals;
  size_t literal_count;
  const orbsoc_pl_segment *segments; /* by their numbers */
  uint32_t segment_count;
  const orbsoc_pl_instruction *instructions; /* of the control program; none without resident control */
  uint32_t instruction_count;
  uint32_t identity; /* of the engine that it was made for */
  uint32_t digest;   /* as the PL makes it of templates and lines, each in their order */
} orbsoc_pl_image;

/* Where the words of a buffer lie: its word `indices[i]` at storage address `addresses[i]`. Others have no place on the PL. */
typedef struct {
  size_t count;
  const uint32_t *indices, *addresses;
} orbsoc_pl_buffer;

/* Programs whose microcode may be in the memory at a time; one of them, and its first line. */
#define ORBSOC_PL_PROGRAMS 8u
typedef struct {
  const orbsoc_pl_image *image;
  uint32_t first;
} orbsoc_pl_resident;

#define ORBSOC_PIECES(width) (((width) + 31u) / 32u)

/* One PL. Fields are the driver's; the caller may read `sequence`, `valid` and the engine's sizes. */
typedef struct {
  uintptr_t registers, memories;
  uint32_t engine, binary64, address_bits, code_bits, code_width, identity, words; /* as the PL says */
  uint32_t flag_words;
  uint32_t sequence;       /* of the last frame */
  uint64_t valid, written; /* flags as last read; buffers ever written */
  orbsoc_pl_resident resident[ORBSOC_PL_PROGRAMS];
  uint32_t residents;
  uint32_t first; /* line of the program that was loaded, or switched to, last */
  /* The launch that is out. */
  uint32_t number;
  uint64_t writes, stales, may_write;
  volatile uint32_t out, taken; /* a launch is out; its end was taken by orbsoc_pl_on_interrupt */
  volatile orbsoc_pl_error result;
  volatile uint32_t bus_errors; /* since the last reset */
} orbsoc_pl;

/* Find out what engine is there, and reset it. `buffers`: of the method, at most ORBSOC_PL_BUFFERS. */
orbsoc_pl_error orbsoc_pl_open(orbsoc_pl *pl, uintptr_t registers, uintptr_t memories, uint32_t buffers);

/* Registers, flags, table and entries of the control program afresh; memories stay. The only way on after an error of a
 * launch: until then it counts as out, since the PL may still be busy. */
orbsoc_pl_error orbsoc_pl_reset(orbsoc_pl *pl);

/* Microcode, templates, literals, table of segments and control program: all of an image, or one of them. An image of another
 * engine is WRONG_ENGINE before anything is written. What came to be in the memories is compared with the image: microcode
 * and templates by the PL's own digest, literals word by word; WRONG_PROGRAM where it differs. */
orbsoc_pl_error orbsoc_pl_load(orbsoc_pl *pl, const orbsoc_pl_image *image);

/* The same in two halves, for a loader that moves the lines between them, in their order: by DMA, say. Where microcode is streamed
 * there is nothing to move, and the bus refuses a line. */
orbsoc_pl_error orbsoc_pl_load_begin(orbsoc_pl *pl, const orbsoc_pl_image *image);
orbsoc_pl_error orbsoc_pl_load_end(orbsoc_pl *pl, const orbsoc_pl_image *image);
orbsoc_pl_error orbsoc_pl_load_line(orbsoc_pl *pl, uint32_t line, const uint32_t *pieces);
orbsoc_pl_error orbsoc_pl_load_template(orbsoc_pl *pl, uint32_t number, uint32_t word);
orbsoc_pl_error orbsoc_pl_load_segment(orbsoc_pl *pl, uint32_t number, const orbsoc_pl_segment *segment);
orbsoc_pl_error orbsoc_pl_load_instruction(orbsoc_pl *pl, uint32_t place, const orbsoc_pl_instruction *instruction);

/* Several programs in one memory of microcode, which a switch leaves alone. `load_beside` loads an image on the first lines that no
 * other has, OUT_OF_RANGE where there are not enough; `load_beside_begin` and `orbsoc_pl_load_end` are its halves, the lines between them
 * from `pl->first` on. `switch` goes to one that is there: a reset, templates, literals and tables; WRONG_PROGRAM for one that is
 * not. Both leave all flags down: programs share the storage, so no buffer outlives them. An image stays where it is in
 * the caller's memory; orbsoc_pl_load forgets those whose lines it takes, orbsoc_pl_open all. */
orbsoc_pl_error orbsoc_pl_load_beside(orbsoc_pl *pl, const orbsoc_pl_image *image);
orbsoc_pl_error orbsoc_pl_load_beside_begin(orbsoc_pl *pl, const orbsoc_pl_image *image);
orbsoc_pl_error orbsoc_pl_switch(orbsoc_pl *pl, const orbsoc_pl_image *image);

/* The table of segments and the control program of an image alone: what a reset forgets. */
orbsoc_pl_error orbsoc_pl_load_tables(orbsoc_pl *pl, const orbsoc_pl_image *image);

/* Words of storage by their addresses, while no launch is out; bits of binary64, or of binary32 in the low half. */
orbsoc_pl_error orbsoc_pl_set_words(orbsoc_pl *pl, const uint32_t *addresses, const uint64_t *words, size_t count);
orbsoc_pl_error orbsoc_pl_get_words(orbsoc_pl *pl, const uint32_t *addresses, uint64_t *words, size_t count);

/* Whether the PS may run a stage itself: no buffer that it reads has its flag down. */
orbsoc_pl_error orbsoc_pl_readable(const orbsoc_pl *pl, const orbsoc_pl_segment *segment);

/* Tell the PL which buffers a stage of the PS, or the problem data (segment 0), wrote and made stale. */
orbsoc_pl_error orbsoc_pl_publish(orbsoc_pl *pl, uint32_t number, const orbsoc_pl_segment *segment);

/* Start a segment, or an attempt under resident control; neither waits. */
orbsoc_pl_error orbsoc_pl_launch(orbsoc_pl *pl, uint32_t number, const orbsoc_pl_segment *segment);
orbsoc_pl_error orbsoc_pl_launch_attempt(orbsoc_pl *pl, const orbsoc_pl_attempt *attempt);

/* Let the PL stop a launch that is busy for more than `clocks` of its own: ORBSOC_PL_CYCLE_LIMIT, told by the interrupt. 0: no limit.
 * It holds from now on, over resets as well. LOST_WRITE: the register does not have it, or the PL has none. */
orbsoc_pl_error orbsoc_pl_limit(orbsoc_pl *pl, uint32_t clocks);

/* Clocks for which the launch that runs, or ran last, was busy, by the counter behind the limit. */
uint32_t orbsoc_pl_spent(const orbsoc_pl *pl);

/* Ask a running attempt to end at its next decision. */
orbsoc_pl_error orbsoc_pl_stop(orbsoc_pl *pl);

/* Without interrupts: read STATUS, at most `budget` times, until the launch has ended, and take its end. */
orbsoc_pl_error orbsoc_pl_poll(orbsoc_pl *pl, uint32_t budget);

/* In the interrupt handler: take the end of the launch, which lets the line fall. After a fault it stays up: mask it. */
orbsoc_pl_error orbsoc_pl_on_interrupt(orbsoc_pl *pl);

/* In the handler of an abort that an access to the PL has raised, which then goes on behind that access: the function that
 * made it, or the next one that looks at STATUS, returns ORBSOC_PL_BUS_ERROR. */
void orbsoc_pl_on_bus_error(orbsoc_pl *pl);

/* Beside the handler: look, at most `budget` times, whether it has taken the end of the launch; what it found. */
orbsoc_pl_error orbsoc_pl_await(orbsoc_pl *pl, uint32_t budget);

/* At the end of a run nothing may be running, half announced or unacknowledged. */
orbsoc_pl_error orbsoc_pl_require_rest(orbsoc_pl *pl);

/* Busy cycles of the last segment, by the engine's counter. */
uint32_t orbsoc_pl_cycles(const orbsoc_pl *pl);

#endif
