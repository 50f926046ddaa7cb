// The engine behind AXI under Verilator, and the driver in C as its PS: each of the driver's accesses is a transaction on one
// of the two ports, with VALID and READY delayed by chance. The rules of AXI are looked at in every clock; an error on the bus
// ends the program, as it would end up in a processor's abort.
#pragma once
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "Vaxi_engine.h"
#include "Vaxi_engine_axi_engine.h"
#include "axi_monitor.hpp"
#include "axi_stream_memory.hpp"
#include "rules.hpp"

#define ORBSOC_EXTERNAL_ACCESS
#define ORBSOC_BUS_ADDRESS
extern "C" {
#include "orbsoc.h"
}

using Built = Vaxi_engine_axi_engine;

class AxiComputer {
 public:
  static constexpr uintptr_t REGISTERS = 0x40000000, MEMORIES = 0x80000000;
  static inline AxiComputer *current = nullptr;  // whose accesses the driver's are

  AxiComputer() {
    current = this;
    dut.aclk = dut.aresetn = 0;
    dut.s_axil_awvalid = dut.s_axil_awaddr = dut.s_axil_wvalid = dut.s_axil_wdata = dut.s_axil_wstrb = dut.s_axil_bready = 0;
    dut.s_axil_arvalid = dut.s_axil_araddr = dut.s_axil_rready = 0;
    dut.s_axi_awvalid = dut.s_axi_awid = dut.s_axi_awaddr = dut.s_axi_awlen = dut.s_axi_awsize = dut.s_axi_awburst = 0;
    dut.s_axi_wvalid = dut.s_axi_wdata = dut.s_axi_wstrb = dut.s_axi_wlast = dut.s_axi_bready = 0;
    dut.s_axi_arvalid = dut.s_axi_arid = dut.s_axi_araddr = dut.s_axi_arlen = dut.s_axi_arsize = dut.s_axi_arburst = dut.s_axi_rready = 0;
    for (int i = 0; i < RESET_CLOCKS; ++i) clock();
    dut.aresetn = 1;
    require(orbsoc_pl_open(&pl, REGISTERS, MEMORIES, ORBSOC_PL_BUFFERS));
    segments.clear();  // what random bits ran before the reset
    violations.fill(0);
  }

  // ---- what a session asks of a computer (session.hpp) ----

  void reset() {
    require(orbsoc_pl_reset(&pl));
    violations.fill(0);
  }
  void load_line(uint64_t address, const std::string &word) {
    require(orbsoc_pl_load_line(&pl, uint32_t(address), pieces(word, Built::CODE_WIDTH).data()));
  }
  void load_template(uint64_t number, const std::string &word) {
    require(orbsoc_pl_load_template(&pl, uint32_t(number), uint32_t(std::stoul(word, nullptr, 16))));
  }
  void write_word(uint64_t address, uint64_t word) {
    const uint32_t at = uint32_t(address);
    require(orbsoc_pl_set_words(&pl, &at, &word, 1));
  }
  uint64_t read_word(uint64_t address) {
    const uint32_t at = uint32_t(address);
    uint64_t word = 0;
    require(orbsoc_pl_get_words(&pl, &at, &word, 1));
    return word;
  }
  void write_register(uint16_t address, uint32_t value) { orbsoc_pl_write(REGISTERS + address, value); }
  uint32_t read_register(uint16_t address) { return orbsoc_pl_read(REGISTERS + address); }
  bool interrupt() const { return dut.irq; }
  uint32_t identity() { return orbsoc_pl_read(REGISTERS + ORBSOC_REG_IDENTITY); }
  uint32_t counted() const { return dut.axi_engine->cycles; }
  void set_gaps(uint32_t, uint32_t) { throw std::runtime_error("no fetch gaps behind AXI"); }

  void clock() {
    dut.aclk = 0;
    if (Built::STREAM) stream.drive(dut, Built::STREAM, Built::BEAT / 8);
    dut.eval();
    if (dut.aresetn) look();
    if (Built::STREAM && dut.aresetn) stream.see(dut, Built::STREAM, Built::BEAT / 8);
    const auto &inside = *dut.axi_engine;
    for (int i = 0; i < RULE_COUNT; ++i) violations[std::size_t(i)] += inside.violations >> i & 1;
    if (was_busy && !inside.busy) segments.push_back({uint32_t(inside.running), uint32_t(inside.cycles)});
    was_busy = inside.busy;
    dut.aclk = 1;
    dut.eval();
    ++clocks;
  }

  std::array<uint64_t, RULE_COUNT> violations{};
  uint64_t clocks = 0;
  std::vector<std::array<uint32_t, 2>> segments;
  orbsoc_pl pl{};
  StreamMemory stream;

  // Streamed microcode, as the bus has it.
  void place(const void *data, std::size_t bytes) { stream_data = data, stream_address = stream.place(data, bytes); }
  uint32_t placed(const void *data) {
    if (data != stream_data) die("streamed microcode that is not where the bus has it");
    return stream_address;
  }

  // ---- transactions ----

  struct Answer {
    uint32_t response;
    uint64_t data;
  };

  void lite_write(uint16_t address, uint32_t value) {
    dut.s_axil_awaddr = address;
    dut.s_axil_wdata = value;
    dut.s_axil_wstrb = 15;
    send(dut.s_axil_awvalid, dut.s_axil_awready, dut.s_axil_wvalid, dut.s_axil_wready);
    if (receive(dut.s_axil_bready, dut.s_axil_bvalid, [this] { return dut.s_axil_bresp; })) die("a register write was refused");
  }
  uint32_t lite_read(uint16_t address) {
    dut.s_axil_araddr = address;
    send(dut.s_axil_arvalid, dut.s_axil_arready);
    uint32_t word = 0;
    if (receive(dut.s_axil_rready, dut.s_axil_rvalid, [&] { word = dut.s_axil_rdata; return dut.s_axil_rresp; })) die("a register read was refused");
    return word;
  }

  // One burst of beats of 2^size bytes; the response, or the first that is not OKAY.
  uint32_t write_burst(uint64_t address, uint32_t size, const std::vector<uint64_t> &beats) {
    dut.s_axi_awid = take_id();
    dut.s_axi_awaddr = IData(address);
    dut.s_axi_awlen = CData(beats.size() - 1);
    dut.s_axi_awsize = CData(size);
    dut.s_axi_awburst = 1;
    bool addressed = false;
    std::size_t sent = 0;
    uint32_t address_waits = wait(), data_waits = wait();
    while (!addressed || sent < beats.size()) {
      dut.s_axi_awvalid = !addressed && address_waits == 0;
      dut.s_axi_wvalid = sent < beats.size() && data_waits == 0;
      if (dut.s_axi_wvalid) {
        dut.s_axi_wdata = beats[sent];
        dut.s_axi_wstrb = size == 3 ? 0xff : (address / 4 + sent) % 2 ? 0xf0 : 0x0f;
        dut.s_axi_wlast = sent + 1 == beats.size();
      }
      const bool address_goes = dut.s_axi_awvalid && dut.s_axi_awready, data_goes = dut.s_axi_wvalid && dut.s_axi_wready;
      clock_of_transaction();
      addressed |= address_goes;
      address_waits -= address_waits > 0;
      data_waits -= data_waits > 0;
      if (data_goes) {
        ++sent;
        data_waits = wait();
      }
    }
    dut.s_axi_awvalid = dut.s_axi_wvalid = 0;
    return receive(dut.s_axi_bready, dut.s_axi_bvalid, [this] { return dut.s_axi_bresp; });
  }
  uint32_t read_burst(uint64_t address, uint32_t size, std::size_t count, std::vector<uint64_t> &beats) {
    dut.s_axi_arid = take_id();
    dut.s_axi_araddr = IData(address);
    dut.s_axi_arlen = CData(count - 1);
    dut.s_axi_arsize = CData(size);
    dut.s_axi_arburst = 1;
    send(dut.s_axi_arvalid, dut.s_axi_arready);
    uint32_t response = 0;
    for (std::size_t i = 0; i < count; ++i)
      response |= receive(dut.s_axi_rready, dut.s_axi_rvalid, [&] { beats.push_back(dut.s_axi_rdata); return dut.s_axi_rresp; });
    return response;
  }

  // Hexadecimal digits in words of 32 bits, the low one first.
  static std::vector<uint32_t> pieces(const std::string &hex, uint32_t width) {
    std::vector<uint32_t> words(ORBSOC_PIECES(width));
    for (std::size_t i = 0; i < words.size(); ++i) {
      const std::size_t end = hex.size() > 8 * i ? hex.size() - 8 * i : 0, begin = end > 8 ? end - 8 : 0;
      words[i] = end ? uint32_t(std::stoul(hex.substr(begin, end - begin), nullptr, 16)) : 0;
    }
    return words;
  }

  static void require(orbsoc_pl_error found) {
    if (found != ORBSOC_PL_OK) throw std::runtime_error("the driver reports error " + std::to_string(found));
  }
  [[noreturn]] void die(const std::string &what) {
    std::fprintf(stderr, "axi_engine: %s, clock %llu\n", what.c_str(), static_cast<unsigned long long>(clocks));
    std::exit(3);
  }
  void eager(bool always) { never_waits = always; }

 private:
  static constexpr uint64_t PATIENCE = 1000;
  static constexpr int RESET_CLOCKS = 2;

  uint32_t random() {
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state;
  }
  uint32_t wait() { return never_waits || random() % 2 ? 0 : random() % 4; }
  uint8_t take_id() { return id = (id + 1) % 16; }

  void clock_of_transaction() {
    clock();
    if (clocks > since + PATIENCE) die("a transaction without an end");
  }
  // VALID until READY on one channel, or on two that do not wait for each other.
  void send(CData &valid, const CData &ready) {
    CData none = 0;
    const CData always = 1;
    send(valid, ready, none, always);
  }
  void send(CData &valid_1, const CData &ready_1, CData &valid_2, const CData &ready_2) {
    since = clocks;
    bool done_1 = false, done_2 = false;
    for (uint32_t waits_1 = wait(), waits_2 = wait(); !done_1 || !done_2; waits_1 -= waits_1 > 0, waits_2 -= waits_2 > 0) {
      valid_1 = !done_1 && waits_1 == 0;
      valid_2 = !done_2 && waits_2 == 0;
      const bool goes_1 = valid_1 && ready_1, goes_2 = valid_2 && ready_2;
      clock_of_transaction();
      done_1 |= goes_1;
      done_2 |= goes_2;
    }
    valid_1 = valid_2 = 0;
  }
  template <class Take> uint32_t receive(CData &ready, const CData &valid, Take take) {
    since = clocks;
    uint32_t response = 0;
    bool done = false;
    for (uint32_t waits = wait(); !done; waits -= waits > 0) {
      ready = waits == 0;
      done = ready && valid;
      if (done) response = take();
      clock_of_transaction();
    }
    ready = 0;
    return response;
  }

  void look() {
    lite.see({bool(dut.s_axil_awvalid), bool(dut.s_axil_awready), bool(dut.s_axil_wvalid), bool(dut.s_axil_wready), true,
              bool(dut.s_axil_bvalid), bool(dut.s_axil_bready), bool(dut.s_axil_arvalid), bool(dut.s_axil_arready),
              bool(dut.s_axil_rvalid), bool(dut.s_axil_rready), true, 0, 0, 0, 0, dut.s_axil_bresp, 0, dut.s_axil_rresp,
              dut.s_axil_rdata},
             clocks);
    burst.see({bool(dut.s_axi_awvalid), bool(dut.s_axi_awready), bool(dut.s_axi_wvalid), bool(dut.s_axi_wready),
               bool(dut.s_axi_wlast), bool(dut.s_axi_bvalid), bool(dut.s_axi_bready), bool(dut.s_axi_arvalid),
               bool(dut.s_axi_arready), bool(dut.s_axi_rvalid), bool(dut.s_axi_rready), bool(dut.s_axi_rlast), dut.s_axi_awid,
               dut.s_axi_arid, dut.s_axi_arlen, dut.s_axi_bid, dut.s_axi_bresp, dut.s_axi_rid, dut.s_axi_rresp, dut.s_axi_rdata},
              clocks);
    for (const auto *found : {&lite.faults, &burst.faults})
      if (!found->empty()) die(found->front());
  }

  Vaxi_engine dut;
  const void *stream_data = nullptr;
  uint32_t stream_address = 0;
  Monitor lite{"AXI4-Lite"}, burst{"AXI4"};
  uint64_t since = 0;
  uint32_t state = 1;
  uint8_t id = 0;
  bool was_busy = false, never_waits = false;
};
