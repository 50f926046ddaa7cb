// The fields of a microcode word without its last bit, unit by unit: lanes first, then dividers. For each unit four
// addresses, operands a, b, c and the destination, and which of the four its operation uses. Combinational.
module unpack #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int ADDRESS_BITS = 14,
    parameter int FIELDS = LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2),
    parameter int UNITS = LANES + DIVIDERS
) (
    input logic [FIELDS-1:0] fields,
    output logic [4*LANES-1:0] op,
    output logic [2*DIVIDERS-1:0] divider_op,
    output logic [UNITS*4*ADDRESS_BITS-1:0] address,
    output logic [UNITS*4-1:0] uses
);
  `include "engine/operations.svh"

  localparam int A = ADDRESS_BITS;
  localparam int LANE = 4 * A + 4;
  localparam int DIVIDER = 3 * A + 2;

  generate
    for (genvar l = 0; l < LANES; l++) begin : g_lane
      logic [3:0] operation;
      assign operation = fields[l*LANE+4*A+:4];
      assign op[4*l+:4] = operation;
      assign address[l*4*A+:4*A] = fields[l*LANE+:4*A];
      assign uses[4*l+:4] = {operation != OP_NOP, reads_c(operation), reads_b(operation), operation != OP_NOP};
    end
    for (genvar d = 0; d < DIVIDERS; d++) begin : g_divider
      localparam int FIRST = LANES * LANE + d * DIVIDER;
      logic [1:0] operation;
      assign operation = fields[FIRST+3*A+:2];
      assign divider_op[2*d+:2] = operation;
      assign address[(LANES+d)*4*A+:4*A] = {fields[FIRST+2*A+:A], {A{1'b0}}, fields[FIRST+:2*A]};
      assign uses[4*(LANES+d)+:4] = {operation != DIVIDER_NOP, 1'b0, operation == DIVIDER_DIV, operation != DIVIDER_NOP};
    end
  endgenerate
endmodule
