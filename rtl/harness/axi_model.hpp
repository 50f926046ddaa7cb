// What the slaves face on their other side, and what bursts should do there: an engine's ports with their timing rules, and
// a plain model of words in pieces of 32 bits.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "orbsoc_registers.h"

constexpr int READ_CLOCKS = 5, SETTLE_CLOCKS = 5;  // host_read to its word; host_write to the first read or register write

enum Memory : uint32_t { STORAGE = 0, CODE = 1, TEMPLATES = 2 };
using Pieces = std::vector<uint32_t>;
using Commit = std::tuple<uint32_t, uint64_t, Pieces>;  // memory, word, its pieces

struct Sizes {
  uint64_t fp, storage_words, code_bits, code_width, template_bits, template_width;
  uint64_t pieces(uint32_t memory) const { return memory == STORAGE ? fp / 32 : memory == CODE ? (code_width + 31) / 32 : 1; }
  uint64_t stride(uint32_t memory) const {  // bytes from word to word
    uint64_t all = 1;
    while (all < pieces(memory)) all *= 2;
    return 4 * all;
  }
  uint64_t words(uint32_t memory) const {
    return memory == STORAGE ? storage_words : uint64_t(1) << (memory == CODE ? code_bits : template_bits);
  }
  uint64_t bytes(uint32_t memory) const { return memory > TEMPLATES ? 0 : stride(memory) * words(memory); }
  uint64_t width(uint32_t memory) const { return memory == STORAGE ? fp : memory == CODE ? code_width : template_width; }
};

// The pieces of a word, cut to its width.
inline Pieces cut(Pieces pieces, uint64_t width) {
  if (width % 32) pieces.back() &= (1u << width % 32) - 1;
  return pieces;
}

struct Burst {
  uint32_t id, len, size, kind;
  uint64_t address;  // region and offset
  std::vector<uint64_t> data;
  std::vector<uint8_t> strobes;
  uint64_t bytes() const { return uint64_t(1) << size; }
};

// Words that are put together of pieces; a burst at a time.
class Assembly {
 public:
  explicit Assembly(const Sizes &sizes) : sizes(sizes) {}

  bool refused(const Burst &b, uint64_t region_bits) const {
    const uint32_t memory = uint32_t(b.address >> region_bits);
    const uint64_t offset = b.address & ((uint64_t(1) << region_bits) - 1);
    return b.kind != 1 || (b.size != 2 && b.size != 3) || offset % b.bytes() || offset + (b.len + 1) * b.bytes() > sizes.bytes(memory);
  }

  // What a burst that is not refused writes, in order, up to its first error; whether there is none.
  bool write(const Burst &b, uint64_t region_bits, std::vector<Commit> &made) {
    const uint32_t memory = uint32_t(b.address >> region_bits);
    uint64_t offset = b.address & ((uint64_t(1) << region_bits) - 1);
    for (uint32_t beat = 0; beat <= b.len; ++beat, offset += b.bytes()) {
      for (uint64_t at = offset; at < offset + b.bytes(); at += 4) {
        const uint32_t half = at / 4 % 2, strobes = b.strobes[beat] >> 4 * half & 15;
        if (strobes == 0) continue;
        if (strobes != 15) return false;
        if (!piece(memory, at, uint32_t(b.data[beat] >> 32 * half), made)) return false;
      }
    }
    return true;
  }
  void forget() { begun.clear(); }

 private:
  bool piece(uint32_t memory, uint64_t offset, uint32_t value, std::vector<Commit> &made) {
    const uint64_t word = offset / sizes.stride(memory), place = offset % sizes.stride(memory) / 4, count = sizes.pieces(memory);
    if (place >= count) return true;  // padding
    if (place == 0) begun.clear();
    else if (begun.empty() || place != begun.size() || memory != in || word != of) {
      begun.clear();
      return false;
    }
    in = memory;
    of = word;
    begun.push_back(value);
    if (begun.size() == count) {
      made.emplace_back(memory, word, cut(begun, sizes.width(memory)));
      begun.clear();
    }
    return true;
  }

  Sizes sizes;
  Pieces begun;
  uint32_t in = 0;
  uint64_t of = 0;
};

// The engine's ports: memories, a register bus that answers something else in every clock, segments that run for a while
// after CONTROL is written. Accesses that it would not take, or whose timing breaks its rules, are faults.
class EngineModel {
 public:
  EngineModel(const Sizes &sizes, uint32_t seed) : random(seed), storage(sizes.words(STORAGE)), history(sizes.words(STORAGE)) {
    for (uint64_t i = 0; i < storage.size(); ++i) history[i] = {{0, storage[i] = draw64(sizes.fp)}};
  }

  // The answer to this address in this clock, in which nothing else of the engine shows.
  uint32_t answer(uint16_t address, uint64_t clock) const {
    const uint32_t noise = uint32_t(address * 2654435761u ^ clock * 40503u);
    return address == ORBSOC_REG_STATUS ? (noise & ~1u) | status_busy(clock) : noise;
  }
  bool status_busy(uint64_t clock) const { return clock < status_until && clock >= began; }
  // The sequencer: with gaps as between the segments of an attempt, and on when a fault has ended STATUS's.
  bool busy(uint64_t clock) const {
    return clock < busy_until && clock >= began && (clock >= status_until || (clock - began) % 16 < 12);
  }
  bool running(uint64_t clock) const { return status_busy(clock) || busy(clock); }
  bool irq(uint64_t clock) const { return faulty || (began && clock >= began && !status_busy(clock)); }

  void bus_write(uint16_t address, uint32_t value, uint64_t clock) {
    if (clock < last_write + SETTLE_CLOCKS || clock < last_read + READ_CLOCKS) fault("a register write before the memories were quiet", clock);
    writes.emplace_back(address, value, clock);
    if (address == ORBSOC_REG_CONTROL && value == 1 && !running(clock) && !faulty) {
      began = clock + 1;
      status_until = began + 10 + random() % 150;
      busy_until = random() % 4 ? status_until : status_until + random() % 10;
      if (random() % 6 == 0) {  // a fault: STATUS is not busy, the sequencer is, and without a gap
        status_until = began;
        busy_until = began + 1 + random() % 12;
      }
    }
  }
  // A reset ends what runs; the read of an unknown address, by which the wrapper stops a launch behind one, is a fault.
  void reset(uint64_t clock) {
    status_until = std::min(status_until, clock + 1);
    busy_until = std::min(busy_until, clock + 1);
    faulty = false;
  }
  void fault_of_access() { faulty = true; }
  void bus_read(uint16_t address, uint32_t value, uint64_t clock) { reads.emplace_back(address, value, clock); }

  void host_write(uint64_t address, uint64_t word, uint64_t clock) {
    require_idle(clock);
    last_write = clock;
    landing[clock + SETTLE_CLOCKS - 1] = {address, word};
    history[address].push_back({clock, word});
  }
  void host_read(uint64_t address, uint64_t clock) {
    require_idle(clock);
    if (clock < last_write + SETTLE_CLOCKS) fault("a read before the last write has settled", clock);
    last_read = clock;
    arriving[clock + READ_CLOCKS] = storage[address];
  }
  void other_write(uint64_t clock) {
    require_idle(clock);
    last_write = clock;
  }
  // The storage port's word in this clock: what was asked for READ_CLOCKS ago, or anything.
  uint64_t host_value(uint64_t clock) {
    const auto found = arriving.find(clock);
    return found == arriving.end() ? draw64(64) : found->second;
  }
  void end_of_clock(uint64_t clock) {
    const auto found = landing.find(clock);
    if (found != landing.end()) storage[found->second.first] = found->second.second;
    landing.erase(clock);
    arriving.erase(clock);
  }

  // Whether a read between these clocks may give this.
  bool possible(uint64_t address, uint64_t value, uint64_t from, uint64_t to) const {
    const auto &all = history[address];
    for (std::size_t i = 0; i < all.size(); ++i) {
      const bool replaced = i + 1 < all.size() && all[i + 1].first <= from;
      if (all[i].first <= to && !replaced && all[i].second == value) return true;
    }
    return false;
  }

  std::vector<std::tuple<uint16_t, uint32_t, uint64_t>> writes, reads;  // on the bus: address, value, clock
  std::vector<std::string> faults;

 private:
  uint64_t draw64(uint64_t bits) {
    const uint64_t word = uint64_t(random()) << 32 | random();
    return bits == 64 ? word : word & 0xffffffff;
  }
  void require_idle(uint64_t clock) {
    if (running(clock)) fault("an access to a memory while the engine runs", clock);
  }
  void fault(const char *what, uint64_t clock) { faults.push_back(std::string("engine: ") + what + ", clock " + std::to_string(clock)); }

  std::mt19937 random;
  std::vector<uint64_t> storage;
  std::vector<std::vector<std::pair<uint64_t, uint64_t>>> history;  // of each word: since when, what
  std::map<uint64_t, std::pair<uint64_t, uint64_t>> landing;
  std::map<uint64_t, uint64_t> arriving;
  uint64_t last_write = 0, last_read = 0, began = 0, status_until = 0, busy_until = 0;
  bool faulty = false;
};
