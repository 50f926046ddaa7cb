// Number of zeros above the highest one of `value`; WIDTH or more (a power of two less one) when there is none.
module fp_leading_zeros #(
    parameter int WIDTH = 57,
    parameter int BITS  = $clog2(WIDTH + 1)
) (
    input  logic [WIDTH-1:0] value,
    output logic [ BITS-1:0] count
);
  localparam int PADDED = 1 << BITS;

  // A tree: of two halves the count of the upper one, unless it is zero.
  logic [PADDED-1:0] any;
  logic [PADDED*BITS-1:0] zeros;
  always_comb begin
    any   = {value, {(PADDED - WIDTH) {1'b0}}};
    zeros = '0;
    for (int level = 0; level < BITS; level++) begin
      for (int i = 0; i < PADDED >> (level + 1); i++) begin
        zeros[i*BITS+:BITS] = any[2*i+1] ? zeros[(2*i+1)*BITS+:BITS] : zeros[2*i*BITS+:BITS] | (BITS'(1) << level);
        any[i] = any[2*i+1] || any[2*i];
      end
    end
    count = any[0] ? zeros[BITS-1:0] : '1;
  end
endmodule
