// The memory behind the ports of streamed microcode: the host's own, from an address of the bus on. Each port answers in order, the
// first beat of a burst `latency` clocks after its address at the soonest, and gives `beats` beats in `per` clocks while it has some to give. With
// a seed addresses and beats wait by chance as well. One beat may be told to come with an error.
#pragma once
#include <cstdint>
#include <cstring>
#include <deque>
#include <stdexcept>
#include <vector>

class StreamMemory {
 public:
  static constexpr uint32_t BASE = 0x20000000;

  uint64_t latency = 1, beats = 1, per = 1;
  uint32_t seed = 0;
  int64_t error_at = -1;  // the beat, counted over all ports, that comes with SLVERR; -1: none

  // Where the bus has something of the host's; one thing at a time.
  uint32_t place(const void *data, std::size_t bytes) {
    memory = static_cast<const uint8_t *>(data);
    size = bytes;
    return BASE;
  }

  // What each port sees in this clock: inputs of the master, then its outputs.
  template <class Dut> void drive(Dut &dut, uint32_t ports, uint32_t beat_bytes) {
    if (lines.size() != ports) lines.resize(ports);
    ready = given = 0;
    uint32_t responses = 0;
    std::vector<uint8_t> data(std::size_t(ports) * beat_bytes);
    for (uint32_t p = 0; p < ports; ++p) {
      Port &port = lines[p];
      if (!chance()) ready |= 1u << p;
      if (port.bursts.empty() || port.bursts.front().due > clocks) {
        port.tokens = per;  // it has had time
        continue;
      }
      if (port.tokens < per) port.tokens += beats;
      if (port.tokens < per || chance()) continue;
      given |= 1u << p;
      const Burst &burst = port.bursts.front();
      if (burst.address < BASE || burst.address - BASE + beat_bytes > size) throw std::runtime_error("a port reads where there is no microcode");
      std::memcpy(data.data() + std::size_t(p) * beat_bytes, memory + (burst.address - BASE), beat_bytes);
      if (error_at >= 0 && served + popcount(given) - 1 == uint64_t(error_at)) responses |= 2u << 2 * p;
    }
    dut.m_axi_arready = uint8_t(ready);
    dut.m_axi_rvalid = uint8_t(given);
    dut.m_axi_rresp = uint8_t(responses);
    std::memcpy(&dut.m_axi_rdata, data.data(), data.size());  // a port's words of 32 bits lie one after the other
  }
  // The clock's edge is about to come.
  template <class Dut> void see(const Dut &dut, uint32_t ports, uint32_t beat_bytes) {
    for (uint32_t p = 0; p < ports; ++p) {
      Port &port = lines[p];
      if (given >> p & 1) {
        if (!(dut.m_axi_rready >> p & 1)) throw std::runtime_error("a beat is not taken");
        port.tokens -= per;
        ++served;
        Burst &burst = port.bursts.front();
        burst.address += beat_bytes;
        if (--burst.beats == 0) port.bursts.pop_front();
      }
      const bool asks = dut.m_axi_arvalid >> p & 1;
      const Burst burst{slice(&dut.m_axi_araddr, p), uint32_t(reinterpret_cast<const uint8_t *>(&dut.m_axi_arlen)[p]) + 1, clocks + latency};
      if (port.waits && (!asks || burst.address != port.asked.address || burst.beats != port.asked.beats))
        throw std::runtime_error("an address was withdrawn before it was taken");
      port.waits = asks && !(ready >> p & 1);
      port.asked = burst;
      if (!asks || port.waits) continue;
      if (burst.address / 4096 != (burst.address + burst.beats * beat_bytes - 1) / 4096) throw std::runtime_error("a burst across 4 KiB");
      port.bursts.push_back(burst);
    }
    ++clocks;
  }
  bool count_from_here() {
    served = 0;
    return true;
  }

 private:
  struct Burst {
    uint32_t address, beats;
    uint64_t due;
  };
  struct Port {
    std::deque<Burst> bursts;
    uint64_t tokens = 0;
    Burst asked{};
    bool waits = false;
  };
  static uint32_t slice(const void *port, uint32_t p) {
    uint32_t word;
    std::memcpy(&word, static_cast<const uint8_t *>(port) + 4 * p, 4);
    return word;
  }
  static uint64_t popcount(uint32_t bits) { return uint64_t(__builtin_popcount(bits)); }
  bool chance() {
    if (seed == 0) return false;
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed % 3 == 0;
  }

  const uint8_t *memory = nullptr;
  std::size_t size = 0;
  std::vector<Port> lines;
  uint32_t ready = 0, given = 0;
  uint64_t served = 0;  // beats
  uint64_t clocks = 0;
};
