// Unit test of the floating-point units: units EXP MAN LATENCIES(add,mul,div) INTERVAL(div) VECTORS SEED.
// Prints one line per operation and the first mismatches; exits 1 if there is one. Units get new operands every cycle,
// the divider once in INTERVAL, with cycles of `enable` low in between; the result is compared exactly LATENCY enabled cycles later.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <deque>

#include "Vunits.h"
#include "start.hpp"
#include "vectors.hpp"

namespace {

struct Expected {
  uint64_t a, b, result;
};

struct Outcome {
  uint64_t vectors = 0, mismatches = 0, nan = 0, infinite = 0, subnormal = 0, zero = 0;
};

class Bench {
 public:
  Bench(Format format, uint64_t seed) : f(format), pause(seed) {
    dut.subtract = dut.start = dut.root = dut.a = dut.b = 0;
    dut.reset = 1;
    dut.enable = 1;
    clock();
    dut.reset = 0;
  }

  Outcome run(Op op, uint64_t latency, uint64_t interval, uint64_t vectors, uint64_t seed) {
    Vectors source(f, op, seed);
    Outcome outcome;
    const bool divides = op == Op::div || op == Op::sqrt;
    std::deque<Expected> expected;
    dut.subtract = op == Op::sub;
    dut.root = op == Op::sqrt;
    const uint64_t cycles = (vectors - 1) * interval + latency + 1;
    for (uint64_t cycle = 0, i = 0; cycle < cycles;) {
      // Compare the outputs, set the inputs, clock.
      const bool due = cycle >= latency && (cycle - latency) % interval == 0;
      if (due && op != Op::less) {
        check(op, expected.front(), output(op), outcome);
        expected.pop_front();
      }
      dut.start = 0;
      if (i < vectors && cycle % interval == 0) {
        const auto [a, b] = source.pair(i++);
        dut.a = a;
        dut.b = b;
        dut.start = divides;
        dut.eval();
        expected.push_back({a, b, reference(f, op, a, b)});
        if (op == Op::less) check(op, expected.back(), dut.less, outcome);
      }
      stumble();
      clock();
      ++cycle;
    }
    return outcome;
  }

 private:
  // Random cycles without enable: no register may change.
  void stumble() {
    pause = pause * 6364136223846793005ull + 1442695040888963407ull;
    if (pause >> 61 != 0) return;
    dut.enable = 0;
    clock();
    dut.enable = 1;
  }
  void clock() {
    dut.clock = 0;
    dut.eval();
    dut.clock = 1;
    dut.eval();
  }
  uint64_t output(Op op) {
    switch (op) {
      case Op::mul: return dut.product;
      case Op::div:
      case Op::sqrt: return dut.quotient;
      default: return dut.sum;
    }
  }
  void check(Op op, const Expected &e, uint64_t found, Outcome &outcome) {
    ++outcome.vectors;
    const uint64_t magnitude = e.result & ~f.sign();
    if (op != Op::less) {
      outcome.nan += magnitude > f.infinity();
      outcome.infinite += magnitude == f.infinity();
      outcome.zero += magnitude == 0;
      outcome.subnormal += magnitude != 0 && magnitude >> f.man == 0;
    }
    if (found == e.result) return;
    if (outcome.mismatches++ < 5)
      std::printf("differ %s %" PRIx64 " %" PRIx64 " expected %" PRIx64 " found %" PRIx64 "\n", OP_NAME[int(op)], e.a, e.b,
                  e.result, found);
  }

  Format f;
  uint64_t pause;
  Vunits dut;
};

}  // namespace

int main(int argc, char **argv) {
  if (argc != 9) {
    std::fprintf(stderr, "usage: units EXP MAN ADD_CYCLES MUL_CYCLES DIV_CYCLES DIV_INTERVAL_CYCLES VECTORS SEED\n");
    return 2;
  }
  const Format format{std::atoi(argv[1]), std::atoi(argv[2])};
  const int add = std::atoi(argv[3]), mul = std::atoi(argv[4]), div = std::atoi(argv[5]);
  const uint64_t interval = std::strtoull(argv[6], nullptr, 10);
  const uint64_t vectors = std::strtoull(argv[7], nullptr, 10), seed = std::strtoull(argv[8], nullptr, 10);
  begin_with_bits_of(seed_of_start());
  const int latency[] = {add, add, mul, div, div, 0};
  const uint64_t intervals[] = {1, 1, 1, interval, interval, 1};
  Bench bench(format, seed);
  bool good = true;
  for (Op op : {Op::add, Op::sub, Op::mul, Op::div, Op::sqrt, Op::less}) {
    const Outcome o = bench.run(op, uint64_t(latency[int(op)]), intervals[int(op)], vectors, seed + uint64_t(op));
    std::printf("unit %s vectors %" PRIu64 " mismatches %" PRIu64 " nan %" PRIu64 " infinite %" PRIu64 " subnormal %" PRIu64
                " zero %" PRIu64 "\n",
                OP_NAME[int(op)], o.vectors, o.mismatches, o.nan, o.infinite, o.subnormal, o.zero);
    good = good && o.mismatches == 0 && o.vectors == vectors;
  }
  return good ? 0 : 1;
}
