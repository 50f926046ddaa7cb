// Static sequencer: it issues one word of a segment a cycle, up to the word whose last bit is set.
// First busy cycle: address register; second: microcode memory; third: its output register; fourth: the first word is
// in the issue register.
module sequencer_flat #(
    parameter int WIDTH = 285,
    parameter int CODE_BITS = 16,
    parameter int PARITY = 0,
    parameter int STORED = WIDTH + (PARITY != 0 ? 1 : 0)
) (
    input logic clock,
    input logic reset,
    input logic code_write,
    input logic [CODE_BITS-1:0] code_address,
    input logic [WIDTH-1:0] code_word,
    input logic start,
    input logic [CODE_BITS-1:0] start_address,
    input logic empty,
    output logic busy,
    output logic [STORED-1:0] word
);
  logic [STORED-1:0] code[0:(1<<CODE_BITS)-1];
  logic [STORED-1:0] fetched, ready;
  logic [WIDTH-1:0] issued;
  logic [CODE_BITS-1:0] next;
  logic fetched_valid, ready_valid, issue, ended;  // ended: the last word is, or was, in the issue register

  // With PARITY a line has one bit more, even parity, and `word` too: that a line which was taken had another.
  logic [STORED-1:0] given;
  logic wrong;
  generate
    if (PARITY != 0) begin : g_parity
      assign given = {^code_word, code_word};
      always_ff @(posedge clock) wrong <= busy && ready_valid && !ended && ^ready;
      assign word = {wrong, issued};
    end else begin : g_no_parity
      assign given = code_word;
      assign wrong = 1'b0;
      assign word  = issued;
    end
  endgenerate

  always_ff @(posedge clock) begin
    if (code_write) code[code_address] <= given;
    fetched <= code[next];
    ready <= fetched;
    next <= start ? start_address : next + CODE_BITS'(1);
    issued <= (busy && ready_valid && !ended) ? ready[WIDTH-1:0] : '0;
  end
  always_ff @(posedge clock) begin
    if (reset) begin
      busy <= 1'b0;
      fetched_valid <= 1'b0;
      ready_valid <= 1'b0;
      issue <= 1'b0;
      ended <= 1'b0;
    end else begin
      if (start) busy <= 1'b1;
      else if (ended && !issue && empty) busy <= 1'b0;
      fetched_valid <= busy && !start;
      ready_valid <= busy && fetched_valid;
      issue <= busy && ready_valid && !ended;
      ended <= busy && !(ended && !issue && empty) && (ended || (ready_valid && ready[0]));
    end
  end
endmodule
