// Runs a program on the whole computer: soc +image=FILE RATIO LATENCY [LIMIT [FAULT SKIP TIMES]]. The program's console is the
// output; lines "@CLOCKS" say how far the run is. RATIO is core clocks a clock of the engine, from 1, fractions allowed. Ends at the
// program's exit code (the run's own), or after LIMIT core clocks, where it is not 0, with 124. FAULT: a kind of soc_fault.sv.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "Vsoc.h"
#include "start.hpp"
#include "verilated.h"
#if VM_TRACE
#include "verilated_fst_c.h"
#endif

// Waveforms of a window of core clocks, +trace=FILE +trace_from=CLOCK +trace_clocks=COUNT, ten units of time a clock; and lines
// "pl CLOCK SEGMENT" where the engine begins a segment, SEGMENT -1 where it comes to rest. In a model built for it, or nothing.
#if VM_TRACE
class Trace {
 public:
  Trace(VerilatedContext &context, Vsoc &top) : top_(top) {
    const auto given = [&](const char *name) {
      const std::string found = context.commandArgsPlusMatch(name);
      const auto at = found.find('=');
      return at == std::string::npos ? std::string() : found.substr(at + 1);
    };
    first_ = std::strtoull(given("trace_from=").c_str(), nullptr, 10);
    last_ = first_ + std::strtoull(given("trace_clocks=").c_str(), nullptr, 10);
    context.traceEverOn(true);
    top.trace(&file_, 99);
    file_.open(given("trace=").c_str());
  }
  ~Trace() { file_.close(); }
  void at(uint64_t clocks, bool high) {
    if (clocks >= first_ && clocks < last_) file_.dump(10 * clocks + (high ? 5 : 0));
    const int segment = top_.pl_busy ? top_.pl_running : -1;
    if (high && segment != before_) std::printf("pl %llu %d\n", (unsigned long long)clocks, segment);
    before_ = high ? segment : before_;
  }

 private:
  Vsoc &top_;
  VerilatedFstC file_;
  uint64_t first_, last_;
  int before_ = -1;
};
#else
class Trace {
 public:
  Trace(VerilatedContext &, Vsoc &) {}
  void at(uint64_t, bool) {}
};
#endif

int main(int count, char **arguments) {
  if (count < 4) {
    std::fprintf(stderr, "soc +image=FILE RATIO LATENCY [LIMIT [FAULT SKIP TIMES]]\n");
    return 2;
  }
  VerilatedContext context;
  begin_with_bits_of(seed_of_start(0), context);  // the core is not ours
  context.commandArgs(count, (const char **)arguments);
  Vsoc top{&context};
  Trace trace{context, top};
  const double ratio = std::atof(arguments[2]);
  const auto number = [&](int at) { return count > at ? std::strtoull(arguments[at], nullptr, 10) : 0; };
  const uint64_t limit = number(4) != 0 ? number(4) : UINT64_MAX;
  top.latency = uint16_t(number(3));
  top.fault = uint8_t(number(5));
  top.fault_skip = uint16_t(number(6));
  top.fault_times = uint16_t(number(7));

  // Edge k of the engine's clock is at the core's edge ceil(k ratio).
  uint64_t clocks = 0, edges = 0;
  int code = -1;
  bool line_open = false;
  bool tick = true;
  top.next_tick = top.reset_input = 1;
  for (; code < 0 && clocks < limit; ++clocks) {
    edges += tick;
    if (clocks == uint64_t(64 * ratio)) top.reset_input = 0;
    top.clock = 0;
    top.pl_clock = 0;
    top.eval();
    trace.at(clocks, false);
    if (!top.reset_input) {
      if (top.console_valid) std::putchar(top.console_byte);
      if (top.console_valid) line_open = top.console_byte != '\n';
      if (clocks % (1 << 18) == 0 && !line_open) std::printf("@%llu\n", (unsigned long long)clocks), std::fflush(stdout);
      if (top.exit_valid) code = int(top.exit_code & 0xff);
    }
    top.clock = 1;
    top.pl_clock = tick && !top.pl_stopped;
    top.next_tick = tick = double(clocks + 1) >= double(edges) * ratio;
    top.eval();
    trace.at(clocks, true);
  }
  std::fflush(stdout);
  top.final();
  return code < 0 ? 124 : code;
}
