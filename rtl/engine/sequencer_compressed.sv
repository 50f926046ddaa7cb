// Static sequencer for compressed microcode (docs/pl-machine.md, Compressed microcode): lines of FETCH bits go into a
// buffer, items of variable length are taken from it, and each decodes to one flat word or a run of empty ones. After a
// cycle without a word, `frozen` stops the datapath.
module sequencer_compressed #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int ADDRESS_BITS = 14,
    parameter int SHORT = contract::SHORT_BITS,
    parameter int TEMPLATE = contract::TEMPLATE_BITS,
    parameter int TEMPLATE_WIDTH = contract::TEMPLATE_WIDTH,
    parameter int CODE_BITS = 16,
    parameter int FETCH = 128,
    parameter int WIDTH = 1 + LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2)
) (
    input logic clock,
    input logic reset,
    input logic code_write,
    input logic [CODE_BITS-1:0] code_address,
    input logic [FETCH-1:0] code_word,
    input logic template_write,
    input logic [TEMPLATE-1:0] template_address,
    input logic [TEMPLATE_WIDTH-1:0] template_word,
    input logic start,
    input logic [CODE_BITS-1:0] start_address,
    input logic empty,
    output logic busy,
    output logic frozen,
    output logic [WIDTH-1:0] word
);
  `include "engine/operations.svh"

  localparam int A = ADDRESS_BITS;
  localparam int LANE = 4 * A + 4;
  localparam int DIVIDER = 3 * A + 2;
  localparam int ITEM = 2 + LANES * (1 + TEMPLATE + 4 * A) + DIVIDERS * (2 + 3 * A);  // the longest
  localparam int BUFFER = 4 * FETCH;
  localparam int FILL = $clog2(BUFFER + 1);
  localparam int RUN = 8;
  localparam logic [1:0] SAME = 2'd0;
  localparam logic [1:0] EMPTY = 2'd2;
  localparam logic [1:0] LAST = 2'd3;

  // Decode the item at the bottom of the buffer: decoded bits are shifted out of `left`, and counted.
  logic [BUFFER-1:0] buffer;
  logic [FILL-1:0] fill, length;
  logic [RUN-1:0] rest, rest_next;  // empty words still to come
  logic [TEMPLATE_WIDTH-1:0] templates[0:(1<<TEMPLATE)-1];
  logic [LANES*TEMPLATE_WIDTH-1:0] used, used_next;  // the current template of each lane
  logic [LANES*4*A-1:0] kept, kept_next, step, step_next;  // last address and step of each field a, b, c, destination
  logic [WIDTH-1:0] made;
  logic [1:0] kind;
  assign kind = buffer[1:0];

  logic [ITEM-1:0] left;
  logic [LANES-1:0] mask;
  logic [2*DIVIDERS-1:0] divider_op;
  logic [3:0] op;
  logic [1:0] mode;
  logic [A-1:0] at;
  always_comb begin
    left = buffer[ITEM-1:0] >> 2;
    length = FILL'(2);
    used_next = used;
    kept_next = kept;
    step_next = step;
    rest_next = left[RUN-1:0];
    mask = '0;
    divider_op = '0;
    made = '0;
    op = OP_NOP;
    mode = SAME;
    at = '0;
    if (kind == EMPTY) begin
      length = FILL'(2 + RUN);
    end else begin
      rest_next = '0;
      if (kind != SAME) begin
        mask = left[LANES-1:0];
        left = left >> LANES;
        length = length + FILL'(LANES + 2 * DIVIDERS);
        for (int l = 0; l < LANES; l++) begin
          if (mask[l]) begin
            used_next[TEMPLATE_WIDTH*l+:TEMPLATE_WIDTH] = templates[left[TEMPLATE-1:0]];
            left = left >> TEMPLATE;
            length = length + FILL'(TEMPLATE);
          end
        end
        divider_op = left[2*DIVIDERS-1:0];
        left = left >> (2 * DIVIDERS);
      end
      made[0] = kind == LAST;
      for (int l = 0; l < LANES; l++) begin
        op = used_next[TEMPLATE_WIDTH*l+:4];
        for (int f = 0; f < 4; f++) begin
          mode = used_next[TEMPLATE_WIDTH*l+4+2*f+:2];
          at   = kept[(4*l+f)*A+:A];
          case (mode)
            2'd0: if (f == 3) at = kept_next[(4*l+2)*A+:A];
            2'd1: at = at + step[(4*l+f)*A+:A];
            2'd2: begin
              step_next[(4*l+f)*A+:A] = {{(A - SHORT) {left[SHORT-1]}}, left[SHORT-1:0]};
              at = at + step_next[(4*l+f)*A+:A];
              left = left >> SHORT;
              length = length + FILL'(SHORT);
            end
            default: begin
              at = left[A-1:0];
              left = left >> A;
              length = length + FILL'(A);
            end
          endcase
          if (op != OP_NOP) begin
            kept_next[(4*l+f)*A+:A] = at;
            if ((f != 1 || reads_b(op)) && (f != 2 || reads_c(op))) made[1+l*LANE+f*A+:A] = at;
          end
        end
        made[1+l*LANE+4*A+:4] = op;
      end
      for (int d = 0; d < DIVIDERS; d++) begin
        if (divider_op[2*d+:2] != DIVIDER_NOP) begin
          made[1+LANES*LANE+d*DIVIDER+:A] = left[A-1:0];
          left = left >> A;
          length = length + FILL'(2 * A);
          if (divider_op[2*d+:2] == DIVIDER_DIV) begin
            made[1+LANES*LANE+d*DIVIDER+A+:A] = left[A-1:0];
            left = left >> A;
            length = length + FILL'(A);
          end
          made[1+LANES*LANE+d*DIVIDER+2*A+:A] = left[A-1:0];
          left = left >> A;
          made[1+LANES*LANE+d*DIVIDER+3*A+:2] = divider_op[2*d+:2];
        end
      end
    end
  end

  // Fetch as in the in-order sequencer: the memory's output register holds the next line, the memory the one after.
  logic [FETCH-1:0] code[0:(1<<CODE_BITS)-1];
  logic [FETCH-1:0] fetched, ready;
  logic [CODE_BITS-1:0] next;
  logic warm, fetched_valid, ended, issue, done, decoding, take, deliver, push, advance;
  logic [FILL-1:0] stays;
  assign decoding = busy && fetched_valid && !ended;
  assign take = decoding && rest == '0 && fill >= length;
  assign deliver = take || (decoding && rest != '0);
  assign stays = take ? fill - length : fill;
  assign push = decoding && stays <= FILL'(3 * FETCH);
  assign advance = push || (busy && !fetched_valid);
  assign done = ended && !issue && empty;
  always_ff @(posedge clock) begin
    if (code_write) code[code_address] <= code_word;
    if (template_write) templates[template_address] <= template_word;
    if (advance) fetched <= code[next];
    if (advance) ready <= fetched;
    if (start) next <= start_address;
    else if (advance) next <= next + CODE_BITS'(1);
  end

  // The buffer is zero above `fill`: an OR appends a line.
  logic [BUFFER-1:0] staying, line;
  assign staying = take ? buffer >> length : buffer;
  assign line = {{(BUFFER - FETCH) {1'b0}}, ready} << stays;
  always_ff @(posedge clock) begin
    if (start) begin
      buffer <= '0;
      fill <= '0;
      rest <= '0;
      used <= '0;
      kept <= '0;
      step <= '0;
    end else begin
      buffer <= push ? staying | line : staying;
      fill   <= push ? stays + FILL'(FETCH) : stays;
      if (take) begin
        rest <= rest_next;
        used <= used_next;
        kept <= kept_next;
        step <= step_next;
      end else if (deliver) begin
        rest <= rest - RUN'(1);
      end
    end
    word <= take ? made : '0;
  end
  always_ff @(posedge clock) begin
    if (reset) begin
      busy   <= 1'b0;
      warm   <= 1'b0;
      fetched_valid <= 1'b0;
      ended  <= 1'b0;
      issue  <= 1'b0;
      frozen <= 1'b0;
    end else begin
      if (start) busy <= 1'b1;
      else if (done) busy <= 1'b0;
      warm   <= busy && !done;
      fetched_valid <= warm && !done;
      ended  <= busy && !done && (ended || (take && kind == LAST));
      issue  <= deliver;
      frozen <= decoding && !deliver;
    end
  end
endmodule
