// One lane: a multiplier, then an adder, a path for simple operations, and one result register.
// `op` and `destination` come with the issue register (cycle t), the operands READ = 3 cycles later, the result U
// cycles after those. A shift register holds the destinations; its stages are the cycles left to the result.
module lane #(
    parameter int EXP = 11,
    parameter int MAN = 52,
    parameter int ADD = EXP == 11 ? contract::F64_ADD_CYCLES : contract::F32_ADD_CYCLES,
    parameter int MUL = EXP == 11 ? contract::F64_MUL_CYCLES : contract::F32_MUL_CYCLES,
    parameter int SIMPLE = contract::SIMPLE_CYCLES,
    parameter int ADDRESS_BITS = 14,
    parameter int STAGES = 3 + MUL + ADD
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

  // While the operands are read: cycles t + 1 ... t + 3.
  logic [3:0] op_1, op_2, op_3;
  logic [A-1:0] to_1, to_2, to_3;
  always_ff @(posedge clock) begin
    if (reset) begin
      op_1 <= OP_NOP;
      op_2 <= OP_NOP;
      op_3 <= OP_NOP;
    end else if (enable) begin
      op_1 <= op;
      op_2 <= op_1;
      op_3 <= op_2;
    end
    if (enable) begin
      to_1 <= destination;
      to_2 <= to_1;
      to_3 <= to_2;
    end
  end

  // The shift register of destinations. Stage j is j cycles before the result register; stage 0 belongs to it.
  logic [LINE-1:0] line_valid, line_product, line_sum, line_subtract;
  logic [A-1:0] line_to[0:LINE-1];
  logic [LINE:0] enter;  // the stage at which the operation with its operands enters
  always_comb begin
    enter = '0;
    for (int j = 0; j < LINE; j++) begin
      if (j + 1 == SIMPLE && op_3 != OP_NOP && !is_product(op_3) && !is_sum(op_3)) enter[j] = 1'b1;
      if (j + 1 == MUL && op_3 == OP_MUL) enter[j] = 1'b1;
      if (j + 1 == ADD && (op_3 == OP_ADD || op_3 == OP_SUB)) enter[j] = 1'b1;
      if (j + 1 == LINE && (op_3 == OP_ADD_MUL || op_3 == OP_SUB_MUL)) enter[j] = 1'b1;
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
          line_product[j]  <= enter[j] ? is_product(op_3) : line_product[(j+1)%LINE];
          line_sum[j]      <= enter[j] ? is_sum(op_3) : line_sum[(j+1)%LINE];
          line_subtract[j] <= enter[j] ? op_3 == OP_SUB_MUL : line_subtract[(j+1)%LINE];
          line_to[j]       <= enter[j] ? to_3 : line_to[(j+1)%LINE];
        end
      end
      assign flight_valid[3+j] = line_valid[j];
      assign flight_address[(3+j)*A+:A] = line_to[j];
    end
  endgenerate
  assign flight_valid[2:0] = {op_3 != OP_NOP, op_2 != OP_NOP, op_1 != OP_NOP};
  assign flight_address[3*A-1:0] = {to_3, to_2, to_1};

  // The units.
  logic [W-1:0] product, c_late, sum, simple, simple_1;
  logic chained, less;
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
  // A product with its addend is at the adder when ADD cycles are left.
  assign chained = line_valid[ADD] && line_sum[ADD] && line_product[ADD];
  fp_add #(
      .EXP(EXP),
      .MAN(MAN),
      .LATENCY(ADD)
  ) adder (
      .clock(clock),
      .enable(enable),
      .subtract(chained ? line_subtract[ADD] : op_3 == OP_SUB),
      .a(chained ? c_late : c),
      .b(chained ? product : a),
      .result(sum)
  );
  fp_less #(
      .EXP(EXP),
      .MAN(MAN)
  ) compare (
      .a(op_3 == OP_MIN ? b : a),
      .b(op_3 == OP_MIN ? a : b),
      .less(less)
  );
  always_comb begin
    case (op_3)
      OP_NEG: simple = {!a[W-1], a[W-2:0]};
      OP_ABS: simple = {1'b0, a[W-2:0]};
      OP_MIN, OP_MAX: simple = less ? b : a;
      OP_COMPARE: simple = {W{less}};
      OP_AND: simple = a & b;
      OP_SELECT: simple = c[0] ? a : b;
      default: simple = a;
    endcase
  end
  fp_delay #(
      .WIDTH (W),
      .CYCLES(SIMPLE)
  ) simple_path (
      .clock(clock),
      .enable(enable),
      .in(simple),
      .out(simple_1)
  );

  assign result_valid = line_valid[0];
  assign result_address = line_to[0];
  assign result = line_sum[0] ? sum : line_product[0] ? product : simple_1;
endmodule
