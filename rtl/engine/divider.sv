// Divide and square-root unit: one operation at a time, the next CYCLES cycles after the last. Timing as in lane.sv.
module divider #(
    parameter int EXP = 11,
    parameter int MAN = 52,
    parameter int CYCLES = EXP == 11 ? contract::F64_DIV_CYCLES : contract::F32_DIV_CYCLES,
    parameter int ADDRESS_BITS = 14
) (
    input logic clock,
    input logic reset,
    input logic enable,
    input logic [1:0] op,
    input logic [ADDRESS_BITS-1:0] destination,
    input logic [EXP+MAN:0] a,
    input logic [EXP+MAN:0] b,
    output logic result_valid,
    output logic [ADDRESS_BITS-1:0] result_address,
    output logic [EXP+MAN:0] result,
    output logic [3:0] flight_valid,
    output logic [4*ADDRESS_BITS-1:0] flight_address,
    output logic conflict
);
  `include "engine/operations.svh"

  localparam int A = ADDRESS_BITS;
  localparam int COUNT = $clog2(CYCLES + 1);

  logic [1:0] op_1, op_2, op_3;
  logic [A-1:0] to_1, to_2, to_3, to;
  logic [COUNT-1:0] left;  // cycles to the result, 1 when it is valid, 0 when idle
  logic start;
  assign start = op_3 != DIVIDER_NOP;
  always_ff @(posedge clock) begin
    if (reset) begin
      op_1 <= DIVIDER_NOP;
      op_2 <= DIVIDER_NOP;
      op_3 <= DIVIDER_NOP;
      left <= '0;
    end else if (enable) begin
      op_1 <= op;
      op_2 <= op_1;
      op_3 <= op_2;
      if (start) left <= COUNT'(CYCLES);
      else if (left != '0) left <= left - COUNT'(1);
    end
    if (enable) begin
      to_1 <= destination;
      to_2 <= to_1;
      to_3 <= to_2;
      if (start) to <= to_3;
    end
  end

  fp_divsqrt #(
      .EXP(EXP),
      .MAN(MAN),
      .CYCLES(CYCLES)
  ) unit (
      .clock(clock),
      .reset(reset),
      .enable(enable),
      .start(start),
      .root(op_3 == DIVIDER_SQRT),
      .a(a),
      .b(b),
      .result(result)
  );
  assign conflict = enable && start && left > COUNT'(1);
  assign result_valid = left == COUNT'(1);
  assign result_address = to;
  assign flight_valid = {left != '0, start, op_2 != DIVIDER_NOP, op_1 != DIVIDER_NOP};
  assign flight_address = {to, to_3, to_2, to_1};
endmodule
