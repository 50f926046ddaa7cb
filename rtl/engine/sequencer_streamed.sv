// Static sequencer for compressed microcode that comes from outside: the decoder takes the next line where it is there, and
// waits where it is not. With PARITY the word has its bit, which is never set: no line is kept here.
module sequencer_streamed #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int ADDRESS_BITS = 14,
    parameter int SHORT = contract::SHORT_BITS,
    parameter int TEMPLATE = contract::TEMPLATE_BITS,
    parameter int TEMPLATE_WIDTH = contract::TEMPLATE_WIDTH,
    parameter int FETCH = 128,
    parameter int PARITY = 0,
    parameter int WIDTH = 1 + LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2)
) (
    input logic clock,
    input logic reset,
    input logic [FETCH-1:0] line,
    input logic there,
    output logic taken,
    input logic template_write,
    input logic [TEMPLATE-1:0] template_address,
    input logic [TEMPLATE_WIDTH-1:0] template_word,
    input logic start,
    input logic empty,
    output logic busy,
    output logic frozen,
    output logic [WIDTH+(PARITY != 0 ? 1 : 0)-1:0] word
);
  logic opening;
  logic [WIDTH-1:0] issued;
  compressed_decode #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .SHORT(SHORT),
      .TEMPLATE(TEMPLATE),
      .TEMPLATE_WIDTH(TEMPLATE_WIDTH),
      .FETCH(FETCH),
      .WAITS(1)
  ) decoder (
      .clock(clock),
      .reset(reset),
      .template_write(template_write),
      .template_address(template_address),
      .template_word(template_word),
      .start(start),
      .empty(empty),
      .line(line),
      .there(there),
      .push(taken),
      .opening(opening),
      .busy(busy),
      .frozen(frozen),
      .word(issued)
  );
  generate
    if (PARITY != 0) begin : g_parity
      assign word = {1'b0, issued};
    end else begin : g_no_parity
      assign word = issued;
    end
  endgenerate
endmodule
