// The decoder of compressed microcode (docs/pl-machine.md, Compressed microcode): lines of FETCH bits go into a buffer, items of
// variable length are taken from it, and each decodes to one flat word or a run of empty ones. After a cycle without a word,
// `frozen` stops the datapath.
module compressed_decode #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int ADDRESS_BITS = 14,
    parameter int SHORT = contract::SHORT_BITS,
    parameter int TEMPLATE = contract::TEMPLATE_BITS,
    parameter int TEMPLATE_WIDTH = contract::TEMPLATE_WIDTH,
    parameter int FETCH = 128,
    parameter int WAITS = 0,  // whether a line may be late: `there`
    parameter int STAGES = contract::DECODE_CYCLES - contract::HEADERS_AHEAD - 1,  // from the payload in the buffer to the issue register
    parameter int WIDTH = 1 + LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2)
) (
    input logic clock,
    input logic reset,
    input logic template_write,
    input logic [TEMPLATE-1:0] template_address,
    input logic [TEMPLATE_WIDTH-1:0] template_word,
    input logic start,
    input logic empty,
    input logic [FETCH-1:0] line,
    input logic there,
    output logic push,  // the line goes into the buffer
    output logic opening,  // busy, and lines do not go there yet
    output logic busy,
    output logic frozen,
    output logic [WIDTH-1:0] word
);
  localparam int PAYLOAD = LANES * 4 * ADDRESS_BITS + DIVIDERS * 3 * ADDRESS_BITS;
  localparam int FILL = $clog2(PAYLOAD + 1);
  localparam int AT = $clog2(FETCH) + 2;

  logic decoding, deliver, last, valid, last_1;
  logic starts;  // a cycle after the command, which comes late in its own
  logic [FETCH*4-1:0] buffer;
  logic [AT-1:0] place;
  logic [LANES*TEMPLATE_WIDTH-1:0] used;
  logic [(LANES+1)*FILL-1:0] first;
  logic [2*DIVIDERS-1:0] divider_op;
  compressed_items #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .FETCH(FETCH),
      .WAITS(WAITS),
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
      .line(line),
      .there(there),
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
      .word(word)
  );
  always_ff @(posedge clock) begin
    starts <= start;
    last_1 <= last;
  end

  logic warm, fetched_valid, stopped, done;
  logic [STAGES-1:0] issue, ended, freeze;  // bit i: i + 1 cycles ago
  assign decoding = busy && fetched_valid && !stopped;
  assign opening = busy && !fetched_valid;
  assign done = ended[STAGES-1] && !issue[STAGES-1] && empty;
  assign frozen = freeze[STAGES-1];

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
