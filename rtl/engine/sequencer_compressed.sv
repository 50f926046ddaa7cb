// Static sequencer for compressed microcode: a memory of lines of FETCH bits, one fetched a cycle, and their decoder.
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
  logic push, opening, advance;
  logic [STORED-1:0] fetched, ready;
  logic [WIDTH-1:0] issued;
  compressed_decode #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .SHORT(SHORT),
      .TEMPLATE(TEMPLATE),
      .TEMPLATE_WIDTH(TEMPLATE_WIDTH),
      .FETCH(FETCH)
  ) decoder (
      .clock(clock),
      .reset(reset),
      .template_write(template_write),
      .template_address(template_address),
      .template_word(template_word),
      .start(start),
      .empty(empty),
      .line(ready[FETCH-1:0]),
      .there(1'b1),
      .push(push),
      .opening(opening),
      .busy(busy),
      .frozen(frozen),
      .word(issued)
  );

  // Fetch as in the in-order sequencer: the memory's output register holds the next line, the memory the one after.
  logic [STORED-1:0] code[0:(1<<CODE_BITS)-1];
  logic [CODE_BITS-1:0] next;
  assign advance = push || opening;

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
endmodule
