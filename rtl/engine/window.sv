// WIDTH bits of `row` from bit STEP * `from` on. The choice is made from its highest bit down, so that every level of
// multiplexers is narrower than the last. No registers.
module window #(
    parameter int WIDTH = 38,
    parameter int BITS  = 7,
    parameter int STEP  = 1,
    parameter int ROW   = WIDTH + STEP * ((1 << BITS) - 1)
) (
    input  logic [  ROW-1:0] row,
    input  logic [ BITS-1:0] from,
    output logic [WIDTH-1:0] view
);
  logic [ROW-1:0] left;
  always_comb begin
    left = row;
    for (int i = BITS - 1; i >= 0; i--) begin
      // Bits above WIDTH + STEP * (2^i - 1) are not read any more.
      if (from[i]) left = left >> (STEP << i);
    end
    view = left[WIDTH-1:0];
  end
endmodule
