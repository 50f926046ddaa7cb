// Top of the unit test: one of each floating-point unit, beside each other.
module units #(
    parameter int EXP = 11,
    parameter int MAN = 52,
    parameter int ADD_CYCLES = 6,
    parameter int MUL_CYCLES = 7,
    parameter int DIV_CYCLES = 32
) (
    input  logic               clock,
    input  logic               reset,
    input  logic               enable,
    input  logic               subtract,
    input  logic               start,
    input  logic               root,
    input  logic [EXP+MAN : 0] a,
    input  logic [EXP+MAN : 0] b,
    output logic [EXP+MAN : 0] sum,
    output logic [EXP+MAN : 0] product,
    output logic [EXP+MAN : 0] quotient,
    output logic               less
);
  fp_add #(
      .EXP(EXP),
      .MAN(MAN),
      .LATENCY(ADD_CYCLES)
  ) add (
      .clock(clock),
      .enable(enable),
      .subtract(subtract),
      .a(a),
      .b(b),
      .result(sum)
  );
  fp_mul #(
      .EXP(EXP),
      .MAN(MAN),
      .LATENCY(MUL_CYCLES)
  ) mul (
      .clock(clock),
      .enable(enable),
      .a(a),
      .b(b),
      .result(product)
  );
  fp_divsqrt #(
      .EXP(EXP),
      .MAN(MAN),
      .CYCLES(DIV_CYCLES)
  ) divsqrt (
      .clock(clock),
      .reset(reset),
      .enable(enable),
      .start(start),
      .root(root),
      .a(a),
      .b(b),
      .result(quotient)
  );
  fp_less #(
      .EXP(EXP),
      .MAN(MAN)
  ) compare (
      .a(a),
      .b(b),
      .less(less)
  );
endmodule
