#include "dma.h"

#define DESCRIPTOR (*(volatile uint64_t *)0x11000010)
#define START (*(volatile uint64_t *)0x11000018)
#define STATUS (*(volatile uint64_t *)0x11000020)
#define BUSY 1u
#define REFUSED 2u
#define TO_MEMORY ((uint64_t)1 << 32)

typedef struct {
  uint64_t addresses, beats;
} descriptor;

/* A list of one, from start to end. The core's caches are coherent with the DMA: a fence is all that it takes. */
static uint32_t move(uintptr_t memory, uint32_t engine, size_t beats, uint64_t direction) {
  static descriptor one;
  uint64_t status;
  one.addresses = (uint64_t)engine << 32 | (uint32_t)memory;
  one.beats = beats | direction;
  __asm__ volatile("fence iorw, iorw" ::: "memory");
  DESCRIPTOR = (uintptr_t)&one;
  START = 1;
  do status = STATUS;
  while (status & BUSY);
  STATUS = 0;
  __asm__ volatile("fence iorw, iorw" ::: "memory");
  return status & REFUSED ? ORBSOC_PL_BUS_ERROR : ORBSOC_PL_OK;
}

static const orbsoc_pl_buffer *buffer_of(const orbsoc_pl_device *device, uint32_t buffer) {
  return &device->parts->buffers[device->parts->flag[buffer]];
}

/* Indices and addresses rise: where the ends are as far apart as there are words, all between follow each other. */
int dma_moves(const orbsoc_pl_device *device, uint32_t buffer) {
  const orbsoc_pl_buffer *at = buffer_of(device, buffer);
  const size_t last = at->count - 1;
  return sizeof(orbsoc_real) == 8 && at->count != 0 && at->indices[last] - at->indices[0] == last &&
         at->addresses[last] - at->addresses[0] == last;
}

uint32_t dma_put(orbsoc_pl_device *device, uint32_t buffer, const orbsoc_real *words) {
  const orbsoc_pl_buffer *at = buffer_of(device, buffer);
  return move((uintptr_t)&words[at->indices[0]], ORBSOC_REGION_STORAGE + 8u * at->addresses[0], at->count, 0);
}

uint32_t dma_get(orbsoc_pl_device *device, uint32_t buffer, orbsoc_real *words) {
  const orbsoc_pl_buffer *at = buffer_of(device, buffer);
  return move((uintptr_t)&words[at->indices[0]], ORBSOC_REGION_STORAGE + 8u * at->addresses[0], at->count, TO_MEMORY);
}

uint32_t dma_load(orbsoc_pl_device *device) {
  const orbsoc_pl_image *whole = device->parts->image;
  const uint32_t pieces = ORBSOC_PIECES(whole->code_width);
  const int contiguous = (pieces & (pieces - 1u)) == 0 && pieces >= 2 && (uintptr_t)whole->microcode % 8u == 0;
  uint32_t found = (uint32_t)orbsoc_pl_open(&device->pl, device->registers, device->memories, ORBSOC_PL_BUFFERS);
  found = (found == ORBSOC_PL_OK) ? (uint32_t)orbsoc_pl_limit(&device->pl, device->limit) : found;
  if (found != ORBSOC_PL_OK) return found;
  if (!contiguous) return (uint32_t)orbsoc_pl_load(&device->pl, whole);
  found = (uint32_t)orbsoc_pl_load_begin(&device->pl, whole);
  if (found == ORBSOC_PL_OK)
    found = move((uintptr_t)whole->microcode, ORBSOC_REGION_MICROCODE, (size_t)pieces / 2u * whole->lines, 0);
  return (found == ORBSOC_PL_OK) ? (uint32_t)orbsoc_pl_load_end(&device->pl, whole) : found;
}
