// What a model's registers and memories begin with: random bits of a seed, as those of a device may; of seed 0 zeros. The seed is
// ORBSOC_RTL_SEED, `otherwise` where that is not set. Called before a model is made.
#pragma once
#include <cstdio>
#include <cstdlib>

#include "verilated.h"

inline int seed_of_start(int otherwise = 1) {
  const char *const given = std::getenv("ORBSOC_RTL_SEED");
  if (!given) return otherwise;
  char *end = nullptr;
  const long seed = std::strtol(given, &end, 10);
  if (end == given || *end || seed < 0 || seed > 1000000000) {
    std::fprintf(stderr, "ORBSOC_RTL_SEED = '%s': allowed is a whole number from 0 to 1000000000\n", given);
    std::exit(2);
  }
  return int(seed);
}

inline void begin_with_bits_of(int seed, VerilatedContext &context = *Verilated::threadContextp()) {
  context.randReset(seed ? 2 : 0);
  context.randSeed(seed);
}

// Of an engine. With PARITY zeros: that its memories hold no wrong word at power-up is asked of a device (docs/rtl.md).
inline void begin_as_engine(bool parity) { begin_with_bits_of(parity ? 0 : seed_of_start()); }
