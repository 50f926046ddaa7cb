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
    parameter int STAGES = contract::DECODE_CYCLES,  // from the buffer to the issue register
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

  localparam int HEAD = LANES + 2 * DIVIDERS;  // of an item that names templates, without their numbers
  localparam int LONG = $clog2(4 * A + 1);  // the length of a lane's payload

  // Stage 1, the only loop: how extent is the item at the bottom of the buffer? It is taken whole if all of it is there. A
  // template is stored with the length of the payload that it asks for.
  logic [BUFFER-1:0] buffer;
  logic [FILL-1:0] fill, length;
  logic [RUN-1:0] rest;  // empty words still to come
  logic [TEMPLATE_WIDTH-1:0] templates[0:(1<<TEMPLATE)-1];
  logic [LONG-1:0] lengths[0:(1<<TEMPLATE)-1];
  logic [LANES*TEMPLATE_WIDTH-1:0] used, used_next;  // the current template of each lane
  logic [LANES*LONG-1:0] extent, extent_next;  // and the length of its payload
  logic [1:0] kind;
  logic [LANES-1:0] mask;
  logic [2*DIVIDERS-1:0] divider_op;
  logic [HEAD+LANES*TEMPLATE-1:0] head, numbers;
  logic [FILL-1:0] divided;
  logic [LONG-1:0] written;
  assign kind = buffer[1:0];
  assign head = buffer[2+:HEAD+LANES*TEMPLATE];
  always_comb begin
    mask = kind == SAME ? '0 : head[LANES-1:0];
    numbers = head >> LANES;
    used_next = used;
    extent_next = extent;
    length = FILL'(2);
    for (int l = 0; l < LANES; l++) begin
      if (mask[l]) begin
        used_next[TEMPLATE_WIDTH*l+:TEMPLATE_WIDTH] = templates[numbers[TEMPLATE-1:0]];
        extent_next[LONG*l+:LONG] = lengths[numbers[TEMPLATE-1:0]];
        numbers = numbers >> TEMPLATE;
        length = length + FILL'(TEMPLATE);
      end
    end
    divider_op = kind == SAME ? '0 : numbers[2*DIVIDERS-1:0];
    if (kind != SAME) length = length + FILL'(HEAD);
    divided = '0;
    for (int d = 0; d < DIVIDERS; d++) begin
      if (divider_op[2*d+:2] != DIVIDER_NOP)
        divided = divided + (divider_op[2*d+:2] == DIVIDER_DIV ? FILL'(3 * A) : FILL'(2 * A));
    end
    length = length + divided;
    for (int l = 0; l < LANES; l++) length = length + FILL'(extent_next[LONG*l+:LONG]);
    if (kind == EMPTY) length = FILL'(2 + RUN);
    written = '0;
    for (int f = 0; f < 4; f++) begin
      if (template_word[4+2*f+:2] == 2'd2) written = written + LONG'(SHORT);
      if (template_word[4+2*f+:2] == 2'd3) written = written + LONG'(A);
    end
  end

  // Stage 2: take the payload behind the templates' numbers; where does each lane's begin?
  logic valid_1, last_1, same_1;
  logic [LANES-1:0] mask_1;
  logic [2*DIVIDERS-1:0] divider_op_1;
  logic [ITEM-3:0] item_1, payload_1;
  always_comb begin
    payload_1 = same_1 ? item_1 : item_1 >> HEAD;
    for (int l = 0; l < LANES; l++) if (mask_1[l]) payload_1 = payload_1 >> TEMPLATE;
  end
  logic [(LANES+1)*FILL-1:0] first, first_2;
  logic valid_2, last_2;
  logic [2*DIVIDERS-1:0] divider_op_2;
  logic [ITEM-3:0] payload_2;
  logic [LANES*TEMPLATE_WIDTH-1:0] used_2;
  always_comb begin
    first = '0;
    for (int l = 0; l < LANES; l++)
      first[FILL*(l+1)+:FILL] = first[FILL*l+:FILL] + FILL'(extent[LONG*l+:LONG]);
  end

  // Stage 3: a shift for each lane, and one for the dividers.
  logic valid_3, last_3;
  logic [2*DIVIDERS-1:0] divider_op_3;
  logic [LANES*4*A-1:0] lane_3;
  logic [3*A*DIVIDERS-1:0] divider_3;
  logic [LANES*TEMPLATE_WIDTH-1:0] used_3;
  // Stage 4: a choice for each field.
  logic valid_4, last_4;
  logic [WIDTH-1:0] divided_3, divided_4;
  logic [LANES*4*A-1:0] field_3, field_4;
  logic [LANES*TEMPLATE_WIDTH-1:0] used_4;
  logic [4*A-1:0] lane_left;
  logic [3*A*DIVIDERS-1:0] divider_left;
  always_comb begin
    field_3 = '0;
    lane_left = '0;
    for (int l = 0; l < LANES; l++) begin
      lane_left = lane_3[4*A*l+:4*A];
      for (int f = 0; f < 4; f++) begin
        field_3[(4*l+f)*A+:A] = lane_left[A-1:0];
        if (used_3[TEMPLATE_WIDTH*l+4+2*f+:2] == 2'd2) lane_left = lane_left >> SHORT;
        if (used_3[TEMPLATE_WIDTH*l+4+2*f+:2] == 2'd3) lane_left = lane_left >> A;
      end
    end
    divided_3 = '0;
    divider_left = divider_3;
    for (int d = 0; d < DIVIDERS; d++) begin
      if (divider_op_3[2*d+:2] != DIVIDER_NOP) begin
        divided_3[1+LANES*LANE+d*DIVIDER+:A] = divider_left[A-1:0];
        divider_left = divider_left >> A;
        if (divider_op_3[2*d+:2] == DIVIDER_DIV) begin
          divided_3[1+LANES*LANE+d*DIVIDER+A+:A] = divider_left[A-1:0];
          divider_left = divider_left >> A;
        end
        divided_3[1+LANES*LANE+d*DIVIDER+2*A+:A] = divider_left[A-1:0];
        divider_left = divider_left >> A;
        divided_3[1+LANES*LANE+d*DIVIDER+3*A+:2] = divider_op_3[2*d+:2];
      end
    end
  end

  // Stage 5: addresses, from those kept.
  logic [LANES*4*A-1:0] kept, kept_next, step, step_next;  // last address and step of each field a, b, c, destination
  logic [WIDTH-1:0] made;
  logic [3:0] op;
  logic [1:0] mode;
  logic [A-1:0] at;
  always_comb begin
    kept_next = kept;
    step_next = step;
    made = divided_4;
    made[0] = last_4;
    op = OP_NOP;
    mode = SAME;
    at = '0;
    for (int l = 0; l < LANES; l++) begin
      op = used_4[TEMPLATE_WIDTH*l+:4];
      for (int f = 0; f < 4; f++) begin
        mode = used_4[TEMPLATE_WIDTH*l+4+2*f+:2];
        at   = kept[(4*l+f)*A+:A];
        case (mode)
          2'd0: if (f == 3) at = kept_next[(4*l+2)*A+:A];
          2'd1: at = at + step[(4*l+f)*A+:A];
          2'd2: begin
            step_next[(4*l+f)*A+:A] = {{(A - SHORT) {field_4[(4*l+f)*A+SHORT-1]}}, field_4[(4*l+f)*A+:SHORT]};
            at = at + step_next[(4*l+f)*A+:A];
          end
          default: at = field_4[(4*l+f)*A+:A];
        endcase
        if (op != OP_NOP) begin
          kept_next[(4*l+f)*A+:A] = at;
          if ((f != 1 || reads_b(op)) && (f != 2 || reads_c(op))) made[1+l*LANE+f*A+:A] = at;
        end
      end
      made[1+l*LANE+4*A+:4] = op;
    end
  end

  always_ff @(posedge clock) begin
    if (take) begin
      item_1 <= buffer[ITEM-1:2];
      mask_1 <= mask;
      same_1 <= kind == SAME;
      last_1 <= kind == LAST;
      divider_op_1 <= divider_op;
    end
    last_2 <= last_1;
    divider_op_2 <= divider_op_1;
    payload_2 <= payload_1;
    used_2 <= used;
    first_2 <= first;
    last_3 <= last_2;
    divider_op_3 <= divider_op_2;
    for (int l = 0; l < LANES; l++) lane_3[4*A*l+:4*A] <= (4 * A)'(payload_2 >> first_2[FILL*l+:FILL]);
    divider_3 <= (3 * A * DIVIDERS)'(payload_2 >> first_2[FILL*LANES+:FILL]);
    used_3 <= used_2;
    last_4 <= last_3;
    divided_4 <= divided_3;
    field_4 <= field_3;
    used_4 <= used_3;
    if (start) begin
      kept <= '0;
      step <= '0;
    end else if (valid_4) begin
      kept <= kept_next;
      step <= step_next;
    end
    word <= valid_4 ? made : '0;
  end

  // Fetch as in the in-order sequencer: the memory's output register holds the next line, the memory the one after.
  logic [FETCH-1:0] code[0:(1<<CODE_BITS)-1];
  logic [FETCH-1:0] fetched, ready;
  logic [CODE_BITS-1:0] next;
  logic warm, fetched_valid, stopped, done, decoding, take, deliver, push, advance;
  logic [STAGES-1:0] issue, ended, freeze;  // bit i: i + 1 cycles ago
  logic [FILL-1:0] stays;
  assign decoding = busy && fetched_valid && !stopped;
  assign take = decoding && rest == '0 && fill >= length;
  assign deliver = take || (decoding && rest != '0);
  assign stays = take ? fill - length : fill;
  assign push = decoding && stays <= FILL'(3 * FETCH);
  assign advance = push || (busy && !fetched_valid);
  assign done = ended[STAGES-1] && !issue[STAGES-1] && empty;
  assign frozen = freeze[STAGES-1];
  always_ff @(posedge clock) begin
    if (code_write) code[code_address] <= code_word;
    if (template_write) templates[template_address] <= template_word;
    if (template_write) lengths[template_address] <= written;
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
      extent <= '0;
    end else begin
      buffer <= push ? staying | line : staying;
      fill   <= push ? stays + FILL'(FETCH) : stays;
      if (take) begin
        rest <= kind == EMPTY ? buffer[2+:RUN] : '0;
        if (kind != EMPTY) used <= used_next;
        if (kind != EMPTY) extent <= extent_next;
      end else if (deliver) begin
        rest <= rest - RUN'(1);
      end
    end
  end
  always_ff @(posedge clock) begin
    if (reset) begin
      busy   <= 1'b0;
      warm   <= 1'b0;
      fetched_valid <= 1'b0;
      stopped <= 1'b0;
      ended  <= '0;
      issue  <= '0;
      freeze <= '0;
      {valid_1, valid_2, valid_3, valid_4} <= '0;
    end else begin
      if (start) busy <= 1'b1;
      else if (done) busy <= 1'b0;
      warm   <= busy && !done;
      fetched_valid <= warm && !done;
      stopped <= busy && !done && (stopped || (take && kind == LAST));
      ended  <= (busy && !done) ? {ended[STAGES-2:0], stopped || (take && kind == LAST)} : '0;
      issue  <= {issue[STAGES-2:0], deliver};
      freeze <= {freeze[STAGES-2:0], decoding && !deliver};
      {valid_1, valid_2, valid_3, valid_4} <= {take && kind != EMPTY, valid_1, valid_2, valid_3};
    end
  end
endmodule
