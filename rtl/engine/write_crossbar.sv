// From the units' result registers to the banks' write registers: for each bank the OR of the results addressed to it,
// at most one a cycle.
module write_crossbar #(
    parameter int UNITS = 6,
    parameter int BANKS = 16,
    parameter int ADDRESS_BITS = 14,
    parameter int WIDTH = 64,
    parameter int ROW = ADDRESS_BITS - $clog2(BANKS)
) (
    input logic clock,
    input logic reset,
    input logic enable,
    input logic [UNITS-1:0] valid,
    input logic [UNITS*ADDRESS_BITS-1:0] address,
    input logic [UNITS*WIDTH-1:0] word,
    output logic [BANKS-1:0] write,
    output logic [BANKS*ROW-1:0] write_row,
    output logic [BANKS*WIDTH-1:0] write_word,
    output logic conflict
);
  localparam int A = ADDRESS_BITS;
  localparam int PICK = $clog2(BANKS);

  logic [BANKS-1:0] take;
  logic [BANKS*ROW-1:0] rows;
  logic [BANKS*WIDTH-1:0] words;
  logic pick, clash;
  always_comb begin
    take  = '0;
    rows  = '0;
    words = '0;
    clash = 1'b0;
    pick  = 1'b0;
    for (int b = 0; b < BANKS; b++) begin
      for (int u = 0; u < UNITS; u++) begin
        pick = valid[u] && address[u*A+:PICK] == PICK'(b);
        clash = clash || (pick && take[b]);
        take[b] = take[b] || pick;
        rows[b*ROW+:ROW] = rows[b*ROW+:ROW] | ({ROW{pick}} & address[u*A+PICK+:ROW]);
        words[b*WIDTH+:WIDTH] = words[b*WIDTH+:WIDTH] | ({WIDTH{pick}} & word[u*WIDTH+:WIDTH]);
      end
    end
  end
  assign conflict = enable && clash;
  always_ff @(posedge clock) begin
    if (reset) write <= '0;
    else if (enable) write <= take;
    if (enable) begin
      write_row  <= rows;
      write_word <= words;
    end
  end
endmodule
