// A digest of what was written to microcode and templates since it was cleared: CRC-32 (IEEE 802.3, as zlib has it) of the
// pieces in order, XOR CRC-32 of the numbers of the lines and templates that they made. Both over bytes, the low one first.
module axi_digest #(
    parameter int CODE_BITS = 17
) (
    input logic clock,
    input logic reset,
    input logic clear,
    input logic take,  // a piece of a line or template, taken in this cycle
    input logic pair,  // and its upper neighbour
    input logic [31:0] value,
    input logic [31:0] upper,
    input logic code_write,
    input logic [CODE_BITS-1:0] code_address,
    input logic template_write,
    input logic [contract::TEMPLATE_BITS-1:0] template_address,
    output logic [31:0] digest
);
  function automatic logic [31:0] crc_word(input logic [31:0] crc, input logic [31:0] next);
    logic [31:0] state;
    state = crc ^ next;
    for (int i = 0; i < 32; i++) state = (state >> 1) ^ (state[0] ? 32'hedb88320 : 32'd0);
    crc_word = state;
  endfunction

  logic taken, taken_pair;
  logic [31:0] low, high, pieces, places, number;
  assign number = template_write ? 32'h8000_0000 | 32'(template_address) : 32'(code_address);
  assign digest = pieces ^ places;
  always_ff @(posedge clock) begin
    taken <= take && !reset;
    taken_pair <= pair;
    low <= value;
    high <= upper;
    if (reset || clear) begin
      pieces <= '1;
      places <= '1;
    end else begin
      if (taken) pieces <= taken_pair ? crc_word(crc_word(pieces, low), high) : crc_word(pieces, low);
      if (code_write || template_write) places <= crc_word(places, number);
    end
  end
endmodule
