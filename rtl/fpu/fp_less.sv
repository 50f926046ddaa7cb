// IEEE 754 a < b: false if either is a NaN; -0 equals +0. No registers.
module fp_less #(
    parameter int EXP = 11,
    parameter int MAN = 52
) (
    input  logic [EXP+MAN : 0] a,
    input  logic [EXP+MAN : 0] b,
    output logic               less
);
  localparam int M = EXP + MAN;
  localparam logic [M-1:0] INFINITY = {{EXP{1'b1}}, MAN'(0)};

  logic nan, both_zero;
  always_comb begin
    nan       = a[M-1:0] > INFINITY || b[M-1:0] > INFINITY;
    both_zero = a[M-1:0] == '0 && b[M-1:0] == '0;
    case ({
      a[M], b[M]
    })
      2'b00:   less = a[M-1:0] < b[M-1:0];
      2'b11:   less = a[M-1:0] > b[M-1:0];
      default: less = a[M];
    endcase
    if (nan || both_zero) less = 1'b0;
  end
endmodule
