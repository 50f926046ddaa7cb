// Top of the unit test: one of each floating-point unit.
module units #(
    parameter int EXP = 11,
    parameter int MAN = 52,
    parameter int ADD_CYCLES = EXP == 11 ? contract::F64_ADD_CYCLES : contract::F32_ADD_CYCLES,
    parameter int MUL_CYCLES = EXP == 11 ? contract::F64_MUL_CYCLES : contract::F32_MUL_CYCLES,
    parameter int DIV_CYCLES = EXP == 11 ? contract::F64_DIV_CYCLES : contract::F32_DIV_CYCLES,
    parameter int DIV_INTERVAL_CYCLES = EXP == 11 ? contract::F64_DIV_INTERVAL_CYCLES : contract::F32_DIV_INTERVAL_CYCLES
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
      .CYCLES(DIV_CYCLES),
      .INTERVAL(DIV_INTERVAL_CYCLES)
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
