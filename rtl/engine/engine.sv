// The PL: register file, sequencer, datapath, and their assertions. docs/pl-machine.md describes it.
// SEQUENCER: 0 flat microcode, 1 compressed, 2 in order with fetch gaps, 3 compressed, each line from outside as it is wanted. CHECKS = 0: no assertions (synthesis). PARITY: one
// bit a word of storage and a line of microcode, and a fault where one that is read is wrong.
module engine #(
    parameter int FP /*verilator public*/ = 64,
    parameter int LANES /*verilator public*/ = 4,
    parameter int DIVIDERS /*verilator public*/ = 1,
    parameter int BANKS /*verilator public*/ = 16,
    parameter int CLUSTERS /*verilator public*/ = 1,
    parameter int ADDRESS_BITS /*verilator public*/ = 14,
    parameter int CODE_BITS /*verilator public*/ = 17,
    parameter int SEQUENCER /*verilator public*/ = 0,
    parameter int CHECKS = 1,
    parameter int RESIDENT /*verilator public*/ = 0,
    parameter int PARITY /*verilator public*/ = 0,
    parameter int ROWS = 0,  // of a bank of storage; 0: as many as an address tells apart
    parameter int DEPTH /*verilator public*/ = ROWS == 0 ? (1 << ADDRESS_BITS) / BANKS : ROWS,
    parameter int INSTRUCTIONS = 128,
    parameter int W = FP,
    parameter int WIDTH = 1 + LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2),
    parameter int ITEM_LINES = (2 + LANES * (4 * ADDRESS_BITS + 8) + DIVIDERS * (3 * ADDRESS_BITS + 2) + 95) / 96,
    parameter int FETCH = 32 << $clog2(ITEM_LINES > LANES ? ITEM_LINES : LANES),
    parameter int CODE_WIDTH /*verilator public*/ = SEQUENCER == 1 || SEQUENCER == 3 ? FETCH : WIDTH,
    parameter int TEMPLATES /*verilator public*/ = 1 << contract::TEMPLATE_BITS,
    parameter int TEMPLATE_WIDTH /*verilator public*/ = contract::TEMPLATE_WIDTH,
    parameter int RULES /*verilator public*/ = 8
) (
    input logic clock,
    input logic reset,
    // Registers.
    input logic bus_write,
    input logic bus_read,
    input logic [15:0] bus_address,
    input logic [31:0] bus_value,
    output logic [31:0] bus_answer,
    output logic irq,
    // Storage, while the engine is idle; read latency READ_CYCLES + 1 cycles.
    input logic host_write,
    input logic host_read,
    input logic [ADDRESS_BITS-1:0] host_address,
    input logic [W-1:0] host_word,
    output logic [W-1:0] host_value,
    // Microcode memory and templates (compressed), while the engine is idle, and whether fetch delivers (in order). SEQUENCER 3
    // has no such memory: `code_word` is the segment's next line if `code_write`, and `fetch_wanted` takes it.
    input logic code_write,
    input logic [CODE_BITS-1:0] code_address,
    input logic [CODE_WIDTH-1:0] code_word,
    input logic template_write,
    input logic [contract::TEMPLATE_BITS-1:0] template_address,
    input logic [TEMPLATE_WIDTH-1:0] template_word,
    input logic fetch_valid,
    output logic fetch_wanted,
    // Busy, its cycles in this or the last segment, and the rules violated in this cycle.
    output logic busy,
    output logic [31:0] cycles,
    output logic [7:0] running,  // the segment of these cycles
    output logic [RULES-1:0] violations
);
  localparam int EXP = FP == 64 ? 11 : 8;
  localparam int MAN = FP == 64 ? 52 : 23;
  localparam int ADD = FP == 64 ? contract::F64_ADD_CYCLES : contract::F32_ADD_CYCLES;
  localparam int MUL = FP == 64 ? contract::F64_MUL_CYCLES : contract::F32_MUL_CYCLES;
  localparam int DIV = FP == 64 ? contract::F64_DIV_CYCLES : contract::F32_DIV_CYCLES;
  localparam int SQRT = FP == 64 ? contract::F64_SQRT_CYCLES : contract::F32_SQRT_CYCLES;
  localparam int INTERVAL = FP == 64 ? contract::F64_DIV_INTERVAL_CYCLES : contract::F32_DIV_INTERVAL_CYCLES;
  localparam int SQRT_INTERVAL = FP == 64 ? contract::F64_SQRT_INTERVAL_CYCLES : contract::F32_SQRT_INTERVAL_CYCLES;
  localparam int UNITS = LANES + DIVIDERS;
  localparam int FLIGHTS = LANES * (contract::READ_CYCLES + MUL + ADD) + DIVIDERS * (contract::READ_CYCLES + DIV);

  // The pipeline has these latencies; other parameters are refused.
  generate
    if (LANES % CLUSTERS != 0 || BANKS < 2 * CLUSTERS || (CLUSTERS > 1 && SEQUENCER == 2)) begin : g_clusters_refused
      $error("clusters have equal numbers of lanes, two banks or more, and no in-order sequencer");
    end
    if (contract::READ_CYCLES != 4 || contract::WRITE_CYCLES != 1 || contract::STARTUP_CYCLES != 3 ||
        contract::FINISH_CYCLES != 1 || contract::DECODE_CYCLES != 11 || contract::HEADERS_AHEAD != 4 || SQRT != DIV || SQRT_INTERVAL != INTERVAL) begin : g_refused
      $error("engine.svh or latency.svh names a latency that this engine does not have");
    end
  endgenerate

  logic start, empty, enable, was_busy, ended;
  logic [CODE_BITS-1:0] start_address;
  localparam int ISSUED = WIDTH + (PARITY != 0 ? 1 : 0);
  logic [ISSUED-1:0] word;  // with PARITY its highest bit says that a line was wrong
  logic wrong_word, wrong_parity;
  logic program_write, launch, stop, halt, run, finished, flag_read;
  logic [$clog2(INSTRUCTIONS):0] program_address;
  logic [$clog2(INSTRUCTIONS)-1:0] entry;
  logic [7:0] run_segment;
  logic [ADDRESS_BITS-1:0] flag_address;
  registers #(
      .CODE_BITS(CODE_BITS),
      .RESIDENT(RESIDENT),
      .INSTRUCTIONS(INSTRUCTIONS)
  ) control (
      .clock(clock),
      .reset(reset),
      .write(bus_write),
      .read(bus_read),
      .address(bus_address),
      .value(bus_value),
      .answer(bus_answer),
      .irq(irq),
      .start(start),
      .start_address(start_address),
      .ended(ended),
      .wrong_parity(wrong_parity),
      .program_write(program_write),
      .program_address(program_address),
      .launch(launch),
      .entry(entry),
      .stop(stop),
      .halt(halt),
      .run(run),
      .run_segment(run_segment),
      .finished(finished),
      .running(running)
  );

  // Resident control, which reads its flags where the PS reads the storage.
  generate
    if (RESIDENT != 0) begin : g_resident
      attempt #(
          .INSTRUCTIONS(INSTRUCTIONS),
          .ADDRESS_BITS(ADDRESS_BITS),
          .W(W)
      ) sequencer (
          .clock(clock),
          .reset(reset),
          .program_write(program_write),
          .program_address(program_address),
          .program_word(bus_value),
          .launch(launch),
          .entry(entry),
          .stop(stop),
          .halt(halt),
          .ended(ended),
          .run(run),
          .segment(run_segment),
          .finished(finished),
          .flag_read(flag_read),
          .flag_address(flag_address),
          .flag_word(host_value)
      );
    end else begin : g_no_resident
      assign run = 1'b0;
      assign run_segment = '0;
      assign finished = 1'b0;
      assign flag_read = 1'b0;
      assign flag_address = '0;
    end
  endgenerate

  // A wrong word is noticed five cycles after its address. One that was read before a reset is noticed up to five cycles after
  // the reset began, and does not count.
  logic [5:0] since_reset;
  generate
    if (PARITY != 0) begin : g_parity
      always_ff @(posedge clock) since_reset <= reset ? '0 : {since_reset[4:0], 1'b1};
      assign wrong_parity = (wrong_word || word[ISSUED-1]) && since_reset[5];
    end else begin : g_no_parity
      assign since_reset  = '0;
      assign wrong_parity = 1'b0;
    end
  endgenerate

  logic [FLIGHTS-1:0] flight_valid;
  logic [FLIGHTS*ADDRESS_BITS-1:0] flight_address;
  generate
    if (SEQUENCER == 2) begin : g_in_order
      sequencer_in_order #(
          .ADD(ADD),
          .MUL(MUL),
          .DIV(DIV),
          .INTERVAL(INTERVAL),
          .SIMPLE(contract::SIMPLE_CYCLES),
          .LANES(LANES),
          .DIVIDERS(DIVIDERS),
          .BANKS(BANKS),
          .ADDRESS_BITS(ADDRESS_BITS),
          .FLIGHTS(FLIGHTS),
          .QUEUE_DEPTH(contract::QUEUE_DEPTH),
          .CODE_BITS(CODE_BITS),
          .PARITY(PARITY)
      ) sequencer (
          .clock(clock),
          .reset(reset),
          .code_write(code_write),
          .code_address(code_address),
          .code_word(code_word),
          .start(start),
          .start_address(start_address),
          .fetch_valid(fetch_valid),
          .flight_valid(flight_valid),
          .flight_address(flight_address),
          .empty(empty),
          .fetch_wanted(fetch_wanted),
          .busy(busy),
          .word(word)
      );
      assign enable = 1'b1;
    end else if (SEQUENCER == 1) begin : g_compressed
      logic frozen;
      sequencer_compressed #(
          .LANES(LANES),
          .DIVIDERS(DIVIDERS),
          .ADDRESS_BITS(ADDRESS_BITS),
          .SHORT(contract::SHORT_BITS),
          .TEMPLATE(contract::TEMPLATE_BITS),
          .TEMPLATE_WIDTH(TEMPLATE_WIDTH),
          .CODE_BITS(CODE_BITS),
          .FETCH(FETCH),
          .PARITY(PARITY)
      ) sequencer (
          .clock(clock),
          .reset(reset),
          .code_write(code_write),
          .code_address(code_address),
          .code_word(code_word),
          .template_write(template_write),
          .template_address(template_address),
          .template_word(template_word),
          .start(start),
          .start_address(start_address),
          .empty(empty),
          .busy(busy),
          .frozen(frozen),
          .word(word)
      );
      assign enable = !frozen;
      assign fetch_wanted = 1'b0;
    end else if (SEQUENCER == 3) begin : g_streamed
      logic frozen;
      sequencer_streamed #(
          .LANES(LANES),
          .DIVIDERS(DIVIDERS),
          .ADDRESS_BITS(ADDRESS_BITS),
          .SHORT(contract::SHORT_BITS),
          .TEMPLATE(contract::TEMPLATE_BITS),
          .TEMPLATE_WIDTH(TEMPLATE_WIDTH),
          .FETCH(FETCH),
          .PARITY(PARITY)
      ) sequencer (
          .clock(clock),
          .reset(reset),
          .line(code_word),
          .there(code_write),
          .taken(fetch_wanted),
          .template_write(template_write),
          .template_address(template_address),
          .template_word(template_word),
          .start(start),
          .empty(empty),
          .busy(busy),
          .frozen(frozen),
          .word(word)
      );
      assign enable = !frozen;
    end else begin : g_flat
      sequencer_flat #(
          .WIDTH(WIDTH),
          .CODE_BITS(CODE_BITS),
          .PARITY(PARITY)
      ) sequencer (
          .clock(clock),
          .reset(reset),
          .code_write(code_write),
          .code_address(code_address),
          .code_word(code_word),
          .start(start),
          .start_address(start_address),
          .empty(empty),
          .busy(busy),
          .word(word)
      );
      assign enable = 1'b1;
      assign fetch_wanted = 1'b0;
    end
  endgenerate

  // The end of busy, and its cycles.
  assign ended = was_busy && !busy;
  always_ff @(posedge clock) begin
    was_busy <= busy && !reset;
    if (reset) cycles <= '0;
    else if (busy) cycles <= was_busy ? cycles + 32'd1 : 32'd1;
  end

  // The PS's access to the storage, through one register.
  logic load, store;
  logic [ADDRESS_BITS-1:0] host_at;
  logic [W-1:0] host_store;
  always_ff @(posedge clock) begin
    load <= (host_read || flag_read) && !busy && !reset;
    store <= host_write && !busy && !reset;
    host_at <= flag_read ? flag_address : host_address;
    host_store <= host_word;
  end

  logic [UNITS-1:0] result_valid;
  logic [UNITS*ADDRESS_BITS-1:0] result_address;
  logic read_conflict, result_conflict, write_conflict, divider_busy;
  datapath #(
      .EXP(EXP),
      .MAN(MAN),
      .ADD(ADD),
      .MUL(MUL),
      .DIV(DIV),
      .INTERVAL(INTERVAL),
      .SIMPLE(contract::SIMPLE_CYCLES),
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .BANKS(BANKS),
      .CLUSTERS(CLUSTERS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .PARITY(PARITY),
      .ROWS(DEPTH)
  ) path (
      .clock(clock),
      .reset(reset),
      .enable(enable),
      .fields(word[WIDTH-1:1]),
      .host_read(load),
      .host_write(store),
      .host_address(host_at),
      .host_word(host_store),
      .host_value(host_value),
      .flight_valid(flight_valid),
      .flight_address(flight_address),
      .result_valid(result_valid),
      .result_address(result_address),
      .empty(empty),
      .read_conflict(read_conflict),
      .result_conflict(result_conflict),
      .write_conflict(write_conflict),
      .divider_busy(divider_busy),
      .wrong_parity(wrong_word)
  );

  generate
    if (CHECKS != 0) begin : g_checks
      checks #(
          .LANES(LANES),
          .DIVIDERS(DIVIDERS),
          .ADDRESS_BITS(ADDRESS_BITS),
          .WORDS(DEPTH * BANKS)
      ) watch (
          .clock(clock),
          .reset(reset),
          .enable(enable),
          .fields(word[WIDTH-1:1]),
          .host_write(store),
          .host_address(host_at),
          .result_valid(result_valid),
          .result_address(result_address),
          .read_conflict(read_conflict),
          .result_conflict(result_conflict),
          .write_conflict(write_conflict),
          .divider_busy(divider_busy),
          .violations(violations)
      );
    end else begin : g_no_checks
      assign violations = '0;
    end
  endgenerate
endmodule
