// Number of zeros above the highest one of `value`; WIDTH or more (up to the next power of two) when there is none.
module fp_leading_zeros #(
    parameter int WIDTH = 57,
    parameter int BITS  = $clog2(WIDTH + 1)
) (
    input  logic [WIDTH-1:0] value,
    output logic [ BITS-1:0] count
);
  localparam int PADDED = 1 << BITS;

  logic [PADDED-1:0] rest;

  // Binary search: whether the upper half of the rest is zero.
  always_comb begin
    rest  = {value, {(PADDED - WIDTH) {1'b0}}};
    count = '0;
    for (int i = BITS - 1; i >= 0; i--) begin
      if ((rest >> (PADDED - (1 << i))) == '0) begin
        count = count | (BITS'(1) << i);
        rest  = rest << (1 << i);
      end
    end
  end
endmodule
