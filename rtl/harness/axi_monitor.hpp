// The rules of AXI for a slave's channels, looked at in every clock: VALID stays up, with its payload, until READY; one B
// for each burst of which address and last beat have been taken, with its ID; as many R as the burst has beats, with its ID,
// and RLAST with the last of them. AXI4-Lite is the same with bursts of one beat.
#pragma once
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

// One clock of a port, before its rising edge.
struct Port {
  bool awvalid, awready, wvalid, wready, wlast, bvalid, bready, arvalid, arready, rvalid, rready, rlast;
  uint32_t awid, arid, arlen, bid, bresp, rid, rresp;
  uint64_t rdata;
};

class Monitor {
 public:
  explicit Monitor(std::string port) : name(std::move(port)) {}

  void see(const Port &now, uint64_t clock) {
    if (b_waits && !(now.bvalid && now.bid == last.bid && now.bresp == last.bresp)) fault("B changed or fell before BREADY", clock);
    if (r_waits && !(now.rvalid && now.rid == last.rid && now.rresp == last.rresp && now.rdata == last.rdata && now.rlast == last.rlast))
      fault("R changed or fell before RREADY", clock);
    if (now.bvalid) {
      if (addresses.empty() || bursts == 0) fault("B before the burst's address and last beat", clock);
      else if (now.bid != addresses.front()) fault("B with another burst's ID", clock);
      if ((now.bresp & 1) != 0) fault("BRESP is neither OKAY nor SLVERR", clock);
    }
    if (now.rvalid) {
      if (reads.empty()) fault("R without a burst", clock);
      else {
        if (now.rid != reads.front().id) fault("R with another burst's ID", clock);
        if (now.rlast != (reads.front().beats == 1)) fault("RLAST at the wrong beat", clock);
      }
      if ((now.rresp & 1) != 0) fault("RRESP is neither OKAY nor SLVERR", clock);
    }
    if (now.bvalid && now.bready && !addresses.empty() && bursts > 0) {
      addresses.pop_front();
      --bursts;
    }
    if (now.rvalid && now.rready && !reads.empty() && --reads.front().beats == 0) reads.pop_front();
    // Taken in this clock: an answer may come in the next one at the earliest.
    if (now.awvalid && now.awready) addresses.push_back(now.awid);
    if (now.wvalid && now.wready && now.wlast) ++bursts;
    if (now.arvalid && now.arready) reads.push_back({now.arid, now.arlen + 1});
    b_waits = now.bvalid && !now.bready;
    r_waits = now.rvalid && !now.rready;
    last = now;
  }

  // Nothing is owed.
  bool at_rest() const { return addresses.empty() && bursts == 0 && reads.empty() && !b_waits && !r_waits; }

  std::vector<std::string> faults;

 private:
  struct Read {
    uint32_t id, beats;
  };
  void fault(const char *what, uint64_t clock) { faults.push_back(name + ": " + what + ", clock " + std::to_string(clock)); }

  std::string name;
  std::deque<uint32_t> addresses;
  std::deque<Read> reads;
  uint64_t bursts = 0;  // last beats taken, and not answered
  bool b_waits = false, r_waits = false;
  Port last{};
};
