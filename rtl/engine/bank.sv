// Block memory with its output register, one synchronous read port and one write port. Reading a row while it is
// written gives its old or its new word; no schedule does that. Nor does one address a row behind the last: what is read there is
// undefined, and a write may land in another row.
module bank #(
    parameter int ROW   = 10,
    parameter int WIDTH = 64,
    parameter int ROWS  = 1 << ROW
) (
    input  logic             clock,
    input  logic             enable,
    input  logic [  ROW-1:0] read_row,
    output logic [WIDTH-1:0] read_word,
    input  logic             write,
    input  logic [  ROW-1:0] write_row,
    input  logic [WIDTH-1:0] write_word
);
  generate
    if (ROWS < 1 || ROWS > 1 << ROW) begin : g_refused
      $error("a bank has from one row to as many as its address tells apart");
    end
  endgenerate
  localparam int INDEX = ROWS > 2 ? $clog2(ROWS) : 1;
  logic [WIDTH-1:0] words[0:ROWS-1];
  logic [WIDTH-1:0] found;
  always_ff @(posedge clock) begin
    if (enable) found <= words[INDEX'(read_row)];
    if (enable) read_word <= found;
    if (enable && write) words[INDEX'(write_row)] <= write_word;
  end
endmodule
