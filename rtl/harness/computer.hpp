// Driver of the engine under Verilator: clock, registers, storage, microcode.
#pragma once
#include <array>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <vector>

#include "Vengine.h"
#include "Vengine_engine.h"
#include "contract.hpp"
#include "orbsoc_registers.h"
#include "rules.hpp"

// Parameters and widths of the ports as the RTL has them (engine.sv, public).
using Built = Vengine_engine;
constexpr uint64_t CODE_LINES = uint64_t(1) << Built::CODE_BITS, STORAGE_WORDS = uint64_t(Built::DEPTH) * Built::BANKS;
constexpr uint64_t WORD_MASK = ~uint64_t(0) >> (64 - Built::FP);

static_assert(RULE_COUNT == Built::RULES, "a rule without a name (checks.sv)");

enum Register : uint16_t {
  MODULE = ORBSOC_REG_MODULE,
  SEGMENT = ORBSOC_REG_SEGMENT,
  SEQUENCE = ORBSOC_REG_SEQUENCE,
  CONTROL = ORBSOC_REG_CONTROL,
  STATUS = ORBSOC_REG_STATUS,
  IRQ_ACK = ORBSOC_REG_IRQ_ACK,
  TABLE = ORBSOC_TABLE
};

// Hexadecimal digits into a port of any width.
inline void set_port(IData &port, const std::string &hex) { port = IData(std::stoull(hex, nullptr, 16)); }
inline void set_port(QData &port, const std::string &hex) { port = std::stoull(hex, nullptr, 16); }
template <std::size_t N> void set_port(VlWide<N> &port, const std::string &hex) {
  for (std::size_t i = 0; i < N; ++i) {
    const std::size_t end = hex.size() > 8 * i ? hex.size() - 8 * i : 0, begin = end > 8 ? end - 8 : 0;
    port[i] = end ? EData(std::stoul(hex.substr(begin, end - begin), nullptr, 16)) : 0;
  }
}

class Computer {
 public:
  Computer() {
    dut.clock = dut.bus_write = dut.bus_read = dut.bus_address = dut.bus_value = 0;
    dut.host_write = dut.host_read = dut.host_address = dut.host_word = 0;
    dut.code_write = dut.code_address = dut.template_write = dut.template_address = dut.template_word = 0;
    set_port(dut.code_word, "0");
    reset();
    clocks = 0;
    segments.clear();  // what random bits ran before the reset
  }

  // Reset registers, flags and checks; microcode stays, storage counts as unwritten.
  void reset() {
    dut.reset = 1;
    for (int i = 0; i < RESET_CLOCKS; ++i) clock();
    dut.reset = 0;
    violations.fill(0);
    busy_cycles = 0;
  }

  // One line of microcode; one template of compressed microcode.
  void load_line(uint64_t address, const std::string &word) {
    if (address >= CODE_LINES)
      throw std::runtime_error("microcode: line " + std::to_string(address) + ", but this engine's memory holds " +
                               std::to_string(CODE_LINES) + " (CODE_BITS)");
    dut.code_write = 1;
    dut.code_address = IData(address);
    set_port(dut.code_word, word);
    clock();
    dut.code_write = 0;
  }
  void load_template(uint64_t number, const std::string &word) {
    if (number >= Built::TEMPLATES)
      throw std::runtime_error("template " + std::to_string(number) + ", but this engine holds " + std::to_string(Built::TEMPLATES));
    dut.template_write = 1;
    dut.template_address = CData(number);
    dut.template_word = SData(std::stoul(word, nullptr, 16));
    clock();
    dut.template_write = 0;
  }

  void write_word(uint64_t address, uint64_t word) {
    dut.host_write = 1;
    dut.host_address = address;
    dut.host_word = word;
    clock();
    dut.host_write = 0;
  }
  // Writes reach the storage a few cycles later; call between the last write and the first read or start.
  void settle() { for (int i = 0; i < 4; ++i) clock(); }

  uint64_t read_word(uint64_t address) {
    dut.host_read = 1;
    dut.host_address = address;
    clock();
    dut.host_read = 0;
    for (int i = 0; i < 4; ++i) clock();
    return dut.host_value;
  }

  // Every word of storage, by address, while the engine is idle: one read a clock, latency five clocks.
  std::vector<uint64_t> read_storage() {
    constexpr uint64_t UNDER_WAY = 4;
    std::vector<uint64_t> words(STORAGE_WORDS);
    for (uint64_t at = 0; at < STORAGE_WORDS + UNDER_WAY; ++at) {
      dut.host_read = at < STORAGE_WORDS;
      dut.host_address = at % STORAGE_WORDS;
      clock();
      if (at >= UNDER_WAY) words[at - UNDER_WAY] = dut.host_value;
    }
    dut.host_read = 0;
    return words;
  }

  void write_register(uint16_t address, uint32_t value) {
    dut.bus_write = 1;
    dut.bus_address = address;
    dut.bus_value = value;
    clock();
    dut.bus_write = 0;
  }
  uint32_t read_register(uint16_t address) {
    dut.bus_read = 1;
    dut.bus_address = address;
    dut.eval();
    const uint32_t answer = dut.bus_answer;
    clock();
    dut.bus_read = 0;
    return answer;
  }

  bool interrupt() const { return dut.irq; }
  // What axi_contract.sv says of an engine behind AXI, for one without; the host compares it with the program's.
  uint32_t identity() const {
    constexpr bool F64 = Built::FP == 64;
    constexpr uint32_t ROWS = uint32_t(Built::DEPTH) == (1u << Built::ADDRESS_BITS) / Built::BANKS ? 0 : Built::DEPTH;
    uint32_t hash = 0x811c9dc5;
    for (const uint32_t word : std::initializer_list<uint32_t>{
             1, Built::FP, Built::LANES, Built::DIVIDERS, Built::BANKS, Built::CLUSTERS, Built::ADDRESS_BITS | ROWS << 8, Built::SEQUENCER == 1,
             F64 ? F64_ADD_CYCLES : F32_ADD_CYCLES, F64 ? F64_MUL_CYCLES : F32_MUL_CYCLES, F64 ? F64_DIV_CYCLES : F32_DIV_CYCLES,
             F64 ? F64_SQRT_CYCLES : F32_SQRT_CYCLES, F64 ? F64_DIV_INTERVAL_CYCLES : F32_DIV_INTERVAL_CYCLES,
             F64 ? F64_SQRT_INTERVAL_CYCLES : F32_SQRT_INTERVAL_CYCLES, SIMPLE_CYCLES, READ_CYCLES, WRITE_CYCLES, STARTUP_CYCLES,
             DECODE_CYCLES, HEADERS_AHEAD, SHORT_BITS, TEMPLATE_BITS, TEMPLATE_WIDTH})
      hash = (hash ^ word) * 16777619;
    return hash;
  }
  uint32_t counted() const { return dut.cycles; }  // by the engine's own counter

  // Fetch gaps: one step of a xorshift per cycle in which fetch is wanted.
  void set_gaps(uint32_t seed, uint32_t gap_level) {
    random = seed;
    level = gap_level;
  }

  void clock() {
    dut.clock = 0;
    dut.fetch_valid = 1;
    dut.eval();
    if (dut.fetch_wanted) {
      random ^= random << 13;
      random ^= random >> 17;
      random ^= random << 5;
      dut.fetch_valid = (random & 255) >= level;
      dut.eval();
    }
    if (dut.busy) ++busy_cycles;
    if (dut.violations && !dut.reset) {
      for (int i = 0; i < RULE_COUNT; ++i) violations[i] += dut.violations >> i & 1;
    }
    if (was_busy && !dut.busy) segments.push_back({uint32_t(dut.running), uint32_t(dut.cycles)});
    was_busy = dut.busy;
    dut.clock = 1;
    dut.eval();
    ++clocks;
  }

  std::array<uint64_t, RULE_COUNT> violations{};
  uint64_t busy_cycles = 0;  // counted from outside
  uint64_t clocks = 0;       // since construction
  std::vector<std::array<uint32_t, 2>> segments;  // that have ended: number, busy cycles by the engine's own counter

 private:
  static constexpr int RESET_CLOCKS = 2;

  Vengine dut;
  uint32_t random = 1, level = 0;
  bool was_busy = false;
};
