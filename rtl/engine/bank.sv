// Block memory with its output register, one synchronous read port and one write port. Reading a row while it is
// written gives its old or its new word; no schedule does that.
module bank #(
    parameter int ROW   = 10,
    parameter int WIDTH = 64
) (
    input  logic             clock,
    input  logic             enable,
    input  logic [  ROW-1:0] read_row,
    output logic [WIDTH-1:0] read_word,
    input  logic             write,
    input  logic [  ROW-1:0] write_row,
    input  logic [WIDTH-1:0] write_word
);
  logic [WIDTH-1:0] words[0:(1<<ROW)-1];
  logic [WIDTH-1:0] found;
  always_ff @(posedge clock) begin
    if (enable) found <= words[read_row];
    if (enable) read_word <= found;
    if (enable && write) words[write_row] <= write_word;
  end
endmodule
