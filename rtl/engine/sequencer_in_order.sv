// In-order sequencer: fetch fills a queue of words, with gaps; the head is issued as soon as it has no hazard.
// Busy words are the destinations in flight; result registers, write ports and dividers are reserved in advance.
module sequencer_in_order #(
    parameter int ADD = contract::F64_ADD_CYCLES,
    parameter int MUL = contract::F64_MUL_CYCLES,
    parameter int DIV = contract::F64_DIV_CYCLES,
    parameter int INTERVAL = contract::F64_DIV_INTERVAL_CYCLES,
    parameter int SIMPLE = contract::SIMPLE_CYCLES,
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int BANKS = 16,
    parameter int ADDRESS_BITS = 14,
    parameter int FLIGHTS = LANES * (contract::READ_CYCLES + MUL + ADD) + DIVIDERS * (contract::READ_CYCLES + DIV),
    parameter int QUEUE_DEPTH = contract::QUEUE_DEPTH,
    parameter int CODE_BITS = 16,
    parameter int PARITY = 0,
    parameter int WIDTH = 1 + LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2),
    parameter int STORED = WIDTH + (PARITY != 0 ? 1 : 0)
) (
    input logic clock,
    input logic reset,
    input logic code_write,
    input logic [CODE_BITS-1:0] code_address,
    input logic [WIDTH-1:0] code_word,
    input logic start,
    input logic [CODE_BITS-1:0] start_address,
    input logic fetch_valid,
    input logic [FLIGHTS-1:0] flight_valid,
    input logic [FLIGHTS*ADDRESS_BITS-1:0] flight_address,
    input logic empty,
    output logic fetch_wanted,  // from the third busy cycle on, as long as words remain to be fetched
    output logic busy,
    output logic [STORED-1:0] word
);
  `include "engine/operations.svh"

  localparam int A = ADDRESS_BITS;
  localparam int PICK = $clog2(BANKS);
  localparam int LINE = MUL + ADD;
  localparam int AHEAD = DIV > LINE ? DIV : LINE;
  localparam int COUNT = $clog2(QUEUE_DEPTH + 1);

  logic [COUNT-1:0] waiting, behind;  // words in the queue, and those that remain

  // Fetch: the memory's output register holds the next word of the segment, the memory the one after.
  logic [STORED-1:0] code[0:(1<<CODE_BITS)-1];
  logic [STORED-1:0] fetched, ready;
  logic [WIDTH-1:0] issued;
  logic [CODE_BITS-1:0] next;
  logic warm, fetched_valid, ready_valid, fetched_all, push, done;
  assign push = fetch_wanted && fetch_valid && waiting < COUNT'(QUEUE_DEPTH);
  assign fetch_wanted = busy && ready_valid && !fetched_all;
  logic advance;
  assign advance = push || (busy && !fetched_valid);

  // With PARITY a line has one bit more, even parity, and `word` too: that a line which was taken had another.
  logic [STORED-1:0] given;
  logic wrong;
  generate
    if (PARITY != 0) begin : g_parity
      assign given = {^code_word, code_word};
      always_ff @(posedge clock) wrong <= push && ^ready;
      assign word = {wrong, issued};
    end else begin : g_no_parity
      assign given = code_word;
      assign wrong = 1'b0;
      assign word  = issued;
    end
  endgenerate

  always_ff @(posedge clock) begin
    if (code_write) code[code_address] <= given;
    if (advance) fetched <= code[next];
    if (advance) ready <= fetched;
    if (start) next <= start_address;
    else if (advance) next <= next + CODE_BITS'(1);
  end

  // The queue; its head is the issue register.
  logic [WIDTH-1:0] queue[0:QUEUE_DEPTH-1];
  assign behind = waiting - COUNT'(issue);
  generate
    for (genvar i = 0; i < QUEUE_DEPTH; i++) begin : g_queue
      always_ff @(posedge clock) begin
        if (push && behind == COUNT'(i)) queue[i] <= ready[WIDTH-1:0];
        else if (issue) queue[i] <= queue[(i+1)%QUEUE_DEPTH];
      end
    end
  endgenerate
  assign done = fetched_all && waiting == '0 && empty;
  always_ff @(posedge clock) begin
    if (reset) begin
      busy <= 1'b0;
      warm <= 1'b0;
      fetched_valid <= 1'b0;
      ready_valid <= 1'b0;
      fetched_all <= 1'b0;
      waiting <= '0;
    end else begin
      if (start) busy <= 1'b1;
      else if (done) busy <= 1'b0;
      warm <= busy && !done;
      fetched_valid <= warm && !done;
      ready_valid <= fetched_valid && !done;
      fetched_all <= busy && !done && (fetched_all || (push && ready[0]));
      waiting <= behind + COUNT'(push);
    end
  end

  // Hazards of the head.
  logic [WIDTH-1:0] head;
  logic [LANES*LINE-1:0] result_taken;  // bit k - 1: taken k cycles after this one (all shifted by READ)
  logic [BANKS*AHEAD-1:0] bank_taken;
  logic [DIVIDERS*INTERVAL-1:0] divider_taken;
  logic hazard, issue;
  assign head = queue[0];
  assign issue = busy && waiting != '0 && !hazard;
  assign issued = issue ? head : '0;

  localparam int UNITS = LANES + DIVIDERS;
  logic [4*LANES-1:0] op;
  logic [2*DIVIDERS-1:0] divider_op;
  logic [UNITS*4*A-1:0] address;
  logic [UNITS*4-1:0] uses;
  unpack #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .ADDRESS_BITS(A)
  ) head_by_unit (
      .fields(head[WIDTH-1:1]),
      .op(op),
      .divider_op(divider_op),
      .address(address),
      .uses(uses)
  );
  // For each unit the cycles to its result (bit k - 1 for k), and the bank of the destination.
  logic [UNITS*AHEAD-1:0] when;
  logic [UNITS*BANKS-1:0] into;
  generate
    for (genvar l = 0; l < LANES; l++) begin : g_lane
      logic product, sum, simple;
      assign product = is_product(op[4*l+:4]);
      assign sum = is_sum(op[4*l+:4]);
      assign simple = op[4*l+:4] != OP_NOP && !product && !sum;
      for (genvar k = 1; k <= AHEAD; k++) begin : g_when
        assign when[l*AHEAD+k-1] = (k == LINE && product && sum) || (k == MUL && product && !sum) ||
            (k == ADD && !product && sum) || (k == SIMPLE && simple);
      end
    end
    for (genvar d = 0; d < DIVIDERS; d++) begin : g_divider
      for (genvar k = 1; k <= AHEAD; k++) begin : g_when
        assign when[(LANES+d)*AHEAD+k-1] = k == DIV && divider_op[2*d+:2] != DIVIDER_NOP;
      end
    end
    for (genvar u = 0; u < UNITS; u++) begin : g_into
      for (genvar b = 0; b < BANKS; b++) begin : g_bank
        assign into[u*BANKS+b] = uses[4*u+3] && address[(4*u+3)*A+:PICK] == PICK'(b);
      end
    end
  endgenerate

  logic [UNITS*4-1:0] word_busy;
  logic result_hazard, bank_hazard, divider_hazard;
  always_comb begin
    for (int i = 0; i < UNITS * 4; i++) begin
      word_busy[i] = 1'b0;
      for (int f = 0; f < FLIGHTS; f++) begin
        if (flight_valid[f] && flight_address[f*A+:A] == address[i*A+:A]) word_busy[i] = uses[i];
      end
    end
  end
  always_comb begin
    result_hazard  = 1'b0;
    bank_hazard    = 1'b0;
    divider_hazard = 1'b0;
    for (int l = 0; l < LANES; l++) begin
      if ((result_taken[l*LINE+:LINE] & when[l*AHEAD+:LINE]) != '0) result_hazard = 1'b1;
    end
    for (int u = 0; u < UNITS; u++) begin
      for (int b = 0; b < BANKS; b++) begin
        if (into[u*BANKS+b] && (bank_taken[b*AHEAD+:AHEAD] & when[u*AHEAD+:AHEAD]) != '0) bank_hazard = 1'b1;
      end
    end
    for (int d = 0; d < DIVIDERS; d++) begin
      if (divider_op[2*d+:2] != DIVIDER_NOP && divider_taken[d*INTERVAL+:INTERVAL] != '0) divider_hazard = 1'b1;
    end
  end
  assign hazard = word_busy != '0 || result_hazard || bank_hazard || divider_hazard;

  // Reservations: those of the head enter, and all are shifted by one cycle.
  logic [LANES*LINE-1:0] result_next;
  logic [BANKS*AHEAD-1:0] bank_next;
  logic [DIVIDERS*INTERVAL-1:0] divider_next;
  always_comb begin
    result_next = result_taken;
    bank_next = bank_taken;
    divider_next = divider_taken;
    if (issue) begin
      for (int l = 0; l < LANES; l++) begin
        result_next[l*LINE+:LINE] = result_next[l*LINE+:LINE] | when[l*AHEAD+:LINE];
      end
      for (int u = 0; u < UNITS; u++) begin
        for (int b = 0; b < BANKS; b++) begin
          if (into[u*BANKS+b]) bank_next[b*AHEAD+:AHEAD] = bank_next[b*AHEAD+:AHEAD] | when[u*AHEAD+:AHEAD];
        end
      end
      for (int d = 0; d < DIVIDERS; d++) begin
        if (divider_op[2*d+:2] != DIVIDER_NOP) divider_next[d*INTERVAL+INTERVAL-1] = 1'b1;
      end
    end
  end
  always_ff @(posedge clock) begin
    if (reset) begin
      result_taken  <= '0;
      bank_taken    <= '0;
      divider_taken <= '0;
    end else begin
      for (int l = 0; l < LANES; l++) result_taken[l*LINE+:LINE] <= result_next[l*LINE+:LINE] >> 1;
      for (int b = 0; b < BANKS; b++) bank_taken[b*AHEAD+:AHEAD] <= bank_next[b*AHEAD+:AHEAD] >> 1;
      for (int d = 0; d < DIVIDERS; d++) divider_taken[d*INTERVAL+:INTERVAL] <= divider_next[d*INTERVAL+:INTERVAL] >> 1;
    end
  end
endmodule
