// One lane: a multiplier, then an adder, a path for simple operations, and one result register.
// `op` and `destination` come with the issue register (cycle t), the operands READ cycles later, the result U
// cycles after those. A shift register holds the destinations; its stages are the cycles left to the result.
module lane #(
    parameter int EXP = 11,
    parameter int MAN = 52,
    parameter int ADD = EXP == 11 ? contract::F64_ADD_CYCLES : contract::F32_ADD_CYCLES,
    parameter int MUL = EXP == 11 ? contract::F64_MUL_CYCLES : contract::F32_MUL_CYCLES,
    parameter int SIMPLE = contract::SIMPLE_CYCLES,
    parameter int ADDRESS_BITS = 14,
    parameter int READ = contract::READ_CYCLES,
    parameter int STAGES = READ + MUL + ADD
) (
    input logic clock,
    input logic reset,
    input logic enable,
    input logic [3:0] op,
    input logic [ADDRESS_BITS-1:0] destination,
    input logic [EXP+MAN:0] a,
    input logic [EXP+MAN:0] b,
    input logic [EXP+MAN:0] c,
    output logic result_valid,
    output logic [ADDRESS_BITS-1:0] result_address,
    output logic [EXP+MAN:0] result,
    // Destinations in flight, from cycle t + 1 to the result register.
    output logic [STAGES-1:0] flight_valid,
    output logic [STAGES*ADDRESS_BITS-1:0] flight_address,
    output logic conflict
);
  `include "engine/operations.svh"

  localparam int W = EXP + MAN + 1;
  localparam int A = ADDRESS_BITS;
  localparam int LINE = MUL + ADD;

  // While the operands are read: cycles t + 1 ... t + READ. What the operation is, is decoded a cycle before the operands
  // are there.
  logic [4*READ-1:0] ops;
  logic [READ*A-1:0] tos;
  logic [3:0] coming, op_r;
  logic [A-1:0] to_r;
  logic enters_simple, enters_mul, enters_add, enters_chain, subtract_r, chained;
  assign coming = ops[4*(READ-2)+:4];
  always_ff @(posedge clock) begin
    if (reset) begin
      ops <= '0;
      {enters_simple, enters_mul, enters_add, enters_chain} <= '0;
    end else if (enable) begin
      ops <= {ops[4*READ-5:0], op};
      enters_simple <= coming != OP_NOP && !is_product(coming) && !is_sum(coming);
      enters_mul <= coming == OP_MUL;
      enters_add <= is_sum(coming) && !is_product(coming);
      enters_chain <= is_sum(coming) && is_product(coming);
    end
    if (enable) begin
      tos <= {tos[(READ-1)*A-1:0], destination};
      subtract_r <= coming == OP_SUB || coming == OP_SUB_MUL;
    end
  end
  assign op_r = ops[4*(READ-1)+:4];
  assign to_r = tos[(READ-1)*A+:A];

  // The shift register of destinations. Stage j is j cycles before the result register; stage 0 belongs to it.
  logic [LINE-1:0] line_valid, line_product, line_sum, line_subtract;
  logic [A-1:0] line_to[0:LINE-1];
  logic [LINE:0] enter;  // the stage at which the operation with its operands enters
  always_comb begin
    enter = '0;
    for (int j = 0; j < LINE; j++) begin
      if (j + 1 == SIMPLE && enters_simple) enter[j] = 1'b1;
      if (j + 1 == MUL && enters_mul) enter[j] = 1'b1;
      if (j + 1 == ADD && enters_add) enter[j] = 1'b1;
      if (j + 1 == LINE && enters_chain) enter[j] = 1'b1;
    end
  end
  // Result conflict: two operations of the lane end in the same cycle.
  assign conflict = enable && (enter[LINE-2:0] & line_valid[LINE-1:1]) != '0;

  generate
    for (genvar j = 0; j < LINE; j++) begin : g_line
      always_ff @(posedge clock) begin
        if (reset) line_valid[j] <= 1'b0;
        else if (enable) line_valid[j] <= enter[j] || (j + 1 < LINE ? line_valid[(j+1)%LINE] : 1'b0);
        if (enable) begin
          line_product[j]  <= enter[j] ? enters_mul || enters_chain : line_product[(j+1)%LINE];
          line_sum[j]      <= enter[j] ? enters_add || enters_chain : line_sum[(j+1)%LINE];
          line_subtract[j] <= enter[j] ? subtract_r : line_subtract[(j+1)%LINE];
          line_to[j]       <= enter[j] ? to_r : line_to[(j+1)%LINE];
        end
      end
      assign flight_valid[READ+j] = line_valid[j];
      assign flight_address[(READ+j)*A+:A] = line_to[j];
    end
  endgenerate
  generate
    for (genvar i = 0; i < READ; i++) begin : g_read
      assign flight_valid[i] = ops[4*i+:4] != OP_NOP;
    end
  endgenerate
  assign flight_address[READ*A-1:0] = tos;

  // The units.
  logic [W-1:0] product, c_late, sum, simple;
  fp_mul #(
      .EXP(EXP),
      .MAN(MAN),
      .LATENCY(MUL)
  ) multiplier (
      .clock(clock),
      .enable(enable),
      .a(a),
      .b(b),
      .result(product)
  );
  fp_delay #(
      .WIDTH (W),
      .CYCLES(MUL)
  ) addend (
      .clock(clock),
      .enable(enable),
      .in(c),
      .out(c_late)
  );
  // A product with its addend is at the adder's first register when ADD cycles are left.
  always_ff @(posedge clock) if (enable) chained <= line_valid[ADD+1] && line_sum[ADD+1] && line_product[ADD+1];
  fp_add #(
      .EXP(EXP),
      .MAN(MAN),
      .LATENCY(ADD)
  ) adder (
      .clock(clock),
      .enable(enable),
      .subtract(chained ? line_subtract[ADD] : subtract_r),
      .a(chained ? c_late : c),
      .b(chained ? product : a),
      .result(sum)
  );
  // Simple operations: compare, then choose. Both ways are compared, as a choice of operands before one comparison would
  // have the longest wires of the lane.
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
  logic [3:0] op_1;
  logic less_1, more_1, odd_1;
  logic [W-1:0] a_1, b_1;
  always_ff @(posedge clock) if (enable) begin
    op_1   <= op_r;
    less_1 <= less;
    more_1 <= more;
    odd_1  <= c[0];
    a_1    <= a;
    b_1    <= b;
  end

  logic [W-1:0] chosen, simple_2;
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
  always_ff @(posedge clock) if (enable) simple_2 <= chosen;
  fp_delay #(
      .WIDTH (W),
      .CYCLES(SIMPLE - 2)
  ) simple_path (
      .clock(clock),
      .enable(enable),
      .in(simple_2),
      .out(simple)
  );

  assign result_valid = line_valid[0];
  assign result_address = line_to[0];
  assign result = line_sum[0] ? sum : line_product[0] ? product : simple;
endmodule
