// Assertions of the rules of a schedule (docs/pl-machine.md, rules 1 to 7), in simulation. A word behind the last row is never free
// to be written, and never has been. One bit per rule and cycle:
//   0 read_conflict  1 read_pending  2 write_pending  3 result_conflict  4 write_conflict  5 divider_busy
//   6 read_unwritten  7 unknown_operation
module checks #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int ADDRESS_BITS = 14,
    parameter int WORDS = 1 << ADDRESS_BITS,  // that are there
    parameter int FIELDS = LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2),
    parameter int UNITS = LANES + DIVIDERS
) (
    input logic clock,
    input logic reset,
    input logic enable,
    input logic [FIELDS-1:0] fields,
    input logic host_write,
    input logic [ADDRESS_BITS-1:0] host_address,
    input logic [UNITS-1:0] result_valid,
    input logic [UNITS*ADDRESS_BITS-1:0] result_address,
    input logic read_conflict,
    input logic result_conflict,
    input logic write_conflict,
    input logic divider_busy,
    output logic [7:0] violations
);
  `include "engine/operations.svh"

  localparam int A = ADDRESS_BITS;

  logic [4*LANES-1:0] op;
  logic [2*DIVIDERS-1:0] divider_op;
  logic [UNITS*4*A-1:0] address;
  logic [UNITS*4-1:0] uses;
  unpack #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .ADDRESS_BITS(A)
  ) fields_by_unit (
      .fields(fields),
      .op(op),
      .divider_op(divider_op),
      .address(address),
      .uses(uses)
  );

  // For every word the epoch of its last issued write, and of a pending write. A reset begins a new epoch, which clears
  // all words at once.
  localparam int EPOCH = 16;
  logic [EPOCH-1:0] epoch;
  logic [EPOCH-1:0] written[0:(1<<A)-1];
  logic [EPOCH-1:0] pending[0:(1<<A)-1];
  initial begin
    epoch = EPOCH'(1);
`ifndef SYNTHESIS  // yosys reads every module, and unrolls the loop
    for (int i = 0; i < 1 << A; i++) begin
      written[i] = '0;
      pending[i] = '0;
    end
`endif
  end
  always_ff @(posedge clock) begin
    if (reset) epoch <= epoch + EPOCH'(1);
    if (host_write) written[host_address] <= epoch;
    if (enable) begin
      for (int u = 0; u < UNITS; u++) begin
        if (result_valid[u]) pending[result_address[u*A+:A]] <= '0;
      end
      for (int u = 0; u < UNITS; u++) begin
        if (uses[4*u+3]) begin
          written[address[(4*u+3)*A+:A]] <= epoch;
          pending[address[(4*u+3)*A+:A]] <= epoch;
        end
      end
    end
  end

  logic read_pending, write_pending, read_unwritten, unknown_operation;
  always_comb begin
    read_pending = 1'b0;
    write_pending = 1'b0;
    read_unwritten = 1'b0;
    unknown_operation = 1'b0;
    for (int u = 0; u < UNITS; u++) begin
      for (int k = 0; k < 3; k++) begin
        if (uses[4*u+k]) begin
          if (pending[address[(4*u+k)*A+:A]] == epoch) read_pending = 1'b1;
          if (written[address[(4*u+k)*A+:A]] != epoch) read_unwritten = 1'b1;
          if (WORDS != 1 << A && 32'(address[(4*u+k)*A+:A]) >= WORDS) read_unwritten = 1'b1;
        end
      end
      if (uses[4*u+3] && pending[address[(4*u+3)*A+:A]] == epoch) write_pending = 1'b1;
      if (WORDS != 1 << A && uses[4*u+3] && 32'(address[(4*u+3)*A+:A]) >= WORDS) write_pending = 1'b1;
      // Equal destinations in one microcode word; write_conflict sees them only if their latencies are equal.
      for (int v = 0; v < UNITS; v++) begin
        if (v < u && uses[4*u+3] && uses[4*v+3] && address[(4*u+3)*A+:A] == address[(4*v+3)*A+:A]) write_pending = 1'b1;
      end
    end
    for (int l = 0; l < LANES; l++) if (op[4*l+:4] > OP_SELECT) unknown_operation = 1'b1;
    for (int d = 0; d < DIVIDERS; d++) if (divider_op[2*d+:2] > DIVIDER_SQRT) unknown_operation = 1'b1;
  end
  assign violations = {
    unknown_operation && enable,
    read_unwritten && enable,
    divider_busy,
    write_conflict,
    result_conflict,
    write_pending && enable,
    read_pending && enable,
    read_conflict
  };
endmodule
