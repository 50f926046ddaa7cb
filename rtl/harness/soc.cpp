// Runs a program on the whole computer: soc +image=FILE RATIO LATENCY [LIMIT]. The program's console is the output;
// lines "@CLOCKS" say how far the run is. RATIO is core clocks a clock of the engine, from 1, fractions allowed. Ends at the program's exit code (the run's own),
// or after LIMIT core clocks with 124.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "Vsoc.h"
#include "verilated.h"

int main(int count, char **arguments) {
  if (count < 4) {
    std::fprintf(stderr, "soc +image=FILE RATIO LATENCY [LIMIT]\n");
    return 2;
  }
  VerilatedContext context;
  context.commandArgs(count, (const char **)arguments);
  Vsoc top{&context};
  const double ratio = std::atof(arguments[2]);
  const uint64_t limit = count > 4 ? std::strtoull(arguments[4], nullptr, 10) : UINT64_MAX;
  top.latency = uint16_t(std::atoi(arguments[3]));

  // Edge k of the engine's clock is at the core's edge ceil(k ratio).
  uint64_t clocks = 0, edges = 0;
  int code = -1;
  bool line_open = false;
  top.reset = 1;
  for (; code < 0 && clocks < limit; ++clocks) {
    const bool tick = double(clocks) >= double(edges) * ratio;
    edges += tick;
    if (clocks == uint64_t(64 * ratio)) top.reset = 0;
    top.tick = tick;
    top.clock = 0;
    top.pl_clock = 0;
    top.eval();
    if (!top.reset) {
      if (top.console_valid) std::putchar(top.console_byte);
      if (top.console_valid) line_open = top.console_byte != '\n';
      if (clocks % (1 << 18) == 0 && !line_open) std::printf("@%llu\n", (unsigned long long)clocks), std::fflush(stdout);
      if (top.exit_valid) code = int(top.exit_code & 0xff);
    }
    top.clock = 1;
    top.pl_clock = tick;
    top.eval();
  }
  std::fflush(stdout);
  top.final();
  return code < 0 ? 124 : code;
}
