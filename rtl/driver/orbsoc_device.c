#include "orbsoc_device.h"

#include <string.h>

#if ORBSOC_FP == 64
typedef uint64_t word_bits;
#else
typedef uint32_t word_bits;
#endif

static orbsoc_pl_device *device_of(void *context) { return (orbsoc_pl_device *)context; }

static const orbsoc_pl_segment *segment_of(const orbsoc_pl_device *device, uint32_t number) {
  return &device->parts->image->segments[number];
}

static uint32_t restart(void *context, uint32_t reload) {
  orbsoc_pl_device *device = device_of(context);
  orbsoc_pl *pl = &device->pl;
  orbsoc_pl_error found;
  if (reload != 0u) {
    found = orbsoc_pl_open(pl, device->registers, device->memories, ORBSOC_PL_BUFFERS);
    found = (found == ORBSOC_PL_OK) ? orbsoc_pl_limit(pl, device->limit) : found;
    return (uint32_t)((found == ORBSOC_PL_OK) ? orbsoc_pl_load(pl, device->parts->image) : found);
  }
  found = orbsoc_pl_reset(pl);
  found = (found == ORBSOC_PL_OK) ? orbsoc_pl_limit(pl, device->limit) : found;
  return (uint32_t)((found == ORBSOC_PL_OK) ? orbsoc_pl_load_tables(pl, device->parts->image) : found);
}

static const orbsoc_pl_buffer *buffer_of(const orbsoc_pl_device *device, uint32_t buffer) {
  return &device->parts->buffers[device->parts->flag[buffer]];
}

static uint32_t put(void *context, uint32_t buffer, const orbsoc_real *words) {
  orbsoc_pl_device *device = device_of(context);
  const orbsoc_pl_buffer *at = buffer_of(device, buffer);
  orbsoc_pl_error found = ORBSOC_PL_OK;
  for (size_t i = 0; i < at->count && found == ORBSOC_PL_OK; ++i) {
    word_bits bits;
    memcpy(&bits, &words[at->indices[i]], sizeof bits);
    const uint64_t word = bits;
    found = orbsoc_pl_set_words(&device->pl, &at->addresses[i], &word, 1);
  }
  return (uint32_t)found;
}

static uint32_t get(void *context, uint32_t buffer, orbsoc_real *words) {
  orbsoc_pl_device *device = device_of(context);
  const orbsoc_pl_buffer *at = buffer_of(device, buffer);
  orbsoc_pl_error found = ORBSOC_PL_OK;
  for (size_t i = 0; i < at->count && found == ORBSOC_PL_OK; ++i) {
    uint64_t word = 0;
    found = orbsoc_pl_get_words(&device->pl, &at->addresses[i], &word, 1);
    const word_bits bits = (word_bits)word;
    memcpy(&words[at->indices[i]], &bits, sizeof bits);
  }
  return (uint32_t)found;
}

static uint32_t publish(void *context, uint32_t number) {
  orbsoc_pl_device *device = device_of(context);
  const orbsoc_pl_segment *segment = segment_of(device, number);
  const orbsoc_pl_error found = orbsoc_pl_readable(&device->pl, segment);
  return (uint32_t)((found == ORBSOC_PL_OK) ? orbsoc_pl_publish(&device->pl, number, segment) : found);
}

static uint32_t launch(void *context, uint32_t number) {
  orbsoc_pl_device *device = device_of(context);
  if (number == (uint32_t)ORBSOC_COLD_SEGMENT) return (uint32_t)orbsoc_pl_launch_attempt(&device->pl, device->parts->cold);
  if (number == (uint32_t)ORBSOC_WARM_SEGMENT) return (uint32_t)orbsoc_pl_launch_attempt(&device->pl, device->parts->warm);
  return (uint32_t)orbsoc_pl_launch(&device->pl, number, segment_of(device, number));
}

static uint32_t wait(void *context) {
  orbsoc_pl_device *device = device_of(context);
  const orbsoc_pl_error found = orbsoc_pl_poll(&device->pl, device->polls);
  return (found == ORBSOC_PL_LAUNCH_TIMEOUT) ? ORBSOC_DEVICE_RUNS : (uint32_t)found;
}

static uint32_t stop(void *context) { return (uint32_t)orbsoc_pl_stop(&device_of(context)->pl); }

orbsoc_error orbsoc_pl_attach(orbsoc_solver *solver, orbsoc_pl_device *device, const orbsoc_pl_parts *parts,
                              uintptr_t registers, uintptr_t memories) {
  const orbsoc_device hook = {device, ORBSOC_PL_PATIENCE, restart, put, get, publish, launch, wait, stop};
  if (device == NULL || parts == NULL) return ORBSOC_NO_POINTER;
  device->parts = parts;
  device->registers = registers;
  device->memories = memories;
  device->polls = ORBSOC_PL_POLLS;
  device->limit = parts->limit;
  return orbsoc_attach(solver, parts->partition, &hook);
}

const char *orbsoc_pl_event_name(uint32_t event) {
  static const char *const names[] = {
      "none", "launch while busy", "unacknowledged interrupt", "spurious acknowledge", "write out of order",
      "wrong segment", "wrong sequence", "read before valid", "invalid access", "cycle limit"};
  static const char *const found[] = {"lost interrupt", "launch timeout", "lost write", "wrong engine", "out of range",
                                      "not at rest", "bus error", "wrong program"};
  if (event < sizeof names / sizeof names[0]) return names[event];
  if (event >= 16u && event < 16u + sizeof found / sizeof found[0]) return found[event - 16u];
  switch (event) {
    case ORBSOC_ANSWER_REFUSED: return "answer refused by the certificate";
    case ORBSOC_DEVICE_LATE: return "no end within the patience";
    case ORBSOC_DEVICE_ENDLESS: return "more stages than an attempt has";
    default: return "unknown";
  }
}
