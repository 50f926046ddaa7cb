// The other end of a serial line, clock by clock: eight bits, one stop bit, `clocks` clocks a bit.
#pragma once
#include <cstdint>

class Serial {
 public:
  explicit Serial(int clocks) : clocks_(clocks) {}
  // The line towards the board in this clock.
  bool out() {
    if (sending_ == 0) return true;
    const bool bit = bits_ >> (10 - (sending_ + clocks_ - 1) / clocks_) & 1;
    sending_ -= 1;
    return bit;
  }
  void send(uint8_t byte) {
    bits_ = uint32_t(byte) << 1 | 0x200;
    sending_ = 10 * clocks_;
  }
  // The line from the board in this clock; a byte where one is complete, or -1.
  int in(bool level) {
    if (at_ == 0 && level) return -1;
    at_ += 1;
    if (at_ % clocks_ == clocks_ / 2) came_ = came_ >> 1 | uint32_t(level) << 9;
    if (at_ < 9 * clocks_ + clocks_ / 2) return -1;
    at_ = 0;
    return came_ & 0x200 ? int(came_ >> 1 & 0xff) : -1;
  }

 private:
  int clocks_, sending_ = 0, at_ = 0;
  uint32_t bits_ = 0, came_ = 0;
};
