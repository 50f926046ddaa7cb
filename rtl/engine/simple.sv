// What a lane does without multiplier and adder: move, neg, abs, min, max, compare, and, select. LATENCY >= 2 cycles: the
// comparison, then the choice. `op` comes a cycle before its operands.
module simple #(
    parameter int EXP = 11,
    parameter int MAN = 52,
    parameter int LATENCY = contract::SIMPLE_CYCLES
) (
    input logic clock,
    input logic enable,
    input logic [3:0] op,
    input logic [EXP+MAN:0] a,
    input logic [EXP+MAN:0] b,
    input logic [EXP+MAN:0] c,
    output logic [EXP+MAN:0] result
);
  `include "engine/operations.svh"

  localparam int W = EXP + MAN + 1;

  // 1: compare. Both ways, as a choice of operands before one comparison would have the longest wires of the lane.
  logic less, more;
  fp_less #(
      .EXP(EXP),
      .MAN(MAN)
  ) below (
      .a(a),
      .b(b),
      .less(less)
  );
  fp_less #(
      .EXP(EXP),
      .MAN(MAN)
  ) above (
      .a(b),
      .b(a),
      .less(more)
  );
  logic [3:0] op_0, op_1;
  logic less_1, more_1, odd_1;
  logic [W-1:0] a_1, b_1;
  always_ff @(posedge clock) if (enable) begin
    op_0   <= op;
    op_1   <= op_0;
    less_1 <= less;
    more_1 <= more;
    odd_1  <= c[0];
    a_1    <= a;
    b_1    <= b;
  end

  // 2: choose.
  logic [W-1:0] chosen, result_2;
  always_comb begin
    case (op_1)
      OP_NEG: chosen = {!a_1[W-1], a_1[W-2:0]};
      OP_ABS: chosen = {1'b0, a_1[W-2:0]};
      OP_MIN: chosen = more_1 ? b_1 : a_1;
      OP_MAX: chosen = less_1 ? b_1 : a_1;
      OP_COMPARE: chosen = {W{less_1}};
      OP_AND: chosen = a_1 & b_1;
      OP_SELECT: chosen = odd_1 ? a_1 : b_1;
      default: chosen = a_1;
    endcase
  end
  always_ff @(posedge clock) if (enable) result_2 <= chosen;
  fp_delay #(
      .WIDTH (W),
      .CYCLES(LATENCY - 2)
  ) extra (
      .clock(clock),
      .enable(enable),
      .in   (result_2),
      .out  (result)
  );
endmodule
