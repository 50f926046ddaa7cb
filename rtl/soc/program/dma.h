/* Words of whole buffers, and microcode, by the board's DMA (soc_dma.sv), in place of the driver's single stores. */
#ifndef DMA_H
#define DMA_H

#include "orbsoc_device.h"

/* Whether the words of a buffer follow each other in memory and on the PL: what follows is for such buffers. */
int dma_moves(const orbsoc_pl_device *device, uint32_t buffer);
uint32_t dma_put(orbsoc_pl_device *device, uint32_t buffer, const orbsoc_real *words);
uint32_t dma_get(orbsoc_pl_device *device, uint32_t buffer, orbsoc_real *words);

/* The engine found and all of its program loaded. */
uint32_t dma_load(orbsoc_pl_device *device);

#endif
