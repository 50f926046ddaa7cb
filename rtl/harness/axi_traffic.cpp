// Random traffic on both AXI slaves (axi_slaves.sv), with back-pressure on every channel, against plain models of engine and
// memories: axi_slaves SEED CLOCKS [+NAME]. Prints a count a line of what was done, and what was wrong; exits 0 if nothing was.
// axi_slaves timing: clocks of bursts of 16 beats on which no side waits, from the address to the answer, both included, and the
// digest of each that writes microcode.
//   Each register access reaches the bus once, in order, before it is answered, with its data.
//   A burst that is not refused writes its words once, in order, and nothing else; reads see what was answered before.
//   A burst that meets the engine idle all the time is taken, one that meets it running is refused without effect.
//   While a register read waits, few register writes go before it.
//   A launch is stopped in its first clock beyond LIMIT, and no other; SPENT counts its clocks.
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>

#include "Vaxi_slaves.h"
#include "Vaxi_slaves_axi_slaves.h"
#include "axi_model.hpp"
#include "axi_monitor.hpp"
#include "start.hpp"

namespace {

using Built = Vaxi_slaves_axi_slaves;
constexpr uint16_t RESET = ORBSOC_REG_RESET, ENGINE = ORBSOC_REG_ENGINE, SIZES = ORBSOC_REG_SIZES, CYCLES = ORBSOC_REG_CYCLES,
                   IDENTITY = ORBSOC_REG_IDENTITY, DIGEST = ORBSOC_REG_DIGEST, LIMIT = ORBSOC_REG_LIMIT, SPENT = ORBSOC_REG_SPENT;
constexpr uint32_t ENGINE_WORD = 0x01010184, SIZES_WORD = 0x12345678, IDENTITY_WORD = 0x23456789, SLVERR = 2;
constexpr uint32_t LIMIT_FAULT = ORBSOC_FAULT_CYCLE_LIMIT << ORBSOC_STATUS_FAULT_SHIFT;
constexpr uint64_t LAG = 4;       // clocks after the engine's end in which it may still count as running
constexpr uint64_t PATIENCE = 3000;  // clocks without an answer that is owed
constexpr int RESET_CLOCKS = 2;     // what the slaves want, at least
constexpr uint32_t OVERTAKING = 2;   // register writes that may go before a read: one on its way, and one in turn

struct LiteWrite {
  uint16_t address;
  uint32_t value;
  uint8_t strobes;
};

class Traffic {
 public:
  Traffic(uint32_t seed, uint64_t clocks) : random(seed), sizes(built()), engine(sizes, seed), assembly(sizes), end(clocks) {}

  bool run() {
    reset();
    const uint64_t start = now;
    while (now < start + end || owes()) {
      if (now % 512 == 0) choose_rates();
      if (now < start + end) create();
      step();
      if (now > last_answer + PATIENCE && owes()) {
        fault("no answer for " + std::to_string(PATIENCE) + " clocks");
        break;
      }
      if (faults.size() + engine.faults.size() + lite.faults.size() + burst.faults.size() > 20) break;
    }
    if (engine.writes.size() != lite_taken || engine.reads.size() != lite_read_taken) fault("accesses on the bus that nothing asked for");
    if (resets != resets_wanted) fault("resets of the engine: " + std::to_string(resets) + " for " + std::to_string(resets_wanted));
    for (const auto *list : {&faults, &engine.faults, &lite.faults, &burst.faults})
      for (const auto &line : *list) std::printf("fault %s\n", line.c_str());
    for (const auto &[what, count] : done) std::printf("%s %" PRIu64 "\n", what.c_str(), count);
    return faults.empty() && engine.faults.empty() && lite.faults.empty() && burst.faults.empty();
  }

  bool timing() {
    reset();
    for (double &rate : offer) rate = 1.0;
    for (double &rate : take) rate = 1.0;
    const struct { const char *what; uint32_t memory, size; bool read; } kinds[] = {
        {"storage written by 8 bytes", STORAGE, 3, false}, {"storage written by 4 bytes", STORAGE, 2, false},
        {"microcode written by 8 bytes", CODE, 3, false}, {"microcode written by 4 bytes", CODE, 2, false},
        {"storage read by 8 bytes", STORAGE, 3, true}};
    for (const auto &kind : kinds) {
      if (kind.memory == CODE) access(DIGEST, true);
      sixteen(kind.memory, kind.size, kind.read);
      settle();
      std::printf("clocks %s %" PRIu64 "\n", kind.what, last_answer - accepted + 1);
      if (kind.memory != CODE) continue;
      access(DIGEST, false);
      std::printf("digest %s %" PRIu32 "\n", kind.what, digest);
    }
    for (int i = 0; i < 16; ++i) sixteen(STORAGE, 3, false);
    while (writes.size() > 15) step();
    const uint64_t from = now;
    sixteen(STORAGE, 3, true);
    while (!reads.empty() && !writes.empty()) step();
    std::printf("clocks storage read by 8 bytes while writes wait %" PRIu64 "\n", now - from);
    settle();
    for (const auto *list : {&faults, &engine.faults, &lite.faults, &burst.faults})
      for (const auto &line : *list) std::printf("fault %s\n", line.c_str());
    return faults.empty() && engine.faults.empty() && lite.faults.empty() && burst.faults.empty();
  }

 private:
  // A burst of 16 beats of 2^size bytes from the begin of a memory on.
  void sixteen(uint32_t memory, uint32_t size, bool read) {
    Burst b{};
    b.address = uint64_t(memory) << Built::REGION_BITS;
    b.len = 15;
    b.size = size;
    b.kind = 1;
    for (uint32_t i = 0; i < 16; ++i) {
      b.data.push_back(i);
      b.strobes.push_back(size == 3 ? 0xff : i % 2 ? 0xf0 : 0x0f);
    }
    if (read) read_address.push_back(b), reads.push_back(b);
    else write_address.push_back(b), writes.push_back(b);
    for (uint32_t i = 0; i < 16 && !read; ++i) write_data.push_back({b.data[i], b.strobes[i], i == 15});
  }
  void settle() {
    for (int i = 0; i < 2000 && owes(); ++i) step();
    if (owes()) fault("no answer");
  }
  // One register access to its end.
  void access(uint16_t address, bool write) {
    const LiteWrite w{address, 0, 15};
    if (write) lite_address.push_back(w), lite_data.push_back(w), lite_writes.push_back(w);
    else lite_read_address.push_back(address), lite_reads.push_back(address);
    settle();
  }
  void reset() {
    dut.bus_answer = 0;
    drive();
    dut.reset = 1;
    dut.stream_failed = 0;  // no stream here
    dut.lite_awvalid = dut.lite_wvalid = dut.lite_arvalid = dut.awvalid = dut.wvalid = dut.arvalid = 0;
    dut.lite_bready = dut.lite_rready = dut.bready = dut.rready = 0;
    for (int i = 0; i < RESET_CLOCKS; ++i) clock_edge();
    dut.reset = 0;
  }
  static Sizes built() {
    uint64_t template_bits = 0;
    while (ORBSOC_TEMPLATES >> template_bits > 1) ++template_bits;
    return {Built::FP, Built::WORDS, Built::CODE_BITS, Built::CODE_WIDTH, template_bits, Built::TEMPLATE_WIDTH};
  }
  uint32_t draw() { return uint32_t(random()); }
  bool chance(double p) { return draw() % 10000 < p * 10000; }
  uint32_t below(uint64_t n) { return uint32_t(draw() % n); }
  void fault(const std::string &what) { faults.push_back(what + ", clock " + std::to_string(now)); }

  // How eager each side of each channel is, for a while.
  void choose_rates() {
    const double rates[] = {1.0, 0.9, 0.5, 0.2, 0.05};
    for (double &rate : offer) rate = rates[below(5)];
    for (double &rate : take) rate = rates[below(5)];
    create_rate = rates[below(5)] * 0.3;
    launch_rate = below(2) ? 0.15 : 0.02;
  }

  // ---- what masters want ----

  void create() {
    if (lite_address.size() + lite_data.size() < 6 && chance(create_rate)) {
      LiteWrite w{uint16_t(below(0x2000) & (below(4) ? ~3u : ~0u)), draw(), 15};
      if (chance(launch_rate)) w = {ORBSOC_REG_CONTROL, 1, 15};
      else if (chance(0.06)) w = {chance(0.2) ? DIGEST : RESET, draw(), 15};
      else if (chance(0.06)) w = {LIMIT, below(3) ? 5 + below(100) : 0, 15};
      if (chance(0.1)) w.strobes = uint8_t(below(15));
      lite_address.push_back(w);
      lite_data.push_back(w);
      lite_writes.push_back(w);
    }
    if (lite_reads.size() < 3 && chance(create_rate)) {
      const uint16_t places[] = {ORBSOC_REG_STATUS, ORBSOC_REG_STATUS, ENGINE, SIZES, CYCLES, IDENTITY, DIGEST, LIMIT, SPENT, uint16_t(below(0x10000))};
      lite_read_address.push_back(places[below(10)]);
      lite_reads.push_back(lite_read_address.back());
    }
    if (writes.size() < 4 && chance(create_rate)) {
      for (const Burst &b : make_writes()) {
        write_address.push_back(b);
        for (uint32_t i = 0; i <= b.len; ++i) write_data.push_back({b.data[i], b.strobes[i], i == b.len});
        writes.push_back(b);
      }
    }
    if (reads.size() < 3 && chance(create_rate)) {
      read_address.push_back(make_burst(true));
      reads.push_back(read_address.back());
    }
  }

  Burst make_burst(bool read) {
    const uint32_t memory = chance(read ? 0.9 : 0.6) ? STORAGE : below(4) ? CODE : TEMPLATES;
    const uint64_t bytes = sizes.bytes(memory);
    Burst b{};
    b.id = below(uint64_t(1) << Built::ID_BITS);
    b.kind = 1;
    b.size = 2 + below(2);
    const uint64_t places = bytes / b.bytes();
    uint64_t at = below(places);
    if (b.size == 2 && !chance(0.1)) at -= at * b.bytes() % sizes.stride(memory) / b.bytes();  // mostly the begin of a word
    if (b.size == 3 && sizes.stride(memory) > 8 && !chance(0.1)) at -= at * 8 % sizes.stride(memory) / 8;
    b.len = chance(0.1) ? below(places - at) : below(std::min<uint64_t>(places - at, 12));
    b.address = uint64_t(memory) << Built::REGION_BITS | at * b.bytes();
    if (chance(0.12)) spoil(b, bytes);
    return b;
  }
  // Something that is refused.
  void spoil(Burst &b, uint64_t bytes) {
    switch (below(5)) {
      case 0: b.kind = below(2) ? 2 : 0; break;
      case 1: b.size = below(2) ? below(2) : 4 + below(4); break;
      case 2: b.address += 1 + below(b.bytes() - 1); break;
      case 3: b.address += bytes - below(std::min<uint64_t>(bytes, 4)) * b.bytes(); break;
      default: b.address |= uint64_t(3) << Built::REGION_BITS; break;
    }
    ++done["spoilt bursts"];
  }

  std::vector<Burst> make_writes() {
    Burst b = make_burst(false);
    for (uint32_t i = 0; i <= b.len; ++i) {
      b.data.push_back(uint64_t(draw()) << 32 | draw());
      b.strobes.push_back(b.size == 2 ? ((b.address / 4 + i) % 2 ? 0xf0 : 0x0f) : 0xff);
    }
    if (b.len && b.size == 2 && b.kind == 1 && chance(0.4)) {  // in two bursts, a word begun in the first ended in the second
      Burst rest = b;
      const uint32_t first = 1 + below(b.len);
      rest.address += 4 * first;
      if (chance(0.3)) rest.address ^= sizes.stride(uint32_t(b.address >> Built::REGION_BITS));  // another word's: an error
      rest.len = b.len - first;
      rest.data.erase(rest.data.begin(), rest.data.begin() + first);
      rest.strobes.erase(rest.strobes.begin(), rest.strobes.begin() + first);
      b.len = first - 1;
      b.data.resize(first);
      b.strobes.resize(first);
      std::vector<Burst> all{b, rest};  // the rest again, perhaps after a run: it completes no word that began before
      if (chance(0.7)) all.insert(all.end(), 1 + below(4), rest);
      return all;
    }
    if (chance(0.08)) b.strobes[below(b.strobes.size())] &= 0xf0;
    if (chance(0.04)) b.strobes[below(b.strobes.size())] = uint8_t(draw());
    return {b};
  }

  // ---- one clock ----

  template <class Queue> bool offered(Queue &queue, std::size_t channel) {
    if (!valid[channel] && !queue.empty()) valid[channel] = chance(offer[channel]);
    return valid[channel];
  }

  void drive() {
    dut.lite_awvalid = offered(lite_address, 0);
    dut.lite_awaddr = valid[0] ? lite_address.front().address : uint16_t(draw());
    dut.lite_wvalid = offered(lite_data, 1);
    dut.lite_wdata = valid[1] ? lite_data.front().value : draw();
    dut.lite_wstrb = valid[1] ? lite_data.front().strobes : below(16);
    dut.lite_arvalid = offered(lite_read_address, 2);
    dut.lite_araddr = valid[2] ? lite_read_address.front() : uint16_t(draw());
    const bool aw = offered(write_address, 3), w = offered(write_data, 4), ar = offered(read_address, 5);
    const Burst to = aw ? write_address.front() : Burst{draw(), draw(), draw(), draw(), draw(), {}, {}};
    dut.awvalid = aw;
    dut.awid = to.id & ((1u << Built::ID_BITS) - 1);
    dut.awaddr = to.address & ((uint64_t(4) << Built::REGION_BITS) - 1);
    dut.awlen = uint8_t(to.len);
    dut.awsize = to.size & 7;
    dut.awburst = to.kind & 3;
    dut.wvalid = w;
    dut.wdata = w ? write_data.front().data : draw();
    dut.wstrb = w ? write_data.front().strobes : uint8_t(draw());
    dut.wlast = w ? write_data.front().last : below(2);
    const Burst from = ar ? read_address.front() : Burst{draw(), draw(), draw(), draw(), draw(), {}, {}};
    dut.arvalid = ar;
    dut.arid = from.id & ((1u << Built::ID_BITS) - 1);
    dut.araddr = from.address & ((uint64_t(4) << Built::REGION_BITS) - 1);
    dut.arlen = uint8_t(from.len);
    dut.arsize = from.size & 7;
    dut.arburst = from.kind & 3;
    dut.lite_bready = chance(take[0]);
    dut.lite_rready = chance(take[1]);
    dut.bready = chance(take[2]);
    dut.rready = chance(take[3]);
    dut.irq = engine.irq(now);
    dut.busy = engine.busy(now);
    dut.cycles = uint32_t(now);
    dut.host_value = engine.host_value(now);
  }

  void step() {
    drive();
    dut.clock = 0;
    dut.eval();
    dut.bus_answer = engine.answer(dut.bus_address, now);
    dut.eval();
    for (const LiteWrite &w : lite_writes)
      if (w.address == LIMIT) limit_changed_at = now;
    watch_engine();
    running_at[now] = engine.running(now);
    lite.see({bool(dut.lite_awvalid), bool(dut.lite_awready), bool(dut.lite_wvalid), bool(dut.lite_wready), true,
              bool(dut.lite_bvalid), bool(dut.lite_bready), bool(dut.lite_arvalid), bool(dut.lite_arready),
              bool(dut.lite_rvalid), bool(dut.lite_rready), true, 0, 0, 0, 0, dut.lite_bresp, 0, dut.lite_rresp, dut.lite_rdata},
             now);
    burst.see({bool(dut.awvalid), bool(dut.awready), bool(dut.wvalid), bool(dut.wready), bool(dut.wlast), bool(dut.bvalid),
               bool(dut.bready), bool(dut.arvalid), bool(dut.arready), bool(dut.rvalid), bool(dut.rready), bool(dut.rlast),
               dut.awid, dut.arid, dut.arlen, dut.bid, dut.bresp, dut.rid, dut.rresp, dut.rdata},
              now);
    lite_channels();
    burst_channels();
    clock_edge();
  }
  void clock_edge() {
    dut.clock = 0;
    dut.eval();
    dut.clock = 1;
    dut.eval();
    engine.end_of_clock(now);
    ++now;
  }

  void watch_engine() {
    const bool any = dut.bus_write || dut.bus_read || dut.host_write || dut.host_read || dut.code_write || dut.template_write;
    if (dut.engine_reset && any) fault("an access while the engine is reset");
    const uint32_t busy_before = busy_clocks;
    busy_clocks = engine.status_busy(now) && !dut.engine_reset ? busy_clocks + 1 : 0;
    if (busy_clocks == 1) launched_at = now;
    spent_at[now] = spent;
    if (busy_clocks) spent = busy_clocks;
    const bool sure = limit_changed_at < launched_at;
    if (limit && sure && busy_clocks > limit + 1) fault("a launch goes on beyond its limit");
    if (dut.engine_reset && !was_reset) {
      stopped_after = busy_before;
      engine.reset(now);
      stopped = false;
    }
    if (dut.bus_read && dut.bus_address == LIMIT) {
      if (sure && (limit == 0 || stopped_after != limit + 1)) fault("a launch stopped after " + std::to_string(stopped_after) + " clocks");
      ++resets_wanted;
      ++done["launches stopped by their limit"];
      stopped = true;
      engine.fault_of_access();
    }
    if (dut.engine_reset && !was_reset && now > 110) ++resets;
    if (was_reset && !dut.engine_reset && now - reset_since < 2) fault("a reset of one clock");
    if (dut.engine_reset && !was_reset) reset_since = now;
    was_reset = dut.engine_reset;
    if (dut.bus_write && dut.bus_read) fault("a read and a write on the bus at once");
    if (dut.host_write && dut.host_read) fault("a read and a write of storage at once");
    if (dut.bus_write) engine.bus_write(dut.bus_address, dut.bus_value, now);
    if (lite_asked.empty() || dut.lite_rvalid) overtaken = 0;
    else if (dut.bus_write && ++overtaken > OVERTAKING) fault("register writes before a read that waits");
    if (dut.bus_read && dut.bus_address != LIMIT)
      engine.bus_read(dut.bus_address, stopped && dut.bus_address == ORBSOC_REG_STATUS ? (dut.bus_answer & ~ORBSOC_STATUS_FAULT_MASK) | LIMIT_FAULT : dut.bus_answer, now);
    if (dut.host_write) {
      engine.host_write(dut.host_address, dut.host_word, now);
      commit(STORAGE, dut.host_address, dut.host_word);
    }
    if (dut.host_read) engine.host_read(dut.host_address, now);
    if (dut.code_write) {
      engine.other_write(now);
      commit(CODE, dut.code_address, dut.code_word);
    }
    if (dut.template_write) {
      engine.other_write(now);
      commit(TEMPLATES, dut.template_address, dut.template_word);
    }
  }
  void commit(uint32_t memory, uint64_t address, uint64_t word) {
    Pieces pieces;
    for (uint64_t i = 0; i < sizes.pieces(memory); ++i) pieces.push_back(uint32_t(word >> 32 * i));
    commits.emplace_back(memory, address, pieces);
  }
  template <std::size_t N> void commit(uint32_t memory, uint64_t address, const VlWide<N> &word) {
    Pieces pieces;
    for (uint64_t i = 0; i < sizes.pieces(memory); ++i) pieces.push_back(word[i]);
    commits.emplace_back(memory, address, pieces);
  }

  void answered(const char *what) {
    ++done[what];
    last_answer = now;
  }

  void lite_channels() {
    if (dut.lite_awvalid && dut.lite_awready) pop(lite_address, 0);
    if (dut.lite_wvalid && dut.lite_wready) pop(lite_data, 1);
    if (dut.lite_arvalid && dut.lite_arready) {
      lite_asked.push_back(now);
      pop(lite_read_address, 2);
    }
    if (dut.lite_bvalid && dut.lite_bready && !lite_writes.empty()) {
      const LiteWrite w = lite_writes.front();
      lite_writes.pop_front();
      const bool whole = w.strobes == 15, forwarded = whole && w.address != RESET && w.address != DIGEST && w.address != LIMIT;
      if (whole && w.address == LIMIT) limit = w.value;
      if ((dut.lite_bresp == SLVERR) == whole) fault("a register write's response");
      if (whole && w.address == RESET && (w.value & 1)) ++resets_wanted;
      if (forwarded) {
        if (engine.writes.size() != lite_taken + 1) fault("a register write that reached the bus other than once");
        else if (std::get<0>(engine.writes.back()) != w.address || std::get<1>(engine.writes.back()) != w.value)
          fault("another register write on the bus than was asked for");
        ++lite_taken;
      } else if (engine.writes.size() != lite_taken) {
        fault("a register write on the bus that must not be there");
      }
      answered(!whole ? "register writes with strobes missing" : forwarded ? "register writes" : w.address == RESET ? "writes to RESET" : w.address == LIMIT ? "writes to LIMIT" : "writes to DIGEST");
    }
    if (dut.lite_rvalid && dut.lite_rready && !lite_reads.empty() && !lite_asked.empty()) {
      const uint16_t address = lite_reads.front();
      const uint64_t asked = lite_asked.front();
      lite_reads.pop_front();
      lite_asked.pop_front();
      if (dut.lite_rresp != 0) fault("a register read's response");
      const bool own = address == ENGINE || address == SIZES || address == CYCLES || address == IDENTITY || address == DIGEST || address == LIMIT || address == SPENT;
      if (own) {
        const uint32_t word = address == ENGINE ? ENGINE_WORD : address == SIZES ? SIZES_WORD : IDENTITY_WORD;
        if (address == DIGEST) digest = dut.lite_rdata;
        else if (address == LIMIT) limit_read(dut.lite_rdata, asked);
        else if (address == SPENT) spent_read(dut.lite_rdata, asked);
        else if (address == CYCLES ? dut.lite_rdata < asked || dut.lite_rdata > now : dut.lite_rdata != word) fault("a wrapper's register");
      } else if (engine.reads.size() != lite_read_taken + 1) {
        fault("a register read that reached the bus other than once");
      } else {
        const auto &[where, value, when] = engine.reads[lite_read_taken++];
        if (where != address || value != dut.lite_rdata || when < asked) fault("a register read's address or data");
      }
      answered(own ? "reads of the wrapper's registers" : "register reads");
    }
  }

  template <class Queue> void pop(Queue &queue, std::size_t channel) {
    queue.pop_front();
    valid[channel] = false;
  }

  void limit_read(uint32_t value, uint64_t asked) {
    if (limit_changed_at < asked && value != limit) fault("LIMIT");
  }
  void spent_read(uint32_t value, uint64_t asked) {
    for (auto at = spent_at.lower_bound(asked); at != spent_at.end(); ++at)
      if (at->second == value) return;
    fault("SPENT");
  }

  // Whether the engine ran at some, or at all clocks from one on.
  bool ran(uint64_t from, bool all) const {
    for (auto at = running_at.lower_bound(from); at != running_at.end(); ++at)
      if (at->second != all) return !all;
    return all;
  }

  void burst_channels() {
    if (dut.awvalid && dut.awready) {
      write_since.push_back(accepted = now);
      pop(write_address, 3);
    }
    if (dut.wvalid && dut.wready) pop(write_data, 4);
    if (dut.arvalid && dut.arready) {
      read_since.push_back(accepted = now);
      pop(read_address, 5);
      beat = 0;
    }
    if (dut.bvalid && dut.bready && !writes.empty() && !write_since.empty()) end_of_write();
    if (dut.rvalid && dut.rready && !reads.empty() && !read_since.empty()) beat_of_read();
  }

  void end_of_write() {
    const Burst b = writes.front();
    const uint64_t since = write_since.front();
    writes.pop_front();
    write_since.pop_front();
    const bool error = dut.bresp == SLVERR, may_run = ran(since - LAG, false);
    std::vector<Commit> wanted, found;
    for (auto &one : commits) found.emplace_back(std::get<0>(one), std::get<1>(one), cut(std::get<2>(one), sizes.width(std::get<0>(one))));
    commits.clear();
    if (assembly.refused(b, Built::REGION_BITS)) {
      if (!error || !found.empty()) fault("a burst that must be refused");
      answered("refused write bursts");
      return;
    }
    const bool clean = assembly.write(b, Built::REGION_BITS, wanted);
    const bool whole = found == wanted;
    const bool begun = found.size() <= wanted.size() && std::equal(found.begin(), found.end(), wanted.begin());
    if (!begun) fault("a burst wrote other words than its own");
    if (!error && (!clean || !whole)) fault("a burst was taken that has an error, or not all of it was written");
    if (error && clean && !may_run) fault("a burst was refused although the engine was idle");
    if (error && !may_run && !whole) fault("a burst with an error did not write what is before it");
    if (error && ran(since, true) && !found.empty()) fault("a burst wrote while the engine ran");
    if (!error && ran(since, true) && !wanted.empty()) fault("a burst was taken while the engine ran");
    if (error) assembly.forget();
    answered(!error ? "write bursts" : clean ? "write bursts refused by a running engine" : "write bursts with an error within");
    for (const auto &one : found) ++done[std::get<0>(one) == STORAGE ? "words of storage written" : std::get<0>(one) == CODE ? "lines of microcode written" : "templates written"];
  }

  void beat_of_read() {
    const Burst &b = reads.front();
    const uint64_t since = read_since.front();
    const bool error = dut.rresp == SLVERR, may_run = ran(since - LAG, false);
    const bool refused = assembly.refused(b, Built::REGION_BITS) || b.address >> Built::REGION_BITS != STORAGE;
    if (error && dut.rdata != 0) fault("data in a beat with an error");
    if (refused && !error) fault("a read that must be refused");
    if (!refused && error && !may_run) fault("a read was refused although the engine was idle");
    if (!error && !refused && ran(since, true)) fault("a read was taken while the engine ran");
    if (!error && !refused) {
      const uint64_t at = (b.address & ((uint64_t(1) << Built::REGION_BITS) - 1)) + beat * b.bytes();
      for (uint64_t half = at; half < at + b.bytes(); half += sizes.fp / 8) {
        const uint64_t word = half / (sizes.fp / 8);
        const uint64_t value = sizes.fp == 64 ? dut.rdata : dut.rdata >> (half & 4) * 8 & 0xffffffff;
        if (!engine.possible(word, value, since, now)) fault("a read's word");
        ++done["words of storage read"];
      }
    }
    if (beat++ != b.len) return;
    answered(refused ? "refused read bursts" : error ? "read bursts refused by a running engine" : "read bursts");
    beat = 0;
    reads.pop_front();
    read_since.pop_front();
  }

  bool owes() const {
    return !(lite.at_rest() && burst.at_rest() && lite_writes.empty() && lite_reads.empty() && writes.empty() && reads.empty());
  }

  Vaxi_slaves dut;
  std::mt19937 random;
  Sizes sizes;
  EngineModel engine;
  Assembly assembly;
  Monitor lite{"AXI4-Lite"}, burst{"AXI4"};
  uint64_t end, now = 100, last_answer = 100, reset_since = 0, accepted = 0;
  double offer[6] = {}, take[4] = {}, create_rate = 0.1, launch_rate = 0.1;
  bool valid[6] = {}, was_reset = true;

  struct Beat {
    uint64_t data;
    uint8_t strobes;
    bool last;
  };
  std::deque<LiteWrite> lite_address, lite_data, lite_writes;  // to be offered, offered, to be answered
  std::deque<uint16_t> lite_read_address, lite_reads;
  std::deque<uint64_t> lite_asked, write_since, read_since;
  std::deque<Burst> write_address, writes, read_address, reads;
  std::deque<Beat> write_data;
  std::vector<Commit> commits;
  std::map<uint64_t, bool> running_at;
  std::map<uint64_t, uint32_t> spent_at;
  uint32_t limit = 0, spent = 0, busy_clocks = 0, stopped_after = 0;
  uint64_t limit_changed_at = 0, launched_at = 0;
  bool stopped = false;
  uint32_t beat = 0, overtaken = 0, digest = 0;
  uint64_t lite_taken = 0, lite_read_taken = 0, resets = 0, resets_wanted = 0;
  std::map<std::string, uint64_t> done;
  std::vector<std::string> faults;
};

}  // namespace

int main(int argc, char **argv) {
  begin_with_bits_of(seed_of_start());
  Verilated::commandArgs(argc, argv);  // a test's RTL may ask for a +NAME
  if (argc == 2 && std::string(argv[1]) == "timing") return Traffic(1, 0).timing() ? 0 : 1;
  if (argc < 3) {
    std::fprintf(stderr, "usage: axi_slaves SEED CLOCKS [+NAME], or axi_slaves timing\n");
    return 2;
  }
  return Traffic(uint32_t(std::atoi(argv[1])), uint64_t(std::atoll(argv[2]))).run() ? 0 : 1;
}
