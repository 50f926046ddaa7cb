// The items of compressed microcode (docs/pl-machine.md): the buffer of lines, the place in it, and the headers. A header
// comes AHEAD payloads before its own, so that a payload's length is a register's when its turn comes.
module compressed_items #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int ADDRESS_BITS = 14,
    parameter int FETCH = 128,
    parameter int WAITS = 0,
    parameter int SHORT = contract::SHORT_BITS,
    parameter int TEMPLATE = contract::TEMPLATE_BITS,
    parameter int TEMPLATE_WIDTH = contract::TEMPLATE_WIDTH,
    parameter int PAYLOAD = LANES * 4 * ADDRESS_BITS + DIVIDERS * 3 * ADDRESS_BITS,  // the longest
    parameter int FILL = $clog2(PAYLOAD + 1),
    parameter int AT = $clog2(FETCH) + 2
) (
    input logic clock,
    input logic template_write,
    input logic [TEMPLATE-1:0] template_address,
    input logic [TEMPLATE_WIDTH-1:0] template_word,
    input logic start,
    input logic decoding,
    input logic [FETCH-1:0] line,
    input logic there,  // with WAITS: the line is
    output logic push,  // the line goes into the buffer
    output logic deliver,  // a word, which may be empty
    output logic last,  // it is the segment's last
    output logic valid,  // it has operations, or may have: those of the payload below
    output logic [FETCH*4-1:0] buffer,
    output logic [AT-1:0] place,
    output logic [LANES*TEMPLATE_WIDTH-1:0] used,  // the template of each lane
    output logic [(LANES+1)*FILL-1:0] first,  // where the payload of each lane begins, and that of the dividers
    output logic [2*DIVIDERS-1:0] divider_op
);
  `include "engine/operations.svh"

  localparam int A = ADDRESS_BITS;
  localparam int RUN = 8;
  localparam int HEAD = 2 + LANES * (1 + TEMPLATE) + 2 * DIVIDERS;  // the longest header
  localparam int HEADER = HEAD > 2 + RUN ? HEAD : 2 + RUN;
  localparam int BIT = $clog2(FETCH);  // a place in a line
  localparam int WRAP = AT + 1;  // a place in the stream, modulo twice the buffer
  localparam int LONG = $clog2(4 * A + 1);  // the length of a lane's payload
  localparam logic [1:0] SAME = 2'd0;
  localparam logic [1:0] EMPTY = 2'd2;
  localparam logic [1:0] LAST = 2'd3;

  // The loop. At `at` lies a header, and behind it the payload of an item whose header came AHEAD items ago, so that its
  // length is known; `over` is the header's place with that length added. Both are taken if all of both is there. How long
  // the header is, its kind and mask say, which are read a cycle before, once for each length of the header in front. A header
  // has one of KINDS lengths: whether it is there is found for each beside the choice. What follows is kept in PARTS of two
  // lengths each, which together are the next opening, so that no cycle has both the view of the buffer and all of the choice.
  localparam int OPEN = 2 + LANES;  // kind and mask
  localparam int KINDS = LANES + 3;  // by the number of templates; of a run of empty words; of the same templates again
  localparam int PARTS = (KINDS + 1) / 2;
  function automatic int length_of(input int kind);
    length_of = kind <= LANES ? OPEN + 2 * DIVIDERS + kind * TEMPLATE : kind == LANES + 1 ? 2 + RUN : 2;
  endfunction
  // Whether `bits` bits from a place on, at most a line, lie before the end of `lines`, which is at most four lines from there.
  function automatic logic reaches(input logic [2:0] lines, input logic [WRAP-1:0] from, input int bits);
    logic [2:0] left;
    left = lines - from[BIT+:3];
    reaches = left == 3'd1 ? from[BIT-1:0] <= BIT'(FETCH - bits) : left == 3'd2 || left == 3'd3 || left == 3'd4;
  endfunction
  logic [WRAP-1:0] at, over, length;
  logic [2:0] filled, filled_1;  // lines, modulo twice the buffer: now, and a cycle ago
  logic opened;  // the header's opening was there when it was read
  logic whole, complete;  // the header is there; that of operations would be
  logic [OPEN-1:0] opening, again;
  logic [LANES:1] named;  // bit n: n templates or more
  logic [PARTS*OPEN-1:0] following, follows;
  logic [KINDS-1:0] is, fits;  // of this length, one hot; one of this length is there
  logic [HEADER-1:0] header;
  logic [HEADER+OPEN-1:0] next_headers;
  logic [FILL-1:0] extent_3;
  compressed_view #(
      .WIDTH(HEADER),
      .FETCH(FETCH)
  ) at_header (
      .buffer(buffer),
      .place (at[AT-1:0]),
      .view  (header)
  );
  compressed_view #(
      .WIDTH(HEADER + OPEN),
      .FETCH(FETCH)
  ) at_next (
      .buffer(buffer),
      .place (over[AT-1:0]),
      .view  (next_headers)
  );
  always_comb begin
    opening = again;
    for (int p = 0; p < PARTS; p++) opening = opening | follows[OPEN*p+:OPEN];
    named = '0;
    for (int l = 0; l < LANES; l++) if (opening[2+l]) named = named << 1 | LANES'(1);
    is = '0;
    if (opening[0]) is[LANES:0] = {named, 1'b1} & ~{1'b0, named};
    else is[LANES+1+:2] = opening[1] ? 2'b01 : 2'b10;
    length = '0;
    following = '0;
    for (int k = 0; k < KINDS; k++) begin
      length = length | ({WRAP{is[k]}} & WRAP'(length_of(k)));
      fits[k] = reaches(filled, over, length_of(k));
      following[OPEN*(k/2)+:OPEN] = following[OPEN*(k/2)+:OPEN] | ({OPEN{is[k]}} & next_headers[length_of(k)+:OPEN]);
    end
    opened   = reaches(filled_1, at, OPEN);
    whole    = fits[0] && &(fits[LANES:1] | ~named);
    complete = opened && (opening[0] ? whole : opening[1] ? fits[LANES+1] : fits[LANES+2]);
  end

  // Headers, as they are taken. 1: its bits.
  logic [HEADER-1:0] header_1;
  logic there_1, there_2, there_3, there_4;  // an item
  // 2: the templates that it names, each stored with the length of its payload.
  logic [TEMPLATE_WIDTH-1:0] templates[0:(1<<TEMPLATE)-1];
  logic [LONG-1:0] lengths[0:(1<<TEMPLATE)-1];
  logic [LANES*TEMPLATE_WIDTH-1:0] used_2, used_next;
  logic [LANES*LONG-1:0] lane_2, lane_next;
  logic [2*DIVIDERS-1:0] divider_op_2, divider_op_next;
  logic [1:0] kind_2;
  logic [RUN-1:0] run_2;
  logic [LANES*TEMPLATE+2*DIVIDERS-1:0] numbers;
  logic [LONG-1:0] written;
  always_comb begin
    numbers   = header_1[HEAD-1:2+LANES];
    used_next = used_2;
    lane_next = lane_2;
    for (int l = 0; l < LANES; l++) begin
      if (header_1[0] && header_1[2+l]) begin
        used_next[TEMPLATE_WIDTH*l+:TEMPLATE_WIDTH] = templates[numbers[TEMPLATE-1:0]];
        lane_next[LONG*l+:LONG] = lengths[numbers[TEMPLATE-1:0]];
        numbers = numbers >> TEMPLATE;
      end
    end
    divider_op_next = header_1[0] ? numbers[2*DIVIDERS-1:0] : '0;
    written = '0;
    for (int f = 0; f < 4; f++) begin
      if (template_word[4+2*f+:2] == 2'd2) written = written + LONG'(SHORT);
      if (template_word[4+2*f+:2] == 2'd3) written = written + LONG'(A);
    end
  end
  // 3: where each lane's payload begins, and the length of all.
  logic [LANES*TEMPLATE_WIDTH-1:0] used_3;
  logic [2*DIVIDERS-1:0] divider_op_3;
  logic [1:0] kind_3;
  logic [RUN-1:0] run_3;
  logic runs_3;
  logic [(LANES+1)*FILL-1:0] begins;
  logic take, idle;
  logic [(LANES+1)*FILL-1:0] first_3;
  logic [FILL-1:0] extent;
  // 4: it waits for its payload, whose length is in `over`.
  logic [LANES*TEMPLATE_WIDTH-1:0] used_4;
  logic [2*DIVIDERS-1:0] divider_op_4;
  logic [1:0] kind_4;
  logic [RUN-1:0] run_4;
  logic runs_4;
  logic [(LANES+1)*FILL-1:0] first_4;
  always_comb begin
    begins = '0;
    for (int l = 0; l < LANES; l++)
      begins[FILL*(l+1)+:FILL] = begins[FILL*l+:FILL] + FILL'(lane_2[LONG*l+:LONG]);
    extent = begins[FILL*LANES+:FILL];
    for (int d = 0; d < DIVIDERS; d++) begin
      if (divider_op_2[2*d+:2] != DIVIDER_NOP)
        extent = extent + (divider_op_2[2*d+:2] == DIVIDER_DIV ? FILL'(3 * A) : FILL'(2 * A));
    end
    if (kind_2 == EMPTY) extent = '0;
  end
  always_ff @(posedge clock) begin
    if (start) begin
      {there_1, there_2, there_3, there_4} <= '0;
      header_1 <= '0;
      used_2 <= '0;
      lane_2 <= '0;
      kind_2 <= SAME;
      divider_op_2 <= '0;
      extent_3 <= '0;
    end else if (take) begin
      {there_1, there_2, there_3, there_4} <= {1'b1, there_1, there_2, there_3};
      header_1 <= header;
      kind_2 <= header_1[1:0];
      used_2 <= used_next;
      lane_2 <= lane_next;
      divider_op_2 <= divider_op_next;
      extent_3 <= extent;
    end
    if (take) begin
      run_2 <= header_1[2+:RUN];
      kind_3 <= kind_2;
      run_3 <= run_2;
      runs_3 <= kind_2 == EMPTY && run_2 != '0;
      used_3 <= used_2;
      divider_op_3 <= divider_op_2;
      first_3 <= begins;
      {kind_4, run_4, runs_4} <= {kind_3, run_3, runs_3};
      {used_4, divider_op_4, first_4} <= {used_3, divider_op_3, first_3};
    end
  end


  // What is taken: the payload of the item whose header is in the fourth place. Empty words go on after it.
  logic [RUN-1:0] rest;
  assign take = decoding && idle && complete;
  assign deliver = decoding && (!idle || (there_4 && complete));
  assign last = take && there_4 && kind_4 == LAST;
  always_ff @(posedge clock) begin
    if (start) idle <= 1'b1;
    else if (take) idle <= !(there_4 && runs_4);
    else if (rest == RUN'(1)) idle <= 1'b1;
    rest <= take ? run_4 : rest - RUN'(1);
    valid <= take && there_4 && kind_4 != EMPTY;
    place <= AT'(at + length);
    used <= used_4;
    first <= first_4;
    divider_op <= divider_op_4;
  end

  // A line goes where no bit is left that was not taken before this cycle.
  logic room;
  assign room = !(filled[1:0] == at[BIT+:2] && filled[2] != at[BIT+2]);
  generate
    if (WAITS != 0) begin : g_waits
      assign push = decoding && room && there;
    end else begin : g_there
      assign push = decoding && room;
    end
  endgenerate
  always_ff @(posedge clock) begin
    if (start) {at, over} <= '0;
    else if (take) begin
      at   <= over + length;
      over <= over + WRAP'(extent_3) + length;
    end
    again   <= take ? '0 : header[OPEN-1:0];
    follows <= take ? following : '0;
    if (start) filled <= '0;
    else if (push) filled <= filled + 3'd1;
    filled_1 <= start ? '0 : filled;
    for (int i = 0; i < 4; i++) if (push && filled[1:0] == 2'(i)) buffer[FETCH*i+:FETCH] <= line;
    if (template_write) templates[template_address] <= template_word;
    if (template_write) lengths[template_address] <= written;
  end
endmodule
