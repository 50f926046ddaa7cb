// Static sequencer for compressed microcode (docs/pl-machine.md, Compressed microcode): lines of FETCH bits are fetched into
// a buffer, items of variable length are taken from it, and each decodes to one flat word or a run of empty ones. After a
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
    parameter int PARITY = 0,
    parameter int STORED = FETCH + (PARITY != 0 ? 1 : 0),
    parameter int STAGES = contract::DECODE_CYCLES - contract::HEADERS_AHEAD - 1,  // from the payload in the buffer to the issue register
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
    output logic [WIDTH+STORED-FETCH-1:0] word
);
  localparam int PAYLOAD = LANES * 4 * ADDRESS_BITS + DIVIDERS * 3 * ADDRESS_BITS;
  localparam int FILL = $clog2(PAYLOAD + 1);
  localparam int AT = $clog2(FETCH) + 2;

  logic decoding, push, deliver, last, valid, last_1;
  logic starts;  // a cycle after the command, which comes late in its own
  logic [FETCH*4-1:0] buffer;
  logic [STORED-1:0] fetched, ready;
  logic [WIDTH-1:0] issued;
  logic [AT-1:0] place;
  logic [LANES*TEMPLATE_WIDTH-1:0] used;
  logic [(LANES+1)*FILL-1:0] first;
  logic [2*DIVIDERS-1:0] divider_op;
  compressed_items #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .FETCH(FETCH),
      .SHORT(SHORT),
      .TEMPLATE(TEMPLATE),
      .TEMPLATE_WIDTH(TEMPLATE_WIDTH)
  ) items (
      .clock(clock),
      .template_write(template_write),
      .template_address(template_address),
      .template_word(template_word),
      .start(starts),
      .decoding(decoding),
      .line(ready[FETCH-1:0]),
      .push(push),
      .deliver(deliver),
      .last(last),
      .valid(valid),
      .buffer(buffer),
      .place(place),
      .used(used),
      .first(first),
      .divider_op(divider_op)
  );
  compressed_payload #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .FETCH(FETCH),
      .SHORT(SHORT),
      .TEMPLATE_WIDTH(TEMPLATE_WIDTH)
  ) payload (
      .clock(clock),
      .reset(reset),
      .start(starts),
      .valid(valid),
      .last(last_1),
      .buffer(buffer),
      .place(place),
      .used(used),
      .first(first),
      .divider_op(divider_op),
      .word(issued)
  );
  always_ff @(posedge clock) begin
    starts <= start;
    last_1 <= last;
  end

  // Fetch as in the in-order sequencer: the memory's output register holds the next line, the memory the one after.
  logic [STORED-1:0] code[0:(1<<CODE_BITS)-1];
  logic [CODE_BITS-1:0] next;
  logic warm, fetched_valid, stopped, done, advance;
  logic [STAGES-1:0] issue, ended, freeze;  // bit i: i + 1 cycles ago
  assign decoding = busy && fetched_valid && !stopped;
  assign advance = push || (busy && !fetched_valid);
  assign done = ended[STAGES-1] && !issue[STAGES-1] && empty;
  assign frozen = freeze[STAGES-1];

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
  always_ff @(posedge clock) begin
    if (reset) begin
      busy   <= 1'b0;
      warm   <= 1'b0;
      fetched_valid <= 1'b0;
      stopped <= 1'b0;
      ended  <= '0;
      issue  <= '0;
      freeze <= '0;
    end else begin
      if (start) busy <= 1'b1;
      else if (done) busy <= 1'b0;
      warm   <= busy && !done;
      fetched_valid <= warm && !done;
      stopped <= busy && !done && (stopped || last);
      ended  <= (busy && !done) ? {ended[STAGES-2:0], stopped || last} : '0;
      issue  <= {issue[STAGES-2:0], deliver};
      freeze <= {freeze[STAGES-2:0], decoding && !deliver};
    end
  end
endmodule
