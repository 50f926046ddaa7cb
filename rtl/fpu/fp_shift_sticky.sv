// Right shift with a sticky bit: `lost` says whether a one was shifted out. Amounts of WIDTH and more lose everything.
module fp_shift_sticky #(
    parameter int WIDTH = 56,
    parameter int BITS  = $clog2(WIDTH + 1)
) (
    input  logic [WIDTH-1:0] value,
    input  logic [ BITS-1:0] amount,
    output logic [WIDTH-1:0] shifted,
    output logic             lost
);
  always_comb begin
    shifted = value;
    lost    = 1'b0;
    for (int i = 0; i < BITS; i++) begin
      if (amount[i]) begin
        lost    = lost | ((shifted << (WIDTH - (((1 << i) < WIDTH) ? (1 << i) : WIDTH))) != '0);
        shifted = shifted >> (1 << i);
      end
    end
  end
endmodule
