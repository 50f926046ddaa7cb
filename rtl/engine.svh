// Timing of the PL engine around its units, in cycles (docs/pl-machine.md). It is defined only here: the RTL
// includes this file, and the schedulers read it (lines `localparam int NAME = N;`). Latencies of the units: latency.svh.
localparam int SIMPLE_CYCLES = 2;   // move, neg, abs, min, max, compare, and, select
localparam int READ_CYCLES = 4;     // issue register to operand registers
localparam int WRITE_CYCLES = 1;    // result register to a bank's write register
localparam int STARTUP_CYCLES = 3;  // busy before the first word is in the issue register
localparam int DECODE_CYCLES = 11;  // compressed microcode: from a complete first header in the buffer to the issue register
localparam int HEADERS_AHEAD = 4;   // compressed microcode: payloads from a header to its own
localparam int FINISH_CYCLES = 1;   // busy after the last write
localparam int QUEUE_DEPTH = 4;     // instruction queue of the in-order sequencer
localparam int SHORT_BITS = 6;      // compressed microcode: a step
localparam int TEMPLATE_BITS = 6;   // compressed microcode: number of a template
localparam int TEMPLATE_WIDTH = 12; // compressed microcode: a template, an operation and the modes of four fields
localparam int STREAM_ROWS = 512;   // streamed microcode: parts of lines that a port holds
localparam int STREAM_BURST = 16;   // streamed microcode: beats of a burst, at most
